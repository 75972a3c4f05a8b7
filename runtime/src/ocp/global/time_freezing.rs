//! The optimal control problem as one complementarity problem: time-freezing and FESD.

use crate::dcs::HeavisideSystem;
use crate::fesd::finite_element::State;
use crate::fesd::transcription::{
    Controls, Guess, Task, Transcription, Weights, size_groups, transcribe,
};
use crate::model::{ConstraintRelation, ImpactLaw, Model, OptimalControlDeclaration};
use crate::mpcc::Mpcc;
use crate::nlp::NlpProblem;
use crate::ocp::motion::final_times::FinalTimes;
use crate::ocp::motion::targets::{horizon_guess, targets};
use crate::ocp::problem::{Horizon, Problem, bounds};
use crate::ocp::settings::TimeFreezingSettings;
use crate::rk::ButcherTableau;
use crate::simulation::{InputError, SizeGroup};
use crate::time_freezing::TimeFreezingSystem;

/// An optimal control problem on a [`Model`] as a mathematical program with complementarity constraints:
/// the time-freezing system, transcribed by finite elements with switch detection in step form. Solve it
/// with [`mpcc::solve`](crate::mpcc::solve).
///
/// Bounds of coordinates are imposed at the ends of the finite elements, bounds of controls everywhere.
/// The starting point is made from the problem alone: coordinates with a goal move to it at constant speed,
/// the others rest; without goals, it is a coarse simulation. Controls start at zero, or as
/// near to it as their bounds allow.
///
/// Sources: Nurkanovic, Albrecht, Brogliato, Diehl, Automatica 158 (2023) 111295 (time-freezing);
/// Nurkanovic, Sperl, Albrecht, Diehl, Numerische Mathematik 2024 (finite elements).
#[derive(Clone)]
pub struct TimeFreezing<'a> {
    transcription: Transcription<'a>,
    intervals: usize,
}

/// One motion out of a [`TimeFreezing`] program.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::ocp) struct TimeFreezingMotion {
    /// Length \[s\].
    pub(in crate::ocp) horizon: f64,
    /// Controls of each interval.
    pub(in crate::ocp) controls: Vec<Vec<f64>>,
    /// Physical time at the end of each element \[s\].
    pub(in crate::ocp) time: Vec<f64>,
    /// Coordinates there.
    pub(in crate::ocp) q: Vec<Vec<f64>>,
    /// Velocities there.
    pub(in crate::ocp) v: Vec<Vec<f64>>,
    /// Mean step function of each contact in each element: 1 free, 0 jump, between in sustained contact.
    pub(in crate::ocp) step_functions: Vec<Vec<f64>>,
}

impl<'a> TimeFreezing<'a> {
    /// Transcribes a problem.
    ///
    /// # Errors
    /// [`InputError`] if the problem or the settings are refused.
    pub fn new(
        model: &'a dyn Model,
        problem: &Problem,
        settings: &TimeFreezingSettings,
    ) -> Result<Self, InputError> {
        problem.check(model)?;
        let mut contacts = model.declaration().contacts.iter();
        if let Some(contact) = contacts.find(|contact| contact.law != ImpactLaw::Inelastic) {
            return Err(InputError::unsupported(
                format!(
                    "restitution of `{}` in the time-freezing formulation",
                    contact.name
                ),
                "leave the formulation at its default",
            ));
        }
        let refuse = |what: &str, value: f64, bound: String| {
            Err(InputError::out_of_range(what, value, "", bound))
        };
        if settings.elements == 0 {
            return refuse("finite elements of an interval", 0.0, "at least 1".into());
        }
        let complementarity = settings.complementarity;
        if !(complementarity > 0.0 && complementarity < 1.0) {
            return refuse("complementarity", complementarity, "in (0, 1)".into());
        }
        let a_bar = settings.auxiliary_acceleration;
        if !(a_bar > 0.0 && a_bar.is_finite()) {
            return refuse("auxiliary acceleration", a_bar, "above 0".into());
        }
        let Some(tableau) = ButcherTableau::new(settings.scheme, settings.stages) else {
            return refuse(
                "Runge-Kutta stages",
                settings.stages as f64,
                format!("in 1..={}", ButcherTableau::MAX_STAGES),
            );
        };
        let system = TimeFreezingSystem::new(model, a_bar);
        let task = task(model, problem, settings)?;
        Ok(Self {
            transcription: transcribe(HeavisideSystem::new(system), &tableau, task),
            intervals: problem.intervals,
        })
    }

