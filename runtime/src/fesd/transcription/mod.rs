//! The time-freezing system on a grid of control intervals as a mathematical program with complementarity
//! constraints: FESD in step form with FE-FE cross complementarity.
//!
//! Interval `k` of `N` has the numerical length `s_k` and ends at the physical time `(k+1) T / N`. On its
//! finite element `e` with start `y_e` and length `h_e s_k`:
//!
//! ```text
//! Y_m = y_e + h_e s_k sum_j a_mj F(Y_j, u_k, z_j)      0 = algebraic rows (Y_m, z_m)
//! y_{e+1} = y_e + h_e s_k sum_j b_j F(Y_j, u_k, z_j)   (Y of the last stage for a stiffly accurate scheme)
//! 0 <= sum_m alpha_m  _|_  ln_0 + sum_m ln_m >= 0
//! 0 <= sum_m beta_m   _|_  lp_0 + sum_m lp_m >= 0      (cross complementarity, a contact)
//! 0 <= p_m _|_ w_m >= 0                                (a stage and contact)
//! 0 <= c+_m _|_ c-_m >= 0                              (a stage and friction)
//! sum_e h_e = 1,  t at the end of interval k = t_0 + (k+1) T / N
//! ```
//!
//! and the same sums for the weights by which friction and restitution split a jump (see the step form). The
//! multipliers with index 0 are those at the end of the element before; they put switches on element
//! boundaries. Schemes without a stage at the end carry `lp, ln, p, w` there as boundary variables. The
//! objective contains `3e-4 sum_e (h_e / h_0 - 1)^2`, the mean step equilibration: lengths that no switch
//! determines stay equal. Sources: Nurkanovic et al., Numerische Mathematik 2024; Nurkanovic, Pozharskiy,
//! Frey, Diehl, Nonlinear Analysis: Hybrid Systems 54 (2024).

mod conditions;
mod corrections;
mod derivatives;
mod guess;
mod joints;
mod known;
mod laid_out;
mod modes;
mod names;
mod neighbours;
mod numbered;
mod program;
mod provided;
mod purposes;
mod ramps;
mod sites;
mod start;
mod task;
#[cfg(test)]
mod test_scenes;
#[cfg(test)]
mod tests;

use numbered::{
    Beginning, Block, Correction, Element, Impact, Interval, JointRows, Place, Provisions, Ramp,
};

pub(crate) use known::{KnownSides, known_sides};
pub(crate) use program::transcribe;
pub(crate) use purposes::size_groups;
pub(crate) use task::{Controls, Guess, Span, Task};

use std::ops::Range;

use hangtime_solver::nlp::Pattern;

use crate::dcs::{Group, HeavisideSystem};
use crate::fesd::finite_element::State;
use crate::model::{ContactTerms, OptimalControlDeclaration};
use crate::rk::ButcherTableau;

/// Smallest element length relative to the nominal one: elements of length zero would make the Jacobian
/// singular.
const SHORTEST: f64 = 1e-3;
/// Weight of the step equilibration: small enough to leave the complementarity to the solver, large
/// enough to fix the lengths that nothing else does.
const EQUILIBRATION: f64 = 3e-4;
/// Default bound of the numerical time relative to the physical time.
const SPEED_OF_TIME: f64 = 25.0;
/// Cross complementarity sums of one group and element.
const SUMS: usize = 4;

/// The program of a [`Task`].
// Many fields: a task, the numbering of its program, and the memory of its evaluation.
#[derive(Clone)]
pub(crate) struct Transcription<'a> {
    dcs: HeavisideSystem<'a>,
    tableau: ButcherTableau,
    task: Task,
    /// `(q, v, t, G, D)` at the start.
    start: Vec<f64>,
    /// Unit of each control unknown.
    control_units: Vec<f64>,
    intervals: Vec<Interval>,
    elements: Vec<Element>,
    /// The start of the motion, where it is free.
    beginning: Option<Beginning>,
    /// Where the functions that the scene declares are evaluated.
    sites: Vec<sites::Site>,
    /// The controls of blocks, where they are linear between nodes.
    ramps: Vec<Ramp>,
    provisions: Provisions,
    joints: JointRows,
    variables: usize,
    constraints: usize,
    /// Variable of the final time, if it is free.
    horizon: Option<usize>,
    /// First constraint of the goals.
    goal_rows: usize,
    speed_bound: f64,
    /// What is cross-complementary.
    groups: Vec<Group>,
    /// Values of the variables of each group at the start; only the multipliers count.
    start_values: Vec<[f64; SUMS]>,
    pairs: Vec<(usize, usize)>,
    jacobian: Pattern,
    hessian: Pattern,
    guess: Vec<f64>,
    local: Vec<f64>,
    rows: Vec<f64>,
}

