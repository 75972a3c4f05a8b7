//! The rules of the search by name.
//!
//! None of them decides what is true of a result: they only say where is looked for better motions, and in which order. So each can be
//! left out ([`Settings::without`](super::Settings::without)), and a table can say what it earns: `cargo bench --bench zoo -- --ablate`.
//! The neighbours that a certificate needs are no such rules; without them nothing would be proved.

use crate::refusal;
use crate::simulation::InputError;

/// A rule of the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rule {
    /// Its name.
    pub name: &'static str,
    /// What part of the search it belongs to.
    pub part: RulePart,
    /// What it does, in one sentence.
    pub does: &'static str,
}

/// Parts of the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RulePart {
    /// Words that the search begins with.
    Source,
    /// Words that are made of solved ones.
    Edit,
    /// Switches that are put into control intervals.
    Mapping,
    /// Contact sequences on the grid that no multiplier points to.
    Basin,
}

use RulePart::{Basin, Edit, Mapping, Source};

const fn rule(part: RulePart, name: &'static str, does: &'static str) -> Rule {
    Rule { name, part, does }
}

/// All rules, in the order in which the search comes to them.
pub const RULES: [Rule; 24] = [
    rule(
        Source,
        "time-freezing",
        "The plan of a time-freezing program that is left early, where it is proved.",
    ),
    rule(
        Source,
        "sample",
        "The best motions under random controls and policies, one for each order of events.",
    ),
    rule(
        Source,
        "beginning",
        "What these begin with, up to three phases.",
    ),
    rule(Source, "ride", "The motion without controls."),
    rule(Source, "empty", "No switch at all."),
    rule(Source, "steps", "Steps of feet that stand at the start."),
    rule(
        Source,
        "visits",
        "Contacts that are open at first close, or are visited by what stands.",
    ),
    rule(
        Source,
        "relaxed",
        "The motions of time-freezing programs from the ride and the best random motion.",
    ),
    rule(
        Source,
        "redraw",
        "Other random motions, where no word meets its goals.",
    ),
    rule(Edit, "collapse", "Without all phases that have no length."),
    rule(Edit, "vanish", "Without a phase that has no length."),
    rule(
        Edit,
        "press",
        "A cycle in which a contact does what the solution presses towards.",
    ),
    rule(
        Edit,
        "flip",
        "One contact otherwise in a phase, or in half of it.",
    ),
    rule(
        Edit,
        "touch",
        "A touch where the gap of an open contact presses.",
    ),
    rule(Edit, "cut", "Without the last instant."),
    rule(
        Edit,
        "refine",
        "The best words once more with pieces of free length.",
    ),
    rule(
        Mapping,
        "at-jumps",
        "Switches at the nearest end of an interval, where controls jump.",
    ),
    rule(
        Mapping,
        "shift",
        "Switches an interval earlier and later, alone and with all behind them, while the grid costs more than it has to.",
    ),
    rule(
        Mapping,
        "near",
        "All switches in the intervals around, and at their ends, where shifts do not help.",
    ),
    rule(
        Mapping,
        "through",
        "Switches that press on an end of their interval moved through it.",
    ),
    rule(Basin, "shortened", "Without the last switch."),
    rule(
        Basin,
        "sliding-moved",
        "Changes of friction an interval earlier and later.",
    ),
    rule(
        Basin,
        "at-nodes",
        "Each switch at the ends of its interval, and in the next ones.",
    ),
    rule(
        Basin,
        "all-at-once",
        "All switches an interval earlier and later.",
    ),
];

/// Checks that all of these are names of rules.
pub(in crate::ocp) fn check(names: &[String]) -> Result<(), InputError> {
    let known: Vec<&str> = RULES.iter().map(|rule| rule.name).collect();
    match names.iter().find(|name| !known.contains(&name.as_str())) {
        Some(unknown) => Err(refusal::no_such("rule of the search", unknown, &known)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rule_has_a_name_of_its_own() {
        let mut names: Vec<&str> = RULES.iter().map(|rule| rule.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), RULES.len());
    }
}
