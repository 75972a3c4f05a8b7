//! How contacts share friction where several of them hold the same sliding velocity: the feet of a box, or a
//! block in a corner. The motion is unique, the shares are not; those of the complementarity problem are
//! kept, with one sticking contact for each independent sliding velocity.

use super::line::{Line, unbiased_lines};
use super::mode_error::ModeError;
use super::shares::Shares;
use super::state::{ActiveContact, ContactState};
use super::view::View;
use crate::linalg::dense;

/// Share of its own coupling that a line keeps while the others are held, below which it depends on them.
const DEPENDENT: f64 = 1e-10;

/// Friction of a contact as the complementarity problem gave it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Share {
    pub(crate) contact: usize,
    pub(crate) friction: f64,
    /// `mu r - |s|`, 0 on the edge of the cone.
    pub(crate) margin: f64,
}

/// Lets only independent contacts of `active` stick: first those inside their cone whose friction is not
/// zero, which a basic solution has for independent contacts only, so that the others keep the force that
/// `shares` says.
pub(crate) fn share_friction(
    contacts: &View<'_>,
    active: &mut [ActiveContact],
    shares: &[Share],
) -> Result<(), ModeError> {
    let share = |contact: usize| {
        shares
            .iter()
            .find(|share| share.contact == contact)
            .copied()
            .unwrap_or(Share {
                contact,
                friction: 0.0,
                margin: f64::INFINITY,
            })
    };
    let mut sticking: Vec<usize> = (0..active.len())
        .filter(|&k| active[k].state.sticks())
        .collect();
    if sticking.is_empty() {
        return Ok(());
    }
    sticking.sort_by_key(|&k| {
        let share = share(active[k].contact);
        (share.friction == 0.0, share.margin == 0.0)
    });
    for &k in &sticking {
        active[k].state = ContactState::Held(None);
    }
    for k in sticking {
        let Share {
            contact,
            friction,
            margin,
        } = share(active[k].contact);
        let tangent = Line::tangent(contact);
        let independent = is_independent(contacts, active, tangent)?;
        active[k].state = if contacts.is_in_space(contact) {
            // Whatever others hold: how they share their load is asked for as long as they hold.
            ContactState::StickInSpace
        } else if independent {
            ContactState::Stick
        } else if margin > 0.0 {
            ContactState::Held(None)
        } else {
            ContactState::at_edge(-friction)
        };
    }
    Ok(())
}

/// Lets only independent contacts of `active` stick; the others carry no friction.
pub(crate) fn drop_dependent_sticks(
    contacts: &View<'_>,
    active: &mut [ActiveContact],
) -> Result<(), ModeError> {
    share_friction(contacts, active, &[])
}

/// Whether the velocity of `line` is free while the `active` contacts hold theirs.
pub(crate) fn is_independent(
    contacts: &View<'_>,
    active: &[ActiveContact],
    line: Line,
) -> Result<bool, ModeError> {
    is_free(contacts, &unbiased_lines(active), line)
}

/// Whether the velocity of `line` is free while others are `held`.
pub(crate) fn is_free(contacts: &View<'_>, held: &[Line], line: Line) -> Result<bool, ModeError> {
    let own = contacts.coupling(line, line);
    let free = reduced_couplings(contacts, held, &[line])?;
    Ok(free[0] > DEPENDENT * own)
}

/// Couplings of `lines` while the `held` ones keep their velocity: `D_UU - D_UH D_HH^-1 D_HU`.
pub(crate) fn reduced_couplings(
    contacts: &View<'_>,
    held: &[Line],
    lines: &[Line],
) -> Result<Vec<f64>, ModeError> {
    let mut matrix = contacts.couplings(lines);
    if held.is_empty() {
        return Ok(matrix);
    }
    let couplings = contacts.couplings(held);
    let mut factors = couplings.clone();
    let mut pivots = vec![0; held.len()];
    let independent = dense::factorize_independent(&mut factors, &mut pivots);
    for (column, &j) in lines.iter().enumerate() {
        let mut response: Vec<f64> = held.iter().map(|&h| contacts.coupling(h, j)).collect();
        if independent {
            dense::solve(&factors, &pivots, &mut response);
        } else {
            response = Shares::of(contacts, held, &couplings, &response)?.forces;
        }
        for (row, &i) in lines.iter().enumerate() {
            let through: f64 = held
                .iter()
                .zip(&response)
                .map(|(&h, value)| contacts.coupling(i, h) * value)
                .sum();
            matrix[row * lines.len() + column] -= through;
        }
    }
    Ok(matrix)
}
