//! Measured motions.

use super::builder::Builder;
use super::declared::unit;
use super::shown::output_unit;
use crate::declaration::{Experiment, Measured, MeasuredQuantity, list, text};

/// The kernels of the initial coordinates and velocities of a motion that has a start of its own.
type OwnStart = Option<(usize, usize)>;

/// What is declared of measured motions, and kernels of the starts of those that have one of their own.
pub(super) fn experiments(
    builder: &mut Builder<'_>,
) -> (&'static [Experiment], &'static [OwnStart]) {
    let scene = builder.scene;
    let declared = list(scene.experiments.iter().map(|known| Experiment {
        name: text(&known.name.text),
        documentation: text(&known.documentation),
        file: text(&known.file),
        quantities: list(known.quantities.iter().map(|&(measured, within)| {
            let (name, unit) = called(builder, measured);
            MeasuredQuantity {
                name: text(&name),
                unit,
                measured,
                within,
            }
        })),
        huber: known.huber,
        own_start: known.start.is_some(),
    }));
    let starts = scene.experiments.iter().map(|known| {
        let (q, v) = known.start.as_ref()?;
        let what = |part: &str| format!("start_{part}_{}", known.name.text);
        Some((
            builder.unlisted(&what("coordinates"), q),
            builder.unlisted(&what("velocities"), v),
        ))
    });
    (declared, list(starts))
}

/// Name and unit of something that was measured.
fn called(builder: &Builder<'_>, measured: Measured) -> (String, &'static str) {
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
            let own = if own.is_empty() { "1" } else { own };
            (
                format!("dot({})", known.name.text),
                text(&format!("{own}/s")),
            )
        }
        Measured::Output(k) => {
            let output = &scene.outputs[k];
            (output.name.text.clone(), output_unit(output))
        }
    }
}
