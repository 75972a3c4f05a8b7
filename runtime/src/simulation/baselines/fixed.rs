//! The classical Runge-Kutta method with fixed steps, which notices switches only at the ends of steps.

use super::shared::{check, check_gaps, judged};
use crate::Observer;
use crate::model::Model;
use crate::simulation::agreement;
use crate::simulation::event::contact_mode;
use crate::simulation::event::dop853::{Dop853, System};
use crate::simulation::event::dynamics::{Dynamics, motion};
use crate::simulation::event::here::{Here, LowestBounce, Undetermined};
use crate::simulation::impulse;
use crate::simulation::joints::Closed;
use crate::simulation::other_grid::OtherGrid;
use crate::simulation::watch::Watch;
use crate::simulation::{
    Diagnosis, Event, EventKind, InitialValueProblem, InputError, Simulation, SimulationStatus,
    Simulator,
};

/// The classical Runge-Kutta method of order 4 with fixed steps on the mode-switched system: the
/// constrained dynamics of the contacts that are active at the start of a step hold to its end. Only
/// there does it look: a contact that has penetrated is struck (Moreau's impact law at that time, position
/// moved back onto the surface), a contact whose force has become negative is released.
///
/// Order 4 without switches, in general order 1 with them: the time of a switch is known to a step. A
/// take-off alone costs order 2, because the force vanishes there, and so does a landing on a plane, along
/// which flight and slide accelerate alike. Its error is measured by runs of half and of three fifths
/// of the steps, which cost as much again, and by an embedded estimate of its steps. To be compared with.
///
/// ```
/// use hangtime::baselines::FixedStep;
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81, height: m = 1 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: inelastic
/// #         start { z: height }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let ball = Ball::default();
/// let run = simulate(&ball).method(FixedStep::default()).steps(400).run()?;
/// // The impact is found at the end of its step.
/// assert!((run.events[0].time - (2.0_f64 / 9.81).sqrt()).abs() < 1.0 / 400.0);
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FixedStep {
    /// Number of equal steps; default 1000.
    pub steps: usize,
    /// Acceleration `a_bar` of the auxiliary dynamics that the numerical time refers to
    /// \[unit of the gap / s^2\]; default `100 * 9.81`.
    pub auxiliary_acceleration: f64,
}

impl Default for FixedStep {
    fn default() -> Self {
        Self {
            steps: 1000,
            auxiliary_acceleration: 981.0,
        }
    }
}

impl Simulator for FixedStep {
    fn name(&self) -> &'static str {
        "fixed"
    }

    fn simulate(
        &self,
        model: &dyn Model,
        problem: &InitialValueProblem,
        observer: &mut Observer<'_>,
    ) -> Result<Simulation, InputError> {
        check(self.steps, self.auxiliary_acceleration)?;
        let closed = Closed::of(model, problem)?;
        let (model, problem) = closed.scene();
        InitialValueProblem::check_inelastic(model, self.name())?;
        InitialValueProblem::check_resets(
            model,
            "fixed steps",
            crate::simulation::joints::LOCATED,
        )?;
        let others = OtherGrid::of_steps(self.steps, |steps| Self {
            steps,
            ..self.clone()
        });
        let run = |settings: &Self, watch: &mut Watch<'_>| {
            FixedRun::new(settings, model, problem).run(watch)
        };
        let scene = (model, problem);
        let mut result = judged((self, others), "take more steps", scene, observer, run);
        impulse::record(model, &mut result);
        closed.finish(&mut result);
        Ok(result)
    }

    fn set_steps(&mut self, steps: usize) -> Result<(), InputError> {
        self.steps = steps;
        Ok(())
    }
}

struct FixedRun<'a> {
    settings: &'a FixedStep,
    problem: &'a InitialValueProblem,
    dynamics: Dynamics<'a>,
    probe: Dop853,
    y: Vec<f64>,
    stage: Vec<f64>,
    slopes: [Vec<f64>; 4],
    forces: Vec<f64>,
    friction_forces: Vec<f64>,
    /// Sums of the local errors of coordinates and velocities.
    local_errors: Vec<f64>,
    result: Simulation,
}

