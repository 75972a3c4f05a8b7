//! The entry point: the method that fits the program, and its result in the terms of the file.

use crate::clock::ThreadTime;

use super::program::Program;
use super::solution::{Solution, Status, Work};
use crate::mpcc::{self, Mpcc, Stationarity, StationarityType};
use crate::nlp::{self, InputError};

/// Solves a program with the default settings of [`mpcc`], or of [`nlp`] where nothing is complementary, in at most
/// `seconds` of wall-clock time. The observer sees each iteration and can stop the run.
///
/// # Errors
/// [`InputError`] where a lower bound exceeds its upper bound, or a function is not finite at the starting point.
pub fn solve(
    program: &mut Program,
    seconds: f64,
    observer: &mut nlp::Observer<'_>,
) -> Result<Solution, InputError> {
    let start = ThreadTime::now();
    let mut solution = if program.complementarities().is_empty() {
        let settings = nlp::Settings {
            maximum_seconds: seconds,
            ..nlp::Settings::default()
        };
        let solution = nlp::solve_from(program, &settings, None, Some(observer))?;
        of_nonlinear(program, solution)
    } else {
        let mut settings = mpcc::Settings::default();
        settings.interior_point.maximum_seconds = seconds;
        let solution = mpcc::solve_observed(program, &settings, observer)?;
        of_complementary(program, solution)
    };
    solution.work.seconds = start.elapsed().as_secs_f64();
    Ok(solution)
}

fn of_nonlinear(program: &Program, solution: nlp::Solution) -> Solution {
    let status = of_run(solution.status);
    let stationarity = match status {
        Status::Solved => Stationarity::S,
        _ => Stationarity::None,
    };
    Solution {
        reason: solution.status.to_string(),
        stationarity,
        objective: program.sense() * solution.objective,
        x: program.in_file(&solution.x),
        multipliers: multipliers(program, &solution.multipliers),
        residuals: solution.residuals,
        violation_stationarity: solution.violation_stationarity,
        work: Work {
            iterations: solution.counts.iterations,
            factorizations: solution.counts.factorizations,
            ..Work::default()
        },
        violations: solution.violations,
        status,
    }
}

fn of_complementary(program: &Program, solution: mpcc::Solution) -> Solution {
    let status = match solution.status {
        mpcc::Status::Solved => Status::Solved,
        mpcc::Status::Uncertified | mpcc::Status::NotStationary => Status::Uncertified,
        mpcc::Status::Relaxed => Status::Relaxed,
        mpcc::Status::Infeasible => Status::Infeasible,
        // the sides of a run without a crossover need not vanish
        mpcc::Status::Failed(nlp::Status::Degenerate) => Status::Failed,
        mpcc::Status::Failed(status) => of_run(status),
    };
    let stationarity = match &solution.certificate {
        Some(certificate) if status == Status::Solved => match certificate.stationarity {
            StationarityType::Strong => Stationarity::S,
            _ => Stationarity::B,
        },
        _ => Stationarity::None,
    };
    Solution {
        reason: solution.status.to_string(),
        stationarity,
        objective: program.sense() * solution.objective,
        x: program.in_file(&solution.x),
        multipliers: multipliers(program, &solution.multipliers),
        residuals: solution.residuals,
        violation_stationarity: solution.violation_stationarity,
        work: Work {
            iterations: solution.iterations + solution.certificate_iterations,
            crossover_iterations: solution.crossover_iterations,
            factorizations: solution.factorizations,
            ..Work::default()
        },
        violations: solution.violations,
        status,
    }
}

fn of_run(status: nlp::Status) -> Status {
    match status {
        nlp::Status::Solved => Status::Solved,
        nlp::Status::Degenerate => Status::Uncertified,
        nlp::Status::Infeasible => Status::Infeasible,
        nlp::Status::Diverging => Status::Unbounded,
        nlp::Status::Interrupted => Status::Interrupted,
        nlp::Status::TimeLimit => Status::TimeLimit,
        _ => Status::Failed,
    }
}

/// Rates of change of the objective with the right-hand sides of the rows of the file; 0 for rows that became pairs.
fn multipliers(program: &Program, own: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0; program.file_rows];
    for (row, y) in program.vertical.rows.iter().zip(own) {
        let has_slack = row.function.linear.last();
        if has_slack.is_none_or(|&(variable, _)| variable < program.variables) {
            // the sign turns where `-f` was minimized
            all[row.of] = -program.sense() * y + 0.0;
        }
    }
    all
}
