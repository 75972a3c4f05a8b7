//! The JSON documents of a simulation and of a solution.
//!
//! Field names and their order are a contract. A number is written as the shortest decimal text
//! that reads back as exactly the same double (at most 17 significant digits), so nothing is lost
//! and `10.2759` stays `10.2759`. What is not finite is never written: the rows of a trajectory end
//! before the first such number, and elsewhere `null` stands in its place.

mod columns;
mod estimate;
mod gradient;
mod joints;
mod parts;
mod program;
mod simulation;
mod solution;

pub use columns::Columns;
pub(crate) use columns::{part, quantities};
pub(crate) use estimate::estimate_document;
pub(crate) use parts::{Object, SCHEMA, to_line};
pub(crate) use program::program_document;
pub(crate) use simulation::simulation_document;
pub(crate) use solution::{SolverSettings, solution_document, struck_after_the_end};
