//! What the documents have in common.

use std::fmt::Write as _;

use hangtime::model::{ContactDeclaration, Declaration, Model};
use hangtime::simulation::{ContactMode, Direction, Event, Simulation, Trajectory};
use serde::{Serialize, Serializer};
use serde_json::value::{RawValue, to_raw_value};

use super::columns::{finite_instants, kept_instants, of_kept, quantities};
use crate::ending::Ending;
use crate::failure::steers;
use crate::scene_file::warned;
use crate::settings::ChosenScene;
use crate::thinning;

/// Version of the document's layout.
pub(crate) const SCHEMA: u32 = 1;

/// The parts of a trajectory that have columns; those marked stand in documents only where there are any.
fn parts() -> [(&'static str, bool); 7] {
    [
        // Coordinates.
        ("q", false),
        // Velocities.
        ("v", false),
        // States of first order. Only for scenes that declare states.
        ("states", true),
        // Controls.
        ("u", false),
        // Normal force of each contact.
        ("contact_force", false),
        // Friction force of each contact. Only for scenes with friction.
        ("friction_force", true),
        // What the scene declares in `outputs`. Only for scenes that declare outputs.
        ("outputs", true),
    ]
}

/// One line of JSON with its line end, in which nothing steers a terminal: this stands in texts only, where JSON has
/// escapes for it.
pub(crate) fn to_line(value: &impl Serialize) -> String {
    // Maps with keys that are not text and failing writers are the only errors of this writer; the
    // documents have neither.
    let text = serde_json::to_string(value).unwrap_or_default();
    let mut line = String::with_capacity(text.len() + 1);
    for c in text.chars() {
        if steers(c) {
            let _ = write!(line, "\\u{:04x}", u32::from(c));
        } else {
            line.push(c);
        }
    }
    line + "\n"
}

/// An object of a document: its fields, written already, in the order of the contract.
#[derive(Default)]
pub(crate) struct Object(Vec<(String, Box<RawValue>)>);

impl Object {
    /// With one more field.
    pub(crate) fn with(mut self, name: &str, value: impl Serialize) -> Self {
        // See `to_line` on errors.
        let value = to_raw_value(&value).ok();
        self.0.extend(value.map(|value| (name.to_owned(), value)));
        self
    }

    /// With a field that is left out where there is nothing to tell.
    pub(crate) fn some(self, name: &str, value: Option<impl Serialize>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }

    /// With a list that is left out where it is empty.
    pub(crate) fn list(self, name: &str, values: &[impl Serialize]) -> Self {
        self.some(name, Some(values).filter(|values| !values.is_empty()))
    }

    /// The object as one line of text.
    pub(crate) fn text(&self) -> String {
        to_line(self)
    }
}

impl Serialize for Object {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

/// The begin of the document of a scene: with the values of its parameters in their declared units, by name in order of declaration,
/// and then the choices of its form.
pub(super) fn begun(chosen: &ChosenScene) -> Object {
    let mut parameters = Object::default();
    let declared = chosen.model.declaration().parameters.iter();
    for (index, parameter) in declared.enumerate() {
        parameters = parameters.with(parameter.name, chosen.model.parameter(index));
    }
    for (name, choice) in chosen.choices {
        parameters = parameters.with(name, choice);
    }
    Object::default()
        // Version of the layout of the document.
        .with("schema", SCHEMA)
        // Name of the scene.
        .with("scene", chosen.scene.name)
        // Values of the parameters in their declared units, by name, and the choice of the form of the scene.
        .with("parameters", parameters)
}

/// A motion as documents tell it.
pub(super) struct Motion<'a> {
    chosen: &'a ChosenScene,
    simulation: Option<&'a Simulation>,
    rows: usize,
}

impl<'a> Motion<'a> {
    /// With at most `rows` rows of its trajectory; without a simulation there are none.
    pub(super) fn new(
        chosen: &'a ChosenScene,
        simulation: Option<&'a Simulation>,
        rows: usize,
    ) -> Self {
        Self {
            chosen,
            simulation,
            rows,
        }
    }

    /// How it ended, where and why if early, what happened in the order of time, the instants, and the last of them.
    pub(super) fn told(
        &self,
        object: Object,
        ending: &Ending,
        diagnosis: Option<impl Serialize>,
    ) -> Object {
        let model = self.chosen.model.as_ref();
        let events = self.simulation.map_or(&[][..], |known| &known.events);
        let events = events.iter().map(|known| event(known, model.declaration()));
        let none = Trajectory::default();
        let trajectory = self.simulation.map_or(&none, |known| &known.trajectory);
        let (trajectory, last) = instants(model, trajectory, self.rows);
        object
            // How the run ended.
            .with("status", ending.status)
            // Where and why it ended early.
            .some("diagnosis", diagnosis)
            // What happened, in the order of time.
            .with("events", events.collect::<Vec<_>>())
            // The instants of the motion, at most as many as `--rows` allows.
            .with("trajectory", trajectory)
            // The last of them.
            .with("final", last)
    }

    /// What one might want to know about the run in sentences, name and unit of every column of the trajectory, and what contacts do from
    /// the start on.
    pub(super) fn ended(
        &self,
        object: Object,
        before: impl IntoIterator<Item = String>,
        behind: impl IntoIterator<Item = String>,
    ) -> Object {
        let thinned = self.simulation.and_then(|known| {
            let kept = kept_instants(&known.trajectory, self.rows).len();
            thinning::note(finite_instants(&known.trajectory), kept)
        });
        let notes = before.into_iter().chain(thinned).chain(behind);
        let notes = notes.chain(warned(self.chosen.scene));
        let initially = self.simulation.map_or_else(Vec::new, initially);
        object
            // What one might want to know about this run, in sentences.
            .with("notes", notes.collect::<Vec<_>>())
            // Name and unit of every column of the trajectory.
            .with("quantities", columns(self.chosen.model.as_ref()))
            // What contacts do from the start on.
            .with("initially", initially)
    }
}

/// An event: when \[s\], what of which contact or switch, and the state before and after it; impulses of impacts only.
pub(super) fn event(event: &Event, declaration: &Declaration) -> Object {
    let mechanical = declaration.mechanical();
    let (v_after, states) = event.v_after.split_at(mechanical);
    Object::default()
        // When \[s\].
        .with("time", event.time)
        // What: `impact`, `lift_off`, `contact`, `stick`, `slip`, `switch`, `slide`, `when`.
        .with("kind", event.kind.name())
        // The contact or switch.
        .with("contact", declaration.contacts[event.contact].name)
        // Coordinates.
        .with("q", &event.q[..mechanical])
        // Velocities right before it.
        .with("v_before", &event.v_before[..mechanical])
        // Velocities right after it.
        .with("v_after", v_after)
        // States of first order. Only for scenes that declare states.
        .list("states", states)
        // Impulse of each contact. Only of impacts.
        .list("contact_impulse", &event.contact_impulse)
        // Impulse of the friction of each contact. Only of impacts in scenes with friction.
        .list("friction_impulse", &event.friction_impulse)
}

/// What each contact does from the start on, as of none of this there is an event: open, closed, sticking, or slipping forward or
/// backward; of a switch the sign of its function, or `sliding`.
fn initially(simulation: &Simulation) -> Vec<Object> {
    let contacts = simulation.declaration.contacts.iter();
    let modes = simulation.initial_modes.iter();
    let entry = |(contact, mode): (&ContactDeclaration, &ContactMode)| {
        let mode = match (contact.switch, mode) {
            // Friction against minus the function of the switch.
            (Some(_), ContactMode::Slip(Direction::Forward)) => "negative".to_owned(),
            (Some(_), ContactMode::Slip(Direction::Backward)) => "positive".to_owned(),
            (Some(_), ContactMode::Stick) => "sliding".to_owned(),
            _ => mode.to_string(),
        };
        // The contact or switch.
        let object = Object::default().with("contact", contact.name);
        // What it does: open, closed, sticking, or slipping forward or backward; of a switch the sign of its function, or `sliding`.
        object.with("mode", mode)
    };
    contacts.zip(modes).map(entry).collect()
}

/// At most `most` of the rows before the first state that is not finite, and the state of the last one; other such numbers are null. The
/// time stands twice in a row where something jumps, and is followed by that of the time-freezing system \[s\].
fn instants(model: &dyn Model, trajectory: &Trajectory, most: usize) -> (Object, Option<Object>) {
    let kept = kept_instants(trajectory, most);
    let part = |name: &str| of_kept(model, trajectory, &kept, name).unwrap_or_default();
    let time = part("time").values;
    // Time \[s\]; the same twice in a row where something jumps.
    let mut last = time.last().map(|time| Object::default().with("time", time));
    // Time \[s\]; the same twice in a row where something jumps.
    let mut all = Object::default().with("time", time);
    // Time of the time-freezing system \[s\]; that of the motion with other formulations.
    all = all.with("numerical_time", part("numerical_time").values);
    for (name, is_optional) in parts() {
        let columns = part(name);
        if is_optional && columns.is_empty() || name == "states" && columns.width == 0 {
            continue;
        }
        if ["q", "v", "states"].contains(&name) {
            last = last.map(|last| last.some(name, columns.last()));
        }
        all = all.with(name, columns);
    }
    (all, last)
}

/// Name and unit of every column of a trajectory: of a velocity `dy/dt`, and no unit of a number.
fn columns(model: &dyn Model) -> Object {
    // Unit of the time.
    let mut all = Object::default().with("time", "s");
    for (part, is_optional) in parts() {
        let of_part = quantities(model, part).into_iter();
        let of_part = of_part.map(|(name, unit)| {
            Object::default()
                // Name of the coordinate, control or contact; of a velocity `dy/dt`.
                .with("name", name)
                // Its unit; empty for a number.
                .with("unit", unit)
        });
        let of_part: Vec<Object> = of_part.collect();
        if !is_optional || !of_part.is_empty() {
            all = all.with(part, of_part);
        }
    }
    all
}

/// A parameter that was found: its value and unit, its standard deviation where it has one, the range in which it was looked for, and the
/// end of that at which it is, if it is at one.
pub(super) fn found(
    (value, unit): (f64, &str),
    deviation: Option<Option<f64>>,
    range: (f64, f64),
    at_bound: Option<&str>,
) -> Object {
    Object::default()
        // The value that was found.
        .with("value", value)
        // Its unit.
        .with("unit", unit)
        // Its standard deviation. Null where the measurements do not determine it, and at a bound.
        .some("deviation", deviation)
        // The range in which it was looked for.
        .with("range", range)
        // The end of the range at which it is, `lower` or `upper`; null within it.
        .with("at_bound", at_bound)
}