impl<'a> Transcription<'a> {
    /// The variables and constraints of `task`, without guess and patterns.
    fn new(mut dcs: HeavisideSystem<'a>, tableau: &ButcherTableau, task: Task) -> Self {
        let mut y: Vec<f64> = task.start.q.iter().chain(&task.start.v).copied().collect();
        y.push(task.start.time);
        y.resize(dcs.layout.states(), 0.0);
        let mut local = vec![0.0; dcs.layout.local_variables()];
        local[..y.len()].copy_from_slice(&y);
        let controls = dcs.layout.states()..dcs.layout.states() + dcs.layout.controls();
        local[controls].copy_from_slice(task.controls.values(0));
        let rows = vec![0.0; dcs.layout.states() + dcs.layout.algebraic_equations()];
        dcs.shares(&local);
        let duration = task.horizon / task.intervals as f64;
        let mut speed_bound = SPEED_OF_TIME;
        for contact in 0..dcs.layout.contacts() {
            let velocity = dcs.system.normal_velocity(contact);
            // A bounce falls at the rate a_bar and rises at e^2 a_bar, to the speed e |v_n|.
            let e = dcs.system.restitution(contact);
            let rise = if e > 0.0 { 1.0 / e } else { 0.0 };
            let speed = velocity.abs() * (1.0 + rise) / dcs.system.auxiliary_acceleration;
            speed_bound = speed_bound.max(2.0 + 2.0 * speed / duration);
            y[dcs.layout.lifted_gap(contact)] = dcs.system.gap(contact);
        }
        local[..y.len()].copy_from_slice(&y);
        let shares = dcs.shares(&local);
        dcs.complete(&mut local, &shares);
        let groups = dcs.layout.groups();
        let start_values = (0..groups.len())
            .map(|group| {
                std::array::from_fn(|sum| {
                    let places = dcs.layout.summed(group, sum);
                    places.iter().map(|&place| local[place]).sum()
                })
            })
            .collect();
        let mut problem = Self {
            start: y,
            control_units: task.controls.units(),
            intervals: Vec::with_capacity(task.intervals),
            elements: Vec::with_capacity(task.intervals * task.elements),
            beginning: None,
            sites: Vec::new(),
            ramps: Vec::new(),
            provisions: Provisions::default(),
            joints: JointRows::default(),
            variables: 0,
            constraints: 0,
            horizon: None,
            goal_rows: 0,
            speed_bound,
            groups,
            start_values,
            pairs: Vec::new(),
            jacobian: Pattern::default(),
            hessian: Pattern::default(),
            guess: Vec::new(),
            local,
            rows,
            dcs,
            tableau: tableau.clone(),
            task,
        };
        problem.lay_out();
        problem
    }

    /// Reserves `count` variables and returns the first.
    fn take(&mut self, count: usize) -> usize {
        self.variables += count;
        self.variables - count
    }

    fn lay_out(&mut self) {
        self.horizon = self.task.horizon_bounds.map(|_| self.take(1));
        self.push_beginning();
        let (once, staged) = self.path_rows();
        for k in 0..self.task.intervals {
            let length = self.take(1);
            let (controls, ends) = self.take_controls();
            let rows = self.constraints;
            self.constraints += 2 + once;
            self.intervals.push(Interval {
                length,
                controls,
                ends,
                rows,
            });
            let (alike, closed) = (self.alike(k), self.corrected(k));
            for e in 0..self.task.elements {
                let corrected = closed.get(e).map_or(&[][..], |contacts| contacts);
                self.push_element(staged, alike.get(e) == Some(&true), corrected);
            }
        }
        self.goal_rows = self.constraints;
        self.constraints += self.goals().len();
    }

