//! Explicit functions of the input vector, as operations that may be carried out on ranges of numbers.

use super::contact::Contact;
use super::kernel::Kernel;

/// What an explicit function is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ExplicitFunction {
    /// The gap of a surface.
    Gap(usize),
    /// Normal velocity, curvature and normal of a contact.
    Normal(usize),
    /// Sliding velocity, curvature and tangent of a contact with friction.
    Tangent(usize),
    /// Second sliding velocity in space, curvature and tangent of a contact with friction.
    Across(usize),
    /// The factor that the direction of friction of a contact carries, where it carries one.
    Share(usize),
    /// Accelerations without contact, or the matrix and the right-hand side of the linear system that they solve.
    Motion,
}

/// Those of the contact with index `i` in a scene of `n` coordinates, of the kernels that compute them as well.
pub(super) fn of_contact(
    kernels: &[Kernel],
    n: usize,
    (i, dry, contact): (usize, bool, &Contact),
) -> Vec<(ExplicitFunction, Kernel)> {
    let mut functions = Vec::new();
    if !dry {
        let gap = kernels[contact.gap].part([0]);
        functions.push((ExplicitFunction::Gap(i), gap));
    }
    // The inverse inertia stands before the normal.
    let normal = kernels[contact.point].part([1, 2].into_iter().chain(4..4 + n));
    functions.push((ExplicitFunction::Normal(i), normal));
    if let Some(friction) = &contact.friction {
        let side = |kernel: usize| kernels[kernel].part(0..2 + n);
        functions.push((ExplicitFunction::Tangent(i), side(friction.tangent)));
        if let Some(share) = friction.share {
            functions.push((ExplicitFunction::Share(i), kernels[share].clone()));
        }
        if let Some((across, _)) = friction.across {
            functions.push((ExplicitFunction::Across(i), side(across)));
        }
    }
    functions
}
