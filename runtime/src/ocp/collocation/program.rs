//! A solved collocation program as a motion.

use super::layout::{Distance, Phase, SolvedPhase, Tangential};
use crate::joints::partition::{Jacobian, share};
use crate::model::Model;
use crate::ocp::motion::control_grid::{ControlGrid, ControlShape};
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::tuning::attempt::DECIDED;
use crate::program::sparse_program::Program;
use crate::rk::ButcherTableau;
use hangtime_solver::nlp::{self, NlpProblem};

/// The program with its phases.
pub(in crate::ocp) struct Collocation<'a> {
    pub(in crate::ocp) program: Program<'a>,
    pub(in crate::ocp) model: &'a dyn Model,
    pub(in crate::ocp) sequence: Sequence,
    pub(in crate::ocp) phases: Vec<Phase>,
    /// Variables of the state `(q, v)` at the end, after any impact there.
    pub(in crate::ocp) end: Vec<usize>,
    /// Contacts with friction in the impacts, by the index of the switch.
    pub(in crate::ocp) impacts: Vec<(usize, Tangential)>,
    /// Touches, and the row of the least impact velocity of each.
    pub(in crate::ocp) touches: Vec<(Switch, usize)>,
    pub(in crate::ocp) distances: Vec<Distance>,
    pub(in crate::ocp) tableau: &'a ButcherTableau,
    /// Numbers of variables and rows before each interval, and before what follows the last one.
    pub(in crate::ocp) spans: Vec<(usize, usize)>,
    pub(in crate::ocp) horizon: usize,
    /// Variables of the controls on each interval, or at each node.
    pub(in crate::ocp) controls: Vec<Vec<usize>>,
    pub(in crate::ocp) shape: ControlShape,
    /// Whether control intervals have the lengths of what the motion is made up of, instead of equal ones.
    pub(in crate::ocp) aligned: bool,
    /// Variables of how far goals are missed, where they may be.
    pub(in crate::ocp) missed: Vec<usize>,
}

