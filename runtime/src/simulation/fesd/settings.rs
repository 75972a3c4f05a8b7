//! Settings of the simulation by finite elements.

use crate::fesd::finite_element::FiniteElement;
use crate::model::Model;
use crate::refusal;
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::InputError;
use crate::yardstick;

/// How the equations of a step are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum StepFormulation {
    /// Newton's method in a fixed contact mode, switches located.
    #[default]
    ActiveSet,
    /// The time-freezing system in numerical time, region by region: free flow, frozen jumps, and contacts that slow the
    /// clock down. Every start and end of a jump, of contact, and of sticking is an end of an element, so that the order
    /// of the scheme is kept through impacts.
    ///
    /// The auxiliary dynamics of a jump is a constant field along the impulses of the impact law, whatever number of
    /// contacts jump together, so that it ends where the law says.
    TimeFreezing,
}

/// Simulator by finite elements with switch detection.
///
/// Where forces or the ground depend on time itself, no element of a controlled run is longer than what they show at some places
/// beforehand: a pulse is seen down to a ten thousandth of the horizon. A named grid stays, and a note says where it is too coarse.
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
/// let fesd = Fesd::default().with_grid(10, 2);
/// let run = simulate(&ball).method(fesd).run()?;
/// assert!((run.events[0].time - (2.0_f64 / 9.81).sqrt()).abs() < 1e-9);
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Fesd {
    /// Family of the collocation scheme. Default Radau IIA, which keeps its order in contact.
    pub scheme: Scheme,
    /// Stages `n_s` of the scheme, 1 to 9. Default `None`: 6 under error control, 3 on a grid.
    pub stages: Option<usize>,
    /// Steps of equal physical length over the horizon, which choose a grid instead of error control; with a
    /// tolerance as well, elements end where steps do. Default `None`: error control (60 steps where
    /// `formulation` has none).
    pub steps: Option<usize>,
    /// Finite elements in a step of a grid without switches. Default 3, as in the paper.
    pub elements: usize,
    /// Error that is promised, relative to the largest distance from the start and the largest velocity, at
    /// the end and at every event. Default `None`: 1e-6, or no error control where `steps` are named.
    ///
    /// Elements take the lengths that an embedded error estimate allows. The run is compared with a looser
    /// one; where they differ by more than is promised, tighter ones follow, and where these still differ the
    /// status is [`Inaccurate`](crate::simulation::SimulationStatus::Inaccurate).
    pub tolerance: Option<f64>,
    /// Longest element under error control \[s\]. Default a tenth of the horizon.
    pub max_step: Option<f64>,
    /// Events of a run before it ends with
    /// [`EventLimit`](crate::simulation::SimulationStatus::EventLimit), whatever the horizon. Default 2,000,000.
    pub most_events: usize,
    /// Elements of a run beside those that end in events before it ends with
    /// [`StepLimit`](crate::simulation::SimulationStatus::StepLimit): a bound on memory and time. Default
    /// 300,000, which take some hundred megabytes.
    pub most_elements: usize,
    /// How the equations of a step are solved. Default: active set.
    pub formulation: StepFormulation,
    /// Whether the end of a contact arc is pinned by a vanishing force. Default true; `false` gives the
    /// earliest take-off that the published method admits, to show what the condition is worth.
    pub exit_condition: bool,
    /// Acceleration `a_bar` of the auxiliary dynamics [m/s^2 for a gap in metres]. It scales the numerical
    /// time; the result in physical time changes by the errors of the elements at most. Default 981 (100 times gravity, as
    /// in the paper).
    pub auxiliary_acceleration: f64,
    /// Normal velocity below which a contact with restitution no longer bounces \[unit of the gap / s\], which
    /// ends infinite sequences of bounces, with a note. Default none, which means 1e-6 of the largest normal
    /// velocity of the contact so far (the sum of its terms' sizes).
    /// Where several contacts touch, bounces that stay within rounding error of the gap end as well.
    pub rest_velocity: Option<f64>,
    /// Whether the event-driven method takes over a motion at which the elements of an error-controlled run in active-set form fail; a
    /// note says so. Default false: what is asked for runs. [`simulate`](crate::prelude::simulate) without a method sets it.
    pub hands_over: bool,
}

