//! Expressions over the names in force: evaluation and calls of functions need each other.

use super::algebra::{cross_product, inner_product, not_a_vector, of_numbers, power, step};
use super::edges;
use super::functions::{elementary, fades, is_derivative, velocity_direction};
use super::matrix;
use super::named;
use super::number::{number, unrepresentable};
use super::recorded;
use super::remembered;
use super::scope::{Meaning, Role, Scope};
use super::switch;
use super::value::Value;
use crate::ast::{Expr, Kind, Link, Name, Prefix, WrittenUnit};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported, list};
use crate::graph::{self, Compose, Fault, Function, Function2, Sym, Variable};
use crate::words;
use std::rc::Rc;

/// Most nodes of the syntax tree that one scene may evaluate, calls of functions included: far above
/// any mechanism, and a second or so of compile time.
pub(crate) const BUDGET: usize = 300_000;

/// Deepest evaluation, functions inserted; within the stack of a thread of 2 MB, without optimization as well.
const DEPTH: usize = 300;

/// Deepest expression, abbreviations and functions inserted; far above any mechanism.
const DEEPEST: usize = 300;

/// Why an expression is refused that takes more work than a compilation can wait for.
const TOO_LARGE: &str = "the declaration grows too large to be derived: abbreviations or functions that use others twice, again and again, double each time; use fewer, or make an intermediate quantity a coordinate of its own";

const TOO_DEEP: &str = "abbreviations or functions build on each other too many times; use fewer, or make an intermediate quantity a coordinate of its own";

/// Evaluates an expression.
pub(crate) fn value(
    scope: &mut Scope,
    expr: &Expr,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    if scope.depth == 0 {
        // What happened to constants elsewhere is not this expression's fault.
        graph::take_fault();
    }
    scope.depth += 1;
    let value = if scope.depth > DEPTH {
        Err(diagnostics.report(
            "E22",
            expr.place,
            "the functions used here are nested too deeply; simplify them",
        ))
    } else {
        value_unguarded(scope, expr, diagnostics)
    };
    scope.depth -= 1;
    let value = value?;
    if graph::is_exhausted() {
        return Err(diagnostics.report("E22", expr.place, TOO_LARGE));
    }
    if value.components().iter().any(|part| part.depth() > DEEPEST) {
        return Err(diagnostics.report("E22", expr.place, TOO_DEEP));
    }
    // A derivative may cancel up to rounding; that is zero on paper.
    match graph::take_fault() {
        Some(fault) if fault.is_of_range() || !is_derivative(expr) => {
            Err(unrepresentable(fault, expr, diagnostics))
        }
        _ => Ok(value),
    }
}

fn value_unguarded(
    scope: &mut Scope,
    expr: &Expr,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    scope.evaluated += 1;
    if scope.evaluated > BUDGET {
        return Err(diagnostics.report(
            "E22",
            expr.place,
            "the declaration grows too large when its functions are inserted; simplify it",
        ));
    }
    match &expr.kind {
        Kind::Number { value, unit, .. } => {
            let Some(unit) = unit else {
                return Ok(Value::Scalar(Sym::number(*value)));
            };
            // Checked as the product of two constants.
            let checked = Sym::number(*value).scaled(unit.unit.scale);
            let value = unit.unit.in_si(*value);
            Ok(Value::Scalar(match value.is_finite() {
                true => Sym::number(value),
                false => checked,
            }))
        }
        Kind::Name(name) => scope.name(name, diagnostics),
        Kind::Negate(inner) => {
            let inner = value(scope, inner, diagnostics)?;
            Ok(inner.map(|&component| -component))
        }
        Kind::Chain(first, rest) => chain(scope, first, rest, diagnostics),
        Kind::Power {
            base,
            place,
            exponent,
        } => {
            let values = [base, exponent].map(|expr| value(scope, expr, diagnostics));
            let [base_value, exponent_value] = values;
            let values = [base_value?, exponent_value?];
            power(base, exponent, values, *place, diagnostics)
        }
        Kind::Call {
            function,
            arguments,
        } => call(scope, expr, function, arguments, diagnostics),
        Kind::Derivative {
            function,
            order,
            argument,
        } => derivative(scope, function, *order, argument, diagnostics),
        Kind::Norm(inner) => norm(scope, expr, inner, diagnostics),
        Kind::Vector(items) => vector(scope, items, diagnostics),
        Kind::Component { vector, name } => component(scope, vector, name, diagnostics),
        Kind::Index { vector, index } => component_at(scope, expr, vector, *index, diagnostics),
        Kind::Profile {
            profile,
            argument,
            argument_unit,
            value_unit,
        } => {
            let at = scope.name(argument, diagnostics)?;
            let of = |unit: &Option<WrittenUnit>| unit.as_ref().map_or(1.0, |unit| unit.unit.scale);
            let (from, to) = (of(argument_unit), of(value_unit));
            let function = Function::Profile(*profile);
            Ok(at.map(|at| at.scaled(1.0 / from).call(function).scaled(to)))
        }
    }
}

