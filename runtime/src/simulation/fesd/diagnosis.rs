//! Why a run stopped, in words.

use super::driver::{Driver, rest_velocity};
use super::stop::Stop;
use crate::contact::find;
use crate::contact::touching::jammed;
use crate::fesd::contacts::ModeError;
use crate::fesd::finite_element::ElementError;
use crate::run::resets;
use crate::simulation::problem::{not_finite_at, vanishing_inertia};
use crate::simulation::sentences::{
    has_pole, leaps, negative_bound, not_unique, second_order, unbounded, zero_parameters,
};
use crate::simulation::{Diagnosis, EventKind, SimulationStatus};

/// Switches while time nearly stands still before the contact mode counts as ambiguous. A ball that keeps all but a hundredth
/// of its speed takes about 1,400 bounces to rest.
pub(super) const MAX_SWITCHES: usize = 5_000;

/// Normal acceleration for a unit force of a sliding contact, 1 without friction, below which the failure of
/// short elements is that of the contact law.
const NEARLY_JAMMED: f64 = 1e-2;

/// Share of the horizon after which a motion that cannot go on is looked at.
const AHEAD: f64 = 1e-6;

/// Growth of a velocity in a moment that only a pole explains: a force that a contact or a switch turns on changes it by less than itself.
const GROWTH: f64 = 1e3;

pub(super) fn diagnosis(
    driver: &Driver<'_>,
    step: usize,
    contact: Option<usize>,
    message: String,
) -> Diagnosis {
    Diagnosis {
        time: driver.now.state.time,
        step,
        contact,
        message,
    }
}

/// Whether the friction of a sliding contact presses nearly as much as its force lifts, so that the forces
/// grow without bound.
pub(super) fn nearly_jams(driver: &Driver<'_>) -> bool {
    driver.now.active.iter().any(|held| {
        let sense = held.state.sense();
        sense != 0.0 && driver.now.contacts.lift_in_slip(held.contact, sense) < NEARLY_JAMMED
    })
}

/// The status of a run whose elements become ever shorter, the last of them up to `end`.
pub(super) fn too_short(driver: &Driver<'_>, step: usize, end: f64) -> SimulationStatus {
    if nearly_jams(driver) {
        return stopped(driver, step, &Stop::Mode(ModeError::Jammed));
    }
    if driver.record.not_finite && not_finite_ahead(driver, end) {
        return stopped(driver, step, &Stop::Mode(ModeError::NotFinite));
    }
    let start = driver.setup.problem.input(driver.setup.model);
    if let Some(why) = vanishing_inertia(driver.setup.model, &start, driver.now.input()) {
        return SimulationStatus::NotFinite(diagnosis(driver, step, None, why));
    }
    if let Some(coordinate) = grows(driver) {
        return SimulationStatus::NotFinite(diagnosis(driver, step, None, unbounded(coordinate)));
    }
    let settings = driver.setup.settings;
    let why = if settings.stage_count() == 1 && settings.promise().is_some() {
        "an element of one stage has an order too low for the tolerance; error control needs 2 stages or more, or name \
         the steps"
    } else {
        "forces grow without bound, switches of the contact mode follow each other, or the tolerance is below what the model's \
         functions resolve; raise the tolerance, or ask the method `event`"
    };
    SimulationStatus::StepLimit(diagnosis(
        driver,
        step,
        driver.now.active.first().map(|held| held.contact),
        format!(
            "too many elements, the last of {:.1e} s: {why}",
            end - driver.now.state.time
        ),
    ))
}

