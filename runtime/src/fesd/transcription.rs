//! One control stage of the time-freezing system as a mathematical program with complementarity
//! constraints: FESD in step form with FE-FE cross complementarity.
//!
//! On finite element `e` with start `y_e`, length `h_e` and speed of time `s`:
//!
//! ```text
//! Y_m = y_e + h_e s sum_j a_mj F(Y_j, z_j)      0 = algebraic rows (Y_m, z_m)
//! y_{e+1} = y_e + h_e s sum_j b_j F(Y_j, z_j)   (Y of the last stage for a stiffly accurate scheme)
//! 0 <= sum_m alpha_m  _|_  ln_0 + sum_m ln_m >= 0
//! 0 <= sum_m beta_m   _|_  lp_0 + sum_m lp_m >= 0      (cross complementarity, a contact)
//! 0 <= p_m _|_ w_m >= 0                                (a stage and contact)
//! sum_e h_e = T,  t_end = t_0 + T
//! ```
//!
//! The multipliers with index 0 are those at the end of the element before; they put switches on element
//! boundaries. Schemes without a stage at the end carry `lp, ln, p, w` there as boundary variables. The
//! objective `1e-4 sum_e (h_e / h_0 - 1)^2` is the mean step equilibration: lengths that no switch determines
//! stay equal. Sources: Nurkanovic et al., Numerische Mathematik 2024; Nurkanovic, Pozharskiy, Frey, Diehl,
//! Nonlinear Analysis: Hybrid Systems 54 (2024).

use crate::dcs::{ALPHA, BETA, HeavisideSystem, LAMBDA_MINUS, LAMBDA_PLUS, P, PER_CONTACT, W};
use crate::fesd::finite_element::State;
use crate::mpcc::Mpcc;
use crate::nlp::NlpProblem;
use crate::rk::ButcherTableau;
use std::collections::BTreeMap;

/// Smallest element length relative to the nominal one: elements of length zero would make the Jacobian
/// singular.
const SHORTEST: f64 = 1e-4;
/// Weight of the step equilibration: small enough to leave the complementarity to the solver, large
/// enough to fix the lengths that nothing else does. With 1e-4, 88 of 104 impact steps of a ball were solved;
/// with 1, 63, with 1e-6, 49.
const EQUILIBRATION: f64 = 1e-4;
/// Default bound of the speed of time.
const SPEED_OF_TIME: f64 = 25.0;
/// Cross complementarity sums of one contact and element.
const SUMS: usize = 4;

/// A point at which the step form is evaluated: a Runge-Kutta stage, or the end of an element.
struct Block {
    /// Variable of each local one, unless it is constant there.
    variables: Vec<Option<usize>>,
    /// First constraint of the algebraic rows.
    algebraic_rows: usize,
    /// Whether this is the end of an element: only the rows of the switching functions apply.
    boundary: bool,
}

/// One finite element: where its variables and constraints begin.
struct Element {
    length: usize,
    /// Blocks of the stages, then of the boundary if there is one.
    blocks: Vec<Block>,
    /// First of the collocation constraints, one group of `2 n + 1` a block.
    collocation_rows: usize,
    /// First sum variable, `SUMS` a contact: alpha, ln, beta, lp.
    sums: usize,
    /// First constraint that defines the sums.
    sum_rows: usize,
}

/// Which number multiplies what in a pattern whose values come in a fixed order.
#[derive(Default)]
struct Pattern {
    entries: Vec<(usize, usize)>,
    /// Place in `entries` of each addition, in order.
    places: Vec<usize>,
}

impl Pattern {
    fn new(additions: &[(usize, usize)]) -> Self {
        let mut index = BTreeMap::new();
        let mut pattern = Self::default();
        for &position in additions {
            let place = *index.entry(position).or_insert_with(|| {
                pattern.entries.push(position);
                pattern.entries.len() - 1
            });
            pattern.places.push(place);
        }
        pattern
    }
}

/// The program of one control stage.
pub(crate) struct Transcription<'a> {
    dcs: HeavisideSystem<'a>,
    tableau: &'a ButcherTableau,
    controls: Vec<f64>,
    start: Vec<f64>,
    duration: f64,
    elements: Vec<Element>,
    variables: usize,
    constraints: usize,
    speed_of_time: usize,
    speed_bound: f64,
    /// Multipliers `(lp, ln)` of each contact at the start.
    start_multipliers: Vec<(f64, f64)>,
    pairs: Vec<(usize, usize)>,
    jacobian: Pattern,
    hessian: Pattern,
    guess: Vec<f64>,
    local: Vec<f64>,
    rows: Vec<f64>,
}

