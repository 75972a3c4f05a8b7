//! The state of a run: what it is about, where it is, and what is recorded of it.

use super::detection::Detector;
use super::error_control::ErrorControl;
use super::present::Present;
use super::settings::Fesd;
use super::stop::Stop;
use super::switch::Switch;
use crate::contact::edge::Zeros;
use crate::contact::{Balance, ContactState, Touching, View, find};
use crate::fesd::contacts::ModeError;
use crate::fesd::finite_element::size::size;
use crate::fesd::finite_element::{FiniteElement, State};
use crate::model::{ImpactLaw, Model};
use crate::rk::ButcherTableau;
use crate::run::remarks::Remarks;
use crate::run::{Bounce, Instant};
use crate::simulation::event_log::EventLog;
use crate::simulation::explicit_time::ExplicitTime;
use crate::simulation::verdict::Verdict;
use crate::simulation::{
    ContactMode, ControlSignal, Counts, Event, EventKind, InitialValueProblem, ProblemSize,
    Trajectory,
};
use crate::yardstick;
use std::ops::Range;

/// Share of the largest velocity of a contact with which it closes at the end of many bounces.
const SLOW: f64 = 1e-3;
/// Share of the horizon below which times are rounding error.
const SHORTEST: f64 = 1e-14;

/// What a run is about, which never changes.
pub(super) struct Setup<'a> {
    pub(super) settings: &'a Fesd,
    pub(super) tableau: &'a ButcherTableau,
    pub(super) model: &'a dyn Model,
    pub(super) problem: &'a InitialValueProblem,
    pub(super) controls: &'a ControlSignal,
    pub(super) horizon: f64,
    /// Coefficients of restitution, one entry a contact.
    pub(super) restitution: Vec<f64>,
    /// Whether a contact declares friction.
    pub(super) frictional: bool,
}

impl Setup<'_> {
    /// All contacts.
    pub(super) fn contacts(&self) -> Range<usize> {
        0..self.restitution.len()
    }

    /// The shortest time that the run tells apart, beyond the rounding error of its times \[s\].
    pub(super) fn shortest(&self) -> f64 {
        SHORTEST * self.horizon
    }

    pub(super) fn name(&self, contact: usize) -> &'static str {
        self.model.declaration().contacts[contact].name
    }
}

fn restitution(model: &dyn Model, contact: usize) -> f64 {
    match model.declaration().contacts[contact].law {
        ImpactLaw::Inelastic => 0.0,
        ImpactLaw::Restitution => model.restitution(contact),
    }
}

/// What a run leaves.
#[derive(Default)]
pub(super) struct Record {
    /// Modes of the contacts right after the start.
    pub(super) initial_modes: Vec<ContactMode>,
    pub(super) events: Vec<Event>,
    pub(super) log: EventLog,
    pub(super) trajectory: Trajectory,
    /// Whether the trajectory is left out, but for its end.
    pub(super) forgetful: bool,
    /// Residuals of the conditions of contacts, and whether they are kept.
    pub(super) verdict: Verdict,
    pub(super) size: ProblemSize,
    pub(super) counts: Counts,
    /// What has to be said of impacts.
    pub(super) remarks: Remarks,
    /// Whether the last attempt at a segment failed since the model was not finite.
    pub(super) not_finite: bool,
}

/// Where a segment begins, to which a run returns from elements that are not accepted.
pub(super) struct SegmentStart {
    pub(super) state: State,
    acceleration: Vec<f64>,
    numerical_time: f64,
    error_estimate: f64,
    local_errors: Vec<f64>,
    verdict: Verdict,
    recorded: usize,
}

/// A run.
pub(super) struct Driver<'a> {
    pub(super) setup: Setup<'a>,
    pub(super) now: Present<'a>,
    pub(super) start: SegmentStart,
    pub(super) control: ErrorControl,
    /// How fast what acts depends on time, where it does.
    pub(super) explicit_time: Option<ExplicitTime<'a>>,
    pub(super) element: FiniteElement<'a>,
    /// Element used to look at the one after a take-off.
    pub(super) next_element: FiniteElement<'a>,
    pub(super) detector: Detector<'a>,
    pub(super) record: Record,
}

