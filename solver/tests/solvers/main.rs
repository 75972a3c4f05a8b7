//! The interior point method, and the complementarity method.

#[path = "../../benches/homotopy.rs"]
mod homotopy;
mod mpcc_certificates;
mod mpcc_limits;
mod mpcc_problems;
mod nl_certificates;
mod nl_files;
mod nl_texts;
mod nl_unbounded;
mod nlp_hock_schittkowski;
mod nlp_interrupt;
mod nlp_second_round;
mod nlp_special;
#[path = "../solver_support/mod.rs"]
mod solver_support;
