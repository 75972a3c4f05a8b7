//! Optimal control against closed forms and brute force.

mod brute_force;
mod declared;
mod dry_friction;
mod explicit_time;
mod final_impact;
mod final_time;
mod friction;
mod linear_controls;
mod refinement;
mod scaling;
mod sizes;
mod support;
