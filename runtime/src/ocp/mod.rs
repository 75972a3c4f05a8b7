//! Optimal control of mechanical systems with impacts.
//!
//! A [`Problem`] asks for controls, constant or linear on intervals of equal physical length, that take a
//! [`Model`](crate::model::Model) to its goals at least cost. [`solve`] goes through phases, each of which
//! starts where the one before it ended:
//!
//! ```text
//! sources        simulated motions under random controls and policies, a time-freezing program: words, orders of contact modes
//! words          the program of a word has a phase of free length for each mode; goals may be missed at a price
//! edits          solved words are made into others where they press, best first
//! places         the best words on the grid: each switch in one of the intervals, or at an end of one
//! collocation    Radau IIA of order 7 between the switches, exit conditions, impact maps, bounds at all times
//! repair         neighbouring sequences that the solution presses towards, while they improve it
//! re-simulation  event-driven, under the final controls; its distance from the plan is part of the result
//! ```
//!
//! A contact without friction is open or closed; one with Coulomb friction is open, sticks, or slips forward or
//! backward, and the sequence holds the changes between these as well. Of a surface with an outer edge it holds the piece
//! that acts, and where the motion passes from one to another.
//!
//! A relaxed complementarity problem is never reported as a result. What comes out is a local
//! optimum; [`Stationarity`] says what is proved about its contact sequence.
//!
//! # Units
//! A scene may be written in any units. The solver sees every control, time and contact force divided by its own size,
//! and every coordinate, gap and objective divided by the power of a thousand (of a million for the objective) nearest
//! to its size, so that its tolerance means the same for a scene in millimetres and kilonewtons as in metres and
//! newtons. Path constraints are not measured, terminal conditions only where they are far smaller: state those in numbers of the order of one. What
//! stays in the units of the scene is what belongs to it: [`Settings::gap_margin`] and [`Settings::largest_distance`], but in motions that
//! are far smaller or far larger than those units, as the goals say, or else the motion itself.
//!
//! # Time
//! A model may depend on the time itself (`t` in forces, surfaces or costs). Where the final time is free, the time of
//! every stage is then an unknown that moves with it.
//!
//! # Layers
//! Each folder uses those below it, and the data that the caller sees; `effort` says how thoroughly each searches:
//!
//! ```text
//! solve        the order of work: words, places, one grid
//! judge        re-simulation of a plan, and finer grids where it does not agree
//! words        orders of contact modes with phases of free length
//! search       simulated motions; contact sequences on a grid: attempts, neighbours, repair
//! global       motions to start from: guesses, time-freezing programs
//! collocation  the program of high order with a given contact sequence
//! program      sparse programs of model functions, their units, and the door to the solvers
//! motion       trajectories, controls, contact modes and sequences
//! ```
//!
//! # Examples
//! Least final time of a cart that is pushed from rest to 1 m and has no bound on its speed: it accelerates all the
//! way, `t = sqrt(2 m / u)`.
//!
//! ```
//! use hangtime::ocp::{self, Problem, Settings};
//!
//! hangtime::model! {
//!     /// A cart that is pushed.
//!     pub Cart {
//!         parameters { m: kg = 2 }
//!         coordinates { y: m }
//!         controls { u: N in -1..=1 }
//!         lagrangian m/2*dot(y)^2
//!         forces { y: u }
//!         minimize time
//!         finally { y == 1[m] }
//!     }
//! }
//!
//! let cart = Cart::default();
//! let solution = ocp::solve(&cart, &Problem::of(&cart, 4), &Settings::default(), &mut |_| true)?;
//! assert!(solution.status.is_solved());
//! assert!((solution.horizon - 2.0).abs() < 1e-6);
//! # Ok::<(), hangtime::simulation::InputError>(())
//! ```

mod collocation;
mod effort;
mod global;
mod joined;
mod judge;
mod misses;
mod motion;
mod parameters;
mod previous;
mod problem;
mod program;
mod progress;
mod rules;
mod scale;
mod search;
mod settings;
mod size;
mod solution;
mod solve;
mod struck;
mod summary;
mod tuning;
mod unknown;
mod words;

pub use global::time_freezing::TimeFreezing;
pub use hangtime_solver::mpcc::Stationarity;
pub use misses::{Miss, Nearest};
pub use motion::control_grid::ControlShape;
pub use parameters::{FoundParameter, OptimumGradient, OptimumSides};
pub use previous::Previous;
pub use problem::{CompletedStart, Horizon, Problem};
pub use rules::{RULES, Rule, RulePart};
pub use settings::{ControlNodes, Formulation, Guess, Settings, TimeFreezingSettings};
pub use size::program_size;
pub use solution::{
    Counts, Excess, Improvement, Margin, Optimum, RelaxedReport, Solution, Source, Status,
    TimeFreezingReport, WordCounts,
};
pub use solve::solve;
pub use unknown::parameter_named;
