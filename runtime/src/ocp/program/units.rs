//! Units of the unknowns and rows of a program: what the solver divides them by, so that all are of the order of one
//! whatever units the scene is written in.
//!
//! Controls, times, forces and gap variables are measured by their own size: the range of a control, the guess of the
//! horizon, the acceleration of a contact at the start. Coordinates, velocities and gaps in rows are measured in the
//! *power of a thousand* nearest to their size, as a person would choose between millimetres, metres and kilometres:
//! numbers between 0.03 and 30 stay as they are. The objective is measured in a power of a million while motions are looked
//! for; where one is known and has to be exact, in one of ten if that is smaller: a large unit weighs feasibility more. So a scene in
//! millimetres and kilonewtons gives the solver the same numbers as one in metres and newtons. Goals keep the numbers that they are
//! stated in, but for those of motions that are far smaller.

use crate::model::{Model, Switching, contact_point, tangent_point};
use crate::ocp::motion::mode::is_frictional;
use crate::ocp::motion::model_input::{drive, free_normal_acceleration};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::scale::Scale;
use crate::program::powers::{MILLION, THOUSAND, nearest_power, objective_size};
use crate::yardstick;

/// One to the unit of a coordinate below which distances between motions are measured by it, and that unit to one above which they are.
const FINE: f64 = 1e3;
/// A control without bounds that is so many times its unit is measured anew: in the unit of the program its stationarity
/// may be no more than a small number.
const FAR: f64 = 1e3;

/// Units of the unknowns, from the start of the motion and the bounds.
#[derive(Debug, Clone)]
pub(in crate::ocp) struct Units {
    /// Time \[s\]: the guess of the horizon.
    pub(in crate::ocp) time: f64,
    /// Each control: half of its range, or 1 where that is infinite.
    pub(in crate::ocp) controls: Vec<f64>,
    /// Normal acceleration of each contact at the start under no force, at least a tenth of the
    /// largest; without any a power of a thousand near to what forces at hand can give.
    pub(in crate::ocp) force: Vec<f64>,
    /// Gap of each contact: how far that acceleration carries in a tenth of the time, times 10.
    pub(in crate::ocp) gap: Vec<f64>,
    /// Components of `(q, v)`, powers of a thousand; velocities in those of their coordinates, by one near the time.
    pub(in crate::ocp) states: Vec<f64>,
    /// Rows of gaps and, per second, of normal velocities, powers of a thousand.
    pub(in crate::ocp) gap_rows: Vec<f64>,
    /// How far goals ask each coordinate to go; 0 where they do not.
    ways: Vec<f64>,
    /// Whether the objective is measured as exactly as it can be.
    pub(in crate::ocp) is_exact: bool,
}

impl Units {
    /// Sliding velocity of a contact: what its normal acceleration gives in a tenth of the time.
    pub(in crate::ocp) fn velocity(&self, contact: usize) -> f64 {
        0.1 * self.force[contact] * self.time
    }

    /// Units of the scene itself, but for controls, which are measured by their bounds, and the time, by a guess of its length.
    pub(in crate::ocp) fn of_scene(
        model: &dyn Model,
        horizon: f64,
        (lower, upper): (&[f64], &[f64]),
    ) -> Self {
        let declaration = model.declaration();
        let (n, contacts) = (declaration.coordinates.len(), declaration.contacts.len());
        let bounds = lower[n..].iter().zip(&upper[n..]);
        let largest = bounds.map(|(lower, upper)| lower.abs().max(upper.abs()));
        let unit = |size: f64| {
            if size.is_finite() && size > 0.0 {
                size
            } else {
                1.0
            }
        };
        Self {
            time: horizon,
            controls: largest.map(unit).collect(),
            force: vec![1.0; contacts],
            gap: vec![1.0; contacts],
            states: vec![1.0; 2 * n],
            gap_rows: vec![1.0; contacts],
            ways: vec![0.0; n],
            is_exact: false,
        }
    }

