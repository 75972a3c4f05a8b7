//! A motion with its controls: what one phase of the solution hands to the next.

use super::problem::{Component, Problem};
use crate::model::{Model, contact_point};
use crate::simulation::{ControlSignal, Simulation};

/// States over time, piecewise linear, with controls on equal intervals.
#[derive(Debug, Clone)]
pub(super) struct Path {
    /// Length \[s\].
    pub(super) horizon: f64,
    /// Controls of each interval.
    pub(super) controls: Vec<Vec<f64>>,
    /// Instants \[s\], not decreasing; twice at a jump.
    pub(super) time: Vec<f64>,
    /// `(q, v, r)` at each instant, where `r` are the normal accelerations that the contacts provide.
    pub(super) states: Vec<Vec<f64>>,
}

impl Path {
    /// A guess from the model alone: coordinates with a goal move to it at constant speed, the others
    /// rest; controls are 0, or as near to it as their bounds allow.
    pub(super) fn straight(model: &dyn Model, problem: &Problem, bounds: (&[f64], &[f64])) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let horizon = problem.horizon_guess(model);
        let controls: Vec<f64> = (n..n + declaration.controls.len())
            .map(|k| 0.0_f64.clamp(bounds.0[k], bounds.1[k]))
            .collect();
        let samples = 4 * problem.intervals;
        let mut path = Self {
            horizon,
            controls: vec![controls.clone(); problem.intervals],
            time: Vec::new(),
            states: Vec::new(),
        };
        for i in 0..=samples {
            let share = i as f64 / samples as f64;
            let mut x = problem.q.clone();
            x.resize(2 * n, 0.0);
            for k in 0..n {
                if let Some(goal) = problem.goal(Component::Coordinate(k)) {
                    x[n + k] = (goal - problem.q[k]) / horizon;
                    x[k] += share * (goal - problem.q[k]);
                }
            }
            x.extend(&controls);
            let forces: Vec<f64> = (0..declaration.contacts.len())
                .map(|contact| (-free_normal_acceleration(model, contact, &x)).max(0.0))
                .collect();
            x.truncate(2 * n);
            x.extend(forces);
            path.time.push(share * horizon);
            path.states.push(x);
        }
        path
    }

    /// The motion of a simulation.
    pub(super) fn of_simulation(
        model: &dyn Model,
        simulation: &Simulation,
        horizon: f64,
        controls: Vec<Vec<f64>>,
    ) -> Self {
        let declaration = model.declaration();
        let mut point = vec![0.0; contact_point::length(declaration.coordinates.len())];
        let trajectory = &simulation.trajectory;
        let states = (0..trajectory.time.len()).map(|i| {
            let mut x = trajectory.q[i].clone();
            x.extend(&trajectory.v[i]);
            let plain = x.len();
            x.extend(&trajectory.u[i]);
            let forces: Vec<f64> = (0..declaration.contacts.len())
                .map(|contact| {
                    model.contact(contact, &x, &mut point);
                    trajectory.contact_force[i][contact] * point[contact_point::INVERSE_INERTIA]
                })
                .collect();
            x.truncate(plain);
            x.extend(forces);
            x
        });
        Self {
            horizon,
            controls,
            time: trajectory.time.clone(),
            states: states.collect(),
        }
    }

    /// The controls as a signal.
    pub(super) fn signal(&self) -> ControlSignal {
        let intervals = self.controls.len();
        ControlSignal::PiecewiseConstant {
            times: (0..intervals)
                .map(|k| self.horizon * k as f64 / intervals as f64)
                .collect(),
            values: self.controls.clone(),
        }
    }

    /// `(q, v, r)` at time `t`, on the later side of a jump if `after`.
    pub(super) fn at(&self, t: f64, after: bool) -> Vec<f64> {
        let next = if after {
            self.time.partition_point(|&time| time <= t)
        } else {
            self.time.partition_point(|&time| time < t)
        };
        let last = self.time.len() - 1;
        if next == 0 || next > last {
            return self.states[next.min(last)].clone();
        }
        let (from, to) = (self.time[next - 1], self.time[next]);
        let share = if to > from {
            (t - from) / (to - from)
        } else {
            1.0
        };
        let pair = self.states[next - 1].iter().zip(&self.states[next]);
        pair.map(|(a, b)| a + share * (b - a)).collect()
    }
}

/// Normal acceleration of a contact without its force, `n'a + curvature`, at `x = (q, v, u)`.
pub(super) fn free_normal_acceleration(model: &dyn Model, contact: usize, x: &[f64]) -> f64 {
    let n = model.declaration().coordinates.len();
    let mut point = vec![0.0; contact_point::length(n)];
    let mut acceleration = vec![0.0; n];
    model.contact(contact, x, &mut point);
    model.free_acceleration(x, &mut acceleration);
    let normal = &point[contact_point::NORMAL..][..n];
    let along: f64 = normal.iter().zip(&acceleration).map(|(n, a)| n * a).sum();
    along + point[contact_point::CURVATURE]
}

/// Units of the unknowns, from the start of the motion and the bounds.
#[derive(Debug, Clone)]
pub(super) struct Units {
    /// Time \[s\]: the guess of the horizon.
    pub(super) time: f64,
    /// Each control: half of its range, or 1 where that is infinite.
    pub(super) controls: Vec<f64>,
    /// Normal acceleration of each contact at the start under no force, at least a tenth of the
    /// largest.
    pub(super) force: Vec<f64>,
    /// Gap of each contact: how far that acceleration carries in a tenth of the time, times 10.
    pub(super) gap: Vec<f64>,
}

impl Units {
    pub(super) fn new(model: &dyn Model, path: &Path, bounds: (&[f64], &[f64])) -> Self {
        let declaration = model.declaration();
        let (n, controls) = (declaration.coordinates.len(), declaration.controls.len());
        let control_units = (n..n + controls).map(|k| {
            let half = (bounds.1[k] - bounds.0[k]) / 2.0;
            if half.is_finite() && half > 0.0 {
                half
            } else {
                1.0
            }
        });
        let mut x = path.states[0][..2 * n].to_vec();
        x.extend(&path.controls[0]);
        let accelerations: Vec<f64> = (0..declaration.contacts.len())
            .map(|contact| free_normal_acceleration(model, contact, &x).abs())
            .collect();
        let largest = accelerations.iter().copied().fold(0.0, f64::max);
        let floor = if largest > 0.0 { 0.1 * largest } else { 1.0 };
        let force: Vec<f64> = accelerations.iter().map(|a| a.max(floor)).collect();
        Self {
            time: path.horizon,
            controls: control_units.collect(),
            gap: force
                .iter()
                .map(|force| force * path.horizon * path.horizon / 200.0)
                .collect(),
            force,
        }
    }
}