impl<'a> Transcription<'a> {
    /// The control stage that starts at `start`, lasts `duration` [s, physical] under constant controls
    /// `u`, with `elements` finite elements.
    pub(crate) fn new(
        mut dcs: HeavisideSystem<'a>,
        tableau: &'a ButcherTableau,
        start: &State,
        u: &[f64],
        duration: f64,
        elements: usize,
    ) -> Self {
        let mut y: Vec<f64> = start.q.iter().chain(&start.v).copied().collect();
        y.push(start.time);
        let mut local = vec![0.0; dcs.local_variables()];
        local[..y.len()].copy_from_slice(&y);
        local[y.len()..y.len() + u.len()].copy_from_slice(u);
        let mut rows = vec![0.0; dcs.states() + dcs.algebraic_equations()];
        dcs.rows(&local, &mut rows);
        let mut speed_bound = SPEED_OF_TIME;
        let start_multipliers = (0..dcs.contacts())
            .map(|contact| {
                let (gap, velocity) =
                    (dcs.system.gap(contact), dcs.system.normal_velocity(contact));
                let speed = velocity.abs() / dcs.system.auxiliary_acceleration;
                speed_bound = speed_bound.max(2.0 + 2.0 * speed / duration);
                let margin = gap.max(velocity);
                (margin.max(0.0), (-margin).max(0.0))
            })
            .collect();
        let mut problem = Self {
            controls: u.to_vec(),
            start: y,
            duration,
            elements: Vec::with_capacity(elements),
            variables: 1,
            constraints: 2,
            speed_of_time: 0,
            speed_bound,
            start_multipliers,
            pairs: Vec::new(),
            jacobian: Pattern::default(),
            hessian: Pattern::default(),
            guess: Vec::new(),
            local,
            rows,
            dcs,
            tableau,
        };
        for _ in 0..elements {
            problem.push_element();
        }
        problem.set_guess();
        problem.set_patterns();
        problem
    }

    fn push_element(&mut self) {
        let states = self.dcs.states();
        let mut take = |count: usize| {
            self.variables += count;
            self.variables - count
        };
        let length = take(1);
        let mut blocks = Vec::new();
        let mut row = self.constraints;
        let collocation_rows = row;
        let boundary = usize::from(!self.tableau.stiffly_accurate());
        row += states * (self.tableau.stages() + boundary);
        for stage in 0..self.tableau.stages() + boundary {
            let boundary = stage == self.tableau.stages();
            let mut variables = vec![None; self.dcs.local_variables()];
            for slot in variables.iter_mut().take(states) {
                *slot = Some(take(1));
            }
            for contact in 0..self.dcs.contacts() {
                for offset in 0..PER_CONTACT {
                    if !(boundary && matches!(offset, ALPHA | BETA)) {
                        variables[self.dcs.algebraic(contact, offset)] = Some(take(1));
                    }
                }
            }
            if !boundary {
                for slot in &mut variables[states + self.dcs.controls()..] {
                    slot.get_or_insert_with(|| take(1));
                }
            }
            blocks.push(Block {
                variables,
                algebraic_rows: row,
                boundary,
            });
            row += if boundary {
                2 * self.dcs.contacts()
            } else {
                self.dcs.algebraic_equations()
            };
        }
        let sums = take(SUMS * self.dcs.contacts());
        for block in &blocks {
            for contact in 0..self.dcs.contacts() {
                let place = |offset| block.variables[self.dcs.algebraic(contact, offset)];
                self.pairs.extend(place(P).zip(place(W)));
            }
        }
        for contact in 0..self.dcs.contacts() {
            let first = sums + SUMS * contact;
            self.pairs.push((first, first + 1));
            self.pairs.push((first + 2, first + 3));
        }
        self.constraints = row + SUMS * self.dcs.contacts();
        self.elements.push(Element {
            length,
            blocks,
            collocation_rows,
            sums,
            sum_rows: row,
        });
    }

    /// State variables `y` at the end of element `index`.
    fn end_state(&self, index: usize) -> &[Option<usize>] {
        let last = self.elements[index].blocks.last();
        last.map_or(&[], |block| &block.variables[..self.dcs.states()])
    }

