//! The work of a search, what it has led to, and whether more of it is worth while.

use crate::ocp::settings::Settings;
use crate::ocp::tuning::equal::{MOTION, OPTIMUM};
use crate::ocp::tuning::on_grid::NEAR;

/// What a search has spent and found. Work is counted in iterations times variables and rows, so that it is the same on every machine.
pub(in crate::ocp) struct Ledger {
    /// Work without a gain after which the search ends, as a share of the work until the last gain.
    patience: f64,
    work: f64,
    /// The work until the last gain.
    gained: f64,
    /// Objective of the incumbent, the best plan on the grid since one was proved; infinite without one.
    incumbent: f64,
    /// Least objective of a word off the grid that meets its goals.
    word: f64,
    /// What the incumbent's own word costs off the grid, from the incumbent's motion.
    own: f64,
}

impl Ledger {
    pub(in crate::ocp) fn new(settings: &Settings) -> Self {
        Self {
            patience: settings.patience,
            work: 0.0,
            gained: 0.0,
            incumbent: f64::INFINITY,
            word: f64::INFINITY,
            own: f64::INFINITY,
        }
    }

    /// Adds the iterations of a program of that size.
    pub(in crate::ocp) fn spend(&mut self, iterations: usize, size: usize) {
        self.work += iterations as f64 * size as f64;
    }

    /// A proved plan on the grid: from now on others are measured by it, and patience counts.
    pub(in crate::ocp) fn lead(&mut self, objective: f64) {
        self.incumbent = objective;
        self.gained = self.work;
    }

    /// A confirmed plan on the grid, beside an incumbent.
    pub(in crate::ocp) fn plan(&mut self, objective: f64) {
        if self.incumbent.is_infinite() {
            return;
        }
        if is_less(objective, self.incumbent, MOTION) {
            self.gained = self.work;
        }
        if objective < self.incumbent {
            self.incumbent = objective;
            self.own = f64::INFINITY;
        }
    }

    /// A word off the grid that meets its goals.
    pub(in crate::ocp) fn word(&mut self, merit: f64) {
        if is_less(merit, self.word, MOTION) && !self.is_hopeless(merit) {
            self.gained = self.work;
        }
        self.word = self.word.min(merit);
    }

    /// The word of the incumbent, solved off the grid from the incumbent's motion.
    pub(in crate::ocp) fn own_word(&mut self, merit: f64) {
        self.own = merit;
    }

    /// Whether a word off the grid leaves nothing to gain over the incumbent: it costs as much as that, or as its word does. An incumbent that
    /// the grid costs more than it mostly does is poorly placed, whatever its word.
    pub(in crate::ocp) fn is_hopeless(&self, merit: f64) -> bool {
        let incumbent = self.incumbent;
        let well_placed = incumbent - merit <= NEAR * incumbent.abs();
        incumbent.is_finite()
            && (!is_less(merit, incumbent, OPTIMUM)
                || well_placed && !is_less(merit, self.own, OPTIMUM))
    }

    /// Whether a plan on the grid costs no less than the incumbent.
    pub(in crate::ocp) fn is_outdone(&self, objective: f64) -> bool {
        !is_less(objective, self.incumbent, OPTIMUM) && self.incumbent.is_finite()
    }

    /// Whether there is an incumbent, and the work since the last gain has exhausted the patience.
    pub(in crate::ocp) fn is_spent(&self) -> bool {
        self.incumbent.is_finite() && self.work - self.gained > self.patience * self.gained
    }
}

/// Whether an objective is less than another one by more than a share of it.
fn is_less(objective: f64, than: f64, share: f64) -> bool {
    than.is_infinite() || objective < than - share * than.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn search_ends_when_the_work_since_the_last_gain_exceeds_a_share_of_all_before() {
        let mut ledger = Ledger::new(&Settings::default());
        ledger.spend(100, 10);
        assert!(!ledger.is_spent() && !ledger.is_hopeless(1e9));
        ledger.lead(2.0);
        ledger.own_word(1.99);
        ledger.spend(50, 10);
        assert!(!ledger.is_spent());
        ledger.spend(1, 10);
        assert!(ledger.is_spent());
        // What costs no less than the incumbent's own word leads nowhere, and one that does is a reason to go on.
        ledger.word(1.99);
        assert!(ledger.is_spent() && ledger.is_hopeless(1.99));
        ledger.word(1.98);
        assert!(!ledger.is_spent() && !ledger.is_hopeless(1.98) && ledger.is_outdone(2.001));
        // Beside one that the grid costs much, its own word says nothing.
        ledger.plan(1.9);
        ledger.own_word(1.5);
        assert!(!ledger.is_hopeless(1.5) && ledger.is_hopeless(1.9));
    }
}
