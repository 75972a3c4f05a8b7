//! Which contacts are active right after an instant, and which of them stick: the complementarity of gaps and
//! normal contact accelerations with Coulomb's law; where that is undecided, of what follows a moment later.

mod later;

use self::later::{Candidate, Sign, accept_after, sign_after, signs_after};
use super::contact_problem::ContactProblem;
use super::dop853::{Dop853, System};
use super::dynamics::{Dynamics, Switch, motion, switching};
use super::here::{Undetermined, rates};
use crate::contact::{
    Balance, ContactState, Decision, Line, ModeError, Touching, Vanished, shares, sliding,
};
use crate::model::{Switching, contact_point, pair_size};
use crate::run::Place;
use crate::run::sides::{self, Failed, Known};
use crate::simulation::sentences::{negative_bound, not_unique, second_order};
use crate::yardstick;

/// Shares of the step size after which undecided contacts are looked at, with the multiple of the force now
/// that a force then must exceed: the earliest moment that shows more than rounding error belongs to the
/// leading derivative. If none does, force or acceleration are constant, and what there is now counts.
const MOMENTS: [(f64, f64); 7] = [
    (1e-6, 4.0),
    (1e-5, 4.0),
    (1e-4, 4.0),
    (1e-3, 4.0),
    (1e-2, 4.0),
    (1e-1, 4.0),
    (1e-1, 0.0),
];
/// Largest number of modes that are compared by what follows a moment later; of more undecided contacts each is decided
/// by itself.
const MOST_MODES: usize = 64;

/// Accelerations below this share of those they balance are compared by what follows a moment later: event
/// times carry rounding error, and the force its rate times that.
const BIACTIVE: f64 = 1e-10;

/// Choices of a mode before the direction of sliding counts as undetermined; the second is the last in exact
/// arithmetic.
const ATTEMPTS: usize = 4;

/// How far what follows is looked at.
#[derive(Debug, Clone, Copy)]
pub(in crate::simulation) struct Outlook {
    /// A time over which the motion is smooth, such as a step size.
    pub(in crate::simulation) moment: f64,
    /// A time beyond which nothing is foreseen, such as a horizon.
    pub(in crate::simulation) longest: f64,
    /// How many of the earliest moments are passed over: those that have led back to the same instant.
    pub(in crate::simulation) skipped: usize,
}

/// Chooses the contact mode: the active contacts among those closed and at rest, and which of them stick. They
/// follow from `0 <= r _|_ n' a + curvature + D r >= 0` and Coulomb's law for the rates of the sliding
/// velocities that are zero; where these are undecided, from the same a moment later. On return the mode of
/// `dynamics` is the new one, and the state `y` fulfils its constraints.
///
/// `vanished` is a switching function of the mode before that is known to vanish now, whatever rounding error
/// has left of it.
pub(in crate::simulation) fn change(
    dynamics: &mut Dynamics<'_>,
    probe: &mut Dop853,
    t: f64,
    y: &mut [f64],
    resting: &[usize],
    vanished: Option<Switch>,
    outlook: Outlook,
) -> Result<(), Undetermined> {
    let undetermined = |dynamics: &Dynamics<'_>, message: &str| {
        Err(Undetermined {
            contact: dynamics.mode.active.first().copied().unwrap_or_default(),
            message: message.into(),
        })
    };
    for _ in 0..ATTEMPTS {
        // What follows a moment later depends on no gap of an open contact.
        dynamics.leave_gaps(true);
        let selected = select(dynamics, probe, t, y, resting, vanished, outlook);
        dynamics.leave_gaps(false);
        selected?;
        if !motion::settle(dynamics, t, y) {
            return undetermined(
                dynamics,
                "the state cannot be moved onto the surfaces in contact: their normals are dependent",
            );
        }
        // What is left of a normal velocity may have had its share in a sliding velocity as small.
        if !slides_back(dynamics) {
            return Ok(());
        }
    }
    undetermined(
        dynamics,
        "the direction of sliding is not determined; start from a slightly different state",
    )
}

