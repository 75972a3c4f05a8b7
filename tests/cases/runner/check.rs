//! Whether what was found is what is expected.

use crate::block::Block;
use crate::found::{Found, because};
use crate::prepared::output;
use crate::run::{Results, is_one};
use crate::statement::{Claim, Comparison, Expectation, Instant, Left, Right, Text, Within};
use crate::words::flat;
use hangtime::model::Model as _;
use hangtime::prelude::*;
use hangtime_scene_files::TextMistake;
use hangtime_units::Unit;

/// Whether an expectation holds, by each of its methods.
pub(crate) fn check(
    block: &Block,
    results: &Results,
    expectation: &Expectation,
) -> Vec<(String, Result<(), String>)> {
    match results {
        Results::Refused(mistakes, report) => {
            let unmet = refused(block, expectation, mistakes, report);
            vec![("the language".to_owned(), unmet)]
        }
        Results::Ran(prepared, outcomes, theirs) => {
            let methods = block.methods(expectation).into_iter();
            let each = methods.map(|method| {
                let found = Found {
                    prepared,
                    expectation,
                    outcome: &outcomes[&method],
                    theirs: theirs.as_deref(),
                };
                (method.to_string(), check_one(&found))
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
) -> Result<(), String> {
    let has = |text: &str, words: &Option<String>| {
        words
            .as_deref()
            .is_none_or(|words| flat(text).contains(&flat(words)))
    };
    match &expectation.claim {
        Claim::Text(text, words, present) if text.kind == "refusal" => {
            told(text, report, words, *present)
        }
        Claim::Message([code, words, place]) => {
            let fits = |mistake: &TextMistake| {
                code.as_deref()
                    .is_none_or(|code| mistake.code == Some(code))
                    && has(&mistake.message, words)
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

/// Whether a text has one of these words in it, or is one of these names.
fn told(text: &Text, found: &str, wanted: &[String], present: bool) -> Result<(), String> {
    let is_one = |words: &String| match text.kind {
        "status" | "certificate" => found == words,
        // `no note` is that there is none at all.
        _ if words.is_empty() => !found.trim().is_empty(),
        _ => flat(found).contains(&flat(words)),
    };
    match wanted.iter().any(is_one) == present {
        true => Ok(()),
        false => because(format!("found \"{found}\"")),
    }
}

fn check_one(found: &Found<'_>) -> Result<(), String> {
    let (unmet, is_listed) = match &found.expectation.claim {
        Claim::Value(left, instant, comparison, right) => {
            let is_listed = matches!(left, Left::Count(_) | Left::EventTime(..));
            (value(found, left, instant, *comparison, right), is_listed)
        }
        Claim::Text(text, words, present) => {
            let unmet = found
                .text(text)
                .and_then(|text_of| told(text, &text_of, words, *present));
            (unmet, text.kind == "status")
        }
        Claim::Events(events) => {
            let known = &found.motion()?.events;
            let mut pairs = known.iter().zip(events);
            let same =
                known.len() == events.len() && pairs.all(|(event, which)| is_one(event, which));
            let unmet = if same {
                Ok(())
            } else {
                because("events are others")
            };
            (unmet, true)
        }
        Claim::SameEvents => (same_events(found), true),
        Claim::Message(..) => (because("the scene has no mistakes"), false),
    };
    let listed = || {
        if is_listed {
            found.listed()
        } else {
            String::new()
        }
    };
    unmet.map_err(|why| why + &listed())
}

fn tolerance(found: &Found<'_>, wanted: f64) -> Result<f64, String> {
    Ok(match found.expectation.within {
        Within::Promised => 1e-6 * wanted.abs().max(1.0),
        Within::Absolute(id) => found.prepared.constant(id)?,
        Within::Estimated(id) => found.prepared.constant(id)? * found.fact("error_estimate")?,
        Within::Relative(id) => found.prepared.constant(id)? * wanted.abs(),
    })
}

/// Compares a number with what is expected, moved by so many tolerances.
fn near(of: &Found<'_>, found: f64, wanted: f64) -> Result<(), String> {
    let tolerance = tolerance(of, wanted)?;
    let moved = of.expectation.moved;
    let wanted = wanted + moved * if tolerance > 0.0 { tolerance } else { 1.0 };
    let off = (found - wanted).abs();
    if off <= tolerance {
        return Ok(());
    }
    because(format!(
        "== {wanted:?} within {tolerance:.1e}, found {found:?}, off by {off:.1e}"
    ))
}

fn value(
    found: &Found<'_>,
    left: &Left,
    instant: &Instant,
    comparison: Comparison,
    right: &[Right],
) -> Result<(), String> {
    let series = match (left, instant) {
        (Left::Expression(id, _), Instant::Always) => found
            .motion()?
            .series(&output(*id))
            .unwrap_or_default()
            .to_vec(),
        _ => vec![found.number(left, instant)?],
    };
    let first = *series.first().ok_or("there is no motion")?;
    let one = |right: &Right| {
        let wanted = match right {
            Right::Own(right) => {
                if let Some(unit) = unit(found, left) {
                    found.prepared.same_unit(*right, &unit)?;
                }
                found.prepared.constant(*right)?
            }
            Right::Their(left) => found.theirs()?.number(left, instant)?,
            Right::Derived(right, by) => found.prepared.derived(*right, by)?,
            Right::Start => first,
        };
        let mut series = series.iter();
        series.try_for_each(|&number| compare(found, number, comparison, wanted))
    };
    let each = right.iter().map(one);
    each.reduce(|before, next| before.or(next))
        .unwrap_or(Ok(()))
}

fn compare(of: &Found<'_>, found: f64, comparison: Comparison, wanted: f64) -> Result<(), String> {
    let (holds, mark) = match comparison {
        Comparison::Equal => return near(of, found, wanted),
        Comparison::AtMost => (found <= wanted, "<="),
        Comparison::AtLeast => (found >= wanted, ">="),
        Comparison::Less => (found < wanted, "<"),
        Comparison::More => (found > wanted, ">"),
    };
    match holds {
        true => Ok(()),
        false => because(format!("{mark} {wanted:?}, found {found:?}")),
    }
}

fn same_events(found: &Found<'_>) -> Result<(), String> {
    let (own, their) = (&found.motion()?.events, &found.theirs()?.motion()?.events);
    let kinds = |events: &[Event]| events.iter().map(|event| event.kind).collect::<Vec<_>>();
    if kinds(own) != kinds(their) {
        return because(format!("theirs are{}", found.theirs()?.listed()));
    }
    if found.expectation.moved != 0.0 && own.is_empty() {
        return because("there is nothing to move");
    }
    let mut pairs = own.iter().zip(their);
    pairs.try_for_each(|(own, their)| near(found, own.time, their.time))
}

/// The unit of what is compared, where it is known.
fn unit(found: &Found<'_>, left: &Left) -> Option<String> {
    if !found.prepared.has_units() {
        return None;
    }
    match left {
        Left::Expression(id, _) => Some(found.prepared.unit(*id).to_owned()),
        Left::EventTime(..) => Some("s".to_owned()),
        Left::Count(_) => Some("1".to_owned()),
        Left::Derivative(of, by, _) => {
            let mut known = found.prepared.scene.declaration().parameters.iter();
            let by = known.find(|known| known.name == by)?.unit;
            let by = if by.is_empty() { "1" } else { by };
            let parsed = |text: &str| text.parse::<Unit>().ok();
            Some((parsed(&unit(found, of)?)? / parsed(by)?).si().to_string())
        }
        Left::Fact(_) | Left::Named(_) | Left::Limit(_) => None,
    }
}
