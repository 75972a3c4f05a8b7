//! Shapes of bodies: `shape crate: rectangle (w, h)`. Each is all that lies within a radius of a convex core, which has corners,
//! strips along its sides, and the half planes in all of which it lies.

use super::body::Bodies;
use super::clause::{Clause, clauses, shown, sorted};
use super::names::{Scope, encoded, indices, member};
use super::tokens::{
    ended, group_in, grouped, inside, is_punct, items, place_of, punct, undocumented,
};
use crate::diagnostics::{Checked, Place, Reported, closest, list};
use crate::words;
use proc_macro2::{Delimiter, Ident, Span, TokenStream, TokenTree};
use quote::quote_spanned;
use std::rc::Rc;

/// How each kind of shape is written.
const KINDS: [&str; 5] = [
    "circle r",
    "rectangle (w, h)",
    "half plane",
    "capsule (l, r)",
    "segment l",
];

/// All points with `|along . (p - middle)| <= half_length` and `|across . (p - middle)| <= half_width`.
pub(super) struct Strip {
    pub(super) middle: Ident,
    pub(super) along: Ident,
    pub(super) across: Ident,
    pub(super) half_length: TokenStream,
    pub(super) half_width: TokenStream,
    /// Whether the radius is added to its length, otherwise to its width.
    pub(super) is_longer: bool,
}

/// All points with `normal . (p - foot) <= 0`.
pub(super) struct Side {
    pub(super) normal: TokenStream,
    pub(super) foot: Ident,
}

/// A shape, with names in the place of its parts.
pub(super) struct Shape {
    /// Its own whole name, and that of its body.
    pub(super) name: String,
    pub(super) body: String,
    /// Its kind as it is written.
    pub(super) kind: &'static str,
    /// None of a half plane.
    pub(super) corners: Vec<Ident>,
    pub(super) radius: Option<Ident>,
    pub(super) strips: Vec<Strip>,
    pub(super) sides: Vec<Side>,
}

impl Shape {
    fn new(name: String, body: String, kind: &'static str) -> Self {
        Self {
            name,
            body,
            kind,
            corners: Vec::new(),
            radius: None,
            strips: Vec::new(),
            sides: Vec::new(),
        }
    }

    pub(super) fn is_half_plane(&self) -> bool {
        self.corners.is_empty()
    }
}

/// What a shape is made with.
struct Frame<'s> {
    whole: String,
    span: Span,
    middle: Ident,
    scope: &'s Rc<Scope>,
    /// What `at` and `angle` say of how it lies on its body.
    placed: [Vec<TokenTree>; 2],
}

