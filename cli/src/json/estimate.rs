//! The JSON document of an estimation.

use hangtime::estimation::{Direction, Estimate, EstimatedParameter, FittedExperiment};
use hangtime::model::Declaration;

use super::parts::{Motion, Object, begun, event, found};
use crate::ending::Ending;
use crate::settings::ChosenScene;

/// The document of an estimate of `chosen` that ended as `ending` tells: the motion of its first experiment, with at most `rows` rows of
/// its trajectory, and what belongs to the estimate.
pub(crate) fn estimate_document(
    chosen: &ChosenScene,
    estimate: &Estimate,
    ending: &Ending,
    rows: usize,
) -> Object {
    let simulation = estimate.experiments.first().map(|known| &known.motion);
    let motion = Motion::new(chosen, simulation, rows);
    let parameters = &estimate.parameters;
    let horizon = simulation.and_then(|known| known.trajectory.time.last());
    let directions = estimate.undetermined.iter();
    let directions = directions.map(|known| direction(known, parameters));
    let declaration = chosen.model.declaration();
    let experiments = estimate.experiments.iter();
    let experiments = experiments.map(|fitted| experiment(fitted, declaration));
    let free = parameters.iter().fold(Object::default(), |free, known| {
        free.with(known.name, parameter(known))
    });
    let iterations = Object::default()
        // Steps of Levenberg and Marquardt.
        .with("steps", estimate.steps)
        // Simulations.
        .with("simulations", estimate.simulations);
    let begin = begun(chosen)
        // The parameters that were found, by name.
        .with("free", free)
        // Length of the motion \[s\].
        .with("horizon", horizon);
    let document = motion
        .told(begin, ending, ending.diagnosis.as_deref())
        // The misfit.
        .with("objective", estimate.misfit)
        // How many numbers were measured.
        .with("measurements", estimate.measurements)
        // Root mean square of the residuals with the degrees of freedom that are left: about 1 where deviations are declared as they are.
        .with("spread", estimate.spread())
        // Distance from the optimum of the linear problem there, in standard deviations of what was found.
        .with("distance", estimate.distance)
        // What the measurements tell of the parameters.
        .with("knowledge", knowledge(estimate))
        // Directions in which they tell nothing.
        .with("undetermined", directions.collect::<Vec<_>>())
        // Measurements beside the motion that was found.
        .with("experiments", experiments.collect::<Vec<_>>())
        // From how many values it was looked for.
        .with("starts", estimate.starts)
        // Where the searches ended, best first.
        .with("optima", &estimate.optima)
        // What the run took, counted.
        .with("iterations", iterations)
        // CPU time \[s\].
        .with("seconds", Object::default().with("total", estimate.seconds));
    motion.ended(document, estimate.notes.iter().cloned(), None)
}

/// A parameter that was found: its deviation is null where the measurements do not determine it, and at a bound; the last is the derivative
/// of the misfit by it.
fn parameter(known: &EstimatedParameter) -> Object {
    let end = match known.value <= known.range.0 {
        true => "lower",
        false => "upper",
    };
    let value = (known.value, known.unit);
    let found = found(
        value,
        Some(known.deviation),
        known.range,
        known.at_bound.then_some(end),
    );
    // Derivative of the misfit by it.
    found.with("gradient", known.gradient)
}

/// Two symmetric matrices over the parameters.
fn knowledge(estimate: &Estimate) -> Object {
    let names = estimate.parameters.iter().map(|known| known.name);
    let count = 0..estimate.parameters.len();
    let row = |i| count.clone().map(|j| estimate.correlation(i, j)).collect();
    let correlation: Vec<Vec<f64>> = count.clone().map(row).collect();
    Object::default()
        // Names of rows and columns.
        .with("parameters", names.collect::<Vec<_>>())
        // Covariance.
        .with("covariance", &estimate.covariance)
        // Correlation.
        .with("correlation", correlation)
}

/// A direction in which nothing is determined: in words, and the parameters that change along it by how much.
fn direction(direction: &Direction, parameters: &[EstimatedParameter]) -> Object {
    let changes = direction.changes.iter();
    let names = changes.clone().map(|&(j, _)| parameters[j].name);
    let by = changes.map(|&(_, change)| change);
    Object::default()
        // The direction in words.
        .with("text", &direction.text)
        // The parameters that change along it.
        .with("parameters", names.collect::<Vec<_>>())
        // By how much.
        .with("changes", by.collect::<Vec<_>>())
}

/// One experiment beside its motion: the file of its measurements, null where the scene has them itself, when something was measured
/// \[s\], and by quantity what was measured, null where nothing was, with the motion that was found and their difference in standard
/// deviations.
fn experiment(fitted: &FittedExperiment, declaration: &Declaration) -> Object {
    let column = |rows: &[Vec<f64>], k: usize| rows.iter().map(|row| row[k]).collect::<Vec<_>>();
    let quantities = fitted.declared.quantities.iter().enumerate();
    let quantities = quantities.map(|(k, quantity)| {
        Object::default()
            // Name of the experiment.
            .with("name", quantity.name)
            // Its unit.
            .with("unit", quantity.unit)
            // Standard deviation of a measurement.
            .with("within", quantity.within)
            // Measured values. Null where nothing was measured.
            .with("measured", column(&fitted.measured, k))
            // Values of the motion that was found.
            .with("computed", column(&fitted.computed, k))
            // Their difference, in standard deviations.
            .with("residuals", fitted.residuals(k))
    });
    let file = match fitted.declared.table() {
        Some(_) => None,
        None => Some(fitted.declared.file),
    };
    let events = fitted.motion.events.iter();
    let events = events.map(|known| event(known, declaration));
    Object::default()
        // Name of the experiment.
        .with("name", fitted.declared.name)
        // File of its measurements. Null where the scene has them itself.
        .with("file", file)
        // When something was measured \[s\].
        .with("time", &fitted.times)
        // What was measured.
        .with("quantities", quantities.collect::<Vec<_>>())
        // What happens in the motion that was found.
        .with("events", events.collect::<Vec<_>>())
}
