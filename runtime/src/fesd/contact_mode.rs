//! The contact mode: which contacts carry a force, and the velocity jump of an impact.
//!
//! Contacts that touch (`g_i = 0`, `v_n,i = 0`) take accelerations from the linear complementarity
//! problem `0 <= r _|_ phi + D r >= 0` with `phi_i = n_i' a + curvature_i`, `D_ij = n_i' d_j`. Where both
//! sides vanish the same problem one derivative higher decides. Impacts follow Moreau's law,
//! `0 <= p _|_ v_n + D p >= 0`, for all touching contacts at once.

use crate::linalg::{dense, lcp};
use crate::model::{Model, contact_point};

/// Relative size below which an acceleration or a jerk counts as zero when the mode is chosen.
const BIACTIVE: f64 = 1e-8;

/// Why a contact mode could not be determined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ModeError {
    /// The complementarity problem of impulses or accelerations has no solution: jamming.
    Jammed,
    /// The normals of the active contacts are dependent.
    Dependent,
    /// A model value is infinite or not a number.
    NotFinite,
}

impl From<lcp::LcpError> for ModeError {
    fn from(error: lcp::LcpError) -> Self {
        match error {
            lcp::LcpError::Ray => Self::Jammed,
            lcp::LcpError::NotFinite => Self::NotFinite,
        }
    }
}

/// Tolerances on the gap and the normal velocity of a contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touching {
    /// Gap tolerance [unit of the gap].
    pub(crate) gap: f64,
    /// Normal velocity tolerance [unit of the gap / s].
    pub(crate) velocity: f64,
}

/// Evaluates contacts and their forces at a point; owns the memory for it.
pub(crate) struct Contacts<'a> {
    model: &'a dyn Model,
    n: usize,
    acceleration: Vec<f64>,
    points: Vec<f64>,
    /// Largest sum of terms of each normal acceleration seen so far: the scale of its rounding error. At one
    /// instant the terms may cancel inside the model.
    scales: Vec<f64>,
    matrix: Vec<f64>,
    pivots: Vec<usize>,
    shifted: Vec<f64>,
    pub(crate) evaluations: usize,
}

impl<'a> Contacts<'a> {
    pub(crate) fn new(model: &'a dyn Model) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let contacts = declaration.contacts.len();
        Self {
            model,
            n,
            acceleration: vec![0.0; n],
            points: vec![0.0; contacts * contact_point::length(n)],
            scales: vec![0.0; contacts],
            matrix: Vec::new(),
            pivots: Vec::new(),
            shifted: vec![0.0; declaration.inputs()],
            evaluations: 0,
        }
    }

    fn point(&self, contact: usize) -> &[f64] {
        let length = contact_point::length(self.n);
        &self.points[contact * length..(contact + 1) * length]
    }

    fn normal(&self, contact: usize) -> &[f64] {
        &self.point(contact)[contact_point::NORMAL..contact_point::NORMAL + self.n]
    }

    /// Contact direction `d_i` of the last evaluation.
    pub(crate) fn direction(&self, contact: usize) -> &[f64] {
        &self.point(contact)[contact_point::direction(self.n)..]
    }

    /// Gap of the last evaluation.
    pub(crate) fn gap(&self, contact: usize) -> f64 {
        self.point(contact)[contact_point::GAP]
    }

    /// Normal velocity of the last evaluation.
    pub(crate) fn normal_velocity(&self, contact: usize) -> f64 {
        self.point(contact)[contact_point::NORMAL_VELOCITY]
    }

    /// Contact force `lambda_i = r_i / D_i` for a normal contact acceleration.
    pub(crate) fn force(&self, contact: usize, r: f64) -> f64 {
        r / self.point(contact)[contact_point::INVERSE_INERTIA]
    }

    /// Evaluates the listed contacts at `x`, without forces.
    pub(crate) fn evaluate_contacts(&mut self, x: &[f64], contacts: &[usize]) {
        let length = contact_point::length(self.n);
        for &i in contacts {
            self.model
                .contact(i, x, &mut self.points[i * length..(i + 1) * length]);
        }
        self.evaluations += 1;
    }

