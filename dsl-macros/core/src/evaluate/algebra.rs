//! Sums, products and quotients of numbers and vectors.

use super::Value;
use crate::ast::{Expr, Operator};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported};
use crate::graph::{self, Function2, Sym};

pub(super) fn map(value: &Value, f: impl Fn(Sym) -> Sym) -> Value {
    match value {
        Value::Scalar(sym) => Value::Scalar(f(*sym)),
        Value::Vector(components) => {
            Value::Vector(components.iter().map(|&component| f(component)).collect())
        }
    }
}

pub(super) fn not_a_vector(expr: &Expr, diagnostics: &mut Diagnostics) -> Reported {
    diagnostics.report(
        "E02",
        expr.place,
        format!("`{expr}` is a number and has no components; write a vector as `(y, z)`"),
    )
}

pub(super) fn inner_product(
    left: &Value,
    right: &Value,
    place: Place,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    match (left, right) {
        (Value::Vector(a), Value::Vector(b)) if a.len() == b.len() => Ok(Value::Scalar(
            a.iter().zip(b.iter()).map(|(&a, &b)| a * b).sum(),
        )),
        (a, b) => Err(diagnostics.report(
            "E02",
            place,
            format!(
                "the inner product needs two vectors of the same length, found {} and {}",
                describe(a),
                describe(b)
            ),
        )),
    }
}

pub(super) fn cross_product(
    left: &Value,
    right: &Value,
    place: Place,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    match (left.components(), right.components()) {
        (&[a, b], &[c, d]) => Ok(Value::Scalar(a * d - b * c)),
        (&[a, b, c], &[d, e, f]) => Ok(Value::Vector(
            [b * f - c * e, c * d - a * f, a * e - b * d].into(),
        )),
        _ => Err(diagnostics.report(
            "E02",
            place,
            format!(
                "the cross product needs two vectors of two or of three components, found {} and {}",
                describe(left),
                describe(right)
            ),
        )),
    }
}

fn describe(value: &Value) -> String {
    match value {
        Value::Scalar(_) => "a number".to_owned(),
        Value::Vector(components) => format!("{} components", components.len()),
    }
}

pub(super) fn binary(
    operator: Operator,
    (left, left_value): (&Expr, Value),
    (right, right_value): (&Expr, Value),
    place: Place,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    match (operator, &left_value, &right_value) {
        (Operator::Power, Value::Scalar(base), Value::Scalar(exponent)) => {
            if *exponent == Sym::ZERO {
                return Ok(Value::Scalar(Sym::ONE));
            }
            Ok(Value::Scalar(base.call2(Function2::Power, *exponent)))
        }
        (Operator::Power, Value::Vector(_), _) => Err(diagnostics.report(
            "E02",
            place,
            format!("a vector has no power; the square of its length is `|{left}|^2`"),
        )),
        (Operator::Divide, _, Value::Scalar(divisor)) if divisor.is_structural_zero() => {
            Err(diagnostics.syntax(right.place, format!("`{right}` is zero; it cannot divide")))
        }
        (Operator::Add, Value::Scalar(a), Value::Scalar(b)) => Ok(Value::Scalar(*a + *b)),
        (Operator::Subtract, Value::Scalar(a), Value::Scalar(b)) => Ok(Value::Scalar(*a - *b)),
        (Operator::Multiply, Value::Scalar(a), Value::Scalar(b)) => Ok(Value::Scalar(*a * *b)),
        (Operator::Divide, _, Value::Scalar(b)) => {
            let inverse = b.power(-2);
            Ok(map(&left_value, |component| component * inverse))
        }
        (Operator::Multiply, Value::Scalar(a), Value::Vector(_)) => {
            Ok(map(&right_value, |component| *a * component))
        }
        (Operator::Multiply, Value::Vector(_), Value::Scalar(b)) => {
            Ok(map(&left_value, |component| component * *b))
        }
        (Operator::Add | Operator::Subtract, Value::Vector(a), Value::Vector(b))
            if a.len() == b.len() =>
        {
            let sign = if operator == Operator::Add { 1.0 } else { -1.0 };
            Ok(Value::Vector(
                a.iter()
                    .zip(b.iter())
                    .map(|(&a, &b)| graph::sum([(a, 1.0), (b, sign)]))
                    .collect(),
            ))
        }
        (Operator::Multiply, Value::Vector(_), Value::Vector(_)) => Err(diagnostics.report(
            "E02",
            place,
            format!("`{left}*{right}` multiplies two vectors; write `dot({left}, {right})`"),
        )),
        (operator, a, b) => Err(diagnostics.report(
            "E02",
            place,
            format!(
                "`{}` between {} (`{left}`) and {} (`{right}`)",
                operator.symbol(),
                describe(a),
                describe(b)
            ),
        )),
    }
}
