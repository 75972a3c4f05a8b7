//! What a scene declares of its joints.

use super::SparsityPattern;

/// All joints of a scene: equations that hold throughout the motion, `g(q, t) = 0` with the rate `w = G(q, t) v - b(q, t)`,
/// or `w = 0` alone.
///
/// The equations of motion are `M v' = f + G' lambda`, and [`Model::joint_forces`](super::Model::joint_forces) gives
/// `lambda` where nothing is in contact. Accelerations of a model and directions of its contacts are those of the system in
/// which joints hold, so that `G v' = b' - G' v` along every motion.
#[derive(Debug, Clone, Copy)]
pub struct JointsDeclaration {
    /// In order of declaration.
    pub list: &'static [JointDeclaration],
    /// Pattern of the Jacobian of `(g, w)` by the input vector: twice as many rows as there are equations, those of `g` first,
    /// which are empty for joints of velocities.
    pub jacobian: SparsityPattern,
}

/// One joint.
#[derive(Debug, Clone, Copy)]
pub struct JointDeclaration {
    /// Name, as written.
    pub name: &'static str,
    /// Unit of `g`, or of `w` times a second; empty for a pure number.
    pub unit: &'static str,
    /// Number of its equations.
    pub rows: usize,
    /// Whether they are equations between positions; between velocities otherwise.
    pub holonomic: bool,
    /// Documentation, as written.
    pub documentation: &'static str,
}

impl JointsDeclaration {
    /// Number of equations of all joints.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.list.iter().map(|joint| joint.rows).sum()
    }

    /// The joint of each equation, and its number in it.
    pub(crate) fn equations(
        &self,
    ) -> impl Iterator<Item = (&'static JointDeclaration, usize)> + use<> {
        self.list
            .iter()
            .flat_map(|joint| (0..joint.rows).map(move |row| (joint, row)))
    }
}

impl JointDeclaration {
    /// The name of one of its equations, for people.
    pub(crate) fn equation(&self, row: usize) -> String {
        match self.rows {
            1 => format!("`{}`", self.name),
            _ => format!("`{}.{}`", self.name, row + 1),
        }
    }
}

/// Number of equations of all joints of a scene.
pub(crate) fn joint_rows(model: &dyn super::Model) -> usize {
    model.declaration().joints.map_or(0, |joints| joints.rows())
}
