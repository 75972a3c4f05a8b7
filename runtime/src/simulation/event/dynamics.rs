//! The constrained dynamics of one contact mode: accelerations, normal contact accelerations, speed of
//! numerical time, projection onto the surfaces in contact.

use super::dop853::System;
use super::small_system;
use crate::model::{Model, contact_point};
use crate::simulation::{
    ControlSignal, Counts, ProblemSize, Residuals, Seconds, Simulation, SimulationStatus,
    Trajectory,
};

/// Gaps below this times `max(1, |q|)` are closed: a gap is a difference of numbers of the size of the
/// coordinates, so rounding alone leaves some `1e-15` of them, polynomial surfaces some `1e-14`.
const CLOSED_GAP: f64 = 1e-12;
/// Normal velocities below this times `max(1, |v|)` are zero.
const ZERO_VELOCITY: f64 = 1e-12;
/// Normal contact accelerations below this times the accelerations they balance are zero.
const ZERO_FORCE: f64 = 1e-12;
/// Newton steps of one projection; the second already meets rounding error after a step that passed
/// the error test.
const PROJECTIONS: usize = 6;

/// Dynamics of a model with a set of active contacts `I`: `v' = a + sum_I d_i r_i` with the normal
/// contact accelerations from `n_i' v' + curvature_i = 0`, that is `D r = -(n' a + curvature)`,
/// `D_ij = n_i' d_j`.
///
/// The state is `y = (q, v, numerical time)`.
pub(in crate::simulation) struct Dynamics<'a> {
    pub(in crate::simulation) model: &'a dyn Model,
    /// Number of coordinates.
    pub(in crate::simulation) n: usize,
    /// Number of contacts.
    pub(in crate::simulation) contacts: usize,
    /// Active contacts, increasing.
    pub(in crate::simulation) active: Vec<usize>,
    /// Controls that hold now.
    pub(in crate::simulation) u: Vec<f64>,
    /// For active contacts the normal contact acceleration, for open ones the gap, at the last
    /// evaluation.
    pub(in crate::simulation) values: Vec<f64>,
    /// Smallest of `values` since [`sample_from`](Self::sample_from).
    pub(in crate::simulation) lowest: Vec<f64>,
    /// Largest of `values` since [`sample_from`](Self::sample_from).
    pub(in crate::simulation) highest: Vec<f64>,
    /// Sizes of the terms that the normal contact acceleration of an active contact balances,
    /// `|curvature| + sum_k |n_k a_k| + sum_j |D_ij r_j|`: rounding error is a share of it.
    pub(in crate::simulation) force_scale: Vec<f64>,
    /// Accelerations that are nothing to a contact: `sqrt(D_i a'M a)`, the largest normal acceleration that
    /// forces of the size of those present could give, at the last change of the mode.
    force_floor: Vec<f64>,
    /// Evaluations so far.
    pub(in crate::simulation) evaluations: usize,
    auxiliary_acceleration: f64,
    explicit_time: bool,
    x: Vec<f64>,
    acceleration: Vec<f64>,
    points: Vec<f64>,
    mass: Vec<f64>,
    matrix: Vec<f64>,
    right: Vec<f64>,
}

impl<'a> Dynamics<'a> {
    pub(in crate::simulation) fn new(model: &'a dyn Model, auxiliary_acceleration: f64) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let contacts = declaration.contacts.len();
        Self {
            model,
            n,
            contacts,
            active: Vec::with_capacity(contacts),
            u: vec![0.0; declaration.controls.len()],
            values: vec![0.0; contacts],
            lowest: vec![0.0; contacts],
            highest: vec![0.0; contacts],
            force_scale: vec![0.0; contacts],
            force_floor: vec![0.0; contacts],
            mass: vec![0.0; n * n],
            evaluations: 0,
            auxiliary_acceleration,
            explicit_time: declaration.explicit_time,
            x: vec![0.0; declaration.inputs()],
            acceleration: vec![0.0; n],
            points: vec![0.0; contacts * contact_point::length(n)],
            matrix: vec![0.0; contacts * contacts],
            right: vec![0.0; contacts],
        }
    }

