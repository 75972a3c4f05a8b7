//! What counts as zero at a contact: shares of the sizes of its own functions, so that it depends neither on where
//! a scene is nor on the units in which it is written.

use crate::model::rounding::ROUNDINGS;
use crate::model::{contact_point, tangent_point};

/// Gaps below this share of the range of values that the gap has had are closed: contacts that close at one
/// instant do so up to the errors of integration.
const CLOSED_GAP: f64 = 1e-12;
/// Velocities below this share of the largest terms they have been sums of are zero.
const ZERO_VELOCITY: f64 = 1e-12;
/// Normal velocities below this multiple of what rounding of the place leaves of them are zero.
const TURNS: f64 = 4.0;
/// A flight lower than this share of the range of the gap is none. It ends the geometric sequence of impacts of,
/// for example, a rocking block.
const LOWEST_FLIGHT: f64 = 1e-14;
/// Sizes at one contact, measured along the motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactScale {
    /// Rounding error of the gap where it was last measured.
    rounding: f64,
    /// Lowest and highest gap so far.
    lowest: f64,
    highest: f64,
    /// Largest sum of the terms of the normal velocity so far.
    normal_velocity: f64,
    /// Largest sum of the terms of the sliding velocity so far.
    sliding_velocity: f64,
    /// Rounding error that the place leaves in the normal velocity.
    turn: f64,
    /// Longest moment so far.
    longest: f64,
}

/// State and acceleration at an instant, and a time over which the motion is smooth.
#[derive(Clone, Copy)]
pub(super) struct Instant<'a> {
    q: &'a [f64],
    v: &'a [f64],
    a: &'a [f64],
    moment: f64,
    /// Time \[s\], 0 where nothing depends on it.
    time: f64,
}

impl<'a> Instant<'a> {
    /// The state `(q, v)` with the acceleration `a`.
    pub(super) fn new(state: &'a [f64], a: &'a [f64], moment: f64) -> Self {
        let (q, v) = state.split_at(a.len());
        Self {
            q,
            v,
            a,
            moment,
            time: 0.0,
        }
    }

    /// These states at a time on which gaps depend.
    pub(super) fn at(self, time: f64) -> Self {
        Self { time, ..self }
    }

    /// What the ground of a contact with this `normal` and normal velocity has moved by now, by its present velocity: rounding of
    /// the time is a share of it.
    fn way_of_ground(&self, normal: &[f64], velocity: f64) -> f64 {
        if self.time == 0.0 {
            return 0.0;
        }
        let own: f64 = normal.iter().zip(self.v).map(|(n, v)| n * v).sum();
        (velocity - own).abs() * self.time
    }

    /// `sum_k |covector_k| (|v_k| + moment |a_k|)`: size of the terms of a velocity.
    fn velocity_terms(&self, covector: &[f64]) -> f64 {
        let terms = self.v.iter().zip(self.a);
        covector
            .iter()
            .zip(terms)
            .map(|(c, (v, a))| c.abs() * (v.abs() + self.moment * a.abs()))
            .sum()
    }

    /// `sum_k |covector_k a_k|`: size of the terms of an acceleration.
    fn acceleration_terms(&self, covector: &[f64]) -> f64 {
        let terms = covector.iter().zip(self.a);
        terms.map(|(c, a)| (c * a).abs()).sum()
    }

    /// The coordinate `k` after a share of what it moves in the moment.
    pub(super) fn moved(&self, k: usize, share: f64) -> f64 {
        let speed = self.v[k] + self.moment * self.a[k];
        self.q[k] + share * self.moment * speed
    }
}

impl Default for ContactScale {
    fn default() -> Self {
        Self {
            rounding: 0.0,
            lowest: f64::INFINITY,
            highest: f64::NEG_INFINITY,
            normal_velocity: 0.0,
            sliding_velocity: 0.0,
            turn: 0.0,
            longest: 0.0,
        }
    }
}

