//! What a scene declares, as static data: names, units, patterns, operation counts.
//!
//! Solvers read it as `hangtime::model::Declaration`; `Model` is their trait there.

mod epigraph;
mod experiment;
mod given;
mod picture;

pub use epigraph::{Epigraph, Over};
pub use experiment::{Experiment, Measured, MeasuredQuantity};
pub use given::{Given, Held};
pub use picture::{Picture, Shape};

/// Everything about a scene that does not depend on parameter values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Declaration {
    /// Name of the scene's type, as written.
    pub name: &'static str,
    /// Documentation of the scene, as written.
    pub documentation: &'static str,
    /// Parameters in order of declaration.
    pub parameters: &'static [ParameterDeclaration],
    /// Coordinates in order of declaration, and behind them one for each state; their number is `n_q`.
    pub coordinates: &'static [VariableDeclaration],
    /// Controls in order of declaration; their number is `n_u`.
    pub controls: &'static [VariableDeclaration],
    /// States of first order in order of declaration: the velocities of the last coordinates, which have unit mass and which no
    /// function reads.
    pub states: &'static [VariableDeclaration],
    /// Contacts in order of declaration; their number is `n_c`.
    pub contacts: &'static [ContactDeclaration],
    /// Joints, if there are any.
    pub joints: Option<JointsDeclaration>,
    /// Whether the physical time is the last component of the input vector.
    pub explicit_time: bool,
    /// Pattern of the Jacobian of the free acceleration.
    pub free_jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of the weighted free acceleration.
    pub free_hessian: SparsityPattern,
    /// What the scene declares for optimal control, if it declares anything.
    pub optimal_control: Option<OptimalControlDeclaration>,
    /// The emitted kernels with their operation counts.
    pub kernels: &'static [Kernel],
    /// The derived equations, as a person would write them.
    pub equations: &'static [Equation],
}

impl Declaration {
    /// Length of the input vector `x = (q, v, u)`, plus one with explicit time.
    #[must_use]
    pub const fn inputs(&self) -> usize {
        2 * self.coordinates.len() + self.controls.len() + self.explicit_time as usize
    }

    /// Number of coordinates of the mechanism; those behind them belong to the [`states`](Self::states).
    #[must_use]
    pub const fn mechanical(&self) -> usize {
        self.coordinates.len() - self.states.len()
    }

    /// The state of first order that this velocity is, if it is one.
    #[must_use]
    pub fn state(&self, velocity: usize) -> Option<&'static VariableDeclaration> {
        self.states.get(velocity.checked_sub(self.mechanical())?)
    }

    /// Length of what path functions read.
    #[must_use]
    pub const fn path_inputs(&self) -> usize {
        match self.optimal_control {
            Some(task) if task.contacts.path => self.impact_inputs(),
            _ => self.inputs(),
        }
    }

    /// Length of what terminal functions read.
    #[must_use]
    pub const fn terminal_inputs(&self) -> usize {
        let plain = 2 * self.coordinates.len() + 1;
        match self.optimal_control {
            Some(task) if task.contacts.terminal => {
                plain + task.contacts.sums + 2 * self.contacts.len()
            }
            Some(task) => plain + task.contacts.sums,
            None => plain,
        }
    }

    /// Length of what impact functions read.
    #[must_use]
    pub const fn impact_inputs(&self) -> usize {
        self.inputs() + 2 * self.contacts.len()
    }
}

/// A number that can be changed at run time.
#[derive(Debug, Clone, Copy, PartialEq)]
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

/// A generalized coordinate, a control input, or a quantity that is recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VariableDeclaration {
    /// Name, as written.
    pub name: &'static str,
    /// Unit, as written; empty if dimensionless or undeclared.
    pub unit: &'static str,
    /// Documentation, as written.
    pub documentation: &'static str,
}

/// A unilateral contact: an impact surface and its law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactDeclaration {
    /// Name of the surface, as written.
    pub name: &'static str,
    /// Unit of the gap.
    pub unit: &'static str,
    /// What happens at an impact.
    pub law: ImpactLaw,
    /// Coulomb friction, if the scene declares it.
    pub friction: Option<FrictionDeclaration>,
    /// Whether this is dry friction without a surface: the contact always touches, its normal force is the declared
    /// bound, and its coefficient of friction is 1. Such contacts stand behind all others.
    pub dry: bool,
    /// Of dry friction: what its bound follows, each times what `Model::loads` says: normal forces of surfaces
    /// (indices of contacts), and friction forces, counted behind the normal ones of all contacts. Forces of joints contain both.
    pub loads: &'static [usize],
    /// Of a switch of what acts, which is [`dry`](Self::dry): how the motion meets the zeros of its function.
    pub switch: Option<Switching>,
    /// Whether the scene declares its own impulse direction.
    pub custom_direction: bool,
    /// Coordinates (indices) that are rigid under the contact force.
    pub held: &'static [usize],
    /// Whether contacts that touch are struck one after the other: this one takes part in an impact only where it approaches, as if
    /// there were a gap too small to be seen; at once with all others that touch otherwise (Moreau's law).
    pub sequence: bool,
    /// Other contacts (indices) of the same edge, whose gaps are the pieces of a `max`: this one acts only where its gap
    /// is the largest of theirs. Empty for a surface without edges.
    pub alternatives: &'static [usize],
    /// Pattern of the Jacobian of `(g, v_n, d)`: `2 + n_q` rows.
    pub jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of the weighted `(g, v_n, d)`.
    pub hessian: SparsityPattern,
    /// Documentation, as written.
    pub documentation: &'static str,
}

