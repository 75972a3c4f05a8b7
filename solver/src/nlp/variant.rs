//! A problem with something changed: its objective and the unit of it, variables that are fixed at zero, its start, the units of its variables.

use std::borrow::Cow;

use super::{NlpProblem, Pattern};

/// A problem with something changed; what is empty stays as it is.
pub(crate) struct Variant<'a, P: ?Sized> {
    pub(crate) problem: &'a mut P,
    pub(crate) objective: Objective,
    /// Unit in which the objective of the problem is measured.
    pub(crate) objective_unit: f64,
    /// Variables that are fixed at zero.
    pub(crate) fixed: Vec<bool>,
    /// Where it starts, in the variables of the problem.
    pub(crate) start: Vec<f64>,
    /// Units in which the variables are measured.
    pub(crate) units: Vec<f64>,
}

/// What is minimized.
pub(crate) enum Objective {
    /// The objective of the problem.
    Own,
    /// The distance to a point in place of it, `1/2 sum_i ((x_i - a_i) / max(1, |a_i|))^2`.
    Distance(Distance),
}

/// The distance to a point.
pub(crate) struct Distance {
    to: Vec<f64>,
    hessian: Pattern,
    /// Number of entries of the Hessian of the problem itself.
    own_hessian: usize,
}

impl Distance {
    fn weight(&self, i: usize) -> f64 {
        self.to[i].abs().max(1.0).powi(-2)
    }
}

impl<'a, P: NlpProblem + ?Sized> Variant<'a, P> {
    /// The problem as it is.
    pub(crate) fn of(problem: &'a mut P) -> Self {
        Self {
            problem,
            objective: Objective::Own,
            objective_unit: 1.0,
            fixed: Vec::new(),
            start: Vec::new(),
            units: Vec::new(),
        }
    }

    /// The search for the point nearest to `to`, from there: the same rows and bounds. Where an objective leads runs to where pairs cannot be
    /// met, or keeps them busy for long, this one, which is convex and flat, leaves the question of a point at all.
    pub(crate) fn nearest(problem: &'a mut P, to: &[f64]) -> Self {
        let mut hessian = problem.hessian_pattern();
        let own_hessian = hessian.len();
        hessian.extend((0..to.len()).map(|i| (i, i)));
        Self {
            objective: Objective::Distance(Distance {
                to: to.to_vec(),
                hessian: Pattern::new(&hessian),
                own_hessian,
            }),
            start: to.to_vec(),
            ..Self::of(problem)
        }
    }

    fn in_problem<'x>(&self, x: &'x [f64]) -> Cow<'x, [f64]> {
        if self.units.is_empty() {
            return x.into();
        }
        let mut x = x.to_vec();
        self.per_unit(&mut x);
        x.into()
    }

    /// Values of the variables of the problem in their units.
    pub(crate) fn to_units(&self, x: &mut [f64]) {
        x.iter_mut()
            .zip(&self.units)
            .for_each(|(x, unit)| *x /= unit);
    }

    /// Rates of change with the variables of the problem as rates with their units.
    pub(crate) fn per_unit(&self, z: &mut [f64]) {
        z.iter_mut()
            .zip(&self.units)
            .for_each(|(z, unit)| *z *= unit);
    }
}

