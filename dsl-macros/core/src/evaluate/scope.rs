//! Names in force, and expressions over them: evaluation and calls of functions need each other.

use super::algebra::{cross_product, inner_product, map, not_a_vector, of_numbers, power, step};
use super::functions::{elementary, velocity_direction};
use super::matrix;
use super::value::Value;
use crate::ast::{Expr, Kind, Link, Name, Prefix};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported, closest, list};
use crate::graph::{self, Compose, Fault, Function2, Sym, Variable};
use crate::words;
use std::collections::{BTreeMap, HashSet};
use std::rc::Rc;

/// Most nodes of the syntax tree that one scene may evaluate, calls of functions included: far above
/// any mechanism, and a second or so of compile time.
pub(crate) const BUDGET: usize = 300_000;

/// Deepest evaluation, functions inserted; within the stack of a thread of 2 MB, without optimization as well.
const DEPTH: usize = 300;

/// Deepest expression, abbreviations and functions inserted; far above any mechanism.
const DEEPEST: usize = 300;

/// Why an expression is refused that takes more work than a compilation can wait for.
pub(crate) const TOO_LARGE: &str = "the declaration grows too large to be derived: abbreviations or functions that use others twice, again and again, double each time; use fewer, or make an intermediate quantity a coordinate of its own";

const TOO_DEEP: &str = "abbreviations or functions build on each other too many times; use fewer, or make an intermediate quantity a coordinate of its own";

/// What a name stands for.
#[derive(Clone)]
pub(crate) enum Meaning {
    Value(Value),
    Function(Rc<UserFunction>),
}

/// `fn name(arguments) = body`.
pub(crate) struct UserFunction {
    pub(crate) arguments: Vec<Name>,
    pub(crate) body: Expr,
}

/// What an expression is for, which decides what it may use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Role {
    /// The motion: dynamics, surfaces, laws.
    #[default]
    Motion,
    /// What is added up or holds during the motion: running cost and constraints.
    Running,
    /// What counts at the final instant: final cost and terminal conditions, which know the final time.
    End,
}

/// All names in force, and which of them have been used.
#[derive(Default)]
pub(crate) struct Scope {
    pub(crate) role: Role,
    pub(crate) names: BTreeMap<String, Meaning>,
    pub(crate) used: HashSet<String>,
    /// Names that are declared further down.
    pub(crate) later: HashSet<String>,
    /// Arguments of the functions being evaluated, innermost last.
    frames: Vec<Vec<(String, Value)>>,
    /// Functions being evaluated.
    active: Vec<String>,
    evaluated: usize,
    depth: usize,
    arguments: u16,
}

