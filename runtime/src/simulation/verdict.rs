//! Whether the residuals of a run are within its tolerance: a run that reaches its horizon is solved only then.
//!
//! A condition of a contact is an equation (a closed gap, a velocity at rest) or a sign (an open gap, a force, the reserve of friction, a
//! sliding velocity or a switch against its part). What one misses beyond rounding is compared with the terms that the motion has made of
//! it: a larger share than the tolerance is no error of integration but an event that was missed, or a mode that does not hold.

use super::{Diagnosis, Residuals, SimulationStatus};
use crate::model::Model;

/// A condition, by the words for its value and the contact.
pub(super) type Condition = (&'static str, usize);

/// The largest miss of a condition.
#[derive(Debug, Clone, Copy)]
struct Miss {
    condition: Condition,
    /// By how much, in the unit of the condition, and as a share of its terms.
    value: f64,
    share: f64,
    /// Time \[s\] and step.
    place: (f64, usize),
}

/// The residuals of a run, and the largest miss beyond its tolerance.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Verdict {
    tolerance: f64,
    /// Time \[s\] and step at which conditions are looked at.
    pub(super) place: (f64, usize),
    pub(super) residuals: Residuals,
    worst: Option<Miss>,
}

impl Verdict {
    /// That of a run which keeps this tolerance; an infinite one judges nothing.
    pub(super) fn within(tolerance: f64) -> Self {
        Self {
            tolerance,
            ..Self::default()
        }
    }

    /// Takes note of a `value` that should vanish, with its rounding error and the size of its terms.
    pub(super) fn vanishes(&mut self, condition: Condition, value: f64, sizes: (f64, f64)) {
        self.residuals.primal = self.residuals.primal.max(value.abs());
        self.judge(condition, value.abs(), sizes);
    }

    /// Takes note of a `value` that should not be negative, with its rounding error and the size of its terms.
    pub(super) fn is_positive(&mut self, condition: Condition, value: f64, sizes: (f64, f64)) {
        // Written so that NaN is looked at.
        if value >= 0.0 {
            return;
        }
        self.residuals.dual = self.residuals.dual.max(-value);
        self.judge(condition, -value, sizes);
    }

    /// Takes note of a product of a gap and its force.
    pub(super) fn complements(&mut self, gap: f64, force: f64) {
        let product = (gap * force).abs();
        self.residuals.complementarity = self.residuals.complementarity.max(product);
    }

    fn judge(&mut self, condition: Condition, value: f64, (rounding, size): (f64, f64)) {
        let share = (value - rounding) / size;
        let known = self.worst.map_or(self.tolerance, |worst| worst.share);
        if value > rounding && share > known || value.is_nan() && self.tolerance.is_finite() {
            self.worst = Some(Miss {
                condition,
                value,
                share,
                place: self.place,
            });
        }
    }

    /// Grows to what was seen elsewhere.
    pub(super) fn include(&mut self, other: &Self) {
        let (own, seen) = (&mut self.residuals, &other.residuals);
        own.primal = own.primal.max(seen.primal);
        own.dual = own.dual.max(seen.dual);
        own.complementarity = own.complementarity.max(seen.complementarity);
        let share = |worst: Option<Miss>| worst.map_or(self.tolerance, |worst| worst.share);
        if share(other.worst) > share(self.worst) {
            self.worst = other.worst;
        }
    }

    /// Why a run that reached its horizon is not solved, if it is not.
    pub(super) fn status(&self, model: &dyn Model) -> Option<SimulationStatus> {
        let worst = self.worst?;
        let ((words, contact), (time, step)) = (worst.condition, worst.place);
        let name = model.declaration().contacts[contact].name;
        Some(SimulationStatus::Inaccurate(Diagnosis {
            time,
            step,
            contact: Some(contact),
            message: format!(
                "{words} of `{name}` misses its condition by {:.1e}, {:.0e} of its terms where the run keeps {:.0e}: an event was \
                 missed; lower the tolerance or the longest step",
                worst.value, worst.share, self.tolerance
            ),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn condition_is_missed_beyond_rounding_and_the_tolerance_alone() {
        let misses = |value: f64, sizes: (f64, f64)| {
            let mut verdict = Verdict::within(1e-6);
            verdict.is_positive(("the gap", 0), value, sizes);
            assert_eq!(verdict.residuals.dual, (-value).max(0.0));
            verdict.worst.is_some()
        };
        assert!(!misses(1.0, (0.0, 0.0)) && !misses(-1e-7, (0.0, 1.0)));
        assert!(!misses(-1e-3, (1e-2, 1.0)) && misses(-1e-3, (1e-4, 1.0)));
        // Without terms rounding alone is allowed.
        assert!(misses(-1e-12, (1e-15, 0.0)) && !misses(-1e-16, (1e-15, 0.0)));
        let mut verdict = Verdict::within(f64::INFINITY);
        verdict.vanishes(("the gap", 0), f64::NAN, (0.0, 1.0));
        assert!(verdict.worst.is_none());
    }
}
