//! Sums, products and quotients of numbers and vectors.

use super::value::{Matrix, Value};
use crate::ast::{Expr, Link, Operator, Prefix};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported};
use crate::graph::{self, Compose, Function2, Sym};

pub(super) fn not_a_vector(expr: &Expr, value: &Value, diagnostics: &mut Diagnostics) -> Reported {
    let message = match value {
        Value::Matrix(_) => {
            format!("`{expr}` is a matrix; its first row is `{expr}[0]`, an entry `{expr}[0][1]`")
        }
        _ => format!("`{expr}` is a number and has no components; write a vector as `(y, z)`"),
    };
    diagnostics.report("E02", expr.place, message)
}

pub(super) fn inner_product(
    left: &Value,
    right: &Value,
    place: Place,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    match (left, right) {
        (Value::Vector(a), Value::Vector(b)) if a.len() == b.len() => {
            Ok(Value::Scalar(inner(a.iter().zip(b.iter()))))
        }
        (a, b) => Err(diagnostics.report(
            "E02",
            place,
            format!(
                "the inner product needs two vectors of the same length, found {} and {}",
                a.describe(),
                b.describe()
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
    let vectors = matches!((left, right), (Value::Vector(_), Value::Vector(_)));
    match (left.components(), right.components()) {
        (&[a, b], &[c, d]) if vectors => Ok(Value::Scalar(a * d - b * c)),
        (&[a, b, c], &[d, e, f]) if vectors => Ok(Value::Vector(
            [b * f - c * e, c * d - a * f, a * e - b * d].into(),
        )),
        _ => Err(diagnostics.report(
            "E02",
            place,
            format!(
                "the cross product needs two vectors of two or of three components, found {} and {}",
                left.describe(),
                right.describe()
            ),
        )),
    }
}

/// `base^exponent`.
pub(super) fn power(
    base: &Expr,
    exponent: &Expr,
    values: [Value; 2],
    place: Place,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let message = match &values {
        [Value::Scalar(_), Value::Scalar(exponent)] if *exponent == Sym::ZERO => {
            return Ok(Value::Scalar(Sym::ONE));
        }
        [Value::Scalar(base), Value::Scalar(exponent)] => {
            return Ok(Value::Scalar(base.call2(Function2::Power, *exponent)));
        }
        [Value::Vector(_), _] => {
            format!("a vector has no power; the square of its length is `|{base}|^2`")
        }
        [Value::Matrix(_), _] => {
            format!("a matrix has no power here; write the product, as in `{base}*{base}`")
        }
        [Value::Scalar(_), other] => format!(
            "`^` between a number (`{base}`) and {} (`{exponent}`); an exponent is a number",
            other.describe()
        ),
    };
    Err(diagnostics.report("E02", place, message))
}

/// All of a chain at once, if it is made of numbers: the normal form of the whole is built once, not
/// after each operand again. `None` if it holds something else, or a division by zero.
pub(super) fn of_numbers(values: &[Value], rest: &[Link]) -> Option<Sym> {
    let mut numbers = Vec::with_capacity(values.len());
    for value in values {
        match value {
            Value::Scalar(number) => numbers.push(*number),
            _ => return None,
        }
    }
    let operators = std::iter::once(None).chain(rest.iter().map(|link| Some(link.operator)));
    let operands = numbers.into_iter().zip(operators);
    if rest.iter().any(|link| link.operator.is_additive()) {
        return Some(graph::sum(operands.map(|(number, operator)| {
            let negative = operator == Some(Operator::Subtract);
            (number, if negative { -1.0 } else { 1.0 })
        })));
    }
    let mut factors = Vec::with_capacity(values.len());
    for (number, operator) in operands {
        let divides = operator == Some(Operator::Divide);
        if divides && number.is_structural_zero() {
            return None;
        }
        factors.push((number, if divides { -2 } else { 2 }));
    }
    Some(graph::product(factors))
}

/// One step of a chain: what is on the left of an operator, and what stands on its right.
pub(super) fn step(
    left: &Prefix<'_>,
    left_value: &Value,
    link: &Link,
    right_value: &Value,
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let (right, place) = (&link.operand, link.place);
    match (link.operator, left_value, right_value) {
        (Operator::Divide, _, Value::Scalar(divisor)) if divisor.is_structural_zero() => {
            Err(diagnostics.syntax(right.place, format!("`{right}` is zero; it cannot divide")))
        }
        (Operator::Add, Value::Scalar(a), Value::Scalar(b)) => Ok(Value::Scalar(*a + *b)),
        (Operator::Subtract, Value::Scalar(a), Value::Scalar(b)) => Ok(Value::Scalar(*a - *b)),
        (Operator::Multiply, Value::Scalar(a), Value::Scalar(b)) => Ok(Value::Scalar(*a * *b)),
        (Operator::Divide, _, Value::Scalar(b)) => {
            let inverse = b.power(-2);
            Ok(left_value.map(|&component| component * inverse))
        }
        (Operator::Multiply, Value::Scalar(a), Value::Vector(_) | Value::Matrix(_)) => {
            Ok(right_value.map(|&component| *a * component))
        }
        (Operator::Multiply, Value::Matrix(m), Value::Vector(v)) if m.columns == v.len() => {
            Ok(Value::Vector(m.products(v, 1).map(inner).collect()))
        }
        (Operator::Multiply, Value::Matrix(a), Value::Matrix(b)) if a.columns == b.rows() => {
            let entries = a.products(&b.entries, b.columns).map(inner);
            Ok(Value::Matrix(Matrix::new(entries.collect(), b.columns)))
        }
        (Operator::Multiply, Value::Vector(_) | Value::Matrix(_), Value::Scalar(b)) => {
            Ok(left_value.map(|&component| component * *b))
        }
        (Operator::Add | Operator::Subtract, Value::Vector(a), Value::Vector(b))
            if a.len() == b.len() =>
        {
            Ok(left_value.with_components(sums(link.operator, a, b)))
        }
        (Operator::Add | Operator::Subtract, Value::Matrix(a), Value::Matrix(b))
            if (a.rows(), a.columns) == (b.rows(), b.columns) =>
        {
            Ok(left_value.with_components(sums(link.operator, &a.entries, &b.entries)))
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
                "`{}` between {} (`{left}`) and {} (`{right}`){}",
                operator.symbol(),
                a.describe(),
                b.describe(),
                hint(operator, a, b)
            ),
        )),
    }
}

/// The sum of the products of pairs.
fn inner<'a>(pairs: impl IntoIterator<Item = (&'a Sym, &'a Sym)>) -> Sym {
    pairs.into_iter().map(|(&a, &b)| a * b).sum()
}

fn sums(operator: Operator, a: &[Sym], b: &[Sym]) -> Vec<Sym> {
    let sign = if operator == Operator::Add { 1.0 } else { -1.0 };
    a.iter()
        .zip(b)
        .map(|(&a, &b)| graph::sum([(a, 1.0), (b, sign)]))
        .collect()
}

/// What fits where two sizes do not.
fn hint(operator: Operator, left: &Value, right: &Value) -> String {
    match (operator, left, right) {
        (Operator::Multiply, Value::Matrix(m), Value::Vector(_)) => format!(
            "; a matrix with {0} columns multiplies a vector with {0} components",
            m.columns
        ),
        (Operator::Multiply, Value::Matrix(m), Value::Matrix(_)) => format!(
            "; a matrix with {0} columns multiplies one with {0} rows",
            m.columns
        ),
        (Operator::Multiply, Value::Vector(_), Value::Matrix(_)) => {
            "; the matrix stands on the left, as in `transpose(m)*v`".to_owned()
        }
        (Operator::Divide, _, _) => "; only a number can divide".to_owned(),
        _ => "; both must have the same size".to_owned(),
    }
}
