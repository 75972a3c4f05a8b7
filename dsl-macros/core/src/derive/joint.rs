//! What methods read of joints: positions and velocities of their rows, and their forces.

use super::contacts::Contacts;
use super::explicit::hessian;
use super::implicit::Locked;
use super::ldl::Factorization;
use super::{Sparse, jacobian, simplify};
use crate::graph::{Sym, Variable};
use crate::scene::{CheckedScene, Contact};

/// The functions of all joints.
pub(crate) struct JointEquations {
    /// The positions `g` of all rows, 0 of those of velocities, and then the velocities `w` of all.
    pub(crate) values: Vec<Sym>,
    pub(crate) jacobian: Sparse,
    /// Lower triangle of the Hessian of their weighted sum.
    pub(crate) hessian: Sparse,
    /// The forces, unless they are the rest of the solution of the system of motion.
    pub(crate) forces: Option<Vec<Sym>>,
}

/// What of the joints methods read, from the factors of the system where there are any; none without joints. `right` is what acts on
/// each coordinate.
pub(super) fn equations(
    scene: &CheckedScene,
    inertia: &Locked<'_>,
    (factors, right): (Option<&Factorization>, &[Sym]),
    inputs: &[Variable],
) -> Option<JointEquations> {
    if inertia.joints.is_empty() {
        return None;
    }
    let joints = scene.joints.iter();
    let positions = joints.flat_map(|joint| {
        let rows = joint.rows.iter();
        rows.map(|&row| {
            if joint.holonomic {
                simplify(row)
            } else {
                Sym::ZERO
            }
        })
    });
    let rates = inertia.joints.iter().map(|row| row.rate);
    let values: Vec<Sym> = positions.chain(rates).collect();
    let solution = factors.map(|factors| factors.solve(&inertia.right(right)));
    let behind = scene.coordinates.len();
    Some(JointEquations {
        jacobian: jacobian(&values, inputs),
        hessian: hessian(&values, inputs),
        values,
        forces: solution.map(|solution| solution[behind..].iter().map(|&mu| -mu).collect()),
    })
}

/// The forces of all rows as formulas, with those of contacts among them.
///
/// # Errors
/// The coordinate whose pivot is structurally zero.
pub(super) fn forces(
    inertia: &Locked<'_>,
    right: &[Sym],
    contacts: &Contacts,
    declared: &[Contact],
) -> Result<Vec<Sym>, usize> {
    let mut right = right.to_vec();
    for ((contact, declared), i) in contacts.iter().zip(declared).zip(0_u16..) {
        let mut push = |covector: &[Sym], force: Variable| {
            for (right, &component) in right.iter_mut().zip(covector) {
                *right += component * Sym::variable(force);
            }
        };
        if declared.bound.is_none() {
            push(&contact.normal, Variable::ContactForce(i));
        }
        if let Some(friction) = &contact.friction {
            push(&friction.tangent, Variable::FrictionForce(i));
        }
    }
    let solution = inertia.factorized()?.solve(&inertia.right(&right));
    let behind = inertia.size() - inertia.joints.len();
    Ok(solution[behind..].iter().map(|&mu| -mu).collect())
}
