//! The JSON document of a program from a file.

use hangtime::nl::{SecondOrder, Solution};
use hangtime::simulation::ProblemSize;

use super::parts::{Object, SCHEMA};
use crate::ending::Ending;

/// The document of a solution of the program in a file that ended as `ending` tells: the fields that it shares with that of a scene have
/// the same names and meanings.
pub(crate) fn program_document(
    file: &str,
    size: ProblemSize,
    solution: &Solution,
    ending: &Ending,
) -> Object {
    // Largest violations, scaled; the gradient of the violation of a point that is called infeasible.
    let residuals = Object::default()
        // Largest violation, scaled.
        .with("primal", solution.residuals.primal)
        // Largest violation of the conditions on multipliers, scaled.
        .with("dual", solution.residuals.dual)
        // Largest product of a pair, scaled.
        .with("complementarity", solution.residuals.complementarity)
        // Gradient of the violation. Only of a point that is called infeasible.
        .some("violation_stationarity", solution.violation_stationarity);
    let work = &solution.work;
    let iterations = Object::default()
        // Of the interior point method.
        .with("interior_point", work.iterations)
        // Of crossovers.
        .with("crossover", work.crossover_iterations)
        // Factorizations.
        .with("factorizations", work.factorizations);
    // Second derivatives are asked of a point that is strongly stationary only.
    Object::default()
        // Version of the layout of the document.
        .with("schema", SCHEMA)
        // The file.
        .with("file", file)
        // How the run ended.
        .with("status", ending.status)
        // Where and why it ended early.
        .some("diagnosis", ending.diagnosis.as_deref())
        // The objective.
        .with("objective", solution.objective)
        // The certificate.
        .with("stationarity", solution.stationarity.name())
        // What second derivatives say. Only of a point that is strongly stationary.
        .some("second_order", solution.second_order.map(SecondOrder::name))
        // How well the conditions hold.
        .with("residuals", residuals)
        // Size of the largest system or program.
        .with("size", size)
        // What the run took, counted.
        .with("iterations", iterations)
        // CPU time \[s\].
        .with("seconds", Object::default().with("total", work.seconds))
        // Values of the variables, in the order of the file.
        .with("x", &solution.x)
        // Multipliers of the rows.
        .with("multipliers", &solution.multipliers)
}
