//! What stands behind `expect`: the grammar is told in README.md beside the cases.

use crate::document::Line;
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

/// What is expected: of a number that hangs on parameters alone, or a value of the motion that it is compared with.
#[derive(Debug, Clone)]
pub(crate) enum Right {
    Own(Id),
    Their(Id),
    /// The optimum of the scene that this one is compared with.
    TheirObjective,
    /// The derivative of a number that hangs on parameters by one of these.
    Derived(Id, String),
}

/// An expectation.
#[derive(Debug, Clone)]
pub(crate) struct Expectation {
    pub(crate) line: Line,
    pub(crate) claim: Claim,
    pub(crate) within: Within,
    /// The methods that it is about; empty for all that the block runs by default.
    pub(crate) by: Vec<Method>,
    /// Whether its value may be written anew.
    pub(crate) snapshot: bool,
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
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Which {
    pub(crate) kind: EventKind,
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
#[derive(Debug, Clone, Copy, PartialEq)]
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
    Fact(String),
    /// What a state holds by this name.
    Named(String),
    /// How many events there are.
    Count(Option<Which>),
    /// A derivative of a value or of the time of an event by a quantity, on a side where it has only such.
    Derivative(Box<Left>, String, Option<Side>),
    /// The time of an event, from the start or from another one on.
    EventTime(Option<Which>, Which),
}

/// A side of a quantity, and whether the factor of the root of its change is asked for in the place of a derivative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Side {
    pub(crate) above: bool,
    pub(crate) root: bool,
}

/// What is claimed.
#[derive(Debug, Clone)]
pub(crate) enum Claim {
    Event(Which, Option<Id>),
    NoEvent(Option<Which>),
    /// All events, in their order.
    Events(Vec<(Which, Option<Id>)>),
    /// Of several on the right one is enough.
    Value(Left, Instant, Comparison, Vec<Right>),
    /// The events are those of the motion that it is compared with.
    SameEvents,
    /// An expression that keeps the value that it has at the start.
    Constant(Id),
    Status(Vec<String>, Option<Id>),
    NotStatus(String),
    /// One of the texts that a run has: `note`, `diagnosis`, `warning`, `refusal`.
    Text(TextKind, String, bool),
    /// A mistake of the scene: its code, words, and a text of the scene that it is about.
    Message(Option<String>, Option<String>, Option<String>),
    Certificate(String),
    /// Why there are no derivatives by a quantity: words that are there or not.
    Obstacle(String, String, bool),
    /// How far a quantity may go to one side until the order of events is another, and why; or that it may go on.
    Limit(String, Above, Option<(Id, String)>),
}

/// A side of a quantity: towards larger values, if it is true.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Above(pub(crate) bool);

/// Where a text is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum TextKind {
    Note,
    Diagnosis,
    Warning,
    Refusal,
}

/// Numbers that a result has besides what moves.
const FACTS: [&str; 18] = [
    "residuals.primal",
    "residuals.dual",
    "residuals.complementarity",
    "starts",
    "bound",
    "objective",
    "final_time",
    "numerical_time",
    "error_estimate",
    "resimulation_error",
    "least_time",
    "resimulated_objective",
    "shortest_time",
    "longest_time",
    "objective_error",
    "excess",
    "margins",
    "size.variables",
];

/// Reads what stands behind `expect`; `.. with derivatives by a, b` expects those of both sides as well.
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
    let expected = expectation(line, text, expressions)?;
    let mut all = Vec::new();
    for name in names {
        let mut derivative = expected.clone();
        let (left, instant, right) = match &expected.claim {
            Claim::Event(which, Some(time)) => {
                (Left::EventTime(None, which.clone()), Instant::End, *time)
            }
            Claim::Value(left, instant, Comparison::Equal, right) => match right[..] {
                [Right::Own(right)] => (left.clone(), instant.clone(), right),
                _ => return Err("these have no derivatives".to_owned()),
            },
            _ => return Err("this has no derivatives".to_owned()),
        };
        let left = Left::Derivative(Box::new(left), name.to_owned(), None);
        let right = Right::Derived(right, name.to_owned());
        derivative.claim = Claim::Value(left, instant, Comparison::Equal, vec![right]);
        all.push(derivative);
    }
    all.insert(0, expected);
    Ok(all)
}

fn expectation(
    line: &Line,
    text: &str,
    expressions: &mut Expressions,
) -> Result<Expectation, String> {
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
    let (text, snapshot) = match behind(text, "snapshot") {
        Some(rest) => (rest, true),
        None => (text, false),
    };
    Ok(Expectation {
        line: line.clone(),
        claim: claim(text, &mut add)?,
        within,
        by,
        snapshot,
        moved: 0.0,
    })
}

