//! The starting point of the solver, from the task alone.

use super::laid_out::{Placed, laid_out};
use super::{Guess, SUMS, Transcription};

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

pub(super) fn set_guess(transcription: &mut Transcription<'_>) {
    let mut guess = vec![0.0; transcription.variables];
    if let Some(horizon) = transcription.horizon {
        guess[horizon] = transcription.task.horizon;
    }
    let known = matches!(transcription.task.guess, Guess::Known(_));
    let intervals = elements(transcription);
    for (k, (interval, (length, _))) in transcription.intervals.iter().zip(&intervals).enumerate() {
        guess[interval.length] = *length;
        let units = &transcription.control_units;
        for (node, variables) in [&interval.controls, &interval.ends].into_iter().enumerate() {
            let values = transcription.task.controls.values(k + node);
            for ((&control, value), unit) in variables.iter().zip(values).zip(units) {
                guess[control] = value / unit;
            }
        }
    }
    if let Some(beginning) = &transcription.beginning {
        let variables = beginning.block.variables.clone();
        let y = transcription.start.clone();
        set_local(transcription, 0, &y, &vec![1.0; transcription.groups.len()]);
        for (variable, value) in variables.iter().zip(&transcription.local) {
            if let Some(variable) = variable {
                guess[*variable] = *value;
            }
        }
    }
    let count = transcription.task.elements;
    let states = transcription.dcs.layout.states();
    let placed = intervals.iter().flat_map(|(_, elements)| elements);
    for (e, Placed { width, points }) in placed.enumerate() {
        guess[transcription.elements[e].length] = *width;
        if known {
            transcription.elements[e].even = *width;
        }
        for (b, point) in points.iter().enumerate() {
            set_local(transcription, e / count, &point[..states], &point[states..]);
            for k in 0..transcription.local.len() {
                if let Some(variable) = transcription.elements[e].blocks[b].variables[k] {
                    guess[variable] = transcription.local[k] / transcription.unit(k);
                }
            }
        }
    }
    for e in 0..transcription.elements.len() {
        for group in 0..transcription.groups.len() {
            for sum in 0..SUMS {
                let place = transcription.elements[e].sums + SUMS * group + sum;
                guess[place] = transcription.sum(&guess, e, group, sum);
            }
        }
    }
    transcription.guess = guess;
}

/// Local vector in interval `k` for states and shares of the groups. Lifted gaps are those of the coordinates, where
/// they do not move alone.
fn set_local(transcription: &mut Transcription<'_>, k: usize, y: &[f64], shares: &[f64]) {
    let states = transcription.dcs.layout.states();
    transcription.local.fill(0.0);
    transcription.local[..states].copy_from_slice(y);
    let task = &transcription.task;
    let elapsed = y[transcription.dcs.layout.time()] - task.start.time;
    let share = task.intervals as f64 * elapsed / task.horizon - k as f64;
    let controls = task.controls.at(k, share.clamp(0.0, 1.0));
    transcription.local[states..states + controls.len()].copy_from_slice(&controls);
    transcription
        .dcs
        .rows(&transcription.local, &mut transcription.rows);
    for contact in 0..transcription.dcs.layout.contacts() {
        if !transcription.dcs.layout.moves_in_jumps(contact) {
            let place = transcription.dcs.layout.lifted_gap(contact);
            transcription.local[place] = transcription.dcs.system.gap(contact);
        }
    }
    transcription.dcs.complete(&mut transcription.local, shares);
    transcription
        .dcs
        .rows(&transcription.local, &mut transcription.rows);
}

/// Length in numerical time and elements of each interval.
fn elements(transcription: &mut Transcription<'_>) -> Vec<(f64, Vec<Placed>)> {
    let count = transcription.task.elements;
    let states = transcription.dcs.layout.states();
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

/// The part of a motion in interval `k`.
fn sample(transcription: &mut Transcription<'_>, k: usize, motion: &[Vec<f64>]) -> Sampled {
    let count = transcription.task.intervals;
    let duration = transcription.task.horizon / count as f64;
    let steps = ((motion.len() - 1) / count).max(1);
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
    let count = transcription.task.intervals;
    let duration = transcription.task.horizon / count as f64;
    let mut y = transcription.start.clone();
    let intervals = (0..count).map(|k| simulate(transcription, k, &mut y, duration));
    intervals.collect()
}

/// The point `(q, v)` at a time since the start, with gaps of its own and every step function undecided.
fn undecided(transcription: &mut Transcription<'_>, state: &[f64], elapsed: f64) -> Vec<f64> {
    let states = transcription.dcs.layout.states();
    let mut point = state.to_vec();
    point.push(transcription.task.start.time + elapsed);
    let mut local = point.clone();
    local.resize(transcription.local.len(), 0.0);
    transcription.dcs.rows(&local, &mut transcription.rows);
    let system = &transcription.dcs.system;
    let contacts = 0..transcription.dcs.layout.contacts();
    point.extend(contacts.map(|contact| system.gap(contact)));
    point.resize(states, 0.0);
    point.resize(states + transcription.groups.len(), 0.5);
    point
}

/// Explicit Euler steps of the time-freezing system in interval `k` from `y` until `duration` has passed on its clock.
fn simulate(
    transcription: &mut Transcription<'_>,
    k: usize,
    y: &mut [f64],
    duration: f64,
) -> Sampled {
    let time = transcription.dcs.layout.time();
    let end = y[time] + duration;
    let step = duration / STEPS as f64;
    let most = (transcription.speed_bound * STEPS as f64) as usize;
    let mut points = Vec::new();
    loop {
        let open = vec![1.0; transcription.groups.len()];
        set_local(transcription, k, y, &open);
        y.copy_from_slice(&transcription.local[..y.len()]);
        let shares = transcription.dcs.shares(&transcription.local);
        let mut point = y.to_vec();
        point.extend(&shares);
        points.push(point);
        if points.len() > most || points.len() > 1 && y[time] >= end - 0.5 * step {
            let length = step * (points.len() - 1) as f64;
            return Sampled { length, points };
        }
        set_local(transcription, k, y, &shares);
        for (value, rate) in y.iter_mut().zip(&transcription.rows) {
            *value += step * rate;
        }
    }
}
