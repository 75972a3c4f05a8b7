//! Shapes of bodies: `shape crate: rectangle (w, h)`. Each is all that lies within a radius of a convex core, which has corners,
//! strips along its sides, and the half planes in all of which it lies.

use super::body::Bodies;
use super::clause::{Clause, clauses, shown, sorted};
use super::names::{Scope, encoded, member};
use super::tokens::{components, ended, grouped, is_punct, place_of, punct, undocumented};
use crate::diagnostics::{Checked, Place, Reported, list};
use crate::words;
use proc_macro2::{Delimiter, Ident, Span, TokenStream, TokenTree};
use quote::quote_spanned;
use std::rc::Rc;

/// How each kind of shape is written in the plane.
const KINDS: [&str; 8] = [
    "circle r",
    "rectangle (w, h)",
    "polygon ((0, 0), (l, 0), (0, l))",
    "half plane",
    "below h",
    "capsule (l, r)",
    "segment l",
    "point",
];

/// The same in space.
const IN_SPACE: [&str; 5] = [
    "sphere r",
    "box (a, b, c)",
    "half space",
    "capsule (l, r)",
    "point",
];

/// All points with `normal . (p - middle) <= half`, or within a radius of a line along `normal`.
#[derive(Clone)]
pub(super) struct Side {
    pub(super) normal: TokenStream,
    pub(super) half: TokenStream,
    /// Whether a round shape is a radius farther away.
    pub(super) is_moved: bool,
    /// A point of the line.
    pub(super) line: Option<Ident>,
    /// Directions along it, where they are the same everywhere.
    pub(super) tangents: Option<[Ident; 2]>,
}

impl Side {
    pub(super) fn new(normal: TokenStream, half: TokenStream) -> Self {
        Self {
            normal,
            half,
            is_moved: false,
            line: None,
            tangents: None,
        }
    }

    pub(super) fn moved(self, is_moved: bool) -> Self {
        Self { is_moved, ..self }
    }
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
    /// In all of them the core lies.
    pub(super) sides: Vec<Side>,
    /// Whether a corner that is inside of all sides is inside of the core, which has a width.
    pub(super) is_solid: bool,
    /// What lies within a radius of the core beside its corners: all points that are within all sides of one of these.
    pub(super) strips: Vec<Vec<Side>>,
    /// Of what lies below a curve, its function and the directions along and across its argument.
    pub(super) curve: Option<(TokenStream, [Ident; 2])>,
}

