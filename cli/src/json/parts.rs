//! What the documents have in common.

use std::fmt::Write as _;

use hangtime::model::{ContactDeclaration, Declaration, Model};
use hangtime::simulation::{ContactMode, Diagnosis, Direction, Event, Simulation, Trajectory};
use serde::{Serialize, Serializer};

use super::columns::{Columns, finite_instants, kept_instants, of_kept, quantities};
use crate::ending::Ending;
use crate::failure::steers;
use crate::settings::ChosenScene;
use crate::thinning;

/// Version of the document's layout.
pub(crate) const SCHEMA: u32 = 1;

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

/// Parameter values by name, in order of declaration, then the choices of the scene's form.
pub(crate) struct ParameterValues<'a> {
    model: &'a dyn Model,
    choices: &'static [(&'static str, &'static str)],
}

impl<'a> ParameterValues<'a> {
    /// The values of a scene with its settings applied.
    pub(crate) fn of(chosen: &'a ChosenScene) -> Self {
        Self {
            model: chosen.model.as_ref(),
            choices: chosen.choices,
        }
    }
}

impl Serialize for ParameterValues<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeMap as _;
        let mut map = serializer.serialize_map(None)?;
        for (index, parameter) in self.model.declaration().parameters.iter().enumerate() {
            map.serialize_entry(parameter.name, &self.model.parameter(index))?;
        }
        for (name, choice) in self.choices {
            map.serialize_entry(name, choice)?;
        }
        map.end()
    }
}

/// Where and why a run ended early.
#[derive(Serialize)]
pub(super) struct DiagnosisEntry<'a> {
    /// Time that was reached \[s\].
    time: f64,
    /// Step in which it ended, from 0.
    step: usize,
    /// The contact concerned, if one can be named.
    contact: Option<&'static str>,
    /// What happened, and what to change.
    message: &'a str,
}

impl<'a> DiagnosisEntry<'a> {
    /// Where it stopped, and why it `ended`.
    pub(super) fn new(
        diagnosis: &Diagnosis,
        ended: &'a Ending,
        contacts: &[ContactDeclaration],
    ) -> Self {
        Self {
            time: diagnosis.time,
            step: diagnosis.step,
            contact: diagnosis.contact.map(|contact| contacts[contact].name),
            message: ended.diagnosis.as_deref().unwrap_or_default(),
        }
    }
}

/// An event.
#[derive(Serialize)]
pub(super) struct EventEntry<'a> {
    /// When \[s\].
    time: f64,
    /// What: `impact`, `lift_off`, `contact`, `stick`, `slip`, `switch`, `slide`, `when`.
    kind: &'static str,
    /// The contact or switch.
    contact: &'static str,
    /// Coordinates.
    q: &'a [f64],
    /// Velocities right before it.
    v_before: &'a [f64],
    /// Velocities right after it.
    v_after: &'a [f64],
    /// States of first order. Only for scenes that declare states.
    #[serde(skip_serializing_if = "<[f64]>::is_empty")]
    states: &'a [f64],
    /// Impulse of each contact. Only of impacts.
    #[serde(skip_serializing_if = "<[f64]>::is_empty")]
    contact_impulse: &'a [f64],
    /// Impulse of the friction of each contact. Only of impacts in scenes with friction.
    #[serde(skip_serializing_if = "<[f64]>::is_empty")]
    friction_impulse: &'a [f64],
}

impl<'a> EventEntry<'a> {
    /// All events of a motion.
    pub(super) fn all(events: &'a [Event], declaration: &Declaration) -> Vec<Self> {
        let entries = events.iter();
        entries.map(|event| Self::new(event, declaration)).collect()
    }

    fn new(event: &'a Event, declaration: &Declaration) -> Self {
        let mechanical = declaration.mechanical();
        let (v_after, states) = event.v_after.split_at(mechanical);
        Self {
            time: event.time,
            kind: event.kind.name(),
            contact: declaration.contacts[event.contact].name,
            q: &event.q[..mechanical],
            v_before: &event.v_before[..mechanical],
            v_after,
            states,
            contact_impulse: &event.contact_impulse,
            friction_impulse: &event.friction_impulse,
        }
    }
}

/// What a contact does from the start on: of none of these there is an event.
#[derive(Serialize)]
pub(super) struct InitialEntry {
    /// The contact or switch.
    contact: &'static str,
    /// What it does: open, closed, sticking, or slipping forward or backward; of a switch the sign of its function, or `sliding`.
    mode: String,
}

