//! The variables of a time-freezing system on a grid, and what is read off them.

use super::field::Field;
use super::laid_out;
use super::layout::{Group, SLIP_MINUS, SLIP_PLUS};
use super::names;
use super::task::{Guess, Outer, Task};
use crate::model::held::{first_of_stages, is_held};
use crate::program::sparse_program::Program;
use crate::rk::ButcherTableau;

/// Smallest element length relative to the nominal one: elements of length zero would make the Jacobian
/// singular.
const SHORTEST: f64 = 1e-3;
/// Default bound of the numerical time relative to the physical time.
const SPEED_OF_TIME: f64 = 25.0;
/// Cross complementarity sums of one group and element.
pub(super) const SUMS: usize = 4;
/// Bounds of what has none.
const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
/// Bounds of what is not negative.
const POSITIVE: (f64, f64) = (0.0, f64::INFINITY);

/// A point at which the step form is stated: a Runge-Kutta stage, or the end of an element.
#[derive(Debug, Clone, Default)]
pub(crate) struct Block {
    /// Variable of each place of the local vector; none for weights at the end of an element.
    pub(crate) variables: Vec<Option<usize>>,
    /// Whether this is the end of an element: only the rows of the switching functions apply.
    pub(crate) boundary: bool,
}

impl Block {
    /// The variables of some places.
    pub(crate) fn at(&self, places: impl std::ops::RangeBounds<usize>) -> Vec<usize> {
        self.variables[(places.start_bound().cloned(), places.end_bound().cloned())]
            .iter()
            .copied()
            .flatten()
            .collect()
    }
}

/// One finite element.
#[derive(Debug, Clone)]
pub(crate) struct Element {
    pub(crate) interval: usize,
    /// The variable of its length, which may be that of the element before.
    pub(crate) length: usize,
    /// Its length over that of its interval where nothing else decides it.
    pub(crate) even: f64,
    /// Blocks of the stages, then of the end if there is no stage.
    pub(crate) blocks: Vec<Block>,
    /// First sum variable, `SUMS` a group: for a contact alpha, ln, beta, lp.
    pub(crate) sums: usize,
    /// What keeps coordinates on curved surfaces.
    pub(crate) corrections: Vec<Correction>,
    /// Variables of each condition, at the start of an element that another one comes before.
    pub(super) turns: Vec<Turn>,
}

/// A condition at the start of an element.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turn {
    pub(crate) condition: usize,
    /// Whether it comes true there, and whether it does not.
    pub(crate) sets: [usize; 2],
    /// By how much that is more than its share rises.
    pub(crate) more: usize,
}

/// What keeps coordinates on the surface of one contact in one element.
#[derive(Debug, Clone)]
pub(crate) struct Correction {
    pub(crate) contact: usize,
    /// The unknowns `mu` \[m\], one a block.
    pub(crate) variables: Vec<usize>,
}

/// One control interval.
#[derive(Debug, Clone)]
pub(crate) struct Interval {
    /// Variable of the numerical length \[s\].
    pub(crate) length: usize,
    /// Variables of the controls, or where they are linear those at its start, and those at its end, of which there are none else.
    pub(crate) controls: Vec<usize>,
    pub(crate) ends: Vec<usize>,
}

/// The variables of a [`Task`] in a program.
pub(crate) struct Transcription<'a> {
    pub(crate) program: Program<'a>,
    pub(crate) field: Field<'a>,
    pub(crate) tableau: ButcherTableau,
    pub(crate) task: Task,
    pub(crate) outer: Outer,
    pub(crate) intervals: Vec<Interval>,
    pub(crate) elements: Vec<Element>,
    /// The start of the motion.
    pub(super) beginning: Block,
    /// Whether any of its states is free.
    pub(super) is_free: bool,
    /// What is cross-complementary.
    pub(super) groups: Vec<Group>,
    /// Most of the numerical time relative to the physical time.
    pub(super) speed_bound: f64,
}

