//! The methods of a chart, each over its range of settings.

use crate::arguments::{Method, MethodArguments, SchemeName};

/// Steps of the methods of high order.
const FINITE_ELEMENTS: [usize; 8] = [10, 15, 20, 30, 40, 80, 160, 320];
/// Steps of the methods of low order.
const TIME_STEPS: [usize; 7] = [50, 100, 200, 400, 1600, 6400, 25600];
/// Widths of the smoothed step functions.
const WIDTHS: [f64; 5] = [1e-1, 3e-2, 1e-2, 3e-3, 1e-3];
/// Tolerance of a smoothed run, as a share of its width: the width is what its error comes from.
const SMOOTHED_TOLERANCE: f64 = 1e-3;
/// Tolerances of the methods that control their steps.
const TOLERANCES: [f64; 6] = [1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12];
/// One method over its range of settings.
pub(super) struct Sweep {
    /// Name in tables and legends.
    pub(super) name: String,
    pub(super) colour: usize,
    pub(super) dashed: bool,
    pub(super) group: Group,
    pub(super) settings: Vec<MethodArguments>,
}

impl Sweep {
    /// Whether the runs differ in their step size, and not in a tolerance.
    pub(super) fn stepped(&self) -> bool {
        let tolerance = |settings: &MethodArguments| settings.tolerance.is_some();
        !self.settings.iter().any(tolerance)
    }

    /// Whether the error is expected to follow a power of what the runs differ in.
    pub(super) fn ordered(&self) -> bool {
        let width = |settings: &MethodArguments| settings.width.is_some();
        self.stepped() || self.settings.iter().all(width)
    }
}

/// The figure in which a sweep appears beside its likes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    Radau,
    Gauss,
    Others,
}

/// All of them.
pub(super) fn sweeps() -> Vec<Sweep> {
    let mut sweeps = finite_elements();
    sweeps.extend(controlled());
    sweeps.extend(others());
    sweeps
}

/// Finite elements of equal length, by scheme, stages and exit condition.
fn finite_elements() -> Vec<Sweep> {
    let mut sweeps = Vec::new();
    for (scheme, group, title) in [
        (SchemeName::RadauIia, Group::Radau, "FESD Radau"),
        (SchemeName::GaussLegendre, Group::Gauss, "FESD Gauss"),
    ] {
        for no_exit_condition in [false, true] {
            for stages in 1..=4 {
                let exit = if no_exit_condition { ", no exit" } else { "" };
                sweeps.push(Sweep {
                    name: format!("{title}-{stages}{exit}"),
                    colour: stages - 1,
                    dashed: no_exit_condition,
                    group,
                    settings: FINITE_ELEMENTS
                        .iter()
                        .map(|&steps| MethodArguments {
                            scheme: Some(scheme),
                            stages: Some(stages),
                            steps: Some(steps),
                            elements: Some(1),
                            no_exit_condition,
                            ..MethodArguments::default()
                        })
                        .collect(),
                });
            }
        }
    }
    sweeps
}

/// The methods that control their error.
fn controlled() -> Vec<Sweep> {
    let mut sweeps = Vec::new();
    let controlled = [
        (
            "FESD Radau-6, controlled",
            MethodArguments {
                stages: Some(6),
                steps: Some(5),
                ..MethodArguments::default()
            },
        ),
        (
            "event-driven",
            MethodArguments {
                method: Method::Event,
                ..MethodArguments::default()
            },
        ),
    ];
    for (colour, (name, arguments)) in controlled.into_iter().enumerate() {
        let with_tolerance = |&tolerance| MethodArguments {
            tolerance: Some(tolerance),
            ..arguments.clone()
        };
        sweeps.push(Sweep {
            name: name.to_owned(),
            colour: 4 + colour,
            dashed: false,
            group: Group::Others,
            settings: TOLERANCES.iter().map(with_tolerance).collect(),
        });
    }
    sweeps
}

/// The methods to compare with.
fn others() -> Vec<Sweep> {
    let mut sweeps = Vec::new();
    for (colour, method, name) in [
        (6, Method::Moreau, "Moreau-Jean"),
        (7, Method::Fixed, "fixed steps"),
    ] {
        let with_steps = |&steps| MethodArguments {
            method,
            steps: Some(steps),
            ..MethodArguments::default()
        };
        sweeps.push(Sweep {
            name: name.to_owned(),
            colour,
            dashed: false,
            group: Group::Others,
            settings: TIME_STEPS.iter().map(with_steps).collect(),
        });
    }
    let with_width = |&width: &f64| MethodArguments {
        method: Method::Smooth,
        width: Some(width),
        tolerance: Some(width * SMOOTHED_TOLERANCE),
        ..MethodArguments::default()
    };
    sweeps.push(Sweep {
        name: "smoothed".to_owned(),
        colour: 8,
        dashed: false,
        group: Group::Others,
        settings: WIDTHS.iter().map(with_width).collect(),
    });
    sweeps
}
