//! What a simulation returns.

use crate::yardstick;
use std::fmt;
use std::ops::Index;

use hangtime_solver::{ProblemSize, Seconds};
use serde::Serialize;

use super::quantity::{Quantity, number};
use super::{ContactMode, Doubts, InputError, Residuals, State, Trajectory};
use crate::contact::ContactState;
use crate::model::{ContactDeclaration, Declaration, Model};
use crate::refusal;

/// Result of a simulation.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81, height: m = 1 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: inelastic
/// #         start { z: height }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let ball = Ball::default();
/// let run = simulate(&ball).run()?;
/// assert!(run.status.is_solved());
/// let impact = run.events[0].time;
/// assert!(run.just_before(impact)?["dot(z)"] < -4.4 && run.at(impact)?["dot(z)"] == 0.0);
/// assert_eq!(run["z"].len(), run["time"].len());
/// assert!(run.to_string().starts_with("solved\n0.451524 s: impact at floor\n"));
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Simulation {
    /// Names and units of coordinates, controls and contacts.
    pub declaration: &'static Declaration,
    /// Why it ended.
    pub status: SimulationStatus,
    /// Mode of each contact right after the start and its impacts; empty if the run ended before it was known.
    ///
    /// The mode at a later time is that of the last event until then. Methods without events know the modes of the
    /// start only: [`Moreau`](crate::baselines::Moreau) those of its first step, [`Smooth`](crate::baselines::Smooth) which contacts are
    /// closed up to its width.
    pub initial_modes: Vec<ContactMode>,
    /// Switches of the contact mode in order of time. Of more than 200,000 one of so many is listed, which a note says;
    /// [`Counts::events`] is the number of all.
    pub events: Vec<Event>,
    /// States at the accepted grid points; both sides of an impact are kept.
    pub trajectory: Trajectory,
    /// Largest residuals measured over the whole run: of the discrete equations and of the contact constraints while in
    /// contact (`primal`), of signs, that is negative contact forces or penetration (`dual`), and of products of a gap and
    /// its normal contact acceleration (`complementarity`). A run is solved only where none is above its tolerance.
    pub residuals: Residuals,
    /// Error at the end and at events relative to the largest values of the motion: the difference to a looser run, with
    /// another tolerance, on half the steps or with twice the width, or the sum of the errors of the steps where that is
    /// more. Of methods that locate no switches it is the difference to several runs all along the way, or what the
    /// impacts would have changed that lie between two steps. Infinite where a looser run does not reach the end. Every solved
    /// run has one.
    pub error_estimate: Option<f64>,
    /// Size of the largest system that was solved: of an element, or of a step.
    pub size: ProblemSize,
    /// Operation counts, deterministic.
    pub counts: Counts,
    /// CPU time by kind of work.
    pub seconds: Seconds,
    /// Functions of the contact mode that were interpolated: between the places at which they were evaluated nothing bounds them, so that
    /// an event might be missed there. Those of all others are enclosed. None by methods that locate no events.
    pub interpolated: Option<Vec<String>>,
    /// Remarks that a user should read: the impact law used for simultaneous impacts.
    pub notes: Vec<String>,
    /// What of it its method could not decide alone; the notes say so in words.
    pub doubts: Doubts,
}

/// Which side of an instant.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Before,
    After,
}

impl Simulation {
    /// Leaves the coordinates out that stand for parameters, at the values of which `scene` is the model without them.
    pub(crate) fn leave_held_out(&mut self, scene: &dyn Model) {
        let n = scene.declaration().coordinates.len();
        self.declaration = scene.declaration();
        self.trajectory.leave_held_out(scene);
        for event in &mut self.events {
            for values in [&mut event.q, &mut event.v_before, &mut event.v_after] {
                values.truncate(n);
            }
        }
    }

