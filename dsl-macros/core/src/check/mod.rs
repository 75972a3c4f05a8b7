//! The declaration as a whole: names in force, every expression evaluated, the rules of the language.

mod at_times;
mod branch;
mod checker;
mod chosen;
mod dependence;
mod design;
mod dry;
mod epigraph;
mod friction;
mod joint;
mod law;
mod measured;
mod names;
mod optimal_control;
mod outputs;
mod picture;
mod pieces;
mod reach;
mod remembered;
mod resets;
mod rules;
mod start;
mod states;
mod switches;
mod values;

pub(crate) use design::without_free_bounds;
pub(crate) use law::normal;
pub(crate) use start::inertia_at_start;

use crate::ast::{Documentation, Expr, Name, Relation, Scene, Statement, WrittenUnit};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported};
use crate::evaluate::{Meaning, Role, Scope, UserFunction};
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{self, CheckedScene};
use checker::{Abbreviation, Checker, Laws, Of, Shown, Surface, Task};
use std::rc::Rc;

/// Checks a declaration. Every mistake found is reported; a scene comes back if its mistakes leave what is derived from
/// it meaningful, such as units that differ in a terminal condition.
pub(crate) fn scene(declared: &Scene, diagnostics: &mut Diagnostics) -> Checked<CheckedScene> {
    let before = diagnostics.mistakes();
    let mut checker = Checker {
        scope: Scope::default(),
        diagnostics,
        parameters: Vec::new(),
        free_parameters: Vec::new(),
        coordinates: Vec::new(),
        controls: Vec::new(),
        states: Vec::new(),
        rates: Vec::new(),
        abbreviations: Vec::new(),
        lagrangian: None,
        dissipation: None,
        forces: Vec::new(),
        surfaces: Vec::new(),
        laws: Laws::default(),
        start: Vec::new(),
        horizon: None,
        task: Task::default(),
        moments: Vec::new(),
        shown: Shown::default(),
    };
    names::declare_all(&mut checker, &declared.statements);
    let (mut complete, mut sound) = (before == 0, true);
    for statement in &declared.statements {
        // Each statement reports its own mistakes; the next one is checked all the same.
        if one_statement(&mut checker, statement).is_err() {
            complete = false;
            // Units are no matter of what means nothing.
            checker.scope.units.found = Diagnostics::default();
        }
        let energy = matches!(
            statement,
            Statement::Lagrangian { .. } | Statement::Let { .. }
        );
        sound &= !energy || checker.scope.units.found.mistakes() == 0;
        checker.tell_units();
    }
    finish(checker, declared, sound, complete)
}

fn one_statement(checker: &mut Checker<'_>, statement: &Statement) -> Checked<()> {
    match statement {
        Statement::Parameters(quantities) => design::bounds(checker, quantities),
        Statement::Coordinates(quantities) => values::bounds(checker, quantities, Of::Coordinates),
        Statement::Controls(quantities) => values::bounds(checker, quantities, Of::Controls),
        Statement::States(quantities) => values::bounds(checker, quantities, Of::States),
        Statement::Rates(assignments) => states::rates(checker, assignments),
        Statement::Let { name, unit, value } => abbreviation(checker, (name, unit.as_ref()), value),
        Statement::Function {
            name,
            arguments,
            body,
        } => function(checker, name, arguments, body),
        Statement::Positive(positive) => values::positive(checker, positive),
        Statement::Lagrangian { keyword, value } => values::lagrangian(checker, *keyword, value),
        Statement::Dissipation { keyword, value } => values::dissipation(checker, *keyword, value),
        Statement::Forces(assignments) => values::forces(checker, assignments),
        Statement::Surface {
            documentation,
            name,
            left,
            relation,
            right,
        } => surface(checker, documentation, name, left, *relation, right),
        Statement::Impact { surfaces, law } => law::impact(checker, surfaces, law),
        Statement::Dry {
            documentation,
            name,
            bound,
            sliding,
        } => dry::friction(checker, (documentation, name), bound, sliding),
        Statement::Joint {
            documentation,
            name,
            left,
            right,
        } => joint::joint(checker, (documentation, name), left, right),
        Statement::When {
            condition,
            assignments,
        } => resets::when(checker, condition, assignments),
        Statement::At {
            time,
            conditions,
            values,
            ..
        } => at_times::at(checker, time, conditions, values),
        Statement::Start(assignments) => values::start_statement(checker, assignments),
        Statement::Horizon { keyword, value } => values::horizon(checker, *keyword, value),
        Statement::Minimize { value, .. } if measured::is_misfit(checker, value) => Ok(()),
        Statement::Minimize { keyword, value } => {
            optimal_control::minimize(checker, *keyword, value)
        }
        Statement::Constraint { name, condition } => {
            optimal_control::constraint(checker, name, condition)
        }
        Statement::Finally(goals) => optimal_control::finally(checker, goals),
        Statement::Free(values) => optimal_control::free(checker, values),
        // Outputs that are measured may stand below.
        Statement::Measured(_) => Ok(()),
        Statement::Outputs(quantities) => outputs::outputs(checker, quantities),
        Statement::Picture { keyword, shapes } => picture::picture(checker, *keyword, shapes),
    }
}

