//! What is transcribed: an initial value or optimal control problem in plain numbers.

use crate::fesd::finite_element::State;

/// A motion over equal control intervals: where it starts, how long it lasts, what is free and what is
/// minimized.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    pub(crate) start: State,
    /// Components of `(q, v)` that are free at the start, with their ranges.
    pub(crate) free_start: Vec<(usize, (f64, f64))>,
    /// Rows of positions and velocities of joints, `(g, w)`, that a free start has to fulfil: those that do not follow from each other.
    pub(crate) joints_at_start: Vec<usize>,
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
    /// Whether objective, path constraints and terminal conditions are those that the scene declares; else there are
    /// none.
    pub(crate) declared: bool,
    pub(crate) guess: Guess,
}

/// Controls of all intervals.
#[derive(Debug, Clone)]
pub(crate) enum Controls {
    /// Given, the same everywhere.
    Fixed(Vec<f64>),
    /// Unknown, constant on each interval, with a guess for each, or linear between nodes, with a guess for each of these.
    Free {
        lower: Vec<f64>,
        upper: Vec<f64>,
        guess: Vec<Vec<f64>>,
        linear: bool,
    },
}

/// Where the solver starts.
#[derive(Debug, Clone)]
pub(crate) enum Guess {
    /// `(q, v)` at equal steps of physical time over the whole motion, with every step function undecided.
    Motion(Vec<Vec<f64>>),
    /// A coarse explicit simulation of the time-freezing system under the guessed controls.
    Simulated,
    /// What happens in each interval, one span after the other and no more of them than elements.
    Known(Vec<Vec<Span>>),
}

/// A phase or a jump of a known motion, in numerical time.
#[derive(Debug, Clone)]
pub(crate) struct Span {
    /// Length in numerical time \[s\].
    pub(crate) length: f64,
    /// Whether the clock stands: velocities change along straight lines, so that one element is enough.
    pub(crate) jumps: bool,
    /// Which of the two weights of each group there are. Of a contact: `alpha` and `beta`, one in flight, the other in a jump and
    /// both in contact; of its friction: that against sliding forward and that against sliding backward, both where it sticks; of
    /// its restitution: fall and rise.
    pub(crate) weights: Vec<[bool; 2]>,
    /// `(q, v, t, G, D)` and then the shares of the groups, at equal steps.
    pub(crate) points: Vec<Vec<f64>>,
}

impl Task {
    /// A motion of length `duration` \[s\] from `start` under constant controls.
    pub(crate) fn step(start: &State, u: &[f64], duration: f64, elements: usize) -> Self {
        let n = start.q.len();
        Self {
            start: start.clone(),
            free_start: Vec::new(),
            joints_at_start: Vec::new(),
            horizon: duration,
            horizon_bounds: None,
            controls: Controls::Fixed(u.to_vec()),
            intervals: 1,
            elements,
            coordinate_bounds: (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]),
            declared: false,
            guess: Guess::Simulated,
        }
    }
}

impl Controls {
    /// Whether they are unknown and linear between nodes.
    pub(crate) fn are_linear(&self) -> bool {
        matches!(self, Self::Free { linear: true, .. })
    }

    /// Value, or guess of it, at that share of interval `k`.
    pub(crate) fn at(&self, k: usize, share: f64) -> Vec<f64> {
        let before = self.values(k);
        if !self.are_linear() {
            return before.to_vec();
        }
        let ends = before.iter().zip(self.values(k + 1));
        let between = |(before, after): (&f64, &f64)| before + share * (after - before);
        ends.map(between).collect()
    }

    /// Value on interval `k`, or at its start, or guess of it.
    pub(crate) fn values(&self, k: usize) -> &[f64] {
        match self {
            Self::Fixed(values) => values,
            Self::Free { guess, .. } => guess.get(k).map_or(&[], Vec::as_slice),
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
