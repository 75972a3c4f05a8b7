//! The earliest event within a step: enclosed on the continuous extension, confirmed and polished with
//! true steps of the method.

use super::dop853::Dop853;
use super::dynamics::{Dynamics, Switch, motion, switching};
use super::tableau::DEGREE;
use crate::enclosure::{
    Along, Bracket, Fall, Form, Interpolated, Sample, Suspect, Watched, earliest_fall, refine,
};
use crate::model::{Explicit, contact_point};
use crate::yardstick;
use std::collections::BTreeSet;
use std::convert::Infallible;

/// Crossings of one switching function on the continuous extension that true steps may refute before the step
/// counts as too long.
const FALSE_ALARMS: usize = 20;
/// A crossing less deep than this share of the range of values within the step is confirmed by a true
/// step: it may be an error of the continuous extension.
const SHALLOW: f64 = 1e-4;
/// Share of what counts as zero that rounding leaves of a value that vanishes.
const ROUNDING: f64 = 1e-3;
/// Halvings of a step on the way back to where the true solution is positive.
const HALVINGS: usize = 40;
/// Most bisections of a step; 64 use up all digits.
const BISECTIONS: usize = 80;
/// Most places of a step at which all forces are remembered: those of their interpolants.
const PLACES_REMEMBERED: usize = 16;

/// The switching functions at a place of the continuous extension.
#[derive(Debug, Clone)]
struct Place {
    theta: f64,
    values: Vec<f64>,
    /// Sizes of the terms of those that are forces.
    scales: Vec<f64>,
}

/// Buffers of the search.
pub(super) struct EventSearch<'a> {
    /// Explicit functions on the continuous extension.
    along: Along<'a>,
    /// What acts in the present mode.
    acting: Vec<Explicit>,
    memory: Memory,
    false_alarms: Vec<usize>,
    /// The functions that may vanish within the step.
    suspects: Vec<Option<Suspect>>,
    end: Vec<f64>,
    /// Value of the function at the last root.
    root_value: f64,
    /// Functions that were looked at by some of their values.
    pub(super) interpolated: BTreeSet<Interpolated>,
    /// Whether values vary faster than any step tells, so that those of its stages have to do.
    pub(super) too_fast: bool,
}

/// Buffers of an evaluation.
struct Memory {
    /// Where forces were evaluated since the last true step.
    places: Vec<Place>,
    state: Vec<f64>,
    slope: Vec<f64>,
}

/// The step that was just made, from `(t, y)` with length `h`.
#[derive(Clone, Copy)]
pub(super) struct Step<'a> {
    pub(super) t: f64,
    pub(super) h: f64,
    pub(super) y: &'a [f64],
    /// Values of the switching functions at its start and its end.
    pub(super) start_values: &'a [f64],
    pub(super) end_values: &'a [f64],
}

impl Step<'_> {
    /// Shortest time that can be told from none.
    fn resolution(&self) -> f64 {
        f64::EPSILON * (self.t.abs() + self.h)
    }
}

/// The step that was just made, by a method on the dynamics of a mode; true steps of other lengths are made again.
pub(super) struct Made<'s, 'a> {
    pub(super) dynamics: &'s mut Dynamics<'a>,
    pub(super) method: &'s mut Dop853,
    pub(super) step: Step<'s>,
}

/// An event: which switching function vanishes, and the length of the step that ends there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub(super) function: usize,
    pub(super) h: f64,
}

/// What the search found.
#[derive(Debug, Clone, Copy)]
pub(super) enum Outcome {
    /// No event within the step.
    Nothing,
    /// The earliest event.
    Event(Found),
    /// Something acts that the stages of the step do not show: the step is too long.
    Hidden,
    /// This function changes its sign through infinity, or by a jump.
    Pole(Found),
    /// The continuous extension is too far from the solution to find the zeros of this function: the step
    /// is too long.
    Unresolved(usize),
}

impl<'a> EventSearch<'a> {
    pub(super) fn new(dynamics: &Dynamics<'a>) -> Self {
        let (dimension, functions) = (2 * dynamics.n + 1, dynamics.functions());
        Self {
            along: Along::new(dynamics.model, DEGREE),
            acting: Vec::new(),
            memory: Memory {
                places: Vec::new(),
                state: vec![0.0; dimension],
                slope: vec![0.0; dimension],
            },
            end: vec![0.0; dimension],
            false_alarms: vec![0; functions],
            suspects: vec![None; functions],
            root_value: 0.0,
            interpolated: BTreeSet::new(),
            too_fast: false,
        }
    }

