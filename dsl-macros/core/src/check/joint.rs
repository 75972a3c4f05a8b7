//! E25: joints, which are equations between positions, or linear ones between velocities.

use super::checker::Checker;
use super::dry;
use super::rules::is_square;
use crate::ast::{Documentation, Expr, Name};
use crate::diagnostics::{Checked, Place};
use crate::evaluate::{Number, Value, velocity_direction};
use crate::graph::{self, Sym, Variable};
use crate::scene::{Contact, Joint};

/// Most equations of all joints of one scene.
const MOST: usize = 500;

/// `joint name: left == right`.
pub(super) fn joint(
    checker: &mut Checker<'_>,
    (documentation, name): (&Documentation, &Name),
    left: &Expr,
    right: &Expr,
) -> Checked<()> {
    dry::new_contact(checker, name, "joint")?;
    let own = checker.value(left);
    let its = checker.value(right);
    let (Ok(own), Ok(its)) = (own, its) else {
        return checker.poison(name);
    };
    let place = left.place.to(right.place);
    let Ok(rows) = rows(checker, name, (left, &own), (right, &its)) else {
        return checker.poison(name);
    };
    let Ok(holonomic) = kind(checker, name, &rows, place) else {
        return checker.poison(name);
    };
    units(checker, (name, holonomic), (left, &own), (right, &its));
    let first = checker
        .laws
        .joints
        .iter()
        .map(|joint| joint.rows.len())
        .sum();
    if first + rows.len() > MOST {
        let message = format!("the joints of a scene are at most {MOST} equations");
        return Err(checker.diagnostics.syntax(name.place(), message));
    }
    let known = (name.text.clone(), first..first + rows.len());
    checker.scope.joints.push(known);
    checker.laws.joints.push(Joint {
        name: name.clone(),
        documentation: documentation.clone(),
        unit: None,
        rows,
        holonomic,
    });
    Ok(())
}

/// The differences of both sides, one a component.
fn rows(
    checker: &mut Checker<'_>,
    name: &Name,
    (left, own): (&Expr, &Value),
    (right, its): (&Expr, &Value),
) -> Checked<Vec<Sym>> {
    let zero = |value: &Value| matches!(value, Value::Scalar(own) if own.sym == Sym::ZERO);
    let place = left.place.to(right.place);
    let matrix = |value: &Value| matches!(value, Value::Matrix(_));
    if matrix(own) || matrix(its) {
        let message = format!(
            "joint `{}` compares matrices; write an equation for each entry, or for vectors",
            name.text
        );
        return Err(checker.diagnostics.report("E25", place, message));
    }
    let (first, second) = (own.syms(), its.syms());
    // A bare zero is the zero of any number of components.
    if zero(its) {
        return Ok(first);
    }
    if zero(own) {
        return Ok(second.into_iter().map(|value| -value).collect());
    }
    if first.len() != second.len() {
        let components = |value: &Value| match value {
            Value::Scalar(_) => "a number".to_owned(),
            other => format!("a vector with {} components", other.components().len()),
        };
        let message = format!(
            "joint `{}` compares {} with {}; both sides need the same number of components",
            name.text,
            components(own),
            components(its)
        );
        return Err(checker.diagnostics.report("E25", place, message));
    }
    Ok(first.into_iter().zip(second).map(|(a, b)| a - b).collect())
}

/// Whether a joint is one of positions; it is one of velocities otherwise, and linear in them.
fn kind(checker: &mut Checker<'_>, name: &Name, rows: &[Sym], place: Place) -> Checked<bool> {
    let text = &name.text;
    let n = checker.coordinates.len();
    checker.free_of(rows, Variable::is_control, (Some("E25"), place), |control| {
        format!(
            "joint `{text}` depends on {control}; it may depend on positions, velocities and the time only. What a motor \
             moves is held by a force, `forces {{ x: u }}`, or given over the time `t`"
        )
    })?;
    let first_state = checker.scope.first_state;
    let is_state = |known: &Variable| matches!(known, Variable::Velocity(i) if *i >= first_state);
    if !checker.states.is_empty() && graph::variables(rows).iter().any(is_state) {
        let message = format!(
            "joint `{text}` depends on a state, which changes by its rate alone; it may depend on positions, velocities and the time \
             only"
        );
        return Err(checker.diagnostics.report("E25", place, message));
    }
    let moving: Vec<bool> = rows
        .iter()
        .map(|&row| graph::depends_on(row, Variable::is_velocity))
        .collect();
    let holonomic = !moving.contains(&true);
    if !holonomic && moving.contains(&false) {
        let message = format!(
            "joint `{text}` has velocities in some of its components and positions alone in others; declare two \
             joints"
        );
        return Err(checker.diagnostics.report("E25", place, message));
    }
    for (i, &row) in rows.iter().enumerate() {
        let component = match rows.len() {
            1 => format!("joint `{text}`"),
            _ => format!("component {} of joint `{text}`", i + 1),
        };
        let rate = rate(row, holonomic);
        let gradient = graph::gradient(rate, &Variable::velocities(n));
        if gradient.iter().all(|entry| entry.is_structural_zero()) {
            let message = format!(
                "{component} depends on no coordinate, so that it holds nothing; write positions on its sides, or \
                 velocities"
            );
            return Err(checker.diagnostics.report("E25", place, message));
        }
        if !holonomic {
            linear(checker, &component, &gradient, place)?;
        } else if is_square(row) {
            let message = format!(
                "{component} is a square that is 0, whose gradient vanishes where it holds; write what is squared \
                 itself, and a component for each direction of a distance"
            );
            return Err(checker.diagnostics.report("E25", place, message));
        }
    }
    Ok(holonomic)
}

