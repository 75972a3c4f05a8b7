//! Whether what was found is what is expected.

use crate::block::Block;
use crate::found::{Found, Of, Unmet, because, listed};
use crate::method::Method;
use crate::prepared::output;
use crate::run::{Results, event, named};
use crate::statement::{
    Above, Claim, Comparison, Expectation, Id, Instant, Left, Right, TextKind, Which, Within,
};
use crate::words::flat;
use hangtime::model::Model as _;
use hangtime::prelude::*;
use hangtime_scene_files::TextMistake;
use hangtime_units::Unit;

/// An expectation that does not hold.
#[derive(Debug)]
pub(crate) struct Failure {
    /// The method; none where no motion is simulated.
    pub(crate) by: Option<Method>,
    /// What was expected and what came.
    pub(crate) why: String,
    /// The number that came, where one was expected.
    pub(crate) found: Option<f64>,
}

/// How often an expectation of these results is looked at: once a method.
pub(crate) fn looks(block: &Block, results: &Results, expectation: &Expectation) -> usize {
    match results {
        Results::Simulated(..) => named(block, expectation).len(),
        _ => 1,
    }
}

/// Where an expectation does not hold.
pub(crate) fn check(block: &Block, results: &Results, expectation: &Expectation) -> Vec<Failure> {
    let once = |unmet: Result<(), Unmet>| {
        let unmet = unmet.err().into_iter();
        unmet
            .map(|(why, found)| Failure {
                by: None,
                why,
                found,
            })
            .collect()
    };
    match results {
        Results::Refused(mistakes, report) => once(refused(block, expectation, mistakes, report)),
        Results::Solved(prepared, solution, theirs) => once(match solution {
            Err(error) => not_run(expectation, error),
            Ok(solution) => check_one(&Found {
                prepared,
                expectation,
                result: Of::Solution(solution),
                theirs: None,
                their_optimum: theirs.as_deref(),
            }),
        }),
        Results::Simulated(prepared, runs, theirs) => {
            let methods = named(block, expectation).into_iter();
            let each = methods.filter_map(|method| {
                let runs = runs.get(&method)?;
                let unmet = match &runs.whole {
                    Err(error) => not_run(expectation, error),
                    Ok(_) => check_one(&Found {
                        prepared,
                        expectation,
                        result: Of::Run(&method, runs),
                        theirs: theirs.as_deref(),
                        their_optimum: None,
                    }),
                };
                let (why, found) = unmet.err()?;
                let by = Some(method);
                Some(Failure { by, why, found })
            });
            each.collect()
        }
    }
}

/// What is expected of a scene with mistakes.
fn refused(
    block: &Block,
    expectation: &Expectation,
    mistakes: &[TextMistake],
    report: &str,
) -> Result<(), Unmet> {
    match &expectation.claim {
        Claim::Text(TextKind::Refusal, words, present) => contains(report, words, *present),
        Claim::Message(code, words, place) => {
            let fits = |mistake: &TextMistake| {
                let message = flat(&mistake.message);
                code.as_deref()
                    .is_none_or(|code| mistake.code == Some(code))
                    && words
                        .as_deref()
                        .is_none_or(|words| message.contains(&flat(words)))
                    && place
                        .as_deref()
                        .is_none_or(|place| covers(&block.scene, mistake, place))
            };
            match mistakes.iter().any(fits) {
                true => Ok(()),
                false => because(format!("the mistakes are\n{report}")),
            }
        }
        _ => because(format!("the scene is refused\n{report}")),
    }
}

/// Whether a mistake stands at a text of the scene.
fn covers(scene: &str, mistake: &TextMistake, place: &str) -> bool {
    let mut found = scene.match_indices(place);
    found.any(|(at, text)| mistake.place.start < at + text.len() && at < mistake.place.end.max(1))
}

/// What is expected where the first step was refused.
fn not_run(expectation: &Expectation, error: &str) -> Result<(), Unmet> {
    match &expectation.claim {
        Claim::Text(TextKind::Refusal, words, present) => contains(error, words, *present),
        _ => because(format!("refused: {error}")),
    }
}

fn contains(text: &str, words: &str, present: bool) -> Result<(), Unmet> {
    let holds = match words.is_empty() {
        // `no note` is that there is none at all.
        true => !text.trim().is_empty(),
        false => flat(text).contains(&flat(words)),
    };
    match holds == present {
        true => Ok(()),
        false => because(format!("found \"{text}\"")),
    }
}

