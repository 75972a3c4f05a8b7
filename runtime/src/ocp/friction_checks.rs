//! Friction between the stages: forces stay in their cones, slipping contacts do not slip back.

use super::collocation::{Cut, CutKind, Phase};
use super::cuts::{Limits, Motion, lows};
use super::friction::reserve_between;
use super::kernel::Kernel;
use super::mode::{Direction, Mode};
use super::transcribe::Builder;
use crate::model::tangent_point;

impl Motion<'_, '_> {
    /// Places between the stages where a sticking contact's force leaves the friction cone, or a slipping contact slips
    /// back. What the solver leaves of an active row is let pass; where sliding sets in without an acceleration, what
    /// is let pass of a gap.
    pub(super) fn friction(&self, limits: Limits) -> Vec<Cut> {
        let mut found = Vec::new();
        for (index, phase) in self.program.phases.iter().enumerate() {
            let cut = |theta: f64, kind: CutKind| Cut {
                interval: phase.interval,
                phase: phase.index,
                theta,
                kind,
            };
            for (contact, mode) in phase.modes.iter().enumerate() {
                match *mode {
                    Mode::Stick => {
                        for direction in Direction::BOTH {
                            let tolerance = limits.bound * self.largest_force(phase, contact);
                            let range = (-tolerance, tolerance);
                            let mut reserve = |_: usize, theta: f64| {
                                self.reserve(phase, (contact, direction), theta)
                            };
                            let lows = lows(&[index], &mut reserve, range);
                            let kind = CutKind::Cone(contact, direction);
                            found.extend(lows.iter().map(|low| cut(low.1, kind)));
                        }
                    }
                    Mode::Slip(direction) => {
                        let yielded = phase.yielded.contains(&contact);
                        let tolerance = if yielded { limits.gap } else { limits.bound };
                        let tolerance = tolerance * limits.units.gap_rows[contact];
                        let mut velocity = self.sliding(contact, direction);
                        let lows = lows(&[index], &mut velocity, (-tolerance, tolerance));
                        found.extend(lows.iter().map(|low| cut(low.1, CutKind::Slip(contact))));
                        let last = index + 1 == self.program.phases.len();
                        if last && velocity(index, 1.0) < -tolerance {
                            found.push(cut(1.0, CutKind::Slip(contact)));
                        }
                    }
                    Mode::Open | Mode::Frictionless => {}
                }
            }
        }
        found
    }

    /// Sliding velocity of a contact in the direction in which it slips.
    fn sliding(&self, contact: usize, direction: Direction) -> impl FnMut(usize, f64) -> f64 + '_ {
        let model = self.program.model;
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let mut input = vec![0.0; declaration.inputs()];
        let mut point = vec![0.0; tangent_point::length(n)];
        move |phase, theta| {
            self.write(phase, theta, &mut input);
            model.tangent(contact, &input, &mut point);
            direction.sign() * point[tangent_point::SLIDING_VELOCITY]
        }
    }

    /// `mu r + sigma s` of a sticking contact inside a phase.
    fn reserve(&self, phase: &Phase, (contact, direction): (usize, Direction), theta: f64) -> f64 {
        let mut weights = vec![0.0; phase.stages.len()];
        self.program.tableau.lagrange_values(theta, &mut weights);
        let mu = self.program.model.friction(contact);
        let stages = phase.stages.iter().zip(weights);
        stages
            .flat_map(|(stage, weight)| stage.tangential.iter().map(move |t| (t, weight)))
            .filter(|(tangential, _)| tangential.contact == contact)
            .filter_map(|(tangential, weight)| Some((tangential.normal, tangential.force?, weight)))
            .map(|(r, s, weight)| weight * (mu * self.x[r] + direction.sign() * self.x[s]))
            .sum()
    }

    /// The largest `mu r` of a contact at the stages of a phase, at least the smallest positive number.
    fn largest_force(&self, phase: &Phase, contact: usize) -> f64 {
        let mu = self.program.model.friction(contact);
        let tangential = phase.stages.iter().flat_map(|stage| &stage.tangential);
        let own = tangential.filter(|tangential| tangential.contact == contact);
        own.map(|tangential| mu * self.x[tangential.normal])
            .fold(f64::MIN_POSITIVE, f64::max)
    }
}

impl Builder<'_, '_> {
    pub(super) fn cone_cut(
        &mut self,
        phase: &Phase,
        contact: usize,
        direction: Direction,
        cut: &Cut,
        at: &str,
    ) {
        if phase.modes[contact] != Mode::Stick {
            return;
        }
        let (model, tableau) = (self.setting.model, self.setting.tableau);
        let name = model.declaration().contacts[contact].name;
        let mut weights = vec![0.0; phase.stages.len()];
        tableau.lagrange_values(cut.theta, &mut weights);
        let name = format!("friction cone of `{name}` {at}");
        let unit = self.setting.units.gap_rows[contact];
        let row = self.program.row_in(unit, name, 0.0, f64::INFINITY);
        let place = (row, contact, direction);
        reserve_between(&mut self.program, model, place, &phase.stages, &weights);
    }

    pub(super) fn slip_cut(&mut self, phase: &Phase, contact: usize, cut: &Cut, at: &str) {
        let Mode::Slip(direction) = phase.modes[contact] else {
            return;
        };
        let state = self.state_at(phase, cut, 2 * self.n, at);
        let (q, v) = state.split_at(self.n);
        let drive = self.drive_within(phase, cut.theta, at);
        let name = self.setting.model.declaration().contacts[contact].name;
        let name = format!("sliding velocity of `{name}` {at}");
        let unit = self.setting.units.gap_rows[contact];
        let row = self.program.row_in(unit, name, 0.0, f64::INFINITY);
        let uses = vec![(row, 0, direction.sign())];
        self.program
            .block(&Kernel::Sliding(contact), [q, v, &drive, &[]], None, uses);
    }
}
