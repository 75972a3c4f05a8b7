//! One contact sequence: its program, the cuts that its motion asks for, and how it compares with the best.
//!
//! A program is solved in two stages. The first one ends at a moderate barrier parameter: that tells whether the
//! sequence can be better than the best, and where its motion needs cuts; most sequences end there. Only a motion that
//! passes is solved to the tolerance.

use super::collocation::{Collocation, Cut};
use super::cuts::between_stages;
use super::path::Path;
use super::search::{Local, Search, refused};
use super::sequence::{Sequence, Signature};
use crate::nlp;
use crate::simulation::InputError;

/// Barrier parameters that a program is started with, in this order, and most iterations with each: of the first
/// program, of a neighbour, which starts near its solution, and of a sequence about which nothing is claimed.
const FIRST: [(f64, usize); 3] = [(1e-2, usize::MAX), (1e-3, usize::MAX), (1e-1, usize::MAX)];
const NEIGHBOUR: [(f64, usize); 2] = [(1e-4, 60), (1e-2, 300)];
const EXPLORED: [(f64, usize); 1] = [(1e-4, 80)];
/// The same after a cut.
const AFTER_CUT: (f64, usize) = (1e-5, 80);
/// Rounds of cuts of one sequence.
const ROUNDS: usize = 6;
/// Tolerance of the first stage.
const FIRST_TOLERANCE: f64 = 2e-7;
/// Relative decrease of the objective that counts as an improvement.
const IMPROVEMENT: f64 = 1e-9;

/// What became of a sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Verdict {
    /// It is the best now.
    Better,
    /// Its local optimum is at least this, and not better than the best; infinite if it allows no motion.
    NotBetter(f64),
    /// Its program could not be solved.
    Undecided,
}

/// Why a sequence is attempted while there is a best.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// It is a neighbour of the best, and has to be decided.
    Compare,
    /// It may be better, but nothing is claimed about it.
    Explore,
}

/// A sequence that was attempted.
pub(super) struct Tried {
    signature: Signature,
    purpose: Purpose,
    verdict: Verdict,
}