    /// Value of state component `k` at the start of element `index`.
    fn start_value(&self, x: &[f64], index: usize, k: usize) -> f64 {
        if index == 0 {
            return self.start[k];
        }
        self.end_state(index - 1)[k].map_or(0.0, |variable| x[variable])
    }

    /// Weight of stage `j` in the collocation row of block `m`.
    fn weight(&self, m: usize, j: usize) -> f64 {
        if m < self.tableau.stages() {
            self.tableau.a(m, j)
        } else {
            self.tableau.b()[j]
        }
    }

    /// Local vector of a block.
    fn gather(&mut self, x: &[f64], element: usize, block: usize) {
        let states = self.dcs.states();
        self.local.fill(0.0);
        for (value, variable) in self
            .local
            .iter_mut()
            .zip(&self.elements[element].blocks[block].variables)
        {
            if let Some(variable) = variable {
                *value = x[*variable];
            }
        }
        self.local[states..states + self.controls.len()].copy_from_slice(&self.controls);
    }

    /// Constraint of local algebraic row `row` (counted after the states), if it applies in the block.
    fn algebraic_row(&self, block: &Block, row: usize) -> Option<usize> {
        if !block.boundary {
            return Some(block.algebraic_rows + row);
        }
        let (contact, which) = (row / 3, row % 3);
        (contact < self.dcs.contacts() && which > 0)
            .then(|| block.algebraic_rows + 2 * contact + which - 1)
    }

    /// Motion without forces, with every step function undecided.
    fn set_guess(&mut self) {
        let n = self.dcs.system.coordinates();
        let mut guess = vec![0.0; self.variables];
        guess[self.speed_of_time] = 1.0;
        let count = self.elements.len();
        let nominal = self.duration / count as f64;
        for e in 0..count {
            guess[self.elements[e].length] = nominal;
            for b in 0..self.elements[e].blocks.len() {
                let c = self.tableau.c().get(b).copied().unwrap_or(1.0);
                let elapsed = (e as f64 + c) * nominal;
                self.local.fill(0.0);
                for k in 0..n {
                    self.local[k] = self.start[k] + elapsed * self.start[n + k];
                    self.local[n + k] = self.start[n + k];
                }
                self.local[2 * n] = self.start[2 * n] + elapsed;
                let states = self.dcs.states();
                self.local[states..states + self.controls.len()].copy_from_slice(&self.controls);
                self.dcs.rows(&self.local, &mut self.rows);
                for contact in 0..self.dcs.contacts() {
                    let (gap, velocity) = (
                        self.dcs.system.gap(contact),
                        self.dcs.system.normal_velocity(contact),
                    );
                    let margin = gap.max(velocity);
                    let z = [
                        0.5,
                        0.5,
                        margin.max(0.0),
                        (-margin).max(0.0),
                        (velocity - gap).max(0.0),
                        (gap - velocity).max(0.0),
                    ];
                    let first = self.dcs.algebraic(contact, ALPHA);
                    self.local[first..first + PER_CONTACT].copy_from_slice(&z);
                }
                for (value, variable) in
                    self.local.iter().zip(&self.elements[e].blocks[b].variables)
                {
                    if let Some(variable) = variable {
                        guess[*variable] = *value;
                    }
                }
            }
        }
        for e in 0..count {
            for contact in 0..self.dcs.contacts() {
                for sum in 0..SUMS {
                    let place = self.elements[e].sums + SUMS * contact + sum;
                    guess[place] = self.sum(&guess, e, contact, sum);
                }
            }
        }
        self.guess = guess;
    }

    /// Algebraic variable that sum `sum` adds up.
    fn summed(sum: usize) -> usize {
        [ALPHA, LAMBDA_MINUS, BETA, LAMBDA_PLUS][sum]
    }

    /// Variables of a cross complementarity sum.
    fn sum_variables(&self, e: usize, contact: usize, sum: usize) -> Vec<usize> {
        let place = self.dcs.algebraic(contact, Self::summed(sum));
        let mut variables: Vec<usize> = self.elements[e]
            .blocks
            .iter()
            .filter_map(|block| block.variables[place])
            .collect();
        if sum % 2 == 1
            && e > 0
            && let Some(last) = self.elements[e - 1].blocks.last()
        {
            variables.extend(last.variables[place]);
        }
        variables
    }