    /// Evaluates the free acceleration and the listed contacts at `x`.
    pub(crate) fn evaluate(&mut self, x: &[f64], contacts: &[usize]) {
        self.model.free_acceleration(x, &mut self.acceleration);
        self.evaluate_contacts(x, contacts);
        for &i in contacts {
            let terms: f64 = self
                .normal(i)
                .iter()
                .zip(&self.acceleration)
                .map(|(n, a)| (n * a).abs())
                .sum();
            let scale = terms + self.point(i)[contact_point::CURVATURE].abs();
            if scale > self.scales[i] {
                self.scales[i] = scale;
            }
        }
    }

    /// Normal acceleration without contact force, `phi_i`.
    fn phi(&self, contact: usize) -> f64 {
        dot(self.normal(contact), &self.acceleration)
            + self.point(contact)[contact_point::CURVATURE]
    }

    /// Scale of the rounding error of `phi_i`.
    pub(crate) fn phi_scale(&self, contact: usize) -> f64 {
        self.scales[contact]
    }

    fn coupling(&self, i: usize, j: usize) -> f64 {
        dot(self.normal(i), self.direction(j))
    }

    /// Normal contact accelerations of the `active` contacts at the last evaluation: `D r = -phi`.
    pub(crate) fn contact_accelerations(
        &mut self,
        active: &[usize],
        r: &mut [f64],
    ) -> Result<(), ModeError> {
        if let [single] = active {
            // n' d = 1 by the scaling of the contact direction
            r[0] = -self.phi(*single);
            return Ok(());
        }
        let size = active.len();
        self.matrix.clear();
        for &i in active {
            for &j in active {
                let entry = self.coupling(i, j);
                self.matrix.push(entry);
            }
        }
        self.pivots.resize(size, 0);
        for (value, &i) in r.iter_mut().zip(active) {
            *value = -self.phi(i);
        }
        dense::factorize(&mut self.matrix, &mut self.pivots).map_err(|_| ModeError::Dependent)?;
        dense::solve(&self.matrix, &self.pivots, r);
        Ok(())
    }

    /// Acceleration `a + sum d_i r_i` at the last evaluation.
    pub(crate) fn constrained_acceleration(&self, active: &[usize], r: &[f64], result: &mut [f64]) {
        result.copy_from_slice(&self.acceleration);
        for (&i, &force) in active.iter().zip(r) {
            for (a, d) in result.iter_mut().zip(self.direction(i)) {
                *a += d * force;
            }
        }
    }

    /// Solves the impact of all contacts in `touching` at the last evaluation; writes the normal
    /// velocity increments `p` and adds the jump to `v`.
    pub(crate) fn impact(
        &self,
        touching: &[usize],
        p: &mut Vec<f64>,
        v: &mut [f64],
    ) -> Result<(), ModeError> {
        let velocities: Vec<f64> = touching.iter().map(|&i| self.normal_velocity(i)).collect();
        p.clear();
        p.resize(touching.len(), 0.0);
        lcp::solve(&self.couplings(touching), &velocities, p)?;
        for (&i, &impulse) in touching.iter().zip(&*p) {
            for (component, d) in v.iter_mut().zip(self.direction(i)) {
                *component += d * impulse;
            }
        }
        Ok(())
    }

    /// Removes the normal velocities of the `active` contacts at the last evaluation from `v`, along their
    /// directions.
    pub(crate) fn hold(&mut self, active: &[usize], v: &mut [f64]) -> Result<(), ModeError> {
        let mut factors = self.couplings(active);
        let mut pivots = vec![0; active.len()];
        let mut impulses: Vec<f64> = active.iter().map(|&i| self.normal_velocity(i)).collect();
        dense::factorize(&mut factors, &mut pivots).map_err(|_| ModeError::Dependent)?;
        dense::solve(&factors, &pivots, &mut impulses);
        for (&i, impulse) in active.iter().zip(&impulses) {
            for (component, d) in v.iter_mut().zip(self.direction(i)) {
                *component -= d * impulse;
            }
        }
        Ok(())
    }

