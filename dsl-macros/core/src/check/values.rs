//! Numbers of the declaration: defaults, bounds, start, horizon; and the formulas of the dynamics.

use super::checker::{Checker, Of};
use super::rules::smooth;
use super::states;
use crate::ast::{Assignment, Condition, Expr, Kind, Name, Positive, Quantity, WrittenUnit};
use crate::derive::simplify;
use crate::diagnostics::{Checked, Place, Reported};
use crate::evaluate::{Meaning, Number, Value, unrepresentable};
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{self, Coordinate};

/// The default of a parameter, in its declared unit: a constant expression. Without a unit of its
/// own it is meant in the declared one.
pub(super) fn default_value(
    checker: &mut Checker<'_>,
    quantity: &Quantity,
    value: &Expr,
) -> Checked<f64> {
    let of = Target::declared(&quantity.name, quantity.unit.as_ref());
    let later = |part: &Expr| matches!(&part.kind, Kind::Name(name) if checker.scope.later.contains(&name.text));
    let sym = match value.any(&later) {
        true => None,
        false => Some(in_declared_unit(checker, value, &of, DECLARED)?),
    };
    sym.and_then(Sym::as_number).ok_or_else(|| {
        let message = format!(
            "the default of parameter `{}` must be a number; abbreviations of other parameters belong to `let`",
            quantity.name.text
        );
        checker.diagnostics.syntax(value.place, message)
    })
}

/// E10 and E27: numbers that are above zero for the defaults of the parameters, and in each run as far as they depend on parameters.
pub(super) fn positive(checker: &mut Checker<'_>, positive: &Positive) -> Checked<()> {
    let Positive { of, part, .. } = positive;
    if checker.diagnostics.is_poisoned(of) {
        return Err(Reported);
    }
    for own in checker.value(&positive.value)?.components() {
        let fails = |value: f64| value.is_nan() || value <= 0.0;
        let moves = graph::depends_on(own.sym, Variable::moves);
        let message = match checker.at_default(own.sym) {
            Some(value) if fails(value) => Some(positive.message.clone()),
            _ if moves && positive.code == "E27" => Some(format!(
                "{of} moves; its corners follow from numbers and parameters"
            )),
            _ => None,
        };
        if let Some(message) = message {
            checker.diagnostics.poison(of);
            let place = positive.value.place;
            return Err(checker.diagnostics.report(positive.code, place, message));
        }
        if !moves && own.sym.as_number().is_none() {
            checker.laws.positive.push(scene::Positive {
                what: format!("{of}{part} ({})", positive.code),
                unit: checker.scope.units.known(&own.unit),
                value: own.sym,
            });
        }
    }
    Ok(())
}

/// What a number is of: a coordinate, its velocity, or anything else with a unit.
pub(super) struct Target {
    name: String,
    velocity: bool,
    /// The unit of the name, as declared.
    unit: Option<WrittenUnit>,
    bounds: Option<(Sym, Sym)>,
}

impl Target {
    /// What belongs to the declaration of a name with a unit.
    pub(super) fn declared(name: &Name, unit: Option<&WrittenUnit>) -> Self {
        Self {
            name: name.text.clone(),
            velocity: false,
            unit: unit.cloned(),
            bounds: None,
        }
    }

    /// A coordinate or a state, or the velocity of a coordinate, and its place in `(q, v)`.
    pub(super) fn of(
        checker: &mut Checker<'_>,
        name: &Name,
        velocity: bool,
    ) -> Checked<(usize, Self)> {
        let n = checker.coordinates.len() + checker.states.len();
        let (place, known) = match states::index(checker, name) {
            Some(state) if !velocity => (states::place(checker, state), &checker.states[state]),
            _ => {
                let index = checker.coordinate_index(name)?;
                let place = if velocity { n + index } else { index };
                (place, &checker.coordinates[index])
            }
        };
        let target = Self {
            velocity,
            bounds: known.bounds,
            ..Self::declared(name, known.unit.as_ref())
        };
        Ok((place, target))
    }

    /// As it is written.
    pub(super) fn shown(&self) -> String {
        written(&self.name, self.velocity)
    }
}

