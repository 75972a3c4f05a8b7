//! Moreau-Jean time stepping: impacts and contact forces as impulses over a fixed step, without events.

use super::shared::{check, check_gaps, judged};
use crate::Observer;
use crate::contact::{Balance, Line, Touching};
use crate::linalg::products::{dot, largest};
use crate::model::{Model, contact_point, friction_share, pair_size};
use crate::simulation::event::contact_problem::ContactProblem;
use crate::simulation::event::dynamics::{Dynamics, motion};
use crate::simulation::joints::Closed;
use crate::simulation::other_grid::OtherGrid;
use crate::simulation::watch::Watch;
use crate::simulation::{
    ContactMode, Diagnosis, Direction, InitialValueProblem, InputError, Simulation,
    SimulationStatus, Simulator,
};
use crate::yardstick;

/// Largest number of iterations of the implicit midpoint rule; they contract with the step size times the
/// rate at which forces change, so more than ten mean that the step is too long.
const ITERATIONS: usize = 100;
/// Change of the velocity, relative to it, at which the iterations end.
const CONVERGED: f64 = 1e-13;

/// Moreau-Jean time stepping with `theta = 1/2`.
///
/// ```text
/// v+ = v + h a(q + h/4 (v + v+), (v + v+)/2) + sum_i d_i p_i + e_i s_i
/// q_m = q + h/2 v,   q+ = q + h/2 (v + v+)
/// 0 <= p_i  _|_  n_i' v+ + restitution_i min(n_i' v, 0) >= 0
/// |s_i| <= mu_i p_i,   s_i v_t,i+ = -mu_i p_i |v_t,i+|,   v_t,i+ = b_i' v+
/// ```
///
/// for contacts with `g_i(q_m) <= 0`, with `n_i`, `d_i`, `b_i`, `e_i` at `q_m`; the others carry nothing.
///
/// Order 2 without contact, order 1 with impacts; in sustained contact on curved ground gaps of the size
/// of `h^2` open and close. Where friction admits no sustained force (Painleve), it takes the impulse that
/// stops the sliding. A contact with restitution that comes to rest does so after bounces that last a step.
/// It locates no events, so [`Simulation::events`] stays empty. Its error
/// is measured by runs of half and of three fifths of the steps, which cost as much again. To be compared with.
///
/// Source: Jean, *The non-smooth contact dynamics method* (1999); Acary, Brogliato, *Numerical Methods for
/// Nonsmooth Dynamical Systems* (2008), chapter 10; forces at the midpoint.
///
/// ```
/// use hangtime::baselines::Moreau;
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
/// let run = simulate(&ball).method(Moreau::default()).steps(400).run()?;
/// // The ball lies on the floor to the length of a step times its speed.
/// assert!(run.at(0.9)?["z"].abs() < 4.5 / 400.0 && run.events.is_empty());
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Moreau {
    /// Number of equal steps; default 1000.
    pub steps: usize,
    /// Acceleration `a_bar` of the auxiliary dynamics that the numerical time refers to
    /// \[unit of the gap / s^2\]; default `100 * 9.81`. An impulse `p` takes `p / a_bar`.
    pub auxiliary_acceleration: f64,
}

impl Default for Moreau {
    fn default() -> Self {
        Self {
            steps: 1000,
            auxiliary_acceleration: 981.0,
        }
    }
}

impl Simulator for Moreau {
    fn name(&self) -> &'static str {
        "moreau"
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
        InitialValueProblem::check_at_once(model, "Moreau's time stepping")?;
        let remedy = "simulate by finite elements or from event to event";
        InitialValueProblem::check_switches(model, "Moreau's time stepping", remedy)?;
        let others = OtherGrid::of_steps(self.steps, |steps| Self {
            steps,
            ..self.clone()
        });
        let run = |settings: &Self, watch: &mut Watch<'_>| {
            TimeStepping::new(settings, model, problem).run(watch)
        };
        let scene = (model, problem);
        let mut result = judged((self, others), "take more steps", scene, observer, run);
        result.notes.push(
            "time stepping locates no events; contact forces of the trajectory show where contact is"
                .into(),
        );
        closed.finish_without_events(&mut result);
        Ok(result)
    }

    fn set_steps(&mut self, steps: usize) -> Result<(), InputError> {
        self.steps = steps;
        Ok(())
    }
}

struct TimeStepping<'a> {
    settings: &'a Moreau,
    problem: &'a InitialValueProblem,
    dynamics: Dynamics<'a>,
    /// `(q, v)` at the start of the step, at the midpoint, at the end.
    start: Vec<f64>,
    middle: Vec<f64>,
    end: Vec<f64>,
    numerical_time: f64,
    forces: Vec<f64>,
    friction_forces: Vec<f64>,
    result: Simulation,
}

