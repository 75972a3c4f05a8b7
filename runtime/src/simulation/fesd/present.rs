//! The present state of a run: the motion, its contacts and their forces.

use crate::contact::{ActiveContact, ContactState, find, force_count};
use crate::enclosure::Bounds;
use crate::fesd::contact_size::ContactSize;
use crate::fesd::contacts::{Contacts, ModeError};
use crate::fesd::finite_element::State;
use crate::model::{ControlPiece, Model, Pieces, friction_share};
use crate::simulation::near::Near;
use crate::simulation::verdict::Verdict;
use crate::simulation::{ContactMode, ControlSignal, InitialValueProblem, Trajectory};

/// The present state, and what is known there.
pub(super) struct Present<'a> {
    pub(super) state: State,
    pub(super) numerical_time: f64,
    /// Length of the run \[s\].
    length: f64,
    /// Contacts that carry a force.
    pub(super) active: Vec<ActiveContact>,
    /// Controls \[their units\].
    pub(super) u: Vec<f64>,
    /// The controls over time, until they jump or change their slope.
    pub(super) piece: ControlPiece,
    /// Input vector of the model, `(q, v, u[, t])`.
    pub(super) x: Vec<f64>,
    pub(super) contacts: Contacts<'a>,
    /// Which contacts may close; the others are far.
    pub(super) near: Near,
    /// Gaps of all contacts, of one that is far what it is not below.
    pub(super) gaps: Vec<f64>,
    /// Normal velocities of the contacts that may close.
    pub(super) velocities: Vec<f64>,
    /// Sliding velocities of the contacts that may close, 0 for those without friction.
    pub(super) sliding: Vec<f64>,
    /// Forces of the active contacts: `r` of each, then `s` of those that stick.
    pub(super) forces: Vec<f64>,
    /// Acceleration with contact forces.
    pub(super) acceleration: Vec<f64>,
}

fn finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

impl<'a> Present<'a> {
    pub(super) fn new(model: &'a dyn Model, problem: &InitialValueProblem) -> Self {
        let declaration = model.declaration();
        let contacts = declaration.contacts.len();
        let x = problem.input(model);
        let mut evaluated = Contacts::new(model);
        evaluated.pieces = Pieces::at(model, &x);
        Self {
            state: State {
                time: 0.0,
                q: problem.q.clone(),
                v: problem.v.clone(),
            },
            numerical_time: 0.0,
            length: problem.horizon,
            active: Vec::with_capacity(contacts),
            u: vec![0.0; declaration.controls.len()],
            piece: ControlPiece::default(),
            x,
            near: Near::new(model, evaluated.surfaces),
            contacts: evaluated,
            gaps: vec![0.0; contacts],
            velocities: vec![0.0; contacts],
            sliding: vec![0.0; contacts],
            forces: Vec::with_capacity(contacts),
            acceleration: vec![0.0; declaration.coordinates.len()],
        }
    }

    /// Takes the piece of the controls that holds from `time` on.
    pub(super) fn take_piece(&mut self, controls: &ControlSignal, time: f64) {
        controls.take_piece(time, self.u.len(), &mut self.piece);
        self.piece.write(time, &mut self.u);
        self.contacts.set_control_slopes(self.piece.slopes());
    }

    /// The input vector of the last evaluation.
    pub(super) fn input(&self) -> &[f64] {
        &self.x
    }

    /// Writes the input vector.
    pub(super) fn write_input(&mut self) {
        let (n, m) = (self.state.q.len(), self.u.len());
        self.x[..n].copy_from_slice(&self.state.q);
        self.x[n..2 * n].copy_from_slice(&self.state.v);
        self.piece.write(self.state.time, &mut self.u);
        self.x[2 * n..2 * n + m].copy_from_slice(&self.u);
        if let Some(time) = self.x.get_mut(2 * n + m) {
            *time = self.state.time;
        }
    }

