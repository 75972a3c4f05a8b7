//! All cases in one table, and the cases of a scene in one figure.

use std::fmt::Write as _;

use crate::{PublishedCase, Quantity, Reference, Task};

use super::case::{Reproduced, decimals};
use crate::figure::{COLOURS, Series, over_time};
use crate::motion::{panel, series};
use crate::page::Section;
use crate::table::{seconds, table};

/// The page that shows everything: its file, and what it holds.
pub(super) const INDEX: (&str, &str) = ("index.html", "all published results");
/// What the page is about.
pub(super) const INTRODUCTION: &str = "Each section shows a published motion beside the same motion computed here. \
    Certified values come from quadrature or Taylor series in at least 25 digits; best known values are the best \
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

/// The overview on the page.
pub(super) fn section(reproduced: &[Reproduced], figures: &[(String, String)]) -> Section {
    Section {
        heading: "Overview".to_owned(),
        text: "Best known values stand in brackets.".to_owned(),
        animation: None,
        folds: Vec::new(),
        figures: figures.iter().map(|(_, svg)| svg.clone()).collect(),
        header: HEADER.map(str::to_owned).into(),
        rows: rows(reproduced),
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
    Section {
        heading: published.title.to_owned(),
        text,
        animation: None,
        folds: Vec::new(),
        figures: figures.map(|(_, svg)| svg.clone()).collect(),
        header,
        rows,
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
