//! Parameters as coordinates without motion, so that everything is differentiated by them twice.
//!
//! A parameter `p` stands behind all coordinates, with `p'' = 0`: mass matrix `diag(M, 1)`, no force, no component of any normal
//! or tangent. What no function of the motion is, a start, a horizon or a coefficient of a law, keeps the value of the
//! parameter, and is listed as a function of `p` besides.

use super::explicit::Explicit;
use super::simplify::simplify;
use crate::evaluate::velocity_direction;
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{CheckedScene, Condition, Coordinate, OptimalControl};

/// What a function of parameters gives, by the index of a component of the start `(q, v)` or of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Given {
    /// A component of the start.
    Start(usize),
    /// The length of the motion.
    Horizon,
    /// The coefficient of restitution of a contact.
    Restitution(usize),
    /// The coefficient of friction of a contact.
    Friction(usize),
}

/// The scene with those parameters (indices) as coordinates without motion; free ones among them have their ranges, and are to
/// be found at the start.
pub(crate) fn with_held(scene: CheckedScene, chosen: &[u16]) -> CheckedScene {
    let mut scene = scene;
    let n = scene.coordinates.len();
    let place = |variable: Variable| match variable {
        Variable::Parameter(i) => {
            let k = chosen.iter().position(|&known| known == i)?;
            Some(Sym::variable(Variable::Coordinate((n + k) as u16)))
        }
        _ => None,
    };
    let one = |value: Sym| graph::substitute(&[value], place)[0];
    for &index in chosen {
        let known = &scene.parameters[usize::from(index)];
        scene.coordinates.push(Coordinate {
            name: known.name.clone(),
            unit: known.unit.clone(),
            documentation: known.documentation.clone(),
            // What does not move is bounded at the start.
            bounds: None,
        });
        scene
            .start
            .0
            .push(Sym::variable(Variable::Parameter(index)));
        scene.start.1.push(Sym::ZERO);
        scene.forces.push(Sym::ZERO);
    }
    let rates = (0..chosen.len()).map(|k| Sym::variable(Variable::Velocity((n + k) as u16)));
    let inertia: Sym = rates.map(|rate| (rate * rate).scaled(0.5)).sum();
    scene.lagrangian = one(scene.lagrangian) + inertia;
    for force in &mut scene.forces {
        *force = one(*force);
    }
    for contact in &mut scene.contacts {
        contact.gap = one(contact.gap);
        contact.bound = contact.bound.map(one);
        contact
            .loads
            .iter_mut()
            .for_each(|(_, factor)| *factor = one(*factor));
        if let Some(along) = &mut contact.along {
            along
                .iter_mut()
                .for_each(|component| *component = one(*component));
            along.resize(n + chosen.len(), Sym::ZERO);
        }
        if let Some(friction) = &mut contact.friction {
            friction.sliding = one(friction.sliding);
            friction.share = friction.share.map(one);
            friction.across = friction.across.map(one);
        }
    }
    for output in &mut scene.outputs {
        output.value = one(output.value);
    }
    scene.picture = None;
    let free = scene
        .free_parameters
        .iter()
        .map(|free| (free.index, free.bounds));
    let free: Vec<(usize, Option<(Sym, Sym)>)> = free
        .filter_map(|(index, bounds)| {
            let k = chosen.iter().position(|&known| known == index)?;
            Some((n + k, Some(bounds)))
        })
        .collect();
    scene.optimal_control = scene
        .optimal_control
        .map(|task| task_with(task, (n, chosen.len()), free, &one));
    scene.held = chosen.to_vec();
    scene
}

/// The task with its functions replaced; conditions that read nothing but what has no motion hold at the end alone.
fn task_with(
    task: OptimalControl,
    (n, held): (usize, usize),
    free: Vec<(usize, Option<(Sym, Sym)>)>,
    one: &impl Fn(Sym) -> Sym,
) -> OptimalControl {
    let replaced = |conditions: Vec<Condition>| -> Vec<Condition> {
        let replaced = conditions.into_iter().map(|known| Condition {
            function: one(known.function),
            ..known
        });
        replaced.collect()
    };
    let moves = |condition: &Condition| {
        graph::depends_on(condition.function, |variable| match variable {
            Variable::Coordinate(i) => usize::from(i) < n,
            Variable::Parameter(_) => false,
            _ => true,
        })
    };
    let (constraints, fixed): (Vec<_>, Vec<_>) =
        replaced(task.constraints).into_iter().partition(moves);
    let shifted = |&(k, bounds): &(usize, _)| (if k < n { k } else { k + held }, bounds);
    let mut free_start: Vec<(usize, Option<(Sym, Sym)>)> =
        task.free_start.iter().map(shifted).chain(free).collect();
    free_start.sort_by_key(|known| known.0);
    OptimalControl {
        running_cost: task.running_cost.map(one),
        final_cost: task.final_cost.map(one),
        constraints,
        at_impacts: replaced(task.at_impacts),
        sums: task.sums.into_iter().map(one).collect(),
        goals: replaced(task.goals).into_iter().chain(fixed).collect(),
        free_start,
        ..task
    }
}

/// Number of coordinates that move; those behind them are held.
pub(super) fn moving(scene: &CheckedScene) -> usize {
    scene.coordinates.len() - scene.held.len()
}

/// What a variable becomes along the motion: coordinates from `moving` on do not change.
pub(super) fn along_motion(moving: usize) -> impl Fn(Variable) -> Sym + Copy {
    move |variable| match variable {
        Variable::Coordinate(i) if usize::from(i) >= moving => Sym::ZERO,
        _ => velocity_direction(variable),
    }
}

/// What of start, horizon and laws depends on parameters that are held, as functions of these.
pub(crate) fn given(scene: &CheckedScene, inputs: &[Variable]) -> (Vec<Given>, Explicit) {
    let (n, moving) = (scene.coordinates.len(), moving(scene));
    let mut known: Vec<(Given, Sym)> = Vec::new();
    for k in 0..moving {
        known.push((Given::Start(k), scene.start.0[k]));
        known.push((Given::Start(n + k), scene.start.1[k]));
    }
    known.sort_by_key(|&(given, _)| matches!(given, Given::Start(k) if k >= n));
    known.extend(scene.horizon.map(|horizon| (Given::Horizon, horizon)));
    for (i, contact) in scene.contacts.iter().enumerate() {
        known.extend(contact.restitution.map(|e| (Given::Restitution(i), e)));
        // That of dry friction is 1.
        let friction = contact
            .friction
            .as_ref()
            .filter(|_| contact.bound.is_none());
        known.extend(friction.map(|known| (Given::Friction(i), known.coefficient)));
    }
    let free_start = scene.optimal_control.as_ref().map(|task| &task.free_start);
    let is_free = |given: Given| {
        let mut free = free_start.into_iter().flatten();
        matches!(given, Given::Start(k) if free.any(|&(index, _)| index == k))
    };
    let held = |variable: Variable| match variable {
        Variable::Parameter(i) => scene.held.contains(&i),
        _ => false,
    };
    known.retain(|&(given, value)| !is_free(given) && graph::depends_on(value, held));
    let (kinds, values): (Vec<Given>, Vec<Sym>) = known.into_iter().unzip();
    let values = graph::substitute(&values, |variable| match variable {
        Variable::Parameter(i) => {
            let k = scene.held.iter().position(|&known| known == i)?;
            Some(Sym::variable(Variable::Coordinate((moving + k) as u16)))
        }
        _ => None,
    });
    let values = values.into_iter().map(simplify).collect();
    (kinds, Explicit::new(values, inputs))
}
