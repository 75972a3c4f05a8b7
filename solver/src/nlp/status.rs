//! Why a run ended.

/// Why a run ended. Only [`Status::Solved`] means that the point satisfies the tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Status {
    /// The optimality error is within `tolerance`.
    Solved,
    /// The error stayed within `acceptable_tolerance` but did not reach `tolerance`.
    Acceptable,
    /// The error is within `tolerance` only relative to multipliers so large (beyond 1e4 on average), or with
    /// multipliers so large (beyond 1e8), that any residual would pass, or the run gave up at a feasible point with such
    /// multipliers: none seem to exist, a constraint qualification fails, and the point may lie much farther from a
    /// solution than the tolerance says.
    Degenerate,
    /// A stationary point of the constraint violation that is not feasible: the constraints are
    /// infeasible near it. The diagnosis names the rows. Where rows are not linear, other starts found no feasible point either.
    Infeasible,
    /// The iterates grew beyond 1e20, or the objective fell on and on beyond 1e12, at points that violate no row by more than
    /// rounding: the objective is probably unbounded below.
    Diverging,
    /// The iteration limit was reached.
    IterationLimit,
    /// The time limit was reached.
    TimeLimit,
    /// The steps fell below the resolution of the numbers before the tolerance was reached.
    StepTooSmall,
    /// Neither the line search nor the restoration phase finds an acceptable point.
    RestorationFailed,
    /// A derivative at an accepted point is not a finite number.
    NotFinite,
    /// No shift of the Newton matrix gives usable factors.
    FactorizationFailed,
    /// The observer asked to stop.
    Interrupted,
}

impl Status {
    /// Whether the point satisfies the tolerances.
    pub fn is_solved(self) -> bool {
        self == Self::Solved
    }
}

impl std::fmt::Display for Status {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Solved => "solved",
            Self::Acceptable => "solved to the acceptable tolerance only",
            Self::Degenerate => "no multipliers were found: those of the iterates diverge, as they do where a constraint qualification fails",
            Self::Infeasible => "converged to a point of local infeasibility",
            Self::Diverging => "iterates diverge, the problem is probably unbounded",
            Self::IterationLimit => "iteration limit reached",
            Self::TimeLimit => "time limit reached",
            Self::StepTooSmall => "steps became too small",
            Self::RestorationFailed => "restoration failed",
            Self::NotFinite => "a derivative is not finite",
            Self::FactorizationFailed => "the newton matrix could not be factorized",
            Self::Interrupted => "stopped by the observer",
        })
    }
}
