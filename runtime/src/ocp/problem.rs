//! The optimal control problem, and the checks that come before it is solved.

use crate::model::{Function, Given, Model, Pieces, contact_point, held};
use crate::refusal;
use crate::simulation::{ControlSignal, InitialValueProblem, InputError};
use crate::yardstick;

/// Most control intervals: the programs are kept in memory.
const MOST_INTERVALS: usize = 10_000;

/// An optimal control problem on a [`Model`]:
///
/// ```text
/// min  phi(q, v, T) + int_0^T L(q, v, u) dt
/// s.t. the motion of the model from (q, v), with impacts,
///      coordinates and controls within Model::bounds at all times,
///      path constraints c(q, v, u) = 0 or >= 0,
///      the goals at T
/// ```
///
/// `phi`, `L`, `c`, goals and free initial values are those that the scene declares
/// ([`OptimalControlDeclaration`](crate::model::OptimalControlDeclaration)); what is to vary from one problem to the next is a parameter of the scene. The
/// controls are constant or linear ([`ControlShape`](super::ControlShape)) on `intervals`
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
    /// Number of control intervals, 1 to 10 000.
    pub intervals: usize,
    /// How joints move the start with given parameters that are variables; nothing but while an optimum is differentiated.
    pub completed: Vec<CompletedStart>,
}

/// How a component of the start of a scene with joints, which complete it, goes with given parameters: to first order, which is all that
/// derivatives read.
#[derive(Debug, Clone, PartialEq)]
pub struct CompletedStart {
    /// Index of the component of `(q, v)`.
    pub component: usize,
    /// Indices of coordinates that stand for parameters, and the derivatives by these.
    pub by: Vec<(usize, f64)>,
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

impl Problem {
    /// The problem that the scene declares, from where it starts. Where it declares a free final time, or nothing at
    /// all, that is to be found; otherwise the horizon is that of the scene.
    #[must_use]
    pub fn of(model: &dyn Model, intervals: usize) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
        model.start(&mut q, &mut v);
        let horizon = match declaration.optimal_control {
            Some(declared)
                if !declared.free_time && held::place(model, Given::Horizon).is_some() =>
            {
                Horizon::Free {
                    guess: model.horizon(),
                }
            }
            Some(declared) if !declared.free_time => {
                Horizon::Fixed(model.horizon().unwrap_or(f64::NAN))
            }
            _ => Horizon::Free { guess: None },
        };
        Self {
            q,
            v,
            horizon,
            intervals,
            completed: Vec::new(),
        }
    }

    /// The length of the motion, or a guess of it \[s\]; NaN of a problem without.
    pub(in crate::ocp) fn length(&self, model: &dyn Model) -> f64 {
        match self.horizon {
            Horizon::Fixed(horizon) => horizon,
            Horizon::Free { guess } => guess.or_else(|| model.horizon()).unwrap_or(1.0),
        }
    }

    /// Checks everything that can be known beforehand.
    ///
    /// # Errors
    /// The first [`InputError`] found, with the name of what is wrong, its value and its bound.
    pub(in crate::ocp) fn check(&self, model: &dyn Model) -> Result<(), InputError> {
        if !(1..=MOST_INTERVALS).contains(&self.intervals) {
            return Err(refusal(
                "number of control intervals".into(),
                self.intervals as f64,
                "",
                format!("in 1..={MOST_INTERVALS}"),
            ));
        }
        if matches!(self.horizon, Horizon::Fixed(horizon) if horizon.is_nan()) {
            return Err(refusal::unsupported(
                "an optimal control problem without final time",
                "declare a `horizon`, or let `time` occur in `minimize` or `finally`",
            ));
        }
        let horizon = self.length(model);
        self.initial_value_problem(&self.start(), horizon, ControlSignal::Zero)
            .check(model)?;
        InitialValueProblem::check_at_once(model, "optimal control")?;
        let remedy = "give the contact one coefficient, as in `friction mu`, and dry friction a bound of positions and time";
        InitialValueProblem::check_friction(model, "optimal control", remedy)?;
        let (lower, upper) = bounds(model);
        let declaration = model.declaration();
        let bounded = declaration
            .coordinates
            .iter()
            .map(|known| (known.name, known.unit));
        let driven = declaration
            .controls
            .iter()
            .map(|known| (known.name, known.unit));
        for (k, (name, unit)) in bounded.chain(driven).enumerate() {
            if lower[k].is_nan() || upper[k].is_nan() || lower[k] > upper[k] {
                return Err(refusal(
                    format!("lower bound of `{name}`"),
                    lower[k],
                    unit,
                    format!("at most the upper one, {}", upper[k]),
                ));
            }
        }
        for (k, known) in declaration.coordinates.iter().enumerate() {
            if !(lower[k]..=upper[k]).contains(&self.q[k]) {
                return Err(refusal(
                    format!("initial `{}`", known.name),
                    self.q[k],
                    known.unit,
                    format!("within its bounds {}..={}", lower[k], upper[k]),
                ));
            }
        }
        self.check_free_start(model)?;
        self.check_constraints(model)?;
        self.check_contacts(model)
    }