fn vector(scope: &mut Scope, items: &[Expr], diagnostics: &mut Diagnostics) -> Checked<Value> {
    let mut values: Vec<Value> = Vec::with_capacity(items.len());
    let mut failed = false;
    for item in items {
        // The first item decides between a vector and the rows of a matrix.
        let rows = matches!(values.first(), Some(Value::Vector(_)));
        let value = value(scope, item, diagnostics).and_then(|value| {
            if rows || values.is_empty() && matches!(value, Value::Vector(_)) {
                return Ok(value);
            }
            Ok(Value::Scalar(number(item, &value, diagnostics)?))
        });
        match value {
            Ok(value) => values.push(value),
            Err(Reported) => failed = true,
        }
    }
    if failed {
        return Err(Reported);
    }
    matrix::stacked(items, values, diagnostics)
}

fn component_at(
    scope: &mut Scope,
    expr: &Expr,
    vector: &Expr,
    index: usize,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let value = value(scope, vector, diagnostics)?;
    if let Some(part) = value.at(index) {
        return Ok(part);
    }
    let (count, parts) = match &value {
        Value::Scalar(_) => return Err(not_a_vector(vector, &value, diagnostics)),
        Value::Vector(components) => (components.len(), "components"),
        Value::Matrix(matrix) => (matrix.rows(), "rows"),
    };
    let message = format!("`{vector}` has {count} {parts}, counted from 0; there is no [{index}]");
    Err(diagnostics.report("E02", expr.place, message))
}

fn chain(
    scope: &mut Scope,
    first: &Expr,
    rest: &[Link],
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let operands = std::iter::once(first).chain(rest.iter().map(|link| &link.operand));
    let values: Vec<Checked<Value>> = operands
        .map(|operand| value(scope, operand, diagnostics))
        .collect();
    let values: Vec<Value> = values.into_iter().collect::<Checked<_>>()?;
    // What a function makes small beside another constant was not written small: far from a bump its exponential is nothing.
    let fading = std::iter::once(first)
        .chain(rest.iter().map(|link| &link.operand))
        .any(fades);
    let fault = || graph::take_fault().filter(|fault| !(fading && *fault == Fault::Absorption));
    if let Some(number) = of_numbers(&values, rest) {
        let Some(fault) = fault() else {
            return Ok(Value::Scalar(number));
        };
        // Where it happens: with one operand more each time.
        for (i, link) in rest.iter().enumerate() {
            of_numbers(&values[..i + 2], &rest[..=i]);
            if let Some(fault) = graph::take_fault() {
                return Err(unrepresentable(fault, &link.operand, diagnostics));
            }
        }
        return Err(unrepresentable(fault, first, diagnostics));
    }
    let mut total = values[0].clone();
    for (i, (link, value)) in rest.iter().zip(&values[1..]).enumerate() {
        let left = Prefix {
            first,
            rest: &rest[..i],
        };
        total = step(&left, &total, link, value, diagnostics)?;
        match fault() {
            Some(fault) if fault.is_of_range() || link.operator.is_additive() => {
                return Err(unrepresentable(fault, &link.operand, diagnostics));
            }
            _ => {}
        }
    }
    Ok(total)
}