impl<'a> Transcription<'a> {
    /// The variables of `task`, without guess and rows.
    pub(super) fn new(
        program: Program<'a>,
        outer: Outer,
        field: Field<'a>,
        tableau: &ButcherTableau,
        task: Task,
    ) -> Self {
        let mut own = Self {
            groups: field.layout.groups(),
            is_free: false,
            beginning: Block::default(),
            intervals: Vec::with_capacity(task.intervals),
            elements: Vec::with_capacity(task.intervals * task.elements),
            speed_bound: SPEED_OF_TIME,
            tableau: tableau.clone(),
            program,
            field,
            task,
            outer,
        };
        own.begin();
        for k in 0..own.task.intervals {
            own.push_interval(k);
        }
        own
    }

    /// Fixes the patterns of the program; call once, after everything is added.
    pub(crate) fn finished(self) -> Self {
        Self {
            program: self.program.finish(&[], |_| 1.0),
            ..self
        }
    }

    /// Adds a variable.
    pub(crate) fn take(&mut self, name: String, range: (f64, f64)) -> usize {
        self.program.variable(name, range, 0.0, 1.0)
    }

    /// Adds a row that has this value.
    pub(crate) fn row(&mut self, name: impl Into<String>, value: f64) -> usize {
        self.program.row(name, value, value)
    }

    /// Terms (place, factor, variable) of the weight with which a contact presses, each times a product: where its coefficient of
    /// restitution is an unknown, that twice.
    pub(super) fn pressing(&self, contact: usize) -> Vec<(usize, f64, Vec<usize>)> {
        let unknown = self.program.laws().restitution(contact);
        let terms = self.field.pressing(contact).into_iter().enumerate();
        let term = |(part, (place, factor)): (usize, (usize, f64))| match unknown {
            Some(e) if part > 0 => (place, 1.0, vec![e, e]),
            _ => (place, factor, Vec::new()),
        };
        terms.map(term).collect()
    }

    /// The coefficient of friction of a contact, or 1 and its variable where it is an unknown.
    fn rubbing(&self, contact: usize) -> (f64, Option<usize>) {
        match self.program.laws().friction(contact) {
            Some(mu) => (1.0, Some(mu)),
            None => (self.field.friction(contact), None),
        }
    }

    /// What contacts provide, by number, the normal accelerations first and then those along the sliding velocities, over `a_bar` and
    /// the speed of the clock: terms as of [`pressing`](Self::pressing).
    pub(crate) fn provision(&self, number: usize) -> Vec<(usize, f64, Vec<usize>)> {
        let layout = &self.field.layout;
        let Some(contact) = number.checked_sub(self.contacts()) else {
            let presses = !layout.is_dry(number);
            return if presses {
                self.pressing(number)
            } else {
                Vec::new()
            };
        };
        let acts = |&rough: &usize| rough == contact && !layout.is_condition(contact);
        let Some(r) = layout.rough.iter().position(acts) else {
            return Vec::new();
        };
        let (mu, unknown) = self.rubbing(contact);
        let parts = [(SLIP_MINUS, mu), (SLIP_PLUS, -mu)].into_iter();
        let term = |(offset, factor)| {
            let variables = unknown.into_iter().collect();
            (layout.friction_place(r, offset), factor, variables)
        };
        parts.map(term).collect()
    }

    /// The size of what has that number, over `a_bar`.
    pub(crate) fn size_of_provision(&self, number: usize) -> f64 {
        let contact = number.checked_sub(self.contacts());
        contact.map_or(1.0, |contact| self.field.friction(contact))
    }

    /// Whether a component of `(q, v)` is free at the start.
    fn is_free_at_start(&self, k: usize) -> bool {
        let (lower, upper) = self.program.bounds(self.outer.start[k]);
        lower < upper
    }

    /// Whether any coordinate is, so that gaps are unknown there.
    pub(super) fn gaps_are_free(&self) -> bool {
        (0..self.field.coordinates()).any(|k| self.is_free_at_start(k))
    }

