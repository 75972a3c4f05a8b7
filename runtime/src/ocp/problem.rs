//! The optimal control problem, and the checks that come before it is solved.

use crate::model::{Model, contact_point};
use crate::simulation::{ControlSignal, InitialValueProblem, InputError};

/// Most control intervals: the programs are kept in memory.
const MOST_INTERVALS: usize = 10_000;
/// Normal velocity into a surface that rounding may cause at the start.
const AT_REST: f64 = 1e-9;

/// An optimal control problem on a [`Model`]:
///
/// ```text
/// min  w_T T + w_u int_0^T u'u dt + sum w q(T) + sum w v(T)
/// s.t. the motion of the model from (q, v), with impacts,
///      coordinates and controls within Model::bounds at all times,
///      the goals at T
/// ```
///
/// The controls are constant on `intervals` intervals of equal physical length `T / intervals`.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Initial coordinates, length `n_q`.
    pub q: Vec<f64>,
    /// Initial velocities, length `n_q`.
    pub v: Vec<f64>,
    /// Length of the motion.
    pub horizon: Horizon,
    /// What to minimize.
    pub objective: Objective,
    /// What has to hold at the end.
    pub goals: Vec<Goal>,
    /// Number of control intervals, 1 to 10 000.
    pub intervals: usize,
}

/// Length of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Horizon {
    /// Given \[s\].
    Fixed(f64),
    /// To be found; the solver makes its own guess if none is given \[s\].
    Free {
        /// Where to start, if known.
        guess: Option<f64>,
    },
}

/// Weights of the objective; everything that is not named has the weight 0.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Objective {
    /// Weight of the final time.
    pub final_time: f64,
    /// Weight of the control effort `int u'u dt`, at least 0.
    pub control_effort: f64,
    /// (index, weight) of coordinates at the end.
    pub final_coordinates: Vec<(usize, f64)>,
    /// (index, weight) of velocities at the end.
    pub final_velocities: Vec<(usize, f64)>,
}

impl Objective {
    /// Least final time.
    #[must_use]
    pub fn time() -> Self {
        Self {
            final_time: 1.0,
            ..Self::default()
        }
    }

    /// Least control effort `int u'u dt`.
    #[must_use]
    pub fn effort() -> Self {
        Self {
            control_effort: 1.0,
            ..Self::default()
        }
    }
}

/// A component of the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    /// Coordinate with this index.
    Coordinate(usize),
    /// Velocity of the coordinate with this index.
    Velocity(usize),
}

/// A terminal condition `component(T) = value`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Which component of the state.
    pub component: Component,
    /// Its value at the end, in the unit of the coordinate (per second).
    pub value: f64,
}

impl Problem {
    /// The problem that starts where the scene starts, with free final time.
    #[must_use]
    pub fn of(model: &dyn Model, objective: Objective, goals: Vec<Goal>, intervals: usize) -> Self {
        let n = model.declaration().coordinates.len();
        let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
        model.start(&mut q, &mut v);
        Self {
            q,
            v,
            horizon: Horizon::Free { guess: None },
            objective,
            goals,
            intervals,
        }
    }

