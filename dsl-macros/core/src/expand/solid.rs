//! Shapes in space: spheres, boxes, capsules and half spaces.

use super::names::{Scope, encoded, member};
use super::shape::{Frame, Shapes, Side, pair};
use super::tokens::punct;
use crate::diagnostics::Checked;
use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::quote_spanned;
use std::rc::Rc;

/// Writes shapes in space out.
pub(super) struct Solids<'s, 'a>(pub(super) &'s mut Shapes<'a>);

impl Solids<'_, '_> {
    /// `shape crate: rectangle (w, h)` in the plane, `shape die: box (a, b, c)` in space.
    pub(super) fn shape(&mut self, statement: &[TokenTree], scope: &Rc<Scope>) -> Checked<()> {
        let mut frame = self.0.frame(statement, scope)?;
        match self.0.bodies.in_space {
            true => self.solid(&mut frame)?,
            false => self.0.in_plane(&mut frame)?,
        }
        self.0.list.push(frame.shape);
        Ok(())
    }

    fn solid(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        match frame.kind.word().as_str() {
            "sphere" => {
                frame.shape.radius = Some(self.0.size(frame, "radius", frame.kind.tokens())?);
                frame.shape.corners = vec![frame.shape.middle.clone()];
                frame.shape.kind = "sphere";
                self.draw_round(frame);
            }
            "point" => self.0.point(frame),
            "box" => self.cuboid(frame)?,
            "capsule" => self.rod(frame)?,
            _ => self.half_space(frame)?,
        }
        Ok(())
    }

    /// The axes of the body.
    fn axes(&mut self, frame: &Frame<'_>) -> [Ident; 3] {
        let (turn, span) = (self.0.bodies.turn(&frame.shape.body), frame.span);
        let axes = [
            ("along", [1, 0, 0]),
            ("across", [0, 1, 0]),
            ("up", [0, 0, 1]),
        ];
        axes.map(|(name, axis)| {
            let axis = axis.map(|part| super::tokens::number(part, span));
            let value = quote_spanned!(span=> = #turn*(#(#axis),*));
            self.0
                .bodies
                .define((&frame.shape.name, name, span), value, frame.scope)
        })
    }

    /// All that lies below the first two axes.
    fn half_space(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        if !matches!(frame.kind.tokens(), [TokenTree::Ident(word)] if word == "space") {
            let message =
                "a half space is written as in `shape table: half space`; `at` stands behind that";
            return Err(self
                .0
                .bodies
                .diagnostics
                .syntax(frame.kind.place(), message));
        }
        let [along, across, up] = self.axes(frame);
        let span = frame.span;
        let mut side = Side::new(quote_spanned!(span=> #up), quote_spanned!(span=> 0)).moved(true);
        side.tangents = Some([along, across]);
        frame.shape.sides.push(side);
        frame.shape.kind = "half space";
        Ok(())
    }

    /// A box: what is round comes near to its faces, its edges and its corners.
    fn cuboid(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        let sizes = self
            .0
            .lengths("box (a, b, c)", frame, ["length", "width", "height"])?;
        let axes = self.axes(frame);
        let (span, middle) = (frame.span, frame.shape.middle.clone());
        let both = ['+', '-'].map(|sign| punct(sign, span));
        for a in &both {
            for b in &both {
                for c in &both {
                    let parts = [a, b, c].into_iter().zip(&sizes).zip(&axes);
                    let parts = parts
                        .map(|((sign, size), axis)| quote_spanned!(span=> #sign #size/2*#axis));
                    self.0
                        .corner(frame, quote_spanned!(span=> #middle #(#parts)*));
                }
            }
        }
        let half = |k: usize| {
            let size = &sizes[k];
            quote_spanned!(span=> #size/2)
        };
        for sign in &both {
            for (k, axis) in axes.iter().enumerate() {
                let side = Side::new(quote_spanned!(span=> (#sign #axis)), half(k));
                frame.shape.sides.push(side);
            }
        }
        let faces = (0..3).map(|k| pair(&frame.shape.sides, 3, k));
        let mut strips: Vec<Vec<Side>> = faces.collect();
        for k in 0..3 {
            let (others, axis) = ([(k + 1) % 3, (k + 2) % 3], &axes[k]);
            for a in &both {
                for b in &both {
                    let parts = [a, b].into_iter().zip(others);
                    let parts = parts.map(|(sign, other)| {
                        let (size, axis) = (&sizes[other], &axes[other]);
                        quote_spanned!(span=> #sign #size/2*#axis)
                    });
                    let line = quote_spanned!(span=> = #middle #(#parts)*);
                    let line = self.0.listed(frame, ("edge", strips.len() - 2), line);
                    strips.push(around(axis, &half(k), line));
                }
            }
        }
        let shape = &mut frame.shape;
        (shape.kind, shape.is_solid, shape.strips) = ("box", true, strips);
        self.draw_edges(frame);
        Ok(())
    }

    /// All within a radius of a segment along the first axis.
    fn rod(&mut self, frame: &mut Frame<'_>) -> Checked<()> {
        let [length, radius] = self
            .0
            .lengths("capsule (l, r)", frame, ["length", "radius"])?;
        let [axis, ..] = self.axes(frame);
        let (span, middle) = (frame.span, frame.shape.middle.clone());
        for sign in ['+', '-'].map(|sign| punct(sign, span)) {
            self.0
                .corner(frame, quote_spanned!(span=> #middle #sign #length/2*#axis));
        }
        let strip = around(&axis, &quote_spanned!(span=> #length/2), middle);
        let shape = &mut frame.shape;
        (shape.kind, shape.strips, shape.radius) = ("capsule", vec![strip], Some(radius));
        self.draw_round(frame);
        Ok(())
    }

    /// Draws circles around the corners, as seen along the second axis.
    fn draw_round(&mut self, frame: &Frame<'_>) {
        let (Some(radius), true) = (&frame.shape.radius, frame.is_drawn) else {
            return;
        };
        for (k, corner) in (1..).zip(&frame.shape.corners) {
            let name = match frame.shape.corners.len() {
                1 => frame.shape.name.clone(),
                _ => member(&format!("{}.end", frame.shape.name), &[k]),
            };
            let name = Ident::new(&encoded(&name), frame.span);
            let entry = quote_spanned!(frame.span=> circle #name at (#corner[0], #corner[2]) radius #radius);
            self.0.bodies.drawn(&frame.shape.name, entry, frame.scope);
        }
    }

    /// Draws lines between corners that differ in one sign, as seen along the second axis.
    fn draw_edges(&mut self, frame: &Frame<'_>) {
        let pairs = (0..8_usize).flat_map(|a| [1, 2, 4].map(|bit| (a, a | bit)));
        for (a, b) in pairs.filter(|(a, b)| a < b && frame.is_drawn) {
            let [a, b] = [a, b].map(|k| &frame.shape.corners[k]);
            let entry = quote_spanned!(frame.span=> link (#a[0], #a[2]) to (#b[0], #b[2]));
            self.0.bodies.drawn(&frame.shape.name, entry, frame.scope);
        }
    }
}

/// What lies within a radius of a line of some length.
fn around(axis: &Ident, half: &TokenStream, line: Ident) -> Vec<Side> {
    let (span, end) = (axis.span(), |side: TokenStream| Side {
        line: Some(line.clone()),
        ..Side::new(side, half.clone())
    });
    let along = end(quote_spanned!(span=> #axis));
    vec![
        along.clone().moved(true),
        along,
        end(quote_spanned!(span=> (-#axis))),
    ]
}
