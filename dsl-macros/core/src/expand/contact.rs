//! Contacts between shapes: `contact crate, ground: inelastic, friction mu` becomes surfaces, one for each corner that can touch,
//! and their laws with the sliding velocities.

use super::body::Bodies;
use super::clause::shown;
use super::names::{Scope, encoded, member};
use super::shape::{Shape, Strip};
use super::tokens::{ended, is_punct, items, place_of, undocumented};
use crate::diagnostics::{Checked, Place};
use proc_macro2::{Ident, Span, TokenStream, TokenTree};
use quote::quote_spanned;
use std::rc::Rc;

/// A smooth piece of a gap, `distance >= 0`, of a corner of one body on another one.
pub(super) struct Piece {
    pub(super) distance: TokenStream,
    /// The velocity at which they slide on each other.
    pub(super) sliding: TokenStream,
}

/// The corner of one body, with the radius around it, on another body with its own radius.
struct Touch<'b> {
    span: Span,
    corner: Ident,
    body: &'b str,
    on: &'b str,
    radius: Option<Ident>,
    others: Option<Ident>,
}

impl Bodies<'_> {
    /// `contact a, b: law`, also of more than two, each with each.
    pub(super) fn contact(&mut self, statement: &[TokenTree], scope: &Rc<Scope>) -> Checked<()> {
        let statement = ended(undocumented(statement));
        let begin = Place::at(statement[0].span());
        let colon = statement
            .iter()
            .position(|token| is_punct(Some(token), ':'));
        let colon = colon.unwrap_or(statement.len());
        let law = statement.get(colon + 1..).unwrap_or_default();
        let operands: Vec<&[TokenTree]> = items(&statement[1..colon]).collect();
        if operands.len() < 2 || law.is_empty() {
            let message = "a contact is that of two shapes with a law, as in `contact block, ground: inelastic, friction mu`";
            return Err(self.diagnostics.syntax(begin, message));
        }
        let is_word = |word: &'static str| move |token: &&TokenTree| matches!(token, TokenTree::Ident(own) if own == word);
        let rubs = law.iter().any(|token| is_word("friction")(&token));
        if let Some(wrong) = law.iter().find(is_word("sliding")) {
            let message =
                "the sliding velocity of a contact is derived from its bodies; leave `sliding` out";
            return Err(self.told(Place::at(wrong.span()), message));
        }
        let before = self.diagnostics.mistakes();
        let found: Vec<_> = operands
            .iter()
            .map(|operand| self.shapes_of(operand, scope))
            .collect();
        self.diagnostics.none_since(before)?;
        let found: Vec<Vec<usize>> = found.into_iter().flatten().collect();
        let is_list = found.len() > 2;
        for (k, first) in found.iter().enumerate() {
            for second in &found[k + 1..] {
                for (&a, &b) in first
                    .iter()
                    .flat_map(|a| second.iter().map(move |b| (a, b)))
                {
                    if is_list && self.stand_still(a, b) {
                        continue;
                    }
                    let place = place_of(&statement[1..colon], begin);
                    self.pair((a, b), place, (law, rubs), scope)?;
                }
            }
        }
        Ok(())
    }

    /// The shapes that a name means: that of a body with all that have names of their own, or one of these.
    pub(super) fn shapes_of(
        &mut self,
        tokens: &[TokenTree],
        scope: &Rc<Scope>,
    ) -> Checked<Vec<usize>> {
        let place = place_of(tokens, Place::at(Span::call_site()));
        let whole = self.whole(tokens, scope)?;
        let is_meant = |shape: &Shape| shape.name == whole || shape.body == whole;
        let found: Vec<usize> = (0..self.shapes.len())
            .filter(|&k| is_meant(&self.shapes[k]))
            .collect();
        match (found.is_empty(), self.bodies.contains_key(&whole)) {
            (false, _) => Ok(found),
            (true, true) => {
                let name = shown(&whole);
                let message = format!(
                    "body `{name}` has no shape above that could touch anything; declare one before, as in `shape {name}: circle r`"
                );
                Err(self.told(place, message))
            }
            (true, false) => Err(self.no_body(&whole, place)),
        }
    }

    /// Whether two shapes are on one body, or on bodies that are both fixed.
    fn stand_still(&self, a: usize, b: usize) -> bool {
        let [one, other] = [a, b].map(|shape| &self.shapes[shape].body);
        let is_fixed = |body: &str| self.bodies.get(body).is_some_and(|body| body.is_fixed);
        one == other || is_fixed(one) && is_fixed(other)
    }

    /// The surfaces and laws between two shapes.
    fn pair(
        &mut self,
        (a, b): (usize, usize),
        place: Place,
        (law, rubs): (&[TokenTree], bool),
        scope: &Rc<Scope>,
    ) -> Checked<()> {
        let [one, other] = [a, b].map(|shape| self.shapes[shape].body.clone());
        if self.stand_still(a, b) {
            let names = [a, b].map(|shape| shown(&self.shapes[shape].name));
            let message = format!(
                "`{}` and `{}` never move against each other, on one body or on fixed ones; leave the contact out",
                names[0], names[1]
            );
            return Err(self.told(place, message));
        }
        if rubs {
            for body in [&one, &other] {
                self.needs_angle(body, place, "friction, which turns it,")?;
            }
        }
        let groups = self.gaps(a, b, place.start);
        if groups.is_empty() {
            let kinds = [a, b].map(|shape| self.shapes[shape].kind);
            let message = format!(
                "there is no contact between a {} and a {}; give one of them a radius, as a circle or a capsule has",
                kinds[0], kinds[1]
            );
            return Err(self.told(place, message));
        }
        let (first, second) = (&self.shapes[a].name, &self.shapes[b].name);
        let own = second.strip_prefix(&scope.prefix).unwrap_or(second);
        let whole = format!("{first}.{own}");
        let many = groups.len() > 1;
        if !self.names.declare_path(&whole) {
            let message = format!(
                "`{}` is declared twice; keep one contact between two shapes",
                shown(&whole)
            );
            return Err(self.diagnostics.report("E19", place, message));
        }
        let span = place.start;
        for (k, pieces) in (1..).zip(groups) {
            let name = match many {
                true => {
                    self.names.declare(&whole, &[k]);
                    Ident::new(&encoded(&member(&whole, &[k])), span)
                }
                false => Ident::new(&encoded(&whole), span),
            };
            self.surface(&name, pieces, (law, rubs), scope);
        }
        Ok(())
    }

    /// One surface of a contact, with its law.
    fn surface(
        &mut self,
        name: &Ident,
        pieces: Vec<Piece>,
        (law, rubs): (&[TokenTree], bool),
        scope: &Rc<Scope>,
    ) {
        let span = name.span();
        let (gaps, slides): (Vec<TokenStream>, Vec<TokenStream>) = pieces
            .into_iter()
            .map(|piece| (piece.distance, piece.sliding))
            .unzip();
        let surface = match &gaps[..] {
            [gap] => quote_spanned!(span=> surface #name: #gap >= 0),
            gaps => quote_spanned!(span=> surface #name: max(#(#gaps),*) >= 0),
        };
        self.write(surface, scope);
        let law = law.iter();
        let law = quote_spanned!(span=> impact #name: #(#law)*);
        self.write(
            match rubs {
                false => law,
                true => quote_spanned!(span=> #law, sliding (#(#slides),*)),
            },
            scope,
        );
    }

    /// All gaps that have to be kept between two shapes, each the largest of its pieces.
    pub(super) fn gaps(&self, a: usize, b: usize, span: Span) -> Vec<Vec<Piece>> {
        let (a, b) = (&self.shapes[a], &self.shapes[b]);
        let is_round = a.radius.is_some() || b.radius.is_some();
        let halves = a.is_half_plane() || b.is_half_plane();
        let mut groups = Vec::new();
        // A sharp corner that meets a segment has no side on which it is.
        if !is_round && !halves && (a.sides.is_empty() || b.sides.is_empty()) {
            return groups;
        }
        if is_round && !halves {
            for corner in &a.corners {
                let touch = touch(a, corner, b, span);
                groups.extend(
                    b.corners
                        .iter()
                        .map(|other| vec![self.on_corner(&touch, other)]),
                );
            }
        }
        for (one, other) in [(a, b), (b, a)] {
            for corner in &one.corners {
                let touch = touch(one, corner, other, span);
                if is_round && !halves {
                    let strips = other.strips.iter();
                    groups.extend(strips.map(|strip| self.on_strip(&touch, strip)));
                } else if !other.sides.is_empty() {
                    let sides = other.sides.iter().map(|side| {
                        let (normal, foot) = (&side.normal, &side.foot);
                        let height = quote_spanned!(span=> #normal . (#corner - #foot));
                        self.piece(&touch, &side.normal, &less_radii(&touch, height))
                    });
                    groups.push(sides.collect());
                }
            }
        }
        groups
    }

    /// A round corner on a round corner.
    fn on_corner(&self, touch: &Touch<'_>, other: &Ident) -> Piece {
        let (span, corner) = (touch.span, &touch.corner);
        let distance = quote_spanned!(span=> |#corner - #other|);
        let normal = quote_spanned!(span=> ((#corner - #other)/#distance));
        self.piece(touch, &normal, &less_radii(touch, distance))
    }

    /// A corner on a strip that is a radius longer or wider than the core.
    fn on_strip(&self, touch: &Touch<'_>, strip: &Strip) -> Vec<Piece> {
        let (span, corner) = (touch.span, &touch.corner);
        let Strip {
            middle,
            along,
            across,
            half_length,
            half_width,
            is_longer,
        } = strip;
        let sides = [
            (quote_spanned!(span=> #along), half_length, *is_longer),
            (quote_spanned!(span=> #across), half_width, !is_longer),
            (quote_spanned!(span=> (-#along)), half_length, *is_longer),
            (quote_spanned!(span=> (-#across)), half_width, !is_longer),
        ];
        let pieces = sides.into_iter().map(|(normal, half, is_round)| {
            let distance = quote_spanned!(span=> #normal . (#corner - #middle) - #half);
            let distance = match is_round {
                true => less_radii(touch, distance),
                false => distance,
            };
            self.piece(touch, &normal, &distance)
        });
        pieces.collect()
    }

    /// A piece of a gap along a normal of length 1. The point of the corner that touches is a radius below it; its velocity and that of
    /// the other body there differ along the surface by `(p' - b') x n + w_a r_a + w_b (n . (p - b) - r_a)`.
    fn piece(&self, touch: &Touch<'_>, normal: &TokenStream, distance: &TokenStream) -> Piece {
        let (span, corner) = (touch.span, &touch.corner);
        let on = self.body_place(touch.on);
        let apart = quote_spanned!(span=> (dot(#corner) - dot(#on)));
        let mut sliding = quote_spanned!(span=> #normal[1]*#apart[0] - #normal[0]*#apart[1]);
        let mut below = quote_spanned!(span=> #normal . (#corner - #on));
        if let Some(radius) = &touch.radius {
            below = quote_spanned!(span=> #below - #radius);
            if self.turns(touch.body) {
                let angle = self.named(touch.body, "angle");
                sliding = quote_spanned!(span=> #sliding + dot(#angle)*#radius);
            }
        }
        if self.turns(touch.on) {
            let angle = self.named(touch.on, "angle");
            sliding = quote_spanned!(span=> #sliding + dot(#angle)*(#below));
        }
        let distance = distance.clone();
        Piece { distance, sliding }
    }
}

fn touch<'b>(shape: &'b Shape, corner: &Ident, on: &'b Shape, span: Span) -> Touch<'b> {
    Touch {
        span,
        corner: corner.clone(),
        body: &shape.body,
        on: &on.body,
        radius: shape.radius.clone(),
        others: on.radius.clone(),
    }
}

/// A distance of cores as one of shapes.
fn less_radii(touch: &Touch<'_>, distance: TokenStream) -> TokenStream {
    let radii = touch.radius.iter().chain(&touch.others);
    radii.fold(
        distance,
        |distance, radius| quote_spanned!(touch.span=> #distance - #radius),
    )
}
