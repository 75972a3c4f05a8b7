//! Methods to compare with, which [`baselines`](crate::baselines) shows.
//!
//! A folder of the simulators and no package of its own: they run on the dynamics, the joints and the judgement of grids of
//! [`simulation`](crate::simulation), none of which is public.

mod fixed;
mod moreau;
mod shared;
mod smooth;

pub use fixed::FixedStep;
pub use moreau::Moreau;
pub use smooth::Smooth;
