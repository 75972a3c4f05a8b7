//! What happens to a motion at an instant, once for every method that comes to one.
//!
//! A method tells by an [`Instant`] where its motion is, what counts as zero there and how it solves the law of impacts; the rest is the same
//! question whichever integrator asks it: which conditions come true (`resets`), what is struck and how it bounces (`impact`), which
//! sides of switches act (`sides`), how long they hold a motion at rest (`rest`), and what a user should know of all that (`remarks`).

mod ahead;
pub(crate) mod impact;
mod instant;
mod place;
pub(crate) mod remarks;
pub(crate) mod resets;
pub(crate) mod rest;
pub(crate) mod sides;
mod turns;

pub(crate) use instant::{Bounce, Instant};
pub(crate) use place::Place;