/// Whether a contact slides against the direction of its mode, at the state loaded.
fn slides_back(dynamics: &mut Dynamics<'_>) -> bool {
    (0..dynamics.contacts).any(|i| {
        let ContactState::Slip(direction) = dynamics.state(i) else {
            return false;
        };
        dynamics.evaluate_tangent(i);
        direction.sign() * dynamics.sliding_velocity(i) < -dynamics.zero_sliding_velocity(i)
    })
}

fn select(
    dynamics: &mut Dynamics<'_>,
    probe: &mut Dop853,
    t: f64,
    y: &[f64],
    resting: &[usize],
    vanished: Option<Switch>,
    outlook: Outlook,
) -> Result<(), Undetermined> {
    let mut mode = vec![ContactState::Open; dynamics.contacts];
    dynamics.set_mode(&mode);
    let Some(&contact) = resting.first() else {
        return Ok(());
    };
    let candidates = candidates(dynamics, (t, y), resting, vanished, outlook)
        .map_err(|message| Undetermined { contact, message })?;
    if dynamics.rest.is_some() {
        enter_rest(dynamics, mode, resting);
        return Ok(());
    }
    for candidate in &candidates {
        mode[candidate.contact] = candidate.states[0];
    }
    let open = |candidate: &&Candidate| candidate.states.len() > 1;
    let undecided: Vec<&Candidate> = candidates.iter().filter(open).collect();
    let Some(first) = undecided.first() else {
        enter(dynamics, &mode, t, y);
        return Ok(());
    };
    let mut neutral = None;
    let skipped = outlook.skipped.min(MOMENTS.len() - 1);
    let Some(combinations) = combinations(&undecided) else {
        return select_one_by_one(
            dynamics,
            probe,
            (t, y),
            (&mut mode, &undecided),
            (outlook.moment, skipped),
        );
    };
    let single = combinations.len() > 1 && has_one_motion(dynamics, resting);
    for &(share, multiple) in &MOMENTS[skipped..] {
        neutral = None;
        for combination in &combinations {
            if neutral.is_some() && single {
                // What is consistent up to zeros has the motion that what is more than that would have.
                break;
            }
            for (candidate, &state) in undecided.iter().zip(combination) {
                mode[candidate.contact] = state;
            }
            enter(dynamics, &mode, t, y);
            match sign_after(
                dynamics,
                probe,
                (t, y),
                &undecided,
                share * outlook.moment,
                multiple,
            ) {
                Sign::Positive => {
                    for &(share, _) in &MOMENTS[..skipped] {
                        accept_after(dynamics, probe, (t, y), share * outlook.moment);
                    }
                    return Ok(());
                }
                Sign::Zero if neutral.is_none() => neutral = Some(dynamics.mode().to_vec()),
                Sign::Zero | Sign::Negative => {}
            }
        }
    }
    match neutral {
        Some(mode) => {
            dynamics.set_mode(&mode);
            Ok(())
        }
        None => Err(inconsistent(first.contact)),
    }
}

/// Whether all balances of the contacts have one motion, and independent ones one set of forces: none has friction, and their couplings are
/// symmetric as those of forces along normals.
fn has_one_motion(dynamics: &Dynamics<'_>, contacts: &[usize]) -> bool {
    let rubs = |&i: &usize| dynamics.is_dry(i) || dynamics.has_friction(i);
    if contacts.iter().any(rubs) {
        return false;
    }
    let lines: Vec<Line> = contacts.iter().map(|&i| Line::normal(i)).collect();
    let inverse_inertia = |&i: &usize| dynamics.point(i)[contact_point::INVERSE_INERTIA];
    let inertia: Vec<f64> = contacts.iter().map(inverse_inertia).collect();
    let order = lines.len();
    let couplings = dynamics.couplings(&lines);
    let entry = |i: usize, j: usize| couplings[i * order + j] * inertia[j];
    (0..order).all(|i| {
        (0..i).all(|j| {
            let size = (entry(i, i) * entry(j, j)).abs().sqrt();
            (entry(i, j) - entry(j, i)).abs() <= yardstick::NOTHING * size
        })
    })
}