/// All joints of a scene: equations that hold throughout the motion, `g(q, t) = 0` with the rate `w = G(q, t) v - b(q, t)`,
/// or `w = 0` alone.
///
/// The equations of motion are `M v' = f + G' lambda`, and `Model::joint_forces` gives
/// `lambda` where nothing is in contact. Accelerations of a model and directions of its contacts are those of the system in
/// which joints hold, so that `G v' = b' - G' v` along every motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointsDeclaration {
    /// In order of declaration.
    pub list: &'static [JointDeclaration],
    /// Pattern of the Jacobian of `(g, w)` by the input vector: twice as many rows as there are equations, those of `g` first,
    /// which are empty for joints of velocities.
    pub jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of the weighted `(g, w)`.
    pub hessian: SparsityPattern,
}

/// One joint.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    pub fn equations(&self) -> impl Iterator<Item = (&'static JointDeclaration, usize)> + use<> {
        self.list
            .iter()
            .flat_map(|joint| (0..joint.rows).map(move |row| (joint, row)))
    }
}

impl JointDeclaration {
    /// The name of one of its equations, for people.
    #[must_use]
    pub fn equation(&self, row: usize) -> String {
        match self.rows {
            1 => format!("`{}`", self.name),
            _ => format!("`{}.{}`", self.name, row + 1),
        }
    }
}

/// What happens at an impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImpactLaw {
    /// No restitution: the normal velocity after the impact is zero.
    Inelastic,
    /// Newton's law, `v_n+ = -e v_n-` with `e` from `Model::restitution`.
    Restitution,
}

/// A switch: what acts contains the sign `s` of a function `c` of the motion, `f = f_0 + a s` with `|s| <= 1` and `s = sign c` unless
/// `c = 0` (Filippov). It is dry friction with the sliding velocity `-c`, the direction `M^-1 a / D`, the normal acceleration
/// `D > 0` and the coefficient 1, so that its friction force is `s`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Switching {
    /// The sign may change the rate of `c`: the motion crosses `c = 0`, or slides along it with the `s` that holds `c' = 0`.
    Slides,
    /// The sign does not change the rate of `c` where `c = 0`, and the motion passes; `D` is 1.
    Passes,
    /// Nothing acts by the sign: where `c` comes to be positive, velocities are set, see `Model::reset`.
    Resets,
}

impl Switching {
    /// Whether the function is only passed, and never held at zero.
    #[must_use]
    pub const fn passes(self) -> bool {
        !matches!(self, Self::Slides)
    }
}

/// Coulomb friction of a contact, in the plane or in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionDeclaration {
    /// Pattern of the Jacobian of `(v_t, e)`: `1 + n_q` rows.
    pub jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of the weighted `(v_t, e)`.
    pub hessian: SparsityPattern,
    /// Whether sliding has a coefficient of its own, `Model::kinetic_friction`.
    pub kinetic: bool,
    /// Whether the friction direction carries a factor that changes with the sliding velocity or the place,
    /// `Model::friction_share`.
    pub share: bool,
    /// In space, where a contact slides along two directions: the pattern of the Jacobian of the second one, as
    /// [`jacobian`](Self::jacobian) is of the first. The sliding velocities are perpendicular to each other, and Coulomb's law is
    /// that of the cone `|(s_1, s_2)| <= mu r`.
    pub across: Option<SparsityPattern>,
}

/// Objective, path constraints, terminal conditions and free initial values.
///
/// The *path functions* are the running cost (if there is one) followed by the path constraints; they
/// read the input vector `x` of the model. The *terminal functions* are the final cost (if there is
/// one) followed by the terminal conditions; they read `z = (q, v, T)` with the final time `T`. Either may read
/// [`contacts`](Self::contacts) besides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OptimalControlDeclaration {
    /// Whether the first path function is a running cost, to be integrated over physical time.
    pub running_cost: bool,
    /// Whether the first terminal function is a final cost.
    pub final_cost: bool,
    /// Path constraints, in the order of their functions.
    pub constraints: &'static [ConstraintDeclaration],
    /// Terminal conditions, in the order of their functions.
    pub goals: &'static [ConstraintDeclaration],
    /// Whether the final time is to be found: it occurs in the final cost or in a terminal condition.
    pub free_time: bool,
    /// Initial values that are to be found: indices into `(q, v)`, increasing.
    pub free_start: &'static [usize],
    /// Pattern of the Jacobian of the path functions with respect to `x`.
    pub path_jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of the weighted path functions.
    pub path_hessian: SparsityPattern,
    /// Pattern of the Jacobian of the terminal functions with respect to `z`.
    pub terminal_jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of the weighted terminal functions.
    pub terminal_hessian: SparsityPattern,
    /// What the functions read of contacts.
    pub contacts: ContactTerms,
}

