//! The one door to the solvers: counts, limits, failures and the observer of a whole solve.

use hangtime_solver::Seconds;
use hangtime_solver::mpcc::Mpcc;
use hangtime_solver::nlp::{NlpProblem, Violation};
use hangtime_solver::{mpcc, nlp};

use super::ledger::Ledger;
use crate::ocp::effort::Effort;
use crate::ocp::progress::Watch;
use crate::ocp::settings::Settings;
use crate::ocp::solution::Counts;
use crate::program::sparse_program::Program;
use crate::progress::BestMotion;
use crate::refusal;
use crate::simulation::InputError;

/// What programs lead to, or why the last of them ended without a solution.
pub(in crate::ocp) type Ended<T> = Result<T, nlp::Status>;

/// Why a program ended without a solution, its worst rows, and where it ended.
pub(in crate::ocp) struct Failure {
    pub(in crate::ocp) status: nlp::Status,
    pub(in crate::ocp) violations: Vec<Violation>,
}

impl Failure {
    /// Why a relaxed program has no solution, if it has none.
    pub(in crate::ocp) fn of_relaxed(solution: &mpcc::Solution) -> Option<Self> {
        let status = match solution.status {
            mpcc::Status::Failed(status) => status,
            mpcc::Status::Infeasible => nlp::Status::Infeasible,
            _ => return None,
        };
        Some(Self {
            status,
            violations: solution.violations.clone(),
        })
    }

    /// Violation of the worst row.
    fn worst(&self) -> f64 {
        self.violations.first().map_or(0.0, |row| row.amount)
    }
}

/// How a smooth program is run.
pub(in crate::ocp) struct Run<'r> {
    pub(in crate::ocp) settings: &'r nlp::Settings,
    pub(in crate::ocp) start: Option<&'r nlp::WarmStart>,
    /// Iterations of the restoration phase after which it ends: these take long, and a larger barrier parameter less.
    pub(in crate::ocp) restores: usize,
    /// Best objective so far, for the observer.
    pub(in crate::ocp) best: Option<f64>,
}

/// Runs programs and keeps what they have in common.
pub(in crate::ocp) struct Runner<'s> {
    pub(in crate::ocp) settings: &'s Settings,
    pub(in crate::ocp) counts: Counts,
    /// CPU time of all programs by kind of work.
    pub(in crate::ocp) seconds: Seconds,
    pub(in crate::ocp) effort: Effort,
    pub(in crate::ocp) ledger: Ledger,
    watch: Watch<'s>,
    /// Most programs, those before it included, and those of one motion.
    most_programs: usize,
    pub(in crate::ocp) of_a_motion: usize,
    /// Of the program that came nearest to a solution.
    failure: Option<Failure>,
    /// Why a program could not be started.
    refusal: Option<InputError>,
}

impl<'s> Runner<'s> {
    /// Begins to count.
    pub(in crate::ocp) fn new(settings: &'s Settings, watch: Watch<'s>, effort: Effort) -> Self {
        Self {
            settings,
            counts: Counts::default(),
            seconds: Seconds::default(),
            effort,
            ledger: Ledger::new(settings),
            watch,
            most_programs: settings.maximum_programs,
            of_a_motion: settings.maximum_programs,
            failure: None,
            refusal: None,
        }
    }

    /// Whether the observer has asked to stop.
    pub(in crate::ocp) fn stopped(&self) -> bool {
        self.watch.stopped
    }

    /// Reports work on something other than a program; `false` if the observer asks to stop.
    pub(in crate::ocp) fn goes_on(&mut self, step: &'static str) -> bool {
        self.watch.goes_on(step)
    }

    /// Tells the observer of a motion that may be the best.
    pub(in crate::ocp) fn found(&mut self, motion: BestMotion) {
        self.watch.found(motion);
    }

    /// Whether the observer has asked to stop, or the programs are used up.
    pub(in crate::ocp) fn is_exhausted(&self) -> bool {
        self.watch.stopped || self.counts.programs >= self.most_programs
    }

    /// Grants as many programs as one motion may take, from now on.
    pub(in crate::ocp) fn grant(&mut self) {
        self.most_programs = self.counts.programs + self.of_a_motion;
    }

    /// Takes why a program could not be started.
    pub(in crate::ocp) fn take_refusal(&mut self) -> Option<InputError> {
        self.refusal.take()
    }

    /// Takes the failure of the program that came nearest to a solution.
    pub(in crate::ocp) fn take_failure(&mut self) -> Option<Failure> {
        self.failure.take()
    }

