//! The charts of BENCHMARKS.md are drawn from its tables, so that they cannot say anything else.
//! `UPDATE_CHARTS=1` draws them anew.

use std::env;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const BENCHMARKS: &str = include_str!("../../BENCHMARKS.md");

/// Ink and paper by day and by night.
const COLOURS: &str = "svg{color:#1f2430;background:#ffffff}\
                       @media (prefers-color-scheme:dark){svg{color:#dfe3ea;background:#14171c}}";

/// A chart, and the columns of the table below it that it shows; each column gives a row one bar.
struct Chart {
    name: &'static str,
    columns: &'static [usize],
    logarithmic: bool,
}

const CHARTS: [Chart; 6] = [
    chart("simulation", &[3, 4], true),
    chart("derivatives", &[4], false),
    chart("nonlinear_programs", &[3], false),
    chart("growth", &[1, 2], true),
    chart("complementarity", &[1, 2], false),
    chart("optimal_control", &[4, 5], true),
];

const fn chart(name: &'static str, columns: &'static [usize], logarithmic: bool) -> Chart {
    Chart {
        name,
        columns,
        logarithmic,
    }
}

/// The cells of the table below the chart, its heading first.
fn table(name: &str) -> Vec<Vec<&'static str>> {
    let (_, below) = BENCHMARKS
        .split_once(&format!("(docs/charts/{name}.svg)\n"))
        .unwrap_or_else(|| panic!("BENCHMARKS.md shows no chart {name}"));
    let rows: Vec<Vec<&str>> = below
        .lines()
        .skip_while(|line| !line.starts_with('|'))
        .take_while(|line| line.starts_with('|'))
        .filter(|line| !line.starts_with("|--"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert!(rows.len() > 1, "no table below the chart {name}");
    rows
}

/// The number that a cell begins with.
fn number(cell: &str) -> Option<f64> {
    cell.split_whitespace()
        .next()?
        .replace(',', "")
        .parse()
        .ok()
}

/// Bars to the right, one group a row of the table.
fn draw(chart: &Chart) -> String {
    let rows = table(chart.name);
    let (heading, rows) = (&rows[0], &rows[1..]);
    let values: Vec<f64> = rows
        .iter()
        .flat_map(|row| chart.columns.iter().filter_map(|&c| number(row[c])))
        .collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let fraction = |value: f64| {
        if chart.logarithmic {
            // the shortest bar keeps a tenth of the width
            0.1 + 0.9 * (value / least).ln() / (largest / least).ln()
        } else {
            value / largest
        }
    };
    let (label, width, bar) = (330.0, 360.0, 13.0);
    let group = bar * chart.columns.len() as f64 + 8.0;
    let top = 16.0 + 18.0 * chart.columns.len() as f64;
    let height = top + group * rows.len() as f64 + 6.0;
    let colours = ["#2b6cb0", "#dd6b20"];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"800\" height=\"{height}\" viewBox=\"0 0 800 {height}\" \
         font-family=\"sans-serif\" font-size=\"12\" fill=\"currentColor\">\n<style>{COLOURS}</style>\n"
    );
    let scale = if chart.logarithmic {
        ", logarithmic"
    } else {
        ""
    };
    for (k, &column) in chart.columns.iter().enumerate() {
        let y = 16.0 + 18.0 * k as f64;
        let colour = colours[k];
        let _ = writeln!(
            svg,
            "<rect x=\"{label}\" y=\"{}\" width=\"12\" height=\"12\" fill=\"{colour}\"/><text x=\"{}\" y=\"{y}\">{}{scale}</text>",
            y - 10.0,
            label + 18.0,
            heading[column],
        );
    }
    for (r, row) in rows.iter().enumerate() {
        let y = top + group * r as f64;
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            label - 8.0,
            y + group / 2.0,
            row[0],
        );
        for (k, &column) in chart.columns.iter().enumerate() {
            let y = y + bar * k as f64;
            let length = number(row[column]).map_or(0.0, |value| width * fraction(value));
            let _ = writeln!(
                svg,
                "<rect x=\"{label}\" y=\"{y}\" width=\"{length:.1}\" height=\"{}\" fill=\"{}\"/><text x=\"{:.1}\" y=\"{}\">{}</text>",
                bar - 2.0,
                colours[k],
                label + length + 6.0,
                y + 10.0,
                row[column],
            );
        }
    }
    svg + "</svg>\n"
}

#[test]
fn charts_show_the_tables_of_the_benchmarks() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/charts");
    for chart in &CHARTS {
        let file = folder.join(format!("{}.svg", chart.name));
        let drawn = draw(chart);
        if env::var_os("UPDATE_CHARTS").is_some() {
            fs::create_dir_all(&folder).expect("a writable folder");
            fs::write(&file, drawn).expect("a writable folder");
            continue;
        }
        let kept = fs::read_to_string(&file).expect("the chart is kept beside the table");
        assert_eq!(
            kept, drawn,
            "{}: the table has changed; run with UPDATE_CHARTS=1",
            chart.name
        );
    }
    assert_eq!(BENCHMARKS.matches("](docs/charts/").count(), CHARTS.len());
}