    /// Value of a cross complementarity sum.
    fn sum(&self, x: &[f64], e: usize, contact: usize, sum: usize) -> f64 {
        let at_start = match (e, sum) {
            (0, 1) => self.start_multipliers[contact].1,
            (0, 3) => self.start_multipliers[contact].0,
            _ => 0.0,
        };
        let variables = self.sum_variables(e, contact, sum);
        at_start + variables.iter().map(|&variable| x[variable]).sum::<f64>()
    }

    fn set_patterns(&mut self) {
        let x = self.guess.clone();
        let multipliers = vec![1.0; self.constraints];
        let mut additions = Vec::new();
        self.add_jacobian(&x, &mut |row, column, _| additions.push((row, column)));
        self.jacobian = Pattern::new(&additions);
        additions.clear();
        self.add_hessian(&x, 1.0, &multipliers, &mut |i, j, _| {
            additions.push((i.max(j), i.min(j)));
        });
        self.hessian = Pattern::new(&additions);
    }

    fn add_jacobian(&mut self, x: &[f64], add: &mut dyn FnMut(usize, usize, f64)) {
        let states = self.dcs.states();
        let speed = x[self.speed_of_time];
        let last = self.elements.len() - 1;
        for e in 0..self.elements.len() {
            add(0, self.elements[e].length, 1.0);
            let h = x[self.elements[e].length];
            let rows = self.elements[e].collocation_rows;
            let blocks = self.elements[e].blocks.len();
            for m in 0..blocks {
                for k in 0..states {
                    let row = rows + m * states + k;
                    if let Some(variable) = self.elements[e].blocks[m].variables[k] {
                        add(row, variable, 1.0);
                    }
                    if e > 0
                        && let Some(variable) = self.end_state(e - 1)[k]
                    {
                        add(row, variable, -1.0);
                    }
                }
            }
            for j in 0..blocks {
                self.gather(x, e, j);
                let local = std::mem::take(&mut self.local);
                let mut values = std::mem::take(&mut self.rows);
                self.dcs.rows(&local, &mut values);
                if j < self.tableau.stages() {
                    for m in 0..blocks {
                        let weight = self.weight(m, j);
                        for (k, value) in values[..states].iter().enumerate() {
                            let row = rows + m * states + k;
                            add(row, self.elements[e].length, -speed * weight * value);
                            add(row, self.speed_of_time, -h * weight * value);
                        }
                    }
                }
                let mut entries = Vec::new();
                self.dcs.jacobian(&local, |row, column, value| {
                    entries.push((row, column, value))
                });
                let block = &self.elements[e].blocks[j];
                for (row, column, value) in entries {
                    let Some(variable) = block.variables[column] else {
                        continue;
                    };
                    if row >= states {
                        if let Some(row) = self.algebraic_row(block, row - states) {
                            add(row, variable, value);
                        }
                    } else if !block.boundary {
                        for m in 0..blocks {
                            let weight = self.weight(m, j);
                            add(
                                rows + m * states + row,
                                variable,
                                -h * speed * weight * value,
                            );
                        }
                    }
                }
                self.local = local;
                self.rows = values;
            }
            for contact in 0..self.dcs.contacts() {
                for sum in 0..SUMS {
                    let row = self.elements[e].sum_rows + SUMS * contact + sum;
                    add(row, self.elements[e].sums + SUMS * contact + sum, 1.0);
                    for variable in self.sum_variables(e, contact, sum) {
                        add(row, variable, -1.0);
                    }
                }
            }
        }
        if let Some(clock) = self.end_state(last)[states - 1] {
            add(1, clock, 1.0);
        }
    }

