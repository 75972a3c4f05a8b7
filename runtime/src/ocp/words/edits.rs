//! Named rules that make other words of a solved one.
//!
//! A rule returns drafts in its own order of promise; the search takes the first ones of each rule first. What separates the rules is
//! their price, a share of the objective by which the parent of a draft may be worse than that of another one and still come first.

use super::library::Library;
use super::off_grid::{Press, Pressed, Timed};
use super::word::{Draft, Instant, Word, between, closed_modes, touch};
use crate::model::Model;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::global::start_modes::may_be_closed_at_start;
use crate::ocp::motion::mode::is_condition;
use crate::ocp::tuning::edits::{INSERTED, LEFT_OUT, OFTEN, ROOM, TOUCHED, VANISHED, price};
use crate::ocp::tuning::off_grid::TOLERANCE;
use crate::simulation::ContactMode;

/// A rule: its name, its price, and the drafts that it makes.
pub(super) struct Rule {
    pub(super) name: &'static str,
    pub(super) price: f64,
    pub(super) drafts: fn(&Parent) -> Vec<Draft>,
}

/// What rules look at.
pub(super) struct Parent<'p> {
    pub(super) setting: Setting<'p>,
    pub(super) timed: &'p Timed,
    pub(super) library: &'p Library,
}

/// All rules, the cheapest first.
pub(super) const RULES: [Rule; 6] = [
    Rule {
        name: "collapse",
        price: price::COLLAPSE,
        drafts: collapse,
    },
    Rule {
        name: "vanish",
        price: price::VANISH,
        drafts: vanish,
    },
    Rule {
        name: "press",
        price: price::PRESS,
        drafts: press,
    },
    Rule {
        name: "flip",
        price: price::FLIP,
        drafts: flip,
    },
    Rule {
        name: "touch",
        price: price::TOUCH,
        drafts: touches,
    },
    Rule {
        name: "cut",
        price: price::CUT,
        drafts: cut,
    },
];

impl Parent<'_> {
    fn model(&self) -> &dyn Model {
        self.setting.model
    }

    /// The phases of no length.
    fn vanished(&self) -> impl Iterator<Item = usize> {
        let least = VANISHED * self.draft().horizon;
        let phases = self.draft().phases().into_iter().enumerate();
        phases
            .filter(move |(_, (from, to))| to - from < least)
            .map(|(phase, _)| phase)
    }

    pub(super) fn has_vanished(&self) -> bool {
        self.vanished().next().is_some()
    }

    fn draft(&self) -> &Draft {
        &self.timed.draft
    }

    fn word(&self) -> &Word {
        &self.timed.draft.word
    }

    /// The draft with other instants in the place of those from `first` up to `last`, at times spread evenly from `begin` to `end`.
    fn spliced(
        &self,
        (first, last): (usize, usize),
        instants: &[Instant],
        (begin, end): (f64, f64),
    ) -> Draft {
        let count = instants.len();
        let time = |k: usize| match count {
            1 => 0.5 * (begin + end),
            _ => begin + (end - begin) * k as f64 / (count - 1) as f64,
        };
        self.timed_splice((first, last), instants, (0..count).map(time).collect())
    }

    fn timed_splice(
        &self,
        (first, last): (usize, usize),
        instants: &[Instant],
        times: Vec<f64>,
    ) -> Draft {
        let mut draft = self.draft().clone();
        draft
            .word
            .instants
            .splice(first..last, instants.iter().cloned());
        draft.times.splice(first..last, times);
        let mut before = 0.0;
        for time in &mut draft.times {
            *time = time.max(before);
            before = *time;
        }
        draft
    }

    /// With a cycle in a phase, around a time.
    fn inserted(&self, phase: usize, cycle: &[Instant], time: f64, length: f64) -> Draft {
        let (from, to) = self.draft().phases()[phase];
        let room = ROOM * (to - from);
        let begin = (time - 0.5 * length).max(from + room);
        let end = (begin + length).min(to - room);
        self.spliced((phase, phase), cycle, (begin.min(end), end))
    }

    /// Without the phase alone, as far as that is a word: what follows it has lengths of its own; or else without what follows it up to a
    /// phase with the modes of the one before.
    fn without(&self, phase: usize) -> Option<Draft> {
        match phase {
            0 => self.without_first(),
            _ => self.straight(phase).or_else(|| self.without_cycle(phase)),
        }
    }

    fn without_first(&self) -> Option<Draft> {
        let first = self.word().instants.first()?;
        if first.iter().any(|switch| switch.closes || switch.passes) {
            return None;
        }
        let mut draft = self.timed_splice((0, 1), &[], Vec::new());
        draft.word.initially.clone_from(&self.word().modes()[1]);
        Some(draft)
    }

    /// Without the phase and those behind it, up to one with the modes of the phase before.
    fn without_cycle(&self, phase: usize) -> Option<Draft> {
        let (word, modes) = (self.word(), self.word().modes());
        let last = (phase + LEFT_OUT).min(modes.len());
        let same = (phase..last).find(|&other| modes[other] == modes[phase - 1])?;
        let ends = word.ends_with_impact && same == word.instants.len();
        (!ends).then(|| self.timed_splice((phase - 1, same), &[], Vec::new()))
    }

    /// Straight from the phase before to the next one.
    fn straight(&self, phase: usize) -> Option<Draft> {
        let (word, modes) = (self.word(), self.word().modes());
        let (before, next) = (phase.checked_sub(1)?, modes.get(phase + 1)?);
        if phase >= word.instants.len() {
            return None;
        }
        let instants = word.instants[before..=phase].iter().flatten();
        let passes = instants.into_iter().any(|switch| switch.passes);
        let straight = between(&modes[before], next);
        let time = self.draft().times[phase];
        (!passes && !straight.is_empty())
            .then(|| self.timed_splice((before, phase + 1), &[straight], vec![time]))
    }
}

