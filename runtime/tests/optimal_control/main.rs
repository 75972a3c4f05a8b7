//! Optimal control against closed forms and brute force.

mod brute_force;
mod complementarity_method;
mod final_time;
#[path = "../../../solver/benches/homotopy.rs"]
mod homotopy;
mod orders;
mod refinement;
mod scaling;
mod scene_scale;
mod sizes;
mod support;
mod vanishing_objective;
