//! What counts as zero at a contact: shares of the sizes of its own functions, so that it depends neither on where
//! a scene is nor on the units in which it is written. How far and how fast the motion has been says the [`Extent`].

use crate::contact::Extent;
use crate::model::rounding::ROUNDINGS;
use crate::model::{contact_point, tangent_point};
use crate::yardstick;

/// Normal velocities below this multiple of what rounding of the place leaves of them are zero.
const TURNS: f64 = 4.0;
/// A flight lower than this share of the range of the gap is none. It ends the geometric sequence of impacts of,
/// for example, a rocking block.
const LOWEST_FLIGHT: f64 = 1e-14;
/// Sizes at one contact, where the motion is.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ContactScale {
    /// Rounding error of the gap where it was last measured.
    pub(super) rounding: f64,
    /// By how much the way of the motion has changed the gap.
    pub(super) range: f64,
    /// Sum of the terms of the normal velocity.
    pub(super) normal_velocity: f64,
    /// Sum of the terms of the sliding velocity.
    pub(super) sliding_velocity: f64,
    /// Rounding error that the place leaves in the normal velocity.
    turn: f64,
    /// Longest moment so far.
    pub(super) longest: f64,
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

impl ContactScale {
    /// Takes note of a contact, laid out as in [`contact_point`], and of its tangential side, laid out as in
    /// [`tangent_point`], with the coefficient of friction, if it has friction, in a motion of this `extent`.
    pub(super) fn observe(
        &mut self,
        point: &[f64],
        friction: Option<(&[f64], f64)>,
        instant: Instant<'_>,
        extent: &Extent,
    ) {
        self.longest = self.longest.max(instant.moment);
        let normal = &point[contact_point::NORMAL..][..instant.q.len()];
        let curvature = point[contact_point::CURVATURE].abs();
        // What accelerations add in the moment, to a motion from rest as well.
        let moment = instant.moment;
        let pull = instant.acceleration_terms(normal) + curvature;
        let terms = extent.velocities(normal) + moment * pull;
        self.range = extent.ways(normal);
        self.normal_velocity = terms;
        if let Some((tangent, mu)) = friction {
            let along = &tangent[tangent_point::TANGENT..][..instant.q.len()];
            // Ground that moves is a term of its own.
            let sliding = tangent[tangent_point::SLIDING_VELOCITY].abs();
            let pulled = moment * instant.acceleration_terms(along);
            let terms = (extent.velocities(along) + pulled).max(sliding);
            // Where nothing pulls along the surface, what friction could do there is the measure.
            self.sliding_velocity = terms.max(moment * mu * pull);
        }
        let position = extent.places(normal);
        let way = moment * terms;
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

    /// Below this gap the contact is closed.
    pub(super) fn closed_gap(&self) -> f64 {
        (yardstick::ROUNDING * self.range).max(ROUNDINGS * self.rounding)
    }

    /// Flights lower than this are none.
    pub(super) fn lowest_flight(&self) -> f64 {
        (LOWEST_FLIGHT * self.range).max(self.rounding)
    }

    /// Below this normal velocity the contact is at rest.
    pub(super) fn zero_normal_velocity(&self) -> f64 {
        (yardstick::ROUNDING * self.normal_velocity).max(TURNS * self.turn)
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

    /// Below this sliding velocity the contact does not slide.
    pub(super) fn zero_sliding_velocity(&self) -> f64 {
        yardstick::ROUNDING * self.sliding_velocity
    }
}
