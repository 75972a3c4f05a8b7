//! Matrices: rows of equal length, as far as mechanics needs them.

use super::scope::Evaluation;
use super::value::{Matrix, Number, Value};
use crate::ast::{Expr, Name};
use crate::diagnostics::{Checked, Diagnostics, Reported};
use crate::graph::{Compose, Function, Sym};

/// The value of `((a, b), (c, d))` from that of its rows, and of `(a, b)` from that of its components.
pub(super) fn stacked(
    items: &[Expr],
    values: &[Value],
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let Some(Value::Vector(first)) = values.first() else {
        return Ok(Value::Vector(
            values
                .iter()
                .flat_map(|value| value.components().to_vec())
                .collect(),
        ));
    };
    let columns = first.len();
    let mut entries = Vec::with_capacity(columns * values.len());
    for (item, value) in items.iter().zip(values) {
        match value {
            Value::Vector(row) if row.len() == columns => entries.extend_from_slice(row),
            other => {
                return Err(diagnostics.report(
                    "E02",
                    item.place,
                    format!(
                        "the rows of a matrix have the same length: `{}` has {columns} components, \
                         `{item}` is {}",
                        items[0],
                        other.describe()
                    ),
                ));
            }
        }
    }
    Ok(Value::Matrix(Matrix::new(entries, columns)))
}

/// Functions that make matrices of numbers, or of matrices.
pub(super) fn call(
    eval: &mut Evaluation<'_>,
    function: &Name,
    (arguments, values): (&[Expr], &[Value]),
) -> Checked<Value> {
    let numbers = values.iter().map(|value| match value {
        Value::Scalar(number) => Some(number.clone()),
        _ => None,
    });
    let units = &mut eval.scope.units;
    match (function.text.as_str(), numbers.collect(), values) {
        ("transpose", _, [Value::Matrix(matrix)]) => Ok(Value::Matrix(matrix.transposed())),
        ("diagonal", Some::<Vec<Number>>(numbers), _) if numbers.len() > 1 => {
            let n = numbers.len();
            // Zeros fit anywhere.
            let zero = |_| Number {
                sym: Sym::ZERO,
                unit: units.unknown(""),
            };
            let mut entries: Vec<Number> = (0..n * n).map(zero).collect();
            for (i, number) in numbers.into_iter().enumerate() {
                entries[i * n + i] = number;
            }
            Ok(Value::Matrix(Matrix::new(entries, n)))
        }
        (name, Some(numbers), [_]) if name.starts_with("rotation") => {
            units.pure(name, &arguments[0], &numbers[0]);
            let columns = if name == "rotation" { 2 } else { 3 };
            let entries = rotation(name, numbers[0].sym).into_iter();
            let entries = entries.map(|sym| Number {
                sym,
                unit: units.one(),
            });
            Ok(Value::Matrix(Matrix::new(entries.collect(), columns)))
        }
        (name, _, _) => Err(wrong_arguments(name, function, values, eval.diagnostics)),
    }
}

/// The entries of the rotation by an angle: in the plane from the first axis to the second one, in space about an axis.
fn rotation(name: &str, angle: Sym) -> Vec<Sym> {
    let (s, c) = (angle.call(Function::Sin), angle.call(Function::Cos));
    let (o, i) = (Sym::ZERO, Sym::ONE);
    match name {
        "rotation_x" => vec![i, o, o, o, c, -s, o, s, c],
        "rotation_y" => vec![c, o, s, o, i, o, -s, o, c],
        "rotation_z" => vec![c, -s, o, s, c, o, o, o, i],
        _ => vec![c, -s, s, c],
    }
}

fn wrong_arguments(
    name: &str,
    function: &Name,
    values: &[Value],
    diagnostics: &mut Diagnostics,
) -> Reported {
    let wanted = match name {
        "transpose" => "one matrix",
        "diagonal" => "two or more numbers, the entries of the diagonal",
        _ => "one angle",
    };
    let found: Vec<String> = values.iter().map(Value::describe).collect();
    let found = if found.is_empty() {
        "nothing".to_owned()
    } else {
        found.join(", ")
    };
    diagnostics.report(
        "E02",
        function.place(),
        format!("`{name}` takes {wanted}; found {found}"),
    )
}
