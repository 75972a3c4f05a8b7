//! How fast what acts depends on time itself, looked at before a step is made.
//!
//! Errors of a step are estimated from what its stages see of a motion. A body that rests or sticks does not move, whatever its
//! forces do between the stages, and a pulse between them leaves no trace of itself; another run with other steps agrees. So
//! accelerations, gaps and slips are bounded as functions of time alone beforehand, the state being the present one: a step may be as long
//! as nothing in them is confined to a part of it, and sines go through a radian at most. Where that is not so, they are looked at in
//! each part where it is, and a step may be as long as the cubic through four places of it tells what is at all others, up to a share of
//! their range. A sinusoid gets about six steps a period by that, a pulse as many.

use crate::enclosure::{Bounds, Range, calm_parts};
use crate::model::{Explicit, Model, contact_point, friction_coefficients, tangent_point};
use crate::simulation::InitialValueProblem;

/// Share of the horizon that is a moment: no step is asked for that is much shorter.
const MOMENT: f64 = 1e-4;
/// Most parts of a step. Chosen: what acts at more places than this is resolved by a shorter one.
const MOST_PARTS: usize = 64;
/// Part of a sine over which a step tells it \[rad\].
const WAVE: f64 = 1.0;
/// Places in a part of a step in which nothing is hidden.
const PLACES: [f64; 4] = [0.21, 0.55, 0.83, 1.0];
/// Parts of the horizon that tell the range of functions before the run, where more of them would be calm.
const FIRST_PARTS: usize = 256;
/// Share of the range of a function that the cubic may miss.
const MISSED: f64 = 1e-3;
/// Share of the largest value of a function that is rounding.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Longest step relative to the last one, and in moments where that was short: looking far ahead of a motion that is stopped by
/// events is in vain.
const GROWTH: f64 = 4.0;
const SHORT: f64 = 16.0;
/// Moments between the ends of the shortest step that is asked for.
const SHORTEST: f64 = 0.125;

/// What a model with explicit time does in the steps to come.
pub(super) struct ExplicitTime<'a> {
    functions: Functions<'a>,
    bounds: Bounds<'a>,
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

/// The functions that read the time: accelerations without contacts; gap, normal velocity and curvature of contacts; sliding
/// velocity and curvature of friction.
struct Functions<'a> {
    model: &'a dyn Model,
    accelerations: bool,
    contacts: Vec<usize>,
    tangents: Vec<usize>,
    /// All of them whose operations may be known.
    explicit: Vec<Explicit>,
    /// Input vector of the model.
    x: Vec<f64>,
    acceleration: Vec<f64>,
    point: Vec<f64>,
    tangent: Vec<f64>,
}

impl<'a> Functions<'a> {
    /// Those of a model; none if it does not read the time.
    fn of(model: &'a dyn Model) -> Option<Self> {
        let declaration = model.declaration();
        if !declaration.explicit_time {
            return None;
        }
        let n = declaration.coordinates.len();
        let time = declaration.inputs() - 1;
        let contacts = declaration.contacts;
        let friction = friction_coefficients(model);
        let reads = |i: &usize| {
            (0..contacts[*i].jacobian.rows).any(|row| contacts[*i].jacobian.reads(row, time))
        };
        let slides = |i: &usize| {
            let pattern = contacts[*i].friction.map(|friction| friction.jacobian);
            let across = contacts[*i].friction.and_then(|friction| friction.across);
            let mut patterns = pattern.into_iter().chain(across);
            friction[*i] > 0.0 && patterns.any(|p| (0..p.rows).any(|row| p.reads(row, time)))
        };
        let free = declaration.free_jacobian;
        let accelerations = (0..n).any(|row| free.reads(row, time));
        let normal: Vec<usize> = (0..contacts.len()).filter(reads).collect();
        let tangents: Vec<usize> = (0..contacts.len()).filter(slides).collect();
        let motion = accelerations.then_some(Explicit::Motion).into_iter();
        let explicit = motion.chain(normal.iter().map(|&i| Explicit::Normal(i)));
        let sides = |&i: &usize| [Explicit::Tangent(i), Explicit::Across(i)];
        let explicit = explicit.chain(tangents.iter().flat_map(sides)).collect();
        Some(Self {
            model,
            explicit,
            accelerations,
            contacts: normal,
            tangents,
            x: vec![0.0; declaration.inputs()],
            acceleration: vec![0.0; n],
            point: vec![0.0; contact_point::length(n)],
            tangent: vec![0.0; tangent_point::length(n)],
        })
    }

