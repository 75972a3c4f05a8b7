//! The declaration as a whole: names in force, every expression evaluated, the rules of the language.

mod dependence;
mod law;
mod names;
mod optimal_control;
mod rules;
mod start;
mod units;
mod values;

pub(crate) use law::normal;
pub(crate) use start::at_start;

use crate::ast::{Assignment, Documentation, Expr, Name, Relation, Scene, Statement};
use crate::diagnostics::{Checked, Diagnostics, Reported};
use crate::evaluate::{Meaning, Scope, UserFunction};
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{self, CheckedScene, Coordinate, Parameter};
use std::collections::HashSet;
use std::rc::Rc;

/// Checks a declaration. Every mistake found is reported; a scene comes back only if there was none.
pub(crate) fn scene(declared: &Scene, diagnostics: &mut Diagnostics) -> Checked<CheckedScene> {
    let before = diagnostics.grave();
    let mut checker = Checker {
        scope: Scope::default(),
        diagnostics,
        parameters: Vec::new(),
        coordinates: Vec::new(),
        controls: Vec::new(),
        abbreviations: Vec::new(),
        lagrangian: None,
        dissipation: None,
        forces: Vec::new(),
        surfaces: Vec::new(),
        impacts: Vec::new(),
        start: Vec::new(),
        horizon: None,
        task: optimal_control::Task::default(),
    };
    checker.declare_all(&declared.statements);
    let mut failed = HashSet::new();
    for (index, statement) in declared.statements.iter().enumerate() {
        // Each statement reports its own mistakes; the next one is checked all the same.
        if checker.statement(statement).is_err() {
            failed.insert(index);
        }
    }
    let units = units::inferred(declared, &failed, checker.diagnostics);
    let scene = checker.finish(declared, &units);
    if diagnostics.grave() > before {
        return Err(Reported);
    }
    scene
}

/// A surface before its law is known.
struct Surface {
    documentation: Documentation,
    name: Name,
    gap: Sym,
}

/// A sum of which parts are used by name.
struct Abbreviation {
    name: Name,
    what: &'static str,
}

struct Checker<'a> {
    scope: Scope,
    diagnostics: &'a mut Diagnostics,
    parameters: Vec<Parameter>,
    coordinates: Vec<Coordinate>,
    controls: Vec<Coordinate>,
    abbreviations: Vec<Abbreviation>,
    lagrangian: Option<(Sym, crate::diagnostics::Place)>,
    dissipation: Option<Sym>,
    /// Generalized force in SI units, by coordinate.
    forces: Vec<(usize, Sym)>,
    surfaces: Vec<Surface>,
    impacts: Vec<law::CheckedLaw>,
    start: Vec<Assignment>,
    horizon: Option<Sym>,
    task: optimal_control::Task,
}

