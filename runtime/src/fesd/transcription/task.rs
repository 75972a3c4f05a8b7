//! What is transcribed: an initial value or optimal control problem in plain numbers.

use crate::fesd::finite_element::State;

/// A motion over equal control intervals: where it starts, how long it lasts, what is free and what is
/// minimized.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    pub(crate) start: State,
    /// Length \[s\], or a guess of it.
    pub(crate) horizon: f64,
    /// Bounds of the length \[s\], if it is free.
    pub(crate) horizon_bounds: Option<(f64, f64)>,
    pub(crate) controls: Controls,
    /// Control intervals of equal physical length.
    pub(crate) intervals: usize,
    /// Finite elements of each interval.
    pub(crate) elements: usize,
    /// Bounds of the coordinates at the ends of the elements.
    pub(crate) coordinate_bounds: (Vec<f64>, Vec<f64>),
    /// Values at the end, by index in `(q, v)`.
    pub(crate) goals: Vec<(usize, f64)>,
    pub(crate) objective: Weights,
    pub(crate) guess: Guess,
}

/// Controls of all intervals.
#[derive(Debug, Clone)]
pub(crate) enum Controls {
    /// Given, the same everywhere.
    Fixed(Vec<f64>),
    /// Unknown, constant on each interval.
    Free {
        lower: Vec<f64>,
        upper: Vec<f64>,
        guess: Vec<f64>,
    },
}

/// Where the solver starts.
#[derive(Debug, Clone)]
pub(crate) enum Guess {
    /// Motion at this velocity, with every step function undecided.
    Line(Vec<f64>),
    /// A coarse explicit simulation of the time-freezing system under the guessed controls.
    Simulated,
}

/// Weights of the objective.
#[derive(Debug, Clone, Default)]
pub(crate) struct Weights {
    /// Of the final time.
    pub(crate) final_time: f64,
    /// Of `int u'u dt`.
    pub(crate) control_effort: f64,
    /// Of components of `(q, v)` at the end, by index.
    pub(crate) final_state: Vec<(usize, f64)>,
}

impl Task {
    /// A motion of length `duration` \[s\] from `start` under constant controls.
    pub(crate) fn step(start: &State, u: &[f64], duration: f64, elements: usize) -> Self {
        let n = start.q.len();
        Self {
            start: start.clone(),
            horizon: duration,
            horizon_bounds: None,
            controls: Controls::Fixed(u.to_vec()),
            intervals: 1,
            elements,
            coordinate_bounds: (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]),
            goals: Vec::new(),
            objective: Weights::default(),
            guess: Guess::Simulated,
        }
    }
}

impl Controls {
    /// Value, or guess of it.
    pub(crate) fn values(&self) -> &[f64] {
        match self {
            Self::Fixed(values) | Self::Free { guess: values, .. } => values,
        }
    }

    /// Sizes that make the unknowns of the order of one.
    pub(crate) fn units(&self) -> Vec<f64> {
        match self {
            Self::Fixed(values) => vec![1.0; values.len()],
            Self::Free { lower, upper, .. } => lower
                .iter()
                .zip(upper)
                .map(|(lower, upper)| lower.abs().max(upper.abs()))
                .map(|unit| {
                    if unit.is_finite() && unit > 0.0 {
                        unit
                    } else {
                        1.0
                    }
                })
                .collect(),
        }
    }
}
