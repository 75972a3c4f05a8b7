//! The program that a file states: functions and exact derivatives on a fixed sparsity.

use super::error::ReadError;
use super::hessian::Hessian;
use super::jacobian::Gradients;
use super::operation::Partials;
use super::read;
use super::statement::Duals;
use super::tape::{Function, Tape};
use super::vertical::{Measure, Row, Slack, Vertical};
use crate::mpcc::Mpcc;
use crate::nlp::NlpProblem;

/// A nonlinear program with or without complementarity constraints, as a `.nl` file states it.
///
/// As an [`NlpProblem`] its variables are measured as the pairs of the vertical form ask for: `x = offset +- v`. Slacks come
/// after the variables of the file, a row that complements a variable may be part of a bound, and an objective that is
/// maximized is negated. [`solve`](super::solve) speaks of the variables and rows of the file again.
///
/// # Examples
/// `min (x_0 - 1)^2 + (x_1 - 1)^2` where `x_1 >= 0` complements `x_0 >= 0`: one of them is zero.
///
/// ```
/// use hangtime_solver::nl::{self, Program};
///
/// let text = "g3 1 1 0\n 2 1 1 0 0\n 0 1 1\n 0 0\n 0 2 0\n 0 0 0 1\n 0 0 0 0 0\n 1 0\n 0 0\n 0 0 0 0 0\n\
///     C0\nn0\nO0 0\no0\no5\no0\nn-1\nv0\nn2\no5\no0\nn-1\nv1\nn2\n\
///     x1\n0 0.3\nr\n5 1 1\nb\n2 0\n2 0\nk1\n0\nJ0 1\n1 1\n";
/// let mut program = Program::read(text.as_bytes())?;
/// let solution = nl::solve(&mut program, 60.0, &mut |_| true)?;
/// assert!(solution.status.is_solved());
/// assert_eq!(solution.x[0].min(solution.x[1]), 0.0);
/// assert!((solution.objective - 1.0).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Program {
    pub(super) options: Vec<String>,
    /// Variables and rows of the file.
    pub(super) variables: usize,
    pub(super) file_rows: usize,
    pub(super) maximizes: bool,
    pub(super) vertical: Vertical,
    start: Vec<f64>,
    pub(super) duals: Duals,
    objective: Function,
    derivatives: Derivatives,
    variable_names: Vec<String>,
    row_names: Vec<String>,
}

/// Tape, derivatives and what they are at the last point.
#[derive(Debug)]
struct Derivatives {
    tape: Tape,
    gradients: Gradients,
    hessian: Hessian,
    /// Variables of the program, then all values of the tape, at the last point.
    point: Vec<f64>,
    x: Vec<f64>,
    values: Vec<f64>,
    partials: Vec<Partials>,
    /// Whether `partials` and `gradients` are those of the point.
    has_partials: bool,
    jacobian: Vec<(usize, usize)>,
    /// Coefficients of the linear terms at the places of the Jacobian.
    constant: Vec<f64>,
    /// Where the nonlinear gradient of each row goes, row after row.
    places: Vec<u32>,
}

impl Program {
    /// Reads a `.nl` file, text (`g`) or binary (`b`).
    ///
    /// Rows may complement variables. Of several objectives the first counts; without one any feasible point is a solution.
    /// Initial multipliers of rows, and of bounds by the suffixes `ipopt_zL_in` and `ipopt_zU_in`, are kept for
    /// [`solve_with`](super::solve_with); other suffixes are skipped. Bounds of 1e20 or more are none.
    ///
    /// # Errors
    /// [`ReadError`] where the file is damaged, and for whole variables, logical and network constraints, imported functions
    /// and operators that are not continuous, by their names.
    pub fn read(bytes: &[u8]) -> Result<Self, ReadError> {
        Self::read_named(bytes, Vec::new(), Vec::new())
    }

    /// As [`Program::read`], with the names of variables and rows, which files beside the `.nl` file hold; what has no name
    /// is `x[index]` or `c[index]`.
    ///
    /// # Errors
    /// As [`Program::read`].
    pub fn read_named(
        bytes: &[u8],
        variable_names: Vec<String>,
        row_names: Vec<String>,
    ) -> Result<Self, ReadError> {
        let name = |index: usize| match variable_names.get(index) {
            Some(name) => name.clone(),
            None => format!("x[{index}]"),
        };
        let statement = read::read(bytes, &name)?;
        let (variables, file_rows) = (statement.start.len(), statement.rows.len());
        let bodies = statement.rows.iter().map(|(body, _)| body);
        let bodies: Vec<_> = bodies.chain([&statement.objective]).collect();
        let (tape, mut functions) = Tape::new(&statement.graph, variables, &bodies);
        let objective = functions.pop().unwrap_or_default();
        let demands = statement.rows.iter().map(|(_, demand)| *demand);
        let rows = functions.into_iter().zip(demands).collect();
        let vertical = Vertical::new(statement.bounds, rows, &name)?;
        let derivatives =
            Derivatives::new(tape, &vertical.rows, &objective, vertical.bounds.len())?;
        let mut program = Self {
            options: statement.options,
            variables,
            file_rows,
            maximizes: statement.maximizes,
            start: statement.start,
            duals: statement.duals,
            vertical,
            objective,
            derivatives,
            variable_names,
            row_names,
        };
        program.start_slacks();
        Ok(program)
    }

