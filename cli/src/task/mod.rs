//! What is to be computed: arguments become a task, which gives its result and the documents about it.

mod fit;
mod optimum;
mod simulation;

pub(crate) use fit::{FitTask, METHOD as FIT_METHOD, facts as fit_facts};
pub(crate) use optimum::{INTERVALS, OptimumTask, facts as optimum_facts};
pub(crate) use simulation::{SimulationTask, facts as simulation_facts};
