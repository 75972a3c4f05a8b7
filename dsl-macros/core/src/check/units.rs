//! E03: both sides of every sum, comparison and declaration have the same unit.
//!
//! Seven exponents are propagated through every expression; units that are not declared are inferred.
//! Bare numbers are dimensionless, except 0, which fits anywhere, and except where a declaration gives
//! the unit (`m: kg = 80`). A scene that declares no unit at all is not checked.

mod angle;
mod shown;
mod statement;
mod walk;

use crate::ast::{Scene, Statement};
use crate::diagnostics::{Checked, Diagnostics};
use crate::dimension::{Dimension, Unifier};
use hangtime_units::Unit;
use std::collections::{HashMap, HashSet};
use walk::{Shown, Walk};

/// Units of gaps and of the functions of conditions, as far as they are known.
#[derive(Default)]
pub(super) struct Inferred {
    pub(super) gaps: HashMap<String, Unit>,
    pub(super) constraints: Vec<Option<Unit>>,
    pub(super) goals: Vec<Option<Unit>>,
    /// Of the outputs, as far as they are known.
    pub(super) outputs: Vec<Option<Unit>>,
    /// Whether the Lagrangian, and what it may be made of, have units that agree.
    pub(super) energy: bool,
    /// Surfaces, and coordinates with a start value, whose units differ.
    pub(super) faulty: HashSet<String>,
}

impl Inferred {
    /// A gap with its unit, for people.
    pub(super) fn gap(&self, surface: &str, value: f64) -> String {
        let unit = self.gaps.get(surface).map(Unit::to_string);
        match unit.filter(|unit| unit != "1") {
            Some(unit) => format!("{} {unit}", rounded(value)),
            None => rounded(value).to_string(),
        }
    }
}

/// To four digits behind the point, or to the leading one.
pub(super) fn rounded(value: f64) -> f64 {
    let scale = if value.abs() < 1e-3 { 1e9 } else { 1e4 };
    (value * scale).round() / scale
}

/// Checks and infers units. Statements at the positions `skip` failed before and are passed over; the joints called
/// `rolling` are equations between velocities.
pub(super) fn inferred(
    scene: &Scene,
    (skip, rolling): (&HashSet<usize>, HashSet<String>),
    diagnostics: &mut Diagnostics,
) -> Inferred {
    if !declares_units(scene) {
        return Inferred {
            energy: true,
            ..Inferred::default()
        };
    }
    let mut walk = walk(scene, rolling, diagnostics);
    let mut sound = true;
    statement::declare(&mut walk, scene);
    for (index, statement) in scene.statements.iter().enumerate() {
        if skip.contains(&index) {
            continue;
        }
        // Reported where it fails; the next statement is checked all the same.
        let before = walk.diagnostics.mistakes();
        let _: Checked<()> = statement::statement(&mut walk, statement);
        let energy = matches!(
            statement,
            Statement::Lagrangian { .. } | Statement::Let { .. } | Statement::Function { .. }
        );
        sound &= !energy || walk.diagnostics.mistakes() == before;
    }
    statement::measured(&mut walk, scene);
    statement::sliding_velocities(&mut walk);
    angle::arguments(&mut walk);
    let Walk {
        unifier,
        gaps,
        constraints,
        goals,
        shown,
        faulty,
        ..
    } = walk;
    let known = |conditions: Vec<Dimension>| {
        let dimensions = conditions.iter();
        dimensions
            .map(|dimension| unifier.known(dimension))
            .collect()
    };
    Inferred {
        energy: sound,
        faulty,
        constraints: known(constraints),
        goals: known(goals),
        outputs: known(shown.outputs),
        gaps: gaps
            .into_iter()
            .filter_map(|(name, dimension)| Some((name, unifier.known(&dimension)?)))
            .collect(),
    }
}

/// A walk that has not begun.
fn walk<'a>(scene: &Scene, rolling: HashSet<String>, diagnostics: &'a mut Diagnostics) -> Walk<'a> {
    let mut unifier = Unifier::default();
    let energy = unifier.unknown("lagrangian");
    Walk {
        diagnostics,
        unifier,
        values: HashMap::new(),
        functions: HashMap::new(),
        frames: Vec::new(),
        visited: 0,
        coordinates: Vec::new(),
        energy,
        called: scene.name.place(),
        gaps: Vec::new(),
        sliding: Vec::new(),
        constraints: Vec::new(),
        goals: Vec::new(),
        shown: Shown::default(),
        faulty: HashSet::new(),
        angles: Vec::new(),
        radians: HashSet::new(),
        joints: Vec::new(),
        rolling,
    }
}

fn declares_units(scene: &Scene) -> bool {
    scene.statements.iter().any(|statement| match statement {
        Statement::Parameters(list)
        | Statement::Coordinates(list)
        | Statement::Controls(list)
        | Statement::States(list) => list.iter().any(|quantity| quantity.unit.is_some()),
        _ => false,
    })
}
