//! What the caller may choose.

use hangtime_solver::mpcc::RelaxationRule;

use super::previous::Previous;
use crate::model::Model;
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::rules;
use crate::refusal;
use crate::rk::{ButcherTableau, Scheme};
use crate::simulation::InputError;

/// Starts of the search in phases, unless others are asked for: one, and two that bring nothing.
const STARTS: usize = 3;
/// Most starts of the time-freezing formulation, unless others are asked for.
pub(in crate::ocp) const FREEZING_STARTS: usize = 6;

/// Where the global phase starts; every guess but a previous motion is made from the model and the problem alone.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A cart that is pushed to 1 m.
/// #     pub Cart {
/// #         parameters { m: kg = 2 }
/// #         coordinates { y: m }
/// #         controls { u: N in -1..=1 }
/// #         lagrangian m/2*dot(y)^2
/// #         forces { y: u }
/// #         minimize time
/// #         finally { y == 1[m] }
/// #     }
/// # }
/// let heavy = Cart { m: 2.5 };
/// let cart = Cart::default();
/// let known = solve(&cart).intervals(4).run()?;
/// // The neighbouring problem starts from the known motion.
/// let previous = known.previous.expect("a motion was found");
/// let solution = solve(&heavy).intervals(4).guess(Guess::Previous(Box::new(previous))).run()?;
/// assert!((solution.objective - 5.0_f64.sqrt()).abs() < 1e-6);
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Guess {
    /// Coordinates with a goal move to it at constant speed, everything else rests.
    #[default]
    Straight,
    /// All states as at the start, and a final time of 1 s where it is free.
    Rest,
    /// The simulated motion without controls.
    Ride,
    /// [`Straight`](Self::Straight) with random controls, a random horizon and bent coordinates,
    /// from this seed.
    Perturbed(u64),
    /// The simulated motion under random controls, which change a few times, from this seed.
    Random(u64),
    /// The motion of an earlier [`Solution`](super::Solution) of the same scene, for other parameters or another
    /// number of intervals. Its contact sequence is tried first, and where that allows none, the words that edits lead to from its own.
    Previous(Box<Previous>),
}

/// How the contact sequence is found.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A cart that is pushed to 1 m.
/// #     pub Cart {
/// #         parameters { m: kg = 2 }
/// #         coordinates { y: m }
/// #         controls { u: N in -1..=1 }
/// #         lagrangian m/2*dot(y)^2
/// #         forces { y: u }
/// #         minimize time
/// #         finally { y == 1[m] }
/// #     }
/// # }
/// let cart = Cart::default();
/// let solution = solve(&cart).intervals(4).formulation(Formulation::Phases).run()?;
/// assert!(solution.status.is_solved());
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Formulation {
    /// Words, orders of contact modes with phases of free length, that are put on the control grid.
    #[default]
    Phases,
    /// The complementarity problem of [`TimeFreezing`](super::TimeFreezing), with controls of either shape.
    TimeFreezing(TimeFreezingSettings),
}

/// Where the control intervals of [`Formulation::Phases`] begin and end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ControlNodes {
    /// At equal distances, as of a controller with a clock: contacts change within them.
    #[default]
    Equal,
    /// Divided among the phases between two contacts, of equal length in each: controls may change where contacts do, so that the same
    /// number of them leads further. How many a phase has follows from its length off the grid. `B` is said where no word is better that the
    /// multipliers of a plan point to.
    Aligned,
}

impl ControlNodes {
    /// Name used on the command line and in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::Aligned => "aligned",
        }
    }
}

