//! Where the search starts: motions made from model and problem alone.

use crate::model::{Model, held};
use crate::ocp::motion::control_grid::ControlGrid;
use crate::ocp::motion::model_input::{drive, with_forces};
use crate::ocp::motion::targets::{horizon_guess, targets};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::{Horizon, Problem};
use crate::ocp::settings::Guess;
use crate::ocp::tuning::candidates::SAMPLES;
use crate::ocp::tuning::guesses::{OF_RANGE, OF_SIZE, OF_WAY, PERTURBED_TIME};
use crate::simulation::{EventDriven, InputError, simulate_once};

/// The start of the global phase.
pub(in crate::ocp) fn guess(
    model: &dyn Model,
    problem: &Problem,
    guess: &Guess,
    bounds: (&[f64], &[f64]),
) -> Result<Trajectory, InputError> {
    let straight = straight(model, problem, bounds);
    match guess {
        Guess::Straight => Ok(straight),
        Guess::Rest => Ok(at_rest(straight, model, problem)),
        Guess::Ride => ride(straight, model, problem, &problem.start()),
        Guess::Perturbed(seed) => Ok(perturbed(straight, model, problem, *seed, bounds)),
        Guess::Random(seed) => {
            let (driven, drawn) = random(straight, model, problem, *seed, bounds);
            match drawn.map(|start| ride(driven.clone(), model, problem, &start)) {
                Some(Ok(motion)) => Ok(motion),
                // It may be inside a surface: the declared one is not.
                Some(Err(_)) | None => ride(driven, model, problem, &problem.start()),
            }
        }
        Guess::Previous(previous) => previous.trajectory(model, problem),
    }
}

/// A motion with random controls and length, and a random start where values are free.
pub(in crate::ocp) fn random(
    motion: Trajectory,
    model: &dyn Model,
    problem: &Problem,
    seed: u64,
    bounds: (&[f64], &[f64]),
) -> (Trajectory, Option<Vec<f64>>) {
    let driven = randomly_driven(motion, model, problem, seed, bounds);
    let drawn = random_start(model, problem, seed, driven.horizon);
    (driven, drawn)
}

/// Coordinates with a goal move to it at constant speed, the others rest; states of first order are as at the start; controls are 0,
/// or as near to it as their bounds allow.
fn straight(model: &dyn Model, problem: &Problem, bounds: (&[f64], &[f64])) -> Trajectory {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let horizon = horizon_guess(problem, model);
    let targets = targets(problem, model);
    let controls: Vec<f64> = (n..n + declaration.controls.len())
        .map(|k| 0.0_f64.clamp(bounds.0[k], bounds.1[k]))
        .collect();
    let samples = SAMPLES * problem.intervals;
    let states = (0..=samples).map(|i| {
        let share = i as f64 / samples as f64;
        let mut x = problem.q.clone();
        x.resize(2 * n, 0.0);
        for k in 0..n {
            if let Some(target) = targets[k] {
                x[n + k] = (target - problem.q[k]) / horizon;
                x[k] += share * (target - problem.q[k]);
            }
        }
        let first = declaration.mechanical();
        let states = &problem.v[first..];
        x[n + first..2 * n].copy_from_slice(states);
        for (integral, state) in x[first..n].iter_mut().zip(states) {
            *integral += share * horizon * state;
        }
        with_forces(model, x, &drive(model, &controls, share * horizon))
    });
    Trajectory {
        horizon,
        states: states.collect(),
        time: (0..=samples)
            .map(|i| horizon * i as f64 / samples as f64)
            .collect(),
        controls: ControlGrid::constant(vec![controls.clone(); problem.intervals]),
    }
}

/// All states as at the start, over 1 s unless the horizon is fixed.
fn at_rest(mut motion: Trajectory, model: &dyn Model, problem: &Problem) -> Trajectory {
    let driven = drive(model, motion.controls.start(), 0.0);
    let state = with_forces(model, problem.start(), &driven);
    motion.states.fill(state);
    if let Horizon::Free { guess: None } = problem.horizon {
        for time in &mut motion.time {
            *time /= motion.horizon;
        }
        motion.horizon = 1.0;
    }
    motion
}

/// A start whose free values are random within their ranges; of a range without end, as far around the declared value as that is
/// from zero, and as coordinates with a goal are from it, or what takes them there in the time of the motion. None where no value is
/// free.
fn random_start(model: &dyn Model, problem: &Problem, seed: u64, horizon: f64) -> Option<Vec<f64>> {
    let declared = model.declaration().optimal_control?;
    let n = problem.q.len();
    let targets = targets(problem, model);
    let ranges = problem.start_ranges(model);
    // Other numbers than those of the controls, and of every second start the opposite ones of the one before: so few starts
    // try both halves of each range.
    let opposite = matches!(seed % 4, 0 | 3) && seed > 2;
    let (drawn, sign) = if opposite {
        (seed - 2, -1.0)
    } else {
        (seed, 1.0)
    };
    let mut random = uniform(!drawn);
    let mut start = problem.start();
    for &k in declared.free_start {
        let way = targets[k % n].map_or(0.0, |target| (target - problem.q[k % n]).abs());
        let way = if k < n { way } else { 2.0 * way / horizon };
        let size = start[k].abs().max(way);
        let size = if size > 0.0 { size } else { 1.0 };
        let (lower, upper) = ranges[k];
        let (from, to) = if (upper - lower).is_finite() {
            (lower, upper)
        } else {
            (start[k] - size, start[k] + size)
        };
        start[k] = (from + 0.5 * (sign * random() + 1.0) * (to - from)).clamp(lower, upper);
    }
    held::complete_start(model, &mut start);
    (!declared.free_start.is_empty()).then_some(start)
}

