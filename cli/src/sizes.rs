//! `hangtime explain --size`: what every formulation of a scene takes.

use std::fmt::Write as _;

use hangtime::InputError;
use hangtime::ocp::{Formulation, Problem, Settings, TimeFreezingSettings, program_size};
use hangtime::rk::Scheme;
use hangtime::simulation::{
    Fesd, FormulationSize, InitialValueProblem, StepFormulation, step_sizes,
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
        let frozen = time_freezing(TimeFreezingSettings::default());
        for (name, settings) in [
            ("optimal control", Settings::default()),
            ("optimal control, time-freezing program", frozen),
        ] {
            let program = program_size(&*chosen.model, &problem, &settings);
            sizes.add(name, program.map(|own| vec![own]));
        }
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
        let rows = self.formulations.iter().map(|own| {
            let size = own.size;
            let [rows, signs] = [size.equalities, size.inequalities];
            let nonzeros = [size.jacobian_nonzeros, size.hessian_nonzeros];
            let counts = [size.variables, rows, signs, size.complementarities];
            let counts = counts.into_iter().chain(nonzeros).map(|k| k.to_string());
            let name = std::iter::once(own.formulation.clone());
            let cells = name.chain(counts).chain([own.discretization.clone()]);
            cells.collect()
        });
        let heads = "formulation variables equations inequalities pairs Jacobian Hessian grid";
        text += &described(heads.split(' '), rows);
        text += "  Jacobian, Hessian: structural nonzeros\n";
        for (name, why) in &self.refused {
            let _ = writeln!(text, "\n{name}: not for this scene: {why}");
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
            .with("formulations", &self.formulations)
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
    let mut all = vec![time_freezing(settings)];
    if published.scheme == Scheme::RadauIia {
        let mut settings = Settings::default();
        settings.stages = published.stages;
        settings.elements = published.elements;
        all.push(settings);
    }
    // What this grid is not possible for has no size on it.
    let ours = all
        .iter()
        .filter_map(|settings| program_size(&*chosen.model, &problem, settings).ok());
    Comparison {
        published,
        ours: ours.collect(),
    }
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
            .with("ours", &self.ours)
    }

    fn text(&self) -> String {
        let known = self.published;
        let mut text = format!("\npublished: {} ({})\n", known.what, known.source);
        let row = |name: &str, grid: &str, variables: usize, nonzeros: usize| {
            let mut cells = vec![format!("{name}, {grid}")];
            for (own, published) in [
                (variables, known.variables),
                (nonzeros, known.jacobian_nonzeros),
            ] {
                cells.push(own.to_string());
                let share = 100.0 * own as f64 / published as f64;
                cells.push(format!("{share:.0} %"));
            }
            cells
        };
        let (variables, nonzeros) = (known.variables, known.jacobian_nonzeros);
        let theirs = row(known.what, &known.discretization(), variables, nonzeros);
        let ours = self.ours.iter().map(|own| {
            let (variables, nonzeros) = (own.size.variables, own.size.jacobian_nonzeros);
            row(&own.formulation, &own.discretization, variables, nonzeros)
        });
        text += &table(
            ["formulation", "variables", "", "Jacobian", ""],
            std::iter::once(theirs).chain(ours),
        );
        text
    }
}
