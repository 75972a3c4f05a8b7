//! What stands behind `expect`: the grammar is told in README.md beside the cases.

use crate::document::Line;
use crate::found::fact;
use crate::method::Method;
use crate::words::{behind, parts, quoted, split, split_last};
use hangtime::prelude::EventKind;

/// All kinds of events, by the names that JSON has.
pub(crate) const KINDS: [EventKind; 8] = [
    EventKind::Impact,
    EventKind::Contact,
    EventKind::LiftOff,
    EventKind::Stick,
    EventKind::Slip,
    EventKind::Slide,
    EventKind::Switch,
    EventKind::When,
];

/// An expression of the language: its place among those of a block.
pub(crate) type Id = usize;

/// The expressions of a block, with the lines they stand in: of its scene, and of the one that it is compared with.
#[derive(Debug, Default, Clone)]
pub(crate) struct Expressions {
    pub(crate) own: Vec<Line>,
    pub(crate) theirs: Vec<Line>,
}

impl Expressions {
    pub(crate) fn add(&mut self, number: usize, text: &str) -> Id {
        let text = text.trim();
        let (all, text) = match behind(text, "their") {
            Some(text) => (&mut self.theirs, text),
            None => (&mut self.own, text),
        };
        let text = text.to_owned();
        all.push(Line { number, text });
        all.len() - 1
    }
}

/// What is expected of a number.
#[derive(Debug, Clone)]
pub(crate) enum Right {
    /// What hangs on parameters alone.
    Own(Id),
    /// The same of the run that this one is compared with.
    Their(Left),
    /// The derivative of a number that hangs on parameters by one of these.
    Derived(Id, String),
    /// What it is at the start.
    Start,
}

/// An expectation.
#[derive(Debug, Clone)]
pub(crate) struct Expectation {
    pub(crate) line: Line,
    pub(crate) claim: Claim,
    pub(crate) within: Within,
    /// The methods that it is about; empty for all that the block runs by default.
    pub(crate) by: Vec<Method>,
    /// By how many tolerances expected numbers are moved: zero but in the test of this runner.
    pub(crate) moved: f64,
}

/// How far a number may be from what is expected.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Within {
    /// What a run promises that was asked for nothing else: 1e-6 of the number, or of 1 where that is more.
    Promised,
    /// In the unit of the number.
    Absolute(Id),
    /// As a share of what is expected.
    Relative(Id),
    /// So many times the error that the run itself estimates.
    Estimated(Id),
}

/// Which event.
#[derive(Debug, Clone)]
pub(crate) struct Which {
    /// Any, if there is none.
    pub(crate) kind: Option<EventKind>,
    /// From 1 on, among those of its kind and name.
    pub(crate) number: usize,
    pub(crate) name: Option<String>,
}

/// When a value is looked at.
#[derive(Debug, Clone)]
pub(crate) enum Instant {
    Start,
    End,
    Time(Id),
    Before(Which),
    After(Which),
    /// At every point of the motion.
    Always,
}

/// How two numbers are compared.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Comparison {
    Equal,
    AtMost,
    AtLeast,
    Less,
    More,
}

/// What is compared.
#[derive(Debug, Clone)]
pub(crate) enum Left {
    /// An expression along the motion, and its text.
    Expression(Id, String),
    /// A number of the result itself, by its name.
    Fact(&'static str),
    /// What a state holds by this name.
    Named(String),
    /// How many events there are.
    Count(Which),
    /// A derivative of a value or of the time of an event by a quantity, on a side where it has only such.
    Derivative(Box<Left>, String, Option<Side>),
    /// The time of an event, from the start or from another one on.
    EventTime(Option<Which>, Which),
    /// How far a quantity may go to one side until the order of events is another.
    Limit(Text),
}

/// A side of a quantity, and whether the factor of the root of its change is asked for in the place of a derivative.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    pub(crate) above: bool,
    pub(crate) root: bool,
}

/// What is claimed.
#[derive(Debug, Clone)]
pub(crate) enum Claim {
    /// Of several on the right one is enough.
    Value(Left, Instant, Comparison, Vec<Right>),
    /// A text of the result has one of these words in it, or not.
    Text(Text, Vec<String>, bool),
    /// All events, in their order.
    Events(Vec<Which>),
    /// The events are those of the motion that it is compared with.
    SameEvents,
    /// A mistake of the scene: its code, words, and a text of the scene that it is about.
    Message([Option<String>; 3]),
}

