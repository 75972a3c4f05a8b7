//! Expressions over the names in force: evaluation and calls of functions need each other.

use super::algebra::{cross_product, inner_product, not_a_vector, of_numbers, power, step};
use super::edges;
use super::functions::{elementary, fades, is_derivative, takes, velocity_direction};
use super::matrix;
use super::named;
use super::number::{number, unrepresentable};
use super::recorded;
use super::remembered;
use super::scope::{Evaluation, Meaning, Role};
use super::switch;
use super::value::{Number, Value};
use crate::ast::{Expr, Kind, Link, Name, Prefix, WrittenUnit};
use crate::diagnostics::{Checked, Place, Reported, all, list};
use crate::dimension::Dimension;
use crate::graph::{self, Compose, Fault, Function, Function2, Sym, Variable};
use crate::words;
use std::rc::Rc;

/// Most nodes of the syntax tree that one scene may evaluate, calls of functions included: far above
/// any mechanism, and a second or so of compile time.
const BUDGET: usize = 300_000;

/// Deepest evaluation, functions inserted; within the stack of a thread of 2 MB, without optimization as well.
const DEPTH: usize = 300;

/// Deepest expression, abbreviations and functions inserted; far above any mechanism.
const DEEPEST: usize = 300;

/// Why an expression is refused that takes more work than a compilation can wait for.
const TOO_LARGE: &str = "the declaration grows too large to be derived: abbreviations or functions that use others twice, again and again, double each time; use fewer, or make an intermediate quantity a coordinate of its own";

const TOO_DEEP: &str = "abbreviations or functions build on each other too many times; use fewer, or make an intermediate quantity a coordinate of its own";

/// Evaluates an expression.
pub(crate) fn value(eval: &mut Evaluation<'_>, expr: &Expr) -> Checked<Value> {
    if eval.scope.depth == 0 {
        // What happened to constants elsewhere is not this expression's fault.
        graph::take_fault();
    }
    eval.scope.depth += 1;
    let value = if eval.scope.depth > DEPTH {
        Err(eval.diagnostics.report(
            "E22",
            expr.place,
            "the functions used here are nested too deeply; simplify them",
        ))
    } else {
        value_unguarded(eval, expr)
    };
    eval.scope.depth -= 1;
    let value = value?;
    if graph::is_exhausted() {
        return Err(eval.diagnostics.report("E22", expr.place, TOO_LARGE));
    }
    if value
        .components()
        .iter()
        .any(|part| part.sym.depth() > DEEPEST)
    {
        return Err(eval.diagnostics.report("E22", expr.place, TOO_DEEP));
    }
    // A derivative may cancel up to rounding; that is zero on paper.
    match graph::take_fault() {
        Some(fault) if fault.is_of_range() || !is_derivative(expr) => {
            Err(unrepresentable(fault, expr, eval.diagnostics))
        }
        _ => Ok(value),
    }
}

fn value_unguarded(eval: &mut Evaluation<'_>, expr: &Expr) -> Checked<Value> {
    eval.scope.evaluated += 1;
    if eval.scope.evaluated > BUDGET {
        return Err(eval.diagnostics.report(
            "E22",
            expr.place,
            "the declaration grows too large when its functions are inserted; simplify it",
        ));
    }
    match &expr.kind {
        Kind::Number { value, unit, .. } => Ok(Value::Scalar(Number {
            sym: written(*value, unit.as_ref()),
            unit: eval.scope.units.written(*value, unit.as_ref()),
        })),
        Kind::Name(name) => eval.scope.name(name, eval.diagnostics),
        Kind::Negate(inner) => {
            let inner = value(eval, inner)?;
            Ok(inner.map(|own| own.with(-own.sym)))
        }
        Kind::Chain(first, rest) => chain(eval, first, rest),
        Kind::Power {
            base,
            place,
            exponent,
        } => {
            let values = [base, exponent].map(|expr| value(eval, expr));
            let [base_value, exponent_value] = values;
            let values = [base_value?, exponent_value?];
            power(eval, [base, exponent], values, *place)
        }
        Kind::Call {
            function,
            arguments,
        } => call(eval, expr, function, arguments),
        Kind::Derivative {
            function,
            order,
            argument,
        } => derivative(eval, function, *order, argument),
        Kind::Norm(inner) => norm(eval, expr, inner),
        Kind::Vector(items) => vector(eval, items),
        Kind::Component { vector, name } => component(eval, expr, vector, name),
        Kind::Index { vector, index } => component_at(eval, expr, vector, *index),
        Kind::Profile {
            profile,
            argument,
            argument_unit,
            value_unit,
        } => {
            let at = eval.scope.name(argument, eval.diagnostics)?;
            let of = |unit: &Option<WrittenUnit>| unit.as_ref().map_or(1.0, |unit| unit.unit.scale);
            let (from, to) = (of(argument_unit), of(value_unit));
            let function = Function::Profile(*profile);
            let units = [argument_unit, value_unit];
            let unit = eval.scope.units.of_points(expr, &at, units);
            Ok(at.map(|at| Number {
                sym: at.sym.scaled(1.0 / from).call(function).scaled(to),
                unit: unit.clone(),
            }))
        }
    }
}

