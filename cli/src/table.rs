//! Tables for people.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use hangtime::simulation::Residuals;

/// Lines up `rows` under `header`: the first column to the left, numbers to the right.
pub(crate) fn table<H, R>(header: H, rows: R) -> String
where
    H: IntoIterator,
    H::Item: Into<String>,
    R: IntoIterator<Item = Vec<String>>,
{
    aligned(header, rows, |column, _| column > 0)
}

/// Lines up `rows` whose last column is text.
pub(crate) fn described<H, R>(header: H, rows: R) -> String
where
    H: IntoIterator,
    H::Item: Into<String>,
    R: IntoIterator<Item = Vec<String>>,
{
    aligned(header, rows, |column, columns| {
        column > 0 && column + 1 < columns
    })
}

/// Lines up `rows`; `right` tells from the index of a column and their number which ones go to the right.
fn aligned<H, R>(header: H, rows: R, right: impl Fn(usize, usize) -> bool) -> String
where
    H: IntoIterator,
    H::Item: Into<String>,
    R: IntoIterator<Item = Vec<String>>,
{
    let mut table = Table::new();
    table
        .load_preset(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Disabled)
        .set_header(header.into_iter().map(Into::into).collect::<Vec<String>>());
    for row in rows {
        table.add_row(row);
    }
    let columns = table.column_count();
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((if index == 0 { 2 } else { 1 }, 1));
        if right(index, columns) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table.trim_fmt() + "\n"
}

/// What a result leaves unsatisfied, as it stands behind its title in a summary.
pub(crate) fn residual_line(residuals: Residuals) -> String {
    format!(
        "primal {:.1e}, dual {:.1e}, complementarity {:.1e}",
        residuals.primal, residuals.dual, residuals.complementarity
    )
}

/// A number with its unit as an axis or a column is headed: `y [m]`, or `y` without a unit.
pub(crate) fn headed(name: &str, unit: &str) -> String {
    if unit.is_empty() {
        name.to_owned()
    } else {
        format!("{name} [{unit}]")
    }
}

/// `1 step`, `2 steps`.
pub(crate) fn counted(number: usize, noun: &str) -> String {
    let ending = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{ending}")
}

/// A number as it was given, with an exponent where there would be dozens of digits.
pub(crate) fn number(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-6..1e16).contains(&size) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

/// The unit of a time derivative.
pub(crate) fn per_second(unit: &str) -> String {
    if unit.is_empty() {
        "1/s".to_owned()
    } else {
        format!("{unit}/s")
    }
}

/// CPU time for people.
pub(crate) fn seconds(value: f64) -> String {
    if value < 1e-3 {
        format!("{:.0} us", value * 1e6)
    } else if value < 1.0 {
        format!("{:.1} ms", value * 1e3)
    } else {
        format!("{value:.2} s")
    }
}
