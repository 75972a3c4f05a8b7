//! What is transcribed beside the variables that a program begins with.

/// The variables that a program begins with.
#[derive(Debug, Clone)]
pub(crate) struct Outer {
    /// The length of the motion \[s\].
    pub(crate) horizon: usize,
    /// Controls of each interval, or at each node where they are linear in between.
    pub(crate) controls: Vec<Vec<usize>>,
    /// `(q, v)` at the start.
    pub(crate) start: Vec<usize>,
}

/// A grid of equal control intervals, and where the solver starts.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    /// Time at the start \[s\].
    pub(crate) time: f64,
    /// Whether controls are linear between nodes.
    pub(crate) linear: bool,
    /// Control intervals of equal physical length.
    pub(crate) intervals: usize,
    /// Finite elements of each interval.
    pub(crate) elements: usize,
    /// Bounds of the coordinates at the ends of the elements.
    pub(crate) coordinate_bounds: (Vec<f64>, Vec<f64>),
    pub(crate) guess: Guess,
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
    /// Conditions that come true where it begins.
    pub(crate) sets: Vec<usize>,
    /// `(q, v, t, G, D)` and then the shares of the groups, at equal steps.
    pub(crate) points: Vec<Vec<f64>>,
}