impl Collocation<'_> {
    /// Charges so much objective for each size by which a goal is missed.
    pub(in crate::ocp) fn penalize(&mut self, price: f64) {
        self.program.penalize(&self.missed, price);
    }

    /// That price.
    pub(in crate::ocp) fn price(&self) -> f64 {
        self.program.penalty()
    }

    /// By how much all goals are missed, in their sizes.
    pub(in crate::ocp) fn missed(&self, point: &[f64]) -> f64 {
        self.missed.iter().map(|&i| point[i].max(0.0)).sum()
    }

    /// Whether joints are to decide velocities in an element that they hardly determine where the motion went: these may be any, as the differential
    /// equations in whose place joints stand do not hold them.
    pub(in crate::ocp) fn is_singular(&self, point: &[f64]) -> bool {
        let Some(joints) = self.model.declaration().joints else {
            return false;
        };
        let n = self.end.len() / 2;
        let states = self.phases.iter().zip(self.solved(point));
        let mut states = states.flat_map(|(phase, solved)| {
            let ends = [
                (solved.start, 0),
                (solved.start + solved.length, solved.inputs.len() - 1),
            ];
            ends.map(|(time, input)| (phase, solved.inputs[input].clone(), time))
        });
        states.any(|(phase, input, time)| {
            let units: Vec<f64> = phase.start[n..]
                .iter()
                .map(|&i| self.program.unit(i))
                .collect();
            let jacobian = Jacobian::at(self.model, joints, &input[..2 * n], time);
            share(self.model, joints, &jacobian, &units, &phase.decided) < DECIDED
        })
    }

    /// Length of the motion, from physical values.
    pub(in crate::ocp) fn horizon_at(&self, physical: &[f64]) -> f64 {
        physical[self.horizon]
    }

    /// A start from the solution of another program: what intervals with the same switches have in common, and of the same
    /// sequence all but the cuts that came in addition.
    pub(in crate::ocp) fn start_from(
        &self,
        other: &Collocation,
        solution: &nlp::Solution,
        barrier: f64,
    ) -> nlp::WarmStart {
        let (variables, rows) = self.program.extent();
        let mut known = (vec![None; variables], vec![None; rows]);
        let parts = |program: &Collocation| {
            let ends = program.spans.iter().copied();
            let ends = ends.chain([program.program.extent()]);
            let begins = std::iter::once((0, 0)).chain(program.spans.iter().copied());
            begins.zip(ends).collect::<Vec<_>>()
        };
        let same = self.sequence.signature() == other.sequence.signature();
        for (own, of_other) in parts(self).into_iter().zip(parts(other)) {
            let variables = (own.0.0..own.1.0, of_other.0.0..of_other.1.0);
            let rows = (own.0.1..own.1.1, of_other.0.1..of_other.1.1);
            if same || self.program.is_like(&other.program, &variables, &rows) {
                let common = self.program.in_common(&other.program, variables, rows);
                for (known, common) in [&mut known.0, &mut known.1].into_iter().zip(common) {
                    for (i, j) in common {
                        known[i] = Some(j);
                    }
                }
            }
        }
        let mut x = vec![0.0; variables];
        self.program.initial_point(&mut x);
        let unit = other.program.objective_unit / self.program.objective_unit;
        nlp::WarmStart::carried(solution, unit, x, (&known.0, &known.1), barrier)
    }

    /// Variables of the lengths of phases in which contacts are, at the guess, in other modes than in the motion of another
    /// program at that time, with other pieces of edges that act, or after another number of touches: of those that make up
    /// an interval with others.
    pub(in crate::ocp) fn lengths_of_new_phases(
        &self,
        other: &Collocation,
        x: &[f64],
    ) -> Vec<usize> {
        let mut guess = vec![0.0; self.program.extent().0];
        self.program.initial_point(&mut guess);
        let known = other.solved(x);
        let (own, others) = (self.touches_before(), other.touches_before());
        let mut found = Vec::new();
        for ((phase, solved), touches) in self.phases.iter().zip(self.solved(&guess)).zip(own) {
            let middle = solved.start + 0.5 * solved.length;
            let then = known.iter().rposition(|phase| phase.start <= middle);
            let same = then.is_none_or(|then| {
                let there = &other.phases[then];
                (&there.modes, &there.pieces) == (&phase.modes, &phase.pieces)
                    && others[then] == touches
            });
            if !same && phase.scale != self.horizon && !found.contains(&phase.scale) {
                found.push(phase.scale);
            }
        }
        found
    }

    /// Holds these lengths of phases at their least; `relaxed` without the inequalities within those phases.
    pub(in crate::ocp) fn hold(&mut self, lengths: &[usize], relaxed: bool) {
        for &length in lengths {
            self.program.hold_at_lower(length);
        }
        let held = |phase: &&Phase| relaxed && lengths.contains(&phase.scale);
        for phase in self.phases.iter().filter(held) {
            self.program.relax_rows(phase.rows.clone());
        }
    }

    /// How often each contact was touched before each phase.
    fn touches_before(&self) -> Vec<Vec<usize>> {
        let switches = &self.sequence.switches;
        let contacts = self.sequence.initially.len();
        let mut end = switches.len();
        let mut interval = usize::MAX;
        let mut before: Vec<Vec<usize>> = Vec::with_capacity(self.phases.len());
        for phase in self.phases.iter().rev() {
            if phase.interval != interval {
                interval = phase.interval;
                end = switches.partition_point(|switch| switch.interval <= interval);
            }
            end = phase.ends_with.unwrap_or(end);
            let mut touches = vec![0; contacts];
            for switch in switches[..end].iter().filter(|switch| switch.touches()) {
                touches[switch.contact] += 1;
            }
            before.push(touches);
        }
        before.reverse();
        before
    }

    /// Start, length and states of every phase at a solver's point.
    pub(in crate::ocp) fn solved(&self, x: &[f64]) -> Vec<SolvedPhase> {
        let x = self.program.physical(x);
        let mut time = 0.0;
        let values = |variables: &[usize]| variables.iter().map(|&i| x[i]).collect::<Vec<f64>>();
        self.phases
            .iter()
            .map(|phase| {
                let length = phase.factor * x[phase.scale];
                time += length;
                let mut inputs = vec![values(&phase.start)];
                let stages = phase.stages.iter();
                inputs.extend(
                    stages.map(|stage| [values(&stage.state), values(&stage.drive)].concat()),
                );
                // Controls and time are affine over a phase.
                let (c, last) = (self.tableau.c(), inputs.len() - 1);
                let share = c[0] / (c[last - 1] - c[0]);
                for k in inputs[0].len()..inputs[last].len() {
                    let (from, to) = (inputs[1][k], inputs[last][k]);
                    inputs[0].push(from - share * (to - from));
                }
                SolvedPhase {
                    start: time - length,
                    length,
                    inputs,
                }
            })
            .collect()
    }

    /// Where each control interval begins and the last one ends, as shares of the motion.
    fn nodes(&self, point: &[f64]) -> Vec<f64> {
        let horizon = self.horizon_at(&self.program.physical(point));
        let mut nodes = vec![1.0; self.controls.len() + 1];
        for (phase, solved) in self.phases.iter().zip(self.solved(point)).rev() {
            nodes[phase.interval] = solved.start / horizon;
        }
        nodes
    }

    /// The motion and the sequence with its times at a solver's point.
    pub(in crate::ocp) fn result(&self, point: &[f64]) -> (Trajectory, Sequence) {
        let x = self.program.physical(point);
        let contacts = self.model.declaration().contacts.len();
        let horizon = x[self.horizon];
        let controls = self.controls.iter();
        let controls = controls.map(|controls| controls.iter().map(|&u| x[u]).collect());
        let controls = ControlGrid::new(self.shape, controls.collect());
        let controls = match self.aligned {
            true => controls.with_nodes(self.nodes(point)),
            false => controls,
        };
        let intervals = controls.intervals() as f64;
        let mut trajectory = Trajectory {
            horizon,
            controls,
            time: Vec::new(),
            states: Vec::new(),
        };
        let mut sequence = self.sequence.clone();
        // In units of intervals of equal length.
        let begins = trajectory.controls.times(intervals);
        for switch in &mut sequence.switches {
            switch.time = begins[switch.interval];
        }
        for (phase, solved) in self.phases.iter().zip(self.solved(point)) {
            let nodes = std::iter::once(0.0).chain(self.tableau.c().iter().copied());
            for (index, (node, input)) in nodes.zip(&solved.inputs).enumerate() {
                let mut forces = vec![0.0; contacts];
                let stage = &phase.stages[index.saturating_sub(1)];
                for (&i, &force) in phase.closed.iter().zip(&stage.forces) {
                    forces[i] = x[force] / solved.length;
                }
                trajectory.time.push(solved.start + node * solved.length);
                let state = input[..phase.start.len()].iter().copied();
                trajectory.states.push(state.chain(forces).collect());
            }
            if let Some(index) = phase.ends_with {
                let switch = &mut sequence.switches[index];
                switch.time = (solved.start + solved.length) / horizon * intervals;
            }
        }
        for index in 1..sequence.switches.len() {
            if sequence.switches[index].accompanies {
                sequence.switches[index].time = sequence.switches[index - 1].time;
            }
        }
        (trajectory, sequence)
    }
}
