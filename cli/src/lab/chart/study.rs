//! What is charted: a scene with its settings, and what errors are measured against.

use hangtime::simulation::{InitialValueProblem, Simulation, SimulationStatus};

use crate::Scene;
use crate::arguments::{ChartArguments, Method, MethodArguments};
use crate::bounds::Bounds;
use crate::ending::Ending;
use crate::failure::BadInput;
use crate::method::ChosenMethod;
use crate::settings::{ChosenScene, find};
use crate::table::headed;
use crate::timing::EXACT_TOLERANCE;

/// Tolerances of the finite elements that confirm the event-driven run, the tightest first.
const CONFIRMING: [f64; 3] = [EXACT_TOLERANCE, 1e-12, 1e-11];
/// Rounding error of a formula, relative to its values.
const ROUNDING: f64 = 1e-14;

/// One simulation of a scene.
pub(super) struct Study {
    pub(super) chosen: ChosenScene,
    pub(super) problem: InitialValueProblem,
    /// What is special about it, if the scene has several.
    what: Option<&'static str>,
}

impl Study {
    pub(super) fn new(
        chosen: ChosenScene,
        horizon: Option<f64>,
        what: Option<&'static str>,
    ) -> Result<Self, BadInput> {
        let model = chosen.model.as_ref();
        let problem = InitialValueProblem::of(model, horizon)
            .and_then(|problem| problem.check(model).map(|()| problem))
            .map_err(|error| chosen.refuse(&error))?;
        Ok(Self {
            chosen,
            problem,
            what,
        })
    }

    /// Name for people.
    pub(super) fn title(&self) -> String {
        let name = self.chosen.scene.name;
        self.what
            .map_or_else(|| name.to_owned(), |what| format!("{name}, {what}"))
    }

    /// The unit of all coordinates, if they have one in common.
    pub(super) fn unit(&self) -> Option<&'static str> {
        let coordinates = self.chosen.model.declaration().coordinates;
        let unit = coordinates.first()?.unit;
        let alike = coordinates.iter().all(|other| other.unit == unit);
        (alike && !unit.is_empty()).then_some(unit)
    }

    /// What an error of it is, with its unit.
    pub(super) fn error(&self) -> String {
        let words = format!(
            "largest error of a coordinate at {} s",
            self.problem.horizon
        );
        headed(&words, self.unit().unwrap_or_default())
    }

    /// Name of its files, without what comes before and after.
    pub(super) fn stem(&self) -> String {
        let fits = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        self.title().replace(", ", "-").chars().map(fits).collect()
    }
}

/// All simulations of one scene.
pub(super) struct Charted {
    pub(super) scene: &'static Scene,
    pub(super) studies: Vec<Study>,
}

/// What the arguments ask for.
pub(super) fn charted(
    scenes: &'static [Scene],
    arguments: &ChartArguments,
) -> Result<Vec<Charted>, BadInput> {
    let named: Vec<&'static Scene> = if arguments.scenes.is_empty() {
        let compiled = |scene: &&Scene| scene.unread.is_none();
        scenes.iter().filter(compiled).collect()
    } else {
        let names = arguments.scenes.iter();
        names
            .map(|name| find(scenes, name))
            .collect::<Result<_, _>>()?
    };
    if named.len() > 1 && !arguments.settings.is_empty() {
        return Err(BadInput::new(
            "--set changes the parameters of one scene; name one scene only, or leave --set out",
        ));
    }
    for (index, scene) in named.iter().enumerate() {
        if named[..index].iter().any(|other| other.name == scene.name) {
            return Err(BadInput::new(format!(
                "two scenes are called `{}`, and so would be their files; chart one of them, or rename its file",
                scene.name
            )));
        }
    }
    named
        .into_iter()
        .map(|scene| {
            Ok(Charted {
                scene,
                studies: studies(scene, arguments)?,
            })
        })
        .collect()
}

/// The simulations that a scene lists, unless the arguments say which one.
fn studies(scene: &'static Scene, arguments: &ChartArguments) -> Result<Vec<Study>, BadInput> {
    let asked = !arguments.settings.is_empty() || arguments.horizon.is_some();
    if asked || scene.charted.is_empty() {
        let chosen = ChosenScene::new(scene, &arguments.settings)?;
        return Ok(vec![Study::new(chosen, arguments.horizon, None)?]);
    }
    listed(scene)
}

