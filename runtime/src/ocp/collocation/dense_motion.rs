//! The continuous motion of a solved program, and the lows of functions along it.

use super::bounds::Bounds;
use super::layout::SolvedPhase;
use super::program::Collocation;
use super::provided;

/// Points of a phase that are looked at.
pub(in crate::ocp) const POINTS: usize = 64;

/// The continuous motion of a solved program.
pub(in crate::ocp) struct DenseMotion<'p, 'm> {
    pub(in crate::ocp) program: &'p Collocation<'m>,
    pub(in crate::ocp) solved: Vec<SolvedPhase>,
    /// Weights of the states of a phase at its points `i / POINTS`.
    weights: Vec<Vec<f64>>,
    /// Physical values of the unknowns.
    pub(in crate::ocp) x: Vec<f64>,
}

impl<'p, 'm> DenseMotion<'p, 'm> {
    pub(in crate::ocp) fn new(program: &'p Collocation<'m>, x: &[f64]) -> Self {
        let thetas = (0..=POINTS).map(|i| i as f64 / POINTS as f64);
        Self {
            program,
            solved: program.solved(x),
            weights: thetas
                .map(|theta| program.tableau.values_with_start(theta))
                .collect(),
            x: program.program.physical(x),
        }
    }

    /// Writes the first components of the model's input vector at the share `theta` of a phase.
    pub(in crate::ocp) fn write(&self, phase: usize, theta: f64, input: &mut [f64]) {
        let place = theta * POINTS as f64;
        let between;
        let weights = if place.fract() == 0.0 {
            &self.weights[place as usize]
        } else {
            between = self.program.tableau.values_with_start(theta);
            &between
        };
        input.fill(0.0);
        for (values, weight) in self.solved[phase].inputs.iter().zip(weights) {
            for (slot, value) in input.iter_mut().zip(values) {
                *slot += weight * value;
            }
        }
    }

    /// Writes the input there with positions that have the velocities as their slopes. Right after a start, where gaps grow with a high power of the
    /// time, those of [`Self::write`] are less accurate than what they grow to.
    pub(super) fn write_smooth(&self, phase: usize, theta: f64, input: &mut [f64]) {
        self.write(phase, theta, input);
        let n = self.program.model.declaration().coordinates.len();
        let solved = &self.solved[phase];
        input[..n].fill(0.0);
        let weights = self.program.tableau.hermite_with_start(theta);
        for (values, (value, slope)) in solved.inputs.iter().zip(weights) {
            for (k, slot) in input[..n].iter_mut().enumerate() {
                *slot += value * values[k] + slope * solved.length * values[n + k];
            }
        }
    }

    /// Values of bounds at the share `theta` of a phase.
    pub(in crate::ocp) fn bounds(&self, bounds: &Bounds, phase: usize, theta: f64) -> Vec<f64> {
        let declaration = self.program.model.declaration();
        let mut input = vec![0.0; declaration.path_inputs()];
        self.write(phase, theta, &mut input);
        let plain = declaration.inputs();
        if input.len() > plain {
            let mut weights = vec![0.0; self.program.tableau.stages()];
            self.program.tableau.lagrange_values(theta, &mut weights);
            let provided = provided::values(&self.program.phases[phase], &weights, &self.x);
            let slots = input[plain..].iter_mut();
            slots.zip(provided).for_each(|(slot, value)| *slot = value);
        }
        bounds.values(input)
    }

    /// These at all points of each phase.
    pub(in crate::ocp) fn table(&self, bounds: &Bounds) -> Vec<Vec<Vec<f64>>> {
        let points = |phase| {
            let points = (0..=POINTS).map(|i| i as f64 / POINTS as f64);
            points
                .map(|theta| self.bounds(bounds, phase, theta))
                .collect()
        };
        (0..self.solved.len()).map(points).collect()
    }
}

/// Local minima below the limit of a function over consecutive phases, as (phase, theta, whether the function
/// exceeds the limit before and after): those of which that is true, and those deeper than the depth.
pub(in crate::ocp) fn lows(
    phases: &[usize],
    value: &mut dyn FnMut(usize, f64) -> f64,
    limit: f64,
    depth: f64,
) -> Vec<(usize, f64, bool)> {
    let mut samples = Vec::with_capacity(phases.len() * POINTS + 1);
    for (position, &phase) in phases.iter().enumerate() {
        for i in usize::from(position > 0)..=POINTS {
            let theta = i as f64 / POINTS as f64;
            samples.push((phase, theta, value(phase, theta)));
        }
    }
    let above = |sample: &(usize, f64, f64)| sample.2 > limit;
    let first = samples.iter().position(above).unwrap_or(samples.len());
    let last = samples.iter().rposition(above).unwrap_or(0);
    let mut found = Vec::new();
    for i in 1..samples.len().saturating_sub(1) {
        let (phase, theta, here) = samples[i];
        let between = first < i && i < last;
        if !between && here > -depth {
            continue;
        }
        if here > samples[i - 1].2 || here >= samples[i + 1].2 {
            continue;
        }
        let step = 1.0 / POINTS as f64;
        let theta = if theta < 1.0 {
            minimum(&mut |theta| value(phase, theta), theta - step, theta + step)
        } else {
            theta
        };
        if value(phase, theta) < limit {
            found.push((phase, theta, between));
        }
    }
    found
}

/// Minimum of a function between two points, by golden section to the square root of the precision.
fn minimum(value: &mut dyn FnMut(f64) -> f64, mut from: f64, mut to: f64) -> f64 {
    const SHARE: f64 = 0.381_966_011_250_105;
    const STEPS: usize = 40;
    for _ in 0..STEPS {
        let (a, b) = (from + SHARE * (to - from), to - SHARE * (to - from));
        if value(a) < value(b) {
            to = b;
        } else {
            from = a;
        }
    }
    0.5 * (from + to)
}
