//! The functions of a contact mode whose zeros are events, as a piece of a motion bounds them.

use super::along::Along;
use super::crossing::{Bounded, Crossing, Sample, first_crossing};
use super::interpolant::Interpolant;
use super::range::Range;
use super::root::{positive_before, root};
use crate::model::Model;

/// A function of the contact mode.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Watched {
    /// The gap of a contact.
    Gap(usize),
    /// What is made of the sliding velocity of a contact.
    Sliding(usize, Form),
    /// One of the solution of the mode: a force, or what it lacks to a bound.
    Solved,
}

/// What is made of a sliding velocity.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Form {
    /// A multiple of it.
    Signed(f64),
    /// How far its size is below a number.
    Below(f64),
}

impl Form {
    fn range(self, sliding: Range) -> Range {
        match self {
            Self::Signed(sign) => sliding.scaled(sign),
            Self::Below(most) => Range::of(most) - sliding.size(),
        }
    }

    fn slope(self, slope: Range) -> Range {
        match self {
            Self::Signed(sign) => slope.scaled(sign),
            Self::Below(_) => slope.with(-slope),
        }
    }
}

impl Watched {
    /// Whether its operations are known.
    pub(crate) fn is_explicit(self, along: &Along<'_>) -> bool {
        match self {
            Self::Gap(i) => along.knows_gap(i),
            Self::Sliding(i, _) => along.knows_sliding(i),
            Self::Solved => false,
        }
    }

    /// A range of it over the whole piece, before its polynomials are known; all numbers where its operations are not.
    pub(crate) fn as_a_whole(self, along: &mut Along<'_>) -> Range {
        match self {
            Self::Gap(i) => along.gap_as_a_whole(i),
            Self::Sliding(i, form) => form.range(along.sliding_as_a_whole(i)),
            Self::Solved => Range::ALL,
        }
    }

    /// The first place between two at which it falls below `-zero`, by its bounds, or else by its `value` at some places.
    fn first_fall(
        self,
        along: &mut Along<'_>,
        mut value: impl FnMut(f64) -> f64,
        (from, to): (Sample, Sample),
        zero: f64,
    ) -> Crossing {
        if self.is_explicit(along) {
            let mut bounded = Explicit {
                value,
                along,
                function: self,
            };
            return first_crossing(&mut bounded, from, to, zero);
        }
        let mut bounded = Interpolant::new(&mut value, [from.at, to.at]);
        first_crossing(&mut bounded, from, to, zero)
    }
}

/// A function that may vanish along a piece.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Suspect {
    pub(crate) watched: Watched,
    /// Where the search begins, and ends.
    pub(crate) from: Sample,
    pub(crate) end: Sample,
    /// Falls less deep than this are none.
    pub(crate) zero: f64,
    /// Values up to this are rounding error.
    pub(crate) rounding: f64,
}

/// The fall of a function through zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fall {
    /// Which one, by its number.
    pub(crate) function: usize,
    /// Where the search began.
    pub(crate) from: Sample,
    /// Neighbours of different signs, unless the function is positive nowhere before.
    pub(crate) left: Sample,
    pub(crate) right: Sample,
    pub(crate) root: f64,
    /// Falls less deep than this were none.
    pub(crate) zero: f64,
}

/// The first fall among functions, whose values `value(number, place)` tells, or the number of one that varies too fast.
pub(crate) fn earliest_fall(
    along: &mut Along<'_>,
    suspects: &[Option<Suspect>],
    mut value: impl FnMut(usize, f64) -> f64,
) -> Result<Option<Fall>, usize> {
    let mut earliest: Option<Fall> = None;
    for (function, suspect) in suspects.iter().enumerate() {
        let &Some(Suspect {
            watched,
            from,
            end,
            zero,
            rounding,
        }) = suspect
        else {
            continue;
        };
        let mut value = |at| value(function, at);
        let to = match earliest {
            None => end,
            Some(Fall { root, .. }) => Sample {
                at: root,
                value: value(root),
            },
        };
        if to.at <= from.at {
            continue;
        }
        let (left, right) = match watched.first_fall(along, &mut value, (from, to), zero) {
            Crossing::Nowhere => continue,
            Crossing::Undecided => return Err(function),
            Crossing::Between(left, right) => (left, right),
        };
        let left = positive_before(&mut value, from, left, right, rounding);
        earliest = Some(Fall {
            function,
            from,
            left,
            right,
            root: root(&mut value, left, right),
            zero,
        });
    }
    Ok(earliest)
}

/// A function whose operations are known, with its bounds.
struct Explicit<'s, 'a, F> {
    value: F,
    along: &'s mut Along<'a>,
    function: Watched,
}

impl<F: FnMut(f64) -> f64> Bounded for Explicit<'_, '_, F> {
    fn value(&mut self, at: f64) -> f64 {
        (self.value)(at)
    }

    fn range(&mut self, part: [f64; 2]) -> Range {
        match self.function {
            Watched::Gap(i) => self.along.gap(i, part),
            Watched::Sliding(i, form) => form.range(self.along.sliding(i, part)),
            Watched::Solved => Range::ALL,
        }
    }

    fn slopes(&mut self, part: [f64; 2]) -> [Range; 2] {
        match self.function {
            Watched::Gap(i) => self.along.gap_slopes(i, part),
            Watched::Sliding(i, form) => {
                [form.slope(self.along.sliding_slope(i, part)), Range::ALL]
            }
            Watched::Solved => [Range::ALL; 2],
        }
    }
}

/// A function that was interpolated: known at some places alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Interpolated {
    /// The gap of a contact.
    Gap(usize),
    /// Its sliding velocity.
    Sliding(usize),
    /// Its normal force.
    Force(usize),
    /// What its friction lacks to its bound.
    Friction(usize),
}

impl Interpolated {
    /// What it is called in results.
    pub(crate) fn name(self, model: &dyn Model) -> String {
        let (what, contact) = match self {
            Self::Gap(i) => ("gap", i),
            Self::Sliding(i) => ("sliding", i),
            Self::Force(i) => ("force", i),
            Self::Friction(i) => ("friction", i),
        };
        format!("{what}({})", model.declaration().contacts[contact].name)
    }
}
