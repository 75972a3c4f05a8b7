//! The functions of optimal control, of what solvers know.
//!
//! The force of a contact is `r / D` with the normal acceleration `r` that it provides and `D = n' H n`, that of its
//! friction `s / D`; its impulse is the same of the normal velocity that it provides in an impact. So functions of forces
//! are functions of `r` and `s` of all contacts, which solvers know, and of coordinates.

use super::contact::Mechanism;
use super::contacts::Contacts;
use super::explicit::Explicit;
use super::{Failure, simplify};
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{CheckedScene, Condition, Contact, OptimalControl};

/// Functions of optimal control.
pub(crate) struct ControlEquations {
    /// Running cost, then path constraints; functions of the input vector.
    pub(crate) path: Explicit,
    /// Final cost, then terminal conditions; functions of coordinates, velocities and final time, and then of the sums
    /// over impacts.
    pub(crate) terminal: Explicit,
    /// What is added up over impacts, then conditions on them, then what conditions that come true set; functions of the input vector with what contacts provide,
    /// here the impulses.
    pub(crate) impact: Explicit,
    /// Whether path functions read what contacts provide, behind the input vector.
    pub(crate) path_reads_forces: bool,
    /// Whether terminal functions read the same, last.
    pub(crate) terminal_reads_forces: bool,
}

/// What conditions set: the contact that each is, the velocity, and its value.
pub(crate) fn resets(scene: &CheckedScene) -> impl Iterator<Item = (usize, usize, Sym)> {
    let contacts = scene.contacts.iter().enumerate();
    contacts.flat_map(|(contact, known)| {
        let values = known.reset.iter();
        values.map(move |&(velocity, value)| (contact, velocity, value))
    })
}

/// Derives the functions of optimal control.
pub(super) fn equations(
    task: &OptimalControl,
    scene: &CheckedScene,
    contacts: &Contacts,
    mechanism: &Mechanism<'_>,
) -> Result<ControlEquations, Failure> {
    let inputs = mechanism.inputs;
    let path = listed(task.running_cost, &task.constraints);
    let terminal = listed(task.final_cost, &task.goals);
    let impact: Vec<Sym> = task
        .sums
        .iter()
        .copied()
        .chain(task.at_impacts.iter().map(|known| known.function))
        .chain(resets(scene).map(|(_, _, value)| value))
        .collect();
    let reads = |functions: &[Sym], of: fn(Variable) -> bool| {
        functions
            .iter()
            .any(|&function| graph::depends_on(function, of))
    };
    let path_reads_forces = reads(&path, Variable::is_force);
    let terminal_reads_forces = reads(&terminal, Variable::is_force);
    let used =
        [&path, &terminal, &impact].map(|functions| reads(functions, Variable::is_of_contact));
    let inertias = match used.contains(&true) {
        true => (scene.contacts.iter().zip(contacts.iter()))
            .map(|(declared, contact)| mechanism.inverse_inertia(declared, &contact))
            .collect::<Result<_, _>>()?,
        false => Vec::new(),
    };
    let provided: Vec<Variable> = [Variable::Provided, Variable::ProvidedSliding]
        .into_iter()
        .flat_map(|kind| (0..contacts.len() as u16).map(kind))
        .collect();
    let explicit = |functions: &[Sym], inputs: &[&[Variable]]| {
        let functions = functions
            .iter()
            .map(|&function| of_provided(function, &inertias, &scene.contacts));
        Explicit::new(functions.map(simplify).collect(), &inputs.concat())
    };
    let forces = |read: bool| if read { &provided[..] } else { &[] };
    let sums: Vec<Variable> = (0..task.sums.len() as u16).map(Variable::Sum).collect();
    let states = &inputs[..2 * scene.coordinates.len()];
    let parameters = &inputs[inputs.len() - scene.differentiated.len()..];
    let at_the_end = [
        states,
        &[Variable::Time],
        &sums,
        forces(terminal_reads_forces),
        parameters,
    ];
    Ok(ControlEquations {
        path: explicit(&path, &[inputs, forces(path_reads_forces)]),
        terminal: explicit(&terminal, &at_the_end),
        impact: explicit(&impact, &[inputs, forces(!impact.is_empty())]),
        path_reads_forces,
        terminal_reads_forces,
    })
}

/// A cost, if there is one, and the functions of conditions.
fn listed(cost: Option<Sym>, conditions: &[Condition]) -> Vec<Sym> {
    let functions = conditions.iter().map(|condition| condition.function);
    cost.into_iter().chain(functions).collect()
}

/// A function of forces or impulses as one of what contacts provide.
fn of_provided(function: Sym, inertias: &[Sym], contacts: &[Contact]) -> Sym {
    let force = |provided: Variable, contact: u16| {
        let inertia = inertias.get(usize::from(contact));
        inertia.map(|inertia| Sym::variable(provided) * inertia.power(-2))
    };
    let inserted = graph::substitute(&[function], |variable| match variable {
        Variable::ContactForce(i) | Variable::ContactImpulse(i) => force(Variable::Provided(i), i),
        Variable::FrictionForce(i) | Variable::FrictionImpulse(i) => {
            let friction = contacts.get(usize::from(i))?.friction?;
            let force = force(Variable::ProvidedSliding(i), i)?;
            Some(friction.share.map_or(force, |share| share * force))
        }
        _ => None,
    });
    inserted[0]
}
