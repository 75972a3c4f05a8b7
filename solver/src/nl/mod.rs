//! Programs from files: `.nl`, which AMPL, Pyomo and JuMP write, and `.sol`, which they read.
//!
//! A `.nl` file (Gay, Writing .nl files, 2005) states
//!
//! ```text
//!     min or max f(x)  s.t.  c_l <= c(x) <= c_u,  x_l <= x <= x_u,  and rows that complement variables,
//! ```
//!
//! with expressions in prefix notation whose common parts are named. [`Program`] holds them as one graph in which nothing is
//! stated twice, brings complementarity to the vertical form of [`mpcc`](crate::mpcc), and differentiates exactly: values in
//! one sweep forwards, gradients in one backwards, Hessians by pushing edges. Patterns and places are found once.
//!
//! A file is data. Whatever its bytes are, it gives a program or a message with the line; memory and time of reading are bounded
//! by its length and a limit on second derivatives.

mod answer;
mod error;
mod expression;
mod graph;
mod heading;
mod hessian;
mod jacobian;
mod operation;
mod program;
mod read;
mod second_order;
mod solution;
mod solve;
mod source;
mod statement;
mod tape;
mod vertical;

pub use answer::refusal_text;
pub use error::ReadError;
pub use program::Program;
pub use second_order::SecondOrder;
pub use solution::{Solution, Status, Work};
pub use solve::{Options, solve, solve_with};
