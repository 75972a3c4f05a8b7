//! When the switches of a contact sequence have to happen: its program with intervals of free lengths.
//!
//! A switch stays in its control interval while a program is solved, so that a sequence whose switches are guessed too early
//! or too late has no motion. With intervals of free lengths a switch may be at any time: where that program has a solution, its
//! switches are in the intervals of equal length in which the motion needs them, and its controls, averaged over these, are a
//! start.

use super::attempt::{Attempts, interior_point};
use crate::ocp::collocation::discretization::{Lengths, Places, Setting};
use crate::ocp::collocation::program::Collocation;
use crate::ocp::collocation::transcribe::transcribe;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::{ControlGrid, ControlShape};
use crate::ocp::motion::sequence::{Place, Sequence};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::{Run, Runner};
use crate::ocp::tuning::attempt::QUICK;
use crate::ocp::tuning::candidates::{AT_A_JUMP, FREE_TOLERANCE};
use crate::ocp::tuning::off_grid::RESTORED;

/// The motion of a sequence on intervals of free lengths, read on those of equal length; `None` where there is none.
pub(super) fn retimed(
    runner: &mut Runner,
    attempts: &Attempts,
    sequence: &Sequence,
    guess: &Trajectory,
) -> Option<Candidate> {
    let setting = Setting {
        places: Places {
            bounds_at_nodes: true,
            ..attempts.setting.places
        },
        shape: ControlShape::Constant,
        lengths: Lengths::Free,
        ..attempts.setting
    };
    let intervals = setting.problem.intervals;
    let guess = Trajectory {
        controls: guess.controls.resampled(ControlShape::Constant, intervals),
        ..guess.clone()
    };
    let mut program = transcribe(setting, sequence, &guess, &[], attempts.elements);
    let (barrier, iterations) = QUICK[0];
    let mut settings = interior_point(runner.settings);
    settings.tolerance = FREE_TOLERANCE.max(settings.tolerance);
    settings.initial_barrier_parameter = barrier;
    settings.maximum_iterations = settings.maximum_iterations.min(iterations);
    let run = Run {
        settings: &settings,
        start: None,
        restores: if runner.effort.proves() {
            usize::MAX
        } else {
            RESTORED
        },
        best: None,
    };
    let horizon = program.horizon;
    let failure = runner.take_failure();
    let solution = runner.solve(&mut program.program, horizon, &run);
    runner.restore_failure(failure, solution.is_ok());
    let solution = solution.ok()?;
    Some(equalized(&program, &solution.x, solution.objective))
}

/// A solved program with intervals of free lengths, read on those of equal length.
fn equalized(program: &Collocation, x: &[f64], objective: f64) -> Candidate {
    let (mut trajectory, mut sequence) = program.result(x);
    let intervals = trajectory.controls.intervals();
    let unit = trajectory.horizon / intervals as f64;
    let mut nodes = vec![intervals as f64; intervals + 1];
    for (phase, solved) in program.phases.iter().zip(program.solved(x)).rev() {
        nodes[phase.interval] = solved.start / unit;
    }
    for switch in &mut sequence.switches {
        if switch.place == Place::Start {
            switch.time = nodes[switch.interval];
            let node = switch.time.round();
            let stays = (switch.time - node).abs() < AT_A_JUMP && node > 0.0;
            if switch.interval < intervals && stays {
                switch.time = node;
            } else if switch.interval < intervals {
                switch.place = Place::Inside;
            }
        }
        switch.interval = if switch.place == Place::Start {
            switch.time as usize
        } else {
            (switch.time as usize).min(intervals - 1)
        };
    }
    let values = (0..intervals).map(|k| averaged(&trajectory.controls, &nodes, k as f64));
    trajectory.controls = ControlGrid::constant(values.collect());
    Candidate {
        objective,
        trajectory,
        sequence,
    }
}

/// Controls that are constant between these `nodes`, averaged over the interval of length 1 from `begin`.
fn averaged(controls: &ControlGrid, nodes: &[f64], begin: f64) -> Vec<f64> {
    let mut average = vec![0.0; controls.values()[0].len()];
    for (values, ends) in controls.values().iter().zip(nodes.windows(2)) {
        let overlap = (ends[1].min(begin + 1.0) - ends[0].max(begin)).max(0.0);
        for (average, value) in average.iter_mut().zip(values) {
            *average += overlap * value;
        }
    }
    average
}