    /// Names of the variables of the file, in its order.
    #[must_use]
    pub fn variable_names(&self) -> Vec<String> {
        (0..self.variables).map(|k| self.variable_name(k)).collect()
    }

    /// Names of the rows of the file, in its order.
    #[must_use]
    pub fn row_names(&self) -> Vec<String> {
        (0..self.file_rows).map(|k| self.row_name(k)).collect()
    }

    /// Slacks start where their rows hold, as far as their bounds allow.
    fn start_slacks(&mut self) {
        let first = self.variables;
        self.start.resize(self.vertical.bounds.len(), 0.0);
        let mut x = self.start.clone();
        for (x, (lower, upper)) in x.iter_mut().zip(&self.vertical.bounds) {
            *x = x.max(*lower).min(*upper);
        }
        self.derivatives.values[..first].copy_from_slice(&x[..first]);
        self.derivatives.tape.evaluate(&mut self.derivatives.values);
        for row in &self.vertical.rows {
            let value = row.function.value(&x, &self.derivatives.values) - row.lower;
            for &(slack, coefficient) in row.function.linear.iter().filter(|term| term.0 >= first) {
                let start = (-value / coefficient).max(0.0);
                self.start[slack] = if start.is_finite() { start } else { 0.0 };
            }
        }
    }

    /// The variables of the file at a point of the program.
    pub(super) fn in_file(&self, v: &[f64]) -> Vec<f64> {
        let measures = &self.vertical.measures[..self.variables];
        let measured = measures.iter().zip(v);
        measured
            .map(|(measure, v)| measure.offset + measure.sign * v)
            .collect()
    }

    /// The start of the file, in its variables.
    pub(super) fn file_start(&self) -> &[f64] {
        &self.start[..self.variables]
    }

    /// Starts at another point of the variables of the file.
    pub(super) fn start_at(&mut self, x: &[f64]) {
        self.start.truncate(0);
        self.start.extend_from_slice(x);
        self.start_slacks();
    }

    fn row_name(&self, row: usize) -> String {
        match self.row_names.get(row) {
            Some(name) => name.clone(),
            None => format!("c[{row}]"),
        }
    }

    /// 1 for a minimum, -1 for a maximum.
    pub(super) fn sense(&self) -> f64 {
        if self.maximizes { -1.0 } else { 1.0 }
    }
}

impl Derivatives {
    fn new(
        tape: Tape,
        rows: &[Row],
        objective: &Function,
        variables: usize,
    ) -> Result<Self, ReadError> {
        let functions: Vec<Function> = rows
            .iter()
            .map(|row| &row.function)
            .chain([objective])
            .cloned()
            .collect();
        let too_dense = || {
            ReadError::whole(
                "its functions depend on too many variables at once for second derivatives; state long sums and \
                 products by variables and rows of their own",
            )
        };
        let gradients = Gradients::new(&tape, &functions).ok_or_else(too_dense)?;
        let hessian = Hessian::new(&tape).ok_or_else(too_dense)?;
        let (mut jacobian, mut constant, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for (index, row) in rows.iter().enumerate() {
            let first = jacobian.len();
            let linear = &row.function.linear;
            let nonlinear = gradients.columns(index);
            let mut columns: Vec<usize> = nonlinear.iter().map(|&column| column as usize).collect();
            columns.extend(linear.iter().map(|term| term.0));
            columns.sort_unstable();
            columns.dedup();
            let place = |column: usize| first + columns.partition_point(|&other| other < column);
            places.extend(
                nonlinear
                    .iter()
                    .map(|&column| place(column as usize) as u32),
            );
            constant.resize(first + columns.len(), 0.0);
            for &(column, coefficient) in linear {
                constant[place(column)] += coefficient;
            }
            jacobian.extend(columns.iter().map(|&column| (index, column)));
        }
        let length = tape.len();
        Ok(Self {
            point: vec![f64::NAN; variables],
            x: vec![0.0; variables],
            values: vec![0.0; length],
            partials: vec![Partials::default(); length],
            has_partials: false,
            tape,
            gradients,
            hessian,
            jacobian,
            constant,
            places,
        })
    }

    /// Evaluates the tape, unless it was evaluated there.
    fn move_to(&mut self, v: &[f64], measures: &[Measure]) {
        if self.point == v {
            return;
        }
        self.point.copy_from_slice(v);
        for ((x, v), measure) in self.x.iter_mut().zip(v).zip(measures) {
            *x = measure.offset + measure.sign * v;
        }
        let variables = self.tape.variables;
        self.values[..variables].copy_from_slice(&self.x[..variables]);
        self.tape.evaluate(&mut self.values);
        self.has_partials = false;
    }

    fn differentiate(&mut self, v: &[f64], measures: &[Measure]) {
        self.move_to(v, measures);
        if !self.has_partials {
            self.tape.differentiate(&self.values, &mut self.partials);
            self.gradients.evaluate(&self.tape, &self.partials);
            self.has_partials = true;
        }
    }
}

impl NlpProblem for Program {
    fn variables(&self) -> usize {
        self.vertical.bounds.len()
    }