impl ContactScale {
    /// Takes note of a contact, laid out as in [`contact_point`], and of its tangential side, laid out as in
    /// [`tangent_point`], with the coefficient of friction, if it has friction.
    pub(super) fn observe(
        &mut self,
        point: &[f64],
        friction: Option<(&[f64], f64)>,
        instant: Instant<'_>,
    ) {
        let gap = point[contact_point::GAP];
        self.longest = self.longest.max(instant.moment);
        self.lowest = self.lowest.min(gap);
        self.highest = self.highest.max(gap);
        let normal = &point[contact_point::NORMAL..][..instant.q.len()];
        let curvature = point[contact_point::CURVATURE].abs();
        let terms = instant.velocity_terms(normal) + instant.moment * curvature;
        self.normal_velocity = self.normal_velocity.max(terms);
        if let Some((tangent, mu)) = friction {
            let along = &tangent[tangent_point::TANGENT..][..instant.q.len()];
            // Ground that moves is a term of its own.
            let sliding = tangent[tangent_point::SLIDING_VELOCITY].abs();
            // Where nothing pulls along the surface, what friction could do there is the measure.
            let slowed = mu * (instant.acceleration_terms(normal) + curvature);
            let terms = instant
                .velocity_terms(along)
                .max(sliding)
                .max(instant.moment * slowed);
            self.sliding_velocity = self.sliding_velocity.max(terms);
        }
        let position: f64 = normal
            .iter()
            .zip(instant.q)
            .map(|(n, q)| (n * q).abs())
            .sum();
        let way = instant.moment * self.normal_velocity;
        let ground = instant.way_of_ground(normal, point[contact_point::NORMAL_VELOCITY]);
        self.rounding = f64::EPSILON * (position + way + ground);
        // The normal turns while the motion covers the rounding error of the coordinates.
        self.turn = if terms > 0.0 {
            curvature * f64::EPSILON * position / terms
        } else {
            0.0
        };
    }

    /// Expects this to be the longest moment, whatever has been so far.
    pub(super) fn expect_moment(&mut self, moment: f64) {
        self.longest = moment;
    }

    /// Takes note of a measured rounding error of the gap; NaN leaves what is known.
    pub(super) fn observe_rounding(&mut self, error: f64) {
        self.rounding = self.rounding.max(error);
    }

    /// Range of the values of the gap so far.
    pub(super) fn range(&self) -> f64 {
        (self.highest - self.lowest).max(0.0)
    }

    /// Below this gap the contact is closed.
    pub(super) fn closed_gap(&self) -> f64 {
        (CLOSED_GAP * self.range()).max(ROUNDINGS * self.rounding)
    }

    /// Flights lower than this are none.
    pub(super) fn lowest_flight(&self) -> f64 {
        (LOWEST_FLIGHT * self.range()).max(self.rounding)
    }

    /// Rounding error of the gap.
    pub(super) fn rounding(&self) -> f64 {
        self.rounding
    }

    /// Below this normal velocity the contact is at rest.
    pub(super) fn zero_normal_velocity(&self) -> f64 {
        (ZERO_VELOCITY * self.normal_velocity).max(TURNS * self.turn)
    }

    /// Accelerations with which those of the contact are compared however small their terms are: they would give its
    /// velocities in the longest moment.
    pub(super) fn acceleration(&self) -> f64 {
        if self.longest > 0.0 {
            self.normal_velocity.max(self.sliding_velocity) / self.longest
        } else {
            0.0
        }
    }

    /// Takes note of the terms of the function of a switch.
    pub(super) fn observe_switch(&mut self, terms: f64) {
        self.sliding_velocity = self.sliding_velocity.max(terms);
    }

    /// Largest terms of the sliding velocity so far.
    pub(super) fn sliding_velocity(&self) -> f64 {
        self.sliding_velocity
    }

    /// Below this sliding velocity the contact does not slide.
    pub(super) fn zero_sliding_velocity(&self) -> f64 {
        ZERO_VELOCITY * self.sliding_velocity
    }
}
