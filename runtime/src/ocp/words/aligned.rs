//! A word with a given number of control intervals, divided among its phases: controls may change where contacts do.
//!
//! Where intervals are of equal length a switch falls somewhere within one, and what follows it is driven by what was chosen before it.
//! Here each phase has intervals of its own, of equal length within it, at least one; its length is free, so that no switch presses on an
//! end of an interval. What a motion presses against are other words then, of which those are solved that its multipliers point to.

use hangtime_solver::mpcc::Stationarity;

use super::edits::{Parent, RULES};
use super::library::Library;
use super::off_grid::{Goals, Timed, begun, read, solved, spans_with};
use super::word::{Draft, Word};
use crate::ocp::collocation::discretization::{Lengths, Setting, Span};
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::Runner;
use crate::ocp::search::attempt::{Attempt, Attempts, Local, Purpose, Verdict};
use crate::ocp::tuning::equal::COST;
use crate::ocp::tuning::off_grid::{BARRIER, DEARER, ITERATIONS};
use crate::ocp::tuning::on_grid::FOLLOWED;
use crate::simulation::InputError;

/// Rules that lead to the words that a motion is a limit of.
const NEIGHBOURS: [&str; 3] = ["collapse", "vanish", "press"];

/// A word and the control intervals of its phases.
#[derive(Clone)]
pub(in crate::ocp) struct Aligned {
    draft: Draft,
    motion: Trajectory,
    counts: Vec<usize>,
}

impl Aligned {
    /// A word with so many control intervals, by the lengths of its phases; `None` where there are fewer of them than phases.
    pub(in crate::ocp) fn of(timed: &Timed, intervals: usize) -> Option<Self> {
        Self::of_draft(&timed.draft, &timed.motion, intervals)
    }

    fn of_draft(draft: &Draft, motion: &Trajectory, intervals: usize) -> Option<Self> {
        let lengths = draft.phases().into_iter().map(|(from, to)| to - from);
        Some(Self {
            counts: shares(&lengths.collect::<Vec<_>>(), intervals)?,
            draft: draft.clone(),
            motion: motion.clone(),
        })
    }

    fn word(&self) -> &Word {
        &self.draft.word
    }

    /// The control intervals between its switches, each with so many finite elements.
    pub(in crate::ocp) fn spans(&self, setting: Setting, elements: usize) -> Vec<Span> {
        let mut spans = spans_with(&self.draft, setting.problem, |phase, _| self.counts[phase]);
        for span in &mut spans {
            span.elements = elements;
        }
        spans
    }

    /// The word of a plan on equal intervals, with as many.
    pub(in crate::ocp) fn of_plan(plan: Candidate) -> Option<Self> {
        let intervals = plan.trajectory.controls.intervals();
        let horizon = plan.trajectory.horizon;
        let draft = Draft::read(&plan.sequence, horizon / intervals as f64, horizon);
        Self::of_draft(&draft, &plan.trajectory, intervals)
    }

    /// Its exact solution with these spans, or what is known without one.
    pub(in crate::ocp) fn solved<'a>(
        &self,
        runner: &mut Runner,
        setting: Setting<'a>,
        spans: &'a [Span],
    ) -> Result<Local<'a>, Verdict> {
        let Some(sequence) = self.draft.word.sequence(&self.counts) else {
            return Err(Verdict::NotBetter(f64::INFINITY));
        };
        let (guess, elements) = begun(spans, &self.motion);
        let setting = Setting {
            shape: ControlShape::Constant,
            lengths: Lengths::Phases(spans),
            elastic: None,
            ..setting
        };
        let mut attempts = Attempts::new(setting, &elements);
        let attempt = Attempt {
            sequence: &sequence,
            guess: &guess,
            cuts: &[],
            purpose: Purpose::Near,
        };
        let verdict = attempts.attempt(runner, attempt);
        attempts.best.ok_or(verdict)
    }

    /// Its objective with these spans where goals may be missed, at a high price; `None` where that is not known, infinite without an order.
    fn merit(
        &self,
        runner: &mut Runner,
        setting: Setting,
        (spans, goals): (&[Span], &Goals),
    ) -> Option<f64> {
        let Some(sequence) = self.draft.word.sequence(&self.counts) else {
            return Some(f64::INFINITY);
        };
        let (guess, elements) = begun(spans, &self.motion);
        let setting = Setting {
            shape: ControlShape::Constant,
            lengths: Lengths::Phases(spans),
            elastic: Some(&goals.sizes),
            ..setting
        };
        let mut dear = goals.at(DEARER * goals.price?);
        let from = (&sequence, &guess, &elements[..]);
        let (_, solution) = solved(runner, setting, from, &mut dear, (BARRIER, ITERATIONS))?;
        Some(solution.objective)
    }

    /// The words that a solution points to.
    fn neighbours(&self, setting: Setting, local: &Local) -> Vec<Self> {
        let timed = read(&local.program, &local.solution, (&self.draft, &self.counts));
        let library = Library::default();
        let parent = Parent {
            setting,
            timed: &timed,
            library: &library,
        };
        let rules = RULES.iter().filter(|rule| NEIGHBOURS.contains(&rule.name));
        let drafts = rules.flat_map(|rule| (rule.drafts)(&parent));
        let intervals = setting.problem.intervals;
        drafts
            .filter_map(|draft| Self::of_draft(&draft, &timed.motion, intervals))
            .collect()
    }
}