    /// Finds the functions that may vanish within the step, by bounds over the whole of it; whether there are any.
    pub(super) fn suspect(
        &mut self,
        dynamics: &mut Dynamics<'_>,
        method: &Dop853,
        step: Step<'_>,
    ) -> bool {
        self.along.begin(step.t, step.h, &dynamics.pieces);
        for (end, time) in [step.t, step.t + step.h].into_iter().enumerate() {
            dynamics.write_controls(time);
            self.along.controls_at(end).copy_from_slice(&dynamics.u);
        }
        self.along
            .enclose(|whole| method.enclose(step.y, step.h, whole));
        self.suspects.fill(None);
        let mut any = false;
        for slot in 0..dynamics.near().len() {
            any |= self.suspect_one(dynamics, step, dynamics.near()[slot]);
        }
        for function in dynamics.contacts..dynamics.functions() {
            any |= self.suspect_one(dynamics, step, function);
        }
        any
    }

    /// Whether bounds tell that nothing acts in the step that its stages do not show.
    pub(super) fn is_calm(&mut self, dynamics: &Dynamics<'_>) -> bool {
        self.acting = self.along.hiding(|i| dynamics.is_active(i));
        self.along.is_calm(&self.acting)
    }

    /// Parts of the step in each of which nothing is hidden of what acts; none if there are too many.
    pub(super) fn calm_parts(&mut self) -> Option<Vec<[f64; 2]>> {
        self.along.calm_parts(&self.acting)
    }

    /// Takes up the continuous extension of the step, which is ready.
    pub(super) fn follow(&mut self, method: &Dop853) {
        self.along
            .follow(|theta, out| method.interpolate(theta, out));
    }

    /// Whether some function was suspected to vanish in the last step.
    pub(super) fn has_suspects(&self) -> bool {
        self.suspects.iter().any(Option::is_some)
    }

    fn suspect_one(&mut self, dynamics: &Dynamics<'_>, step: Step<'_>, function: usize) -> bool {
        let zero = self.least_zero(dynamics, step, function);
        let watched = watched(dynamics, function);
        let suspicious = if watched.is_explicit(&self.along) {
            watched.as_a_whole(&mut self.along).low < -zero
        } else {
            self.interpolated.extend(named(dynamics.switch(function)));
            dynamics.switching.lowest[function] <= 0.0
                || !self.too_fast && may_cross(dynamics, function)
        };
        if suspicious {
            let values = [(0.0, step.start_values), (1.0, step.end_values)];
            let [from, end] = values.map(|(at, values)| Sample {
                at,
                value: values[function],
            });
            self.suspects[function] = Some(Suspect {
                watched,
                from,
                end,
                zero,
                rounding: ROUNDING * switching::zero_value(dynamics, function),
            });
        }
        suspicious
    }

    /// The earliest event within the step, whose continuous extension is ready. If there is one,
    /// `method.end()` is the state there, on the surfaces of the active contacts; if there is nothing,
    /// it stays the end of the step.
    pub(super) fn earliest(&mut self, made: &mut Made<'_, '_>) -> Outcome {
        let step = made.step;
        self.memory.places.clear();
        self.end.copy_from_slice(made.method.end());
        self.false_alarms.fill(0);
        loop {
            let memory = &mut self.memory;
            let value = |function, theta| memory.interpolated(made, function, theta);
            let crossing = match earliest_fall(&mut self.along, &self.suspects, value) {
                Ok(Some(crossing)) => crossing,
                Ok(None) => break,
                Err(function) => return Outcome::Unresolved(function),
            };
            let function = crossing.function;
            match self.polish(made, crossing) {
                Ok(h) => {
                    // A function changes its sign at a pole as well, and a gap where it jumps.
                    let Fall {
                        from, left, zero, ..
                    } = crossing;
                    let last = step.end_values[function];
                    let largest = from.value.abs().max(last.abs());
                    let kept = match made.dynamics.switch(function) {
                        Switch::Gap(_) if left.value > zero => yardstick::VISIBLE * largest,
                        _ => largest,
                    };
                    return if self.root_value.abs() > kept.max(zero) {
                        Outcome::Pole(Found { function, h })
                    } else {
                        Outcome::Event(Found { function, h })
                    };
                }
                Err(value) => {
                    let Sample { at, value: wrong } = crossing.right;
                    self.false_alarms[function] += 1;
                    if at >= 1.0 || self.false_alarms[function] > FALSE_ALARMS {
                        return Outcome::Unresolved(function);
                    }
                    if let Some(suspect) = &mut self.suspects[function] {
                        suspect.from = Sample { at, value };
                        // So wrong is the continuous extension here.
                        suspect.zero = suspect.zero.max(4.0 * (value - wrong));
                    }
                }
            }
        }
        for i in 0..made.dynamics.functions() {
            if step.end_values[i] < -self.least_zero(made.dynamics, step, i) {
                return Outcome::Unresolved(i);
            }
        }
        made.method.end_mut().copy_from_slice(&self.end);
        Outcome::Nothing
    }

