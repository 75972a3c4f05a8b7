//! The stepping loop: elements, segments between switches, their lengths.

use super::diagnosis::{self, MAX_SWITCHES};
use super::driver::Driver;
use super::settings::{Fesd, StepFormulation};
use super::stop::Stop;
use super::{location, program};
use crate::fesd::contacts::ModeError;
use crate::fesd::finite_element::{ElementError, newton};
use crate::simulation::watch::Watch;
use crate::simulation::{ProblemSize, Seconds, Simulation, SimulationStatus};
use cpu_time::ThreadTime;

/// Halvings of the elements of a step before it counts as failed.
const MAX_HALVINGS: usize = 8;
/// The same under error control, where each halves the length that lasts.
const MAX_CONTROLLED_HALVINGS: usize = 24;
/// Attempts at a segment within a hundredth of the horizon: of them some are rejected, some lead to a switch.
const MAX_ATTEMPTS: usize = 20_000;
/// Largest share of the horizon that an element may take under error control: a flight has no error, but
/// passes over ground.
const LONGEST: f64 = 0.1;
/// Largest share of the horizon that the first element may take, for a tolerance of one.
const FIRST: f64 = 0.25;
/// Share of the horizon below which slow starts do not shorten the first element.
const LEAST_FIRST: f64 = 1e-9;
/// Largest and smallest change of the element length by the error control.
const LENGTH_CHANGE: (f64, f64) = (0.2, 4.0);

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
        Ok(()) => SimulationStatus::Solved,
        Err(status) => status,
    };
    if !driver.keeps_trajectory {
        driver.keeps_trajectory = true;
        driver.record();
    }
    let controlled = driver.local_tolerance.is_some();
    driver.note_cascades();
    driver.note_energy_gains();
    let newton = driver.element.counts;
    let other = driver.next_element.counts;
    driver.counts.newton = newton.iterations + other.iterations;
    driver.counts.factorizations = newton.factorizations + other.factorizations;
    driver.counts.evaluations =
        newton.evaluations + other.evaluations + driver.contacts.evaluations;
    Simulation {
        declaration: driver.model.declaration(),
        status,
        error_estimate: (!controlled).then_some(driver.error_estimate),
        initial_modes: driver.initial_modes,
        events: driver.events,
        trajectory: driver.trajectory,
        residuals: driver.residuals,
        size: driver.size,
        counts: driver.counts,
        seconds: Seconds {
            total: clock.elapsed().as_secs_f64(),
            ..Seconds::default()
        },
        notes: driver.notes,
    }
}

/// Steps over the horizon.
fn step_count(driver: &Driver<'_>) -> usize {
    match driver.local_tolerance {
        None => driver.settings.steps.unwrap_or(Fesd::DEFAULT_STEPS),
        Some(_) => driver.settings.steps.unwrap_or(1),
    }
}

fn steps(driver: &mut Driver<'_>, watch: &mut Watch<'_>) -> Result<(), SimulationStatus> {
    driver.take_piece(0.0);
    driver.active.clear();
    if let Err(error) = driver.settle(&[]) {
        driver.record();
        return Err(diagnosis::stopped(driver, 0, &Stop::Mode(error)));
    }
    driver.initial_modes = driver.modes();
    driver.record();
    propose_first_length(driver);
    let steps = step_count(driver);
    for step in 0..steps {
        let end = if step + 1 == steps {
            driver.horizon
        } else {
            driver.horizon * (step + 1) as f64 / steps as f64
        };
        advance(driver, step, end, watch)?;
        watch.reach(
            driver.state.time,
            driver.counts.elements,
            &mut driver.trajectory,
        )?;
    }
    Ok(())
}

/// First element length: a share of the horizon and of the time in which the velocity changes, which falls
/// with the tolerance, so that two runs do not share their first elements.
fn propose_first_length(driver: &mut Driver<'_>) {
    let Some(tolerance) = driver.local_tolerance else {
        return;
    };
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let share = tolerance.powf(1.0 / (driver.tableau.stages() as f64 + 1.0));
    let mut length = FIRST * driver.horizon;
    let (speed, acceleration) = (largest(&driver.state.v), largest(&driver.acceleration));
    if speed > 0.0 && acceleration > 0.0 {
        // What an impact leaves of a velocity may be rounding error, which says nothing of the motion that follows.
        length = length.min((speed / acceleration).max(LEAST_FIRST * driver.horizon));
    }
    driver.proposed_length = share * length;
}

