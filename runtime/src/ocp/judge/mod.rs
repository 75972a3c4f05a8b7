//! The judge of a plan: an event-driven simulation under its controls, which shares nothing with the programs but the
//! model's functions, and finer grids where the two do not agree.
//!
//! Uses [`search`](super::search) to attempt the same sequence again.

mod at_bounds;
pub(in crate::ocp) mod confirm;
mod dense;
mod disagreement;
mod follow;
mod forces;
pub(in crate::ocp) mod gradient;
pub(in crate::ocp) mod incumbent;
mod margins;
mod objective;
mod refine_grid;
