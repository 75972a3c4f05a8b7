//! Units of whole statements.

use super::walk::{Units, Walk};
use super::{angle, shown};
use crate::ast::{
    Assignment, Condition, Expr, FreeStart, Kind, Law, Name, Quantity, Scene, Statement,
    WrittenUnit,
};
use crate::check::law::velocities;
use crate::check::measured::contains_misfit;
use crate::check::values::is_bare;
use crate::diagnostics::{Checked, Reported};
use crate::dimension::Dimension;
use crate::words;

pub(super) fn declare(walk: &mut Walk<'_>, scene: &Scene) {
    for statement in &scene.statements {
        if let Statement::At { values, .. } = statement {
            for value in values {
                let name = &value.target.text;
                let dimension = walk.unifier.unknown(name);
                walk.values.insert(name.clone(), Units::Scalar(dimension));
            }
        }
        let (Statement::Parameters(list)
        | Statement::Coordinates(list)
        | Statement::Controls(list)
        | Statement::States(list)) = statement
        else {
            continue;
        };
        if matches!(statement, Statement::Coordinates(_)) {
            walk.coordinates
                .extend(list.iter().map(|quantity| quantity.name.clone()));
        }
        for quantity in list {
            if quantity
                .unit
                .as_ref()
                .is_some_and(|unit| unit.text == "rad")
            {
                walk.radians.insert(quantity.name.text.clone());
            }
            let dimension = match &quantity.unit {
                Some(written) => Dimension::of(written.unit),
                None => walk.unifier.unknown(&quantity.name.text),
            };
            walk.values
                .insert(quantity.name.text.clone(), Units::Scalar(dimension));
        }
    }
}

pub(super) fn statement(walk: &mut Walk<'_>, statement: &Statement) -> Checked<()> {
    match statement {
        Statement::Parameters(list)
        | Statement::Coordinates(list)
        | Statement::Controls(list)
        | Statement::States(list) => {
            for quantity in list {
                let _: Checked<()> = declared_quantity(walk, quantity);
            }
            Ok(())
        }
        Statement::Let { name, unit, value } => abbreviation(walk, (name, unit.as_ref()), value),
        Statement::Function {
            name,
            arguments,
            body,
        } => {
            walk.functions
                .insert(name.text.clone(), (arguments.clone(), body.clone()));
            Ok(())
        }
        Statement::Lagrangian { value, .. } => lagrangian(walk, value),
        Statement::Dissipation { value, .. } => dissipation(walk, value),
        Statement::Forces(assignments) => each(walk, assignments, force),
        Statement::Rates(assignments) => each(walk, assignments, rate),
        Statement::Surface {
            name, left, right, ..
        } => {
            let result = surface(walk, name, left, right);
            noted(walk, name, result)
        }
        Statement::Impact { surfaces, law } => impact_law(walk, surfaces, law),
        Statement::Dry { .. } => dry_friction(walk, statement),
        Statement::Joint { name, .. } => {
            let result = joint(walk, statement);
            noted(walk, name, result)
        }
        Statement::Minimize { value, .. } if contains_misfit(value) => Ok(()),
        Statement::Minimize { value, .. } => walk.scalar(value).map(|_| ()),
        Statement::Constraint { name, condition } => {
            let what = format!("both sides of constraint `{}`", name.text);
            let own = comparison(walk, condition, &what)?;
            walk.constraints.push(own);
            Ok(())
        }
        Statement::Finally(goals) => finally(walk, goals),
        Statement::Free(values) => {
            for value in values {
                let _: Checked<()> = free(walk, value);
            }
            Ok(())
        }
        // Outputs that are measured may stand below.
        Statement::Measured(_) => Ok(()),
        Statement::When {
            condition,
            assignments,
        } => {
            let _: Checked<Dimension> = comparison(walk, condition, "both sides of a condition");
            each(walk, assignments, reset)
        }
        Statement::At {
            time,
            conditions,
            values,
            ..
        } => at(walk, time, conditions, values),
        Statement::Start(assignments) => starts(walk, assignments),
        Statement::Horizon { value, .. } => {
            walk.given(value, &Dimension::second(), "the horizon is a time")
        }
        Statement::Outputs(quantities) => shown::outputs(walk, quantities),
        Statement::Picture { shapes, .. } => shown::picture(walk, shapes),
    }
}

