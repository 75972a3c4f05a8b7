//! What a scene declares, as static data: names, units, patterns, operation counts.

/// Everything about a scene that does not depend on parameter values.
#[derive(Debug, Clone, Copy)]
pub struct Declaration {
    /// Name of the scene's type, as written.
    pub name: &'static str,
    /// Documentation of the scene, as written.
    pub documentation: &'static str,
    /// Parameters in order of declaration.
    pub parameters: &'static [ParameterDeclaration],
    /// Coordinates in order of declaration; their number is `n_q`.
    pub coordinates: &'static [CoordinateDeclaration],
    /// Controls in order of declaration; their number is `n_u`.
    pub controls: &'static [ControlDeclaration],
    /// Contacts in order of declaration; their number is `n_c`.
    pub contacts: &'static [ContactDeclaration],
    /// Whether the physical time is the last component of the input vector.
    pub explicit_time: bool,
    /// Pattern of the Jacobian of the free acceleration.
    pub free_jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of the weighted free acceleration.
    pub free_hessian: SparsityPattern,
    /// The emitted kernels with their operation counts.
    pub kernels: &'static [Kernel],
    /// The derived equations, as a person would write them.
    pub equations: &'static [Equation],
    /// Time that the derivation took at compile time \[s\].
    pub derivation_seconds: f64,
    /// Start of the expansion at compile time \[s since 1970\].
    pub expanded_at: f64,
}

impl Declaration {
    /// Length of the input vector `x = (q, v, u)`, plus one with explicit time.
    #[must_use]
    pub const fn inputs(&self) -> usize {
        2 * self.coordinates.len() + self.controls.len() + self.explicit_time as usize
    }
}

/// A number that can be changed at run time.
#[derive(Debug, Clone, Copy)]
pub struct ParameterDeclaration {
    /// Name, as written.
    pub name: &'static str,
    /// Unit, as written; empty if dimensionless or undeclared.
    pub unit: &'static str,
    /// Default value in that unit.
    pub default: f64,
    /// Whether the scene loses its meaning for values that are not above zero (masses, lengths of
    /// inertia): a mass is any parameter in kg or kg m^2.
    pub positive: bool,
    /// Documentation, as written.
    pub documentation: &'static str,
}

/// A generalized coordinate.
#[derive(Debug, Clone, Copy)]
pub struct CoordinateDeclaration {
    /// Name, as written.
    pub name: &'static str,
    /// Unit, as written; empty if dimensionless or undeclared.
    pub unit: &'static str,
    /// Documentation, as written.
    pub documentation: &'static str,
}

/// A control input.
#[derive(Debug, Clone, Copy)]
pub struct ControlDeclaration {
    /// Name, as written.
    pub name: &'static str,
    /// Unit, as written; empty if dimensionless or undeclared.
    pub unit: &'static str,
    /// Documentation, as written.
    pub documentation: &'static str,
}

/// A unilateral contact: an impact surface and its law.
#[derive(Debug, Clone, Copy)]
pub struct ContactDeclaration {
    /// Name of the surface, as written.
    pub name: &'static str,
    /// Unit of the gap.
    pub unit: &'static str,
    /// What happens at an impact.
    pub law: ImpactLaw,
    /// Whether the scene declares its own impulse direction.
    pub custom_direction: bool,
    /// Pattern of the Jacobian of `(g, v_n, d)`: `2 + n_q` rows.
    pub jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of the weighted `(g, v_n, d)`.
    pub hessian: SparsityPattern,
    /// Documentation, as written.
    pub documentation: &'static str,
}

/// What happens at an impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ImpactLaw {
    /// No restitution: the normal velocity after the impact is zero.
    Inelastic,
}

/// Positions of the structural nonzeros of a matrix.
#[derive(Debug, Clone, Copy)]
pub struct SparsityPattern {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// (row, column) of each nonzero, in the order of the values, each position once.
    pub entries: &'static [(u32, u32)],
}

/// One emitted function and its cost.
#[derive(Debug, Clone, Copy)]
pub struct Kernel {
    /// Name of the function.
    pub name: &'static str,
    /// Number of arithmetic operations and elementary function calls.
    pub operations: usize,
    /// Number of values it writes.
    pub outputs: usize,
}

/// One derived equation `left = right` in readable form.
#[derive(Debug, Clone, Copy)]
pub struct Equation {
    /// Left-hand side.
    pub left: &'static str,
    /// Right-hand side.
    pub right: &'static str,
}
