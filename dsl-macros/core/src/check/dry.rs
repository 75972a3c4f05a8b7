//! Dry friction without a surface: a contact whose normal force is given.

use super::checker::{Checker, DryFriction};
use super::{friction, law};
use crate::ast::{Documentation, Expr, Name};
use crate::derive::simplify;
use crate::diagnostics::Checked;
use crate::dimension::Dimension;
use crate::evaluate::{FIRST_DRY, Number, Role};
use crate::graph::{self, Sym, Variable};
use crate::scene::Contact;

/// E20: a surface, a dry friction or a joint has a name of its own.
pub(super) fn new_contact(checker: &mut Checker<'_>, name: &Name, what: &str) -> Checked<()> {
    let text = &name.text;
    let mut joints = checker.scope.joints.iter();
    let dry = checker.scope.dry.contains(text) || joints.any(|(known, _)| known == text);
    let surface = checker.scope.units.gaps.contains_key(text);
    if dry || surface || checker.diagnostics.is_poisoned(text) {
        let message = format!("{what} `{text}` is declared twice; rename one");
        let reported = checker.diagnostics.report("E20", name.place(), message);
        if dry {
            // What its law says is no second mistake.
            checker.diagnostics.poison(text);
        }
        return Err(reported);
    }
    Ok(())
}

pub(super) fn friction(
    checker: &mut Checker<'_>,
    (documentation, name): (&Documentation, &Name),
    bound: &Expr,
    sliding: &Expr,
) -> Checked<()> {
    new_contact(checker, name, "dry friction")?;
    let velocity = law::sliding(checker, sliding);
    let speed = velocity.as_ref().map(|velocity| velocity.unit.clone());
    let own = self::bound(checker, name, bound, speed.unwrap_or_default());
    let (Ok(own), Ok(velocity)) = (own, velocity) else {
        return checker.poison(name);
    };
    let units = &mut checker.scope.units;
    // A force does work along the way on which it brakes.
    let way = velocity.unit.times(&units.second());
    let wanted = units.energy.over(&way);
    let reason = format!(
        "the bound of `{}` is the Lagrangian's unit over that of its sliding velocity times s",
        name.text
    );
    units.expect(bound, &own.unit, &wanted, &reason);
    units.gaps.insert(name.text.clone(), way);
    let (bound, sliding) = (own.sym, velocity.sym);
    let forces = graph::variables(&[bound]).into_iter();
    let (mut loads, mut joint_loads) = (Vec::new(), Vec::new());
    for force in forces {
        let (loads, i) = match force {
            Variable::ContactForce(i) => (&mut loads, i),
            Variable::JointForce(i) => (&mut joint_loads, i),
            _ => continue,
        };
        let factor = graph::partial(&[bound], force)[0];
        loads.push((i, simplify(friction::at_speed(factor, sliding))));
    }
    let unloaded = |variable| is_force(variable).then_some(Sym::ZERO);
    let bound = graph::substitute(&[bound], unloaded)[0];
    checker.scope.dry.push(name.text.clone());
    checker.laws.dry.push(DryFriction {
        documentation: documentation.clone(),
        name: name.clone(),
        bound: friction::at_speed(bound, sliding),
        loads,
        joint_loads,
        sliding,
    });
    Ok(())
}

/// Whether a variable is a force that a bound may follow.
fn is_force(variable: Variable) -> bool {
    matches!(
        variable,
        Variable::ContactForce(_) | Variable::JointForce(_)
    )
}