    /// Largest scale of the normal accelerations of the listed contacts.
    pub(crate) fn largest_scale(&self, contacts: &[usize]) -> f64 {
        contacts
            .iter()
            .fold(0.0, |largest, &i| self.scales[i].max(largest))
    }

    /// One Newton step on `q` towards `g_i = 0` of the listed contacts, from the last evaluation.
    pub(crate) fn close_gaps(&self, contacts: &[usize], q: &mut [f64]) -> Result<(), ModeError> {
        let mut factors = self.couplings(contacts);
        let mut pivots = vec![0; contacts.len()];
        let mut shift: Vec<f64> = contacts.iter().map(|&i| self.gap(i)).collect();
        dense::factorize(&mut factors, &mut pivots).map_err(|_| ModeError::Dependent)?;
        dense::solve(&factors, &pivots, &mut shift);
        for (&i, value) in contacts.iter().zip(&shift) {
            for (component, d) in q.iter_mut().zip(self.direction(i)) {
                *component -= d * value;
            }
        }
        Ok(())
    }

    fn couplings(&self, contacts: &[usize]) -> Vec<f64> {
        let mut matrix = Vec::with_capacity(contacts.len() * contacts.len());
        for &i in contacts {
            for &j in contacts {
                matrix.push(self.coupling(i, j));
            }
        }
        matrix
    }

    /// The contact mode at `x`: writes the contacts that carry a force to `active`. Of the contacts that
    /// are `close`, those touch whose normal velocity is at most `velocity_tolerance`.
    ///
    /// `active` holds the previous mode on entry; it decides where accelerations and jerks both vanish.
    /// What [`evaluate`](Self::evaluate) stored is overwritten.
    pub(crate) fn select(
        &mut self,
        x: &[f64],
        close: &[usize],
        velocity_tolerance: f64,
        active: &mut Vec<usize>,
    ) -> Result<(), ModeError> {
        self.evaluate(x, close);
        let touching: Vec<usize> = close
            .iter()
            .copied()
            .filter(|&i| self.normal_velocity(i).abs() <= velocity_tolerance)
            .collect();
        if touching.is_empty() {
            active.clear();
            return Ok(());
        }
        let phi: Vec<f64> = touching.iter().map(|&i| self.phi(i)).collect();
        let matrix = self.couplings(&touching);
        let mut r = vec![0.0; touching.len()];
        lcp::solve(&matrix, &phi, &mut r)?;
        let size = touching.len();
        let (mut strict, mut undecided) = (Vec::new(), Vec::new());
        for k in 0..size {
            let zero = BIACTIVE * self.phi_scale(touching[k]);
            let w = phi[k] + dot(&matrix[k * size..(k + 1) * size], &r);
            if r[k] > zero {
                strict.push(touching[k]);
            } else if w <= zero {
                undecided.push(touching[k]);
            }
        }
        if !undecided.is_empty() {
            self.select_by_jerk(x, active, &mut strict, &undecided)?;
        }
        strict.sort_unstable();
        active.clone_from(&strict);
        Ok(())
    }

