//! The finished problem: patterns, places, evaluation with memory of the last point.

use super::Target;
use super::group::{Group, OBJECTIVE};
use super::statement::Statement;
use crate::nlp::{Fault, InputError, NlpProblem};

/// A nonlinear program made of elements; see [`ElementProblemBuilder`](super::ElementProblemBuilder).
///
/// Objective and constraints are evaluated together, and so are gradient and Jacobian; a second call at the same
/// point costs nothing.
pub struct ElementProblem {
    statement: Statement,
    /// (row, column) of the Jacobian and of the lower triangle of the Hessian.
    jacobian_pattern: Vec<(usize, usize)>,
    hessian_pattern: Vec<(usize, usize)>,
    /// (target, variable, coefficient) with the objective as target `m`, by target.
    linear: Vec<(u32, u32, f64)>,
    /// Constant parts of `(c, f)` and of the first derivatives.
    constant: Vec<f64>,
    constant_first: Vec<f64>,
    /// Last `(c, f)` and last Jacobian and gradient, with the points they belong to.
    values: Vec<f64>,
    first: Vec<f64>,
    values_at: Point,
    first_at: Point,
    /// `(y, weight)`.
    weights: Vec<f64>,
}

/// The point of the last evaluation.
struct Point {
    x: Vec<f64>,
    is_set: bool,
}

impl Point {
    fn new(variables: usize) -> Self {
        Self {
            x: vec![0.0; variables],
            is_set: false,
        }
    }

    /// Whether `x` differs from the last point, by bits; takes it over.
    fn moves_to(&mut self, x: &[f64]) -> bool {
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        let same_block = |(a, b): (&[f64], &[f64])| {
            a.iter().zip(b).filter(|&pair| same(pair)).count() == a.len()
        };
        if self.is_set && self.x.chunks(64).zip(x.chunks(64)).all(same_block) {
            return false;
        }
        self.is_set = true;
        self.x.copy_from_slice(x);
        true
    }
}

impl ElementProblem {
    pub(super) fn new(mut statement: Statement) -> Result<Self, InputError> {
        let (n, m) = (statement.start.len(), statement.row_bounds.len());
        check_indices(&statement)?;
        let index = |target: Target| match target {
            Target::Objective => m,
            Target::Row(row) => row,
        };
        let linear: Vec<(usize, usize, f64)> = statement
            .linear
            .iter()
            .map(|&(target, coefficient, variable)| (index(target), variable, coefficient))
            .collect();
        let constants: Vec<(usize, f64)> = statement
            .constants
            .iter()
            .map(|&(target, value)| (index(target), value))
            .collect();
        for group in &mut statement.groups {
            group.place_objective(m);
        }

        let mut first: Vec<(usize, usize)> = linear.iter().map(|&(t, v, _)| (t, v)).collect();
        let mut second = Vec::new();
        for group in &statement.groups {
            group.first_positions(&mut |target, variable| first.push((target, variable)));
            group.second_positions(&mut |row, column| second.push((row, column)));
        }
        let (hessian_pattern, second_places) = positions(&second);
        let (all_first, mut first_places) = positions(&first);
        // the objective sorts after all rows; its gradient is dense
        let entries = all_first.partition_point(|&(target, _)| target < m);
        for place in &mut first_places {
            if *place as usize >= entries {
                *place = narrow(entries + all_first[*place as usize].1);
            }
        }
        let length = entries + n;
        if u32::try_from(length.max(second.len()).max(first.len())).is_err() {
            return Err(InputError::from(Fault::Size {
                variables: n,
                constraints: m,
            }));
        }
        let jacobian_pattern = all_first[..entries].to_vec();
        let mut constant_first = vec![0.0; length];
        let (of_linear, of_groups) = first_places.split_at(linear.len());
        for (&(_, _, coefficient), &place) in linear.iter().zip(of_linear) {
            constant_first[place as usize] += coefficient;
        }
        distribute(&mut statement.groups, of_groups, &second_places);
        let mut constant = vec![0.0; m + 1];
        for (target, value) in constants {
            constant[target] += value;
        }
        let mut linear: Vec<(u32, u32, f64)> = linear
            .into_iter()
            .map(|(target, variable, coefficient)| (narrow(target), narrow(variable), coefficient))
            .collect();
        linear.sort_unstable_by_key(|&(target, variable, _)| (target, variable));
        Ok(Self {
            statement,
            jacobian_pattern,
            hessian_pattern,
            linear,
            constant,
            constant_first,
            values: vec![0.0; m + 1],
            first: vec![0.0; length],
            values_at: Point::new(n),
            first_at: Point::new(n),
            weights: vec![0.0; m + 1],
        })
    }