    /// Variables of the controls of the next interval, or else of those at its start, which end the interval before, and at its end.
    fn take_controls(&mut self) -> (Vec<usize>, Vec<usize>) {
        if matches!(self.task.controls, Controls::Fixed(_)) {
            return (Vec::new(), Vec::new());
        }
        let count = self.dcs.layout.controls();
        let before = self.intervals.last().map(|interval| interval.ends.clone());
        match before.filter(|ends| !ends.is_empty()) {
            Some(controls) => (controls, self.take_each(count)),
            None => {
                let controls = self.take_each(count);
                let ends = if self.task.controls.are_linear() {
                    self.take_each(count)
                } else {
                    Vec::new()
                };
                (controls, ends)
            }
        }
    }

    /// Reserves `count` variables and returns all of them.
    fn take_each(&mut self, count: usize) -> Vec<usize> {
        let first = self.take(count);
        (first..first + count).collect()
    }

    /// Adds the start of the motion, if any of its values is free.
    fn push_beginning(&mut self) {
        let free: Vec<usize> = self.task.free_start.iter().map(|f| f.0).collect();
        if free.is_empty() {
            return;
        }
        let n = self.dcs.system.coordinates();
        let layout = self.dcs.layout.clone();
        let moves = free.iter().any(|&k| k < n);
        let mut variables = vec![None; layout.local_variables()];
        for (place, slot) in variables.iter_mut().enumerate() {
            let gap = layout.lifted_gaps().contains(&place);
            let switching = place >= layout.first_algebraic()
                && place < layout.first_product()
                && layout.is_switching(place);
            if free.contains(&place) || gap && moves || switching {
                *slot = Some(self.take(1));
            }
        }
        for (first, second) in layout.stage_pairs() {
            let pair = variables[first].zip(variables[second]);
            self.pairs.extend(pair);
        }
        let algebraic_rows = self.constraints;
        let gap_rows = algebraic_rows + layout.switching_rows();
        let end = gap_rows + if moves { layout.contacts() } else { 0 };
        self.constraints = end;
        self.beginning = Some(Beginning {
            block: Block {
                variables,
                algebraic_rows,
                boundary: true,
            },
            gap_rows,
            end,
        });
        self.joints.first_at_start = self.constraints;
        self.constraints += self.task.joints_at_start.len();
    }

    /// What the scene declares for optimal control, if it is asked for.
    fn declared(&self) -> Option<OptimalControlDeclaration> {
        let declared = self.dcs.system.model.declaration().optimal_control;
        declared.filter(|_| self.task.declared)
    }

    /// The inputs of the model that are controls.
    fn control_inputs(&self) -> Range<usize> {
        let first = 2 * self.dcs.system.coordinates();
        first..first + self.dcs.layout.controls()
    }

    /// Numbers of the path constraints that are imposed once an interval, and at each stage.
    fn path_rows(&self) -> (usize, usize) {
        let Some(declared) = self.declared() else {
            return (0, 0);
        };
        let (once, staged) = self.by_interval(&declared);
        let count = |functions: &[usize]| sites::constraints_of(&declared, functions).len();
        (count(&once), count(&staged))
    }

    /// Path functions that have one value an interval, as they read nothing but controls that are constant there; the others.
    fn by_interval(&self, declared: &OptimalControlDeclaration) -> (Vec<usize>, Vec<usize>) {
        let inputs = self.dcs.system.model.declaration().inputs();
        let functions = sites::path_functions(declared, inputs);
        if self.task.controls.are_linear() {
            return (Vec::new(), functions);
        }
        sites::by_interval(declared, functions, self.control_inputs())
    }

    /// Terminal functions that are conditions of the program.
    fn goals(&self) -> Vec<usize> {
        let plain = 2 * self.dcs.system.coordinates() + 1;
        let Some(declared) = self.declared() else {
            return Vec::new();
        };
        let read = match (self.is_known(), self.last_stage()) {
            (false, _) => plain,
            (true, None) => plain + declared.contacts.sums,
            (true, Some(_)) => self.dcs.system.model.declaration().terminal_inputs(),
        };
        sites::goals(&declared, read)
    }

    /// Whether the motion is known at which the solver starts.
    fn is_known(&self) -> bool {
        matches!(self.task.guess, Guess::Known(_))
    }

