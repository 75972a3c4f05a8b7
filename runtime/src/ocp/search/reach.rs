//! States that controls can lead to, where the goals are out of reach of every guess: those that take several swings.
//!
//! Motions are simulated step by step, under the largest and the smallest controls and those at rest. Of the states that they
//! come to after a step, one is kept in each cell of a grid over their range, which is as fine as their number allows:
//! many ways lead to much the same state (cell-to-cell mapping, Hsu 1980). Motions that end nearest to the goals are what programs
//! start from.

use std::collections::HashSet;

use super::replay::simulated;
use super::ride::is_within;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::global::guess::{guess, natural_size};
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::ControlGrid;
use crate::ocp::motion::targets::{goal_values, horizon_guess};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::Horizon;
use crate::ocp::program::runner::Runner;
use crate::ocp::settings::Guess;
use crate::ocp::tuning::equal::MOTION;
use crate::ocp::tuning::reach::{COARSER, COMBINED, FINEST, LONGEST, SIMULATED, STARTED, STEPS};
use crate::ocp::tuning::sampled::{TOLERANCE, WITHIN};
use crate::simulation::{ControlSignal, EventDriven, InputError, SimulationStatus, simulate_once};

/// A state that controls lead to.
struct Reached {
    /// The place among the states before the step of that from which it is reached, and of its controls among the choices.
    from: usize,
    choice: usize,
    /// `(q, v)`.
    state: Vec<f64>,
}

/// Where a motion may end: after so many steps at the state with this place among those reached.
struct End {
    steps: usize,
    place: usize,
    /// What is missing from each goal.
    missing: Vec<f64>,
}

/// The motions of the search.
struct Reach<'a> {
    setting: Setting<'a>,
    /// The controls that are tried on each step.
    choices: Vec<Vec<f64>>,
    /// Length of a step \[s\].
    step: f64,
    /// The states after each number of steps.
    layers: Vec<Vec<Reached>>,
}

/// The motions that end nearest to the goals, the nearest first; none without controls, or where the model depends on time.
pub(in crate::ocp) fn reachable(
    runner: &mut Runner,
    setting: Setting,
) -> Result<Vec<Candidate>, InputError> {
    let Setting { model, problem, .. } = setting;
    let choices = choices(setting)?;
    if model.declaration().explicit_time || choices.len() < 2 {
        return Ok(Vec::new());
    }
    let intervals = problem.intervals;
    let steps = (intervals * STEPS.div_ceil(intervals)).div_ceil(intervals.div_ceil(STEPS));
    let (longest, fewest) = match problem.horizon {
        Horizon::Fixed(horizon) => (horizon, steps),
        Horizon::Free { .. } => (LONGEST * horizon_guess(problem, model), 1),
    };
    let start = Reached {
        from: 0,
        choice: 0,
        state: problem.start(),
    };
    let mut reach = Reach {
        setting,
        choices,
        step: longest / steps as f64,
        layers: vec![vec![start]],
    };
    for _ in 0..steps {
        if !runner.goes_on("reachable states") {
            return Ok(Vec::new());
        }
        let next = reach.one_step_on();
        reach.layers.push(next);
    }
    let mut found = Vec::new();
    for end in reach.nearest(fewest) {
        found.extend(reach.candidate(&end, runner.settings.replay_tolerance)?);
    }
    Ok(found)
}

/// The controls that are tried: at rest, and at their ends.
fn choices(setting: Setting) -> Result<Vec<Vec<f64>>, InputError> {
    let Setting {
        model,
        problem,
        bounds,
        ..
    } = setting;
    let straight = guess(model, problem, &Guess::Straight, bounds)?;
    let n = problem.q.len();
    let rest = straight.controls.start().to_vec();
    let values = rest.iter().enumerate().map(|(control, &rest)| {
        let k = n + control;
        let size = natural_size(model, &straight, k);
        let end = |bound: f64, other: f64| if bound.is_finite() { bound } else { other };
        let ends = [end(bounds.0[k], rest - size), end(bounds.1[k], rest + size)];
        // The control at rest may be at an end.
        let ends = ends.into_iter().filter(move |&end| end != rest);
        std::iter::once(rest).chain(ends).collect()
    });
    let values: Vec<Vec<f64>> = values.collect();
    if values.len() > COMBINED {
        let ends = values.iter().enumerate().flat_map(|(control, values)| {
            let rest = &rest;
            values[1..].iter().map(move |&end| {
                let mut choice = rest.clone();
                choice[control] = end;
                choice
            })
        });
        return Ok(std::iter::once(rest.clone()).chain(ends).collect());
    }
    let mut all = vec![Vec::new()];
    for values in &values {
        let longer = |before: &Vec<f64>| {
            let before = before.clone();
            values
                .iter()
                .map(move |&value| [&before[..], &[value]].concat())
        };
        all = all.iter().flat_map(longer).collect();
    }
    Ok(all)
}

