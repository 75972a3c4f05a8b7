//! CPU time by kind of work.

use std::ops::AddAssign;

use serde::Serialize;

use crate::clock::ThreadTime;

/// CPU time by kind of work \[s\].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Seconds {
    /// Whole run.
    pub total: f64,
    /// Model evaluation, where measured separately.
    pub evaluate: f64,
    /// Assembly and factorization of Newton systems, where measured separately.
    pub factorize: f64,
    /// Linear solves, where measured separately.
    pub solve: f64,
}

/// Adds the time of another run.
impl AddAssign for Seconds {
    fn add_assign(&mut self, other: Self) {
        self.total += other.total;
        self.evaluate += other.evaluate;
        self.factorize += other.factorize;
        self.solve += other.solve;
    }
}

/// What `work` returns; its CPU time is added to `seconds`.
pub(crate) fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = ThreadTime::now();
    let result = work();
    *seconds += start.elapsed().as_secs_f64();
    result
}