    /// Units of programs that start from a motion.
    pub(in crate::ocp) fn new(
        model: &dyn Model,
        scale: &Scale,
        motion: &Trajectory,
        bounds: (&[f64], &[f64]),
    ) -> Self {
        let declaration = model.declaration();
        let (n, controls) = (declaration.coordinates.len(), declaration.controls.len());
        let control_units = control_units(bounds, n, controls);
        let mut x = motion.states[0][..2 * n].to_vec();
        x.extend(drive(model, motion.controls.start(), 0.0));
        let accelerations: Vec<f64> = (0..declaration.contacts.len())
            .map(|contact| free_normal_acceleration(model, contact, &x).abs())
            .collect();
        let largest = accelerations.iter().copied().fold(0.0, f64::max);
        // Next to nothing beside what forces can give is an error of the guess, where weight acts along a surface.
        let at_hand = at_hand(model, &x, &control_units);
        let floor = if largest > yardstick::PROMISE * normal(model, &x, &at_hand) {
            0.1 * largest
        } else {
            nearest_power(THOUSAND, normal(model, &x, &at_hand))
        };
        let force: Vec<f64> = accelerations.iter().map(|a| a.max(floor)).collect();
        // How far an acceleration carries in about a third of the time.
        let reach = |acceleration: f64| acceleration.abs() * motion.horizon * motion.horizon / 20.0;
        let mut acceleration = vec![0.0; n];
        model.free_acceleration(&x, &mut acceleration);
        let pushed = pushed(model, &x, at_hand, &force);
        let set = set(model, motion);
        let sizes = acceleration.into_iter().zip(pushed).enumerate();
        let sizes = sizes.map(|(k, (acceleration, pushed))| {
            let values = motion.states.iter().map(|state| state[k].abs());
            let values = values.chain([set[k] * motion.horizon]);
            let limits = [bounds.0[k].abs(), bounds.1[k].abs()];
            let limits = limits.into_iter().filter(|limit| limit.is_finite());
            let size = values.chain(limits).fold(reach(acceleration), f64::max);
            // A coordinate that forces could move, and which stays where it is but for errors of the motion, has no size.
            if size < yardstick::PROMISE * reach(pushed) {
                0.0
            } else {
                size
            }
        });
        let coordinates: Vec<f64> = sizes
            .zip(&scale.sizes)
            .map(|(size, &asked)| coordinate_unit(size, asked))
            .collect();
        // Long motions keep theirs: small velocities are no trouble.
        let rate = nearest_power(THOUSAND, 1.0 / motion.horizon).max(1.0);
        let velocities: Vec<f64> = coordinates.iter().map(|size| size * rate).collect();
        Self {
            time: motion.horizon,
            controls: control_units,
            gap: force
                .iter()
                .map(|force| force * motion.horizon * motion.horizon / 200.0)
                .collect(),
            states: [&coordinates[..], &velocities].concat(),
            gap_rows: force
                .iter()
                .map(|&force| nearest_power(THOUSAND, reach(force)))
                .collect(),
            ways: scale.ways.clone(),
            is_exact: false,
            force,
        }
    }
}

/// Half of the range of each of so many controls behind the coordinates, or 1 where that is infinite.
fn control_units(bounds: (&[f64], &[f64]), n: usize, controls: usize) -> Vec<f64> {
    let unit = |k: usize| {
        let half = (bounds.1[k] - bounds.0[k]) / 2.0;
        if half.is_finite() && half > 0.0 {
            half
        } else {
            1.0
        }
    };
    (n..n + controls).map(unit).collect()
}

impl Units {
    /// These units with controls measured by a part of their bounds.
    pub(in crate::ocp) fn driven_within(mut self, range: (&[f64], &[f64])) -> Self {
        let controls = self.controls.len();
        self.controls = control_units(range, range.0.len() - controls, controls);
        self
    }