    /// What counts as zero for the value of a switching function if the continuous extension is exact: one that
    /// starts below zero and grows is no crossing.
    fn least_zero(&self, dynamics: &Dynamics<'_>, step: Step<'_>, function: usize) -> f64 {
        let zero = switching::zero_value(dynamics, function);
        zero.max(-2.0 * step.start_values[function])
    }

    /// Normal velocity of a contact at the end of the last true step.
    fn normal_velocity(&mut self, made: &mut Made<'_, '_>, t: f64, contact: usize) -> f64 {
        made.dynamics.load(t, made.method.end());
        made.dynamics.evaluate_contact(contact);
        made.dynamics.point(contact)[contact_point::NORMAL_VELOCITY]
    }

    /// Value of a switching function after a true step of length `h`, which ends in `method.end()`.
    fn stepped(&mut self, made: &mut Made<'_, '_>, function: usize, h: f64) -> f64 {
        let step = made.step;
        self.memory.places.clear();
        // Only one function is looked at, at the end.
        made.dynamics.leave_gaps(true);
        made.method.step(made.dynamics, step.t, step.y, h);
        made.dynamics.leave_gaps(false);
        if !motion::project(made.dynamics, step.t + h, made.method.end_mut()) {
            return f64::NAN;
        }
        switching::switching_value(
            made.dynamics,
            function,
            step.t + h,
            made.method.end(),
            &mut self.memory.slope,
        )
    }

    /// Length of the true step at whose end the value of the function vanishes; if there is none in the
    /// bracket, the value at its right end.
    fn polish(&mut self, made: &mut Made<'_, '_>, crossing: Fall) -> Result<f64, f64> {
        let step = made.step;
        let Fall {
            function,
            mut from,
            left,
            right,
            root: theta,
            ..
        } = crossing;
        let zero = self.least_zero(made.dynamics, step, function);
        let range =
            made.dynamics.switching.highest[function] - made.dynamics.switching.lowest[function];
        let resolution = step.resolution();
        let rounding = ROUNDING * switching::zero_value(made.dynamics, function);
        let sinks = left.value <= rounding || (theta - left.at) * step.h <= resolution;
        if right.at < 1.0 && (sinks || -right.value < SHALLOW * range) {
            let value = self.stepped(made, function, right.at * step.h);
            if value >= -zero {
                return Err(value);
            }
        }
        if sinks {
            return self.sink(made, crossing);
        }
        let memory = &mut self.memory;
        let mut value = |theta| memory.interpolated(made, function, theta);
        let around = 1e-3 * (right.at - left.at);
        let (before, after) = ((theta - around).max(0.0), (theta + around).min(1.0));
        let slope = (value(after) - value(before)) / ((after - before) * step.h);
        // A function that starts at zero has any sign there: the way back ends where it is positive.
        if from.value <= rounding && left.at > from.at {
            let value = self.stepped(made, function, left.at * step.h);
            if value > rounding {
                from = left;
            }
        }
        let bracket = Bracket {
            low: from.at * step.h,
            high: right.at * step.h,
            guess: theta * step.h,
            slope,
        };
        self.refine(made, function, bracket)
    }

    /// Locates a fall where the continuous extension is positive nowhere before it; the true solution may be, for a
    /// while. A flight too low to be seen in the gap ends where it begins to fall.
    fn sink(&mut self, made: &mut Made<'_, '_>, crossing: Fall) -> Result<f64, f64> {
        let step = made.step;
        let Fall {
            function,
            mut left,
            mut right,
            ..
        } = crossing;
        let rounding = ROUNDING * switching::zero_value(made.dynamics, function);
        let mut width = right.at - left.at;
        let (mut rises, mut falls) = (None, right.at);
        let positive = (0..HALVINGS).find_map(|_| {
            width *= 0.5;
            let at = left.at + width;
            let value = self.stepped(made, function, at * step.h);
            if value <= 0.0 {
                right = Sample { at, value };
            }
            if let Switch::Gap(contact) = made.dynamics.switch(function)
                && rises.is_none()
            {
                let t = step.t + at * step.h;
                let velocity = self.normal_velocity(made, t, contact);
                if velocity > ROUNDING * made.dynamics.zero_normal_velocity(contact) {
                    rises = Some((contact, at));
                } else {
                    falls = at;
                }
            }
            (value > rounding).then_some(Sample { at, value })
        });
        match (positive, rises) {
            (Some(sample), _) => left = sample,
            (None, Some((contact, at))) => {
                let flight = (at * step.h, falls * step.h);
                return Ok(self.end_of_rise(made, contact, flight));
            }
            (None, None) => right = left,
        }
        let bracket = Bracket {
            low: left.at * step.h,
            high: right.at * step.h,
            guess: left.at * step.h,
            slope: (right.value - left.value) / ((right.at - left.at) * step.h),
        };
        self.refine(made, function, bracket)
    }

