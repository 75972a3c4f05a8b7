//! All cases in one table, and the cases of a scene in one figure.

use std::fmt::Write as _;

use crate::{PublishedCase, Quantity, Reference, Task};

use super::case::{Reproduced, decimals, significant};
use crate::figure::{COLOURS, Series, over_time};
use crate::motion::{panel, series};
use crate::page::{Block, Section, Table};
use crate::table::{seconds, table};

/// The page that shows everything: its file, and what it holds.
pub(super) const INDEX: (&str, &str) = ("index.html", "all published results");
/// What words mean.
pub(super) const NOTE: &str = "Each section shows a published motion beside the same motion computed here. Numbers end at the \
    first digit that their error changes, or after eight; without a better value to compare with they have six. Certified values come from quadrature or Taylor series in at least 25 digits; best known values are the best \
    local optima that any search has found. The residual of a simulation is its largest violated equation or sign \
    condition; that of an optimum is the distance at the end between the plan and an independent event-driven \
    simulation under its controls.";

const HEADER: [&str; 8] = [
    "",
    "published",
    "hangtime",
    "certified or best",
    "published off by",
    "hangtime off by",
    "CPU time",
    "residual",
];

/// A row with the name of each case, and one for each of its values.
fn rows(reproduced: &[Reproduced]) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for one in reproduced {
        let mut head = vec![String::new(); HEADER.len()];
        head[0] = one.case.published.title.to_owned();
        head[HEADER.len() - 2] = seconds(one.seconds);
        head[HEADER.len() - 1] = format!("{:.1e}", one.residual);
        rows.push(head);
        rows.extend(one.rows.iter().map(|row| {
            let known = match row.value.reference {
                Reference::BestKnown(_) => format!("({})", row.known_text()),
                _ => row.known_text(),
            };
            vec![
                format!("  {}", row.label),
                row.published_text(),
                decimals(row.ours),
                known,
                row.difference(row.published),
                row.difference(row.ours),
                String::new(),
                String::new(),
            ]
        }));
    }
    rows
}

/// The table and the remarks for people.
pub(super) fn text(reproduced: &[Reproduced]) -> String {
    let mut text = table(HEADER, rows(reproduced));
    text.push_str(
        "  certified: quadrature or Taylor series in 25 digits and more; in brackets: best of all local optima known\n  \
         residual of a simulation: largest violated condition; of an optimum: distance of its re-simulation at the end\n\n\
         what differs\n",
    );
    for one in reproduced {
        let _ = writeln!(text, "  {}", one.case.published.title);
        for remark in &one.remarks {
            let _ = writeln!(text, "    {remark}");
        }
    }
    text
}