impl InitialEntry {
    /// Those of a run.
    pub(super) fn all(simulation: &Simulation) -> Vec<Self> {
        let contacts = simulation.declaration.contacts.iter();
        let modes = simulation.initial_modes.iter();
        let entry = |(contact, mode): (&ContactDeclaration, &ContactMode)| Self {
            contact: contact.name,
            mode: match (contact.switch, mode) {
                // Friction against minus the function of the switch.
                (Some(_), ContactMode::Slip(Direction::Forward)) => "negative".to_owned(),
                (Some(_), ContactMode::Slip(Direction::Backward)) => "positive".to_owned(),
                (Some(_), ContactMode::Stick) => "sliding".to_owned(),
                _ => mode.to_string(),
            },
        };
        contacts.zip(modes).map(entry).collect()
    }
}

/// The instants of a trajectory, thinned to the number asked for.
#[derive(Default, Serialize)]
pub(super) struct TrajectoryEntry {
    /// Time \[s\]; the same twice in a row where something jumps.
    time: Vec<f64>,
    /// Time of the time-freezing system \[s\]; that of the motion with other formulations.
    numerical_time: Vec<f64>,
    /// Coordinates.
    q: Columns,
    /// Velocities.
    v: Columns,
    /// States of first order. Only for scenes that declare states.
    #[serde(skip_serializing_if = "Columns::is_empty")]
    states: Columns,
    /// Controls.
    u: Columns,
    /// Normal force of each contact.
    contact_force: Columns,
    /// Friction force of each contact. Only for scenes with friction.
    #[serde(skip_serializing_if = "Columns::is_empty")]
    friction_force: Columns,
    /// What the scene declares in `outputs`. Only for scenes that declare outputs.
    #[serde(skip_serializing_if = "Columns::is_empty")]
    outputs: Columns,
}

impl TrajectoryEntry {
    /// At most `most` of the rows before the first state that is not finite; other such numbers are null.
    pub(super) fn new(model: &dyn Model, trajectory: &Trajectory, most: usize) -> Self {
        let kept = kept_instants(trajectory, most);
        let part = |name: &str| of_kept(model, trajectory, &kept, name).unwrap_or_default();
        Self {
            time: part("time").values,
            numerical_time: part("numerical_time").values,
            q: part("q"),
            v: part("v"),
            states: match model.declaration().states.len() {
                0 => Columns::default(),
                _ => part("states"),
            },
            u: part("u"),
            contact_force: part("contact_force"),
            friction_force: part("friction_force"),
            outputs: part("outputs"),
        }
    }

    /// What the notes say about rows that were left out.
    pub(super) fn note(&self, trajectory: &Trajectory) -> Option<String> {
        thinning::note(finite_instants(trajectory), self.time.len())
    }

    pub(super) fn last(&self) -> Option<FinalEntry> {
        let row = |part: &Columns| part.last().map(<[f64]>::to_vec);
        Some(FinalEntry {
            time: *self.time.last()?,
            q: row(&self.q)?,
            v: row(&self.v)?,
            states: row(&self.states).unwrap_or_default(),
        })
    }
}

/// Name and unit of every column of a trajectory.
#[derive(Serialize)]
pub(super) struct QuantitiesEntry {
    /// Unit of the time.
    time: &'static str,
    /// Of coordinates.
    q: Vec<QuantityEntry>,
    /// Of velocities.
    v: Vec<QuantityEntry>,
    /// Of states. Only for scenes that declare states.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    states: Vec<QuantityEntry>,
    /// Of controls.
    u: Vec<QuantityEntry>,
    /// Of normal forces.
    contact_force: Vec<QuantityEntry>,
    /// Of friction forces. Only for scenes with friction.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    friction_force: Vec<QuantityEntry>,
    /// Of outputs. Only for scenes that declare outputs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    outputs: Vec<QuantityEntry>,
}

/// A column.
#[derive(Serialize)]
struct QuantityEntry {
    /// Name of the coordinate, control or contact; of a velocity `dy/dt`.
    name: String,
    /// Its unit; empty for a number.
    unit: String,
}

impl QuantitiesEntry {
    pub(super) fn of(model: &dyn Model) -> Self {
        let columns = |part: &str| {
            let quantities = quantities(model, part).into_iter();
            let entries = quantities.map(|(name, unit)| QuantityEntry { name, unit });
            entries.collect()
        };
        Self {
            time: "s",
            q: columns("q"),
            v: columns("v"),
            states: columns("states"),
            u: columns("u"),
            contact_force: columns("contact_force"),
            outputs: columns("outputs"),
            friction_force: columns("friction_force"),
        }
    }
}

/// The state at the end.
#[derive(Serialize)]
pub(super) struct FinalEntry {
    /// Time \[s\].
    time: f64,
    /// Coordinates.
    q: Vec<f64>,
    /// Velocities.
    v: Vec<f64>,
    /// States of first order. Only for scenes that declare states.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    states: Vec<f64>,
}
