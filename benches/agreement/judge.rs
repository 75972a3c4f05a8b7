//! The rule: the default simulation against the event-driven one, and what decides where they differ.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

use hangtime::model::Model;
use hangtime::simulation::{EventDriven, Fesd, InitialValueProblem, Simulation, Simulator};

/// Two runs agree if they differ by less than this share of the largest value.
pub(crate) const AGREE: f64 = 1e-5;
/// Share of a coordinate that is rounding error of a motion, and of its last digits alone.
const ROUNDING: f64 = 1e-12;
const LAST_DIGITS: f64 = 16.0 * f64::EPSILON;
/// Tolerance of the run that says which of the two is off.
const TIGHT: f64 = 1e-12;

/// What became of one scene.
pub(crate) enum Verdict {
    /// Both are solved and agree; whether the event-driven method has taken the default one over.
    Agree {
        /// The default run is one of the event-driven method.
        handed_over: bool,
    },
    /// Both are solved and differ.
    Disagree(Difference),
    /// One of them was not solved: the status of each.
    Ended {
        /// Status and message of the default simulation.
        default: Ended,
        /// Status and message of the event-driven one.
        event: Ended,
    },
}

/// Shares of the largest value by which the runs differ.
#[derive(Clone, Copy)]
pub(crate) struct Difference {
    /// The default simulation from the event-driven one.
    pub(crate) apart: f64,
    /// The default simulation from the event-driven one of a tight tolerance; none if that is not solved.
    pub(crate) default: Option<f64>,
    /// The event-driven simulation from the one of a tight tolerance.
    pub(crate) event: Option<f64>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "disagree by {:.1e}", self.apart)?;
        match (self.default, self.event) {
            (Some(default), Some(event)) => {
                write!(
                    f,
                    ": default off by {default:.1e}, event-driven by {event:.1e}"
                )
            }
            _ => f.write_str(": a tight tolerance is not solved"),
        }
    }
}

/// How a run ended.
#[derive(Clone, PartialEq)]
pub(crate) struct Ended {
    /// Name of the status, or what else happened.
    pub(crate) status: &'static str,
    /// The diagnosis, if there is one.
    pub(crate) message: String,
}

impl Ended {
    pub(crate) fn is_solved(&self) -> bool {
        self.status == "solved"
    }
}

/// Judges a scene over its declared horizon.
///
/// Both methods run with their default settings. Where both say `solved` their states at the end differ by no more than
/// [`AGREE`]: nothing excuses more, for a motion that is not determined so well must not be called solved.
pub(crate) fn judge(model: &dyn Model) -> Verdict {
    let (default, event) = (
        run(&by_default(), model),
        run(&event_driven(EventDriven::default().tolerance), model),
    );
    let handed_over = default.as_ref().is_ok_and(|run| {
        let mut notes = run.notes.iter();
        notes.any(|note| note.starts_with("finite elements ended"))
    });
    let (Ok(default_run), Ok(event_run)) = (&default, &event) else {
        return Verdict::Ended {
            default: ended(&default),
            event: ended(&event),
        };
    };
    let apart = distance(model, default_run, event_run);
    if apart <= AGREE {
        return Verdict::Agree { handed_over };
    }
    let tight = run(&event_driven(TIGHT), model).ok();
    let from_tight = |run| tight.as_ref().map(|tight| distance(model, run, tight));
    Verdict::Disagree(Difference {
        apart,
        default: from_tight(default_run),
        event: from_tight(event_run),
    })
}

/// What a call without any setting does.
pub(crate) fn by_default() -> Fesd {
    Fesd {
        hands_over: true,
        ..Fesd::default()
    }
}

fn event_driven(tolerance: f64) -> EventDriven {
    EventDriven {
        tolerance,
        ..EventDriven::default()
    }
}

