//! What the caller keeps.

use hangtime_solver::Seconds;
use hangtime_solver::mpcc::Stationarity;
use hangtime_solver::nlp::Violation;
use hangtime_solver::{mpcc, nlp};
use serde::{Serialize, Serializer};

use super::misses::Nearest;
use super::parameters::{FoundParameter, OptimumGradient};
use super::previous::Previous;
use crate::model::{Model, Pieces, contact_point};
use crate::ocp::motion::control_grid::{ControlShape, Mesh, signal};
use crate::ocp::tuning::on_grid::NEAR;
use crate::refusal;
use crate::simulation::{
    ControlSignal, EventKind, InputError, ProblemSize, Residuals, Simulation, State, number,
};

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Status {
    /// A certified local optimum that an independent simulation confirms.
    Solved,
    /// Confirmed by simulation, but not all neighbouring contact sequences were decided, since programs of theirs failed or
    /// the limit of programs was reached, or a distance that the method keeps holds the plan back, see [`Solution::margins`].
    Uncertified,
    /// The independent simulation does not follow the plan: other events, or another end.
    Unconfirmed,
    /// It is shown that no controls within their bounds reach the goals: these lie beyond the bounds of coordinates, or beyond what
    /// controls do in the given time, see [`Solution::least_time`], where they alone make up the accelerations and nothing is touched.
    Infeasible,
    /// No motion to the goals was found: the programs converged to points of local infeasibility, which says nothing of others.
    NotFound,
    /// The objective still improves at an end of the final times that were looked at,
    /// [`Solution::final_times`], however far they were moved: a control without bound, or an objective that rewards
    /// ever longer motions.
    Unbounded,
    /// The observer asked to stop; the result is the best motion found so far, if there is one.
    Interrupted,
    /// A program ended without a solution, for the reason given.
    Failed(nlp::Status),
}

impl Serialize for Status {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Status {
    /// Whether the result is a confirmed and certified local optimum.
    #[must_use]
    pub fn is_solved(self) -> bool {
        self == Self::Solved
    }

    /// Name used in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Uncertified => "uncertified",
            Self::Unconfirmed => "unconfirmed",
            Self::Infeasible => "infeasible",
            Self::NotFound => "not_found",
            Self::Unbounded => "unbounded",
            Self::Interrupted => "interrupted",
            Self::Failed(_) => "failed",
        }
    }
}

/// What became of the complementarity problem of [`Formulation::TimeFreezing`](super::Formulation::TimeFreezing): relaxed, it
/// gives the contact sequence of the motion that is polished, and with that sequence it is solved exactly.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TimeFreezingReport {
    /// How it ended: [`Uncertified`](mpcc::Status::Uncertified) at an exact solution, as the certificate is that of the
    /// polished motion; [`Relaxed`](mpcc::Status::Relaxed) where none is known.
    #[serde(serialize_with = "in_words")]
    pub status: mpcc::Status,
    /// Its objective, with the step equilibration.
    pub objective: f64,
    /// Length of its motion \[s\].
    pub horizon: f64,
    /// Its residuals, which have no `dual` in JSON; the complementarity is the largest product of a pair.
    #[serde(serialize_with = "without_dual")]
    pub residuals: Residuals,
    /// What of the scene it leaves out, and the polished motion does not: at a relaxed solution forces and
    /// impulses of contacts, which are 0 in its functions and of which it has no conditions.
    pub left_out: Vec<&'static str>,
    /// The relaxed solution before the polish.
    pub relaxed: RelaxedReport,
    /// Size of the relaxed program.
    pub size: ProblemSize,
    /// Interior point iterations, those of the relaxed program among them.
    pub iterations: usize,
    /// CPU time, that of the relaxed program included \[s\].
    pub seconds: f64,
}

fn in_words<S: Serializer>(status: &mpcc::Status, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(status)
}

fn without_dual<S: Serializer>(known: &Residuals, serializer: S) -> Result<S::Ok, S::Error> {
    let complementarity = ("complementarity", known.complementarity);
    serializer.collect_map([("primal", known.primal), complementarity])
}

