//! Calls: functions of the language, declared functions, derivatives.

use super::algebra::{cross_product, inner_product};
use super::{Meaning, Role, Scope, Value, matrix};
use crate::ast::{Expr, Name};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported, closest};
use crate::graph::{self, Function, Function2, Sym, Variable};
use crate::words;
use std::rc::Rc;

impl Scope {
    pub(super) fn derivative(
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

    pub(super) fn call(
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

/// The direction in which time moves the variables, velocities held.
pub(crate) fn velocity_direction(variable: Variable) -> Sym {
    match variable {
        Variable::Coordinate(i) => Sym::variable(Variable::Velocity(i)),
        Variable::Time => Sym::ONE,
        _ => Sym::ZERO,
    }
}

/// The elementary function with this name.
fn elementary(name: &str) -> Option<Box<dyn Fn(Sym) -> Sym>> {
    if name == "sqrt" {
        return Some(Box::new(|x| x.power(1)));
    }
    Function::named(name)
        .map(|function| -> Box<dyn Fn(Sym) -> Sym> { Box::new(move |x| x.call(function)) })
}
