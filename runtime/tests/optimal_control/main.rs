//! Optimal control against closed forms and brute force.

mod aligned;
mod brute_force;
mod complementarity_method;
mod declared;
mod final_impact;
mod final_time;
#[path = "../../../solver/benches/homotopy.rs"]
mod homotopy;
mod impact_times;
mod impacts_at_nodes;
mod not_finite;
mod orders;
mod polish;
mod refinement;
#[path = "../shared/root.rs"]
mod root;
mod scaling;
mod scene_scale;
mod sizes;
mod support;
mod swings;
mod throws;
mod vanishing_objective;
mod words;
