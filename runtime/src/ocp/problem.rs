//! The optimal control problem, and the checks that come before it is solved.

use crate::model::{Model, OptimalControlDeclaration, contact_point};
use crate::simulation::{ControlSignal, InitialValueProblem, InputError};

/// Most control intervals: the programs are kept in memory.
const MOST_INTERVALS: usize = 10_000;

/// Normal velocity into a surface that rounding may cause at the start.
const AT_REST: f64 = 1e-9;

/// An optimal control problem on a [`Model`]:
///
/// ```text
/// min  phi(q, v, T) + int_0^T L(q, v, u) dt + w_T T + w_u int_0^T u'u dt + sum w q(T) + sum w v(T)
/// s.t. the motion of the model from (q, v), with impacts,
///      coordinates and controls within Model::bounds at all times,
///      path constraints c(q, v, u) = 0 or >= 0,
///      the goals at T
/// ```
///
/// `phi`, `L`, `c`, goals and free initial values are those that the scene declares
/// ([`OptimalControlDeclaration`]); the weights of [`Objective`] and the [`Goal`]s are added to them by the program
/// that states the problem. The controls are constant or linear ([`ControlShape`](super::ControlShape)) on `intervals`
/// intervals of equal physical length `T / intervals`. An impact at the final time itself counts: goals and costs mean
/// the state after it.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// Initial coordinates, length `n_q`; where they are free, a guess.
    pub q: Vec<f64>,
    /// Initial velocities, length `n_q`; where they are free, a guess.
    pub v: Vec<f64>,
    /// Length of the motion.
    pub horizon: Horizon,
    /// Whether objective, path constraints, terminal conditions and free initial values of the scene count.
    pub declared: bool,
    /// What to minimize, besides what the scene declares.
    pub objective: Objective,
    /// What has to hold at the end, besides what the scene declares.
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
    /// The problem that the scene declares. Where it declares a free final time, that is to be found; otherwise the
    /// horizon is that of the scene.
    #[must_use]
    pub fn of(model: &dyn Model, intervals: usize) -> Self {
        let declared = model.declaration().optimal_control;
        let horizon = match declared {
            Some(declared) if !declared.free_time => {
                Horizon::Fixed(model.horizon().unwrap_or(f64::NAN))
            }
            _ => Horizon::Free { guess: None },
        };
        Self {
            horizon,
            declared: declared.is_some(),
            ..Self::new(model, Objective::default(), Vec::new(), intervals)
        }
    }

    /// A problem that starts where the scene starts, with free final time; what else the scene declares for optimal
    /// control does not count.
    #[must_use]
    pub fn new(
        model: &dyn Model,
        objective: Objective,
        goals: Vec<Goal>,
        intervals: usize,
    ) -> Self {
        let n = model.declaration().coordinates.len();
        let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
        model.start(&mut q, &mut v);
        Self {
            q,
            v,
            horizon: Horizon::Free { guess: None },
            declared: false,
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
        if !(1..=MOST_INTERVALS).contains(&self.intervals) {
            return refuse(
                "number of control intervals".into(),
                self.intervals as f64,
                "",
                &format!("in 1..={MOST_INTERVALS}"),
            );
        }
        let horizon = match self.horizon {
            Horizon::Fixed(horizon) if horizon.is_nan() => {
                return Err(InputError::Unsupported {
                    what: "an optimal control problem without final time".into(),
                    remedy: "declare a `horizon`, or let `time` occur in `minimize` or `finally`"
                        .into(),
                });
            }
            Horizon::Fixed(horizon) => horizon,
            Horizon::Free { guess } => guess.unwrap_or(1.0),
        };
        self.initial_value_problem(&self.start(), horizon, ControlSignal::Zero)
            .check(model)?;
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
        self.check_free_start(model)?;
        for (i, contact) in declaration.contacts.iter().enumerate() {
            let input = self
                .initial_value_problem(&self.start(), 1.0, ControlSignal::Zero)
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

    fn check_free_start(&self, model: &dyn Model) -> Result<(), InputError> {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let known = self.q.iter().chain(&self.v).zip(self.start_ranges(model));
        for (k, (&value, (lower, upper))) in known.enumerate() {
            let coordinate = &declaration.coordinates[k % n];
            let (dot, per_second) = if k < n { ("", "") } else { ("d/dt ", "/s") };
            if !(lower..=upper).contains(&value) {
                return Err(InputError::OutOfRange {
                    what: format!("initial {dot}`{}`", coordinate.name),
                    value,
                    unit: format!("{}{per_second}", coordinate.unit),
                    bound: format!("within the bounds {lower}..={upper} of the free initial value"),
                });
            }
        }
        Ok(())
    }

    /// What the scene declares, as far as it counts.
    pub(in crate::ocp) fn declared(&self, model: &dyn Model) -> Option<OptimalControlDeclaration> {
        let declared = model.declaration().optimal_control;
        declared.filter(|_| self.declared)
    }

    /// Range of each component of `(q, v)` at the start: a point but for the free initial values.
    pub(in crate::ocp) fn start_ranges(&self, model: &dyn Model) -> Vec<(f64, f64)> {
        let start = self.q.iter().chain(&self.v);
        let mut ranges: Vec<(f64, f64)> = start.map(|&value| (value, value)).collect();
        let Some(declared) = self.declared(model) else {
            return ranges;
        };
        let count = declared.free_start.len();
        let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; count], vec![f64::INFINITY; count]);
        model.free_start_bounds(&mut lower, &mut upper);
        let bounds = bounds(model);
        for (i, &k) in declared.free_start.iter().enumerate() {
            ranges[k] = (lower[i], upper[i]);
            if k < self.q.len() {
                ranges[k] = (lower[i].max(bounds.0[k]), upper[i].min(bounds.1[k]));
            }
        }
        ranges
    }

    /// The motion under given controls from the start `(q, v)`.
    pub(in crate::ocp) fn initial_value_problem(
        &self,
        start: &[f64],
        horizon: f64,
        controls: ControlSignal,
    ) -> InitialValueProblem {
        let (q, v) = start.split_at(self.q.len());
        InitialValueProblem {
            q: q.to_vec(),
            v: v[..q.len()].to_vec(),
            horizon,
            controls,
            points: InitialValueProblem::DEFAULT_POINTS,
        }
    }

    /// The declared `(q, v)` at the start.
    pub(in crate::ocp) fn start(&self) -> Vec<f64> {
        self.q.iter().chain(&self.v).copied().collect()
    }

    /// Whether any initial value is to be found.
    pub(in crate::ocp) fn has_free_start(&self, model: &dyn Model) -> bool {
        self.declared(model)
            .is_some_and(|declared| !declared.free_start.is_empty())
    }
}

impl Component {
    /// Index of the coordinate.
    pub(in crate::ocp) fn index(self) -> usize {
        match self {
            Self::Coordinate(index) | Self::Velocity(index) => index,
        }
    }
}

/// Declared bounds, coordinates first.
pub(in crate::ocp) fn bounds(model: &dyn Model) -> (Vec<f64>, Vec<f64>) {
    let declaration = model.declaration();
    let length = declaration.coordinates.len() + declaration.controls.len();
    let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; length], vec![f64::INFINITY; length]);
    model.bounds(&mut lower, &mut upper);
    (lower, upper)
}
