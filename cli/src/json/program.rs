//! The JSON document of a program from a file.

use hangtime::nl::{SecondOrder, Solution};
use hangtime::simulation::ProblemSize;
use serde::Serialize;

use super::parts::{SCHEMA, to_line};
use crate::ending::Ending;

/// The document of a program: the fields that it shares with that of a scene have the same names and meanings.
#[derive(Serialize)]
pub(crate) struct ProgramDocument<'a> {
    /// Version of the layout of the document.
    schema: u32,
    /// The file.
    file: &'a str,
    /// How the run ended.
    status: &'static str,
    /// Where and why it ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    diagnosis: Option<&'a str>,
    /// The objective.
    objective: f64,
    /// The certificate.
    stationarity: &'static str,
    /// What second derivatives say. Only of a point that is strongly stationary.
    #[serde(skip_serializing_if = "Option::is_none")]
    second_order: Option<&'static str>,
    /// How well the conditions hold.
    residuals: Residuals,
    /// Size of the largest system or program.
    size: ProblemSize,
    /// What the run took, counted.
    iterations: Iterations,
    /// CPU time \[s\].
    seconds: Seconds,
    /// Values of the variables, in the order of the file.
    x: &'a [f64],
    /// Multipliers of the rows.
    multipliers: &'a [f64],
}

/// Residuals.
#[derive(Serialize)]
struct Residuals {
    /// Largest violation, scaled.
    primal: f64,
    /// Largest violation of the conditions on multipliers, scaled.
    dual: f64,
    /// Largest product of a pair, scaled.
    complementarity: f64,
    /// Gradient of the violation. Only of a point that is called infeasible.
    #[serde(skip_serializing_if = "Option::is_none")]
    violation_stationarity: Option<f64>,
}

/// Counts.
#[derive(Serialize)]
struct Iterations {
    /// Of the interior point method.
    interior_point: usize,
    /// Of crossovers.
    crossover: usize,
    /// Factorizations.
    factorizations: usize,
}

/// CPU times \[s\].
#[derive(Serialize)]
struct Seconds {
    /// All.
    total: f64,
}

impl<'a> ProgramDocument<'a> {
    /// The document of a solution that ended as `ending` tells.
    pub(crate) fn new(
        file: &'a str,
        size: ProblemSize,
        solution: &'a Solution,
        ending: &'a Ending,
    ) -> Self {
        Self {
            schema: SCHEMA,
            file,
            status: ending.status,
            diagnosis: ending.diagnosis.as_deref(),
            objective: solution.objective,
            stationarity: solution.stationarity.name(),
            second_order: solution.second_order.map(SecondOrder::name),
            residuals: Residuals {
                primal: solution.residuals.primal,
                dual: solution.residuals.dual,
                complementarity: solution.residuals.complementarity,
                violation_stationarity: solution.violation_stationarity,
            },
            size,
            iterations: Iterations {
                interior_point: solution.work.iterations,
                crossover: solution.work.crossover_iterations,
                factorizations: solution.work.factorizations,
            },
            seconds: Seconds {
                total: solution.work.seconds,
            },
            x: &solution.x,
            multipliers: &solution.multipliers,
        }
    }

    /// The document as one line of text.
    pub(crate) fn text(&self) -> String {
        to_line(self)
    }
}
