//! Motions that play in a page: frames in plain data, drawn by a script that the page carries along.

mod force;
mod touch;

use crate::{PublishedData, PublishedPoint};
use hangtime::model::Model;
use hangtime::simulation::{Event, Simulation};
use serde::Serialize;

use self::force::Arrow;
use crate::drawing::{Body, Drawing, GroundLine, Placed, frame};
use crate::json::to_line;
use crate::markup::embedded;
use crate::quantity;
use crate::sampling::{State, state_at};

/// The script, its style, and the elements that it works on.
pub(crate) const SCRIPT: &str = include_str!("player.js");
pub(crate) const STYLE: &str = include_str!("player.css");
pub(crate) const ELEMENTS: &str = include_str!("player.html");

/// Frames of a second of motion [1/s].
const FRAME_RATE: f64 = 240.0;
/// Fewest and most frames of a motion.
const FRAMES: (f64, f64) = (200.0, 2400.0);
/// Most events that can be gone to.
const MOST_EVENTS: usize = 500;

/// What the script draws.
#[derive(Serialize)]
struct Frames {
    bodies: Vec<BodyEntry>,
    /// Whether each line is a spring; the others are links.
    springs: Vec<bool>,
    axes: [String; 2],
    /// Left, right, bottom, top.
    frame: Vec<f64>,
    ground: Vec<GroundLine>,
    contacts: Vec<&'static str>,
    /// Largest force of a contact, and largest torque; 0 if there is none.
    largest_force: f64,
    largest_torque: f64,
    /// Units of both; empty where lengths are drawn in others than metres.
    units: [&'static str; 2],
    /// Place of each body, a row for each frame.
    positions: Vec<Vec<[f64; 2]>>,
    /// Angle of each body, a row for each frame.
    angles: Vec<Vec<f64>>,
    /// Both ends of each line, a row for each frame.
    ends: Vec<Vec<[[f64; 2]; 2]>>,
    /// What each contact does, a row for each frame; `null` where it does nothing.
    forces: Vec<Vec<Option<Arrow>>>,
    /// Published places of the bodies, in order of time.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    published: Vec<PublishedPoint>,
    #[serde(flatten)]
    curves: Curves,
}

/// All quantities over time.
#[derive(Serialize)]
struct Curves {
    time: Vec<f64>,
    events: Vec<EventEntry>,
    readings: Vec<Reading>,
}

#[derive(Serialize)]
struct BodyEntry {
    name: &'static str,
    /// Corners where place and angle are zero; none for a point.
    outline: Vec<[f64; 2]>,
    /// Whether a line from its place to its rim shows how it turns.
    spoke: bool,
}

#[derive(Serialize)]
struct EventEntry {
    time: f64,
    label: String,
}

/// A number that is shown beside the clock.
#[derive(Serialize)]
struct Reading {
    name: String,
    unit: String,
    values: Vec<f64>,
}

/// The part of a page that plays a motion.
pub(crate) struct Animation {
    frames: String,
}

impl Animation {
    /// The frames of a simulation, beside published places if there are any; `None` if nothing moved.
    pub(crate) fn new(
        drawing: &Drawing<'_>,
        model: &dyn Model,
        simulation: &Simulation,
        published: &PublishedData,
    ) -> Option<Self> {
        let states = states(model, simulation);
        let (first, last) = (states.first()?.time, states.last()?.time);
        if last <= first {
            return None;
        }
        let placed: Vec<Placed> = states.iter().map(|state| drawing.at(state)).collect();
        let extents: Vec<[f64; 2]> = placed
            .iter()
            .flat_map(|placed| placed.extent(&drawing.bodies))
            .chain(published.points.iter().flat_map(|p| p.positions.clone()))
            .collect();
        // Nothing but ground is drawn, or what is drawn has no place.
        if extents.is_empty() || !extents.as_flattened().iter().all(|x| x.is_finite()) {
            return None;
        }
        let frame = frame(extents.iter());
        let ground = drawing.ground(frame);
        let forces: Vec<Vec<Option<Arrow>>> = states
            .iter()
            .map(|state| force::arrows(drawing, &ground, model, state))
            .collect();
        let largest = |size: fn(&Arrow) -> f64| {
            let sizes = forces.iter().flatten().flatten().map(size);
            sizes.fold(0.0, f64::max)
        };
        let bodies = drawing.bodies.iter().enumerate();
        let bodies = bodies.map(|(index, body)| BodyEntry::new(body, index, &placed));
        let frames = Frames {
            bodies: bodies.collect(),
            springs: drawing.springs.clone(),
            axes: drawing.axes.clone(),
            frame: frame.concat(),
            ground,
            contacts: model
                .declaration()
                .contacts
                .iter()
                .map(|c| c.name)
                .collect(),
            largest_force: largest(Arrow::magnitude),
            largest_torque: largest(|arrow| arrow.torque.abs()),
            units: match drawing.unit {
                "m" => ["N", "N m"],
                _ => ["", ""],
            },
            angles: placed.iter().map(|placed| placed.angles.clone()).collect(),
            ends: placed.iter().map(|placed| placed.ends.clone()).collect(),
            positions: placed.into_iter().map(|placed| placed.places).collect(),
            forces,
            published: whole(published, drawing.bodies.len()),
            curves: Curves::new(model, simulation, &states),
        };
        Some(Self {
            frames: to_line(&frames),
        })
    }