    /// Length of each element in numerical time \[s\], at the point `x` of the program.
    #[must_use]
    pub fn numerical_lengths(&self, x: &[f64]) -> Vec<f64> {
        let program = &self.transcription;
        (0..program.elements())
            .map(|e| program.numerical_length(x, e))
            .collect()
    }

    /// What its variables and rows are there for.
    #[must_use]
    pub fn groups(&self) -> Vec<SizeGroup> {
        size_groups(&self.transcription)
    }

    /// The motion at the point `x` of the program.
    #[must_use]
    pub(in crate::ocp) fn motion(&self, x: &[f64]) -> TimeFreezingMotion {
        let program = &self.transcription;
        let elements = 0..program.elements();
        let states: Vec<State> = elements.clone().map(|e| program.state(x, e)).collect();
        TimeFreezingMotion {
            horizon: program.horizon(x),
            controls: (0..self.intervals)
                .map(|k| program.controls(x, k))
                .collect(),
            time: states.iter().map(|state| state.time).collect(),
            step_functions: elements
                .clone()
                .map(|e| {
                    (0..program.contacts())
                        .map(|i| program.mean_alpha(x, e, i))
                        .collect()
                })
                .collect(),
            q: states.iter().map(|state| state.q.clone()).collect(),
            v: states.into_iter().map(|state| state.v).collect(),
        }
    }
}

/// The problem in plain numbers.
fn task(
    model: &dyn Model,
    problem: &Problem,
    settings: &TimeFreezingSettings,
) -> Result<Task, InputError> {
    let n = problem.q.len();
    let (lower, upper) = bounds(model);
    let horizon = horizon_guess(problem, model);
    let controls = if lower.len() == n {
        Controls::Fixed(Vec::new())
    } else {
        Controls::Free {
            guess: (n..lower.len())
                .map(|k| 0.0_f64.clamp(lower[k], upper[k]))
                .collect(),
            lower: lower[n..].to_vec(),
            upper: upper[n..].to_vec(),
        }
    };
    let mut stated = Stated::default();
    if let Some(declared) = model.declaration().optimal_control {
        stated = state(model, &declared, &problem.start())?;
    }
    let Stated { goals, weights } = stated;
    let guess = if settings.simulated_guess || goals.is_empty() {
        Guess::Simulated
    } else {
        let targets = targets(problem, model).into_iter().zip(&problem.q);
        let velocity =
            targets.map(|(target, q)| target.map_or(0.0, |target| (target - q) / horizon));
        Guess::Line(velocity.collect())
    };
    Ok(Task {
        start: State {
            time: 0.0,
            q: problem.q.clone(),
            v: problem.v.clone(),
        },
        horizon,
        horizon_bounds: match problem.horizon {
            Horizon::Fixed(_) => None,
            Horizon::Free { .. } => {
                let range = FinalTimes::around(problem, horizon);
                Some((range.shortest, range.longest))
            }
        },
        controls,
        intervals: problem.intervals,
        elements: settings.elements,
        coordinate_bounds: (lower[..n].to_vec(), upper[..n].to_vec()),
        goals,
        objective: weights,
        guess,
    })
}

/// What a scene declares, in plain numbers.
#[derive(Default)]
struct Stated {
    /// (component of `(q, v)`, value).
    goals: Vec<(usize, f64)>,
    weights: Weights,
}

/// What the scene declares, as far as this formulation can state it: a running cost `w u'u`, a final cost that is
/// linear in the state and the final time, and terminal conditions that give one component of the state a value.
fn state(
    model: &dyn Model,
    declared: &OptimalControlDeclaration,
    start: &[f64],
) -> Result<Stated, InputError> {
    let refuse = |what: &str| {
        Err(InputError::unsupported(
            format!("{what} in the time-freezing formulation"),
            "leave the formulation at its default",
        ))
    };
    if let Some(constraint) = declared.constraints.first() {
        return refuse(&format!("the path constraint `{}`", constraint.name));
    }
    if !declared.free_start.is_empty() {
        return refuse("a free initial value");
    }
    if !declared.terminal_hessian.entries.is_empty() {
        return refuse("a nonlinear final cost or terminal condition");
    }
    let mut stated = Stated::default();
    if declared.running_cost {
        match effort_weight(model, declared, start) {
            Some(weight) => stated.weights.control_effort = weight,
            None => return refuse("a running cost that is not a multiple of `u'u`"),
        }
    }
    let Stated { goals, weights } = &mut stated;
    let mut z = start.to_vec();
    z.push(1.0);
    let mut values = vec![0.0; declared.terminal_functions()];
    let mut slopes = vec![0.0; declared.terminal_jacobian.entries.len()];
    model.terminal_functions(&z, &mut values);
    model.terminal_jacobian(&z, &mut slopes);
    let time = start.len();
    let row = |function: usize| {
        let entries = declared.terminal_jacobian.entries.iter().zip(&slopes);
        let own =
            entries.filter(move |(entry, slope)| entry.0 as usize == function && **slope != 0.0);
        own.map(|(entry, &slope)| (entry.1 as usize, slope))
    };
    if declared.final_cost {
        for (k, slope) in row(0) {
            if k == time {
                weights.final_time += slope;
            } else {
                weights.final_state.push((k, slope));
            }
        }
    }
    for (i, goal) in declared.goals.iter().enumerate() {
        let function = i + usize::from(declared.final_cost);
        let entries: Vec<(usize, f64)> = row(function).collect();
        match entries[..] {
            [(k, slope)] if k < time && goal.relation == ConstraintRelation::Zero => {
                goals.push((k, z[k] - values[function] / slope));
            }
            _ => {
                return refuse(&format!(
                    "the terminal condition `{}`, which is not a value of one component,",
                    goal.name
                ));
            }
        }
    }
    Ok(stated)
}

