//! `hangtime explain --size`: what every formulation of a scene takes, and what each part of it is there for.

use std::fmt::Write as _;

use hangtime::InputError;
use hangtime::ocp::{Formulation, Problem, Settings, TimeFreezingSettings, program_sizes};
use hangtime::rk::Scheme;
use hangtime::simulation::{
    Fesd, FormulationSize, InitialValueProblem, ProblemSize, StepFormulation, step_sizes,
};

use crate::json::{Object, SCHEMA};
use crate::published::PublishedSize;
use crate::settings::ChosenScene;
use crate::table::{described, table};

/// Control intervals of the default discretization, as in `solve`.
const INTERVALS: usize = 30;

/// All sizes of a scene.
pub(crate) struct Sizes {
    formulations: Vec<FormulationSize>,
    /// Formulations that do not take the scene, and why.
    refused: Vec<(&'static str, String)>,
    comparisons: Vec<Comparison>,
}

/// A published size and the sizes of this library on the same grid.
struct Comparison {
    published: &'static PublishedSize,
    ours: Vec<FormulationSize>,
}

impl Sizes {
    /// Makes the systems and programs of a scene, and solves none.
    pub(crate) fn of(chosen: &ChosenScene) -> Self {
        let mut sizes = Self {
            formulations: Vec::new(),
            refused: Vec::new(),
            comparisons: Vec::new(),
        };
        for (name, formulation) in [
            ("simulation", StepFormulation::ActiveSet),
            ("simulation, time-freezing", StepFormulation::TimeFreezing),
        ] {
            sizes.add(name, simulated(chosen, formulation));
        }
        if chosen.model.declaration().optimal_control.is_none() {
            return sizes;
        }
        let problem = Problem::of(&*chosen.model, INTERVALS);
        let phases = program_sizes(&*chosen.model, &problem, &Settings::default());
        sizes.add("optimal control", phases);
        let settings = time_freezing(TimeFreezingSettings::default());
        let program = program_sizes(&*chosen.model, &problem, &settings);
        sizes.add("optimal control, time-freezing program", program);
        let published = chosen.scene.published_sizes.iter();
        sizes.comparisons = published.map(|known| compare(chosen, known)).collect();
        sizes
    }

    fn add(&mut self, name: &'static str, found: Result<Vec<FormulationSize>, InputError>) {
        match found {
            Ok(found) => self.formulations.extend(found),
            Err(error) => self.refused.push((name, error.to_string())),
        }
    }

    /// The sizes for people.
    pub(crate) fn text(&self) -> String {
        let mut text = String::from(
            "sizes as the solvers see them (fixed variables and rows without bounds are left out)\n\n",
        );
        let rows = self.formulations.iter().map(|formulation| {
            let mut row = vec![formulation.formulation.clone()];
            row.extend(numbers(formulation.size()));
            row
        });
        text += &table(
            [
                "formulation",
                "variables",
                "equations",
                "inequalities",
                "pairs",
                "Jacobian",
                "Hessian",
            ],
            rows,
        );
        text += "  Jacobian, Hessian: structural nonzeros\n";
        for (name, why) in &self.refused {
            let _ = writeln!(text, "\n{name}: not for this scene: {why}");
        }
        for formulation in &self.formulations {
            let (name, grid) = (&formulation.formulation, &formulation.discretization);
            let _ = writeln!(text, "\n{name} ({grid})");
            let rows = formulation.groups.iter().map(|group| {
                let mut row = vec![group.name.to_owned()];
                row.extend(numbers(group.size));
                row.push(group.why.to_owned());
                row
            });
            text += &described(
                [
                    "group",
                    "variables",
                    "equations",
                    "inequalities",
                    "pairs",
                    "Jacobian",
                    "Hessian",
                    "what for",
                ],
                rows,
            );
        }
        for comparison in &self.comparisons {
            text += &comparison.text();
        }
        text
    }

