//! The phase that finds the digits: collocation of high order with a given contact sequence.
//!
//! A phase is a part of a control interval between two switches. On each of its Radau IIA elements (one, unless the
//! grid is refined), of length `h`, with the closed contacts `A`:
//!
//! ```text
//! sum_j C_mj Q_j = h V_m + sum_A d_i eta_i      g_i(Q_m) = 0,  v_n,i(Q_m, V_m) = 0,  r_i >= 0     i in A
//! sum_j C_mj V_j = h a_m + sum_A d_i r_i        g_i(Q_m) >= 0                                 i not in A
//! ```
//!
//! (stabilised index 2: Gear, Leimkuhler, Gupta 1985; order `2 s - 1` in `q` and `v`). The unknowns `r_i` are
//! normal accelerations times `h`, so that the system stays regular for short phases. Between phases:
//! an opening inside an interval happens where the force vanishes, `r_i = 0`; one at a jump of the
//! controls where `r_i >= 0` before and the normal acceleration is `>= 0` after it, and one at a node of linear
//! controls, which do not jump, where `r_i = 0` before it; a closing or a touch where `g_i = 0`, possibly at the very
//! end, followed by the impact map `v+ = v + sum_B d_i p_i`, `v_n,i(v+) = -e_i v_n,i(v)` for all contacts `B` closed
//! there. A touch leaves its contact open; without a bounce the normal acceleration is `>= 0` after it.
//! Contacts with friction are the subject of [`friction`](super::friction).
//!
//! A coordinate whose acceleration depends on nothing but the controls is a parabola on each interval,
//! so a bound holds at all times if and only if the shifted control points `b_0, b_1, b_2` of the parabola
//! satisfy `b_0 >= s theta^2`, `b_1 >= -s theta (1 - theta)`, `b_2 >= s (1 - theta)^2` for some `s >= 0` and
//! `theta` in `[0, 1]`: a nonnegative combination of the Bernstein polynomials and of a square (Lukacs). The
//! rows have independent gradients also where the coordinate rests on its bound. Under linear controls it is a cubic,
//! with a condition alike (`cubic_bounds`). Other bounds hold at the stages, and between them where a [`Cut`] says so.

use super::control_grid::ControlGrid;
use super::friction::Tangential;
use super::mode::{Direction, Mode, is_rough};
use super::path::Path;
use super::problem::Problem;
use super::program::Program;
use super::sequence::{Sequence, Switch};
use super::settings::{BoundsAt, ControlShape, PathPoints};
use super::units::Units;
use crate::model::{Model, contact_point, tangent_point};
use crate::rk::ButcherTableau;

/// What must hold between the stages of a phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CutKind {
    /// `g_i >= margin`.
    Gap(usize, f64),
    /// The coordinate stays within its bounds.
    Bounds(usize),
    /// The path constraint holds.
    Path(usize),
    /// The normal acceleration of a contact right after the start of the phase is at least 0.
    Departure(usize),
    /// A sticking contact's force stays on its side of the edge from which it would slip that way.
    Cone(usize, Direction),
    /// A slipping contact does not slip back.
    Slip(usize),
}

/// A condition inside a phase, at the share `theta` of its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cut {
    pub(super) interval: usize,
    /// Index of the phase in its interval, and the number of phases there.
    pub(super) phase: (usize, usize),
    pub(super) theta: f64,
    pub(super) kind: CutKind,
}

/// Variables of a stage.
pub(super) struct Stage {
    /// `q` then `v`.
    pub(super) state: Vec<usize>,
    /// Controls at the stage, those of the interval where they are constant, and the time where the model reads it.
    pub(super) drive: Vec<usize>,
    /// Normal accelerations of the closed contacts times the length of the phase, in the order of
    /// [`Phase::closed`].
    pub(super) forces: Vec<usize>,
    /// Row of each contact's gap.
    pub(super) gap_rows: Vec<usize>,
    /// The closed contacts with friction.
    pub(super) tangential: Vec<Tangential>,
}

/// One element of a phase and where its unknowns are.
pub(super) struct Phase {
    pub(super) interval: usize,
    /// Index in its interval, and the number of elements there.
    pub(super) index: (usize, usize),
    pub(super) closed: Vec<usize>,
    /// Mode of each contact.
    pub(super) modes: Vec<Mode>,
    /// State `(q, v)` at the start, after any jump.
    pub(super) start: Vec<usize>,
    pub(super) stages: Vec<Stage>,
    /// Length: `factor` times this variable.
    pub(super) scale: usize,
    pub(super) factor: f64,
    /// (contact, row) of the normal acceleration after an opening at a jump of the controls.
    pub(super) openings: Vec<(usize, usize)>,
    /// (contact, row) of the sliding acceleration of contacts that are pulled into slip at the start.
    pub(super) pulled: Vec<(usize, usize)>,
    /// (contact, direction of the slip beyond, row) of the friction cones of sticking contacts at the start.
    pub(super) cones: Vec<(usize, Direction, usize)>,
    /// Contacts that begin to slip at the start with no acceleration.
    pub(super) yielded: Vec<usize>,
    /// The switch at the end inside the interval, as an index into the sequence.
    pub(super) ends_with: Option<usize>,
    /// The contacts that close or are touched at the end.
    pub(super) closing: Vec<usize>,
}

/// The program with its phases.
pub(super) struct Collocation<'a> {
    pub(super) program: Program<'a>,
    pub(super) model: &'a dyn Model,
    pub(super) sequence: Sequence,
    pub(super) phases: Vec<Phase>,
    /// Contacts with friction in the impacts, by the index of the switch.
    pub(super) impacts: Vec<(usize, Tangential)>,
    /// Touches, and the row of the least impact velocity of each.
    pub(super) touches: Vec<(Switch, usize)>,
    pub(super) tableau: &'a ButcherTableau,
    pub(super) horizon: usize,
    /// Variables of the controls on each interval, or at each node.
    pub(super) controls: Vec<Vec<usize>>,
    pub(super) shape: ControlShape,
}

