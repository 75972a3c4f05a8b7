//! Numbers of the declaration: defaults, bounds, start, horizon; and the formulas of the dynamics.

use super::checker::{Checker, Of};
use super::states;
use crate::ast::{Assignment, Expr, Kind, Name, Quantity, WrittenUnit};
use crate::derive::simplify;
use crate::diagnostics::{Checked, Place, Reported};
use crate::evaluate::unrepresentable;
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene;

/// The default of a parameter, in its declared unit: a constant expression. Without a unit of its
/// own it is meant in the declared one.
pub(super) fn default_value(
    checker: &mut Checker<'_>,
    name: &Name,
    value: &Expr,
    unit: Option<&WrittenUnit>,
) -> Checked<f64> {
    let sym = match names_a_later_one(checker, value) {
        true => None,
        false => Some(in_declared_unit(checker, value, unit)?),
    };
    sym.and_then(Sym::as_number).ok_or_else(|| {
        let message = format!(
            "the default of parameter `{}` must be a number; abbreviations of other parameters belong to `let`",
            name.text
        );
        checker.diagnostics.syntax(value.place, message)
    })
}

/// Whether an expression contains the name of a parameter that is declared behind it.
fn names_a_later_one(checker: &Checker<'_>, expr: &Expr) -> bool {
    match &expr.kind {
        Kind::Name(name) => checker.scope.later.contains(&name.text),
        _ => {
            let mut parts = expr.children().into_iter();
            parts.any(|part| names_a_later_one(checker, part))
        }
    }
}

/// An expression as a number in a declared unit: bare numbers are in that unit already, anything
/// else is in SI units and converted.
pub(super) fn in_declared_unit(
    checker: &mut Checker<'_>,
    expr: &Expr,
    unit: Option<&WrittenUnit>,
) -> Checked<Sym> {
    let value = checker.scalar(expr)?;
    if is_bare(expr) {
        return Ok(value);
    }
    let value = value.scaled(1.0 / scene::scale(unit));
    match graph::take_fault() {
        Some(fault) => Err(unrepresentable(fault, expr, checker.diagnostics)),
        None => Ok(value),
    }
}

/// Bounds of coordinates, controls or states.
pub(super) fn bounds(checker: &mut Checker<'_>, quantities: &[Quantity], of: Of) -> Checked<()> {
    for quantity in quantities {
        let (name, unit) = (&quantity.name.text, quantity.unit.as_ref());
        let mut known = checker.list(of).iter();
        let index = known.position(|known| known.name.text == *name);
        let (Some(index), Some(bounds)) = (index, &quantity.bounds) else {
            continue;
        };
        if let Ok(range) = range(checker, bounds, unit, name) {
            checker.list(of)[index].bounds = Some(range);
        }
    }
    Ok(())
}

/// E17: bounds in the declared unit. A unit behind the upper bound is meant for both: `0.3..=0.5 [m]`.
pub(super) fn range(
    checker: &mut Checker<'_>,
    (lower, upper): &(Expr, Expr),
    unit: Option<&WrittenUnit>,
    name: &str,
) -> Checked<(Sym, Sym)> {
    let shared = match own_unit(upper) {
        Some(shared) if is_bare(lower) => shared.unit.scale / scene::scale(unit),
        _ => 1.0,
    };
    let what = format!("a bound of `{name}`");
    let mut bound = |expr: &Expr, factor: f64| {
        let sym = in_declared_unit(checker, expr, unit)?.scaled(factor);
        if let Some(fault) = graph::take_fault() {
            return Err(unrepresentable(fault, expr, checker.diagnostics));
        }
        let sym = checker.constant(sym, expr, &what)?;
        checker.fixed_bound(sym, expr, name)
    };
    let (low, high) = (bound(lower, shared), bound(upper, 1.0));
    let (low, high) = (low?, high?);
    if let (Some(least), Some(most)) = (low.as_number(), high.as_number())
        && least > most
    {
        return Err(checker.diagnostics.report(
            "E17",
            lower.place.to(upper.place),
            format!(
                "lower bound {least} of `{name}` lies above its upper bound {most}; exchange them"
            ),
        ));
    }
    Ok((low, high))
}

