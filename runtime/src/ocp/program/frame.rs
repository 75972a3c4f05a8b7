//! What all programs have in common: horizon, controls, start, objective, goals and path functions.

use super::units::Units;
use super::{given, start_joints};
use crate::model::{ConstraintDeclaration, ContactDeclaration, Function, Model};
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::final_times::FinalTimes;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::Problem;
use crate::program::kernel::Kernel;
use crate::program::parts::OBJECTIVE;
use crate::program::powers::{THOUSAND, nearest_power};
use crate::program::sparse_program::Program;

/// By how much goals are missed to start with, in their sizes: within the reach of the barrier.
const FIRST_MISS: f64 = 0.1;

/// The variables of a program that do not belong to a phase or element.
pub(in crate::ocp) struct Frame<'a> {
    model: &'a dyn Model,
    pub(in crate::ocp) horizon: usize,
    /// Controls on each interval, or at each node.
    pub(in crate::ocp) controls: Vec<Vec<usize>>,
    /// `(q, v)` at the start; fixed but for the free initial values.
    pub(in crate::ocp) start: Vec<usize>,
    /// Sums over impacts; empty where they are not asked for.
    pub(in crate::ocp) sums: Vec<Sum>,
}

/// A sum over all impacts: its variable, and the row that says what it is.
pub(in crate::ocp) struct Sum {
    pub(in crate::ocp) variable: usize,
    pub(in crate::ocp) row: usize,
}

