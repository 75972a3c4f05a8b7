//! Event-driven motions under given controls, and their contact sequences.

use crate::model::{Pieces, edge};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::edit_sequence::touching_at_edges;
use crate::ocp::motion::passages::with_passages;
use crate::ocp::motion::read_sequence::{
    AT_THE_END, COMES_TO_REST, Replay, landed, landed_in_an_interval,
};
use crate::ocp::motion::sequence::Sequence;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::tuning::candidates::{AT_ONCE, OUTPUTS, UNDRIVEN};
use crate::ocp::tuning::equal::ROUNDING;
use crate::simulation::{
    Ending, Event, EventDriven, EventKind, InputError, Simulation, SimulationStatus, simulate_to,
};

/// Equal parts of a motion by which its simulation is read: its control intervals, or else as many as make it fine enough.
pub(in crate::ocp) fn parts(setting: Setting) -> usize {
    let driven = !setting.model.declaration().controls.is_empty();
    let intervals = setting.problem.intervals;
    if driven {
        intervals
    } else {
        intervals.max(UNDRIVEN)
    }
}

/// The motion under the controls of a trajectory, from its start, simulated to a tolerance, with so many points in each interval. That of a `plan`, which it may be so far away from, ends with
/// the impacts that the plan ends with: rounding puts them on either side of the final time.
pub(in crate::ocp) fn simulate(
    setting: Setting,
    trajectory: &Trajectory,
    plan: Option<(&Sequence, f64)>,
    (tolerance, outputs): (f64, usize),
) -> Result<Simulation, InputError> {
    let Setting { model, problem, .. } = setting;
    let start = trajectory.start(model, problem);
    let simulator = EventDriven {
        tolerance,
        max_step: Some(trajectory.horizon / parts(setting) as f64),
        output_times: outputs * parts(setting),
        ..EventDriven::default()
    };
    let motion = problem.initial_value_problem(&start, trajectory.horizon, trajectory.signal());
    let struck: Vec<usize> = plan.map_or(Vec::new(), |(plan, _)| {
        let last = plan.switches.iter();
        let last = last.filter(|s| s.interval == problem.intervals && s.closes);
        last.map(|switch| switch.contact).collect()
    });
    let ending = plan.map(|(_, distance)| Ending {
        near: AT_THE_END * trajectory.horizon / problem.intervals as f64,
        gap: distance,
        struck: &struck,
    });
    simulate_to(&simulator, model, &motion, ending)
}

/// The motion under the controls of a trajectory, on the grid of the problem; nothing where it cannot be simulated to its end.
pub(in crate::ocp) fn simulated(
    setting: Setting,
    driven: &Trajectory,
    tolerance: f64,
) -> Result<Option<Candidate>, InputError> {
    Ok(simulations(setting, driven, tolerance)?.into_iter().next())
}

/// The simulated motion with each way to read the bounces of a contact that comes to rest: those in the control interval of the rest are the
/// landing that a plan has there, or those within half an interval.
pub(in crate::ocp) fn simulations(
    setting: Setting,
    driven: &Trajectory,
    tolerance: f64,
) -> Result<Vec<Candidate>, InputError> {
    let replay = simulate(setting, driven, None, (tolerance, OUTPUTS))?;
    if replay.status != SimulationStatus::Solved {
        return Ok(Vec::new());
    }
    let Setting { model, problem, .. } = setting;
    let (horizon, grid) = (driven.horizon, &driven.controls);
    let controls = grid.resampled(setting.shape, problem.intervals);
    let read = read_replay(setting, &replay, driven);
    let intervals_in_a_part = problem.intervals as f64 / parts(setting) as f64;
    let soon = landed(read.clone(), model, COMES_TO_REST * intervals_in_a_part);
    let in_an_interval = if intervals_in_a_part < 1.0 {
        soon.clone()
    } else {
        landed_in_an_interval(read, model)
    };
    let other = (soon.signature() != in_an_interval.signature()).then_some(soon);
    let trajectory = Trajectory::of_simulation(model, &replay, horizon, controls);
    let sequences = std::iter::once(in_an_interval).chain(other);
    let candidate = |sequence| Candidate {
        objective: f64::INFINITY,
        sequence,
        trajectory: trajectory.clone(),
    };
    Ok(sequences.map(candidate).collect())
}

/// The contact sequence of a simulation under the controls of a trajectory.
pub(in crate::ocp) fn read_replay(
    setting: Setting,
    replay: &Simulation,
    trajectory: &Trajectory,
) -> Sequence {
    let Setting { model, problem, .. } = setting;
    let intervals = problem.intervals;
    let interval = trajectory.horizon / intervals as f64;
    let mut closed: Vec<bool> = match replay.trajectory.contact_force.first() {
        Some(forces) => forces.iter().map(|&force| force > 0.0).collect(),
        None => Vec::new(),
    };
    for (closed, contact) in closed.iter_mut().zip(model.declaration().contacts) {
        *closed |= contact.dry;
    }
    let start = trajectory.start(model, problem);
    let mut input = vec![0.0; model.declaration().inputs()];
    input[..start.len()].copy_from_slice(&start);
    let pieces = Pieces::at(model, &input);
    // A start that rounding puts above a surface lands at once; a contact may begin without a force.
    for (contact, closed) in closed.iter_mut().enumerate() {
        let own = |event: &&Event| event.contact == contact;
        let is_closed = match replay.events.iter().find(own) {
            Some(first) => (first.kind == EventKind::LiftOff) != (first.time < AT_ONCE * interval),
            None => !replay.initial_modes[contact].is_open(),
        };
        let on_the_surface = ROUNDING * setting.units.share_of_gap(contact);
        *closed |=
            !pieces.is_idle(contact) && model.gap(contact, &input) <= on_the_surface && is_closed;
    }
    let read = Replay {
        model,
        simulation: replay,
        interval,
        intervals,
    };
    let sequence = read.sequence(&closed);
    if edge(model).is_none() {
        return sequence;
    }
    let controls = trajectory.controls.clone();
    let motion = Trajectory::of_simulation(model, replay, trajectory.horizon, controls);
    touching_at_edges(with_passages(model, sequence, &motion, true), AT_THE_END)
}