    /// The sizes as one JSON object.
    pub(crate) fn json(&self, chosen: &ChosenScene) -> String {
        let refused = self.refused.iter().map(|(formulation, why)| {
            let object = Object::default().with("formulation", formulation);
            object.with("why", why)
        });
        let published = self.comparisons.iter().map(Comparison::json);
        Object::default()
            .with("schema", SCHEMA)
            .with("scene", chosen.scene.name)
            .with("formulations", formulations(&self.formulations))
            .with("refused", refused.collect::<Vec<_>>())
            .with("published", published.collect::<Vec<_>>())
            .text()
    }
}

fn simulated(
    chosen: &ChosenScene,
    formulation: StepFormulation,
) -> Result<Vec<FormulationSize>, InputError> {
    let model = chosen.model.as_ref();
    // Sizes do not depend on the length of the motion, which a scene may leave open.
    let horizon = model.horizon().unwrap_or(1.0);
    let problem = InitialValueProblem::of(model, Some(horizon))?;
    step_sizes(
        model,
        &problem,
        &Fesd::default().with_formulation(formulation),
    )
}

fn time_freezing(settings: TimeFreezingSettings) -> Settings {
    let mut all = Settings::default();
    all.formulation = Formulation::TimeFreezing(settings);
    all
}

/// The formulations of this library on the grid of a published size.
fn compare(chosen: &ChosenScene, published: &'static PublishedSize) -> Comparison {
    let problem = Problem::of(&*chosen.model, published.intervals);
    let mut settings = TimeFreezingSettings::default();
    settings.scheme = published.scheme;
    settings.stages = published.stages;
    settings.elements = published.elements;
    let mut ours = Vec::new();
    let mut add = |settings: &Settings| {
        // What this grid is not possible for has no size on it.
        let found = program_sizes(&*chosen.model, &problem, settings);
        ours.extend(found.unwrap_or_default());
    };
    add(&time_freezing(settings));
    if published.scheme == Scheme::RadauIia {
        let mut settings = Settings::default();
        settings.stages = published.stages;
        settings.elements = published.elements;
        add(&settings);
    }
    Comparison { published, ours }
}

impl Comparison {
    fn json(&self) -> Object {
        let known = self.published;
        Object::default()
            .with("what", known.what)
            .with("source", known.source)
            .with("discretization", known.discretization())
            .with("variables", known.variables)
            .with("constraints", known.constraints)
            .with("jacobian_nonzeros", known.jacobian_nonzeros)
            .with("hessian_nonzeros", known.hessian_nonzeros)
            .with("ours", formulations(&self.ours))
    }

    fn text(&self) -> String {
        let known = self.published;
        let mut text = format!("\npublished: {} ({})\n", known.what, known.source);
        let share = |own: usize, published: usize| {
            format!("{:.0} %", 100.0 * own as f64 / published as f64)
        };
        let theirs = vec![
            format!("{}, {}", known.what, known.discretization()),
            known.variables.to_string(),
            "100 %".to_owned(),
            known.jacobian_nonzeros.to_string(),
            "100 %".to_owned(),
        ];
        let ours = self.ours.iter().map(|own| {
            let size = own.size();
            vec![
                format!("{}, {}", own.formulation, own.discretization),
                size.variables.to_string(),
                share(size.variables, known.variables),
                size.jacobian_nonzeros.to_string(),
                share(size.jacobian_nonzeros, known.jacobian_nonzeros),
            ]
        });
        text += &table(
            ["formulation", "variables", "", "Jacobian", ""],
            std::iter::once(theirs).chain(ours),
        );
        text
    }
}

/// The numbers of a size in the order of the tables.
fn numbers(size: ProblemSize) -> [String; 6] {
    [
        size.variables,
        size.equalities,
        size.inequalities,
        size.complementarities,
        size.jacobian_nonzeros,
        size.hessian_nonzeros,
    ]
    .map(|number| number.to_string())
}

/// The entries of formulations, with what each group of variables and equations is there for.
fn formulations(list: &[FormulationSize]) -> Vec<Object> {
    let entry = |known: &FormulationSize| {
        let groups = known.groups.iter().map(|group| {
            let object = Object::default().with("group", group.name);
            object.with("why", group.why).with("size", group.size)
        });
        Object::default()
            .with("formulation", &known.formulation)
            .with("discretization", &known.discretization)
            .with("size", known.size())
            .with("groups", groups.collect::<Vec<_>>())
    };
    list.iter().map(entry).collect()
}
