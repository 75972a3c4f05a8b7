//! The stepping loop: elements, segments between switches, their lengths.

use hangtime_solver::clock::ThreadTime;

use super::diagnosis::{self, MAX_SWITCHES};
use super::driver::Driver;
use super::error_control::ErrorControl;
use super::settings::Fesd;
use super::stop::Stop;
use super::{hidden_force, location, mode_change, standstill};
use crate::fesd::contacts::ModeError;
use crate::fesd::finite_element::{ElementError, newton};
use crate::run::rest::BURST;
use crate::simulation::explicit_time::ExplicitTime;
use crate::simulation::problem::MOMENT;
use crate::simulation::watch::Watch;
use crate::simulation::{EventKind, Seconds, Simulation, SimulationStatus};
use crate::simulation::{accumulation, agreement};

/// Attempts at a segment within a hundredth of the horizon: of them some are rejected, some lead to a switch.
const MAX_ATTEMPTS: usize = 20_000;

/// Attempts that lead to one switch, which do not count.
const ATTEMPTS_A_SWITCH: usize = 10;
/// Elements that an event takes, which do not count against the limit on elements: events have their own.
const ELEMENTS_AN_EVENT: usize = 4;
const SHORTEST_BURST: f64 = 1e-9;

/// How a segment ended.
enum Segment {
    /// At its planned end.
    Completed,
    /// At a switch, which was carried out.
    Switched,
    /// Nowhere: the error estimate asks for a shorter element.
    Rejected,
}

/// Runs to the horizon, or until it fails.
pub(super) fn run(mut driver: Driver<'_>, watch: &mut Watch<'_>) -> Simulation {
    let clock = ThreadTime::now();
    let status = match steps(&mut driver, watch) {
        Ok(()) => {
            let verdict = &driver.record.verdict;
            let status = verdict.status(driver.setup.model);
            status.unwrap_or(SimulationStatus::Solved)
        }
        Err(status) => status,
    };
    if driver.record.forgetful {
        driver.record.forgetful = false;
        driver.record_state();
    }
    let controlled = driver.control.tolerance.is_some();
    let explicit_time = driver.explicit_time.as_ref();
    let mut notes = Vec::from_iter(explicit_time.and_then(ExplicitTime::note));
    let remarks = &driver.record.remarks;
    notes.extend(remarks.notes(driver.setup.model.declaration()));
    let newton = driver.element.counts;
    let other = driver.next_element.counts;
    driver.record.counts.events = driver.events();
    driver.record.counts.newton = newton.iterations + other.iterations;
    driver.record.counts.factorizations = newton.factorizations + other.factorizations;
    driver.record.counts.evaluations =
        newton.evaluations + other.evaluations + driver.now.contacts.evaluations;
    let model = driver.setup.model;
    let interpolated = driver.detector.interpolated.iter();
    let interpolated = interpolated.map(|function| function.name(model));
    let mut run = Simulation {
        declaration: driver.setup.model.declaration(),
        status,
        error_estimate: None,
        initial_modes: driver.record.initial_modes,
        events: driver.record.events,
        trajectory: driver.record.trajectory,
        residuals: driver.record.verdict.residuals,
        size: driver.record.size,
        counts: driver.record.counts,
        seconds: Seconds {
            total: clock.elapsed().as_secs_f64(),
            ..Seconds::default()
        },
        interpolated: Some(interpolated.collect()),
        notes,
        doubts: driver.record.remarks.doubts(),
    };
    if run.status.is_solved() {
        let scene = (driver.setup.model, driver.setup.problem);
        let elements = agreement::share(&run, scene, &driver.control.local_errors);
        // Under error control runs are compared, and steps that were solved as programs count by their difference.
        let programs = if controlled {
            0.0
        } else {
            driver.control.estimate
        };
        run.error_estimate = Some(elements + programs);
    }
    run
}

/// Steps over the horizon.
fn step_count(driver: &Driver<'_>) -> usize {
    match driver.control.tolerance {
        None => driver.setup.settings.steps.unwrap_or(Fesd::DEFAULT_STEPS),
        Some(_) => driver.setup.settings.steps.unwrap_or(1),
    }
}