impl Bodies<'_> {
    /// `shape crate: rectangle (w, h) at (a, b) angle c`, also under a name of its own, `shape crate.lid: ..`.
    pub(super) fn shape(&mut self, statement: &[TokenTree], scope: &Rc<Scope>) -> Checked<()> {
        let statement = ended(undocumented(statement));
        let begin = Place::at(statement[0].span());
        let colon = statement
            .iter()
            .position(|token| is_punct(Some(token), ':'));
        let Some(colon) = colon.filter(|&colon| colon + 1 < statement.len()) else {
            let message = "a shape is written as in `shape block: rectangle (w, h)`, behind the name of its body";
            return Err(self.diagnostics.syntax(begin, message));
        };
        let (body, whole, span) = self.owner(&statement[1..colon], scope)?;
        let clauses = clauses(&statement[colon + 1..], &words::SHAPE);
        let what = format!("the shape of `{}`", shown(&whole));
        let [kinds @ .., at, angle] =
            sorted(clauses.into_iter(), &words::SHAPE, &what, self.diagnostics)?;
        let mut kinds = kinds.into_iter().flatten();
        let (Some(kind), None) = (kinds.next(), kinds.next()) else {
            let message = format!("{what} is one of {}", list(KINDS));
            return Err(self.told(begin, message));
        };
        if kind.word() != "circle" {
            self.needs_angle(&body, kind.place(), &format!("a shape `{}`", kind.word()))?;
        }
        let middle = match at {
            None => self.body_place(&body),
            Some(at) => {
                let place = self.offset(&body, at.place(), &at.value())?;
                let middle = self.own(&whole, "middle", span);
                self.write(quote_spanned!(span=> let #middle: m = #place), scope);
                middle
            }
        };
        let placed = [at, angle].map(|clause| {
            clause.map_or_else(Vec::new, |clause: Clause<'_>| clause.tokens().to_vec())
        });
        let frame = Frame {
            whole,
            span,
            middle,
            scope,
            placed,
        };
        let shape = match kind.word().as_str() {
            "circle" => self.circle(body, &frame, &kind)?,
            "capsule" | "segment" => self.capsule(body, &frame, &kind)?,
            "rectangle" => self.rectangle(body, &frame, &kind)?,
            _ => self.half_plane(body, &frame, &kind)?,
        };
        self.shapes.push(shape);
        Ok(())
    }

    /// The body of a shape, the whole name of the shape, and where that stands.
    fn owner(
        &mut self,
        tokens: &[TokenTree],
        scope: &Rc<Scope>,
    ) -> Checked<(String, String, Span)> {
        let place = place_of(tokens, Place::at(Span::call_site()));
        let (names, own) = match tokens {
            [names @ .., point, TokenTree::Ident(own)] if is_punct(Some(point), '.') => {
                (names, Some(own))
            }
            names => (names, None),
        };
        let outer = self.whole(if own.is_some() { names } else { tokens }, scope)?;
        let (body, whole) = match own {
            Some(own) if self.bodies.contains_key(&outer) => {
                let whole = format!("{outer}.{own}");
                (outer, whole)
            }
            Some(_) => {
                let whole = self.whole(tokens, scope)?;
                (whole.clone(), whole)
            }
            None => (outer.clone(), outer),
        };
        let Some(known) = self.bodies.get(&body) else {
            return Err(self.no_body(&body, place));
        };
        let span = match own {
            Some(own) => own.span(),
            None => known.span,
        };
        if self.shapes.iter().any(|shape| shape.name == whole)
            || body != whole && self.names.has(&whole)
        {
            let message = format!(
                "`{}` is declared twice; give this shape a name of its own, as in `shape {}.lid: ..`",
                shown(&whole),
                shown(&body)
            );
            return Err(self.diagnostics.report("E19", place, message));
        }
        if body != whole {
            self.names.declare_body(&whole, &[]);
        }
        Ok((body, whole, span))
    }

    /// E27: a name that is no body above.
    pub(super) fn no_body(&mut self, name: &str, place: Place) -> Reported {
        let bodies: Vec<String> = self.bodies.keys().map(|name| shown(name)).collect();
        let name = shown(name);
        let message = match closest(&name, bodies.iter().map(String::as_str)) {
            Some(near) => format!("there is no body `{name}` above; did you mean `{near}`?"),
            None => format!(
                "there is no body `{name}` above; declare it before, as in `body {name}: mass m, at (x, z)` or `body {name}: fixed`"
            ),
        };
        self.told(place, message)
    }

    /// Directions of a shape, `along` and `across` it.
    fn directions(&mut self, body: &str, frame: &Frame<'_>) -> [Ident; 2] {
        let (angle, span) = (self.named(body, "angle"), frame.span);
        let turn = match &frame.placed[1][..] {
            [] => quote_spanned!(span=> #angle),
            turn => {
                let turn = grouped(Delimiter::None, turn.to_vec(), turn[0].span());
                quote_spanned!(span=> #angle + #turn)
            }
        };
        let [along, across] = ["along", "across"].map(|name| self.own(&frame.whole, name, span));
        self.write(
            quote_spanned!(span=> let #along = rotation(#turn)*(1, 0)),
            frame.scope,
        );
        self.write(
            quote_spanned!(span=> let #across = rotation(#turn)*(0, 1)),
            frame.scope,
        );
        [along, across]
    }

    /// A length of a shape, by name.
    fn size(&mut self, frame: &Frame<'_>, name: &str, value: &[TokenTree]) -> Checked<Ident> {
        self.is_length(value, frame.scope)?;
        let span = value.first().map_or(frame.span, TokenTree::span);
        let size = self.own(&frame.whole, name, span);
        let value = grouped(Delimiter::None, value.to_vec(), span);
        self.write(quote_spanned!(span=> let #size: m = #value), frame.scope);
        Ok(size)
    }

    fn circle(&mut self, body: String, frame: &Frame<'_>, kind: &Clause<'_>) -> Checked<Shape> {
        let radius = self.size(frame, "radius", kind.tokens())?;
        let mut shape = Shape::new(frame.whole.clone(), body, "circle");
        shape.corners = vec![frame.middle.clone()];
        shape.radius = Some(radius.clone());
        self.draw_shape(
            &shape,
            frame,
            "circle",
            kind.tokens(),
            &quote_spanned!(frame.span=> radius #radius),
        );
        Ok(shape)
    }

    fn rectangle(&mut self, body: String, frame: &Frame<'_>, kind: &Clause<'_>) -> Checked<Shape> {
        let [w, h] = self.two_lengths(kind, "rectangle (w, h)", frame, ["width", "height"])?;
        let [along, across] = self.directions(&body, frame);
        let (span, middle) = (frame.span, &frame.middle);
        let mut shape = Shape::new(frame.whole.clone(), body, "rectangle");
        let corners = [['+', '+'], ['-', '+'], ['-', '-'], ['+', '-']];
        for (k, signs) in (1..).zip(corners) {
            let [a, b] = signs.map(|sign| punct(sign, span));
            let place = quote_spanned!(span=> #middle #a #w/2*#along #b #h/2*#across);
            self.corner(&mut shape, k, place, frame);
        }
        let [right, top] = [shape.corners[0].clone(), shape.corners[0].clone()];
        let [left, bottom] = [shape.corners[2].clone(), shape.corners[2].clone()];
        shape.sides = vec![
            Side {
                normal: quote_spanned!(span=> #along),
                foot: right,
            },
            Side {
                normal: quote_spanned!(span=> #across),
                foot: top,
            },
            Side {
                normal: quote_spanned!(span=> (-#along)),
                foot: left,
            },
            Side {
                normal: quote_spanned!(span=> (-#across)),
                foot: bottom,
            },
        ];
        shape.strips = [true, false]
            .map(|is_longer| Strip {
                middle: middle.clone(),
                along: along.clone(),
                across: across.clone(),
                half_length: quote_spanned!(span=> #w/2),
                half_width: quote_spanned!(span=> #h/2),
                is_longer,
            })
            .into();
        self.draw_shape(
            &shape,
            frame,
            "rectangle",
            kind.tokens(),
            &quote_spanned!(span=> size (#w, #h)),
        );
        Ok(shape)
    }

    /// What lies within a radius of a segment, or the segment alone.
    fn capsule(&mut self, body: String, frame: &Frame<'_>, kind: &Clause<'_>) -> Checked<Shape> {
        let is_round = kind.word() == "capsule";
        let mut shape = Shape::new(
            frame.whole.clone(),
            body,
            if is_round { "capsule" } else { "segment" },
        );
        let length = if is_round {
            let [length, radius] =
                self.two_lengths(kind, "capsule (l, r)", frame, ["length", "radius"])?;
            shape.radius = Some(radius);
            length
        } else {
            self.size(frame, "length", kind.tokens())?
        };
        let [along, across] = self.directions(&shape.body, frame);
        let (span, middle) = (frame.span, &frame.middle);
        for (k, sign) in [(1, '+'), (2, '-')] {
            let sign = punct(sign, span);
            self.corner(
                &mut shape,
                k,
                quote_spanned!(span=> #middle #sign #length/2*#along),
                frame,
            );
        }
        self.draw_capsule(&shape, frame, kind.tokens());
        shape.strips.push(Strip {
            middle: middle.clone(),
            along,
            across,
            half_length: quote_spanned!(span=> #length/2),
            half_width: quote_spanned!(span=> 0),
            is_longer: false,
        });
        Ok(shape)
    }

    /// The ends of a capsule, and the lines between them.
    fn draw_capsule(&mut self, shape: &Shape, frame: &Frame<'_>, size: &[TokenTree]) {
        let (span, [a, b]) = (frame.span, [0, 1].map(|k| &shape.corners[k]));
        let across = self.named(&shape.name, "across");
        let entries = match &shape.radius {
            None => vec![quote_spanned!(span=> link #a to #b)],
            Some(radius) => {
                let name = |k| member(&format!("{}.end", shape.name), &[k]);
                let [c, d] = [1, 2].map(|k| Ident::new(&encoded(&name(k)), span));
                vec![
                    quote_spanned!(span=> circle #c at #a radius #radius),
                    quote_spanned!(span=> circle #d at #b radius #radius),
                    quote_spanned!(span=> link #a + #radius*#across to #b + #radius*#across),
                    quote_spanned!(span=> link #a - #radius*#across to #b - #radius*#across),
                ]
            }
        };
        if self.is_constant(size, frame.scope) {
            entries
                .into_iter()
                .for_each(|entry| self.drawn(&shape.name, entry, frame.scope));
        }
    }

    /// Declares a corner of the core.
    fn corner(&mut self, shape: &mut Shape, k: i64, place: TokenStream, frame: &Frame<'_>) {
        let name = format!("{}.corner", frame.whole);
        self.names.declare(&name, &[k]);
        let corner = Ident::new(&encoded(&member(&name, &[k])), frame.span);
        self.write(
            quote_spanned!(frame.span=> let #corner = #place),
            frame.scope,
        );
        shape.corners.push(corner);
    }

    fn half_plane(&mut self, body: String, frame: &Frame<'_>, kind: &Clause<'_>) -> Checked<Shape> {
        if !matches!(kind.tokens(), [TokenTree::Ident(word)] if word == "plane") {
            let message = "a half plane is written as in `shape ground: half plane`; `at` and `angle` stand behind that";
            return Err(self.diagnostics.syntax(kind.place(), message));
        }
        let [along, across] = self.directions(&body, frame);
        let (span, middle) = (frame.span, &frame.middle);
        let mut shape = Shape::new(frame.whole.clone(), body, "half plane");
        shape.sides.push(Side {
            normal: quote_spanned!(span=> #across),
            foot: middle.clone(),
        });
        let name = Ident::new(&encoded(&shape.name), span);
        let is_still = self
            .bodies
            .get(&shape.body)
            .is_some_and(|body| body.is_still);
        if is_still
            && frame
                .placed
                .iter()
                .all(|tokens| self.is_constant(tokens, frame.scope))
        {
            let entry = quote_spanned!(span=> curve #name: #middle + w*#along over w);
            self.drawn(&shape.name, entry, frame.scope);
        }
        Ok(shape)
    }

    /// Two lengths in parentheses.
    fn two_lengths(
        &mut self,
        kind: &Clause<'_>,
        example: &str,
        frame: &Frame<'_>,
        names: [&str; 2],
    ) -> Checked<[Ident; 2]> {
        let tokens = kind.tokens();
        let inner = match tokens {
            [group] => group_in(Some(group), Delimiter::Parenthesis).map(inside),
            _ => None,
        };
        let inner = inner.unwrap_or_default();
        match items(&inner).collect::<Vec<_>>()[..] {
            [first, second] => Ok([
                self.size(frame, names[0], first)?,
                self.size(frame, names[1], second)?,
            ]),
            _ => {
                let message = format!("`{}` has two lengths, as in `{example}`", kind.word());
                Err(self.told(kind.place(), message))
            }
        }
    }

    /// Draws a shape whose size does not move.
    fn draw_shape(
        &mut self,
        shape: &Shape,
        frame: &Frame<'_>,
        word: &str,
        size: &[TokenTree],
        drawn: &TokenStream,
    ) {
        if !self.is_constant(size, frame.scope) {
            return;
        }
        let (span, middle) = (frame.span, &frame.middle);
        let word = Ident::new(word, span);
        let name = Ident::new(&encoded(&shape.name), span);
        let turned = self.turns(&shape.body);
        let angle = self.named(&shape.body, "angle");
        let turn = grouped(Delimiter::None, frame.placed[1].clone(), span);
        let angle = match (turned, frame.placed[1].is_empty()) {
            (false, _) => TokenStream::new(),
            (true, true) => quote_spanned!(span=> angle #angle),
            (true, false) => quote_spanned!(span=> angle #angle + #turn),
        };
        let entry = quote_spanned!(span=> #word #name at #middle #drawn #angle);
        self.drawn(&shape.name, entry, frame.scope);
    }

    /// The whole name that tokens are.
    pub(super) fn whole(&mut self, tokens: &[TokenTree], scope: &Rc<Scope>) -> Checked<String> {
        let before = self.diagnostics.mistakes();
        let found = self.names.resolved(tokens, scope, self.diagnostics);
        self.diagnostics.none_since(before)?;
        match &found[..] {
            [TokenTree::Ident(name)] => Ok(super::decoded(name.to_string())),
            [TokenTree::Ident(name), bracket] if indices(bracket).is_some() => {
                let name = super::decoded(name.to_string());
                Ok(member(&name, &indices(bracket).unwrap_or_default()))
            }
            _ => {
                let place = place_of(tokens, Place::at(Span::call_site()));
                Err(self.told(
                    place,
                    "a body or a shape has a name here, as in `block` or `block.lid`",
                ))
            }
        }
    }
}