    /// Adds the start of the motion: its clock, gaps and switching functions, numbers but where its states are free.
    fn begin(&mut self) {
        let layout = self.field.layout.clone();
        let n = self.field.coordinates();
        self.is_free = (0..2 * n).any(|k| self.is_free_at_start(k));
        let moves = self.gaps_are_free();
        let guessed = |variables: &[usize]| -> Vec<f64> {
            let values = variables.iter().map(|&i| self.program.guessed(i));
            values.collect()
        };
        let mut local = guessed(&self.outer.start);
        let controls = guessed(&self.outer.controls[0]);
        local.push(self.task.time);
        local.resize(layout.states(), 0.0);
        local.extend(controls);
        local.resize(layout.local_variables(), 0.0);
        self.field.locate(&local);
        let duration = self.program.guessed(self.outer.horizon) / self.task.intervals as f64;
        for contact in 0..layout.contacts {
            // A bounce falls at the rate a_bar and rises at e^2 a_bar, to the speed e |v_n|.
            let e = self.field.restitution(contact);
            let rise = if e > 0.0 { 1.0 / e } else { 0.0 };
            let velocity = self.field.normal_velocity(contact).abs();
            let speed = velocity * (1.0 + rise) / self.field.auxiliary_acceleration;
            self.speed_bound = self.speed_bound.max(2.0 + 2.0 * speed / duration);
            local[layout.lifted_gap(contact)] = self.field.gap(contact);
        }
        self.field
            .complete(&mut local, &vec![1.0; self.groups.len()]);
        let gaps: Vec<f64> = local[layout.lifted_gaps()].to_vec();
        for (place, value) in local.into_iter().enumerate() {
            let gap = layout.lifted_gaps().contains(&place);
            let paired = layout.first_algebraic()..layout.first_product();
            let switching = paired.contains(&place) && layout.is_switching(place);
            let variable = if place < 2 * n {
                Some(self.outer.start[place])
            } else if place < layout.states() || switching {
                let range = if gap && moves {
                    let idle = self.is_idle(place - layout.lifted_gap(0), &gaps);
                    if idle { FREE } else { POSITIVE }
                } else if switching && self.is_free {
                    POSITIVE
                } else {
                    (value, value)
                };
                let name = format!("{} at the start", names::local(&self.field, place));
                let variable = self.take(name, range);
                self.program.set_guess(variable, value);
                Some(variable)
            } else {
                let control = place.checked_sub(layout.states());
                control.and_then(|k| self.outer.controls[0].get(k).copied())
            };
            self.beginning.variables.push(variable);
        }
        self.beginning.boundary = true;
        if self.is_free {
            let beginning = self.beginning.clone();
            self.push_pairs(&beginning);
        }
    }

    /// Whether another piece of its edge acts in place of a contact where gaps are these.
    fn is_idle(&self, contact: usize, gaps: &[f64]) -> bool {
        let declared = &self.field.model.declaration().contacts[contact];
        let mut others = declared.alternatives.iter();
        others.any(|&other| {
            gaps[other] > gaps[contact] || gaps[other] == gaps[contact] && other < contact
        })
    }

    /// Declares the pairs of a block.
    fn push_pairs(&mut self, block: &Block) {
        for (first, second) in self.field.layout.stage_pairs() {
            if let (Some(i), Some(j)) = (block.variables[first], block.variables[second]) {
                self.program.pair(i, j);
            }
        }
    }

    /// Adds interval `k` with its elements.
    fn push_interval(&mut self, k: usize) {
        let count = self.task.intervals as f64;
        let (least, most) = self.program.bounds(self.outer.horizon);
        let name = format!("numerical length of {}", self.interval_name(k));
        let range = (least / count, self.speed_bound * most / count);
        let length = self.take(name, range);
        let linear = self.task.linear;
        let nodes = &self.outer.controls;
        self.intervals.push(Interval {
            length,
            controls: nodes[k].clone(),
            ends: if linear {
                nodes[k + 1].clone()
            } else {
                Vec::new()
            },
        });
        let (mut alike, mut closed) = (Vec::new(), Vec::new());
        if let Guess::Known(intervals) = &self.task.guess {
            let contacts = 0..self.field.layout.contacts;
            let turning: Vec<usize> = contacts.filter(|&i| self.field.turns(i)).collect();
            alike = laid_out::alike(&intervals[k], self.task.elements);
            closed = laid_out::closed(&intervals[k], self.task.elements, &turning);
        }
        for e in 0..self.task.elements {
            let corrected = closed.get(e).map_or(&[][..], |contacts| contacts);
            self.push_element(alike.get(e) == Some(&true), corrected);
        }
    }