/// An abbreviation; one with a unit has it for its uses whatever its value has, so that these give no second message.
fn abbreviation(
    walk: &mut Walk<'_>,
    (name, unit): (&Name, Option<&WrittenUnit>),
    value: &Expr,
) -> Checked<()> {
    let own = walk.units(value)?;
    let Some(written) = unit else {
        walk.values.insert(name.text.clone(), own);
        return Ok(());
    };
    let wanted = Dimension::of(written.unit);
    let declared = own.map(|_| wanted.clone());
    walk.values.insert(name.text.clone(), declared);
    let reason = format!("`{}` is declared so", name.text);
    let mut components = own.components().iter();
    components.try_for_each(|own| walk.expect(value, own, &wanted, &reason))
}

/// Conditions at the end; each reports its own mistakes.
fn finally(walk: &mut Walk<'_>, goals: &[Condition]) -> Checked<()> {
    for goal in goals {
        if let Ok(own) = comparison(walk, goal, "both sides of a terminal condition") {
            walk.goals.push(own);
        }
    }
    Ok(())
}

/// Conditions at a time, and values that are asked for then.
fn at(
    walk: &mut Walk<'_>,
    time: &Expr,
    conditions: &[Condition],
    values: &[Assignment],
) -> Checked<()> {
    walk.given(time, &Dimension::second(), "conditions hold at a time")?;
    for condition in conditions {
        let own = comparison(walk, condition, "both sides of a condition")?;
        walk.goals.push(own);
    }
    if conditions.is_empty() && !values.is_empty() {
        // That the time has come.
        walk.goals.push(Dimension::one());
    }
    each(walk, values, reset)
}

