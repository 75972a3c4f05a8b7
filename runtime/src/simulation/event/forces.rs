//! The forces of a run at its last evaluation.

use super::dynamics::Dynamics;
use crate::model::{contact_point, friction_share};
use crate::simulation::Residuals;

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

    /// Takes those at the last evaluation, and returns the residuals there.
    pub(super) fn measure(&mut self, dynamics: &Dynamics<'_>) -> Residuals {
        dynamics.forces(&mut self.normal);
        dynamics.friction_forces(&mut self.tangential);
        if let Some(rest) = &dynamics.rest {
            for (&i, part) in rest.contacts.iter().zip(&rest.parts) {
                let force = part * dynamics.friction(i) * dynamics.normal_force(i);
                self.tangential[i] =
                    -dynamics.force(i, force) * friction_share(dynamics.model, i, dynamics.input());
            }
        }
        let mut residuals = Residuals::default();
        for &i in &dynamics.mode.active {
            let point = dynamics.point(i);
            let gap = point[contact_point::GAP].abs();
            residuals.primal = residuals
                .primal
                .max(gap)
                .max(point[contact_point::NORMAL_VELOCITY].abs());
            if dynamics.state(i).is_stuck() {
                residuals.primal = residuals.primal.max(dynamics.sliding_velocity(i).abs());
            }
            let product = gap * dynamics.normal_force(i).abs();
            residuals.complementarity = residuals.complementarity.max(product);
        }
        residuals
    }
}
