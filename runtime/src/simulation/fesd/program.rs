//! A step as the complementarity problem itself: the time-freezing system transcribed by FESD and solved by
//! the interior point method. The last resort where Newton's method in a fixed mode fails.
//!
//! Its limit is that of the step form: a jump may share an element with the contact after it, so that an
//! switch is known to the length of an element.

use hangtime_solver::mpcc;
use hangtime_solver::nlp::IterationInfo;

use super::driver::{Driver, end_bounces, rest_velocity};
use super::mode_change;
use super::settings::StepFormulation;
use super::stop::Stop;
use crate::contact::impact;
use crate::contact::{ActiveContact, ContactState, find};
use crate::fesd::contact_mode;
use crate::fesd::finite_element::{ElementError, State};
use crate::joints::{JointError, Joints};
use crate::model::Model;
use crate::program::sparse_program::Program;
use crate::rk::ButcherTableau;
use crate::simulation::EventKind;
use crate::simulation::watch::Watch;
use crate::time_freezing::field::Field;
use crate::time_freezing::step_form::transcribe;
use crate::time_freezing::task::{CrossComplementarity, Guess, Outer, Task};
use crate::time_freezing::transcription::Transcription;

/// Finite elements that one switch with an impact needs: before, jump, after.
pub(super) const ELEMENTS: usize = 3;
/// Finite elements that a bounce needs: before, fall, rise, after.
pub(super) const BOUNCE_ELEMENTS: usize = 4;
/// Numbers of elements that are tried in turn; another number often solves a step that one does not.
const ATTEMPTS: usize = 3;
/// Acceleration of the auxiliary dynamics here, of the order of contact accelerations: the step functions
/// stay away from 0 and 1, and more steps are solved (of 448 with and without impact 411, with 981 m/s^2 357).
pub(super) const AUXILIARY_ACCELERATION: f64 = 20.0;
/// Barrier parameter of the start, which is a coarse simulation: from 1e-5 424 of the 448 steps are solved, in
/// two thirds of the iterations that 0.1 takes for 412.
const BARRIER_PARAMETER: f64 = 1e-5;
/// Interior point iterations of one run; steps that are solved take fewer than half of them.
const MAX_ITERATIONS: usize = 300;
/// Residual up to which a solution of the program is a step.
const ACCEPTED: f64 = 1e-7;
/// Distance of a mean step function from 0 or 1 that counts as sustained contact.
const BETWEEN: f64 = 1e-4;

/// A step that is solved as a complementarity problem.
pub(super) struct Step<'s> {
    pub(super) state: &'s State,
    /// Controls at its start, and their rates, empty where they are constant.
    pub(super) u: &'s [f64],
    pub(super) slopes: &'s [f64],
    /// Its length \[s\].
    pub(super) duration: f64,
    pub(super) elements: usize,
}

impl Step<'_> {
    /// Its program, in which the contacts in `resting` do not bounce.
    pub(super) fn program<'a>(
        &self,
        model: &'a dyn Model,
        resting: &[usize],
        tableau: &ButcherTableau,
    ) -> Transcription<'a> {
        let mut program = Program::new(model);
        let mut given = |what: &str, value: f64| {
            program.variable(format!("{what} of the step"), (value, value), value, 1.0)
        };
        let n = self.state.q.len();
        let start = self.state.q.iter().chain(&self.state.v);
        let outer = Outer {
            horizon: given("length", self.duration),
            controls: vec![self.u.iter().map(|&u| given("control", u)).collect()],
            start: start.map(|&value| given("state", value)).collect(),
        };
        let field = Field::new(model, AUXILIARY_ACCELERATION, resting);
        let task = Task {
            time: self.state.time,
            linear: false,
            slopes: self.slopes.to_vec(),
            intervals: 1,
            elements: self.elements,
            coordinate_bounds: (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]),
            cross: CrossComplementarity::FeFe,
            guess: Guess::Simulated,
        };
        transcribe(program, outer, field, tableau, task).finished()
    }
}

/// What a contact does during an element of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Free,
    Jump,
    Contact,
}

impl Phase {
    fn of(mean_alpha: f64) -> Self {
        if mean_alpha >= 1.0 - BETWEEN {
            Self::Free
        } else if mean_alpha <= BETWEEN {
            Self::Jump
        } else {
            Self::Contact
        }
    }
}

