//! Runs that are asked to end within a step, or whose time is over there: they leave the point before it.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use hangtime_solver::mpcc::{self, Mpcc};
use hangtime_solver::nlp::{self, Interrupt, NlpProblem, Settings, Status};

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

/// `min sum_i (x_i - i)^4 + (x_i - i)^2 + x_0 x_1` where `x_0` and `x_1` complement each other if asked as such.
struct Program {
    event: Event,
    asked: Arc<AtomicBool>,
    hessians: usize,
    /// Evaluations of the objective after the event, and the point of the last second derivatives.
    after: usize,
    point: Vec<f64>,
}

const SIZE: usize = 6;
/// Second derivatives at which it happens.
const THIRD: usize = 3;

impl Program {
    fn new(event: Event) -> Self {
        Self {
            event,
            asked: Arc::default(),
            hessians: 0,
            after: 0,
            point: Vec::new(),
        }
    }

    fn has_happened(&self) -> bool {
        self.hessians >= THIRD
    }
}

impl NlpProblem for Program {
    fn variables(&self) -> usize {
        SIZE
    }
    fn constraints(&self) -> usize {
        0
    }
    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        lower.fill(0.0);
        upper.fill(f64::INFINITY);
    }
    fn constraint_bounds(&self, _: &mut [f64], _: &mut [f64]) {}
    fn initial_point(&self, x: &mut [f64]) {
        x.fill(9.0);
    }
    fn objective(&mut self, x: &[f64]) -> f64 {
        if self.has_happened() {
            self.after += 1;
            if self.event == Event::AskedAtTrial {
                self.asked.store(true, Ordering::Relaxed);
                return f64::NAN;
            }
        }
        let terms = x.iter().enumerate().map(|(i, x)| {
            let d = x - i as f64;
            d.powi(4) + d * d
        });
        terms.sum::<f64>() + x[0] * x[1]
    }
    fn gradient(&mut self, x: &[f64], g: &mut [f64]) {
        for (i, (g, x)) in g.iter_mut().zip(x).enumerate() {
            let d = x - i as f64;
            *g = 4.0 * d.powi(3) + 2.0 * d;
        }
        g[0] += x[1];
        g[1] += x[0];
    }
    fn constraint_values(&mut self, _: &[f64], _: &mut [f64]) {}
    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        Vec::new()
    }
    fn jacobian_values(&mut self, _: &[f64], _: &mut [f64]) {}
    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        (0..SIZE).map(|i| (i, i)).chain([(1, 0)]).collect()
    }
    fn hessian_values(&mut self, x: &[f64], weight: f64, _: &[f64], values: &mut [f64]) {
        self.hessians += 1;
        if self.has_happened() {
            match self.event {
                Event::AskedBeforeFactors => self.asked.store(true, Ordering::Relaxed),
                Event::Slow => thread::sleep(Duration::from_millis(300)),
                Event::AskedAtTrial | Event::Nothing => {}
            }
        }
        self.point = x.to_vec();
        for (i, (value, x)) in values.iter_mut().zip(x).enumerate() {
            *value = weight * (12.0 * (x - i as f64).powi(2) + 2.0);
        }
        values[SIZE] = weight;
    }
}

impl Mpcc for Program {
    fn complementarities(&self) -> &[(usize, usize)] {
        &[(0, 1)]
    }
}

fn settings(program: &Program, seconds: f64) -> Settings {
    let mut settings = Settings::default();
    settings.interrupt = Interrupt::by(Arc::clone(&program.asked));
    settings.maximum_seconds = seconds;
    settings
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
        let mut program = Program::new(event);
        let settings = settings(&program, 0.25);
        let solution = nlp::solve(&mut program, &settings).unwrap();
        assert_eq!(solution.status, status, "{event:?}");
        assert_eq!(program.hessians, THIRD, "{event:?}");
        assert!(program.after <= most, "{event:?}: {}", program.after);
        assert_eq!(solution.x, program.point, "{event:?}");
    }
    let mut program = Program::new(Event::Nothing);
    let settings = settings(&program, 60.0);
    let solution = nlp::solve(&mut program, &settings).unwrap();
    assert_eq!(solution.status, Status::Solved);
}

#[test]
fn complementarity_solve_ends_with_all_its_runs() {
    let mut program = Program::new(Event::AskedBeforeFactors);
    let mut settings = mpcc::Settings::default();
    settings.interior_point.interrupt = Interrupt::by(Arc::clone(&program.asked));
    let solution = mpcc::solve(&mut program, &settings).unwrap();
    let interrupted = mpcc::Status::Failed(Status::Interrupted);
    assert_eq!(solution.status, interrupted);
    assert_eq!(program.hessians, THIRD);
    assert!(solution.x.iter().all(|x| x.is_finite()));
}