    /// Gaps and velocities of `contacts`.
    pub(super) fn evaluate_contacts(&mut self, contacts: impl IntoIterator<Item = usize>) {
        self.write_input();
        self.contacts.evaluate_contacts(&self.x, contacts);
    }

    /// Sizes of the gap and the normal velocity of a contact.
    pub(super) fn size(&self, contact: usize) -> ContactSize {
        self.contacts.size(contact, self.state.time)
    }

    /// Contacts that may close, increasing.
    pub(super) fn near(&self) -> &[usize] {
        self.near.contacts()
    }

    /// Gaps and velocities of the contacts that may close, with the sizes of these.
    pub(super) fn evaluate_near(&mut self) {
        self.write_input();
        self.contacts.evaluate_free_acceleration(&self.x);
        if self.near.is_left(&self.x, self.state.q.len(), self.time()) {
            self.look_around();
        }
        self.observe(self.near.contacts().to_vec());
    }

    /// Looks around for a segment of this `length` \[s\] from the present state, if it may leave where nothing can close.
    pub(super) fn look_ahead(&mut self, length: f64) {
        self.near.expect_step(length);
        self.write_input();
        let (a, timed) = (self.contacts.free_acceleration(), self.time().is_some());
        if self.near.is_left_within(&self.x, a, timed) {
            let news = self.look_around();
            self.observe(news);
        }
    }

    /// Time on which gaps depend, if they do.
    fn time(&self) -> Option<f64> {
        let has_time = self.x.len() > 2 * self.state.q.len() + self.u.len();
        has_time.then_some(self.state.time)
    }

    /// Finds out which contacts may close within the next segments; returns those that were far until now.
    fn look_around(&mut self) -> Vec<usize> {
        let mut bounds = Bounds::new(self.contacts.model);
        let least_gap = |i: usize, low: &[f64], high: &[f64]| bounds.least_gap(i, low, high);
        let timed = self.time().is_some();
        let gaps = &mut self.gaps;
        let now = (&self.x[..], self.contacts.free_acceleration());
        let place = |contact: usize, bound: f64| gaps[contact] = bound;
        let news = self.near.look(least_gap, now, timed, place);
        self.choose_pieces(&news);
        news
    }

    /// Lets the pieces of the edges of these contacts act that do so at the input vector.
    fn choose_pieces(&mut self, contacts: &[usize]) {
        let model = self.contacts.model;
        let pieces = &mut self.contacts.pieces;
        pieces.choose_among(model, &self.x, contacts.iter().copied());
    }

    /// Gaps and velocities of the listed contacts at the input vector, with the sizes of these.
    fn observe(&mut self, contacts: Vec<usize>) {
        self.contacts
            .evaluate_contacts(&self.x, contacts.iter().copied());
        self.contacts
            .remember_sizes(&self.x, contacts.iter().copied());
        for i in contacts {
            self.gaps[i] = self.contacts.gap(i);
            self.velocities[i] = self.contacts.normal_velocity(i);
            if self.contacts.friction(i) > 0.0 {
                self.sliding[i] = self.contacts.sliding_velocity(i);
            }
        }
    }

    /// Contacts and forces; the `verdict` takes note of their conditions.
    pub(super) fn evaluate(&mut self, verdict: &mut Verdict) -> Result<(), ModeError> {
        self.evaluate_near();
        self.contacts
            .remember_scales(self.near.contacts().iter().copied());
        for k in 0..self.active.len() {
            let held = self.active[k];
            if held.state.sense() != 0.0 {
                self.contacts.align(held.contact, None);
            }
        }
        self.contacts.check_bounds()?;
        self.forces.resize(force_count(&self.active), 0.0);
        self.contacts
            .contact_forces(&self.active, &mut self.forces)?;
        self.contacts.check_followed(&self.active, &self.forces)?;
        self.contacts
            .constrained_acceleration(&self.active, &self.forces, &mut self.acceleration);
        if self.contacts.rest.is_some() {
            self.acceleration.fill(0.0);
        }
        self.contacts.remember_acceleration(&self.acceleration);
        if !finite(&self.acceleration) || !finite(&self.forces) {
            return Err(ModeError::NotFinite);
        }
        if !finite(&self.gaps) || !finite(&self.velocities) {
            return Err(ModeError::NotFinite);
        }
        self.measure(verdict);
        Ok(())
    }