    fn count(&self) -> usize {
        let accelerations = if self.accelerations {
            self.acceleration.len()
        } else {
            0
        };
        let beyond = self.tangents.iter().map(|&contact| {
            let friction = self.model.declaration().contacts[contact].friction;
            friction.map_or(0, |known| {
                usize::from(known.share) + 2 * usize::from(known.across.is_some())
            })
        });
        let beyond: usize = beyond.sum();
        accelerations + 3 * self.contacts.len() + 2 * self.tangents.len() + beyond
    }

    /// Appends their values at `time` and the state of the input vector to `values`.
    fn append(&mut self, time: f64, values: &mut Vec<f64>) {
        if let Some(last) = self.x.last_mut() {
            *last = time;
        }
        if self.accelerations {
            self.model
                .free_acceleration(&self.x, &mut self.acceleration);
            values.extend_from_slice(&self.acceleration);
        }
        for &contact in &self.contacts {
            self.model.contact(contact, &self.x, &mut self.point);
            values.extend_from_slice(&self.point[..=contact_point::CURVATURE]);
        }
        for &contact in &self.tangents {
            self.model.tangent(contact, &self.x, &mut self.tangent);
            values.extend_from_slice(&self.tangent[..=tangent_point::CURVATURE]);
            let Some(friction) = self.model.declaration().contacts[contact].friction else {
                continue;
            };
            if friction.share {
                values.push(self.model.friction_share(contact, &self.x));
            }
            if friction.across.is_some() {
                self.model.across(contact, &self.x, &mut self.tangent);
                values.extend_from_slice(&self.tangent[..=tangent_point::CURVATURE]);
            }
        }
    }
}

impl<'a> ExplicitTime<'a> {
    /// That of a model along a problem; none if the model does not read the time.
    pub(super) fn of(model: &'a dyn Model, problem: &InitialValueProblem) -> Option<Self> {
        let functions = Functions::of(model)?;
        let mut time = Self {
            ranges: vec![(f64::INFINITY, f64::NEG_INFINITY); functions.count()],
            functions,
            bounds: Bounds::new(model),
            moment: MOMENT * problem.horizon,
            values: Vec::new(),
            places: Vec::new(),
            last: 0.0,
            limited: false,
            too_fast: None,
        };
        time.functions.x.copy_from_slice(&problem.input(model));
        // Before the run it is seen which values functions have, as far as they are told.
        let parts = time.calm_parts(0.0, problem.horizon).unwrap_or_else(|| {
            let at = |k: usize| k as f64 / FIRST_PARTS as f64;
            (0..FIRST_PARTS).map(|k| [at(k), at(k + 1)]).collect()
        });
        time.look(0.0, problem.horizon, &parts);
        Some(time)
    }

    /// The longest step of at most `wanted` from the input vector `x` that resolves what depends on time.
    pub(super) fn longest(&mut self, x: &[f64], wanted: f64) -> f64 {
        self.functions.x.copy_from_slice(x);
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
        let (x, bounds) = (&self.functions.x, &mut self.bounds);
        let last = x.len() - 1;
        calm_parts(MOST_PARTS, |part| {
            self.functions.explicit.iter().all(|&function| {
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
        for place in &self.places {
            self.functions
                .append(from + place * length, &mut self.values);
        }
        if self.ranges.is_empty() {
            return;
        }
        for row in self.values.chunks_exact(self.ranges.len()) {
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
                let allowed =
                    (MISSED * (largest - least)).max(ROUNDING * largest.abs().max(least.abs()));
                let missed = (value - told).abs();
                missed <= allowed || !missed.is_finite()
            })
        })
    }

    /// Takes note of the first of `count` elements of a grid from the input vector `x`, of this `length`, that does not even resolve
    /// with its halves what depends on time.
    pub(super) fn watch(&mut self, x: &[f64], length: f64, count: usize) {
        self.functions.x.copy_from_slice(x);
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
