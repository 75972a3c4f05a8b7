//! The final times that programs look at: a trust region around the guess, which is moved where a plan presses against
//! one of its ends.

use crate::ocp::problem::{Horizon, Problem};

/// Shortest and longest final time of a program where it is free, relative to the guess.
const RANGE: (f64, f64) = (0.05, 20.0);
/// Share of an end within which a final time lies at it: one that is nearer by chance costs a second look.
const AT_THE_END: f64 = 0.02;

/// A range of final times \[s\]; a point where the final time is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::ocp) struct FinalTimes {
    pub(in crate::ocp) shortest: f64,
    pub(in crate::ocp) longest: f64,
}

impl FinalTimes {
    /// Those that the programs of a problem look at, started at a guess.
    pub(in crate::ocp) fn around(problem: &Problem, guess: f64) -> Self {
        match problem.horizon {
            Horizon::Fixed(horizon) => Self {
                shortest: horizon,
                longest: horizon,
            },
            Horizon::Free { .. } => Self {
                shortest: RANGE.0 * guess,
                longest: RANGE.1 * guess,
            },
        }
    }

    /// The end at which a final time lies, if it does.
    pub(in crate::ocp) fn end_at(self, time: f64) -> Option<f64> {
        if self.shortest == self.longest {
            None
        } else if time <= (1.0 + AT_THE_END) * self.shortest {
            Some(self.shortest)
        } else if time >= (1.0 - AT_THE_END) * self.longest {
            Some(self.longest)
        } else {
            None
        }
    }

    /// The range from the shorter to the longer times of both.
    pub(in crate::ocp) fn with(self, other: Self) -> Self {
        Self {
            shortest: self.shortest.min(other.shortest),
            longest: self.longest.max(other.longest),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn final_time_at_an_end_of_its_range_is_found_there_and_nowhere_else() {
        let range = FinalTimes {
            shortest: 0.1,
            longest: 40.0,
        };
        for (time, end) in [
            (0.1, Some(0.1)),
            (0.1 + 1e-9, Some(0.1)),
            (0.11, None),
            (2.0, None),
            (38.0, None),
            (40.0 - 1e-6, Some(40.0)),
            (f64::NAN, None),
        ] {
            assert_eq!(range.end_at(time), end, "{time}");
        }
        let given = FinalTimes {
            shortest: 2.0,
            longest: 2.0,
        };
        assert_eq!(given.end_at(2.0), None);
        let both = range.with(FinalTimes {
            shortest: 2.0,
            longest: 800.0,
        });
        assert_eq!((both.shortest, both.longest), (0.1, 800.0));
    }
}
