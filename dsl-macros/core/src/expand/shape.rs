//! Shapes of bodies: `shape crate: rectangle (w, h)`. Each is all that lies within a radius of a convex core, which has corners,
//! strips along its sides, and the half planes in all of which it lies.

use super::body::Bodies;
use super::clause::{Clause, clauses, shown, sorted};
use super::names::{Scope, encoded, member};
use super::tokens::{
    ended, group_in, grouped, inside, is_punct, items, place_of, punct, undocumented,
};
use crate::diagnostics::{Checked, Place, list};
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

/// All points with `normal . (p - middle) <= half`.
pub(super) struct Side {
    pub(super) normal: TokenStream,
    pub(super) half: TokenStream,
}

/// A shape, with names in the place of its parts.
pub(super) struct Shape {
    /// Its own whole name, and that of its body.
    pub(super) name: String,
    pub(super) body: String,
    /// Its kind as it is written.
    pub(super) kind: &'static str,
    pub(super) middle: Ident,
    /// None of a half plane.
    pub(super) corners: Vec<Ident>,
    pub(super) radius: Option<Ident>,
    /// In all of them the core lies; opposite ones are two apart.
    pub(super) sides: Vec<Side>,
    /// Whether a corner that is inside of all sides is inside of the core, which has a width.
    pub(super) is_solid: bool,
    /// What lies within a radius of the core beside its corners: all sides, of which those with this remainder by two are moved by
    /// the radius.
    pub(super) strips: &'static [usize],
}

/// What a shape is made with.
struct Frame<'t> {
    shape: Shape,
    span: Span,
    scope: &'t Rc<Scope>,
    kind: Clause<'t>,
    /// How it is turned.
    turn: TokenStream,
    /// Whether it can be drawn: its size does not move.
    is_drawn: bool,
}

/// All shapes of a scene.
pub(super) struct Shapes<'a> {
    pub(super) bodies: Bodies<'a>,
    pub(super) list: Vec<Shape>,
}

impl<'a> Shapes<'a> {
    pub(super) fn new(bodies: Bodies<'a>) -> Self {
        let list = Vec::new();
        Self { bodies, list }
    }

