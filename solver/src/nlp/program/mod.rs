//! The barrier problem and its functions: from the caller's problem to variables with barriers, rows and residuals.

pub(super) mod barrier_problem;
pub(super) mod formulation;
pub(super) mod iterate;
pub(super) mod residuals;
pub(super) mod scaling;
