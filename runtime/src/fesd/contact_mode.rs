//! The contact mode: which contacts carry a force, and which of them stick.
//!
//! Contacts that touch (`g_i = 0`, `v_n,i = 0`) take accelerations from the linear complementarity problem
//! `0 <= r _|_ w >= 0` with the normal accelerations `w = phi + D r`, `phi_i = n_i' a + curvature_i`,
//! `D_ij = n_i' d_j`. With friction a contact that slides acts along `d -+ mu e`, and one that does not
//! follows Coulomb's law with the sliding acceleration. Where both sides of a condition vanish the same
//! problem one derivative higher decides.

use super::contacts::{Contacts, Line, ModeError, norm};
use crate::contact::{
    ActiveContact, Balance, Cone, ContactState, Decision, Problem, Touching, Vanished, find, law,
    shares, sliding, touching, unbiased_lines,
};
use crate::linalg::products::dot;
use crate::model::pair_size;
use crate::run::Place;
use crate::run::sides::{self, Failed, Known};

/// Relative size below which an acceleration or a jerk counts as zero when the mode is chosen.
const BIACTIVE: f64 = 1e-8;

/// A condition whose two sides both vanish in accelerations.
#[derive(Debug, Clone, Copy)]
enum Undecided {
    /// Neither force nor normal acceleration; slides in the given sense, or is at rest tangentially.
    Normal { contact: usize, sense: Option<f64> },
    /// Friction on the edge of its cone, without sliding acceleration: about to slip in the given sense.
    Edge { contact: usize, sense: f64 },
}

impl Undecided {
    fn contact(self) -> usize {
        let (Self::Normal { contact, .. } | Self::Edge { contact, .. }) = self;
        contact
    }
}

/// The contact mode at `x` and `time`: writes the contacts that carry a force to `active`. Of the contacts
/// that are `close`, those touch whose normal velocity is zero for their size; those of them slide whose
/// sliding velocity is not.
///
/// `active` holds the previous mode on entry; it decides where accelerations and jerks both vanish.
/// What [`Contacts::evaluate`] stored is overwritten.
pub(crate) fn select(
    contacts: &mut Contacts<'_>,
    x: &[f64],
    close: &[usize],
    time: f64,
    active: &mut Vec<ActiveContact>,
) -> Result<(), ModeError> {
    contacts.rest = None;
    contacts.evaluate(x, close.iter().copied());
    let touching: Vec<usize> = close
        .iter()
        .copied()
        .filter(|&i| contacts.normal_velocity(i).abs() <= contacts.resting_velocity(i, time))
        .collect();
    if touching.is_empty() {
        active.clear();
        return Ok(());
    }
    for &i in &touching {
        contacts.measure_sliding(i, time);
        contacts.align(i, None);
    }
    let solved = sided(contacts, x, &touching, time)?;
    if contacts.rest.is_some() {
        let held = |&contact: &usize| {
            let slides = pair_size(contacts.sliding(contact)) > contacts.rest_speed(contact, time);
            let state = if slides {
                sliding(contacts, contact)
            } else {
                ContactState::Held(None)
            };
            ActiveContact { contact, state }
        };
        *active = touching.iter().map(held).collect();
        return Ok(());
    }
    let Sorted {
        mut strict,
        mut undecided,
        slips,
    } = sort(&solved, contacts);
    for (contact, slip) in slips {
        contacts.align(contact, Some(slip));
    }
    share_friction(contacts, &mut strict, Some(&solved))?;
    drop_held(contacts, &mut strict, &mut undecided)?;
    if !undecided.is_empty() {
        select_by_jerk(contacts, x, active, &mut strict, &undecided)?;
        share_friction(contacts, &mut strict, Some(&solved))?;
    }
    strict.sort_unstable_by_key(|held| held.contact);
    active.clone_from(&strict);
    Ok(())
}

/// What accelerations decide.
#[derive(Default)]
struct Sorted {
    /// Contacts that carry a force.
    strict: Vec<ActiveContact>,
    undecided: Vec<Undecided>,
    /// Contacts in space that begin to slip, with the direction in their frames.
    slips: Vec<(usize, (f64, f64))>,
}