/// A relaxed solution of the complementarity problem of the time-freezing formulation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RelaxedReport {
    /// Its objective.
    pub objective: f64,
    /// The largest product of a pair.
    pub complementarity: f64,
    /// Interior point iterations.
    pub iterations: usize,
    /// Whether the contact sequence of the motion was found by way of it. Where no start led to a motion, it is that of the
    /// search over words.
    pub led_to_motion: bool,
}

/// A local optimum that several starts led to, or one of them alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Optimum {
    /// Its objective.
    pub objective: f64,
    /// Length of the motion \[s\].
    pub horizon: f64,
    /// Status of the first start that ended there.
    pub status: Status,
    /// What is proved about its contact sequence.
    pub stationarity: Stationarity,
    /// Number of contact switches of the plan.
    pub switches: usize,
    /// Control intervals of the grid that it was seen on.
    pub intervals: usize,
    /// The starts that ended there, from 0.
    pub starts: Vec<usize>,
    /// Where all was looked that ended there, the starts among it.
    pub sources: Vec<Source>,
}

/// How many orders of contacts a search has tried off the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct WordCounts {
    /// Orders whose programs were started.
    pub tried: usize,
    /// Those without a solution from any guess: whether they allow a motion, and how good a one, is undecided.
    pub failed: usize,
}

/// Where a search looked for a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Source {
    /// The simulated motion of the scene's guess, as it is or with its contact sequence solved.
    Guess,
    /// Among words, orders of contact modes.
    Words,
    /// From a known motion, or a variant of the time-freezing formulation, from 0.
    Start(usize),
}

impl Serialize for Source {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl std::fmt::Display for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Guess => f.write_str("guess"),
            Self::Words => f.write_str("words"),
            Self::Start(start) => write!(f, "start {start}"),
        }
    }
}

/// A motion that was confirmed and better than all before it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Improvement {
    /// CPU time of the call until it was found \[s\].
    pub cpu: f64,
    /// Its objective.
    pub objective: f64,
    /// Its status at that time.
    pub status: Status,
    /// Where it was found.
    pub source: Source,
}

/// Work done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Programs solved.
    pub programs: usize,
    /// Interior point iterations of the global phase.
    pub global_iterations: usize,
    /// Interior point iterations of the collocation programs.
    pub iterations: usize,
    /// Factorizations of all programs.
    pub factorizations: usize,
    /// Changes of the contact sequence that improved the objective.
    pub repairs: usize,
}

impl Counts {
    /// Adds the work of another run.
    pub(in crate::ocp) fn add(&mut self, other: &Self) {
        self.programs += other.programs;
        self.global_iterations += other.global_iterations;
        self.iterations += other.iterations;
        self.factorizations += other.factorizations;
        self.repairs += other.repairs;
    }
}

/// A violation between the places where a condition is imposed, or by the forces of the re-simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Excess {
    /// Name of the coordinate, path constraint or condition on forces.
    pub name: String,
    /// By how much it leaves its bounds, in its unit.
    pub amount: f64,
    /// That unit.
    pub unit: String,
    /// When \[s\].
    pub time: f64,
}

impl Excess {
    /// It in words.
    pub(in crate::ocp) fn words(&self) -> String {
        format!(
            "`{}` is violated by {:.1e} {} at {:.6} s of the re-simulation",
            self.name, self.amount, self.unit, self.time
        )
    }
}

/// A distance that a plan keeps for the sake of the method, and that costs it something.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Margin {
    /// What is kept, and where.
    pub name: String,
    /// How much of it; of the time in which a contact comes to rest the jump of its normal velocity at the first bounce, `(1 + e) v_n`
    /// with the restitution `e` and the normal velocity `v_n` after the landing.
    pub amount: f64,
    /// The unit of that: of a gap, of its velocity, or seconds.
    pub unit: String,
    /// What the objective would gain without it, to first order.
    pub cost: f64,
    /// Whether it is [`Settings::gap_margin`](super::Settings::gap_margin). Others that cost more than a millionth of
    /// the objective leave the result [`Uncertified`](Status::Uncertified).
    pub chosen: bool,
}

