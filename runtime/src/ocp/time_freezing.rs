//! The optimal control problem as one complementarity problem: time-freezing and FESD.

use super::problem::{Component, Horizon, Problem, bounds};
use crate::dcs::HeavisideSystem;
use crate::fesd::finite_element::State;
use crate::fesd::transcription::{Controls, Guess, Task, Transcription, Weights};
use crate::model::Model;
use crate::mpcc::Mpcc;
use crate::nlp::NlpProblem;
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::InputError;
use crate::time_freezing::TimeFreezingSystem;

/// Shortest and longest horizon relative to the guess, where it is free.
const HORIZONS: (f64, f64) = (0.05, 20.0);

/// How a problem is transcribed; change fields of [`TimeFreezingSettings::default`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TimeFreezingSettings {
    /// Runge-Kutta scheme; default Radau IIA.
    pub scheme: Scheme,
    /// Its stages; default 2, in `1..=9`.
    pub stages: usize,
    /// Finite elements of a control interval; default 3, at least 1. One more than the switches that an
    /// interval should be able to hold; a touchdown is two (the jump has a beginning and an end).
    pub elements: usize,
    /// Acceleration `a_bar` of the auxiliary dynamics \[unit of the gap / s^2\]; default 20, > 0. Of the
    /// order of the contact accelerations, so that the step functions stay away from 0 and 1.
    pub auxiliary_acceleration: f64,
}

impl Default for TimeFreezingSettings {
    fn default() -> Self {
        Self {
            scheme: Scheme::RadauIia,
            stages: 2,
            elements: 3,
            auxiliary_acceleration: 20.0,
        }
    }
}

/// An optimal control problem on a [`Model`] as a mathematical program with complementarity constraints:
/// the time-freezing system, transcribed by finite elements with switch detection in step form. Solve it
/// with [`mpcc::solve`](crate::mpcc::solve).
///
/// Bounds of coordinates are imposed at the ends of the finite elements, bounds of controls everywhere.
/// The starting point is made from the problem alone: coordinates with a goal move to it at constant speed,
/// the others rest; without goals, it is a coarse simulation. Controls start at zero, or as
/// near to it as their bounds allow.
///
/// Sources: Nurkanovic, Albrecht, Brogliato, Diehl, Automatica 158 (2023) 111295 (time-freezing);
/// Nurkanovic, Sperl, Albrecht, Diehl, Numerische Mathematik 2024 (finite elements).
pub struct TimeFreezing<'a> {
    transcription: Transcription<'a>,
    intervals: usize,
}

/// One motion out of a [`TimeFreezing`] program.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TimeFreezingMotion {
    /// Length \[s\].
    pub horizon: f64,
    /// Controls of each interval.
    pub controls: Vec<Vec<f64>>,
    /// Physical time at the end of each element \[s\].
    pub time: Vec<f64>,
    /// Coordinates there.
    pub q: Vec<Vec<f64>>,
    /// Velocities there.
    pub v: Vec<Vec<f64>>,
    /// Mean step function of each contact in each element: 1 free, 0 jump, between in sustained contact.
    pub step_functions: Vec<Vec<f64>>,
    /// Length of each element in numerical time \[s\].
    pub numerical_lengths: Vec<f64>,
}

impl<'a> TimeFreezing<'a> {
    /// Transcribes a problem.
    ///
    /// # Errors
    /// [`InputError`] if the problem or the settings are refused.
    pub fn new(
        model: &'a dyn Model,
        problem: &Problem,
        settings: &TimeFreezingSettings,
    ) -> Result<Self, InputError> {
        problem.check(model)?;
        let refuse = |what: &str, value: f64, bound: String| {
            Err(InputError::OutOfRange {
                what: what.into(),
                value,
                unit: String::new(),
                bound,
            })
        };
        if settings.elements == 0 {
            return refuse("finite elements of an interval", 0.0, "at least 1".into());
        }
        let a_bar = settings.auxiliary_acceleration;
        if !(a_bar > 0.0 && a_bar.is_finite()) {
            return refuse("auxiliary acceleration", a_bar, "above 0".into());
        }
        let Some(tableau) = ButcherTableau::new(settings.scheme, settings.stages) else {
            return refuse(
                "Runge-Kutta stages",
                settings.stages as f64,
                format!("in 1..={}", ButcherTableau::MAX_STAGES),
            );
        };
        let system = TimeFreezingSystem::new(model, a_bar);
        let task = task(model, problem, settings.elements);
        Ok(Self {
            transcription: Transcription::new(HeavisideSystem::new(system), &tableau, task),
            intervals: problem.intervals,
        })
    }