impl<'a> Driver<'a> {
    pub(super) fn new(
        settings: &'a Fesd,
        tableau: &'a ButcherTableau,
        model: &'a dyn Model,
        problem: &'a InitialValueProblem,
    ) -> Self {
        let contacts = model.declaration().contacts;
        let now = Present::new(model, problem);
        let verdict = Verdict::within(settings.residual_tolerance());
        Self {
            setup: Setup {
                settings,
                tableau,
                model,
                problem,
                controls: &problem.controls,
                horizon: problem.horizon,
                restitution: (0..contacts.len()).map(|i| restitution(model, i)).collect(),
                frictional: contacts.iter().any(|c| c.friction.is_some()),
            },
            start: SegmentStart {
                state: now.state.clone(),
                acceleration: now.acceleration.clone(),
                numerical_time: 0.0,
                error_estimate: 0.0,
                local_errors: Vec::new(),
                verdict,
                recorded: 0,
            },
            now,
            control: ErrorControl::new(problem, model.declaration().mechanical(), tableau.stages()),
            explicit_time: ExplicitTime::of(model, problem),
            element: settings.element(model, tableau),
            next_element: settings.element(model, tableau),
            detector: Detector::new(model, tableau),
            record: Record {
                verdict,
                ..Record::default()
            },
        }
    }

    /// This run with element lengths that keep the error estimate of each element below `tolerance`; the `longest` is
    /// this share of the longest there are.
    pub(super) fn controlled(mut self, tolerance: f64, longest: f64) -> Self {
        self.control.tolerance = Some(tolerance);
        self.control.longest *= longest;
        if let Some(max_step) = self.setup.settings.max_step {
            self.control.longest = self.control.longest.min(max_step);
        }
        self
    }

    /// This run without a trajectory but its end.
    pub(super) fn forgetful(mut self) -> Self {
        self.record.forgetful = true;
        self
    }

    /// Begins a segment at the present state.
    pub(super) fn begin_segment(&mut self) {
        let (start, now) = (&mut self.start, &self.now);
        start.state.copy_from(&now.state);
        start.acceleration.clone_from(&now.acceleration);
        start.numerical_time = now.numerical_time;
        start.error_estimate = self.control.estimate;
        start.local_errors.clone_from(&self.control.local_errors);
        start.verdict = self.record.verdict;
        start.recorded = self.record.trajectory.time.len();
    }

    /// Takes back all elements since the start of the segment. Contacts and forces stay those of the last state that was
    /// evaluated.
    pub(super) fn return_to_start(&mut self) {
        let (start, now) = (&self.start, &mut self.now);
        now.state.copy_from(&start.state);
        now.acceleration.clone_from(&start.acceleration);
        now.numerical_time = start.numerical_time;
        self.control.estimate = start.error_estimate;
        self.control.local_errors.clone_from(&start.local_errors);
        self.record.verdict = start.verdict;
        self.record.trajectory.truncate(start.recorded);
    }

    /// The first switch in the solved element, which begins at the present state.
    pub(super) fn first_violation(&mut self) -> Result<Option<Switch>, Stop> {
        let motion = self.control.tolerance.map(|_| &self.control.motion);
        let solved = (&self.element, self.setup.tableau);
        self.detector.first_violation(solved, &mut self.now, motion)
    }

    /// Makes the solved element part of the trajectory.
    pub(super) fn accept_element(&mut self) -> Result<(), Stop> {
        let stages = self.setup.tableau.stages();
        let mut rates = [0.0; ButcherTableau::MAX_STAGES];
        for (m, rate) in rates[..stages].iter_mut().enumerate() {
            let acceleration = self.setup.settings.auxiliary_acceleration;
            *rate = self.element.numerical_rate(m, acceleration);
        }
        if self.control.tolerance.is_some() && !self.record.forgetful {
            self.record_stages(&rates[..stages]);
        }
        let weights = self.setup.tableau.b().iter().copied();
        let length = self.element.length;
        self.now.numerical_time +=
            length * self.element.numerical_length(&rates[..stages], weights);
        self.control
            .add_error(&self.element, &self.now.acceleration);
        self.now.state.copy_from(&self.element.end);
        let state = &self.now.state;
        self.control.motion.include(&state.q, &state.v);
        let residuals = &mut self.record.verdict.residuals;
        residuals.primal = residuals.primal.max(self.element.residual_norm);
        self.record.counts.elements += 1;
        if self.element.variables() > self.record.size.variables {
            self.record.size = size(&mut self.element);
        }
        self.evaluate_state()?;
        self.record_state();
        Ok(())
    }

    /// Contacts and forces at the present state; measures the residuals there.
    pub(super) fn evaluate_state(&mut self) -> Result<(), ModeError> {
        self.record.verdict.place = (self.now.state.time, self.record.counts.elements);
        self.now.evaluate(&mut self.record.verdict)
    }

    /// Records the inner stages of the solved element; `rates` are those of numerical time.
    fn record_stages(&mut self, rates: &[f64]) {
        let (now, tableau) = (&mut self.now, self.setup.tableau);
        let length = self.element.length;
        for (m, _) in tableau
            .c()
            .iter()
            .enumerate()
            .take_while(|(_, c)| **c < 1.0)
        {
            let weights = (0..rates.len()).map(|j| tableau.a(m, j));
            let past = length * self.element.numerical_length(rates, weights);
            now.x.copy_from_slice(self.element.stage_input(m));
            let held = now.active.iter().map(|held| held.contact);
            now.contacts.evaluate_contacts(&now.x, held);
            now.push(
                (self.element.stage_time(m), now.numerical_time + past),
                self.element.stage_constraint_forces(m),
                self.setup.frictional,
                &mut self.record.trajectory,
            );
        }
    }

