//! Velocity jumps: impacts, and the removal of what rounding leaves of held velocities.

use super::contacts::{Contacts, Line, ModeError};
use super::coulomb::{self, Cone};
use crate::contact::ActiveContact;
use crate::linalg::dense;

/// The lines of the `listed` contacts at which forces are sought, normals first, and the cones of those with
/// friction for which `in_cone` holds; the others slip already.
pub(super) fn coulomb_lines(
    contacts: &Contacts<'_>,
    listed: &[usize],
    in_cone: impl Fn(usize) -> bool,
) -> (Vec<Line>, Vec<Cone>) {
    let (mut lines, mut tangents, mut cones) = (Vec::new(), Vec::new(), Vec::new());
    let mut acrosses = Vec::new();
    for (normal, &contact) in listed.iter().enumerate() {
        let friction = contacts.friction(contact);
        let mut slope = 0.0;
        if friction > 0.0 && in_cone(contact) {
            let sense = 1.0;
            tangents.push(Line::Tangent { contact, sense });
            if contacts.is_in_space(contact) {
                acrosses.push((cones.len(), Line::Across { contact }));
            }
            cones.push(contacts.cone(contact, normal));
        } else if friction > 0.0 {
            slope = -contacts.kinetic(contact) * contacts.side(contact).signum();
        }
        lines.push(Line::Normal { contact, slope });
    }
    lines.extend(tangents);
    add_acrosses(&mut lines, &mut cones, acrosses);
    (lines, cones)
}

/// Adds the lines of the second tangents of some cones.
pub(super) fn add_acrosses(
    lines: &mut Vec<Line>,
    cones: &mut [Cone],
    acrosses: Vec<(usize, Line)>,
) {
    for (cone, line) in acrosses {
        cones[cone].across = Some(lines.len());
        lines.push(line);
    }
}

/// Solves the impact of all contacts in `touching` at the last evaluation; writes the normal
/// velocity increments `p` and adds the jump to `v`.
///
/// Moreau's law with `restitution` (one coefficient a touching contact), and planar Coulomb friction
/// between impulses and the sliding velocity after the impact:
///
/// ```text
/// 0 <= p _|_ v_n+ + e v_n- >= 0     |s| <= mu p,  s = -mu p sign(v_t+) unless v_t+ = 0
/// ```
pub(crate) fn strike(
    contacts: &Contacts<'_>,
    touching: &[usize],
    restitution: &[f64],
    p: &mut Vec<f64>,
    v: &mut [f64],
) -> Result<(), ModeError> {
    let (lines, cones) = coulomb_lines(contacts, touching, |_| true);
    let mut offsets: Vec<f64> = lines.iter().map(|&line| contacts.velocity(line)).collect();
    for (velocity, e) in offsets.iter_mut().zip(restitution) {
        *velocity += e * velocity.min(0.0);
    }
    p.clear();
    p.resize(lines.len(), 0.0);
    coulomb::solve(&contacts.couplings(&lines), &offsets, &cones, p)?;
    for (&line, &impulse) in lines.iter().zip(&*p) {
        contacts.push(line, impulse, v);
    }
    p.truncate(touching.len());
    Ok(())
}

/// Removes the normal velocities of the `active` contacts at the last evaluation, and the sliding
/// velocities of those that stick, from `v`, along their directions.
pub(crate) fn hold(
    contacts: &Contacts<'_>,
    active: &[ActiveContact],
    v: &mut [f64],
) -> Result<(), ModeError> {
    let lines = crate::contact::unbiased_lines(active);
    let mut factors = contacts.couplings(&lines);
    let mut pivots = vec![0; lines.len()];
    let mut impulses: Vec<f64> = lines.iter().map(|&line| contacts.velocity(line)).collect();
    dense::factorize(&mut factors, &mut pivots).map_err(|_| ModeError::Dependent)?;
    dense::solve(&factors, &pivots, &mut impulses);
    for (&line, &impulse) in lines.iter().zip(&impulses) {
        contacts.push(line, -impulse, v);
    }
    Ok(())
}

/// One Newton step on `q` towards `g_i = 0` of the listed contacts, from the last evaluation.
pub(crate) fn close_gaps(
    contacts: &Contacts<'_>,
    listed: &[usize],
    q: &mut [f64],
) -> Result<(), ModeError> {
    let normal = |&contact: &usize| Line::Normal {
        contact,
        slope: 0.0,
    };
    let lines: Vec<Line> = listed.iter().map(normal).collect();
    let mut factors = contacts.couplings(&lines);
    let mut pivots = vec![0; listed.len()];
    let mut shift: Vec<f64> = listed.iter().map(|&i| contacts.gap(i)).collect();
    dense::factorize(&mut factors, &mut pivots).map_err(|_| ModeError::Dependent)?;
    dense::solve(&factors, &pivots, &mut shift);
    for (&line, &value) in lines.iter().zip(&shift) {
        contacts.push(line, -value, q);
    }
    Ok(())
}
