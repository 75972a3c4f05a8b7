//! What the caller keeps, and the solution file that modelling languages read.

use std::fmt::Write as _;

use super::answer::one_line;
use super::program::Program;
use super::second_order::SecondOrder;
use crate::mpcc::Stationarity;
use crate::nlp::{Residuals, Violation};

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Status {
    /// The point is feasible, complementary to rounding error, and stationary: a local solution.
    Solved,
    /// The point is feasible, but that it is stationary was not proved.
    Uncertified,
    /// Complementarity holds to the last relaxation only.
    Relaxed,
    /// A stationary point of the constraint violation: the rows are infeasible near it.
    Infeasible,
    /// The iterates grew without bound, or the objective improves without bound along a ray of feasible points.
    Unbounded,
    /// The observer asked to stop.
    Interrupted,
    /// The time was over.
    TimeLimit,
    /// The limit on iterations was reached.
    IterationLimit,
    /// A failure; [`Solution::reason`] says which.
    Failed,
}

impl Status {
    /// Whether the point is certified.
    pub fn is_solved(self) -> bool {
        self == Self::Solved
    }

    /// Name of the status, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Uncertified => "uncertified",
            Self::Relaxed => "relaxed",
            Self::Infeasible => "locally_infeasible",
            Self::Unbounded => "unbounded",
            Self::Interrupted => "interrupted",
            Self::TimeLimit => "time_limit",
            Self::IterationLimit => "iteration_limit",
            Self::Failed => "failed",
        }
    }

    /// The number that modelling languages classify results by (`solve_result_num` of AMPL).
    fn number(self) -> usize {
        match self {
            Self::Solved => 0,
            Self::Uncertified | Self::Relaxed => 100,
            Self::Infeasible => 200,
            Self::Unbounded => 300,
            Self::IterationLimit => 400,
            Self::TimeLimit => 401,
            Self::Interrupted => 402,
            Self::Failed => 500,
        }
    }
}

/// Work done.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Work {
    /// Interior point iterations of all runs, those of crossovers and certificates included.
    pub iterations: usize,
    /// Those of crossovers alone.
    pub crossover_iterations: usize,
    /// Numeric factorizations.
    pub factorizations: usize,
    /// CPU time in seconds.
    pub seconds: f64,
}

/// The result of a solve, in the variables and rows of the file.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Solution {
    /// How the solve ended.
    pub status: Status,
    /// How it ended in words.
    pub reason: String,
    /// What is proved about the point.
    pub stationarity: Stationarity,
    /// What second derivatives say of a point that is strongly stationary; `None` of others.
    pub second_order: Option<SecondOrder>,
    /// Objective of the file at the point.
    pub objective: f64,
    /// The variables of the file.
    pub x: Vec<f64>,
    /// Rate of change of the objective with the right-hand side of each row; 0 for rows that complement a variable.
    pub multipliers: Vec<f64>,
    /// Rates of change of the objective with the lower and the upper bounds of the variables of the file.
    pub bound_multipliers: [Vec<f64>; 2],
    /// Residuals, unscaled.
    pub residuals: Residuals,
    /// Of a point that is called infeasible: the largest entry of the gradient of the violation.
    pub violation_stationarity: Option<f64>,
    /// Work done.
    pub work: Work,
    /// Worst violated rows, bounds and pairs, at most ten; empty when all are within tolerance.
    pub violations: Vec<Violation>,
}

impl Solution {
    /// Why the point is no certified solution, in one line; `None` where it is one.
    pub fn diagnosis(&self) -> Option<String> {
        if self.status.is_solved() {
            return None;
        }
        let mut text = self.reason.clone();
        if let Some(residual) = self.violation_stationarity {
            let _ = write!(text, ", gradient of the violation {residual:.1e}");
        }
        let mut before = "; violated: ";
        for violation in &self.violations {
            let _ = write!(
                text,
                "{before}{} by {:.1e}",
                violation.name, violation.amount
            );
            before = ", ";
        }
        Some(text)
    }

    /// The text of a `.sol` file: a message, the counts of rows and variables, the multipliers of all rows, the values of all
    /// variables, and the number that classifies the result.
    pub fn file_text(&self, program: &Program) -> String {
        let reason = one_line(&self.reason);
        let mut text = format!(
            "hangtime: {reason}; objective {}; {} iterations\n\nOptions\n",
            self.objective, self.work.iterations
        );
        for option in &program.options {
            let _ = writeln!(text, "{option}");
        }
        for count in [self.multipliers.len(), self.x.len()] {
            let _ = writeln!(text, "{count}\n{count}");
        }
        for value in self.multipliers.iter().chain(&self.x) {
            let _ = writeln!(text, "{value:e}");
        }
        let _ = writeln!(text, "objno 0 {}", self.status.number());
        text
    }

    /// As [`Solution::file_text`], and the suffixes of the protocol by which modelling languages call solvers: multipliers of bounds in
    /// `ipopt_zL_out` and `ipopt_zU_out` (rates of change of the objective), `stationarity` of the problem (2: S, 1: B, 0: nothing is proved) and
    /// `second_order` (3: sufficient, 2: necessary, 1: undecided, 0: not asked, -1: the objective descends).
    pub fn file_text_with_suffixes(&self, program: &Program) -> String {
        let mut text = self.file_text(program);
        for (name, values) in ["ipopt_zL_out", "ipopt_zU_out"]
            .iter()
            .zip(&self.bound_multipliers)
        {
            let present = values
                .iter()
                .enumerate()
                .filter(|(_, value)| **value != 0.0);
            // kind 4: real values of variables; the length of the name counts the end of a C string
            let _ = writeln!(
                text,
                "suffix 4 {} {} 0 0\n{name}",
                present.clone().count(),
                name.len() + 1
            );
            for (index, value) in present {
                let _ = writeln!(text, "{index} {value:e}");
            }
        }
        let stationarity = match self.stationarity {
            Stationarity::S => 2,
            Stationarity::B => 1,
            Stationarity::None => 0,
        };
        let second_order = match self.second_order {
            Some(SecondOrder::Sufficient) => 3,
            Some(SecondOrder::Necessary) => 2,
            Some(SecondOrder::Undecided) => 1,
            Some(SecondOrder::Descends) => -1,
            None => 0,
        };
        for (name, value) in [
            ("stationarity", stationarity),
            ("second_order", second_order),
        ] {
            // kind 3: a whole number of the problem
            let _ = writeln!(text, "suffix 3 1 {} 0 0\n{name}\n0 {value}", name.len() + 1);
        }
        text
    }
}