    /// The elements of the player that has this number on its page, its data and, for whoever reads the page by program,
    /// the whole result, if it is not empty. One that `plays` does so as soon as it is seen.
    pub(crate) fn html(&self, number: usize, result: &str, plays: bool) -> String {
        let frames = embedded(&self.frames);
        let plays = if plays { " data-plays" } else { "" };
        let data = |id: &str, json: &str| {
            format!("<script type=\"application/json\" id=\"{id}\"{plays}>{json}</script>\n")
        };
        let mut html = ELEMENTS.to_owned() + &data("frames", &frames);
        if !result.is_empty() {
            html += &format!(
                "<script type=\"application/json\" id=\"result\">{}</script>\n",
                embedded(result)
            );
        }
        if number == 0 {
            return html;
        }
        // Every player has elements of its own.
        let numbered = |attribute: &str, html: &str| -> String {
            let opening = format!("{attribute}=\"");
            let mut pieces = html.split(&opening);
            let mut numbered = pieces.next().unwrap_or_default().to_owned();
            for piece in pieces {
                let (id, rest) = piece.split_once('"').unwrap_or((piece, ""));
                numbered += &format!("{attribute}=\"{id}{number}\"{rest}");
            }
            numbered
        };
        let (elements, data) = html.split_at(ELEMENTS.len());
        let elements = numbered(" for", &numbered(" id", elements));
        elements
            + &data
                .replace("id=\"frames\"", &format!("id=\"frames{number}\""))
                .replace("id=\"result\"", &format!("id=\"result{number}\""))
    }
}

/// Those that show every body, in order of time.
fn whole(published: &PublishedData, bodies: usize) -> Vec<PublishedPoint> {
    let points = published.points.iter();
    let whole = points.filter(|point| point.positions.len() == bodies);
    let mut whole: Vec<PublishedPoint> = whole.cloned().collect();
    whole.sort_by(|a, b| a.time.total_cmp(&b.time));
    whole
}

impl Curves {
    fn new(model: &dyn Model, simulation: &Simulation, states: &[State]) -> Self {
        let declaration = model.declaration();
        let readings = quantity::all(model).into_iter().map(|quantity| {
            let values = states.iter().filter_map(|state| state.value(quantity));
            Reading {
                name: quantity::symbol(model, quantity).replace("contact force", "force"),
                unit: quantity::unit(model, quantity),
                values: values.collect(),
            }
        });
        let events = shown(simulation).map(|event| EventEntry {
            time: event.time,
            label: format!(
                "{} {}",
                event.kind.name().replace('_', " "),
                declaration.contacts[event.contact].name
            ),
        });
        Self {
            time: states.iter().map(|state| state.time).collect(),
            events: events.collect(),
            readings: readings.collect(),
        }
    }
}

impl BodyEntry {
    fn new(body: &Body, index: usize, placed: &[Placed]) -> Self {
        let turns = placed.iter().any(|placed| placed.angles[index] != 0.0);
        Self {
            name: body.name,
            outline: body.outline.clone(),
            spoke: turns && body.round && !body.outline.is_empty(),
        }
    }
}

/// What a host draws of a motion, as JSON: the frames of the player, or the curves alone where nothing is drawn in a
/// plane; `None` if nothing moved.
pub(crate) fn motion(
    drawing: Option<&Drawing<'_>>,
    model: &dyn Model,
    simulation: &Simulation,
) -> Option<String> {
    let published = PublishedData::default();
    let drawn = |drawing| Animation::new(drawing, model, simulation, &published);
    if let Some(animation) = drawing.and_then(drawn) {
        return Some(animation.frames);
    }
    let states = states(model, simulation);
    let moved = states.first()?.time < states.last()?.time;
    moved.then(|| to_line(&Curves::new(model, simulation, &states)))
}

/// The events that the page has frames and buttons for.
fn shown(simulation: &Simulation) -> impl Iterator<Item = &Event> {
    simulation.events.iter().take(MOST_EVENTS)
}

/// The states of the frames: evenly spaced, and where something jumps one before and one after it, so that a step is drawn as a step.
fn states(model: &dyn Model, simulation: &Simulation) -> Vec<State> {
    let trajectory = &simulation.trajectory;
    let (Some(&first), Some(&last)) = (trajectory.time.first(), trajectory.time.last()) else {
        return Vec::new();
    };
    let count = ((last - first) * FRAME_RATE)
        .clamp(FRAMES.0, FRAMES.1)
        .round();
    let even = (0..=count as usize).map(|k| first + (last - first) * (k as f64 / count));
    let events = shown(simulation).map(|event| event.time);
    let jumps = jumps(&trajectory.time);
    let jump = |t: f64| {
        jumps
            .iter()
            .any(|&(before, _)| trajectory.time[before] == t)
    };
    let mut times: Vec<f64> = even.chain(events).map(|t| t.clamp(first, last)).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    times.retain(|&t| !jump(t));
    let smooth = times.iter().filter_map(|&t| state_at(model, trajectory, t));
    let sides = jumps.iter().flat_map(|&(before, after)| [before, after]);
    let sides = sides.map(|k| State::of(model, trajectory, k));
    let mut states: Vec<State> = smooth.chain(sides).collect();
    // Stable: the side before a jump stays before the one after it.
    states.sort_by(|a, b| a.time.total_cmp(&b.time));
    states
}

/// The instants right before and right after each jump: of those that have the same time, the first and the last.
fn jumps(time: &[f64]) -> Vec<(usize, usize)> {
    let mut jumps: Vec<(usize, usize)> = Vec::new();
    for k in 1..time.len() {
        if time[k] != time[k - 1] || time[k] == time[0] {
            continue;
        }
        match jumps.last_mut() {
            Some((_, after)) if *after == k - 1 => *after = k,
            _ => jumps.push((k - 1, k)),
        }
    }
    jumps.truncate(MOST_EVENTS);
    jumps
}
