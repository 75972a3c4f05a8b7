//! What a simulation returns.

use super::ContactMode;
use crate::model::Declaration;

/// Result of a simulation.
#[derive(Debug, Clone)]
pub struct Simulation {
    /// Names and units of coordinates, controls and contacts.
    pub declaration: &'static Declaration,
    /// Why it ended.
    pub status: SimulationStatus,
    /// Mode of each contact right after the start and its impacts; empty if the run ended before it was known.
    ///
    /// The mode at a later time is that of the last event until then. Methods without events know the modes of the
    /// start only: [`Moreau`](super::Moreau) those of its first step, [`Smooth`](super::Smooth) which contacts are
    /// closed up to its width.
    pub initial_modes: Vec<ContactMode>,
    /// Switches of the contact mode in order of time.
    pub events: Vec<Event>,
    /// States at the accepted grid points; both sides of an impact are kept.
    pub trajectory: Trajectory,
    /// Largest residuals measured over the whole run.
    pub residuals: Residuals,
    /// Error at the end relative to the largest values of the motion, where the method estimates it: the
    /// difference to a looser run under error control, else the sum of the errors of the elements.
    pub error_estimate: Option<f64>,
    /// Size of the largest system that was solved for one step.
    pub size: ProblemSize,
    /// Operation counts, deterministic.
    pub counts: Counts,
    /// CPU time by kind of work.
    pub seconds: Seconds,
    /// Remarks that a user should read: the impact law used for simultaneous impacts, fallbacks.
    pub notes: Vec<String>,
}

/// Why a simulation ended.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SimulationStatus {
    /// Reached the horizon.
    Solved,
    /// A step did not converge; everything before it is kept.
    StepFailed(Diagnosis),
    /// A state or force became infinite or not a number.
    NotFinite(Diagnosis),
    /// The contact mode stays undetermined: dependent normals without a solution, or infinitely many
    /// switches in finite time.
    AmbiguousContact(Diagnosis),
    /// The limit on the number of steps was reached before the horizon.
    StepLimit(Diagnosis),
    /// Reached the horizon, but not with the accuracy that is promised.
    Inaccurate(Diagnosis),
}

impl SimulationStatus {
    /// Name used in JSON.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::StepFailed(_) => "step_failed",
            Self::NotFinite(_) => "not_finite",
            Self::AmbiguousContact(_) => "ambiguous_contact",
            Self::StepLimit(_) => "step_limit",
            Self::Inaccurate(_) => "inaccurate",
        }
    }

    /// The diagnosis, unless solved.
    #[must_use]
    pub fn diagnosis(&self) -> Option<&Diagnosis> {
        match self {
            Self::Solved => None,
            Self::StepFailed(diagnosis)
            | Self::NotFinite(diagnosis)
            | Self::AmbiguousContact(diagnosis)
            | Self::StepLimit(diagnosis)
            | Self::Inaccurate(diagnosis) => Some(diagnosis),
        }
    }
}

/// Where and why a simulation stopped early.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// Physical time reached \[s\].
    pub time: f64,
    /// Step (control stage) in which it stopped, from 0.
    pub step: usize,
    /// Contact concerned, if one can be named.
    pub contact: Option<usize>,
    /// What happened and what to change, one line.
    pub message: String,
}

/// A switch of the contact mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Physical time \[s\].
    pub time: f64,
    /// What happened.
    pub kind: EventKind,
    /// Which contact, in the order of declaration.
    pub contact: usize,
    /// Its name, as declared.
    pub contact_name: &'static str,
    /// Mode of each contact right after the event; events that are found together share it.
    pub modes: Vec<ContactMode>,
    /// Coordinates.
    pub q: Vec<f64>,
    /// Velocities just before.
    pub v_before: Vec<f64>,
    /// Velocities just after.
    pub v_after: Vec<f64>,
}