    /// Puts the failure `before` other programs back, if there was one or they led somewhere: rows of the programs of contact
    /// sequences say more than theirs.
    pub(in crate::ocp) fn restore_failure(&mut self, before: Option<Failure>, led: bool) {
        if before.is_some() || led {
            self.failure = before;
        }
    }

    /// Keeps why a program failed, if it came nearer to a solution than those before.
    pub(in crate::ocp) fn note(&mut self, failure: Failure) {
        let nearer = |before: &Failure| failure.worst() < before.worst();
        if self.failure.as_ref().is_none_or(nearer) {
            self.failure = Some(failure);
        }
    }

    /// Runs the interior point method on a smooth program; the reason if it ends without a solution.
    pub(in crate::ocp) fn solve(
        &mut self,
        program: &mut Program,
        run: &Run,
    ) -> Ended<nlp::Solution> {
        self.watch
            .begin("collocation", &self.counts, run.best, run.restores);
        let unit = program.objective_unit;
        let mut observer = |info: &nlp::IterationInfo| self.watch.iteration(info, unit);
        let mut solution = nlp::solve_from(program, run.settings, run.start, Some(&mut observer))
            .map_err(|error| refused(&mut self.refusal, &error))?;
        solution.objective *= unit;
        for info in &mut solution.history {
            info.objective *= unit;
        }
        self.counts.programs += 1;
        self.counts.iterations += solution.counts.iterations;
        let size = solution.x.len() + solution.multipliers.len();
        self.ledger.spend(solution.counts.iterations, size);
        self.counts.factorizations += solution.counts.factorizations;
        self.seconds += solution.cpu;
        let status = match solution.status {
            nlp::Status::Solved | nlp::Status::Acceptable => return Ok(solution),
            status => self.unless_left(status),
        };
        self.note(Failure {
            status,
            violations: solution.violations,
        });
        Err(status)
    }

    /// How a program ended; where it was interrupted and nobody asked for that, it was left as it restored feasibility.
    fn unless_left(&self, status: nlp::Status) -> nlp::Status {
        match status {
            nlp::Status::Interrupted if !self.watch.stopped => nlp::Status::RestorationFailed,
            status => status,
        }
    }

    /// Relaxes a complementarity problem whose objective is measured in `unit`; `step` says what for, and how many iterations may restore
    /// feasibility. An error if it could not be started.
    pub(in crate::ocp) fn relax(
        &mut self,
        program: &mut dyn Mpcc,
        settings: &mpcc::Settings,
        (step, restores): (&'static str, usize),
        unit: f64,
    ) -> Ended<mpcc::Solution> {
        self.watch.begin(step, &self.counts, None, restores);
        let mut observer = |info: &nlp::IterationInfo| self.watch.iteration(info, unit);
        let mut solution = mpcc::solve_observed(program, settings, &mut observer)
            .map_err(|error| refused(&mut self.refusal, &error))?;
        self.counts.programs += 1;
        self.counts.global_iterations += solution.iterations;
        self.ledger.spend(solution.iterations, 2 * solution.x.len());
        self.counts.factorizations += solution.factorizations;
        self.seconds += solution.cpu;
        if let mpcc::Status::Failed(status) = solution.status {
            solution.status = mpcc::Status::Failed(self.unless_left(status));
        }
        Ok(solution)
    }

    /// Solves the smooth program that a complementarity problem is once sides of its pairs are fixed, from its own starting
    /// point; `step` says what for.
    pub(in crate::ocp) fn fixed(
        &mut self,
        program: &mut dyn NlpProblem,
        settings: &nlp::Settings,
        step: &'static str,
    ) -> Ended<nlp::Solution> {
        self.watch.begin(step, &self.counts, None, usize::MAX);
        let mut observer = |info: &nlp::IterationInfo| self.watch.iteration(info, 1.0);
        let solution = nlp::solve_from(program, settings, None, Some(&mut observer))
            .map_err(|error| refused(&mut self.refusal, &error))?;
        self.counts.programs += 1;
        self.counts.global_iterations += solution.counts.iterations;
        self.counts.factorizations += solution.counts.factorizations;
        self.seconds += solution.cpu;
        match solution.status {
            nlp::Status::Solved | nlp::Status::Acceptable => Ok(solution),
            status => Err(status),
        }
    }
}

/// Keeps the first refusal of the interior point method: the programs here are built to be accepted, except where the
/// model's functions are not finite. Where they are so at one guess others may lead to a motion.
fn refused(first: &mut Option<InputError>, error: &nlp::InputError) -> nlp::Status {
    let what = format!("optimal control: {error}; a number there");
    first.get_or_insert_with(|| refusal::not_finite(what, f64::NAN));
    nlp::Status::NotFinite
}