    fn update_values(&mut self, x: &[f64]) {
        if !self.values_at.moves_to(x) {
            return;
        }
        self.values.copy_from_slice(&self.constant);
        for &(target, variable, coefficient) in &self.linear {
            self.values[target as usize] += coefficient * x[variable as usize];
        }
        for group in &self.statement.groups {
            group.add_values(x, &mut self.values);
        }
    }

    fn update_first(&mut self, x: &[f64]) {
        if !self.first_at.moves_to(x) {
            return;
        }
        self.first.copy_from_slice(&self.constant_first);
        for group in &self.statement.groups {
            group.add_first(x, &mut self.first);
        }
    }
}

/// Checks every term before the objective takes the place after the last row.
fn check_indices(statement: &Statement) -> Result<(), InputError> {
    let (n, m) = (statement.start.len(), statement.row_bounds.len());
    let mut fault = None;
    let mut check_row = |target: usize| {
        if target != OBJECTIVE && target >= m {
            fault = Some(("row", target, m));
        }
    };
    let index = |target: Target| match target {
        Target::Objective => OBJECTIVE,
        Target::Row(row) => row,
    };
    for &(target, _, _) in &statement.linear {
        check_row(index(target));
    }
    for &(target, _) in &statement.constants {
        check_row(index(target));
    }
    for group in &statement.groups {
        group.first_positions(&mut |target, _| check_row(target));
    }
    let mut check_variable = |variable: usize| {
        if variable >= n {
            fault = Some(("variable", variable, n));
        }
    };
    for &(_, _, variable) in &statement.linear {
        check_variable(variable);
    }
    for group in &statement.groups {
        group.second_positions(&mut |row, _| check_variable(row));
    }
    match fault {
        None => Ok(()),
        Some((what, index, count)) => Err(InputError::from(Fault::Element { what, index, count })),
    }
}

fn narrow(place: usize) -> u32 {
    u32::try_from(place).unwrap_or(u32::MAX)
}

/// Sorted positions without repetition, and the place of each one given.
fn positions(given: &[(usize, usize)]) -> (Vec<(usize, usize)>, Vec<u32>) {
    let mut order: Vec<usize> = (0..given.len()).collect();
    order.sort_unstable_by_key(|&k| given[k]);
    let mut sorted: Vec<(usize, usize)> = Vec::with_capacity(given.len());
    let mut places = vec![0; given.len()];
    for k in order {
        if sorted.last() != Some(&given[k]) {
            sorted.push(given[k]);
        }
        places[k] = narrow(sorted.len() - 1);
    }
    (sorted, places)
}

/// Tells each group where its derivatives go; the places are in the order in which groups name their positions.
fn distribute(groups: &mut [Box<dyn Group>], mut first: &[u32], mut second: &[u32]) {
    for group in groups {
        let (mut first_length, mut second_length) = (0, 0);
        group.first_positions(&mut |_, _| first_length += 1);
        group.second_positions(&mut |_, _| second_length += 1);
        let (own_first, own_second);
        (own_first, first) = first.split_at(first_length);
        (own_second, second) = second.split_at(second_length);
        group.set_places(own_first, own_second);
    }
}

impl NlpProblem for ElementProblem {
    fn variables(&self) -> usize {
        self.statement.start.len()
    }

    fn constraints(&self) -> usize {
        self.statement.row_bounds.len()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        for ((l, u), bounds) in lower
            .iter_mut()
            .zip(upper)
            .zip(&self.statement.variable_bounds)
        {
            (*l, *u) = *bounds;
        }
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        for ((l, u), bounds) in lower.iter_mut().zip(upper).zip(&self.statement.row_bounds) {
            (*l, *u) = *bounds;
        }
    }

    fn initial_point(&self, x: &mut [f64]) {
        x.copy_from_slice(&self.statement.start);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        self.update_values(x);
        self.values[self.values.len() - 1]
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.update_first(x);
        gradient.copy_from_slice(&self.first[self.jacobian_pattern.len()..]);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.update_values(x);
        c.copy_from_slice(&self.values[..c.len()]);
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.jacobian_pattern.clone()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        self.update_first(x);
        values.copy_from_slice(&self.first[..self.jacobian_pattern.len()]);
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.hessian_pattern.clone()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        let m = multipliers.len();
        self.weights[..m].copy_from_slice(multipliers);
        self.weights[m] = weight;
        values.fill(0.0);
        for group in &self.statement.groups {
            group.add_second(x, &self.weights, values);
        }
    }

    fn variable_name(&self, index: usize) -> String {
        match self.statement.variable_names.get(index) {
            Some(Some(name)) => name.clone(),
            _ => format!("x[{index}]"),
        }
    }

    fn constraint_name(&self, index: usize) -> String {
        match self.statement.row_names.get(index) {
            Some(Some(name)) => name.clone(),
            _ => format!("c[{index}]"),
        }
    }
}