/// State for the share of friction that opposes forward sliding.
fn state(share: Option<f64>) -> ContactState {
    match share {
        None => ContactState::Held(None),
        Some(share) if share >= 1.0 - BETWEEN => ContactState::slip(1.0),
        Some(share) if share <= BETWEEN => ContactState::slip(-1.0),
        Some(_) => ContactState::Stick,
    }
}

/// Advances to `end` by one complementarity problem.
pub(super) fn solve_program(
    driver: &mut Driver<'_>,
    end: f64,
    watch: &mut Watch<'_>,
) -> Result<(), Stop> {
    if driver.setup.settings.formulation == StepFormulation::TimeFreezing {
        // Its switches are known to the length of an element only, and this formulation promises more.
        return Err(Stop::Program(
            "Newton's method did not solve the step; take more steps",
        ));
    }
    // Contacts that rest do not bounce; nor do impacts below the rest velocity, which a second run finds.
    let resting: Vec<usize> = driver.now.active.iter().map(|held| held.contact).collect();
    let elastic = |i: usize| driver.setup.restitution[i] > 0.0 && !resting.contains(&i);
    if driver.setup.contacts().any(elastic) {
        if try_program(driver, end, (&resting, BOUNCE_ELEMENTS), watch)? {
            return Ok(());
        }
        let everything: Vec<usize> = driver.setup.contacts().collect();
        if try_program(driver, end, (&everything, ELEMENTS), watch)? {
            return Ok(());
        }
        return Err(Stop::Program(
            "neither Newton's method nor the interior point method solved the step; if bounces \
             follow each other faster than the steps, raise the rest velocity",
        ));
    }
    if try_program(driver, end, (&resting, ELEMENTS), watch)? {
        return Ok(());
    }
    Err(Stop::Program(
        "neither Newton's method nor the interior point method solved the step",
    ))
}

/// Bounces that the program leaves out, with the speed at which each contact comes: impacts of the contacts
/// in `resting`, and sustained contact of the others, which the equations admit but no bounce leads to.
fn bounces_left_out(
    driver: &mut Driver<'_>,
    program: &Transcription<'_>,
    x: &[f64],
    resting: &[usize],
) -> Vec<(usize, f64)> {
    let start = driver.now.state.clone();
    let mut ended = Vec::new();
    for i in driver.setup.contacts() {
        if driver.setup.restitution[i] == 0.0 {
            continue;
        }
        let phase = |e: usize| Phase::of(program.mean_alpha(x, e, i));
        for e in 0..program.elements() {
            if !resting.contains(&i) {
                if phase(e) == Phase::Contact {
                    ended.push((i, f64::INFINITY));
                }
                continue;
            }
            let closed = if e == 0 {
                find(&driver.now.active, i).is_some()
            } else {
                phase(e - 1) != Phase::Free
            };
            if closed || phase(e) == Phase::Free {
                continue;
            }
            if e > 0 {
                driver.now.state = state_after(program, x, e - 1);
            }
            driver.now.write_input();
            driver.now.contacts.evaluate_contacts(&driver.now.x, [i]);
            ended.push((i, -driver.now.contacts.normal_velocity(i)));
            driver.now.state.copy_from(&start);
        }
    }
    driver.now.write_input();
    ended
}