/// Result of a run.
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
/// let solution = solve(&cart).intervals(4).run()?;
/// assert!(solution.status.is_solved());
/// // Full push all the way: t = sqrt(2 m y / u).
/// assert!((solution.objective - 2.0).abs() < 1e-6);
/// assert!((solution.at(1.0)?["y"] - 0.25).abs() < 1e-6);
/// println!("{solution}");
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Solution {
    /// Why it ended.
    pub status: Status,
    /// Objective of the plan.
    pub objective: f64,
    /// What the objective is measured in, by the largest of its derivatives, in the unit of the objective; 0 without a plan. Less
    /// than `1e-8` of it is what the tolerance explains.
    pub objective_unit: f64,
    /// Length of the motion \[s\].
    pub horizon: f64,
    /// Shortest and longest final time that was looked at \[s\]; where the final time is free, the range is moved until
    /// the plan lies inside.
    pub final_times: (f64, f64),
    /// The values of the free parameters; empty where nothing is free, or no motion was found. The motion is that of the scene
    /// with these values.
    pub parameters: Vec<FoundParameter>,
    /// How the optimum changes with given parameters, where that is asked for by
    /// [`Settings::gradient`](super::Settings::gradient); without a plan that was polished why there are no derivatives.
    pub gradient: Option<OptimumGradient>,
    /// What is proved about the contact sequence. `S`: nowhere do gap and force of a contact vanish together, and no
    /// switch sticks to a jump of the controls, so that the sequence has no neighbours. `B`: no neighbour is better.
    pub stationarity: Stationarity,
    /// Largest difference of a final coordinate between plan and re-simulation.
    pub resimulation_error: f64,
    /// Largest difference of a final velocity between plan and re-simulation. Coordinates are what is judged; velocities are less
    /// accurate by the rates of the motion.
    pub resimulation_velocity_error: f64,
    /// That difference as one of a motion of the order of a metre and a radian: what is judged.
    pub(in crate::ocp) departure: f64,
    /// Whether it is a motion of a problem in which every longer one costs less.
    pub(in crate::ocp) is_longest: bool,
    /// Objective of the re-simulated motion, by its own quadrature; NaN without a motion, and where the objective reads forces or
    /// impulses of contacts, of which the re-simulation is looked at more coarsely.
    pub resimulated_objective: f64,
    /// Its difference from that of the plan, as a share of what is let pass.
    pub(in crate::ocp) cost_departure: f64,
    /// The least distance, of all coordinates, that is let pass between plan and re-simulation.
    pub(in crate::ocp) let_pass: f64,
    /// The first contact event or bound in which plan and re-simulation differ, in words.
    pub disagreement: Option<String>,
    /// Residuals of the plan: violation of its equations and bounds, gradient of the Lagrangian,
    /// and largest `min(gap, normal acceleration)`.
    pub residuals: Residuals,
    /// (time \[s\], kind, contact) of the switches of the plan; a closing counts as an impact.
    pub planned_events: Vec<(f64, EventKind, usize)>,
    /// Largest violation of the bounds of each coordinate, of each path constraint and of each condition on forces or impulses along the
    /// re-simulation, where there is any; no more than plan and re-simulation may differ unless bounds are asked for at the nodes only.
    pub excess: Vec<Excess>,
    /// Elements in which plan and re-simulation agree better at bounds, where they differ there.
    pub(in crate::ocp) finer: Option<Mesh>,
    /// Distances that hold the plan back, the dearest first.
    pub margins: Vec<Margin>,
    /// Controls of each interval, or at each node where they are linear in between.
    pub controls: Vec<Vec<f64>>,
    /// When each interval begins and the last one ends \[s\]: at equal distances, unless [`Settings::grid`](super::Settings::grid) is
    /// [`ControlNodes::Aligned`](super::ControlNodes::Aligned).
    pub control_times: Vec<f64>,
    /// What the controls are on an interval.
    pub shape: ControlShape,
    /// Finite elements of a phase in each interval: more than asked for where the re-simulation wanted them.
    pub elements: Vec<usize>,
    /// The event-driven re-simulation of the plan's controls; absent without a plan. It ends with the impacts that the plan ends with.
    pub motion: Option<Simulation>,
    /// Worst violated rows, if a program failed.
    pub violations: Vec<Violation>,
    /// Least final time \[s\], to a thousandth, in which the goals are not known to be out of reach, where they are in the given one.
    pub least_time: Option<f64>,
    /// What the nearest of many simulated motions misses, where no plan was found.
    pub nearest: Option<Nearest>,
    /// Size of the program of the plan.
    pub size: ProblemSize,
    /// Work done.
    pub counts: Counts,
    /// CPU time of all starts; what is not listed by kind is simulation and bookkeeping.
    pub seconds: Seconds,
    /// The complementarity problem of the time-freezing formulation, where it was asked for.
    pub time_freezing: Option<TimeFreezingReport>,
    /// The motion as a start for a neighbouring problem, for [`Guess::Previous`](super::Guess::Previous); absent
    /// without a plan.
    pub previous: Option<Previous>,
    /// Motions from which the best order of contacts was solved; of the time-freezing formulation its variants.
    pub starts: usize,
    /// The least objective of an order of contacts that reaches the goals off the grid, with controls that change at any time; to the
    /// tolerance of words, a ten-thousandth. None where no order reaches them, or none was tried.
    pub bound: Option<f64>,
    /// Orders of contacts that were tried off the grid.
    pub words: WordCounts,
    /// Whether the motion is a simulated one, of the scene's guess or under random controls.
    pub(in crate::ocp) is_simulated: bool,
    /// The distinct local optima that the starts ended at, the best first.
    pub optima: Vec<Optimum>,
    /// The first motion that was confirmed and every better one after it, in order.
    pub improvements: Vec<Improvement>,
}

