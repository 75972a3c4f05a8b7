//! `--record NAME,..`: numbers of a run's JSON document, by name.

use serde_json::Value;

use crate::failure::{BadInput, did_you_mean};
use crate::settings::ChosenScene;
use crate::table::{headed, per_second};

/// Names that need no coordinate, with units and places in the document; the second group exists for solves only.
const NUMBERS: [(&str, &str, &[&str]); 5] = [
    ("final_time", "s", &["final", "time"]),
    ("horizon", "s", &["horizon"]),
    ("objective", "", &["objective"]),
    ("stationarity", "", &["stationarity"]),
    ("resimulation_error", "", &["resimulation_error"]),
];
/// How many of them every run has.
const OF_SIMULATIONS: usize = 2;

/// One recorded number.
#[derive(Debug)]
pub(super) struct Record {
    /// Name and unit.
    pub(super) heading: String,
    place: Place,
}

#[derive(Debug)]
enum Place {
    /// By keys.
    Keys(&'static [&'static str]),
    /// By the key of a vector in the final state, and the place in it.
    Final(&'static str, usize),
    /// How many events there are.
    Events,
}

impl Record {
    /// Finds `name` among what runs of the scene have.
    pub(super) fn read(chosen: &ChosenScene, name: &str, solve: bool) -> Result<Self, BadInput> {
        let numbers = if solve {
            &NUMBERS[..]
        } else {
            &NUMBERS[..OF_SIMULATIONS]
        };
        if name == "events" {
            let (heading, place) = (name.to_owned(), Place::Events);
            return Ok(Self { heading, place });
        }
        if let Some(&(_, unit, keys)) = numbers.iter().find(|known| known.0 == name) {
            let (heading, place) = (headed(name, unit), Place::Keys(keys));
            return Ok(Self { heading, place });
        }
        let declaration = chosen.model.declaration();
        let coordinates = &declaration.coordinates[..declaration.mechanical()];
        let mut names: Vec<String> = numbers.iter().map(|known| known.0.to_owned()).collect();
        names.push("events".to_owned());
        for (index, coordinate) in coordinates.iter().enumerate() {
            let (q, v) = (coordinate.name, format!("dot({})", coordinate.name));
            for (key, what, unit) in [
                ("q", q, coordinate.unit.to_owned()),
                ("v", v.as_str(), per_second(coordinate.unit)),
            ] {
                let known = format!("final.{what}");
                if known == name {
                    let (heading, place) = (headed(name, &unit), Place::Final(key, index));
                    return Ok(Self { heading, place });
                }
                names.push(known);
            }
        }
        for (index, state) in declaration.states.iter().enumerate() {
            let known = format!("final.{}", state.name);
            if known == name {
                let (heading, place) = (headed(name, state.unit), Place::Final("states", index));
                return Ok(Self { heading, place });
            }
            names.push(known);
        }
        Err(BadInput::new(format!(
            "--record `{name}`: runs of scene `{}` have no such number{} (they have: {})",
            chosen.scene.name,
            did_you_mean(name, names.iter().map(String::as_str)),
            names.join(", ")
        )))
    }

    /// The cell of a run's document: digits as they stand there; empty where there is none.
    pub(super) fn cell(&self, document: &Value) -> String {
        match &self.place {
            Place::Events => {
                let events = document["events"].as_array();
                events.map_or_else(String::new, |events| events.len().to_string())
            }
            Place::Keys(keys) => text(keys.iter().fold(document, |value, &key| &value[key])),
            Place::Final(key, index) => text(&document["final"][key][index]),
        }
    }
}

/// The events of a run in order, as `kind contact; kind contact`: its contact sequence.
pub(super) fn sequence(document: &Value) -> String {
    let events = document["events"].as_array().into_iter().flatten();
    let word = |event: &Value| format!("{} {}", text(&event["kind"]), text(&event["contact"]));
    events.map(word).collect::<Vec<_>>().join("; ")
}

fn text(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::{Record, sequence};
    use crate::settings::{ChosenScene, find};

    #[test]
    fn records_take_the_digits_of_the_document_and_refuse_other_names() {
        let chosen = ChosenScene::new(find(crate::testing::SCENES, "slide").unwrap(), &[]).unwrap();
        let first = chosen.model.declaration().coordinates[0].name;
        let document: serde_json::Value = serde_json::from_str(
            r#"{"final": {"time": 1.0, "q": [0.30000000000000004, 2], "v": [1e-300, 2]},
                "events": [{"kind": "impact", "contact": "slope"}, {"kind": "slip", "contact": "slope"}]}"#,
        )
        .unwrap();
        let cell = |name: &str| Record::read(&chosen, name, false).unwrap().cell(&document);
        assert_eq!(cell(&format!("final.{first}")), "0.30000000000000004");
        assert_eq!(cell(&format!("final.dot({first})")), "1e-300");
        assert_eq!(
            (cell("final_time"), cell("events")),
            ("1.0".into(), "2".into())
        );
        assert_eq!(sequence(&document), "impact slope; slip slope");
        assert_eq!(sequence(&json!({})), "");
        let refusal = Record::read(&chosen, "final_tme", false).unwrap_err();
        assert!(refusal.to_string().contains("did you mean `final_time`?"));
        assert!(Record::read(&chosen, "objective", false).is_err());
        assert!(Record::read(&chosen, "objective", true).is_ok());
    }
}