impl Checker<'_> {
    fn statement(&mut self, statement: &Statement) -> Checked<()> {
        match statement {
            Statement::Parameters(_) => Ok(()),
            Statement::Coordinates(quantities) => self.bounds(quantities, false),
            Statement::Controls(quantities) => self.bounds(quantities, true),
            Statement::Let { name, value } => self.abbreviation(name, value),
            Statement::Function {
                name,
                arguments,
                body,
            } => self.function(name, arguments, body),
            Statement::Lagrangian { keyword, value } => self.lagrangian(*keyword, value),
            Statement::Dissipation { keyword, value } => self.dissipation(*keyword, value),
            Statement::Forces(assignments) => self.forces(assignments),
            Statement::Surface {
                documentation,
                name,
                left,
                relation,
                right,
            } => self.surface(documentation, name, left, *relation, right),
            Statement::Impact { surfaces, law } => self.impact(surfaces, law),
            Statement::Start(assignments) => self.start_statement(assignments),
            Statement::Horizon { keyword, value } => self.horizon(*keyword, value),
            Statement::Minimize { keyword, value } => self.minimize(*keyword, value),
            Statement::Constraint { name, condition } => self.constraint(name, condition),
            Statement::Finally(goals) => self.finally(goals),
            Statement::Free(values) => self.free(values),
        }
    }

    fn abbreviation(&mut self, name: &Name, value: &Expr) -> Checked<()> {
        let free = self.new_name(name, "abbreviation");
        self.scope.later.remove(&name.text);
        let value = self.scope.value(value, self.diagnostics);
        free?;
        let meaning = match value {
            Ok(value) => value,
            Err(Reported) => return self.poison(name),
        };
        self.scope
            .names
            .insert(name.text.clone(), Meaning::Value(meaning));
        self.abbreviations.push(Abbreviation {
            name: name.clone(),
            what: "abbreviation",
        });
        Ok(())
    }

    /// A name whose declaration failed: uses of it are not reported as undeclared, as the stand-in is
    /// never emitted.
    fn poison(&mut self, name: &Name) -> Checked<()> {
        self.diagnostics.poison(&name.text);
        Err(Reported)
    }

    fn function(&mut self, name: &Name, arguments: &[Name], body: &Expr) -> Checked<()> {
        let free = self.new_name(name, "function");
        self.scope.later.remove(&name.text);
        let mut failed = free.is_err();
        for (i, argument) in arguments.iter().enumerate() {
            if arguments[..i]
                .iter()
                .any(|known| known.text == argument.text)
            {
                self.diagnostics.report(
                    "E19",
                    argument.place(),
                    format!(
                        "function `{}` has two arguments `{}`",
                        name.text, argument.text
                    ),
                );
                failed = true;
            }
        }
        if failed {
            return self.poison(name);
        }
        self.scope.names.insert(
            name.text.clone(),
            Meaning::Function(Rc::new(UserFunction {
                arguments: arguments.to_vec(),
                body: body.clone(),
            })),
        );
        self.abbreviations.push(Abbreviation {
            name: name.clone(),
            what: "function",
        });
        Ok(())
    }

    fn surface(
        &mut self,
        documentation: &Documentation,
        name: &Name,
        left: &Expr,
        relation: Relation,
        right: &Expr,
    ) -> Checked<()> {
        if self
            .surfaces
            .iter()
            .any(|known| known.name.text == name.text)
            || self.diagnostics.is_poisoned(&name.text)
        {
            return Err(self.diagnostics.report(
                "E20",
                name.place(),
                format!("surface `{}` is declared twice; rename one", name.text),
            ));
        }
        let left_value = self.scope.scalar(left, self.diagnostics);
        let right_value = self.scope.scalar(right, self.diagnostics);
        let (Ok(left_value), Ok(right_value)) = (left_value, right_value) else {
            return self.poison(name);
        };
        let gap = match relation {
            Relation::AtLeast | Relation::Equal => left_value - right_value,
            Relation::AtMost => right_value - left_value,
        };
        if rules::surface(name, gap, (left, right), self).is_err() {
            return self.poison(name);
        }
        self.surfaces.push(Surface {
            documentation: documentation.clone(),
            name: name.clone(),
            gap,
        });
        Ok(())
    }

    /// A variable as the user knows it.
    fn in_words(&self, variable: Variable) -> String {
        let name = |list: &[Coordinate], i: u16| {
            list.get(usize::from(i))
                .map_or_else(String::new, |known| known.name.text.clone())
        };
        match variable {
            Variable::Coordinate(i) => format!("the coordinate `{}`", name(&self.coordinates, i)),
            Variable::Velocity(i) => format!("the velocity `dot({})`", name(&self.coordinates, i)),
            Variable::Control(i) => format!("the control `{}`", name(&self.controls, i)),
            Variable::Time => "the time `t`".to_owned(),
            _ => "a parameter".to_owned(),
        }
    }

    fn finish(self, declared: &Scene, units: &units::Inferred) -> Checked<CheckedScene> {
        let mut checker = self;
        rules::missing_statements(&declared.name, &mut checker);
        let laws = law::of_surfaces(&mut checker);
        let start = checker.start_values();
        let (Some((lagrangian, place)), Ok(laws), Ok(start)) = (checker.lagrangian, laws, start)
        else {
            return Err(Reported);
        };
        // Missing inertia and unused names are most often consequences of other mistakes, but not of units.
        if checker.diagnostics.others_than(&["E03"]) > 0 {
            return Err(Reported);
        }
        if checker.diagnostics.mistakes() == 0 {
            rules::inertia(&checker.coordinates, lagrangian, place, checker.diagnostics)?;
        }
        let mut contacts = law::contacts(laws, lagrangian, &mut checker)?;
        dependence::gaps(&contacts, &mut checker);
        rules::unused(&mut checker);
        for contact in &mut contacts {
            contact.unit = units.gaps.get(&contact.name.text).copied();
        }
        let forces = checker.total_forces();
        let mut dynamics: Vec<Sym> = vec![lagrangian];
        dynamics.extend(&forces);
        for contact in &contacts {
            dynamics.push(contact.gap);
            dynamics.extend(contact.along.iter().flatten());
            dynamics.extend(contact.friction.iter().map(|friction| friction.sliding));
        }
        let optimal_control = checker.optimal_control(units);
        if let Some(task) = &optimal_control {
            dynamics.extend(task.running_cost);
            dynamics.extend(task.constraints.iter().map(|known| known.function));
        }
        let explicit_time = graph::variables(&dynamics).contains(&Variable::Time);
        Ok(CheckedScene {
            documentation: declared.documentation.clone(),
            visibility: declared.visibility.clone(),
            name: declared.name.clone(),
            parameters: checker.parameters,
            coordinates: checker.coordinates,
            controls: checker.controls,
            lagrangian,
            forces,
            contacts,
            start,
            horizon: checker.horizon,
            explicit_time,
            optimal_control,
        })
    }

    /// Generalized forces in declared units: applied forces minus the gradient of the dissipation
    /// function with respect to the velocities.
    fn total_forces(&self) -> Vec<Sym> {
        let n = self.coordinates.len();
        let mut forces = vec![Sym::ZERO; n];
        for &(index, force) in &self.forces {
            // A force does work on a displacement, so it scales with the unit of the coordinate.
            forces[index] += force.scaled(scene::scale(self.coordinates[index].unit.as_ref()));
        }
        if let Some(dissipation) = self.dissipation {
            let velocities: Vec<Variable> = (0..n).map(|i| Variable::Velocity(i as u16)).collect();
            for (force, damping) in forces
                .iter_mut()
                .zip(graph::gradient(dissipation, &velocities))
            {
                *force -= damping;
            }
        }
        forces
    }
}
