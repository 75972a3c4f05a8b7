//! One step of DOP853, its error estimate and its continuous extension, on buffers that are allocated
//! once.

use crate::enclosure::Range;

use super::tableau::{
    DEGREE, DERIVATIVES, ERROR_3, ERROR_5, EXTENSION_ROWS, EXTENSION_WEIGHTS, NODES, Row,
    STAGE_ROWS, STAGES, WEIGHTS,
};

/// Exponent of the error in the step size control, `1/8`, reduced by the share of the PI term.
const PROPORTIONAL: f64 = 1.0 / 8.0 - 0.2 * INTEGRAL;
/// Weight of the previous error in the step size control (Hairer, Norsett, Wanner, II.4).
const INTEGRAL: f64 = 0.04;
/// Safety factor of the step size control.
const SAFETY: f64 = 0.9;
/// Bounds of the factor between two consecutive step sizes.
const FACTORS: (f64, f64) = (0.2, 8.0);

/// A system of ordinary differential equations `y' = f(t, y)`.
pub(in crate::simulation) trait System {
    /// Writes `f(t, y)` into `dy`; what cannot be evaluated is written as NaN.
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]);
}

/// Buffers of the method: derivatives, the state at the end of the step, the continuous extension.
#[derive(Debug, Clone)]
pub(in crate::simulation) struct Dop853 {
    dimension: usize,
    measured: usize,
    derivatives: Vec<f64>,
    stage: Vec<f64>,
    end: Vec<f64>,
    start: Vec<f64>,
    extension: Vec<f64>,
    previous_error: f64,
}

impl Dop853 {
    /// Buffers for `dimension` components, of which the first `measured` enter the error estimate.
    pub(in crate::simulation) fn new(dimension: usize, measured: usize) -> Self {
        Self {
            dimension,
            measured,
            derivatives: vec![0.0; DERIVATIVES * dimension],
            stage: vec![0.0; dimension],
            end: vec![0.0; dimension],
            start: vec![0.0; dimension],
            extension: vec![0.0; DEGREE * dimension],
            previous_error: 1e-4,
        }
    }

    /// Evaluates the derivative at the start of a step.
    pub(in crate::simulation) fn begin(&mut self, system: &mut impl System, t: f64, y: &[f64]) {
        system.derivative(t, y, &mut self.derivatives[..self.dimension]);
    }

    /// The derivative at the start of the step.
    pub(in crate::simulation) fn slope(&self) -> &[f64] {
        &self.derivatives[..self.dimension]
    }

    /// The derivative at the end of the step; [`finish`](Self::finish) comes before.
    pub(in crate::simulation) fn end_slope(&self) -> &[f64] {
        &self.derivatives[STAGES * self.dimension..(STAGES + 1) * self.dimension]
    }

    /// The state at the end of the step.
    pub(in crate::simulation) fn end(&self) -> &[f64] {
        &self.end
    }

    /// The state at the end of the step, to be projected onto constraints.
    pub(in crate::simulation) fn end_mut(&mut self) -> &mut [f64] {
        &mut self.end
    }

    /// The stages of a step of length `h` from `(t, y)`, and the state at its end.
    /// [`begin`](Self::begin) or [`advance`](Self::advance) comes before.
    pub(in crate::simulation) fn step(
        &mut self,
        system: &mut impl System,
        t: f64,
        y: &[f64],
        h: f64,
    ) {
        for (i, row) in STAGE_ROWS.iter().enumerate() {
            self.stage(system, t, y, h, i + 1, row);
        }
        combine(
            &self.derivatives,
            self.dimension,
            WEIGHTS,
            y,
            h,
            &mut self.end,
        );
    }

    fn stage(
        &mut self,
        system: &mut impl System,
        t: f64,
        y: &[f64],
        h: f64,
        index: usize,
        row: Row,
    ) {
        let n = self.dimension;
        let (known, new) = self.derivatives.split_at_mut(index * n);
        combine(known, n, row, y, h, &mut self.stage);
        system.derivative(t + NODES[index] * h, &self.stage, &mut new[..n]);
    }

    /// Error estimate of the step just made, each component relative to `scale(component, its value at the end)`; at
    /// most 1 is good enough. NaN if a stage could not be evaluated.
    pub(in crate::simulation) fn error(&self, h: f64, scale: impl Fn(usize, f64) -> f64) -> f64 {
        let n = self.dimension;
        let (mut fifth, mut third) = (0.0, 0.0);
        for component in 0..self.measured {
            let share = |row| {
                let error = weighted(&self.derivatives, n, row, component);
                // What does not move has neither an error nor a size.
                if error == 0.0 {
                    return 0.0;
                }
                error / scale(component, self.end[component])
            };
            fifth += f64::powi(share(ERROR_5), 2);
            third += f64::powi(share(ERROR_3), 2);
        }
        let both: f64 = (fifth + 0.01 * third) * self.measured as f64;
        // Squares of the smallest numbers vanish.
        if both == 0.0 {
            return 0.0;
        }
        h.abs() * fifth / both.sqrt()
    }