/// Forces and accelerations of the contacts that touch.
fn balance(contacts: &Contacts<'_>, touching: &[usize], time: f64) -> Result<Balance, ModeError> {
    let at_rest = |i: usize| {
        let free = !contacts.passes(i) && contacts.sides[i] == 0.0;
        free && pair_size(contacts.sliding(i)) <= contacts.rest_speed(i, time)
    };
    let touching = Touching::new(contacts, touching, at_rest);
    let free = touching.lines.iter();
    let free: Vec<f64> = free
        .map(|&line| contacts.free_line_acceleration(line))
        .collect();
    let balance = Balance::first(touching, contacts, &free)?;
    match balance.touching.parting(contacts) {
        Some(contact) if balance.is_one_of_several(contacts, &free) => {
            Err(ModeError::NotUnique(contact))
        }
        _ => Ok(balance.spread(contacts)),
    }
}

/// The balance of accelerations with the sides of the switches that are passed now.
fn sided(
    contacts: &mut Contacts<'_>,
    x: &[f64],
    touching: &[usize],
    time: f64,
) -> Result<Balance, ModeError> {
    let scales = touching
        .iter()
        .filter(|&&i| contacts.switch_of(i).is_some())
        .map(|&i| contacts.tangential_scale(i));
    let Some(scale) = scales.reduce(f64::max) else {
        return balance(contacts, touching, time);
    };
    let (_, moment) = difference_step(contacts, x, (contacts.free_acceleration(), scale));
    let all = 0..contacts.sides.len();
    let zeros: Vec<f64> = all.map(|i| contacts.rest_speed(i, time)).collect();
    let place = Place {
        x,
        rates: &contacts.rates(),
        touching,
        zeros: &zeros,
        moment,
        longest: if contacts.moment.is_finite() {
            contacts.moment
        } else {
            moment
        },
    };
    let known = Known {
        side: &|_: &Contacts<'_>, _, by_rate| by_rate,
        zero: &|contacts: &Contacts<'_>, i| BIACTIVE * contacts.tangential_scale(i),
    };
    let solve = |contacts: &mut Contacts<'_>| balance(contacts, touching, time);
    let solved = sides::balanced(contacts, &place, &known, solve);
    let solved = solved.map_err(|undecided| match undecided {
        Failed::Law(error) | Failed::Sides(error) => error,
    })?;
    // Elements have no force that holds a function whose jump begins to grow here.
    let begins = |k: &usize| {
        let (contact, own) = (touching[*k], Line::tangent(touching[*k]));
        let switches = contacts.switch_of(contact).is_some() && solved.slip(*k).is_some();
        switches && contacts.rest.is_none() && contacts.coupling(own, own) == 0.0
    };
    match (0..touching.len()).find(begins) {
        Some(k) => Err(ModeError::SecondOrder(touching[k])),
        None => Ok(solved),
    }
}

/// Sorts the contacts by what their forces and accelerations say.
fn sort(balance: &Balance, contacts: &Contacts<'_>) -> Sorted {
    let mut sorted = Sorted::default();
    for (k, &contact) in balance.touching.contacts.iter().enumerate() {
        let zero = BIACTIVE * contacts.tangential_scale(contact);
        let zeros = (BIACTIVE * contacts.phi_scale(contact), zero);
        let decision = if contacts.is_dry(contact) {
            balance.pressed(contacts, k, zero, None)
        } else {
            balance.decide(contacts, k, zeros, Vanished::default())
        };
        let slip = balance.slip(k);
        match decision {
            Decision::Is(ContactState::Open) => continue,
            Decision::Touches => {
                let sense = match slip {
                    None => Some(sliding(contacts, contact).sense()),
                    Some(slip) if pair_size(slip) <= zero => None,
                    Some(_) if contacts.is_in_space(contact) => Some(1.0),
                    Some(slip) => Some(slip.0.signum()),
                };
                sorted.undecided.push(Undecided::Normal { contact, sense });
                if slip.is_some_and(|slip| pair_size(slip) > zero) {
                    sorted.slips.push((contact, balance.heading(k, zero)));
                }
                continue;
            }
            Decision::Edge(state) => {
                let sense = state.sense();
                sorted.undecided.push(Undecided::Edge { contact, sense });
            }
            Decision::Is(_) => {}
        }
        let (Decision::Is(state) | Decision::Edge(state)) = decision else {
            continue;
        };
        sorted.strict.push(ActiveContact { contact, state });
        if slip.is_some() && state.slips() {
            sorted.slips.push((contact, balance.heading(k, zero)));
        }
    }
    sorted
}