/// A text of a result: one of [`TEXTS`], and of which quantity.
#[derive(Debug, Clone)]
pub(crate) struct Text {
    pub(crate) kind: &'static str,
    pub(crate) of: String,
}

const TEXTS: [&str; 9] = [
    "note",
    "diagnosis",
    "warning",
    "refusal",
    "status",
    "certificate",
    "obstacle",
    "limit above",
    "limit below",
];

/// Reads what stands behind `expect`, which may be several expectations.
///
/// # Errors
/// What cannot be read of it.
pub(crate) fn expectations(
    line: &Line,
    text: &str,
    expressions: &mut Expressions,
) -> Result<Vec<Expectation>, String> {
    let (text, names) = match split(text, " with derivatives by ") {
        Some((text, names)) => (text, parts(names, ",")),
        None => (text, Vec::new()),
    };
    let (text, by) = match split_last(text, " by ") {
        Some((before, names)) => match parts(names, ",").into_iter().map(Method::read).collect() {
            Ok(methods) => (before, methods),
            // Derivatives are by quantities.
            Err(_) if text.contains("derivative") => (text, Vec::new()),
            Err(error) => return Err(error),
        },
        None => (text, Vec::new()),
    };
    let mut add = |text: &str| expressions.add(line.number, text);
    let (text, within) = match split_last(text, " within ") {
        Some((before, tolerance)) => {
            let suffixes = ["relative", "estimated"].map(|word| tolerance.strip_suffix(word));
            match suffixes {
                [Some(share), _] => (before, Within::Relative(add(share))),
                [_, Some(factor)] => (before, Within::Estimated(add(factor))),
                _ => (before, Within::Absolute(add(tolerance))),
            }
        }
        None => (text, Within::Promised),
    };
    let mut claims = claims(text, &mut add)?;
    for name in names {
        let Claim::Value(left, instant, Comparison::Equal, right) = &claims[0] else {
            return Err("this has no derivatives".to_owned());
        };
        let [Right::Own(right)] = right[..] else {
            return Err("these have no derivatives".to_owned());
        };
        let left = Left::Derivative(Box::new(left.clone()), name.to_owned(), None);
        let right = vec![Right::Derived(right, name.to_owned())];
        claims.push(Claim::Value(
            left,
            instant.clone(),
            Comparison::Equal,
            right,
        ));
    }
    let each = claims.into_iter().map(|claim| Expectation {
        line: line.clone(),
        claim,
        within,
        by: by.clone(),
        moved: 0.0,
    });
    Ok(each.collect())
}

fn claims(text: &str, add: &mut dyn FnMut(&str) -> Id) -> Result<Vec<Claim>, String> {
    let absent = behind(text, "no");
    let rest = absent.unwrap_or(text);
    for kind in TEXTS {
        if let Some(rest) = behind(rest, kind) {
            return about_text(kind, rest, absent.is_none(), add);
        }
    }
    if let Some(rest) = behind(text, "message") {
        return Ok(vec![message(rest)?]);
    }
    if text == "same events" {
        return Ok(vec![Claim::SameEvents]);
    }
    if let Some(rest) = behind(text, "events") {
        let (mut events, mut times) = (Vec::new(), Vec::new());
        for (event, number) in parts(rest, ",").into_iter().zip(1..) {
            let (event, time) = timed(event, add);
            events.push(which(event)?);
            let any = Which {
                kind: None,
                number,
                name: None,
            };
            times.extend(time.map(|time| equal(Left::EventTime(None, any), time)));
        }
        times.insert(0, Claim::Events(events));
        return Ok(times);
    }
    if let Some(text) = text.strip_suffix(" constant") {
        let left = Left::Expression(add(text), text.to_owned());
        let start = vec![Right::Start];
        return Ok(vec![Claim::Value(
            left,
            Instant::Always,
            Comparison::Equal,
            start,
        )]);
    }
    if compared(text).is_some() {
        return Ok(vec![value(text, add)?]);
    }
    let (event, time) = timed(rest, add);
    let which = which(event)?;
    Ok(vec![match time {
        Some(time) if absent.is_none() => equal(Left::EventTime(None, which), time),
        _ => {
            let number = vec![Right::Own(add(&which.number.to_string()))];
            let comparison = absent.map_or(Comparison::AtLeast, |_| Comparison::Less);
            Claim::Value(Left::Count(which), Instant::End, comparison, number)
        }
    }])
}

