//! Runs that are asked to end within a step, or whose time is over there: they leave the point before it.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use crate::solver_support::{Asked, Watched, read_problems};
use hangtime_solver::mpcc;
use hangtime_solver::nlp::{self, Interrupt, Settings, Status};

/// What happens in the middle of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Event {
    /// Somebody asks when second derivatives are evaluated.
    AskedBeforeFactors,
    /// Somebody asks at the first trial point of a line search, at which the objective has no value.
    AskedAtTrial,
    /// Second derivatives take long.
    Slow,
    /// Nothing.
    Nothing,
}

/// What was seen of a run.
#[derive(Default)]
struct Seen {
    asked: Arc<AtomicBool>,
    hessians: usize,
    /// Evaluations of the objective after the event, and the point of the last second derivatives.
    after: usize,
    point: Vec<f64>,
}

/// Second derivatives at which it happens.
const THIRD: usize = 3;

/// `min sum_i (x_i - i)^4 + (x_i - i)^2 + x_0 x_1` where `x_0` and `x_1` complement each other if asked as such.
fn program(event: Event, seen: &mut Seen) -> Watched<impl FnMut(Asked, &[f64], &mut [f64])> {
    let mut text = "problem p 6\nstart 9 9 9 9 9 9\nminimize x1*x2\npair 1 2\n".to_owned();
    for (i, x) in (0..6).zip(1..) {
        text += &format!("bounds {x} 0 inf\nminimize (x{x} - {i})^4 + (x{x} - {i})^2\n");
    }
    let watch = move |asked, x: &[f64], values: &mut [f64]| {
        if asked == Asked::Hessian {
            seen.hessians += 1;
            seen.point = x.to_vec();
        }
        if seen.hessians < THIRD {
            return;
        }
        match (asked, event) {
            (Asked::Hessian, Event::AskedBeforeFactors) => {
                seen.asked.store(true, Ordering::Relaxed)
            }
            (Asked::Hessian, Event::Slow) => thread::sleep(Duration::from_millis(300)),
            (Asked::Objective, _) => {
                seen.after += 1;
                if event == Event::AskedAtTrial {
                    seen.asked.store(true, Ordering::Relaxed);
                    values[0] = f64::NAN;
                }
            }
            _ => {}
        }
    };
    Watched::new(read_problems(&text).remove(0), watch)
}

/// Solves it; what was seen.
fn solved(event: Event, seconds: f64) -> (nlp::Solution, Seen) {
    let mut seen = Seen::default();
    let mut settings = Settings::default();
    settings.interrupt = Interrupt::by(Arc::clone(&seen.asked));
    settings.maximum_seconds = seconds;
    let solution = nlp::solve(&mut program(event, &mut seen), &settings).unwrap();
    (solution, seen)
}

#[test]
fn run_ends_within_the_step_at_the_point_before_it() {
    for (event, status, most) in [
        // the result has the objective of its point
        (Event::AskedBeforeFactors, Status::Interrupted, 1),
        // and the trial at which it happens
        (Event::AskedAtTrial, Status::Interrupted, 2),
        (Event::Slow, Status::TimeLimit, 1),
    ] {
        let (solution, seen) = solved(event, 0.25);
        assert_eq!(solution.status, status, "{event:?}");
        assert_eq!(seen.hessians, THIRD, "{event:?}");
        assert!(seen.after <= most, "{event:?}: {}", seen.after);
        assert_eq!(solution.x, seen.point, "{event:?}");
    }
    assert_eq!(solved(Event::Nothing, 60.0).0.status, Status::Solved);
}

#[test]
fn complementarity_solve_ends_with_all_its_runs() {
    let mut seen = Seen::default();
    let mut settings = mpcc::Settings::default();
    settings.interior_point.interrupt = Interrupt::by(Arc::clone(&seen.asked));
    let mut program = program(Event::AskedBeforeFactors, &mut seen);
    let solution = mpcc::solve(&mut program, &settings).unwrap();
    drop(program);
    let interrupted = mpcc::Status::Failed(Status::Interrupted);
    assert_eq!(solution.status, interrupted);
    assert_eq!(seen.hessians, THIRD);
    assert!(solution.x.iter().all(|x| x.is_finite()));
}