/// Follows better ones of the words that a solution points to, until there is none, and hands the exact solution of that to a judge, with what
/// is proved of it; the word, what is proved and the judgement, if there is a solution.
pub(in crate::ocp) fn followed<T>(
    runner: &mut Runner,
    setting: Setting,
    (aligned, elements, goals): (Aligned, usize, &Goals),
    judge: impl FnOnce(&mut Runner, Setting, Local, Stationarity) -> Result<T, InputError>,
) -> Result<Option<(Aligned, Stationarity, T)>, InputError> {
    let mut best = aligned;
    let mut known: Vec<Word> = vec![best.word().clone()];
    loop {
        let spans = best.spans(setting, elements);
        let Ok(local) = best.solved(runner, setting, &spans) else {
            return Ok(None);
        };
        let (stationarity, better) = if known.len() > FOLLOWED {
            (Stationarity::None, None)
        } else {
            let plan = (&best, &local, elements, goals);
            compared(runner, setting, plan, &mut known)
        };
        let Some(better) = better else {
            let own = Setting {
                lengths: Lengths::Phases(&spans),
                ..setting
            };
            let judged = judge(runner, own, local, stationarity)?;
            return Ok(Some((best, stationarity, judged)));
        };
        best = better;
    }
}

/// What the words that a solution points to say of it, and the first of them that is better; those that are known are passed over.
fn compared(
    runner: &mut Runner,
    setting: Setting,
    (best, local, elements, goals): (&Aligned, &Local, usize, &Goals),
    known: &mut Vec<Word>,
) -> (Stationarity, Option<Aligned>) {
    let objective = local.solution.objective;
    let least = objective - COST * local.program.program.size_of(objective);
    let mut stationarity = Stationarity::B;
    for other in best.neighbours(setting, local) {
        if known.contains(other.word()) || runner.stopped() {
            continue;
        }
        known.push(other.word().clone());
        let spans = other.spans(setting, elements);
        let merit = other.merit(runner, setting, (&spans, goals));
        if merit.is_some_and(|merit| merit >= least) {
            continue;
        }
        match other.solved(runner, setting, &spans) {
            Ok(found) if found.solution.objective < least => {
                return (stationarity, Some(other));
            }
            Err(Verdict::Undecided) => stationarity = Stationarity::None,
            _ => {}
        }
    }
    (stationarity, None)
}

/// So many intervals divided by lengths, at least one each; `None` where there are fewer of them.
fn shares(lengths: &[f64], intervals: usize) -> Option<Vec<usize>> {
    let left = intervals.checked_sub(lengths.len())?;
    let total: f64 = lengths.iter().sum();
    let ideal: Vec<f64> = lengths
        .iter()
        .map(|length| (length / total * intervals as f64 - 1.0).max(0.0))
        .collect();
    let sum: f64 = ideal.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let scaled: Vec<f64> = ideal
        .iter()
        .map(|share| share * left as f64 / sum)
        .collect();
    let mut counts: Vec<usize> = scaled
        .iter()
        .map(|share| 1 + share.floor() as usize)
        .collect();
    let mut order: Vec<usize> = (0..lengths.len()).collect();
    let rest = |k: &usize| scaled[*k] - scaled[*k].floor();
    order.sort_by(|a, b| rest(b).total_cmp(&rest(a)));
    let missing = intervals.saturating_sub(counts.iter().sum());
    for &phase in order.iter().cycle().take(missing) {
        counts[phase] += 1;
    }
    Some(counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_divided_by_lengths_and_every_phase_has_one() {
        assert_eq!(shares(&[1.0, 3.0], 8), Some(vec![2, 6]));
        assert_eq!(shares(&[1e-9, 1.0, 1.0], 5), Some(vec![1, 2, 2]));
        assert_eq!(shares(&[1.0, 1.0, 1.0], 3), Some(vec![1, 1, 1]));
        assert_eq!(shares(&[1.0, 1.0, 1.0], 2), None);
        let many = shares(&[0.3, 0.01, 1.7, 0.2], 31).expect("enough");
        assert_eq!(many.iter().sum::<usize>(), 31);
    }
}