    /// These units with controls that have no bounds measured by those of a known motion. What would not move any coordinate in its time but
    /// by an error of the motion is no size: of a motion that asks for no force rounding is left.
    pub(in crate::ocp) fn measured_by(
        mut self,
        model: &dyn Model,
        motion: &Trajectory,
        bounds: (&[f64], &[f64]),
    ) -> Self {
        for (i, size) in self.unbounded(motion.controls.values(), bounds) {
            let moved = self.moved_by(model, motion, i);
            if moved == 0.0 || size * moved > yardstick::PROMISE {
                self.controls[i] = nearest_power(THOUSAND, size);
            }
        }
        self
    }

    /// By how many units a control at one moves the coordinate that it moves most in the time of a motion, from its start.
    fn moved_by(&self, model: &dyn Model, motion: &Trajectory, control: usize) -> f64 {
        let n = self.states.len() / 2;
        let mut x = motion.states[0][..2 * n].to_vec();
        x.extend(drive(model, &vec![0.0; self.controls.len()], 0.0));
        let (mut idle, mut driven) = (vec![0.0; n], vec![0.0; n]);
        model.free_acceleration(&x, &mut idle);
        x[2 * n + control] = 1.0;
        model.free_acceleration(&x, &mut driven);
        let moved = driven.iter().zip(&idle).zip(&self.states);
        let moved = moved.map(|((driven, idle), unit)| (driven - idle).abs() / unit);
        moved.fold(0.0, f64::max) * motion.horizon * motion.horizon
    }

    /// These units measured by another motion, but for controls and the objective: where that motion lasts another time, other sizes are
    /// of the order of one.
    pub(in crate::ocp) fn of_motion(
        &self,
        model: &dyn Model,
        scale: &Scale,
        motion: &Trajectory,
        bounds: (&[f64], &[f64]),
    ) -> Self {
        Self {
            controls: self.controls.clone(),
            is_exact: self.is_exact,
            ..Self::new(model, scale, motion, bounds)
        }
    }

    /// Share of a length that belongs to the unit of the scene which a gap keeps: where motions are far smaller than that unit, as much less.
    pub(in crate::ocp) fn share_of_gap(&self, contact: usize) -> f64 {
        self.gap_rows[contact].min(1.0)
    }

    /// Share of a distance in the unit of the scene by which plan and re-simulation may differ, a coordinate: by what goals ask of it and how
    /// far it goes, or else by its unit; where motions are far larger than the unit of the scene, as much more.
    pub(in crate::ocp) fn shares_of_distances(&self, plan: &Trajectory) -> Vec<f64> {
        let shares = self.ways.iter().enumerate().map(|(k, &way)| {
            let farthest = |from: f64| {
                let distances = plan.states.iter().map(|state| (state[k] - from).abs());
                distances.fold(0.0, f64::max)
            };
            let unit = self.states[k];
            let unit = if way > 0.0 {
                nearest_power(THOUSAND, farthest(plan.states[0][k]).max(way))
            } else if unit > 1.0 {
                nearest_power(THOUSAND, farthest(0.0)).min(unit)
            } else {
                unit
            };
            if unit < 1.0 {
                (FINE * unit).min(1.0)
            } else {
                (unit / FINE).max(1.0)
            }
        });
        shares.collect()
    }

    /// The largest velocity unit, 1 at most: what velocities that count as none are measured in where all are small.
    pub(in crate::ocp) fn slow(&self) -> f64 {
        let velocities = &self.states[self.states.len() / 2..];
        velocities.iter().copied().fold(0.0, f64::max).min(1.0)
    }

    /// These units with the objective measured as exactly as it can be.
    pub(in crate::ocp) fn exact(self) -> Self {
        let is_exact = true;
        Self { is_exact, ..self }
    }

    /// The unit of an objective with derivatives up to `largest`: a power of a million, or of ten where that is smaller
    /// and it has to be exact.
    pub(in crate::ocp) fn objective(&self, largest: f64) -> f64 {
        if self.is_exact {
            objective_size(largest)
        } else {
            nearest_power(MILLION, largest)
        }
    }