/// The weight `w` of a running cost `w u'u`; nothing for another one. It reads nothing but the controls, its second
/// derivatives are `2 w` for each of them and do not change with them, and it vanishes with its gradient at 0.
fn effort_weight(
    model: &dyn Model,
    declared: &OptimalControlDeclaration,
    start: &[f64],
) -> Option<f64> {
    let controls = model.declaration().controls.len();
    let own = start.len()..start.len() + controls;
    let jacobian = declared.path_jacobian.entries;
    let hessian = declared.path_hessian.entries;
    let reads_controls = jacobian.iter().all(|e| own.contains(&(e.1 as usize)));
    let pure = hessian.iter().all(|e| e.0 == e.1) && hessian.len() == controls;
    if !reads_controls || !pure {
        return None;
    }
    let mut x = start.to_vec();
    x.resize(model.declaration().inputs(), 0.0);
    let (mut value, mut slopes) = ([0.0], vec![0.0; jacobian.len()]);
    let mut curvatures = vec![0.0; hessian.len()];
    model.path_functions(&x, &mut value);
    model.path_jacobian(&x, &mut slopes);
    model.path_hessian(&x, &[1.0], &mut curvatures);
    let twice = *curvatures.first()?;
    let alike = |curvatures: &[f64]| curvatures.iter().all(|curvature| *curvature == twice);
    let even = value == [0.0] && slopes.iter().all(|slope| *slope == 0.0);
    // A second derivative that is the same at points of very different size does not depend on them.
    let constant = [1e-3, 1.0, 1e3].iter().all(|size| {
        x[own.clone()].fill(*size);
        model.path_hessian(&x, &[1.0], &mut curvatures);
        alike(&curvatures)
    });
    (even && constant).then_some(0.5 * twice)
}