fn steps(driver: &mut Driver<'_>, watch: &mut Watch<'_>) -> Result<(), SimulationStatus> {
    driver.now.take_piece(driver.setup.controls, 0.0);
    driver.now.active.clear();
    driver.now.write_input();
    let shortest = driver.setup.shortest();
    let now = &mut driver.now;
    now.contacts.shortest = shortest;
    now.contacts.moment = driver.setup.horizon;
    if let Some(explicit_time) = &mut driver.explicit_time {
        explicit_time.longest(&now.x, driver.setup.horizon);
        now.contacts.moment = explicit_time.moment();
    }
    now.contacts
        .remember_rounding_at_start(&now.x, MOMENT * driver.setup.horizon);
    leave_the_ground(driver);
    driver.record_state();
    if let Err(error) = mode_change::settle(driver, &[]) {
        return Err(diagnosis::stopped(driver, 0, &Stop::Mode(error)));
    }
    let mut events = driver.record.events.iter();
    if !events.any(|event| event.kind == EventKind::Impact) {
        // The instant before is one of its own where something is struck at once.
        driver.record.trajectory.truncate(0);
    }
    driver.record.initial_modes = driver.now.modes();
    driver.record_state();
    let now = &driver.now;
    driver
        .control
        .propose_first(&now.state.v, &now.acceleration);
    let steps = step_count(driver);
    for step in 0..steps {
        let end = if step + 1 == steps {
            driver.setup.horizon
        } else {
            driver.setup.horizon * (step + 1) as f64 / steps as f64
        };
        advance(driver, step, end, watch)?;
        watch.reach(
            driver.now.state.time,
            driver.record.counts.elements,
            &mut driver.record.trajectory,
        )?;
    }
    Ok(())
}

/// Moves a start that is inside the ground, by less than is refused but more than its rounding error, onto the surface; the
/// contacts are evaluated there.
fn leave_the_ground(driver: &mut Driver<'_>) {
    let now = &mut driver.now;
    now.contacts.remember_sizes(&now.x, 0..now.gaps.len());
    let surfaces = 0..now.contacts.surfaces;
    let sinks = |&i: &usize| {
        !now.contacts.pieces.is_idle(i) && now.contacts.gap(i) < -now.size(i).gap_rounding()
    };
    let inside: Vec<usize> = surfaces.filter(sinks).collect();
    if inside.is_empty() {
        return;
    }
    let start = now.state.q.clone();
    if mode_change::project(driver, &inside).is_err() {
        driver.now.state.q = start;
    }
}

/// A step of the grid, and how it goes.
pub(super) struct Step {
    /// Its number, from 0.
    pub(super) number: usize,
    begin: f64,
    end: f64,
    /// What is left of it where it has been made, up to rounding error \[s\].
    shortest: f64,
    /// How often its elements have been halved.
    halvings: usize,
    /// Attempts at segments since `counted_from` \[s\], but for those that a switch takes.
    attempts: usize,
    counted_from: f64,
    /// Switches of a burst, and its begin \[s\].
    switches: usize,
    pub(super) burst: f64,
}

impl Step {
    fn new(number: usize, (begin, end): (f64, f64), shortest: f64) -> Self {
        Self {
            number,
            begin,
            end,
            shortest,
            halvings: 0,
            attempts: 0,
            counted_from: begin,
            switches: 0,
            burst: begin,
        }
    }

    /// Counts a switch at this `time` of a run to `horizon`; true if they come so fast that time stands still.
    fn bursts(&mut self, time: f64, horizon: f64) -> bool {
        if time - self.burst > (BURST * time).max(SHORTEST_BURST * horizon) {
            (self.switches, self.burst) = (0, time);
        }
        self.switches += 1;
        self.attempts = self.attempts.saturating_sub(ATTEMPTS_A_SWITCH);
        self.switches > MAX_SWITCHES
    }

    /// Halves the elements after a segment of this `length` that led to nothing.
    fn halve(&mut self, control: &mut ErrorControl, length: f64) {
        self.halvings = (self.halvings + 1).min(control.most_halvings());
        control.shorten(length);
    }
}