    /// Takes note of the conditions of contacts.
    fn measure(&self, verdict: &mut Verdict) {
        let (contacts, length) = (&self.contacts, self.length);
        let frictions = contacts.frictions(&self.active, &self.forces);
        for ((held, &r), s) in self.active.iter().zip(&self.forces).zip(frictions) {
            let i = held.contact;
            let size = self.size(i);
            verdict.complements(self.gaps[i], r);
            verdict.is_positive(("the normal force", i), r, (0.0, contacts.phi_scale(i)));
            if !contacts.is_dry(i) {
                let sizes = (size.collected_gap(length), contacts.range(i));
                verdict.vanishes(("the gap", i), self.gaps[i], sizes);
                let sizes = (size.touching_velocity(), size.speed());
                verdict.vanishes(("the normal velocity", i), self.velocities[i], sizes);
            }
            if contacts.friction(i) == 0.0 {
                continue;
            }
            let (sense, sizes) = (held.state.sense(), (size.crossed_rest(), size.sliding()));
            if held.state.is_stuck() {
                verdict.vanishes(("the sliding velocity", i), self.sliding[i], sizes);
            } else {
                let along = sense * self.sliding[i];
                verdict.is_positive(("the sliding velocity", i), along, sizes);
            }
            let (reserve, terms) = (
                contacts.friction(i) * r - s.abs(),
                contacts.tangential_scale(i),
            );
            verdict.is_positive(("the reserve of friction", i), reserve, (0.0, terms));
        }
        for &i in self.near.contacts() {
            if find(&self.active, i).is_none() {
                let acting = self.size(contacts.pieces.acting(i));
                let size = self.size(i).as_difference_from(acting);
                let sizes = (size.collected_gap(length), contacts.range(i));
                verdict.is_positive(("the gap", i), self.gaps[i], sizes);
            }
        }
    }

    /// The mode of each contact.
    pub(super) fn modes(&self) -> Vec<ContactMode> {
        let state = |i: usize| find(&self.active, i).unwrap_or(ContactState::Open);
        (0..self.gaps.len()).map(|i| state(i).into()).collect()
    }

    /// Appends an instant to the `trajectory`: the input vector, at which the active contacts carry `forces`; those of
    /// friction only where there may be any.
    pub(super) fn push(
        &self,
        (time, numerical_time): (f64, f64),
        forces: &[f64],
        friction: bool,
        trajectory: &mut Trajectory,
    ) {
        let (n, m) = (self.state.q.len(), self.u.len());
        let mut row = vec![0.0; self.gaps.len()];
        // Of a mode that could not be entered no forces are known.
        let active = match force_count(&self.active) == forces.len() {
            true => &self.active[..],
            false => &[],
        };
        for (held, &r) in active.iter().zip(forces) {
            row[held.contact] = self.contacts.force(held.contact, r);
        }
        trajectory.push(
            time,
            numerical_time,
            &self.x[..n],
            &self.x[n..2 * n],
            &self.x[2 * n..2 * n + m],
            &row,
        );
        if friction {
            row.fill(0.0);
            let frictions = self.contacts.frictions(active, forces);
            for ((held, s), r) in active.iter().zip(frictions).zip(forces) {
                let part = self.contacts.rest.as_ref();
                let part = part.and_then(|rest| rest.part(held.contact));
                let s = part.map_or(s, |part| -part * self.contacts.friction(held.contact) * r);
                // In space it has a size, and a direction that the velocities tell.
                let s = if self.contacts.is_in_space(held.contact) {
                    s.abs()
                } else {
                    s
                };
                row[held.contact] = self.contacts.force(held.contact, s)
                    * friction_share(self.contacts.model, held.contact, &self.x);
            }
            trajectory.friction_force.push(row);
        }
    }
}