impl NlpProblem for TimeFreezing<'_> {
    fn variables(&self) -> usize {
        self.transcription.variables()
    }

    fn constraints(&self) -> usize {
        self.transcription.constraints()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.transcription.variable_bounds(lower, upper);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.transcription.constraint_bounds(lower, upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        self.transcription.initial_point(x);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        self.transcription.objective(x)
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.transcription.gradient(x, gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.transcription.constraint_values(x, c);
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.transcription.jacobian_pattern()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        self.transcription.jacobian_values(x, values);
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.transcription.hessian_pattern()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        self.transcription
            .hessian_values(x, weight, multipliers, values);
    }

    fn variable_name(&self, index: usize) -> String {
        self.transcription.variable_name(index)
    }

    fn constraint_name(&self, index: usize) -> String {
        self.transcription.constraint_name(index)
    }
}

impl Mpcc for TimeFreezing<'_> {
    fn complementarities(&self) -> &[(usize, usize)] {
        self.transcription.complementarities()
    }

    fn complementarity_name(&self, index: usize) -> String {
        self.transcription.complementarity_name(index)
    }

    fn vanishing_sides(&self, x: &[f64], vanishes: &mut [bool]) -> bool {
        self.transcription.vanishing_sides(x, vanishes)
    }

    fn neighbour(&self, index: usize, x: &mut [f64], vanishes: &mut [bool]) -> bool {
        self.transcription.neighbour(index, x, vanishes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mpcc::{self, Status};

    crate::model! {
        /// A cart that is pushed.
        Cart {
            parameters { m: kg = 2 }
            coordinates { y: m }
            controls { u: N in -1..=1 }
            lagrangian m/2*dot(y)^2
            forces { y: u }
            minimize time
            finally { y == 1[m], dot(y) == 0[m/s] }
        }
    }

    crate::model! {
        /// A point mass in a bowl that is parabolic.
        Bowl {
            parameters { m: kg = 1, g: m/s^2 = 9.81, c: 1/m = 0.5 }
            coordinates { y: m, z: m }
            lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
            surface ground: z - c*y^2 >= 0
            impact ground: inelastic
        }
    }

    crate::model! {
        /// A mass that falls on a table and is pushed along it.
        Puck {
            parameters { m: kg = 1, g: m/s^2 = 9.81 }
            coordinates { y: m, z: m }
            controls { u: N in -4..=4 }
            lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
            forces { y: u }
            surface table: z >= 0
            impact table: inelastic
            minimize integral(u^2)
            finally { y == 0.5[m] }
            horizon 1 [s]
        }
    }

    crate::model! {
        /// A mass that falls on a table.
        Stone {
            parameters { m: kg = 1, g: m/s^2 = 9.81 }
            coordinates { z: m }
            controls { u: N in -4..=4 }
            lagrangian m/2*dot(z)^2 - m*g*z
            forces { z: u }
            surface table: z >= 0
            impact table: inelastic
            minimize 2*integral(u^2)
            start { z: 0.1 [m] }
            horizon 1 [s]
        }
    }

    fn solve(
        model: &dyn Model,
        problem: &Problem,
        simulated_guess: bool,
    ) -> (mpcc::Solution, TimeFreezingMotion) {
        let settings = TimeFreezingSettings {
            simulated_guess,
            ..TimeFreezingSettings::default()
        };
        let mut program = TimeFreezing::new(model, problem, &settings).expect("valid");
        let solution = mpcc::solve(&mut program, &mpcc::Settings::default()).expect("accepted");
        let motion = program.motion(&solution.x);
        (solution, motion)
    }

    #[test]
    fn motion_without_contact_least_time_is_bang_bang() {
        // Half of the way at u / m = 1/2 from rest, the other half braking: 1 m takes sqrt(8) s.
        let cart = Cart::default();
        let problem = Problem::of(&cart, 4);
        let (solution, motion) = solve(&cart, &problem, false);
        assert_eq!(solution.status, Status::Solved);
        // Constant forces are integrated exactly; the solver's tolerance is 1e-8.
        assert!((motion.horizon - 8.0_f64.sqrt()).abs() < 1e-7, "{motion:?}");
        let controls: Vec<f64> = motion.controls.iter().map(|u| u[0].round()).collect();
        assert_eq!(controls, [1.0, 1.0, -1.0, -1.0]);
    }

    #[test]
    fn push_along_a_table_effort_is_that_of_the_motion_without_weight() {
        // Contact slows the clock, but along the table nothing but u acts. From rest to 0.5 m in 1 s with four
        // constant pieces: the displacement is sum_k u_k h^2 (4 - k - 1/2), so u is proportional to
        // 4 - k - 1/2, and the effort is d^2 / (h^3 sum_k (4 - k - 1/2)^2) = 16 / 21.
        let puck = Puck::default();
        let (solution, motion) = solve(&puck, &Problem::of(&puck, 4), false);
        assert_eq!(solution.status, Status::Solved);
        let effort: f64 = motion.controls.iter().map(|u| 0.25 * u[0] * u[0]).sum();
        // Quadratics in numerical time are integrated exactly; equal elements cost nothing.
        assert!((effort - 16.0 / 21.0).abs() < 1e-7, "{effort}");
        let last = motion.q.len() - 1;
        assert!((motion.q[last][0] - 0.5).abs() < 1e-7 && motion.q[last][1].abs() < 1e-7);
        // theta = a_bar / (a_bar + g)
        let contact = 20.0 / (20.0 + 9.81);
        for alpha in &motion.step_functions {
            assert!((alpha[0] - contact).abs() < 1e-6, "{alpha:?}");
        }
    }

    #[test]
    fn fall_on_a_table_clock_rests_during_the_impact() {
        let stone = Stone::default();
        let (solution, motion) = solve(&stone, &Problem::of(&stone, 2), true);
        assert_eq!(solution.status, Status::Solved);
        // A fall of 0.1 m takes sqrt(0.2 / g) and ends where the first element of flight does.
        let fall = (0.2_f64 / 9.81).sqrt();
        let landed = motion.time.iter().any(|time| (time - fall).abs() < 1e-6);
        assert!(landed, "{motion:?}");
        let last = motion.q.len() - 1;
        assert!(motion.q[last][0].abs() < 1e-7 && motion.v[last][0].abs() < 1e-7);
        // The numerical time is longer by the jump and by the contact after it.
        let settings = TimeFreezingSettings {
            simulated_guess: true,
            ..TimeFreezingSettings::default()
        };
        let program = TimeFreezing::new(&stone, &Problem::of(&stone, 2), &settings).expect("valid");
        let numerical: f64 = program.numerical_lengths(&solution.x).iter().sum();
        let (jump, contact) = (9.81 * fall / 20.0, (1.0 - fall) * 9.81 / 20.0);
        assert!(
            (numerical - 1.0 - jump - contact).abs() < 1e-6,
            "{numerical}"
        );
    }

    #[test]
    fn sliding_in_a_bowl_keeps_gap_and_energy_to_the_order_of_the_scheme() {
        let bowl = Bowl::default();
        let mut problem = Problem::of(&bowl, 1);
        (problem.q, problem.v) = (vec![-1.0, 0.5], vec![1.0, -1.0]);
        problem.horizon = Horizon::Fixed(0.1);
        let (solution, motion) = solve(&bowl, &problem, true);
        assert_eq!(solution.status, Status::Solved);
        for (q, v) in motion.q.iter().zip(&motion.v) {
            // Radau IIA with two stages has order 3: errors of the order of (0.1 / 3)^3 = 4e-5.
            assert!((q[1] - 0.5 * q[0] * q[0]).abs() < 4e-5, "{q:?}");
            let energy = 0.5 * (v[0] * v[0] + v[1] * v[1]) + 9.81 * q[1];
            assert!(
                (energy - (1.0 + 9.81 * 0.5)).abs() < 9.81 * 4e-5,
                "{energy}"
            );
        }
        let inside = |alpha: &Vec<f64>| alpha[0] > 0.1 && alpha[0] < 0.95;
        assert!(motion.step_functions.iter().all(inside), "{motion:?}");
    }

    #[test]
    fn constraint_names_say_what_and_where() {
        let cart = Cart::default();
        let problem = Problem::of(&cart, 2);
        let program = TimeFreezing::new(&cart, &problem, &TimeFreezingSettings::default());
        let program = program.expect("valid");
        // An interval: length and clock, then three elements of two stages with (y, v, t).
        let name = |index| program.constraint_name(index);
        assert_eq!(name(1), "clock at the end of interval 0");
        assert_eq!(name(8), "collocation of element 1 of interval 0");
        assert_eq!(name(20), "sum of the element lengths of interval 1");
        assert_eq!(name(program.constraints() - 1), "goal 1");
    }

    crate::model! {
        /// A cart whose push costs more one way than the other.
        Uneven {
            parameters { m: kg = 2 }
            coordinates { y: m }
            controls { u: N in -1..=1, p: N in -1..=1 }
            lagrangian m/2*dot(y)^2
            forces { y: u + p }
            minimize integral(u^2 + 2*p^2)
            horizon 1 [s]
        }
    }

    crate::model! {
        /// A cart whose push costs little as long as it is small.
        Steep {
            parameters { m: kg = 2 }
            coordinates { y: m }
            controls { u: N in -1..=1 }
            lagrangian m/2*dot(y)^2
            forces { y: u }
            minimize integral(u^2 + u^4/1[N^2])
            horizon 1 [s]
        }
    }

    #[test]
    fn running_cost_that_is_no_effort_is_refused_and_its_weight_is_found_if_it_is() {
        let weight = |model: &dyn Model| {
            let declared = model.declaration().optimal_control.expect("a cost");
            effort_weight(model, &declared, &Problem::of(model, 1).start())
        };
        assert_eq!(weight(&Puck::default()), Some(1.0));
        assert_eq!(weight(&Stone::default()), Some(2.0));
        assert_eq!(weight(&Uneven::default()), None);
        assert_eq!(weight(&Steep::default()), None);
    }

    #[test]
    fn settings_out_of_range_are_refused_with_their_bound() {
        let bowl = Bowl::default();
        let problem = Problem::of(&bowl, 1);
        for (elements, stages, a_bar) in [(0, 2, 20.0), (3, 0, 20.0), (3, 2, -1.0)] {
            let settings = TimeFreezingSettings {
                elements,
                stages,
                auxiliary_acceleration: a_bar,
                ..TimeFreezingSettings::default()
            };
            assert!(TimeFreezing::new(&bowl, &problem, &settings).is_err());
        }
    }
}