impl<'a> Frame<'a> {
    pub(in crate::ocp) fn add(
        program: &mut Program,
        model: &'a dyn Model,
        problem: &Problem,
        guess: &Trajectory,
        shape: ControlShape,
        units: &Units,
        bounds: (&[f64], &[f64]),
    ) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let range = FinalTimes::around(problem, units.time);
        let range = (range.shortest, range.longest);
        let horizon = program.variable("final time", range, guess.horizon, units.time);
        let place = match shape {
            ControlShape::Constant => "on interval",
            ControlShape::Linear => "at node",
        };
        let guessed = guess.controls.resampled(shape, problem.intervals);
        let guessed = guessed.values().iter().enumerate();
        let controls = guessed
            .map(|(k, guessed)| {
                let declared = declaration.controls.iter().enumerate();
                declared
                    .map(|(i, control)| {
                        program.variable(
                            format!("`{}` {place} {k}", control.name),
                            (bounds.0[n + i], bounds.1[n + i]),
                            guessed[i],
                            units.controls[i],
                        )
                    })
                    .collect()
            })
            .collect();
        let start = problem.start_ranges(model).into_iter().enumerate();
        let start: Vec<usize> = start
            .map(|(k, range)| {
                let name = format!("initial {}", state_name(model, k));
                program.variable(name, range, guess.states[0][k], units.states[k])
            })
            .collect();
        given::add(program, (model, problem), (horizon, &start), units);
        start_joints::add_at_start(program, model, problem, (&start, &units.states));
        Self {
            model,
            horizon,
            controls,
            start,
            sums: Vec::new(),
        }
    }

    /// A variable for the time that is a sum of `coefficient variable`.
    pub(in crate::ocp) fn time(
        &self,
        program: &mut Program,
        name: String,
        terms: &[(usize, f64)],
        guess: f64,
    ) -> usize {
        let unit = program.unit(self.horizon);
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let time = program.variable(name.clone(), free, guess, unit);
        let row = program.row(name, 0.0, 0.0);
        program.linear(row, time, 1.0 / unit);
        for &(variable, coefficient) in terms {
            program.linear(row, variable, -coefficient / unit);
        }
        time
    }

    /// Adds `factor` times the variables of `scale` times the running cost at `(q, v, u)` to the objective; `provided` is what contacts do there.
    pub(in crate::ocp) fn running_cost(
        &self,
        program: &mut Program,
        [q, v, u]: [&[usize]; 3],
        provided: Provided,
        scale: impl IntoIterator<Item = usize>,
        factor: f64,
    ) {
        let declared = self.model.declaration().optimal_control;
        if declared.is_some_and(|d| d.running_cost) {
            let behind = provided.behind(declared.is_some_and(|d| d.contacts.path));
            let uses = vec![(OBJECTIVE, 0, factor)];
            program.block_behind(
                &Kernel::Whole(Function::Path),
                [q, v, u],
                behind,
                scale,
                uses,
            );
        }
    }

    /// Adds the rows of the path constraints at `(q, v, u)`, as far as it is known what contacts do.
    pub(in crate::ocp) fn path_rows(
        &self,
        program: &mut Program,
        inputs: [&[usize]; 3],
        provided: Provided,
        place: &str,
    ) {
        let declared = self.model.declaration().optimal_control;
        let constraints = declared.map_or(0, |d| d.constraints.len());
        let all: Vec<usize> = (0..constraints).collect();
        self.path_rows_of(program, &all, inputs, provided, place);
    }

    /// Adds the rows of some path constraints at `(q, v, u)`.
    pub(in crate::ocp) fn path_rows_of(
        &self,
        program: &mut Program,
        chosen: &[usize],
        inputs: [&[usize]; 3],
        provided: Provided,
        place: &str,
    ) {
        let declaration = self.model.declaration();
        let Some(declared) = declaration.optimal_control else {
            return;
        };
        let first = usize::from(declared.running_cost);
        let pattern = declared.path_jacobian;
        let known =
            |i: &&usize| provided.is_known() || !pattern.reads(first + **i, declaration.inputs());
        let uses: Vec<(usize, usize, f64)> = chosen
            .iter()
            .filter(known)
            .map(|&i| {
                (
                    condition(program, &declared.constraints[i], 1.0, place),
                    first + i,
                    1.0,
                )
            })
            .collect();
        if !uses.is_empty() {
            let behind = provided.behind(declared.contacts.path);
            program.block_behind(&Kernel::Whole(Function::Path), inputs, behind, None, uses);
        }
    }

    /// Adds the final cost and the goals on the final state `(q, v)`, as far as it is known what contacts do.
    /// Where goals may be missed, the variables of by how much.
    pub(in crate::ocp) fn finish(
        &self,
        program: &mut Program,
        last: &[usize],
        provided: Provided,
        elastic: Option<&[f64]>,
    ) -> Vec<usize> {
        let mut missed = Vec::new();
        let Some(declared) = self.model.declaration().optimal_control else {
            return missed;
        };
        let first = usize::from(declared.final_cost);
        let mut uses: Vec<(usize, usize, f64)> = Vec::new();
        if declared.final_cost {
            uses.push((OBJECTIVE, 0, 1.0));
        }
        let pattern = declared.terminal_jacobian;
        let known = last.len() + 1 + self.sums.len();
        let units = self.goal_units(program, last);
        for (i, goal) in declared.goals.iter().enumerate() {
            if provided.is_known() || !pattern.reads(first + i, known) {
                let row = condition(program, goal, units[first + i], "at the end");
                uses.push((row, first + i, 1.0));
                if let Some(size) = elastic.and_then(|sizes| sizes.get(i)) {
                    missed.extend(may_be_missed(program, goal, (row, *size)));
                }
            }
        }
        if !uses.is_empty() {
            let (q, v) = last.split_at(last.len() / 2);
            let sums = self.sums.iter().map(|sum| Some(sum.variable));
            let mut behind: Vec<Option<usize>> = sums.collect();
            behind.extend(provided.behind(declared.contacts.terminal));
            if declared.contacts.terminal {
                let forces = 2 * self.model.declaration().contacts.len();
                behind.resize(self.sums.len() + forces, None);
            }
            let inputs = [q, v, &[self.horizon]];
            program.block_behind(
                &Kernel::Whole(Function::Terminal),
                inputs,
                &behind,
                None,
                uses,
            );
        }
        missed
    }

    /// Units of the terminal functions at the guess of the final state: 1, or where they change by far less while what they read changes by its
    /// unit, a power of a thousand near to that.
    fn goal_units(&self, program: &Program, last: &[usize]) -> Vec<f64> {
        let declaration = self.model.declaration();
        let Some(declared) = declaration.optimal_control else {
            return Vec::new();
        };
        let read: Vec<usize> = last.iter().copied().chain([self.horizon]).collect();
        let mut z: Vec<f64> = read.iter().map(|&i| program.guessed(i)).collect();
        z.resize(declaration.terminal_inputs(), 0.0);
        let entries = declared.terminal_jacobian.entries;
        let mut slopes = vec![0.0; entries.len()];
        self.model.jacobian(Function::Terminal, &z, &mut slopes);
        let mut sizes = vec![0.0_f64; declared.terminal_functions()];
        for (&(row, column), slope) in entries.iter().zip(slopes) {
            // Forces and impulses are left out: these are in units of their own.
            let unit = read.get(column as usize).map_or(1.0, |&i| program.unit(i));
            let size = &mut sizes[row as usize];
            *size = size.max((slope * unit).abs());
        }
        let units = sizes.into_iter().map(|size| nearest_power(THOUSAND, size));
        units.map(|unit| unit.min(1.0)).collect()
    }
}

