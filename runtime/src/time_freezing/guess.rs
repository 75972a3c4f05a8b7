//! The starting point of the solver, from the task alone.

use super::conditions;
use super::laid_out::{Placed, laid_out};
use super::task::Guess;
use super::transcription::{SUMS, Transcription};
use crate::model::held::complete_largest;

/// Explicit Euler steps of a simulated guess in an interval without contact.
const STEPS: usize = 200;

/// Steps without a change of a step function that count as flight or jump; in contact it chatters.
const STEADY: usize = 5;

/// A motion in numerical time on equal steps of one interval.
struct Sampled {
    /// Numerical length of the interval.
    length: f64,
    /// `(q, v, t, G, D)` and then the shares of the groups during the following step, at each instant.
    points: Vec<Vec<f64>>,
}

impl Sampled {
    /// The elements of the interval, `count` of them with blocks at `places`, of which `stages` are those of the scheme.
    fn elements(
        &self,
        count: usize,
        (places, stages): (&[f64], usize),
        states: usize,
    ) -> Vec<Placed> {
        let mut start = 0.0;
        let ends = self.ends(count, states).into_iter();
        ends.map(|end| {
            let (from, width) = (start, end - start);
            start = end;
            let window = width / stages as f64;
            let at = |place: &f64| self.at(from + place * width, window, states);
            Placed {
                width,
                points: places.iter().map(at).collect(),
            }
        })
        .collect()
    }

    /// Ends of `count` elements as fractions of the interval: at the changes of mode, the longest phases
    /// divided evenly.
    fn ends(&self, count: usize, states: usize) -> Vec<f64> {
        let steps = self.points.len() - 1;
        let mut modes = vec![Vec::new(); steps];
        for k in states..self.points[0].len() {
            let mut from = 0;
            while from < steps {
                let value = self.points[from][k];
                let same = |i: &usize| self.points[*i][k] == value;
                let to = from + (from..steps).take_while(same).count();
                let mode = if to - from < STEADY { 0.5 } else { value };
                modes[from..to].iter_mut().for_each(|step| step.push(mode));
                from = to;
            }
        }
        // lengths of the phases
        let mut phases: Vec<usize> = modes
            .chunk_by(|a, b| a == b)
            .map(<[Vec<f64>]>::len)
            .collect();
        while phases.len() > count {
            let shortest = (0..phases.len()).min_by_key(|&i| phases[i]).unwrap_or(0);
            let length = phases.remove(shortest);
            phases[shortest.saturating_sub(1)] += length;
        }
        let mut parts = vec![1; phases.len()];
        for _ in phases.len()..count {
            let longest = (0..phases.len()).max_by_key(|&i| phases[i] / parts[i]);
            parts[longest.unwrap_or(0)] += 1;
        }
        let mut ends = Vec::with_capacity(count);
        let mut start = 0.0;
        for (&length, &parts) in phases.iter().zip(&parts) {
            let length = length as f64 / steps as f64;
            ends.extend((1..=parts).map(|part| start + length * part as f64 / parts as f64));
            start += length;
        }
        ends
    }

    /// Linear interpolation at the fraction `share` of the interval; step functions are averaged over
    /// `window` of it.
    fn at(&self, share: f64, window: f64, states: usize) -> Vec<f64> {
        let steps = (self.points.len() - 1) as f64;
        let place = (share * steps).clamp(0.0, steps);
        let first = (place as usize).min(self.points.len() - 2);
        let fraction = place - first as f64;
        let mut point: Vec<f64> = self.points[first][..states]
            .iter()
            .zip(&self.points[first + 1])
            .map(|(a, b)| a + fraction * (b - a))
            .collect();
        let from = (((share - 0.5 * window) * steps).max(0.0) as usize).min(self.points.len() - 2);
        let to = (((share + 0.5 * window) * steps) as usize).clamp(from + 1, self.points.len() - 1);
        for k in states..self.points[first].len() {
            let sum: f64 = self.points[from..to].iter().map(|point| point[k]).sum();
            point.push(sum / (to - from) as f64);
        }
        point
    }
}