    /// Whether the controls of a plan are of the size of their units, or small.
    pub(in crate::ocp) fn fit(&self, controls: &[Vec<f64>], bounds: (&[f64], &[f64])) -> bool {
        let unbounded = self.unbounded(controls, bounds);
        unbounded
            .into_iter()
            .all(|(i, size)| size <= FAR * self.controls[i])
    }

    /// The controls without bounds, and the largest size of each.
    fn unbounded(&self, controls: &[Vec<f64>], bounds: (&[f64], &[f64])) -> Vec<(usize, f64)> {
        let first = bounds.0.len() - self.controls.len();
        let unbounded = (0..self.controls.len())
            .filter(|&i| !(bounds.1[first + i] - bounds.0[first + i]).is_finite());
        let sizes = unbounded.map(|i| {
            let values = controls.iter().map(|u| u[i].abs());
            (i, values.fold(0.0, f64::max))
        });
        sizes.collect()
    }
}

/// The unit of a coordinate of some size, of which goals ask that size, 0 for none: a guess that hardly moves it says nothing, and one
/// that goes too far beyond the goal no more than that.
fn coordinate_unit(size: f64, asked: f64) -> f64 {
    if asked > 0.0 {
        let most = THOUSAND * nearest_power(THOUSAND, asked);
        nearest_power(THOUSAND, size.max(asked)).min(most)
    } else {
        nearest_power(THOUSAND, size)
    }
}

/// The largest acceleration of each coordinate at a state, as it is and with each control by itself at its unit.
fn at_hand(model: &dyn Model, x: &[f64], controls: &[f64]) -> Vec<f64> {
    let n = model.declaration().coordinates.len();
    let (mut largest, mut acceleration) = (vec![0.0_f64; n], vec![0.0; n]);
    let mut collect = |x: &[f64]| {
        model.free_acceleration(x, &mut acceleration);
        for (largest, a) in largest.iter_mut().zip(&acceleration) {
            *largest = largest.max(a.abs());
        }
    };
    collect(x);
    for (k, unit) in controls.iter().enumerate() {
        let mut driven = x.to_vec();
        driven[2 * n + k] = *unit;
        collect(&driven);
    }
    largest
}

/// The largest normal acceleration of a contact that accelerations of coordinates can have together.
fn normal(model: &dyn Model, x: &[f64], accelerations: &[f64]) -> f64 {
    let n = accelerations.len();
    let mut point = vec![0.0; contact_point::length(n)];
    let normal = (0..model.declaration().contacts.len()).map(|contact| {
        model.contact(contact, x, &mut point);
        let normal = point[contact_point::NORMAL..][..n].iter();
        normal.zip(accelerations).map(|(n, a)| (n * a).abs()).sum()
    });
    normal.fold(0.0, f64::max)
}

/// Accelerations of coordinates with what contacts add that provide these normal accelerations, and friction as large.
fn pushed(model: &dyn Model, x: &[f64], mut accelerations: Vec<f64>, force: &[f64]) -> Vec<f64> {
    let n = accelerations.len();
    let mut point = vec![0.0; contact_point::length(n)];
    let mut tangent = vec![0.0; tangent_point::length(n)];
    for (contact, force) in force.iter().enumerate() {
        let mut push = |direction: &[f64]| {
            for (acceleration, d) in accelerations.iter_mut().zip(direction) {
                *acceleration += (d * force).abs();
            }
        };
        model.contact(contact, x, &mut point);
        push(&point[contact_point::direction(n)..][..n]);
        if is_frictional(model, contact) {
            model.tangent(contact, x, &mut tangent);
            push(&tangent[tangent_point::direction(n)..][..n]);
        }
    }
    accelerations
}

