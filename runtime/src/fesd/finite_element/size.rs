//! How large the system of an element is: the entries of its assembled matrix.

use hangtime_solver::ProblemSize;

use super::{FiniteElement, assembly};
use crate::model::surfaces;

/// The size of an element at its present stages, whose factors it leaves as they are. Inequalities are the signs that are
/// watched at each stage: of the gap or the force of each surface, and of each friction.
pub(crate) fn size(element: &mut FiniteElement<'_>) -> ProblemSize {
    let factors = std::mem::take(&mut element.matrix);
    assembly::assemble(element);
    let matrix = std::mem::replace(&mut element.matrix, factors);
    let rubbing = element.active().iter().filter(|held| held.state.rubs());
    let signs = surfaces(element.model) + rubbing.count();
    ProblemSize {
        variables: element.variables(),
        equalities: element.variables(),
        inequalities: element.tableau.stages() * signs,
        jacobian_nonzeros: matrix.iter().filter(|entry| **entry != 0.0).count(),
        ..ProblemSize::default()
    }
}