    /// The stage at the end of a known motion, if the scheme has one there.
    fn last_stage(&self) -> Option<Place> {
        (self.is_known() && self.tableau.stiffly_accurate()).then(|| Place::Stage {
            element: self.task.intervals * self.task.elements - 1,
            stage: self.tableau.stages() - 1,
        })
    }

    /// Whether functions read forces and impulses of which the program knows nothing.
    pub(crate) fn leaves_out_forces(&self) -> bool {
        let terms = self.declared().map_or(ContactTerms::NONE, |d| d.contacts);
        terms.any() && (!self.is_known() || terms.terminal && self.last_stage().is_none())
    }

    /// Which elements of interval `k` are as long as the one before: those of the same span of a known motion. Nothing else decides
    /// their lengths, and an objective would move them to where its error of integration is largest.
    fn alike(&self, k: usize) -> Vec<bool> {
        let Guess::Known(intervals) = &self.task.guess else {
            return Vec::new();
        };
        let parts = laid_out::parts(&intervals[k], self.task.elements).into_iter();
        parts
            .flat_map(|count| (0..count).map(|part| part > 0))
            .collect()
    }

    /// Contacts that are closed in each element of interval `k` of a known motion, and along which coordinates would drift.
    fn corrected(&self, k: usize) -> Vec<Vec<usize>> {
        let Guess::Known(intervals) = &self.task.guess else {
            return Vec::new();
        };
        let contacts = 0..self.dcs.layout.contacts();
        let turning: Vec<usize> = contacts.filter(|&i| self.dcs.system.turns(i)).collect();
        laid_out::closed(&intervals[k], self.task.elements, &turning)
    }

    /// Adds an element to the last interval, with `staged` path constraints at each stage, perhaps the length of the element before,
    /// and the contacts whose coordinates are corrected.
    fn push_element(&mut self, staged: usize, alike: bool, corrected: &[usize]) {
        let states = self.dcs.layout.states();
        let first = self.variables;
        let before = self.elements.last().filter(|_| alike);
        let length = match before.map(|before| before.length) {
            Some(length) => length,
            None => self.take(1),
        };
        let interval = self.intervals.len() - 1;
        let mut blocks = Vec::new();
        let mut row = self.constraints;
        let collocation_rows = row;
        let boundary = usize::from(!self.tableau.stiffly_accurate());
        row += states * (self.tableau.stages() + boundary);
        for stage in 0..self.tableau.stages() + boundary {
            let boundary = stage == self.tableau.stages();
            let mut variables = vec![None; self.dcs.layout.local_variables()];
            for slot in variables.iter_mut().take(states) {
                *slot = Some(self.take(1));
            }
            let controls = self.controls_of_block(interval);
            for (slot, control) in variables[states..].iter_mut().zip(controls) {
                *slot = Some(control);
            }
            let first = self.dcs.layout.first_algebraic();
            for (place, slot) in variables.iter_mut().enumerate().skip(first) {
                let switching =
                    place < self.dcs.layout.first_product() && self.dcs.layout.is_switching(place);
                if !boundary || switching {
                    *slot = Some(self.take(1));
                }
            }
            blocks.push(Block {
                variables,
                algebraic_rows: row,
                boundary,
            });
            row += if boundary {
                self.dcs.layout.switching_rows()
            } else {
                self.dcs.layout.algebraic_equations()
            };
        }
        let corrections = self.take_corrections(corrected, blocks.len(), row);
        row += corrected.len() * blocks.len();
        row += self.push_ramps(interval, &blocks, row);
        let sums = self.take(SUMS * self.groups.len());
        for block in &blocks {
            for (first, second) in self.dcs.layout.stage_pairs() {
                let pair = block.variables[first].zip(block.variables[second]);
                self.pairs.extend(pair);
            }
        }
        for group in 0..self.groups.len() {
            let first = sums + SUMS * group;
            self.pairs.push((first, first + 1));
            self.pairs.push((first + 2, first + 3));
        }
        let path_rows = row + SUMS * self.groups.len();
        self.constraints = path_rows + staged * self.tableau.stages();
        self.elements.push(Element {
            interval,
            first,
            length,
            even: 1.0 / self.task.elements as f64,
            blocks,
            collocation_rows,
            sums,
            sum_rows: row,
            path_rows,
            corrections,
        });
    }

