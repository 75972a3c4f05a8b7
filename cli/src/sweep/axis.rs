//! `--over NAME=from:to:count[UNIT]` and `--over NAME=a,b,c`: the values of one parameter.

use hangtime_scene_files::TextScene;
use hangtime_units::Quantity;

use crate::failure::{BadInput, did_you_mean};
use crate::settings::{ChosenScene, is_count};

/// Most points of a sweep: their rows are ordered in memory.
pub(super) const MOST_POINTS: usize = 10_000_000;

/// Significant digits of a decimal number that come back from a double as they were.
const DIGITS: usize = f64::DIGITS as usize;

/// The values that a parameter takes.
pub(super) struct Axis {
    /// Name of the parameter.
    pub(super) name: String,
    /// Its declared unit; empty for a number or a choice.
    pub(super) unit: &'static str,
    /// The values in that unit, as shortest texts that read back as the same numbers; or choices.
    pub(super) values: Vec<String>,
    /// Whether they choose the form of the scene.
    pub(super) is_choice: bool,
}

impl Axis {
    /// Reads `NAME=VALUES` for a scene in its default form.
    pub(super) fn read(chosen: &ChosenScene, text: &str) -> Result<Self, BadInput> {
        let refused = |what: &str| {
            BadInput::new(format!(
                "--over `{text}`: {what}; write NAME=from:to:count, such as speed=3:8:200 or speed=10:20:11km/h, or \
                 NAME=a,b,c"
            ))
        };
        let pair = text.split_once('=');
        let pair = pair.map(|(name, values)| (name.trim(), values.trim()));
        let Some((name, values)) = pair.filter(|(name, values)| name.len() * values.len() > 0)
        else {
            return Err(refused("a name and values are missing"));
        };
        let parameters = chosen.model.declaration().parameters;
        let Some(parameter) = parameters.iter().find(|known| known.name == name) else {
            return Self::choice(chosen, name, values);
        };
        let unit = parameter.unit;
        let number = |text: &str| {
            let value = Quantity::parse(text).and_then(|value| value.in_unit(unit));
            match value {
                Ok(value) if value.is_finite() => Ok(value),
                Ok(_) => Err(refused(&format!("`{text}` is not finite"))),
                Err(error) => Err(refused(&error.to_string())),
            }
        };
        let parts: Vec<&str> = values.split(':').collect();
        let numbers = match parts.as_slice() {
            [list] => list.split(',').map(|one| number(one.trim())).collect(),
            [from, to, count] => {
                let digits = count.trim_start();
                let end = digits.find(|c: char| !c.is_ascii_digit());
                let (count, unit) = digits.split_at(end.unwrap_or(digits.len()));
                let count = count.parse().ok();
                let Some(count) = count.filter(|count| (1..=MOST_POINTS).contains(count)) else {
                    return Err(refused(&format!(
                        "the count must be a whole number from 1 to {MOST_POINTS}"
                    )));
                };
                let [from, to] = [from, to].map(|end| number(&format!("{end}{unit}")));
                Ok(spread(from?, to?, count))
            }
            _ => Err(refused("a range has three parts")),
        };
        let numbers: Vec<f64> = numbers?;
        Ok(Self {
            name: name.to_owned(),
            unit,
            values: numbers.iter().map(ToString::to_string).collect(),
            is_choice: false,
        })
    }

    /// The choices of a form of the scene, or its counts.
    fn choice(chosen: &ChosenScene, name: &str, values: &str) -> Result<Self, BadInput> {
        let choices = chosen.choices.iter().map(|&(choice, _)| choice);
        let text = chosen.scene.text.map(TextScene::source);
        let counted = text.is_some_and(|text| is_count(text, name));
        if counted || choices.clone().any(|choice| choice == name) {
            return Ok(Self {
                name: name.to_owned(),
                unit: "",
                values: values.split(',').map(|v| v.trim().to_owned()).collect(),
                is_choice: true,
            });
        }
        let parameters = chosen.model.declaration().parameters;
        let names: Vec<&str> = (parameters.iter().map(|p| p.name).chain(choices)).collect();
        Err(BadInput::new(format!(
            "--over: scene `{}` has no parameter `{name}`{} (it has: {})",
            chosen.scene.name,
            did_you_mean(name, names.iter().copied()),
            names.join(", ")
        )))
    }

