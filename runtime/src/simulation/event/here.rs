//! The present instant of a run, as what happens there is told by [`run`](crate::run).

use super::contact_problem::ContactProblem;
use super::dop853::System;
use super::dynamics::{Dynamics, Switch};
use crate::contact::edge::Zeros;
use crate::contact::{Balance, ContactState, Direction, Line, Touching, View};
use crate::model::contact_point;
use crate::run::impact::{self, Impact};
use crate::run::{Bounce, Instant, resets};

/// Bounces lower than this share of the range of a gap are left out, and those lower than ten times a closed gap.
const LOWEST_BOUNCE: f64 = 1e-11;

/// Why no contact mode could be found.
#[derive(Debug, Clone)]
pub(in crate::simulation) struct Undetermined {
    pub(in crate::simulation) contact: usize,
    pub(in crate::simulation) message: String,
}

/// Which bounces are left out.
#[derive(Debug, Clone, Copy)]
pub(in crate::simulation) struct LowestBounce {
    /// Normal velocity below which a contact no longer bounces; by default that of a bounce as high as
    /// `height`.
    pub(in crate::simulation) velocity: Option<f64>,
    /// Height relative to the range of the gap so far.
    pub(in crate::simulation) height: f64,
}

/// An instant of a run from event to event.
pub(in crate::simulation) struct Here<'h, 'a> {
    pub(in crate::simulation) dynamics: &'h mut Dynamics<'a>,
    pub(in crate::simulation) time: f64,
    /// State, `(q, v, ..)`.
    pub(in crate::simulation) y: &'h mut [f64],
    pub(in crate::simulation) lowest: LowestBounce,
}

impl<'a> Instant<'a> for Here<'_, 'a> {
    type Error = Undetermined;

    fn view(&self) -> &View<'a> {
        self.dynamics
    }

    fn view_mut(&mut self) -> &mut View<'a> {
        self.dynamics
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn input(&mut self) -> Vec<f64> {
        self.dynamics.load(self.time, self.y);
        self.dynamics.input().to_vec()
    }

    fn put(&mut self, x: &[f64]) {
        let n = self.dynamics.n;
        self.y[..2 * n].copy_from_slice(&x[..2 * n]);
        self.dynamics.load(self.time, self.y);
    }

    fn rates(&mut self) -> Vec<f64> {
        rates(self.dynamics, (self.time, self.y))
    }

    fn accelerations(&mut self) -> Vec<f64> {
        let mut slope = vec![0.0; self.y.len()];
        self.dynamics.derivative(self.time, self.y, &mut slope);
        let n = self.dynamics.n;
        slope[n..2 * n].to_vec()
    }

    fn state(&self, contact: usize) -> ContactState {
        self.dynamics.state(contact)
    }

    fn zeros(&self, contact: usize) -> Zeros {
        Zeros {
            gap: self.dynamics.closed_gap(contact),
            gap_rounding: self.dynamics.gap_rounding(contact),
            rounding: self.dynamics.zero_normal_velocity(contact),
            velocity: self.dynamics.zero_normal_velocity(contact),
        }
    }

    fn rest_speed(&self, contact: usize) -> f64 {
        self.dynamics.zero_speed(contact)
    }

    fn still(&self) -> Vec<(f64, f64)> {
        self.dynamics.zero_velocities()
    }

    fn restitution(&self, contact: usize) -> f64 {
        self.dynamics.laws.restitution[contact]
    }

    /// How high a bounce would be depends on what presses the contact in the present mode.
    fn bounces(&mut self, contacts: &[usize], _: bool) -> Vec<Bounce> {
        let accelerations = self.accelerations();
        let dynamics = &mut *self.dynamics;
        let bounce = |&i: &usize| {
            let press = -dynamics.line_acceleration(Line::normal(i), &accelerations);
            let height = (self.lowest.height.max(LOWEST_BOUNCE) * dynamics.gap_range(i))
                .max(10.0 * dynamics.closed_gap(i));
            let own = || (2.0 * press.max(0.0) * height).sqrt();
            Bounce {
                slowest: self.lowest.velocity.unwrap_or_else(own),
                press,
            }
        };
        contacts.iter().map(bounce).collect()
    }

    fn solve(
        view: &View<'a>,
        touching: Touching,
        offsets: &[f64],
    ) -> Result<Balance, Undetermined> {
        let contact = touching.contacts.first().copied().unwrap_or_default();
        let problem = ContactProblem {
            what: "impact",
            touching,
            offsets: offsets.to_vec(),
        };
        let solved = problem.solve(view);
        solved.map_err(|message| Undetermined { contact, message })
    }

    fn set_twice(&self, condition: usize) -> Undetermined {
        Undetermined {
            contact: condition,
            message: resets::set_twice(self.dynamics.model.declaration().contacts[condition].name),
        }
    }

    fn may_follow(&self, _: &Undetermined, _: &[usize]) -> bool {
        false
    }
}