pub(super) fn lagrangian(checker: &mut Checker<'_>, keyword: Place, expr: &Expr) -> Checked<()> {
    let value = checker.scalar(expr)?;
    if checker.lagrangian.is_some() {
        return Err(checker.diagnostics.syntax(
            keyword,
            "a scene has one `lagrangian`; add the terms up in it",
        ));
    }
    if let Some(variable) = graph::variables(&[value])
        .into_iter()
        .find(|variable| matches!(variable, Variable::Control(_)))
    {
        return Err(checker.diagnostics.syntax(
            expr.place,
            format!(
                "the Lagrangian depends on {}; a control acts through `forces {{ ... }}`",
                checker.in_words(variable)
            ),
        ));
    }
    super::rules::smooth(value, expr, checker)?;
    checker.lagrangian = Some((value, keyword));
    Ok(())
}

pub(super) fn dissipation(checker: &mut Checker<'_>, keyword: Place, expr: &Expr) -> Checked<()> {
    let value = checker.scalar(expr)?;
    if checker.dissipation.is_some() {
        return Err(checker.diagnostics.syntax(
            keyword,
            "a scene has one `dissipation`; add the terms up in it",
        ));
    }
    if !graph::depends_on(value, |variable| matches!(variable, Variable::Velocity(_))) {
        return Err(checker.diagnostics.report(
            "E04",
            expr.place,
            "the dissipation contains no velocity; write e.g. `c/2*dot(y)^2` for a damper",
        ));
    }
    super::rules::smooth(value, expr, checker)?;
    damping_grows(checker, value, expr)?;
    damping_is_not_negative(checker, value, expr)?;
    checker.dissipation = Some(value);
    Ok(())
}

/// E10: no velocity enters linearly only. A power like that has no smallest value, so in one direction it is fed in, by a
/// force that no velocity changes.
fn damping_grows(checker: &mut Checker<'_>, dissipation: Sym, expr: &Expr) -> Checked<()> {
    let velocities = (0..checker.coordinates.len()).map(|i| Variable::Velocity(i as u16));
    let velocities: Vec<Variable> = velocities.collect();
    let slopes = graph::gradient(dissipation, &velocities);
    for (coordinate, slope) in checker.coordinates.iter().zip(slopes) {
        let slope = simplify(slope);
        if slope.is_structural_zero() {
            continue;
        }
        let grows = graph::gradient(slope, &velocities);
        if grows
            .into_iter()
            .all(|part| simplify(part).is_structural_zero())
        {
            let name = &coordinate.name.text;
            let message = format!(
                "the dissipation is linear in `dot({name})`: its force is the same at any velocity, so it feeds in \
                 energy one way; a damper is quadratic or of higher degree, as in `c/2*dot({name})^2`, and friction of \
                 constant size is `dry friction`, as in `dry friction rail: bound f, sliding dot({name})`"
            );
            return Err(checker.diagnostics.report("E10", expr.place, message));
        }
    }
    Ok(())
}

/// E10: where damping is a constant for the defaults of the parameters, it takes energy out.
fn damping_is_not_negative(
    checker: &mut Checker<'_>,
    dissipation: Sym,
    expr: &Expr,
) -> Checked<()> {
    for (i, coordinate) in checker.coordinates.iter().enumerate() {
        let velocity = Variable::Velocity(i as u16);
        let slope = graph::partial(&[dissipation], velocity);
        let damping = graph::partial(&slope, velocity)[0];
        if checker.at_default(damping).is_some_and(|value| value < 0.0) {
            let message = format!(
                "the dissipation is negative: with the defaults of the parameters it feeds energy into \
                 `dot({})`; a damper is written with a plus sign, as in `c/2*dot(y)^2`",
                coordinate.name.text
            );
            return Err(checker.diagnostics.report("E10", expr.place, message));
        }
    }
    Ok(())
}