    /// Checks everything that can be known beforehand.
    ///
    /// # Errors
    /// The first [`InputError`] found, with the name of what is wrong, its value and its bound.
    pub fn check(&self, model: &dyn Model) -> Result<(), InputError> {
        let declaration = model.declaration();
        let refuse = |what: String, value: f64, unit: &str, bound: &str| {
            Err(InputError::OutOfRange {
                what,
                value,
                unit: unit.into(),
                bound: bound.into(),
            })
        };
        if declaration.explicit_time {
            return refuse(
                "explicit time in the model".into(),
                1.0,
                "",
                "absent: optimal control treats autonomous models",
            );
        }
        if !(1..=MOST_INTERVALS).contains(&self.intervals) {
            return refuse(
                "number of control intervals".into(),
                self.intervals as f64,
                "",
                &format!("in 1..={MOST_INTERVALS}"),
            );
        }
        let horizon = match self.horizon {
            Horizon::Fixed(horizon) => horizon,
            Horizon::Free { guess } => guess.unwrap_or(1.0),
        };
        self.initial_value_problem(horizon, ControlSignal::Zero)
            .check(model)?;
        InitialValueProblem::check_inelastic(model, "optimal control")?;
        let n = declaration.coordinates.len();
        let objective = &self.objective;
        let finals = objective.final_coordinates.iter();
        let finals = finals.chain(&objective.final_velocities);
        let goals = self.goals.iter().map(|goal| goal.component.index());
        if let Some(index) = finals.map(|f| f.0).chain(goals).find(|&index| index >= n) {
            return refuse(
                "index of a coordinate in objective or goal".into(),
                index as f64,
                "",
                &format!("below {n}, the number of coordinates"),
            );
        }
        if objective.control_effort < 0.0 {
            return refuse(
                "weight of the control effort".into(),
                objective.control_effort,
                "",
                "at least 0",
            );
        }
        let (lower, upper) = bounds(model);
        for (k, known) in declaration.coordinates.iter().enumerate() {
            if !(lower[k]..=upper[k]).contains(&self.q[k]) {
                return refuse(
                    format!("initial `{}`", known.name),
                    self.q[k],
                    known.unit,
                    &format!("within its bounds {}..={}", lower[k], upper[k]),
                );
            }
        }
        for (i, contact) in declaration.contacts.iter().enumerate() {
            let input = self
                .initial_value_problem(1.0, ControlSignal::Zero)
                .input(model);
            let mut point = vec![0.0; contact_point::length(n)];
            model.contact(i, &input, &mut point);
            let velocity = point[contact_point::NORMAL_VELOCITY];
            if point[contact_point::GAP] <= 0.0 && velocity < -AT_REST {
                return refuse(
                    format!("initial normal velocity of `{}`", contact.name),
                    velocity,
                    &format!("{}/s", contact.unit),
                    "at least 0 on the surface: start after the impact",
                );
            }
        }
        for goal in &self.goals {
            let k = goal.component.index();
            if !goal.value.is_finite() {
                return Err(InputError::NotFinite {
                    what: format!("goal of `{}`", declaration.coordinates[k].name),
                    value: goal.value,
                });
            }
            if goal.component == Component::Coordinate(k)
                && !(lower[k]..=upper[k]).contains(&goal.value)
            {
                return refuse(
                    format!("goal of `{}`", declaration.coordinates[k].name),
                    goal.value,
                    declaration.coordinates[k].unit,
                    &format!("within its bounds {}..={}", lower[k], upper[k]),
                );
            }
        }
        Ok(())
    }

    /// The motion under given controls.
    pub(super) fn initial_value_problem(
        &self,
        horizon: f64,
        controls: ControlSignal,
    ) -> InitialValueProblem {
        InitialValueProblem {
            q: self.q.clone(),
            v: self.v.clone(),
            horizon,
            controls,
        }
    }

    /// Goal of a coordinate, if it has one.
    pub(super) fn goal(&self, component: Component) -> Option<f64> {
        let goal = self.goals.iter().find(|goal| goal.component == component);
        goal.map(|goal| goal.value)
    }

    /// A guess of the horizon \[s\]: the longest distance to a goal at the speed of the start, or else the
    /// horizon of the scene, or else 1 s.
    pub(super) fn horizon_guess(&self, model: &dyn Model) -> f64 {
        match self.horizon {
            Horizon::Fixed(horizon)
            | Horizon::Free {
                guess: Some(horizon),
            } => horizon,
            Horizon::Free { guess: None } => {
                let times = self.goals.iter().filter_map(|goal| match goal.component {
                    Component::Coordinate(k) => Some((goal.value - self.q[k]) / self.v[k]),
                    Component::Velocity(_) => None,
                });
                let longest = times.filter(|t| t.is_finite() && *t > 0.0).reduce(f64::max);
                longest.or_else(|| model.horizon()).unwrap_or(1.0)
            }
        }
    }
}

impl Component {
    /// Index of the coordinate.
    pub(super) fn index(self) -> usize {
        match self {
            Self::Coordinate(index) | Self::Velocity(index) => index,
        }
    }
}

/// Declared bounds, coordinates first.
pub(super) fn bounds(model: &dyn Model) -> (Vec<f64>, Vec<f64>) {
    let declaration = model.declaration();
    let length = declaration.coordinates.len() + declaration.controls.len();
    let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; length], vec![f64::INFINITY; length]);
    model.bounds(&mut lower, &mut upper);
    (lower, upper)
}
