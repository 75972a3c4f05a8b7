//! What happens at an instant of the run: resets, impacts, and the contact mode after them.

use super::{Integration, PATIENCE};
use crate::contact::Direction;
use crate::run::impact::Impact;
use crate::run::resets;
use crate::simulation::event::contact_mode::{self, Outlook};
use crate::simulation::event::dynamics::{Switch, switching};
use crate::simulation::event::here::{Here, LowestBounce};
use crate::simulation::{Event, EventKind, SimulationStatus, accumulation, changes};

impl<'a> Integration<'a> {
    /// Applies the impact law and finds the contact mode right after the present instant, records both
    /// sides, and prepares the next step. `vanished` is the switching function that has just vanished.
    pub(super) fn enter_mode(
        &mut self,
        vanished: Option<Switch>,
        at_start: bool,
    ) -> Result<(), SimulationStatus> {
        let n = self.dynamics.n;
        let before = self.y[n..2 * n].to_vec();
        let previously = self.dynamics.mode().to_vec();
        let outlook = Outlook {
            moment: self.h,
            longest: self.problem.horizon,
            skipped: self.counts.repeats / PATIENCE,
        };
        let vanished = self.dynamics.pass_edge(vanished);
        self.dynamics
            .observe_rounding(self.t, &self.y, self.h, at_start);
        let (condition, located) = match vanished {
            Some(Switch::SlidingVelocity(contact, direction)) => {
                let comes_true = direction == Direction::Forward;
                (Some(contact), Some(contact).filter(|_| comes_true))
            }
            _ => (None, None),
        };
        let mut here = self.here();
        let value = condition.map(|contact| resets::function(&mut here, contact));
        let mut set = resets::set(&mut here, located);
        // Where a condition reads nothing that was set its function vanishes as before, however far rounding has left it from zero.
        let now = condition.map(|contact| resets::function(&mut here, contact));
        let vanished = vanished.filter(|_| set.is_empty() || value.is_some() && now == value);
        let (mut impact, mut resting) = self.impact(vanished)?;
        if !impact.struck.is_empty() {
            set.extend(resets::set(&mut self.here(), None));
        }
        if at_start && !impact.struck.is_empty() {
            let after = self.y[n..2 * n].to_vec();
            self.y[n..2 * n].copy_from_slice(&before);
            self.record();
            self.y[n..2 * n].copy_from_slice(&after);
        }
        // An impact changes velocities and forces: what has vanished before it may not have done so after.
        let mut vanished = vanished.filter(|_| impact.struck.is_empty());
        loop {
            let (dynamics, probe, y) = (&mut self.dynamics, &mut self.probe, &mut self.y);
            contact_mode::change(dynamics, probe, self.t, y, &resting, vanished, outlook)
                .map_err(|problem| self.place().undetermined(problem))?;
            if at_start || !resets::set_turned(&mut self.here(), &previously, &mut set) {
                break;
            }
            // What was set may lead into a surface.
            let (next, rests) = self.impact(None)?;
            impact.struck.extend(next.struck);
            resting = rests;
            vanished = None;
        }
        if at_start {
            self.result.initial_modes = self.dynamics.contact_modes();
        }
        self.begin()?;
        switching::accept_forces(&mut self.dynamics);
        self.record();
        self.observe();
        let happened = changes::of(
            self.dynamics.model.declaration().contacts,
            (&previously, self.dynamics.mode()),
            (&impact.struck, &set),
            at_start,
        );
        let happened = happened.into_iter();
        let events = happened.map(|(kind, contact)| self.event(kind, contact, &before));
        self.list(events.collect())
    }

    /// The present instant, as what happens there reads it.
    pub(super) fn here(&mut self) -> Here<'_, 'a> {
        Here {
            dynamics: &mut self.dynamics,
            time: self.t,
            y: &mut self.y,
            lowest: LowestBounce {
                velocity: self.settings.rest_velocity,
                height: self.settings.tolerance.powi(2),
            },
        }
    }

    /// An event at the present instant, before which there were these velocities.
    fn event(&self, kind: EventKind, contact: usize, velocities: &[f64]) -> Event {
        let n = self.dynamics.n;
        let declared = &self.dynamics.model.declaration().contacts[contact];
        Event {
            time: self.t,
            kind: kind.of(declared),
            contact,
            contact_name: declared.name,
            modes: self.dynamics.contact_modes(),
            q: self.y[..n].to_vec(),
            v_before: velocities.to_vec(),
            v_after: self.y[n..2 * n].to_vec(),
            contact_impulse: Vec::new(),
            friction_impulse: Vec::new(),
        }
    }

    /// Lists events, unless there are too many.
    fn list(&mut self, events: Vec<Event>) -> Result<(), SimulationStatus> {
        self.result.events.extend(events);
        let last = self.result.events.last().map(|event| event.contact);
        if let Some(status) = accumulation::of(&self.result.events, self.problem.horizon) {
            return Err(status);
        }
        self.log.tidy(&mut self.result.events);
        if self.events() > self.settings.max_events {
            return Err(self.place().too_many_events(self.events(), last));
        }
        Ok(())
    }

    /// Events so far, listed or not.
    pub(super) fn events(&self) -> usize {
        self.log.count(self.result.events.len())
    }

    /// Applies the impact law, and remembers what a user should know of it. Returns the contacts at rest after it as well.
    fn impact(
        &mut self,
        vanished: Option<Switch>,
    ) -> Result<(Impact, Vec<usize>), SimulationStatus> {
        let closing = match vanished {
            Some(Switch::Gap(contact)) => Some(contact),
            _ => None,
        };
        let impact = self.here().impact(closing);
        let (impact, resting) = impact.map_err(|problem| self.place().undetermined(problem))?;
        self.y[2 * self.dynamics.n] += impact.impulse / self.settings.auxiliary_acceleration;
        self.checks.remarks.add(self.t, &impact);
        Ok((impact, resting))
    }

    /// Evaluates derivative, values and forces at the present state.
    pub(super) fn begin(&mut self) -> Result<(), SimulationStatus> {
        self.method.begin(&mut self.dynamics, self.t, &self.y);
        self.step
            .start_values
            .copy_from_slice(&self.dynamics.switching.values);
        let measured = self.forces.measure(&self.dynamics);
        self.audit_now();
        self.keep(measured);
        if self.method.slope().iter().all(|slope| slope.is_finite()) {
            self.step.orientation = self.dynamics.orientation;
            Ok(())
        } else {
            Err(self.place().not_finite(self.method.slope()))
        }
    }
}
