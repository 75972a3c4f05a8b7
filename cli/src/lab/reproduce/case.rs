//! One published case: its scene and data, and what came out.

use crate::{ComparedValue, Measure, PublishedCase, PublishedData, Quantity, Scene};

use crate::failure::BadInput;
use crate::page::{Player, Section};
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
    /// The motion, to play beside what was published; `None` without one.
    pub(super) player: Option<Player>,
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
        headed(&self.words(value), value.unit)
    }

    /// What a value is.
    pub(super) fn words(&self, value: ComparedValue) -> String {
        let model = self.chosen.model.as_ref();
        let symbol = |quantity| quantity::symbol(model, quantity);
        let coordinate = |index| symbol(Quantity::Coordinate(index));
        match value.measure {
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
        }
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

/// Digits of a value of whose error nothing is known, and most digits: beyond them the difference itself says more.
const DIGITS: [f64; 2] = [6.0, 8.0];

/// A value with the digits that matter: down to the first one that its error may change, but not more than eight; six where
/// nothing is known of that.
pub(super) fn significant(value: f64, error: Option<f64>) -> String {
    // The place behind the point of the digit with this power of ten.
    let place = |x: f64| -x.abs().log10().floor();
    let first = if value == 0.0 { 0.0 } else { place(value) };
    let most = first + DIGITS[1] - 1.0;
    let decimals = match error.filter(|error| error.is_finite()) {
        Some(0.0) => most,
        Some(error) => place(error).min(most),
        None => first + DIGITS[0] - 1.0,
    };
    format!("{value:.*}", decimals.max(0.0) as usize)
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn digits_end_where_the_error_begins_and_are_eight_at_most() {
        assert_eq!(significant(35.828_043_575, Some(-2.4e-1)), "35.8");
        assert_eq!(significant(1.785_438_154_1, Some(7.5e-11)), "1.7854382");
        assert_eq!(significant(35.110_734_819_3, Some(-3.1e-9)), "35.110735");
        assert_eq!(significant(16.510_246_358, None), "16.5102");
        assert_eq!(significant(0.0, None), "0.00000");
        assert_eq!(significant(1234.5, Some(20.0)), "1234");
        assert_eq!(significant(0.5, Some(0.0)), "0.50000000");
    }
}
