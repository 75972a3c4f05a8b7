//! Sizes of a problem, for reports.

use super::NlpProblem;

/// How many variables, rows and entries of each kind a problem has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct ProblemStatistics {
    /// Variables, those of every kind.
    pub variables: usize,
    /// Variables with equal bounds, which the solver removes.
    pub fixed: usize,
    /// Variables without bounds.
    pub free: usize,
    /// Variables with a lower bound only.
    pub lower_bounded: usize,
    /// Variables with an upper bound only.
    pub upper_bounded: usize,
    /// Variables with two different bounds.
    pub two_sided: usize,
    /// Constraints with equal bounds.
    pub equalities: usize,
    /// Constraints with one bound, or two different ones.
    pub inequalities: usize,
    /// Constraints without bounds, which the solver drops.
    pub free_constraints: usize,
    /// Entries of the Jacobian pattern.
    pub jacobian_entries: usize,
    /// Entries of the lower triangle of the Hessian pattern.
    pub hessian_entries: usize,
}

impl ProblemStatistics {
    /// Counts of `problem`; evaluates nothing.
    ///
    /// # Examples
    /// ```
    /// use hangtime::nlp::{ElementProblemBuilder, ProblemStatistics, Target};
    ///
    /// let mut builder = ElementProblemBuilder::new();
    /// let x = [(0.0, 1.0), (0.0, f64::INFINITY)].map(|(l, u)| builder.variable(l, u, 0.5));
    /// let row = builder.row(1.0, 1.0);
    /// for x in x {
    ///     builder.linear(Target::Row(row), 1.0, x);
    /// }
    /// let statistics = ProblemStatistics::of(&builder.build()?);
    /// assert_eq!((statistics.two_sided, statistics.lower_bounded), (1, 1));
    /// assert_eq!((statistics.equalities, statistics.jacobian_entries), (1, 2));
    /// # Ok::<(), hangtime::nlp::InputError>(())
    /// ```
    pub fn of(problem: &dyn NlpProblem) -> Self {
        let (n, m) = (problem.variables(), problem.constraints());
        let mut statistics = Self {
            variables: n,
            jacobian_entries: problem.jacobian_pattern().len(),
            hessian_entries: problem.hessian_pattern().len(),
            ..Self::default()
        };
        let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
        problem.variable_bounds(&mut lower, &mut upper);
        for (l, u) in lower.iter().zip(&upper) {
            *match (l == u, l.is_finite(), u.is_finite()) {
                (true, _, _) => &mut statistics.fixed,
                (false, false, false) => &mut statistics.free,
                (false, true, false) => &mut statistics.lower_bounded,
                (false, false, true) => &mut statistics.upper_bounded,
                (false, true, true) => &mut statistics.two_sided,
            } += 1;
        }
        let (mut lower, mut upper) = (vec![0.0; m], vec![0.0; m]);
        problem.constraint_bounds(&mut lower, &mut upper);
        for (l, u) in lower.iter().zip(&upper) {
            *if l == u {
                &mut statistics.equalities
            } else if l.is_finite() || u.is_finite() {
                &mut statistics.inequalities
            } else {
                &mut statistics.free_constraints
            } += 1;
        }
        statistics
    }
}