/// Holds the `resting` contacts whose functions vanish; the others act by their sides.
fn enter_rest(dynamics: &mut Dynamics<'_>, mut mode: Vec<ContactState>, resting: &[usize]) {
    for &contact in resting {
        let slides = pair_size(dynamics.sliding(contact)) > dynamics.zero_speed(contact);
        mode[contact] = match slides {
            true => sliding(dynamics, contact),
            false => ContactState::Held(None),
        };
    }
    dynamics.set_mode(&mode);
}

fn inconsistent(contact: usize) -> Undetermined {
    Undetermined {
        contact,
        message: "neither holding nor releasing the contact is consistent a moment later; start from a slightly \
                  different state"
            .into(),
    }
}

/// Chooses the states of more contacts than all combinations of them can be tried: each takes the next of its states where
/// what follows contradicts the present one, until nothing does.
fn select_one_by_one(
    dynamics: &mut Dynamics<'_>,
    probe: &mut Dop853,
    (t, y): (f64, &[f64]),
    (mode, undecided): (&mut [ContactState], &[&Candidate]),
    (moment, skipped): (f64, usize),
) -> Result<(), Undetermined> {
    let free = release_dependent(dynamics, mode, undecided);
    let mut neutral = None;
    for &(share, multiple) in &MOMENTS[skipped..] {
        neutral = None;
        let mut choices: Vec<usize> = vec![0; free.len()];
        for _ in 0..=4 * free.len() {
            for (candidate, &choice) in free.iter().zip(&choices) {
                mode[candidate.contact] = candidate.states[choice];
            }
            enter(dynamics, mode, t, y);
            let delta = share * moment;
            let Some(signs) = signs_after(dynamics, probe, (t, y), &free, delta, multiple) else {
                break;
            };
            let wrong = |&k: &usize| matches!(signs[k], Sign::Negative);
            let Some(changed) = (0..free.len()).rev().find(wrong) else {
                if signs.iter().all(|sign| matches!(sign, Sign::Positive)) {
                    for &(share, _) in &MOMENTS[..skipped] {
                        accept_after(dynamics, probe, (t, y), share * moment);
                    }
                    return Ok(());
                }
                neutral = Some(dynamics.mode().to_vec());
                break;
            };
            choices[changed] = (choices[changed] + 1) % free[changed].states.len();
        }
    }
    match neutral {
        Some(mode) => {
            dynamics.set_mode(&mode);
            Ok(())
        }
        None => Err(inconsistent(
            free.first()
                .or(undecided.first())
                .map_or(0, |first| first.contact),
        )),
    }
}

/// Opens those of the undecided contacts whose normal velocity the others hold; the rest of them.
fn release_dependent<'c>(
    dynamics: &mut Dynamics<'_>,
    mode: &mut [ContactState],
    undecided: &[&'c Candidate],
) -> Vec<&'c Candidate> {
    for candidate in undecided {
        mode[candidate.contact] = ContactState::Open;
    }
    dynamics.set_mode(mode);
    let mut free = Vec::with_capacity(undecided.len());
    for &candidate in undecided {
        let opens = candidate.states.iter().any(|state| state.is_open());
        if opens && motion::keeps_apart(dynamics, candidate.contact) {
            continue;
        }
        mode[candidate.contact] = candidate.states[0];
        dynamics.set_mode(mode);
        free.push(candidate);
    }
    free
}

