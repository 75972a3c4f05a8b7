//! The optimal control problem as one complementarity problem: time-freezing and FESD.

use hangtime_solver::mpcc::Mpcc;
use hangtime_solver::nlp::NlpProblem;

use super::declared;
use super::guess::guess;
use super::spans::spans;
use crate::model::{ContactDeclaration, Model};
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::{ControlGrid, ControlShape};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::{Problem, bounds};
use crate::ocp::program::frame::Frame;
use crate::ocp::program::units::Units;
use crate::ocp::settings::{self, TimeFreezingSettings};
use crate::ocp::tuning::candidates::SAMPLES;
use crate::program::sparse_program::Program;
use crate::refusal;
use crate::rk::ButcherTableau;
use crate::simulation::{InitialValueProblem, InputError};
use crate::time_freezing::conditions;
use crate::time_freezing::field::Field;
use crate::time_freezing::modes;
use crate::time_freezing::step_form::transcribe;
use crate::time_freezing::task::{Guess, Outer, Task};
use crate::time_freezing::transcription::Transcription;

/// An optimal control problem on a [`Model`] as a mathematical program with complementarity constraints:
/// the time-freezing system, transcribed by finite elements with switch detection in step form. Solve it
/// with [`mpcc::solve`](hangtime_solver::mpcc::solve).
///
/// Objective, path constraints, terminal conditions and free initial values are those that the scene declares. Bounds of
/// coordinates are imposed at the ends of the finite elements, path constraints at their stages, bounds of controls
/// everywhere. Controls are constant on each interval, or linear there. Forces and impulses of contacts are those of physical time: where it is not
/// known which elements are jumps, functions that read them take them for 0, and conditions on them are left out.
/// The starting point is made from the problem alone: coordinates with a goal move to it at constant speed,
/// the others rest; without goals, it is a coarse simulation. Controls start at zero, or as
/// near to it as their bounds allow.
///
/// Sources: Nurkanovic, Albrecht, Brogliato, Diehl, Automatica 158 (2023) 111295 (time-freezing);
/// Nurkanovic, Sperl, Albrecht, Diehl, Numerische Mathematik 2024 (finite elements).
pub struct TimeFreezing<'a> {
    transcription: Transcription<'a>,
    shape: ControlShape,
}

