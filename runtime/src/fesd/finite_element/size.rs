//! How large the system of an element is: the entries of its assembled matrix.

use hangtime_solver::ProblemSize;

use super::{FiniteElement, State, assembly, newton};
use crate::model::{ControlPiece, surfaces};

/// The size of an element in its contact mode from a `start`, a place where nothing vanishes by chance, to one that long.
/// Inequalities are the signs that are watched at each stage: of the gap or the force of each surface, and of each friction.
pub(crate) fn size(
    element: &mut FiniteElement<'_>,
    start: &State,
    (length, controls): (f64, &ControlPiece),
) -> ProblemSize {
    // Where there is no such motion the first matrix is that of its stages.
    let _ = newton::solve(element, start, length, controls);
    assembly::assemble(element);
    let rubbing = element.active().iter().filter(|held| held.state.rubs());
    let signs = surfaces(element.model) + rubbing.count();
    ProblemSize {
        variables: element.variables(),
        equalities: element.variables(),
        inequalities: element.tableau.stages() * signs,
        jacobian_nonzeros: element.matrix.iter().filter(|entry| **entry != 0.0).count(),
        ..ProblemSize::default()
    }
}
