//! Derivatives put onto what joints hold.
//!
//! Accelerations hold the equations of joints up to the error of the motion, and a start that depends on parameters holds them only
//! where it is itself what fulfils them. As the methods do with the motion, each derivative is moved by the least in the metric
//! of the mass matrix, along the columns of `D` ([`crate::joints`]):
//!
//! ```text
//! dq -= D (g_q dq + g_p)        dv -= D (w_q dq + w_v dv + w_p)
//! ```
//!
//! These are the derivatives of Newton's steps where `g = 0` and `w = 0`.

use super::tangent::{Matrix, Tangent, add};
use crate::joints::Joints;
use crate::model::{Model, ParameterDerivatives};

/// The equations of joints with their derivatives.
pub(super) struct JointRows<'a> {
    joints: Joints<'a>,
    by: Matrix,
}

impl<'a> JointRows<'a> {
    /// None for a scene without joints.
    pub(super) fn of(model: &'a dyn Model, columns: usize) -> Option<Self> {
        let rows = model.declaration().joints?.rows();
        Some(Self {
            joints: Joints::of(model)?,
            by: Matrix::zeros(2 * rows, columns),
        })
    }

    /// Evaluates them at `x`; `false` where they depend on each other.
    pub(super) fn evaluate(&mut self, derivatives: &ParameterDerivatives, x: &[f64]) -> bool {
        self.joints.evaluate(x);
        derivatives.joints(x, &mut self.by.values);
        self.joints.direct(x).is_ok()
    }

    /// Moves derivatives of `(q, v)` onto them, where they were evaluated.
    pub(super) fn project(&self, tangent: &mut Tangent) {
        let rows = self.by.values.len() / self.by.columns / 2;
        let n = tangent.layout.n;
        let positions: Vec<usize> = self.joints.positions().collect();
        let all: Vec<usize> = (0..self.joints.count()).collect();
        for (places, first, to) in [(positions, 0, 0), (all, rows, n)] {
            let off = |&place: &usize| tangent.of(self.by.row(first + self.joints.held()[place]));
            let off: Vec<Vec<f64>> = places.iter().map(off).collect();
            for (place, off) in places.iter().zip(&off) {
                let direction = &self.joints.directions()[place * n..(place + 1) * n];
                for (k, component) in direction.iter().enumerate() {
                    add(tangent.all.row_mut(to + k), -component, off);
                }
            }
        }
    }
}