    /// Adds an element to the last interval, perhaps with the length of the element before, and with the contacts whose coordinates
    /// are corrected.
    fn push_element(&mut self, alike: bool, corrected: &[usize]) {
        let e = self.elements.len();
        let interval = self.intervals.len() - 1;
        let element = self.element_name(e);
        let before = self.elements.last().filter(|_| alike);
        let length = match before.map(|before| before.length) {
            Some(length) => length,
            None => {
                let range = (SHORTEST * self.nominal(), 1.0);
                self.take(format!("length of {element}"), range)
            }
        };
        let stages = self.tableau.stages();
        let count = stages + usize::from(!self.tableau.stiffly_accurate());
        let places: Vec<String> = (0..count).map(|block| self.block_name(e, block)).collect();
        let mut blocks = Vec::with_capacity(count);
        for (block, place) in places.iter().enumerate() {
            let kind = (block == stages, block + 1 == count);
            blocks.push(self.take_block(interval, kind, place));
        }
        let corrections = corrected.iter().map(|&contact| {
            let along = names::contact(&self.field, contact);
            let name = |place: &String| format!("correction along {along} at {place}");
            let variables = places.iter().map(name);
            let variables = variables.map(|name| self.take(name, FREE));
            let variables = variables.collect();
            Correction { contact, variables }
        });
        let corrections = corrections.collect();
        let (sums, _) = self.program.extent();
        for group in 0..self.groups.len() {
            for sum in 0..SUMS {
                let name = format!("sum of {} in {element}", self.summed_name(group, sum));
                self.take(name, POSITIVE);
            }
        }
        let turns = self.take_turns(e, &element);
        for block in &blocks {
            self.push_pairs(block);
        }
        self.elements.push(Element {
            interval,
            length,
            even: self.nominal(),
            blocks,
            sums,
            corrections,
            turns,
        });
        for group in 0..self.groups.len() {
            for weight in [0, 2] {
                // The sum of the weights of the stages of an element against that of the multipliers, of the end before it as well: so the mode of
                // a contact, or the side of a switch, is the same all over the element, by one pair.
                let first = self.elements[e].sums + SUMS * group + weight;
                self.program.pair(first, first + 1);
            }
        }
    }

    /// Adds the variables of conditions at the start of an element.
    fn take_turns(&mut self, e: usize, element: &str) -> Vec<Turn> {
        let conditions = self.field.layout.conditions.clone().into_iter();
        let turn = |condition| {
            let own = names::contact(&self.field, condition);
            let mut take =
                |what: &str| self.take(format!("{what} of {own} in {element}"), POSITIVE);
            Turn {
                condition,
                sets: ["beginning", "waiting"].map(&mut take),
                more: take("return"),
            }
        };
        conditions.filter(|_| e > 0).map(turn).collect()
    }