/// Advances to `end`, with as many segments as there are switches and pieces of the controls.
fn advance(
    driver: &mut Driver<'_>,
    step: usize,
    end: f64,
    watch: &mut Watch<'_>,
) -> Result<(), SimulationStatus> {
    let begin = driver.state.time;
    let shortest = 1e-14 * driver.horizon;
    let mut halvings = 0;
    let (mut switches, mut attempts) = (0, 0);
    let mut counted_from = begin;
    let mut size = ProblemSize::default();
    while end - driver.state.time > shortest {
        watch.reach(
            driver.state.time,
            driver.counts.elements,
            &mut driver.trajectory,
        )?;
        take_up_controls(driver, step)?;
        let segment_end = driver
            .controls
            .next_break(driver.state.time)
            .map_or(end, |next| next.min(end));
        if driver.settings.formulation == StepFormulation::Complementarity {
            if let Err(stop) = program::solve_program(driver, segment_end) {
                return Err(diagnosis::stopped(driver, step, &stop));
            }
            continue;
        }
        let (segment_end, elements) = plan(driver, begin, segment_end, end, halvings);
        if driver.state.time - counted_from > 0.01 * driver.horizon {
            (switches, attempts) = (0, 0);
            counted_from = driver.state.time;
        }
        attempts += 1;
        if driver.counts.elements >= driver.settings.most_elements {
            return Err(diagnosis::too_many(driver, step));
        }
        let vanishes = driver.local_tolerance.is_some() && driver.proposed_length <= shortest;
        if attempts > MAX_ATTEMPTS || vanishes {
            return Err(diagnosis::too_short(driver, step, segment_end));
        }
        let (time, events) = (driver.state.time, driver.events.len());
        match segment(driver, segment_end, elements, shortest, &mut size) {
            Ok(Segment::Rejected) => {}
            Ok(Segment::Completed) if driver.local_tolerance.is_some() => halvings = 0,
            Ok(Segment::Completed) => halvings = halvings.saturating_sub(1),
            Ok(Segment::Switched) => {
                driver.not_finite = false;
                switches += 1;
                // A switch at the start that changes nothing is an error of an element that is much too long.
                if driver.state.time == time && driver.events.len() == events {
                    halvings = (halvings + 1).min(most_halvings(driver));
                    shorten(driver, segment_end);
                }
                if switches > MAX_SWITCHES {
                    return Err(diagnosis::unsettled(driver, step));
                }
            }
            Err(Stop::Mode(ModeError::NotFinite)) | Err(Stop::Element(ElementError::NotFinite))
                if halvings < most_halvings(driver) =>
            {
                halvings += 1;
                driver.not_finite = true;
                shorten(driver, segment_end);
            }
            Err(stop @ Stop::Mode(_)) => return Err(diagnosis::stopped(driver, step, &stop)),
            Err(_) if halvings < most_halvings(driver) => {
                halvings += 1;
                shorten(driver, segment_end);
            }
            Err(_) if diagnosis::nearly_jams(driver) => {
                return Err(diagnosis::stopped(
                    driver,
                    step,
                    &Stop::Mode(ModeError::Jammed),
                ));
            }
            Err(stop @ Stop::Element(ElementError::NotFinite)) => {
                return Err(diagnosis::stopped(driver, step, &stop));
            }
            Err(_) => {
                if let Err(stop) = program::solve_program(driver, segment_end) {
                    return Err(diagnosis::stopped(driver, step, &stop));
                }
                halvings = 0;
            }
        }
    }
    driver.state.time = end;
    if let Some(time) = driver.trajectory.time.last_mut() {
        *time = end;
    }
    if size.variables > driver.size.variables {
        driver.size = size;
    }
    Ok(())
}

/// Halves the proposed length after a failed segment that ended at `end`.
fn shorten(driver: &mut Driver<'_>, end: f64) {
    if driver.local_tolerance.is_some() {
        driver.proposed_length = 0.5 * (end - driver.segment_start.time);
    }
}

/// Halvings before a segment counts as failed.
fn most_halvings(driver: &Driver<'_>) -> usize {
    match driver.local_tolerance {
        None => MAX_HALVINGS,
        Some(_) => MAX_CONTROLLED_HALVINGS,
    }
}

/// End and number of elements of the next segment: equal elements up to `segment_end`, or the length
/// that the error control proposes.
fn plan(
    driver: &Driver<'_>,
    begin: f64,
    segment_end: f64,
    end: f64,
    halvings: usize,
) -> (f64, usize) {
    let remaining = segment_end - driver.state.time;
    if driver.local_tolerance.is_none() {
        let share = remaining / (end - begin);
        let elements = (driver.settings.elements as f64 * share).round() as usize;
        return (segment_end, elements.max(1) << halvings);
    }
    let length = driver.proposed_length;
    if remaining <= 1.01 * length {
        (segment_end, 1)
    } else {
        // Two nearly equal elements rather than one and a sliver.
        (driver.state.time + length.min(0.5 * remaining), 1)
    }
}

