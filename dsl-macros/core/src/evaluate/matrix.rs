//! Matrices: rows of equal length, as far as mechanics needs them.

use super::value::{Matrix, Value};
use crate::ast::{Expr, Name};
use crate::diagnostics::{Checked, Diagnostics, Reported};
use crate::graph::{Compose, Function, Sym};

/// The value of `((a, b), (c, d))` from that of its rows, and of `(a, b)` from that of its components.
pub(crate) fn stacked<T: Clone>(
    items: &[Expr],
    values: Vec<Value<T>>,
    diagnostics: &mut Diagnostics,
) -> Checked<Value<T>> {
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
    for (item, value) in items.iter().zip(&values) {
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
    function: &Name,
    arguments: &[(&Expr, Value)],
    diagnostics: &mut Diagnostics,
) -> Checked<Value> {
    let numbers: Option<Vec<Sym>> = arguments
        .iter()
        .map(|(_, value)| match value {
            Value::Scalar(number) => Some(*number),
            _ => None,
        })
        .collect();
    match (function.text.as_str(), numbers, arguments) {
        ("transpose", _, [(_, Value::Matrix(matrix))]) => Ok(Value::Matrix(matrix.transposed())),
        ("diagonal", Some(numbers), _) if numbers.len() > 1 => {
            let n = numbers.len();
            let mut entries = vec![Sym::ZERO; n * n];
            for (i, number) in numbers.into_iter().enumerate() {
                entries[i * n + i] = number;
            }
            Ok(Value::Matrix(Matrix::new(entries, n)))
        }
        (name, Some(numbers), [_]) if name.starts_with("rotation") => {
            Ok(Value::Matrix(rotation(name, numbers[0])))
        }
        (name, _, _) => Err(wrong_arguments(name, function, arguments, diagnostics)),
    }
}

/// The rotation by an angle: in the plane from the first axis to the second one, in space about an axis.
fn rotation(name: &str, angle: Sym) -> Matrix {
    let (s, c) = (angle.call(Function::Sin), angle.call(Function::Cos));
    let (o, i) = (Sym::ZERO, Sym::ONE);
    match name {
        "rotation_x" => Matrix::new(vec![i, o, o, o, c, -s, o, s, c], 3),
        "rotation_y" => Matrix::new(vec![c, o, s, o, i, o, -s, o, c], 3),
        "rotation_z" => Matrix::new(vec![c, -s, o, s, c, o, o, o, i], 3),
        _ => Matrix::new(vec![c, -s, s, c], 2),
    }
}

fn wrong_arguments(
    name: &str,
    function: &Name,
    arguments: &[(&Expr, Value)],
    diagnostics: &mut Diagnostics,
) -> Reported {
    let wanted = match name {
        "transpose" => "one matrix",
        "diagonal" => "two or more numbers, the entries of the diagonal",
        _ => "one angle",
    };
    let found: Vec<String> = arguments
        .iter()
        .map(|(_, value)| value.describe())
        .collect();
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
