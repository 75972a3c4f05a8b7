//! Sums, products and quotients of numbers and vectors.

use super::scope::Evaluation;
use super::value::{Matrix, Number, Value};
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

/// The inner product of what stands in an expression; where it stands, and where a mistake with its form is shown.
pub(super) fn inner_product(
    eval: &mut Evaluation<'_>,
    (left, right): (&Value, &Value),
    [whole, place]: [Place; 2],
) -> Checked<Value> {
    let message = match (left, right) {
        (Value::Vector(a), Value::Vector(b)) if a.len() == b.len() => {
            let products: Vec<Number> = a.iter().zip(b.iter()).map(|(a, b)| a.times(b)).collect();
            let what = "the inner product";
            return Ok(Value::Scalar(inner(eval, &products, whole, what)));
        }
        (a, b) => format!(
            "the inner product needs two vectors of the same length, found {} and {}",
            a.describe(),
            b.describe()
        ),
    };
    Err(eval.diagnostics.report("E02", place, message))
}

pub(super) fn cross_product(
    eval: &mut Evaluation<'_>,
    (left, right): (&Value, &Value),
    place: Place,
) -> Checked<Value> {
    let vectors = matches!((left, right), (Value::Vector(_), Value::Vector(_)));
    let (own, its) = (left.components(), right.components());
    let entry = |a: usize, b: usize| {
        let product = own[a].times(&its[b]);
        product.with(product.sym - own[b].sym * its[a].sym)
    };
    match own.len() {
        2 if vectors && its.len() == 2 => Ok(Value::Scalar(entry(0, 1))),
        3 if vectors && its.len() == 3 => {
            let pairs = [(1, 2), (2, 0), (0, 1)];
            Ok(Value::Vector(pairs.map(|(a, b)| entry(a, b)).into()))
        }
        _ => Err(eval.diagnostics.report(
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
    eval: &mut Evaluation<'_>,
    [base, exponent]: [&Expr; 2],
    values: [Value; 2],
    place: Place,
) -> Checked<Value> {
    let message = match &values {
        [Value::Scalar(own), Value::Scalar(its)] => {
            let units = &mut eval.scope.units;
            let unit = units.of_power((base, own), (exponent, its));
            let sym = match its.sym {
                Sym::ZERO => Sym::ONE,
                its => own.sym.call2(Function2::Power, its),
            };
            return Ok(Value::Scalar(Number { sym, unit }));
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
    Err(eval.diagnostics.report("E02", place, message))
}

/// All of a chain at once, if it is made of numbers: the normal form of the whole is built once, not
/// after each operand again. `None` if it holds something else, or a division by zero.
pub(super) fn of_numbers(values: &[Value], rest: &[Link]) -> Option<Number> {
    let numbers = values.iter().map(|value| match value {
        Value::Scalar(number) => Some(number),
        _ => None,
    });
    let numbers: Vec<&Number> = numbers.collect::<Option<_>>()?;
    let (first, others) = numbers.split_first()?;
    let others = others.iter().zip(rest.iter().map(|link| link.operator));
    if rest.iter().any(|link| link.operator.is_additive()) {
        let terms = others.map(|(number, operator)| (number.sym, operator.sign()));
        let terms = std::iter::once((first.sym, 1.0)).chain(terms);
        return Some(first.with(graph::sum(terms)));
    }
    let (mut factors, mut unit) = (vec![(first.sym, 2)], first.unit.clone());
    for (number, operator) in others {
        if operator != Operator::Divide {
            factors.push((number.sym, 2));
            unit = unit.times(&number.unit);
        } else if number.sym.is_structural_zero() {
            return None;
        } else {
            factors.push((number.sym, -2));
            unit = unit.over(&number.unit);
        }
    }
    let sym = graph::product(factors);
    Some(Number { sym, unit })
}

/// One step of a chain: what is on the left of an operator, and what stands on its right. The units of sums are compared
/// elsewhere.
pub(super) fn step(
    eval: &mut Evaluation<'_>,
    (left, left_value): (&Prefix<'_>, &Value),
    (link, right_value): (&Link, &Value),
) -> Checked<Value> {
    let (right, place) = (&link.operand, link.place);
    let diagnostics = &mut *eval.diagnostics;
    let what = || format!("the product `{left}*{right}`");
    match (link.operator, left_value, right_value) {
        (Operator::Divide, _, Value::Scalar(divisor)) if divisor.sym.is_structural_zero() => {
            Err(diagnostics.syntax(right.place, format!("`{right}` is zero; it cannot divide")))
        }
        (Operator::Divide, _, Value::Scalar(b)) => Ok(left_value.map(|own| own.over(b))),
        (Operator::Multiply, Value::Scalar(a), _) => Ok(right_value.map(|its| a.times(its))),
        (Operator::Multiply, _, Value::Scalar(b)) => Ok(left_value.map(|own| own.times(b))),
        (Operator::Multiply, Value::Matrix(m), Value::Vector(v)) if m.columns == v.len() => {
            let entries = m.products(v, 1);
            let entries = entries.map(|products| inner(eval, &products, place, &what()));
            Ok(Value::Vector(entries.collect()))
        }
        (Operator::Multiply, Value::Matrix(a), Value::Matrix(b)) if a.columns == b.rows() => {
            let entries = a.products(&b.entries, b.columns);
            let entries = entries.map(|products| inner(eval, &products, place, &what()));
            Ok(Value::Matrix(Matrix::new(entries.collect(), b.columns)))
        }
        (Operator::Add | Operator::Subtract, a, b) if a.describe() == b.describe() => {
            Ok(sums(link.operator, a, b))
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

/// The sum of some products, of which `what` consists.
fn inner(eval: &mut Evaluation<'_>, products: &[Number], place: Place, what: &str) -> Number {
    let message = |first, other| format!("the terms of {what} are in {first} and {other}");
    Number {
        sym: products.iter().map(|product| product.sym).sum(),
        unit: eval.scope.units.common(products, place, message),
    }
}

fn sums(operator: Operator, left: &Value, right: &Value) -> Value {
    let pairs = left.syms().into_iter().zip(right.syms());
    left.with_syms(
        pairs
            .map(|(a, b)| graph::sum([(a, 1.0), (b, operator.sign())]))
            .collect(),
    )
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