    /// Records the present state.
    pub(super) fn record_state(&mut self) {
        if !self.record.forgetful {
            let now = &mut self.now;
            now.write_input();
            now.push(
                (now.state.time, now.numerical_time),
                &now.forces,
                self.setup.frictional,
                &mut self.record.trajectory,
            );
        }
    }

    /// Records an event at the present state, before which the velocity was `v_before`.
    pub(super) fn record_event(&mut self, kind: EventKind, contact: usize, v_before: Vec<f64>) {
        let state = &self.now.state;
        self.record.events.push(Event {
            time: state.time,
            kind: kind.of(&self.setup.model.declaration().contacts[contact]),
            contact,
            contact_name: self.setup.name(contact),
            modes: self.now.modes(),
            q: state.q.clone(),
            v_before,
            v_after: state.v.clone(),
            contact_impulse: Vec::new(),
            friction_impulse: Vec::new(),
        });
    }

    /// Events so far, listed or not.
    pub(super) fn events(&self) -> usize {
        self.record.log.count(self.record.events.len())
    }
}

impl<'a> Instant<'a> for Driver<'a> {
    type Error = ModeError;

    fn view(&self) -> &View<'a> {
        &self.now.contacts
    }

    fn view_mut(&mut self) -> &mut View<'a> {
        &mut self.now.contacts
    }

    fn time(&self) -> f64 {
        self.now.state.time
    }

    fn input(&mut self) -> Vec<f64> {
        self.now.write_input();
        self.now.x.clone()
    }

    fn put(&mut self, x: &[f64]) {
        let (q, v) = x[..2 * self.now.state.q.len()].split_at(self.now.state.q.len());
        self.now.state.q.copy_from_slice(q);
        self.now.state.v.copy_from_slice(v);
        self.now.write_input();
    }

    fn rates(&mut self) -> Vec<f64> {
        self.now.contacts.rates()
    }

    fn accelerations(&mut self) -> Vec<f64> {
        self.now.acceleration.clone()
    }

    fn state(&self, contact: usize) -> ContactState {
        find(&self.now.active, contact).unwrap_or(ContactState::Open)
    }

    fn zeros(&self, contact: usize) -> Zeros {
        let size = self.now.size(contact);
        Zeros {
            gap: size.touching_gap(),
            gap_rounding: size.gap_rounding(),
            rounding: size.velocity_rounding(),
            velocity: size.touching_velocity(),
        }
    }

    fn rest_speed(&self, contact: usize) -> f64 {
        self.now.contacts.rest_speed(contact, self.now.state.time)
    }

    fn still(&self) -> Vec<(f64, f64)> {
        vec![(0.0, 0.0); self.setup.restitution.len()]
    }

    fn restitution(&self, contact: usize) -> f64 {
        self.setup.restitution[contact]
    }

    /// A bounce that stays within what counts as touching is none.
    fn bounces(&mut self, contacts: &[usize], alone: bool) -> Vec<Bounce> {
        let bounce = |&contact: &usize| {
            let size = self.now.size(contact);
            let lowest = if alone {
                size.gap_rounding()
            } else {
                size.touching_gap()
            };
            let slowest = (2.0 * self.now.contacts.phi_scale(contact) * lowest).sqrt();
            let slowest = slowest / self.setup.restitution[contact];
            Bounce {
                slowest: rest_velocity(self, contact).max(slowest),
                press: -self.now.contacts.normal_acceleration(contact),
            }
        };
        contacts.iter().map(bounce).collect()
    }

    fn solve(view: &View<'a>, touching: Touching, offsets: &[f64]) -> Result<Balance, ModeError> {
        Balance::first(touching, view, offsets)
    }

    fn set_twice(&self, condition: usize) -> ModeError {
        ModeError::SetTwice(condition)
    }

    /// At the end of bounces contacts may strike one after the other where together they jam.
    fn may_follow(&self, error: &ModeError, struck: &[usize]) -> bool {
        let is_slow = |&i: &usize| {
            let speed = -self.now.contacts.normal_velocity(i);
            speed <= SLOW * self.now.size(i).speed()
        };
        *error == ModeError::Jammed && struck.iter().all(is_slow)
    }
}

/// Normal velocity below which a contact with restitution no longer bounces.
pub(super) fn rest_velocity(driver: &Driver<'_>, contact: usize) -> f64 {
    let largest = driver.now.size(contact).speed();
    let chosen = driver.setup.settings.rest_velocity;
    chosen.unwrap_or(yardstick::PROMISE * largest)
}