/// What the functions of optimal control read of contacts: `(r, s)`, what all contacts provide along their normals, and
/// then along their sliding velocities; 0 where they are open. Forces are `r_i / D_i` and `s_i / D_i` of accelerations,
/// impulses the same of the velocities that an impact provides.
///
/// The *impact functions* are what is added up over all impacts, followed by conditions on impacts; they read
/// `(x, r, s)` with those velocities, and no velocities or controls of `x`. Behind them stand the values that conditions set where they come
/// true, which read coordinates, velocities and the time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactTerms {
    /// Whether path functions read `(x, r, s)` instead of `x`.
    pub path: bool,
    /// Whether terminal functions read `(r, s)` at the end of the motion, behind all else.
    pub terminal: bool,
    /// Number of sums over impacts; terminal functions read them behind `(q, v, T)`.
    pub sums: usize,
    /// Conditions on each impact of a contact that they read, in the order of their functions.
    pub constraints: &'static [ConstraintDeclaration],
    /// What conditions that come true set, [`Switching::Resets`], in the order of their functions: the contact that each is, and the
    /// index of the velocity.
    pub resets: &'static [(usize, usize)],
    /// Pattern of the Jacobian of the impact functions.
    pub impact_jacobian: SparsityPattern,
    /// Pattern (lower triangle) of the Hessian of the weighted impact functions.
    pub impact_hessian: SparsityPattern,
}

impl ContactTerms {
    /// Functions that read nothing of contacts.
    pub const NONE: Self = Self {
        path: false,
        terminal: false,
        sums: 0,
        constraints: &[],
        resets: &[],
        impact_jacobian: SparsityPattern::EMPTY,
        impact_hessian: SparsityPattern::EMPTY,
    };

    /// Number of impact functions.
    #[must_use]
    pub const fn impact_functions(&self) -> usize {
        self.of_impacts() + self.resets.len()
    }

    /// Number of those that impacts have: all but what conditions set.
    #[must_use]
    pub const fn of_impacts(&self) -> usize {
        self.sums + self.constraints.len()
    }

    /// Whether anything is read.
    #[must_use]
    pub const fn any(&self) -> bool {
        self.path || self.terminal || self.of_impacts() > 0
    }
}

impl OptimalControlDeclaration {
    /// Number of path functions.
    #[must_use]
    pub const fn path_functions(&self) -> usize {
        self.running_cost as usize + self.constraints.len()
    }

    /// Number of terminal functions.
    #[must_use]
    pub const fn terminal_functions(&self) -> usize {
        self.final_cost as usize + self.goals.len()
    }
}

/// A constraint of the optimal control problem, on one scalar function `c`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstraintDeclaration {
    /// Its name, or the condition as written.
    pub name: &'static str,
    /// Unit of `c`.
    pub unit: &'static str,
    /// Whether `c = 0` is asked for; `c >= 0` otherwise.
    pub equality: bool,
    /// Documentation, as written.
    pub documentation: &'static str,
}

/// Positions of the structural nonzeros of a matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparsityPattern {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// (row, column) of each nonzero, in the order of the values, each position once.
    pub entries: &'static [(u32, u32)],
}

impl SparsityPattern {
    /// That of a matrix without rows and columns.
    pub const EMPTY: Self = Self {
        rows: 0,
        columns: 0,
        entries: &[],
    };

    /// Whether a row depends on a column from `first` on.
    #[must_use]
    pub fn reads(&self, row: usize, first: usize) -> bool {
        let mut entries = self.entries.iter();
        entries.any(|&(r, column)| r as usize == row && column as usize >= first)
    }
}

/// One emitted function and its cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel {
    /// Name of the function.
    pub name: &'static str,
    /// Number of arithmetic operations and elementary function calls.
    pub operations: usize,
    /// Number of values it writes.
    pub outputs: usize,
}

/// One derived equation `left = right` in readable form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equation {
    /// Left-hand side.
    pub left: &'static str,
    /// Right-hand side.
    pub right: &'static str,
}

/// A text that lives as long as the program, as declarations do: solvers and results keep names of them.
pub(crate) fn text(text: &str) -> &'static str {
    text.to_owned().leak()
}

/// A list that lives as long.
pub(crate) fn list<T>(items: impl IntoIterator<Item = T>) -> &'static [T] {
    items.into_iter().collect::<Vec<T>>().leak()
}