/// A number as it is written, in SI units.
fn written(value: f64, unit: Option<&WrittenUnit>) -> Sym {
    let Some(unit) = unit else {
        return Sym::number(value);
    };
    // Checked as the product of two constants.
    let checked = Sym::number(value).scaled(unit.unit.scale);
    let value = unit.unit.in_si(value);
    match value.is_finite() {
        true => Sym::number(value),
        false => checked,
    }
}

fn vector(eval: &mut Evaluation<'_>, items: &[Expr]) -> Checked<Value> {
    let mut values: Vec<Value> = Vec::with_capacity(items.len());
    let mut failed = false;
    for item in items {
        // The first item decides between a vector and the rows of a matrix.
        let rows = matches!(values.first(), Some(Value::Vector(_)));
        let value = value(eval, item).and_then(|value| {
            if rows || values.is_empty() && matches!(value, Value::Vector(_)) {
                return Ok(value);
            }
            Ok(Value::Scalar(number(item, &value, eval.diagnostics)?))
        });
        match value {
            Ok(value) => values.push(value),
            Err(Reported) => failed = true,
        }
    }
    if failed {
        return Err(Reported);
    }
    matrix::stacked(items, &values, eval.diagnostics)
}

fn component_at(
    eval: &mut Evaluation<'_>,
    expr: &Expr,
    vector: &Expr,
    index: usize,
) -> Checked<Value> {
    let value = value(eval, vector)?;
    if let Some(part) = value.at(index) {
        return Ok(part);
    }
    let (count, parts) = match &value {
        Value::Scalar(_) => return Err(not_a_vector(vector, &value, eval.diagnostics)),
        Value::Vector(components) => (components.len(), "components"),
        Value::Matrix(matrix) => (matrix.rows(), "rows"),
    };
    let message = format!("`{vector}` has {count} {parts}, counted from 0; there is no [{index}]");
    Err(eval.diagnostics.report("E02", expr.place, message))
}

fn chain(eval: &mut Evaluation<'_>, first: &Expr, rest: &[Link]) -> Checked<Value> {
    let operands = std::iter::once(first).chain(rest.iter().map(|link| &link.operand));
    let values = all(operands.map(|operand| value(eval, operand)))?;
    // What a function makes small beside another constant was not written small: far from a bump its exponential is nothing.
    let fading = std::iter::once(first)
        .chain(rest.iter().map(|link| &link.operand))
        .any(fades);
    let fault = || graph::take_fault().filter(|fault| !(fading && *fault == Fault::Absorption));
    let agree = !rest[0].operator.is_additive() || eval.scope.units.of_sum(first, rest, &values);
    let told = |value: Value| match agree {
        true => value,
        false => value.map(|own| own.in_unit(Dimension::default())),
    };
    if let Some(number) = of_numbers(&values, rest) {
        let Some(fault) = fault() else {
            return Ok(told(Value::Scalar(number)));
        };
        // Where it happens: with one operand more each time.
        for (i, link) in rest.iter().enumerate() {
            of_numbers(&values[..i + 2], &rest[..=i]);
            if let Some(fault) = graph::take_fault() {
                return Err(unrepresentable(fault, &link.operand, eval.diagnostics));
            }
        }
        return Err(unrepresentable(fault, first, eval.diagnostics));
    }
    let mut total = values[0].clone();
    for (i, (link, value)) in rest.iter().zip(&values[1..]).enumerate() {
        let left = Prefix {
            first,
            rest: &rest[..i],
        };
        total = step(eval, (&left, &total), (link, value))?;
        match fault() {
            Some(fault) if fault.is_of_range() || link.operator.is_additive() => {
                return Err(unrepresentable(fault, &link.operand, eval.diagnostics));
            }
            _ => {}
        }
    }
    Ok(told(total))
}

/// Evaluates an expression that must be a number.
pub(crate) fn scalar(eval: &mut Evaluation<'_>, expr: &Expr) -> Checked<Number> {
    let value = value(eval, expr)?;
    number(expr, &value, eval.diagnostics)
}