/// The resting contacts with the states that the balance of forces leaves open.
fn candidates(
    dynamics: &mut Dynamics<'_>,
    (t, y): (f64, &[f64]),
    resting: &[usize],
    vanished: Option<Switch>,
    outlook: Outlook,
) -> Result<Vec<Candidate>, String> {
    dynamics.load(t, y);
    dynamics.evaluate_free_acceleration();
    dynamics.sides.fill(0.0);
    dynamics.rest = None;
    let Free {
        accelerations,
        rests,
    } = Free::of(dynamics, resting, vanished)?;
    let balance = if resting.iter().any(|&i| dynamics.switch_of(i).is_some()) {
        let zeros: Vec<f64> = (0..dynamics.contacts)
            .map(|i| dynamics.zero_speed(i))
            .collect();
        let (rates, x) = (rates(dynamics, (t, y)), dynamics.input().to_vec());
        let place = Place {
            x: &x,
            rates: &rates,
            touching: resting,
            zeros: &zeros,
            moment: outlook.moment,
            longest: outlook.longest,
        };
        let known = Known {
            side: &|dynamics: &Dynamics<'_>, i, by_rate| known_side(dynamics, i, vanished, by_rate),
            zero: &|dynamics: &Dynamics<'_>, i| BIACTIVE * dynamics.sliding_acceleration_scale(i),
        };
        let solve =
            |dynamics: &mut Dynamics<'_>| balanced(dynamics, resting, &rests, &accelerations);
        let solved = sides::balanced(dynamics, &place, &known, solve);
        let name = |contact: usize| dynamics.model.declaration().contacts[contact].name;
        solved.map_err(|undecided| match undecided {
            Failed::Law(message) => message,
            Failed::Sides(ModeError::NotUnique(contact)) => not_unique(name(contact)),
            Failed::Sides(error) => second_order(name(error.contact().unwrap_or(resting[0]))),
        })?
    } else {
        balanced(dynamics, resting, &rests, &accelerations)?
    };
    for (slot, &i) in resting.iter().enumerate() {
        // Its force is not negative, so that it moves against one that is given so.
        let floor = BIACTIVE * accelerations[slot].0.1.max(dynamics.force_floor(i));
        if dynamics.is_dry(i) && dynamics.follows(i) && balance.motions[slot] > floor {
            let name = dynamics.model.declaration().contacts[i].name;
            return Err(negative_bound(name));
        }
        if dynamics.is_in_space(i) && rests[i] {
            let zero = BIACTIVE * dynamics.sliding_acceleration_scale(i);
            dynamics.align(i, Some(balance.heading(slot, zero)));
        }
    }
    let candidates = accelerations.iter().enumerate().map(|(slot, scales)| {
        let floor = dynamics.force_floor(resting[slot]);
        let ((_, normal), (_, tangential)) = *scales;
        let zeros = (
            BIACTIVE * normal.max(floor),
            BIACTIVE * tangential.max(floor),
        );
        candidate(dynamics, (&balance, slot), zeros, vanished)
    });
    Ok(candidates.collect())
}

/// The normal and the tangential acceleration of a contact without contact forces, each with the sum of the sizes of its terms.
type Accelerations = ((f64, f64), (f64, f64));

/// The resting contacts without contact forces.
struct Free {
    accelerations: Vec<Accelerations>,
    /// Of all contacts, those that are at rest along their tangents and have a cone.
    rests: Vec<bool>,
}

impl Free {
    fn of(
        dynamics: &mut Dynamics<'_>,
        resting: &[usize],
        vanished: Option<Switch>,
    ) -> Result<Self, String> {
        let (mut accelerations, mut rests) = (Vec::new(), vec![false; dynamics.contacts]);
        for &i in resting {
            dynamics.evaluate_sides(i);
            dynamics.align(i, None);
            let normal = dynamics.free_normal_acceleration(i);
            // Where it vanishes and goes on falling, its force was about to change its sign.
            let released = vanished == Some(Switch::NormalForce(i));
            let negative = normal.0 > 0.0 && !dynamics.follows(i);
            if dynamics.is_dry(i) && (negative || released) {
                let name = dynamics.model.declaration().contacts[i].name;
                return Err(negative_bound(name));
            }
            let mut tangential = (0.0, 0.0);
            if dynamics.has_friction(i) {
                tangential = dynamics.free_sliding_acceleration(i);
                rests[i] = rests_along(dynamics, i, vanished) && !dynamics.passes(i);
            }
            accelerations.push((normal, tangential));
        }
        Ok(Self {
            accelerations,
            rests,
        })
    }
}

