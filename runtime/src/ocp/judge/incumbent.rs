//! A simulated motion that meets the goals, as a result of which nothing is proved.

use super::confirm::resimulated;
use super::forces;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::targets::goal_values;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::previous::Previous;
use crate::ocp::search::replay::simulated;
use crate::ocp::settings::Settings;
use crate::ocp::solution::{Counts, Solution, Status};
use crate::simulation::{InputError, SimulationStatus};

/// The motion under the controls of a trajectory as a result. None where it does not reach its end, misses a goal by more than that of the
/// `largest` goals, breaks a condition on forces, or has an objective that reads these.
pub(in crate::ocp) fn incumbent(
    setting: Setting,
    settings: &Settings,
    (driven, largest): (&Trajectory, &[f64]),
) -> Result<Option<Solution>, InputError> {
    let (model, tolerance) = (setting.model, settings.resimulation_tolerance);
    let Some(candidate) = simulated(setting, driven, tolerance)? else {
        return Ok(None);
    };
    let let_pass = setting.largest_distance(settings, driven);
    let with = ((&candidate.sequence, let_pass), tolerance);
    let (motion, cost) = resimulated(setting, driven, with, (0.0, 0.0))?;
    let (q, v) = (motion.trajectory.q.last(), motion.trajectory.v.last());
    let (Some(cost), Some(q), Some(v)) = (cost, q, v) else {
        return Ok(None);
    };
    let missing = goal_values(model, &[&q[..], v, &[driven.horizon]].concat());
    let meets = missing.iter().zip(largest).all(|(m, l)| m.abs() <= *l);
    let conditions = forces::looked(model, &motion);
    let ends = motion.status == SimulationStatus::Solved;
    if !ends || !meets || forces::violated(&conditions).is_some() {
        return Ok(None);
    }
    let controls = &candidate.trajectory.controls;
    let events = motion.events.iter();
    Ok(Some(Solution {
        objective: cost.cost,
        resimulated_objective: cost.cost,
        horizon: driven.horizon,
        resimulation_error: 0.0,
        resimulation_velocity_error: 0.0,
        departure: 0.0,
        let_pass,
        planned_events: events.map(|e| (e.time, e.kind, e.contact)).collect(),
        excess: forces::excess(&conditions, Vec::new()),
        controls: controls.values().to_vec(),
        control_times: controls.times(driven.horizon),
        shape: controls.shape,
        elements: vec![settings.elements; setting.problem.intervals],
        previous: Some(Previous::new(candidate.trajectory, candidate.sequence)),
        motion: Some(motion),
        is_simulated: true,
        ..Solution::without_motion(Status::Uncertified, Vec::new(), Counts::default())
    }))
}