    /// Step size after an accepted step of size `h` with error `error` (PI control).
    pub(in crate::simulation) fn next_size(&mut self, h: f64, error: f64) -> f64 {
        let factor = SAFETY * self.previous_error.powf(INTEGRAL)
            / error.max(f64::MIN_POSITIVE).powf(PROPORTIONAL);
        self.previous_error = error.max(1e-4);
        h * factor.clamp(FACTORS.0, FACTORS.1)
    }

    /// Step size after a rejected step of size `h` with error `error > 1` or NaN.
    pub(in crate::simulation) fn smaller_size(h: f64, error: f64) -> f64 {
        if error.is_finite() {
            h * (SAFETY / error.powf(PROPORTIONAL)).clamp(FACTORS.0, SAFETY)
        } else {
            h * FACTORS.0
        }
    }

    /// A first step size for the error per step `tolerance` (Hairer, Norsett, Wanner, II.4), from the
    /// sizes of state, derivative and second derivative. [`begin`](Self::begin) comes before.
    pub(in crate::simulation) fn initial_size(
        &mut self,
        system: &mut impl System,
        t: f64,
        y: &[f64],
        limit: f64,
        tolerance: f64,
    ) -> f64 {
        let n = self.dimension;
        let (mut value, mut slope) = (0.0_f64, 0.0_f64);
        for (component, y) in y.iter().enumerate().take(self.measured) {
            let scale = tolerance * (1.0 + y.abs());
            value += (y / scale).powi(2);
            slope += (self.derivatives[component] / scale).powi(2);
        }
        let guess = if value <= 1e-10 || slope <= 1e-10 {
            1e-6
        } else {
            0.01 * (value / slope).sqrt()
        }
        .min(limit);
        let (known, new) = self.derivatives.split_at_mut(n);
        combine(known, n, &[(0, 1.0)], y, guess, &mut self.stage);
        system.derivative(t + guess, &self.stage, &mut new[..n]);
        let mut change = 0.0_f64;
        for (component, y) in y.iter().enumerate().take(self.measured) {
            let scale = tolerance * (1.0 + y.abs());
            change += ((new[component] - known[component]) / scale).powi(2);
        }
        let largest = slope.sqrt().max(change.sqrt() / guess);
        let size = if largest <= 1e-15 {
            (guess * 1e-3).max(1e-6)
        } else {
            (0.01 / largest).powf(1.0 / 8.0)
        };
        let size = size.min(100.0 * guess).min(limit);
        if size.is_finite() { size } else { guess }
    }

    /// Evaluates the derivative at the end of the step (possibly projected), which the continuous
    /// extension and the next step need.
    pub(in crate::simulation) fn finish(&mut self, system: &mut impl System, t: f64, h: f64) {
        let n = self.dimension;
        system.derivative(
            t + h,
            &self.end,
            &mut self.derivatives[STAGES * n..(STAGES + 1) * n],
        );
    }

    /// Makes the derivative at the end of the step the one at the start of the next.
    pub(in crate::simulation) fn advance(&mut self) {
        let n = self.dimension;
        self.derivatives
            .copy_within(STAGES * n..(STAGES + 1) * n, 0);
    }

    /// Prepares the continuous extension of the step just finished: three more evaluations. It stays
    /// valid while other steps are tried from the same start.
    pub(in crate::simulation) fn extend(
        &mut self,
        system: &mut impl System,
        t: f64,
        y: &[f64],
        h: f64,
    ) {
        let n = self.dimension;
        for (i, row) in EXTENSION_ROWS.iter().enumerate() {
            self.stage(system, t, y, h, STAGES + 1 + i, row);
        }
        self.start.copy_from_slice(y);
        for (component, y) in y.iter().enumerate() {
            let difference = self.end[component] - y;
            let first = h * self.derivatives[component];
            let last = h * self.derivatives[STAGES * n + component];
            self.extension[component] = difference;
            self.extension[n + component] = first - difference;
            self.extension[2 * n + component] = 2.0 * difference - first - last;
            for (i, row) in EXTENSION_WEIGHTS.iter().enumerate() {
                self.extension[(3 + i) * n + component] =
                    h * weighted(&self.derivatives, n, row, component);
            }
        }
    }

    /// In what coordinates and velocities are over the step of length `h` from `y` that was just finished, by the slopes of its stages,
    /// which say what velocities and accelerations are: as far beyond them again as they are apart.
    pub(in crate::simulation) fn enclose(&self, y: &[f64], h: f64, out: &mut Vec<Range>) {
        let n = self.measured / 2;
        out.resize(2 * n, Range::ALL);
        for k in (0..2 * n).rev() {
            let slopes = if k < n {
                out[n + k]
            } else {
                let stages = self.derivatives[k..].iter().step_by(self.dimension);
                let seen = Range::hull(stages.take(STAGES + 1).copied());
                let beyond = seen.width();
                seen + Range::between(-beyond, beyond)
            };
            let way = (slopes.with(Range::of(0.0))).scaled(h);
            let forth = Range::of(y[k]) + way;
            out[k] = forth.within(Range::of(self.end[k]) - way);
        }
    }