    /// Adds the variables of a block of an interval, which may be a boundary and the end of its element.
    fn take_block(
        &mut self,
        interval: usize,
        (boundary, last): (bool, bool),
        place: &str,
    ) -> Block {
        let layout = self.field.layout.clone();
        let n = self.field.coordinates();
        let first = first_of_stages(self.field.model);
        let own = self.task.linear;
        let mut variables = Vec::with_capacity(layout.local_variables());
        for k in 0..layout.local_variables() {
            let control = k.checked_sub(layout.states());
            let shared = control.and_then(|i| self.intervals[interval].controls.get(i).copied());
            let unit = shared.map_or(1.0, |shared| self.program.unit(shared));
            let range = if k < layout.states() {
                let (lower, upper) = &self.task.coordinate_bounds;
                let bounded = last && k < n;
                Some(if bounded { (lower[k], upper[k]) } else { FREE })
            } else if shared.is_some() {
                Some(FREE)
            } else if k >= layout.first_product() {
                (!boundary).then_some(FREE)
            } else {
                // alpha + beta = 1 bounds both from above, and with them their parts
                (!boundary || layout.is_switching(k)).then_some(POSITIVE)
            };
            let known = if k < 2 * n && is_held(self.field.model, k) {
                Some(self.outer.start[k])
            } else {
                shared.filter(|_| !own && control < Some(first))
            };
            let name = format!("{} at {place}", names::local(&self.field, k));
            let new = |range| self.program.variable(name, range, 0.0, unit);
            variables.push(known.or_else(|| range.map(new)));
        }
        Block {
            variables,
            boundary,
        }
    }

    /// Length of an element over that of its interval, if all are equal.
    pub(super) fn nominal(&self) -> f64 {
        1.0 / self.task.elements as f64
    }

    /// Says how long an element is where nothing else decides it.
    pub(super) fn set_even(&mut self, e: usize, even: f64) {
        let shortest = SHORTEST * self.nominal().min(even);
        let element = &mut self.elements[e];
        element.even = even;
        self.program.bound(element.length, shortest, 1.0);
    }

    /// Interval `k`, with its physical time if that is known before the solution.
    pub(crate) fn interval_name(&self, k: usize) -> String {
        let (least, most) = self.program.bounds(self.outer.horizon);
        if least < most {
            return format!("interval {k}");
        }
        let duration = self.program.guessed(self.outer.horizon) / self.task.intervals as f64;
        let from = self.task.time + k as f64 * duration;
        format!("interval {k}, {from:.4} to {:.4} s", from + duration)
    }

    /// Element `e` of the whole motion, as element of its interval.
    pub(crate) fn element_name(&self, e: usize) -> String {
        let count = self.task.elements;
        let interval = self.interval_name(e / count);
        format!("element {} of {interval}", e % count)
    }

    /// Stage or end of an element.
    pub(crate) fn block_name(&self, e: usize, block: usize) -> String {
        let element = self.element_name(e);
        if block == self.tableau.stages() {
            format!("the end of {element}")
        } else {
            format!("stage {block} of {element}")
        }
    }

    /// What a cross complementarity sum adds up.
    pub(super) fn summed_name(&self, group: usize, sum: usize) -> String {
        names::local(&self.field, self.groups[group].places[sum])
    }

    /// The block with whose state element `index` starts.
    pub(crate) fn block_before(&self, index: usize) -> &Block {
        let before = index.checked_sub(1).map(|before| &self.elements[before]);
        let last = before.and_then(|before| before.blocks.last());
        last.unwrap_or(&self.beginning)
    }

    /// Weight of stage `j` in the collocation row of block `m`.
    pub(super) fn weight(&self, m: usize, j: usize) -> f64 {
        if m < self.tableau.stages() {
            self.tableau.a(m, j)
        } else {
            self.tableau.b()[j]
        }
    }

    /// Variable of the sum over the stages of an element of the share in which a condition is true.
    pub(super) fn sum_that_holds(&self, e: usize, condition: usize) -> usize {
        let group = self.field.layout.slip_group(condition).unwrap_or(0);
        self.elements[e].sums + SUMS * group + 2
    }

    /// Variables of a cross complementarity sum, with those of a given start if they are asked for.
    fn summed(&self, e: usize, group: usize, sum: usize, given: bool) -> Vec<usize> {
        let places = self.field.layout.summed(group, sum);
        let counts = e > 0 || self.is_free || given;
        let before = (sum % 2 == 1 && counts).then(|| self.block_before(e));
        let blocks = self.elements[e].blocks.iter().chain(before);
        let of_block = |block: &Block| -> Vec<usize> {
            let variables = places.iter().filter_map(|&place| block.variables[place]);
            variables.collect()
        };
        blocks.flat_map(of_block).collect()
    }

