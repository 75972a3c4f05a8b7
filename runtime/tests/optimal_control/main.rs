//! Optimal control against closed forms and brute force.

mod aligned;
mod brute_force;
mod complementarity_method;
mod declared;
mod dry_friction;
mod edges;
mod explicit_time;
mod final_impact;
mod final_time;
mod forces;
mod friction;
mod grip;
#[path = "../../../solver/benches/homotopy.rs"]
mod homotopy;
mod impact_times;
mod impacts_at_nodes;
mod landings;
mod linear_controls;
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
mod waiting;
mod words;