/// Advances to `end`, with as many segments as there are switches and pieces of the controls.
fn advance(
    driver: &mut Driver<'_>,
    number: usize,
    end: f64,
    watch: &mut Watch<'_>,
) -> Result<(), SimulationStatus> {
    let mut step = Step::new(
        number,
        (driver.now.state.time, end),
        driver.setup.shortest(),
    );
    while end - driver.now.state.time > step.shortest {
        watch.reach(
            driver.now.state.time,
            driver.record.counts.elements,
            &mut driver.record.trajectory,
        )?;
        take_up_controls(driver, number)?;
        let next = driver.setup.controls.next_break(driver.now.state.time);
        let piece_end = next.map_or(end, |next| next.min(end));
        if standstill::rests(driver) {
            standstill::rest(driver, piece_end)
                .map_err(|error| diagnosis::stopped(driver, number, &Stop::Mode(error)))?;
        } else if let Err(status) = attempt(driver, &mut step, piece_end) {
            match standstill::comes_to_rest(driver) {
                Ok(true) => {}
                Ok(false) => return Err(status),
                Err(error) => return Err(diagnosis::stopped(driver, number, &Stop::Mode(error))),
            }
        }
    }
    driver.now.state.time = end;
    if let Some(time) = driver.record.trajectory.time.last_mut() {
        *time = end;
    }
    Ok(())
}

/// Attempts a segment of a step, at most up to `piece_end`, and decides how to go on where it fails.
fn attempt(
    driver: &mut Driver<'_>,
    step: &mut Step,
    piece_end: f64,
) -> Result<(), SimulationStatus> {
    let time = driver.now.state.time;
    let share = (piece_end - time) / (step.end - step.begin);
    let share = driver.setup.settings.elements as f64 * share;
    let (end, elements) = driver.control.plan(time, piece_end, share, step.halvings);
    let end = foreseen(driver, end, elements);
    driver.now.look_ahead(end - time);
    if time - step.counted_from > 0.01 * driver.setup.horizon {
        step.attempts = 0;
        step.counted_from = time;
    }
    step.attempts += 1;
    let most = driver.setup.settings.most_elements + ELEMENTS_AN_EVENT * driver.events();
    if driver.record.counts.elements >= most {
        return Err(diagnosis::too_many(driver, step.number));
    }
    let control = &driver.control;
    let vanishes = control.tolerance.is_some() && control.proposed_length <= step.shortest;
    if step.attempts > MAX_ATTEMPTS || vanishes {
        return Err(diagnosis::too_short(driver, step.number, end));
    }
    let events = driver.record.events.len();
    match segment(driver, step, end, elements) {
        Ok(Segment::Rejected) => {}
        Ok(Segment::Completed) if driver.control.tolerance.is_some() => step.halvings = 0,
        Ok(Segment::Completed) => step.halvings = step.halvings.saturating_sub(1),
        Ok(Segment::Switched) => {
            driver.record.not_finite = false;
            let bursts = step.bursts(driver.now.state.time, driver.setup.horizon);
            // A switch at the start that changes nothing is an error of an element that is much too long.
            if driver.now.state.time == time && driver.record.events.len() == events {
                step.halve(&mut driver.control, end - time);
            }
            if let Some(status) = accumulation::of(&driver.record.events, driver.setup.horizon) {
                return Err(status);
            }
            if bursts {
                return Err(diagnosis::unsettled(driver, step.number, step.burst));
            }
            if driver.events() > driver.setup.settings.most_events {
                return Err(diagnosis::too_many_events(driver, step.number));
            }
            driver.record.log.tidy(&mut driver.record.events);
        }
        Err(stop) => recover(driver, step, (end, stop))?,
    }
    Ok(())
}

/// The end of the next segment of this many elements, planned at `end`, up to which it tells what depends on time. A grid that was
/// asked for stays.
fn foreseen(driver: &mut Driver<'_>, end: f64, elements: usize) -> f64 {
    let Some(explicit_time) = &mut driver.explicit_time else {
        return end;
    };
    driver.now.write_input();
    let (time, x) = (driver.now.state.time, &driver.now.x);
    if driver.control.tolerance.is_none() {
        let length = (end - time) / elements as f64;
        driver.now.contacts.moment = length;
        explicit_time.watch(x, length, elements);
        return end;
    }
    let longest = explicit_time.longest(x, end - time);
    driver.now.contacts.moment = explicit_time.moment();
    if longest < end - time {
        time + longest
    } else {
        end
    }
}

