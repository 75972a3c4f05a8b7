//! The numbers of a case beside each other.

use super::case::{Case, Row, significant};
use super::column::Column;

/// The rows of the comparison with `ours`.
pub(super) fn rows(case: &Case, ours: &Column) -> Vec<Row> {
    let values = case.published.values.iter();
    values
        .map(|&value| Row {
            label: case.label(value),
            published: value.stated.or_else(|| case.data.value(value.measure)),
            ours: ours.measure(case, value),
            value,
        })
        .collect()
}

/// A table with a column for every source, and the CPU time of each.
pub(super) fn comparison(
    case: &Case,
    rows: &[Row],
    columns: &[Column],
) -> (Vec<String>, Vec<Vec<String>>) {
    let mut header = vec![
        String::new(),
        "published".to_owned(),
        "certified or best known".to_owned(),
    ];
    header.extend(columns.iter().map(|column| column.name.to_owned()));
    let mut table: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let known = row.value.reference.value();
            let number = |value: Option<f64>, measure: Option<f64>| {
                let error = value.zip(measure).map(|(value, right)| value - right);
                value.map_or_else(|| "-".to_owned(), |value| significant(value, error))
            };
            let published = match row.value.stated {
                Some(_) => row.published_text(),
                None => number(row.published, known),
            };
            // A reference is shown to the digits of what is compared with it.
            let mut cells = vec![row.label.clone(), published, number(known, row.ours)];
            let measured = columns.iter();
            cells.extend(measured.map(|column| number(column.measure(case, row.value), known)));
            cells
        })
        .collect();
    let last = |name: &str, text: &dyn Fn(&Column) -> String| {
        let mut cells = vec![name.to_owned(), "-".to_owned(), "-".to_owned()];
        cells.extend(columns.iter().map(text));
        cells
    };
    table.push(last("residual", &|column| {
        format!("{:.1e}", column.residual)
    }));
    table.push(last("CPU time", &|column| {
        crate::table::seconds(column.simulation.seconds.total)
    }));
    (header, table)
}
