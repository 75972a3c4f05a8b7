//! Velocity jumps: impacts, and the removal of what rounding leaves of held velocities.

use super::line::{Line, unbiased_lines};
use super::mode_error::ModeError;
use super::state::ActiveContact;
use super::touching::Touching;
use super::view::View;
use crate::linalg::dense;

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
    contacts: &View<'_>,
    touching: &[usize],
    restitution: &[f64],
    p: &mut Vec<f64>,
    v: &mut [f64],
) -> Result<(), ModeError> {
    let touching = Touching::new(contacts, touching, |_| true);
    let mut offsets: Vec<f64> = touching
        .lines
        .iter()
        .map(|&line| contacts.velocity(line))
        .collect();
    for (velocity, e) in offsets.iter_mut().zip(restitution) {
        *velocity += e * velocity.min(0.0);
    }
    let balance = touching.balance(contacts, &offsets)?;
    balance.push(contacts, &balance.forces, v);
    p.clear();
    p.extend(balance.normals());
    Ok(())
}

/// Removes the normal velocities of the `active` contacts at the last evaluation, and the sliding
/// velocities of those that stick, from `v`, along their directions.
pub(crate) fn hold(
    contacts: &View<'_>,
    active: &[ActiveContact],
    v: &mut [f64],
) -> Result<(), ModeError> {
    let lines = unbiased_lines(active);
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
    contacts: &View<'_>,
    listed: &[usize],
    q: &mut [f64],
) -> Result<(), ModeError> {
    let lines: Vec<Line> = listed.iter().map(|&i| Line::normal(i)).collect();
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
