//! The watchdog: full steps without a test where the line search keeps cutting them (Chamberlain, Powell, Lemarechal and
//! Pedersen 1982).
//!
//! Near curved constraints the filter may refuse full steps that would be fine two iterations later. After a number of
//! shortened steps in a row the point is kept, full steps are taken whatever they do, and each is judged against the kept
//! point; if none of three is acceptable to it, the search goes back and cuts the kept step as usual.

use super::barrier_problem::Values;
use super::iterate::Iterate;
use super::line_search::{Acceptance, Reference, Search};
use super::solver::Loop;

/// Full steps that are tried before the search goes back.
const TRIALS: usize = 3;

/// Counter of shortened steps, and what a trial goes back to.
#[derive(Debug, Clone, Default)]
pub(crate) struct Watchdog {
    shortened: usize,
    is_active: bool,
    trials: usize,
    /// Allocated at the first trial, reused by the others.
    kept: Option<Box<Kept>>,
}

/// The point where a trial began, with its direction.
#[derive(Debug, Clone)]
struct Kept {
    iterate: Iterate,
    values: Values,
    direction: Iterate,
    reference: Reference,
    alpha_max: f64,
}

impl Watchdog {
    /// Ends a trial where it stands: what it compares with has changed.
    pub(crate) fn reset(&mut self) {
        self.is_active = false;
        self.shortened = 0;
    }

    /// Counts shortened steps.
    pub(crate) fn see(&mut self, search: &Search) {
        if self.is_active || search.trials <= 1 {
            self.shortened = 0;
        } else {
            self.shortened += 1;
        }
    }
}

impl Loop<'_, '_, '_, '_> {
    /// Begins a trial if the last steps were cut: keeps the point and takes the full step.
    pub(crate) fn begin_watchdog(
        &mut self,
        reference: &Reference,
        alpha_max: f64,
    ) -> Option<Search> {
        let steps = self.core.settings.watchdog_steps;
        let is_main = !self.is_restoration && self.problem.products.is_empty();
        if steps == 0 || !is_main || self.watchdog.shortened < steps {
            return None;
        }
        self.watchdog.shortened = 0;
        if !self.take_trial(alpha_max, false) {
            return None;
        }
        match &mut self.watchdog.kept {
            Some(kept) => {
                kept.iterate.copy_from(&self.iterate);
                kept.values.copy_from(&self.values);
                kept.direction.copy_from(&self.direction);
                kept.reference = *reference;
                kept.alpha_max = alpha_max;
            }
            None => {
                self.watchdog.kept = Some(Box::new(Kept {
                    iterate: self.iterate.clone(),
                    values: self.values.clone(),
                    direction: self.direction.clone(),
                    reference: *reference,
                    alpha_max,
                }));
            }
        }
        self.watchdog.is_active = true;
        self.watchdog.trials = 0;
        Some(self.end_or_go_on(alpha_max))
    }

    /// A full step of a trial in progress; without one, or after going back, the search that cuts steps decides.
    pub(crate) fn watchdog_step(&mut self) -> Option<Search> {
        if !self.watchdog.is_active {
            return None;
        }
        let alpha_max = self.longest_step(&self.direction);
        if self.watchdog.trials < TRIALS && self.take_trial(alpha_max, false) {
            return Some(self.end_or_go_on(alpha_max));
        }
        self.watchdog.reset();
        let kept = self.watchdog.kept.as_ref()?;
        self.iterate.copy_from(&kept.iterate);
        self.values.copy_from(&kept.values);
        self.direction.copy_from(&kept.direction);
        let (reference, alpha_max) = (kept.reference, kept.alpha_max);
        self.evaluate_first_derivatives();
        self.update_lagrangian();
        Some(self.backtrack(&reference, alpha_max, 0.5 * alpha_max))
    }

    /// Judges the full step in `trial` against the kept point.
    fn end_or_go_on(&mut self, alpha: f64) -> Search {
        let mut search = Search {
            acceptance: Acceptance::Watchdog,
            alpha,
            alpha_max: alpha,
            trials: 1,
            corrected: false,
            filter_rejected: false,
        };
        let Some(kept) = &self.watchdog.kept else {
            return search;
        };
        let (reference, step) = (kept.reference, kept.alpha_max);
        let (acceptance, _) = self.judge(&reference, step, step);
        if acceptance == Acceptance::None {
            self.watchdog.trials += 1;
        } else {
            self.watchdog.reset();
            self.augment_filter(acceptance, &reference);
            search.acceptance = acceptance;
        }
        search
    }
}