    /// A result without events and trajectory.
    pub(in crate::simulation) fn empty_result(&self) -> Simulation {
        Simulation {
            status: SimulationStatus::Solved,
            events: Vec::new(),
            trajectory: Trajectory::default(),
            residuals: Residuals::default(),
            size: ProblemSize {
                variables: 2 * self.n,
                equalities: 2 * self.n,
                complementarities: self.contacts,
                ..ProblemSize::default()
            },
            counts: Counts::default(),
            seconds: Seconds::default(),
            notes: Vec::new(),
        }
    }

    /// Sets the controls that hold right after `t`.
    pub(in crate::simulation) fn set_controls(&mut self, signal: &ControlSignal, t: f64) {
        signal.write(t, &mut self.u);
        let n = self.n;
        self.x[2 * n..2 * n + self.u.len()].copy_from_slice(&self.u);
    }

    /// Writes the state into the input vector that the model's kernels read.
    pub(in crate::simulation) fn load(&mut self, t: f64, y: &[f64]) {
        let n = self.n;
        self.x[..2 * n].copy_from_slice(&y[..2 * n]);
        if self.explicit_time
            && let Some(last) = self.x.last_mut()
        {
            *last = t;
        }
    }

    /// Evaluates one contact at the state loaded.
    pub(in crate::simulation) fn evaluate_contact(&mut self, contact: usize) {
        let length = contact_point::length(self.n);
        let point = &mut self.points[contact * length..(contact + 1) * length];
        self.model.contact(contact, &self.x, point);
    }

    /// The contact as last evaluated, laid out as in [`contact_point`].
    pub(in crate::simulation) fn point(&self, contact: usize) -> &[f64] {
        let length = contact_point::length(self.n);
        &self.points[contact * length..(contact + 1) * length]
    }

    /// Contact normal as last evaluated.
    pub(in crate::simulation) fn normal(&self, contact: usize) -> &[f64] {
        &self.point(contact)[contact_point::NORMAL..][..self.n]
    }

    /// Contact direction as last evaluated.
    pub(in crate::simulation) fn direction(&self, contact: usize) -> &[f64] {
        &self.point(contact)[contact_point::direction(self.n)..][..self.n]
    }

    /// `D_ij = n_i' d_j` as last evaluated.
    pub(in crate::simulation) fn coupling(&self, i: usize, j: usize) -> f64 {
        dot(self.normal(i), self.direction(j))
    }

    /// Gap at the state loaded.
    pub(in crate::simulation) fn gap(&self, contact: usize) -> f64 {
        self.model.gap(contact, &self.x)
    }

    /// Evaluates the acceleration without contact at the state loaded.
    pub(in crate::simulation) fn evaluate_free_acceleration(&mut self) {
        self.evaluations += 1;
        self.model
            .free_acceleration(&self.x, &mut self.acceleration);
    }

    /// Acceleration without contact as last evaluated.
    pub(in crate::simulation) fn free_acceleration(&self) -> &[f64] {
        &self.acceleration
    }

    /// Normal acceleration of contact `i` without contact forces, `n' a + curvature`, and the sum of
    /// the absolute values of its terms.
    pub(in crate::simulation) fn free_normal_acceleration(&self, contact: usize) -> (f64, f64) {
        let curvature = self.point(contact)[contact_point::CURVATURE];
        self.normal(contact)
            .iter()
            .zip(&self.acceleration)
            .fold((curvature, curvature.abs()), |(sum, scale), (n, a)| {
                (sum + n * a, scale + (n * a).abs())
            })
    }

    /// Sets the sizes of forces to which others are compared, for the contacts given; contacts and free
    /// acceleration are evaluated.
    pub(in crate::simulation) fn set_force_floors(&mut self, contacts: &[usize]) {
        self.model.mass_matrix(&self.x, &mut self.mass);
        let a = &self.acceleration;
        let square: f64 = self
            .mass
            .chunks_exact(self.n.max(1))
            .zip(a)
            .map(|(row, a_k)| a_k * dot(row, a))
            .sum();
        for &i in contacts {
            let inverse_inertia = self.point(i)[contact_point::INVERSE_INERTIA];
            self.force_floor[i] = (inverse_inertia * square).max(0.0).sqrt();
        }
    }