/// How a problem is transcribed; change fields of [`TimeFreezingSettings::default`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TimeFreezingSettings {
    /// Runge-Kutta scheme; default Radau IIA.
    pub scheme: Scheme,
    /// Its stages; default 2, in `1..=9`.
    pub stages: usize,
    /// Finite elements of a control interval; default 3, at least 1. One more than the switches that an
    /// interval should be able to hold; a touchdown is two (the jump has a beginning and an end). Where a contact bounces,
    /// there is one more ([`elements_of`](Self::elements_of)): its jump is a fall and a rise.
    pub elements: usize,
    /// Acceleration `a_bar` of the auxiliary dynamics \[unit of the gap / s^2\]; default 20, > 0. Of the
    /// order of the contact accelerations, so that the step functions stay away from 0 and 1.
    pub auxiliary_acceleration: f64,
    /// Whether to start at a coarse simulation under the guessed controls instead of the straight line to
    /// the goals; default false. Good where the motion that is looked for touches and leaves surfaces much
    /// as it does without control. Without goals it is always so.
    pub(crate) simulated_guess: bool,
    /// Largest product of a pair, and optimality error, at which [`solve`](super::solve) takes the relaxed program for
    /// solved; default 1e-4, in (0, 1). The motion that is polished from there has the contact sequence with which the program
    /// is solved exactly afterwards, with products of zero; below that the iterations double without another sequence.
    pub complementarity: f64,
    /// Rules of the relaxation, one after the other until one ends; default [`RULES`].
    pub(crate) rules: [RelaxationRule; 3],
}

/// The first one is prone to poor local minima in programs that have to end at exact solutions by themselves; for a contact sequence
/// it is mostly as good as the others, in half the iterations.
const RULES: [RelaxationRule; 3] = [
    RelaxationRule::Proportional,
    RelaxationRule::RollOff,
    RelaxationRule::Elastic,
];

impl Default for TimeFreezingSettings {
    fn default() -> Self {
        Self {
            scheme: Scheme::RadauIia,
            stages: 2,
            elements: 3,
            auxiliary_acceleration: 20.0,
            simulated_guess: false,
            complementarity: 1e-4,
            rules: RULES,
        }
    }
}

impl TimeFreezingSettings {
    /// Finite elements of a control interval of a scene: [`elements`](Self::elements), and one more where a contact bounces.
    #[must_use]
    pub fn elements_of(&self, model: &dyn Model) -> usize {
        let mut contacts = 0..model.declaration().contacts.len();
        self.elements + usize::from(contacts.any(|contact| model.restitution(contact) > 0.0))
    }
}

/// Settings of the optimal control solver; change fields of [`Settings::default`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// How the contact sequence is found; default [`Formulation::Phases`].
    pub formulation: Formulation,
    /// Controls on each interval; default constant.
    pub controls: ControlShape,
    /// Where intervals begin and end; default [`ControlNodes::Equal`].
    pub grid: ControlNodes,
    /// Where the global phase starts; default [`Guess::Straight`].
    pub guess: Guess,
    /// Number of starts, at least 1. In phases, the motions from which the best order of contacts is solved, as programs have local optima:
    /// default until two more in a row bring nothing, else until one less than the given number do. With time-freezing, the variants
    /// that are solved side by side, the first one with these settings, the others with other guesses and discretizations: default two, of
    /// which one is on a grid of about ten intervals and is carried to the one asked for, and up to four others one after the other until a
    /// motion is certified; then the word of the best motion is edited, as a program keeps its switches in their intervals. The result does not depend on the number of threads.
    pub starts: Option<usize>,
    /// Names of [`RULES`](super::RULES) of the search that are left out, to see what they earn; default none.
    pub without: Vec<String>,
    /// Work without a gain after which a search that has a plan ends, as a share of the work until then; default 0.5, at least 0. Work counts
    /// iterations times variables and rows; a gain is 0.1 % of a plan, or of an order of contacts that may become a better one.
    pub patience: f64,
    /// Free parameters (indices) that are not to be found, but keep the values of the model; default none.
    pub given_parameters: Vec<usize>,
    /// Parameters (indices) by which the optimum is differentiated, see [`Solution::gradient`](super::Solution::gradient), none of
    /// them free. Default none.
    pub gradient: Vec<usize>,
    /// Finite elements of a phase at the start; default 1, at least 1. Where the re-simulation does not confirm a plan,
    /// more are taken in the intervals that a simulation of each shows to be inaccurate; see
    /// [`Solution::elements`](super::Solution::elements).
    pub elements: usize,
    /// Radau IIA stages of an element; default 4, in `2..=9`. Order `2 n - 1`. More are taken where the re-simulation
    /// does not confirm a plan.
    pub stages: usize,
    /// Tolerance of the collocation programs; default 1e-9, in (0, 1). The motion that is returned is solved to a thousandth of it,
    /// where rounding allows that.
    pub tolerance: f64,
    /// Gap that a flight keeps where it would otherwise graze the surface \[unit of the gap\]; default
    /// 1e-5, > 0. A grazing plan is not one that a motion can follow: a hair lower it would land. Of gaps that are measured in a smaller unit
    /// than that of the scene, as they are all far smaller, it is that share.
    pub gap_margin: f64,
    /// Most programs, those of the global phase included; default 200.
    pub maximum_programs: usize,
    /// Most iterations of one program; default 500. Programs of the search of which few are solved that late end sooner.
    pub maximum_iterations: usize,
    /// Tolerance of the simulation that reads the contact sequence; default 1e-9.
    pub(crate) replay_tolerance: f64,
    /// Tolerance of the re-simulation that judges the result; default 1e-12.
    pub(crate) resimulation_tolerance: f64,
    /// Largest distance between planned and re-simulated final coordinates of a confirmed result;
    /// default 1e-6 \[unit of the coordinates\], > 0. Where a coordinate is measured in less than a thousandth of that unit, as much less.
    pub largest_distance: f64,
    /// Price of a longer motion, in sizes of the objective for a unit of the final time; default 0. Where rest costs nothing it decides among
    /// motions that cost the same.
    pub(crate) haste: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            formulation: Formulation::default(),
            grid: ControlNodes::default(),
            controls: ControlShape::default(),
            guess: Guess::default(),
            starts: None,
            without: Vec::new(),
            patience: 0.5,
            given_parameters: Vec::new(),
            gradient: Vec::new(),
            elements: 1,
            stages: 4,
            tolerance: 1e-9,
            gap_margin: 1e-5,
            maximum_programs: 200,
            maximum_iterations: 500,
            replay_tolerance: 1e-9,
            resimulation_tolerance: 1e-12,
            largest_distance: 1e-6,
            haste: 0.0,
        }
    }
}