    fn add_hessian(
        &mut self,
        x: &[f64],
        weight: f64,
        multipliers: &[f64],
        add: &mut dyn FnMut(usize, usize, f64),
    ) {
        let states = self.dcs.states();
        let speed = x[self.speed_of_time];
        let nominal = self.duration / self.elements.len() as f64;
        let mut local_weights = vec![0.0; states + self.dcs.algebraic_equations()];
        for e in 0..self.elements.len() {
            let length = self.elements[e].length;
            add(
                length,
                length,
                2.0 * EQUILIBRATION * weight / (nominal * nominal),
            );
            let h = x[length];
            let rows = self.elements[e].collocation_rows;
            let blocks = self.elements[e].blocks.len();
            for j in 0..blocks {
                self.gather(x, e, j);
                let local = std::mem::take(&mut self.local);
                let mut values = std::mem::take(&mut self.rows);
                self.dcs.rows(&local, &mut values);
                // sensitivity of the Lagrangian to F_j, without the factor h s
                let mut by_field = vec![0.0; states];
                if j < self.tableau.stages() {
                    for m in 0..blocks {
                        for (k, sensitivity) in by_field.iter_mut().enumerate() {
                            *sensitivity -= self.weight(m, j) * multipliers[rows + m * states + k];
                        }
                    }
                    let product: f64 = by_field
                        .iter()
                        .zip(&values)
                        .map(|(w, value)| w * value)
                        .sum();
                    add(length, self.speed_of_time, product);
                    let mut entries = Vec::new();
                    self.dcs.jacobian(&local, |row, column, value| {
                        entries.push((row, column, value))
                    });
                    for (row, column, value) in entries {
                        if row < states
                            && let Some(variable) = self.elements[e].blocks[j].variables[column]
                        {
                            add(length, variable, speed * by_field[row] * value);
                            add(self.speed_of_time, variable, h * by_field[row] * value);
                        }
                    }
                }
                let block = &self.elements[e].blocks[j];
                for (k, value) in local_weights.iter_mut().enumerate() {
                    *value = if k < states {
                        h * speed * by_field[k]
                    } else {
                        self.algebraic_row(block, k - states)
                            .map_or(0.0, |row| multipliers[row])
                    };
                }
                let variables = &block.variables;
                self.dcs.hessian(&local, &local_weights, |i, j, value| {
                    if let (Some(i), Some(j)) = (variables[i], variables[j]) {
                        add(i, j, value);
                    }
                });
                self.local = local;
                self.rows = values;
            }
        }
    }

    /// Number of finite elements.
    pub(crate) fn elements(&self) -> usize {
        self.elements.len()
    }

    /// Length of element `e` in numerical time.
    pub(crate) fn numerical_length(&self, x: &[f64], e: usize) -> f64 {
        x[self.elements[e].length] * x[self.speed_of_time]
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

    /// Mean step function `alpha` of `contact` in element `e`: 1 free, 0 jump, between in contact.
    pub(crate) fn mean_alpha(&self, x: &[f64], e: usize, contact: usize) -> f64 {
        x[self.elements[e].sums + SUMS * contact] / self.tableau.stages() as f64
    }
}

impl NlpProblem for Transcription<'_> {
    fn variables(&self) -> usize {
        self.variables
    }

    fn constraints(&self) -> usize {
        self.constraints
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        lower.fill(f64::NEG_INFINITY);
        upper.fill(f64::INFINITY);
        lower[self.speed_of_time] = 1.0;
        upper[self.speed_of_time] = self.speed_bound;
        let nominal = self.duration / self.elements.len() as f64;
        for element in &self.elements {
            lower[element.length] = SHORTEST * nominal;
            upper[element.length] = self.duration;
            for block in &element.blocks {
                for contact in 0..self.dcs.contacts() {
                    for offset in 0..PER_CONTACT {
                        let place = self.dcs.algebraic(contact, offset);
                        if let Some(variable) = block.variables[place] {
                            lower[variable] = 0.0;
                            if matches!(offset, ALPHA | BETA) {
                                upper[variable] = 1.0;
                            }
                        }
                    }
                }
            }
            lower[element.sums..element.sums + SUMS * self.dcs.contacts()].fill(0.0);
        }
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        lower.fill(0.0);
        upper.fill(0.0);
    }