/// Goes on after a segment up to `end` that failed with shorter elements, as far as they may help.
fn recover(
    driver: &mut Driver<'_>,
    step: &mut Step,
    (end, stop): (f64, Stop),
) -> Result<(), SimulationStatus> {
    if matches!(stop, Stop::Leap(..)) {
        return Err(diagnosis::stopped(driver, step.number, &stop));
    }
    let mode = matches!(stop, Stop::Mode(_));
    let not_finite = matches!(
        stop,
        Stop::Mode(ModeError::NotFinite) | Stop::Element(ElementError::NotFinite)
    );
    if (not_finite || !mode) && step.halvings < driver.control.most_halvings() {
        let length = end - driver.start.state.time;
        step.halve(&mut driver.control, length);
        driver.record.not_finite |= not_finite;
        return Ok(());
    }
    if !mode && diagnosis::nearly_jams(driver) {
        let jammed = Stop::Mode(ModeError::Jammed);
        return Err(diagnosis::stopped(driver, step.number, &jammed));
    }
    Err(diagnosis::stopped(driver, step.number, &stop))
}

/// Controls that hold from now on; a jump of theirs may change the contact mode.
fn take_up_controls(driver: &mut Driver<'_>, step: usize) -> Result<(), SimulationStatus> {
    if driver.now.u.is_empty() {
        return Ok(());
    }
    let before = driver.now.u.clone();
    // A jump within rounding error of the present time has been reached.
    let now = driver.now.state.time + 4.0 * f64::EPSILON * driver.setup.horizon;
    driver.now.take_piece(driver.setup.controls, now);
    if driver.setup.controls.jumps() && before != driver.now.u && driver.now.state.time > 0.0 {
        if let Err(error) = mode_change::settle(driver, &[]) {
            return Err(diagnosis::stopped(driver, step, &Stop::Mode(error)));
        }
        driver.record_state();
    }
    Ok(())
}

/// Solves `elements` elements of equal length up to `end`, or up to the first switch, which is then
/// located, with the elements before it of equal length again, and carried out.
fn segment(
    driver: &mut Driver<'_>,
    step: &mut Step,
    end: f64,
    elements: usize,
) -> Result<Segment, Stop> {
    driver.begin_segment();
    let length = (end - driver.now.state.time) / elements as f64;
    let mut violation = None;
    for count in 1..=elements {
        let now = &driver.now;
        newton::solve(&mut driver.element, &now.state, length, &now.piece)?;
        let acceleration = &driver.now.acceleration;
        if driver.control.rejects(&mut driver.element, acceleration) {
            return Ok(Segment::Rejected);
        }
        let found = driver.first_violation()?;
        if hidden_force::acts(driver, found.map_or(1.0, |switch| switch.theta)) {
            driver.control.shorten(length);
            return Ok(Segment::Rejected);
        }
        if let Some(switch) = found {
            violation = Some((switch, count));
            break;
        }
        let length = driver.element.length;
        if driver.control.strays(driver.detector.drift, length) {
            return Ok(Segment::Rejected);
        }
        driver.accept_element()?;
    }
    let Some((switch, count)) = violation else {
        return Ok(Segment::Completed);
    };
    driver.return_to_start();
    let offset = (count - 1) as f64 + switch.theta;
    if offset * length <= step.shortest && location::holds_at_start(driver, switch.function) {
        mode_change::carry_out(driver, switch.function)?;
        return Ok(Segment::Switched);
    }
    let located = match location::locate(driver, switch, length, count) {
        Ok(located) => located,
        Err(stop) => {
            // Whoever tries again starts where this segment did.
            driver.return_to_start();
            driver.evaluate_state()?;
            return Err(stop);
        }
    };
    mode_change::carry_out(driver, located.function)?;
    Ok(Segment::Switched)
}