impl Here<'_, '_> {
    /// Applies the impact law to all closed contacts; `closing` counts as closed whatever its gap. Returns the impact and the contacts that
    /// are at rest after it, or whose next flight is too low to be one, increasing.
    pub(in crate::simulation) fn impact(
        &mut self,
        closing: Option<usize>,
    ) -> Result<(Impact, Vec<usize>), Undetermined> {
        // Dry friction has no impulses; it acts before and after.
        let (closed, dry): (Vec<usize>, Vec<usize>) = self
            .closed_contacts(closing)
            .into_iter()
            .partition(|&i| !self.dynamics.is_dry(i));
        let impact = impact::carry_out(self, &closed)?;
        self.dynamics.load(self.time, self.y);
        self.dynamics.evaluate_free_acceleration();
        let own = impact.after.len() - impact.edges;
        let mut resting = Vec::with_capacity(impact.after.len() + dry.len());
        for (k, &(i, velocity)) in impact.after.iter().enumerate() {
            // A gap that falls through zero at once, although it grows, has been negative all the time.
            let never_open = k < own && closing == Some(i) && impact.struck.is_empty();
            if rests(self.dynamics, i, velocity, never_open) {
                resting.push(i);
            }
        }
        if impact.edges > 0 {
            resting.sort_unstable();
        }
        resting.extend(dry);
        Ok((impact, resting))
    }

    /// Sets what conditions ask for that come true where a switching function has `vanished`. Returns them, and what still vanishes then.
    pub(super) fn conditions(
        &mut self,
        vanished: Option<Switch>,
    ) -> Result<(Vec<usize>, Option<Switch>), Undetermined> {
        let (condition, located) = match vanished {
            Some(Switch::SlidingVelocity(contact, direction)) => {
                let comes_true = direction == Direction::Forward;
                (Some(contact), Some(contact).filter(|_| comes_true))
            }
            _ => (None, None),
        };
        let value = condition.map(|contact| resets::function(self, contact));
        let coming = resets::coming(self, located);
        let set = resets::set(self, coming)?;
        // Where a condition reads nothing that was set its function vanishes as before, however far rounding has left it from zero.
        let now = condition.map(|contact| resets::function(self, contact));
        let vanished = vanished.filter(|_| set.is_empty() || value.is_some() && now == value);
        Ok((set, vanished))
    }

    /// Contacts that are closed, evaluated.
    fn closed_contacts(&mut self, closing: Option<usize>) -> Vec<usize> {
        let dynamics = &mut *self.dynamics;
        dynamics.load(self.time, self.y);
        dynamics.stay_near();
        let mut closed = Vec::new();
        for i in dynamics.near().to_vec() {
            if dynamics.pieces.is_idle(i) {
                continue;
            }
            dynamics.evaluate_sides(i);
            let gap = dynamics.point(i)[contact_point::GAP];
            if gap <= dynamics.closed_gap(i) || closing == Some(i) || dynamics.is_active(i) {
                closed.push(i);
            }
        }
        closed
    }
}

/// Rates of what the model reads besides coordinates and velocities: controls, and the time.
pub(super) fn rates(dynamics: &mut Dynamics<'_>, (t, y): (f64, &[f64])) -> Vec<f64> {
    let n = dynamics.n;
    dynamics.load(t, y);
    let now = dynamics.input()[2 * n..].to_vec();
    dynamics.load(t + 1.0, y);
    let later = dynamics.input()[2 * n..].to_vec();
    dynamics.load(t, y);
    let pairs = later.iter().zip(&now);
    pairs.map(|(later, now)| later - now).collect()
}

/// Whether a closed contact with this normal velocity stays: it has none, or its flight is too low to be one.
fn rests(dynamics: &mut Dynamics<'_>, contact: usize, velocity: f64, never_open: bool) -> bool {
    dynamics.evaluate_contact(contact);
    let (acceleration, _) = dynamics.free_normal_acceleration(contact);
    let highest = if never_open {
        dynamics.closed_gap(contact)
    } else {
        dynamics.lowest_flight(contact)
    };
    let room = highest - dynamics.point(contact)[contact_point::GAP];
    let returns = velocity > 0.0 && velocity * velocity <= -2.0 * acceleration * room;
    velocity.abs() <= dynamics.zero_normal_velocity(contact) || returns
}
