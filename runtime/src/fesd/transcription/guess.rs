//! The starting point of the solver, from the task alone.

use super::{Guess, SUMS, Transcription};

/// Explicit Euler steps of a simulated guess in an interval without contact.
const STEPS: usize = 200;

/// Steps without a change of a step function that count as flight or jump; in contact it chatters.
const STEADY: usize = 5;

/// A motion in numerical time on equal steps of one interval.
struct Sampled {
    /// Numerical length of the interval.
    length: f64,
    /// `(q, v, t, G)` and then the shares of the groups during the following step, at each instant.
    points: Vec<Vec<f64>>,
}

impl Sampled {
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

impl Transcription<'_> {
    pub(super) fn set_guess(&mut self) {
        let mut guess = vec![0.0; self.variables];
        if let Some(horizon) = self.horizon {
            guess[horizon] = self.task.horizon;
        }
        let intervals = self.sample();
        for (interval, sampled) in self.intervals.iter().zip(&intervals) {
            guess[interval.length] = sampled.length;
            for (k, &control) in interval.controls.iter().enumerate() {
                guess[control] = self.task.controls.values()[k] / self.control_units[k];
            }
        }
        let count = self.task.elements;
        let states = self.dcs.layout.states();
        let ends: Vec<Vec<f64>> = intervals
            .iter()
            .map(|sampled| sampled.ends(count, states))
            .collect();
        for e in 0..self.elements.len() {
            let ends = &ends[e / count];
            let start = (e % count)
                .checked_sub(1)
                .map_or(0.0, |before| ends[before]);
            let width = ends[e % count] - start;
            guess[self.elements[e].length] = width;
            for b in 0..self.elements[e].blocks.len() {
                let c = self.tableau.c().get(b).copied().unwrap_or(1.0);
                let share = start + c * width;
                let window = width / self.tableau.stages() as f64;
                let point = intervals[e / count].at(share, window, states);
                self.set_local(&point[..states], &point[states..]);
                for k in 0..self.local.len() {
                    if let Some(variable) = self.elements[e].blocks[b].variables[k] {
                        guess[variable] = self.local[k] / self.unit(k);
                    }
                }
            }
        }
        for e in 0..self.elements.len() {
            for group in 0..self.groups.len() {
                for sum in 0..SUMS {
                    let place = self.elements[e].sums + SUMS * group + sum;
                    guess[place] = self.sum(&guess, e, group, sum);
                }
            }
        }
        self.guess = guess;
    }

    /// Local vector for states and shares of the groups. Lifted gaps are those of the coordinates, where
    /// they do not move alone.
    fn set_local(&mut self, y: &[f64], shares: &[f64]) {
        let states = self.dcs.layout.states();
        self.local.fill(0.0);
        self.local[..states].copy_from_slice(y);
        for (k, &control) in self.task.controls.values().iter().enumerate() {
            self.local[states + k] = control;
        }
        self.dcs.rows(&self.local, &mut self.rows);
        for contact in 0..self.dcs.layout.contacts() {
            if !self.dcs.layout.bounces(contact) {
                let place = self.dcs.layout.lifted_gap(contact);
                self.local[place] = self.dcs.system.gap(contact);
            }
        }
        self.dcs.complete(&mut self.local, shares);
        self.dcs.rows(&self.local, &mut self.rows);
    }

    /// The guessed motion of each interval.
    fn sample(&mut self) -> Vec<Sampled> {
        let (groups, contacts) = (self.groups.len(), self.dcs.layout.contacts());
        let states = self.dcs.layout.states();
        let duration = self.task.horizon / self.task.intervals as f64;
        let mut y = self.start.clone();
        (0..self.task.intervals)
            .map(|k| match self.task.guess.clone() {
                Guess::Line(velocity) => {
                    let n = velocity.len();
                    let end = |share: f64| {
                        let elapsed = (k as f64 + share) * duration;
                        let mut point = self.start[..n].to_vec();
                        for (q, v) in point.iter_mut().zip(&velocity) {
                            *q += elapsed * v;
                        }
                        point.extend(&velocity);
                        point.push(self.start[2 * n] + elapsed);
                        // a gap that moves in jumps alone stays where it is
                        point.extend(&self.start[states - contacts..]);
                        point.resize(states + groups, 0.5);
                        point
                    };
                    Sampled {
                        length: duration,
                        points: vec![end(0.0), end(1.0)],
                    }
                }
                Guess::Simulated => self.simulate(&mut y, duration),
            })
            .collect()
    }

    /// Explicit Euler steps of the time-freezing system from `y` until `duration` has passed on its clock.
    fn simulate(&mut self, y: &mut [f64], duration: f64) -> Sampled {
        let time = self.dcs.layout.time();
        let end = y[time] + duration;
        let step = duration / STEPS as f64;
        let most = (self.speed_bound * STEPS as f64) as usize;
        let mut points = Vec::new();
        loop {
            let open = vec![1.0; self.groups.len()];
            self.set_local(y, &open);
            y.copy_from_slice(&self.local[..y.len()]);
            let shares = self.dcs.shares(&self.local);
            let mut point = y.to_vec();
            point.extend(&shares);
            points.push(point);
            if points.len() > most || points.len() > 1 && y[time] >= end - 0.5 * step {
                let length = step * (points.len() - 1) as f64;
                return Sampled { length, points };
            }
            self.set_local(y, &shares);
            for (value, rate) in y.iter_mut().zip(&self.rows) {
                *value += step * rate;
            }
        }
    }
}
