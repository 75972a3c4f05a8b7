//! Joints: what is declared of them, and their functions.

use super::builder::{Builder, Pattern};
use super::declared::{inferred, text};
use crate::derive::JointEquations;

/// All joints of a scene. Kernels are named by their index.
#[derive(Debug, Clone, PartialEq)]
pub struct Joints {
    /// In order of declaration.
    pub list: Vec<Joint>,
    /// Kernel of the positions of all equations, 0 of those of velocities, and then of their velocities.
    pub values: usize,
    /// Kernel of their Jacobian by the inputs.
    pub jacobian: usize,
    /// Pattern of that.
    pub pattern: Pattern,
    /// Kernel of the Hessian (lower triangle) of the values weighted by multipliers.
    pub hessian: usize,
    /// Pattern of that.
    pub hessian_pattern: Pattern,
    /// Kernel of the forces of all equations without those of contacts; without one, they are the rest of the solution of the
    /// system of motion, with the other sign.
    pub forces: Option<usize>,
}

/// One joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, as written.
    pub name: String,
    /// Unit of its positions, or of its velocities times a second; empty for a pure number.
    pub unit: String,
    /// Documentation, as written.
    pub documentation: String,
    /// Number of its equations.
    pub rows: usize,
    /// Whether they are equations between positions.
    pub holonomic: bool,
}

impl Joints {
    /// Number of the equations of all joints.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.list.iter().map(|joint| joint.rows).sum()
    }
}

pub(super) fn joints(builder: &mut Builder<'_>, derived: &JointEquations) -> Joints {
    let declared = builder.scene.joints.iter();
    let list = declared.map(|joint| Joint {
        name: joint.name.text.clone(),
        unit: inferred(joint.unit),
        documentation: text(&joint.documentation),
        rows: joint.rows.len(),
        holonomic: joint.holonomic,
    });
    let list = list.collect();
    let forces = derived.forces.as_ref();
    Joints {
        list,
        values: builder.kernel("joints", &derived.values),
        jacobian: builder.kernel("joints_jacobian", &derived.jacobian.values),
        pattern: Pattern::of(&derived.jacobian),
        hessian: builder.kernel("joints_hessian", &derived.hessian.values),
        hessian_pattern: Pattern::of(&derived.hessian),
        forces: forces.map(|forces| builder.kernel("joint_forces", forces)),
    }
}