impl<'a> FixedRun<'a> {
    fn new(
        settings: &'a FixedStep,
        model: &'a dyn Model,
        problem: &'a InitialValueProblem,
    ) -> Self {
        let dynamics = Dynamics::new(model, settings.auxiliary_acceleration);
        let y = [&problem.q[..], &problem.v[..], &[0.0]].concat();
        let dimension = y.len();
        Self {
            settings,
            problem,
            probe: Dop853::new(dimension, 2 * dynamics.n),
            stage: y.clone(),
            slopes: std::array::from_fn(|_| vec![0.0; dimension]),
            y,
            forces: vec![0.0; dynamics.contacts],
            friction_forces: vec![0.0; dynamics.contacts],
            result: dynamics.empty_result(),
            local_errors: vec![0.0; 2 * dynamics.n],
            dynamics,
        }
    }

    fn run(mut self, watch: &mut Watch<'_>) -> Simulation {
        match self.integrate(watch) {
            Ok(()) => {
                let scene = (self.dynamics.model, self.problem);
                let error = agreement::share(&self.result, scene, &self.local_errors);
                self.result.error_estimate = Some(error);
            }
            Err(status) => self.result.status = status,
        }
        self.result.counts.evaluations = self.dynamics.evaluations;
        self.result.counts.events = self.result.events.len();
        self.result
    }

    fn integrate(&mut self, watch: &mut Watch<'_>) -> Result<(), SimulationStatus> {
        let h = self.problem.horizon / self.settings.steps as f64;
        self.dynamics.set_controls(&self.problem.controls, 0.0);
        self.enter_mode(0.0, h)?;
        self.evaluate(0.0)?;
        self.record(0.0);
        for step in 0..self.settings.steps {
            let t = step as f64 * h;
            let end = if step + 1 == self.settings.steps {
                self.problem.horizon
            } else {
                t + h
            };
            // The piece at the middle of the step: jumps of the controls or of their slopes are not located either.
            self.dynamics
                .set_controls(&self.problem.controls, t + 0.5 * h);
            self.runge_kutta(t, h);
            let switched = self.evaluate(end)?;
            self.add_local_errors(h);
            self.result.counts.elements += 1;
            if switched {
                self.record(end);
                self.enter_mode(end, h)?;
                self.evaluate(end)?;
            }
            self.record(end);
            let count = self.result.counts.elements;
            watch.reach(end, count, &mut self.result.trajectory)?;
        }
        Ok(())
    }

    /// One step of the classical method from the slope at its start, then onto the surfaces.
    fn runge_kutta(&mut self, t: f64, h: f64) {
        self.dynamics.derivative(t, &self.y, &mut self.slopes[0]);
        for (index, share) in [(1, 0.5), (2, 0.5), (3, 1.0)] {
            for ((stage, y), slope) in self
                .stage
                .iter_mut()
                .zip(&self.y)
                .zip(&self.slopes[index - 1])
            {
                *stage = y + share * h * slope;
            }
            self.dynamics
                .derivative(t + share * h, &self.stage, &mut self.slopes[index]);
        }
        let [first, second, third, fourth] = &self.slopes;
        for (k, y) in self.y.iter_mut().enumerate() {
            *y += h / 6.0 * (first[k] + 2.0 * (second[k] + third[k]) + fourth[k]);
        }
        if !motion::project(&mut self.dynamics, t + h, &mut self.y) {
            self.y.fill(f64::NAN);
        }
    }

    /// Adds the local errors of the step of length `h` that has just been made: the embedded estimate `e = h/6 |k_4 - k_5|` with the
    /// slope `k_5` at its end has order 3, and the step is more accurate by `w h` for what turns at the rate `w`, which is
    /// `18 e / (h |k_3 - k_2|)`. What steps damp counts in full.
    fn add_local_errors(&mut self, h: f64) {
        let [end, second, third, fourth] = &self.slopes;
        for (k, error) in self.local_errors.iter_mut().enumerate() {
            let embedded = h / 6.0 * (fourth[k] - end[k]).abs();
            let change = h * (third[k] - second[k]).abs();
            *error += embedded * (18.0 * embedded / change).min(1.0);
        }
    }

