//! What the caller may choose.

use super::{Fault, InputError, Interrupt};

/// Settings of the interior point method; change fields of [`Settings::default`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// Bound of the scaled optimality error at which a point is a solution; default 1e-8, in (0, 1).
    pub tolerance: f64,
    /// Bound of the unscaled constraint violation of a solution; default 1e-6, > 0.
    pub constraint_tolerance: f64,
    /// Looser bound of the optimality error that ends a run that makes no progress; default 1e-6.
    pub acceptable_tolerance: f64,
    /// Consecutive iterations within `acceptable_tolerance` that end a run; default 15, 0 = never.
    pub acceptable_iterations: usize,
    /// Most iterations, those of the restoration phase included; default 3000.
    pub maximum_iterations: usize,
    /// Most seconds of wall-clock time, looked at within a step too; default infinite.
    pub maximum_seconds: f64,
    /// Ends the run from outside, within a step too; then its status is [`Interrupted`](super::Status::Interrupted). Default never.
    pub interrupt: Interrupt,
    /// First barrier parameter; default 0.1, > 0. Small values suit warm starts.
    pub initial_barrier_parameter: f64,
    /// Least absolute distance of the first point from its bounds; default 1e-2, > 0.
    pub bound_push: f64,
    /// Least distance of the first point from two-sided bounds, relative to their distance; default
    /// 1e-2, in (0, 0.5).
    pub bound_fraction: f64,
    /// Whether a run that would end without a solution goes on by other means: from other starts, by Newton's method without a
    /// line search, with rows that give way a little; default true. Complementarity problems have their own means.
    pub persistent: bool,
    /// Unit in which the slopes of the objective are of the order of one, > 0; default `None`: it is measured at the start, so that an objective
    /// times any positive number makes the same run.
    pub objective_unit: Option<f64>,
    /// Shift of the dual rows relative to `mu^0.25` that is always on; default 0. Complementarity
    /// problems use 1e-10: their Jacobians lose rank.
    pub(crate) permanent_dual_shift: f64,
    /// So many first steps are taken without a test; default 0.
    pub(crate) untested_steps: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            tolerance: 1e-8,
            constraint_tolerance: 1e-6,
            acceptable_tolerance: 1e-6,
            acceptable_iterations: 15,
            maximum_iterations: 3000,
            maximum_seconds: f64::INFINITY,
            interrupt: Interrupt::default(),
            initial_barrier_parameter: 0.1,
            bound_push: 1e-2,
            bound_fraction: 1e-2,
            persistent: true,
            objective_unit: None,
            permanent_dual_shift: 0.0,
            untested_steps: 0,
        }
    }
}

impl Settings {
    /// Checks every field against its range.
    ///
    /// # Errors
    /// [`InputError`] names the first field outside its range.
    pub(crate) fn validate(&self) -> Result<(), InputError> {
        let check = |name, value: f64, valid: bool, range| {
            if valid {
                Ok(())
            } else {
                Err(InputError::from(Fault::Setting { name, value, range }))
            }
        };
        let positive = |name, value: f64| check(name, value, value > 0.0, "(0, inf)");
        check(
            "tolerance",
            self.tolerance,
            self.tolerance > 0.0 && self.tolerance < 1.0,
            "(0, 1)",
        )?;
        positive("constraint_tolerance", self.constraint_tolerance)?;
        positive("acceptable_tolerance", self.acceptable_tolerance)?;
        positive("maximum_seconds", self.maximum_seconds)?;
        positive("initial_barrier_parameter", self.initial_barrier_parameter)?;
        positive("objective_unit", self.objective_unit.unwrap_or(1.0))?;
        positive("bound_push", self.bound_push)?;
        check(
            "bound_fraction",
            self.bound_fraction,
            self.bound_fraction > 0.0 && self.bound_fraction < 0.5,
            "(0, 0.5)",
        )?;
        let small = |value: f64| (0.0..1e-2).contains(&value);
        check(
            "permanent_dual_shift",
            self.permanent_dual_shift,
            small(self.permanent_dual_shift),
            "[0, 0.01)",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn validate_default_passes_and_not_a_number_does_not() {
        assert_eq!(Settings::default().validate(), Ok(()));
        let settings = Settings {
            bound_push: f64::NAN,
            ..Settings::default()
        };
        let message = settings.validate().unwrap_err().to_string();
        assert_eq!(
            message,
            "setting `bound_push` is NaN; choose a value in (0, inf)"
        );
    }
}