/// Everything that stays the same over all sequences.
#[derive(Clone, Copy)]
pub(super) struct Setting<'a> {
    pub(super) model: &'a dyn Model,
    pub(super) problem: &'a Problem,
    pub(super) tableau: &'a ButcherTableau,
    pub(super) units: &'a Units,
    pub(super) bounds: (&'a [f64], &'a [f64]),
    /// Whether each coordinate is a parabola on each interval.
    pub(super) parabolas: &'a [bool],
    pub(super) places: Places,
    pub(super) shape: ControlShape,
}

/// Where bounds of coordinates and path constraints are imposed.
#[derive(Clone, Copy)]
pub(super) struct Places {
    pub(super) bounds: BoundsAt,
    pub(super) path: PathPoints,
}

/// Which coordinates are parabolas while the controls are constant: their acceleration is affine in the
/// controls alone, and no contact pushes or rubs them.
pub(super) fn parabolas(model: &dyn Model, start: &[f64]) -> Vec<bool> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut x = start.to_vec();
    x.resize(declaration.inputs(), 0.0);
    let mut point = vec![0.0; contact_point::length(n)];
    let mut tangent = vec![0.0; tangent_point::length(n)];
    let places = 2 * n..2 * n + declaration.controls.len();
    let controls = |column: u32| places.contains(&(column as usize));
    let affine = !declaration
        .free_hessian
        .entries
        .iter()
        .any(|&(i, j)| controls(i) && controls(j));
    (0..n)
        .map(|k| {
            let mut jacobian = declaration.free_jacobian.entries.iter();
            let free = jacobian.all(|&(row, column)| row as usize != k || controls(column));
            let pushed = declaration.contacts.iter().enumerate().any(|(i, contact)| {
                model.contact(i, &x, &mut point);
                let mut entries = contact.jacobian.entries.iter();
                let friction = contact.friction.filter(|_| is_rough(model, i));
                let rubbed = friction.is_some_and(|friction| {
                    model.tangent(i, &x, &mut tangent);
                    let mut entries = friction.jacobian.entries.iter();
                    tangent[tangent_point::direction(n) + k] != 0.0
                        || entries.any(|&(row, _)| row as usize == 1 + k)
                });
                rubbed
                    || point[contact_point::direction(n) + k] != 0.0
                    || entries.any(|&(row, _)| row as usize == 2 + k)
            });
            affine && free && !pushed
        })
        .collect()
}

/// Weights `l_j(theta)` and, with `slope`, `l_j'(theta)` of the nodes `0, c_1 .. c_s`.
pub(super) fn lagrange(tableau: &ButcherTableau, theta: f64, slope: bool) -> Vec<f64> {
    let nodes: Vec<f64> = std::iter::once(0.0)
        .chain(tableau.c().iter().copied())
        .collect();
    let others = |j: usize| (0..nodes.len()).filter(move |&k| k != j);
    (0..nodes.len())
        .map(|j| {
            let product = |skip: usize| -> f64 {
                others(j)
                    .filter(|&k| k != skip)
                    .map(|k| (theta - nodes[k]) / (nodes[j] - nodes[k]))
                    .product()
            };
            if slope {
                others(j).map(|i| product(i) / (nodes[j] - nodes[i])).sum()
            } else {
                product(j)
            }
        })
        .collect()
}

/// A phase with its numbers.
pub(super) struct SolvedPhase {
    /// Start and length \[s\].
    pub(super) start: f64,
    pub(super) length: f64,
    /// Input vectors of the model at the start and the stages.
    pub(super) inputs: Vec<Vec<f64>>,
}

impl Collocation<'_> {
    /// Length of the motion, from physical values.
    pub(super) fn horizon_at(&self, physical: &[f64]) -> f64 {
        physical[self.horizon]
    }

    /// Start, length and states of every phase at a solver's point.
    pub(super) fn solved(&self, x: &[f64]) -> Vec<SolvedPhase> {
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

    /// The motion and the sequence with its times at a solver's point.
    pub(super) fn result(&self, point: &[f64]) -> (Path, Sequence) {
        let x = self.program.physical(point);
        let contacts = self.model.declaration().contacts.len();
        let horizon = x[self.horizon];
        let controls = self.controls.iter();
        let controls = controls.map(|controls| controls.iter().map(|&u| x[u]).collect());
        let controls = ControlGrid::new(self.shape, controls.collect());
        let intervals = controls.intervals() as f64;
        let mut path = Path {
            horizon,
            controls,
            time: Vec::new(),
            states: Vec::new(),
        };
        let mut sequence = self.sequence.clone();
        for switch in &mut sequence.switches {
            switch.time = switch.interval as f64;
        }
        for (phase, solved) in self.phases.iter().zip(self.solved(point)) {
            let nodes = std::iter::once(0.0).chain(self.tableau.c().iter().copied());
            for (index, (node, input)) in nodes.zip(&solved.inputs).enumerate() {
                let mut forces = vec![0.0; contacts];
                let stage = &phase.stages[index.saturating_sub(1)];
                for (&i, &force) in phase.closed.iter().zip(&stage.forces) {
                    forces[i] = x[force] / solved.length;
                }
                path.time.push(solved.start + node * solved.length);
                let state = input[..phase.start.len()].iter().copied();
                path.states.push(state.chain(forces).collect());
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
        (path, sequence)
    }
}
