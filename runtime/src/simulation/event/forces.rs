//! The forces of a run at its last evaluation.

use super::dynamics::{Dynamics, switching};
use crate::model::{contact_point, friction_share};
use crate::simulation::verdict::Verdict;

/// Forces of all contacts.
pub(super) struct Forces {
    pub(super) normal: Vec<f64>,
    pub(super) tangential: Vec<f64>,
}

impl Forces {
    pub(super) fn new(contacts: usize) -> Self {
        Self {
            normal: vec![0.0; contacts],
            tangential: vec![0.0; contacts],
        }
    }

    /// Takes those at the last evaluation, and measures there what active contacts hold.
    pub(super) fn measure(&mut self, dynamics: &Dynamics<'_>, verdict: &mut Verdict) {
        dynamics.forces(&mut self.normal);
        dynamics.friction_forces(&mut self.tangential);
        if let Some(rest) = &dynamics.rest {
            for (&i, part) in rest.contacts.iter().zip(&rest.parts) {
                let force = part * dynamics.friction(i) * dynamics.normal_force(i);
                self.tangential[i] =
                    -dynamics.force(i, force) * friction_share(dynamics.model, i, dynamics.input());
            }
        }
        for &i in &dynamics.mode.active {
            let point = dynamics.point(i);
            let (gap, velocity) = (
                point[contact_point::GAP],
                point[contact_point::NORMAL_VELOCITY],
            );
            let [range, normal, sliding] = dynamics.held_sizes(i);
            verdict.complements(gap, dynamics.normal_force(i));
            if dynamics.state(i).is_stuck() {
                let sizes = (switching::held_velocity(dynamics, i), sliding);
                let velocity = dynamics.sliding_velocity(i);
                verdict.vanishes(("the sliding velocity", i), velocity, sizes);
            }
            if !dynamics.is_dry(i) {
                let sizes = (dynamics.closed_gap(i), range);
                verdict.vanishes(("the gap", i), gap, sizes);
                let mut zero = dynamics.zero_normal_velocity(i);
                if velocity.abs() > zero {
                    zero = zero.max(dynamics.zero_of_energy(i));
                }
                verdict.vanishes(("the normal velocity", i), velocity, (zero, normal));
            }
        }
    }
}
