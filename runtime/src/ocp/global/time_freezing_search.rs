//! The contact sequence from the complementarity problem of finite elements on the time-freezing system, and its exact solution
//! with that of a motion.

use std::io;

use hangtime_solver::clock::ThreadTime;
use hangtime_solver::mpcc::Mpcc as _;
use hangtime_solver::nlp::Residuals;
use hangtime_solver::{mpcc, nlp};

use super::start_modes::modes_at_start;
use super::time_freezing::{TimeFreezing, TimeFreezingMotion};
use crate::model::Model;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::edit_sequence::touching_for_less_than;
use crate::ocp::motion::mode::{closed_mode, is_condition, is_frictional, sliding_velocity};
use crate::ocp::motion::model_input::{drive, with_forces};
use crate::ocp::motion::passages::with_passages;
use crate::ocp::motion::read_sequence::{Elements, of_elements};
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::Problem;
use crate::ocp::program::runner::{Failure, Runner};
use crate::ocp::settings::TimeFreezingSettings;
use crate::ocp::solution::{RelaxedReport, TimeFreezingReport};
use crate::ocp::tuning::freezing::{
    BARRIER, BOUNCE, EXACT, EXACT_ITERATIONS, FIRST, ITERATIONS, OPEN, PUSH,
};
use crate::ocp::tuning::off_grid::RESTORED;
use crate::simulation::{ContactMode, Direction};
use crate::simulation::{InputError, ProblemSize};

/// Solves the relaxed complementarity problem from a guess, or from the simulation under its controls, and reads motion and
/// contact sequence from it, if there is one. Nothing where the program cannot be started. Where nothing is to be proved it is left early.
pub(in crate::ocp) fn candidate(
    runner: &mut Runner,
    setting: Setting,
    settings: &TimeFreezingSettings,
    guess: &Trajectory,
    simulated: bool,
) -> Result<Option<(TimeFreezingReport, Option<Candidate>)>, InputError> {
    let clock = ThreadTime::try_now();
    let (model, problem) = (setting.model, setting.problem);
    let settings = TimeFreezingSettings {
        simulated_guess: settings.simulated_guess || simulated,
        ..settings.clone()
    };
    let controls = guess.controls.resampled(setting.shape, problem.intervals);
    let guess = Trajectory {
        controls,
        ..guess.clone()
    };
    let mut program = TimeFreezing::from_guess(model, problem, &settings, &guess)?;
    let mut relaxation = mpcc::Settings::default();
    relaxation.interior_point.objective_unit = Some(1.0);
    relaxation.crossover = false;
    relaxation.final_relaxation = settings.complementarity;
    relaxation.rules = settings.rules.to_vec();
    relaxation.interior_point.tolerance = settings.complementarity;
    relaxation.interior_point.maximum_iterations =
        runner.settings.maximum_iterations.max(ITERATIONS);
    let mut step = ("time-freezing program", usize::MAX);
    if !runner.effort.proves() {
        relaxation.rules.truncate(1);
        relaxation.maximum_iterations = FIRST;
        relaxation.interior_point.maximum_iterations = FIRST;
        step.1 = RESTORED;
    }
    let Ok(solution) = runner.relax(&mut program, &relaxation, step, 1.0) else {
        return Ok(None);
    };
    let complementarity = largest_product(&program, &solution.x);
    let motion = program.motion(&solution.x);
    if let Some(failure) = Failure::of_relaxed(&solution) {
        runner.note(failure);
    }
    let report = TimeFreezingReport {
        status: solution.status,
        objective: solution.objective,
        horizon: motion.horizon,
        residuals: Residuals {
            complementarity,
            ..solution.residuals
        },
        left_out: left_out(&program),
        relaxed: RelaxedReport {
            objective: solution.objective,
            complementarity,
            iterations: solution.iterations,
            led_to_motion: true,
        },
        iterations: solution.iterations,
        size: ProblemSize::of(&program),
        seconds: elapsed(clock),
    };
    let near = match solution.status {
        mpcc::Status::Failed(status) => status == nlp::Status::Acceptable,
        mpcc::Status::Infeasible => false,
        _ => true,
    };
    let candidate = near.then(|| {
        let trajectory = trajectory(setting, &motion);
        Candidate {
            objective: solution.objective,
            sequence: sequence(setting, &motion, &settings, &trajectory),
            trajectory,
        }
    });
    Ok(Some((report, candidate)))
}

/// Solves the complementarity problem with the contact sequence of a motion, which says what vanishes of each pair, and
/// adds that to the report. Where that does not succeed, the relaxed solution is left.
pub(in crate::ocp) fn solve_exactly(
    runner: &mut Runner,
    (model, problem): (&dyn Model, &Problem),
    settings: &TimeFreezingSettings,
    motion: &Candidate,
    report: &mut TimeFreezingReport,
) -> Result<(), InputError> {
    let clock = ThreadTime::try_now();
    let mut program = TimeFreezing::known(model, problem, settings, motion)?;
    let mut interior_point = mpcc::Settings::default().interior_point;
    interior_point.objective_unit = Some(1.0);
    interior_point.constraint_tolerance = EXACT[0];
    interior_point.initial_barrier_parameter = BARRIER;
    interior_point.bound_push = PUSH * BARRIER;
    interior_point.bound_fraction = PUSH * BARRIER;
    interior_point.maximum_iterations = EXACT_ITERATIONS;
    let before = runner.counts.global_iterations;
    let mut ended = Err(nlp::Status::IterationLimit);
    for tolerance in EXACT {
        interior_point.tolerance = tolerance;
        ended = runner.fixed(&mut program, &interior_point, "exact time-freezing program");
        if !ended.as_ref().is_err_and(has_stalled) {
            break;
        }
    }
    report.iterations += runner.counts.global_iterations - before;
    if let Ok(solution) = ended {
        report.status = mpcc::Status::Uncertified;
        report.objective = solution.objective;
        report.horizon = program.motion(&solution.x).horizon;
        report.residuals = Residuals {
            complementarity: largest_product(&program, &solution.x),
            ..solution.residuals
        };
        report.left_out = left_out(&program);
    }
    report.seconds += elapsed(clock);
    Ok(())
}