fn equal(left: Left, right: Id) -> Claim {
    let right = vec![Right::Own(right)];
    Claim::Value(left, Instant::End, Comparison::Equal, right)
}

/// What stands before ` at TIME`, and that time.
fn timed<'a>(text: &'a str, add: &mut dyn FnMut(&str) -> Id) -> (&'a str, Option<Id>) {
    match split(text, " at ") {
        Some((before, time)) => (before, Some(add(time))),
        None => (text, None),
    }
}

/// `[no] KIND [OF] ["WORDS"]`: `status NAME or NAME [at TIME]`, `certificate NAME`, and `limit SIDE OF == CHANGE "WORDS"` as well.
fn about_text(
    kind: &'static str,
    rest: &str,
    present: bool,
    add: &mut dyn FnMut(&str) -> Id,
) -> Result<Vec<Claim>, String> {
    let (of, words) = rest.split_at(rest.find('"').unwrap_or(rest.len()));
    let (mut of, number) = match kind {
        "status" => timed(of.trim(), add),
        _ => match split(of, "==") {
            Some((of, change)) => (of, Some(add(change))),
            None => (of.trim(), None),
        },
    };
    let mut wanted = vec![String::new()];
    if ["status", "certificate"].contains(&kind) {
        let names = parts(std::mem::take(&mut of), " or ").into_iter();
        wanted = names.map(str::to_owned).collect();
    } else {
        let needs_quantity = kind.starts_with("limit") || kind == "obstacle";
        if needs_quantity == of.is_empty() || present && !needs_quantity && words.is_empty() {
            return Err(format!("`{rest}` is no {kind}"));
        }
        if !words.is_empty() {
            wanted = vec![quoted(words)?.0.to_owned()];
        }
    }
    let of = of.to_owned();
    let text = Text { kind, of };
    let left = match kind {
        "status" => Left::Fact("diagnosed_at"),
        _ => Left::Limit(text.clone()),
    };
    let mut claims = vec![Claim::Text(text, wanted, present)];
    claims.extend(number.map(|number| equal(left, number)));
    Ok(claims)
}

/// `[KIND] [NUMBER] [NAME]`; a name that is no word stands in quotes.
fn which(text: &str) -> Result<Which, String> {
    let (kind, rest) = text.split_once(' ').unwrap_or((text, ""));
    let known = KINDS.into_iter().find(|known| known.name() == kind);
    if known.is_none() && text != "events" {
        return Err(format!(
            "`{text}` is no event and nothing else that is known"
        ));
    }
    let rest = rest.trim();
    let (first, behind) = rest.split_once(' ').unwrap_or((rest, ""));
    let (number, rest) = match first.parse() {
        Ok(0) => return Err(format!("events are counted from 1 on: `{text}`")),
        Ok(number) => (number, behind.trim()),
        Err(_) => (1, rest),
    };
    let (name, rest) = match rest.starts_with('"') {
        true => quoted(rest)?,
        false => rest.split_once(' ').unwrap_or((rest, "")),
    };
    if !rest.is_empty() {
        return Err(format!("`{rest}` is too much in `{text}`"));
    }
    Ok(Which {
        kind: known,
        number,
        name: (!name.is_empty()).then(|| name.to_owned()),
    })
}

/// `[CODE] ["WORDS"] [at "TEXT"]`.
fn message(text: &str) -> Result<Claim, String> {
    let (what, place) = match split(text, "at ") {
        Some((what, place)) => (what, Some(quoted(place)?.0.to_owned())),
        None => (text, None),
    };
    let (code, words) = match what.find('"') {
        Some(at) => (what[..at].trim(), Some(quoted(&what[at..])?.0.to_owned())),
        None => (what, None),
    };
    let code = (!code.is_empty()).then(|| code.to_owned());
    if code.is_none() && words.is_none() {
        return Err("a message has a code, as E03, or words in quotes".to_owned());
    }
    Ok(Claim::Message([code, words, place]))
}

/// The two sides of a comparison.
fn compared(text: &str) -> Option<(&str, Comparison, &str)> {
    [
        ("==", Comparison::Equal),
        ("<=", Comparison::AtMost),
        (">=", Comparison::AtLeast),
        ("<", Comparison::Less),
        (">", Comparison::More),
    ]
    .into_iter()
    .find_map(|(mark, comparison)| {
        let (left, right) = split(text, mark)?;
        Some((left, comparison, right))
    })
}