/// A name, or its velocity, as it is written.
fn written(name: &str, velocity: bool) -> String {
    match velocity {
        true => format!("dot({name})"),
        false => name.to_owned(),
    }
}

/// Why a number of a declaration has its unit.
pub(super) const DECLARED: [&str; 2] = ["", " is declared so"];

/// An expression as a number in the declared unit of what it is of, which it has for the reason in words around that.
pub(super) fn in_declared_unit(
    checker: &mut Checker<'_>,
    expr: &Expr,
    of: &Target,
    because: [&str; 2],
) -> Checked<Sym> {
    let own = checker.number(expr)?;
    converted(checker, (expr, &own), of, because)
}

/// E03 and E23: a number in the declared unit of what it is of. Bare ones are in that unit already, anything else is in SI units
/// and converted.
pub(super) fn converted(
    checker: &mut Checker<'_>,
    (expr, own): (&Expr, &Number),
    of: &Target,
    [before, behind]: [&str; 2],
) -> Checked<Sym> {
    let mut wanted = checker.unit_of(&of.name);
    let units = &mut checker.scope.units;
    let mut called = ["", ""];
    if of.velocity {
        wanted = wanted.over(&units.second());
        if units.is_angle(&of.name) {
            called = ["1/s", "rad/s"];
        }
    } else {
        units.angle_of(&of.name, expr, own.sym);
    }
    if expr.is_bare() {
        return Ok(own.sym);
    }
    let reason = format!("{before}`{}`{behind}", of.shown());
    units.expect_called(expr, (&own.unit, &wanted), &reason, called);
    let value = own.sym.scaled(1.0 / scene::scale(of.unit.as_ref()));
    match graph::take_fault() {
        Some(fault) => Err(unrepresentable(fault, expr, checker.diagnostics)),
        None => Ok(value),
    }
}

/// Bounds of coordinates, controls or states.
pub(super) fn bounds(checker: &mut Checker<'_>, quantities: &[Quantity], of: Of) -> Checked<()> {
    for quantity in quantities {
        let name = &quantity.name;
        let mut known = checker.list(of).iter();
        let index = known.position(|known| known.name.text == name.text);
        let (Some(index), Some(bounds)) = (index, &quantity.bounds) else {
            continue;
        };
        let target = Target::declared(name, quantity.unit.as_ref());
        if let Ok(range) = range(checker, bounds, &target, DECLARED) {
            checker.list(of)[index].bounds = Some(range);
        }
    }
    Ok(())
}