/// Kinds of events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum EventKind {
    /// The gap closes with a velocity jump.
    Impact,
    /// Sustained contact begins without a velocity jump.
    Contact,
    /// Sustained contact ends.
    LiftOff,
    /// A sliding contact begins to stick.
    Stick,
    /// A sticking contact begins to slip, or the direction of sliding turns round.
    Slip,
}

impl EventKind {
    /// Name used in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Impact => "impact",
            Self::Contact => "contact",
            Self::LiftOff => "lift_off",
            Self::Stick => "stick",
            Self::Slip => "slip",
        }
    }
}

/// States over time; entry `k` of every field belongs to the same instant.
#[derive(Debug, Clone, Default)]
pub struct Trajectory {
    /// Physical time \[s\], not decreasing (equal across an impact).
    pub time: Vec<f64>,
    /// Numerical time of the time-freezing system \[s\]: grows faster in contact, and alone during a jump.
    pub numerical_time: Vec<f64>,
    /// Coordinates, one vector an instant.
    pub q: Vec<Vec<f64>>,
    /// Velocities, one vector an instant.
    pub v: Vec<Vec<f64>>,
    /// Controls, one vector an instant.
    pub u: Vec<Vec<f64>>,
    /// Normal contact forces [N for a gap in metres], one vector an instant, 0 for open contacts.
    pub contact_force: Vec<Vec<f64>>,
    /// Tangential contact forces, one vector an instant, 0 for contacts that carry none; no vector at
    /// all if no contact declares friction.
    pub friction_force: Vec<Vec<f64>>,
}

impl Trajectory {
    /// Keeps the first `instants` instants.
    pub fn truncate(&mut self, instants: usize) {
        self.time.truncate(instants);
        self.numerical_time.truncate(instants);
        self.q.truncate(instants);
        self.v.truncate(instants);
        self.u.truncate(instants);
        self.contact_force.truncate(instants);
        self.friction_force.truncate(instants);
    }

    /// Appends one instant.
    pub fn push(
        &mut self,
        time: f64,
        numerical_time: f64,
        q: &[f64],
        v: &[f64],
        u: &[f64],
        force: &[f64],
    ) {
        self.time.push(time);
        self.numerical_time.push(numerical_time);
        self.q.push(q.to_vec());
        self.v.push(v.to_vec());
        self.u.push(u.to_vec());
        self.contact_force.push(force.to_vec());
    }
}

/// Largest residuals, measured after the fact.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Residuals {
    /// Largest violation of the discrete equations, or of the contact constraints while in contact.
    pub primal: f64,
    /// Largest violation of a sign condition: negative contact force or penetration.
    pub dual: f64,
    /// Largest product of a gap and its normal contact acceleration.
    pub complementarity: f64,
}

/// Size of a discrete system.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ProblemSize {
    /// Unknowns.
    pub variables: usize,
    /// Equations.
    pub equalities: usize,
    /// Inequalities that are checked or imposed.
    pub inequalities: usize,
    /// Complementarity pairs.
    pub complementarities: usize,
    /// Structural nonzeros of the Jacobian.
    pub jacobian_nonzeros: usize,
    /// Structural nonzeros of the Hessian (lower triangle).
    pub hessian_nonzeros: usize,
}

/// Deterministic operation counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Interior point iterations.
    pub interior_point: usize,
    /// Crossover iterations.
    pub crossover: usize,
    /// Newton iterations.
    pub newton: usize,
    /// Matrix factorizations.
    pub factorizations: usize,
    /// Evaluations of the right-hand side.
    pub evaluations: usize,
    /// Accepted steps or finite elements.
    pub elements: usize,
    /// Steps that needed the interior point fallback.
    pub fallbacks: usize,
}

/// CPU time by kind of work \[s\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Seconds {
    /// Whole run.
    pub total: f64,
    /// Model evaluation, where measured separately.
    pub evaluate: f64,
    /// Factorization, where measured separately.
    pub factorize: f64,
    /// Linear solves, where measured separately.
    pub solve: f64,
}
