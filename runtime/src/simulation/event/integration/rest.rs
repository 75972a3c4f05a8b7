//! Rest where the functions of switches vanish together: how long it lasts, and motions that come to it by ever more switches in ever less
//! time.

use super::Integration;
use crate::contact::passing::{self, Place};
use crate::contact::{ContactState, Rest};
use crate::simulation::SimulationStatus;
use crate::simulation::event::sides;

/// Share of the horizon within which switches that lead to a rest follow each other.
const BURST: f64 = 1e-6;

impl Integration<'_> {
    /// Rests until `limit`, where the controls may jump, or until what acts is balanced no more, if the motion does.
    pub(super) fn rest(&mut self, limit: f64) -> Result<bool, SimulationStatus> {
        let Some(rest) = self.dynamics.rest.clone() else {
            return Ok(false);
        };
        let longest = limit - self.t;
        let rates = sides::rates(&mut self.dynamics, (self.t, &self.y));
        let x = self.dynamics.input().to_vec();
        let zeros: Vec<f64> = (0..self.dynamics.contacts)
            .map(|i| self.dynamics.zero_speed(i))
            .collect();
        let place = Place {
            x: &x,
            rates: &rates,
            touching: &rest.contacts,
            zeros: &zeros,
            moment: longest,
        };
        let lasts = passing::lasts(&mut self.dynamics, &place, longest);
        let over = lasts < longest;
        if !over && let Some(parts) = passing::parts_after(&mut self.dynamics, &place, lasts) {
            self.dynamics.rest = Some(Rest { parts, ..rest });
        }
        let n = self.dynamics.n;
        self.y[2 * n] += lasts;
        self.t = if over { self.t + lasts } else { limit };
        self.result.counts.elements += 1;
        if over {
            self.enter_mode(None, false)?;
        } else {
            self.begin()?;
            self.record();
            if limit < self.problem.horizon {
                self.dynamics.set_controls(&self.problem.controls, self.t);
                self.enter_mode(None, false)?;
            }
        }
        Ok(true)
    }

    /// Whether the switches of the last moment have led to a rest, into which the motion is put.
    pub(super) fn comes_to_rest(&mut self) -> bool {
        let moment = BURST * self.problem.horizon;
        let declared = self.dynamics.model.declaration().contacts;
        let events = self.result.events.iter().rev();
        let recent = events.take_while(|event| self.t - event.time <= moment);
        let mut switches: Vec<usize> = recent
            .filter(|event| declared[event.contact].switch.is_some())
            .map(|event| event.contact)
            .collect();
        switches.sort_unstable();
        switches.dedup();
        if switches.is_empty() {
            return false;
        }
        self.dynamics.load(self.t, &self.y);
        let (n, model) = (self.dynamics.n, self.dynamics.model);
        let slope = &self.method.slope()[n..2 * n];
        let largest = slope.iter().fold(0.0_f64, |size, a| size.max(a.abs()));
        let mut x = self.dynamics.input().to_vec();
        let view = &mut self.dynamics;
        if !passing::move_to_zero(model, view, &mut x, &switches, (moment, largest)) {
            return false;
        }
        let before = self.y.clone();
        // Where no mode was found all are open, but a switch always acts.
        let mut mode = self.dynamics.mode().to_vec();
        for &i in &switches {
            if mode[i].is_open() {
                mode[i] = ContactState::slip(1.0);
            }
        }
        self.dynamics.set_mode(&mode);
        self.y[..2 * n].copy_from_slice(&x[..2 * n]);
        let rests = self.enter_mode(None, false).is_ok() && self.dynamics.rest.is_some();
        if !rests {
            self.dynamics.rest = None;
            self.y = before;
        }
        rests
    }
}