    /// Forces at the present state; whether a contact has penetrated or pulls.
    fn evaluate(&mut self, t: f64) -> Result<bool, SimulationStatus> {
        self.dynamics.derivative(t, &self.y, &mut self.slopes[0]);
        check_gaps(&self.dynamics, t, self.result.counts.elements)?;
        if !self.slopes[0].iter().all(|slope| slope.is_finite()) {
            return Err(SimulationStatus::NotFinite(self.diagnosis(
                t,
                self.dynamics.mode.active.first().copied(),
                "state or acceleration is not a finite number; take more steps, or check the scene"
                    .into(),
            )));
        }
        self.dynamics.forces(&mut self.forces);
        self.dynamics.friction_forces(&mut self.friction_forces);
        Ok(self
            .dynamics
            .switching
            .values
            .iter()
            .any(|&value| value < 0.0))
    }

    fn enter_mode(&mut self, t: f64, h: f64) -> Result<(), SimulationStatus> {
        let n = self.dynamics.n;
        let before = self.y[n..2 * n].to_vec();
        let previously = self.dynamics.mode().to_vec();
        // A dry friction that has come to rest within the step does so at its end.
        let functions = 0..self.dynamics.functions();
        let vanished = functions
            .filter(|&function| self.dynamics.switching.values[function] < 0.0)
            .map(|function| self.dynamics.switch(function))
            .find(|switch| self.dynamics.is_dry(switch.contact()));
        // Contacts with restitution are refused: no bounce is too low.
        let lowest = LowestBounce {
            velocity: None,
            height: 0.0,
        };
        self.dynamics.load(t, &self.y);
        self.dynamics.choose_pieces();
        self.dynamics.observe_rounding(t, &self.y, h, false);
        let mut here = Here {
            dynamics: &mut self.dynamics,
            time: t,
            y: &mut self.y,
            lowest,
        };
        let (impact, resting) = here
            .impact(None)
            .map_err(|problem| self.undetermined(t, problem))?;
        self.y[2 * n] += impact.impulse / self.settings.auxiliary_acceleration;
        contact_mode::change(
            &mut self.dynamics,
            &mut self.probe,
            t,
            &mut self.y,
            &resting,
            vanished,
            contact_mode::Outlook {
                moment: h,
                longest: self.problem.horizon,
                skipped: 0,
            },
        )
        .map_err(|problem| self.undetermined(t, problem))?;
        if self.result.initial_modes.is_empty() {
            self.result.initial_modes = self.dynamics.contact_modes();
        }
        for (i, &was) in previously.iter().enumerate() {
            let is = self.dynamics.state(i);
            let kind = if impact.struck.contains(&i) {
                EventKind::Impact
            } else if t == 0.0 || was == is {
                continue;
            } else if is.is_open() {
                EventKind::LiftOff
            } else if was.is_open() {
                EventKind::Contact
            } else if is.is_stuck() {
                EventKind::Stick
            } else {
                EventKind::Slip
            };
            let declared = &self.dynamics.model.declaration().contacts[i];
            self.result.events.push(Event {
                time: t,
                kind: kind.of(declared),
                contact: i,
                contact_name: declared.name,
                modes: self.dynamics.contact_modes(),
                q: self.y[..n].to_vec(),
                v_before: before.clone(),
                v_after: self.y[n..2 * n].to_vec(),
                contact_impulse: Vec::new(),
                friction_impulse: Vec::new(),
            });
        }
        Ok(())
    }

    fn record(&mut self, t: f64) {
        let n = self.dynamics.n;
        self.dynamics.write_controls(t);
        self.result.trajectory.push(
            t,
            self.y[2 * n],
            &self.y[..n],
            &self.y[n..2 * n],
            &self.dynamics.u,
            &self.forces,
        );
        if self.dynamics.laws.declares_friction {
            let frictions = self.friction_forces.clone();
            self.result.trajectory.friction_force.push(frictions);
        }
        let residuals = &mut self.result.residuals;
        for value in &self.dynamics.switching.values {
            residuals.dual = residuals.dual.max(-value);
        }
    }

    fn diagnosis(&self, time: f64, contact: Option<usize>, message: String) -> Diagnosis {
        Diagnosis {
            time,
            step: self.result.counts.elements,
            contact,
            message,
        }
    }

    fn undetermined(&self, t: f64, problem: Undetermined) -> SimulationStatus {
        SimulationStatus::AmbiguousContact(self.diagnosis(
            t,
            Some(problem.contact),
            problem.message,
        ))
    }
}