/// Lets only independent contacts of `active` stick where several of them hold the same sliding velocity: the feet of a box, or a block in a
/// corner. The motion is unique, the shares of the load are not; those of the `balance` are kept. Contacts inside their cone whose friction is
/// not zero come first, which a basic solution has for independent contacts only; the others keep the force of their share.
pub(crate) fn share_friction(
    contacts: &Contacts<'_>,
    active: &mut [ActiveContact],
    balance: Option<&Balance>,
) -> Result<(), ModeError> {
    let switches = |held: &ActiveContact| contacts.switch_of(held.contact).is_some();
    // Switches may hold each other of which fewer could not.
    if active.iter().any(switches) && shares::are_independent(contacts, &unbiased_lines(active)) {
        return Ok(());
    }
    // The friction of a contact, and whether it is inside of its cone.
    let share = |contact: usize| {
        let zero = BIACTIVE * contacts.tangential_scale(contact);
        let shared = balance.and_then(|balance| {
            let contacts_that_touch = &balance.touching.contacts;
            let k = contacts_that_touch.iter().position(|&i| i == contact)?;
            balance.slip(k)?;
            Some((balance.friction(k), balance.margin(contacts, k) > zero))
        });
        shared.unwrap_or(((0.0, 0.0), true))
    };
    let mut sticking: Vec<usize> = (0..active.len())
        .filter(|&k| active[k].state.sticks())
        .collect();
    sticking.sort_by_key(|&k| {
        let (friction, inside) = share(active[k].contact);
        (friction == (0.0, 0.0), !inside)
    });
    for &k in &sticking {
        active[k].state = ContactState::Held(None);
    }
    for k in sticking {
        let contact = active[k].contact;
        let (friction, inside) = share(contact);
        active[k].state = if contacts.is_in_space(contact) {
            // Whatever others hold: how they share their load is asked for as long as they hold.
            ContactState::StickInSpace
        } else if shares::is_free(contacts, &unbiased_lines(active), Line::tangent(contact))? {
            ContactState::Stick
        } else if inside {
            ContactState::Held(None)
        } else {
            ContactState::at_edge(-friction.0)
        };
    }
    Ok(())
}

/// Conditions on velocities that the strictly active contacts hold need no decision: a contact on the edge
/// of its cone stays there, one without a force needs none.
fn drop_held(
    contacts: &Contacts<'_>,
    active: &mut [ActiveContact],
    undecided: &mut Vec<Undecided>,
) -> Result<(), ModeError> {
    for k in (0..undecided.len()).rev() {
        let line = match undecided[k] {
            Undecided::Edge { contact, sense } => Line::Tangent { contact, sense },
            Undecided::Normal { contact, .. } => Line::normal(contact),
        };
        if shares::is_free(contacts, &unbiased_lines(active), line)? {
            continue;
        }
        if let Undecided::Edge { contact, sense } = undecided.remove(k) {
            let state = match contacts.is_in_space(contact) {
                true => ContactState::StickInSpace,
                false => ContactState::at_edge(sense),
            };
            for held in active.iter_mut().filter(|held| held.contact == contact) {
                held.state = state;
            }
        }
    }
    Ok(())
}

