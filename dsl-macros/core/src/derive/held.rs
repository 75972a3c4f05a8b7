//! Parameters as coordinates without motion, so that everything is differentiated by them twice, and what functions of optimal control
//! remember of a free start, which is a parameter that decides it.
//!
//! A parameter `p` stands behind all coordinates, with `p'' = 0`: mass matrix `diag(M, 1)`, no force, no component of any normal
//! or tangent. What no function of the motion is, a start, a horizon or a coefficient of a law, keeps the value of the
//! parameter, and is listed as a function of `p` besides.

use super::explicit::Explicit;
use super::simplify::simplify;
use crate::ast::{Documentation, WrittenUnit};
use crate::declaration::{Given, Over};
use crate::evaluate::velocity_direction;
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{
    CheckedScene, Condition, Contact, Coordinate, Epigraph, Lifted, OptimalControl,
};
use hangtime_units::Unit;

/// Puts the declared start in the place of what functions of optimal control read of it: guesses of what is to be found there; and
/// largest values in the place of the unknowns that they are, but for those over the motion, which no function of an instant is: 0.
pub(crate) fn at_declared_start(scene: &mut CheckedScene) {
    let Some(mut task) = scene.optimal_control.take() else {
        return;
    };
    if !scene.remembered.is_empty() {
        task.map_functions(|value| {
            graph::substitute(&[value], |variable| match variable {
                Variable::Start(k) => Some(scene.start_component(usize::from(k))),
                _ => None,
            })[0]
        });
    }
    let known = std::mem::take(&mut task.epigraphs);
    task.map_functions(|mut value| {
        // What contains others was made after them.
        for epigraph in known.iter().rev() {
            value = graph::substitute(&[value], |variable| {
                (variable == epigraph.variable).then(|| epigraph.value())
            })[0];
        }
        value
    });
    task.epigraphs = known;
    scene.optimal_control = Some(task);
}

/// The scene with those parameters (indices) as coordinates without motion, and with what is remembered of its start; free ones among
/// them have their ranges, and are to be found at the start.
pub(crate) fn with_held(scene: CheckedScene, chosen: &[u16]) -> CheckedScene {
    let mut scene = scene;
    let n = scene.coordinates.len();
    let remembered = scene.remembered.clone();
    let epigraphs = match &mut scene.optimal_control {
        Some(task) => std::mem::take(&mut task.epigraphs),
        None => Vec::new(),
    };
    let known = |&&Epigraph { over, .. }: &&Epigraph| over == Over::Instants;
    let (changing, lasting): (Vec<&Epigraph>, Vec<&Epigraph>) = epigraphs.iter().partition(known);
    let (held, controls) = (
        chosen.len() + remembered.len() + lasting.len(),
        scene.controls.len(),
    );
    let place_of =
        |list: &[&Epigraph], variable| list.iter().position(|known| known.variable == variable);
    let place = |variable: Variable| {
        let k = match variable {
            Variable::Parameter(i) => chosen.iter().position(|&known| known == i)?,
            Variable::Start(k) => {
                let known = |&known: &usize| known == usize::from(k);
                chosen.len() + remembered.iter().position(known)?
            }
            Variable::Epigraph(_) => match place_of(&changing, variable) {
                Some(k) => return Some(Sym::variable(Variable::Control((controls + k) as u16))),
                None => chosen.len() + remembered.len() + place_of(&lasting, variable)?,
            },
            _ => return None,
        };
        Some(Sym::variable(Variable::Coordinate((n + k) as u16)))
    };
    let one = |value: Sym| graph::substitute(&[value], place)[0];
    add_coordinates(&mut scene, chosen);
    add_unknowns(&mut scene, (&changing, &lasting));
    scene.lagrangian = one(scene.lagrangian);
    if scene.states.is_empty() {
        let rates = (0..held).map(|k| Sym::variable(Variable::Velocity((n + k) as u16)));
        let inertia: Sym = rates.map(|rate| (rate * rate).scaled(0.5)).sum();
        scene.lagrangian += inertia;
    } else {
        // Behind states stand states, of the rate 0.
        let rates = scene.coordinates[n..].iter().map(rate);
        scene.states.extend(rates);
    }
    replace_in_mechanism(&mut scene, n + held, &one);
    scene.picture = None;
    // Start values of experiments are for the parameters as they are.
    scene.experiments.clear();
    let free = free_ones(&scene, chosen, n);
    scene.optimal_control = scene.optimal_control.map(|task| {
        let of_start = |&(k, bounds): &(usize, _)| {
            let known = remembered.iter().position(|&known| known == k)?;
            Some((n + chosen.len() + known, bounds))
        };
        let (mut free, mut task) = (free, task);
        free.extend(task.free_start.iter().filter_map(of_start));
        let first = n + chosen.len() + remembered.len();
        free.extend((first..n + held).map(|k| (k, None)));
        for epigraph in lasting.iter().chain(&changing) {
            add_conditions(&mut task, epigraph);
        }
        // What is remembered decides them.
        task.free_start.retain(|free| !remembered.contains(&free.0));
        task_with(task, (n, held), free, &one)
    });
    scene.held = chosen.to_vec();
    scene.remembers = !remembered.is_empty();
    scene.lifted = (!epigraphs.is_empty()).then(|| Lifted {
        coordinates: lasting.len(),
        controls: changing.iter().map(|known| known.rows.len()).collect(),
    });
    scene
}

