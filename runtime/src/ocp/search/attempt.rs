//! One contact sequence: its program, the cuts that its motion asks for, and how it compares with the best.
//!
//! A program is solved in two stages. The first one ends at a moderate barrier parameter: that tells whether the
//! sequence can be better than the best, and where its motion needs cuts; most sequences end there. Only a motion that
//! passes is solved to the tolerance.

use hangtime_solver::nlp;

use crate::model::Model;
use crate::ocp::tuning::attempt::{
    AFTER_CUT, FIRST, FIRST_TOLERANCE, NEIGHBOUR, POLISH, POLISH_ITERATIONS, ROUNDS, SECOND,
};
use crate::ocp::tuning::equal::ROUNDING;
use crate::ocp::tuning::freezing::PUSH;
use crate::ocp::tuning::off_grid::RESTORED;

use crate::ocp::collocation::between_stages::between_stages;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::collocation::layout::Cut;
use crate::ocp::collocation::limits::Limits;
use crate::ocp::collocation::program::Collocation;
use crate::ocp::collocation::transcribe::transcribe;
use crate::ocp::motion::mode::is_passed;
use crate::ocp::motion::sequence::{Sequence, Signature};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::{Ended, Run, Runner};
use crate::ocp::settings::Settings;
use crate::simulation::ContactMode;

/// Whether a sequence holds the function of a switch at zero that is only passed.
fn rests_where_none_may(model: &dyn Model, sequence: &Sequence) -> bool {
    let rests = |(contact, mode): (usize, ContactMode)| {
        mode == ContactMode::Stick && is_passed(model, contact)
    };
    let switches = sequence.switches.iter().map(|s| (s.contact, s.mode));
    let modes = sequence.initially.iter().copied().enumerate();
    modes.chain(switches).any(rests)
}

/// What became of a sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::ocp) enum Verdict {
    /// It is the best now.
    Better,
    /// Its local optimum is at least this, and not better than the best; infinite if it allows no motion.
    NotBetter(f64),
    /// Its program could not be solved.
    Undecided,
}

/// Why a sequence is attempted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::ocp) enum Purpose {
    /// It is a neighbour of the best, and has to be decided.
    Compare,
    /// It may be better, but nothing is claimed about it.
    Explore,
    /// It is that of a motion which is near a solution of it.
    Near,
}

/// A sequence that was attempted.
struct Tried {
    signature: Signature,
    purpose: Purpose,
    verdict: Verdict,
    /// Objective of the best beside which alone that is so, if not beside others.
    only_beside: Option<f64>,
}

/// A solved program of a sequence.
pub(in crate::ocp) struct Local<'a> {
    pub(in crate::ocp) program: Collocation<'a>,
    pub(in crate::ocp) solution: nlp::Solution,
    /// Its objective without a price of the time.
    pub(in crate::ocp) cost: f64,
    /// Distance of each row from the nearest of its bounds.
    pub(super) slacks: Vec<f64>,
    pub(in crate::ocp) trajectory: Trajectory,
    pub(in crate::ocp) sequence: Sequence,
    pub(in crate::ocp) cuts: Vec<Cut>,
}

/// A sequence to attempt.
#[derive(Clone, Copy)]
pub(in crate::ocp) struct Attempt<'t> {
    pub(in crate::ocp) sequence: &'t Sequence,
    pub(in crate::ocp) guess: &'t Trajectory,
    pub(in crate::ocp) cuts: &'t [Cut],
    pub(in crate::ocp) purpose: Purpose,
}

/// A solved program whose motion another one is started from.
pub(super) type Start<'a> = (Collocation<'a>, nlp::Solution);

/// The sequences that were attempted with one discretization, and the best of them.
pub(in crate::ocp) struct Attempts<'a, 'e> {
    pub(in crate::ocp) setting: Setting<'a>,
    /// Finite elements of a phase in each interval.
    pub(in crate::ocp) elements: &'e [usize],
    pub(in crate::ocp) best: Option<Local<'a>>,
    /// The one before it.
    pub(in crate::ocp) outdone: Option<Local<'a>>,
    tried: Vec<Tried>,
}

