//! The program as the solver sees it.

use hangtime_solver::mpcc::Mpcc;
use hangtime_solver::nlp::NlpProblem;

use super::{
    Controls, EQUILIBRATION, SHORTEST, SUMS, Task, Transcription, conditions, corrections,
    derivatives, guess, joints, modes, names, neighbours, provided, ramps, start,
};
use crate::dcs::HeavisideSystem;
use crate::rk::ButcherTableau;

/// The program of `task`, which has at least one interval and element.
pub(crate) fn transcribe<'a>(
    dcs: HeavisideSystem<'a>,
    tableau: &ButcherTableau,
    task: Task,
) -> Transcription<'a> {
    let mut transcription = Transcription::new(dcs, tableau, task);
    provided::number(&mut transcription);
    transcription.sites = conditions::sites(&transcription);
    guess::set_guess(&mut transcription);
    provided::guess_forces(&mut transcription);
    let guess = transcription.guess.clone();
    let mut rows = vec![0.0; transcription.constraints];
    conditions::write_rows(&transcription, &guess, &mut rows);
    provided::guess_sums(&mut transcription, &rows);
    corrections::set_directions(&mut transcription, &guess);
    joints::choose(&mut transcription, &guess);
    derivatives::set_patterns(&mut transcription);
    transcription
}

/// Length of an element over that of its interval, if all are equal.
fn nominal(transcription: &Transcription<'_>) -> f64 {
    1.0 / transcription.task.elements as f64
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
        let count = self.intervals.len() as f64;
        let (least, most) = self
            .task
            .horizon_bounds
            .unwrap_or((self.task.horizon, self.task.horizon));
        if let Some(horizon) = self.horizon {
            (lower[horizon], upper[horizon]) = (least, most);
        }
        start::write_bounds(self, lower, upper);
        for interval in &self.intervals {
            lower[interval.length] = least / count;
            upper[interval.length] = self.speed_bound * most / count;
            if let Controls::Free {
                lower: from,
                upper: to,
                ..
            } = &self.task.controls
            {
                for controls in [&interval.controls, &interval.ends] {
                    for (k, &control) in controls.iter().enumerate() {
                        lower[control] = from[k] / self.control_units[k];
                        upper[control] = to[k] / self.control_units[k];
                    }
                }
            }
        }
        for (e, element) in self.elements.iter().enumerate() {
            lower[element.length] = SHORTEST * nominal(self).min(element.even);
            upper[element.length] = 1.0;
            for block in &element.blocks {
                for place in self.dcs.layout.first_algebraic()..self.dcs.layout.first_product() {
                    if let Some(variable) = block.variables[place] {
                        // alpha + beta = 1 bounds both from above, and with them their parts
                        lower[variable] = 0.0;
                    }
                }
            }
            lower[element.sums..element.sums + SUMS * self.groups.len()].fill(0.0);
            let (from, to) = &self.task.coordinate_bounds;
            for k in 0..from.len() {
                if let Some(variable) = self.end_state(e)[k] {
                    (lower[variable], upper[variable]) = (from[k], to[k]);
                }
            }
        }
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        lower.fill(0.0);
        upper.fill(0.0);
        conditions::write_bounds(self, upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        x.copy_from_slice(&self.guess);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        let equilibration: f64 = self
            .elements
            .iter()
            .map(|element| ((x[element.length] - element.even) / nominal(self)).powi(2))
            .sum();
        EQUILIBRATION * equilibration + conditions::objective(self, x)
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
        let nominal = nominal(self);
        for element in &self.elements {
            gradient[element.length] +=
                2.0 * EQUILIBRATION * (x[element.length] - element.even) / nominal.powi(2);
        }
        conditions::add_gradient(self, x, gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        let states = self.dcs.layout.states();
        for interval in &self.intervals {
            c[interval.rows] = -1.0;
        }
        for e in 0..self.elements.len() {
            let interval = &self.intervals[self.elements[e].interval];
            let (row, s) = (interval.rows, x[interval.length]);
            let h = x[self.elements[e].length];
            c[row] += h;
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
                            c[rows + m * states + k] -= h * s * self.weight(m, j) * value;
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
            for group in 0..self.groups.len() {
                for sum in 0..SUMS {
                    c[self.elements[e].sum_rows + SUMS * group + sum] =
                        x[self.elements[e].sums + SUMS * group + sum] - self.sum(x, e, group, sum);
                }
            }
        }
        let time = self.dcs.layout.time();
        for (k, interval) in self.intervals.iter().enumerate() {
            let end = self.end_state((k + 1) * self.task.elements - 1)[time];
            let share = (k as f64 + 1.0) / self.intervals.len() as f64;
            c[interval.rows + 1] =
                end.map_or(0.0, |clock| x[clock]) - self.start[time] - share * self.horizon(x);
        }
        start::write_rows(self, x, c);
        corrections::write_rows(self, x, c);
        joints::write_rows(self, x, c);
        ramps::write_rows(self, x, c);
        conditions::write_rows(self, x, c);
        provided::write_rows(self, x, c);
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.jacobian.entries.clone()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        let pattern = std::mem::take(&mut self.jacobian);
        values.fill(0.0);
        let mut places = pattern.places.iter();
        derivatives::add_jacobian(self, x, &mut |_, _, value| {
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
        derivatives::add_hessian(self, x, weight, multipliers, &mut |_, _, value| {
            if let Some(&place) = places.next() {
                values[place] += value;
            }
        });
        self.hessian = pattern;
    }

    fn variable_name(&self, index: usize) -> String {
        names::name_of_variable(self, index)
    }

    fn constraint_name(&self, index: usize) -> String {
        names::name_of_constraint(self, index)
    }
}

impl Mpcc for Transcription<'_> {
    fn complementarities(&self) -> &[(usize, usize)] {
        &self.pairs
    }

    fn complementarity_name(&self, index: usize) -> String {
        names::name_of_pair(self, index)
    }

    fn vanishing_sides(&self, x: &[f64], vanishes: &mut [bool]) -> bool {
        modes::mark_vanishing(self, x, vanishes);
        true
    }

    fn neighbour(&self, index: usize, x: &mut [f64], vanishes: &mut [bool]) -> bool {
        neighbours::shift_switch(self, index, x, vanishes)
    }
}