    /// The motion at the point `x` of the program.
    #[must_use]
    pub fn motion(&self, x: &[f64]) -> TimeFreezingMotion {
        let program = &self.transcription;
        let elements = 0..program.elements();
        let states: Vec<State> = elements.clone().map(|e| program.state(x, e)).collect();
        TimeFreezingMotion {
            horizon: program.horizon(x),
            controls: (0..self.intervals)
                .map(|k| program.controls(x, k))
                .collect(),
            time: states.iter().map(|state| state.time).collect(),
            step_functions: elements
                .clone()
                .map(|e| {
                    (0..program.contacts())
                        .map(|i| program.mean_alpha(x, e, i))
                        .collect()
                })
                .collect(),
            numerical_lengths: elements.map(|e| program.numerical_length(x, e)).collect(),
            q: states.iter().map(|state| state.q.clone()).collect(),
            v: states.into_iter().map(|state| state.v).collect(),
        }
    }
}

/// The problem in plain numbers.
fn task(model: &dyn Model, problem: &Problem, elements: usize) -> Task {
    let n = problem.q.len();
    let (lower, upper) = bounds(model);
    let horizon = problem.horizon_guess(model);
    let controls = if lower.len() == n {
        Controls::Fixed(Vec::new())
    } else {
        Controls::Free {
            guess: (n..lower.len())
                .map(|k| 0.0_f64.clamp(lower[k], upper[k]))
                .collect(),
            lower: lower[n..].to_vec(),
            upper: upper[n..].to_vec(),
        }
    };
    let goals = problem.goals.iter().map(|goal| match goal.component {
        Component::Coordinate(k) => (k, goal.value),
        Component::Velocity(k) => (n + k, goal.value),
    });
    let goals: Vec<(usize, f64)> = goals.collect();
    let guess = if goals.is_empty() {
        Guess::Simulated
    } else {
        let goal = |k| problem.goal(Component::Coordinate(k));
        let velocity = (0..n).map(|k| goal(k).map_or(0.0, |goal| (goal - problem.q[k]) / horizon));
        Guess::Line(velocity.collect())
    };
    let objective = &problem.objective;
    let velocities = objective.final_velocities.iter();
    let velocities = velocities.map(|&(k, weight)| (n + k, weight));
    Task {
        start: State {
            time: 0.0,
            q: problem.q.clone(),
            v: problem.v.clone(),
        },
        horizon,
        horizon_bounds: match problem.horizon {
            Horizon::Fixed(_) => None,
            Horizon::Free { .. } => Some((HORIZONS.0 * horizon, HORIZONS.1 * horizon)),
        },
        controls,
        intervals: problem.intervals,
        elements,
        coordinate_bounds: (lower[..n].to_vec(), upper[..n].to_vec()),
        goals,
        objective: Weights {
            final_time: objective.final_time,
            control_effort: objective.control_effort,
            final_state: objective
                .final_coordinates
                .iter()
                .copied()
                .chain(velocities)
                .collect(),
        },
        guess,
    }
}

impl NlpProblem for TimeFreezing<'_> {
    fn variables(&self) -> usize {
        self.transcription.variables()
    }

    fn constraints(&self) -> usize {
        self.transcription.constraints()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.transcription.variable_bounds(lower, upper);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.transcription.constraint_bounds(lower, upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        self.transcription.initial_point(x);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        self.transcription.objective(x)
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.transcription.gradient(x, gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.transcription.constraint_values(x, c);
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.transcription.jacobian_pattern()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        self.transcription.jacobian_values(x, values);
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.transcription.hessian_pattern()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        self.transcription
            .hessian_values(x, weight, multipliers, values);
    }
}

impl Mpcc for TimeFreezing<'_> {
    fn complementarities(&self) -> &[(usize, usize)] {
        self.transcription.complementarities()
    }

    fn vanishing_sides(&self, x: &[f64], vanishes: &mut [bool]) -> bool {
        self.transcription.vanishing_sides(x, vanishes)
    }
}