    fn initial_point(&self, x: &mut [f64]) {
        x.copy_from_slice(&self.guess);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        let nominal = self.duration / self.elements.len() as f64;
        self.elements
            .iter()
            .map(|element| (x[element.length] / nominal - 1.0).powi(2))
            .sum::<f64>()
            * EQUILIBRATION
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
        let nominal = self.duration / self.elements.len() as f64;
        for element in &self.elements {
            gradient[element.length] =
                2.0 * EQUILIBRATION * (x[element.length] / nominal - 1.0) / nominal;
        }
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        let states = self.dcs.states();
        let speed = x[self.speed_of_time];
        c[0] = -self.duration;
        for e in 0..self.elements.len() {
            let h = x[self.elements[e].length];
            c[0] += h;
            let rows = self.elements[e].collocation_rows;
            let blocks = self.elements[e].blocks.len();
            for m in 0..blocks {
                for k in 0..states {
                    let end = self.elements[e].blocks[m].variables[k];
                    c[rows + m * states + k] =
                        end.map_or(0.0, |variable| x[variable]) - self.start_value(x, e, k);
                }
            }
            for j in 0..blocks {
                self.gather(x, e, j);
                let local = std::mem::take(&mut self.local);
                let mut values = std::mem::take(&mut self.rows);
                self.dcs.rows(&local, &mut values);
                if j < self.tableau.stages() {
                    for m in 0..blocks {
                        for (k, value) in values[..states].iter().enumerate() {
                            c[rows + m * states + k] -= h * speed * self.weight(m, j) * value;
                        }
                    }
                }
                let block = &self.elements[e].blocks[j];
                for (k, value) in values[states..].iter().enumerate() {
                    if let Some(row) = self.algebraic_row(block, k) {
                        c[row] = *value;
                    }
                }
                self.local = local;
                self.rows = values;
            }
            for contact in 0..self.dcs.contacts() {
                for sum in 0..SUMS {
                    c[self.elements[e].sum_rows + SUMS * contact + sum] = x
                        [self.elements[e].sums + SUMS * contact + sum]
                        - self.sum(x, e, contact, sum);
                }
            }
        }
        let last = self.elements.len() - 1;
        c[1] = self.end_state(last)[states - 1].map_or(0.0, |clock| x[clock])
            - self.start[states - 1]
            - self.duration;
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.jacobian.entries.clone()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        let pattern = std::mem::take(&mut self.jacobian);
        values.fill(0.0);
        let mut places = pattern.places.iter();
        self.add_jacobian(x, &mut |_, _, value| {
            if let Some(&place) = places.next() {
                values[place] += value;
            }
        });
        self.jacobian = pattern;
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        self.hessian.entries.clone()
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        let pattern = std::mem::take(&mut self.hessian);
        values.fill(0.0);
        let mut places = pattern.places.iter();
        self.add_hessian(x, weight, multipliers, &mut |_, _, value| {
            if let Some(&place) = places.next() {
                values[place] += value;
            }
        });
        self.hessian = pattern;
    }
}

impl Mpcc for Transcription<'_> {
    fn complementarities(&self) -> &[(usize, usize)] {
        &self.pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;
    use crate::nlp::check_derivatives;
    use crate::rk::Scheme;
    use crate::time_freezing::TimeFreezingSystem;

    crate::model! {
        /// A bead over a wavy floor and beside a wall that leans: two curved gaps, two directions.
        Bead {
            parameters { m: kg = 2, g: m/s^2 = 9.81, k: 1/m = 1.5, c: kg/s = 0.3 }
            coordinates { y: m, z: m }
            controls { u: N }
            lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
            forces { y: u - c*dot(y) }
            surface floor: z - sin(k*y)/(4*k) >= 0
            surface wall: 1[m] - y - k*z^2/8 >= 0
            impact floor: inelastic
            impact wall: inelastic
        }
    }

    fn program(tableau: &ButcherTableau, bead: &Bead) -> f64 {
        let system = TimeFreezingSystem::new(bead, 50.0);
        let start = State {
            time: 0.3,
            q: vec![0.2, 0.4],
            v: vec![1.5, -0.7],
        };
        let mut program = Transcription::new(
            HeavisideSystem::new(system),
            tableau,
            &start,
            &[0.8],
            0.25,
            2,
        );
        // A point off every bound and symmetry.
        let mut x = vec![0.0; program.variables()];
        program.initial_point(&mut x);
        for (i, value) in x.iter_mut().enumerate() {
            *value += 0.1 + 0.05 * (i as f64).sin();
        }
        let report = check_derivatives(&mut program, Some(&x)).expect("finite at the start");
        assert!(report.compared > 1000);
        assert!(report.entries.iter().all(|entry| !entry.missing));
        report.worst()
    }

    #[test]
    fn derivatives_agree_with_differences_for_both_kinds_of_schemes() {
        let bead = Bead::default();
        assert_eq!(bead.declaration().contacts.len(), 2);
        for scheme in [Scheme::RadauIia, Scheme::GaussLegendre] {
            let tableau = ButcherTableau::new(scheme, 2).expect("two stages");
            // Central differences of functions of size 100 with steps of 6e-6.
            let worst = program(&tableau, &bead);
            assert!(worst < 1e-6, "{scheme:?}: {worst:e}");
        }
    }
}
