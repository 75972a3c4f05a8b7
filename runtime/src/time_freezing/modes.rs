//! What each contact does in each element, read off a relaxed point, and what vanishes for it.

use super::conditions;
use super::layout::{ALPHA, P, W};
use super::transcription::{SUMS, Transcription};
use hangtime_solver::mpcc::Mpcc as _;

/// Factor of `sqrt(sigma)` below which both sides of a relaxed pair count as zero: at `x_i x_j = sigma` the
/// smaller one is at most `sqrt(sigma)`.
const BOTH_ZERO: f64 = 3.0;

/// What a contact does in an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// `beta = 0` and `ln = 0`: the surface does not act.
    Free,
    /// `alpha = 0` and `lp = 0`: the clock stands while the normal velocity is brought to zero.
    Jump,
    /// `lp = ln = 0`: `alpha` is what keeps the lifted gap at zero.
    Contact,
}

/// Which paired variables, and which terms of paired sums, vanish near `x`.
pub(crate) fn mark_vanishing(transcription: &Transcription<'_>, x: &[f64], vanishes: &mut [bool]) {
    let pairs = transcription.program.complementarities().iter();
    let products = pairs.map(|&(i, j)| x[i] * x[j]);
    let zero = BOTH_ZERO * products.fold(0.0, f64::max).sqrt();
    let modes = modes(transcription, x, zero);
    mark_modes(transcription, x, zero, &modes, vanishes);
    let contacts = transcription.field.layout.contacts;
    conditions::mark_vanishing(transcription, x, vanishes);
    for e in 0..transcription.elements.len() {
        for group in (0..transcription.groups.len())
            .filter(|&g| g >= contacts || transcription.field.layout.bounces(g))
        {
            mark_group(transcription, x, zero, (e, group), vanishes);
        }
    }
    for (k, (first, second)) in transcription
        .field
        .layout
        .stage_pairs()
        .into_iter()
        .enumerate()
    {
        if k < contacts && !transcription.field.layout.bounces(k) {
            continue;
        }
        for block in transcription
            .elements
            .iter()
            .flat_map(|element| &element.blocks)
        {
            if let (Some(i), Some(j)) = (block.variables[first], block.variables[second]) {
                let both = !block.boundary && x[i].max(x[j]) <= zero;
                vanishes[i] |= x[i] < x[j] || both;
                vanishes[j] |= x[j] <= x[i] || both;
            }
        }
    }
}

/// Marks the sums of a group that is decided pair by pair: a weight of friction or restitution, or the step
/// function of a contact that bounces. What vanishes in a stage vanishes in all of the element; both sides
/// vanish where both are small.
fn mark_group(
    transcription: &Transcription<'_>,
    x: &[f64],
    zero: f64,
    (e, group): (usize, usize),
    vanishes: &mut [bool],
) {
    let first = transcription.elements[e].sums + SUMS * group;
    for pair in [0, 2] {
        let (weight, multiplier) = (x[first + pair], x[first + pair + 1]);
        if weight < multiplier || weight <= zero && multiplier <= zero {
            mark_sum(transcription, e, group, pair, vanishes);
        }
        if weight >= multiplier || multiplier <= zero {
            mark_sum(transcription, e, group, pair + 1, vanishes);
        }
    }
}

/// Mode of each contact in each element near the relaxed point `x`, contacts of an element side by side;
/// `zero` is the size up to which both sides of a pair count as zero.
fn modes(transcription: &Transcription<'_>, x: &[f64], zero: f64) -> Vec<Mode> {
    let mut modes =
        Vec::with_capacity(transcription.elements.len() * transcription.field.layout.contacts);
    for element in &transcription.elements {
        for contact in 0..transcription.field.layout.contacts {
            let sum = |k: usize| x[element.sums + SUMS * contact + k];
            let (alpha, ln, beta, lp) = (sum(0), sum(1), sum(2), sum(3));
            modes.push(if alpha < ln || alpha <= zero {
                Mode::Jump
            } else if beta < lp {
                Mode::Free
            } else {
                Mode::Contact
            });
        }
    }
    modes
}