    fn constraints(&self) -> usize {
        self.vertical.rows.len()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        let all = self.vertical.bounds.iter().zip(&self.vertical.measures);
        for ((lower, upper), (&(l, u), measure)) in lower.iter_mut().zip(upper).zip(all) {
            let ends = [l, u].map(|bound| measure.sign * (bound - measure.offset) + 0.0);
            (*lower, *upper) = if measure.sign > 0.0 {
                (ends[0], ends[1])
            } else {
                (ends[1], ends[0])
            };
        }
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        for (index, row) in self.vertical.rows.iter().enumerate() {
            (lower[index], upper[index]) = (row.lower, row.upper);
        }
    }

    fn initial_point(&self, v: &mut [f64]) {
        for ((v, x), measure) in v.iter_mut().zip(&self.start).zip(&self.vertical.measures) {
            *v = measure.sign * (x - measure.offset);
        }
    }

    fn objective(&mut self, v: &[f64]) -> f64 {
        self.derivatives.move_to(v, &self.vertical.measures);
        let Derivatives { x, values, .. } = &self.derivatives;
        self.sense() * self.objective.value(x, values)
    }

    fn gradient(&mut self, v: &[f64], gradient: &mut [f64]) {
        self.derivatives.differentiate(v, &self.vertical.measures);
        let gradients = &self.derivatives.gradients;
        gradient.fill(0.0);
        for &(column, coefficient) in &self.objective.linear {
            gradient[column] += coefficient;
        }
        let last = self.vertical.rows.len();
        for (&column, value) in gradients.columns(last).iter().zip(gradients.values(last)) {
            gradient[column as usize] += value;
        }
        let sense = self.sense();
        for (entry, measure) in gradient.iter_mut().zip(&self.vertical.measures) {
            *entry *= sense * measure.sign;
        }
    }

    fn constraint_values(&mut self, v: &[f64], c: &mut [f64]) {
        self.derivatives.move_to(v, &self.vertical.measures);
        let Derivatives { x, values, .. } = &self.derivatives;
        for (c, row) in c.iter_mut().zip(&self.vertical.rows) {
            *c = row.function.value(x, values);
        }
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.derivatives.jacobian.clone()
    }

    fn jacobian_values(&mut self, v: &[f64], values: &mut [f64]) {
        self.derivatives.differentiate(v, &self.vertical.measures);
        let derivatives = &self.derivatives;
        values.copy_from_slice(&derivatives.constant);
        let gradients = &derivatives.gradients;
        let nonlinear = (0..self.vertical.rows.len()).flat_map(|row| gradients.values(row));
        for (&place, value) in derivatives.places.iter().zip(nonlinear) {
            values[place as usize] += value;
        }
        for (value, &(_, column)) in values.iter_mut().zip(&derivatives.jacobian) {
            *value *= self.vertical.measures[column].sign;
        }
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.derivatives.hessian.pattern().collect()
    }

    fn hessian_values(&mut self, v: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        self.derivatives.differentiate(v, &self.vertical.measures);
        let sense = self.sense();
        let derivatives = &mut self.derivatives;
        let rows = self.vertical.rows.iter().map(|row| &row.function);
        let weights = multipliers.iter().copied().chain([weight * sense]);
        let weighted = rows.chain([&self.objective]).zip(weights);
        let seeds = weighted.flat_map(|(function, weight)| {
            let nodes = function.nodes.iter();
            nodes.map(move |&(node, coefficient)| (node, weight * coefficient))
        });
        derivatives
            .hessian
            .evaluate(&derivatives.tape, &derivatives.partials, seeds);
        let measures = &self.vertical.measures;
        let entries = derivatives.hessian.values();
        for ((value, entry), (row, column)) in values
            .iter_mut()
            .zip(entries)
            .zip(derivatives.hessian.pattern())
        {
            *value = entry * measures[row].sign * measures[column].sign;
        }
    }

    fn variable_name(&self, index: usize) -> String {
        match index.checked_sub(self.variables) {
            Some(slack) => match self.vertical.slacks[slack] {
                Slack::Part { row } => format!("slack of {}", self.row_name(row)),
                Slack::Distance { variable } => {
                    format!(
                        "distance of {} from its bound",
                        self.variable_name(variable)
                    )
                }
            },
            None => match self.variable_names.get(index) {
                Some(name) => name.clone(),
                None => format!("x[{index}]"),
            },
        }
    }

    fn constraint_name(&self, index: usize) -> String {
        self.row_name(self.vertical.rows[index].of)
    }
}

impl Mpcc for Program {
    fn complementarities(&self) -> &[(usize, usize)] {
        &self.vertical.pairs
    }
}