    /// The state at a time, right after an impact at that time.
    ///
    /// Between two points of the trajectory coordinates follow the cubic through their values and velocities, and
    /// velocities its derivative, so that both are as accurate as the distance `h` of the points allows: to `h^4` and
    /// `h^3`. Controls and forces are linear. No interpolation reaches over an impact: both sides of it are points.
    ///
    /// # Errors
    /// [`InputError`] at times that were not simulated.
    pub fn at(&self, time: f64) -> Result<State, InputError> {
        self.on_side(time, Side::After)
    }

    /// The state at a time, right before an impact at that time; as [`at`](Self::at) everywhere else.
    ///
    /// # Errors
    /// [`InputError`] at times that were not simulated.
    pub fn just_before(&self, time: f64) -> Result<State, InputError> {
        self.on_side(time, Side::Before)
    }

    /// All values of one name along the trajectory, as listed at [`State`]; `None` if there is no such name.
    #[must_use]
    pub fn series(&self, name: &str) -> Option<&[f64]> {
        match Quantity::named(self.declaration, self.trajectory.recorded(), name)? {
            Quantity::Time => Some(&self.trajectory.time),
            Quantity::Output(i) => self.trajectory.output(i),
            quantity => self.trajectory.column(self.column_of(quantity)?),
        }
    }

    /// Place of a quantity in a row of the trajectory.
    fn column_of(&self, quantity: Quantity) -> Option<usize> {
        let declaration = self.declaration;
        let (n, controls, contacts) = (
            declaration.coordinates.len(),
            declaration.controls.len(),
            declaration.contacts.len(),
        );
        match quantity {
            Quantity::Time | Quantity::Output(_) => None,
            Quantity::Coordinate(k) => Some(k),
            Quantity::Velocity(k) => Some(n + k),
            Quantity::Control(k) => Some(2 * n + k),
            Quantity::Force(i) => Some(2 * n + controls + i),
            Quantity::Impulse(i) => Some(2 * n + controls + contacts + i),
            Quantity::FrictionImpulse(i) => Some(2 * n + controls + 2 * contacts + i),
            Quantity::Friction(i) => Some(2 * n + controls + 3 * contacts + i),
        }
    }

    fn on_side(&self, time: f64, side: Side) -> Result<State, InputError> {
        let times = &self.trajectory.time;
        let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
            return Err(outside(time, "given by a trajectory, which is empty"));
        };
        if !(first..=last).contains(&time) {
            return Err(outside(
                time,
                &format!("in {first}..={last}, which was simulated"),
            ));
        }
        let exact = match side {
            Side::After => times.partition_point(|&t| t <= time) - 1,
            Side::Before => times.partition_point(|&t| t < time),
        };
        if times[exact] == time {
            return Ok(self.point(exact));
        }
        let next = times.partition_point(|&t| t <= time);
        Ok(State::between(
            &self.point(next - 1),
            &self.point(next),
            time,
        ))
    }

    /// The last state; what is below `share` of the largest value of its component is zero.
    pub(crate) fn last_for_people(&self, share: f64) -> Option<State> {
        let trajectory = &self.trajectory;
        let mut last = self.point(trajectory.time.len().checked_sub(1)?);
        for (values, rows) in [
            (&mut last.q, &trajectory.q),
            (&mut last.v, &trajectory.v),
            (&mut last.u, &trajectory.u),
        ] {
            for (k, value) in values.iter_mut().enumerate() {
                let largest = rows.iter().fold(0.0_f64, |s, row| s.max(row[k].abs()));
                if value.abs() <= share * largest {
                    *value = 0.0;
                }
            }
        }
        Some(last)
    }

    /// The state at a point of the trajectory.
    fn point(&self, index: usize) -> State {
        let trajectory = &self.trajectory;
        let row = |rows: &[Vec<f64>]| rows.get(index).cloned().unwrap_or_default();
        State {
            time: trajectory.time[index],
            q: row(&trajectory.q),
            v: row(&trajectory.v),
            u: row(&trajectory.u),
            contact_force: row(&trajectory.contact_force),
            friction_force: row(&trajectory.friction_force),
            outputs: trajectory.outputs_at(index),
            impulses: trajectory.impulses(index),
            declaration: self.declaration,
            recorder: trajectory.recorder.clone(),
        }
    }
}

