//! The rule: the default simulation against the event-driven one, and what decides where they differ.

use std::panic::{AssertUnwindSafe, catch_unwind};

use hangtime::model::Model;
use hangtime::simulation::{EventDriven, Fesd, InitialValueProblem, Simulation, Simulator};

/// Two runs agree if they differ by less than this share of the largest value.
const AGREE: f64 = 1e-5;
/// Two runs of tighter tolerances whose ends or events differ by more than this share show that the answer is not
/// determined: the motion then amplifies errors more than ten thousand times.
const DETERMINED: f64 = 1e-7;
/// Share of a coordinate that is rounding error.
const ROUNDING: f64 = 1e-12;
/// Tolerances of those two runs.
const TIGHT: [f64; 2] = [1e-11, 1e-13];
/// How often the horizon is halved until the answer is determined.
const HALVINGS: usize = 12;
/// Steps after which the event-driven method gives up: some seconds.
const STEPS: usize = 200_000;

/// What became of one scene.
pub(crate) enum Verdict {
    /// Both are solved and agree: up to this share of the horizon, from where on the answer is not determined.
    Agree(f64),
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
    /// The default simulation from the event-driven one of the tightest tolerance.
    pub(crate) default: f64,
    /// The event-driven simulation from the one of the tightest tolerance.
    pub(crate) event: f64,
    /// Share of the horizon at which they were compared.
    pub(crate) share: f64,
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
/// Both methods run with their default settings. Where the states at the end differ by more than [`AGREE`], two
/// more event-driven runs with tolerances [`TIGHT`] tell whether the answer is determined there; if it is not, the
/// horizon is halved. So chaotic motions are compared as far as they can be known.
pub(crate) fn judge(model: &dyn Model) -> Verdict {
    let mut share = 1.0;
    for _ in 0..=HALVINGS {
        let (default, event) = (
            run(&Fesd::default(), model, share),
            run(&event_driven(1e-9), model, share),
        );
        let (Ok(default_run), Ok(event_run)) = (&default, &event) else {
            return Verdict::Ended {
                default: ended(&default),
                event: ended(&event),
            };
        };
        let apart = distance(model, default_run, event_run);
        if apart <= AGREE {
            return Verdict::Agree(share);
        }
        let [tight, tightest] = TIGHT.map(|tolerance| run(&event_driven(tolerance), model, share));
        if let (Ok(tight), Ok(tightest)) = (tight, tightest)
            && determined(model, &tight, &tightest)
        {
            return Verdict::Disagree(Difference {
                apart,
                default: distance(model, default_run, &tightest),
                event: distance(model, event_run, &tightest),
                share,
            });
        }
        share *= 0.5;
    }
    Verdict::Agree(0.0)
}

fn event_driven(tolerance: f64) -> EventDriven {
    EventDriven {
        tolerance,
        max_steps: STEPS,
        ..EventDriven::default()
    }
}

/// Runs over a share of the horizon; an error is how it ended if not solved.
fn run(simulator: &dyn Simulator, model: &dyn Model, share: f64) -> Result<Simulation, Ended> {
    let ended = |status, message: String| Ended { status, message };
    let mut problem = match InitialValueProblem::of(model, None) {
        Ok(problem) => problem,
        Err(error) => return Err(ended("refused", error.to_string())),
    };
    problem.horizon *= share;
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

/// Whether two runs of tight tolerances have the same events at the same times, and the same end.
fn determined(model: &dyn Model, tight: &Simulation, tightest: &Simulation) -> bool {
    let horizon = tight.trajectory.time.last().copied().unwrap_or_default();
    let same_events = tight.events.len() == tightest.events.len()
        && tight.events.iter().zip(&tightest.events).all(|(a, b)| {
            a.kind == b.kind
                && a.contact == b.contact
                && (a.time - b.time).abs() <= DETERMINED * horizon
        });
    same_events && distance(model, tight, tightest) <= DETERMINED
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
    (0..n)
        .flat_map(|k| {
            [
                share(q_a[k] - q_b[k], largest(&way, k)),
                share(v_a[k] - v_b[k], largest(&speed, k)),
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