impl Settings {
    /// Number of starts: [`starts`](Self::starts), or else that of formulation and guess.
    #[must_use]
    pub fn starts(&self) -> usize {
        self.starts
            .unwrap_or(match (&self.formulation, &self.guess) {
                (_, Guess::Previous(_)) => 1,
                (Formulation::TimeFreezing(_), _) => FREEZING_STARTS,
                (Formulation::Phases, _) => STARTS,
            })
    }

    /// Whether a rule of the search is followed.
    pub(in crate::ocp) fn uses(&self, rule: &str) -> bool {
        !self.without.iter().any(|without| without == rule)
    }

    /// Checks every field against its range.
    ///
    /// # Errors
    /// [`InputError`] names the first field outside its range.
    pub(in crate::ocp) fn check(&self) -> Result<(), InputError> {
        if !(2..=ButcherTableau::MAX_STAGES).contains(&self.stages) {
            return Err(self.refuse_stages());
        }
        for (what, value, below) in [
            ("tolerance", self.tolerance, 1.0),
            ("gap margin", self.gap_margin, f64::INFINITY),
            ("largest distance", self.largest_distance, f64::INFINITY),
        ] {
            if !(value > 0.0 && value < below) {
                return Err(refusal::out_of_range(
                    what,
                    value,
                    "",
                    format!("above 0 and below {below}"),
                ));
            }
        }
        if self.patience.is_nan() || self.patience < 0.0 {
            let what = "patience of the search";
            return Err(refusal::out_of_range(what, self.patience, "", "at least 0"));
        }
        rules::check(&self.without)?;
        let phases = matches!(self.formulation, Formulation::Phases)
            && !matches!(self.guess, Guess::Previous(_));
        let constant = self.controls == ControlShape::Constant;
        if self.grid == ControlNodes::Aligned && !(phases && constant) {
            return Err(InputError::new(
                "optimal control: intervals that are aligned with phases are of constant controls and found over words; \
                 leave out the other formulation, a previous motion or linear controls, or take an equal grid",
            ));
        }
        for (what, value) in [
            ("starts", self.starts()),
            ("elements", self.elements),
            ("most programs", self.maximum_programs),
            ("most iterations", self.maximum_iterations),
        ] {
            if value == 0 {
                return Err(refusal::out_of_range(what, 0.0, "", "at least 1"));
            }
        }
        Ok(())
    }

    pub(in crate::ocp) fn refuse_stages(&self) -> InputError {
        refusal::out_of_range(
            "Runge-Kutta stages",
            self.stages as f64,
            "",
            format!("in 2..={}", ButcherTableau::MAX_STAGES),
        )
    }
}
