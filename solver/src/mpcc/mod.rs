//! Mathematical programs with complementarity constraints, in vertical form.
//!
//! ```text
//!     min f(x)  s.t.  c_l <= c(x) <= c_u,  x_l <= x <= x_u,  0 <= x_i  _|_  x_j >= 0  for all pairs
//! ```
//!
//! # Method
//! One warm interior point run relaxes every pair (Scholtes, SIAM Journal on Optimization 11, 2001),
//!
//! ```text
//!     x_i x_j <= sigma,
//! ```
//!
//! and drives `sigma` to zero together with the barrier parameter `mu`; how, a [`RelaxationRule`] says. The product
//! keeps its slack `s` and multiplier `r` to itself: eliminated from the Newton system, a pair adds the block
//! `[0, r; r, 0] + (r/s) [x_j^2, x_i x_j; x_i x_j, x_i^2]`. Other rules take over where one fails:
//!
//! ```text
//!     RollOff        sigma = mu^2 / (mu^2 + 1e-6)
//!     Elastic        min f + s / sigma,  x_i x_j <= s,  s >= 0,  sigma = 1, 0.1, ... until s vanishes
//!     Continuation   sigma in steps whose length follows the iterations of the last one
//!     Proportional   sigma = 10 mu
//! ```
//!
//! At `sigma = 1e-5` a *crossover* fixes one side of each pair at zero, the smaller one or those that
//! [`Mpcc::vanishing_sides`] says, and with it all that linear rows then force to zero, and solves the remaining
//! smooth program to full accuracy: `min(x_i, x_j) = 0` exactly. If that fails, the run goes on to the final `sigma`
//! and crosses over from there; since it often ends at a poor local solution then, the next rule is asked too
//! and the better of the two points counts. A point is exact if no row is violated by
//! more than 1e-9 and its optimality error is within tolerance, relative to the multipliers only where these exceed 100.
//!
//! A *certificate* follows. With the multipliers `nu_i`, `nu_j` of a pair with `x_i = x_j = 0` the point is strongly
//! stationary if both are nonnegative; else branch and bound over the sides of these pairs looks for a descent
//! direction of the linear program with complementarity constraints
//!
//! ```text
//!     min grad f'd  s.t.  c_l <= c + r J d <= c_u,  x_l <= x + r d <= x_u,  0 <= x_i + r d_i  _|_  x_j + r d_j >= 0,  |d|_inf <= 1
//! ```
//!
//! with a small radius `r`: bounds count with their distances, so that none has to be called active. The same program is asked
//! where multipliers hold nothing: of the wrong sign, or of rows away from their bounds, by `|y|` times the distance; a variable that measures
//! such a row moves in units of its own size there. A side with a zero
//! multiplier ends at `sqrt(mu)`, not at zero. Which of the small sides vanish a Newton step to the end of the central path tells,
//! `mu = 0`: one with a positive multiplier goes all its distance, one without half of it, one that is positive stays. Where the
//! verdict hangs on a pair with such a side, the program with both sides at zero decides.
//!
//! None means B-stationary: certified. A direction leads to another choice of sides and a lower point. Last, the
//! certified point of many pairs is relaxed again, and what is lower goes on: a *second opinion*.
//!
//! Where no rule ends at a certified point, a *second round* crosses over with many more iterations from where they ended: from
//! these ends first, then from exact points near these that are found without the objective. Its programs often have no multipliers (vanishing elements,
//! equations that determine a point twice); their runs end where nothing moves any more, and the linear programs of the
//! certificate, whose dual solutions prove that there is no descent, give the multipliers.
//!
//! Sides whose partners linear rows and bounds keep above zero vanish at every exact point, which a relaxed program knows only as far as
//! its products do. Where there are such sides and six tenths of the iterations have not led to a certified point, the first two rules and the
//! second round follow once more with these sides fixed at zero: the path is another one.
//!
//! Where the first rule ends in a stationary point of the violation, its start may be to blame: the objective led there before rows and
//! bounds held. The nearest point at which they hold, whatever the pairs do, is looked for without the objective; from the first point on the
//! way there that keeps them all of the above begins anew, and goes on from the own start only if that leads nowhere.
//!
//! # How a solve ends
//! Every end has a [`Status`]. *Infeasible* is said of a problem only where runs converged to stationary points of the
//! violation, with the rows and pairs that are to blame; runs that end otherwise, by a limit among them, have *failed*, and
//! say why. Iterations, seconds and the observer are those of the whole solve, crossovers and certificates included.

mod branch;
mod branch_and_cut;
mod certificate;
mod crossover;
mod decided;
mod elastic;
mod finish;
mod forced;
mod linear_program;
mod moved;
mod parts;
mod problem;
mod ray;
mod relaxation;
mod reprise;
mod run;
mod second_round;
mod sensitivity;
mod settings;
mod sides;
mod solution;
mod solve;
mod stationarity;
mod watch;

pub use crate::nlp::Residuals;
pub use certificate::{Certificate, StationarityType};
pub use problem::Mpcc;
pub use sensitivity::{Moved, RangeEnd, RangeLimit, moved};
pub use settings::{RelaxationRule, Settings};
pub use solution::{Solution, Status};
pub use solve::{solve, solve_observed};
pub use stationarity::Stationarity;

pub(crate) use ray::falls_along_a_ray;
