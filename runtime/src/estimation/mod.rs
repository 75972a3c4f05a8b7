//! Estimation: parameters by which the motions of a scene are most like measured ones.
//!
//! A scene declares what was measured, and compares with it:
//!
//! ```text
//! free e in 0..=1 = 0.5
//! measured flight: "throw.csv" { z within 1 [cm] }
//! minimize misfit(flight)
//! ```
//!
//! Each experiment is a motion of its own, with the free parameters that all share; its residuals `(z(t_k) - z_k)/within` are
//! continuous functions of these, whatever the order of impacts, and their derivatives are those of the motion
//! ([`differentiate`](crate::derivative::differentiate)).
//!
//! `measurements` is the data, `motions` the residuals of all experiments, `least_squares` the method (with the singular values of
//! `svd`), `covariance` how well the parameters are known, `result` what is found, and `solve` the order of work.

mod covariance;
mod least_squares;
mod measurements;
mod motions;
mod result;
mod solve;
mod svd;

pub use measurements::Measurements;
pub use result::{Direction, Estimate, EstimatedParameter, FittedExperiment, LocalFit, Status};
pub use solve::{Settings, estimate};