/// One motion out of a [`TimeFreezing`] program.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::ocp) struct TimeFreezingMotion {
    /// Length \[s\].
    pub(in crate::ocp) horizon: f64,
    /// `(q, v)` at the start.
    pub(in crate::ocp) start: Vec<f64>,
    pub(in crate::ocp) controls: ControlGrid,
    /// Physical time at the end of each element \[s\].
    pub(in crate::ocp) time: Vec<f64>,
    /// Coordinates there.
    pub(in crate::ocp) q: Vec<Vec<f64>>,
    /// Velocities there.
    pub(in crate::ocp) v: Vec<Vec<f64>>,
    /// Mean step function of each contact in each element: 1 free, 0 jump, between in sustained contact; of a condition, 0 where it is true.
    pub(in crate::ocp) step_functions: Vec<Vec<f64>>,
    /// Conditions that come true at the start of each element.
    pub(in crate::ocp) set: Vec<Vec<usize>>,
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
        refuse_resets(model)?;
        let (lower, upper) = bounds(model);
        let bounds = (&lower[..], &upper[..]);
        let guess = guess(model, problem, &settings::Guess::Straight, bounds)?;
        Self::from_guess(model, problem, settings, &guess)
    }

    /// Transcribes a problem with controls of the shape of those of a motion and starts it there, or at the simulation under these
    /// controls if the settings ask for that.
    pub(in crate::ocp) fn from_guess(
        model: &'a dyn Model,
        problem: &Problem,
        settings: &TimeFreezingSettings,
        guess: &Trajectory,
    ) -> Result<Self, InputError> {
        let task = task(model, problem, settings, guess);
        Self::transcribed((model, problem, settings), guess, task)
    }

    /// Transcribes a problem whose motion is known, with the sides of the pairs that vanish in it fixed at zero, and with as many
    /// elements as it has phases and jumps in an interval, if those are more.
    pub(in crate::ocp) fn known(
        model: &'a dyn Model,
        problem: &Problem,
        settings: &TimeFreezingSettings,
        motion: &Candidate,
    ) -> Result<Self, InputError> {
        let Candidate {
            sequence,
            trajectory,
            ..
        } = motion;
        let mut task = task(model, problem, settings, trajectory);
        let known = spans(field(model, settings), sequence, trajectory, task.intervals);
        let most = known.iter().map(Vec::len).max();
        task.elements = task.elements.max(most.unwrap_or(0));
        task.guess = Guess::Known(known);
        Self::transcribed((model, problem, settings), trajectory, task)
    }

    /// The program of a task, with all that the scene declares.
    pub(super) fn transcribed(
        (model, problem, settings): (&'a dyn Model, &Problem, &TimeFreezingSettings),
        guess: &Trajectory,
        task: Task,
    ) -> Result<Self, InputError> {
        let tableau = scheme(settings)?;
        let (lower, upper) = bounds(model);
        let bounds = (&lower[..], &upper[..]);
        let shape = guess.controls.shape;
        let units = Units::of_scene(model, guess.horizon, bounds);
        let mut program = Program::new(model);
        let mut frame = Frame::add(&mut program, model, problem, guess, shape, &units, bounds);
        let outer = Outer {
            horizon: frame.horizon,
            controls: frame.controls.clone(),
            start: frame.start.clone(),
        };
        let field = field(model, settings);
        let mut transcription = transcribe(program, outer, field, &tableau, task);
        declared::add(&mut transcription, &mut frame);
        Ok(Self {
            transcription: transcription.finished(),
            shape,
        })
    }

    /// Length of each element in numerical time \[s\], at the point `x` of the program.
    #[cfg(test)]
    fn numerical_lengths(&self, x: &[f64]) -> Vec<f64> {
        let program = &self.transcription;
        let lengths = program.elements.iter();
        lengths
            .map(|e| x[e.length] * x[program.intervals[e.interval].length])
            .collect()
    }

    /// Whether functions that the scene declares read forces or impulses of which the program knows nothing.
    pub(in crate::ocp) fn leaves_out_forces(&self) -> bool {
        declared::leaves_out_forces(&self.transcription)
    }

    /// The motion at the point `x` of the program.
    #[must_use]
    pub(in crate::ocp) fn motion(&self, x: &[f64]) -> TimeFreezingMotion {
        let program = &self.transcription;
        let elements = 0..program.elements();
        let time = program.field.layout.time();
        let states: Vec<Vec<f64>> = elements.clone().map(|e| program.state(x, e)).collect();
        let part = |range: std::ops::Range<usize>| -> Vec<Vec<f64>> {
            let parts = states.iter().map(|state| state[range.clone()].to_vec());
            parts.collect()
        };
        TimeFreezingMotion {
            horizon: program.horizon(x),
            start: program.initial_state(x),
            controls: ControlGrid::new(self.shape, program.controls(x)),
            time: states.iter().map(|state| state[time]).collect(),
            step_functions: elements
                .clone()
                .map(|e| {
                    (0..program.contacts())
                        .map(|i| program.mean_alpha(x, e, i))
                        .collect()
                })
                .collect(),
            set: elements.map(|e| conditions::set(program, x, e)).collect(),
            q: part(0..time / 2),
            v: part(time / 2..time),
        }
    }
}

/// The time-freezing system in step form.
fn field<'a>(model: &'a dyn Model, settings: &TimeFreezingSettings) -> Field<'a> {
    Field::new(model, settings.auxiliary_acceleration)
}

/// The scheme, where all settings are in range.
fn scheme(settings: &TimeFreezingSettings) -> Result<ButcherTableau, InputError> {
    let refuse =
        |what: &str, value: f64, bound: String| Err(refusal::out_of_range(what, value, "", bound));
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
    Ok(tableau)
}

/// The grid, to be started at a motion.
fn task(
    model: &dyn Model,
    problem: &Problem,
    settings: &TimeFreezingSettings,
    guess: &Trajectory,
) -> Task {
    let n = problem.q.len();
    let (lower, upper) = bounds(model);
    let declared = model.declaration().optimal_control;
    let aimless = declared.is_none_or(|declared| declared.goals.is_empty());
    Task {
        time: 0.0,
        linear: guess.controls.shape == ControlShape::Linear,
        intervals: problem.intervals,
        elements: settings.elements_of(model),
        coordinate_bounds: (lower[..n].to_vec(), upper[..n].to_vec()),
        guess: if settings.simulated_guess || aimless {
            Guess::Simulated
        } else {
            let count = SAMPLES * problem.intervals;
            let time = |i: usize| guess.horizon * i as f64 / count as f64;
            let state = |i: usize| guess.at(time(i), true)[..2 * n].to_vec();
            Guess::Motion((0..=count).map(state).collect())
        },
    }
}

