//! Motions to start a search from: made from model and problem alone, or from the time-freezing system.
//!
//! Uses [`collocation`](super::collocation) for what stays the same over all programs on a grid, and the layers below
//! that; each motion comes with the contact sequence that it suggests.

mod declared;
pub(in crate::ocp) mod guess;
mod spans;
pub(in crate::ocp) mod start_modes;
pub(in crate::ocp) mod time_freezing;
pub(in crate::ocp) mod time_freezing_search;