    /// Path constraints that read nothing but given initial values hold at the start: what holds at the stages only would let the
    /// first of them wait until it does.
    fn check_constraints(&self, model: &dyn Model) -> Result<(), InputError> {
        let declaration = model.declaration();
        let Some(declared) = declaration.optimal_control else {
            return Ok(());
        };
        let states = 2 * declaration.coordinates.len();
        let (first, last) = (states + declaration.controls.len(), declaration.inputs());
        let given = |&column: &usize| {
            (column < states || (first..last).contains(&column))
                && !declared.free_start.contains(&column)
        };
        let mut input = self
            .initial_value_problem(&self.start(), 1.0, ControlSignal::Zero)
            .input(model);
        input.resize(declaration.path_inputs(), 0.0);
        let mut values = vec![0.0; declared.path_functions()];
        let mut slopes = vec![0.0; declared.path_jacobian.entries.len()];
        model.values(Function::Path, &input, &mut values);
        model.jacobian(Function::Path, &input, &mut slopes);
        let first = usize::from(declared.running_cost);
        for (known, function) in declared.constraints.iter().zip(first..) {
            let entries = declared.path_jacobian.entries.iter().zip(&slopes);
            let own = entries.filter(|((row, _), _)| *row as usize == function);
            let own = own.map(|(&(_, column), slope)| (column as usize, slope));
            let terms: Vec<(usize, f64)> = own
                .map(|(column, slope)| (column, (slope * input[column]).abs()))
                .collect();
            if !terms.iter().all(|(column, _)| given(column)) {
                continue;
            }
            let size = terms
                .iter()
                .fold(1.0, |most: f64, (_, term)| most.max(*term));
            let value = values[function];
            let violation = if known.equality { value.abs() } else { -value };
            if violation > yardstick::NOTHING * size {
                let bound = if known.equality { "0" } else { "at least 0" };
                return Err(refusal(
                    format!("`{}` at the start", known.name),
                    value,
                    known.unit,
                    format!("{bound}: start where the constraint holds"),
                ));
            }
        }
        Ok(())
    }

    /// The motion starts after its first impact.
    fn check_contacts(&self, model: &dyn Model) -> Result<(), InputError> {
        let declaration = model.declaration();
        let input = self
            .initial_value_problem(&self.start(), 1.0, ControlSignal::Zero)
            .input(model);
        let n = declaration.coordinates.len();
        let mut point = vec![0.0; contact_point::length(n)];
        let pieces = Pieces::at(model, &input);
        let control = declaration.optimal_control.iter();
        let mut free = control.flat_map(|control| control.free_start);
        // A free velocity leaves the surface where another one is given that would have to follow it.
        let remedy = if free.any(|known| (n..2 * n).contains(known)) {
            "start after the impact, or along the surface with all velocities free that follow it"
        } else {
            "start after the impact"
        };
        for (i, contact) in declaration.contacts.iter().enumerate() {
            model.contact(i, &input, &mut point);
            let velocity = point[contact_point::NORMAL_VELOCITY];
            let touches = !pieces.is_idle(i) && point[contact_point::GAP] <= 0.0;
            let normal = &point[contact_point::NORMAL..][..n];
            let along: f64 = normal.iter().zip(&self.v).map(|(n, v)| n * v).sum();
            let largest = |values: &[f64]| values.iter().fold(0.0, |l: f64, x| l.max(x.abs()));
            let size = largest(normal) * largest(&self.v) + (velocity - along).abs();
            if touches && velocity < -yardstick::NOTHING * size {
                return Err(refusal(
                    format!("initial normal velocity of `{}`", contact.name),
                    velocity,
                    &format!("{}/s", contact.unit),
                    format!("at least 0 on the surface: {remedy}"),
                ));
            }
        }
        Ok(())
    }

