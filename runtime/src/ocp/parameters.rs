//! Parameters of a solution: the free ones that were found, and how the optimum moves with given ones.

use crate::derivative::SequenceRange;
use crate::simulation::number;
use crate::yardstick;

/// A free parameter that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FoundParameter {
    /// Its index among the parameters of the scene.
    pub index: usize,
    /// Its name.
    pub name: &'static str,
    /// Its value, in its unit.
    pub value: f64,
    /// That unit.
    pub unit: &'static str,
    /// The range that it was looked for in.
    pub range: (f64, f64),
}

impl FoundParameter {
    /// The end of its range that it lies at, `"lower"` or `"upper"`, if it does: the objective improves beyond it.
    #[must_use]
    pub fn at_bound(&self) -> Option<&'static str> {
        let (lower, upper) = self.range;
        let near = yardstick::PROMISE * (upper - lower);
        if self.value - lower <= near {
            Some("lower")
        } else if upper - self.value <= near {
            Some("upper")
        } else {
            None
        }
    }
}

impl std::fmt::Display for FoundParameter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let value = format!("{} {}", number(self.value), self.unit);
        write!(f, "{} = {}", self.name, value.trim_end())?;
        match self.at_bound() {
            Some(end) => write!(f, ", at the {end} end of its range"),
            None => Ok(()),
        }
    }
}

/// Derivatives of an optimum by given parameters, in their units, on its control grid and as long as its contact sequence stays.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct OptimumGradient {
    /// Indices of the parameters.
    pub parameters: Vec<usize>,
    /// Their names.
    pub names: Vec<&'static str>,
    /// Derivatives of the objective, by the multipliers; not a number where there is none.
    pub objective: Vec<f64>,
    /// For each parameter why there is no derivative by it: multipliers are not unique, or something holds without one.
    pub obstacles: Vec<Option<String>>,
    /// Derivatives to both sides where there is no other one.
    pub sides: Vec<Option<OptimumSides>>,
    /// Derivatives of the final time \[s\]; `None` where the optimum leaves it open to first order.
    pub final_time: Vec<Option<f64>>,
    /// How far each may go, to first order, until other bounds and conditions of the plan hold, among them gaps, forces and lengths of
    /// phases: until the contact sequence is another one, or the optimum has a kink.
    pub ranges: Vec<SequenceRange>,
}

/// Derivatives of an optimum by a parameter towards smaller values, and towards larger ones; not a number to a side on which there is no
/// plan with the same contact sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct OptimumSides {
    /// Of the objective.
    pub objective: [f64; 2],
    /// Of the final time \[s\], where the objective is a function of that alone.
    pub final_time: Option<[f64; 2]>,
}

impl OptimumGradient {
    /// Keeps the derivatives by these parameters (indices), in their order.
    pub(in crate::ocp) fn reorder(&mut self, order: &[usize]) {
        let place = |index: &usize| self.parameters.iter().position(|known| known == index);
        let places: Vec<usize> = order.iter().filter_map(place).collect();
        *self = Self {
            parameters: places.iter().map(|&k| self.parameters[k]).collect(),
            names: places.iter().map(|&k| self.names[k]).collect(),
            objective: places.iter().map(|&k| self.objective[k]).collect(),
            obstacles: places.iter().map(|&k| self.obstacles[k].clone()).collect(),
            sides: places.iter().map(|&k| self.sides[k]).collect(),
            final_time: places.iter().map(|&k| self.final_time[k]).collect(),
            ranges: places.iter().map(|&k| self.ranges[k].clone()).collect(),
        };
    }
}
