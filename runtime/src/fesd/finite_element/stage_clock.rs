//! The clock of an element in numerical time.

use crate::rk::ButcherTableau;

/// Newton iterations for the place at which the clock shows a time; four or five are needed.
const MAX_ITERATIONS: usize = 20;

/// Least speed of the clock in an element: its nodes would leave out what happens where it is slower.
const LEAST_SPEED: f64 = 0.5;
/// Speed of the clock under the largest forces where that is not kept.
const RAISED_SPEED: f64 = 0.9;

/// The clock of an element, stage by stage.
#[derive(Default)]
pub(super) struct StageClock {
    /// Acceleration `a_bar` of the auxiliary dynamics, larger than asked for where contacts press harder; none in physical
    /// time.
    pub(super) auxiliary_acceleration: Option<f64>,
    /// Active contacts.
    pub(super) contacts: usize,
    /// Shares `omega_j`.
    pub(super) shares: Vec<f64>,
    /// Derivatives of `rho_j / sum_k b_k rho_k` with respect to the forces of its own stage, the sum held: one row a stage.
    pub(super) slopes: Vec<f64>,
    /// `sum_k a_mk omega_k a_kj`, row-major.
    pub(super) squares: Vec<f64>,
    /// Derivatives of `(q_m, v_m, t_m)` through the shares with respect to the contact accelerations: for each stage `j`
    /// and contact one row a stage `m`.
    pub(super) through_shares: Vec<f64>,
    /// Derivative of the free acceleration with respect to time at one stage, along the controls.
    pub(super) by_time: Vec<f64>,
}

impl StageClock {
    /// A clock that contacts slow down.
    pub(super) fn slowed(auxiliary_acceleration: f64) -> Self {
        Self {
            auxiliary_acceleration: Some(auxiliary_acceleration),
            ..Self::default()
        }
    }

    /// Whether contacts slow the clock down in the present mode.
    pub(super) fn is_slowed(&self) -> bool {
        self.auxiliary_acceleration.is_some() && self.contacts > 0
    }

    /// Changes the number of contacts.
    pub(super) fn set_mode(&mut self, stages: usize, contacts: usize) {
        self.contacts = contacts;
        self.shares.clear();
        self.shares.resize(stages, 1.0);
        self.slopes.resize(stages * contacts, 0.0);
    }

    /// Raises the acceleration of the auxiliary dynamics where contact accelerations of the sum `force` ask for it; true if
    /// they do. It scales numerical time, and nothing else.
    pub(super) fn adapt(&mut self, force: f64) -> bool {
        let allowed = |acceleration: f64, speed: f64| acceleration * (1.0 / speed - 1.0);
        let Some(acceleration) = &mut self.auxiliary_acceleration else {
            return false;
        };
        let raises = force.is_finite() && force > allowed(*acceleration, LEAST_SPEED);
        if raises {
            *acceleration = force / allowed(1.0, RAISED_SPEED);
        }
        raises
    }

    /// Share of the physical length that has passed at stage `m`.
    pub(super) fn passed(&self, tableau: &ButcherTableau, m: usize) -> f64 {
        if self.is_slowed() {
            let shares = self.shares.iter().enumerate();
            shares.map(|(j, share)| tableau.a(m, j) * share).sum()
        } else {
            tableau.c()[m]
        }
    }

    /// What stage `j` counts for beside its weight.
    pub(super) fn share(&self, j: usize) -> f64 {
        if self.is_slowed() {
            self.shares[j]
        } else {
            1.0
        }
    }

    /// Dense output weights where the clock has passed the share `theta` of the element: `weights`, those at `theta`, in
    /// physical time, else those at the root of `sum_j b_j(x) omega_j = theta` by Newton's method, which are written to
    /// `placed`.
    pub(super) fn weights_at<'w>(
        &self,
        tableau: &ButcherTableau,
        theta: f64,
        weights: &'w [f64],
        placed: &'w mut [f64],
    ) -> &'w [f64] {
        if !self.is_slowed() {
            return weights;
        }
        let sum =
            |weights: &[f64]| -> f64 { weights.iter().zip(&self.shares).map(|(w, s)| w * s).sum() };
        placed.copy_from_slice(weights);
        let mut values = [0.0; ButcherTableau::MAX_STAGES];
        let values = &mut values[..weights.len()];
        let mut place = theta;
        for _ in 0..MAX_ITERATIONS {
            let ahead = sum(placed) - theta;
            tableau.lagrange_values(place, values);
            let speed = sum(values);
            if ahead.abs() <= 4.0 * f64::EPSILON || speed <= 0.0 {
                break;
            }
            place -= ahead / speed;
            tableau.dense_weights(place, placed);
        }
        placed
    }
}
