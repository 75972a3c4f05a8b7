//! The method and its settings.

use crate::refusal;
use crate::simulation::InputError;

/// Admissible tolerances: below the first, rounding error of one step exceeds the tolerance; above the
/// second, a step may jump over whatever happens in it.
const TOLERANCES: (f64, f64) = (1e-14, 1e-2);

/// Event-driven simulation: an explicit Runge-Kutta method of high order between the switches of the contact
/// mode, which are located to rounding error.
///
/// Between events the constrained dynamics of the active contacts `I` are integrated,
///
/// ```text
/// q' = v,   v' = a + sum_I d_i r_i + e_i s_i,   n_i' v' + curvature = 0
/// a contact that sticks:  b_i' v' + curvature = 0;    one that slips:  s_i = -mu r_i sign(v_t,i)
/// ```
///
/// by DOP853 (Hairer, Norsett, Wanner, *Solving Ordinary Differential Equations I*, II.5 and II.6: order 8,
/// error estimates of orders 5 and 3, continuous extension of order 7), and after every step the state is
/// moved onto `g = 0`, `v_n = 0` and, where a contact sticks, `v_t = 0`, so that nothing drifts. A step ends
/// early where a gap closes, a contact force vanishes, a friction force reaches its limit, a sliding velocity
/// vanishes or the controls jump: found on the continuous extension, then polished by true steps of the method. Where forces or
/// the ground depend on time itself, no step is longer than what they show at some places beforehand: a pulse is seen down to a ten
/// thousandth of the horizon.
///
/// An impact obeys Newton's law in the normal and Coulomb's in the tangential direction, for all closed contacts
/// at once (Moreau, *Unilateral contact and dry friction in finite freedom dynamics*, 1988),
///
/// ```text
/// v+ = v- + sum_i d_i p_i + e_i s_i
/// 0 <= p_i _|_ v_n,i+ + restitution_i min(v_n,i-, 0) >= 0,   |s_i| <= mu_i p_i,  s_i v_t,i+ = -mu_i p_i |v_t,i+|
/// ```
///
/// and the new contact mode follows from the same complementarity of forces and accelerations; where that is
/// undecided, from what follows a moment later. Both problems are solved by enumeration: no solution, or several
/// with different motions (Painleve's paradox), end the run as
/// [`AmbiguousContact`](crate::simulation::SimulationStatus::AmbiguousContact), as does a sliding contact whose force grows
/// beyond all bounds. An impact that raises the kinetic energy, as Newton's law does where friction or several
/// contacts couple, is noted.
///
/// What counts as zero is a share of what the scene itself has shown, so that results depend neither on where it is
/// nor on its units: gaps below `1e-12` of the range of that gap so far, or below some roundings of it, are closed,
/// dips below zero of a few times that are no impacts, and a flight lower than `1e-14` of the range is none, which ends
/// geometric sequences of impacts; velocities and forces below `1e-12` of their terms are zero. The root of a switching
/// function is where its sign changes. After the events have been found, the signs of forces and gaps are measured on
/// the continuous extension as well: a run that missed an event by more than errors of integration ends as
/// [`Inaccurate`](crate::simulation::SimulationStatus::Inaccurate), and the largest violation is `residuals.dual`. Up to twelve contacts can
/// close at one instant; one with friction that may stick counts twice.
///
/// A run is `solved` only if another one confirms it: the motion is computed with a hundred times the tolerance and other
/// steps first, and where the two differ at the end or at an event by more than `1e-6` of the largest values (of the way
/// from the start and of the velocity, among the coordinates of one unit; a thousand tolerances, if that is more), twice
/// more with a hundredth of the tolerance each. The finest run is the result and the last difference its
/// `error_estimate`; where it stays too large the status is
/// [`Inaccurate`](crate::simulation::SimulationStatus::Inaccurate), with the time up to which the runs agree.
///
/// It shares nothing with the finite element simulation but the model and the way in which runs are compared, so that each
/// can check the other.
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
/// let method = EventDriven { tolerance: 1e-12, max_events: 100, ..EventDriven::default() };
/// let run = simulate(&ball).method(method).run()?;
/// assert!((run.events[0].time - (2.0_f64 / 9.81).sqrt()).abs() < 1e-14);
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct EventDriven {
    /// Error per step as a share of the fastest velocity so far (among the coordinates of one unit), and of the way
    /// covered with it in the step; in `1e-14..=1e-2`, default `1e-9`. A tenth of it costs about a third more
    /// evaluations.
    pub tolerance: f64,
    /// Longest step \[s\]; default none, which means a sixteenth of the horizon. Lower it if the ground
    /// has features that are passed faster than that.
    pub max_step: Option<f64>,
    /// Normal velocity below which a contact with restitution no longer bounces \[unit of the gap / s\], which
    /// ends infinite sequences of bounces, with a note; default none, which means `sqrt(2 a h)` where the
    /// contact is pressed with the acceleration `a`: bounces lower than `h`, `max(tolerance^2, 1e-11)` times
    /// the range of the gap so far, are left out.
    pub rest_velocity: Option<f64>,
    /// Largest number of events before the run ends as
    /// [`EventLimit`](crate::simulation::SimulationStatus::EventLimit); default 2 000 000, whatever the horizon.
    pub max_events: usize,
    /// Largest number of accepted and rejected steps beside those that end in events; default 1 000 000.
    pub max_steps: usize,
    /// Number of equal intervals of the horizon at whose ends the trajectory has a point, from the
    /// continuous extension, besides those at the ends of steps; default 0, none.
    pub output_times: usize,
    /// Acceleration `a_bar` of the auxiliary dynamics that the numerical time refers to
    /// \[unit of the gap / s^2\]; default `100 * 9.81`. Physical results do not depend on it.
    ///
    /// In contact `dtau/dt = 1/p` with `p = prod_i (1 - r_i p / a_bar)`, which is `1 + r/a_bar` for one
    /// contact. An impact takes `max_i p_i / a_bar`, with the impulses `p_i` of the impact law: for one contact
    /// without friction `(1 + restitution) |v_n| / a_bar`.
    pub auxiliary_acceleration: f64,
}

impl Default for EventDriven {
    fn default() -> Self {
        Self {
            tolerance: 1e-9,
            max_step: None,
            rest_velocity: None,
            max_events: 2_000_000,
            max_steps: 1_000_000,
            output_times: 0,
            auxiliary_acceleration: 981.0,
        }
    }
}

impl EventDriven {
    pub(super) fn check(&self) -> Result<(), InputError> {
        let refuse = |what: &str, value: f64, unit: &str, bound: &str| {
            Err(refusal::out_of_range(what, value, unit, bound))
        };
        if !(TOLERANCES.0..=TOLERANCES.1).contains(&self.tolerance) {
            return refuse("tolerance", self.tolerance, "", "in 1e-14..=1e-2");
        }
        if let Some(max_step) = self.max_step
            && (max_step <= 0.0 || max_step.is_nan())
        {
            return refuse("longest step", max_step, "s", "above 0");
        }
        if let Some(velocity) = self.rest_velocity
            && (velocity < 0.0 || !velocity.is_finite())
        {
            return refuse("rest velocity", velocity, "m/s", "at least 0 and finite");
        }
        if self.auxiliary_acceleration <= 0.0 || !self.auxiliary_acceleration.is_finite() {
            return refuse(
                "auxiliary acceleration",
                self.auxiliary_acceleration,
                "m/s^2",
                "above 0 and finite",
            );
        }
        if self.max_steps == 0 {
            return refuse("largest number of steps", 0.0, "", "at least 1");
        }
        Ok(())
    }
}