pub(super) fn forces(checker: &mut Checker<'_>, assignments: &[Assignment]) -> Checked<()> {
    for assignment in assignments {
        checker.scope.acts = true;
        let value = checker.scalar(&assignment.value);
        checker.scope.acts = false;
        let (Ok(index), Ok(value)) = (checker.coordinate_index(&assignment.target), value) else {
            continue;
        };
        if assignment.velocity {
            checker.diagnostics.syntax(
                assignment.target.place(),
                format!(
                    "a force acts on a coordinate; write `{}: ...`",
                    assignment.target.text
                ),
            );
            continue;
        }
        checker.forces.push((index, value));
    }
    Ok(())
}

pub(super) fn start_statement(
    checker: &mut Checker<'_>,
    assignments: &[Assignment],
) -> Checked<()> {
    checker.start.extend_from_slice(assignments);
    Ok(())
}

/// Initial values `(q, v)` in declared units, as far as they are declared and known.
pub(super) struct StartValues {
    pub(super) declared: Vec<Option<(Sym, Place)>>,
    /// Whether each declared value is known.
    pub(super) complete: bool,
}

impl StartValues {
    /// These values, and where there are none those of `others`.
    pub(super) fn or(mut self, others: &Self) -> Self {
        for (own, other) in self.declared.iter_mut().zip(&others.declared) {
            *own = own.or(*other);
        }
        self.complete &= others.complete;
        self
    }

    /// Initial coordinates and velocities; zero where nothing is declared.
    pub(super) fn values(self) -> Checked<(Vec<Sym>, Vec<Sym>)> {
        if !self.complete {
            return Err(Reported);
        }
        let n = self.declared.len() / 2;
        let values = self.declared.into_iter();
        let mut values: Vec<Sym> = values
            .map(|value| value.map_or(Sym::ZERO, |(value, _)| value))
            .collect();
        let velocities = values.split_off(n);
        Ok((values, velocities))
    }
}

/// A start value, of parameters only.
fn start_value(checker: &mut Checker<'_>, sym: Sym, expr: &Expr, shown: &str) -> Checked<Sym> {
    let variables = graph::variables(&[sym]);
    let mut coordinates = variables.into_iter();
    let Some(index) = coordinates.find_map(|variable| match variable {
        Variable::Coordinate(index) => Some(usize::from(index)),
        _ => None,
    }) else {
        return checker.constant(sym, expr, &format!("the start value of `{shown}`"));
    };
    let name = &checker.coordinates[index].name.text;
    let message = format!(
        "the start value of `{shown}` depends on the coordinate `{name}`; make the start value of `{name}` a parameter, \
         and use that in both"
    );
    Err(checker.diagnostics.syntax(expr.place, message))
}

/// Checks and evaluates what `start` says.
pub(super) fn start_values(checker: &mut Checker<'_>) -> StartValues {
    let assignments = std::mem::take(&mut checker.start);
    let values = assigned(checker, &assignments);
    if values.complete {
        free_start_within_bounds(checker, &values.declared);
    }
    values
}

/// Checks and evaluates start values.
pub(super) fn assigned(checker: &mut Checker<'_>, assignments: &[Assignment]) -> StartValues {
    let n = checker.coordinates.len() + checker.states.len();
    let mut values: Vec<Option<(Sym, Place)>> = vec![None; 2 * n];
    let mut failed = false;
    for assignment in assignments {
        let value = match states::index(checker, &assignment.target) {
            Some(state) => state_start(checker, assignment, state),
            None => coordinate_start(checker, assignment, n),
        };
        let Ok((slot, value)) = value else {
            failed = true;
            continue;
        };
        if values[slot]
            .replace((value, assignment.value.place))
            .is_some()
        {
            checker.diagnostics.syntax(
                assignment.target.place(),
                format!("`{}` has two start values; keep one", shown(assignment)),
            );
            failed = true;
        }
    }
    StartValues {
        declared: values,
        complete: !failed,
    }
}

/// The start value of a coordinate or a velocity, and its place in `(q, v)` of the length `2 n`.
fn coordinate_start(
    checker: &mut Checker<'_>,
    assignment: &Assignment,
    n: usize,
) -> Checked<(usize, Sym)> {
    let index = checker.coordinate_index(&assignment.target)?;
    let unit = checker.coordinates[index].unit.clone();
    let value = start_number(
        checker,
        &assignment.value,
        unit.as_ref(),
        &shown(assignment),
    )?;
    if assignment.velocity {
        return Ok((n + index, value));
    }
    if let Some(bounds) = checker.coordinates[index].bounds {
        checker.within(
            value,
            bounds,
            assignment.value.place,
            &assignment.target.text,
        );
    }
    Ok((index, value))
}