impl<'a> Search<'a, '_> {
    /// Solves the program of a sequence with its cuts and keeps it if it is the best.
    pub(super) fn attempt(
        &mut self,
        sequence: &Sequence,
        guess: &Path,
        cuts: &[Cut],
        purpose: Purpose,
    ) -> Result<Verdict, InputError> {
        let verdict = self.compare(sequence, guess, cuts, purpose)?;
        // From now on the best is at least as good as the best is now.
        let known = match (verdict, &self.best) {
            (Verdict::Better, Some(best)) => Verdict::NotBetter(best.solution.objective),
            _ => verdict,
        };
        self.tried.push(Tried {
            signature: sequence.signature(),
            purpose,
            verdict: known,
        });
        Ok(verdict)
    }

    /// What is known of a neighbour of the best from an earlier attempt.
    pub(super) fn known(&self, sequence: &Sequence) -> Option<Verdict> {
        let signature = sequence.signature();
        let mut tried = self.tried.iter().rev();
        let tried = tried.find(|tried| tried.signature == signature)?;
        match tried.verdict {
            Verdict::NotBetter(least) if !self.improves(least) => Some(tried.verdict),
            Verdict::Undecided if tried.purpose == Purpose::Compare => Some(tried.verdict),
            _ => None,
        }
    }

    /// Whether a sequence was attempted, for whatever purpose.
    pub(super) fn was_tried(&self, sequence: &Sequence) -> bool {
        let signature = sequence.signature();
        self.tried.iter().any(|tried| tried.signature == signature)
    }

    fn compare(
        &mut self,
        sequence: &Sequence,
        guess: &Path,
        cuts: &[Cut],
        purpose: Purpose,
    ) -> Result<Verdict, InputError> {
        let mut cuts = cuts.to_vec();
        let intervals = self.setting.problem.intervals;
        let mut guess = if sequence.ends_with_impact(intervals) {
            guess.up_to_last_jump(intervals)
        } else {
            guess.clone()
        };
        let mut sequence = sequence.clone();
        for round in 0..ROUNDS {
            let last = round + 1 == ROUNDS;
            let Some((mut program, first)) =
                self.first(&sequence, &guess, &cuts, (purpose, round > 0))?
            else {
                return Ok(self.verdict_of_failure());
            };
            let least = least_objective(&first);
            if !self.improves(least) {
                return Ok(Verdict::NotBetter(least));
            }
            let mut new = self.new_cuts(&program, &first.x);
            let mut solved = &first;
            let second;
            // A cut only makes it worse.
            let behind = !self.improves(first.objective);
            if new.is_empty() || behind || last {
                let Some(solution) = self.second(&mut program, &first)? else {
                    return Ok(self.verdict_of_failure());
                };
                second = solution;
                solved = &second;
                if !self.improves(second.objective) {
                    return Ok(Verdict::NotBetter(second.objective));
                }
                new = self.new_cuts(&program, &second.x);
                // What is left after the last round is for the re-simulation to judge.
                if new.is_empty() || last {
                    let (path, sequence) = program.result(&second.x);
                    self.best = Some(Local {
                        program,
                        solution: second,
                        path,
                        sequence,
                        cuts,
                    });
                    return Ok(Verdict::Better);
                }
            }
            (guess, sequence) = program.result(&solved.x);
            cuts.extend(new);
        }
        Ok(Verdict::Undecided)
    }

    fn new_cuts(&self, program: &Collocation, x: &[f64]) -> Vec<Cut> {
        between_stages(program, x, self.setting.parabolas, self.limits())
    }

    /// Whether an objective is better than the best.
    fn improves(&self, objective: f64) -> bool {
        self.best.as_ref().is_none_or(|best| {
            let size = objective.abs().max(best.program.program.objective_unit());
            objective <= best.solution.objective - IMPROVEMENT * size
        })
    }

    fn verdict_of_failure(&self) -> Verdict {
        match self.last_failure {
            Some(nlp::Status::Infeasible) => Verdict::NotBetter(f64::INFINITY),
            _ => Verdict::Undecided,
        }
    }

    /// The first stage of a program: from the point of an earlier one, if there is any, or else from the first barrier
    /// parameter that works.
    fn first(
        &mut self,
        sequence: &Sequence,
        guess: &Path,
        cuts: &[Cut],
        (purpose, after_cut): (Purpose, bool),
    ) -> Result<Option<(Collocation<'a>, nlp::Solution)>, InputError> {
        let mut program = Collocation::new(self.setting, sequence, guess, cuts, &self.elements);
        let settings = nlp::Settings {
            tolerance: FIRST_TOLERANCE.max(self.settings.tolerance),
            ..self.interior_point()
        };
        if after_cut {
            let settings = nlp::Settings {
                initial_barrier_parameter: AFTER_CUT.0,
                maximum_iterations: settings.maximum_iterations.min(AFTER_CUT.1),
                ..settings.clone()
            };
            if let Some(solution) = self.solve(&mut program, &settings, None, true)? {
                return Ok(Some((program, solution)));
            }
        }
        let barriers = match (&self.best, purpose) {
            (None, _) => &FIRST[..],
            (Some(_), Purpose::Compare) => &NEIGHBOUR,
            (Some(_), Purpose::Explore) => &EXPLORED,
        };
        for (index, &(barrier, iterations)) in barriers.iter().enumerate() {
            if self.watch.stopped {
                break;
            }
            let settings = nlp::Settings {
                initial_barrier_parameter: barrier,
                maximum_iterations: settings.maximum_iterations.min(iterations),
                ..settings.clone()
            };
            let gives_up =
                purpose == Purpose::Compare && index + 1 < barriers.len() && self.best.is_some();
            if let Some(solution) = self.solve(&mut program, &settings, None, gives_up)? {
                return Ok(Some((program, solution)));
            }
        }
        Ok(None)
    }

    /// The second stage: from the end of the first one to the tolerance.
    fn second(
        &mut self,
        program: &mut Collocation<'a>,
        first: &nlp::Solution,
    ) -> Result<Option<nlp::Solution>, InputError> {
        let settings = warm(&self.interior_point(), first.barrier_parameter);
        let start = nlp::WarmStart::from_solution(first);
        self.solve(program, &settings, Some(&start), false)
    }

    fn interior_point(&self) -> nlp::Settings {
        nlp::Settings {
            tolerance: self.settings.tolerance,
            constraint_tolerance: self.settings.tolerance,
            maximum_iterations: self.settings.maximum_iterations,
            ..nlp::Settings::default()
        }
    }

    /// One run of the interior point method; `None` if it ends without a solution. One that `gives_up` ends where it
    /// would restore feasibility: that takes long, and a larger barrier parameter less.
    fn solve(
        &mut self,
        program: &mut Collocation<'a>,
        settings: &nlp::Settings,
        start: Option<&nlp::WarmStart>,
        gives_up: bool,
    ) -> Result<Option<nlp::Solution>, InputError> {
        let best = self.best.as_ref().map(|best| best.solution.objective);
        self.watch.begin("collocation", &self.counts, best);
        let unit = program.program.objective_unit();
        let mut observer = |info: &nlp::IterationInfo| {
            self.watch.iteration(info, unit) && !(gives_up && info.restoration)
        };
        let mut solution =
            nlp::solve_from(&mut program.program, settings, start, Some(&mut observer))
                .map_err(|error| refused(&error))?;
        solution.objective *= unit;
        for info in &mut solution.history {
            info.objective *= unit;
        }
        self.counts.programs += 1;
        self.counts.iterations += solution.counts.iterations;
        self.counts.factorizations += solution.counts.factorizations;
        if matches!(
            solution.status,
            nlp::Status::Solved | nlp::Status::Acceptable
        ) {
            return Ok(Some(solution));
        }
        let status = match solution.status {
            nlp::Status::Interrupted if !self.watch.stopped => nlp::Status::RestorationFailed,
            status => status,
        };
        self.note_failure(status, solution.violations);
        Ok(None)
    }
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
fn warm(settings: &nlp::Settings, barrier_parameter: f64) -> nlp::Settings {
    let push = 1e-2 * barrier_parameter;
    nlp::Settings {
        bound_push: push,
        bound_fraction: push,
        ..settings.clone()
    }
}
