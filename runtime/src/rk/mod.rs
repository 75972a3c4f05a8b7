//! Implicit Runge-Kutta schemes by collocation.
//!
//! A scheme with nodes `c_1 < ... < c_s` integrates `x' = f(t, x)` over a step of length `h` by
//!
//! ```text
//! X_i = x_0 + h sum_j a_ij f(t_0 + c_j h, X_j)        x_1 = x_0 + h sum_j b_j f(t_0 + c_j h, X_j)
//! ```
//!
//! with `a_ij = int_0^{c_i} l_j`, `b_j = int_0^1 l_j` and the Lagrange polynomials `l_j` of the nodes.

mod butcher_tableau;
mod nodes;

pub(crate) use butcher_tableau::ButcherTableau;
pub use butcher_tableau::Scheme;
