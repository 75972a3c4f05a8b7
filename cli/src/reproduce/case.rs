//! One published case: its scene and data, and what came out.

use crate::{ComparedValue, Measure, PublishedCase, PublishedData, Quantity, Scene};

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

    /// What a value is, with its unit.
    pub(super) fn label(&self, value: ComparedValue) -> String {
        let model = self.chosen.model.as_ref();
        let symbol = |quantity| quantity::symbol(model, quantity);
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
