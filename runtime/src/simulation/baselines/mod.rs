//! Methods that exist to be compared with: none of them locates events, so that each shows what that is worth.
//!
//! - [`FixedStep`]: Runge-Kutta steps of fixed length that see impacts and switches at their ends only, of first order through them.
//! - [`Moreau`]: Moreau-Jean time stepping, with impulses over fixed steps.
//! - [`Smooth`]: contacts as smoothed step functions of numerical time, whose width is the error.
//!
//! They take scenes and give results as all methods do: `simulate(&scene).method(Moreau::default())`.
//!
//! A folder of the simulators and no package of its own: they run on the dynamics, the law of contacts and the judgement of grids of
//! [`simulation`](crate::simulation), none of which is public.

mod fixed;
mod moreau;
mod smooth;

pub use fixed::FixedStep;
pub use moreau::Moreau;
pub use smooth::Smooth;