    /// Variables of the controls at a block of an interval: its own where they are linear.
    fn controls_of_block(&mut self, interval: usize) -> Vec<usize> {
        let shared = self.intervals[interval].controls.clone();
        if self.task.controls.are_linear() {
            self.take_each(shared.len())
        } else {
            shared
        }
    }

    /// Adds the ramps of blocks, their rows from `first` on, and returns how many there are.
    fn push_ramps(&mut self, interval: usize, blocks: &[Block], first: usize) -> usize {
        let places = (self.dcs.layout.states(), self.dcs.layout.time());
        let before = self.ramps.len();
        for block in blocks {
            let row = first + self.ramps.len() - before;
            let of = (interval, &self.intervals[interval]);
            self.ramps.extend(Ramp::of(block, places, of, row));
        }
        self.ramps.len() - before
    }

    /// Corrections along these contacts of an element with this many blocks, their rows from `first` on.
    fn take_corrections(
        &mut self,
        contacts: &[usize],
        blocks: usize,
        first: usize,
    ) -> Vec<Correction> {
        let number = |(k, &contact): (usize, &usize)| Correction {
            contact,
            first: self.take(blocks),
            rows: first + k * blocks,
            direction: Vec::new(),
        };
        contacts.iter().enumerate().map(number).collect()
    }

    /// The block with whose state element `index` starts; `None` where the start is given.
    fn block_before(&self, index: usize) -> Option<&Block> {
        match index.checked_sub(1) {
            Some(before) => self.elements[before].blocks.last(),
            None => self.beginning.as_ref().map(|beginning| &beginning.block),
        }
    }

    /// Variable of state component `k` at the start of element `index`, unless it is given.
    fn start_variable(&self, index: usize, k: usize) -> Option<usize> {
        self.block_before(index)
            .and_then(|block| block.variables[k])
    }

    /// State variables `y` at the end of element `index`.
    fn end_state(&self, index: usize) -> &[Option<usize>] {
        let last = self.elements[index].blocks.last();
        last.map_or(&[], |block| &block.variables[..self.dcs.layout.states()])
    }

    /// State variables `y` at the end of the motion.
    fn final_state(&self) -> &[Option<usize>] {
        self.end_state(self.elements.len() - 1)
    }

    /// Value of state component `k` at the start of element `index`.
    fn start_value(&self, x: &[f64], index: usize, k: usize) -> f64 {
        let variable = self.start_variable(index, k);
        variable.map_or(self.start[k], |variable| x[variable])
    }

    /// Weight of stage `j` in the collocation row of block `m`.
    fn weight(&self, m: usize, j: usize) -> f64 {
        if m < self.tableau.stages() {
            self.tableau.a(m, j)
        } else {
            self.tableau.b()[j]
        }
    }

    /// Unit of local variable `k`: controls are unknowns in units of their own.
    fn unit(&self, k: usize) -> f64 {
        let control = k.checked_sub(self.dcs.layout.states());
        control
            .and_then(|k| self.control_units.get(k))
            .copied()
            .unwrap_or(1.0)
    }

    /// Local vector of a block of an element.
    fn gather(&mut self, x: &[f64], element: usize, block: usize) {
        let interval = self.elements[element].interval;
        let variables = std::mem::take(&mut self.elements[element].blocks[block].variables);
        self.gather_from(x, interval, &variables);
        self.elements[element].blocks[block].variables = variables;
    }

    /// Local vector with these variables; other states are those of the start, other controls those of the interval.
    fn gather_from(&mut self, x: &[f64], interval: usize, variables: &[Option<usize>]) {
        let states = self.dcs.layout.states();
        self.local.fill(0.0);
        self.local[..states].copy_from_slice(&self.start);
        let given = self.task.controls.values(interval);
        self.local[states..states + given.len()].copy_from_slice(given);
        for (k, variable) in variables.iter().enumerate() {
            if let Some(variable) = variable {
                self.local[k] = self.unit(k) * x[*variable];
            }
        }
    }

    /// Constraint of local algebraic row `row` (counted after the states), if it applies in the block.
    fn algebraic_row(&self, block: &Block, row: usize) -> Option<usize> {
        if !block.boundary {
            return Some(block.algebraic_rows + row);
        }
        let row = self.dcs.layout.switching_row(row)?;
        Some(block.algebraic_rows + row)
    }