/// Whether an evaluated contact with friction does not slide.
fn rests_along(dynamics: &Dynamics<'_>, contact: usize, vanished: Option<Switch>) -> bool {
    // In space a direction may vanish while the contact slides on across it.
    let stops = matches!(vanished, Some(Switch::SlidingVelocity(other, _)) if other == contact)
        && !dynamics.is_in_space(contact);
    stops || pair_size(dynamics.sliding(contact)) <= dynamics.zero_speed(contact)
}

/// The side of a switch that is only passed, where its function vanishes: the other one of a side that has ended, else that of its
/// rate, if it has one. What a condition has set may have turned its rate, which comes first.
fn known_side(
    dynamics: &Dynamics<'_>,
    contact: usize,
    vanished: Option<Switch>,
    by_rate: Option<f64>,
) -> Option<f64> {
    let ended = match vanished {
        Some(Switch::SlidingVelocity(other, direction)) if other == contact => {
            Some(-direction.sign())
        }
        _ => None,
    };
    match dynamics.switch_of(contact) {
        Some(Switching::Resets) => by_rate.or(ended),
        _ => ended.or(by_rate),
    }
}

/// Forces of the resting contacts with these free accelerations and their scales, of which some may stick.
fn balanced(
    dynamics: &mut Dynamics<'_>,
    resting: &[usize],
    rests: &[bool],
    accelerations: &[Accelerations],
) -> Result<Balance, String> {
    switching::set_force_floors(dynamics, resting);
    let touching = Touching::new(dynamics, resting, |i| rests[i] && dynamics.sides[i] == 0.0);
    let slot = |contact: usize| resting.iter().position(|&i| i == contact).unwrap_or(0);
    let offsets = touching.lines.iter().map(|&line| match line {
        Line::Normal { contact, .. } => accelerations[slot(contact)].0.0,
        Line::Tangent { contact, .. } => accelerations[slot(contact)].1.0,
        Line::Across { .. } => dynamics.free_line_acceleration(line),
    });
    let problem = ContactProblem {
        what: "balance of contact forces",
        offsets: offsets.collect(),
        touching,
    };
    Ok(problem.solve(dynamics)?.spread(dynamics))
}

/// The states of one contact that the solution leaves open; `zeros` are the normal and tangential
/// accelerations below which it does not decide.
fn candidate(
    dynamics: &Dynamics<'_>,
    (balance, slot): (&Balance, usize),
    zeros: (f64, f64),
    vanished: Option<Switch>,
) -> Candidate {
    let contact = balance.touching.contacts[slot];
    let known = match vanished {
        Some(Switch::NormalForce(other)) if other == contact => Vanished {
            force: true,
            reserve: None,
        },
        Some(Switch::FrictionLimit(other, direction)) if other == contact => Vanished {
            force: false,
            reserve: Some(direction),
        },
        _ => Vanished::default(),
    };
    let sticking = ContactState::sticking(dynamics.is_in_space(contact));
    let slip = balance.slip(slot);
    let (states, remainder) = match balance.decide(dynamics, slot, zeros, known) {
        Decision::Is(state) => (vec![state], 0.0),
        Decision::Edge(state) => {
            let slip = slip.map_or(0.0, pair_size);
            let margin = balance.margin(dynamics, slot).abs();
            (vec![sticking, state], margin.max(slip))
        }
        // Neither side of a switch agrees whose jump begins to grow here.
        Decision::Touches if slip.is_some() && dynamics.switch_of(contact).is_some() => {
            (vec![sticking], 0.0)
        }
        Decision::Touches => {
            let mut states = match slip {
                None => vec![sliding(dynamics, contact)],
                // In space it slips along the direction of its frame.
                Some(_) if dynamics.is_in_space(contact) => vec![sticking, ContactState::slip(1.0)],
                Some(_) => vec![sticking, ContactState::slip(1.0), ContactState::slip(-1.0)],
            };
            if !dynamics.is_dry(contact) {
                // Dry friction acts always, if only with a force of zero.
                states.push(ContactState::Open);
            }
            let (force, motion) = (balance.forces[slot], balance.motions[slot]);
            (states, force.abs().max(motion.abs()))
        }
    };
    Candidate {
        contact,
        states,
        remainder,
        stops: slip.is_some(),
    }
}

