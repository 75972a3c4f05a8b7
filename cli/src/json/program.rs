//! The JSON document of a program from a file.

use hangtime::nl::{SecondOrder, Solution};
use hangtime::simulation::ProblemSize;
use serde::Serialize;

use super::parts::{SCHEMA, SizeEntry, to_line};
use crate::ending::Ending;

/// The document of a program: the fields that it shares with that of a scene have the same names and meanings.
#[derive(Serialize)]
pub(crate) struct ProgramDocument<'a> {
    schema: u32,
    file: &'a str,
    status: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    diagnosis: Option<&'a str>,
    objective: f64,
    stationarity: &'static str,
    /// Of a point that is strongly stationary.
    #[serde(skip_serializing_if = "Option::is_none")]
    second_order: Option<&'static str>,
    residuals: Residuals,
    #[serde(with = "SizeEntry")]
    size: ProblemSize,
    iterations: Iterations,
    seconds: Seconds,
    /// In the order of the file.
    x: &'a [f64],
    multipliers: &'a [f64],
}

#[derive(Serialize)]
struct Residuals {
    primal: f64,
    dual: f64,
    complementarity: f64,
    /// Of a point that is called infeasible.
    #[serde(skip_serializing_if = "Option::is_none")]
    violation_stationarity: Option<f64>,
}

#[derive(Serialize)]
struct Iterations {
    interior_point: usize,
    crossover: usize,
    factorizations: usize,
}

#[derive(Serialize)]
struct Seconds {
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