    /// Decides contacts whose force and acceleration both vanish by their derivatives along the motion
    /// with the strictly active contacts; where those vanish too, the previous mode stays.
    fn select_by_jerk(
        &mut self,
        x: &[f64],
        previous: &[usize],
        strict: &mut Vec<usize>,
        undecided: &[usize],
    ) -> Result<(), ModeError> {
        let held = strict.clone();
        let mut r = vec![0.0; held.len()];
        self.contact_accelerations(&held, &mut r)?;
        let mut motion = vec![0.0; self.n];
        self.constrained_acceleration(&held, &r, &mut motion);
        let matrix = self.reduced_couplings(&held, undecided)?;
        let scales: Vec<f64> = undecided.iter().map(|&i| self.phi_scale(i)).collect();
        // Central difference along the motion; its truncation and rounding errors are both near
        // 1e-10 of the scale for a step of 1e-5 of the motion's own time scale.
        let speed = norm(&x[self.n..2 * self.n]) + f64::MIN_POSITIVE;
        let time_scale = (speed / (norm(&motion) + f64::MIN_POSITIVE)).clamp(1e-3, 1.0);
        let step = 1e-5 * time_scale;
        let mut ahead = vec![0.0; undecided.len()];
        let mut behind = vec![0.0; undecided.len()];
        self.separation(x, &motion, step, &held, undecided, &mut ahead)?;
        self.separation(x, &motion, -step, &held, undecided, &mut behind)?;
        let jerk: Vec<f64> = ahead
            .iter()
            .zip(&behind)
            .map(|(a, b)| (a - b) / (2.0 * step))
            .collect();
        let mut rate = vec![0.0; undecided.len()];
        lcp::solve(&matrix, &jerk, &mut rate)?;
        for (k, &i) in undecided.iter().enumerate() {
            let zero = BIACTIVE * scales[k] / time_scale;
            let row = &matrix[k * undecided.len()..(k + 1) * undecided.len()];
            let w = jerk[k] + dot(row, &rate);
            if rate[k] > zero || (w <= zero && previous.contains(&i)) {
                strict.push(i);
            }
        }
        Ok(())
    }

    /// Couplings of `undecided` contacts while the `held` ones keep their normal velocity:
    /// `D_UU - D_UH D_HH^-1 D_HU`.
    fn reduced_couplings(
        &self,
        held: &[usize],
        undecided: &[usize],
    ) -> Result<Vec<f64>, ModeError> {
        let mut matrix = self.couplings(undecided);
        if held.is_empty() {
            return Ok(matrix);
        }
        let mut factors = self.couplings(held);
        let mut pivots = vec![0; held.len()];
        dense::factorize(&mut factors, &mut pivots).map_err(|_| ModeError::Dependent)?;
        for (column, &j) in undecided.iter().enumerate() {
            let mut response: Vec<f64> = held.iter().map(|&h| self.coupling(h, j)).collect();
            dense::solve(&factors, &pivots, &mut response);
            for (row, &i) in undecided.iter().enumerate() {
                let through: f64 = held
                    .iter()
                    .zip(&response)
                    .map(|(&h, value)| self.coupling(i, h) * value)
                    .sum();
                matrix[row * undecided.len() + column] -= through;
            }
        }
        Ok(matrix)
    }

    /// Normal accelerations of `undecided` contacts a time `step` along the motion, with the `held`
    /// contacts carrying their forces.
    fn separation(
        &mut self,
        x: &[f64],
        motion: &[f64],
        step: f64,
        held: &[usize],
        undecided: &[usize],
        w: &mut [f64],
    ) -> Result<(), ModeError> {
        let n = self.n;
        let mut shifted = std::mem::take(&mut self.shifted);
        shifted.copy_from_slice(x);
        for k in 0..n {
            shifted[k] += step * x[n + k] + 0.5 * step * step * motion[k];
            shifted[n + k] += step * motion[k];
        }
        if self.model.declaration().explicit_time
            && let Some(time) = shifted.last_mut()
        {
            *time += step;
        }
        let both: Vec<usize> = held.iter().chain(undecided).copied().collect();
        self.evaluate(&shifted, &both);
        self.shifted = shifted;
        let mut r = vec![0.0; held.len()];
        self.contact_accelerations(held, &mut r)?;
        for (value, &i) in w.iter_mut().zip(undecided) {
            *value = self.phi(i)
                + held
                    .iter()
                    .zip(&r)
                    .map(|(&h, force)| self.coupling(i, h) * force)
                    .sum::<f64>();
        }
        Ok(())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