impl<'a, 'e> Attempts<'a, 'e> {
    /// None so far.
    pub(in crate::ocp) fn new(setting: Setting<'a>, elements: &'e [usize]) -> Self {
        Self {
            setting,
            elements,
            best: None,
            outdone: None,
            tried: Vec::new(),
        }
    }

    /// Solves the program of a sequence with its cuts and keeps it if it is the best.
    pub(in crate::ocp) fn attempt(&mut self, runner: &mut Runner, attempt: Attempt) -> Verdict {
        self.attempt_from(runner, attempt, None)
    }

    /// Attempts a sequence from the motion of a program of that sequence.
    pub(super) fn attempt_from(
        &mut self,
        runner: &mut Runner,
        attempt: Attempt,
        start: Option<Start<'a>>,
    ) -> Verdict {
        let verdict = match rests_where_none_may(self.setting.model, attempt.sequence) {
            true => Verdict::NotBetter(f64::INFINITY),
            false => self.compare(runner, attempt, start),
        };
        // From now on the best is at least as good as the best is now.
        let known = match (verdict, &self.best) {
            (Verdict::Better, Some(best)) => Verdict::NotBetter(best.solution.objective),
            _ => verdict,
        };
        let undecided = known == Verdict::Undecided;
        self.tried.push(Tried {
            signature: attempt.sequence.signature(),
            purpose: attempt.purpose,
            verdict: known,
            only_beside: self.best_objective().filter(|_| undecided),
        });
        verdict
    }

    /// What is known of a neighbour of the best from earlier attempts.
    pub(super) fn known(&self, sequence: &Sequence) -> Option<Verdict> {
        let signature = sequence.signature();
        let mut tried = self.tried.iter().rev();
        let last = tried.find(|tried| tried.signature == signature)?;
        if last.only_beside.is_some() && last.only_beside != self.best_objective() {
            return None;
        }
        match last.verdict {
            Verdict::NotBetter(least) if !self.improves(least) => Some(last.verdict),
            Verdict::Undecided if last.purpose == Purpose::Compare => Some(last.verdict),
            _ => None,
        }
    }

    /// Keeps what is known of a neighbour without an attempt, beside the present best.
    pub(super) fn learn(&mut self, sequence: &Sequence, verdict: Verdict) {
        self.tried.push(Tried {
            signature: sequence.signature(),
            purpose: Purpose::Compare,
            verdict,
            only_beside: self.best_objective(),
        });
    }

    /// Whether a sequence was attempted, for whatever purpose.
    pub(super) fn was_tried(&self, sequence: &Sequence) -> bool {
        let signature = sequence.signature();
        self.tried.iter().any(|tried| tried.signature == signature)
    }

    fn compare(
        &mut self,
        runner: &mut Runner,
        attempt: Attempt,
        start: Option<Start<'a>>,
    ) -> Verdict {
        let mut cuts = attempt.cuts.to_vec();
        let intervals = self.setting.problem.intervals;
        let mut guess = if attempt.sequence.ends_with_impact(intervals) {
            attempt.guess.up_to_last_jump(intervals)
        } else {
            attempt.guess.clone()
        };
        let mut sequence = attempt.sequence.clone();
        let limits = Limits::new(self.setting, runner.settings);
        let check = |program: &Collocation, x: &[f64]| between_stages(program, x, limits);
        if let Some((program, solution)) = &start {
            (guess, sequence) = program.result(&solution.x);
        }
        let mut before = start;
        for round in 0..ROUNDS {
            let last = round + 1 == ROUNDS;
            let now = Attempt {
                sequence: &sequence,
                guess: &guess,
                cuts: &cuts,
                ..attempt
            };
            let (mut program, first) = match self.first(runner, now, before.as_ref()) {
                Ok(first) => first,
                Err(status) => return verdict_of(status),
            };
            let least = least_objective(&first);
            if !self.improves(least) {
                return Verdict::NotBetter(least);
            }
            let mut new = check(&program, &first.x);
            let mut solved = first;
            // A cut only makes it worse.
            let behind = !self.improves(solved.objective);
            if new.is_empty() || behind || last {
                solved = match second(runner, &mut program, &solved, self.best_objective()) {
                    Ok(second) => second,
                    Err(status) => return verdict_of(status),
                };
                if !self.improves(solved.objective) {
                    return Verdict::NotBetter(solved.objective);
                }
                new = check(&program, &solved.x);
                // What is left after the last round is for the re-simulation to judge.
                if new.is_empty() || last {
                    let (trajectory, sequence) = program.result(&solved.x);
                    let slacks = program.program.slacks(&solved.x);
                    let cost = program.program.cost_without_haste(&solved.x);
                    self.outdone = self.best.replace(Local {
                        program,
                        slacks,
                        cost: cost.unwrap_or(solved.objective),
                        solution: solved,
                        trajectory,
                        sequence,
                        cuts,
                    });
                    return Verdict::Better;
                }
            }
            (guess, sequence) = program.result(&solved.x);
            cuts.extend(new);
            before = Some((program, solved));
        }
        Verdict::Undecided
    }

