//! How fast what acts depends on time itself, looked at before a step is made.
//!
//! Errors of a step are estimated from what its stages see of a motion. A body that rests or sticks does not move, whatever its
//! forces do between the stages, and a pulse between them leaves no trace of itself; another run with other steps agrees. So
//! accelerations, gaps and slips are bounded as functions of time alone beforehand, the state being the present one: a step may be as long
//! as nothing in them is confined to a part of it, and sines go through a radian at most. Where that is not so, they are looked at in
//! each part where it is, and a step may be as long as the cubic through four places of it tells what is at all others, up to a share of
//! their range. A sinusoid gets about six steps a period by that, a pulse as many.

use crate::enclosure::{Bounds, Range, calm_parts};
use crate::model::{Explicit, Model, SparsityPattern, friction_coefficients};
use crate::simulation::InitialValueProblem;
use crate::yardstick;

/// Share of the horizon that is a moment: no step is asked for that is much shorter.
const MOMENT: f64 = 1e-4;
/// Most parts of a step, and parts of the horizon that tell the range of functions before the run where more of them would be calm. Chosen:
/// what acts at more places than this is resolved by a shorter step.
const MOST_PARTS: usize = 256;
/// Part of a sine over which a step tells it \[rad\].
const WAVE: f64 = 1.0;
/// Places in a part of a step in which nothing is hidden.
const PLACES: [f64; 4] = [0.21, 0.55, 0.83, 1.0];
/// Longest step relative to the last one, and in moments where that was short: looking far ahead of a motion that is stopped by
/// events is in vain.
const GROWTH: f64 = 4.0;
const SHORT: f64 = 16.0;
/// Moments between the ends of the shortest step that is asked for.
const SHORTEST: f64 = 0.125;

/// What a model with explicit time does in the steps to come.
pub(super) struct ExplicitTime<'a> {
    functions: Vec<Explicit>,
    bounds: Bounds<'a>,
    /// Input vector of the model.
    x: Vec<f64>,
    /// A moment \[s\].
    moment: f64,
    /// Least and largest value of each function so far.
    ranges: Vec<(f64, f64)>,
    /// Values of all functions at all places of a step, and its places as shares of it.
    values: Vec<f64>,
    places: Vec<f64>,
    /// Length of the last step that was looked at \[s\].
    last: f64,
    /// Whether it was shortened, so that its length is a time of the functions themselves.
    limited: bool,
    /// Time and length of the first step that does not resolve them \[s\], and what helps.
    too_fast: Option<(f64, f64, &'static str)>,
}

/// The functions of a model that read the time: accelerations without contacts, normal sides of contacts, tangential sides with friction and
/// its factor.
fn functions(model: &dyn Model) -> Vec<Explicit> {
    let declaration = model.declaration();
    let time = declaration.inputs().saturating_sub(1);
    let reads = |pattern: SparsityPattern| (0..pattern.rows).any(|row| pattern.reads(row, time));
    let motion = reads(declaration.free_jacobian).then_some(Explicit::Motion);
    let coefficients = friction_coefficients(model);
    let of_contact = |i: usize| {
        let known = &declaration.contacts[i];
        let friction = known.friction.filter(|_| coefficients[i] > 0.0);
        let sides = friction
            .into_iter()
            .flat_map(|known| [Some(known.jacobian), known.across]);
        let slides = sides.flatten().any(reads);
        let tangential = [
            Explicit::Tangent(i),
            Explicit::Across(i),
            Explicit::Share(i),
        ];
        let normal = reads(known.jacobian).then_some(Explicit::Normal(i));
        normal
            .into_iter()
            .chain(tangential.into_iter().filter(move |_| slides))
    };
    let contacts = (0..declaration.contacts.len()).flat_map(of_contact);
    motion.into_iter().chain(contacts).collect()
}

impl<'a> ExplicitTime<'a> {
    /// That of a model along a problem; none if the model does not read the time.
    pub(super) fn of(model: &'a dyn Model, problem: &InitialValueProblem) -> Option<Self> {
        if !model.declaration().explicit_time {
            return None;
        }
        let mut time = Self {
            ranges: Vec::new(),
            functions: functions(model),
            bounds: Bounds::new(model),
            x: problem.input(model),
            moment: MOMENT * problem.horizon,
            values: Vec::new(),
            places: Vec::new(),
            last: 0.0,
            limited: false,
            too_fast: None,
        };
        // Before the run it is seen which values functions have, as far as they are told.
        let parts = time.calm_parts(0.0, problem.horizon).unwrap_or_else(|| {
            let at = |k: usize| k as f64 / MOST_PARTS as f64;
            (0..MOST_PARTS).map(|k| [at(k), at(k + 1)]).collect()
        });
        time.look(0.0, problem.horizon, &parts);
        Some(time)
    }

    /// The longest step of at most `wanted` from the input vector `x` that resolves what depends on time.
    pub(super) fn longest(&mut self, x: &[f64], wanted: f64) -> f64 {
        self.x.copy_from_slice(x);
        let from = x.last().copied().unwrap_or_default();
        let mut length = wanted.min((GROWTH * self.last).max(SHORT * self.moment));
        self.limited = false;
        let shortest = SHORTEST * self.moment;
        while length >= shortest && !self.resolves(from, length) {
            self.limited = true;
            if length < 2.0 * shortest {
                let first = (from, length, "shorten the horizon");
                self.too_fast.get_or_insert(first);
                break;
            }
            length *= 0.5;
        }
        self.last = length;
        length
    }

