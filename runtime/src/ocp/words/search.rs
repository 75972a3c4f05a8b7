//! Best first: from the words to begin with to better ones by edits, until nothing more is gained.

use super::beginnings::{Beginning, PLAN, another};
use super::edits::{Parent, RULES, Rule};
use super::library::Library;
use super::off_grid::{Fineness, Goals, Timed, solve, solve_around};
use super::word::{Draft, Word};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::final_times::FinalTimes;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::{Horizon, Problem, has_free_start};
use crate::ocp::program::runner::Runner;
use crate::ocp::settings::Settings;
use crate::ocp::solution::WordCounts;
use crate::ocp::tuning::beginnings::MOST_PHASES;
use crate::ocp::tuning::equal::{MET, MOTION};
use crate::ocp::tuning::off_grid::{
    CHEAPER, DEARER, DEAREST, EVEN_PIECES, FREE_PIECES, IN_VAIN, LEAST_PIECES, NO_NEARER,
    TOLERANCE, UNMET,
};
use crate::ocp::tuning::table::{
    DRAFTS, FREE_STARTS, GUESSES, IN_A_TURN, KEPT, MOST_EXCESS, NEXT_OF_RULE, NEXT_TURN,
    OF_EACH_WORD, OF_PARENT, OF_PHASE, PATIENCE, POORER, REFINEMENTS, SAME_TIMES, SHORTER, WORTH,
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
    /// Drafts that were solved, at whatever prices.
    drafts: usize,
    last_gain: usize,
    order: usize,
    /// Whether a word met its goals; the price at first, and the highest at which one missed them while there was none.
    met: bool,
    first_price: f64,
    dearest: f64,
    /// Motions from which the best word was guessed anew.
    guesses: u64,
    /// A motion that no simulation leads to.
    straight: &'r Trajectory,
}

impl<'a, 'r> Words<'a, 'r> {
    pub(in crate::ocp) fn new(
        setting: Setting<'a>,
        (tableau, settings): (&'r ButcherTableau, &Settings),
        straight: &'r Trajectory,
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
            drafts: 0,
            last_gain: 0,
            order: 0,
            met: false,
            first_price: 0.0,
            dearest: 0.0,
            guesses: 0,
            straight,
        }
    }

    /// The best words, the best first, the price of their goals, how many were tried, and from how many guesses the best one was solved.
    pub(in crate::ocp) fn run(
        mut self,
        runner: &mut Runner,
        beginnings: &[Beginning],
    ) -> (Vec<Timed>, Goals, WordCounts, usize) {
        for beginning in beginnings {
            let index = self.evaluate(runner, &beginning.draft, &beginning.motion);
            let own = index.filter(|_| beginning.source == PLAN);
            if let Some(own) = own.filter(|&own| self.solved[own].meets()) {
                runner.ledger.own_word(self.merit(own));
            }
        }
        (0..self.solved.len()).for_each(|index| self.push(index));
        self.edit(runner);
        while self.guessed_anew(runner) {
            self.edit(runner);
        }
        let starts = 1 + self.guesses as usize;
        let tried = self.seen.len();
        let solved = self.seen.iter().filter(|seen| seen.merit.is_finite());
        let failed = tried - solved.count();
        let (words, goals) = self.best_words(runner);
        (words, goals, WordCounts { tried, failed }, starts)
    }

