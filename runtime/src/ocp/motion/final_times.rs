//! The final times that programs look at: a trust region around the guess, which is moved where a plan presses against
//! one of its ends.

use super::targets::goal_values;
use crate::model::Model;
use crate::ocp::problem::{Horizon, Problem};

/// Shortest and longest final time of a program where it is free, relative to the guess.
const RANGE: (f64, f64) = (0.05, 20.0);
/// Share of an end within which a final time lies at it: one that is nearer by chance costs a second look.
const AT_THE_END: f64 = 0.02;
/// Halvings of a range by which the end of the times that a goal allows is found.
const HALVINGS: usize = 60;

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

    /// What goals that read nothing but the final time leave of the range; all of it where they leave nothing.
    pub(in crate::ocp) fn allowed(self, model: &dyn Model) -> Self {
        let time = 2 * model.declaration().coordinates.len();
        let Some(declared) = model.declaration().optimal_control else {
            return self;
        };
        let first = usize::from(declared.final_cost);
        let entries = declared.terminal_jacobian.entries;
        let reads_time_alone = |goal: usize| {
            let own = || entries.iter().filter(|e| e.0 as usize == first + goal);
            own().count() == 1 && own().all(|e| e.1 as usize == time)
        };
        // Values at other states are the same.
        let value = |goal: usize, t: f64| {
            let mut z = vec![0.0; time + 1];
            z[time] = t;
            goal_values(model, &z)[goal]
        };
        let goals = (0..declared.goals.len()).filter(|&goal| reads_time_alone(goal));
        goals.fold(self, |range, goal| {
            let missing = |t: f64| value(goal, t);
            let (first, last) = (missing(range.shortest), missing(range.longest));
            if first * last < 0.0 {
                let root = change(range.shortest, range.longest, |t| missing(t) * first > 0.0);
                Self {
                    shortest: root,
                    longest: root,
                }
            } else if first == 0.0 && last < 0.0 {
                let longest = change(range.shortest, range.longest, |t| missing(t) == 0.0);
                Self { longest, ..range }
            } else if first < 0.0 && last == 0.0 {
                let shortest = change(range.longest, range.shortest, |t| missing(t) == 0.0);
                Self { shortest, ..range }
            } else {
                range
            }
        })
    }

    /// The range from the shorter to the longer times of both.
    pub(in crate::ocp) fn with(self, other: Self) -> Self {
        Self {
            shortest: self.shortest.min(other.shortest),
            longest: self.longest.max(other.longest),
        }
    }
}

/// Where what is true at `inside` ends on the way to `outside`.
fn change(mut inside: f64, mut outside: f64, is_true: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (inside + outside);
        if is_true(middle) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    inside
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