impl Index<&str> for Simulation {
    type Output = [f64];

    /// All values of one name along the trajectory, as listed at [`State`].
    ///
    /// # Panics
    /// If the scene knows no such name; [`Simulation::series`] asks.
    fn index(&self, name: &str) -> &[f64] {
        self.series(name).unwrap_or_else(|| {
            let outputs = self.trajectory.recorded();
            panic!("{}", Quantity::unknown(self.declaration, outputs, name))
        })
    }
}

/// Why a simulation ended.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81, height: m = 1 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: inelastic
/// #         start { z: height }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let ball = Ball::default();
/// let run = simulate(&ball).observer(|_| false).run()?;
/// assert!(matches!(run.status, SimulationStatus::Interrupted(_)));
/// println!("{}", run.status); // name, time and reason
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SimulationStatus {
    /// Reached the horizon.
    Solved,
    /// The observer stopped the run; everything before is kept.
    Interrupted(Diagnosis),
    /// A step did not converge; everything before it is kept.
    StepFailed(Diagnosis),
    /// A state or force became infinite or not a number.
    NotFinite(Diagnosis),
    /// The contact mode stays undetermined: dependent normals without a solution, or infinitely many
    /// switches in finite time.
    AmbiguousContact(Diagnosis),
    /// The limit on the number of steps was reached before the horizon.
    StepLimit(Diagnosis),
    /// The limit on the number of events was reached before the horizon.
    EventLimit(Diagnosis),
    /// Reached the horizon, but not with the accuracy that is promised: the time of the diagnosis is that of the last
    /// event up to which two runs agree, or at which a condition of a contact is missed.
    Inaccurate(Diagnosis),
}

impl SimulationStatus {
    /// Whether the run reached the horizon.
    #[must_use]
    pub fn is_solved(&self) -> bool {
        *self == Self::Solved
    }

    /// Name used in JSON.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Interrupted(_) => "interrupted",
            Self::StepFailed(_) => "step_failed",
            Self::NotFinite(_) => "not_finite",
            Self::AmbiguousContact(_) => "ambiguous_contact",
            Self::StepLimit(_) => "step_limit",
            Self::EventLimit(_) => "event_limit",
            Self::Inaccurate(_) => "inaccurate",
        }
    }

    /// The diagnosis, unless solved.
    #[must_use]
    pub fn diagnosis(&self) -> Option<&Diagnosis> {
        match self {
            Self::Solved => None,
            Self::Interrupted(diagnosis)
            | Self::StepFailed(diagnosis)
            | Self::NotFinite(diagnosis)
            | Self::AmbiguousContact(diagnosis)
            | Self::StepLimit(diagnosis)
            | Self::EventLimit(diagnosis)
            | Self::Inaccurate(diagnosis) => Some(diagnosis),
        }
    }
}

impl fmt::Display for SimulationStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.diagnosis() {
            None => f.write_str(self.name()),
            Some(diagnosis) => {
                let (name, time) = (self.name(), number(diagnosis.time));
                write!(f, "{name} at t = {time} s: {}", diagnosis.message)
            }
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
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81, e = 0.5, height: m = 1 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: restitution e
/// #         start { z: height }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let ball = Ball::default();
/// let run = simulate(&ball).run()?;
/// let bounce = &run.events[0];
/// assert_eq!((bounce.contact_name, bounce.modes[0]), ("floor", ContactMode::Open));
/// assert!((bounce.v_after[0] + 0.5 * bounce.v_before[0]).abs() < 1e-12);
/// # Ok::<(), InputError>(())
/// ```
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
    /// Normal impulse of every contact in the impact \[N s for a gap in metres\], 0 for those that take no part; events
    /// that are found together share it. Empty unless this is an impact, and where not all events are listed.
    ///
    /// It follows from the jump of the velocities. Where contacts are so many that different impulses give the same
    /// jump, it is the smallest.
    pub contact_impulse: Vec<f64>,
    /// Tangential impulses, along the sliding velocities; empty if no contact declares friction as well.
    pub friction_impulse: Vec<f64>,
}

