//! The motion without controls, up to where it comes nearest to the goals: what has to be looked at before a problem is
//! called infeasible.

use super::replay::simulated;
use crate::model::held;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::ControlGrid;
use crate::ocp::motion::model_input::drive;
use crate::ocp::motion::targets::goal_values;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::tuning::candidates::RIDE;
use crate::ocp::tuning::sampled::TOLERANCE;
use crate::simulation::{EventDriven, InputError, simulate_once};

/// The motion without controls, or with those nearest to 0 within their bounds.
pub(in crate::ocp) struct Ride {
    pub(in crate::ocp) candidate: Candidate,
    /// Whether it fulfils the goals within all bounds.
    pub(in crate::ocp) reaches: bool,
}

/// A state `(q, v, T)` of the ride that may end it.
struct End {
    state: Vec<f64>,
    reaches: bool,
    violation: f64,
}

/// The ride over the final times that are looked at, simulated to a tolerance; nothing where it cannot be simulated.
pub(in crate::ocp) fn ride(tolerance: f64, setting: Setting) -> Result<Option<Ride>, InputError> {
    let Setting {
        model,
        problem,
        bounds,
        ..
    } = setting;
    let n = problem.q.len();
    let controls: Vec<f64> = (n..bounds.0.len())
        .map(|k| 0.0_f64.clamp(bounds.0[k], bounds.1[k]))
        .collect();
    let controls = ControlGrid::constant(vec![controls; problem.intervals]);
    let controls = controls.resampled(setting.shape, problem.intervals);
    let start = problem.start();
    let longest = setting.final_times().longest;
    let simulator = EventDriven {
        tolerance,
        output_times: RIDE,
        ..EventDriven::default()
    };
    let motion = problem.initial_value_problem(&start, longest, controls.signal(longest));
    let whole = simulate_once(&simulator, model, &motion)?;
    let trajectory = &whole.trajectory;
    let states: Vec<Vec<f64>> = (0..trajectory.time.len())
        .map(|i| {
            [
                &trajectory.q[i][..],
                &trajectory.v[i],
                &[trajectory.time[i]],
            ]
            .concat()
        })
        .collect();
    let Some(end) = nearest_end(setting, &states) else {
        return Ok(None);
    };
    let horizon = end.state[2 * n];
    let ridden = Trajectory {
        horizon,
        controls,
        time: vec![0.0],
        states: vec![start],
    };
    let Some(candidate) = simulated(setting, &ridden, tolerance)? else {
        return Ok(None);
    };
    let before = states.iter().take_while(|state| state[2 * n] < horizon);
    // What contacts do on the way is not asked here.
    let declared = model.declaration().optimal_control;
    let free_of_contacts = declared.is_none_or(|declared| !declared.contacts.any());
    let reaches = end.reaches
        && free_of_contacts
        && before.chain([&end.state]).all(|state| {
            let controls = ridden.controls.start();
            is_within(setting, state, controls)
        });
    Ok(Some(Ride { candidate, reaches }))
}

/// The first of the states that fulfils the goals, or else the one that comes nearest to that.
fn nearest_end(setting: Setting, states: &[Vec<f64>]) -> Option<End> {
    let range = setting.final_times();
    let mut nearest: Option<End> = None;
    let inside = |state: &Vec<f64>| state.last().is_some_and(|time| *time >= range.shortest);
    for (index, state) in states.iter().enumerate().filter(|(_, state)| inside(state)) {
        let after = goal_values(setting.model, state);
        let mut ends = vec![end_of(setting, state.clone(), None)];
        if let Some(state_before) = index.checked_sub(1).map(|before| &states[before]) {
            let before = goal_values(setting.model, state_before);
            let crossed = |k: &usize| before[*k] * after[*k] < 0.0;
            for k in (0..after.len()).filter(crossed) {
                let share = before[k] / (before[k] - after[k]);
                let pair = state_before.iter().zip(state);
                let between = pair.map(|(from, to)| from + share * (to - from));
                ends.push(end_of(setting, between.collect(), Some(k)));
            }
        }
        for end in ends {
            let known = nearest.as_ref().map_or(f64::INFINITY, |end| end.violation);
            if end.reaches || end.violation < known {
                let reaches = end.reaches;
                nearest = Some(end);
                if reaches {
                    return nearest;
                }
            }
        }
    }
    nearest
}

/// A state as an end of the ride; the goal `met` is fulfilled there by continuity.
fn end_of(setting: Setting, state: Vec<f64>, met: Option<usize>) -> End {
    let values = goal_values(setting.model, &state);
    let others = values
        .iter()
        .enumerate()
        .filter(|(k, _)| Some(*k) != met)
        .map(|(_, value)| value.abs());
    let violation = others.fold(0.0, f64::max);
    End {
        state,
        reaches: violation <= TOLERANCE,
        violation,
    }
}

/// Whether a state of the ride keeps the bounds and the path constraints.
pub(super) fn is_within(setting: Setting, z: &[f64], controls: &[f64]) -> bool {
    let Setting {
        model,
        problem,
        bounds,
        units,
        ..
    } = setting;
    let n = problem.q.len();
    let coordinates = (0..n).all(|k| {
        let room = TOLERANCE * units.states[k];
        (bounds.0[k] - room..=bounds.1[k] + room).contains(&z[k])
    });
    let Some(declared) = model.declaration().optimal_control else {
        return coordinates;
    };
    let mut values = vec![0.0; declared.path_functions()];
    let mut input = z[..2 * n].to_vec();
    input.extend(drive(model, controls, z[2 * n]));
    input.resize(model.declaration().path_inputs(), 0.0);
    held::complete_largest(model, &mut input);
    model.path_functions(&input, &mut values);
    let own = &values[usize::from(declared.running_cost)..];
    let mut constraints = declared.constraints.iter().zip(own);
    coordinates
        && constraints.all(|(constraint, &value)| {
            if constraint.equality {
                value.abs() <= TOLERANCE
            } else {
                value >= -TOLERANCE
            }
        })
}