/// A touch, which leaves no trace in the modes, and conditions at the other end of the phase at one instant.
fn with_touch(parent: &Parent, phase: usize) -> Option<Draft> {
    let before = phase.checked_sub(1)?;
    let instants = parent.word().instants.get(before..=phase)?;
    let mut all: Instant = instants.iter().flatten().copied().collect();
    all.sort_by_key(|switch| !switch.closes);
    for (index, switch) in all.iter_mut().enumerate() {
        switch.accompanies = index > 0;
    }
    let touches = all.iter().filter(|switch| switch.touches()).count();
    let conditions = all.iter();
    let conditions = conditions.filter(|switch| is_condition(parent.model(), switch.contact));
    let both = touches == 1 && conditions.count() + 1 == all.len();
    let time = parent.draft().times[before];
    both.then(|| parent.timed_splice((before, phase + 1), &[all], vec![time]))
}

/// Without any phase of no length: while one is there, a program without another of them is as degenerate as before.
fn collapse(parent: &Parent) -> Vec<Draft> {
    if parent.vanished().nth(1).is_none() {
        return Vec::new();
    }
    let mut timed = parent.timed.clone();
    for _ in 0..parent.word().phases() {
        let left = Parent {
            timed: &timed,
            ..*parent
        };
        let shorter = |phase| as_touch(&left, phase).or_else(|| left.without(phase));
        let Some(draft) = left.vanished().find_map(shorter) else {
            break;
        };
        timed.draft = draft;
    }
    vec![timed.draft]
}

/// Without a phase of no length.
fn vanish(parent: &Parent) -> Vec<Draft> {
    let mut found = Vec::new();
    for phase in parent.vanished() {
        found.extend(as_touch(parent, phase));
        found.extend(with_touch(parent, phase));
        found.extend(parent.without(phase));
    }
    found
}

