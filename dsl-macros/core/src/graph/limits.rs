//! What the graph refuses: constants that double precision does not hold, and more work than a
//! compilation can wait for.
//!
//! The operations of the graph always give an expression. What went wrong on the way is noted, and
//! whoever builds expressions from a declaration asks for it at the places that it knows.

use std::cell::Cell;

/// Most terms and factors that all sums and products of one expansion may be made of, and most visits of
/// nodes: some seconds, and some hundred megabytes. A chain of ten links takes a quarter of it.
pub(crate) const WORK: usize = 16_000_000;

/// Most terms, factors and visits of all that follows from a declaration: four times [`WORK`], some more seconds.
pub(crate) const DERIVED_WORK: usize = 64_000_000;

/// What happened to a constant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// It left the range of double precision, or is no number at all.
    Overflow,
    /// Constants that differ by their rounding only were subtracted.
    Cancellation,
    /// It was added to a constant beside which it has no digit.
    Absorption,
}

impl Fault {
    /// Whether the result is wrong whatever was meant. What cancels up to rounding is zero on paper, which is
    /// right in derivatives, where no user wrote the constants.
    pub(crate) fn is_of_range(self) -> bool {
        matches!(self, Self::Overflow)
    }
}

/// What a derivation is at work on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Expressions as they are written.
    Declaration,
    /// The mass matrix.
    Inertia,
    /// What acts on the coordinates.
    Forces,
    /// The derivatives of the acceleration.
    Motion,
    /// Gap, normal and directions of the contact with this index.
    Contact(usize),
    /// Costs and conditions of optimal control.
    OptimalControl,
    /// The order of operations.
    Kernels,
}

thread_local! {
    static STAGE: Cell<Stage> = const { Cell::new(Stage::Declaration) };
    static FAULT: Cell<Option<Fault>> = const { Cell::new(None) };
    static SPENT: Cell<usize> = const { Cell::new(0) };
}

pub(super) fn reset() {
    FAULT.set(None);
    SPENT.set(0);
    STAGE.set(Stage::Declaration);
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
    SPENT.get() > allowed()
}

/// From now on the derivation is at work on something else.
pub(crate) fn begin(stage: Stage) {
    if !is_exhausted() {
        STAGE.set(stage);
    }
}

/// What it is at work on, or was when it became too large.
pub(crate) fn stage() -> Stage {
    STAGE.get()
}

/// Most work of a declaration and, from then on, of what follows from it.
pub(crate) fn allowed() -> usize {
    match STAGE.get() {
        Stage::Declaration => WORK,
        _ => DERIVED_WORK,
    }
}

/// Counts work before it is done; whether it may be done.
pub(crate) fn spend(work: usize) -> bool {
    SPENT.set(SPENT.get().saturating_add(work));
    !is_exhausted()
}

/// The product of two constants.
pub(super) fn times(a: f64, b: f64) -> f64 {
    checked(a * b, a.is_finite() && b.is_finite())
}

/// A constant that comes from others, which are finite or not. One that is too small is zero.
pub(super) fn checked(value: f64, finite: bool) -> f64 {
    if finite && !value.is_finite() {
        note(Fault::Overflow);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of rods with a torque at each joint.
    fn chain(links: usize) -> String {
        let join = |one: &dyn Fn(usize) -> String, by: &str| {
            (1..=links).map(one).collect::<Vec<_>>().join(by)
        };
        let mut lets = String::from("let a1 = q1 let e1 = (0, 0)");
        for i in 2..=links {
            let before = i - 1;
            lets +=
                &format!(" let a{i} = a{before} + q{i} let e{i} = e{before} + 2*half(a{before})");
        }
        format!(
            "Chain {{ parameters {{ g = 9.81 }} coordinates {{ {} }} controls {{ {} }} fn half(angle) = \
             (sin(angle)/2, -cos(angle)/2) fn energy(p, angle) = |dot(p)|^2/2 + dot(angle)^2/24 - g*p.z {lets} \
             lagrangian {} forces {{ {} }} }}",
            join(&|i| format!("q{i}"), ", "),
            join(&|i| format!("u{i}"), ", "),
            join(&|i| format!("energy(e{i} + half(a{i}), a{i})"), " + "),
            join(&|i| format!("q{i}: u{i}"), ", "),
        )
    }

    #[test]
    fn mechanisms_stay_far_below_the_limit() {
        let tokens = chain(10).parse().expect("tokens");
        assert!(crate::try_expand(tokens).is_ok());
        let work = SPENT.get();
        assert!(3 * work < WORK, "{work}");
        // It is counted at all: each of the ten masses has some hundred terms in each velocity.
        assert!(work > 10_000, "{work}");
    }

    #[test]
    fn work_beyond_the_limit_gives_zero_and_ends() {
        reset();
        assert!(spend(WORK));
        assert!(!is_exhausted());
        assert!(!spend(1));
        assert!(is_exhausted());
        assert_eq!(
            crate::graph::Sym::ONE + crate::graph::Sym::ONE,
            crate::graph::Sym::ZERO
        );
        crate::graph::reset();
        assert!(!is_exhausted());
    }
}