fn component(
    eval: &mut Evaluation<'_>,
    whole: &Expr,
    vector: &Expr,
    name: &Name,
) -> Checked<Value> {
    let value = value(eval, vector)?;
    let Value::Vector(components) = &value else {
        if name.text == "dot" {
            let message = format!("`{vector}.dot`: the velocity is `dot({vector})`");
            let place = vector.place.to(name.place());
            return Err(eval.diagnostics.report("E02", place, message));
        }
        return Err(not_a_vector(vector, &value, eval.diagnostics));
    };
    let syms = value.syms();
    if let Some(index) = named::position(eval.scope, &syms, &name.text) {
        return Ok(Value::Scalar(components[index].clone()));
    }
    let names = named::names(eval.scope, &syms);
    // `a . b` with two vectors is their inner product.
    if !named::NAMES.contains(&name.text.as_str()) && eval.scope.names.contains_key(&name.text) {
        let other = eval.scope.name(name, eval.diagnostics)?;
        let places = [whole.place, name.place()];
        return inner_product(eval, (&value, &other), places);
    }
    Err(eval.diagnostics.report(
        "E02",
        name.place(),
        if names.is_empty() {
            format!(
                "`{vector}` has {} components without names; write an index, as in `{vector}[0]`",
                components.len()
            )
        } else {
            format!(
                "`{vector}` has {} components, {}; there is no `{}`",
                components.len(),
                list(names.iter().copied()),
                name.text
            )
        },
    ))
}

fn norm(eval: &mut Evaluation<'_>, whole: &Expr, inner: &Expr) -> Checked<Value> {
    match value(eval, inner)? {
        Value::Scalar(part) => {
            let size = if eval.scope.may_switch() {
                switch::size(eval, whole, part.sym)?
            } else if edges::admitted(eval.scope) {
                edges::call(eval.scope, "abs", vec![part.sym])
            } else {
                return Err(edges::refuse_size(eval, inner, part.sym));
            };
            Ok(Value::Scalar(part.with(size)))
        }
        Value::Vector(components) => {
            let message = |first, other| {
                format!(
                    "the components of `{inner}` are in {first} and {other}, so they have no common length"
                )
            };
            let unit = eval.scope.units.common(&components, inner.place, message);
            let square: Sym = components.iter().map(|own| own.sym.square()).sum();
            let may_rest =
                eval.scope.may_switch() && graph::contains(square, Variable::is_velocity);
            let sym = match may_rest {
                true => square.call(graph::Function::Root),
                false => square.power(1),
            };
            Ok(Value::Scalar(Number { sym, unit }))
        }
        Value::Matrix(_) => Err(eval.diagnostics.report(
            "E02",
            inner.place,
            format!("`{inner}` is a matrix; only vectors have a length"),
        )),
    }
}

fn derivative(
    eval: &mut Evaluation<'_>,
    function: &Name,
    order: usize,
    argument: &Expr,
) -> Checked<Value> {
    let at = scalar(eval, argument)?;
    eval.scope.arguments += 1;
    let place_holder = Variable::Argument(eval.scope.arguments);
    let variable = at.with(Sym::variable(place_holder));
    let value = if let Some(elementary) = elementary(&function.text) {
        Value::Scalar(Number {
            sym: elementary(variable.sym),
            unit: Dimension::default(),
        })
    } else {
        apply(
            eval,
            function,
            vec![Value::Scalar(variable)],
            function.place(),
        )?
    };
    let mut components = value.syms();
    let shown = (function.text.as_str(), function.place());
    edges::differentiable(eval, &components, shown)?;
    for _ in 0..order {
        components = graph::partial(&components, place_holder);
    }
    let components = graph::substitute(&components, |other| {
        (other == place_holder).then_some(at.sym)
    });
    Ok(value.with_syms(components).per(&at.unit, order))
}