fn check_one(result: &Found<'_>) -> Result<(), Unmet> {
    match &result.expectation.claim {
        Claim::Event(which, time) => one_event(result, which, *time),
        Claim::NoEvent(which) => no_event(result, which.as_ref()),
        Claim::Events(events) => all_events(result, events),
        Claim::Value(left, instant, comparison, right) => {
            value(result, left, instant, *comparison, right)
        }
        Claim::SameEvents => same_events(result),
        Claim::Constant(id) => constant(result, *id),
        Claim::Status(names, time) => status(result, names, *time),
        Claim::NotStatus(name) => match result.status_name() == name {
            true => because(format!("the status is {}", result.status_shown())),
            false => Ok(()),
        },
        Claim::Text(kind, words, present) => contains(&result.text(*kind)?, words, *present),
        Claim::Message(..) => because("the scene has no mistakes"),
        Claim::Obstacle(by, words, present) => contains(result.reach(by)?.0, words, *present),
        Claim::Limit(by, side, wanted) => limit(result, by, *side, wanted.as_ref()),
        Claim::Certificate(name) => match result.result {
            Of::Solution(solution) if solution.stationarity.name() == name => Ok(()),
            Of::Solution(solution) => because(format!("found {}", solution.stationarity)),
            Of::Run(..) => because("only optima have a certificate"),
        },
    }
}

/// How far a quantity may go to one side.
fn limit(
    result: &Found<'_>,
    by: &str,
    side: Above,
    wanted: Option<&(Id, String)>,
) -> Result<(), Unmet> {
    let Some(range) = result.reach(by)?.1 else {
        return because("there are no ranges");
    };
    let limit = if side.0 { &range.above } else { &range.below };
    match (limit, wanted) {
        (Some(limit), Some((change, words))) => {
            contains(&limit.because, words, true)?;
            near(
                result,
                limit.change,
                result.constant_of(*change)?,
                "ends at",
            )
        }
        (Some(limit), None) => because(format!("{}: {}", limit.change, limit.because)),
        (None, Some((_, words))) => because(format!("nothing ends it, and not: {words}")),
        (None, None) => Ok(()),
    }
}

fn tolerance(result: &Found<'_>, wanted: f64) -> Result<f64, Unmet> {
    Ok(match result.expectation.within {
        Within::Promised => 1e-6 * wanted.abs().max(1.0),
        Within::Absolute(id) => result.constant_of(id)?,
        Within::Estimated(id) => result.constant_of(id)? * result.fact("error_estimate")?,
        Within::Relative(id) => result.constant_of(id)? * wanted.abs(),
    })
}

/// Compares a number with what is expected, moved by so many tolerances.
fn near(result: &Found<'_>, found: f64, wanted: f64, what: &str) -> Result<(), Unmet> {
    let tolerance = tolerance(result, wanted)?;
    let moved = result.expectation.moved;
    let wanted = wanted + moved * if tolerance > 0.0 { tolerance } else { 1.0 };
    let off = (found - wanted).abs();
    if off <= tolerance {
        return Ok(());
    }
    let why =
        format!("{what} {wanted:?} within {tolerance:.1e}, found {found:?}, off by {off:.1e}");
    Err((why, Some(found)))
}

fn at_time(result: &Found<'_>, event: &Event, time: Option<Id>) -> Result<(), Unmet> {
    let Some(id) = time else {
        return Ok(());
    };
    if result.prepared.has_units() {
        result
            .prepared
            .same_unit(id, "s")
            .map_err(|why| (why, None))?;
    }
    near(result, event.time, result.constant_of(id)?, "at")
}

fn one_event(result: &Found<'_>, which: &Which, time: Option<Id>) -> Result<(), Unmet> {
    let motion = result.motion()?;
    match event(motion, which) {
        Some(index) => at_time(result, &motion.events[index], time),
        None => because(format!("no such event among\n{}", listed(motion))),
    }
}

fn no_event(result: &Found<'_>, which: Option<&Which>) -> Result<(), Unmet> {
    let motion = result.motion()?;
    let none = match which {
        Some(which) => event(motion, which).is_none(),
        None => motion.events.is_empty(),
    };
    match none {
        true => Ok(()),
        false => because(format!("found\n{}", listed(motion))),
    }
}

fn all_events(result: &Found<'_>, wanted: &[(Which, Option<Id>)]) -> Result<(), Unmet> {
    let motion = result.motion()?;
    let fits = |(event, (which, _)): (&Event, &(Which, Option<Id>))| {
        let name = which.name.as_deref();
        event.kind == which.kind && name.is_none_or(|name| name == event.contact_name)
    };
    if motion.events.len() != wanted.len() || !motion.events.iter().zip(wanted).all(fits) {
        return because(format!("found\n{}", listed(motion)));
    }
    let mut each = motion.events.iter().zip(wanted);
    each.try_for_each(|(event, (_, time))| at_time(result, event, *time))
}

