//! What the graph refuses: constants that double precision does not hold, and more work than a
//! compilation can wait for.
//!
//! The operations of the graph always give an expression. What went wrong on the way is noted, and
//! whoever builds expressions from a declaration asks for it at the places that it knows.

use std::cell::Cell;

/// Most terms and factors that all sums and products of one expansion may be made of, and most visits of
/// nodes: some seconds, and some hundred megabytes. A chain of ten links takes a tenth of it.
const WORK: usize = 30_000_000;

/// What happened to a constant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// It left the range of double precision, or is no number at all.
    Overflow,
    /// It became zero, or lost digits, because it is too small.
    Underflow,
    /// Constants that differ by their rounding only were subtracted.
    Cancellation,
    /// It was added to a constant beside which it has no digit.
    Absorption,
}

impl Fault {
    /// Whether the result is wrong whatever was meant. What cancels up to rounding is zero on paper, which is
    /// right in derivatives, where no user wrote the constants.
    pub(crate) fn is_of_range(self) -> bool {
        matches!(self, Self::Overflow | Self::Underflow)
    }
}

thread_local! {
    static FAULT: Cell<Option<Fault>> = const { Cell::new(None) };
    static SPENT: Cell<usize> = const { Cell::new(0) };
}

pub(super) fn reset() {
    FAULT.set(None);
    SPENT.set(0);
}

/// The worst of what happened to constants since this was asked last.
pub(crate) fn take_fault() -> Option<Fault> {
    FAULT.take()
}

pub(super) fn note(fault: Fault) {
    if FAULT.get().is_none_or(|known| !known.is_of_range()) {
        FAULT.set(Some(fault));
    }
}

/// Whether the expansion has become too large. From then on all that is built is zero, so that
/// whatever runs comes to its end.
pub(crate) fn is_exhausted() -> bool {
    SPENT.get() > WORK
}

/// Counts work before it is done; whether it may be done.
pub(crate) fn spend(work: usize) -> bool {
    SPENT.set(SPENT.get().saturating_add(work));
    !is_exhausted()
}

/// The work done so far.
#[cfg(test)]
pub(crate) fn spent() -> usize {
    SPENT.get()
}

/// The product of two constants.
pub(super) fn times(a: f64, b: f64) -> f64 {
    checked(a * b, a != 0.0 && b != 0.0, a.is_finite() && b.is_finite())
}

/// A constant that comes from others, which are zero or not, finite or not.
pub(super) fn checked(value: f64, nonzero: bool, finite: bool) -> f64 {
    if finite && !value.is_finite() {
        note(Fault::Overflow);
    } else if nonzero && value.abs() < f64::MIN_POSITIVE {
        note(Fault::Underflow);
    }
    value
}
