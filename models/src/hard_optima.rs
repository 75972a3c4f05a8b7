//! Problems of optimal control on which methods fail, each in one respect, and what is right there.

use hangtime_cli::{HardOptimum, RightOptimum};

/// The problem of a file, with what is right and why.
macro_rules! hard {
    ($name:literal, $right:expr, $why:literal) => {
        HardOptimum {
            name: $name,
            text: include_str!(concat!("../hard_optima/", $name, ".hang")),
            right: $right,
            why: $why,
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
    hard!(
        "barely-reached",
        RightOptimum::Least(1.0),
        "Half a second forwards and half a second backwards at full force is the only motion: 2 * (1/2)^2/2 = 1/4."
    ),
    hard!(
        "behind-the-wall",
        OUT_OF_REACH,
        "The wall stands between the cart and its goal."
    ),
    hard!(
        "elastic-ground",
        RightOptimum::Least(2.0 * std::f64::consts::SQRT_2),
        "A bounce costs time, so the lander arrives at rest: half of the way in free fall, half of it at full thrust, T = 2 sqrt(h/g)."
    ),
    hard!(
        "grazing-goal",
        RightOptimum::Least(0.0),
        "Without force the ball comes to the ceiling at rest: 2^2/(2 g) = 1, after 2/g = 1 s. The optimum is a graze."
    ),
    hard!(
        "hard-landing",
        RightOptimum::Least(2.0),
        "An inelastic impact is a state at rest: a free fall takes sqrt(2 h/g), and nothing is faster."
    ),
    hard!(
        "held-by-friction",
        OUT_OF_REACH,
        "The force of 0.9 N is less than the friction of mu m g = 1 N, so the block never moves."
    ),
    hard!(
        "inside-the-ground",
        OUT_OF_REACH,
        "The goal is below the floor."
    ),
    hard!(
        "just-too-far",
        INFEASIBLE,
        "The farthest goal is at 1/4 m; this one lies a micrometre behind it."
    ),
    hard!(
        "nearly-too-far",
        // The two intervals in the middle, of length h = 1/12, lose 1e-6/h^2 of their force.
        RightOptimum::Least(1.0 - (1.0 - (1.0 - 1.44e-4) * (1.0 - 1.44e-4)) / 6.0),
        "As `barely-reached`; the micrometre is spared where it costs least, on the two intervals beside the switch: each force is less by 1e-6/h^2."
    ),
    hard!(
        "negative-root",
        RightOptimum::None(&["refused"]),
        "The root of a negative number: the objective has no value at the start."
    ),
    hard!(
        "slide-and-stop",
        RightOptimum::Least(4.0),
        "Three seconds with (2 - 1) m/s^2 and one with -(2 + 1) m/s^2: 9/2 + 3/2 = 6. The friction helps to brake."
    ),
    hard!(
        "too-far",
        INFEASIBLE,
        "At full force the cart comes as far as 2 * (1/2)^2/2 = 1/4."
    ),
    hard!(
        "turn-at-the-wall",
        RightOptimum::Least(0.0),
        "Without force the wall sends the cart back as fast as it came, and it is home after 2 s."
    ),
    hard!(
        "without-bound",
        RightOptimum::None(&["unbounded"]),
        "A larger force is always faster: the least time is none, and no motion has it."
    ),
];