impl Scope {
    /// Evaluates an expression.
    pub(crate) fn value(&mut self, expr: &Expr, diagnostics: &mut Diagnostics) -> Checked<Value> {
        if self.depth == 0 {
            // What happened to constants elsewhere is not this expression's fault.
            graph::take_fault();
        }
        self.depth += 1;
        let value = if self.depth > DEPTH {
            Err(diagnostics.report(
                "E22",
                expr.place,
                "the functions used here are nested too deeply; simplify them",
            ))
        } else {
            self.value_unguarded(expr, diagnostics)
        };
        self.depth -= 1;
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

    fn value_unguarded(&mut self, expr: &Expr, diagnostics: &mut Diagnostics) -> Checked<Value> {
        self.evaluated += 1;
        if self.evaluated > BUDGET {
            return Err(diagnostics.report(
                "E22",
                expr.place,
                "the declaration grows too large when its functions are inserted; simplify it",
            ));
        }
        match &expr.kind {
            Kind::Number { value, unit, .. } => {
                let scale = unit.as_ref().map_or(1.0, |unit| unit.unit.scale);
                // Checked as the product of two constants.
                Ok(Value::Scalar(Sym::number(*value).scaled(scale)))
            }
            Kind::Name(name) => self.name(name, diagnostics),
            Kind::Negate(inner) => {
                let inner = self.value(inner, diagnostics)?;
                Ok(map(&inner, |component| -component))
            }
            Kind::Chain(first, rest) => self.chain(first, rest, diagnostics),
            Kind::Power {
                base,
                place,
                exponent,
            } => {
                let values = [base, exponent].map(|expr| self.value(expr, diagnostics));
                let [base_value, exponent_value] = values;
                let values = [base_value?, exponent_value?];
                power(base, exponent, values, *place, diagnostics)
            }
            Kind::Call {
                function,
                arguments,
            } => self.call(expr, function, arguments, diagnostics),
            Kind::Derivative {
                function,
                order,
                argument,
            } => self.derivative(function, *order, argument, diagnostics),
            Kind::Norm(inner) => self.norm(inner, diagnostics),
            Kind::Vector(items) => self.vector(items, diagnostics),
            Kind::Component { vector, name } => self.component(vector, name, diagnostics),
            Kind::Index { vector, index } => self.index(expr, vector, *index, diagnostics),
        }
    }

    fn vector(&mut self, items: &[Expr], diagnostics: &mut Diagnostics) -> Checked<Value> {
        let mut values: Vec<Value> = Vec::with_capacity(items.len());
        let mut failed = false;
        for item in items {
            // The first item decides between a vector and the rows of a matrix.
            let rows = matches!(values.first(), Some(Value::Vector(_)));
            let value = self.value(item, diagnostics).and_then(|value| {
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

    fn index(
        &mut self,
        expr: &Expr,
        vector: &Expr,
        index: usize,
        diagnostics: &mut Diagnostics,
    ) -> Checked<Value> {
        let value = self.value(vector, diagnostics)?;
        let components = value.components();
        match (&value, components.get(index)) {
            (Value::Vector(_), Some(&component)) => Ok(Value::Scalar(component)),
            (Value::Vector(_), None) => Err(diagnostics.report(
                "E02",
                expr.place,
                format!(
                    "`{vector}` has {} components, counted from 0; there is no [{index}]",
                    components.len()
                ),
            )),
            (Value::Matrix(matrix), _) => matrix.row(index).ok_or_else(|| {
                diagnostics.report(
                    "E02",
                    expr.place,
                    format!(
                        "`{vector}` has {} rows, counted from 0; there is no [{index}]",
                        matrix.rows()
                    ),
                )
            }),
            (Value::Scalar(_), _) => Err(not_a_vector(vector, &value, diagnostics)),
        }
    }

    fn chain(
        &mut self,
        first: &Expr,
        rest: &[Link],
        diagnostics: &mut Diagnostics,
    ) -> Checked<Value> {
        let operands = std::iter::once(first).chain(rest.iter().map(|link| &link.operand));
        let values: Vec<Checked<Value>> = operands
            .map(|operand| self.value(operand, diagnostics))
            .collect();
        let values: Vec<Value> = values.into_iter().collect::<Checked<_>>()?;
        if let Some(number) = of_numbers(&values, rest) {
            let Some(fault) = graph::take_fault() else {
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
            match graph::take_fault() {
                Some(fault) if fault.is_of_range() || link.operator.is_additive() => {
                    return Err(unrepresentable(fault, &link.operand, diagnostics));
                }
                _ => {}
            }
        }
        Ok(total)
    }

    /// Evaluates an expression that must be a number.
    pub(crate) fn scalar(&mut self, expr: &Expr, diagnostics: &mut Diagnostics) -> Checked<Sym> {
        let value = self.value(expr, diagnostics)?;
        number(expr, &value, diagnostics)
    }

    fn name(&mut self, name: &Name, diagnostics: &mut Diagnostics) -> Checked<Value> {
        let local = self
            .frames
            .last()
            .and_then(|frame| frame.iter().find(|(known, _)| *known == name.text));
        if let Some((_, value)) = local {
            return Ok(value.clone());
        }
        match self.names.get(&name.text) {
            Some(Meaning::Value(value)) => {
                self.used.insert(name.text.clone());
                Ok(value.clone())
            }
            Some(Meaning::Function(_)) => Err(diagnostics.report(
                "E02",
                name.place(),
                format!(
                    "`{0}` is a function; write its argument, as in `{0}(y)`",
                    name.text
                ),
            )),
            None if name.text == "pi" => Ok(Value::Scalar(Sym::number(std::f64::consts::PI))),
            None if name.text == "t" => Ok(Value::Scalar(Sym::variable(Variable::Time))),
            None if name.text == words::FINAL_TIME && self.role == Role::End => {
                self.used.insert(name.text.clone());
                Ok(Value::Scalar(Sym::variable(Variable::Time)))
            }
            None => Err(self.undeclared(name, diagnostics)),
        }
    }

    fn undeclared(&self, name: &Name, diagnostics: &mut Diagnostics) -> Reported {
        let text = &name.text;
        if diagnostics.is_poisoned(text) {
            return Reported;
        }
        if self.later.contains(text) {
            return diagnostics.report(
                "E01",
                name.place(),
                format!("`{text}` is declared further down; move its declaration up"),
            );
        }
        if words::is_function(text) {
            return diagnostics.report(
                "E02",
                name.place(),
                format!("`{text}` is a function; write its argument, as in `{text}(y)`"),
            );
        }
        let frame = self.frames.last().into_iter().flatten();
        let known: Vec<&str> = frame
            .map(|(name, _)| name.as_str())
            .chain(self.names.keys().map(String::as_str))
            .collect();
        let of = text
            .strip_suffix("_dot")
            .filter(|stem| known.contains(stem));
        if let Some(of) = of {
            return diagnostics.report(
                "E01",
                name.place(),
                format!("`{text}` is not declared; the velocity of `{of}` is `dot({of})`"),
            );
        }
        let message = match closest(text, known.iter().copied()) {
            _ if text.eq_ignore_ascii_case("pi") => {
                format!("`{text}` is not declared; the number is `pi`")
            }
            _ if text == words::FINAL_TIME => {
                "`time` is the final time, known to final costs in `minimize` and to `finally` only; the \
                 time at each instant is `t`"
                    .to_owned()
            }
            Some(near) => format!("`{text}` is not declared; did you mean `{near}`?"),
            None if known.is_empty() => {
                format!("`{text}` is not declared; add it to `parameters` or `coordinates`")
            }
            None => format!(
                "`{text}` is not declared; add it to `parameters` or `coordinates` (declared: {})",
                list(known)
            ),
        };
        diagnostics.report("E01", name.place(), message)
    }

    fn component(
        &mut self,
        vector: &Expr,
        name: &Name,
        diagnostics: &mut Diagnostics,
    ) -> Checked<Value> {
        let value = self.value(vector, diagnostics)?;
        let Value::Vector(components) = &value else {
            if name.text == "dot" {
                let message = format!("`{vector}.dot`: the velocity is `dot({vector})`");
                return Err(diagnostics.report("E02", name.place(), message));
            }
            return Err(not_a_vector(vector, &value, diagnostics));
        };
        let names: &[&str] = match components.len() {
            2 => &["y", "z"],
            3 => &["x", "y", "z"],
            _ => &[],
        };
        if let Some(index) = names.iter().position(|known| *known == name.text) {
            return Ok(Value::Scalar(components[index]));
        }
        // `a . b` with two vectors is their inner product.
        if !["x", "y", "z"].contains(&name.text.as_str()) && self.names.contains_key(&name.text) {
            let other = self.name(name, diagnostics)?;
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

    fn norm(&mut self, inner: &Expr, diagnostics: &mut Diagnostics) -> Checked<Value> {
        match self.value(inner, diagnostics)? {
            Value::Scalar(_) => Err(diagnostics.report(
                "E12",
                inner.place,
                format!(
                    "`|{inner}|` of a number has a kink at 0; square it, or declare a `surface` where \
                     the motion switches"
                ),
            )),
            Value::Vector(components) => {
                let square: Sym = components.iter().map(|component| component.square()).sum();
                Ok(Value::Scalar(square.power(1)))
            }
            Value::Matrix(_) => Err(diagnostics.report(
                "E02",
                inner.place,
                format!("`{inner}` is a matrix; only vectors have a length"),
            )),
        }
    }

    fn derivative(
        &mut self,
        function: &Name,
        order: usize,
        argument: &Expr,
        diagnostics: &mut Diagnostics,
    ) -> Checked<Value> {
        let at = self.scalar(argument, diagnostics)?;
        self.arguments += 1;
        let place_holder = Variable::Argument(self.arguments);
        let variable = Sym::variable(place_holder);
        let value = if let Some(elementary) = elementary(&function.text) {
            Value::Scalar(elementary(variable))
        } else {
            self.apply(
                function,
                vec![Value::Scalar(variable)],
                function.place(),
                diagnostics,
            )?
        };
        let mut components = value.components().to_vec();
        for _ in 0..order {
            components = graph::partial(&components, place_holder);
        }
        let components =
            graph::substitute(&components, |other| (other == place_holder).then_some(at));
        Ok(value.with_components(components))
    }

    fn call(
        &mut self,
        whole: &Expr,
        function: &Name,
        arguments: &[Expr],
        diagnostics: &mut Diagnostics,
    ) -> Checked<Value> {
        let text = function.text.as_str();
        if self.names.contains_key(text) || self.is_local(text) {
            let values: Vec<Checked<Value>> = arguments
                .iter()
                .map(|argument| self.value(argument, diagnostics))
                .collect();
            let values = values.into_iter().collect::<Checked<_>>()?;
            return self.apply(function, values, whole.place, diagnostics);
        }
        if text == words::INTEGRAL {
            return Err(diagnostics.report(
                "E15",
                whole.place,
                "`integral` is the running cost and stands in `minimize` only, as a term by itself, \
                 possibly times a constant",
            ));
        }
        if words::NONSMOOTH.contains(&text) {
            return Err(diagnostics.report(
                "E12",
                whole.place,
                format!(
                    "`{text}` has a kink or a jump, which smooth dynamics must not have; declare a \
                     `surface` where the motion switches"
                ),
            ));
        }
        if words::MATRIX_FUNCTIONS.contains(&text) {
            let mut values = Vec::with_capacity(arguments.len());
            for argument in arguments {
                values.push((argument, self.value(argument, diagnostics)?));
            }
            return matrix::call(function, &values, diagnostics);
        }
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
            return Err(self.undeclared_function(function, diagnostics));
        }
        if arguments.len() != wanted {
            return Err(diagnostics.report(
                "E02",
                whole.place,
                format!(
                    "`{text}` takes {wanted} argument{}, found {}",
                    if wanted == 1 { "" } else { "s" },
                    arguments.len()
                ),
            ));
        }
        self.known_function(whole, text, arguments, diagnostics)
    }

    /// A function of the language with as many arguments as it takes.
    fn known_function(
        &mut self,
        whole: &Expr,
        text: &str,
        arguments: &[Expr],
        diagnostics: &mut Diagnostics,
    ) -> Checked<Value> {
        match (text, arguments) {
            ("dot", [argument]) => self.time_derivative(argument, diagnostics),
            ("dot" | "cross", [left, right]) => {
                let left_value = self.value(left, diagnostics);
                let right_value = self.value(right, diagnostics);
                let (left_value, right_value) = (left_value?, right_value?);
                if text == "dot" {
                    inner_product(&left_value, &right_value, whole.place, diagnostics)
                } else {
                    cross_product(&left_value, &right_value, whole.place, diagnostics)
                }
            }
            ("atan2", [y, x]) => {
                let (y, x) = (self.scalar(y, diagnostics), self.scalar(x, diagnostics));
                Ok(Value::Scalar(y?.call2(Function2::Atan2, x?)))
            }
            (_, [argument]) => {
                let argument = self.scalar(argument, diagnostics)?;
                match elementary(text) {
                    Some(elementary) => Ok(Value::Scalar(elementary(argument))),
                    None => Err(Reported),
                }
            }
            _ => Err(Reported),
        }
    }

    fn undeclared_function(&self, function: &Name, diagnostics: &mut Diagnostics) -> Reported {
        let text = function.text.as_str();
        let mut functions: Vec<&str> = words::FUNCTIONS.to_vec();
        functions.extend(words::SPECIAL_FUNCTIONS);
        functions.extend(words::MATRIX_FUNCTIONS);
        functions.extend(
            self.names
                .iter()
                .filter(|(_, meaning)| matches!(meaning, Meaning::Function(_)))
                .map(|(name, _)| name.as_str()),
        );
        let message = if self.later.contains(text) {
            format!("`{text}` is declared further down; move its declaration up")
        } else if text == "log" {
            "`log` is ambiguous; the natural logarithm is `ln`".to_owned()
        } else {
            match closest(text, functions.iter().copied()) {
                Some(near) => {
                    format!("function `{text}` is not declared; did you mean `{near}`?")
                }
                None => format!(
                    "function `{text}` is not declared; declare it by `fn {text}(y) = ...`, or \
                     write `*` if a product is meant"
                ),
            }
        };
        diagnostics.report("E01", function.place(), message)
    }

    fn is_local(&self, name: &str) -> bool {
        self.frames
            .last()
            .is_some_and(|frame| frame.iter().any(|(known, _)| known == name))
    }

    /// A declared function at given arguments.
    fn apply(
        &mut self,
        function: &Name,
        values: Vec<Value>,
        place: Place,
        diagnostics: &mut Diagnostics,
    ) -> Checked<Value> {
        let declared = match self.names.get(&function.text) {
            Some(Meaning::Function(declared)) if !self.is_local(&function.text) => {
                Rc::clone(declared)
            }
            None if !self.is_local(&function.text) => {
                return Err(self.undeclared(function, diagnostics));
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
        self.used.insert(function.text.clone());
        if self.active.contains(&function.text) {
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
        self.frames.push(frame);
        self.active.push(function.text.clone());
        let value = self.value(&declared.body, diagnostics);
        self.active.pop();
        self.frames.pop();
        value
    }

    /// `dot(e)`: the total time derivative along the motion.
    fn time_derivative(
        &mut self,
        argument: &Expr,
        diagnostics: &mut Diagnostics,
    ) -> Checked<Value> {
        let value = self.value(argument, diagnostics)?;
        for variable in graph::variables(value.components()) {
            let message = match variable {
                Variable::Velocity(_) => format!(
                    "`dot({argument})` would be an acceleration, which follows from the Lagrangian; \
                     take `dot` once, of positions only"
                ),
                Variable::Control(_) => format!(
                    "`dot({argument})` needs the derivative of a control, which may jump; take `dot` \
                     of positions only"
                ),
                _ => continue,
            };
            return Err(match (variable, self.role) {
                (Variable::Control(_), Role::Running | Role::End) => {
                    diagnostics.report("E15", argument.place, message)
                }
                _ => diagnostics.syntax(argument.place, message),
            });
        }
        let rates = graph::directional(value.components(), velocity_direction);
        Ok(value.with_components(rates))
    }
}

/// Whether an expression is a derivative.
fn is_derivative(expr: &Expr) -> bool {
    match &expr.kind {
        Kind::Derivative { .. } => true,
        Kind::Call {
            function,
            arguments,
        } => function.text == "dot" && arguments.len() == 1,
        _ => false,
    }
}

/// E21: a constant that double precision does not hold.
pub(crate) fn unrepresentable(
    fault: Fault,
    expr: &Expr,
    diagnostics: &mut Diagnostics,
) -> Reported {
    let message = match fault {
        Fault::Overflow => format!(
            "with `{expr}` a constant has no finite value (double precision ends at 1.8e308); check divisions, roots and powers, or choose units in which the numbers are smaller"
        ),
        Fault::Underflow => format!(
            "with `{expr}` a constant becomes smaller than double precision holds (2.2e-308), and its term would vanish; choose units in which the numbers are larger"
        ),
        Fault::Cancellation => format!(
            "with `{expr}` constants cancel up to their rounding, so that no digit of the difference is right; write the difference itself, or leave the terms out if they cancel"
        ),
        Fault::Absorption => format!(
            "with `{expr}` constants are added of which one is lost, as it is more than 1e16 times smaller; leave it out, or write the sum otherwise"
        ),
    };
    diagnostics.report("E21", expr.place, message)
}

/// A value that must be a number.
fn number(expr: &Expr, value: &Value, diagnostics: &mut Diagnostics) -> Checked<Sym> {
    match value {
        Value::Scalar(sym) => {
            if sym.as_number().is_some_and(|value| !value.is_finite()) {
                return Err(unrepresentable(Fault::Overflow, expr, diagnostics));
            }
            Ok(*sym)
        }
        Value::Vector(_) => Err(diagnostics.report(
            "E02",
            expr.place,
            format!(
                "`{expr}` is {} where a number is needed; take a component, `|...|^2` or `dot(a, b)`",
                value.describe()
            ),
        )),
        Value::Matrix(_) => Err(diagnostics.report(
            "E02",
            expr.place,
            format!(
                "`{expr}` is {} where a number is needed; take an entry, as in `[0][1]`, or write \
                 `dot(v, m*v)`",
                value.describe()
            ),
        )),
    }
}
