//! Best first: from the words to begin with to better ones by edits, until nothing more is gained.

use super::beginnings::Beginning;
use super::edits::{Parent, RULES, Rule};
use super::library::Library;
use super::off_grid::{Fineness, Goals, Timed, solve};
use super::word::{Draft, Word};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::Runner;
use crate::ocp::settings::Settings;
use crate::ocp::tuning::beginnings::MOST_PHASES;
use crate::ocp::tuning::equal::{MET, MOTION};
use crate::ocp::tuning::off_grid::{DEARER, EVEN_PIECES, FREE_PIECES, LEAST_PIECES, TOLERANCE};
use crate::ocp::tuning::table::{
    GUESSES, KEPT, MOST_EXCESS, NEXT_OF_RULE, OF_EACH_WORD, OF_PARENT, OF_PHASE, PATIENCE, POORER,
    PROGRAMS, REFINEMENTS, SAME_TIMES, SHORTER, WORTH,
};
use crate::progress::BestMotion;
use crate::rk::ButcherTableau;

/// Control pieces of a word for least time, with lengths of their own, and of others.
const FREE: Fineness = Fineness {
    pieces: FREE_PIECES,
    least: LEAST_PIECES,
    free: true,
};
const EVEN: Fineness = Fineness {
    pieces: EVEN_PIECES,
    least: LEAST_PIECES,
    free: false,
};

/// Control pieces of the best words at last.
const REFINED: Fineness = Fineness {
    pieces: EVEN_PIECES,
    least: LEAST_PIECES,
    free: true,
};

/// A word that was looked at.
struct Seen {
    word: Word,
    /// Times of the switches that were guessed, as shares.
    guesses: Vec<Vec<f64>>,
    /// How often it was the best.
    won: usize,
    merit: f64,
}

/// A draft that waits.
struct Waiting {
    priority: f64,
    order: usize,
    rule: &'static str,
    draft: Draft,
    parent: usize,
}

/// A search over words.
pub(in crate::ocp) struct Words<'a, 'r> {
    setting: Setting<'a>,
    tableau: &'r ButcherTableau,
    library: Library,
    goals: Goals,
    /// The rules that make words of others.
    rules: Vec<&'static Rule>,
    fineness: Fineness,
    seen: Vec<Seen>,
    solved: Vec<Timed>,
    /// Index of the best.
    best: Option<usize>,
    waiting: Vec<Waiting>,
    programs: usize,
    last_gain: usize,
    order: usize,
}

impl<'a, 'r> Words<'a, 'r> {
    pub(in crate::ocp) fn new(
        setting: Setting<'a>,
        (tableau, settings): (&'r ButcherTableau, &Settings),
        (library, goals): (Library, Goals),
    ) -> Self {
        let declared = setting.model.declaration().optimal_control;
        let efforts = declared.is_none_or(|declared| declared.running_cost);
        Self {
            setting,
            tableau,
            library,
            goals,
            rules: RULES
                .iter()
                .filter(|rule| settings.uses(rule.name))
                .collect(),
            fineness: if efforts { EVEN } else { FREE },
            seen: Vec::new(),
            solved: Vec::new(),
            best: None,
            waiting: Vec::new(),
            programs: 0,
            last_gain: 0,
            order: 0,
        }
    }

    /// The best words, the best first.
    pub(in crate::ocp) fn run(
        mut self,
        runner: &mut Runner,
        beginnings: &[Beginning],
    ) -> (Vec<Timed>, Goals) {
        for beginning in beginnings {
            self.evaluate(runner, &beginning.draft, &beginning.motion);
        }
        (0..self.solved.len()).for_each(|index| self.push(index));
        self.last_gain = self.programs;
        while self.programs < PROGRAMS
            && self.programs - self.last_gain < PATIENCE
            && !runner.stopped()
            && let Some(next) = self.next()
        {
            let parent = self.solved[next.parent].clone();
            let Some(index) = self.evaluate(runner, &next.draft, &parent.motion) else {
                continue;
            };
            let found = &self.solved[index];
            let size = self.size();
            let better = found.value(size) < parent.value(size) - TOLERANCE * size;
            let shorter = found.word().phases() < parent.word().phases()
                && found.merit < self.best_merit() + SHORTER * size;
            if self.best == Some(index) {
                self.last_gain = self.programs;
                self.push(index);
                self.rank_again();
            } else if better || shorter {
                self.push(index);
            }
        }
        self.best_words(runner)
    }

    /// Size against which gains count.
    fn size(&self) -> f64 {
        self.best_merit().abs().max(f64::MIN_POSITIVE)
    }

    fn merit(&self, index: usize) -> f64 {
        self.solved[index].merit
    }

    fn value(&self, index: usize) -> f64 {
        self.solved[index].value(self.size())
    }

    fn best_merit(&self) -> f64 {
        self.best.map_or(f64::INFINITY, |best| self.merit(best))
    }

    /// Solves the program of a draft, unless the word was guessed like that before; its index if it has a solution.
    fn evaluate(
        &mut self,
        runner: &mut Runner,
        draft: &Draft,
        motion: &Trajectory,
    ) -> Option<usize> {
        if draft.word.phases() > MOST_PHASES || runner.stopped() {
            return None;
        }
        let times: Vec<f64> = draft
            .times
            .iter()
            .map(|time| time / draft.horizon)
            .collect();
        let known = self.seen.iter().position(|seen| seen.word == draft.word);
        let place = known.unwrap_or_else(|| {
            self.seen.push(Seen {
                word: draft.word.clone(),
                guesses: Vec::new(),
                won: 0,
                merit: f64::INFINITY,
            });
            self.seen.len() - 1
        });
        let seen = &mut self.seen[place];
        let alike = |other: &Vec<f64>| {
            let pairs = other.iter().zip(&times);
            pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) < SAME_TIMES
        };
        if seen.guesses.len() >= GUESSES + seen.won || seen.guesses.iter().any(alike) {
            return None;
        }
        seen.guesses.push(times);
        let with = (self.tableau, self.fineness);
        let first = solve(runner, self.setting, with, (draft, motion), &mut self.goals);
        self.programs += 1;
        let timed = self.dearer(runner, first?);
        let merit = timed.merit;
        if !merit.is_finite() {
            return None;
        }
        let index = self.solved.len();
        self.solved.push(timed);
        let improves = self
            .best
            .is_none_or(|best| self.value(index) < self.value(best) - TOLERANCE * self.size());
        let seen = &mut self.seen[place];
        seen.merit = seen.merit.min(merit);
        if improves {
            if self.solved[index].missed <= MET {
                let objective = self.solved[index].objective;
                runner.found(BestMotion::new(draft.word.closings(), objective, false));
            }
            seen.won += 1;
            self.best = Some(index);
        }
        Some(index)
    }

