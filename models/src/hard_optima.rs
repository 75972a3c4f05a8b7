//! Problems of optimal control on which methods fail, each in one respect, and what is right there.

use hangtime_cli::{HardOptimum, RightOptimum};

/// The problem of a file, which says why, and what is right.
macro_rules! hard {
    ($name:literal, $right:expr) => {
        HardOptimum {
            name: $name,
            text: include_str!(concat!("../hard_optima/", $name, ".hang")),
            right: $right,
        }
    };
}

/// Goals beyond what bounded controls do in the given time, which is shown.
const INFEASIBLE: RightOptimum = RightOptimum::None(&["infeasible"]);
/// Goals out of reach where contacts have a say, of which nothing is shown.
const OUT_OF_REACH: RightOptimum = RightOptimum::None(&["infeasible", "not_found"]);

/// All of them, by name. `hangtime chart --stability` shows what ways of optimal control make of them.
#[must_use]
pub fn hard_optima() -> &'static [HardOptimum] {
    &PROBLEMS
}

static PROBLEMS: [HardOptimum; 14] = [
    hard!("barely-reached", RightOptimum::Least(1.0)),
    hard!("behind-the-wall", OUT_OF_REACH),
    hard!(
        "elastic-ground",
        RightOptimum::Least(2.0 * std::f64::consts::SQRT_2)
    ),
    hard!("grazing-goal", RightOptimum::Least(0.0)),
    hard!("hard-landing", RightOptimum::Least(2.0)),
    hard!("held-by-friction", OUT_OF_REACH),
    hard!("inside-the-ground", OUT_OF_REACH),
    hard!("just-too-far", INFEASIBLE),
    hard!(
        "nearly-too-far", // The two intervals in the middle, of length h = 1/12, lose 1e-6/h^2 of their force.
        RightOptimum::Least(1.0 - (1.0 - (1.0 - 1.44e-4) * (1.0 - 1.44e-4)) / 6.0)
    ),
    hard!("negative-root", RightOptimum::None(&["refused"])),
    hard!("slide-and-stop", RightOptimum::Least(4.0)),
    hard!("too-far", INFEASIBLE),
    hard!("turn-at-the-wall", RightOptimum::Least(0.0)),
    hard!("without-bound", RightOptimum::None(&["unbounded"])),
];