    /// Length of the true step at whose end a contact that rises at the first end of the bracket and falls at the
    /// second one begins to fall, by bisection.
    fn end_of_rise(
        &mut self,
        made: &mut Made<'_, '_>,
        contact: usize,
        (mut rises, mut falls): (f64, f64),
    ) -> f64 {
        let step = made.step;
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (rises + falls);
            if falls - rises <= step.resolution() {
                break;
            }
            self.stepped(made, contact, middle);
            if self.normal_velocity(made, step.t + middle, contact) > 0.0 {
                rises = middle;
            } else {
                falls = middle;
            }
        }
        self.root_value = self.stepped(made, contact, falls);
        falls
    }

    /// Length of the true step in the bracket at whose end the function vanishes, to the resolution of time; if it
    /// is positive throughout, its value at the right end.
    fn refine(
        &mut self,
        made: &mut Made<'_, '_>,
        function: usize,
        bracket: Bracket,
    ) -> Result<f64, f64> {
        let step = made.step;
        let zero = self.least_zero(made.dynamics, step, function);
        let stepped = |h| Ok(self.stepped(made, function, h));
        let Ok((h, f)) = refine::<Infallible>(stepped, bracket, (zero, step.resolution()));
        self.root_value = f;
        if f <= zero { Ok(h) } else { Err(f) }
    }
}

/// What the bounds of a switching function are those of.
fn watched(dynamics: &Dynamics<'_>, function: usize) -> Watched {
    match dynamics.switch(function) {
        Switch::Gap(i) => Watched::Gap(i),
        Switch::SlidingVelocity(i, direction) if !dynamics.is_in_space(i) => {
            Watched::Sliding(i, Form::Signed(direction.sign()))
        }
        Switch::HeldVelocity(i) => {
            Watched::Sliding(i, Form::Below(switching::held_velocity(dynamics, i)))
        }
        _ => Watched::Solved,
    }
}

/// What a switching function is called that is not enclosed.
fn named(switch: Switch) -> Option<Interpolated> {
    match switch {
        Switch::Gap(i) => Some(Interpolated::Gap(i)),
        Switch::NormalForce(i) => Some(Interpolated::Force(i)),
        Switch::FrictionLimit(i, _) => Some(Interpolated::Friction(i)),
        Switch::SlidingVelocity(i, _) | Switch::HeldVelocity(i) => Some(Interpolated::Sliding(i)),
        Switch::Constant(_) => None,
    }
}

impl Memory {
    /// Value of a switching function on the continuous extension.
    fn interpolated(&mut self, made: &mut Made<'_, '_>, function: usize, theta: f64) -> f64 {
        let step = made.step;
        let t = step.t + theta * step.h;
        made.method
            .interpolate(theta, &mut self.state[..2 * made.dynamics.n]);
        let is_force = made.dynamics.switch(function).is_force();
        if let Some(known) = self.places.iter().find(|known| known.theta == theta)
            && is_force
        {
            made.dynamics.load(t, &self.state);
            made.dynamics
                .switching
                .force_scale
                .copy_from_slice(&known.scales);
            return known.values[function];
        }
        let value =
            switching::switching_value(made.dynamics, function, t, &self.state, &mut self.slope);
        if is_force && self.places.len() < PLACES_REMEMBERED {
            self.places.push(Place {
                theta,
                values: made.dynamics.switching.values.clone(),
                scales: made.dynamics.switching.force_scale.clone(),
            });
        }
        value
    }
}

fn may_cross(dynamics: &Dynamics<'_>, function: usize) -> bool {
    let (lowest, highest) = (
        dynamics.switching.lowest[function],
        dynamics.switching.highest[function],
    );
    lowest <= highest - lowest
}
