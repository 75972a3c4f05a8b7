//! Until when a run may work: as long as nobody asks it to end, and for a number of seconds.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::clock::Instant;

/// A way to end a run from outside, from another thread or a signal handler: within a step too, where an observer, which is asked once an
/// iteration, may have to wait for long.
///
/// ```
/// use std::sync::Arc;
/// use std::sync::atomic::{AtomicBool, Ordering};
///
/// use hangtime_solver::nlp::Interrupt;
///
/// let asked = Arc::new(AtomicBool::new(false));
/// let interrupt = Interrupt::by(Arc::clone(&asked));
/// assert!(!interrupt.is_asked());
/// asked.store(true, Ordering::Relaxed);
/// assert!(interrupt.is_asked());
/// ```
#[derive(Debug, Clone, Default)]
pub struct Interrupt(Option<Arc<AtomicBool>>);

impl Interrupt {
    /// Asks once the flag is set.
    #[must_use]
    pub fn by(flag: Arc<AtomicBool>) -> Self {
        Self(Some(flag))
    }

    /// Whether the run is to end.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        self.0
            .as_ref()
            .is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}

/// Equal where both have one flag, or both none.
impl PartialEq for Interrupt {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            (None, None) => true,
            _ => false,
        }
    }
}

/// Until when a run may work.
#[derive(Debug, Clone)]
pub(crate) struct Until {
    interrupt: Interrupt,
    start: Instant,
    /// From the start on; infinite without a limit.
    seconds: f64,
}

impl Until {
    /// For so many seconds from now on, unless it is asked to end.
    pub(crate) fn new(interrupt: &Interrupt, seconds: f64) -> Self {
        Self {
            interrupt: interrupt.clone(),
            start: Instant::now(),
            seconds,
        }
    }

    /// Whether the run is to end.
    pub(crate) fn is_over(&self) -> bool {
        self.interrupt.is_asked()
            || self.seconds.is_finite() && self.start.elapsed().as_secs_f64() > self.seconds
    }
}

/// Without end.
impl Default for Until {
    fn default() -> Self {
        Self::new(&Interrupt::default(), f64::INFINITY)
    }
}