/// The motion from a start under these controls; as far as it goes.
fn ride(
    motion: Trajectory,
    model: &dyn Model,
    problem: &Problem,
    start: &[f64],
) -> Result<Trajectory, InputError> {
    let simulator = EventDriven {
        output_times: SAMPLES * problem.intervals,
        ..EventDriven::default()
    };
    let unforced = problem.initial_value_problem(start, motion.horizon, motion.signal());
    let simulation = simulate_once(&simulator, model, &unforced)?;
    if simulation.trajectory.time.is_empty() {
        return Ok(motion);
    }
    Ok(Trajectory::of_simulation(
        model,
        &simulation,
        motion.horizon,
        motion.controls,
    ))
}

/// Random numbers in [-1, 1): SplitMix64 (Steele, Lea, Flood 2014).
pub(in crate::ocp) fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// The motion in `factor` times its time where that is free.
fn scaled(motion: Trajectory, problem: &Problem, factor: impl FnOnce() -> f64) -> Trajectory {
    if let Horizon::Free { .. } = problem.horizon {
        let horizon = motion.horizon * factor();
        motion.stretched(horizon)
    } else {
        motion
    }
}

/// Controls that are random within their range over parts of the motion, between one and as many as there are
/// intervals; the horizon scaled by up to a factor of two where it is free.
fn randomly_driven(
    motion: Trajectory,
    model: &dyn Model,
    problem: &Problem,
    seed: u64,
    bounds: (&[f64], &[f64]),
) -> Trajectory {
    let n = problem.q.len();
    let mut random = uniform(seed);
    let mut motion = scaled(motion, problem, || 2.0_f64.powf(random()));
    let intervals = problem.intervals as f64;
    let parts = intervals.powf(0.5 * (random() + 1.0)).round().max(1.0);
    let mut values = motion.controls.values().to_vec();
    let mut current = usize::MAX;
    let mut drawn = vec![0.0; model.declaration().controls.len()];
    for (interval, controls) in values.iter_mut().enumerate() {
        let part = (interval as f64 * parts / intervals) as usize;
        if part != current {
            current = part;
            for (u, k) in drawn.iter_mut().zip(n..) {
                let (lower, upper) = (bounds.0[k], bounds.1[k]);
                let share = random();
                *u = if (upper - lower).is_finite() {
                    lower + 0.5 * (share + 1.0) * (upper - lower)
                } else {
                    (share * natural_size(model, &motion, k)).clamp(lower, upper)
                };
            }
        }
        controls.clone_from(&drawn);
    }
    motion.controls = ControlGrid::constant(values);
    motion
}

/// Size of the control with index `k` among the bounds, where it has none: the least that accelerates a coordinate as much as it
/// does by itself at the start, together with what takes it to its goal and to rest there in the time of the motion; 1
/// where nothing of that kind says how large it is.
pub(in crate::ocp) fn natural_size(model: &dyn Model, motion: &Trajectory, k: usize) -> f64 {
    let n = model.declaration().coordinates.len();
    let mut input = motion.states[0][..2 * n].to_vec();
    input.extend(drive(model, motion.controls.start(), 0.0));
    let (mut alone, mut pushed) = (vec![0.0; n], vec![0.0; n]);
    model.free_acceleration(&input, &mut alone);
    input[n + k] += 1.0;
    model.free_acceleration(&input, &mut pushed);
    let ends = motion.states.first().zip(motion.states.last());
    let sizes = (0..n).filter_map(|i| {
        let (first, last) = ends?;
        let way = 4.0 * (last[i] - first[i]).abs() / motion.horizon.powi(2);
        let size = (alone[i].abs() + way) / (pushed[i] - alone[i]).abs();
        (size > 0.0 && size.is_finite()).then_some(size)
    });
    sizes.reduce(f64::min).unwrap_or(1.0)
}

/// Random controls within a quarter of their range, the horizon scaled by up to 15 %, and every coordinate
/// bent by up to a twentieth of the distance to its goal.
fn perturbed(
    motion: Trajectory,
    model: &dyn Model,
    problem: &Problem,
    seed: u64,
    bounds: (&[f64], &[f64]),
) -> Trajectory {
    let n = problem.q.len();
    let mut random = uniform(seed);
    let mut motion = scaled(motion, problem, || (PERTURBED_TIME * random()).exp());
    let mut values = motion.controls.values().to_vec();
    for controls in &mut values {
        for (u, k) in controls.iter_mut().zip(n..) {
            let range = bounds.1[k] - bounds.0[k];
            let size = if range.is_finite() {
                OF_RANGE * range
            } else {
                OF_SIZE * natural_size(model, &motion, k)
            };
            *u = (*u + size * random()).clamp(bounds.0[k], bounds.1[k]);
        }
    }
    motion.controls = ControlGrid::constant(values);
    let last = (motion.states.len() - 1) as f64;
    for (k, target) in targets(problem, model).into_iter().enumerate() {
        let bend = OF_WAY * random() * target.map_or(0.0, |target| target - problem.q[k]);
        for (i, x) in motion.states.iter_mut().enumerate() {
            x[k] += bend * (std::f64::consts::PI * i as f64 / last).sin();
        }
    }
    for (i, x) in motion.states.iter_mut().enumerate() {
        let controls = motion.controls.at(i as f64 / SAMPLES as f64);
        let driven = drive(model, &controls, motion.time[i]);
        *x = with_forces(model, x[..2 * n].to_vec(), &driven);
    }
    motion
}