impl NlpProblem for TimeFreezing<'_> {
    fn variables(&self) -> usize {
        self.transcription.program.variables()
    }

    fn constraints(&self) -> usize {
        self.transcription.program.constraints()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.transcription.program.variable_bounds(lower, upper);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.transcription.program.constraint_bounds(lower, upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        self.transcription.program.initial_point(x);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        self.transcription.program.objective(x)
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.transcription.program.gradient(x, gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.transcription.program.constraint_values(x, c);
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.transcription.program.jacobian_pattern()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        self.transcription.program.jacobian_values(x, values);
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.transcription.program.hessian_pattern()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        self.transcription
            .program
            .hessian_values(x, weight, multipliers, values);
    }

    fn variable_name(&self, index: usize) -> String {
        self.transcription.program.variable_name(index)
    }

    fn constraint_name(&self, index: usize) -> String {
        self.transcription.program.constraint_name(index)
    }
}

impl Mpcc for TimeFreezing<'_> {
    fn complementarities(&self) -> &[(usize, usize)] {
        self.transcription.program.complementarities()
    }

    fn complementarity_name(&self, index: usize) -> String {
        self.transcription.complementarity_name(index)
    }

    fn vanishing_sides(&self, x: &[f64], vanishes: &mut [bool]) -> bool {
        modes::mark_vanishing(&self.transcription, x, vanishes);
        true
    }
}

/// Refuses conditions that set what a switch or a contact reads: its sign jumps where they come true, within no element.
///
/// # Errors
/// [`InputError`] with the names of the first two.
pub(in crate::ocp) fn refuse_resets(model: &dyn Model) -> Result<(), InputError> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let Some(declared) = declaration.optimal_control else {
        let what = "the time-freezing formulation without an objective";
        return InitialValueProblem::check_resets(model, what, "add what is to be found");
    };
    for &(condition, velocity) in declared.contacts.resets {
        let reads = |known: &&ContactDeclaration| {
            let sliding = known.friction.map(|friction| (friction.jacobian, 1));
            let mut read = sliding.into_iter().chain([(known.jacobian, 2)]);
            read.any(|(pattern, functions)| {
                let mut entries = pattern.entries.iter();
                entries.any(|&(row, input)| row < functions && input as usize == n + velocity)
            })
        };
        if let Some(reader) = declaration.contacts.iter().find(reads) {
            let name = declaration.contacts[condition].name;
            return Err(refusal::unsupported(
                format!(
                    "`when {name}`, which sets what `{}` reads, by the time-freezing formulation",
                    reader.name
                ),
                "solve in phases, the default",
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ocp::problem::Horizon;
    use hangtime_solver::mpcc::{self, Status};

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

    crate::model! {
        /// A block that slides off the end of a table.
        Table {
            parameters { m: kg = 1, g: m/s^2 = 9.81, height: m = 0.8, edge: m = 0.5, speed: m/s = 1.2 }
            coordinates { y: m, z: m }
            lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
            surface table: max(z - height, y - edge) >= 0
            impact table: inelastic
            start { z: height, dot(y): speed }
            horizon 0.8 [s]
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
        let mut settings = mpcc::Settings::default();
        // The objective may be the equilibration alone, whose size means nothing.
        settings.interior_point.objective_unit = Some(1.0);
        let solution = mpcc::solve(&mut program, &settings).expect("accepted");
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
        let controls = motion.controls.values().iter();
        let controls: Vec<f64> = controls.map(|u| u[0].round()).collect();
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
        let effort = motion.controls.values().iter();
        let effort: f64 = effort.map(|u| 0.25 * u[0] * u[0]).sum();
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
    fn block_slides_off_a_table_and_falls_past_its_end() {
        let table = Table::default();
        let mut problem = Problem::of(&table, 2);
        problem.horizon = Horizon::Fixed(0.8);
        let (solution, motion) = solve(&table, &problem, true);
        assert_eq!(solution.status, Status::Solved);
        let steps = || motion.time.iter().zip(&motion.step_functions);
        let holds = |alpha: &[f64]| alpha[0] < 0.99;
        let last = steps().rfind(|(_, alpha)| holds(alpha));
        let left = last.map_or(0.0, |(time, _)| *time);
        // Where contact ends is not determined within the first stage of an element, a third of 0.4/3 s.
        let passes = 0.5 / 1.2;
        assert!(
            (passes - 0.4 / 9.0..passes + 1e-6).contains(&left),
            "{motion:?}"
        );
        for ((time, alpha), q) in steps().zip(&motion.q) {
            // Quadratics are integrated exactly.
            let fall = (time - left).max(0.0);
            assert!((q[0] - 1.2 * time).abs() < 1e-6, "{motion:?}");
            assert!(
                (q[1] - (0.8 - 0.5 * 9.81 * fall * fall)).abs() < 1e-6,
                "{motion:?}"
            );
            // The end of the table never pushes, its top does until the edge.
            assert!((alpha[1] - 1.0).abs() < 1e-6, "{alpha:?}");
            assert_eq!(holds(alpha), *time < left + 1e-6, "{alpha:?}");
        }
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
        let goal = name(program.constraints() - 1);
        assert!(
            goal.contains("dot(y)") && goal.ends_with("` at the end"),
            "{goal}"
        );
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
