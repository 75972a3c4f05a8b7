//! Velocity jumps: impacts, and the removal of what rounding leaves of held velocities.
//!
//! The law is Moreau's, with a coefficient of restitution `e_i` in the normal direction alone, as Newton's law, and Coulomb's friction
//! between the impulses and the sliding velocities after the impact:
//!
//! ```text
//! v+ = v- + sum_i d_i p_i + e_i s_i
//! 0 <= p_i  _|_  v_n,i+ + e_i min(v_n,i-, 0) >= 0
//! |s_i| <= mu_i p_i,   s_i v_t,i+ = -mu_i p_i |v_t,i+|
//! ```
//!
//! Source: Moreau, *Unilateral contact and dry friction in finite freedom dynamics* (1988).

use super::balance::Balance;
use super::line::Line;
use super::mode_error::ModeError;
use super::shares;
use super::touching::Touching;
use super::view::View;
use crate::model::pair_size;
use crate::yardstick;

/// Newton steps onto surfaces; the second already meets rounding error.
const STEPS: usize = 3;

/// The impact of contacts that touch, at the last evaluation of a view.
pub(crate) struct Blow {
    pub(crate) touching: Touching,
    /// Velocities of the lines that the impulses are to take: `v_n + e min(v_n, 0)` and `v_t`.
    pub(crate) offsets: Vec<f64>,
    /// Velocities that restitution sends back, `-e min(v_n, 0)`, one a contact.
    pub(crate) returned: Vec<f64>,
}

impl Blow {
    /// Of the contacts `together`, with a coefficient of `restitution` each. Velocities of lines up to their `zero` are none.
    pub(crate) fn new(
        view: &View<'_>,
        together: &[usize],
        restitution: &[f64],
        zero: impl Fn(Line) -> f64,
    ) -> Self {
        let touching = Touching::new(view, together, |_| true);
        let velocity = |&line: &Line| {
            let size = match line {
                Line::Normal { .. } => view.velocity(line),
                _ => pair_size(view.sliding(line.contact())),
            };
            if size.abs() > zero(line) {
                view.velocity(line)
            } else {
                0.0
            }
        };
        let mut offsets: Vec<f64> = touching.lines.iter().map(velocity).collect();
        let mut returned = Vec::with_capacity(together.len());
        for (velocity, e) in offsets.iter_mut().zip(restitution) {
            returned.push(-e * velocity.min(0.0));
            *velocity += e * velocity.min(0.0);
        }
        Self {
            touching,
            offsets,
            returned,
        }
    }
}

/// Normal velocities after an impact, by its impulses and the velocities `returned`.
pub(crate) fn velocities_after<'b>(
    balance: &'b Balance,
    returned: &'b [f64],
) -> impl Iterator<Item = f64> + 'b {
    let motions = balance.motions.iter().zip(returned);
    motions.map(|(velocity, returned)| velocity + returned)
}

/// Solves the impact of all contacts in `touching` at the last evaluation; adds the jump to `v` and returns the normal velocity
/// increments `p`.
pub(crate) fn strike(
    view: &View<'_>,
    touching: &[usize],
    restitution: &[f64],
    v: &mut [f64],
) -> Result<Vec<f64>, ModeError> {
    let blow = Blow::new(view, touching, restitution, |_| 0.0);
    let balance = Balance::first(blow.touching, view, &blow.offsets)?;
    balance.push(view, &balance.forces, v);
    Ok(balance.normals().to_vec())
}

/// Kinetic energies before and after an impact, where it has raised them.
pub(crate) fn gain(before: f64, after: f64) -> Option<(f64, f64)> {
    (after > before * (1.0 + yardstick::ROUNDING)).then_some((before, after))
}

/// Removes the velocities of these `lines` at the last evaluation from `v`, along their directions.
pub(crate) fn hold(contacts: &View<'_>, lines: &[Line], v: &mut [f64]) -> Result<(), ModeError> {
    let mut impulses: Vec<f64> = lines.iter().map(|&line| contacts.velocity(line)).collect();
    shares::hold(contacts, lines, &mut impulses)?;
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
    let mut shift: Vec<f64> = listed.iter().map(|&i| contacts.gap(i)).collect();
    shares::hold(contacts, &lines, &mut shift)?;
    for (&line, &value) in lines.iter().zip(&shift) {
        contacts.push(line, -value, q);
    }
    Ok(())
}

/// Takes the gaps of the listed contacts, and their normal velocities, at the state that begins `x`; nothing where they depend on each
/// other.
pub(crate) fn bring_to_rest(view: &mut View<'_>, listed: &[usize], x: &mut [f64]) {
    let n = view.n;
    let evaluate = |view: &mut View<'_>, x: &[f64]| {
        for &contact in listed {
            view.evaluate_sides(contact, x);
        }
    };
    evaluate(view, x);
    let normals: Vec<Line> = listed.iter().map(|&i| Line::normal(i)).collect();
    if !shares::are_independent(view, &normals) {
        return;
    }
    // What rubs is held once it is known how it slides.
    let rubs = listed.iter().any(|&i| view.has_friction(i));
    if !rubs && hold(view, &normals, &mut x[n..2 * n]).is_err() {
        return;
    }
    let q = x[..n].to_vec();
    for _ in 0..STEPS {
        if close_gaps(view, listed, &mut x[..n]).is_err() {
            x[..n].copy_from_slice(&q);
            return;
        }
        evaluate(view, x);
    }
}
