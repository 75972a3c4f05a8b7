//! Measured motions.

use super::builder::Builder;
use super::declared::{inferred, text, unit};
use crate::scene::Measured;

/// A measured motion that the objective compares with.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// Its name.
    pub name: String,
    /// Documentation, as written.
    pub documentation: String,
    /// The file of the measurements, as written.
    pub file: String,
    /// What was measured.
    pub quantities: Vec<MeasuredQuantity>,
    /// Kernels of its initial coordinates and velocities, if it has a start of its own.
    pub start: Option<[usize; 2]>,
    /// From how many standard deviations on a residual counts linearly; none where squares are added up.
    pub huber: Option<f64>,
}

/// Something that was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredQuantity {
    /// Its name in the file, such as `z` or `dot(z)`.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub measured: Measured,
    /// Standard deviation of a measurement, in that unit.
    pub within: f64,
}

pub(super) fn experiments(builder: &mut Builder<'_>) -> Vec<Experiment> {
    let scene = builder.scene;
    let list = scene.experiments.iter();
    list.map(|known| Experiment {
        name: known.name.text.clone(),
        documentation: text(&known.documentation),
        file: known.file.clone(),
        quantities: known
            .quantities
            .iter()
            .map(|&(measured, within)| {
                let (name, unit) = called(builder, measured);
                MeasuredQuantity {
                    name,
                    unit,
                    measured,
                    within,
                }
            })
            .collect(),
        start: known.start.as_ref().map(|(q, v)| {
            let what = |part: &str| format!("start_{part}_{}", known.name.text);
            [
                builder.unlisted(&what("coordinates"), q),
                builder.unlisted(&what("velocities"), v),
            ]
        }),
        huber: known.huber,
    })
    .collect()
}

/// Name and unit of something that was measured.
fn called(builder: &Builder<'_>, measured: Measured) -> (String, String) {
    let scene = builder.scene;
    match measured {
        Measured::Coordinate(k) => {
            let known = &scene.coordinates[k];
            (known.name.text.clone(), unit(known.unit.as_ref()))
        }
        Measured::Velocity(k) if k >= scene.mechanical() => {
            let known = &scene.states[k - scene.mechanical()];
            (known.name.text.clone(), unit(known.unit.as_ref()))
        }
        Measured::Velocity(k) => {
            let known = &scene.coordinates[k];
            let own = unit(known.unit.as_ref());
            let own = if own.is_empty() { "1" } else { &own };
            (format!("dot({})", known.name.text), format!("{own}/s"))
        }
        Measured::Output(k) => {
            let output = &scene.outputs[k];
            let unit = match &output.unit {
                Some(_) => unit(output.unit.as_ref()),
                None => inferred(output.inferred),
            };
            (output.name.text.clone(), unit)
        }
    }
}
