//! The time-freezing system with smoothed step functions, integrated as an ordinary differential
//! equation in numerical time.

use super::shared::{check, check_gaps, judged};
use crate::Observer;
use crate::model::{Model, contact_point};
use crate::refusal;
use crate::simulation::event::dop853::{Dop853, System};
use crate::simulation::event::dynamics::Dynamics;
use crate::simulation::joints::{self, Closed};
use crate::simulation::other_grid::OtherGrid;
use crate::simulation::watch::Watch;
use crate::simulation::{
    ContactMode, ControlSignal, Diagnosis, Direction, InitialValueProblem, InputError, Simulation,
    SimulationStatus, Simulator,
};

/// Steps shorter than this share of the horizon fail.
const SHORTEST: f64 = 1e-14;
/// Share of the horizon by which to look ahead for the gap that is no number.
const MOMENT: f64 = 1e-9;
/// Points of the trajectory that are kept for each horizon; the steps are many more.
const POINTS: f64 = 2000.0;
/// Tolerance of the run to compare with, relative to that of the run that is returned.
const LOOSER: f64 = 10.0;
/// Newton steps on the length of the last step.
const LANDINGS: usize = 50;

/// The time-freezing system with the step functions smoothed over a width, in numerical time `tau`:
///
/// ```text
/// q' = p v,   v' = p a + sum_i gamma_i a_bar d_i,   t' = p,        p = prod_i (1 - gamma_i)
/// gamma_i = H(-g_i) H(-v_n,i),   H(x) = (1 + tanh(x / width)) / 2
/// ```
///
/// and `v' = p (a - sum_i e_i r_i tanh(v_t,i / width)) + ...` with dry friction of the given normal acceleration `r_i`,
/// by DOP853 with step size control; it ends where the physical clock `t` reaches the horizon. The error
/// is proportional to the width (a body at rest hovers some widths above the ground), the number of
/// steps to its inverse, because contact becomes stiff like `a_bar / width`. There are no events. The error
/// is measured by a run of twice the width and ten times the tolerance, which costs about half as much again. To be compared with.
///
/// Source of the system: Nurkanovic, Albrecht, Brogliato, Diehl, *The time-freezing reformulation for
/// numerical optimal control of complementarity Lagrangian systems with state jumps*, Automatica 158
/// (2023) 111295.
///
/// ```
/// use hangtime::baselines::Smooth;
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
/// let run = simulate(&ball).method(Smooth::default()).run()?;
/// // The ball hovers within some widths of the floor.
/// assert!(run.at(0.9)?["z"].abs() < 10.0 * Smooth::default().width);
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Smooth {
    /// Width of the step functions, for gaps \[unit of the gap\] and normal velocities
    /// \[unit of the gap / s\]; default `1e-3`.
    pub width: f64,
    /// Error per step, absolute and relative; default `1e-6`.
    pub tolerance: f64,
    /// Acceleration `a_bar` of the auxiliary dynamics \[unit of the gap / s^2\]; default `100 * 9.81`.
    pub auxiliary_acceleration: f64,
    /// Largest number of accepted and rejected steps; default 10 000 000.
    pub max_steps: usize,
}

impl Default for Smooth {
    fn default() -> Self {
        Self {
            width: 1e-3,
            tolerance: 1e-6,
            auxiliary_acceleration: 981.0,
            max_steps: 10_000_000,
        }
    }
}

impl Simulator for Smooth {
    fn name(&self) -> &'static str {
        "smooth"
    }

    fn simulate(
        &self,
        model: &dyn Model,
        problem: &InitialValueProblem,
        observer: &mut Observer<'_>,
    ) -> Result<Simulation, InputError> {
        check(self.max_steps, self.auxiliary_acceleration)?;
        for (what, value, bound) in [
            ("width of the step functions", self.width, "above 0"),
            ("tolerance", self.tolerance, "in 1e-14..=1e-2"),
        ] {
            let inside = value > 0.0 && (what != "tolerance" || (1e-14..=1e-2).contains(&value));
            if !inside || !value.is_finite() {
                return Err(refusal::out_of_range(what, value, "", bound));
            }
        }
        joints::refuse(model, "smoothed steps", joints::LOCATED)?;
        let closed = Closed::of(model, problem)?;
        InitialValueProblem::check_inelastic(model, self.name())?;
        InitialValueProblem::check_friction(
            model,
            "smoothed steps",
            "simulate by finite elements or from event to event",
        )?;
        InitialValueProblem::check_at_once(model, "smoothed steps")?;
        InitialValueProblem::check_resets(model, "smoothed steps", joints::LOCATED)?;
        let other = OtherGrid {
            method: Self {
                width: 2.0 * self.width,
                tolerance: LOOSER * self.tolerance,
                ..self.clone()
            },
            words: "twice the width and a looser tolerance",
        };
        let mut result = judged(
            (self, [other]),
            "narrow the step functions, and lower the tolerance",
            (model, problem),
            observer,
            |settings, watch| run(settings, (model, problem), watch),
        );
        closed.finish_without_events(&mut result);
        Ok(result)
    }

    fn set_tolerance(&mut self, tolerance: f64) -> Result<(), InputError> {
        self.tolerance = tolerance;
        Ok(())
    }
}

