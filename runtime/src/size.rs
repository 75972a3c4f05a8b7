//! How large a discrete system is.

use hangtime_solver::ProblemSize;
use hangtime_solver::mpcc::Mpcc;
use serde::Serialize;

/// The size of one formulation of a scene: what its solver sees. Variables whose bounds fix them are numbers, and rows
/// without bounds do not exist.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct FormulationSize {
    /// Which formulation.
    pub formulation: String,
    /// On which grid.
    pub discretization: String,
    /// How much.
    pub size: ProblemSize,
}

/// The size of an assembled program, without what the solver takes out: fixed variables, and rows
/// without bounds.
pub(crate) fn assembled(program: &dyn Mpcc) -> ProblemSize {
    let (variables, rows) = (program.variables(), program.constraints());
    let (mut lower, mut upper) = (vec![0.0; variables], vec![0.0; variables]);
    program.variable_bounds(&mut lower, &mut upper);
    let free: Vec<bool> = lower.iter().zip(&upper).map(|(l, u)| l < u).collect();
    let (mut lower, mut upper) = (vec![0.0; rows], vec![0.0; rows]);
    program.constraint_bounds(&mut lower, &mut upper);
    let bounds = lower.iter().zip(&upper);
    let bounded: Vec<bool> = bounds
        .map(|(l, u)| l.is_finite() || u.is_finite())
        .collect();
    let count = |flags: &[bool]| flags.iter().filter(|flag| **flag).count();
    let both = |list: &[(usize, usize)], of_first: &[bool]| {
        let own = list.iter().filter(|&&(i, j)| of_first[i] && free[j]);
        own.count()
    };
    let equalities = lower.iter().zip(&upper).filter(|(l, u)| l == u).count();
    ProblemSize {
        variables: count(&free),
        equalities,
        inequalities: count(&bounded) - equalities,
        complementarities: both(program.complementarities(), &free),
        jacobian_nonzeros: both(&program.jacobian_pattern(), &bounded),
        hessian_nonzeros: both(&program.hessian_pattern(), &free),
    }
}