/// Each assignment reports its own mistakes; the next one is checked all the same.
fn each(
    walk: &mut Walk<'_>,
    assignments: &[Assignment],
    one: fn(&mut Walk<'_>, &Assignment) -> Checked<()>,
) -> Checked<()> {
    for assignment in assignments {
        let _: Checked<()> = one(walk, assignment);
    }
    Ok(())
}

fn lagrangian(walk: &mut Walk<'_>, value: &Expr) -> Checked<()> {
    let own = walk.scalar(value)?;
    let energy = walk.energy.clone();
    walk.unifier.unify(&own, &energy);
    Ok(())
}

fn dissipation(walk: &mut Walk<'_>, value: &Expr) -> Checked<()> {
    let wanted = walk.energy.over(&Dimension::second());
    walk.fits(value, &wanted, "the dissipation is a power")
}

/// Remembers what `name` belongs to if its units differ.
fn noted(walk: &mut Walk<'_>, name: &Name, result: Checked<()>) -> Checked<()> {
    if result.is_err() {
        walk.faulty.insert(name.text.clone());
    }
    result
}

fn surface(walk: &mut Walk<'_>, name: &Name, left: &Expr, right: &Expr) -> Checked<()> {
    let what = format!("both sides of surface `{}`", name.text);
    let gap = compared(walk, (left, right), &what)?;
    walk.gaps.push((name.text.clone(), gap));
    Ok(())
}

/// Both sides of a joint agree, component by component. A force does work on what it holds: a joint of velocities is measured
/// by the way.
fn joint(walk: &mut Walk<'_>, statement: &Statement) -> Checked<()> {
    let Statement::Joint {
        name, left, right, ..
    } = statement
    else {
        return Ok(());
    };
    angle::compared(walk, left, right);
    let (own, its) = (walk.units(left), walk.units(right));
    let (own, its) = (own?, its?);
    let place = left.place.to(right.place);
    let what = format!("both sides of joint `{}`", name.text);
    let (first, second) = (own.components(), its.components());
    let mut unit = None;
    for i in 0..first.len().max(second.len()) {
        // A zero stands for all components of the other side.
        let pair = [first, second].map(|list| list.get(i).or(list.first()));
        let [Some(own), Some(its)] = pair else {
            return Err(Reported);
        };
        walk.same(place, (left, own), (right, its), &what)?;
        let one = unit.get_or_insert_with(|| own.clone());
        let what = format!("the components of joint `{}`", name.text);
        walk.same(place, (left, one), (left, own), &what)?;
    }
    let mut unit = unit.ok_or(Reported)?;
    if walk.rolling.contains(&name.text) {
        unit = unit.times(&Dimension::second());
    }
    let count = first.len().max(second.len());
    walk.joints.push((name.text.clone(), count));
    walk.gaps.push((name.text.clone(), unit));
    Ok(())
}

fn declared_quantity(walk: &mut Walk<'_>, quantity: &Quantity) -> Checked<()> {
    let wanted = walk.named(&quantity.name);
    let mut exprs: Vec<&Expr> = quantity.value.iter().collect();
    if let Some((lower, upper)) = &quantity.bounds {
        exprs.extend([lower, upper]);
    }
    for expr in exprs {
        if is_bare(expr) {
            angle::of_name(walk, &quantity.name.text, expr);
            continue;
        }
        let reason = format!("`{}` is declared so", quantity.name.text);
        walk.fits(expr, &wanted, &reason)?;
    }
    Ok(())
}

fn force(walk: &mut Walk<'_>, assignment: &Assignment) -> Checked<()> {
    if !walk
        .coordinates
        .iter()
        .any(|known| known.text == assignment.target.text)
    {
        return Err(Reported);
    }
    let own = walk.scalar(&assignment.value)?;
    let coordinate = walk.named(&assignment.target);
    let wanted = walk.energy.over(&coordinate);
    let reason = format!(
        "a force on `{}` is the Lagrangian's unit over that of the coordinate",
        assignment.target.text
    );
    // On an angle acts a torque.
    walk.expect_called(&assignment.value, (&own, &wanted), &reason, ["J", "N m"])
}

fn starts(walk: &mut Walk<'_>, assignments: &[Assignment]) -> Checked<()> {
    for assignment in assignments {
        let result = start(walk, assignment);
        let _: Checked<()> = noted(walk, &assignment.target, result);
    }
    Ok(())
}

/// What a state changes by.
fn rate(walk: &mut Walk<'_>, assignment: &Assignment) -> Checked<()> {
    let wanted = walk.named(&assignment.target).over(&Dimension::second());
    let reason = format!(
        "the rate of `{}` is the unit of the state over s",
        assignment.target.text
    );
    walk.fits(&assignment.value, &wanted, &reason)
}

/// What a state or a velocity is set to.
fn reset(walk: &mut Walk<'_>, assignment: &Assignment) -> Checked<()> {
    let (wanted, shown) = of_target(walk, &assignment.target, assignment.velocity);
    let reason = format!("`{shown}` is set to it");
    walk.given(&assignment.value, &wanted, &reason)
}

fn start(walk: &mut Walk<'_>, assignment: &Assignment) -> Checked<()> {
    if is_bare(&assignment.value) {
        if !assignment.velocity {
            angle::of_name(walk, &assignment.target.text, &assignment.value);
        }
        return Ok(());
    }
    let own = walk.scalar(&assignment.value)?;
    let (wanted, shown) = of_target(walk, &assignment.target, assignment.velocity);
    let reason = format!("it is the start value of `{shown}`");
    let turns = assignment.velocity && angle::is_declared(walk, &assignment.target.text);
    let called = if turns { ["1/s", "rad/s"] } else { ["", ""] };
    walk.expect_called(&assignment.value, (&own, &wanted), &reason, called)
}

/// Components of an impulse direction are displacements of the coordinates, up to one factor.
fn impulse_direction(walk: &mut Walk<'_>, direction: &Expr) -> Checked<()> {
    let Kind::Vector(items) = &direction.kind else {
        walk.units(direction)?;
        return Ok(());
    };
    let coordinates: Vec<Name> = walk.coordinates.clone();
    let mut first: Option<Dimension> = None;
    for (item, coordinate) in items.iter().zip(&coordinates) {
        let own = walk.scalar(item)?;
        let unit = walk.named(coordinate);
        let known = first.get_or_insert_with(|| own.over(&unit));
        let reason = format!(
            "components of an impulse direction are proportional to displacements, here of `{}`",
            coordinate.text
        );
        walk.expect(item, &own, &known.times(&unit), &reason)?;
    }
    Ok(())
}

fn comparison(walk: &mut Walk<'_>, condition: &Condition, what: &str) -> Checked<Dimension> {
    compared(walk, (&condition.left, &condition.right), what)
}

/// Unit of the difference of both sides.
fn compared(walk: &mut Walk<'_>, (left, right): (&Expr, &Expr), what: &str) -> Checked<Dimension> {
    angle::compared(walk, left, right);
    let (own, its) = (walk.scalar(left), walk.scalar(right));
    let (own, its) = (own?, its?);
    let place = left.place.to(right.place);
    walk.same(place, (left, &own), (right, &its), what)?;
    Ok(own)
}

fn free(walk: &mut Walk<'_>, value: &FreeStart) -> Checked<()> {
    let Some((lower, upper)) = &value.bounds else {
        return Ok(());
    };
    let (wanted, shown) = of_target(walk, &value.target, value.velocity);
    let reason = format!("it bounds `{shown}`");
    walk.given(lower, &wanted, &reason)?;
    walk.given(upper, &wanted, &reason)
}

/// Unit and name of a coordinate or a velocity.
fn of_target(walk: &mut Walk<'_>, target: &Name, velocity: bool) -> (Dimension, String) {
    let own = walk.named(target);
    if velocity {
        (
            own.over(&Dimension::second()),
            format!("dot({})", target.text),
        )
    } else {
        (own, target.text.clone())
    }
}

fn impact_law(walk: &mut Walk<'_>, surfaces: &[Name], law: &Law) -> Checked<()> {
    let speed = law
        .sliding
        .as_ref()
        .and_then(|expr| velocities(expr).first());
    let speed = speed.and_then(|expr| walk.units(expr).ok()?.components().first().cloned());
    let speed = speed.unwrap_or_else(|| {
        let gap = walk.gap(&surfaces[0].text);
        gap.map_or_else(
            || walk.unifier.unknown(words::SPEED),
            |gap| gap.over(&Dimension::second()),
        )
    });
    for (coefficient, of) in [
        (&law.restitution, "restitution"),
        (&law.friction, "friction"),
        (&law.at_rest, "friction"),
    ] {
        let Some(expr) = coefficient else { continue };
        let Ok(own) = with_speed(walk, &speed, expr) else {
            continue;
        };
        let reason = format!("a coefficient of {of} is a ratio");
        let _: Checked<()> = walk.expect(expr, &own, &Dimension::one(), &reason);
    }
    for expr in law.sliding.as_ref().map_or(&[][..], velocities) {
        let Ok(own) = walk.units(expr) else { continue };
        for own in own.components() {
            let own = (surfaces.to_vec(), expr.clone(), own.clone());
            walk.sliding.push(own);
        }
    }
    match &law.along {
        Some(direction) => impulse_direction(walk, direction),
        None => Ok(()),
    }
}

/// The unit of what may contain the speed of sliding, by the word for it unless a declaration has taken that.
fn with_speed(walk: &mut Walk<'_>, speed: &Dimension, expr: &Expr) -> Checked<Dimension> {
    let taken = walk.values.contains_key(words::SPEED);
    if !taken {
        let speed = Units::Scalar(speed.clone());
        walk.values.insert(words::SPEED.to_owned(), speed);
    }
    let own = walk.scalar(expr);
    if !taken {
        walk.values.remove(words::SPEED);
    }
    own
}

/// A force does work along the way on which it brakes.
fn dry_friction(walk: &mut Walk<'_>, statement: &Statement) -> Checked<()> {
    let Statement::Dry {
        name,
        bound,
        sliding,
        ..
    } = statement
    else {
        return Ok(());
    };
    let velocity = walk.scalar(sliding)?;
    let own = with_speed(walk, &velocity, bound)?;
    let way = velocity.times(&Dimension::second());
    let wanted = walk.energy.over(&way);
    walk.gaps.push((name.text.clone(), way));
    let reason = format!(
        "the bound of `{}` is the Lagrangian's unit over that of its sliding velocity times s",
        name.text
    );
    walk.expect(bound, &own, &wanted, &reason)
}

/// Deviations of measurements have the unit of what is measured; start values of an experiment are as those of the scene.
pub(super) fn measured(walk: &mut Walk<'_>, scene: &Scene) {
    for statement in &scene.statements {
        let Statement::Measured(measured) = statement else {
            continue;
        };
        for quantity in &measured.quantities {
            let (wanted, shown) = of_target(walk, &quantity.target, quantity.velocity);
            let reason = format!("it is the standard deviation of the measured `{shown}`");
            let _: Checked<()> = walk.given(&quantity.within, &wanted, &reason);
        }
        let _: Checked<()> = starts(walk, &measured.start);
    }
}

/// Sliding velocities are measured like the gaps, over seconds.
pub(super) fn sliding_velocities(walk: &mut Walk<'_>) {
    for (surfaces, expr, own) in std::mem::take(&mut walk.sliding) {
        for surface in surfaces {
            let Some(gap) = walk.gap(&surface.text) else {
                continue;
            };
            let wanted = gap.over(&Dimension::second());
            let reason = format!(
                "the sliding velocity of `{}` has the unit of its gap over s",
                surface.text
            );
            let _: Checked<()> = walk.expect(&expr, &own, &wanted, &reason);
        }
    }
}
