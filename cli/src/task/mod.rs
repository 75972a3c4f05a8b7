//! What is to be computed: arguments become a task, which gives its result and the documents about it.

mod optimum;
mod simulation;

pub(crate) use optimum::{INTERVALS, OptimumTask, certificate, facts as optimum_facts};
pub(crate) use simulation::{SimulationTask, facts as simulation_facts};
