//! Bounds of functions along a motion: what is not in them is not missed.
//!
//! `range` is interval arithmetic, `bounds` evaluates explicit functions of a model with it, `path` is the motion over a step and
//! `along` the functions on it, `calm` where none of them hides anything,
//! `interpolant` a function that is known by its values alone. `crossing` finds the first place where a
//! function with bounds falls through zero, `root` the zero there, and that of a function which costs a step a value; `watched` says which
//! functions are looked at, and which of them falls first.

mod along;
mod bounds;
mod calm;
mod crossing;
mod interpolant;
mod path;
mod range;
mod root;
mod watched;

pub(crate) use along::Along;
pub(crate) use bounds::Bounds;
pub(crate) use calm::{calm_parts, hide};
pub(crate) use crossing::Sample;
pub(crate) use range::Range;
pub(crate) use root::{Bracket, positive_before, refine, root};
pub(crate) use watched::{Fall, Form, Interpolated, Suspect, Watched, earliest_fall};