    /// A word that would be the best though it misses goals, at a higher price of that.
    fn dearer(&mut self, runner: &mut Runner, timed: Timed) -> Timed {
        if timed.missed <= MET || timed.merit >= self.best_merit() {
            return timed;
        }
        let with = (self.tableau, self.fineness);
        let mut goals = self.goals.clone();
        goals.price = goals.price.map(|price| DEARER * price);
        self.programs += 1;
        let again = solve(
            runner,
            self.setting,
            with,
            (&timed.draft, &timed.motion),
            &mut goals,
        );
        let price = goals.price.unwrap_or(0.0);
        again.unwrap_or(Timed {
            merit: timed.objective + price * timed.missed,
            ..timed
        })
    }

    /// Adds all edits of a solved word to those that wait.
    fn push(&mut self, index: usize) {
        let merit = self.merit(index);
        let excess = (merit - self.best_merit()) / self.size();
        let parent = Parent {
            setting: self.setting,
            timed: &self.solved[index],
            library: &self.library,
        };
        let phases = self.solved[index].word().phases();
        let mut waiting = Vec::new();
        // A phase of no length is not edited further: what it leads to, the word without it does.
        let vanished = parent.has_vanished();
        let rules = self.rules.iter();
        let rules = rules.filter(|rule| !vanished || rule.price == 0.0);
        for rule in rules {
            for (rank, draft) in (rule.drafts)(&parent).into_iter().enumerate() {
                self.order += 1;
                let own = rule.price + NEXT_OF_RULE * rank as f64;
                let of_word = OF_PHASE * phases as f64 + OF_PARENT * excess.min(MOST_EXCESS);
                waiting.push(Waiting {
                    priority: own + of_word,
                    order: self.order,
                    rule: rule.name,
                    draft,
                    parent: index,
                });
            }
        }
        self.waiting.extend(waiting);
    }

    /// Ranks what waits by the new best.
    fn rank_again(&mut self) {
        let mut parents: Vec<usize> = self.waiting.iter().map(|waiting| waiting.parent).collect();
        parents.sort_unstable();
        parents.dedup();
        self.waiting.clear();
        parents.into_iter().for_each(|parent| self.push(parent));
    }

    /// Takes the cheapest that waits, unless its word is known to be better than its parent.
    fn next(&mut self) -> Option<Waiting> {
        loop {
            let cheapest = self.waiting.iter().enumerate().min_by(|(_, a), (_, b)| {
                a.priority
                    .total_cmp(&b.priority)
                    .then(a.order.cmp(&b.order))
            });
            let (index, _) = cheapest?;
            let next = self.waiting.swap_remove(index);
            let mine = self.seen.iter().find(|seen| seen.word == next.draft.word);
            let worse = self.merit(next.parent) - TOLERANCE * self.size();
            let again = next.rule == "press";
            if again || mine.is_none_or(|seen| seen.merit >= worse) {
                return Some(next);
            }
        }
    }

    /// The best words, the best first: of each at most two motions that differ, and those that come first with pieces of free length.
    fn best_words(mut self, runner: &mut Runner) -> (Vec<Timed>, Goals) {
        let size = self.size();
        let most = self.best_merit() + WORTH * size;
        let mut all = std::mem::take(&mut self.solved);
        all.retain(|timed| timed.merit <= most);
        all.sort_by(|a, b| a.value(size).total_cmp(&b.value(size)));
        let mut kept: Vec<Timed> = Vec::new();
        for timed in all {
            let same = kept.iter().filter(|other| other.word() == timed.word());
            let mut distances = same.map(|other| (other.merit - timed.merit).abs());
            let differs = distances.all(|distance| distance >= MOTION * size);
            let same = kept.iter().filter(|other| other.word() == timed.word());
            if same.count() < OF_EACH_WORD && differs && kept.len() < KEPT {
                kept.push(timed);
            }
        }
        for timed in kept.iter_mut().take(REFINEMENTS) {
            if runner.stopped() || !runner.settings.uses("refine") {
                break;
            }
            let with = (self.tableau, REFINED);
            let from = (&timed.draft, &timed.motion);
            if let Some(refined) = solve(runner, self.setting, with, from, &mut self.goals)
                && refined.merit < timed.merit + POORER * size
            {
                *timed = refined;
            }
        }
        kept.sort_by(|a, b| a.value(size).total_cmp(&b.value(size)));
        (kept, self.goals)
    }
}