/// Difference of objectives, as a share of what they are measured in, that the tolerance of the solver explains.
const EXPLAINED: f64 = 1e-8;

impl Solution {
    /// By how much another objective may differ from this one within a relative tolerance: of an objective that vanishes by no less than what the
    /// tolerance of the solver explains.
    pub(in crate::ocp) fn tolerated(&self, relative: f64) -> f64 {
        (relative * self.objective.abs()).max(EXPLAINED * self.objective_unit)
    }

    pub(in crate::ocp) fn without_motion(
        status: Status,
        violations: Vec<Violation>,
        counts: Counts,
    ) -> Self {
        Self {
            status,
            objective: f64::NAN,
            objective_unit: 0.0,
            horizon: f64::NAN,
            final_times: (f64::NAN, f64::NAN),
            parameters: Vec::new(),
            gradient: None,
            stationarity: Stationarity::None,
            resimulation_error: f64::INFINITY,
            resimulation_velocity_error: f64::INFINITY,
            departure: f64::INFINITY,
            resimulated_objective: f64::NAN,
            cost_departure: 0.0,
            let_pass: 0.0,
            is_longest: false,
            disagreement: None,
            residuals: Residuals {
                primal: f64::NAN,
                dual: f64::NAN,
                complementarity: f64::NAN,
            },
            planned_events: Vec::new(),
            margins: Vec::new(),
            excess: Vec::new(),
            finer: None,
            controls: Vec::new(),
            control_times: Vec::new(),
            shape: ControlShape::default(),
            elements: Vec::new(),
            motion: None,
            violations,
            least_time: None,
            nearest: None,
            size: ProblemSize::default(),
            counts,
            seconds: Seconds::default(),
            time_freezing: None,
            previous: None,
            starts: 0,
            bound: None,
            words: WordCounts::default(),
            is_simulated: false,
            optima: Vec::new(),
            improvements: Vec::new(),
        }
    }

    /// True if control intervals are divided among the phases instead of being of equal length.
    pub(in crate::ocp) fn is_aligned(&self) -> bool {
        let driven = self.controls.first().is_some_and(|u| !u.is_empty());
        driven && self.previous.as_ref().is_some_and(Previous::is_aligned)
    }

