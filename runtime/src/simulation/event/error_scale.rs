//! What errors of a step are compared with: the fastest motion so far, so that a tolerance means the same wherever a
//! scene is and whatever units it is written in.

use crate::linalg::products::{dot, largest};
use crate::model::Declaration;
use crate::yardstick;

/// Share of the acceleration without contact forces that rounding leaves of it where these balance it. A body that
/// rests while its forces change moves by no more than that, and no step makes it smooth.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// How many roundings of positions and velocities leave their accelerations undecided: those of the stages of a step and of the sums between.
const STATE_ROUNDINGS: f64 = 16.0;

/// Share of the largest accelerations so far above which what the last digits of positions change is that of a pole, where every step errs.
const POLE: f64 = 1e-10;

/// Numbers below have squares without all digits.
const TINY: f64 = 1e-140;

/// Sizes of velocities, one for all coordinates of the same unit.
#[derive(Debug, Clone)]
pub(super) struct ErrorScale {
    /// Group of each coordinate.
    group: Vec<usize>,
    /// Number of coordinates of the mechanism; those behind them are of states.
    mechanical: usize,
    /// Largest size of the velocities of each group so far.
    fastest: Vec<f64>,
    /// Size of the present accelerations of each group.
    acceleration: Vec<f64>,
    /// Largest size of the accelerations of each group so far.
    largest: Vec<f64>,
    /// Size of the velocities of each group at the end of the step tried.
    end: Vec<f64>,
    /// Size of the accelerations of each group without contact forces in the step tried.
    free: Vec<f64>,
    /// By how much the last digit of positions and velocities changes the accelerations of each group, where it has been asked for.
    undecided: Vec<f64>,
    /// Size of the accelerations of each group that joints take away, where it has been asked for.
    held: Vec<f64>,
}

impl ErrorScale {
    pub(super) fn new(declaration: &Declaration) -> Self {
        let mechanical = declaration.mechanical();
        let coordinates = declaration.coordinates;
        let mut units: Vec<&str> = Vec::new();
        let group = coordinates
            .iter()
            .enumerate()
            .map(|(k, coordinate)| {
                if k >= mechanical {
                    // A state is measured by itself.
                    units.push("");
                    return units.len() - 1;
                }
                let known = units.iter().position(|&unit| unit == coordinate.unit);
                known.unwrap_or_else(|| {
                    units.push(coordinate.unit);
                    units.len() - 1
                })
            })
            .collect();
        Self {
            group,
            mechanical,
            fastest: vec![0.0; units.len()],
            acceleration: vec![0.0; units.len()],
            largest: vec![0.0; units.len()],
            end: vec![0.0; units.len()],
            free: vec![0.0; units.len()],
            undecided: vec![0.0; units.len()],
            held: vec![0.0; units.len()],
        }
    }

    /// Takes note of velocities and accelerations where the mass matrix is `mass`.
    pub(super) fn observe(&mut self, mass: &[f64], v: &[f64], a: &[f64]) {
        for group in 0..self.fastest.len() {
            let speed = self.size(group, mass, v);
            self.fastest[group] = self.fastest[group].max(speed);
            self.acceleration[group] = self.size(group, mass, a);
            self.largest[group] = self.largest[group].max(self.acceleration[group]);
        }
    }

    /// Takes note of the velocities at the end of a step that is only tried, and of the accelerations `free` that there
    /// would be without contact forces.
    pub(super) fn try_end(&mut self, mass: &[f64], v: &[f64], free: &[f64]) {
        for group in 0..self.end.len() {
            self.end[group] = self.size(group, mass, v);
            self.free[group] = self.size(group, mass, free);
        }
    }

    /// Takes note of the `change` of accelerations with the last digits of positions and velocities: errors of steps that are less than what it
    /// makes of them are no errors of steps, and no shorter step is without them. Strong springs about their rest positions have the largest.
    pub(super) fn observe_rounding(&mut self, mass: &[f64], change: &[f64]) {
        for group in 0..self.undecided.len() {
            let size = STATE_ROUNDINGS * self.size(group, mass, change);
            if size <= POLE * self.largest[group] {
                self.undecided[group] = size;
            }
        }
    }