    /// Variables of a cross complementarity sum that are unknowns.
    pub(super) fn sum_variables(&self, e: usize, group: usize, sum: usize) -> Vec<usize> {
        self.summed(e, group, sum, false)
    }

    /// All terms of a cross complementarity sum.
    pub(super) fn sum_terms(&self, e: usize, group: usize, sum: usize) -> Vec<usize> {
        self.summed(e, group, sum, true)
    }

    /// Value of a cross complementarity sum.
    pub(super) fn sum(&self, x: &[f64], e: usize, group: usize, sum: usize) -> f64 {
        let terms = self.sum_terms(e, group, sum);
        terms.iter().map(|&variable| x[variable]).sum()
    }

    /// Variables of `(q, v, u[, t])` at a block.
    pub(crate) fn inputs(&self, block: &Block) -> [Vec<usize>; 3] {
        let (n, layout) = (self.field.coordinates(), &self.field.layout);
        let mut u = block.at(layout.states()..layout.first_algebraic());
        if self.field.model.declaration().explicit_time {
            u.extend(block.variables[layout.time()]);
        }
        [block.at(0..n), block.at(n..2 * n), u]
    }

    /// Variables whose product is the speed of the clock times the length of an element at a block.
    pub(crate) fn passing(&self, e: usize, block: &Block) -> Vec<usize> {
        let element = &self.elements[e];
        let theta = self.field.layout.theta();
        let lengths = [element.length, self.intervals[element.interval].length];
        let theta = theta.and_then(|place| block.variables[place]);
        lengths.into_iter().chain(theta).collect()
    }

    /// Where the solver starts, in physical values.
    pub(crate) fn guess(&self) -> Vec<f64> {
        let (variables, _) = self.program.extent();
        (0..variables).map(|i| self.program.guessed(i)).collect()
    }

    /// Number of finite elements.
    pub(crate) fn elements(&self) -> usize {
        self.elements.len()
    }

    /// Number of contacts, dry friction among them.
    pub(crate) fn contacts(&self) -> usize {
        self.field.contacts()
    }

    /// Length of the motion \[s\].
    pub(crate) fn horizon(&self, x: &[f64]) -> f64 {
        self.program.unit(self.outer.horizon) * x[self.outer.horizon]
    }

    /// Controls of each interval, or at the nodes where they are linear in between.
    pub(crate) fn controls(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let value = |&i: &usize| self.program.unit(i) * x[i];
        let nodes = self.outer.controls.iter();
        nodes.map(|u| u.iter().map(value).collect()).collect()
    }

    /// `(q, v)` at the start.
    pub(crate) fn initial_state(&self, x: &[f64]) -> Vec<f64> {
        self.values(x, &self.outer.start)
    }

    /// Values of variables.
    fn values(&self, x: &[f64], variables: &[usize]) -> Vec<f64> {
        let value = |&i: &usize| self.program.unit(i) * x[i];
        variables.iter().map(value).collect()
    }

    /// `(q, v, t)` at the end of element `e`.
    pub(crate) fn state(&self, x: &[f64], e: usize) -> Vec<f64> {
        let end = self.block_before(e + 1);
        self.values(x, &end.at(0..=self.field.layout.time()))
    }

    /// Mean step function `alpha` of `contact` in element `e`: 1 free, 0 jump, between in contact, as dry friction always
    /// is. Of a condition it is 1 before it comes true, and 0 while it is true.
    pub(crate) fn mean_alpha(&self, x: &[f64], e: usize, contact: usize) -> f64 {
        let layout = &self.field.layout;
        if layout.is_condition(contact) {
            return 1.0 - x[self.sum_that_holds(e, contact)] / self.tableau.stages() as f64;
        }
        if layout.is_dry(contact) {
            return 0.5;
        }
        x[self.elements[e].sums + SUMS * contact] / self.tableau.stages() as f64
    }

    /// Name of a complementarity pair: what complements each other, and where.
    pub(crate) fn complementarity_name(&self, index: usize) -> String {
        names::pair(&self.program, index)
    }
}