/// The cases of each scene in common figures over time, as (name, SVG).
pub(super) fn figures(reproduced: &[Reproduced]) -> Vec<(String, String)> {
    let mut figures: Vec<(String, String)> = Vec::new();
    for one in reproduced {
        let scene = one.case.chosen.scene;
        let name = format!("{}_over_time.svg", scene.name);
        if figures.iter().any(|(known, _)| *known == name) {
            continue;
        }
        let cases: Vec<&Reproduced> = reproduced
            .iter()
            .filter(|other| std::ptr::eq(other.case.chosen.scene, scene))
            .collect();
        let mut shown: Vec<(Quantity, &'static str)> = Vec::new();
        for curve in cases.iter().flat_map(|one| &one.case.data.curves) {
            if !shown
                .iter()
                .any(|(quantity, _)| *quantity == curve.quantity)
            {
                shown.push((curve.quantity, curve.unit));
            }
        }
        let model = one.case.chosen.model.as_ref();
        let panels = shown.into_iter().map(|(quantity, unit)| {
            let with = cases.iter().enumerate();
            let drawn = with.filter(|(_, one)| one.case.data.curve(quantity).is_some());
            let lines = drawn.map(|(index, one)| Series {
                name: Some(short(one.case.published)),
                colour: COLOURS[index % COLOURS.len()],
                dashed: matches!(one.case.published.task, Task::Simulate { .. }),
                ..series(model, quantity, unit, &one.states, &one.case.data)
            });
            panel(model, quantity, unit, lines.collect())
        });
        let panels: Vec<_> = panels.collect();
        let title = format!("{}: lines computed, dots published", scene.name);
        figures.push((name, over_time(&title, &panels)));
    }
    figures
}

/// Name of a case in a legend: its title without the name of the scene.
fn short(published: &PublishedCase) -> String {
    let title = published.title;
    title
        .split_once(", ")
        .map_or(title, |(_, rest)| rest)
        .to_owned()
}

/// The columns of the table on the page.
const COLUMNS: [&str; 8] = [
    "case",
    "value",
    "published",
    "hangtime",
    "certified (or best known)",
    "published off by",
    "hangtime off by",
    "CPU time",
];

/// All values, with their units and the digits that matter.
pub(super) fn values(reproduced: &[Reproduced]) -> Table {
    let mut rows = Vec::new();
    for one in reproduced {
        for (index, row) in one.rows.iter().enumerate() {
            let of_first = |text: String| if index == 0 { text } else { String::new() };
            let known = row.value.reference.value();
            let off = |value: Option<f64>| Some(value? - known?);
            let unit = row.value.unit;
            let with_unit = |text: String| format!("{text} {unit}").trim_end().to_owned();
            let number = |value: Option<f64>, error: Option<f64>| {
                value.map_or_else(
                    || "-".to_owned(),
                    |value| with_unit(significant(value, error)),
                )
            };
            let difference = |value: Option<f64>| {
                off(value).map_or_else(|| "-".to_owned(), |off| with_unit(format!("{off:+.0e}")))
            };
            let published = match row.value.stated {
                // Rounded by the authors: more digits would not be theirs.
                Some(stated) => with_unit(stated.to_string()),
                None => number(row.published, off(row.published)),
            };
            let reference = number(known, off(row.ours));
            rows.push(vec![
                of_first(one.case.published.title.to_owned()),
                one.case.words(row.value),
                published,
                number(row.ours, off(row.ours)),
                match row.value.reference {
                    Reference::BestKnown(_) => format!("({reference})"),
                    _ => reference,
                },
                difference(row.published),
                difference(row.ours),
                of_first(seconds(one.seconds)),
            ]);
        }
    }
    Table {
        header: COLUMNS.map(str::to_owned).into(),
        rows,
        dense: true,
    }
}

/// The section of all values on the page.
pub(super) fn section(reproduced: &[Reproduced]) -> Section {
    Section {
        heading: "Published numbers".to_owned(),
        blocks: vec![Block::Table(values(reproduced))],
        files: Vec::new(),
    }
}

/// The section of the cases of each scene over time.
pub(super) fn over_time_section(figures: &[(String, String)]) -> Section {
    let drawn = figures.iter().map(|(_, svg)| Block::figure(svg.clone()));
    Section {
        heading: "Over time".to_owned(),
        blocks: drawn.collect(),
        files: figures
            .iter()
            .map(|(name, _)| (name.clone(), name.clone()))
            .collect(),
    }
}

/// The section of one case, with its figures and a link to every file.
pub(super) fn section_of(
    published: &PublishedCase,
    remarks: &[String],
    files: &[(String, String)],
    header: Vec<String>,
    rows: Vec<Vec<String>>,
) -> Section {
    let mut text = format!("{}.", published.source);
    for remark in remarks {
        let mut letters = remark.chars();
        if let Some(first) = letters.next() {
            let _ = write!(text, " {}{}.", first.to_uppercase(), letters.as_str());
        }
    }
    let figures = files.iter().filter(|(name, _)| name.ends_with(".svg"));
    let mut blocks = vec![Block::Text(text)];
    blocks.extend(figures.map(|(_, svg)| Block::figure(svg.clone())));
    blocks.push(Block::table(header, rows));
    Section {
        heading: published.title.to_owned(),
        blocks,
        files: files
            .iter()
            .map(|(name, _)| {
                let what = if name.ends_with(".html") {
                    "the motion, to play"
                } else {
                    name
                };
                (name.clone(), what.to_owned())
            })
            .collect(),
    }
}