    pub(super) fn best_objective(&self) -> Option<f64> {
        self.best.as_ref().map(|best| best.solution.objective)
    }

    /// Whether an objective is better than the best.
    pub(super) fn improves(&self, objective: f64) -> bool {
        self.best.as_ref().is_none_or(|best| {
            let size = best.program.program.size_of(objective);
            objective <= best.solution.objective - ROUNDING * size
        })
    }

    /// The first stage of a program: after a cut at first from the solution `before` it, of a neighbour from what it shares
    /// with the best, then from the guess. The reason if it has no solution.
    fn first(
        &self,
        runner: &mut Runner,
        attempt: Attempt,
        before: Option<&Start>,
    ) -> Ended<Start<'a>> {
        let Attempt {
            sequence,
            guess,
            cuts,
            purpose,
        } = attempt;
        // On fine grids a program takes seconds before its first iteration.
        if !runner.goes_on("collocation") {
            return Err(nlp::Status::Interrupted);
        }
        let mut program = transcribe(self.setting, sequence, guess, cuts, self.elements);
        let barriers = match (&self.best, purpose) {
            // After a cut the motion is a start that others do not better.
            _ if !runner.effort.proves() && before.is_some() => &[],
            (None, _) => std::slice::from_ref(&FIRST),
            (Some(_), Purpose::Compare) => &NEIGHBOUR[..],
            (Some(_), Purpose::Explore | Purpose::Near) => &NEIGHBOUR[..1],
        };
        let compares = purpose == Purpose::Compare;
        let near = self.best.as_ref().filter(|_| compares);
        let restores = |last: bool| match &self.best {
            Some(_) if compares && last => usize::MAX,
            Some(_) => 0,
            None => RESTORED,
        };
        let known = match (before, near) {
            (Some((program, solution)), _) => Some((AFTER_CUT, (program, solution))),
            (None, Some(best)) => Some((NEIGHBOUR[0], (&best.program, &best.solution))),
            (None, None) => None,
        };
        let warm = known.map(|(run, known)| (run, 0, Some(known)));
        let stays = purpose == Purpose::Near && self.best.is_none() && before.is_none();
        let near = stays.then_some((NEIGHBOUR[0], 0, None));
        // A deep cut leaves little of that solution but the motion itself.
        let again = before.map(|_| (AFTER_CUT, 0, None));
        let cold = barriers.iter().enumerate();
        let cold = cold.map(|(index, &run)| (run, restores(index + 1 == barriers.len()), None));
        let mut status = nlp::Status::Interrupted;
        let tries = warm.into_iter().chain(again).chain(near).chain(cold);
        for (index, ((barrier, iterations), restores, known)) in tries.enumerate() {
            if index > 0 && runner.stopped() {
                break;
            }
            let mut settings = interior_point(runner.settings);
            settings.tolerance = FIRST_TOLERANCE.max(settings.tolerance);
            settings.initial_barrier_parameter = barrier;
            settings.maximum_iterations = settings.maximum_iterations.min(iterations);
            let start = known.map(|(other, solution)| program.start_from(other, solution, barrier));
            if start.is_some() || stays && index == 0 {
                settings.bound_push = barrier;
                settings.bound_fraction = barrier;
            }
            let run = Run {
                settings: &settings,
                start: start.as_ref(),
                restores,
                best: self.best_objective(),
            };
            match runner.solve(&mut program.program, &run) {
                // From where it ends, with what joints determine there.
                Ok(solution) if program.is_singular(&solution.x) => {
                    let (guess, sequence) = program.result(&solution.x);
                    program = transcribe(self.setting, &sequence, &guess, cuts, self.elements);
                    status = nlp::Status::RestorationFailed;
                }
                Ok(solution) => return Ok((program, solution)),
                Err(reason) => status = reason,
            }
        }
        Err(status)
    }
}