    /// The values as they tell sweeps apart: numbers to the digits that every decimal text keeps, so that what was computed in other ways
    /// is the same.
    pub(super) fn compared(&self) -> impl Iterator<Item = String> {
        let compared = |value: &String| match value.parse::<f64>() {
            Ok(number) if !self.is_choice => format!("{number:.*e}", DIGITS - 1),
            _ => value.clone(),
        };
        self.values.iter().map(compared)
    }

    /// Heading of the column: name and unit.
    pub(super) fn heading(&self) -> String {
        crate::table::headed(&self.name, self.unit)
    }
}

/// `count` numbers at equal distances, both ends included exactly, and rounded as by numpy's `linspace`; of one, the first.
fn spread(from: f64, to: f64, count: usize) -> Vec<f64> {
    let last = count.saturating_sub(1);
    // Counts are below 2^53.
    let step = (to - from) / last.max(1) as f64;
    let value = |k: usize| match k == last && k > 0 {
        true => to,
        false => k as f64 * step + from,
    };
    (0..count).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::{Axis, spread};
    use crate::settings::{ChosenScene, find};

    fn axis(text: &str) -> Result<Vec<String>, String> {
        let chosen = ChosenScene::new(find(crate::testing::SCENES, "slide").unwrap(), &[]).unwrap();
        let axis = Axis::read(&chosen, text).map_err(|refusal| refusal.to_string())?;
        Ok(axis.values)
    }

    #[test]
    fn range_has_both_ends_and_equal_distances() {
        assert_eq!(spread(0.1, 0.7, 1), [0.1]);
        let values = spread(-0.3, 0.9, 5);
        assert_eq!((values[0], values[4]), (-0.3, 0.9));
        for pair in values.windows(2) {
            assert!((pair[1] - pair[0] - 0.3).abs() < 1e-15);
        }
    }

    #[test]
    fn values_that_were_computed_in_other_ways_are_the_same() {
        let chosen = ChosenScene::new(find(crate::testing::SCENES, "slide").unwrap(), &[]).unwrap();
        let compared =
            |text: &str| -> Vec<String> { Axis::read(&chosen, text).unwrap().compared().collect() };
        let sums: Vec<String> = (0..7)
            .map(|k| (0.1 + f64::from(k) * 0.1).to_string())
            .collect();
        let listed = compared(&format!("start_y={}", sums.join(",")));
        assert_eq!(compared("start_y=0.1:0.7:7"), listed);
        assert_ne!(
            compared("start_y=0.1:0.7:7"),
            compared("start_y=0.1:0.70000000000001:7")
        );
    }

    #[test]
    fn values_are_numbers_in_the_declared_unit_whatever_unit_they_are_written_in() {
        assert_eq!(axis("start_y=1:3:3").unwrap(), ["1", "2", "3"]);
        assert_eq!(axis("start_y=100:300:3cm").unwrap(), ["1", "2", "3"]);
        assert_eq!(axis("start_y = 1, 250cm").unwrap(), ["1", "2.5"]);
    }

    #[test]
    fn what_is_no_axis_is_refused_with_the_remedy() {
        for (text, words) in [
            ("start_y", "a name and values are missing"),
            ("start_y=1:2", "a range has three parts"),
            ("start_y=1:2:0", "whole number from 1"),
            ("start_y=1:inf:3", "does not begin with a number"),
            ("start_y=1:2:3kg", "NAME=from:to:count"),
            ("start=1", "did you mean `start_y`?"),
        ] {
            let refusal = axis(text).unwrap_err();
            assert!(refusal.contains(words), "{text}: {refusal}");
        }
    }
}