/// Gives all variables values that go with each other.
pub(super) fn set_guess(transcription: &mut Transcription<'_>) {
    let known = matches!(transcription.task.guess, Guess::Known(_));
    let intervals = elements(transcription);
    for (k, (length, _)) in intervals.iter().enumerate() {
        let interval = transcription.intervals[k].length;
        transcription.program.set_guess(interval, *length);
    }
    let count = transcription.task.elements;
    let states = transcription.field.layout.states();
    let placed = intervals.iter().flat_map(|(_, elements)| elements);
    for (e, Placed { width, points }) in placed.enumerate() {
        if known {
            transcription.set_even(e, *width);
        }
        let length = transcription.elements[e].length;
        transcription.program.set_guess(length, *width);
        for (b, point) in points.iter().enumerate() {
            let (y, shares) = point.split_at(states);
            let mut local = local(transcription, e / count, y, shares);
            set_largest(transcription, &mut local);
            let variables = transcription.elements[e].blocks[b].variables.iter();
            let values = variables.zip(local).enumerate();
            for (place, (variable, value)) in values {
                // What blocks share has its guess already.
                let own = variable.filter(|i| !is_shared(transcription, place, *i));
                if let Some(variable) = own {
                    transcription.program.set_guess(variable, value);
                }
            }
        }
    }
    let mut guess = transcription.guess();
    for e in 0..transcription.elements.len() {
        for group in 0..transcription.groups.len() {
            for sum in 0..SUMS {
                let variable = transcription.elements[e].sums + SUMS * group + sum;
                guess[variable] = transcription.sum(&guess, e, group, sum);
                transcription.program.set_guess(variable, guess[variable]);
            }
        }
        conditions::set_guess(transcription, e, &guess);
    }
}

/// Whether a variable at a place of a block belongs to the whole interval, or to the whole motion.
fn is_shared(transcription: &Transcription<'_>, place: usize, variable: usize) -> bool {
    let outer = &transcription.outer;
    let states = transcription.field.layout.states();
    match place.checked_sub(states) {
        Some(_) => outer.controls.iter().flatten().any(|&own| own == variable),
        None => outer.start.contains(&variable),
    }
}

/// Gives controls that are largest values of an instant what they are in a local vector.
fn set_largest(transcription: &Transcription<'_>, local: &mut [f64]) {
    let model = transcription.field.model;
    if model.held().is_none_or(|held| held.at_stages.is_empty()) {
        return;
    }
    let layout = &transcription.field.layout;
    let mut x = transcription.field.input(local);
    x.resize(model.declaration().path_inputs(), 0.0);
    complete_largest(model, &mut x);
    let first = 2 * transcription.field.coordinates();
    let controls = &x[first..first + layout.controls];
    local[layout.states()..layout.first_algebraic()].copy_from_slice(controls);
}

/// Controls at the start, or those of interval `k` at a share of it.
fn controls(transcription: &Transcription<'_>, k: usize, elapsed: f64) -> Vec<f64> {
    let (task, outer) = (&transcription.task, &transcription.outer);
    let values = |k: usize| -> Vec<f64> {
        let node = outer.controls[k].iter();
        node.map(|&i| transcription.program.guessed(i)).collect()
    };
    let mut controls = values(k);
    if task.linear {
        let horizon = transcription.program.guessed(outer.horizon);
        let share = task.intervals as f64 * elapsed / horizon - k as f64;
        for (control, after) in controls.iter_mut().zip(values(k + 1)) {
            *control += share.clamp(0.0, 1.0) * (after - *control);
        }
    }
    controls
}

/// Local vector in interval `k` for states and shares of the groups. Lifted gaps are those of the coordinates, where
/// they do not move alone.
fn local(transcription: &mut Transcription<'_>, k: usize, y: &[f64], shares: &[f64]) -> Vec<f64> {
    let layout = transcription.field.layout.clone();
    let elapsed = y[layout.time()] - transcription.task.time;
    let mut local = y.to_vec();
    local.extend(controls(transcription, k, elapsed));
    local.resize(layout.local_variables(), 0.0);
    let field = &mut transcription.field;
    field.locate(&local);
    for contact in 0..layout.contacts {
        if !layout.moves_in_jumps(contact) {
            local[layout.lifted_gap(contact)] = field.gap(contact);
        }
    }
    field.complete(&mut local, shares);
    local
}