fn call(
    eval: &mut Evaluation<'_>,
    whole: &Expr,
    function: &Name,
    arguments: &[Expr],
) -> Checked<Value> {
    let text = function.text.as_str();
    if eval.scope.names.contains_key(text) || eval.scope.is_local(text) {
        let values = all(arguments.iter().map(|argument| value(eval, argument)))?;
        return apply(eval, function, values, whole.place);
    }
    if text == words::INTEGRAL {
        return Err(eval.diagnostics.report(
            "E15",
            whole.place,
            "`integral` is the running cost and stands in `minimize` only, as a term by itself, \
             possibly times a constant; for an integral elsewhere add a coordinate whose force is what is integrated, which \
             is its velocity then",
        ));
    }
    if switch::is_switch(text) && eval.scope.may_switch() || switch::may_jump(eval.scope, text) {
        return of_numbers_called(eval, (function, arguments), |eval, parts| {
            switch::call(eval, whole, (text, arguments), &parts)
        });
    }
    if words::NONSMOOTH.contains(&text) || text == words::IF {
        if let ("sign" | "signum", [argument]) = (text, arguments)
            && matches!(eval.scope.role, Role::Motion | Role::Bound)
        {
            let part = scalar(eval, argument)?;
            edges::refuse_sign(whole, argument, part.sym, eval.diagnostics)?;
        }
        edges::admit(eval, whole, (text, arguments.len()))?;
        return of_numbers_called(eval, (function, arguments), |eval, parts| {
            Ok(edges::call(eval.scope, text, parts))
        });
    }
    if words::MATRIX_FUNCTIONS.contains(&text) {
        let mut values = Vec::with_capacity(arguments.len());
        for argument in arguments {
            values.push(value(eval, argument)?);
        }
        return matrix::call(eval, function, (arguments, &values));
    }
    if text == words::SUM && !eval.diagnostics.is_poisoned(text) {
        return sum(eval, whole, arguments);
    }
    if text == words::START {
        return at_start(eval, whole, arguments);
    }
    if text == words::PEAK && !eval.diagnostics.is_poisoned(text) {
        return peak(eval, whole, arguments);
    }
    if words::CONTACT_FUNCTIONS.contains(&text) {
        return recorded::of_contact(eval, whole, text, arguments);
    }
    by_arity(eval, whole, (function, arguments))
}

/// A call of a function of numbers or vectors, with as many arguments as it takes.
fn by_arity(
    eval: &mut Evaluation<'_>,
    whole: &Expr,
    (function, arguments): (&Name, &[Expr]),
) -> Checked<Value> {
    let text = function.text.as_str();
    let wanted = match text {
        "dot" if arguments.len() == 2 => 2,
        "atan2" | "cross" => 2,
        _ => 1,
    };
    let known = elementary(text).is_some() || words::SPECIAL_FUNCTIONS.contains(&text);
    if !known && eval.diagnostics.is_poisoned(text) {
        return Err(Reported);
    }
    if !known {
        return Err(eval.scope.undeclared_function(function, eval.diagnostics));
    }
    let found = arguments.len();
    takes((text, wanted), found, whole.place, eval.diagnostics)?;
    match (text, arguments) {
        ("dot", [argument]) => time_derivative(eval, argument),
        ("dot" | "cross", [left, right]) => {
            let left_value = value(eval, left);
            let right_value = value(eval, right);
            let (left_value, right_value) = (left_value?, right_value?);
            let values = (&left_value, &right_value);
            match text {
                "dot" => inner_product(eval, values, [whole.place; 2]),
                _ => cross_product(eval, values, whole.place),
            }
        }
        _ => of_numbers_called(eval, (function, arguments), |_, parts| {
            match (&parts[..], elementary(text)) {
                (&[y, x], _) => Ok(y.call2(Function2::Atan2, x)),
                (&[argument], Some(elementary)) => Ok(elementary(argument)),
                _ => Err(Reported),
            }
        }),
    }
}

/// `sum(expression)`, over all impacts.
fn sum(eval: &mut Evaluation<'_>, whole: &Expr, arguments: &[Expr]) -> Checked<Value> {
    let argument = recorded::summand(eval, whole, arguments)?;
    let summed = judged(eval, argument, Role::Impact)?;
    recorded::sum(eval, argument, summed)
}

/// A number in what is judged at the end, in another role; what holds all the time is taken apart into smooth pieces.
fn judged(eval: &mut Evaluation<'_>, argument: &Expr, role: Role) -> Checked<Number> {
    let known = std::mem::replace(&mut eval.scope.takes_apart, role == Role::Constraint);
    eval.scope.role = role;
    let number = scalar(eval, argument);
    eval.scope.role = Role::End;
    eval.scope.takes_apart = known;
    number
}

/// `start(expression)`.
fn at_start(eval: &mut Evaluation<'_>, whole: &Expr, arguments: &[Expr]) -> Checked<Value> {
    let argument = remembered::argument(eval, whole, arguments)?;
    let known = value(eval, argument)?;
    remembered::at_start(eval, (whole, argument), &known)
}