/// Decides conditions whose two sides both vanish by their derivatives along the motion with the
/// strictly active contacts, in which those on the edge of their cone slip; where those vanish too, the
/// previous mode stays.
fn select_by_jerk(
    contacts: &mut Contacts<'_>,
    x: &[f64],
    previous: &[ActiveContact],
    strict: &mut Vec<ActiveContact>,
    undecided: &[Undecided],
) -> Result<(), ModeError> {
    let (lines, cones) = undecided_lines(contacts, undecided);
    let mut held = Vec::new();
    contacts.lines(strict, &mut held);
    let mut forces = vec![0.0; held.len()];
    contacts.contact_forces(strict, &mut forces)?;
    let mut motion = vec![0.0; contacts.n];
    contacts.constrained_acceleration(strict, &forces, &mut motion);
    let matrix = shares::reduced_couplings(contacts, &held, &lines)?;
    let scales: Vec<f64> = lines.iter().map(|&line| contacts.scale(line)).collect();
    let largest = scales.iter().copied().fold(0.0, f64::max);
    let (step, time_scale) = difference_step(contacts, x, (&motion, largest));
    // Far from the origin the step is longer and leaves fewer digits.
    let biactive = BIACTIVE.max(4.0 * (step / time_scale).powi(2));
    let at = (x, &motion[..], step);
    let jerk = jerks(contacts, at, strict, (&held, &lines))?;
    let problem = Problem {
        matrix: &matrix,
        offsets: &jerk,
        cones: &cones,
        surfaces: undecided.len(),
        in_space: undecided
            .iter()
            .any(|condition| contacts.is_in_space(condition.contact())),
    };
    let (rates, size) = (law::first(&problem)?, lines.len());
    // What sticks from now on comes first: it may hold normal velocities, so that no force is needed for that.
    let mut order: Vec<usize> = (0..undecided.len()).collect();
    order.sort_by_key(|&k| matches!(undecided[k], Undecided::Normal { .. }));
    for k in order {
        let zero = |line: usize| biactive * scales[line] / time_scale;
        let total = |line: usize| jerk[line] + dot(&matrix[line * size..(line + 1) * size], &rates);
        match undecided[k] {
            Undecided::Edge { contact, sense } => {
                let slips = ContactState::slip(sense);
                let slip = rates[k] <= zero(k)
                    && (total(k) > zero(k) || find(previous, contact) == Some(slips));
                let sticks = ContactState::sticking(contacts.is_in_space(contact));
                for held in strict.iter_mut().filter(|held| held.contact == contact) {
                    held.state = if slip { slips } else { sticks };
                }
            }
            Undecided::Normal { contact, sense } => {
                let before = find(previous, contact);
                let presses = rates[k] > zero(k);
                if !(presses || total(k) <= zero(k) && before.is_some()) {
                    continue;
                }
                if !presses && is_held(contacts, x, strict, contact)? {
                    continue;
                }
                let cone = cones.iter().position(|cone| cone.normal == k);
                let state = match cone.map(|cone| undecided.len() + cone) {
                    None if contacts.friction(contact) > 0.0 => {
                        ContactState::slip(sense.unwrap_or(0.0))
                    }
                    None => ContactState::Frictionless,
                    Some(tangent) => {
                        let across = cones[tangent - undecided.len()].across;
                        let both = (rates[tangent], across.map_or(0.0, |line| rates[line]));
                        let margin = contacts.friction(contact) * rates[k] - pair_size(both);
                        let slip = (total(tangent), across.map_or(0.0, total));
                        let decided = from_rest(contacts, contact, (margin, slip), zero(tangent));
                        decided
                            .or(before)
                            .unwrap_or(ContactState::sticking(contacts.is_in_space(contact)))
                    }
                };
                strict.push(ActiveContact { contact, state });
            }
        }
    }
    Ok(())
}

/// Whether the `active` contacts keep the normal velocity of another one at `x` as it is, which then needs no force.
fn is_held(
    contacts: &mut Contacts<'_>,
    x: &[f64],
    active: &[ActiveContact],
    contact: usize,
) -> Result<bool, ModeError> {
    let seen = active.iter().map(|held| held.contact);
    contacts.evaluate(x, seen.chain([contact]));
    Ok(!shares::is_free(
        contacts,
        &unbiased_lines(active),
        Line::normal(contact),
    )?)
}

/// Rates of the accelerations of `lines` along the motion, while the `active` contacts hold theirs: a central difference over a `step`
/// at `x` with the acceleration `motion`.
fn jerks(
    contacts: &mut Contacts<'_>,
    (x, motion, step): (&[f64], &[f64], f64),
    active: &[ActiveContact],
    (held, lines): (&[Line], &[Line]),
) -> Result<Vec<f64>, ModeError> {
    let mut jerk = vec![0.0; lines.len()];
    let mut behind = vec![0.0; lines.len()];
    for (step, w) in [(step, &mut jerk), (-step, &mut behind)] {
        separation(contacts, x, motion, step, active, held, lines, w)?;
    }
    for (ahead, behind) in jerk.iter_mut().zip(&behind) {
        *ahead = (*ahead - behind) / (2.0 * step);
    }
    Ok(jerk)
}

/// What a contact at rest begins to do, by the distance of its force from the cone and its slip, if they say so; in space its frame
/// points along the slip.
fn from_rest(
    contacts: &mut Contacts<'_>,
    contact: usize,
    (margin, slip): (f64, (f64, f64)),
    zero: f64,
) -> Option<ContactState> {
    if margin > zero {
        return Some(ContactState::sticking(contacts.is_in_space(contact)));
    }
    if pair_size(slip) <= zero {
        return None;
    }
    if contacts.is_in_space(contact) {
        contacts.align(contact, Some(slip));
        return Some(ContactState::slip(1.0));
    }
    Some(ContactState::slip(slip.0))
}

