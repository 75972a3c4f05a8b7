//! What an iteration looked like.

/// One line of the iteration log.
///
/// Printed it is a line of the log, whose heading is [`IterationInfo::HEADING`]:
///
/// | column | meaning |
/// |---|---|
/// | `iter` | iteration number, `r` appended in the restoration phase |
/// | `objective` | unscaled objective; in the restoration phase that of its own problem |
/// | `inf_pr`, `inf_du`, `inf_co` | primal and dual infeasibility and complementarity, scaled |
/// | `lg(mu)`, `lg(sg)` | decimal logarithm of barrier and relaxation parameter |
/// | `\|\|d\|\|` | largest entry of the step |
/// | `lg(rg)` | decimal logarithm of the Hessian shift, `-` without |
/// | `alpha_du`, `alpha_pr` | dual and primal step length, with the letter of the acceptance |
/// | `ls`, `fa` | trial points, factorizations |
///
/// [`solve_from`](super::solve_from) has an observer that sees them as they are made.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct IterationInfo {
    /// Iteration number; those of the restoration phase count on.
    pub iteration: usize,
    /// Whether the iteration belongs to the restoration phase.
    pub restoration: bool,
    /// Objective, unscaled; in the restoration phase that of its own problem.
    pub objective: f64,
    /// Constraint violation `|c|_inf`, scaled.
    pub primal_infeasibility: f64,
    /// Gradient of the Lagrangian `|.|_inf`, scaled.
    pub dual_infeasibility: f64,
    /// Largest complementarity `|(x - l) z|_inf`.
    pub complementarity: f64,
    /// Barrier parameter `mu`.
    pub barrier_parameter: f64,
    /// Relaxation parameter `sigma` of product constraints, 0 if there are none.
    pub relaxation_parameter: f64,
    /// `|d|_inf` of the step that led here.
    pub(crate) step_norm: f64,
    /// Shift `delta_w` of the Hessian that the step used.
    pub(crate) hessian_shift: f64,
    /// Primal step length.
    pub(crate) step_length_primal: f64,
    /// Dual step length.
    pub(crate) step_length_dual: f64,
    /// Trial points of the line search.
    pub(crate) trials: usize,
    /// Factorizations of the iteration.
    pub(crate) factorizations: usize,
    /// How the step was accepted: `f` Armijo, `h` filter, `F`/`H` the same after a second-order
    /// correction, `t` tiny step, `R` after restoration, ` ` none.
    pub(crate) acceptance: char,
}

impl IterationInfo {
    /// Heading of the lines of a log.
    pub const HEADING: &str = "  iter    objective   inf_pr   inf_du   inf_co lg(mu) lg(sg)    ||d||  lg(rg) alpha_du alpha_pr  ls fa";
}

impl IterationInfo {
    /// The line with the objective in a unit.
    pub(crate) fn times(&self, unit: f64) -> Self {
        let objective = unit * self.objective;
        Self { objective, ..*self }
    }
}

impl std::fmt::Display for IterationInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let logarithm = |value: f64| {
            if value > 0.0 {
                format!("{:.1}", value.log10())
            } else {
                String::from("-")
            }
        };
        write!(
            f,
            "{:>5}{} {:>13.6e} {:.2e} {:.2e} {:.2e} {:>6} {:>6} {:.2e} {:>7} {:.2e} {:.2e}{} {:>2} {:>2}",
            self.iteration,
            if self.restoration { 'r' } else { ' ' },
            self.objective,
            self.primal_infeasibility,
            self.dual_infeasibility,
            self.complementarity,
            logarithm(self.barrier_parameter),
            logarithm(self.relaxation_parameter),
            self.step_norm,
            logarithm(self.hessian_shift),
            self.step_length_dual,
            self.step_length_primal,
            self.acceptance,
            self.trials,
            self.factorizations,
        )
    }
}

/// Receives each line of the log as it is made; `false` stops the run.
pub type Observer<'a> = dyn FnMut(&IterationInfo) -> bool + 'a;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn display_has_every_column_under_its_heading() {
        let info = IterationInfo {
            iteration: 7,
            objective: 17.25,
            barrier_parameter: 1e-2,
            step_length_primal: 0.5,
            step_length_dual: 1.0,
            acceptance: 'f',
            trials: 2,
            factorizations: 1,
            ..IterationInfo::default()
        };
        insta::assert_snapshot!(format!("{}\n{info}\n", IterationInfo::HEADING), @r"
          iter    objective   inf_pr   inf_du   inf_co lg(mu) lg(sg)    ||d||  lg(rg) alpha_du alpha_pr  ls fa
            7     1.725000e1 0.00e0 0.00e0 0.00e0   -2.0      - 0.00e0       - 1.00e0 5.00e-1f  2  1
        ");
    }
}