    /// Whether a step resolves what depends on time.
    fn resolves(&mut self, from: f64, length: f64) -> bool {
        match self.calm_parts(from, length) {
            None => false,
            Some(parts) if parts.len() == 1 => true,
            Some(parts) => {
                self.look(from, length, &parts);
                self.tells()
            }
        }
    }

    /// Parts of a step in each of which nothing is hidden; none if there are too many.
    fn calm_parts(&mut self, from: f64, length: f64) -> Option<Vec<[f64; 2]>> {
        let (x, bounds) = (&self.x, &mut self.bounds);
        let last = x.len() - 1;
        calm_parts(MOST_PARTS, |part| {
            self.functions.iter().all(|&function| {
                bounds.is_calm((function, WAVE), part, |k, part| {
                    if k == last {
                        let [begin, end] = part.map(|share| from + share * length);
                        Range::between(begin, end)
                    } else {
                        Range::of(x[k])
                    }
                })
            })
        })
    }

    /// A time over which what acts is smooth \[s\].
    pub(super) fn moment(&self) -> f64 {
        if self.limited {
            self.last
        } else {
            self.last.max(SHORT * self.moment)
        }
    }

    /// Evaluates all functions at places of all parts of a step, and includes them in their ranges.
    fn look(&mut self, from: f64, length: f64, parts: &[[f64; 2]]) {
        self.values.clear();
        self.places.clear();
        let inner = parts
            .iter()
            .flat_map(|[a, b]| PLACES.map(|place| a + place * (b - a)));
        self.places.extend(std::iter::once(0.0).chain(inner));
        let last = self.x.len() - 1;
        for place in &self.places {
            self.x[last] = from + place * length;
            for &function in &self.functions {
                let x = &self.x;
                if self.bounds.evaluate(function, |k| Range::of(x[k])) {
                    self.values
                        .extend(self.bounds.outputs().map(|value| value.low));
                }
            }
        }
        let count = self.values.len() / self.places.len();
        self.ranges
            .resize(count, (f64::INFINITY, f64::NEG_INFINITY));
        for row in self.values.chunks_exact(count.max(1)) {
            for (range, &value) in self.ranges.iter_mut().zip(row) {
                if value.is_finite() {
                    *range = (range.0.min(value), range.1.max(value));
                }
            }
        }
    }

    /// Whether the cubics through four places tell the values at all others.
    fn tells(&self) -> bool {
        let (count, last) = (self.ranges.len(), self.places.len() - 1);
        let inner = |share: f64| self.places.partition_point(|place| *place < share);
        let nodes = [0, inner(0.25), inner(0.75), last];
        let at = nodes.map(|node| self.places[node]);
        let row = |k: usize| &self.values[k * count..(k + 1) * count];
        let through = nodes.map(row);
        (0..=last).all(|k| {
            let weights = cubic_weights(at, self.places[k]);
            row(k).iter().enumerate().all(|(j, value)| {
                let terms = weights.iter().zip(&through);
                let told: f64 = terms.map(|(weight, row)| weight * row[j]).sum();
                let (least, largest) = self.ranges[j];
                let allowed = (yardstick::VISIBLE * (largest - least))
                    .max(yardstick::DIGITS * largest.abs().max(least.abs()));
                let missed = (value - told).abs();
                missed <= allowed || !missed.is_finite()
            })
        })
    }

    /// Takes note of the first of `count` elements of a grid from the input vector `x`, of this `length`, that does not even resolve
    /// with its halves what depends on time.
    pub(super) fn watch(&mut self, x: &[f64], length: f64, count: usize) {
        self.x.copy_from_slice(x);
        let from = x.last().copied().unwrap_or_default();
        let half = 0.5 * length;
        for k in 0..2 * count {
            if self.too_fast.is_some() {
                return;
            }
            let time = from + k as f64 * half;
            if !self.resolves(time, half) {
                self.too_fast = Some((time, length, "take more steps"));
            }
        }
    }

    /// Whether steps do not tell what depends on time, which the run says.
    pub(super) fn is_too_fast(&self) -> bool {
        self.too_fast.is_some()
    }

    /// What has to be said of a run.
    pub(super) fn note(&self) -> Option<String> {
        self.too_fast.map(|(time, length, help)| {
            format!(
                "what acts depends on time faster than steps of {length:.1e} s tell, first at t = {time} s, so that lift-offs, \
                 slips and impacts may be missed where nothing else moves; {help}"
            )
        })
    }
}

/// Weights of the values at four places in the cubic through them, at `place`.
fn cubic_weights(at: [f64; 4], place: f64) -> [f64; 4] {
    let mut weights = [1.0; 4];
    for (i, weight) in weights.iter_mut().enumerate() {
        for (j, other) in at.iter().enumerate() {
            if i != j {
                *weight *= (place - other) / (at[i] - other);
            }
        }
    }
    weights
}