    /// Makes other words of those that are solved, best first, until nothing more is gained.
    fn edit(&mut self, runner: &mut Runner) {
        self.last_gain = self.drafts;
        while self.drafts < DRAFTS
            && self.drafts - self.last_gain < PATIENCE
            && !runner.stopped()
            && !runner.ledger.is_spent()
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
                self.last_gain = self.drafts;
                self.push(index);
                self.rank_again();
            } else if better || shorter {
                self.push(index);
            }
        }
    }

    /// Solves the best word from other motions and times, until so many in a row bring nothing; whether one of them is better.
    fn guessed_anew(&mut self, runner: &mut Runner) -> bool {
        let Some(draft) = self.best.map(|best| self.solved[best].draft.clone()) else {
            return false;
        };
        let place = self.seen.iter().position(|seen| seen.word == draft.word);
        // What is nearest to free initial values too often agrees on one of several motions.
        let free = has_free_start(self.setting.model);
        let starts = runner.settings.starts();
        let starts = if free {
            starts.max(FREE_STARTS)
        } else {
            starts
        };
        let tolerance = runner.settings.replay_tolerance;
        for _ in 1..starts {
            self.guesses += 1;
            let Some(guess) = another(self.setting, &draft, (self.guesses, tolerance)) else {
                continue;
            };
            // As many as are asked for, whatever they bring.
            let spent = runner.settings.starts.is_none() && runner.ledger.is_spent();
            if runner.stopped() || spent {
                return false;
            }
            if let Some(place) = place
                && let Some(index) = self.solve(runner, place, (&guess.0, &guess.1))
                && self.best == Some(index)
            {
                self.push(index);
                self.rank_again();
                return true;
            }
        }
        false
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
        self.solve(runner, place, (draft, motion))
    }

    /// Solves the program of a draft, whose word was seen before; its index if it has a solution.
    fn solve(
        &mut self,
        runner: &mut Runner,
        place: usize,
        (draft, motion): (&Draft, &Trajectory),
    ) -> Option<usize> {
        self.drafts += 1;
        let mut found = self.priced(runner, (draft, motion));
        let missed = found.as_ref().map_or(f64::INFINITY, |timed| timed.missed);
        if !self.met && missed > MET && !runner.stopped() {
            let straight = self.priced(runner, (draft, self.straight));
            let nearer = straight.filter(|straight| straight.missed < missed);
            found = nearer.or(found);
        }
        let timed = found?;
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
                let merit = self.solved[index].merit;
                runner.ledger.word(merit);
            }
            seen.won += 1;
            self.best = Some(index);
        }
        Some(index)
    }

    /// The program of a draft at the price that it needs, which becomes that of all: dearer where it misses its goals, as long as no word
    /// meets them or it would be the best, and where it meets them as cheap as holds them, as of a dearer one its objective is not known.
    fn priced(&mut self, runner: &mut Runner, from: (&Draft, &Trajectory)) -> Option<Timed> {
        let with = (self.tableau, self.fineness);
        let first = solve(runner, self.setting, with, from, &mut self.goals)?;
        let base = self.goals.price.unwrap_or(0.0);
        if self.first_price == 0.0 {
            self.first_price = base;
        }
        if !first.meets() && self.met && first.merit >= self.best_merit() {
            return Some(first);
        }
        let (mut timed, mut price) = self.dearer(runner, from, first, base);
        let decides = timed.meets() && (!self.met || timed.objective < self.best_merit());
        if timed.meets() && price > self.first_price && (price > base || !self.met) {
            (timed, price) = self.cheaper(runner, timed, price);
        }
        if decides {
            self.goals.price = Some(price);
            if timed.objective != 0.0 {
                self.goals.size = Some(timed.objective.abs());
            }
        } else if !timed.meets() && !self.met {
            self.dearest = self.dearest.max(price);
        }
        self.met |= timed.meets();
        let own = self.goals.price.unwrap_or(0.0);
        let price = if self.met { own } else { own.max(self.dearest) };
        self.solved
            .iter_mut()
            .for_each(|other| other.set_price(price));
        timed.set_price(price);
        let indices = 0..self.solved.len();
        self.best = indices.min_by(|a, b| self.value(*a).total_cmp(&self.value(*b)));
        Some(timed)
    }

    /// A word that misses its goals at higher prices, as long as that brings it nearer, anew where it has shrunk to no time, and the price.
    /// Beside a dear miss the objective weighs nothing: so final times stay around those that it begins with.
    fn dearer(
        &mut self,
        runner: &mut Runner,
        from: (&Draft, &Trajectory),
        mut timed: Timed,
        base: f64,
    ) -> (Timed, f64) {
        let looked_at = FinalTimes::around(self.setting.problem, from.1.horizon);
        let (step, most) = match self.met {
            true => (DEARER, 1),
            false if self.dearest > 0.0 => (UNMET, 1),
            false => (UNMET, IN_VAIN),
        };
        let mut price = base;
        let mut in_vain = 0;
        while !timed.meets()
            && in_vain < most
            && price < DEAREST * self.first_price
            && !runner.stopped()
        {
            price *= step;
            let end = looked_at.end_at(timed.motion.horizon);
            let shrunk = end.is_some_and(|end| end < looked_at.longest);
            let ended = (&timed.draft, &timed.motion);
            let start = if shrunk { from } else { ended };
            let Some(again) = self.dear(runner, start, price) else {
                break;
            };
            in_vain = match again.missed < NO_NEARER * timed.missed {
                true => 0,
                false => in_vain + usize::from(!shrunk),
            };
            timed = again;
        }
        (timed, price)
    }

    /// A word at a price beside which the objective weighs nothing: in the time that it begins with, or where it misses its goals in that, in
    /// any.
    fn dear(&self, runner: &mut Runner, from: (&Draft, &Trajectory), price: f64) -> Option<Timed> {
        let with = (self.tableau, self.fineness);
        let mut goals = self.goals.at(price);
        let problem = Problem {
            horizon: Horizon::Fixed(from.1.horizon),
            ..self.setting.problem.clone()
        };
        let setting = Setting {
            problem: &problem,
            ..self.setting
        };
        let fixed = solve_around(runner, setting, with, from, &mut goals);
        let is_free = matches!(self.setting.problem.horizon, Horizon::Free { .. });
        if !is_free || fixed.as_ref().is_some_and(Timed::meets) || runner.stopped() {
            return fixed;
        }
        let ended = fixed.as_ref().map(|timed| (&timed.draft, &timed.motion));
        let from = ended.unwrap_or(from);
        solve(runner, self.setting, with, from, &mut goals).or(fixed)
    }

    /// A word that meets its goals at the least price that is tried at which it does, and that price.
    fn cheaper(&mut self, runner: &mut Runner, timed: Timed, price: f64) -> (Timed, f64) {
        for times in CHEAPER {
            let lower = times * Goals::price_of(timed.objective.abs());
            let lower = lower.max(self.first_price);
            if lower >= 0.5 * price || runner.stopped() {
                break;
            }
            let with = (self.tableau, self.fineness);
            let from = (&timed.draft, &timed.motion);
            let again = solve(runner, self.setting, with, from, &mut self.goals.at(lower));
            if let Some(again) = again.filter(Timed::meets) {
                return (again, lower);
            }
        }
        (timed, price)
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
                // After a few of a rule every other one has its turn.
                let turn = NEXT_TURN * (rank / IN_A_TURN) as f64;
                let own = rule.price + NEXT_OF_RULE * rank as f64 + turn;
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
            let lasting = timed.lasting();
            let same = kept.iter().filter(|other| other.lasting() == lasting);
            let mut distances = same.map(|other| (other.merit - timed.merit).abs());
            let differs = distances.all(|distance| distance >= MOTION * size);
            let same = kept.iter().filter(|other| other.word() == timed.word());
            if same.count() < OF_EACH_WORD && differs && kept.len() < KEPT {
                kept.push(timed);
            }
        }
        for timed in kept.iter_mut().take(REFINEMENTS) {
            if runner.stopped() || runner.ledger.is_spent() || !runner.settings.uses("refine") {
                break;
            }
            if runner.ledger.is_hopeless(timed.merit) {
                continue;
            }
            let with = (self.tableau, REFINED);
            let from = (&timed.draft, &timed.motion);
            if let Some(refined) = solve(runner, self.setting, with, from, &mut self.goals)
                && refined.merit < timed.merit + POORER * size
                && (refined.meets() || !timed.meets())
            {
                *timed = refined;
            }
        }
        kept.sort_by(|a, b| a.value(size).total_cmp(&b.value(size)));
        (kept, self.goals)
    }
}
