//! One published case: its scene and data, and what came out.

use crate::{ComparedValue, Measure, PublishedCase, PublishedData, Quantity, Scene};

use super::column::Column;
use crate::failure::BadInput;
use crate::page::Section;
use crate::quantity;
use crate::sampling::State;
use crate::settings::ChosenScene;
use crate::table::headed;

/// A published case with its scene.
pub(super) struct Case {
    pub(super) published: &'static PublishedCase,
    pub(super) chosen: ChosenScene,
    pub(super) data: PublishedData,
}

/// What a case came to.
pub(super) struct Reproduced {
    pub(super) case: Case,
    /// The motion in dense states, for common figures.
    pub(super) states: Vec<State>,
    /// The compared values.
    pub(super) rows: Vec<Row>,
    /// CPU time [s].
    pub(super) seconds: f64,
    /// Largest residual of a simulation; distance of the re-simulation of an optimum.
    pub(super) residual: f64,
    /// What differs, a sentence each.
    pub(super) remarks: Vec<String>,
    pub(super) diagnoses: Vec<String>,
    pub(super) files: Vec<(String, String)>,
    pub(super) section: Section,
}

/// One compared value.
pub(super) struct Row {
    pub(super) label: String,
    pub(super) published: Option<f64>,
    pub(super) ours: Option<f64>,
    pub(super) value: ComparedValue,
}

impl Case {
    pub(super) fn new(
        scene: &'static Scene,
        published: &'static PublishedCase,
    ) -> Result<Self, BadInput> {
        let settings = published.settings.iter();
        let settings: Vec<String> = settings
            .map(|(name, value)| format!("{name}={value}"))
            .collect();
        Ok(Self {
            published,
            chosen: ChosenScene::new(scene, &settings)?,
            data: (published.data)().map_err(|error| BadInput::new(error.to_string()))?,
        })
    }

    /// The rows of the comparison with `ours`.
    pub(super) fn rows(&self, ours: &Column) -> Vec<Row> {
        let values = self.published.values.iter();
        values
            .map(|&value| Row {
                label: self.label(value),
                published: value.stated.or_else(|| self.data.value(value.measure)),
                ours: ours.measure(self, value),
                value,
            })
            .collect()
    }

    /// What a value is, with its unit.
    fn label(&self, value: ComparedValue) -> String {
        let declaration = self.chosen.model.declaration();
        let symbol = |quantity| quantity::symbol(declaration, quantity);
        let coordinate = |index| symbol(Quantity::Coordinate(index));
        let words = match value.measure {
            Measure::FinalTime => "final time".to_owned(),
            Measure::Final(quantity) => format!("{} at the end", symbol(quantity)),
            Measure::Gain(quantity) => format!("gain of {}", symbol(quantity)),
            Measure::At(time, quantity) => format!("{} at {time} s", symbol(quantity)),
            Measure::EventTime(kind) => format!("time of the {}", kind.name().replace('_', "-")),
            Measure::EventCoordinate(kind, index) => format!(
                "{} at the {}",
                coordinate(index),
                kind.name().replace('_', "-")
            ),
            Measure::Reach(index, target) => format!("{} = {target:.4} at", coordinate(index)),
        };
        headed(&words, value.unit)
    }

    /// A table with a column for every source, and the CPU time of each.
    pub(super) fn comparison(
        &self,
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
                let mut cells = vec![row.label.clone(), row.published_text(), row.known_text()];
                let measured = columns.iter();
                cells.extend(measured.map(|column| decimals(column.measure(self, row.value))));
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
}

impl Row {
    pub(super) fn published_text(&self) -> String {
        match self.value.stated {
            // Rounded by the authors: more digits would not be theirs.
            Some(stated) => stated.to_string(),
            None => decimals(self.published),
        }
    }

    pub(super) fn known_text(&self) -> String {
        use crate::Reference::{BestKnown, Certified, Unknown};
        match self.value.reference {
            Certified(value) => decimals(Some(value)),
            BestKnown(value) => value.to_string(),
            Unknown => decimals(None),
        }
    }

    /// Difference of a value from what is known, in words.
    pub(super) fn difference(&self, value: Option<f64>) -> String {
        let known = self.value.reference.value();
        value.zip(known).map_or_else(
            || "-".to_owned(),
            |(value, known)| format!("{:+.1e}", value - known),
        )
    }
}

/// Ten decimals, or a dash.
pub(super) fn decimals(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.10}"))
}
