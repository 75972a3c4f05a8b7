//! Joints: what is declared of them, and their functions.

use super::builder::{Builder, pattern};
use super::declared::inferred;
use crate::declaration::{JointDeclaration, JointsDeclaration, list, text};
use crate::derive::JointEquations;

/// Kernels of all joints of a scene, by their index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joints {
    /// Kernels of values, Jacobian and weighted Hessian of the positions of all equations, 0 of those of velocities, and then their velocities.
    pub functions: (usize, usize, usize),
    /// Kernel of the forces of all equations without those of contacts; without one, they are the rest of the solution of the
    /// system of motion, with the other sign.
    pub forces: Option<usize>,
}

pub(super) fn joints(
    builder: &mut Builder<'_>,
    derived: &JointEquations,
) -> (JointsDeclaration, Joints) {
    let declared = JointsDeclaration {
        list: list(builder.scene.joints.iter().map(|joint| JointDeclaration {
            name: text(&joint.name.text),
            unit: inferred(joint.unit),
            documentation: text(&joint.documentation),
            rows: joint.rows.len(),
            holonomic: joint.holonomic,
        })),
        jacobian: pattern(&derived.jacobian),
        hessian: pattern(&derived.hessian),
    };
    let forces = derived.forces.as_ref();
    let kernels = Joints {
        functions: (
            builder.kernel("joints", &derived.values),
            builder.kernel("joints_jacobian", &derived.jacobian.values),
            builder.kernel("joints_hessian", &derived.hessian.values),
        ),
        forces: forces.map(|forces| builder.kernel("joint_forces", forces)),
    };
    (declared, kernels)
}