/// The simulations that a scene lists for its charts.
pub(super) fn listed(scene: &'static Scene) -> Result<Vec<Study>, BadInput> {
    let listed = scene.charted.iter().map(|charted| {
        let settings: Vec<String> = charted.settings.iter().map(ToString::to_string).collect();
        let chosen = ChosenScene::new(scene, &settings)?;
        Study::new(chosen, charted.horizon, Some(charted.what))
    });
    listed.collect()
}

/// What the errors of a study are measured against.
pub(super) struct Reference {
    /// Coordinates at the end.
    pub(super) coordinates: Vec<f64>,
    /// Coordinates at the end by another method, against which event-driven runs are measured.
    pub(super) confirming: Vec<f64>,
    /// How far they may be off: rounding, or the distance of two methods.
    pub(super) uncertainty: f64,
    /// What it is, in words.
    pub(super) what: String,
}

impl Reference {
    /// The formula of the scene, or two methods at their tightest tolerances; otherwise why there is nothing to measure
    /// against, unless the run was asked to end.
    pub(super) fn of(
        study: &Study,
        bounds: &Bounds,
    ) -> Result<Result<Self, Option<String>>, BadInput> {
        let (chosen, problem) = (&study.chosen, &study.problem);
        let model = chosen.model.as_ref();
        let formula = chosen.scene.closed_form;
        if let Some(exact) = formula.and_then(|formula| formula(model, problem.horizon)) {
            return Ok(Ok(Self {
                confirming: exact.clone(),
                uncertainty: ROUNDING * size(&exact),
                coordinates: exact,
                what: "its closed form".to_owned(),
            }));
        }
        let run = |arguments: &MethodArguments| -> Result<Simulation, BadInput> {
            ChosenMethod::from_arguments(arguments)?
                .simulate(model, problem, &mut |_| bounds.asked().is_none())
                .map_err(|error| chosen.refuse(&error))
        };
        let event = run(&MethodArguments {
            method: Some(Method::Event),
            tolerance: Some(EXACT_TOLERANCE),
            ..MethodArguments::default()
        })?;
        let event_end = end(&event);
        let mut confirming = None;
        for tolerance in CONFIRMING {
            let elements = run(&MethodArguments {
                method: Some(Method::Fesd),
                tolerance: Some(tolerance),
                ..MethodArguments::default()
            })?;
            confirming = end(&elements).map(|end| (end, tolerance));
            if confirming.is_some() || bounds.asked().is_some() {
                break;
            }
        }
        Ok(match (event_end, confirming) {
            (Some(coordinates), Some((confirming, tolerance))) => Ok(Self {
                uncertainty: distance(&coordinates, &confirming).max(ROUNDING * size(&coordinates)),
                what: format!(
                    "event-driven integration at a tolerance of {EXACT_TOLERANCE:e} (event-driven runs: against finite \
                     elements at {tolerance:e})"
                ),
                coordinates,
                confirming,
            }),
            (Some(alone), None) => Ok(Self::unconfirmed(alone, "event-driven integration")),
            (None, Some((alone, _))) => Ok(Self::unconfirmed(alone, "finite elements")),
            // What asked a run to end is told once for all of them.
            (None, None) => Err(Ending::of_whole(&event)
                .line_of(chosen.scene.name, &event)
                .filter(|_| bounds.asked().is_none())),
        })
    }

    /// What only one method reaches.
    fn unconfirmed(coordinates: Vec<f64>, method: &str) -> Self {
        Self {
            confirming: coordinates.clone(),
            uncertainty: ROUNDING * size(&coordinates),
            coordinates,
            what: format!(
                "{method} at a tolerance of {EXACT_TOLERANCE:e}, which no other method confirms"
            ),
        }
    }
}

/// Coordinates and states at the end of a solved run.
pub(super) fn end(simulation: &Simulation) -> Option<Vec<f64>> {
    reached(simulation).filter(|_| simulation.status.is_solved())
}

/// Coordinates and states at the end of a run that has come to its horizon, however accurate it is.
pub(super) fn reached(simulation: &Simulation) -> Option<Vec<f64>> {
    use SimulationStatus::{Inaccurate, Solved};
    let trajectory = &simulation.trajectory;
    let there = matches!(simulation.status, Solved | Inaccurate(_));
    let (q, v) = (trajectory.q.last()?, trajectory.v.last()?);
    // A state is kept as a velocity.
    let mechanical = simulation.declaration.mechanical();
    there.then(|| [&q[..mechanical], &v[mechanical..]].concat())
}

/// Largest coordinate, at least one.
pub(super) fn size(coordinates: &[f64]) -> f64 {
    coordinates
        .iter()
        .fold(1.0_f64, |size, q| size.max(q.abs()))
}

/// Largest difference of two coordinates.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max)
}