/// The largest velocities, of states of first order those themselves, that conditions would set along a motion, whether or not they come true.
fn set(model: &dyn Model, motion: &Trajectory) -> Vec<f64> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut largest = vec![0.0_f64; n];
    for (contact, declared) in declaration.contacts.iter().enumerate() {
        if declared.switch != Some(Switching::Resets) {
            continue;
        }
        for state in &motion.states {
            let mut x = state[..2 * n].to_vec();
            x.extend(drive(model, motion.controls.start(), 0.0));
            // What it does not set says nothing.
            let mut set = vec![0.0; n];
            model.reset(contact, &x, &mut set);
            for (largest, set) in largest.iter_mut().zip(set) {
                *largest = largest.max(set.abs());
            }
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::{Scale, Units, objective_size};
    use crate::model::Model;
    use crate::ocp::motion::control_grid::ControlGrid;
    use crate::ocp::motion::trajectory::Trajectory;
    use crate::ocp::problem::{Problem, bounds};

    crate::model! {
        /// A box between two fingers.
        Pinched {
            coordinates { l, r, x }
            controls { u in 0..=20, w in 0..=20 }
            lagrangian (dot(l)^2 + dot(r)^2 + dot(x)^2)/2
            forces { l: u, r: -w }
            surface left: x - l >= 0
            surface right: r - x >= 0
            impact left, right: inelastic
            finally { x == 0 }
            horizon 1
        }
    }

    crate::model! {
        /// A box on a belt, which moves it by friction only.
        Carried {
            coordinates { b, z, x }
            controls { u in -20..=20 }
            lagrangian (dot(b)^2 + dot(z)^2 + dot(x)^2)/2 - 9.81*z
            forces { b: u }
            surface belt: z >= 0
            impact belt: inelastic, friction 0.5, sliding dot(x) - dot(b)
            finally { b == 0 }
            horizon 1
        }
    }

    #[test]
    fn coordinate_that_stays_but_for_errors_of_the_motion_has_no_size_of_its_own() {
        let (pinched, carried) = (Pinched::default(), Carried::default());
        let sizes = [
            (0.0, 1.0),
            (1e-10, 1.0),
            (1e-8, 1.0),
            (1e-4, 1e-3),
            (0.1, 1.0),
        ];
        let scenes: [(&dyn Model, [f64; 2]); 2] = [(&pinched, [-0.1, 0.1]), (&carried, [0.0; 2])];
        for (model, [first, second]) in scenes {
            let (lower, upper) = bounds(model);
            let controls = model.declaration().controls.len();
            for (x, unit) in sizes {
                let state = |x: f64| vec![first, second, x, 0.0, 0.0, 0.0, 0.0, 0.0];
                let motion = Trajectory {
                    horizon: 1.0,
                    controls: ControlGrid::constant(vec![vec![1.0; controls]; 2]),
                    time: vec![0.0, 1.0],
                    states: vec![state(0.0), state(x)],
                };
                let scale = Scale::of(model, &Problem::of(model, 1));
                let units = Units::new(model, &scale, &motion, (&lower, &upper));
                let close = (units.states[2] / unit - 1.0).abs() < 1e-12;
                assert!(close, "{x} {}", units.states[2]);
            }
        }
    }

    #[test]
    fn objective_of_a_known_motion_is_measured_in_no_larger_unit_and_differences_never_are() {
        let rough = Units {
            time: 1.0,
            controls: Vec::new(),
            force: Vec::new(),
            gap: Vec::new(),
            states: Vec::new(),
            gap_rows: Vec::new(),
            ways: Vec::new(),
            is_exact: false,
        };
        let exact = rough.clone().exact();
        for (largest, unit, exactly) in [
            (2400.0, 1e6, 1e3),
            (5.0, 1.0, 1.0),
            (200.0, 1.0, 1.0),
            (0.04, 1.0, 0.1),
            (0.0, 1.0, 1.0),
        ] {
            let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
            assert!(close(rough.objective(largest), unit), "{largest}");
            assert!(close(exact.objective(largest), exactly), "{largest}");
            assert!(close(objective_size(largest), exactly), "{largest}");
        }
    }
}
