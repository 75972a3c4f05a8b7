//! Dry friction whose bound follows forces of joints.
//!
//! The force of a joint is linear in those of contacts, normal and tangential ones,
//!
//! ```text
//! lambda = lambda_0(q, v, u, t) + sum_i c_i(q, t) f_i + sum_i b_i(q, t) s_i
//! ```
//!
//! among them the friction itself, as in a brake that pulls its own lever. So a bound that follows it is a given one, what
//! it follows of surfaces, and what it follows of friction.

use super::contact::Mechanism;
use super::contacts::Contacts;
use super::failure::Failure;
use super::implicit::Locked;
use super::{joint, simplify};
use crate::graph::{self, Sym, Variable};
use crate::scene::Contact;

/// All contacts of a scene with this inertia, where `right` acts on each coordinate.
pub(super) fn contacts(
    mechanism: &Mechanism<'_>,
    declared: &[Contact],
    (inertia, right): (&Locked<'_>, &[Sym]),
) -> Result<Contacts, Failure> {
    let derived = mechanism.contacts(declared)?;
    if declared
        .iter()
        .all(|contact| contact.joint_loads.is_empty())
    {
        return Ok(derived);
    }
    let forces = joint::forces(inertia, right, &derived, declared);
    let forces = forces.map_err(|coordinate| Failure::SingularMass { coordinate })?;
    let mut resolved: Vec<Contact> = declared.to_vec();
    let mut frictions = vec![Vec::new(); declared.len()];
    for (contact, rubs) in resolved.iter_mut().zip(&mut frictions) {
        let loads = std::mem::take(&mut contact.joint_loads).into_iter();
        let followed: Sym = loads
            .map(|(row, factor)| factor * forces[usize::from(row)])
            .sum();
        for variable in graph::variables(&[followed]) {
            let factor = || simplify(graph::partial(&[followed], variable)[0]);
            match variable {
                Variable::ContactForce(i) => contact.loads.push((i, factor())),
                Variable::FrictionForce(i) => rubs.push((i, factor())),
                _ => {}
            }
        }
        let unloaded = |variable: Variable| variable.is_force().then_some(Sym::ZERO);
        let given = graph::substitute(&[followed], unloaded)[0];
        contact.bound = contact.bound.map(|bound| simplify(bound + given));
    }
    let mut contacts = mechanism.contacts(&resolved)?;
    for (following, factors) in frictions.iter().enumerate() {
        mechanism.follow_frictions(&mut contacts, &resolved, (following, factors))?;
    }
    Ok(contacts)
}