impl Default for Fesd {
    fn default() -> Self {
        Self {
            scheme: Scheme::RadauIia,
            stages: None,
            steps: None,
            elements: 3,
            tolerance: None,
            max_step: None,
            most_events: 2_000_000,
            most_elements: 300_000,
            formulation: StepFormulation::ActiveSet,
            exit_condition: true,
            auxiliary_acceleration: 981.0,
            rest_velocity: None,
            hands_over: false,
        }
    }
}

impl Fesd {
    /// Steps of a grid where none are named.
    pub const DEFAULT_STEPS: usize = 60;

    /// The error that is promised; none on a grid, nor with the take-offs that are there to be compared with.
    #[must_use]
    pub fn promise(&self) -> Option<f64> {
        let grid = self.steps.is_some() && self.tolerance.is_none();
        let controlled = self.exit_condition && !grid;
        controlled.then(|| self.tolerance.unwrap_or(yardstick::PROMISE))
    }

    /// Share of their terms by which conditions of contacts may be missed.
    pub(super) fn residual_tolerance(&self) -> f64 {
        match self.promise() {
            Some(promise) => promise,
            None if !self.exit_condition => f64::INFINITY,
            None => yardstick::VISIBLE,
        }
    }

    /// Stages of the scheme, whether named or not.
    #[must_use]
    pub fn stage_count(&self) -> usize {
        let default = if self.promise().is_some() { 6 } else { 3 };
        self.stages.unwrap_or(default)
    }

    /// The default settings with another scheme.
    #[must_use]
    pub fn with_scheme(mut self, scheme: Scheme, stages: usize) -> Self {
        self.scheme = scheme;
        self.stages = Some(stages);
        self
    }

    /// These settings on a grid: `steps` of `elements` elements each.
    #[must_use]
    pub fn with_grid(mut self, steps: usize, elements: usize) -> Self {
        self.steps = Some(steps);
        self.elements = elements;
        self
    }

    /// These settings with element lengths controlled to `tolerance`.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(tolerance);
        self
    }

    /// These settings with another way of solving a step.
    #[must_use]
    pub fn with_formulation(mut self, formulation: StepFormulation) -> Self {
        self.formulation = formulation;
        self
    }

    /// An element for the formulation.
    pub(super) fn element<'a>(
        &self,
        model: &'a dyn Model,
        tableau: &'a ButcherTableau,
    ) -> FiniteElement<'a> {
        let element = FiniteElement::new(model, tableau);
        match self.formulation {
            StepFormulation::TimeFreezing => element.in_numerical_time(self.auxiliary_acceleration),
            StepFormulation::ActiveSet => element,
        }
    }

    /// The scheme, with all settings checked.
    pub(super) fn tableau(&self) -> Result<ButcherTableau, InputError> {
        let refuse = |what: &str, value: f64, unit: &str, bound: String| {
            Err(refusal::out_of_range(what, value, unit, bound))
        };
        let steps = self.steps.unwrap_or(1);
        for (what, value) in [("steps", steps), ("elements", self.elements)] {
            if value == 0 {
                return refuse(what, 0.0, "", "at least 1".into());
            }
        }
        if steps.saturating_mul(self.elements) > self.most_elements {
            return refuse(
                "elements of all steps",
                steps as f64 * self.elements as f64,
                "",
                format!("at most {}, or raise `most_elements`", self.most_elements),
            );
        }
        if let Some(tolerance) = self.tolerance
            && !(1e-14..=1e-1).contains(&tolerance)
        {
            return refuse("tolerance", tolerance, "", "from 1e-14 to 0.1".into());
        }
        if let Some(max_step) = self.max_step
            && (max_step <= 0.0 || max_step.is_nan())
        {
            return refuse("longest step", max_step, "s", "above 0".into());
        }
        if !(self.auxiliary_acceleration.is_finite() && self.auxiliary_acceleration > 0.0) {
            return refuse(
                "auxiliary acceleration",
                self.auxiliary_acceleration,
                "m/s^2",
                "above 0 and finite".into(),
            );
        }
        if let Some(velocity) = self.rest_velocity
            && !(0.0..f64::INFINITY).contains(&velocity)
        {
            return refuse(
                "rest velocity",
                velocity,
                "m/s",
                "at least 0 and finite".into(),
            );
        }
        let stages = self.stage_count();
        match ButcherTableau::new(self.scheme, stages) {
            Some(tableau) => Ok(tableau),
            None => refuse(
                "stages",
                stages as f64,
                "",
                format!("from 1 to {}", ButcherTableau::MAX_STAGES),
            ),
        }
    }
}