    /// The first components of the continuous extension at the local time `theta` in `0..=1`, as many
    /// as `out` holds.
    pub(in crate::simulation) fn interpolate(&self, theta: f64, out: &mut [f64]) {
        let n = self.dimension;
        let complement = 1.0 - theta;
        for (component, out) in out.iter_mut().enumerate() {
            let mut sum = 0.0;
            for i in (0..DEGREE).rev() {
                let factor = if i % 2 == 0 { theta } else { complement };
                sum = (sum + self.extension[i * n + component]) * factor;
            }
            *out = self.start[component] + sum;
        }
    }
}

/// `out = y + h sum_j c_j k_j` over a sparse row of coefficients.
fn combine(derivatives: &[f64], n: usize, row: Row, y: &[f64], h: f64, out: &mut [f64]) {
    for (component, out) in out.iter_mut().enumerate() {
        *out = y[component] + h * weighted(derivatives, n, row, component);
    }
}

/// `sum_j c_j k_j` of one component.
fn weighted(derivatives: &[f64], n: usize, row: Row, component: usize) -> f64 {
    row.iter()
        .map(|&(stage, coefficient)| coefficient * derivatives[stage * n + component])
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `y'' = -y` with a counter of evaluations.
    struct Oscillator {
        evaluations: usize,
    }

    impl System for Oscillator {
        fn derivative(&mut self, _t: f64, y: &[f64], dy: &mut [f64]) {
            self.evaluations += 1;
            dy[0] = y[1];
            dy[1] = -y[0];
        }
    }

    #[test]
    fn tableau_any_row_sums_to_its_node() {
        // Published coefficients carry 30 digits; sums of 12 numbers of size up to 20 round to 1e-14.
        for (i, row) in STAGE_ROWS.iter().enumerate() {
            let sum: f64 = row.iter().map(|&(_, c)| c).sum();
            assert!((sum - NODES[i + 1]).abs() < 2e-14, "stage {}", i + 1);
        }
        for (i, row) in EXTENSION_ROWS.iter().enumerate() {
            let sum: f64 = row.iter().map(|&(_, c)| c).sum();
            assert!((sum - NODES[13 + i]).abs() < 2e-14, "stage {}", 13 + i);
        }
    }

    #[test]
    fn weights_of_any_power_integrate_it_exactly_to_degree_seven() {
        for power in 0..8 {
            let sum: f64 = WEIGHTS.iter().map(|&(j, b)| b * NODES[j].powi(power)).sum();
            assert!(
                (sum - 1.0 / f64::from(power + 1)).abs() < 2e-14,
                "degree {power}"
            );
        }
        for row in [ERROR_3, ERROR_5] {
            let sum: f64 = row.iter().map(|&(_, e)| e).sum();
            assert!(sum.abs() < 2e-14);
        }
    }

    /// Error of the state after one period in `steps` steps, and of the extension within them.
    fn errors(steps: usize) -> (f64, f64) {
        let mut system = Oscillator { evaluations: 0 };
        let mut method = Dop853::new(2, 2);
        let mut y = vec![1.0, 0.0];
        let h = 2.0 / steps as f64;
        let mut inside = 0.0_f64;
        method.begin(&mut system, 0.0, &y);
        for step in 0..steps {
            let t = step as f64 * h;
            method.step(&mut system, t, &y, h);
            method.finish(&mut system, t, h);
            method.extend(&mut system, t, &y, h);
            for k in 1..10 {
                let theta = f64::from(k) / 10.0;
                let mut value = [0.0; 2];
                method.interpolate(theta, &mut value);
                inside = inside.max((value[0] - (t + theta * h).cos()).abs());
            }
            y.copy_from_slice(method.end());
            method.advance();
        }
        assert_eq!(system.evaluations, 1 + steps * 15);
        ((y[0] - 2.0_f64.cos()).hypot(y[1] + 2.0_f64.sin()), inside)
    }

    #[test]
    fn oscillator_halved_step_shows_order_eight_and_extension_order_seven() {
        let (coarse, coarse_inside) = errors(2);
        let (fine, fine_inside) = errors(4);
        // Slopes between two step sizes lie within 0.5 of the asymptotic order; the extension of
        // local order 8 has global error of order at least 7.
        let order = (coarse / fine).log2();
        assert!((7.5..9.5).contains(&order), "order {order}");
        let order = (coarse_inside / fine_inside).log2();
        assert!(
            (6.5..9.5).contains(&order),
            "order of the extension {order}"
        );
    }

    #[test]
    fn error_not_a_number_shrinks_the_step() {
        assert!(Dop853::smaller_size(1.0, f64::NAN) < 0.5);
        assert!(Dop853::smaller_size(1.0, 2.0) < 1.0);
        let mut method = Dop853::new(1, 1);
        assert!(method.next_size(1.0, 0.0) > 1.0);
        assert!(method.next_size(1.0, f64::INFINITY) < 1.0);
    }
}
