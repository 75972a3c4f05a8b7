//! What the caller may choose.

use crate::nlp;

/// How the relaxation parameter `sigma` of `x_i x_j <= sigma` falls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum RelaxationRule {
    /// `sigma = mu^2 / (mu^2 + 1e-6)`: near 1 until the barrier parameter is 1e-3, then quadratic.
    RollOff,
    /// `sigma = 1` until the problem with `mu = 1e-3` is solved, then steps whose length follows the
    /// iterations that the last one took, with a return to the last good point.
    Continuation,
    /// `sigma = 10 mu`: fastest, but prone to poor local minima.
    Proportional,
    /// The l-infinity elastic mode: `min f + s / sigma` s.t. `x_i x_j <= s` for all pairs, with one slack
    /// `s >= 0`, for `sigma = 1, 0.1, ...` until `s` vanishes (Anitescu, SIAM Journal on Optimization 15, 2005). The
    /// most robust rule where the relaxed problem becomes infeasible, at the price of a row for each pair.
    Elastic,
}

/// Settings of the method for complementarity problems; change fields of [`Settings::default`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// Settings of the interior point runs. The defaults here differ from those of a nonlinear program:
    /// `permanent_dual_shift` is 1e-10, because Jacobians of complementarity problems lose rank. Its
    /// `maximum_iterations`, here 1000, limit one rule; its `maximum_seconds` limit the whole solve.
    pub interior_point: nlp::Settings,
    /// Most interior point iterations of the whole solve, those of crossovers and certificates included; default
    /// 10 000. Where linear rows decide sides, the program as it is stated may take six tenths of them, but for the certificates of
    /// exact points, and what it leaves is for the program with these sides fixed. The same holds for a start at which rows and bounds
    /// hold, which is taken where the first rule ends in a stationary point of the violation, and the own one after it.
    pub maximum_iterations: usize,
    /// Rules to try, in this order, until one ends at a certified point; default roll-off, elastic and continuation: what
    /// the proportional one, asked last, certified of 238 programs, others did in fewer iterations.
    pub rules: Vec<RelaxationRule>,
    /// Whether the rule after the one that ends at a certified point is tried too, for a better objective, where the
    /// sides that the relaxed problem had chosen at the first crossover could not be met; default true. The relaxed
    /// solution was none of the complementarity problem then, and the point found from there often is a poor one. And whether a
    /// certified point of more than 16 pairs is relaxed again for a better one, which takes as many
    /// iterations as before at most, or 300.
    pub second_opinion: bool,
    /// Last `sigma`; default 1e-8, > 0.
    pub final_relaxation: f64,
    /// Whether to fix one side of each pair and solve the smooth program after the relaxed one;
    /// default true. Without it complementarity is only met to `final_relaxation`, and nothing is
    /// certified.
    pub crossover: bool,
}

impl Default for Settings {
    fn default() -> Self {
        let interior_point = nlp::Settings {
            persistent: false,
            permanent_dual_shift: 1e-10,
            maximum_iterations: 1000,
            ..nlp::Settings::default()
        };
        Self {
            interior_point,
            maximum_iterations: 10_000,
            rules: vec![
                RelaxationRule::RollOff,
                RelaxationRule::Elastic,
                RelaxationRule::Continuation,
            ],
            second_opinion: true,
            final_relaxation: 1e-8,
            crossover: true,
        }
    }
}

impl Settings {
    /// Checks every field against its range.
    ///
    /// # Errors
    /// [`nlp::InputError`] names the first field outside its range.
    pub(crate) fn validate(&self) -> Result<(), nlp::InputError> {
        self.interior_point.validate()?;
        let fault = |name, value, range| {
            Err(nlp::InputError::from(nlp::Fault::Setting {
                name,
                value,
                range,
            }))
        };
        if self.rules.is_empty() {
            return fault("rules", 0.0, "a list of at least one rule");
        }
        let sigma = self.final_relaxation;
        if !(sigma > 0.0 && sigma < 1.0) {
            return fault("final_relaxation", sigma, "(0, 1)");
        }
        Ok(())
    }
}