fn claim(text: &str, add: &mut dyn FnMut(&str) -> Id) -> Result<Claim, String> {
    let absent = behind(text, "no");
    let rest = absent.unwrap_or(text);
    for (word, kind) in [
        ("note", TextKind::Note),
        ("diagnosis", TextKind::Diagnosis),
        ("warning", TextKind::Warning),
        ("refusal", TextKind::Refusal),
    ] {
        if let Some(words) = behind(rest, word) {
            let words = match absent.is_some() && words.is_empty() {
                true => "",
                false => quoted(words)?.0,
            };
            return Ok(Claim::Text(kind, words.to_owned(), absent.is_none()));
        }
    }
    if let Some(rest) = behind(rest, "obstacle") {
        let (by, words) = rest.split_at(rest.find('"').unwrap_or(rest.len()));
        let words = if words.is_empty() {
            ""
        } else {
            quoted(words)?.0
        };
        let (by, words) = (by.trim().to_owned(), words.to_owned());
        return Ok(Claim::Obstacle(by, words, absent.is_none()));
    }
    if let Some(rest) = behind(rest, "limit") {
        return limit(rest, absent.is_some(), add);
    }
    if let Some(rest) = absent {
        return Ok(match behind(rest, "status") {
            Some(name) => Claim::NotStatus(name.to_owned()),
            None if rest == "events" => Claim::NoEvent(None),
            None => Claim::NoEvent(Some(which(rest)?)),
        });
    }
    if let Some(rest) = behind(text, "status") {
        let (names, time) = timed(rest, add);
        let names = parts(names, " or ").into_iter().map(str::to_owned);
        return Ok(Claim::Status(names.collect(), time));
    }
    if let Some(rest) = behind(text, "message") {
        return message(rest);
    }
    if let Some(rest) = behind(text, "certificate") {
        return Ok(Claim::Certificate(rest.to_owned()));
    }
    if text == "same events" {
        return Ok(Claim::SameEvents);
    }
    if let Some(rest) = behind(text, "events") {
        let each = parts(rest, ",").into_iter().map(|event| {
            let (event, time) = timed(event, add);
            Ok((which(event)?, time))
        });
        return Ok(Claim::Events(each.collect::<Result<_, String>>()?));
    }
    if let Some(inner) = text.strip_suffix(" constant") {
        return Ok(Claim::Constant(add(inner)));
    }
    if compared(text).is_some() {
        return value(text, add);
    }
    let (event, time) = timed(text, add);
    Ok(Claim::Event(which(event)?, time))
}

/// What stands before ` at TIME`, and that time.
fn timed<'a>(text: &'a str, add: &mut dyn FnMut(&str) -> Id) -> (&'a str, Option<Id>) {
    match split(text, " at ") {
        Some((before, time)) => (before, Some(add(time))),
        None => (text, None),
    }
}

/// `KIND [NUMBER] [NAME]`; a name that is no word stands in quotes.
fn which(text: &str) -> Result<Which, String> {
    let (kind, rest) = text.split_once(' ').unwrap_or((text, ""));
    let kind = KINDS.into_iter().find(|known| known.name() == kind);
    let kind =
        kind.ok_or_else(|| format!("`{text}` is no event and nothing else that is known"))?;
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
        kind,
        number,
        name: (!name.is_empty()).then(|| name.to_owned()),
    })
}

/// `above NAME == CHANGE "WORDS"`, or `above NAME` where there is none.
fn limit(text: &str, none: bool, add: &mut dyn FnMut(&str) -> Id) -> Result<Claim, String> {
    let (side, rest) = text
        .split_once(' ')
        .ok_or("a limit is `above` or `below`")?;
    let side = Above(side == "above");
    if none {
        return Ok(Claim::Limit(rest.to_owned(), side, None));
    }
    let (name, rest) = split(rest, "==").ok_or("a limit is `above NAME == CHANGE \"WORDS\"`")?;
    let (change, words) = rest.split_at(rest.find('"').unwrap_or(rest.len()));
    let change = (add(change), quoted(words)?.0.to_owned());
    Ok(Claim::Limit(name.to_owned(), side, Some(change)))
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
    Ok(Claim::Message(code, words, place))
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
        let (by, root) = match by.strip_suffix(" as root") {
            Some(by) => (by, true),
            None => (by, false),
        };
        let side = |above| Some(Side { above, root });
        let (by, side) = match (
            by.strip_suffix(" from above"),
            by.strip_suffix(" from below"),
        ) {
            (Some(by), _) => (by, side(true)),
            (_, Some(by)) => (by, side(false)),
            _ => (by, None),
        };
        left = Left::Derivative(Box::new(left), by.trim().to_owned(), side);
    }
    let right = parts(right, " or ").into_iter();
    let right = right.map(|text| match behind(text, "their") {
        Some("objective") => Right::TheirObjective,
        Some(_) => Right::Their(add(text)),
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
        let of = (rest != "events").then(|| which(rest)).transpose()?;
        return Ok(Left::Count(of));
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
    let of_group = ["counts.", "time_freezing."];
    if FACTS.contains(&text) || of_group.iter().any(|group| text.starts_with(group)) {
        return Ok(Left::Fact(text.to_owned()));
    }
    Ok(Left::Expression(add(text), text.to_owned()))
}
