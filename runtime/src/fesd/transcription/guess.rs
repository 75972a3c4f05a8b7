//! The starting point of the solver, from the task alone.

use super::{SUMS, Transcription};
use crate::dcs::{ALPHA, PER_CONTACT};

impl Transcription<'_> {
    /// Motion at the guessed velocity, with every step function undecided.
    pub(super) fn set_guess(&mut self) {
        let n = self.dcs.system.coordinates();
        let states = self.dcs.states();
        let mut guess = vec![0.0; self.variables];
        if let Some(horizon) = self.horizon {
            guess[horizon] = self.task.horizon;
        }
        let duration = self.task.horizon / self.task.intervals as f64;
        for interval in &self.intervals {
            guess[interval.length] = duration;
            for (k, &control) in interval.controls.iter().enumerate() {
                guess[control] = self.task.controls.values()[k] / self.control_units[k];
            }
        }
        let share = 1.0 / self.task.elements as f64;
        for e in 0..self.elements.len() {
            guess[self.elements[e].length] = share;
            for b in 0..self.elements[e].blocks.len() {
                let c = self.tableau.c().get(b).copied().unwrap_or(1.0);
                let elapsed = (e as f64 + c) * share * duration;
                self.local.fill(0.0);
                for k in 0..n {
                    let velocity = self.task.guess_velocity[k];
                    self.local[k] = self.start[k] + elapsed * velocity;
                    self.local[n + k] = velocity;
                }
                let time = self.dcs.time();
                self.local[time] = self.start[time] + elapsed;
                for (k, &control) in self.task.controls.values().iter().enumerate() {
                    self.local[states + k] = control;
                }
                self.dcs.rows(&self.local, &mut self.rows);
                for contact in 0..self.dcs.contacts() {
                    let (gap, velocity) = (
                        self.dcs.system.gap(contact),
                        self.dcs.system.normal_velocity(contact),
                    );
                    let margin = gap.max(velocity);
                    let z = [
                        0.5,
                        0.5,
                        margin.max(0.0),
                        (-margin).max(0.0),
                        (velocity - gap).max(0.0),
                        (gap - velocity).max(0.0),
                    ];
                    let first = self.dcs.algebraic(contact, ALPHA);
                    self.local[first..first + PER_CONTACT].copy_from_slice(&z);
                    let place = self.dcs.lifted_gap(contact);
                    self.local[place] = gap;
                }
                for k in 0..self.local.len() {
                    if let Some(variable) = self.elements[e].blocks[b].variables[k] {
                        guess[variable] = self.local[k] / self.unit(k);
                    }
                }
            }
        }
        for e in 0..self.elements.len() {
            for contact in 0..self.dcs.contacts() {
                for sum in 0..SUMS {
                    let place = self.elements[e].sums + SUMS * contact + sum;
                    guess[place] = self.sum(&guess, e, contact, sum);
                }
            }
        }
        self.guess = guess;
    }
}
