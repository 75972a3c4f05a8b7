//! Linear algebra, the interior point method, and the complementarity method.

mod linalg_chain;
mod linalg_conformance;
mod mpcc_finite_elements;
mod mpcc_limits;
mod mpcc_problems;
mod nlp_elements;
mod nlp_hock_schittkowski;
mod nlp_special;
mod nlp_strategies;
#[path = "../solver_support/mod.rs"]
mod solver_support;