/// The smoothed system in the state `(q, v, t)`.
struct SmoothSystem<'a> {
    dynamics: Dynamics<'a>,
    controls: &'a ControlSignal,
    width: f64,
    auxiliary_acceleration: f64,
    /// `gamma_i / p a_bar`, the normal contact accelerations in physical time, at the last evaluation.
    contact_accelerations: Vec<f64>,
    /// Those of dry friction, 0 for surfaces.
    friction_accelerations: Vec<f64>,
}

impl<'a> SmoothSystem<'a> {
    fn new(settings: &Smooth, model: &'a dyn Model, problem: &'a InitialValueProblem) -> Self {
        let dynamics = Dynamics::new(model, settings.auxiliary_acceleration);
        Self {
            contact_accelerations: vec![0.0; dynamics.contacts],
            friction_accelerations: vec![0.0; dynamics.contacts],
            dynamics,
            controls: &problem.controls,
            width: settings.width,
            auxiliary_acceleration: settings.auxiliary_acceleration,
        }
    }

    /// Contacts within the width of the step functions are closed, at the state just evaluated.
    fn modes(&self) -> Vec<ContactMode> {
        let mode = |i| {
            if self.dynamics.is_dry(i) {
                let velocity = self.dynamics.sliding_velocity(i);
                return if velocity.abs() <= self.width {
                    ContactMode::Stick
                } else {
                    ContactMode::Slip(Direction::of(velocity))
                };
            }
            let point = self.dynamics.point(i);
            let rests = point[contact_point::NORMAL_VELOCITY].abs() <= self.width;
            let acts = !self.dynamics.pieces.is_idle(i);
            if acts && point[contact_point::GAP] <= self.width && rests {
                ContactMode::Frictionless
            } else {
                ContactMode::Open
            }
        };
        (0..self.dynamics.contacts).map(mode).collect()
    }

    /// `H(-x)`.
    fn below(&self, x: f64) -> f64 {
        0.5 * (1.0 - (x / self.width).tanh())
    }
}

impl System for SmoothSystem<'_> {
    fn derivative(&mut self, _numerical_time: f64, y: &[f64], dy: &mut [f64]) {
        let n = self.dynamics.n;
        let time = y[2 * n];
        self.dynamics.set_controls(self.controls, time);
        self.dynamics.load(time, y);
        self.dynamics.choose_pieces();
        self.dynamics.evaluate_free_acceleration();
        let mut free = 1.0;
        for i in 0..self.dynamics.surfaces {
            self.dynamics.evaluate_contact(i);
            if self.dynamics.pieces.is_idle(i) {
                self.contact_accelerations[i] = 0.0;
                continue;
            }
            let point = self.dynamics.point(i);
            let gamma = self.below(point[contact_point::GAP])
                * self.below(point[contact_point::NORMAL_VELOCITY]);
            free *= 1.0 - gamma;
            self.contact_accelerations[i] = gamma * self.auxiliary_acceleration;
        }
        for k in 0..n {
            dy[k] = free * y[n + k];
            dy[n + k] = free * self.dynamics.free_acceleration()[k];
        }
        for i in self.dynamics.surfaces..self.dynamics.contacts {
            self.dynamics.evaluate_sides(i);
            let pressed = -self.dynamics.point(i)[contact_point::CURVATURE];
            let slip = (self.dynamics.sliding_velocity(i) / self.width).tanh();
            let friction = -pressed * slip;
            for (dv, e) in dy[n..2 * n]
                .iter_mut()
                .zip(self.dynamics.friction_direction(i))
            {
                *dv += free * e * friction;
            }
            self.contact_accelerations[i] = pressed;
            self.friction_accelerations[i] = friction;
        }
        for i in 0..self.dynamics.surfaces {
            for (dv, d) in dy[n..2 * n].iter_mut().zip(self.dynamics.direction(i)) {
                *dv += d * self.contact_accelerations[i];
            }
            self.contact_accelerations[i] /= free;
        }
        dy[2 * n] = free;
    }
}

/// Runs to the horizon, or until it fails.
fn run(
    settings: &Smooth,
    (model, problem): (&dyn Model, &InitialValueProblem),
    watch: &mut Watch<'_>,
) -> Simulation {
    let mut system = SmoothSystem::new(settings, model, problem);
    let mut result = system.dynamics.empty_result();
    result.notes.push(
        "smoothed switches have no instant, so there are no events; contact forces fade in and out"
            .into(),
    );
    if let Err(status) = integrate(settings, problem, &mut system, &mut result, watch) {
        result.status = status;
    }
    result.counts.evaluations = system.dynamics.evaluations;
    result
}

fn failure(step: usize, time: f64, message: String) -> Diagnosis {
    Diagnosis {
        time,
        step,
        contact: None,
        message,
    }
}