/// `LEFT [INSTANT] OP RIGHT [INSTANT]`.
fn value(text: &str, add: &mut dyn FnMut(&str) -> Id) -> Result<Claim, String> {
    let (left, comparison, right) = compared(text).ok_or("a comparison is missing")?;
    let (left, first) = instant(left, add)?;
    let (right, second) = instant(right, add)?;
    let when = match (first, second) {
        (Some(_), Some(_)) => return Err(format!("`{text}` has two instants")),
        (first, second) => first.or(second).unwrap_or(Instant::End),
    };
    let (left, by) = match behind(left, "derivative") {
        Some(rest) => {
            let (of, by) = split_last(rest, " by ").ok_or("a derivative is `by` a quantity")?;
            (of, Some(by))
        }
        None => (left, None),
    };
    let (left, when) = of_time(left, when, add)?;
    let mut left = left_side(left, add)?;
    if let Some(by) = by {
        let (by, root) = by
            .strip_suffix(" as root")
            .map_or((by, false), |by| (by, true));
        let (by, side) = match split_last(by, " from ") {
            Some((by, side @ ("above" | "below"))) => {
                let above = side == "above";
                (by, Some(Side { above, root }))
            }
            _ => (by, None),
        };
        left = Left::Derivative(Box::new(left), by.trim().to_owned(), side);
    }
    let right = parts(right, " or ").into_iter();
    let right = right.map(|text| match behind(text, "their") {
        Some(name) => Right::Their(match fact(name) {
            Some(name) => Left::Fact(name),
            None => Left::Expression(add(text), name.to_owned()),
        }),
        None => Right::Own(add(text)),
    });
    let right = right.collect();
    Ok(Claim::Value(left, when, comparison, right))
}

/// An instant behind an expression.
fn instant<'a>(
    text: &'a str,
    add: &mut dyn FnMut(&str) -> Id,
) -> Result<(&'a str, Option<Instant>), String> {
    if let Some(text) = text.strip_suffix(" always") {
        return Ok((text, Some(Instant::Always)));
    }
    if let Some((text, event)) = split(text, " before ") {
        return Ok((text, Some(Instant::Before(which(event)?))));
    }
    if let Some((text, event)) = split(text, " after ") {
        return Ok((text, Some(Instant::After(which(event)?))));
    }
    Ok(match split(text, " at ") {
        Some((text, "start")) => (text, Some(Instant::Start)),
        Some((text, "end")) => (text, Some(Instant::End)),
        Some((text, time)) => (text, Some(Instant::Time(add(time)))),
        None => (text, None),
    })
}

/// `x(0.7 [s])`, which is `x at 0.7 [s]`.
fn of_time<'a>(
    text: &'a str,
    when: Instant,
    add: &mut dyn FnMut(&str) -> Id,
) -> Result<(&'a str, Instant), String> {
    let Some((name, time)) = text.strip_suffix(')').and_then(|text| text.split_once('(')) else {
        return Ok((text, when));
    };
    // A number with its unit: functions of the language take others.
    let is_time = name.chars().all(|c| c.is_alphanumeric() || c == '_') && time.ends_with("[s]");
    match (is_time, when) {
        (true, Instant::End) => Ok((name, Instant::Time(add(time)))),
        (true, _) => Err(format!("`{text}` has two instants")),
        (false, when) => Ok((text, when)),
    }
}

fn left_side(text: &str, add: &mut dyn FnMut(&str) -> Id) -> Result<Left, String> {
    if let Some(rest) = behind(text, "count").filter(|rest| !rest.is_empty()) {
        return Ok(Left::Count(which(rest)?));
    }
    if let Some(event) = behind(text, "time of") {
        return Ok(Left::EventTime(None, which(event)?));
    }
    if let Some((first, second)) = behind(text, "time from").and_then(|rest| split(rest, " to ")) {
        return Ok(Left::EventTime(Some(which(first)?), which(second)?));
    }
    if let Some(name) = behind(text, "state") {
        return Ok(Left::Named(quoted(name)?.0.to_owned()));
    }
    Ok(match fact(text) {
        Some(name) => Left::Fact(name),
        None => Left::Expression(add(text), text.to_owned()),
    })
}