    /// Size of forces to which those of a contact are compared.
    pub(in crate::simulation) fn force_floor(&self, contact: usize) -> f64 {
        self.force_floor[contact]
    }

    /// Accepts the contact forces of a new mode: one that is negative by rounding error is no reason to leave
    /// the mode again.
    pub(in crate::simulation) fn accept_forces(&mut self) {
        for &i in &self.active {
            let pull = -self.values[i];
            self.force_floor[i] = self.force_floor[i].max(2.0 * pull / ZERO_FORCE);
        }
    }

    /// Sizes of the terms of the normal acceleration with contact forces of any contact as last
    /// evaluated: `|curvature| + sum_k |n_k| (|a_k| + sum_j |d_jk r_j|)`, or the floor if that is larger.
    pub(in crate::simulation) fn normal_acceleration_scale(&self, contact: usize) -> f64 {
        let curvature = self.point(contact)[contact_point::CURVATURE].abs();
        let terms = self
            .normal(contact)
            .iter()
            .enumerate()
            .fold(curvature, |sum, (k, n)| {
                let forces: f64 = self
                    .active
                    .iter()
                    .map(|&j| (self.direction(j)[k] * self.values[j]).abs())
                    .sum();
                sum + n.abs() * (self.acceleration[k].abs() + forces)
            });
        terms.max(self.force_floor[contact])
    }

    /// Whether a contact belongs to the present mode.
    pub(in crate::simulation) fn is_active(&self, contact: usize) -> bool {
        self.active.contains(&contact)
    }

    /// Normal contact forces at the last evaluation, `lambda_i = r_i / D_i`, 0 for open contacts.
    pub(in crate::simulation) fn forces(&self, out: &mut [f64]) {
        out.fill(0.0);
        for &i in &self.active {
            out[i] = self.values[i] / self.point(i)[contact_point::INVERSE_INERTIA];
        }
    }

    /// Makes `values` the first sample of a step.
    pub(in crate::simulation) fn sample_from(&mut self, values: &[f64]) {
        self.lowest.copy_from_slice(values);
        self.highest.copy_from_slice(values);
    }

    /// Below this gap a contact is closed.
    pub(in crate::simulation) fn closed_gap(&self, y: &[f64]) -> f64 {
        CLOSED_GAP * largest(&y[..self.n]).max(1.0)
    }

    /// Below this normal velocity a contact is at rest.
    pub(in crate::simulation) fn zero_velocity(&self, y: &[f64]) -> f64 {
        ZERO_VELOCITY * largest(&y[self.n..2 * self.n]).max(1.0)
    }

    /// What counts as zero for the value of a contact: a closed gap or a vanishing force.
    pub(in crate::simulation) fn zero_value(&self, contact: usize, y: &[f64]) -> f64 {
        if self.is_active(contact) {
            ZERO_FORCE * self.force_scale[contact].max(self.force_floor[contact])
        } else {
            self.closed_gap(y)
        }
    }

    /// Solves `D x = right` over the active contacts as last evaluated; `false` if their normals are
    /// dependent.
    fn solve_active(&mut self) -> bool {
        let m = self.active.len();
        for row in 0..m {
            for column in 0..m {
                self.matrix[row * m + column] =
                    self.coupling(self.active[row], self.active[column]);
            }
        }
        small_system::solve(&mut self.matrix[..m * m], &mut self.right[..m])
    }

    /// `to += sum_I d_i right_i` over the active contacts.
    fn add_directions(&self, to: &mut [f64]) {
        for (&i, factor) in self.active.iter().zip(&self.right) {
            for (to, d) in to.iter_mut().zip(self.direction(i)) {
                *to += d * factor;
            }
        }
    }