/// The coordinate whose acceleration would change its velocity in a moment, [`AHEAD`] of the horizon, by more than a thousand times what it
/// is and was: near a pole it changes by any factor in ever shorter elements.
fn grows(driver: &Driver<'_>) -> Option<&'static str> {
    let (state, problem) = (&driver.now.state, driver.setup.problem);
    let moment = AHEAD * driver.setup.horizon;
    let grows = |k: &usize| {
        let change = moment * driver.now.acceleration[*k].abs();
        let known = state.v[*k].abs() + problem.v[*k].abs();
        known > 0.0 && change > GROWTH * known
    };
    let coordinate = (0..state.q.len()).find(grows)?;
    Some(driver.setup.model.declaration().coordinates[coordinate].name)
}

/// Whether the model is infinite or not a number soon after the present state, where elements up to `end` fail: within what they would
/// cover, and a little more.
fn not_finite_ahead(driver: &Driver<'_>, end: f64) -> bool {
    let (model, state) = (driver.setup.model, &driver.now.state);
    let n = state.q.len();
    let soon = (end - state.time).max(AHEAD * driver.setup.horizon);
    [0.0, soon].into_iter().any(|after| {
        let mut x = driver.now.input().to_vec();
        let (places, rest) = x.split_at_mut(n);
        let later = places.iter_mut().zip(&state.q).zip(&state.v);
        later.for_each(|((x, q), v)| *x = q + after * v);
        let later = rest.iter_mut().zip(&state.v).zip(&driver.now.acceleration);
        later.for_each(|((x, v), a)| *x = v + after * a);
        if model.declaration().explicit_time
            && let Some(time) = rest.last_mut()
        {
            *time = state.time + after;
        }
        not_finite_at(model, &x).is_some()
    })
}

/// The status of a run that takes more elements than allowed.
pub(super) fn too_many(driver: &Driver<'_>, step: usize) -> SimulationStatus {
    SimulationStatus::StepLimit(diagnosis(
        driver,
        step,
        None,
        format!(
            "{} elements do not reach the horizon; shorten it, raise the tolerance, or raise \
             `most_elements`",
            driver.setup.settings.most_elements
        ),
    ))
}

/// The status of a run whose contact mode switches without end since the time `burst` \[s\], in that step.
pub(super) fn unsettled(driver: &Driver<'_>, step: usize, burst: f64) -> SimulationStatus {
    let last = driver.record.events.last();
    let contact = last.map(|event| event.contact);
    let why = match last {
        Some(event)
            if event.kind == EventKind::Impact && driver.setup.restitution[event.contact] > 0.0 =>
        {
            let name = driver.setup.name(event.contact);
            let rest = rest_velocity(driver, event.contact);
            format!(
                "`{name}` bounces too often before it rests: raise the rest velocity, {rest:.1e} now, or lower the restitution"
            )
        }
        _ => "the contact mode does not settle: look at the surfaces that meet here, or take more steps"
            .into(),
    };
    SimulationStatus::AmbiguousContact(diagnosis(
        driver,
        step,
        contact,
        format!(
            "more than {MAX_SWITCHES} switches within {:.1e} s; {why}",
            driver.now.state.time - burst
        ),
    ))
}

/// The status of a run with more events than are allowed.
pub(super) fn too_many_events(driver: &Driver<'_>, step: usize) -> SimulationStatus {
    let contact = driver.record.events.last().map(|event| event.contact);
    let message = format!(
        "{} switches of the contact mode until here; shorten the horizon, raise the rest velocity where bounces die away, or raise `most_events`",
        driver.events()
    );
    SimulationStatus::EventLimit(diagnosis(driver, step, contact, message))
}

/// What of the model is infinite or not a number at the present state, and where to look.
fn not_finite(driver: &Driver<'_>) -> String {
    let model = driver.setup.model;
    let what = not_finite_at(model, driver.now.input()).unwrap_or_else(|| "the model".to_owned());
    format!(
        "{what} is infinite or not a number here; look for a division by zero or a root of a negative number{}",
        zero_parameters(model)
    )
}

/// Contacts that touch at the present state.
fn touching(driver: &Driver<'_>) -> impl Iterator<Item = usize> {
    driver.now.near().iter().copied().filter(|&i| {
        find(&driver.now.active, i).is_some()
            || driver.now.contacts.gap(i) <= driver.now.size(i).touching_gap()
    })
}

/// Why no force satisfies the contact law, and the contact to blame: friction that presses more than the
/// contact force lifts, or else the directions.
fn jamming(driver: &Driver<'_>) -> (Option<usize>, String) {
    let pressed = touching(driver)
        .filter(|&i| driver.now.contacts.friction(i) > 0.0)
        .flat_map(|i| [(i, 1.0), (i, -1.0)])
        .map(|(i, sense)| (i, sense, driver.now.contacts.lift_in_slip(i, sense)))
        .min_by(|a, b| a.2.total_cmp(&b.2));
    let first = touching(driver).next();
    match pressed {
        Some((i, sense, lift)) if lift < NEARLY_JAMMED => (
            Some(i),
            format!(
                "no impulse or force satisfies the contact law (jamming): when `{}` slides {} its \
                 friction presses as much as the contact force lifts, or more (1 -+ mu n'e = {lift:.1e}, \
                 Painleve's paradox); lower the friction or keep away from this position",
                driver.setup.name(i),
                if sense > 0.0 { "forward" } else { "backward" },
            ),
        ),
        _ if several_bounce(driver) => (
            first,
            "no impulse satisfies the contact law: restitution sends several \
             contacts back at once, and their friction does not let them go; lower either"
                .into(),
        ),
        _ => (
            first,
            "no impulse or force satisfies the contact law (jamming): the forces of the contacts \
             that touch push each other into the ground; look at their surfaces and impact laws"
                .into(),
        ),
    }
}

/// Whether several contacts with friction and restitution touch and close.
fn several_bounce(driver: &Driver<'_>) -> bool {
    let bounces = |&i: &usize| {
        driver.now.contacts.friction(i) > 0.0
            && driver.setup.restitution[i] > 0.0
            && driver.now.contacts.normal_velocity(i) < 0.0
    };
    touching(driver).filter(bounces).count() > 1
}

pub(super) fn stopped(driver: &Driver<'_>, step: usize, stop: &Stop) -> SimulationStatus {
    let names = |contacts: &mut dyn Iterator<Item = usize>| {
        let declared = driver.setup.model.declaration().contacts;
        let names: Vec<&str> = contacts.map(|i| declared[i].name).collect();
        names.join(", ")
    };
    let held = names(&mut driver.now.active.iter().map(|held| held.contact));
    let touched = names(&mut touching(driver));
    let mode = match (held.as_str(), touched.as_str()) {
        ("", "") => "in free motion".to_string(),
        ("", touched) => format!("touching {touched}"),
        (held, _) => format!("in contact with {held}"),
    };
    let contact = driver.now.active.first().map(|held| held.contact);
    let contact = contact.or_else(|| touching(driver).next());
    let describe = |what: &str| {
        format!(
            "step {step} at t = {} s {mode}: {what}",
            driver.now.state.time
        )
    };
    let failed =
        |what: &str| SimulationStatus::StepFailed(diagnosis(driver, step, contact, describe(what)));
    match stop {
        Stop::Element(ElementError::NotFinite) | Stop::Mode(ModeError::NotFinite) => {
            SimulationStatus::NotFinite(diagnosis(
                driver,
                step,
                contact,
                describe(&not_finite(driver)),
            ))
        }
        &Stop::Mode(error) => {
            let (blamed, why) = undetermined(driver, error);
            let contact = blamed.or(contact);
            SimulationStatus::AmbiguousContact(diagnosis(driver, step, contact, describe(&why)))
        }
        Stop::Element(ElementError::Singular) => {
            failed("singular element matrix; the active contacts may be dependent")
        }
        Stop::Element(ElementError::NotConverged) => {
            failed("Newton's method did not converge; take more steps")
        }
        &Stop::Leap(contact, time) => SimulationStatus::NotFinite(Diagnosis {
            time,
            step,
            contact: Some(contact),
            message: match driver.now.contacts.switch_of(contact) {
                None => leaps(driver.setup.name(contact)),
                Some(_) => has_pole(driver.setup.name(contact)),
            },
        }),
        Stop::Unresolved => failed("a gap varies too fast for the elements; take more steps"),
        Stop::Location => failed("a switch could not be located; take more steps"),
    }
}

/// Why no mode of the contacts could be determined, and the one to blame, if it is known.
fn undetermined(driver: &Driver<'_>, error: ModeError) -> (Option<usize>, String) {
    let name = |contact: usize| driver.setup.name(contact);
    match error {
        ModeError::Jammed | ModeError::NotFinite => jamming(driver),
        ModeError::Several(contact) => {
            let view = &driver.now.contacts;
            let gain = [1.0, -1.0].map(|sense| view.lift_in_slip(contact, sense));
            let why = jammed(view, contact, gain[0].min(gain[1]));
            let several = "the law of contact has several solutions with different motions";
            (Some(contact), format!("{several}: {why}"))
        }
        ModeError::NegativeBound(contact) => (Some(contact), negative_bound(name(contact))),
        ModeError::NotUnique(contact) => (Some(contact), not_unique(name(contact))),
        ModeError::SecondOrder(contact) => (Some(contact), second_order(name(contact))),
        ModeError::SetTwice(contact) => (Some(contact), resets::set_twice(name(contact))),
        ModeError::Dependent => {
            let why = "the normals of the active contacts are dependent";
            (None, why.to_owned())
        }
    }
}
