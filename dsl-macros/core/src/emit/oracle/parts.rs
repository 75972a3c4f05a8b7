//! Values of the oracle: names of components, bound by statements, and what is done to all of them.

use crate::emit::kernel::literal;
use std::fmt::Write;

/// Names of the components of a value; a matrix row by row.
#[derive(Clone)]
pub(super) struct Parts {
    pub(super) names: Vec<String>,
    /// Number of columns, if it is a matrix.
    pub(super) columns: Option<usize>,
}

impl Parts {
    pub(super) fn one(name: String) -> Self {
        vec![name].into()
    }

    /// The same shape with other components.
    pub(super) fn with(&self, names: Vec<String>) -> Self {
        Self {
            names,
            columns: self.columns,
        }
    }

    /// The components of a value of the same shape that stands in an array.
    pub(super) fn within(&self, array: &str) -> Self {
        self.with((0..self.len()).map(|i| format!("{array}[{i}]")).collect())
    }
}

impl From<Vec<String>> for Parts {
    fn from(names: Vec<String>) -> Self {
        Self {
            names,
            columns: None,
        }
    }
}

impl std::ops::Deref for Parts {
    type Target = [String];
    fn deref(&self) -> &[String] {
        &self.names
    }
}

/// Statements of one helper function.
#[derive(Default)]
pub(super) struct Body {
    pub(super) text: String,
    pub(super) count: usize,
}

impl Body {
    pub(super) fn bind(&mut self, value: &str) -> String {
        let name = format!("e{}", self.count);
        self.count += 1;
        let _ = write!(self.text, "let {name} = {value};");
        name
    }
}

/// A matrix times a vector or a matrix.
pub(super) fn matrix_product(left: &Parts, right: &Parts, body: &mut Body) -> Option<Parts> {
    let width = right.columns.unwrap_or(1);
    let mut names = Vec::new();
    for row in left.chunks(left.columns?) {
        for j in 0..width {
            let column: Vec<String> = right.iter().skip(j).step_by(width).cloned().collect();
            names.push(inner_product(row, &column, body));
        }
    }
    Some(Parts {
        names,
        columns: right.columns,
    })
}

pub(super) fn matrix_function(name: &str, arguments: &[Parts], body: &mut Body) -> Option<Parts> {
    let first = arguments.first()?;
    if name == "transpose" {
        let columns = first.columns?;
        let names = (0..columns).flat_map(|j| first.iter().skip(j).step_by(columns).cloned());
        return Some(Parts {
            names: names.collect(),
            columns: Some(first.len() / columns),
        });
    }
    let [o, i] = [0.0, 1.0].map(|number| body.bind(&format!("D::from({})", literal(number))));
    if name == "diagonal" {
        let n = arguments.len();
        let at = |k: usize| {
            if k / n == k % n {
                arguments[k / n][0].clone()
            } else {
                o.clone()
            }
        };
        return Some(Parts {
            names: (0..n * n).map(at).collect(),
            columns: Some(n),
        });
    }
    let s = body.bind(&format!("{}.sin()", first[0]));
    let c = body.bind(&format!("{}.cos()", first[0]));
    let minus = body.bind(&format!("-{s}"));
    let (s, c, minus, o, i) = (&s, &c, &minus, &o, &i);
    let entries = match name {
        "rotation_x" => vec![i, o, o, o, c, minus, o, s, c],
        "rotation_y" => vec![c, o, s, o, i, o, minus, o, c],
        "rotation_z" => vec![c, minus, o, s, c, o, o, o, i],
        _ => vec![c, minus, s, c],
    };
    Some(Parts {
        columns: Some(if entries.len() == 4 { 2 } else { 3 }),
        names: entries.into_iter().cloned().collect(),
    })
}

pub(super) fn each(
    components: &[String],
    body: &mut Body,
    f: impl Fn(&str) -> String,
) -> Vec<String> {
    components.iter().map(|c| body.bind(&f(c))).collect()
}

pub(super) fn inner_product(a: &[String], b: &[String], body: &mut Body) -> String {
    let products: Vec<String> = a.iter().zip(b).map(|(a, b)| format!("{a} * {b}")).collect();
    body.bind(&products.join(" + "))
}
