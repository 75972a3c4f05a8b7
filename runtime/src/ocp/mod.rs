mod collocation;
mod contact_implicit;
mod cuts;
mod kernel;
mod path;
mod problem;
mod program;
mod repair;
mod sequence;
mod settings;
mod solution;
mod solve;
mod time_freezing;

pub use problem::{Component, Goal, Horizon, Objective, Problem};
pub use settings::Settings;
pub use solution::{Counts, Size, Solution, Stationarity, Status};
pub use solve::{Progress, solve};
pub use time_freezing::{TimeFreezing, TimeFreezingMotion, TimeFreezingSettings};
