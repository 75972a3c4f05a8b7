//! What stands behind `with`.

use crate::method::Method;
use crate::statement::{Expressions, Id};
use crate::words::{behind, parts, quoted, split};
use hangtime::ocp::ControlShape;

/// One setting of a run.
#[derive(Debug, Clone)]
pub(crate) enum Setting {
    /// A parameter, and the text of its value.
    Parameter(String, Id),
    /// An initial value.
    Start(String, Id),
    /// One of the motion that it is compared with, and what it is at the start of this one.
    TheirStart(String, Id),
    Horizon(Id),
    Tolerance(f64),
    /// Speed below which nothing bounces.
    Rest(f64),
    /// Width of smoothed steps.
    Width(f64),
    Steps(usize),
    /// Stages of an element, or of a phase.
    Stages(usize),
    /// Most events of a run.
    Events(usize),
    /// Acceleration of the auxiliary dynamics.
    Auxiliary(f64),
    Intervals(usize),
    Starts(usize),
    /// Elements of a phase, or of an interval of the program of the time-freezing system.
    Elements(usize),
    /// Most programs of a search.
    Programs(usize),
    /// Controls on intervals.
    Shape(ControlShape),
    /// By the program of the time-freezing system.
    Freezing,
    /// Intervals that are divided among phases.
    Aligned,
    Control(Control),
    /// A text of the scene, and what stands in its place.
    Replaced(String, String),
    /// Methods in the place of the usual ones.
    By(Vec<Method>),
    /// A setting of the run whose motion this one starts from, which is as this one otherwise.
    Previous(Box<Setting>),
    /// Whether it runs with the long tests.
    Long,
}

/// A control over time.
#[derive(Debug, Clone)]
pub(crate) struct Control {
    pub(crate) name: String,
    pub(crate) linear: bool,
    /// Times and values; the first time is the start for controls that are constant on intervals.
    pub(crate) nodes: Vec<(Option<Id>, Id)>,
}

/// Reads a line behind `with`: for each item the settings it stands for, one of which a run has.
///
/// # Errors
/// What cannot be read of it.
pub(crate) fn settings(
    number: usize,
    text: &str,
    expressions: &mut Expressions,
) -> Result<Vec<Vec<Setting>>, String> {
    let (text, by) = match behind(text, "by") {
        Some(names) => ("", Some(names)),
        None => match split(text, ", by ") {
            Some((text, names)) => (text, Some(names)),
            None => (text, None),
        },
    };
    let mut add = |text: &str| expressions.add(number, text);
    let mut all = Vec::new();
    for item in parts(text, ",").into_iter().filter(|item| !item.is_empty()) {
        all.push(one(item, &mut add)?);
    }
    if let Some(names) = by {
        let methods: Result<_, _> = parts(names, ",").into_iter().map(Method::read).collect();
        all.push(vec![Setting::By(methods?)]);
    }
    Ok(all)
}

fn one(item: &str, add: &mut dyn FnMut(&str) -> Id) -> Result<Vec<Setting>, String> {
    if item.starts_with('"') {
        return replaced(item);
    }
    if let Some(text) = behind(item, "previous") {
        let each = one(text, add)?.into_iter();
        return Ok(each
            .map(|setting| Setting::Previous(Box::new(setting)))
            .collect());
    }
    let number = |text: &str| text.parse().map_err(|_| format!("`{text}` is no number"));
    let whole = |text: &str| text.parse().map_err(|_| format!("`{text}` is no number"));
    if let Some(text) = behind(item, "horizon") {
        let each = parts(text, " or ").into_iter();
        return Ok(each.map(|text| Setting::Horizon(add(text))).collect());
    }
    type Measured = fn(f64) -> Setting;
    let numbers: [(&str, Measured); 4] = [
        ("tolerance", Setting::Tolerance),
        ("rest", Setting::Rest),
        ("width", Setting::Width),
        ("auxiliary", Setting::Auxiliary),
    ];
    for (word, setting) in numbers {
        if let Some(text) = behind(item, word) {
            let each = parts(text, " or ").into_iter();
            return each.map(|text| number(text).map(setting)).collect();
        }
    }
    type Counted = fn(usize) -> Setting;
    let counts: [(&str, Counted); 7] = [
        ("steps", Setting::Steps),
        ("stages", Setting::Stages),
        ("events", Setting::Events),
        ("intervals", Setting::Intervals),
        ("starts", Setting::Starts),
        ("elements", Setting::Elements),
        ("programs", Setting::Programs),
    ];
    for (word, setting) in counts {
        if let Some(text) = behind(item, word) {
            let each = parts(text, " or ").into_iter();
            return each.map(|text| whole(text).map(setting)).collect();
        }
    }
    match item {
        "linear" => return Ok(vec![Setting::Shape(ControlShape::Linear)]),
        "constant" => return Ok(vec![Setting::Shape(ControlShape::Constant)]),
        "freezing" => return Ok(vec![Setting::Freezing]),
        "aligned" => return Ok(vec![Setting::Aligned]),
        "long" => return Ok(vec![Setting::Long]),
        _ => {}
    }
    if let Some(text) = behind(item, "control") {
        return Ok(vec![Setting::Control(control(text, add)?)]);
    }
    type Named = fn(String, Id) -> Setting;
    let (text, setting): (_, Named) = if let Some(text) = behind(item, "their start") {
        (text, Setting::TheirStart)
    } else if let Some(text) = behind(item, "start") {
        (text, Setting::Start)
    } else {
        (behind(item, "set").unwrap_or(item), Setting::Parameter)
    };
    let (name, values) = split(text, "=").ok_or_else(|| format!("`{item}` is no setting"))?;
    let each = parts(values, " or ").into_iter();
    Ok(each
        .map(|value| setting(name.to_owned(), add(value)))
        .collect())
}

/// `"TEXT" => "OTHER" or "ANOTHER"`.
fn replaced(item: &str) -> Result<Vec<Setting>, String> {
    let (from, others) = quoted(item)?;
    let others = behind(others, "=>").ok_or("`=>` stands behind the text that is replaced")?;
    let each = parts(others, " or ").into_iter();
    each.map(|other| {
        let to = quoted(other)?.0.to_owned();
        Ok(Setting::Replaced(from.to_owned(), to))
    })
    .collect()
}

/// `u = 0 [N] until 1 [s] then 30 [N]`, or `u = 0 [N] at 0 [s] to 4 [N] at 2 [s]`.
fn control(text: &str, add: &mut dyn FnMut(&str) -> Id) -> Result<Control, String> {
    let (name, values) = split(text, "=").ok_or("a control is `NAME = VALUE`")?;
    let linear = split(values, " at ").is_some();
    let mut nodes = Vec::new();
    if linear {
        for node in parts(values, " to ") {
            let (value, time) = split(node, " at ").ok_or("a node is `VALUE at TIME`")?;
            nodes.push((Some(add(time)), add(value)));
        }
    } else {
        let mut begin = None;
        for piece in parts(values, " then ") {
            match split(piece, " until ") {
                Some((value, end)) => {
                    nodes.push((begin, add(value)));
                    begin = Some(add(end));
                }
                None => nodes.push((begin, add(piece))),
            }
        }
    }
    Ok(Control {
        name: name.to_owned(),
        linear,
        nodes,
    })
}