/// Why no step leads on from `y`: a gap, or else the state, is not finite a moment later.
fn not_finite(
    system: &mut SmoothSystem<'_>,
    step: usize,
    y: &[f64],
    horizon: f64,
) -> SimulationStatus {
    let n = system.dynamics.n;
    let time = y[2 * n];
    let mut ahead = y.to_vec();
    for k in 0..n {
        ahead[k] += MOMENT * horizon * y[n + k];
    }
    system.dynamics.load(time, &ahead);
    if let Err(status) = check_gaps(&system.dynamics, time, step) {
        return status;
    }
    let message = "the state a moment later is not finite; check roots, divisions and parameters of the scene";
    SimulationStatus::NotFinite(failure(step, time, message.into()))
}

fn integrate(
    settings: &Smooth,
    problem: &InitialValueProblem,
    system: &mut SmoothSystem<'_>,
    result: &mut Simulation,
    watch: &mut Watch<'_>,
) -> Result<(), SimulationStatus> {
    let n = system.dynamics.n;
    let horizon = problem.horizon;
    let mut y = [&problem.q[..], &problem.v[..], &[0.0]].concat();
    let mut method = Dop853::new(y.len(), 2 * n + 1);
    let mut numerical_time = 0.0;
    method.begin(system, numerical_time, &y);
    result.initial_modes = system.modes();
    record(system, result, numerical_time, &y);
    let mut recorded = 0.0;
    let mut h = method.initial_size(system, 0.0, &y, horizon / 16.0, settings.tolerance);
    for _ in 0..settings.max_steps {
        method.step(system, numerical_time, &y, h);
        let error = method.error(h, |k, end: f64| {
            settings.tolerance * (1.0 + end.abs().max(y[k].abs()))
        });
        if error > 1.0 || error.is_nan() {
            h = Dop853::smaller_size(h, error);
            if h <= SHORTEST * horizon {
                let step = result.counts.elements;
                return Err(if error.is_finite() {
                    let message = format!(
                        "steps of {h:.1e} s do not meet the tolerance {:e}; widen the step functions",
                        settings.tolerance
                    );
                    SimulationStatus::StepFailed(failure(step, y[2 * n], message))
                } else {
                    not_finite(system, step, &y, horizon)
                });
            }
            continue;
        }
        let lands = method.end()[2 * n] >= horizon;
        let length = if lands {
            land(system, &mut method, numerical_time, &y, h, horizon)
        } else {
            h
        };
        method.finish(system, numerical_time, length);
        numerical_time += length;
        y.copy_from_slice(method.end());
        if lands {
            y[2 * n] = horizon;
        }
        method.advance();
        h = method.next_size(h, error);
        result.counts.elements += 1;
        let time = y[2 * n];
        if lands || time - recorded >= horizon / POINTS {
            record(system, result, numerical_time, &y);
            recorded = time;
        }
        watch.reach(time, result.counts.elements, &mut result.trajectory)?;
        if lands {
            return Ok(());
        }
    }
    Err(SimulationStatus::StepLimit(failure(
        result.counts.elements,
        y[2 * n],
        format!(
            "{} steps taken; widen the step functions or raise the limit",
            settings.max_steps
        ),
    )))
}

/// Shortens the step of length `h` just made so that the clock reads `horizon` at its end; its length. The clock never
/// runs backwards: Newton steps on the length, from above.
fn land(
    system: &mut SmoothSystem<'_>,
    method: &mut Dop853,
    numerical_time: f64,
    y: &[f64],
    h: f64,
    horizon: f64,
) -> f64 {
    let clock = y.len() - 1;
    let mut length = h;
    for _ in 0..LANDINGS {
        let late = method.end()[clock] - horizon;
        if late.abs() <= f64::EPSILON * horizon {
            break;
        }
        method.finish(system, numerical_time, length);
        let speed = method.end_slope()[clock].max(f64::MIN_POSITIVE);
        length = (length - late / speed).clamp(0.0, h);
        method.step(system, numerical_time, y, length);
    }
    length
}

/// Appends the state just evaluated.
fn record(system: &SmoothSystem<'_>, result: &mut Simulation, numerical_time: f64, y: &[f64]) {
    let n = system.dynamics.n;
    let of_accelerations = |accelerations: &[f64]| -> Vec<f64> {
        let forces = accelerations.iter().enumerate();
        forces
            .map(|(i, a)| a / system.dynamics.point(i)[contact_point::INVERSE_INERTIA])
            .collect()
    };
    let forces = of_accelerations(&system.contact_accelerations);
    if system.dynamics.laws.declares_friction {
        let frictions = of_accelerations(&system.friction_accelerations);
        result.trajectory.friction_force.push(frictions);
    }
    for i in 0..system.dynamics.contacts {
        let penetration = -system.dynamics.point(i)[contact_point::GAP];
        result.residuals.dual = result.residuals.dual.max(penetration);
    }
    result.trajectory.push(
        y[2 * n],
        numerical_time,
        &y[..n],
        &y[n..2 * n],
        &system.dynamics.u,
        &forces,
    );
}