/// Updates the proposed element length from the error estimate of the solved element; true if the
/// element must be shorter.
fn control_error(driver: &mut Driver<'_>) -> bool {
    let Some(tolerance) = driver.local_tolerance else {
        return false;
    };
    let error = driver
        .element
        .relative_error(&driver.acceleration, &driver.motion);
    let ratio = error / tolerance;
    let order = driver.tableau.stages() as f64 + 1.0;
    let factor = 0.9 * ratio.max(1e-12).powf(-1.0 / order);
    if factor < LENGTH_CHANGE.0 {
        // So far off, Newton's method may have found stages that have nothing to do with the motion.
        driver.element.forget();
    }
    let proposed = driver.element.length() * factor.clamp(LENGTH_CHANGE.0, LENGTH_CHANGE.1);
    driver.proposed_length = proposed.min(LONGEST * driver.horizon);
    ratio > 1.0
}

/// Whether the element leaves the ground between its stages by more than its tolerance; the next one is half as long.
fn strays(driver: &mut Driver<'_>) -> bool {
    let strays = driver
        .local_tolerance
        .is_some_and(|tolerance| driver.detector.drift > tolerance);
    if strays {
        driver.proposed_length = 0.5 * driver.element.length();
    }
    strays
}

/// Controls that hold from now on; a jump of theirs may change the contact mode.
fn take_up_controls(driver: &mut Driver<'_>, step: usize) -> Result<(), SimulationStatus> {
    if driver.u.is_empty() {
        return Ok(());
    }
    let before = driver.u.clone();
    // A jump within rounding error of the present time has been reached.
    let now = driver.state.time + 4.0 * f64::EPSILON * driver.horizon;
    driver.take_piece(now);
    if driver.controls.jumps() && before != driver.u && driver.state.time > 0.0 {
        if let Err(error) = driver.settle(&[]) {
            return Err(diagnosis::stopped(driver, step, &Stop::Mode(error)));
        }
        driver.record();
    }
    Ok(())
}

/// Solves `elements` elements of equal length up to `end`, or up to the first switch, which is then
/// located, with the elements before it of equal length again, and carried out.
fn segment(
    driver: &mut Driver<'_>,
    end: f64,
    elements: usize,
    shortest: f64,
    size: &mut ProblemSize,
) -> Result<Segment, Stop> {
    driver.segment_start.copy_from(&driver.state);
    driver.segment_acceleration.clone_from(&driver.acceleration);
    let error_estimate = driver.error_estimate;
    let recorded = driver.trajectory.time.len();
    let start_numerical_time = driver.numerical_time;
    let length = (end - driver.state.time) / elements as f64;
    let mut violation = None;
    for count in 1..=elements {
        newton::solve(&mut driver.element, &driver.state, length, &driver.piece)?;
        if control_error(driver) {
            return Ok(Segment::Rejected);
        }
        if let Some(switch) = location::violation(driver)? {
            violation = Some((switch, count));
            break;
        }
        if strays(driver) {
            return Ok(Segment::Rejected);
        }
        driver.accept_element()?;
    }
    let Some((switch, count)) = violation else {
        add_size(driver, elements, false, size);
        return Ok(Segment::Completed);
    };
    driver.trajectory.truncate(recorded);
    driver.numerical_time = start_numerical_time;
    driver.error_estimate = error_estimate;
    driver.state.copy_from(&driver.segment_start);
    driver.acceleration.clone_from(&driver.segment_acceleration);
    let offset = (count - 1) as f64 + switch.theta;
    if offset * length <= shortest && location::holds_at_start(driver, switch) {
        driver.carry_out(switch)?;
        return Ok(Segment::Switched);
    }
    let located = match location::locate(driver, switch, length, count, recorded) {
        Ok(located) => located,
        Err(stop) => {
            // Whoever tries again starts where this segment did.
            driver.trajectory.truncate(recorded);
            driver.numerical_time = start_numerical_time;
            driver.state.copy_from(&driver.segment_start);
            driver.evaluate_state()?;
            return Err(stop);
        }
    };
    add_size(driver, count, true, size);
    driver.carry_out(located)?;
    Ok(Segment::Switched)
}

/// Size of the step's system: stage unknowns and one length an element.
fn add_size(driver: &Driver<'_>, elements: usize, switched: bool, size: &mut ProblemSize) {
    let stages = driver.tableau.stages();
    let unknowns = elements * driver.element.variables();
    let block = driver.element.variables() / stages;
    let cones = (0..driver.all_contacts.len()).filter(|&i| driver.contacts.friction(i) > 0.0);
    // One condition on the force or the gap of each contact, one on friction or sliding velocity.
    let conditions = driver.all_contacts.len() + cones.count();
    size.variables += unknowns + elements;
    // Equal lengths but one, which the end of the segment or the switch condition determines.
    size.equalities += unknowns + elements;
    size.inequalities += elements * stages * conditions;
    size.complementarities += elements * conditions;
    size.jacobian_nonzeros +=
        elements * stages * stages * block * block + elements + usize::from(switched);
}
