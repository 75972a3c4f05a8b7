//! Impacts at edges: which piece of a surface acts where several vanish together, and which impacts pass an edge by.
//!
//! The largest of some gaps is not negative where one of them is not, so at an edge all motions are free that leave one
//! of its pieces: `max_i v_n,i >= 0`. The contact acts only against the others. Where other contacts are struck at the
//! very instant at which a body is at an edge, their impulses alone decide whether there is one of the edge.

use super::view::View;

/// What counts as zero at a contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Zeros {
    /// Gap up to which it is closed.
    pub(crate) gap: f64,
    /// Rounding error of the gap.
    pub(crate) gap_rounding: f64,
    /// Difference of normal velocities that is rounding error.
    pub(crate) rounding: f64,
    /// Normal velocity up to which it neither approaches nor leaves.
    pub(crate) velocity: f64,
}

/// Of contacts that touch, those at edges that their velocities leave, and the others.
#[derive(Debug, Clone)]
pub(crate) struct Edges {
    pub(crate) edges: Vec<usize>,
    pub(crate) others: Vec<usize>,
    /// Whether the piece that acts stands against a motion that another one sets free, where surfaces meet; the very edge of a
    /// single one is struck.
    pub(crate) blocked: bool,
}

/// The pieces of the edges of contacts.
pub(crate) fn pieces<'v>(
    view: &View<'v>,
    contacts: &'v [usize],
) -> impl Iterator<Item = usize> + use<'v> {
    let declared = view.model.declaration().contacts;
    contacts
        .iter()
        .flat_map(|&i| declared[i].alternatives)
        .copied()
}

/// The piece whose gap is the largest from here on, of those of the edge of a contact that vanish together with it, and its
/// normal velocity; all are evaluated. Where they stay equal, the contact itself. `None` where no other piece vanishes.
fn tied(view: &View<'_>, contact: usize, zeros: impl Fn(usize) -> Zeros) -> Option<(usize, f64)> {
    let others = view.model.declaration().contacts[contact].alternatives;
    let mut least = None;
    for &other in others {
        let zeros = zeros(other);
        if view.gap(other) > zeros.gap {
            continue;
        }
        let (_, behind) = *least.get_or_insert((contact, 0.0));
        // That of an idle piece is how fast the acting one moves away from it.
        let ahead = view.normal_velocity(other);
        if ahead < behind - zeros.rounding {
            least = Some((other, ahead));
        }
    }
    least.map(|(piece, ahead)| (piece, view.normal_velocity(contact) - ahead))
}

/// The piece whose gap is the largest from here on and its normal velocity, or the contact itself where it is at no edge.
pub(crate) fn leading(
    view: &View<'_>,
    contact: usize,
    zeros: impl Fn(usize) -> Zeros,
) -> (usize, f64) {
    tied(view, contact, zeros).unwrap_or((contact, view.normal_velocity(contact)))
}

/// Which of the `touching` contacts are at edges, where the impact of the others may pass them by; `None` where none may.
pub(crate) fn at_edges(
    view: &View<'_>,
    touching: &[usize],
    zeros: impl Fn(usize) -> Zeros + Copy,
) -> Option<Edges> {
    let leaves = |&i: &usize| {
        tied(view, i, zeros).is_some_and(|(_, velocity)| velocity >= -zeros(i).velocity)
    };
    let (edges, others): (Vec<usize>, Vec<usize>) = touching.iter().partition(|&i| leaves(i));
    let approaches = |&i: &usize| view.normal_velocity(i) < -zeros(i).velocity;
    let blocked = touching.len() > 1 && edges.iter().any(approaches);
    let passes = !edges.is_empty() && (!others.is_empty() || blocked);
    passes.then_some(Edges {
        edges,
        others,
        blocked,
    })
}

impl Edges {
    /// The pieces that lead on from the edges, with their normal velocities, after an impact of the others; `None` where one of them is not
    /// free.
    pub(crate) fn leads(
        &self,
        view: &View<'_>,
        zeros: impl Fn(usize) -> Zeros + Copy,
    ) -> Option<Vec<(usize, f64)>> {
        let leads = self.edges.iter().map(|&i| {
            let lead = leading(view, i, zeros);
            (lead.1 >= -zeros(i).velocity).then_some(lead)
        });
        leads.collect()
    }
}