/// All choices of one state for each candidate, fewest open contacts first; `None` if there are too many.
fn combinations(undecided: &[&Candidate]) -> Option<Vec<Vec<ContactState>>> {
    let mut all = vec![Vec::new()];
    for candidate in undecided {
        if all.len() * candidate.states.len() > MOST_MODES {
            return None;
        }
        all = all
            .into_iter()
            .flat_map(|states| {
                candidate.states.iter().map(move |&state| {
                    let mut longer = states.clone();
                    longer.push(state);
                    longer
                })
            })
            .collect();
    }
    all.sort_by_key(|states| states.iter().filter(|state| state.is_open()).count());
    Some(all)
}

/// Sets the mode, in which contacts that others keep from sliding are held.
fn enter(dynamics: &mut Dynamics<'_>, mode: &[ContactState], t: f64, y: &[f64]) {
    dynamics.set_mode(mode);
    hold_dependent(dynamics, t, y);
    let mode = dynamics.mode().to_vec();
    if !mode.iter().any(|state| state.slips()) {
        return;
    }
    let n = dynamics.n;
    let mut slope = vec![0.0; y.len()];
    dynamics.derivative(t, y, &mut slope);
    let mut held = mode;
    for (i, state) in held.iter_mut().enumerate() {
        let ContactState::Slip(direction) = *state else {
            continue;
        };
        let (_, acceleration) = dynamics.contact_accelerations(i, &slope[n..2 * n]);
        let rests = dynamics.sliding_velocity(i).abs() <= dynamics.zero_sliding_velocity(i)
            && acceleration.abs() <= BIACTIVE * dynamics.sliding_acceleration_scale(i);
        let passes = dynamics.passes(i) || dynamics.sides[i] != 0.0;
        let may_be_held = !passes && !dynamics.is_in_space(i);
        if rests && may_be_held && motion::holds(dynamics, i) {
            *state = ContactState::Held(Some(direction));
        }
    }
    dynamics.set_mode(&held);
}

/// Of contacts that stick, those that the ones before them keep from sliding are held without a tangential force of their
/// own: two feet of a rigid body cannot both have one.
fn hold_dependent(dynamics: &mut Dynamics<'_>, t: f64, y: &[f64]) {
    let mut mode = dynamics.mode().to_vec();
    // Those in space stick whatever others hold: how they share their load is asked for as long as they hold.
    let sticks = |&i: &usize| mode[i].sticks() && !dynamics.is_in_space(i);
    let sticking: Vec<usize> = (0..mode.len()).filter(sticks).collect();
    let Some((_, others)) = sticking.split_first() else {
        return;
    };
    if others.is_empty() {
        return;
    }
    for &i in others {
        mode[i] = ContactState::Held(None);
    }
    dynamics.set_mode(&mode);
    let mut slope = vec![0.0; y.len()];
    dynamics.derivative(t, y, &mut slope);
    let mut lines = motion::held(dynamics);
    lines.extend(others.iter().map(|&i| Line::tangent(i)));
    let switches = sticking.iter().any(|&i| dynamics.switch_of(i).is_some());
    // Switches may hold each other of which fewer could not.
    let independent = switches && shares::are_independent(dynamics, &lines);
    for &i in others {
        if independent || !motion::holds(dynamics, i) {
            mode[i] = ContactState::Stick;
            dynamics.set_mode(&mode);
        }
    }
}
