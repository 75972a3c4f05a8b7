//! How large a program is.

use serde::Serialize;

use crate::nlp::NlpProblem;

/// Size of a program, or of a system of equations.
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
    /// Size of a program with that many complementarity pairs.
    #[must_use]
    pub fn of(program: &dyn NlpProblem, complementarities: usize) -> Self {
        let rows = program.constraints();
        let (mut lower, mut upper) = (vec![0.0; rows], vec![0.0; rows]);
        program.constraint_bounds(&mut lower, &mut upper);
        let equalities = lower.iter().zip(&upper).filter(|(l, u)| l == u).count();
        Self {
            variables: program.variables(),
            equalities,
            inequalities: rows - equalities,
            complementarities,
            jacobian_nonzeros: program.jacobian_pattern().len(),
            hessian_nonzeros: program.hessian_pattern().len(),
        }
    }
}