/// The start value of a state, and its place in `(q, v)`.
fn state_start(
    checker: &mut Checker<'_>,
    assignment: &Assignment,
    state: usize,
) -> Checked<(usize, Sym)> {
    let name = &assignment.target;
    if assignment.velocity {
        let message = format!(
            "`{0}` is a state, whose rate stands in `rates`; its start value is written `{0}: ...`",
            name.text
        );
        return Err(checker.diagnostics.syntax(name.place(), message));
    }
    let unit = checker.states[state].unit.clone();
    let value = start_number(checker, &assignment.value, unit.as_ref(), &name.text)?;
    if let Some(bounds) = checker.states[state].bounds {
        checker.within(value, bounds, assignment.value.place, &name.text);
    }
    Ok((states::place(checker, state), value))
}

/// A start value in the unit of what is `shown`.
fn start_number(
    checker: &mut Checker<'_>,
    value: &Expr,
    unit: Option<&WrittenUnit>,
    shown: &str,
) -> Checked<Sym> {
    let sym = in_declared_unit(checker, value, unit)?;
    start_value(checker, sym, value, shown)
}

/// What an assignment is to.
pub(super) fn shown(assignment: &Assignment) -> String {
    let name = &assignment.target.text;
    if assignment.velocity {
        format!("dot({name})")
    } else {
        name.clone()
    }
}

pub(super) fn horizon(checker: &mut Checker<'_>, keyword: Place, expr: &Expr) -> Checked<()> {
    let value = checker.scalar(expr)?;
    let value = checker.constant(value, expr, "the horizon")?;
    if checker.horizon.is_some() {
        return Err(checker
            .diagnostics
            .syntax(keyword, "a scene has one `horizon`; keep one"));
    }
    if let Some(value) = value.as_number()
        && value <= 0.0
    {
        return Err(checker.diagnostics.syntax(
            expr.place,
            format!("the horizon is {value} s; it must be above 0"),
        ));
    }
    checker.horizon = Some(value);
    Ok(())
}

/// E17: guesses of free initial values lie between their bounds. `start` is `(q, v)`, with the places
/// of the values that are declared.
fn free_start_within_bounds(checker: &mut Checker<'_>, start: &[Option<(Sym, Place)>]) {
    for free in std::mem::take(&mut checker.task.free) {
        let (value, place) = start[free.index].unwrap_or((Sym::ZERO, free.place));
        if let Some(bounds) = free.bounds {
            checker.within(value, bounds, place, &free.shown);
        }
        checker.task.free.push(free);
    }
}

/// The unit of a number that carries one, possibly with a sign.
fn own_unit(expr: &Expr) -> Option<&WrittenUnit> {
    match &expr.kind {
        Kind::Number { unit, .. } => unit.as_ref(),
        Kind::Negate(inner) => own_unit(inner),
        _ => None,
    }
}

/// Whether an expression is a number without unit, possibly with sign and arithmetic: such a number is
/// meant in the unit of the declaration it belongs to.
pub(crate) fn is_bare(expr: &Expr) -> bool {
    match &expr.kind {
        Kind::Number { unit, .. } => unit.is_none(),
        Kind::Name(name) => name.text == "pi",
        Kind::Negate(inner) => is_bare(inner),
        Kind::Chain(..) => expr.children().into_iter().all(is_bare),
        _ => false,
    }
}

/// E07: a value of an instant, at which a control may jump.
pub(super) fn of_an_instant(checker: &mut Checker<'_>, expr: &Expr) -> Checked<Sym> {
    let value = checker.scalar(expr)?;
    let mut variables = graph::variables(&[value]).into_iter();
    let Some(control) = variables.find(|variable| matches!(variable, Variable::Control(_))) else {
        return Ok(value);
    };
    let message = format!(
        "`{expr}` depends on {}, which may jump where the condition comes true; use what moves and the time",
        checker.in_words(control)
    );
    Err(checker.diagnostics.report("E07", expr.place, message))
}
