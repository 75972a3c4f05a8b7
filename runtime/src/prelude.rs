//! What a program with a scene of its own needs: `use hangtime::prelude::*;`.

pub use crate::front::simulate::{Simulate, simulate};
pub use crate::front::solve::{Solve, solve};
pub use crate::model::Model;
pub use crate::ocp::{ControlShape, Formulation, Guess, Solution, Stationarity};
pub use crate::progress::Progress;
pub use crate::simulation::{
    ContactMode, ControlSignal, Direction, Event, EventDriven, EventKind, Fesd, InputError,
    Simulation, SimulationStatus, State, Trajectory,
};