    /// Variables of a cross complementarity sum.
    fn sum_variables(&self, e: usize, group: usize, sum: usize) -> Vec<usize> {
        let places = self.dcs.layout.summed(group, sum);
        let before = self.block_before(e).filter(|_| sum % 2 == 1);
        let blocks = self.elements[e].blocks.iter().chain(before);
        let of_block = |block: &Block| -> Vec<usize> {
            let variables = places.iter().filter_map(|&place| block.variables[place]);
            variables.collect()
        };
        blocks.flat_map(of_block).collect()
    }

    /// Value of a cross complementarity sum.
    fn sum(&self, x: &[f64], e: usize, group: usize, sum: usize) -> f64 {
        let at_start = if e == 0 && sum % 2 == 1 && self.beginning.is_none() {
            self.start_values[group][sum]
        } else {
            0.0
        };
        let variables = self.sum_variables(e, group, sum);
        at_start + variables.iter().map(|&variable| x[variable]).sum::<f64>()
    }

    /// Number of finite elements.
    pub(crate) fn elements(&self) -> usize {
        self.elements.len()
    }

    /// Number of contacts, dry friction among them.
    pub(crate) fn contacts(&self) -> usize {
        self.dcs.system.contacts()
    }

    /// Length of the motion \[s\].
    pub(crate) fn horizon(&self, x: &[f64]) -> f64 {
        self.horizon
            .map_or(self.task.horizon, |variable| x[variable])
    }

    /// Controls of each interval, or at the nodes where they are linear in between.
    pub(crate) fn controls(&self, x: &[f64]) -> Vec<Vec<f64>> {
        if let Controls::Fixed(values) = &self.task.controls {
            return vec![values.clone(); self.intervals.len()];
        }
        let values = |variables: &Vec<usize>| -> Vec<f64> {
            let variables = variables.iter().zip(&self.control_units);
            variables
                .map(|(&variable, unit)| unit * x[variable])
                .collect()
        };
        let last = self.intervals.last().map(|interval| &interval.ends);
        let last = last.filter(|_| self.task.controls.are_linear());
        let intervals = self.intervals.iter().map(|interval| &interval.controls);
        intervals.chain(last).map(values).collect()
    }

    /// Length of element `e` in numerical time.
    pub(crate) fn numerical_length(&self, x: &[f64], e: usize) -> f64 {
        let element = &self.elements[e];
        x[element.length] * x[self.intervals[element.interval].length]
    }

    /// `(q, v)` at the start.
    pub(crate) fn initial_state(&self, x: &[f64]) -> Vec<f64> {
        let n = self.dcs.system.coordinates();
        (0..2 * n).map(|k| self.start_value(x, 0, k)).collect()
    }

    /// State at the end of element `e`.
    pub(crate) fn state(&self, x: &[f64], e: usize) -> State {
        let n = self.dcs.system.coordinates();
        let value = |k: usize| self.end_state(e)[k].map_or(f64::NAN, |variable| x[variable]);
        State {
            time: value(2 * n),
            q: (0..n).map(value).collect(),
            v: (n..2 * n).map(value).collect(),
        }
    }

    /// Mean step function `alpha` of `contact` in element `e`: 1 free, 0 jump, between in contact, as dry friction always
    /// is.
    pub(crate) fn mean_alpha(&self, x: &[f64], e: usize, contact: usize) -> f64 {
        if self.dcs.layout.is_dry(contact) {
            return 0.5;
        }
        x[self.elements[e].sums + SUMS * contact] / self.tableau.stages() as f64
    }

    /// Share of the friction of `contact` in element `e` that opposes forward sliding: 1 where it slides
    /// forward, 0 backward, between where it sticks; `None` without friction or without a force.
    pub(crate) fn slip_share(&self, x: &[f64], e: usize, contact: usize) -> Option<f64> {
        let first = self.elements[e].sums + SUMS * self.dcs.layout.slip_group(contact)?;
        let (forward, backward) = (x[first], x[first + 2]);
        let force = forward + backward;
        (force > 0.0).then(|| forward / force)
    }
}