/// What contacts do where functions that the scene declares are evaluated.
#[derive(Clone, Copy)]
pub(in crate::ocp) enum Provided<'a> {
    /// It is not asked: conditions on it are left out, and it costs nothing.
    Unknown,
    /// Variables of the normal and then the tangential accelerations that they provide, none for 0.
    Known(&'a [Option<usize>]),
}

impl<'a> Provided<'a> {
    fn is_known(self) -> bool {
        matches!(self, Self::Known(_))
    }

    /// What a function reads behind all else, if it reads this.
    fn behind(self, is_read: bool) -> &'a [Option<usize>] {
        match self {
            Self::Known(provided) if is_read => provided,
            _ => &[],
        }
    }
}

/// Adds the row of a declared constraint in a unit.
pub(in crate::ocp) fn condition(
    program: &mut Program,
    constraint: &ConstraintDeclaration,
    unit: f64,
    place: &str,
) -> usize {
    let upper = if constraint.equality {
        0.0
    } else {
        f64::INFINITY
    };
    let name = format!("`{}` {place}", constraint.name);
    program.row_in(unit, name, 0.0, upper)
}

/// Adds what a goal may be missed by, to one side or the other; the variables, which are at least 0.
fn may_be_missed(
    program: &mut Program,
    goal: &ConstraintDeclaration,
    (row, unit): (usize, f64),
) -> Vec<usize> {
    let sides: &[f64] = if goal.equality { &[1.0, -1.0] } else { &[1.0] };
    let add = |&side: &f64| {
        let name = format!("miss of `{}`", goal.name);
        let variable = program.variable(name, (0.0, f64::INFINITY), FIRST_MISS * unit, unit);
        program.linear(row, variable, side);
        variable
    };
    sides.iter().map(add).collect()
}

/// Name of the normal force of a contact; of dry friction it is the bound.
pub(in crate::ocp) fn force_name(contact: &ContactDeclaration) -> String {
    let what = if contact.dry {
        "friction bound"
    } else {
        "force"
    };
    format!("{what} of `{}`", contact.name)
}

/// Name of component `k` of `(q, v)`.
pub(in crate::ocp) fn state_name(model: &dyn Model, k: usize) -> String {
    let coordinates = model.declaration().coordinates;
    match k.checked_sub(coordinates.len()) {
        None => format!("`{}`", coordinates[k].name),
        Some(velocity) => format!("d`{}`/dt", coordinates[velocity].name),
    }
}
