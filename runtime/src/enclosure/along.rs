//! Explicit functions along a piece of a motion.

use super::bounds::Bounds;
use super::calm::calm_parts;
use super::path::Path;
use super::range::Range;
use crate::model::{Explicit, Model, Pieces, Switching};

/// Most parts of a piece: a function that is confined to a hundred places of it is none of one step.
const MOST_PARTS: usize = 1024;

/// The ranges of explicit functions of a model, and of their slopes, over any part of a piece of a motion.
///
/// Parts are shares of the piece, and slopes are by that share.
pub(crate) struct Along<'a> {
    bounds: Bounds<'a>,
    pieces: Pieces,
    inputs: Inputs,
    /// Functions in which something may be hidden, in no order.
    hiding: Vec<Explicit>,
}

/// Ranges of the components of the input vector `(q, v, u[, t])`.
struct Inputs {
    n: usize,
    path: Path,
    /// What coordinates and velocities are in as a whole.
    whole: Vec<Range>,
    /// Controls at both ends; between them they are lines.
    controls: [Vec<f64>; 2],
    /// Begin and length \[s\].
    time: [f64; 2],
}

impl Inputs {
    fn range(&self, k: usize, part: [f64; 2]) -> Range {
        if k < 2 * self.n {
            return self.path.range(k, part);
        }
        self.given(k, part)
    }

    fn given(&self, k: usize, part: [f64; 2]) -> Range {
        let ends = match self.controls[0].get(k - 2 * self.n) {
            Some(&from) => [from, self.controls[1][k - 2 * self.n]],
            None => [self.time[0], self.time[0] + self.time[1]],
        };
        let at = |share: f64| (1.0 - share) * ends[0] + share * ends[1];
        Range::between(at(part[0]), at(part[1]))
    }

    /// That over the whole piece, by what is known before its polynomials are.
    fn as_a_whole(&self, k: usize) -> Range {
        match self.whole.get(k) {
            Some(&range) => range,
            None => self.given(k, [0.0, 1.0]),
        }
    }

    /// Rate of some order of a component by the time.
    fn rate(&self, k: usize, order: usize, part: [f64; 2]) -> Range {
        let factor = self.time[1].powi(-(order as i32));
        self.path.derivative(k, order, part).scaled(factor)
    }
}

impl<'a> Along<'a> {
    /// Of motions whose pieces are polynomials of this degree.
    pub(crate) fn new(model: &'a dyn Model, degree: usize) -> Self {
        let declaration = model.declaration();
        let bounds = Bounds::new(model);
        let sides = |i: usize| {
            [
                Explicit::Normal(i),
                Explicit::Tangent(i),
                Explicit::Across(i),
                Explicit::Share(i),
            ]
        };
        // Nothing acts by a condition that sets something.
        let acts = |i: &usize| declaration.contacts[*i].switch != Some(Switching::Resets);
        let sides = (0..declaration.contacts.len()).filter(acts).flat_map(sides);
        let functions = std::iter::once(Explicit::Motion).chain(sides);
        Self {
            hiding: functions
                .filter(|&function| bounds.may_hide(function))
                .collect(),
            bounds,
            pieces: Pieces::default(),
            inputs: Inputs {
                n: declaration.coordinates.len(),
                path: Path::new(degree),
                whole: Vec::new(),
                controls: [(); 2].map(|()| vec![0.0; declaration.controls.len()]),
                time: [0.0, 1.0],
            },
        }
    }

    /// Begins a piece from a `time` on of this `length` \[s\], with the controls at both of its ends.
    pub(crate) fn begin(&mut self, time: f64, length: f64, pieces: &Pieces) {
        self.inputs.time = [time, length];
        self.pieces.clone_from(pieces);
    }

    /// The controls at one end of the piece, 0 or 1.
    pub(crate) fn controls_at(&mut self, end: usize) -> &mut [f64] {
        &mut self.inputs.controls[end]
    }

    /// In what coordinates and velocities are over the whole piece; `fill` writes it.
    pub(crate) fn enclose(&mut self, fill: impl FnOnce(&mut Vec<Range>)) {
        self.inputs.whole.clear();
        fill(&mut self.inputs.whole);
    }

    /// Takes up the polynomials of the piece, by the coordinates and velocities `at` its places.
    pub(crate) fn follow(&mut self, at: impl FnMut(f64, &mut [f64])) {
        let count = 2 * self.inputs.n;
        self.inputs.path.follow(count, at);
    }

    /// Whether the operations of the gap of a contact are known.
    pub(crate) fn knows_gap(&self, contact: usize) -> bool {
        [contact, self.pieces.acting(contact)]
            .into_iter()
            .all(|i| self.bounds.knows(Explicit::Gap(i)) && self.bounds.knows(Explicit::Normal(i)))
    }

    /// Whether those of its sliding velocity are known.
    pub(crate) fn knows_sliding(&self, contact: usize) -> bool {
        self.bounds.knows(Explicit::Tangent(contact))
    }

    /// The range of a value of a contact, or of an idle piece of an edge of what it lacks to acting.
    fn of_pieces(
        &mut self,
        contact: usize,
        mut of: impl FnMut(&mut Self, usize) -> Range,
    ) -> Range {
        let own = of(self, contact);
        match self.pieces.acting(contact) {
            acting if acting == contact => own,
            acting => of(self, acting) - own,
        }
    }