/// Runs over the horizon; an error is how it ended if not solved.
fn run(simulator: &dyn Simulator, model: &dyn Model) -> Result<Simulation, Ended> {
    let ended = |status, message: String| Ended { status, message };
    let problem = match InitialValueProblem::of(model, None) {
        Ok(problem) => problem,
        Err(error) => return Err(ended("refused", error.to_string())),
    };
    let simulate = || simulator.simulate(model, &problem, &mut |_| true);
    match catch_unwind(AssertUnwindSafe(simulate)) {
        Err(_) => Err(ended("panicked", String::new())),
        Ok(Err(error)) => Err(ended("refused", error.to_string())),
        Ok(Ok(simulation)) => match simulation.status.diagnosis() {
            None => Ok(simulation),
            Some(diagnosis) => Err(ended(
                simulation.status.name(),
                format!("at {:.6e} s: {}", diagnosis.time, diagnosis.message),
            )),
        },
    }
}

fn ended(run: &Result<Simulation, Ended>) -> Ended {
    match run {
        Ok(_) => Ended {
            status: "solved",
            message: String::new(),
        },
        Err(ended) => ended.clone(),
    }
}

/// Sizes of the accelerations without contact at the start.
fn free_acceleration(model: &dyn Model) -> Vec<f64> {
    let declaration = model.declaration();
    let mut free = vec![0.0; declaration.coordinates.len()];
    if let Ok(problem) = InitialValueProblem::of(model, None) {
        // Coordinates, velocities; controls and time are zero.
        let mut state = [problem.q, problem.v].concat();
        state.resize(declaration.inputs(), 0.0);
        model.free_acceleration(&state, &mut free);
    }
    free.iter().map(|a| a.abs()).collect()
}

/// Distance of the final states as a share of the largest value: of the way from the start for coordinates, of the
/// velocity for velocities, each among the coordinates of one unit. So it does not depend on where the scene is.
fn distance(model: &dyn Model, a: &Simulation, b: &Simulation) -> f64 {
    let coordinates = model.declaration().coordinates;
    let (a, b) = (&a.trajectory, &b.trajectory);
    let (Some(q_a), Some(q_b)) = (a.q.last(), b.q.last()) else {
        return f64::INFINITY;
    };
    let (Some(v_a), Some(v_b)) = (a.v.last(), b.v.last()) else {
        return f64::INFINITY;
    };
    let n = coordinates.len();
    let horizon = a.time.last().copied().unwrap_or_default();
    // What does not move has rounding errors only.
    let mut way: Vec<f64> = q_a.iter().map(|q| ROUNDING * q.abs()).collect();
    let mut speed: Vec<f64> = way.iter().map(|way| way / horizon).collect();
    for trajectory in [a, b] {
        for (q, v) in trajectory.q.iter().zip(&trajectory.v) {
            for k in 0..n {
                way[k] = way[k].max((q[k] - trajectory.q[0][k]).abs());
                speed[k] = speed[k].max(v[k].abs());
            }
        }
    }
    let largest = |values: &[f64], k: usize| {
        let alike = (0..n).filter(|&other| coordinates[other].unit == coordinates[k].unit);
        alike.map(|other| values[other]).fold(0.0, f64::max)
    };
    let share = |difference: f64, size: f64| {
        if difference == 0.0 {
            0.0
        } else {
            difference.abs() / size
        }
    };
    // Where nothing moves they are all there is; forces that cancel leave those of what they would do alone.
    let free = free_acceleration(model);
    let beyond = |a: f64, b: f64, size: f64| ((a - b).abs() - LAST_DIGITS * size).max(0.0);
    (0..n)
        .flat_map(|k| {
            let alone = largest(&free, k) * horizon;
            let (q, v) = (q_b[k].abs() + alone * horizon, alone);
            [
                share(beyond(q_a[k], q_b[k], q), largest(&way, k)),
                share(beyond(v_a[k], v_b[k], v), largest(&speed, k)),
            ]
        })
        .fold(0.0, |worst, share| {
            if share.is_nan() {
                f64::INFINITY
            } else {
                share.max(worst)
            }
        })
}