    /// What is proved about the contact sequence, and where another one may be better: off the grid one is, by more than the grid is let cost,
    /// or programs of others have no solution, which proves nothing about them.
    #[must_use]
    pub fn certificate(&self) -> String {
        let name = self.stationarity.name();
        let outdone = |bound: &f64| self.objective - bound > self.tolerated(NEAR);
        if let Some(bound) = self.bound.filter(outdone) {
            return format!(
                "{name}, local; a better order may exist: {} off the grid, not found on these intervals; try another number of \
                 intervals, or more starts",
                number(bound)
            );
        }
        let proof = match self.stationarity {
            Stationarity::S => "a local optimum whose contact sequence has no neighbours",
            Stationarity::B => {
                "a local optimum, and no neighbouring contact sequence gives a better one"
            }
            Stationarity::None => "no proof that neighbouring contact sequences are no better",
        };
        let WordCounts { tried, failed } = self.words;
        match failed {
            0 => format!("{name}: {proof}"),
            _ => format!("{name}: {proof}; {failed} of {tried} orders of contacts are undecided"),
        }
    }

    /// Whether the objective of the re-simulated motion is another one than that of the plan.
    pub(in crate::ocp) fn costs_otherwise(&self) -> bool {
        self.cost_departure > 1.0
    }

    /// The controls over time; none without a plan.
    #[must_use]
    pub fn signal(&self) -> ControlSignal {
        if self.controls.is_empty() {
            return ControlSignal::Zero;
        }
        signal(
            self.shape,
            self.control_times.clone(),
            self.controls.clone(),
        )
    }

    /// Contacts that are struck right after the end of the re-simulated motion, and their normal velocity `v_n` before that, in the
    /// unit of the gap per second: what such an impact does and costs is no part of the result. These are the ones with a gap of
    /// at most the distance `d` that is let pass between plan and re-simulation (1e-6 in scenes of the order of a metre, see
    /// [`Settings::largest_distance`](super::Settings::largest_distance)) and `v_n < -d/T` at the end. None without a motion.
    #[must_use]
    pub fn struck_after_the_end(&self, model: &dyn Model) -> Vec<(usize, f64)> {
        let Some(motion) = &self.motion else {
            return Vec::new();
        };
        let trajectory = &motion.trajectory;
        let (Some(time), Some(q), Some(v)) = (
            trajectory.time.last(),
            trajectory.q.last(),
            trajectory.v.last(),
        ) else {
            return Vec::new();
        };
        let u = trajectory.u.last().map_or(&[][..], Vec::as_slice);
        let mut input = [q, v, u].concat();
        input.resize(model.declaration().inputs(), *time);
        let pieces = Pieces::at(model, &input);
        let mut point = vec![0.0; contact_point::length(q.len())];
        let mut struck = Vec::new();
        for contact in 0..model.declaration().contacts.len() {
            model.contact(contact, &input, &mut point);
            let velocity = point[contact_point::NORMAL_VELOCITY];
            let touches = point[contact_point::GAP].abs() <= self.let_pass;
            if touches && velocity < -self.let_pass / self.horizon && !pieces.is_idle(contact) {
                struck.push((contact, velocity));
            }
        }
        struck
    }

    /// The state of the re-simulated motion at a time, right after an impact at that time; see
    /// [`Simulation::at`](crate::simulation::Simulation::at).
    ///
    /// # Errors
    /// [`InputError`] outside of the motion, and if none was found.
    pub fn at(&self, time: f64) -> Result<State, InputError> {
        match &self.motion {
            Some(motion) => motion.at(time),
            None => Err(refusal::unsupported(
                "a state of a result without a motion",
                "its diagnosis says why none was found",
            )),
        }
    }