/// The second stage: from the end of the first one to the tolerance.
fn second(
    runner: &mut Runner,
    program: &mut Collocation,
    first: &nlp::Solution,
    best: Option<f64>,
) -> Ended<nlp::Solution> {
    let mut settings = warm(interior_point(runner.settings), first.barrier_parameter);
    settings.maximum_iterations = settings.maximum_iterations.min(SECOND);
    let run = Run {
        settings: &settings,
        start: Some(&nlp::WarmStart::from_solution(first)),
        restores: usize::MAX,
        best,
    };
    runner.solve(&mut program.program, &run)
}

impl Local<'_> {
    /// The solution with smaller residuals. Where it is not strictly complementary its objective is off by the root of the
    /// barrier parameter, and what errors of the states grow to until the end may be far more than the tolerance.
    pub(in crate::ocp) fn polished(mut self, runner: &mut Runner) -> Self {
        if runner.stopped() {
            return self;
        }
        let mut settings = warm(
            interior_point(runner.settings),
            self.solution.barrier_parameter,
        );
        settings.tolerance *= POLISH;
        settings.constraint_tolerance *= POLISH;
        settings.maximum_iterations = settings.maximum_iterations.min(POLISH_ITERATIONS);
        let run = Run {
            settings: &settings,
            start: Some(&nlp::WarmStart::from_solution(&self.solution)),
            restores: 0,
            best: Some(self.solution.objective),
        };
        // Where rounding leaves no smaller residuals it stays as it is.
        if let Ok(solution) = runner.solve(&mut self.program.program, &run) {
            self.slacks = self.program.program.slacks(&solution.x);
            (self.trajectory, self.sequence) = self.program.result(&solution.x);
            let cost = self.program.program.cost_without_haste(&solution.x);
            self.cost = cost.unwrap_or(solution.objective);
            self.solution = solution;
        }
        self
    }
}

fn verdict_of(failure: nlp::Status) -> Verdict {
    match failure {
        nlp::Status::Infeasible => Verdict::NotBetter(f64::INFINITY),
        _ => Verdict::Undecided,
    }
}

pub(in crate::ocp) fn interior_point(chosen: &Settings) -> nlp::Settings {
    let mut settings = nlp::Settings::default();
    settings.tolerance = chosen.tolerance;
    settings.constraint_tolerance = chosen.tolerance;
    settings.maximum_iterations = chosen.maximum_iterations;
    // the search has other sequences and starts to go on with
    settings.persistent = false;
    settings.objective_unit = Some(1.0);
    settings
}

/// Least objective that the central path may lead to. Between the ends of its last two levels, with barrier parameters
/// `m > m'`, the objective fell from `f` to `f'`. The rest of the way is in proportion to the barrier parameter where
/// complementarity is strict, and to its root where it is not: at most `(f - f') / (sqrt(m / m') - 1)`.
fn least_objective(first: &nlp::Solution) -> f64 {
    let mu = first.barrier_parameter;
    let mut before = first.history.iter().rev();
    let Some(before) = before.find(|info| info.barrier_parameter > mu && !info.restoration) else {
        return f64::NEG_INFINITY;
    };
    let ratio = (before.barrier_parameter / mu).sqrt();
    first.objective - (before.objective - first.objective).max(0.0) / (ratio - 1.0)
}

/// Settings that leave a warm point where it is.
fn warm(mut settings: nlp::Settings, barrier_parameter: f64) -> nlp::Settings {
    settings.bound_push = PUSH * barrier_parameter;
    settings.bound_fraction = settings.bound_push;
    settings
}