impl Reach<'_> {
    /// The states that a step leads to from the last ones, thinned out.
    fn one_step_on(&self) -> Vec<Reached> {
        let mut found = Vec::new();
        for (from, reached) in self.layers.last().into_iter().flatten().enumerate() {
            for (choice, controls) in self.choices.iter().enumerate() {
                found.extend(self.after(&reached.state, controls).map(|state| Reached {
                    from,
                    choice,
                    state,
                }));
            }
        }
        thinned(found, SIMULATED / self.choices.len())
    }

    /// The state after a step under controls; nothing where the motion ends before, or leaves the bounds.
    fn after(&self, state: &[f64], controls: &[f64]) -> Option<Vec<f64>> {
        let signal = ControlSignal::PiecewiseConstant {
            times: vec![0.0],
            values: vec![controls.to_vec()],
        };
        let Setting { model, problem, .. } = self.setting;
        let motion = problem.initial_value_problem(state, self.step, signal);
        let simulator = EventDriven {
            tolerance: TOLERANCE,
            output_times: 1,
            ..EventDriven::default()
        };
        let simulation = simulate_once(&simulator, model, &motion).ok()?;
        if simulation.status != SimulationStatus::Solved {
            return None;
        }
        let trajectory = &simulation.trajectory;
        let mut z = [
            &trajectory.q.last()?[..],
            trajectory.v.last()?,
            &[self.step],
        ]
        .concat();
        let within = is_within(self.setting, &z, controls);
        z.pop();
        within.then_some(z)
    }

    /// The distinct ends after at least so many steps that are nearest to the goals.
    fn nearest(&self, fewest: usize) -> Vec<End> {
        let mut ends = Vec::new();
        for (steps, layer) in self.layers.iter().enumerate().skip(fewest) {
            for (place, reached) in layer.iter().enumerate() {
                let mut z = reached.state.clone();
                z.push(self.step * steps as f64);
                let missing = goal_values(self.setting.model, &z);
                ends.push(End {
                    steps,
                    place,
                    missing,
                });
            }
        }
        let units = units(&ends);
        let distance = |end: &End| {
            let terms = end
                .missing
                .iter()
                .zip(&units)
                .filter(|(_, unit)| **unit > 0.0);
            terms
                .map(|(value, unit)| (value / unit).powi(2))
                .sum::<f64>()
        };
        ends.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let mut kept: Vec<End> = Vec::new();
        for end in ends {
            let state = self.state(&end);
            if !kept.iter().any(|other| is_same(self.state(other), state)) {
                kept.push(end);
            }
            if kept.len() == STARTED {
                break;
            }
        }
        kept
    }

    fn state(&self, end: &End) -> &[f64] {
        &self.layers[end.steps][end.place].state
    }

    /// The motion to an end, on the grid of the problem; nothing if all of it cannot be simulated as its steps can.
    fn candidate(&self, end: &End, tolerance: f64) -> Result<Option<Candidate>, InputError> {
        let mut place = end.place;
        let mut controls = Vec::with_capacity(end.steps);
        for layer in self.layers[1..=end.steps].iter().rev() {
            let reached = &layer[place];
            controls.push(self.choices[reached.choice].clone());
            place = reached.from;
        }
        controls.reverse();
        let driven = Trajectory {
            horizon: self.step * end.steps as f64,
            controls: ControlGrid::constant(controls),
            time: vec![0.0],
            states: vec![self.setting.problem.start()],
        };
        simulated(self.setting, &driven, tolerance)
    }
}

/// One state in each cell of the finest grid with at most so many of them.
fn thinned(mut states: Vec<Reached>, most: usize) -> Vec<Reached> {
    let Some(first) = states.first() else {
        return states;
    };
    let mut ranges: Vec<(f64, f64)> = first.state.iter().map(|&x| (x, x)).collect();
    for reached in &states {
        for (range, &x) in ranges.iter_mut().zip(&reached.state) {
            *range = (range.0.min(x), range.1.max(x));
        }
    }
    let mut cells = FINEST;
    loop {
        let mut seen = HashSet::new();
        let is_first = |reached: &Reached| {
            let shares = reached.state.iter().zip(&ranges).map(|(x, (low, high))| {
                let range = high - low;
                if range > 0.0 { (x - low) / range } else { 0.0 }
            });
            let cell: Vec<u32> = shares.map(|share| (share * cells) as u32).collect();
            seen.insert(cell)
        };
        let kept: Vec<bool> = states.iter().map(is_first).collect();
        if seen.len() <= most || cells < 1.0 {
            let mut kept = kept.into_iter();
            states.retain(|_| kept.next().unwrap_or(false));
            return states;
        }
        cells *= COARSER;
    }
}

/// Units of the goals.
fn units(ends: &[End]) -> Vec<f64> {
    let goals = ends.first().map_or(0, |end| end.missing.len());
    let unit = |goal: usize| {
        let mut values: Vec<f64> = ends.iter().map(|end| end.missing[goal].abs()).collect();
        values.sort_by(f64::total_cmp);
        values[(WITHIN * values.len() as f64) as usize]
    };
    (0..goals).map(unit).collect()
}

fn is_same(a: &[f64], b: &[f64]) -> bool {
    let mut pairs = a.iter().zip(b);
    pairs.all(|(a, b)| (a - b).abs() <= MOTION * a.abs().max(b.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_thinned_to_one_of_each_cell_of_a_grid_over_their_range() {
        let at = |x: f64, v: f64| Reached {
            from: 0,
            choice: 0,
            state: vec![x, v],
        };
        // Few enough: all that differ stay, and equal ones once.
        let few: Vec<Reached> = (0..50).map(|i| at(f64::from(i / 2), -7.0)).collect();
        assert_eq!(thinned(few, 1000).len(), 25);
        // 10,000 states over a square: some 30 cells each way.
        let many =
            (0..100).flat_map(|i| (0..100).map(move |j| at(f64::from(i), 1e6 * f64::from(j))));
        let kept = thinned(many.collect(), 1000);
        assert!((500..=1000).contains(&kept.len()), "{}", kept.len());
        let far = |place: usize| kept.iter().map(|r| r.state[place]).fold(0.0, f64::max);
        assert!(far(0) >= 95.0 && far(1) >= 95e6);
    }
}