/// Replaces what forces, contacts, joints and outputs of a scene read, which has so many coordinates then.
fn replace_in_mechanism(scene: &mut CheckedScene, coordinates: usize, one: &impl Fn(Sym) -> Sym) {
    let forces = scene.forces.iter_mut();
    forces.for_each(|force| *force = one(*force));
    for contact in &mut scene.contacts {
        replace_in(contact, coordinates, one);
    }
    for joint in &mut scene.joints {
        for row in &mut joint.rows {
            *row = one(*row);
        }
    }
    for output in &mut scene.outputs {
        output.value = one(output.value);
    }
}

/// The free ones among held parameters, by their places behind `n` coordinates, with their ranges.
fn free_ones(scene: &CheckedScene, chosen: &[u16], n: usize) -> Vec<(usize, Option<(Sym, Sym)>)> {
    let free = scene.free_parameters.iter();
    let placed = free.filter_map(|free| {
        let k = chosen.iter().position(|&known| known == free.index)?;
        Some((n + k, Some(free.bounds)))
    });
    placed.collect()
}

/// Puts unknowns that are largest values behind the coordinates, where one of them is all that there is, and behind the controls, where
/// there is one at each instant.
fn add_unknowns(scene: &mut CheckedScene, (changing, lasting): (&[&Epigraph], &[&Epigraph])) {
    let named = |shown: &str| {
        let mut name = scene.name.clone();
        name.text = format!("largest of {shown}");
        Coordinate {
            name,
            unit: None,
            documentation: Documentation::default(),
            bounds: None,
        }
    };
    let coordinates: Vec<Coordinate> = lasting.iter().map(|known| named(&known.shown)).collect();
    let controls: Vec<Coordinate> = changing.iter().map(|known| named(&known.shown)).collect();
    scene.coordinates.extend(coordinates);
    scene.controls.extend(controls);
    for values in [&mut scene.start.0, &mut scene.start.1, &mut scene.forces] {
        values.resize(scene.coordinates.len(), Sym::ZERO);
    }
}

/// Adds what an unknown that is a largest value is at least.
fn add_conditions(task: &mut OptimalControl, epigraph: &Epigraph) {
    let condition = |(k, &function): (usize, &Sym)| Condition {
        name: format!("largest of {}.{}", epigraph.shown, k + 1),
        documentation: Documentation::default(),
        function,
        equality: false,
        unit: None,
    };
    let rows = epigraph.rows.iter().enumerate().map(condition);
    match epigraph.over {
        Over::End => task.goals.extend(rows),
        Over::Motion | Over::Instants => task.constraints.extend(rows),
    }
    let first = epigraph.rows.len();
    let at_start = epigraph.at_start.iter().enumerate();
    task.goals
        .extend(at_start.map(|(k, row)| condition((first + k, row))));
}