/// Step of a central difference along the motion with the acceleration `motion`, beside accelerations of the size `scale`,
/// and the motion's own time scale: truncation and rounding errors are both near 1e-10 for a step of 1e-5 of it.
fn difference_step(
    contacts: &Contacts<'_>,
    x: &[f64],
    (motion, scale): (&[f64], f64),
) -> (f64, f64) {
    let speed = norm(&x[contacts.n..2 * contacts.n]) + f64::MIN_POSITIVE;
    let rounding = f64::EPSILON * norm(&x[..contacts.n]);
    let acceleration = norm(motion);
    // Where it is rounding error, at rest under forces that change with time, its ratio to the velocity says nothing.
    let own = if acceleration > BIACTIVE * scale {
        speed / acceleration
    } else {
        f64::INFINITY
    };
    // From rest the velocity says nothing.
    let shortest = if speed * own > 1e8 * rounding {
        0.0
    } else {
        1e-3
    };
    // Nor does it where forces or the ground change faster by themselves.
    let time_scale = own.clamp(shortest, 1.0).min(contacts.moment);
    let share = (rounding / (speed * time_scale)).cbrt().clamp(1e-5, 1e-2);
    (share * time_scale, time_scale)
}

/// One line for each undecided condition, in its order, then the tangents of the cones.
fn undecided_lines(contacts: &Contacts<'_>, undecided: &[Undecided]) -> (Vec<Line>, Vec<Cone>) {
    let (mut lines, mut tangents, mut cones) = (Vec::new(), Vec::new(), Vec::new());
    let mut acrosses = Vec::new();
    for (normal, &condition) in undecided.iter().enumerate() {
        lines.push(match condition {
            Undecided::Edge { contact, sense } => Line::Tangent { contact, sense },
            Undecided::Normal { contact, sense } => {
                let friction = contacts.friction(contact);
                if friction > 0.0 && sense.is_none() {
                    tangents.push(Line::tangent(contact));
                    if contacts.is_in_space(contact) {
                        acrosses.push((cones.len(), Line::Across { contact }));
                    }
                    cones.push(touching::cone(contacts, contact, normal));
                }
                Line::Normal {
                    contact,
                    slope: -contacts.kinetic(contact) * sense.unwrap_or(0.0),
                }
            }
        });
    }
    lines.extend(tangents);
    touching::add_acrosses(&mut lines, &mut cones, acrosses);
    (lines, cones)
}

/// Accelerations of `lines` a time `step` along the motion, with the `active` contacts, whose lines are
/// `held`, carrying their forces.
#[expect(
    clippy::too_many_arguments,
    reason = "a place on the motion and what is held there"
)]
fn separation(
    contacts: &mut Contacts<'_>,
    x: &[f64],
    motion: &[f64],
    step: f64,
    active: &[ActiveContact],
    held: &[Line],
    lines: &[Line],
    w: &mut [f64],
) -> Result<(), ModeError> {
    let n = contacts.n;
    let mut shifted = std::mem::take(&mut contacts.shifted);
    shifted.copy_from_slice(x);
    for k in 0..n {
        shifted[k] += step * x[n + k] + 0.5 * step * step * motion[k];
        shifted[n + k] += step * motion[k];
    }
    for (control, slope) in shifted[2 * n..].iter_mut().zip(&contacts.control_slopes) {
        *control += step * slope;
    }
    if contacts.model.declaration().explicit_time
        && let Some(time) = shifted.last_mut()
    {
        *time += step;
    }
    let seen = held.iter().chain(lines).map(|line| line.contact());
    contacts.evaluate(&shifted, seen);
    contacts.shifted = shifted;
    let mut forces = vec![0.0; held.len()];
    contacts.contact_forces(active, &mut forces)?;
    for (value, &line) in w.iter_mut().zip(lines) {
        *value = contacts.free_line_acceleration(line)
            + held
                .iter()
                .zip(&forces)
                .map(|(&h, force)| contacts.coupling(line, h) * force)
                .sum::<f64>();
    }
    Ok(())
}
