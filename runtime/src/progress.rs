//! What a run tells whoever waits for it, and how it is stopped.

use std::fmt;

use hangtime_solver::nlp::Residuals;

/// What a simulation or an optimal control run is doing.
///
/// ```
/// use hangtime::prelude::*;
///
/// hangtime::model! {
///     /// A stone falls into a well.
///     pub Stone {
///         parameters { m: kg = 1, g: m/s^2 = 9.81 }
///         coordinates { z: m }
///         lagrangian m/2*dot(z)^2 - m*g*z
///         surface water: z + 5[m] >= 0
///         impact water: inelastic
///         horizon 2 [s]
///     }
/// }
///
/// let stone = Stone::default();
/// let run = simulate(&stone).observer(|progress| progress.time < 0.5).run()?;
/// assert_eq!(run.status.name(), "interrupted");
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Name of the step: `"simulation"`, or the phase of the optimal control solver.
    pub step: &'static str,
    /// Physical time that a simulation has reached \[s\]; 0 in optimal control.
    pub time: f64,
    /// Steps or elements that a simulation has accepted, or interior point iterations, those of the program under way
    /// included.
    pub iterations: usize,
    /// Programs solved so far.
    pub programs: usize,
    /// Objective of the iterate; it may be infeasible.
    pub objective: f64,
    /// Scaled residuals of the iterate.
    pub residuals: Residuals,
    /// Best objective of a motion with a consistent contact sequence so far.
    pub best: Option<f64>,
    /// The best motion of an optimal control run so far.
    pub motion: Option<BestMotion>,
    /// Wall-clock time since the start \[s\].
    pub seconds: f64,
}

/// The best motion that an optimal control run knows, which shows as `3 contacts, objective 1.4445, replayed`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct BestMotion {
    /// Contacts that close on the way.
    pub contacts: usize,
    /// Objective; of one that is not replayed that of controls which may jump at any time.
    pub objective: f64,
    /// Whether an event-driven simulation under its controls comes to the same.
    pub replayed: bool,
}

impl BestMotion {
    pub(crate) fn new(contacts: usize, objective: f64, replayed: bool) -> Self {
        Self {
            contacts,
            objective,
            replayed,
        }
    }

    /// The better of two motions: one that is replayed, or else the cheaper one.
    pub(crate) fn better(known: Option<Self>, other: Option<Self>) -> Option<Self> {
        let rank = |motion: &Self| (!motion.replayed, motion.objective);
        match (known, other) {
            (Some(known), Some(other)) if rank(&other) < rank(&known) => Some(other),
            (known, other) => known.or(other),
        }
    }
}

impl fmt::Display for BestMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.contacts == 1 { "" } else { "s" };
        write!(
            f,
            "{} contact{plural}, objective {:.7}",
            self.contacts, self.objective
        )?;
        f.write_str(if self.replayed { ", replayed" } else { "" })
    }
}

impl Progress {
    /// Nothing done yet.
    pub(crate) fn new(step: &'static str) -> Self {
        Self {
            step,
            time: 0.0,
            iterations: 0,
            programs: 0,
            objective: f64::NAN,
            residuals: Residuals {
                primal: f64::NAN,
                dual: f64::NAN,
                complementarity: f64::NAN,
            },
            best: None,
            motion: None,
            seconds: 0.0,
        }
    }
}

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.step)?;
        let no_program = self.objective.is_nan();
        if no_program && self.time > 0.0 {
            return write!(f, "t = {:.6} s, {} steps", self.time, self.iterations);
        }
        write!(
            f,
            "program {}, iteration {}",
            self.programs + 1,
            self.iterations
        )?;
        match (&self.motion, self.best) {
            (Some(motion), _) => write!(f, ", best: {motion}"),
            (None, Some(best)) => write!(f, ", best objective {best:.7}"),
            (None, None) => Ok(()),
        }
    }
}

/// Sees the progress after every accepted step of a simulation, or every interior point iteration; `false` stops the
/// run, which then ends with the status `interrupted` and what was found so far.
///
/// Solvers that run side by side share one observer, hence `Send`.
pub type Observer<'a> = dyn FnMut(&Progress) -> bool + Send + 'a;
