//! The methods of a chart, each over its range of settings.

use crate::arguments::{FormulationName, Method, MethodArguments, SchemeName};
use crate::figure::Look;

/// Steps of the methods of high order.
const FINITE_ELEMENTS: [usize; 14] = [10, 12, 15, 20, 26, 32, 40, 52, 64, 80, 120, 160, 240, 320];
/// Steps of the methods of low order.
const TIME_STEPS: [usize; 7] = [50, 100, 200, 400, 1600, 6400, 25600];
/// Widths of the smoothed step functions.
const WIDTHS: [f64; 5] = [1e-1, 3e-2, 1e-2, 3e-3, 1e-3];
/// Tolerance of a smoothed run, as a share of its width: the width is what its error comes from.
const SMOOTHED_TOLERANCE: f64 = 1e-3;
/// Tolerances of the methods that control their steps.
const TOLERANCES: [f64; 6] = [1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12];

/// One method over its range of settings, from coarse to fine.
pub(super) struct Sweep {
    /// Name in tables and at lines.
    pub(super) name: String,
    /// How its line looks: the colour of its method, and a mark of its own.
    pub(super) look: Look,
    /// Whether it is on the chart that a page opens with.
    pub(super) charted: bool,
    /// The figure of the schemes in which it appears.
    pub(super) group: Group,
    /// Whether it appears where families of methods are compared.
    pub(super) compared: bool,
    /// The order that theory gives.
    pub(super) theory: String,
    pub(super) settings: Vec<MethodArguments>,
}

impl Sweep {
    /// Whether the runs differ in their step size, and not in a tolerance.
    pub(super) fn stepped(&self) -> bool {
        let tolerance = |settings: &MethodArguments| settings.tolerance.is_some();
        self.group != Group::Peers && !self.settings.iter().any(tolerance)
    }

    /// Whether the error is expected to follow a power of what the runs differ in.
    pub(super) fn ordered(&self) -> bool {
        let width = |settings: &MethodArguments| settings.width.is_some();
        self.stepped() || self.settings.iter().all(width)
    }

    /// Whether these are event-driven runs, which have to be measured against something else.
    pub(super) fn event_driven(&self) -> bool {
        let event = |settings: &MethodArguments| settings.method == Some(Method::Event);
        self.settings.iter().any(event)
    }
}

/// The finest points whose slope is an order: enough to cover some steps that end near switches, and some that do not.
pub(super) const SLOPE_POINTS: usize = 5;

/// The figure in which a sweep appears beside its likes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    Radau,
    Gauss,
    TimeFreezing,
    Others,
    /// Other programs.
    Peers,
}

/// The name under which the finite elements with error control are compared.
pub(super) const CONTROLLED: &str = "finite elements (default)";
/// The name of the event-driven runs.
pub(super) const EVENT_DRIVEN: &str = "event-driven";
/// The names of the scheme whose order every scene shows, in both formulations.
pub(super) const SHOWN: [&str; 2] = ["Radau-3", "time-freezing Radau-3"];

/// All of them.
pub(super) fn sweeps() -> Vec<Sweep> {
    let mut sweeps = finite_elements();
    sweeps.extend(time_freezing());
    sweeps.extend(controlled());
    sweeps.extend(others());
    sweeps
}

/// A grid of finite elements.
fn grid(scheme: SchemeName, stages: usize, steps: usize) -> MethodArguments {
    MethodArguments {
        scheme: Some(scheme),
        stages: Some(stages),
        steps: Some(steps),
        elements: Some(1),
        ..MethodArguments::default()
    }
}