/// Evaluates an expression that must be a number.
pub(crate) fn scalar(
    scope: &mut Scope,
    expr: &Expr,
    diagnostics: &mut Diagnostics,
) -> Checked<Sym> {
    let value = value(scope, expr, diagnostics)?;
    number(expr, &value, diagnostics)
}

fn component(
    scope: &mut Scope,
    vector: &Expr,
    name: &Name,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let value = value(scope, vector, diagnostics)?;
    let Value::Vector(components) = &value else {
        if name.text == "dot" {
            let message = format!("`{vector}.dot`: the velocity is `dot({vector})`");
            let place = vector.place.to(name.place());
            return Err(diagnostics.report("E02", place, message));
        }
        return Err(not_a_vector(vector, &value, diagnostics));
    };
    if let Some(index) = named::position(scope, components, &name.text) {
        return Ok(Value::Scalar(components[index]));
    }
    let names = named::names(scope, components);
    // `a . b` with two vectors is their inner product.
    if !named::NAMES.contains(&name.text.as_str()) && scope.names.contains_key(&name.text) {
        let other = scope.name(name, diagnostics)?;
        return inner_product(&value, &other, name.place(), diagnostics);
    }
    Err(diagnostics.report(
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

fn norm(
    scope: &mut Scope,
    whole: &Expr,
    inner: &Expr,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    match value(scope, inner, diagnostics)? {
        Value::Scalar(part) if scope.may_switch() => switch::size(scope, whole, part, diagnostics),
        Value::Scalar(part) if edges::admitted(scope) => Ok(edges::call(scope, "abs", vec![part])),
        Value::Scalar(part) => Err(edges::refuse_size(scope, inner, part, diagnostics)),
        Value::Vector(components) => {
            let square: Sym = components.iter().map(|component| component.square()).sum();
            let is_velocity = |variable| matches!(variable, Variable::Velocity(_));
            let may_rest = scope.may_switch() && graph::contains(square, is_velocity);
            Ok(Value::Scalar(match may_rest {
                true => square.call(graph::Function::Root),
                false => square.power(1),
            }))
        }
        Value::Matrix(_) => Err(diagnostics.report(
            "E02",
            inner.place,
            format!("`{inner}` is a matrix; only vectors have a length"),
        )),
    }
}

fn derivative(
    scope: &mut Scope,
    function: &Name,
    order: usize,
    argument: &Expr,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let at = scalar(scope, argument, diagnostics)?;
    scope.arguments += 1;
    let place_holder = Variable::Argument(scope.arguments);
    let variable = Sym::variable(place_holder);
    let value = if let Some(elementary) = elementary(&function.text) {
        Value::Scalar(elementary(variable))
    } else {
        apply(
            scope,
            function,
            vec![Value::Scalar(variable)],
            function.place(),
            diagnostics,
        )?
    };
    let mut components = value.components().to_vec();
    let shown = (function.text.as_str(), function.place());
    edges::differentiable(scope, &components, shown, diagnostics)?;
    for _ in 0..order {
        components = graph::partial(&components, place_holder);
    }
    let components = graph::substitute(&components, |other| (other == place_holder).then_some(at));
    Ok(value.with_components(components))
}

fn call(
    scope: &mut Scope,
    whole: &Expr,
    function: &Name,
    arguments: &[Expr],
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let text = function.text.as_str();
    if scope.names.contains_key(text) || scope.is_local(text) {
        let values: Vec<Checked<Value>> = arguments
            .iter()
            .map(|argument| value(scope, argument, diagnostics))
            .collect();
        let values = values.into_iter().collect::<Checked<_>>()?;
        return apply(scope, function, values, whole.place, diagnostics);
    }
    if text == words::INTEGRAL {
        return Err(diagnostics.report(
            "E15",
            whole.place,
            "`integral` is the running cost and stands in `minimize` only, as a term by itself, \
             possibly times a constant; for an integral elsewhere add a coordinate whose force is what is integrated, which \
             is its velocity then",
        ));
    }
    if switch::is_switch(text) && scope.may_switch() || switch::may_jump(scope, text) {
        return switched(scope, whole, (text, arguments), diagnostics);
    }
    if words::NONSMOOTH.contains(&text) || text == words::IF {
        if let ("sign" | "signum", [argument]) = (text, arguments)
            && matches!(scope.role, Role::Motion | Role::Bound)
        {
            let part = scalar(scope, argument, diagnostics)?;
            edges::refuse_sign(whole, argument, part, diagnostics)?;
        }
        edges::admit(scope, whole, (text, arguments.len()), diagnostics)?;
        let parts: Vec<Checked<Sym>> = arguments
            .iter()
            .map(|argument| scalar(scope, argument, diagnostics))
            .collect();
        let parts = parts.into_iter().collect::<Checked<_>>()?;
        return Ok(edges::call(scope, text, parts));
    }
    if words::MATRIX_FUNCTIONS.contains(&text) {
        let mut values = Vec::with_capacity(arguments.len());
        for argument in arguments {
            values.push((argument, value(scope, argument, diagnostics)?));
        }
        return matrix::call(function, &values, diagnostics);
    }
    if text == words::SUM && !diagnostics.is_poisoned(text) {
        return sum(scope, whole, arguments, diagnostics);
    }
    if text == words::START {
        return at_start(scope, whole, arguments, diagnostics);
    }
    if text == words::PEAK && !diagnostics.is_poisoned(text) {
        return peak(scope, whole, arguments, diagnostics);
    }
    if words::CONTACT_FUNCTIONS.contains(&text) {
        return recorded::of_contact(scope, whole, text, arguments, diagnostics);
    }
    by_arity(scope, whole, (function, arguments), diagnostics)
}

/// A call of a function of numbers or vectors, with as many arguments as it takes.
fn by_arity(
    scope: &mut Scope,
    whole: &Expr,
    (function, arguments): (&Name, &[Expr]),
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let text = function.text.as_str();
    let wanted = match text {
        "dot" if arguments.len() == 2 => 2,
        "atan2" | "cross" => 2,
        _ => 1,
    };
    let known = elementary(text).is_some() || words::SPECIAL_FUNCTIONS.contains(&text);
    if !known && diagnostics.is_poisoned(text) {
        return Err(Reported);
    }
    if !known {
        return Err(scope.undeclared_function(function, diagnostics));
    }
    if arguments.len() != wanted {
        let plural = if wanted == 1 { "" } else { "s" };
        let found = arguments.len();
        let message = format!("`{text}` takes {wanted} argument{plural}, found {found}");
        return Err(diagnostics.report("E02", whole.place, message));
    }
    known_function(scope, whole, text, arguments, diagnostics)
}

/// `sum(expression)`, over all impacts.
fn sum(
    scope: &mut Scope,
    whole: &Expr,
    arguments: &[Expr],
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let argument = recorded::summand(scope, whole, arguments, diagnostics)?;
    let takes_apart = std::mem::take(&mut scope.takes_apart);
    scope.role = Role::Impact;
    let summed = scalar(scope, argument, diagnostics);
    scope.role = Role::End;
    scope.takes_apart = takes_apart;
    recorded::sum(scope, argument, summed?, diagnostics)
}

/// `start(expression)`.
fn at_start(
    scope: &mut Scope,
    whole: &Expr,
    arguments: &[Expr],
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let argument = remembered::argument(scope, whole, arguments, diagnostics)?;
    let known = value(scope, argument, diagnostics)?;
    remembered::at_start(scope, (whole, argument), &known, diagnostics)
}

/// `peak(expression)`, the largest value over the motion.
fn peak(
    scope: &mut Scope,
    whole: &Expr,
    arguments: &[Expr],
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let argument = remembered::over_the_motion(scope, whole, arguments, diagnostics)?;
    let takes_apart = std::mem::replace(&mut scope.takes_apart, true);
    scope.role = Role::Constraint;
    let known = scalar(scope, argument, diagnostics);
    scope.role = Role::End;
    scope.takes_apart = takes_apart;
    Ok(remembered::peak(scope, whole, known?))
}

/// A switch of these arguments.
fn switched(
    scope: &mut Scope,
    whole: &Expr,
    (text, arguments): (&str, &[Expr]),
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let parts: Vec<Checked<Sym>> = arguments
        .iter()
        .map(|argument| scalar(scope, argument, diagnostics))
        .collect();
    let parts = parts.into_iter().collect::<Checked<Vec<Sym>>>()?;
    switch::call(scope, whole, (text, arguments), &parts, diagnostics)
}

/// Evaluates an expression in which `name` stands for a number.
pub(crate) fn value_over(
    scope: &mut Scope,
    (name, number): (&str, Sym),
    expr: &Expr,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let frame = vec![(name.to_owned(), Value::Scalar(number))];
    scope.frames.push(frame);
    let value = value(scope, expr, diagnostics);
    scope.frames.pop();
    value
}

/// A function of the language with as many arguments as it takes.
fn known_function(
    scope: &mut Scope,
    whole: &Expr,
    text: &str,
    arguments: &[Expr],
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    match (text, arguments) {
        ("dot", [argument]) => time_derivative(scope, argument, diagnostics),
        ("dot" | "cross", [left, right]) => {
            let left_value = value(scope, left, diagnostics);
            let right_value = value(scope, right, diagnostics);
            let (left_value, right_value) = (left_value?, right_value?);
            if text == "dot" {
                inner_product(&left_value, &right_value, whole.place, diagnostics)
            } else {
                cross_product(&left_value, &right_value, whole.place, diagnostics)
            }
        }
        ("atan2", [y, x]) => {
            let (y, x) = (scalar(scope, y, diagnostics), scalar(scope, x, diagnostics));
            Ok(Value::Scalar(y?.call2(Function2::Atan2, x?)))
        }
        (_, [argument]) => {
            let argument = scalar(scope, argument, diagnostics)?;
            match elementary(text) {
                Some(elementary) => Ok(Value::Scalar(elementary(argument))),
                None => Err(Reported),
            }
        }
        _ => Err(Reported),
    }
}

/// A declared function at given arguments.
fn apply(
    scope: &mut Scope,
    function: &Name,
    values: Vec<Value>,
    place: Place,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let declared = match scope.names.get(&function.text) {
        Some(Meaning::Function(declared)) if !scope.is_local(&function.text) => Rc::clone(declared),
        None if !scope.is_local(&function.text) => {
            return Err(scope.undeclared(function, diagnostics));
        }
        _ => {
            return Err(diagnostics.report(
                "E02",
                function.place(),
                format!(
                    "`{0}` is not a function; write a product as `{0}*(...)`",
                    function.text
                ),
            ));
        }
    };
    scope.used.insert(function.text.clone());
    if scope.active.contains(&function.text) {
        return Err(diagnostics.syntax(
            function.place(),
            format!(
                "function `{}` uses itself; functions are inserted where they are used and cannot do \
                 that",
                function.text
            ),
        ));
    }
    if declared.arguments.len() != values.len() {
        return Err(diagnostics.report(
            "E02",
            place,
            format!(
                "`{}` takes {} argument{}, found {}",
                function.text,
                declared.arguments.len(),
                if declared.arguments.len() == 1 {
                    ""
                } else {
                    "s"
                },
                values.len()
            ),
        ));
    }
    let frame = declared
        .arguments
        .iter()
        .map(|argument| argument.text.clone())
        .zip(values)
        .collect();
    scope.frames.push(frame);
    scope.active.push(function.text.clone());
    let value = value(scope, &declared.body, diagnostics);
    scope.active.pop();
    scope.frames.pop();
    value
}

/// `dot(e)`: the total time derivative along the motion.
fn time_derivative(
    scope: &mut Scope,
    argument: &Expr,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let value = value(scope, argument, diagnostics)?;
    for variable in graph::variables(value.components()) {
        let message = match variable {
            Variable::Velocity(i) if i >= scope.first_state => format!(
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
        return Err(match (variable, scope.role) {
            (Variable::Control(_), Role::Running | Role::Constraint | Role::End) => {
                diagnostics.report("E15", argument.place, message)
            }
            _ => diagnostics.syntax(argument.place, message),
        });
    }
    let shown = (&*argument.to_string(), argument.place);
    edges::differentiable(scope, value.components(), shown, diagnostics)?;
    let rates = graph::directional(value.components(), velocity_direction);
    Ok(value.with_components(rates))
}