    /// The range of a component of the input vector over the whole piece.
    pub(crate) fn input(&self, k: usize) -> Range {
        self.inputs.range(k, [0.0, 1.0])
    }

    /// A range of a gap over the whole piece, before its polynomials are known.
    pub(crate) fn gap_as_a_whole(&mut self, contact: usize) -> Range {
        self.of_pieces(contact, |own, contact| {
            let inputs = &own.inputs;
            own.bounds
                .of(Explicit::Gap(contact), |k| inputs.as_a_whole(k))
        })
    }

    /// The range of a gap over a part.
    pub(crate) fn gap(&mut self, contact: usize, part: [f64; 2]) -> Range {
        self.of_pieces(contact, |own, contact| {
            let inputs = &own.inputs;
            own.bounds
                .of(Explicit::Gap(contact), |k| inputs.range(k, part))
        })
    }

    /// The ranges of the slope of a gap over a part and of the slope of that: its normal velocity and acceleration, with the rates of the
    /// coordinates as velocities.
    pub(crate) fn gap_slopes(&mut self, contact: usize, part: [f64; 2]) -> [Range; 2] {
        let length = self.inputs.time[1];
        let mut bends = [Range::of(0.0); 2];
        let mut known = bends.iter_mut();
        let rate = self.of_pieces(contact, |own, contact| {
            let [rate, bend] = own.normal(contact, part);
            if let Some(known) = known.next() {
                *known = bend;
            }
            rate
        });
        let bend = match self.pieces.acting(contact) {
            acting if acting == contact => bends[0],
            _ => bends[1] - bends[0],
        };
        [rate.scaled(length), bend.scaled(length * length)]
    }

    /// Normal velocity and acceleration of a contact.
    fn normal(&mut self, contact: usize, part: [f64; 2]) -> [Range; 2] {
        let (inputs, n) = (&self.inputs, self.inputs.n);
        let known = self.bounds.evaluate(Explicit::Normal(contact), |k| {
            if (n..2 * n).contains(&k) {
                inputs.rate(k - n, 1, part)
            } else {
                inputs.range(k, part)
            }
        });
        if !known {
            return [Range::ALL; 2];
        }
        let curvature = self.bounds.output(1);
        let bend = self
            .bounds
            .turned(curvature, n, |k| inputs.rate(k, 2, part));
        [self.bounds.output(0), bend]
    }

    /// A range of a sliding velocity over the whole piece, before its polynomials are known.
    pub(crate) fn sliding_as_a_whole(&mut self, contact: usize) -> Range {
        let inputs = &self.inputs;
        let function = Explicit::Tangent(contact);
        self.bounds.of(function, |k| inputs.as_a_whole(k))
    }

    /// The range of a sliding velocity over a part.
    pub(crate) fn sliding(&mut self, contact: usize, part: [f64; 2]) -> Range {
        let inputs = &self.inputs;
        let function = Explicit::Tangent(contact);
        self.bounds.of(function, |k| inputs.range(k, part))
    }

    /// The range of the slope of a sliding velocity over a part, `b' v' + curvature`.
    pub(crate) fn sliding_slope(&mut self, contact: usize, part: [f64; 2]) -> Range {
        let (inputs, n) = (&self.inputs, self.inputs.n);
        let function = Explicit::Tangent(contact);
        if !self.bounds.evaluate(function, |k| inputs.range(k, part)) {
            return Range::ALL;
        }
        let curvature = self.bounds.output(1);
        let rate = self
            .bounds
            .turned(curvature, n, |k| inputs.rate(n + k, 1, part));
        rate.scaled(inputs.time[1])
    }

    /// The functions among those of the motion and of the `active` contacts in which something may be hidden.
    pub(crate) fn hiding(&self, active: impl Fn(usize) -> bool) -> Vec<Explicit> {
        let acts = |function: &Explicit| match *function {
            Explicit::Motion => true,
            Explicit::Gap(i) | Explicit::Normal(i) => active(i),
            Explicit::Tangent(i) | Explicit::Across(i) | Explicit::Share(i) => active(i),
        };
        self.hiding.iter().copied().filter(acts).collect()
    }

    /// Whether nothing is hidden in functions over the whole piece, before its polynomials are known. Sines of what moves are the same
    /// everywhere and hide nothing.
    pub(crate) fn is_calm(&mut self, functions: &[Explicit]) -> bool {
        let inputs = &self.inputs;
        functions.iter().all(|&function| {
            let asked = (function, f64::INFINITY);
            self.bounds
                .is_calm(asked, [0.0, 1.0], |k, _| inputs.as_a_whole(k))
        })
    }

    /// Parts of the piece in each of which nothing is hidden in functions; none if there are too many.
    pub(crate) fn calm_parts(&mut self, functions: &[Explicit]) -> Option<Vec<[f64; 2]>> {
        let inputs = &self.inputs;
        calm_parts(MOST_PARTS, |part| {
            functions.iter().all(|&function| {
                let asked = (function, f64::INFINITY);
                self.bounds
                    .is_calm(asked, part, |k, part| inputs.range(k, part))
            })
        })
    }
}
