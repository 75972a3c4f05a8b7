//! Collects variables, rows, linear terms and elements.

use std::any::Any;

use super::group::TypedGroup;
use super::statement::Statement;
use super::{Element, ElementProblem, Target};
use crate::nlp::InputError;

/// Collects the parts of an [`ElementProblem`].
///
/// # Examples
/// Minimize `(x_0 - 1)^2 + exp(x_1)` subject to `x_0 x_1 + 2 x_0 >= 1`:
///
/// ```
/// use hangtime_solver::nlp::{self, DualNum, Element, ElementProblemBuilder, Settings, Target};
///
/// struct Square;
/// impl Element<1, 1> for Square {
///     fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x]: &[D; 1]) -> [D; 1] {
///         [(*x - 1.0).powi(2)]
///     }
/// }
///
/// struct Exponential;
/// impl Element<1, 1> for Exponential {
///     fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x]: &[D; 1]) -> [D; 1] {
///         [x.exp()]
///     }
/// }
///
/// struct Product;
/// impl Element<2, 1> for Product {
///     fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x, y]: &[D; 2]) -> [D; 1] {
///         [*x * *y]
///     }
/// }
///
/// let mut builder = ElementProblemBuilder::new();
/// let infinite = f64::INFINITY;
/// let x = [0, 1].map(|_| builder.variable(-infinite, infinite, 0.5));
/// let row = builder.row(1.0, infinite);
/// builder.element(Square, [x[0]], [&[(Target::Objective, 1.0)]]);
/// builder.element(Exponential, [x[1]], [&[(Target::Objective, 1.0)]]);
/// builder.element(Product, x, [&[(Target::Row(row), 1.0)]]);
/// builder.linear(Target::Row(row), 2.0, x[0]);
/// let mut problem = builder.build()?;
///
/// assert!(nlp::check_derivatives(&mut problem, None)?[0].error < 1e-7);
/// let solution = nlp::solve(&mut problem, &Settings::default())?;
/// assert!(solution.status.is_solved());
/// // the row is active: x_1 = 1 / x_0 - 2
/// assert!((solution.x[1] - (1.0 / solution.x[0] - 2.0)).abs() < 1e-6);
/// # Ok::<(), nlp::InputError>(())
/// ```
#[derive(Default)]
pub struct ElementProblemBuilder {
    statement: Statement,
}

impl ElementProblemBuilder {
    /// A problem without variables.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a variable with `lower <= x <= upper`, infinite where absent, that starts at `start`; returns its index.
    pub fn variable(&mut self, lower: f64, upper: f64, start: f64) -> usize {
        self.statement.variable_bounds.push((lower, upper));
        self.statement.start.push(start);
        self.statement.variable_names.push(None);
        self.statement.start.len() - 1
    }

    /// Adds a constraint `lower <= c <= upper` that is zero so far; returns its index.
    pub fn row(&mut self, lower: f64, upper: f64) -> usize {
        self.statement.row_bounds.push((lower, upper));
        self.statement.row_names.push(None);
        self.statement.row_bounds.len() - 1
    }

    /// Adds `coefficient x_variable` to the target. Terms of the same variable add up.
    pub fn linear(&mut self, target: Target, coefficient: f64, variable: usize) {
        self.statement.linear.push((target, coefficient, variable));
    }

    /// Adds a constant to the target.
    pub fn constant(&mut self, target: Target, value: f64) {
        self.statement.constants.push((target, value));
    }

    /// Adds `coefficient value_o(x_variables)` for each value `o` of the element and each (target, coefficient) of
    /// `targets[o]`. A variable may stand twice.
    pub fn element<E: Element<N, M>, const N: usize, const M: usize>(
        &mut self,
        element: E,
        variables: [usize; N],
        targets: [&[(Target, f64)]; M],
    ) {
        for group in &mut self.statement.groups {
            let group: &mut dyn Any = group.as_mut();
            if let Some(group) = group.downcast_mut::<TypedGroup<E, N, M>>() {
                group.push(element, variables, targets);
                return;
            }
        }
        let mut group = TypedGroup::new();
        group.push(element, variables, targets);
        self.statement.groups.push(Box::new(group));
    }

    /// Names a variable in diagnoses; without a name it is `x[index]`.
    pub fn name_variable(&mut self, index: usize, name: impl Into<String>) {
        if let Some(place) = self.statement.variable_names.get_mut(index) {
            *place = Some(name.into());
        }
    }

    /// Names a constraint in diagnoses; without a name it is `c[index]`.
    pub fn name_row(&mut self, index: usize, name: impl Into<String>) {
        if let Some(place) = self.statement.row_names.get_mut(index) {
            *place = Some(name.into());
        }
    }

    /// Finds the patterns and where each derivative goes.
    ///
    /// # Errors
    /// [`InputError`] if a term names a variable or a row that does not exist.
    pub fn build(self) -> Result<ElementProblem, InputError> {
        ElementProblem::new(self.statement)
    }
}
