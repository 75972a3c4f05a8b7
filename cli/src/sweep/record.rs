//! `--record NAME,..`: numbers of a run, by name: those of its JSON document, and what follows from its motion.

use std::ops::Range;

use hangtime::simulation::EventKind;
use serde_json::Value;

use crate::Quantity;
use crate::failure::{BadInput, did_you_mean};
use crate::job::Run;
use crate::quantity;
use crate::sampling::Side;
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

/// Kinds of events, by the names that they have in documents.
const EVENTS: [EventKind; 8] = [
    EventKind::Impact,
    EventKind::Contact,
    EventKind::LiftOff,
    EventKind::Stick,
    EventKind::Slip,
    EventKind::Slide,
    EventKind::Switch,
    EventKind::When,
];

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
    /// A quantity at the end of the motion.
    Last(Quantity),
    /// The largest value of a quantity along the motion, or the smallest.
    Extreme(Quantity, Side),
    /// When an event happens for the so-manieth time, from 1, at a contact.
    Time(EventKind, usize, usize),
    /// The largest force of a contact.
    Force(usize),
    /// The largest force of a joint, by its equations among those of all joints.
    JointForce(Range<usize>),
}

impl Record {
    /// Finds `name` among what runs of the scene have.
    pub(super) fn read(chosen: &ChosenScene, name: &str, solve: bool) -> Result<Self, BadInput> {
        let known = Self::all(chosen, solve);
        let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        if let Some((_, unit, place)) = known.into_iter().find(|known| known.0 == plain(name)) {
            let heading = headed(name, &unit);
            return Ok(Self { heading, place });
        }
        if let Some(inner) = name.strip_prefix("time(").and_then(|n| n.strip_suffix(')')) {
            let place = Self::time(chosen, inner)
                .map_err(|what| BadInput::new(format!("--record `{name}`: {what}")))?;
            let heading = headed(name, "s");
            return Ok(Self { heading, place });
        }
        let known = Self::all(chosen, solve);
        let names: Vec<&str> = known.iter().map(|known| known.0.as_str()).collect();
        Err(BadInput::new(format!(
            "--record `{name}`: runs of scene `{}` have no such number{} (they have: {}, time(EVENT CONTACT N))",
            chosen.scene.name,
            did_you_mean(name, names.iter().copied()),
            names.join(", ")
        )))
    }

    /// Everything that has a name, with its unit.
    fn all(chosen: &ChosenScene, solve: bool) -> Vec<(String, String, Place)> {
        let (model, declaration) = (chosen.model.as_ref(), chosen.model.declaration());
        let entry = |name: &str, unit: &str, place| (name.to_owned(), unit.to_owned(), place);
        let numbers = match solve {
            true => &NUMBERS[..],
            false => &NUMBERS[..OF_SIMULATIONS],
        };
        let mut all: Vec<_> = numbers
            .iter()
            .map(|&(name, unit, keys)| entry(name, unit, Place::Keys(keys)))
            .collect();
        all.push(entry("events", "", Place::Events));
        let mut quantities = Vec::new();
        let coordinates = &declaration.coordinates[..declaration.mechanical()];
        for (index, coordinate) in coordinates.iter().enumerate() {
            let (name, rate) = (coordinate.name, format!("dot({})", coordinate.name));
            let per_second = per_second(coordinate.unit);
            let of_end = [("q", name, coordinate.unit), ("v", &rate, &per_second)];
            for (key, name, unit) in of_end {
                let place = Place::Final(key, index);
                all.push(entry(&format!("final.{name}"), unit, place));
            }
            quantities.push((name.to_owned(), Quantity::Coordinate(index)));
            quantities.push((rate, Quantity::Velocity(index)));
        }
        for (index, state) in declaration.states.iter().enumerate() {
            let place = Place::Final("states", index);
            all.push(entry(&format!("final.{}", state.name), state.unit, place));
            let velocity = Quantity::Velocity(declaration.mechanical() + index);
            quantities.push((state.name.to_owned(), velocity));
        }
        for (index, control) in declaration.controls.iter().enumerate() {
            quantities.push((control.name.to_owned(), Quantity::Control(index)));
        }
        for (index, output) in model.outputs().iter().enumerate() {
            let last = Place::Last(Quantity::Output(index));
            all.push(entry(&format!("output.{}", output.name), output.unit, last));
            quantities.push((output.name.to_owned(), Quantity::Output(index)));
        }
        for (name, what) in quantities {
            let unit = quantity::unit(model, what);
            for (side, word) in [(Side::Largest, "max"), (Side::Smallest, "min")] {
                let place = Place::Extreme(what, side);
                all.push((format!("{word}({name})"), unit.clone(), place));
            }
        }
        let presses = |index: &usize| !declaration.contacts[*index].dry;
        for index in (0..declaration.contacts.len()).filter(presses) {
            let unit = quantity::unit(model, Quantity::ContactForce(index));
            let name = format!("force({})", declaration.contacts[index].name);
            all.push((name, unit, Place::Force(index)));
        }
        let mut first = 0;
        for joint in declaration.joints.iter().flat_map(|joints| joints.list) {
            let rows = first..first + joint.rows;
            first = rows.end;
            let name = format!("force({})", joint.name);
            all.push(entry(&name, "", Place::JointForce(rows)));
        }
        all
    }