/// Finite elements of equal length, by scheme, stages and exit condition.
fn finite_elements() -> Vec<Sweep> {
    let mut sweeps = Vec::new();
    for (scheme, group, title) in [
        (SchemeName::RadauIia, Group::Radau, "Radau"),
        (SchemeName::GaussLegendre, Group::Gauss, "Gauss"),
    ] {
        for no_exit_condition in [false, true] {
            for stages in 1..=4 {
                let exit = if no_exit_condition { ", no exit" } else { "" };
                let radau = group == Group::Radau;
                let theory = match (no_exit_condition, radau) {
                    (true, _) => "at most 2".to_owned(),
                    (false, true) => (2 * stages - 1).to_string(),
                    (false, false) => format!("at most {}", 2 * stages),
                };
                let settings = FINITE_ELEMENTS.iter().map(|&steps| MethodArguments {
                    no_exit_condition,
                    ..grid(scheme, stages, steps)
                });
                let look = Look::of(title).variant(stages - 1);
                sweeps.push(Sweep {
                    name: format!("{title}-{stages}{exit}"),
                    look: if no_exit_condition {
                        look.dashed()
                    } else {
                        look
                    },
                    charted: false,
                    group,
                    compared: radau && stages > 1 && !no_exit_condition,
                    theory,
                    settings: settings.collect(),
                });
            }
        }
    }
    sweeps
}

/// The time-freezing system, region by region with switches located.
fn time_freezing() -> Vec<Sweep> {
    let mut sweeps = Vec::new();
    for stages in 1..=4 {
        let settings = FINITE_ELEMENTS.iter().map(|&steps| MethodArguments {
            formulation: Some(FormulationName::TimeFreezing),
            ..grid(SchemeName::RadauIia, stages, steps)
        });
        let name = format!("time-freezing Radau-{stages}");
        sweeps.push(Sweep {
            look: Look::of(&name).variant(stages - 1),
            name,
            charted: false,
            group: Group::TimeFreezing,
            compared: stages == 3,
            theory: (2 * stages - 1).to_string(),
            settings: settings.collect(),
        });
    }
    sweeps
}

/// The methods that control their error.
fn controlled() -> Vec<Sweep> {
    let finite_elements = |formulation| MethodArguments {
        stages: Some(6),
        steps: Some(5),
        formulation: Some(formulation),
        ..MethodArguments::default()
    };
    let controlled = [
        (CONTROLLED, finite_elements(FormulationName::ActiveSet)),
        (
            "time-freezing, controlled",
            finite_elements(FormulationName::TimeFreezing),
        ),
        (
            EVENT_DRIVEN,
            MethodArguments {
                method: Some(Method::Event),
                ..MethodArguments::default()
            },
        ),
    ];
    let sweeps = controlled.into_iter().map(|(name, arguments)| {
        let with_tolerance = |&tolerance| MethodArguments {
            tolerance: Some(tolerance),
            ..arguments.clone()
        };
        Sweep {
            name: name.to_owned(),
            look: Look::of(name),
            charted: true,
            group: Group::Others,
            compared: true,
            theory: "-".to_owned(),
            settings: TOLERANCES.iter().map(with_tolerance).collect(),
        }
    });
    sweeps.collect()
}

/// The methods to compare with.
fn others() -> Vec<Sweep> {
    let mut sweeps = Vec::new();
    for (method, name) in [
        (Method::Moreau, "Moreau-Jean"),
        (Method::Fixed, "fixed steps"),
    ] {
        let with_steps = |&steps| MethodArguments {
            method: Some(method),
            steps: Some(steps),
            ..MethodArguments::default()
        };
        sweeps.push(Sweep {
            name: name.to_owned(),
            look: Look::of(name),
            charted: true,
            group: Group::Others,
            compared: true,
            theory: "1 through switches".to_owned(),
            settings: TIME_STEPS.iter().map(with_steps).collect(),
        });
    }
    let with_width = |&width: &f64| MethodArguments {
        method: Some(Method::Smooth),
        width: Some(width),
        tolerance: Some(width * SMOOTHED_TOLERANCE),
        ..MethodArguments::default()
    };
    sweeps.push(Sweep {
        name: "smoothed".to_owned(),
        look: Look::of("smoothed"),
        charted: true,
        group: Group::Others,
        compared: true,
        theory: "1".to_owned(),
        settings: WIDTHS.iter().map(with_width).collect(),
    });
    sweeps
}