/// What a shape is made with.
pub(super) struct Frame<'t> {
    pub(super) shape: Shape,
    pub(super) span: Span,
    pub(super) scope: &'t Rc<Scope>,
    pub(super) kind: Clause<'t>,
    /// How it is turned.
    turn: TokenStream,
    /// Whether it can be drawn: its size does not move.
    pub(super) is_drawn: bool,
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

    /// What a shape is made with, `shape crate: rectangle (w, h) at (a, b) angle c`, also under a name of its own, `shape crate.lid: ..`.
    pub(super) fn frame<'t>(
        &mut self,
        statement: &'t [TokenTree],
        scope: &'t Rc<Scope>,
    ) -> Checked<Frame<'t>> {
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
        // Where this comes to nothing, a contact of the body without a shape is no second mistake.
        self.bodies.diagnostics.poison(&format!("shape {body}"));
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
            return Err(self.no_kind(&what, begin));
        };
        let word = kind.word();
        let known: &[&str] = match self.bodies.in_space {
            true => &IN_SPACE,
            false => &KINDS,
        };
        if !known
            .iter()
            .any(|kind| kind.split(' ').next() == Some(&word))
        {
            return Err(self.no_kind(&what, kind.place()));
        }
        if !["circle", "sphere", "point"].contains(&word.as_str()) {
            self.bodies
                .needs_angle(&body, kind.place(), &format!("a shape `{word}`"))?;
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
            strips: Vec::new(),
            curve: None,
        };
        let is_drawn = match word.as_str() {
            "half" | "below" => is_still,
            _ => self.bodies.constants.all(kind.tokens(), scope),
        };
        Ok(Frame {
            shape,
            span,
            scope,
            kind,
            turn,
            is_drawn,
        })
    }

    /// The core of a shape in the plane, and what is drawn of it.
    pub(super) fn in_plane(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        match frame.kind.word().as_str() {
            "circle" => self.circle(frame)?,
            "capsule" | "segment" => self.capsule(frame)?,
            "rectangle" => self.rectangle(frame)?,
            "polygon" => self.polygon(frame)?,
            "point" => self.point(frame),
            "below" => self.below(frame),
            _ => self.half_plane(frame)?,
        }
        Ok(())
    }

    /// E27: no shape of a scene in the plane or in space.
    fn no_kind(&mut self, what: &str, place: Place) -> Reported {
        let message = match self.bodies.in_space {
            true => format!("{what} is in space one of {}", list(IN_SPACE)),
            false => format!("{what} is one of {}", list(KINDS)),
        };
        self.bodies.told(place, message)
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
    pub(super) fn size(
        &mut self,
        frame: &Frame<'_>,
        name: &str,
        value: &[TokenTree],
    ) -> Checked<Ident> {
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

    /// Lengths in parentheses.
    pub(super) fn lengths<const N: usize>(
        &mut self,
        example: &str,
        frame: &Frame<'_>,
        names: [&str; N],
    ) -> Checked<[Ident; N]> {
        let parts = components(frame.kind.tokens());
        if parts.len() != N {
            let many = if N == 2 { "two" } else { "three" };
            let message = format!(
                "`{}` has {many} lengths, as in `{example}`",
                frame.kind.word()
            );
            return Err(self.bodies.told(frame.kind.place(), message));
        }
        let mut found = Vec::new();
        for (name, part) in names.into_iter().zip(&parts) {
            found.push(self.size(frame, name, part)?);
        }
        found.try_into().map_err(|_| Reported)
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
        .map(|(normal, half)| Side::new(normal, half.clone()))
        .into();
        [along, across]
    }

    /// Declares the next corner of the core.
    pub(super) fn corner(&mut self, frame: &mut Frame<'_>, place: TokenStream) {
        let k = 1 + frame.shape.corners.len();
        let corner = self.listed(frame, ("corner", k), quote_spanned!(frame.span=> = #place));
        frame.shape.corners.push(corner);
    }

    /// Declares one of several things of a shape.
    pub(super) fn listed(
        &mut self,
        frame: &Frame<'_>,
        (name, k): (&str, usize),
        value: TokenStream,
    ) -> Ident {
        let name = format!("{}.{name}", frame.shape.name);
        self.bodies.names.declare(&name, &[k as i64]);
        let own = Ident::new(&encoded(&member(&name, &[k as i64])), frame.span);
        self.bodies
            .write(quote_spanned!(frame.span=> let #own #value), frame.scope);
        own
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
        let [w, h] = self.lengths("rectangle (w, h)", frame, ["width", "height"])?;
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
        let strip = |parity| pair(&shape.sides, 2, parity);
        shape.strips = vec![strip(0), strip(1)];
        (shape.kind, shape.is_solid) = ("rectangle", true);
        Ok(())
    }

    /// What lies within a radius of a segment, or the segment alone.
    fn capsule(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        let (span, middle) = (frame.span, frame.shape.middle.clone());
        let length = if frame.kind.word() == "capsule" {
            let [length, radius] = self.lengths("capsule (l, r)", frame, ["length", "radius"])?;
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
        frame.shape.strips = vec![pair(&frame.shape.sides, 2, 1)];
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

    /// A point alone, which is a corner.
    pub(super) fn point(&mut self, frame: &mut Frame<'_>) {
        frame.shape.corners = vec![frame.shape.middle.clone()];
        (frame.shape.kind, frame.shape.is_solid) = ("point", true);
        if !self.bodies.in_space {
            self.draw_shape(frame, &TokenStream::new());
        }
    }

    /// All that lies below a function of the first axis.
    fn below(&mut self, frame: &mut Frame<'_>) {
        let [along, across] = self.directions(frame);
        let (span, middle) = (frame.span, &frame.shape.middle);
        let function = TokenStream::from_iter(frame.kind.tokens().iter().cloned());
        let name = Ident::new(&encoded(&frame.shape.name), span);
        if frame.is_drawn {
            let entry = quote_spanned!(span=> curve #name: #middle + w*#along + #function(w)*#across over w);
            self.bodies.drawn(&frame.shape.name, entry, frame.scope);
        }
        frame.shape.curve = Some((function, [along, across]));
        frame.shape.kind = "curve";
    }

    /// A convex polygon, whose corners go round either way: normals have the sign of its area.
    fn polygon(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        let spots = self.spots(frame)?;
        let [along, across] = self.directions(frame);
        let (span, middle) = (frame.span, frame.shape.middle.clone());
        let next = |k: usize| &spots[(k + 1) % spots.len()];
        let area = spots.iter().enumerate().map(|(k, spot)| {
            let next = next(k);
            quote_spanned!(span=> (#spot[0]*#next[1] - #spot[1]*#next[0]))
        });
        let area = quote_spanned!(span=> = #(#area)+*);
        let area = self
            .bodies
            .define((&frame.shape.name, "area", span), area, frame.scope);
        let mut strips = Vec::new();
        for (k, spot) in spots.iter().enumerate() {
            self.corner(
                frame,
                quote_spanned!(span=> #middle + #spot[0]*#along + #spot[1]*#across),
            );
            let next = next(k);
            let edge = quote_spanned!(span=> = (#next - #spot)/|#next - #spot|);
            let edge = self.listed(frame, ("edge", k + 1), edge);
            let normal = quote_spanned!(span=> = #area/sqrt(#area^2)*(#edge[1], -#edge[0]));
            let normal = self.listed(frame, ("normal", k + 1), normal);
            let turned = |own: &Ident| quote_spanned!(span=> (#own[0]*#along + #own[1]*#across));
            let [side, way] = [&normal, &edge].map(turned);
            let half = quote_spanned!(span=> #normal . (#spot));
            let ends = [spot, next].map(|end| quote_spanned!(span=> #edge . (#end)));
            let [begin, end] = ends;
            strips.push(vec![
                Side::new(side.clone(), half.clone()).moved(true),
                Side::new(
                    quote_spanned!(span=> (-#side)),
                    quote_spanned!(span=> (-(#half))),
                ),
                Side::new(way.clone(), quote_spanned!(span=> (#end))),
                Side::new(
                    quote_spanned!(span=> (-#way)),
                    quote_spanned!(span=> (-(#begin))),
                ),
            ]);
            frame.shape.sides.push(Side::new(side, half));
        }
        strips.push(frame.shape.sides.clone());
        self.draw_shape(frame, &quote_spanned!(span=> corners (#(#spots),*)));
        let shape = &mut frame.shape;
        (shape.kind, shape.is_solid, shape.strips) = ("polygon", true, strips);
        Ok(())
    }

    /// The corners of a polygon as it is given; it is convex without anything set otherwise.
    fn spots(&mut self, frame: &Frame<'_>) -> Checked<Vec<Ident>> {
        let (kind, constants) = (frame.kind, &self.bodies.constants);
        let points = components(kind.tokens());
        let parts: Vec<_> = points.iter().map(|point| components(point)).collect();
        if points.len() < 3 || parts.iter().any(|parts| parts.len() != 2) {
            let message = "a polygon has three corners at least, each with two lengths, as in `polygon ((0, 0), (l, 0), (0, l))`";
            return Err(self.bodies.told(kind.place(), message));
        }
        let number = |part: &Vec<TokenTree>| constants.value(part, frame.scope);
        let numbers = parts
            .iter()
            .map(|parts| Some([number(&parts[0])?, number(&parts[1])?]));
        let Some(numbers) = numbers.collect::<Option<Vec<_>>>() else {
            let message = "the corners of a polygon are computed from numbers and parameters, so that it is known to be convex";
            return Err(self.bodies.told(kind.place(), message));
        };
        if let Some((corner, why)) = bent(&numbers) {
            let place = place_of(&points[corner], kind.place());
            let message = format!(
                "{why} corner {} of the polygon, which has to be convex; make it of several, as in `shape {}.lid: polygon ..`",
                corner + 1,
                shown(&frame.shape.body)
            );
            return Err(self.bodies.told(place, message));
        }
        let spots = points.iter().enumerate().map(|(k, point)| {
            let span = frame.span;
            self.listed(
                frame,
                ("spot", k + 1),
                quote_spanned!(span=> : m = #(#point)*),
            )
        });
        Ok(spots.collect())
    }

    fn half_plane(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        if !matches!(frame.kind.tokens(), [TokenTree::Ident(word)] if word == "plane") {
            let message = "a half plane is written as in `shape ground: half plane`; `at` and `angle` stand behind that";
            return Err(self.bodies.diagnostics.syntax(frame.kind.place(), message));
        }
        let [along, across] = self.directions(frame);
        let (span, shape) = (frame.span, &mut frame.shape);
        let side = Side::new(quote_spanned!(span=> #across), quote_spanned!(span=> 0));
        shape.sides.push(side.moved(true));
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
            (true, true)
                if self
                    .bodies
                    .diagnostics
                    .is_poisoned(&format!("shape {whole}")) =>
            {
                Err(Reported)
            }
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

/// Sides of which those with a remainder are moved by a radius.
pub(super) fn pair(sides: &[Side], by: usize, remainder: usize) -> Vec<Side> {
    let sides = sides.iter().cloned().enumerate();
    sides
        .map(|(k, side)| side.moved(k % by == remainder))
        .collect()
}

/// The corner at which a polygon is not convex, and what is wrong there.
fn bent(corners: &[[f64; 2]]) -> Option<(usize, &'static str)> {
    let n = corners.len();
    let cross = |k: usize, j: usize| {
        let ([a, b], [c, d], [e, f]) = (corners[k], corners[(k + 1) % n], corners[j % n]);
        (c - a) * (f - b) - (d - b) * (e - a)
    };
    let area: f64 = (1..n).map(|k| cross(0, k)).sum();
    let least = 1e-12 * area.abs();
    let inside = |k: usize, j: usize| cross(k, j) * area.signum() > least;
    let turns = (0..n).find(|&k| !inside(k, k + 2));
    let turns = turns.map(|k| {
        (
            (k + 1) % n,
            "the outline does not turn the same way round at",
        )
    });
    turns.or_else(|| {
        let all = (0..n).flat_map(|k| (2..n).map(move |j| (k, k + j)));
        let crossed = all.into_iter().find(|&(k, j)| !inside(k, j));
        crossed.map(|(_, j)| (j % n, "the outline goes round more than once up to"))
    })
}