/// Advances to `end` by one complementarity problem in which the contacts in `resting` do not bounce, on
/// `fewest` elements or a few more; false if it was not solved, or leaves out a bounce.
fn try_program(
    driver: &mut Driver<'_>,
    end: f64,
    (resting, fewest): (&[usize], usize),
    watch: &mut Watch<'_>,
) -> Result<bool, Stop> {
    // A jump that begins to stick has one switch more.
    let fewest = fewest + usize::from(driver.setup.frictional);
    let asked = driver.setup.settings.elements;
    let chosen = driver.setup.settings.formulation == StepFormulation::Complementarity;
    if chosen && asked < fewest {
        driver.note(&format!(
            "a step that is solved as a complementarity problem has {fewest} elements at least, not {asked}"
        ));
    }
    let fewest = asked.max(fewest);
    for elements in fewest..fewest + ATTEMPTS {
        let step = Step {
            state: &driver.now.state,
            u: &driver.now.u,
            slopes: driver.now.piece.slopes(),
            duration: end - driver.now.state.time,
            elements,
        };
        let mut program = step.program(driver.setup.model, resting, driver.setup.tableau);
        let mut settings = mpcc::Settings::default();
        settings.interior_point.initial_barrier_parameter = BARRIER_PARAMETER;
        settings.interior_point.maximum_iterations = MAX_ITERATIONS;
        settings.second_opinion = false;
        let mut stopped = false;
        let mut observer = |_: &IterationInfo| {
            stopped |= !watch.goes_on();
            !stopped
        };
        let solution = mpcc::solve_observed(&mut program, &settings, &mut observer)
            .map_err(|_| Stop::Program("the step problem was refused"))?;
        driver.record.counts.interior_point += solution.iterations - solution.crossover_iterations;
        driver.record.counts.crossover += solution.crossover_iterations;
        driver.record.counts.fallbacks += 1;
        if stopped {
            return Err(Stop::Interrupted);
        }
        // The step is a root of its equations: feasibility decides, optimality only chooses lengths.
        let residuals = solution.residuals;
        if residuals.primal.max(residuals.complementarity) > ACCEPTED {
            continue;
        }
        let ended = bounces_left_out(driver, &program, &solution.x, resting);
        let slow = |&(i, speed): &(usize, f64)| speed <= rest_velocity(driver, i);
        if ended.iter().all(slow) {
            let (start, events) = (driver.now.state.time, driver.record.events.len());
            take(driver, &program, &solution)?;
            // The program is solved to its residuals, and a switch lies anywhere in its element.
            let residuals = solution.residuals;
            driver.control.estimate += residuals.primal.max(residuals.complementarity);
            if driver.record.events.len() > events && driver.control.motion.distance > 0.0 {
                let length = (end - start) / elements as f64;
                driver.control.estimate +=
                    length * driver.control.motion.speed / driver.control.motion.distance;
            }
            // The clock of the program ends there up to its residual.
            driver.now.state.time = end;
            end_bounces(driver, &ended);
            return Ok(true);
        }
    }
    Ok(false)
}

/// Makes a solved program part of the trajectory.
fn take(
    driver: &mut Driver<'_>,
    program: &Transcription<'_>,
    solution: &mpcc::Solution,
) -> Result<(), Stop> {
    let residuals = solution.residuals;
    let measured = &mut driver.record.verdict.residuals;
    measured.primal = measured.primal.max(residuals.primal);
    measured.complementarity = measured.complementarity.max(residuals.complementarity);
    follow(driver, program, &solution.x)?;
    driver.note(
        "steps solved as complementarity problems know the time of a switch to the length of an \
         element only",
    );
    Ok(())
}

/// The state at the end of an element of a solved program.
fn state_after(program: &Transcription<'_>, x: &[f64], e: usize) -> State {
    let state = program.state(x, e);
    let time = state.len() - 1;
    State {
        time: state[time],
        q: state[..time / 2].to_vec(),
        v: state[time / 2..time].to_vec(),
    }
}

/// How far the elements of a solved program have been followed.
struct Followed {
    /// State at the last boundary.
    before: State,
    /// What each contact did in the last element.
    phases: Vec<Phase>,
    /// Where the jumps of the present instant began.
    jump_start: Option<State>,
    /// First event whose modes are not known yet: those of an instant are known where its jumps have ended.
    open_from: usize,
}

/// Records elements and events of a solved program and settles at its end.
fn follow(driver: &mut Driver<'_>, program: &Transcription<'_>, x: &[f64]) -> Result<(), Stop> {
    let phase = |i| match find(&driver.now.active, i) {
        Some(_) => Phase::Contact,
        None => Phase::Free,
    };
    let mut followed = Followed {
        before: driver.now.state.clone(),
        phases: driver.setup.contacts().map(phase).collect(),
        jump_start: None,
        open_from: driver.record.events.len(),
    };
    for e in 0..program.elements() {
        take_element(driver, (program, x, e), &mut followed)?;
    }
    for i in driver.setup.contacts() {
        if followed.phases[i] == Phase::Jump {
            finish_jump(driver, i, &mut followed);
        }
    }
    let close: Vec<usize> = driver
        .setup
        .contacts()
        .filter(|&i| followed.phases[i] != Phase::Free)
        .collect();
    close_joints(driver)?;
    mode_change::project(driver, &close)?;
    // The velocities are along the surface at the position before; it has another normal where that has been moved to.
    let now = &mut driver.now;
    now.evaluate_contacts(now.active.clone().iter().map(|held| held.contact));
    let lines = now.contacts.lines_of_impulses(&now.active);
    impact::hold(&now.contacts, &lines, &mut now.state.v)?;
    mode_change::settle(driver, &close)?;
    set_modes(driver, followed.open_from);
    Ok(())
}

