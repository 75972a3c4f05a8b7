//! How large a program is.

use serde::Serialize;

use crate::mpcc::Mpcc;

/// Size of a program, or of a system of equations, as its solver sees it: variables whose bounds fix them are numbers, and
/// rows without bounds do not exist.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct ProblemSize {
    /// Unknowns.
    pub variables: usize,
    /// Equations.
    pub equalities: usize,
    /// Inequalities that are checked or imposed.
    pub inequalities: usize,
    /// Complementarity pairs.
    pub complementarities: usize,
    /// Structural nonzeros of the Jacobian.
    pub jacobian_nonzeros: usize,
    /// Structural nonzeros of the Hessian (lower triangle).
    pub hessian_nonzeros: usize,
}

impl ProblemSize {
    /// Size of an assembled program.
    #[must_use]
    pub fn of(program: &dyn Mpcc) -> Self {
        let (variables, rows) = (program.variables(), program.constraints());
        let (mut lower, mut upper) = (vec![0.0; variables], vec![0.0; variables]);
        program.variable_bounds(&mut lower, &mut upper);
        let free: Vec<bool> = lower.iter().zip(&upper).map(|(l, u)| l < u).collect();
        let (mut lower, mut upper) = (vec![0.0; rows], vec![0.0; rows]);
        program.constraint_bounds(&mut lower, &mut upper);
        let bounds = || lower.iter().zip(&upper);
        let bounded = bounds().map(|(l, u)| l.is_finite() || u.is_finite());
        let bounded: Vec<bool> = bounded.collect();
        let count = |flags: &[bool]| flags.iter().filter(|flag| **flag).count();
        let both = |list: &[(usize, usize)], of_first: &[bool]| {
            let own = list.iter().filter(|&&(i, j)| of_first[i] && free[j]);
            own.count()
        };
        let equalities = bounds().filter(|(l, u)| l == u).count();
        Self {
            variables: count(&free),
            equalities,
            inequalities: count(&bounded) - equalities,
            complementarities: both(program.complementarities(), &free),
            jacobian_nonzeros: both(&program.jacobian_pattern(), &bounded),
            hessian_nonzeros: both(&program.hessian_pattern(), &free),
        }
    }
}