    /// `shape crate: rectangle (w, h) at (a, b) angle c`, also under a name of its own, `shape crate.lid: ..`.
    pub(super) fn shape(&mut self, statement: &[TokenTree], scope: &Rc<Scope>) -> Checked<()> {
        let statement = ended(undocumented(statement));
        let begin = Place::at(statement[0].span());
        let colon = statement
            .iter()
            .position(|token| is_punct(Some(token), ':'));
        let Some(colon) = colon.filter(|&colon| colon + 1 < statement.len()) else {
            let message = "a shape is written as in `shape block: rectangle (w, h)`, behind the name of its body";
            return Err(self.bodies.diagnostics.syntax(begin, message));
        };
        let (body, whole, span) = self.owner(&statement[1..colon], scope)?;
        let clauses = clauses(&statement[colon + 1..], &words::SHAPE);
        let what = format!("the shape of `{}`", shown(&whole));
        let [kinds @ .., at, angle] = sorted(
            clauses.into_iter(),
            &words::SHAPE,
            &what,
            self.bodies.diagnostics,
        )?;
        let mut kinds = kinds.into_iter().flatten();
        let (Some(kind), None) = (kinds.next(), kinds.next()) else {
            let message = format!("{what} is one of {}", list(KINDS));
            return Err(self.bodies.told(begin, message));
        };
        if kind.word() != "circle" {
            self.bodies
                .needs_angle(&body, kind.place(), &format!("a shape `{}`", kind.word()))?;
        }
        let middle = self.middle((&body, &whole, span), at, scope)?;
        let own = self.bodies.named(&body, "angle");
        let turn = match angle.map(|angle| angle.value()) {
            None => quote_spanned!(span=> #own),
            Some(angle) => quote_spanned!(span=> #own + #angle),
        };
        let is_still = self.bodies.is_still(&body) && self.bodies.are_still([at, angle], scope);
        let shape = Shape {
            name: whole,
            body,
            kind: "half plane",
            middle,
            corners: Vec::new(),
            radius: None,
            sides: Vec::new(),
            is_solid: false,
            strips: &[],
        };
        let word = kind.word();
        let is_drawn = match word.as_str() {
            "half" => is_still,
            _ => self.bodies.constants.all(kind.tokens(), scope),
        };
        let mut frame = Frame {
            shape,
            span,
            scope,
            kind,
            turn,
            is_drawn,
        };
        match word.as_str() {
            "circle" => self.circle(&mut frame)?,
            "capsule" | "segment" => self.capsule(&mut frame)?,
            "rectangle" => self.rectangle(&mut frame)?,
            _ => self.half_plane(&mut frame)?,
        }
        self.list.push(frame.shape);
        Ok(())
    }

    /// Where the middle of a shape is.
    fn middle(
        &mut self,
        (body, whole, span): (&str, &str, Span),
        at: Option<Clause<'_>>,
        scope: &Rc<Scope>,
    ) -> Checked<Ident> {
        let Some(at) = at else {
            return Ok(self.bodies.body_place(body));
        };
        let place = self.bodies.offset(body, at.place(), &at.value())?;
        let place = quote_spanned!(span=> : m = #place);
        Ok(self.bodies.define((whole, "middle", span), place, scope))
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
        let outer = self
            .bodies
            .whole(if own.is_some() { names } else { tokens }, scope)?;
        let (body, whole) = match own {
            Some(own) if self.bodies.known.contains_key(&outer) => {
                let whole = format!("{outer}.{own}");
                (outer, whole)
            }
            Some(_) => {
                let whole = self.bodies.whole(tokens, scope)?;
                (whole.clone(), whole)
            }
            None => (outer.clone(), outer),
        };
        let Some(known) = self.bodies.known.get(&body) else {
            return Err(self.bodies.no_body(&body, place));
        };
        let span = match own {
            Some(own) => own.span(),
            None => known.span,
        };
        if self.list.iter().any(|shape| shape.name == whole)
            || body != whole && self.bodies.names.has(&whole)
        {
            let message = format!(
                "`{}` is declared twice; give this shape a name of its own, as in `shape {}.lid: ..`",
                shown(&whole),
                shown(&body)
            );
            return Err(self.bodies.diagnostics.report("E19", place, message));
        }
        if body != whole {
            self.bodies.names.declare_body(&whole, &[]);
        }
        Ok((body, whole, span))
    }

    /// Directions of a shape, `along` and `across` it.
    fn directions(&mut self, frame: &Frame<'_>) -> [Ident; 2] {
        let (turn, span, whole) = (&frame.turn, frame.span, &frame.shape.name);
        let along = quote_spanned!(span=> = rotation(#turn)*(1, 0));
        let across = quote_spanned!(span=> = rotation(#turn)*(0, 1));
        [("along", along), ("across", across)]
            .map(|(name, value)| self.bodies.define((whole, name, span), value, frame.scope))
    }

    /// A length of a shape, by name.
    fn size(&mut self, frame: &Frame<'_>, name: &str, value: &[TokenTree]) -> Checked<Ident> {
        self.bodies
            .constants
            .is_length(value, frame.scope, self.bodies.diagnostics)?;
        let span = value.first().map_or(frame.span, TokenTree::span);
        let value = grouped(Delimiter::None, value.to_vec(), span);
        let value = quote_spanned!(span=> : m = #value);
        Ok(self
            .bodies
            .define((&frame.shape.name, name, span), value, frame.scope))
    }

    /// Two lengths in parentheses.
    fn two_lengths(
        &mut self,
        example: &str,
        frame: &Frame<'_>,
        names: [&str; 2],
    ) -> Checked<[Ident; 2]> {
        let inner = match frame.kind.tokens() {
            [group] => group_in(Some(group), Delimiter::Parenthesis).map(inside),
            _ => None,
        };
        let inner = inner.unwrap_or_default();
        let [first, second] = items(&inner).collect::<Vec<_>>()[..] else {
            let message = format!("`{}` has two lengths, as in `{example}`", frame.kind.word());
            return Err(self.bodies.told(frame.kind.place(), message));
        };
        let first = self.size(frame, names[0], first)?;
        Ok([first, self.size(frame, names[1], second)?])
    }

    /// Sides along and across a shape, which lies within these halves of them.
    fn sides(&mut self, frame: &mut Frame<'_>, halves: [TokenStream; 2]) -> [Ident; 2] {
        let [along, across] = self.directions(frame);
        let span = frame.span;
        let [length, width] = &halves;
        frame.shape.sides = [
            (quote_spanned!(span=> #along), length),
            (quote_spanned!(span=> #across), width),
            (quote_spanned!(span=> (-#along)), length),
            (quote_spanned!(span=> (-#across)), width),
        ]
        .map(|(normal, half)| Side {
            normal,
            half: half.clone(),
        })
        .into();
        [along, across]
    }

    /// Declares the next corner of the core.
    fn corner(&mut self, frame: &mut Frame<'_>, place: TokenStream) {
        let name = format!("{}.corner", frame.shape.name);
        let k = 1 + frame.shape.corners.len() as i64;
        self.bodies.names.declare(&name, &[k]);
        let corner = Ident::new(&encoded(&member(&name, &[k])), frame.span);
        self.bodies.write(
            quote_spanned!(frame.span=> let #corner = #place),
            frame.scope,
        );
        frame.shape.corners.push(corner);
    }

    fn circle(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        let radius = self.size(frame, "radius", frame.kind.tokens())?;
        self.draw_shape(frame, &quote_spanned!(frame.span=> radius #radius));
        let shape = &mut frame.shape;
        (shape.kind, shape.radius) = ("circle", Some(radius));
        shape.corners = vec![shape.middle.clone()];
        Ok(())
    }

    fn rectangle(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        let [w, h] = self.two_lengths("rectangle (w, h)", frame, ["width", "height"])?;
        let (span, middle) = (frame.span, frame.shape.middle.clone());
        let halves = [&w, &h].map(|size| quote_spanned!(span=> #size/2));
        let [along, across] = self.sides(frame, halves);
        for signs in [['+', '+'], ['-', '+'], ['-', '-'], ['+', '-']] {
            let [a, b] = signs.map(|sign| punct(sign, span));
            self.corner(
                frame,
                quote_spanned!(span=> #middle #a #w/2*#along #b #h/2*#across),
            );
        }
        self.draw_shape(frame, &quote_spanned!(span=> size (#w, #h)));
        let shape = &mut frame.shape;
        (shape.kind, shape.is_solid, shape.strips) = ("rectangle", true, &[0, 1]);
        Ok(())
    }

    /// What lies within a radius of a segment, or the segment alone.
    fn capsule(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        let (span, middle) = (frame.span, frame.shape.middle.clone());
        let length = if frame.kind.word() == "capsule" {
            let [length, radius] =
                self.two_lengths("capsule (l, r)", frame, ["length", "radius"])?;
            (frame.shape.kind, frame.shape.radius) = ("capsule", Some(radius));
            length
        } else {
            frame.shape.kind = "segment";
            self.size(frame, "length", frame.kind.tokens())?
        };
        let halves = [quote_spanned!(span=> #length/2), quote_spanned!(span=> 0)];
        let [along, across] = self.sides(frame, halves);
        for sign in ['+', '-'].map(|sign| punct(sign, span)) {
            self.corner(frame, quote_spanned!(span=> #middle #sign #length/2*#along));
        }
        frame.shape.strips = &[1];
        let (shape, is_drawn) = (&frame.shape, frame.is_drawn);
        let [a, b] = [0, 1].map(|k| &shape.corners[k]);
        let entries = match &shape.radius {
            None => vec![quote_spanned!(span=> link #a to #b)],
            Some(radius) => {
                let name = |k| encoded(&member(&format!("{}.end", shape.name), &[k]));
                let [c, d] = [1, 2].map(|k| Ident::new(&name(k), span));
                vec![
                    quote_spanned!(span=> circle #c at #a radius #radius),
                    quote_spanned!(span=> circle #d at #b radius #radius),
                    quote_spanned!(span=> link #a + #radius*#across to #b + #radius*#across),
                    quote_spanned!(span=> link #a - #radius*#across to #b - #radius*#across),
                ]
            }
        };
        for entry in entries.into_iter().filter(|_| is_drawn) {
            self.bodies.drawn(&shape.name, entry, frame.scope);
        }
        Ok(())
    }

    fn half_plane(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        if !matches!(frame.kind.tokens(), [TokenTree::Ident(word)] if word == "plane") {
            let message = "a half plane is written as in `shape ground: half plane`; `at` and `angle` stand behind that";
            return Err(self.bodies.diagnostics.syntax(frame.kind.place(), message));
        }
        let [along, across] = self.directions(frame);
        let (span, shape) = (frame.span, &mut frame.shape);
        shape.sides.push(Side {
            normal: quote_spanned!(span=> #across),
            half: quote_spanned!(span=> 0),
        });
        let (name, middle) = (Ident::new(&encoded(&shape.name), span), &shape.middle);
        if frame.is_drawn {
            let entry = quote_spanned!(span=> curve #name: #middle + w*#along over w);
            self.bodies.drawn(&shape.name, entry, frame.scope);
        }
        Ok(())
    }

    /// Draws a shape under the word of its kind.
    fn draw_shape(&mut self, frame: &Frame<'_>, size: &TokenStream) {
        let Frame {
            shape, span, turn, ..
        } = frame;
        let word = Ident::new(&frame.kind.word(), *span);
        let (name, middle) = (Ident::new(&encoded(&shape.name), *span), &shape.middle);
        let angle = match self.bodies.turns(&shape.body) {
            false => TokenStream::new(),
            true => quote_spanned!(*span=> angle #turn),
        };
        if frame.is_drawn {
            let entry = quote_spanned!(*span=> #word #name at #middle #size #angle);
            self.bodies.drawn(&shape.name, entry, frame.scope);
        }
    }

    /// The shapes that a name means: that of a body with all that have names of their own, or one of these.
    pub(super) fn shapes_of(
        &mut self,
        tokens: &[TokenTree],
        scope: &Rc<Scope>,
    ) -> Checked<Vec<usize>> {
        let place = place_of(tokens, Place::at(Span::call_site()));
        let whole = self.bodies.whole(tokens, scope)?;
        let is_meant = |shape: &Shape| shape.name == whole || shape.body == whole;
        let found: Vec<usize> = (0..self.list.len())
            .filter(|&k| is_meant(&self.list[k]))
            .collect();
        match (found.is_empty(), self.bodies.known.contains_key(&whole)) {
            (false, _) => Ok(found),
            (true, true) => {
                let name = shown(&whole);
                let message = format!(
                    "body `{name}` has no shape above that could touch anything; declare one before, as in `shape {name}: circle r`"
                );
                Err(self.bodies.told(place, message))
            }
            (true, false) => Err(self.bodies.no_body(&whole, place)),
        }
    }
}