/// A joint of velocities is linear in them.
fn linear(
    checker: &mut Checker<'_>,
    component: &str,
    gradient: &[Sym],
    place: Place,
) -> Checked<()> {
    let bends = gradient
        .iter()
        .any(|&entry| graph::depends_on(entry, Variable::is_velocity));
    if !bends {
        return Ok(());
    }
    let message = format!(
        "{component} is not linear in the velocities, as an ideal joint is; write components of velocities, such as \
         `dot(x) == r*dot(phi)`, or a force for what only brakes"
    );
    Err(checker.diagnostics.report("E25", place, message))
}

/// The rate of a row of positions; a row of velocities itself.
fn rate(row: Sym, holonomic: bool) -> Sym {
    if holonomic {
        graph::directional(&[row], velocity_direction)[0]
    } else {
        row
    }
}

/// E24: forces of joints in optimal control, where contacts push along normals and tangents, and nothing switches what acts.
pub(super) fn planned(checker: &mut Checker<'_>, contacts: &[Contact]) {
    let Some(place) = checker.scope.planned else {
        return;
    };
    let other = contacts
        .iter()
        .find(|contact| contact.switch.is_some() || !contact.held.is_empty());
    let Some(other) = other else { return };
    let what = if other.switch.is_some() {
        "a switch in `forces`"
    } else {
        "a contact with `holding`"
    };
    let message = format!(
        "the force of a joint in optimal control is not known beside {what} (`{}`); write the cost or condition with controls",
        other.name.text
    );
    checker.diagnostics.report("E24", place, message);
}

/// The units of all joints, now that they are known, and contacts that do not go with them.
pub(super) fn finish(checker: &mut Checker<'_>, contacts: &[Contact]) {
    if checker.laws.joints.is_empty() {
        return;
    }
    for contact in contacts.iter().filter(|contact| contact.along.is_some()) {
        let message = format!(
            "the impulse direction `along` of `{0}` is not known to joints; leave it out, so that the impulse of `{0}` acts as \
             the mechanism can move, or write `holding` with the coordinates that it does not move",
            contact.name.text
        );
        let place = contact.name.place();
        checker.diagnostics.report("E25", place, message);
    }
    for joint in &mut checker.laws.joints {
        joint.unit = checker.scope.units.gap(&joint.name.text);
    }
}

/// E03: both sides agree, component by component, and so do the components. A force does work on what is held: a joint of velocities
/// is measured by the way.
fn units(
    checker: &mut Checker<'_>,
    (name, holonomic): (&Name, bool),
    (left, own): (&Expr, &Value),
    (right, its): (&Expr, &Value),
) {
    let units = &mut checker.scope.units;
    let place = left.place.to(right.place);
    let [sides, components] =
        ["both sides", "the components"].map(|what| format!("{what} of joint `{}`", name.text));
    let (own, its) = (own.components(), its.components());
    if let ([own], [its]) = (own, its) {
        units.angles((left, own), (right, its));
    }
    // A zero stands for all components of the other side.
    let at = |list: &[Number], i: usize| list.get(i).unwrap_or(&list[0]).unit.clone();
    let first = at(own, 0);
    (0..own.len().max(its.len())).all(|i| {
        let (own, its) = (at(own, i), at(its, i));
        units.same(place, (left, &own), (right, &its), &sides)
            && units.same(place, (left, &first), (left, &own), &components)
    });
    let way = match holonomic {
        true => first,
        false => first.times(&units.second()),
    };
    units.put_gap(name, way);
}