    /// The problem with a start that lies below a surface by no more than is let pass, but by more than rounding, moved onto it: what is so
    /// little over the whole motion is not over a part of it, which would be refused.
    pub(in crate::ocp) fn on_the_ground(&self, model: &dyn Model) -> Self {
        let n = self.q.len();
        let mut moved = self.clone();
        let mut point = vec![0.0; contact_point::length(n)];
        for contact in 0..model.declaration().contacts.len() {
            let input = moved
                .initial_value_problem(&moved.start(), 1.0, ControlSignal::Zero)
                .input(model);
            model.contact(contact, &input, &mut point);
            let gap = point[contact_point::GAP];
            let normal = &point[contact_point::NORMAL..][..n];
            let terms = normal.iter().zip(&moved.q).map(|(n, q)| (n * q).abs());
            let below = gap < -yardstick::NOTHING * terms.sum::<f64>();
            if below && !Pieces::at(model, &input).is_idle(contact) {
                let direction = &point[contact_point::direction(n)..][..n];
                for (q, d) in moved.q.iter_mut().zip(direction) {
                    *q -= gap * d;
                }
            }
        }
        moved
    }

    fn check_free_start(&self, model: &dyn Model) -> Result<(), InputError> {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let known = self.q.iter().chain(&self.v).zip(self.start_ranges(model));
        for (k, (&value, (lower, upper))) in known.enumerate() {
            let coordinate = &declaration.coordinates[k % n];
            let (dot, per_second) = if k < n { ("", "") } else { ("d/dt ", "/s") };
            if !(lower..=upper).contains(&value) {
                return Err(refusal(
                    format!("initial {dot}`{}`", coordinate.name),
                    value,
                    &format!("{}{per_second}", coordinate.unit),
                    format!("within the bounds {lower}..={upper} of the free initial value"),
                ));
            }
        }
        Ok(())
    }

    /// Range of each component of `(q, v)` at the start: a point but for the free initial values.
    pub(in crate::ocp) fn start_ranges(&self, model: &dyn Model) -> Vec<(f64, f64)> {
        let start = self.q.iter().chain(&self.v);
        let mut ranges: Vec<(f64, f64)> = start.map(|&value| (value, value)).collect();
        for given in model.held().map_or(&[][..], |held| held.given) {
            if let Given::Start(k) = *given {
                ranges[k] = (f64::NEG_INFINITY, f64::INFINITY);
            }
        }
        for known in &self.completed {
            ranges[known.component] = (f64::NEG_INFINITY, f64::INFINITY);
        }
        let Some(declared) = model.declaration().optimal_control else {
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
}

fn refusal(what: String, value: f64, unit: &str, bound: String) -> InputError {
    refusal::out_of_range(what, value, unit, bound)
}

/// Whether any initial value is to be found.
pub(in crate::ocp) fn has_free_start(model: &dyn Model) -> bool {
    let declared = model.declaration().optimal_control;
    declared.is_some_and(|declared| !declared.free_start.is_empty())
}

/// Declared bounds, coordinates first.
pub(in crate::ocp) fn bounds(model: &dyn Model) -> (Vec<f64>, Vec<f64>) {
    let declaration = model.declaration();
    let length = declaration.coordinates.len() + declaration.controls.len();
    let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; length], vec![f64::INFINITY; length]);
    model.bounds(&mut lower, &mut upper);
    (lower, upper)
}