/// A contact that does not last as a touch.
fn as_touch(parent: &Parent, phase: usize) -> Option<Draft> {
    let modes = parent.word().modes();
    let before = phase.checked_sub(1)?;
    let after = modes
        .get(phase + 1)
        .filter(|after| **after == modes[before])?;
    let mut changed = (0..after.len()).filter(|&i| modes[phase][i] != after[i]);
    let contact = changed.next()?;
    if changed.next().is_some()
        || !after[contact].is_open()
        || phase >= parent.word().instants.len()
    {
        return None;
    }
    let time = parent.draft().times[before];
    let touch = touch(contact, modes[phase][contact]);
    Some(parent.timed_splice((before, phase + 1), &[touch], vec![time]))
}

/// Where the solution presses, a cycle in which that contact does something else: seen ones, and the plainest.
fn press(parent: &Parent) -> Vec<Draft> {
    let modes = parent.word().modes();
    let length = INSERTED * parent.draft().horizon;
    let mut found: Vec<(f64, Draft)> = Vec::new();
    for press in parent
        .timed
        .presses
        .iter()
        .filter(|press| press.share > TOLERANCE)
    {
        let now = &modes[press.phase];
        let (from, to) = parent.draft().phases()[press.phase];
        let length = length.min(0.5 * (to - from));
        let seen = parent.library.cycles(now).filter(|cycle| {
            let mut switches = cycle.instants.iter().flatten();
            switches.any(|switch| switch.contact == press.contact)
        });
        for cycle in seen {
            let often = cycle.seen as f64 / (1 + cycle.instants.len()) as f64;
            let draft = parent.inserted(press.phase, &cycle.instants, press.time, length);
            found.push((press.share + OFTEN * often, draft));
        }
        for cycle in plain_cycles(parent.model(), now, press) {
            let draft = parent.inserted(press.phase, &cycle, press.time, length);
            found.push((press.share, draft));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().map(|(_, draft)| draft).collect()
}

/// The plainest cycles in which a contact does what the solution presses towards.
fn plain_cycles(model: &dyn Model, now: &[ContactMode], press: &Press) -> Vec<Vec<Instant>> {
    let others = others(model, now, press.contact);
    let wanted = others.into_iter().filter(|mode| match press.against {
        Pressed::Gap => !mode.is_open(),
        Pressed::Force => mode.is_open(),
        Pressed::Friction => !mode.is_open(),
    });
    let cycle = |mode: ContactMode| {
        let mut there = now.to_vec();
        there[press.contact] = mode;
        vec![between(now, &there), between(&there, now)]
    };
    let bounces = press.against == Pressed::Gap && model.restitution(press.contact) > 0.0;
    let modes = closed_modes(model, press.contact).into_iter();
    let touched = modes.filter(|_| press.against == Pressed::Gap);
    let touched = touched.map(|mode| vec![touch(press.contact, mode)]);
    wanted
        .filter(|_| !bounces)
        .map(cycle)
        .chain(touched)
        .collect()
}

/// What else a contact may do where it does this now.
fn others(model: &dyn Model, now: &[ContactMode], contact: usize) -> Vec<ContactMode> {
    let dry = model.declaration().contacts[contact].dry;
    let closed = closed_modes(model, contact).into_iter();
    let open = (!dry).then_some(ContactMode::Open);
    let all = open.into_iter().chain(closed);
    all.filter(|mode| *mode != now[contact]).collect()
}

/// One contact otherwise for a phase, or for half of it.
fn flip(parent: &Parent) -> Vec<Draft> {
    let (word, modes) = (parent.word(), parent.word().modes());
    let phases = parent.draft().phases();
    let mut found = Vec::new();
    for (phase, &(from, to)) in phases.iter().enumerate() {
        let now = &modes[phase];
        for contact in 0..now.len() {
            if word.pieces.is_idle(contact) || parent.model().restitution(contact) > 0.0 {
                continue;
            }
            for mode in others(parent.model(), now, contact) {
                let shut = phase == 0 && now[contact].is_open() && !mode.is_open();
                if shut && !may_be_closed_at_start(parent.setting, contact) {
                    continue;
                }
                let mut there = now.clone();
                there[contact] = mode;
                found.extend(flipped(parent, phase, &there));
                let middle = 0.5 * (from + to);
                let half = [between(now, &there)];
                let last = phase == word.instants.len();
                if let Some(next) = modes.get(phase + 1).filter(|_| !last) {
                    let back = [between(now, &there), between(&there, next)];
                    if *next != there && !has_passages(word, phase) {
                        let times = vec![middle, to];
                        found.push(parent.timed_splice((phase, phase + 1), &back, times));
                    }
                } else if last {
                    found.push(parent.timed_splice((phase, phase), &half, vec![middle]));
                }
            }
        }
    }
    found
}

fn has_passages(word: &Word, instant: usize) -> bool {
    word.instants[instant].iter().any(|switch| switch.passes)
}

/// With other modes in a whole phase.
fn flipped(parent: &Parent, phase: usize, there: &[ContactMode]) -> Option<Draft> {
    let (word, modes) = (parent.word(), parent.word().modes());
    let before = phase.checked_sub(1);
    let mut draft = parent.draft().clone();
    if let Some(before) = before {
        if has_passages(word, before) {
            return None;
        }
        draft.word.instants[before] = between(&modes[before], there);
    } else {
        draft.word.initially = there.to_vec();
    }
    if phase < word.instants.len() {
        if has_passages(word, phase) {
            return None;
        }
        draft.word.instants[phase] = between(there, &modes[phase + 1]);
    }
    for instant in [before, Some(phase)].into_iter().flatten().rev() {
        if draft.word.instants.get(instant).is_some_and(Vec::is_empty) {
            draft.word.instants.remove(instant);
            draft.times.remove(instant);
        }
    }
    Some(draft)
}

/// A touch where an open contact presses.
fn touches(parent: &Parent) -> Vec<Draft> {
    let mut found = Vec::new();
    let presses = |phase: usize, contact: usize| {
        let mut presses = parent.timed.presses.iter();
        presses.any(|press| {
            (press.phase, press.contact, press.against) == (phase, contact, Pressed::Gap)
                && press.share > TOLERANCE
        })
    };
    for (phase, (from, to)) in parent.draft().phases().into_iter().enumerate() {
        for contact in 0..parent.word().initially.len() {
            if !presses(phase, contact) || parent.word().pieces.is_idle(contact) {
                continue;
            }
            for impulse in closed_modes(parent.model(), contact) {
                for share in TOUCHED {
                    let time = from + share * (to - from);
                    let touch = [touch(contact, impulse)];
                    found.push(parent.timed_splice((phase, phase), &touch, vec![time]));
                }
            }
        }
    }
    found
}

/// Without the last instant.
fn cut(parent: &Parent) -> Vec<Draft> {
    let count = parent.word().instants.len();
    if count == 0 {
        return Vec::new();
    }
    let mut draft = parent.timed_splice((count - 1, count), &[], Vec::new());
    draft.word.ends_with_impact = false;
    let mut found = vec![draft];
    let closes = parent.word().instants[count - 1]
        .iter()
        .any(|switch| switch.closes);
    if closes && !parent.word().ends_with_impact {
        let mut ending = parent.draft().clone();
        ending.horizon = ending.times[count - 1];
        ending.word.ends_with_impact = true;
        found.push(ending);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ocp::rules::{self, RulePart};

    #[test]
    fn rules_have_names_of_their_own_and_stand_in_the_order_of_their_prices() {
        let prices: Vec<f64> = RULES.iter().map(|rule| rule.price).collect();
        assert!(prices.is_sorted());
        let mut names: Vec<&str> = RULES.iter().map(|rule| rule.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), RULES.len());
        // Each can be left out by its name.
        let edits = rules::RULES.iter();
        let edits = edits.filter(|rule| rule.part == RulePart::Edit);
        let edits: Vec<&str> = edits.map(|rule| rule.name).collect();
        assert!(names.iter().all(|name| edits.contains(name)), "{edits:?}");
    }
}