/// Puts parameters and what is remembered behind the coordinates, with their values at the start.
fn add_coordinates(scene: &mut CheckedScene, chosen: &[u16]) {
    let n = scene.coordinates.len();
    let remembered = scene.remembered.clone();
    for &index in chosen {
        let known = &scene.parameters[usize::from(index)];
        scene.coordinates.push(Coordinate {
            name: known.name.clone(),
            unit: known.unit.clone(),
            documentation: known.documentation.clone(),
            // What does not move is bounded at the start.
            bounds: None,
        });
    }
    let values = remembered.iter().map(|&k| scene.start_component(k));
    let values: Vec<Sym> = values.collect();
    for &k in &remembered {
        let component = component(scene, n, k);
        scene.coordinates.push(component);
    }
    let parameters = chosen.iter().copied().map(Variable::Parameter);
    let parameters = parameters.map(Sym::variable);
    scene.start.0.extend(parameters.chain(values));
    scene.start.1.resize(scene.coordinates.len(), Sym::ZERO);
    scene.forces.resize(scene.coordinates.len(), Sym::ZERO);
}

/// Replaces the functions of a contact, which acts on none of the coordinates behind those that it knew.
fn replace_in(contact: &mut Contact, coordinates: usize, one: &impl Fn(Sym) -> Sym) {
    contact.functions_mut().for_each(|own| *own = one(*own));
    let action = contact.switch.iter_mut();
    let lists = action.flat_map(|action| [&mut action.force, &mut action.usual]);
    for components in lists.chain(&mut contact.along) {
        components.resize(coordinates, Sym::ZERO);
    }
}

/// What is remembered of a component of the start `(q, v)`, as a coordinate.
fn component(scene: &CheckedScene, n: usize, k: usize) -> Coordinate {
    let own = &scene.coordinates[k % n];
    let (mut name, mut unit) = (own.name.clone(), own.unit.clone());
    let state = k.checked_sub(n + n - scene.states.len());
    if let Some(state) = state {
        name = scene.states[state].name.clone();
        unit = scene.states[state].unit.clone();
    } else if k >= n {
        name.text = format!("dot({})", name.text);
        unit = unit.as_ref().map(per_second);
    }
    name.text = format!("start({})", name.text);
    Coordinate {
        name,
        unit,
        documentation: own.documentation.clone(),
        bounds: None,
    }
}

/// The velocity of a coordinate without motion, as a state.
fn rate(held: &Coordinate) -> Coordinate {
    let mut name = held.name.clone();
    name.text = format!("dot({})", name.text);
    Coordinate {
        name,
        unit: held.unit.as_ref().map(per_second),
        documentation: held.documentation.clone(),
        bounds: None,
    }
}

/// The unit of the rate of what has this one.
fn per_second(unit: &WrittenUnit) -> WrittenUnit {
    WrittenUnit {
        text: format!("{}/s", unit.text),
        unit: unit.unit * Unit::mechanical(0, 0, -1),
    }
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
    let remembered = if scene.remembers {
        scene.remembered.len()
    } else {
        0
    };
    let lifted = scene.lifted.as_ref().map_or(0, |lifted| lifted.coordinates);
    scene.coordinates.len() - scene.held.len() - remembered - lifted
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
    let value = |k: usize, value: Sym| {
        let found = scene.remembered.iter().position(|&known| known == k);
        let place = found.map(|place| (moving + scene.held.len() + place) as u16);
        place.map_or(value, |i| Sym::variable(Variable::Coordinate(i)))
    };
    for k in 0..moving {
        known.push((Given::Start(k), value(k, scene.start.0[k])));
        known.push((Given::Start(n + k), value(moving + k, scene.start.1[k])));
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
        Variable::Coordinate(_) => true,
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
