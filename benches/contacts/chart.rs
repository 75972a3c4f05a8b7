//! The chart of all rows: a panel a family, CPU time of a run over contacts, both logarithmic, a line a method.

use crate::row::Row;
use std::fmt::Write as _;

/// Ink and paper by day and by night.
const COLOURS: &str = "svg{color:#1f2430;background:#ffffff}\
                       @media (prefers-color-scheme:dark){svg{color:#dfe3ea;background:#14171c}}";
/// Colours of methods, in their order of appearance.
const LINES: [&str; 6] = [
    "#2b6cb0", "#dd6b20", "#2f855a", "#b83280", "#718096", "#d69e2e",
];
/// Width and height of a panel, and the room around it.
const PANEL: (f64, f64) = (300.0, 190.0);
const ROOM: (f64, f64) = (64.0, 54.0);
const COLUMNS: usize = 3;

/// Values in the order of their first appearance.
fn distinct<'a>(values: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut known: Vec<&str> = Vec::new();
    for value in values {
        if !known.contains(&value) {
            known.push(value);
        }
    }
    known
}

/// Powers of ten around the values.
fn decades(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let logarithms = values.filter(|value| *value > 0.0).map(f64::log10);
    let (low, high) = logarithms.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value.floor()), high.max(value.ceil()))
    });
    if low < high {
        (low, high)
    } else {
        (low.min(0.0), low.min(0.0) + 1.0)
    }
}

/// All rows that were solved, as SVG.
pub(crate) fn drawn(rows: &[Row]) -> String {
    let solved: Vec<&Row> = rows
        .iter()
        .filter(|row| row.ended.is_empty() && row.seconds > 0.0)
        .collect();
    let families = distinct(solved.iter().map(|row| row.family.as_str()));
    let methods = distinct(solved.iter().map(|row| row.method.as_str()));
    let times = decades(solved.iter().map(|row| row.seconds));
    let (width, height) = (PANEL.0 + ROOM.0, PANEL.1 + ROOM.1);
    let lines = families.len().div_ceil(COLUMNS);
    let (all_width, all_height) = (width * COLUMNS as f64 + 20.0, height * lines as f64 + 40.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{all_width}\" height=\"{all_height}\" viewBox=\"0 0 {all_width} \
         {all_height}\" font-family=\"sans-serif\" font-size=\"11\" fill=\"currentColor\">\n<style>{COLOURS}</style>\n"
    );
    for (k, method) in methods.iter().enumerate() {
        let x = ROOM.0 + 130.0 * k as f64;
        let colour = LINES[k % LINES.len()];
        let _ = writeln!(
            svg,
            "<rect x=\"{x}\" y=\"8\" width=\"12\" height=\"12\" fill=\"{colour}\"/><text x=\"{}\" y=\"18\">{method}</text>",
            x + 18.0
        );
    }
    for (f, family) in families.iter().enumerate() {
        let corner = (
            ROOM.0 + width * (f % COLUMNS) as f64,
            50.0 + height * (f / COLUMNS) as f64,
        );
        let own: Vec<&Row> = solved
            .iter()
            .copied()
            .filter(|row| row.family == *family)
            .collect();
        panel(&mut svg, (corner, times), family, &own, &methods);
    }
    svg + "</svg>\n"
}

/// One family.
fn panel(
    svg: &mut String,
    ((left, top), times): ((f64, f64), (f64, f64)),
    family: &str,
    rows: &[&Row],
    methods: &[&str],
) {
    let sizes = decades(rows.iter().map(|row| row.size()));
    let x = |size: f64| left + PANEL.0 * (size.log10() - sizes.0) / (sizes.1 - sizes.0);
    let y = |time: f64| top + PANEL.1 * (times.1 - time.log10()) / (times.1 - times.0);
    let (right, bottom) = (left + PANEL.0, top + PANEL.1);
    let counted = if rows.iter().any(|row| row.contacts > 1) {
        "contacts"
    } else {
        "bodies"
    };
    let _ = writeln!(
        svg,
        "<text x=\"{left}\" y=\"{}\">{family}: CPU time [s] over {counted}</text>",
        top - 8.0
    );
    for decade in times.0 as i32..=times.1 as i32 {
        let height = y(10.0_f64.powi(decade));
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {height:.1}H{right}\" stroke=\"currentColor\" stroke-opacity=\"0.2\"/><text x=\"{}\" y=\"{:.1}\" \
             text-anchor=\"end\">1e{decade}</text>",
            left - 6.0,
            height + 4.0
        );
    }
    for decade in sizes.0 as i32..=sizes.1 as i32 {
        let place = x(10.0_f64.powi(decade));
        let _ = writeln!(
            svg,
            "<path d=\"M{place:.1} {top}V{bottom}\" stroke=\"currentColor\" stroke-opacity=\"0.2\"/><text x=\"{place:.1}\" \
             y=\"{}\" text-anchor=\"middle\">1e{decade}</text>",
            bottom + 14.0
        );
    }
    for (k, method) in methods.iter().enumerate() {
        let colour = LINES[k % LINES.len()];
        let own = rows.iter().filter(|row| row.method == *method);
        let points: Vec<(f64, f64)> = own.map(|row| (x(row.size()), y(row.seconds))).collect();
        let path: Vec<String> = points
            .iter()
            .map(|(x, y)| format!("{x:.1},{y:.1}"))
            .collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"/>",
            path.join(" ")
        );
        for (x, y) in points {
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.4\" fill=\"{colour}\"/>"
            );
        }
    }
}