/// Length in numerical time and elements of each interval.
fn elements(transcription: &mut Transcription<'_>) -> Vec<(f64, Vec<Placed>)> {
    let count = transcription.task.elements;
    let states = transcription.field.layout.states();
    let stages = transcription.tableau.stages();
    let mut places = transcription.tableau.c().to_vec();
    if !transcription.tableau.stiffly_accurate() {
        places.push(1.0);
    }
    let intervals: Vec<Sampled> = match transcription.task.guess.clone() {
        Guess::Known(intervals) => {
            let laid = intervals
                .iter()
                .map(|spans| laid_out(spans, count, &places));
            return laid.collect();
        }
        Guess::Motion(motion) => (0..transcription.task.intervals)
            .map(|k| sample(transcription, k, &motion))
            .collect(),
        Guess::Simulated => simulate_all(transcription),
    };
    let placed = |sampled: &Sampled| sampled.elements(count, (&places, stages), states);
    intervals
        .iter()
        .map(|sampled| (sampled.length, placed(sampled)))
        .collect()
}

/// Guess of the physical length of an interval \[s\].
fn duration(transcription: &Transcription<'_>) -> f64 {
    let horizon = transcription.program.guessed(transcription.outer.horizon);
    horizon / transcription.task.intervals as f64
}

/// The part of a motion in interval `k`.
fn sample(transcription: &mut Transcription<'_>, k: usize, motion: &[Vec<f64>]) -> Sampled {
    let duration = duration(transcription);
    let steps = ((motion.len() - 1) / transcription.task.intervals).max(1);
    let points = (k * steps..=(k + 1) * steps).map(|i| {
        let elapsed = duration * i as f64 / steps as f64;
        undecided(transcription, &motion[i.min(motion.len() - 1)], elapsed)
    });
    Sampled {
        length: duration,
        points: points.collect(),
    }
}

/// The simulated motion of all intervals.
fn simulate_all(transcription: &mut Transcription<'_>) -> Vec<Sampled> {
    let start = &transcription.beginning.variables[..transcription.field.layout.states()];
    let start = start.iter().flatten();
    let mut y: Vec<f64> = start.map(|&i| transcription.program.guessed(i)).collect();
    let intervals = 0..transcription.task.intervals;
    let intervals = intervals.map(|k| simulate(transcription, k, &mut y));
    intervals.collect()
}

/// The point `(q, v)` at a time since the start, with gaps of its own and every step function undecided.
fn undecided(transcription: &mut Transcription<'_>, state: &[f64], elapsed: f64) -> Vec<f64> {
    let layout = transcription.field.layout.clone();
    let mut point = state.to_vec();
    point.push(transcription.task.time + elapsed);
    let mut local = point.clone();
    local.resize(layout.local_variables(), 0.0);
    let field = &mut transcription.field;
    field.locate(&local);
    point.extend((0..layout.contacts).map(|contact| field.gap(contact)));
    point.resize(layout.states(), 0.0);
    point.resize(layout.states() + transcription.groups.len(), 0.5);
    point
}

/// Explicit Euler steps of the time-freezing system in interval `k` from `y` until the interval has passed on its clock.
fn simulate(transcription: &mut Transcription<'_>, k: usize, y: &mut [f64]) -> Sampled {
    let duration = duration(transcription);
    let time = transcription.field.layout.time();
    let end = y[time] + duration;
    let step = duration / STEPS as f64;
    let most = (transcription.speed_bound * STEPS as f64) as usize;
    let mut points: Vec<Vec<f64>> = Vec::new();
    loop {
        let open = vec![1.0; transcription.groups.len()];
        let mut at = local(transcription, k, y, &open);
        y.copy_from_slice(&at[..y.len()]);
        let shares = transcription.field.shares(&at);
        if let Some(before) = points.last() {
            transcription.field.set(&at, &before[y.len()..], &shares, y);
            at[..y.len()].copy_from_slice(y);
        }
        let mut point = y.to_vec();
        point.extend(&shares);
        points.push(point);
        if points.len() > most || points.len() > 1 && y[time] >= end - 0.5 * step {
            let length = step * (points.len() - 1) as f64;
            return Sampled { length, points };
        }
        transcription.field.complete(&mut at, &shares);
        let rates = transcription.field.rates(&at);
        for (value, rate) in y.iter_mut().zip(&rates) {
            *value += step * rate;
        }
    }
}