impl<'a> TimeStepping<'a> {
    fn new(settings: &'a Moreau, model: &'a dyn Model, problem: &'a InitialValueProblem) -> Self {
        let dynamics = Dynamics::new(model, settings.auxiliary_acceleration);
        let start = [&problem.q[..], &problem.v[..]].concat();
        Self {
            settings,
            problem,
            middle: start.clone(),
            end: start.clone(),
            start,
            numerical_time: 0.0,
            forces: vec![0.0; dynamics.contacts],
            friction_forces: vec![0.0; dynamics.contacts],
            result: dynamics.empty_result(),
            dynamics,
        }
    }

    fn run(mut self, watch: &mut Watch<'_>) -> Simulation {
        if let Err(status) = self.integrate(watch) {
            self.result.status = status;
        }
        self.result.counts.evaluations = self.dynamics.evaluations;
        self.result
    }

    fn integrate(&mut self, watch: &mut Watch<'_>) -> Result<(), SimulationStatus> {
        let n = self.dynamics.n;
        let h = self.problem.horizon / self.settings.steps as f64;
        self.dynamics.set_controls(&self.problem.controls, 0.0);
        self.record(0.0)?;
        for step in 0..self.settings.steps {
            let t = step as f64 * h;
            // Controls are those of the piece at the middle of the step: jumps are not located either.
            self.dynamics
                .set_controls(&self.problem.controls, t + 0.5 * h);
            self.step(t, h)?;
            if step == 0 {
                self.result.initial_modes = self.modes();
            }
            for k in 0..n {
                self.end[k] = self.start[k] + 0.5 * h * (self.start[n + k] + self.end[n + k]);
            }
            let time = if step + 1 == self.settings.steps {
                self.problem.horizon
            } else {
                t + h
            };
            if !motion::project_on_joints(&mut self.dynamics, time, &mut self.end) {
                let message = "the joints cannot be closed again; take more steps";
                let diagnosis = self.diagnosis(t, None, message.into());
                return Err(SimulationStatus::StepFailed(diagnosis));
            }
            self.start.copy_from_slice(&self.end);
            self.numerical_time += h;
            self.result.counts.elements += 1;
            self.record(time)?;
            let count = self.result.counts.elements;
            watch.reach(time, count, &mut self.result.trajectory)?;
        }
        Ok(())
    }

    /// Velocities at the end of the step, into `end`.
    fn step(&mut self, t: f64, h: f64) -> Result<(), SimulationStatus> {
        let n = self.dynamics.n;
        let middle = t + 0.5 * h;
        for k in 0..n {
            self.middle[k] = self.start[k] + 0.5 * h * self.start[n + k];
            self.middle[n + k] = self.start[n + k];
        }
        self.dynamics.load(middle, &self.middle);
        self.dynamics.choose_pieces();
        check_gaps(&self.dynamics, t, self.result.counts.elements)?;
        let closed = self.close();
        self.end.copy_from_slice(&self.start);
        for _ in 0..ITERATIONS {
            for k in 0..n {
                let velocity = 0.5 * (self.start[n + k] + self.end[n + k]);
                self.middle[k] = self.start[k] + 0.5 * h * velocity;
                self.middle[n + k] = velocity;
            }
            self.dynamics.load(middle, &self.middle);
            let (velocity, impulses) = self.strike(&closed, t, h)?;
            let moved = velocity
                .iter()
                .zip(&self.end[n..])
                .fold(0.0_f64, |s, (a, b)| s.max((a - b).abs()));
            self.end[n..].copy_from_slice(&velocity);
            if moved <= CONVERGED * largest(&velocity).max(1.0) {
                self.keep_forces(&closed, &impulses, h);
                return Ok(());
            }
        }
        let message =
            format!("the midpoint rule does not converge with steps of {h:.1e} s; take more steps");
        let diagnosis = self.diagnosis(t, closed.first(), message);
        Err(SimulationStatus::StepFailed(diagnosis))
    }

    /// The velocity at the end of a step of length `h` from `t`, by the forces at the state that is loaded and the impulses
    /// of the `closed` contacts.
    fn strike(
        &mut self,
        closed: &[usize],
        t: f64,
        h: f64,
    ) -> Result<(Vec<f64>, Balance), SimulationStatus> {
        let n = self.dynamics.n;
        self.dynamics.evaluate_free_acceleration();
        let change: Vec<f64> = self
            .dynamics
            .free_acceleration()
            .iter()
            .map(|a| h * a)
            .collect();
        let touching = Touching::new(&self.dynamics, closed, |_| true);
        let offsets = touching.lines.iter();
        let offsets: Vec<f64> = offsets.map(|&line| self.offset(line, &change, h)).collect();
        if change.iter().chain(&offsets).any(|v| !v.is_finite()) {
            return Err(self.not_finite(t, closed.first()));
        }
        let problem = ContactProblem {
            what: "impulse",
            touching,
            offsets,
        };
        let impulses = problem.solve(&self.dynamics).map_err(|message| {
            SimulationStatus::StepFailed(self.diagnosis(t, closed.first(), message))
        })?;
        let mut jump = vec![0.0; n];
        impulses.push(&self.dynamics, &impulses.forces, &mut jump);
        let velocity: Vec<f64> = self.start[n..]
            .iter()
            .zip(&change)
            .zip(jump)
            .map(|((v, free), contact)| v + free + contact)
            .collect();
        if velocity.iter().any(|v| !v.is_finite()) {
            return Err(self.not_finite(t, closed.first()));
        }
        Ok((velocity, impulses))
    }