/// Which variables of the contacts without restitution vanish in these modes, and on which side of the pair `p _|_ w` near `x`.
///
/// What vanishes in a stage vanishes in all of the element, terms with their sum, since a sum of zero leaves
/// its nonnegative terms no interior. For the same reason everything vanishes that the mode leaves no other
/// value:
///
/// - in contact `G + p = 0` at every stage. The lifted gap is zero at the start, so that `theta v_n = 0`
///   there: either `v_n = 0`, and `p = w = 0`, or the step function is zero and `w = -v_n > 0`, where a jump
///   shares the element with the contact after it. Which of the two, the smaller of `theta` and `w` says. At
///   the end of an element without a stage there only `p = 0` follows.
/// - in a jump `G` does not change. From gap zero, `ln = p = 0`.
pub(super) fn mark_modes(
    transcription: &Transcription<'_>,
    x: &[f64],
    zero: f64,
    modes: &[Mode],
    vanishes: &mut [bool],
) {
    let contacts = transcription.field.layout.contacts;
    for (e, element) in transcription.elements.iter().enumerate() {
        for contact in (0..contacts).filter(|&contact| !transcription.field.layout.bounces(contact))
        {
            let mut mode = modes[e * contacts + contact];
            if mode == Mode::Contact && mark_contact(transcription, x, e, contact, vanishes) {
                mode = Mode::Jump;
            }
            let first = element.sums + SUMS * contact;
            let (alpha, ln, beta, lp) = (0, 1, 2, 3);
            let from_zero = x[first + ln] <= zero;
            let sums: &[usize] = match mode {
                Mode::Free => &[ln, beta],
                Mode::Contact => &[ln, lp],
                Mode::Jump if from_zero => &[alpha, ln, lp],
                Mode::Jump => &[alpha, lp],
            };
            for &sum in sums {
                mark_sum(transcription, e, contact, sum, vanishes);
            }
            if mode == Mode::Contact {
                continue;
            }
            for block in &element.blocks {
                let place =
                    |offset| block.variables[transcription.field.layout.algebraic(contact, offset)];
                if let (Some(p), Some(w)) = (place(P), place(W)) {
                    let p_vanishes = x[p] < x[w] || mode == Mode::Jump && from_zero;
                    vanishes[p] = p_vanishes;
                    vanishes[w] = !p_vanishes;
                }
            }
        }
    }
}

/// Marks `p`, `w` and step functions at the stages of an element in contact; `true` if the step function
/// vanishes at every stage.
fn mark_contact(
    transcription: &Transcription<'_>,
    x: &[f64],
    e: usize,
    contact: usize,
    vanishes: &mut [bool],
) -> bool {
    let mut jumps = true;
    for block in &transcription.elements[e].blocks {
        let place = |contact, offset| {
            block.variables[transcription.field.layout.algebraic(contact, offset)]
        };
        let (Some(p), Some(w)) = (place(contact, P), place(contact, W)) else {
            continue;
        };
        vanishes[p] = true;
        if block.boundary {
            continue;
        }
        let step = |i| place(i, ALPHA).map_or(1.0, |alpha| x[alpha]);
        let steps = (0..transcription.field.layout.contacts).map(step);
        let theta: f64 = steps.clone().product();
        if theta >= x[w] {
            vanishes[w] = true;
            jumps = false;
        } else if steps.fold(f64::INFINITY, f64::min) < step(contact) {
            // another contact stops the clock
            jumps = false;
        } else if let Some(alpha) = place(contact, ALPHA) {
            vanishes[alpha] = true;
        }
    }
    jumps
}

/// Marks a sum and its terms.
pub(super) fn mark_sum(
    transcription: &Transcription<'_>,
    e: usize,
    group: usize,
    sum: usize,
    vanishes: &mut [bool],
) {
    vanishes[transcription.elements[e].sums + SUMS * group + sum] = true;
    for variable in transcription.sum_variables(e, group, sum) {
        vanishes[variable] = true;
    }
}