/// An abbreviation; one with a unit has it for its uses whatever its value has, so that these give no second message.
fn abbreviation(
    checker: &mut Checker<'_>,
    (name, unit): (&Name, Option<&WrittenUnit>),
    expr: &Expr,
) -> Checked<()> {
    let free = checker.new_name(name, "abbreviation");
    checker.scope.later.remove(&name.text);
    checker.scope.defers = true;
    let value = checker.value(expr);
    checker.scope.defers = false;
    free?;
    let mut meaning = match value {
        Ok(value) => value,
        Err(Reported) => return checker.poison(name),
    };
    if let Some(written) = unit {
        let units = &mut checker.scope.units;
        let wanted = units.of(written.unit);
        let reason = format!("`{}` is declared so", name.text);
        let mut components = meaning.components().iter();
        components.all(|own| units.expect(expr, &own.unit, &wanted, &reason));
        meaning = meaning.map(|own| own.in_unit(wanted.clone()));
    }
    checker
        .scope
        .names
        .insert(name.text.clone(), Meaning::Value(meaning));
    checker.abbreviations.push(Abbreviation {
        name: name.clone(),
        what: "abbreviation",
    });
    Ok(())
}

fn function(
    checker: &mut Checker<'_>,
    name: &Name,
    arguments: &[Name],
    body: &Expr,
) -> Checked<()> {
    let free = checker.new_name(name, "function");
    checker.scope.later.remove(&name.text);
    let mut failed = free.is_err();
    for (i, argument) in arguments.iter().enumerate() {
        if arguments[..i]
            .iter()
            .any(|known| known.text == argument.text)
        {
            checker.diagnostics.report(
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
        return checker.poison(name);
    }
    checker.scope.names.insert(
        name.text.clone(),
        Meaning::Function(Rc::new(UserFunction {
            arguments: arguments.to_vec(),
            body: body.clone(),
        })),
    );
    checker.abbreviations.push(Abbreviation {
        name: name.clone(),
        what: "function",
    });
    Ok(())
}

fn surface(
    checker: &mut Checker<'_>,
    documentation: &Documentation,
    name: &Name,
    left: &Expr,
    relation: Relation,
    right: &Expr,
) -> Checked<()> {
    dry::new_contact(checker, name, "surface")?;
    checker.scope.role = Role::Surface;
    let left_value = checker.number(left);
    let right_value = checker.number(right);
    checker.scope.role = Role::Motion;
    let (Ok(own), Ok(its)) = (left_value, right_value) else {
        return checker.poison(name);
    };
    let what = format!("both sides of surface `{}`", name.text);
    let gap = checker.difference([(left, &own), (right, &its)], relation, &what);
    checker.scope.units.put_gap(name, gap.unit);
    let gap = gap.sym;
    let Ok(groups) = pieces::groups(gap, (left, right), checker) else {
        return checker.poison(name);
    };
    for &gap in groups.iter().flatten() {
        if rules::surface(name, gap, (left, right), checker).is_err() {
            return checker.poison(name);
        }
    }
    let begin = checker.surfaces.len();
    let pieces = groups.iter().map(Vec::len).sum();
    let mut functions: Vec<Sym> = Vec::new();
    for &gap in groups.iter().flatten() {
        if !functions.contains(&gap) {
            functions.push(gap);
        }
    }
    for group in groups {
        let first = checker.surfaces.len();
        for (i, &gap) in group.iter().enumerate() {
            let others = (first..first + group.len()).filter(|&other| other != first + i);
            checker.surfaces.push(Surface {
                documentation: documentation.clone(),
                name: name.clone(),
                gap,
                piece: first + i - begin,
                pieces,
                slides: (
                    functions.iter().position(|own| *own == gap).unwrap_or(0),
                    functions.len(),
                ),
                alternatives: others.collect(),
            });
        }
    }
    let contacts = begin..checker.surfaces.len();
    let declared = (name.text.clone(), contacts);
    checker.scope.surfaces.push(declared);
    Ok(())
}

/// `sound` tells whether the units of the Lagrangian agree, `complete` whether every statement could be read and evaluated.
fn finish(
    mut checker: Checker<'_>,
    declared: &Scene,
    sound: bool,
    complete: bool,
) -> Checked<CheckedScene> {
    rules::missing_statements(&declared.name, &mut checker);
    states::without_rate(&mut checker);
    let start = values::start_values(&mut checker);
    law::sliding_units(&mut checker);
    start::gaps(&mut checker, declared, &start, complete);
    let experiments = measured::experiments(&mut checker, declared, &start);
    reach::surfaces(&mut checker);
    let laws = law::of_surfaces(&mut checker);
    let (Some((lagrangian, place)), Ok(laws), Ok(mut start)) =
        (checker.lagrangian, laws, start.values())
    else {
        return Err(Reported);
    };
    at_times::finish(&mut checker, &mut start.1);
    // Missing inertia and unused names are most often consequences of other mistakes, but not of units and places.
    no_other_mistakes(&checker)?;
    let moves = inertia(&mut checker, sound, (lagrangian, place));
    let contacts = law::contacts(laws, (lagrangian, moves.is_ok()), &mut checker);
    if let Ok(contacts) = &contacts {
        dependence::gaps(contacts, &mut checker);
    }
    chosen::coordinates(lagrangian, &mut checker);
    rules::weight(lagrangian, &mut checker);
    rules::unused(&mut checker);
    let mut contacts = contacts?;
    dry::append(&mut checker, &mut contacts);
    let mut forces = total_forces(&checker);
    states::append(&mut checker, &mut forces);
    switches::append(&mut checker, &mut forces, &mut contacts)?;
    resets::append(&mut checker, &mut contacts);
    joint::finish(&mut checker, &contacts);
    joint::planned(&mut checker, &contacts);
    dry::followed(&mut checker, &contacts);
    let mut dynamics = dynamics(lagrangian, &forces, &contacts, &checker.laws.joints);
    let mut optimal_control = optimal_control::optimal_control(&mut checker);
    let remembered = remembered::starts(&mut checker, optimal_control.as_mut(), &start);
    dynamics.extend(optimal_control.iter().flat_map(along_the_way));
    moves?;
    let given = [&dynamics[..], &forces, &start.0, &start.1].concat();
    let task = (optimal_control.as_ref(), &experiments[..]);
    free_parameters(&mut checker, given, &contacts, task);
    outputs::finish(&mut checker, &contacts);
    no_other_mistakes(&checker)?;
    Ok(CheckedScene {
        explicit_time: graph::variables(&dynamics).contains(&Variable::Time),
        documentation: declared.documentation.clone(),
        visibility: declared.visibility.clone(),
        name: declared.name.clone(),
        parameters: checker.parameters,
        coordinates: checker.coordinates,
        controls: checker.controls,
        states: checker.states,
        lagrangian,
        forces,
        contacts,
        joints: checker.laws.joints,
        positive: checker.laws.positive,
        start,
        horizon: checker.horizon,
        optimal_control,
        outputs: checker.shown.outputs,
        picture: checker.shown.picture,
        differentiated: Vec::new(),
        free_parameters: checker.free_parameters,
        experiments,
        held: Vec::new(),
        remembered,
        remembers: false,
        lifted: None,
    })
}

/// Whether units and places are all that is mistaken so far.
fn no_other_mistakes(checker: &Checker<'_>) -> Checked<()> {
    match checker.diagnostics.others_than(&["E03", "E08"]) {
        0 => Ok(()),
        _ => Err(Reported),
    }
}

/// Whether every coordinate has inertia; a scene of states only has no mechanism.
fn inertia(
    checker: &mut Checker<'_>,
    sound: bool,
    (lagrangian, place): (Sym, Place),
) -> Checked<()> {
    if !sound {
        return Err(Reported);
    }
    if checker.coordinates.is_empty() {
        return Ok(());
    }
    states::momenta(checker, lagrangian, place)?;
    graph::begin(graph::Stage::Inertia);
    rules::inertia(&checker.coordinates, lagrangian, place, checker.diagnostics)
}

/// What a task reads along the motion.
fn along_the_way(task: &scene::OptimalControl) -> Vec<Sym> {
    let constraints = task.constraints.iter().chain(&task.at_impacts);
    let functions = constraints.map(|known| known.function);
    functions
        .chain(task.running_cost)
        .chain(task.sums.iter().copied())
        .chain(
            task.epigraphs
                .iter()
                .flat_map(|known| known.rows.iter().copied()),
        )
        .collect()
}

/// What is asked of free parameters, of which motion, laws and the objective read some.
fn free_parameters(
    checker: &mut Checker<'_>,
    mut given: Vec<Sym>,
    contacts: &[scene::Contact],
    (task, experiments): (Option<&scene::OptimalControl>, &[scene::Experiment]),
) {
    given.extend(measured::functions(checker, experiments));
    let judged = judged(task) || !experiments.is_empty();
    design::finish(checker, (&given, judged), contacts, task);
}

/// Whether a task has an objective.
fn judged(task: Option<&scene::OptimalControl>) -> bool {
    task.is_some_and(|task| task.running_cost.is_some() || task.final_cost.is_some())
}

/// All functions of the motion.
fn dynamics(
    lagrangian: Sym,
    forces: &[Sym],
    contacts: &[scene::Contact],
    joints: &[scene::Joint],
) -> Vec<Sym> {
    let mut dynamics: Vec<Sym> = vec![lagrangian];
    dynamics.extend(forces);
    for contact in contacts {
        dynamics.extend(contact.clone().functions_mut().map(|function| *function));
    }
    dynamics.extend(joints.iter().flat_map(|joint| &joint.rows));
    dynamics
}

/// Generalized forces in declared units: applied forces minus the gradient of the dissipation
/// function with respect to the velocities.
fn total_forces(checker: &Checker<'_>) -> Vec<Sym> {
    let n = checker.coordinates.len();
    let mut forces = vec![Sym::ZERO; n];
    for &(index, force) in &checker.forces {
        // A force does work on a displacement, so it scales with the unit of the coordinate.
        forces[index] += force.scaled(scene::scale(checker.coordinates[index].unit.as_ref()));
    }
    if let Some(dissipation) = checker.dissipation {
        let velocities = Variable::velocities(n);
        for (force, damping) in forces
            .iter_mut()
            .zip(graph::gradient(dissipation, &velocities))
        {
            *force -= damping;
        }
    }
    forces
}
