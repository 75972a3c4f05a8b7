//! Problems that are sums of small functions, with derivatives by dual numbers.
//!
//! Objective and rows of a large sparse program are nearly always sums of linear terms and of functions of few
//! variables (partial separability, Griewank and Toint 1982):
//!
//! ```text
//!     f(x)   = b_0 + a_0' x + sum_k c_0k e_k(x_k),        c_i(x) = b_i + a_i' x + sum_k c_ik e_k(x_k),
//! ```
//!
//! where `x_k` are the `N` variables of element `k`. An element is written once, generic over the number type, and
//! compiled three times: for `f64`, for dual numbers (gradient of its `M` values in one pass) and for second-order
//! dual numbers (Hessian of their weighted sum). Each pass costs `O(N)` or `O(N^2)` operations for each operation of
//! the element, so elements should have few variables, and linear terms should be given as such: they cost
//! nothing but one multiplication. One value may feed several rows, as the right-hand side of a differential
//! equation feeds the two intervals beside its node; it is then evaluated and differentiated once.

mod builder;
mod group;
mod problem;
mod statement;
mod target;

pub use builder::ElementProblemBuilder;
pub use problem::ElementProblem;
pub use target::Target;

use num_dual::DualNum;

/// `M` smooth functions of the same `N` variables.
///
/// Parameters are fields of the implementing type. Second derivatives are taken as dense: every pair of the `N`
/// variables becomes a position of the Hessian.
///
/// # Examples
/// The value and the square of `p sin(x y)`:
///
/// ```
/// use hangtime_solver::nlp::{DualNum, Element};
///
/// struct Wave {
///     p: f64,
/// }
///
/// impl Element<2, 2> for Wave {
///     fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x, y]: &[D; 2]) -> [D; 2] {
///         let wave = (*x * *y).sin() * self.p;
///         [wave, wave * wave]
///     }
/// }
///
/// assert_eq!(Wave { p: 2.0 }.evaluate(&[0.0, 1.0]), [0.0, 0.0]);
/// ```
pub trait Element<const N: usize, const M: usize>: 'static {
    /// The values at `x`.
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, x: &[D; N]) -> [D; M];
}