    /// Reads `EVENT CONTACT N`.
    fn time(chosen: &ChosenScene, text: &str) -> Result<Place, String> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let &[event, contact, count] = words.as_slice() else {
            return Err(
                "write time(EVENT CONTACT N), such as time(impact floor 1) for the first one"
                    .to_owned(),
            );
        };
        let kind = EVENTS.into_iter().find(|kind| kind.name() == event);
        let kind = kind.ok_or_else(|| {
            let names = EVENTS.map(EventKind::name);
            let nearest = did_you_mean(event, names);
            format!(
                "there is no event `{event}`{nearest} (events: {})",
                names.join(", ")
            )
        })?;
        let names = chosen.model.declaration().contacts.iter().map(|c| c.name);
        let place = names.clone().position(|name| name == contact);
        let place = place.ok_or_else(|| {
            let nearest = did_you_mean(contact, names.clone());
            let names: Vec<&str> = names.collect();
            format!(
                "scene `{}` has no contact `{contact}`{nearest} (it has: {})",
                chosen.scene.name,
                names.join(", ")
            )
        })?;
        match count.parse::<usize>() {
            Ok(count) if count > 0 => Ok(Place::Time(kind, place, count)),
            _ => Err(format!("`{count}`: the first one has the number 1")),
        }
    }

    /// The cell of a run: digits as they stand in its document; empty where there is none.
    pub(super) fn cell(&self, run: &Run, document: &Value) -> String {
        let number = |value: Option<f64>| {
            let value = value.filter(|value| value.is_finite());
            value.map_or_else(String::new, |value| text(&Value::from(value)))
        };
        match &self.place {
            Place::Events => {
                let events = document["events"].as_array();
                events.map_or_else(String::new, |events| events.len().to_string())
            }
            Place::Keys(keys) => text(keys.iter().fold(document, |value, &key| &value[key])),
            Place::Final(key, index) => text(&document["final"][key][index]),
            Place::Last(what) => number(run.last(*what)),
            Place::Extreme(what, side) => number(run.extreme(*what, *side)),
            Place::Time(kind, contact, count) => number(run.event_time(*kind, *contact, *count)),
            Place::Force(contact) => {
                number(run.extreme(Quantity::ContactForce(*contact), Side::Largest))
            }
            Place::JointForce(rows) => number(run.joint_force(rows)),
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
    use crate::host::HostScene;

    /// A ball that is dropped from 0.45 m with restitution 1/2, and a weight on a string behind it.
    const BALL: &str = "coordinates { z: m, a: m, b: m } outputs { twice: cm = 2*z } \
        lagrangian 1[kg]/2*(dot(z)^2 + dot(a)^2 + dot(b)^2) - 10[N]*z - 30[N]*a - 40[N]*b \
        joint held: (a, b) == (0, 0) \
        surface floor: z >= 0 impact floor: restitution 0.5 start { z: 0.45 } horizon 0.7[s]";

    fn cell(name: &str) -> Result<String, String> {
        let ball = HostScene::of_text("ball", BALL).unwrap();
        let chosen = ball.chosen(&[]).unwrap();
        let record = Record::read(&chosen, name, false).map_err(|refusal| refusal.to_string())?;
        let run = ball.simulate(&[], &mut |_| true).unwrap();
        let document = serde_json::from_str(&run.json()).unwrap();
        Ok(record.cell(&run, &document))
    }

    #[test]
    fn numbers_of_the_document_keep_its_digits() {
        let ball = HostScene::of_text("ball", BALL).unwrap();
        let run = ball.simulate(&[], &mut |_| true).unwrap();
        let document: serde_json::Value = serde_json::from_str(&run.json()).unwrap();
        for (name, value) in [
            ("final.z", &document["final"]["q"][0]),
            ("final.dot(z)", &document["final"]["v"][0]),
            ("final_time", &document["final"]["time"]),
        ] {
            assert_eq!(cell(name), Ok(value.to_string()));
        }
        assert_eq!(cell("events").unwrap(), "2");
        let events = json!({"events": [{"kind": "impact", "contact": "slope"}, {"kind": "slip", "contact": "slope"}]});
        assert_eq!(sequence(&events), "impact slope; slip slope");
        assert_eq!(sequence(&json!({})), "");
    }

    #[test]
    fn extremes_times_and_forces_are_those_of_the_motion() {
        // It falls for 0.3 s, strikes at 3 m/s, leaves at 1.5 m/s, and strikes again at 0.6 s; 0.1 s later it is at 0.025 m.
        for (name, right) in [
            ("max(z)", 0.45),
            ("min(z)", 0.0),
            ("max(dot(z))", 1.5),
            ("min(dot(z))", -3.0),
            ("time(impact floor 1)", 0.3),
            ("time(impact floor 2)", 0.6),
            ("max(twice)", 90.0),
            ("output.twice", 5.0),
            ("force(held)", 50.0),
            ("force(floor)", 0.0),
        ] {
            let found: f64 = cell(name).unwrap().parse().unwrap();
            // The tolerance of a simulation is 1e-6.
            assert!((found - right).abs() < 1e-4, "{name}: {found}");
        }
        assert_eq!(cell("time(impact floor 3)").unwrap(), "");
    }

    #[test]
    fn other_names_are_refused_with_what_there_is() {
        for (name, words) in [
            ("final_tme", "did you mean `final_time`?"),
            ("objective", "max(z)"),
            ("max(twic)", "did you mean `max(twice)`?"),
            ("time(impact floor)", "time(EVENT CONTACT N)"),
            ("time(impct floor 1)", "did you mean `impact`?"),
            ("time(impact wall 1)", "no contact `wall`"),
            ("time(impact floor 0)", "has the number 1"),
        ] {
            let refusal = cell(name).unwrap_err();
            assert!(refusal.contains(words), "{name}: {refusal}");
        }
    }
}