/// E17: bounds in the declared unit. A unit behind the upper bound is meant for both: `0.3..=0.5 [m]`.
pub(super) fn range(
    checker: &mut Checker<'_>,
    (lower, upper): &(Expr, Expr),
    of: &Target,
    because: [&str; 2],
) -> Checked<(Sym, Sym)> {
    let shared = match upper.unit() {
        Some(shared) if lower.is_bare() => shared.unit.scale / scene::scale(of.unit.as_ref()),
        _ => 1.0,
    };
    let name = &*of.shown();
    let what = format!("a bound of `{name}`");
    let mut bound = |expr: &Expr, factor: f64| {
        let sym = in_declared_unit(checker, expr, of, because)?.scaled(factor);
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
    let own = checker.number(expr)?;
    let energy = checker.scope.units.energy.clone();
    checker.scope.units.unify(&own.unit, &energy);
    let value = own.sym;
    if checker.lagrangian.is_some() {
        return Err(checker.diagnostics.syntax(
            keyword,
            "a scene has one `lagrangian`; add the terms up in it",
        ));
    }
    checker.free_of(
        &[value],
        Variable::is_control,
        (None, expr.place),
        |control| {
            format!(
                "the Lagrangian depends on {control}; a control acts through `forces {{ ... }}`"
            )
        },
    )?;
    smooth(value, expr, checker)?;
    checker.lagrangian = Some((value, keyword));
    Ok(())
}

pub(super) fn dissipation(checker: &mut Checker<'_>, keyword: Place, expr: &Expr) -> Checked<()> {
    let own = checker.number(expr)?;
    let units = &mut checker.scope.units;
    let wanted = units.energy.over(&units.second());
    units.expect(expr, &own.unit, &wanted, "the dissipation is a power");
    let value = own.sym;
    if checker.dissipation.is_some() {
        return Err(checker.diagnostics.syntax(
            keyword,
            "a scene has one `dissipation`; add the terms up in it",
        ));
    }
    if !graph::depends_on(value, Variable::is_velocity) {
        return Err(checker.diagnostics.report(
            "E04",
            expr.place,
            "the dissipation contains no velocity; write e.g. `c/2*dot(y)^2` for a damper",
        ));
    }
    smooth(value, expr, checker)?;
    damping_grows(checker, value, expr)?;
    damping_is_not_negative(checker, value, expr)?;
    checker.dissipation = Some(value);
    Ok(())
}

/// E10: no velocity enters linearly only. A power like that has no smallest value, so in one direction it is fed in, by a
/// force that no velocity changes.
fn damping_grows(checker: &mut Checker<'_>, dissipation: Sym, expr: &Expr) -> Checked<()> {
    let velocities = Variable::velocities(checker.coordinates.len());
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
    for (k, assignment) in assignments.iter().enumerate() {
        let name = &assignment.target;
        if assignments[..k]
            .iter()
            .any(|other| other.target.text == name.text)
        {
            let message = format!(
                "`{0}` has two entries in `forces`, which add up; write one sum, as in `{0}: a + b`, or correct the name of one",
                name.text
            );
            checker.diagnostics.warn("E19", name.place(), message);
        }
        if let Some(moved) = moved(checker, &assignment.target) {
            // Its mistakes are told; the other entries are read all the same.
            let _: Checked<()> = force_on(checker, assignment, &moved);
            continue;
        }
        checker.scope.acts = true;
        let value = checker.number(&assignment.value);
        checker.scope.acts = false;
        let name = &assignment.target.text;
        let (Ok(index), Ok(value)) = (checker.coordinate_index(&assignment.target), value) else {
            continue;
        };
        let wanted = checker.unit_of(name);
        let wanted = checker.scope.units.energy.over(&wanted);
        let reason =
            format!("a force on `{name}` is the Lagrangian's unit over that of the coordinate");
        let pair = (&value.unit, &wanted);
        // On an angle acts a torque.
        let units = &mut checker.scope.units;
        units.expect_called(&assignment.value, pair, &reason, ["J", "N m"]);
        if assignment.velocity {
            checker.diagnostics.syntax(
                assignment.target.place(),
                format!("a force acts on a coordinate; write `{name}: ...`"),
            );
            continue;
        }
        checker.forces.push((index, value.sym));
    }
    Ok(())
}

/// What a name other than that of a coordinate stands for, if coordinates move it.
fn moved(checker: &Checker<'_>, target: &Name) -> Option<Value> {
    let is_target = |known: &Coordinate| known.name.text == target.text;
    let found = match checker.scope.names.get(&target.text) {
        Some(Meaning::Value(value)) if !checker.coordinates.iter().any(is_target) => value,
        _ => return None,
    };
    let moves = |sym: &Sym| graph::depends_on(*sym, Variable::is_coordinate);
    found.syms().iter().any(moves).then(|| found.clone())
}

/// A force on what coordinates move: by its virtual work `f . dp/dq_i` on each of them.
fn force_on(checker: &mut Checker<'_>, assignment: &Assignment, moved: &Value) -> Checked<()> {
    checker.scope.acts = true;
    let force = checker.value(&assignment.value);
    checker.scope.acts = false;
    let (force, name) = (force?, &assignment.target.text);
    let place = assignment.target.place();
    let syms = moved.syms();
    let wrong = |variable: Variable| variable.is_velocity() || variable.is_control();
    checker.free_of(&syms, wrong, (Some("E07"), place), |wrong| {
        format!("a force acts on a position, and `{name}` depends on {wrong}")
    })?;
    if assignment.velocity || matches!(moved, Value::Matrix(_)) || force.syms().len() != syms.len()
    {
        let message = match syms.len() {
            1 => format!("the force on `{name}` is one number, as in `{name}: ..`"),
            more => format!("the force on `{name}` has {more} components, as that has"),
        };
        return Err(checker
            .diagnostics
            .report("E02", assignment.value.place, message));
    }
    let units = &mut checker.scope.units;
    for (own, its) in force.components().iter().zip(moved.components()) {
        let wanted = units.energy.over(&its.unit);
        let reason = format!("a force on `{name}` is the Lagrangian's unit over that of the name");
        let pair = (&own.unit, &wanted);
        units.expect_called(&assignment.value, pair, &reason, ["J", "N m"]);
    }
    let n = checker.coordinates.len();
    let mut work = vec![Sym::ZERO; n];
    for (own, its) in force.syms().into_iter().zip(syms) {
        let rates = graph::gradient(its, &Variable::coordinates(n));
        for (work, rate) in work.iter_mut().zip(rates) {
            *work += own * rate;
        }
    }
    for (i, work) in work.into_iter().enumerate() {
        if !work.is_structural_zero() {
            let scale = scene::scale(checker.coordinates[i].unit.as_ref());
            checker.forces.push((i, work.scaled(1.0 / scale)));
        }
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
    checker.tell_units();
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
        let name = &assignment.target;
        let before = checker.scope.units.found.mistakes();
        let value = start_number(checker, assignment);
        if checker.scope.units.found.mistakes() > before {
            checker.scope.units.faulty.insert(name.text.clone());
        }
        let Ok((slot, value)) = value else {
            failed = true;
            continue;
        };
        if values[slot]
            .replace((value, assignment.value.place))
            .is_some()
        {
            let shown = written(&name.text, assignment.velocity);
            let message = format!("`{shown}` has two start values; keep one");
            checker.diagnostics.syntax(name.place(), message);
            failed = true;
        }
    }
    StartValues {
        declared: values,
        complete: !failed,
    }
}

/// A start value in its declared unit, and its place in `(q, v)`.
fn start_number(checker: &mut Checker<'_>, assignment: &Assignment) -> Checked<(usize, Sym)> {
    let (name, expr) = (&assignment.target, &assignment.value);
    if assignment.velocity && states::index(checker, name).is_some() {
        let message = format!(
            "`{0}` is a state, whose rate stands in `rates`; its start value is written `{0}: ...`",
            name.text
        );
        return Err(checker.diagnostics.syntax(name.place(), message));
    }
    let (place, target) = Target::of(checker, name, assignment.velocity)?;
    let sym = in_declared_unit(checker, expr, &target, ["it is the start value of ", ""])?;
    let value = start_value(checker, sym, expr, &target.shown())?;
    if let Some(bounds) = target.bounds.filter(|_| !target.velocity) {
        checker.within(value, bounds, expr.place, &name.text);
    }
    Ok((place, value))
}

pub(super) fn horizon(checker: &mut Checker<'_>, keyword: Place, expr: &Expr) -> Checked<()> {
    let own = checker.number(expr)?;
    let second = checker.scope.units.second();
    checker.given(expr, &own, &second, "the horizon is a time");
    let value = checker.constant(own.sym, expr, "the horizon")?;
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

/// What a condition compares at an instant, not negative where it holds.
pub(super) fn condition_at_an_instant(
    checker: &mut Checker<'_>,
    condition: &Condition,
) -> Checked<Number> {
    let mut side = |expr: &Expr| {
        let value = of_an_instant(checker, expr)?;
        smooth(value.sym, expr, checker)?;
        Ok(value)
    };
    let (left, right) = (side(&condition.left), side(&condition.right));
    let sides = [(&condition.left, &left?), (&condition.right, &right?)];
    Ok(checker.difference(sides, condition.relation, "both sides of a condition"))
}

/// E07: a value of an instant, at which a control may jump.
pub(super) fn of_an_instant(checker: &mut Checker<'_>, expr: &Expr) -> Checked<Number> {
    let value = checker.number(expr)?;
    checker.free_of(&[value.sym], Variable::is_control, (Some("E07"), expr.place), |control| {
        format!(
            "`{expr}` depends on {control}, which may jump where the condition comes true; use what moves and the time"
        )
    })?;
    Ok(value)
}