/// Kinds of events.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A ball above a floor.
/// #     pub Ball {
/// #         parameters { m: kg = 1, g: m/s^2 = 9.81, e = 0.5, height: m = 1 }
/// #         coordinates { z: m }
/// #         lagrangian m/2*dot(z)^2 - m*g*z
/// #         surface floor: z >= 0
/// #         impact floor: restitution e
/// #         start { z: height }
/// #         horizon 1 [s]
/// #     }
/// # }
/// let ball = Ball::default();
/// let run = simulate(&ball).run()?;
/// let bounces = run.events.iter().filter(|event| event.kind == EventKind::Impact);
/// println!("{} bounces", bounces.count());
/// # Ok::<(), InputError>(())
/// ```
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
    /// The motion begins to slide along the zero of a switch.
    Slide,
    /// The motion passes the zero of a switch, or leaves it.
    Switch,
    /// The condition of a `when` comes true, and states or velocities are set.
    When,
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
            Self::Slide => "slide",
            Self::Switch => "switch",
            Self::When => "when",
        }
    }

    /// What the change of the state of a contact is, without an impact; `None` where nothing changes.
    pub(crate) fn between(before: ContactState, now: ContactState) -> Option<Self> {
        if before == now || before.is_stuck() && now.is_stuck() {
            return None;
        }
        Some(match (before, now) {
            (ContactState::Open, _) => Self::Contact,
            (_, ContactState::Open) => Self::LiftOff,
            (_, now) if now.is_stuck() => Self::Stick,
            _ => Self::Slip,
        })
    }

    /// The kind of a change of friction that is one of the contact `declared`.
    pub(crate) fn of(self, declared: &ContactDeclaration) -> Self {
        match (self, declared.switch) {
            (Self::Stick, Some(_)) => Self::Slide,
            (Self::Slip, Some(_)) => Self::Switch,
            (kind, _) => kind,
        }
    }
}

impl fmt::Display for EventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::LiftOff => "lift-off",
            kind => kind.name(),
        })
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} s: {} at {}",
            number(self.time),
            self.kind,
            self.contact_name
        )
    }
}

/// Events that are listed of a run with more of them.
const LISTED: usize = 20;

impl fmt::Display for Simulation {
    /// Status, the first events, the last state, and the remarks, a line each.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.status)?;
        for event in self.events.iter().take(LISTED) {
            write!(f, "\n{event}")?;
        }
        if let Some(more) = self
            .events
            .len()
            .checked_sub(LISTED)
            .filter(|&more| more > 0)
        {
            write!(f, "\n... and {more} events more")?;
        }
        if let Some(last) = self.last_for_people(yardstick::ROUNDING) {
            write!(f, "\n{last}")?;
        }
        for note in &self.notes {
            write!(f, "\nnote: {note}")?;
        }
        Ok(())
    }
}

/// Deterministic operation counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
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
    /// Switches of the contact mode, listed or not; 0 for methods without events.
    #[serde(skip)]
    pub events: usize,
}

impl Counts {
    /// The work of both; elements are those of the first.
    pub(super) fn with(mut self, other: &Self) -> Self {
        self.interior_point += other.interior_point;
        self.crossover += other.crossover;
        self.newton += other.newton;
        self.factorizations += other.factorizations;
        self.evaluations += other.evaluations;
        self
    }
}

fn outside(time: f64, bound: &str) -> InputError {
    refusal::out_of_range("time of a state", time, "s", bound)
}
