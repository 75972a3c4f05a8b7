//! What an iteration looked like.

/// One line of the iteration log.
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
    pub step_norm: f64,
    /// Shift `delta_w` of the Hessian that the step used.
    pub hessian_shift: f64,
    /// Primal step length.
    pub step_length_primal: f64,
    /// Dual step length.
    pub step_length_dual: f64,
    /// Trial points of the line search.
    pub trials: usize,
    /// Factorizations of the iteration.
    pub factorizations: usize,
    /// How the step was accepted: `f` Armijo, `h` filter, `F`/`H` the same after a second-order
    /// correction, `t` tiny step, `R` after restoration, ` ` none.
    pub acceptance: char,
}

/// Receives each line of the log as it is made; `false` stops the run.
pub type Observer<'a> = dyn FnMut(&IterationInfo) -> bool + 'a;