/// Moves the present state onto the joints, which a solved program fulfils up to its residual.
fn close_joints(driver: &mut Driver<'_>) -> Result<(), Stop> {
    let now = &mut driver.now;
    let Some(mut joints) = Joints::of(driver.setup.model) else {
        return Ok(());
    };
    now.write_input();
    let (n, moment) = (now.state.q.len(), now.contacts.moment);
    joints
        .settle(&mut now.x, moment)
        .map_err(|error| match error {
            JointError::Singular => Stop::Element(ElementError::Singular),
            JointError::NotClosed => Stop::Element(ElementError::NotFinite),
        })?;
    now.state.q.copy_from_slice(&now.x[..n]);
    now.state.v.copy_from_slice(&now.x[n..2 * n]);
    Ok(())
}

/// Records element `e` of a solved program, and the events at its start.
fn take_element(
    driver: &mut Driver<'_>,
    (program, x, e): (&Transcription<'_>, &[f64], usize),
    followed: &mut Followed,
) -> Result<(), Stop> {
    let sliding = driver.now.active.clone();
    let after = state_after(program, x, e);
    driver.now.state.copy_from(&after);
    driver.control.motion.include(&after.q, &after.v);
    // Jumps and the slowing down by contact are inversely proportional to the acceleration.
    let physical = after.time - followed.before.time;
    driver.now.numerical_time += physical
        + (program.numerical_length(x, e) - physical) * AUXILIARY_ACCELERATION
            / driver.setup.settings.auxiliary_acceleration;
    for i in driver.setup.contacts() {
        change_phase(driver, i, Phase::of(program.mean_alpha(x, e, i)), followed);
    }
    let held = |i: &usize| followed.phases[*i] == Phase::Contact;
    driver.now.active = driver
        .setup
        .contacts()
        .filter(held)
        .map(|contact| ActiveContact {
            contact,
            state: match driver.now.contacts.has_friction(contact) {
                true => state(program.slip_share(x, e, contact)),
                false => ContactState::Frictionless,
            },
        })
        .collect();
    let contacts = driver.setup.contacts();
    driver.now.evaluate_contacts(contacts);
    contact_mode::share_friction(&driver.now.contacts, &mut driver.now.active, None)?;
    for held in driver.now.active.clone() {
        let earlier = find(&sliding, held.contact);
        let kind = earlier.and_then(|earlier| EventKind::between(earlier, held.state));
        if let Some(kind) = kind {
            let v_before = followed.before.v.clone();
            record_event_at(driver, &followed.before, kind, held.contact, v_before);
        }
    }
    if !followed.phases.contains(&Phase::Jump) {
        set_modes(driver, followed.open_from);
        followed.open_from = driver.record.events.len();
    }
    driver.evaluate_state()?;
    driver.record_state();
    followed.before.copy_from(&after);
    Ok(())
}

/// Takes a contact to the `phase` of the next element, and records what this means.
fn change_phase(driver: &mut Driver<'_>, contact: usize, phase: Phase, followed: &mut Followed) {
    let before = &followed.before;
    let kind = match (followed.phases[contact], phase) {
        (Phase::Free | Phase::Contact, Phase::Jump) => {
            followed.jump_start.get_or_insert_with(|| before.clone());
            None
        }
        (Phase::Contact, Phase::Free) => Some(EventKind::LiftOff),
        (Phase::Free, Phase::Contact) => Some(EventKind::Contact),
        _ => None,
    };
    if let Some(kind) = kind {
        record_event_at(driver, before, kind, contact, before.v.clone());
    }
    if followed.phases[contact] == Phase::Jump && phase != Phase::Jump {
        finish_jump(driver, contact, followed);
    }
    followed.phases[contact] = phase;
}

/// Makes the present modes those of all events from `first` on.
fn set_modes(driver: &mut Driver<'_>, first: usize) {
    let modes = driver.now.modes();
    for event in &mut driver.record.events[first..] {
        event.modes.clone_from(&modes);
    }
}

/// The event of a jump that has ended.
fn finish_jump(driver: &mut Driver<'_>, contact: usize, followed: &mut Followed) {
    if let Some(begin) = followed.jump_start.take() {
        let kind = EventKind::Impact;
        record_event_at(driver, &followed.before, kind, contact, begin.v);
    }
}

/// Records an event at `state`, the boundary of two elements.
fn record_event_at(
    driver: &mut Driver<'_>,
    state: &State,
    kind: EventKind,
    contact: usize,
    v_before: Vec<f64>,
) {
    let present = std::mem::replace(&mut driver.now.state, state.clone());
    driver.record_event(kind, contact, v_before);
    driver.now.state = present;
}