impl<P: NlpProblem + ?Sized> NlpProblem for Variant<'_, P> {
    fn variables(&self) -> usize {
        self.problem.variables()
    }

    fn constraints(&self) -> usize {
        self.problem.constraints()
    }

    fn variable_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.problem.variable_bounds(lower, upper);
        for (k, _) in self.fixed.iter().enumerate().filter(|(_, fixed)| **fixed) {
            (lower[k], upper[k]) = (0.0, 0.0);
        }
        self.to_units(lower);
        self.to_units(upper);
    }

    fn constraint_bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.problem.constraint_bounds(lower, upper);
    }

    fn initial_point(&self, x: &mut [f64]) {
        if self.start.is_empty() {
            self.problem.initial_point(x);
        } else {
            x.copy_from_slice(&self.start);
        }
        self.to_units(x);
    }

    fn objective(&mut self, x: &[f64]) -> f64 {
        let x = self.in_problem(x);
        match &self.objective {
            Objective::Own => self.problem.objective(&x) / self.objective_unit,
            Objective::Distance(distance) => {
                let term =
                    |(i, x): (usize, &f64)| distance.weight(i) * (x - distance.to[i]).powi(2);
                0.5 * x.iter().enumerate().map(term).sum::<f64>()
            }
        }
    }

    fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        let x = self.in_problem(x);
        match &self.objective {
            Objective::Own => {
                self.problem.gradient(&x, gradient);
                gradient.iter_mut().for_each(|g| *g /= self.objective_unit);
            }
            Objective::Distance(distance) => {
                for (i, g) in gradient.iter_mut().enumerate() {
                    *g = distance.weight(i) * (x[i] - distance.to[i]);
                }
            }
        }
        self.per_unit(gradient);
    }

    fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.problem.constraint_values(&self.in_problem(x), c);
    }

    fn jacobian_pattern(&self) -> Vec<(usize, usize)> {
        self.problem.jacobian_pattern()
    }

    fn jacobian_values(&mut self, x: &[f64], values: &mut [f64]) {
        self.problem.jacobian_values(&self.in_problem(x), values);
        if !self.units.is_empty() {
            for (value, (_, i)) in values.iter_mut().zip(self.problem.jacobian_pattern()) {
                *value *= self.units[i];
            }
        }
    }

    fn hessian_pattern(&self) -> Vec<(usize, usize)> {
        match &self.objective {
            Objective::Distance(distance) => distance.hessian.entries.clone(),
            _ => self.problem.hessian_pattern(),
        }
    }

    fn hessian_values(&mut self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]) {
        let x = self.in_problem(x);
        if let Objective::Distance(distance) = &self.objective {
            // the problem's own entries come first, each position once
            let (own, added) = values.split_at_mut(distance.own_hessian);
            self.problem.hessian_values(&x, 0.0, multipliers, own);
            added.fill(0.0);
            let places = &distance.hessian.places[distance.own_hessian..];
            for (i, &place) in places.iter().enumerate() {
                values[place] += weight * distance.weight(i);
            }
        } else {
            let weight = weight / self.objective_unit;
            self.problem.hessian_values(&x, weight, multipliers, values);
        }
        if !self.units.is_empty() {
            for (value, (i, j)) in values.iter_mut().zip(self.hessian_pattern()) {
                *value *= self.units[i] * self.units[j];
            }
        }
    }

    fn variable_name(&self, index: usize) -> String {
        self.problem.variable_name(index)
    }

    fn constraint_name(&self, index: usize) -> String {
        self.problem.constraint_name(index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nlp::{self, Settings};
    use crate::polynomials::Polynomials;

    /// `min x_1^3 x_0` where `x_0 + x_1 x_0 = 2`, from (0.5, 1).
    fn product() -> Polynomials {
        Polynomials {
            bounds: vec![(0.0, f64::INFINITY); 2],
            start: vec![0.5, 1.0],
            objective: vec![(1.0, &[1, 1, 1, 0])],
            rows: vec![(2.0, 2.0, vec![(1.0, &[0]), (1.0, &[1, 0])])],
            ..Polynomials::default()
        }
    }

    #[test]
    fn derivatives_of_every_change_are_those_of_its_functions() {
        for (units, nearest) in [
            (vec![], true),
            (vec![40.0, 0.02], false),
            (vec![0.3, 7.0], true),
        ] {
            let mut product = product();
            let mut variant = if nearest {
                Variant::nearest(&mut product, &[0.7, -3.0])
            } else {
                Variant::of(&mut product)
            };
            variant.units = units;
            let entries = nlp::check_derivatives(&mut variant, Some(&[1.5, 0.5])).unwrap();
            // differences are right to the root of the rounding unit
            assert!(
                entries.iter().all(|entry| entry.error < 1e-5),
                "{entries:?}"
            );
        }
    }

    #[test]
    fn nearest_point_and_fixed_variables_forget_the_objective() {
        // on x_0 + x_1 x_0 = 2 with x_1 = 0, that nearest to (0.5, 4) and in units of 0.1
        let mut product = product();
        let mut variant = Variant {
            fixed: vec![false, true],
            units: vec![0.1, 5.0],
            ..Variant::nearest(&mut product, &[0.5, 4.0])
        };
        let solution = nlp::solve(&mut variant, &Settings::default()).unwrap();
        assert!((solution.x[0] - 20.0).abs() < 1e-6 && solution.x[1] == 0.0);
        // 1/2 (1.5^2 + (4/4)^2)
        assert!((solution.objective - 1.625).abs() < 1e-6);
    }
}