/// What of the scene a program leaves out.
fn left_out(program: &TimeFreezing<'_>) -> Vec<&'static str> {
    let forces = program.leaves_out_forces().then_some("forces and impulses");
    forces.into_iter().collect()
}

/// Whether a run ended because it made no progress any more.
fn has_stalled(status: &nlp::Status) -> bool {
    use nlp::Status::{IterationLimit, RestorationFailed, StepTooSmall};
    matches!(status, IterationLimit | RestorationFailed | StepTooSmall)
}

/// The largest product of a pair.
fn largest_product(program: &TimeFreezing<'_>, x: &[f64]) -> f64 {
    let products = program.complementarities().iter();
    let products = products.map(|&(i, j)| (x[i] * x[j]).max(0.0));
    products.fold(0.0, f64::max)
}

/// CPU time since then \[s\], NaN without a clock.
fn elapsed(clock: io::Result<ThreadTime>) -> f64 {
    let elapsed = clock.and_then(|clock| clock.try_elapsed());
    elapsed.map_or(f64::NAN, |elapsed| elapsed.as_secs_f64())
}

/// What the contacts do in each element; a jump belongs to the contact after it. How they slide follows from the
/// velocity at the end: in a pair whose product is relaxed, both may be as large as its root.
fn sequence(
    setting: Setting,
    motion: &TimeFreezingMotion,
    settings: &TimeFreezingSettings,
    trajectory: &Trajectory,
) -> Sequence {
    let zero = settings.complementarity.sqrt();
    let model = setting.model;
    let interval = motion.horizon / setting.problem.intervals as f64;
    let states = motion.q.iter().zip(&motion.v).zip(&motion.time);
    let modes: Vec<Vec<ContactMode>> = motion
        .step_functions
        .iter()
        .zip(states)
        .map(|(alpha, ((q, v), &time))| {
            let state = [&q[..], v].concat();
            let mode = |(contact, &alpha): (usize, &f64)| {
                if is_condition(model, contact) {
                    let true_there = alpha < 0.5;
                    return ContactMode::Slip(if true_there {
                        Direction::Backward
                    } else {
                        Direction::Forward
                    });
                }
                if alpha >= OPEN {
                    return ContactMode::Open;
                }
                let frictional = is_frictional(model, contact);
                let slides = frictional.then(|| sliding_velocity(model, contact, &state, time));
                closed_mode(frictional, slides.unwrap_or(0.0), zero)
            };
            alpha.iter().enumerate().map(mode).collect()
        })
        .collect();
    let elements = Elements {
        modes,
        per_interval: settings.elements_of(model),
        ends: motion.time.iter().map(|time| time / interval).collect(),
    };
    let mut read = of_elements(modes_at_start(setting, trajectory), &elements, 0.0);
    add_returns(&mut read, motion, &elements);
    let bounces = |contact| model.restitution(contact) > 0.0;
    let read = touching_for_less_than(&read, BOUNCE, bounces).unwrap_or(read);
    with_passages(model, read, trajectory, false)
}

/// Adds conditions that come true and are false again at once: their mode stays.
fn add_returns(sequence: &mut Sequence, motion: &TimeFreezingMotion, elements: &Elements) {
    let false_there = ContactMode::Slip(Direction::Forward);
    for (e, set) in motion.set.iter().enumerate() {
        for &contact in set.iter().filter(|&&i| elements.modes[e][i] == false_there) {
            let at = Switch::inside(contact, false, false_there, elements.ends[e - 1]);
            sequence.switches.push(Switch {
                interval: e / elements.per_interval,
                sets: true,
                ..at
            });
        }
    }
    sequence.switches.sort_by(|a, b| a.time.total_cmp(&b.time));
}

fn trajectory(setting: Setting, motion: &TimeFreezingMotion) -> Trajectory {
    let (model, problem) = (setting.model, setting.problem);
    let per_interval = motion.time.len() / problem.intervals;
    let mut states = vec![motion.start.clone()];
    let ends = motion.q.iter().zip(&motion.v);
    states.extend(ends.map(|(q, v)| [&q[..], &v[..]].concat()));
    let states = states.into_iter().enumerate().map(|(i, state)| {
        let interval = i.saturating_sub(1) / per_interval;
        let time = i.checked_sub(1).map_or(0.0, |end| motion.time[end]);
        let place = time * problem.intervals as f64 / motion.horizon;
        let driven = drive(model, &motion.controls.within(interval, place), time);
        with_forces(model, state, &driven)
    });
    Trajectory {
        states: states.collect(),
        time: std::iter::once(&0.0).chain(&motion.time).copied().collect(),
        horizon: motion.horizon,
        controls: motion.controls.clone(),
    }
}