    /// Why the run did not end with a certified motion, in one line; `None` if it did.
    #[must_use]
    pub fn diagnosis(&self) -> Option<String> {
        let worst = self.hardest();
        match self.status {
            Status::Solved => None,
            Status::Uncertified if self.margins.iter().any(|margin| !margin.chosen) => {
                let margin = self.margins.iter().find(|margin| !margin.chosen);
                let (name, cost) = margin.map_or(("", 0.0), |m| (&m.name[..], m.cost));
                Some(format!(
                    "the {name} holds the plan back by about {cost:.1e}; choose another number of intervals"
                ))
            }
            Status::Uncertified if self.is_simulated => Some(
                "no plan was found that is as good as this motion, which is simulated under the scene's own guess or under random controls; \
                 try more starts or another number of intervals"
                    .to_owned(),
            ),
            Status::Uncertified if self.disagreement.is_some() => {
                let difference = self.disagreement.as_deref().unwrap_or_default();
                Some(format!(
                    "the elements of the plan are too coarse: {difference}; raise the number of stages or of intervals"
                ))
            }
            Status::Uncertified => Some(format!(
                "not all neighbouring contact sequences were decided in {} programs; try more starts or another \
                 number of intervals",
                self.counts.programs
            )),
            Status::Unconfirmed => {
                let difference = match &self.disagreement {
                    Some(event) => format!("does not agree with the plan ({event})"),
                    None if self.costs_otherwise() => format!(
                        "costs {} and the plan {}",
                        number(self.resimulated_objective),
                        number(self.objective)
                    ),
                    None => "ends too far from the plan".to_owned(),
                };
                Some(format!(
                    "the re-simulation {difference}, {:.1e} away at the end; raise the number of stages or of \
                     intervals, or `gap_margin` of the settings in Rust",
                    self.resimulation_error
                ))
            }
            Status::Infeasible => Some(format!(
                "no controls within their bounds reach the goals, with {}; {}; {worst}",
                self.times_looked_at(),
                self.enough_time()
            )),
            Status::NotFound => Some(format!(
                "no motion to the goals was found, with {}, which does not show that there is none; {}; {worst}",
                self.times_looked_at(),
                self.advice()
            )),
            Status::Unbounded if self.is_longest => Some(
                "rest costs nothing, and every longer motion costs less, as far as can be told; bound the final time, as in `finally { time <= 10 [s] }`".to_owned(),
            ),
            Status::Unbounded => Some(format!(
                "the objective still improves at a final time of {:.3e} s, the end of those from {:.3e} to {:.3e} s that \
                 were looked at; bound the controls or the final time",
                self.horizon, self.final_times.0, self.final_times.1
            )),
            Status::Interrupted if self.motion.is_none() => {
                Some("stopped before a first motion was found".to_owned())
            }
            Status::Interrupted => Some(format!(
                "stopped; the best motion so far ends {:.1e} from its re-simulation, and better ones may exist",
                self.resimulation_error
            )),
            Status::Failed(status) => Some(format!("{status}; {worst}")),
        }
    }

    /// What is hardest to meet: for the nearest of simulated motions, or else for the program that came nearest.
    fn hardest(&self) -> String {
        if let Some(nearest) = &self.nearest {
            return nearest.words();
        }
        self.violations.first().map_or_else(
            || "no row is violated".to_owned(),
            |row| format!("worst row: {}, violated by {:.1e}", row.name, row.amount),
        )
    }

    /// What would make goals possible that are not.
    fn enough_time(&self) -> String {
        match self.least_time {
            Some(time) => format!(
                "a `horizon` of {} s or more may do, or wider bounds of the controls",
                number(time)
            ),
            None => "no other `horizon` helps: ask for other goals, within the bounds and of what the controls move".to_owned(),
        }
    }

    /// What may lead to a motion: first what a search with more effort cannot change.
    fn advice(&self) -> &'static str {
        if self.final_times.0 == self.final_times.1 {
            "try a longer `horizon`, or let `time` occur in `minimize` or `finally`; wider bounds of the controls; goals as \
             inequalities; then more intervals or starts"
        } else {
            "try wider bounds of the controls or of the time; goals as inequalities; a `start` or `horizon` nearer to the \
             motion meant; then more intervals or starts"
        }
    }

    /// The final times among which a motion was looked for, in words.
    fn times_looked_at(&self) -> String {
        match self.final_times {
            (first, last) if first == last => format!("a final time of {first:.3} s"),
            (first, last) => format!("final times from {first:.3} to {last:.3} s"),
        }
    }
}