    /// Moves the state onto `g = 0`, `v_n = 0` of the active contacts, along their directions `d`.
    /// `false` if it cannot.
    pub(in crate::simulation) fn project(&mut self, t: f64, y: &mut [f64]) -> bool {
        if self.active.is_empty() {
            return true;
        }
        let n = self.n;
        // A polynomial surface is evaluated to some 1e-15 of the coordinates; closer is luck.
        let rounding = 2e-3 * self.closed_gap(y);
        let mut previous = f64::INFINITY;
        for _ in 0..PROJECTIONS {
            self.load(t, y);
            let mut worst = 0.0_f64;
            for slot in 0..self.active.len() {
                let i = self.active[slot];
                self.evaluate_contact(i);
                let gap = self.point(i)[contact_point::GAP];
                self.right[slot] = -gap;
                worst = worst.max(gap.abs());
                if gap.is_nan() {
                    return false;
                }
            }
            if worst <= rounding || worst >= previous {
                break;
            }
            previous = worst;
            if !self.solve_active() {
                return false;
            }
            self.add_directions(&mut y[..n]);
        }
        for slot in 0..self.active.len() {
            self.right[slot] = -self.point(self.active[slot])[contact_point::NORMAL_VELOCITY];
        }
        if !self.solve_active() {
            return false;
        }
        self.add_directions(&mut y[n..2 * n]);
        self.load(t, y);
        true
    }

    /// `dtau/dt = 1/p` of the time-freezing system with `a_bar`, `p = prod_i (1 - s_i p)`,
    /// `s_i = r_i / a_bar` over the active contacts: the weight of the free dynamics is `p`, those of
    /// the auxiliary dynamics `gamma_i = s_i p`.
    fn speed_of_numerical_time(&self) -> f64 {
        let shares = || self.right[..self.active.len()].iter();
        let sum: f64 = shares().map(|r| r / self.auxiliary_acceleration).sum();
        if self.active.len() < 2 {
            return 1.0 + sum;
        }
        // The residual p - prod(1 - s p) increases with p and 1 / (1 + sum s) lies below its root.
        let mut p = 1.0 / (1.0 + sum);
        for _ in 0..20 {
            let (mut product, mut slope) = (1.0, 0.0);
            for r in shares() {
                let s = r / self.auxiliary_acceleration;
                slope = slope * (1.0 - s * p) - s * product;
                product *= 1.0 - s * p;
            }
            let step = (p - product) / (1.0 - slope);
            p -= step;
            if step.abs() <= 1e-15 {
                break;
            }
        }
        1.0 / p
    }
}

impl System for Dynamics<'_> {
    fn derivative(&mut self, t: f64, y: &[f64], dy: &mut [f64]) {
        let n = self.n;
        self.load(t, y);
        self.evaluate_free_acceleration();
        let mut next = 0;
        for i in 0..self.contacts {
            if self.active.get(next) == Some(&i) {
                self.evaluate_contact(i);
                let (normal, scale) = self.free_normal_acceleration(i);
                self.right[next] = -normal;
                self.force_scale[i] = scale;
                next += 1;
            } else {
                self.values[i] = self.gap(i);
            }
        }
        dy[..n].copy_from_slice(&y[n..2 * n]);
        dy[n..2 * n].copy_from_slice(&self.acceleration);
        dy[2 * n] = 1.0;
        if next > 0 {
            if self.solve_active() {
                self.add_directions(&mut dy[n..2 * n]);
            } else {
                self.right[..next].fill(f64::NAN);
                dy[n..2 * n].fill(f64::NAN);
            }
            dy[2 * n] = self.speed_of_numerical_time();
            for slot in 0..next {
                let i = self.active[slot];
                self.values[i] = self.right[slot];
                for other in (0..next).filter(|&other| other != slot) {
                    let coupling = self.coupling(i, self.active[other]);
                    self.force_scale[i] += (coupling * self.right[other]).abs();
                }
            }
        }
        for ((value, lowest), highest) in self
            .values
            .iter()
            .zip(&mut self.lowest)
            .zip(&mut self.highest)
        {
            *lowest = lowest.min(*value);
            *highest = highest.max(*value);
        }
    }
}

pub(in crate::simulation) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(in crate::simulation) fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |s, a| s.max(a.abs()))
}