    /// Takes note of the accelerations that joints take away: rounding leaves as much of them as of those that contacts balance.
    pub(super) fn observe_held(&mut self, mass: &[f64], held: &[f64]) {
        for group in 0..self.held.len() {
            self.held[group] = self.size(group, mass, held);
        }
    }

    /// Euclidean norm of the components of a group, at least [`yardstick::VISIBLE`] of what the energy norm of all of them would be
    /// in the heaviest of the group.
    fn size(&self, group: usize, mass: &[f64], vector: &[f64]) -> f64 {
        let n = vector.len();
        let largest = largest(vector);
        if largest > 0.0 && largest < TINY {
            let scaled: Vec<f64> = vector.iter().map(|x| x / largest).collect();
            return largest * self.size(group, mass, &scaled);
        }
        let (mut square, mut heaviest) = (0.0, 0.0_f64);
        for (k, component) in vector.iter().enumerate() {
            if self.group[k] == group {
                square += component * component;
                heaviest = heaviest.max(mass[k * n + k]);
            }
        }
        let is_state = self
            .group
            .iter()
            .skip(self.mechanical)
            .any(|own| *own == group);
        if is_state {
            return square.sqrt();
        }
        let rows = mass.chunks_exact(n.max(1)).zip(vector);
        let rows = rows.take(self.mechanical);
        let energy: f64 = rows.map(|(row, x)| x * dot(row, vector)).sum();
        let others = yardstick::VISIBLE * (energy / heaviest).max(0.0).sqrt();
        f64::max(square.sqrt(), others)
    }

    /// The error of a component of the state `(q, v)` that a step of length `h` may have: the `tolerance` times the
    /// fastest velocity, or what rounding makes of accelerations, and the way covered with that in the step.
    pub(super) fn allowed(&self, component: usize, h: f64, tolerance: f64) -> f64 {
        let n = self.group.len();
        if (self.mechanical..n).contains(&component) {
            // Nothing reads the integral of a state.
            return f64::INFINITY;
        }
        let group = self.group[component % n];
        let speed = self.fastest[group].max(self.end[group]);
        let balanced = self.free[group].max(self.held[group]);
        let rounding = h * f64::max(ROUNDING * balanced, self.undecided[group]);
        // Numbers below have no digits: those of a pulse that has hardly begun are an error of their own size.
        if component < n {
            f64::max(tolerance * (h * speed), h * rounding).max(f64::MIN_POSITIVE)
        } else {
            f64::max(tolerance * speed, rounding).max(f64::MIN_POSITIVE)
        }
    }

    /// The shortest time in which the velocities `v` of a group change by as much as they are, with accelerations `a`,
    /// before any have been observed; infinite if nothing changes.
    pub(super) fn time_at_start(&self, mass: &[f64], v: &[f64], a: &[f64]) -> f64 {
        let mut scale = self.clone();
        scale.observe(mass, v, a);
        scale.shortest_time(mass, &vec![0.0; a.len()], 1.0)
    }

    /// The shortest time in which the velocities of a group change by as much as they are, or their accelerations
    /// given their `change` over the time `moment`; infinite if nothing changes.
    pub(super) fn shortest_time(&self, mass: &[f64], change: &[f64], moment: f64) -> f64 {
        let ratio = |size: f64, rate: f64| {
            if size > 0.0 && rate > 0.0 {
                size / rate
            } else {
                f64::INFINITY
            }
        };
        (0..self.fastest.len())
            .map(|group| {
                let (speed, acceleration) = (self.fastest[group], self.acceleration[group]);
                let jerk = self.size(group, mass, change) / moment;
                ratio(speed, acceleration)
                    .min(ratio(acceleration, jerk))
                    .min(ratio(speed, jerk).sqrt())
            })
            .fold(f64::INFINITY, f64::min)
    }
}