fn value(
    result: &Found<'_>,
    left: &Left,
    instant: &Instant,
    comparison: Comparison,
    right: &[Right],
) -> Result<(), Unmet> {
    let mut unmet = Ok(());
    for right in right {
        unmet = one_value(result, left, instant, comparison, right);
        if unmet.is_ok() {
            break;
        }
    }
    unmet
}

fn one_value(
    result: &Found<'_>,
    left: &Left,
    instant: &Instant,
    comparison: Comparison,
    right: &Right,
) -> Result<(), Unmet> {
    let wanted = match right {
        Right::Own(right) => {
            units(result, left, *right).map_err(|why| (why, None))?;
            result.constant_of(*right)?
        }
        Right::Their(right) => result.their(*right, instant)?,
        Right::TheirObjective => match result.their_optimum {
            Some(solution) => solution.objective,
            None => return because("there is no optimum to compare with"),
        },
        Right::Derived(right, by) => {
            let derived = result.prepared.derived(*right, by);
            derived.map_err(|why| (why, None))?
        }
    };
    let (Left::Expression(id, _), Instant::Always) = (left, instant) else {
        let found = result.number(left, instant)?;
        return compare(result, found, comparison, wanted);
    };
    let series = result.motion()?.series(&output(*id)).unwrap_or_default();
    if series.is_empty() {
        return because("there is no motion");
    }
    let mut series = series.iter();
    series.try_for_each(|&found| compare(result, found, comparison, wanted))
}

fn same_events(result: &Found<'_>) -> Result<(), Unmet> {
    let motion = result.motion()?;
    let theirs = result.their_motion()?;
    let kinds = |run: &Simulation| -> Vec<EventKind> {
        run.events.iter().map(|event| event.kind).collect()
    };
    if kinds(motion) != kinds(theirs) {
        return because(format!(
            "found\n{}\ntheirs\n{}",
            listed(motion),
            listed(theirs)
        ));
    }
    let mut pairs = motion.events.iter().zip(&theirs.events);
    if result.expectation.moved != 0.0 && motion.events.is_empty() {
        return because("there is nothing to move");
    }
    pairs.try_for_each(|(own, their)| near(result, own.time, their.time, "at"))
}

fn compare(
    result: &Found<'_>,
    found: f64,
    comparison: Comparison,
    wanted: f64,
) -> Result<(), Unmet> {
    let (holds, mark) = match comparison {
        Comparison::Equal => return near(result, found, wanted, "=="),
        Comparison::AtMost => (found <= wanted, "<="),
        Comparison::AtLeast => (found >= wanted, ">="),
        Comparison::Less => (found < wanted, "<"),
        Comparison::More => (found > wanted, ">"),
    };
    match holds {
        true => Ok(()),
        false => Err((format!("{mark} {wanted:?}, found {found:?}"), Some(found))),
    }
}

/// Whether an expression keeps its value of the start.
fn constant(result: &Found<'_>, id: Id) -> Result<(), Unmet> {
    let series = result.motion()?.series(&output(id)).unwrap_or_default();
    let Some((&first, rest)) = series.split_first() else {
        return because("there is no motion");
    };
    rest.iter()
        .try_for_each(|&found| near(result, found, first, "constant"))
}

/// Refuses a comparison of quantities of other kinds.
fn units(result: &Found<'_>, left: &Left, right: Id) -> Result<(), String> {
    if !result.prepared.has_units() {
        return Ok(());
    }
    let unit = |left: &Left| match left {
        Left::Expression(id, _) => Some(result.prepared.unit(*id).to_owned()),
        Left::EventTime(..) => Some("s".to_owned()),
        Left::Count(_) => Some("1".to_owned()),
        Left::Fact(_) | Left::Named(_) | Left::Derivative(..) => None,
    };
    let unit = match left {
        Left::Derivative(of, by, _) => {
            let declaration = result.prepared.scene.declaration();
            let mut known = declaration.parameters.iter();
            let known = known.find(|known| known.name == by);
            let units = unit(of).zip(known.map(|known| known.unit));
            units.and_then(|(of, by)| {
                let parsed = |text: &str| text.parse::<Unit>().ok();
                let by = if by.is_empty() { "1" } else { by };
                Some((parsed(&of)? / parsed(by)?).si().to_string())
            })
        }
        left => unit(left),
    };
    unit.map_or(Ok(()), |unit| result.prepared.same_unit(right, &unit))
}

fn status(result: &Found<'_>, names: &[String], time: Option<Id>) -> Result<(), Unmet> {
    if !names.iter().any(|name| name == result.status_name()) {
        return because(format!("the status is {}", result.status_shown()));
    }
    let Some(id) = time else {
        return Ok(());
    };
    let diagnosis = result.motion()?.status.diagnosis();
    match diagnosis {
        Some(diagnosis) => near(result, diagnosis.time, result.constant_of(id)?, "at"),
        None => because("the whole motion was solved"),
    }
}