/// `peak(expression)`, the largest value over the motion.
fn peak(eval: &mut Evaluation<'_>, whole: &Expr, arguments: &[Expr]) -> Checked<Value> {
    let argument = remembered::over_the_motion(eval, whole, arguments)?;
    let known = judged(eval, argument, Role::Constraint)?;
    Ok(remembered::peak(eval.scope, whole, known))
}

/// A function of arguments that must be numbers, each of which reports its own mistakes.
fn of_numbers_called(
    eval: &mut Evaluation<'_>,
    (function, arguments): (&Name, &[Expr]),
    value: impl FnOnce(&mut Evaluation<'_>, Vec<Sym>) -> Checked<Sym>,
) -> Checked<Value> {
    let numbers = arguments.iter().map(|argument| scalar(eval, argument));
    let numbers = all(numbers)?;
    let unit = eval.scope.units.of_call(function, arguments, &numbers);
    let sym = value(eval, numbers.iter().map(|number| number.sym).collect())?;
    Ok(Value::Scalar(Number { sym, unit }))
}

/// Evaluates an expression in which `name` stands for a number.
pub(crate) fn value_over(
    eval: &mut Evaluation<'_>,
    (name, number): (&str, Number),
    expr: &Expr,
) -> Checked<Value> {
    let frame = vec![(name.to_owned(), Value::Scalar(number))];
    eval.scope.frames.push(frame);
    let value = value(eval, expr);
    eval.scope.frames.pop();
    value
}

/// A declared function at given arguments.
fn apply(
    eval: &mut Evaluation<'_>,
    function: &Name,
    values: Vec<Value>,
    place: Place,
) -> Checked<Value> {
    let declared = match eval.scope.names.get(&function.text) {
        Some(Meaning::Function(declared)) if !eval.scope.is_local(&function.text) => {
            Rc::clone(declared)
        }
        None if !eval.scope.is_local(&function.text) => {
            return Err(eval.scope.undeclared(function, eval.diagnostics));
        }
        _ => {
            return Err(eval.diagnostics.report(
                "E02",
                function.place(),
                format!(
                    "`{0}` is not a function; write a product as `{0}*(...)`",
                    function.text
                ),
            ));
        }
    };
    eval.scope.used.insert(function.text.clone());
    if eval.scope.active.contains(&function.text) {
        return Err(eval.diagnostics.syntax(
            function.place(),
            format!(
                "function `{}` uses itself; functions are inserted where they are used and cannot do \
                 that",
                function.text
            ),
        ));
    }
    let wanted = (&*function.text, declared.arguments.len());
    takes(wanted, values.len(), place, eval.diagnostics)?;
    let frame = declared
        .arguments
        .iter()
        .map(|argument| argument.text.clone())
        .zip(values)
        .collect();
    eval.scope.frames.push(frame);
    eval.scope.active.push(function.text.clone());
    eval.scope.units.called = Some(function.place());
    let value = value(eval, &declared.body);
    eval.scope.active.pop();
    eval.scope.frames.pop();
    value
}

/// `dot(e)`: the total time derivative along the motion.
fn time_derivative(eval: &mut Evaluation<'_>, argument: &Expr) -> Checked<Value> {
    let value = value(eval, argument)?;
    let syms = value.syms();
    for variable in graph::variables(&syms) {
        let message = match variable {
            Variable::Velocity(i) if i >= eval.scope.first_state => format!(
                "`dot({argument})` is the rate of a state; give what stands in `rates` a name by `let`, and use that"
            ),
            Variable::Velocity(_) => format!(
                "`dot({argument})` would be an acceleration, which follows from the Lagrangian; \
                 take `dot` once, of positions only"
            ),
            Variable::Switch(_) => format!(
                "`dot({argument})` needs the derivative of a switch, which jumps; take `dot` of positions only"
            ),
            known if known.is_of_contact() => format!(
                "`dot({argument})` needs the derivative of what a contact does, which may jump; take `dot` \
                 of positions only"
            ),
            Variable::Control(_) => format!(
                "`dot({argument})` needs the derivative of a control, which may jump; take `dot` \
                 of positions only"
            ),
            _ => continue,
        };
        return Err(match (variable, eval.scope.role) {
            (Variable::Control(_), Role::Running | Role::Constraint | Role::End) => {
                eval.diagnostics.report("E15", argument.place, message)
            }
            _ => eval.diagnostics.syntax(argument.place, message),
        });
    }
    let shown = (&*argument.to_string(), argument.place);
    edges::differentiable(eval, &syms, shown)?;
    let rates = graph::directional(&syms, velocity_direction);
    Ok(value.with_syms(rates).per(&eval.scope.units.second(), 1))
}