/// E07 and E10: the bound is linear in the forces that it follows, and not negative.
fn bound(checker: &mut Checker<'_>, name: &Name, expr: &Expr, speed: Dimension) -> Checked<Number> {
    checker.scope.role = Role::Bound;
    let own = friction::with_speed(checker, speed, |checker| checker.number(expr));
    checker.scope.role = Role::Motion;
    let own = own?;
    let bound = own.sym;
    for force in graph::variables(&[bound])
        .into_iter()
        .filter(|&v| is_force(v))
    {
        let factor = simplify(graph::partial(&[bound], force)[0]);
        if graph::depends_on(factor, is_force) {
            let message = format!(
                "the bound of dry friction `{}` is no sum of forces of surfaces and joints times what does not follow them; write one, as in \
                 `bound mu*force(pad)`, with the sign by which the force of a joint is positive",
                name.text
            );
            return Err(checker.diagnostics.report("E07", expr.place, message));
        }
        // That of a joint has the sign of how its sides are written.
        let presses = matches!(force, Variable::ContactForce(_));
        let factor = checker.at_default(factor);
        if presses && factor.is_some_and(|factor| factor < 0.0) {
            let message = format!(
                "the bound of dry friction `{}` falls where a surface is pressed, and may fall below 0; change the sign in front \
                 of `force`",
                name.text
            );
            return Err(checker.diagnostics.report("E10", expr.place, message));
        }
    }
    match checker.at_default(bound) {
        Some(value) if value < 0.0 => {
            let message = format!(
                "the bound of dry friction `{}` is {value} < 0: the force would drive the sliding instead of braking \
                 it; change its sign",
                name.text
            );
            Err(checker.diagnostics.report("E10", expr.place, message))
        }
        _ => Ok(own),
    }
}

/// Adds the dry frictions behind the surfaces, with units in which their velocities are integrated, and lets the outputs
/// know their places.
pub(super) fn append(checker: &mut Checker<'_>, contacts: &mut Vec<Contact>) {
    let surfaces = contacts.len() as u16;
    let place = |value: &mut Sym| {
        let placed = graph::substitute(&[*value], |variable| match variable {
            Variable::FrictionForce(i) if i >= FIRST_DRY => Some(Sym::variable(
                Variable::FrictionForce(i - FIRST_DRY + surfaces),
            )),
            _ => None,
        });
        *value = placed[0];
    };
    let outputs = checker.shown.outputs.iter_mut();
    outputs.for_each(|output| place(&mut output.value));
    let task = &mut checker.task;
    let costs = task.cost.iter_mut();
    let costs = costs.flat_map(|cost| cost.running.iter_mut().chain(&mut cost.terminal));
    costs.for_each(&place);
    let conditions = task.constraints.iter_mut().chain(&mut task.goals);
    let conditions = conditions.flat_map(|asked| &mut asked.pieces);
    conditions.for_each(|condition| place(&mut condition.function));
    let epigraphs = task.epigraphs.iter_mut();
    let rows = epigraphs.flat_map(|known| known.rows.iter_mut().chain(&mut known.at_start));
    rows.for_each(&place);
    for dry in std::mem::take(&mut checker.laws.dry) {
        contacts.push(Contact {
            unit: checker.scope.units.gap(&dry.name.text),
            loads: dry.loads,
            joint_loads: dry.joint_loads,
            ..Contact::dry(dry.name, dry.documentation, (dry.sliding, dry.bound))
        });
    }
}

/// E24: bounds that follow forces of joints, where contacts push along normals and one tangent, and nothing switches what acts.
pub(super) fn followed(checker: &mut Checker<'_>, contacts: &[Contact]) {
    let follows = |contact: &&Contact| !contact.joint_loads.is_empty();
    let Some(following) = contacts.iter().find(follows) else {
        return;
    };
    let others = contacts.iter().find_map(|contact| {
        let in_space = contact.friction.as_ref().and_then(|law| law.across);
        let what = match contact {
            Contact {
                switch: Some(_), ..
            } => "a switch",
            contact if !contact.held.is_empty() => "a contact with `holding`",
            _ if in_space.is_some() => "friction in space",
            _ => return None,
        };
        Some((contact.name.text.clone(), what))
    });
    let Some((other, what)) = others else { return };
    let message = format!(
        "the bound of dry friction `{}` follows the force of a joint, which is not known beside {what} (`{other}`); write what presses by \
         positions, velocities and controls, or let a surface carry it, whose force a bound may follow",
        following.name.text
    );
    let place = following.name.place();
    checker.diagnostics.report("E24", place, message);
}