    /// Keeps what the impulses of a step of length `h` are as forces, and the numerical time that they take.
    fn keep_forces(&mut self, closed: &[usize], impulses: &Balance, h: f64) {
        self.forces.fill(0.0);
        self.friction_forces.fill(0.0);
        for (slot, &i) in closed.iter().enumerate() {
            let inertia = self.dynamics.point(i)[contact_point::INVERSE_INERTIA];
            self.forces[i] = impulses.forces[slot] / (h * inertia);
            let share = friction_share(self.dynamics.model, i, self.dynamics.input());
            let friction = impulses.friction(slot);
            let friction = match self.dynamics.is_in_space(i) {
                true => pair_size(friction),
                false => friction.0,
            };
            self.friction_forces[i] = share * friction / (h * inertia);
        }
        let surfaces = closed.iter().filter(|&&i| !self.dynamics.is_dry(i));
        let jumps = largest(&impulses.forces[..surfaces.count()]);
        self.numerical_time += jumps / self.settings.auxiliary_acceleration;
    }

    fn diagnosis(&self, time: f64, contact: Option<&usize>, message: String) -> Diagnosis {
        Diagnosis {
            time,
            step: self.result.counts.elements,
            contact: contact.copied(),
            message,
        }
    }

    fn not_finite(&self, time: f64, contact: Option<&usize>) -> SimulationStatus {
        let message = "a velocity is not a finite number; check roots and divisions of the scene";
        SimulationStatus::NotFinite(self.diagnosis(time, contact, message.into()))
    }

    /// What the impulses of the last step say about each contact.
    fn modes(&self) -> Vec<ContactMode> {
        let forces = self.forces.iter().zip(&self.friction_forces).enumerate();
        let mode = |(i, (&normal, &tangential)): (usize, (&f64, &f64))| {
            let mu = self.dynamics.friction(i);
            if normal <= 0.0 {
                ContactMode::Open
            } else if mu == 0.0 {
                ContactMode::Frictionless
            } else if tangential.abs() < (1.0 - yardstick::NOTHING) * mu * normal {
                ContactMode::Stick
            } else if self.dynamics.is_in_space(i) {
                ContactMode::Slip(Direction::Forward)
            } else {
                ContactMode::Slip(Direction::of(-tangential))
            }
        };
        forces.map(mode).collect()
    }

    /// The contacts that are closed at the middle of the step, evaluated there with the velocities at the start.
    fn close(&mut self) -> Vec<usize> {
        let closed: Vec<usize> = (0..self.dynamics.contacts)
            .filter(|&i| self.dynamics.gap(i) <= 0.0 && !self.dynamics.pieces.is_idle(i))
            .collect();
        for &i in &closed {
            self.dynamics.evaluate_sides(i);
        }
        closed
    }

    /// Velocity `n' v+ + restitution min(n' v, 0)` or `v_t+` of a line that a change of the velocity without impulses gives. The
    /// impulse of dry friction is given, `p = h r`.
    fn offset(&self, line: Line, change: &[f64], h: f64) -> f64 {
        let dynamics = &self.dynamics;
        let before = dynamics.velocity(line);
        match line {
            Line::Normal { contact, .. } if dynamics.is_dry(contact) => {
                h * dynamics.point(contact)[contact_point::CURVATURE]
            }
            Line::Normal { contact, .. } => {
                let returned = dynamics.laws.restitution[contact] * before.min(0.0);
                before + dot(dynamics.normal(contact), change) + returned
            }
            _ => before + dot(dynamics.row(line).0, change),
        }
    }

    fn record(&mut self, time: f64) -> Result<(), SimulationStatus> {
        let n = self.dynamics.n;
        self.dynamics.write_controls(time);
        self.result.trajectory.push(
            time,
            self.numerical_time,
            &self.start[..n],
            &self.start[n..],
            &self.dynamics.u,
            &self.forces,
        );
        if self.dynamics.laws.declares_friction {
            let forces = self.friction_forces.clone();
            self.result.trajectory.friction_force.push(forces);
        }
        self.dynamics.load(time, &self.start);
        self.dynamics.choose_pieces();
        for i in 0..self.dynamics.contacts {
            let penetration = -self.dynamics.gap(i);
            self.result.residuals.dual = self.result.residuals.dual.max(penetration);
        }
        check_gaps(&self.dynamics, time, self.result.counts.elements)
    }
}
