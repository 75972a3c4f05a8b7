//! Derivatives of a motion by parameters, initial values and controls, forwards and backwards.
//!
//! The *word* of a motion, its order of contact modes with the times of its events, is known from a run. Between events the motion is smooth,
//! and its derivatives solve the variational equations, stated by collocation and factorized once (`step`, with the acceleration of a
//! contact mode and all its derivatives from `mode`). An event moves with what the motion is differentiated by
//! (`event`), and with it the instant at which one mode follows the other. With the derivative `tau'` of its time, rates `f-`
//! and `f+` of everything before and after, and the derivative `J` of what happens there (`jump`, `reset`),
//!
//! ```text
//! S+ = J (S- + f- tau') - f+ tau'
//! ```
//!
//! Source: Aizerman, Gantmacher, *On the stability of periodic motions* (J. Appl. Math. Mech. 22, 1958). A tangent `S` has a row for
//! everything that anything depends on: state, controls, time, parameters, impulses and costs. So each function of the scene has one product, an
//! event is one matrix, and the same factors give columns forwards and rows backwards (`adjoint`).
//!
//! By which quantities there are derivatives is a question of its own (`existence`): margins that vanish, and events that happen at once
//! and come apart. Events whose two orders lead to the same derivatives have them. Where there are none, neighbours tell those to each side
//! (`neighbours`). `ranges` says how far a word stays.

mod adjoint;
mod cost;
mod crossing;
mod event;
mod existence;
mod gradient;
mod joint_rows;
mod jump;
mod margins;
mod mode;
mod neighbours;
mod outputs;
mod place;
mod projection;
mod quantities;
mod ranges;
mod reset;
mod samples;
mod sides;
mod start;
mod step;
mod tangent;
mod tape;
mod walk;

pub use gradient::{Gradient, GradientMode, differentiate, differentiate_values};
pub(crate) use gradient::{Observed, observe};
pub use neighbours::{Simulate as SimulateNeighbour, add_one_sided};
pub use ranges::{SequenceLimit, SequenceRange};
pub use sides::{OneSided, Side};
pub(crate) use start::{completed, differences};
