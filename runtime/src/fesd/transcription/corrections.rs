//! Positions of a known motion that stay on curved surfaces.
//!
//! While a contact is closed, the lifted gap and the normal velocity vanish at every stage. Where the normal turns, or the surface
//! moves, coordinates drift off the surface all the same, by the error of the scheme, and a goal that lies on it may have no motion.
//! Each stage `m` of such a contact has an unknown `mu_m` more, and each end without a stage, and a row:
//!
//! ```text
//! q_m = q_e + h_e s_k sum_j a_mj F(Y_j, u_k, z_j) + d mu_m        G_m = g(q_m)
//! ```
//!
//! with the contact direction `d` of the guess at the first stage of the element. As the matrix of the scheme is regular, this is the
//! stabilised system of index 2 (Gear, Gupta, Leimkuhler 1985), `q' = v + d mu`. What is flat and at rest needs none of it.

use super::{Correction, Element, Transcription};
use crate::dcs;

/// Sets the directions at a point.
pub(super) fn set_directions(transcription: &mut Transcription<'_>, x: &[f64]) {
    let n = transcription.dcs.system.coordinates();
    for e in 0..transcription.elements.len() {
        let mut corrections = std::mem::take(&mut transcription.elements[e].corrections);
        for correction in &mut corrections {
            evaluate(transcription, x, e, 0);
            let system = &transcription.dcs.system;
            let direction = (0..n).map(|k| system.auxiliary(correction.contact, k));
            let a_bar = system.auxiliary_acceleration;
            correction.direction = direction.map(|d| d / a_bar).collect();
        }
        transcription.elements[e].corrections = corrections;
    }
}

/// Evaluates the local rows of a block.
fn evaluate(transcription: &mut Transcription<'_>, x: &[f64], e: usize, block: usize) {
    transcription.gather(x, e, block);
    transcription
        .dcs
        .rows(&transcription.local, &mut transcription.rows);
}

/// The contact that a variable of an element corrects, and in which block.
pub(super) fn corrected_by(element: &Element, variable: usize) -> Option<(usize, usize)> {
    let blocks = element.blocks.len();
    let of = |c: &Correction| Some((c.contact, variable.checked_sub(c.first)?));
    let mut places = element.corrections.iter().filter_map(of);
    places.find(|(_, block)| *block < blocks)
}

/// Whether a row of an element keeps coordinates on a surface.
pub(super) fn owns_row(element: &Element, row: usize) -> bool {
    let blocks = element.blocks.len();
    let mut corrections = element.corrections.iter();
    corrections.any(|c| (c.rows..c.rows + blocks).contains(&row))
}

/// Adds the corrections to the rows of collocation, and writes the rows of the gaps.
pub(super) fn write_rows(transcription: &mut Transcription<'_>, x: &[f64], c: &mut [f64]) {
    let states = transcription.dcs.layout.states();
    for e in 0..transcription.elements.len() {
        let corrections = std::mem::take(&mut transcription.elements[e].corrections);
        let collocation = transcription.elements[e].collocation_rows;
        for correction in &corrections {
            let gap = transcription.dcs.layout.lifted_gap(correction.contact);
            for m in 0..transcription.elements[e].blocks.len() {
                for (k, d) in correction.direction.iter().enumerate() {
                    c[collocation + m * states + k] -= d * x[correction.first + m];
                }
                evaluate(transcription, x, e, m);
                c[correction.rows + m] =
                    transcription.local[gap] - transcription.dcs.system.gap(correction.contact);
            }
        }
        transcription.elements[e].corrections = corrections;
    }
}

/// Entries of the Jacobian of what [`write_rows`] writes, always in the same order.
pub(super) fn add_jacobian(
    transcription: &mut Transcription<'_>,
    x: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let states = transcription.dcs.layout.states();
    for e in 0..transcription.elements.len() {
        let element = transcription.elements[e].clone();
        for correction in &element.corrections {
            let gap = transcription.dcs.layout.lifted_gap(correction.contact);
            for (m, block) in element.blocks.iter().enumerate() {
                for (k, d) in correction.direction.iter().enumerate() {
                    let row = element.collocation_rows + m * states + k;
                    add(row, correction.first + m, -d);
                }
                evaluate(transcription, x, e, m);
                let row = correction.rows + m;
                if let Some(gap) = block.variables[gap] {
                    add(row, gap, 1.0);
                }
                dcs::gap_gradient(
                    &mut transcription.dcs,
                    correction.contact,
                    |place, value| {
                        if let Some(variable) = block.variables[place] {
                            add(row, variable, -value);
                        }
                    },
                );
            }
        }
    }
}

/// Entries of the Hessian of the weighted rows of the gaps, always in the same order.
pub(super) fn add_hessian(
    transcription: &mut Transcription<'_>,
    x: &[f64],
    multipliers: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    for e in 0..transcription.elements.len() {
        let element = transcription.elements[e].clone();
        for correction in &element.corrections {
            for (m, block) in element.blocks.iter().enumerate() {
                evaluate(transcription, x, e, m);
                let weight = -multipliers[correction.rows + m];
                let contact = correction.contact;
                dcs::gap_hessian(&mut transcription.dcs, contact, weight, |i, j, value| {
                    if let (Some(a), Some(b)) = (block.variables[i], block.variables[j]) {
                        add(a, b, value);
                    }
                });
            }
        }
    }
}
