//! The functions of one contact.

use super::builder::{Builder, Pattern, Vectors};
use super::declared::{inferred, text};
use crate::derive::{ContactEquations, Directed, Explicit, FrictionEquations, InverseInertia};
use crate::graph::Sym;
use crate::scene;

// Many fields: what a declaration says of a contact, and a kernel each of what is derived.
/// A contact: what is declared of it, and its kernels.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// Name of the surface, as written.
    pub name: String,
    /// Unit of the gap; empty for a pure number.
    pub unit: String,
    /// Documentation, as written.
    pub documentation: String,
    /// Whether an impulse direction is declared.
    pub custom_direction: bool,
    /// Coordinates that are rigid under the contact force.
    pub held: Vec<usize>,
    /// Whether it is struck after the contacts that touch together with it instead of at once with them.
    pub sequence: bool,
    /// Contacts that are pieces of the same maximum of gaps; empty for most.
    pub alternatives: Vec<usize>,
    /// Whether it is dry friction without a surface.
    pub dry: bool,
    /// Of dry friction: the contacts whose forces are added to its bound, those of friction counted behind all normal ones, and the kernel of what a unit of each adds to the given
    /// normal acceleration.
    pub loads: Option<(Vec<usize>, usize)>,
    /// Of a switch, which is a dry friction: whether its function is only passed, as it does not change the rate of that.
    pub switch: Option<bool>,
    /// Of a switch that nothing acts by: kernel of the velocities after its function has come to be positive.
    pub reset: Option<usize>,
    /// Kernel of the gap.
    pub gap: usize,
    /// Kernel of what is known at a point, as far as it is formulas.
    pub point: usize,
    /// Whether the inverse inertia along the normal comes from the system of motion.
    pub inertia_from_motion: bool,
    /// The rows gap, normal velocity and direction, with their derivatives; of dry friction the given normal acceleration
    /// between zeros.
    pub rows: Rows,
    /// Kernel of the coefficient of restitution; none for an inelastic contact.
    pub restitution: Option<usize>,
    /// Friction, if it is declared.
    pub friction: Option<Friction>,
}

/// The kernels of the friction of a contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Friction {
    /// Kernel of the coefficient, of that at rest where there are two.
    pub coefficient: usize,
    /// Kernel of the coefficient of sliding, if it is another one.
    pub kinetic: Option<usize>,
    /// Kernel of the factor that the direction carries, if it carries one.
    pub share: Option<usize>,
    /// Kernel of what is known at a point, as far as it is formulas.
    pub tangent: usize,
    /// The rows sliding velocity and direction, with their derivatives.
    pub rows: Rows,
    /// In space the same of the second sliding velocity: kernel of what is known at a point, and rows.
    pub across: Option<(usize, Rows)>,
}

/// Derivatives of some rows: those that are formulas, followed by the solution of a linear system if there is one.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// Kernels of Jacobian and Hessian of the formulas.
    pub kernels: [usize; 2],
    /// Pattern of the Jacobian of all rows.
    pub jacobian: Pattern,
    /// Pattern (lower triangle) of the Hessian of all rows.
    pub hessian: Pattern,
    /// The rows behind the formulas.
    pub solved: Option<SolvedRows>,
}

/// Rows that are the first part of the solution of a linear system.
#[derive(Debug, Clone, PartialEq)]
pub struct SolvedRows {
    /// What they are solved for with.
    pub by: Solver,
    /// Number of rows before them.
    pub formulas: usize,
    /// Where each value of the formulas' Hessian is added to the Hessian of all rows.
    pub places: Vec<usize>,
}

/// What a direction is solved for with.
#[derive(Debug, Clone, PartialEq)]
pub enum Solver {
    /// The linear system with this index.
    System(usize),
    /// The inertia of the scene.
    Inertia(Vectors),
}

pub(super) fn contact(
    builder: &mut Builder<'_>,
    declared: &scene::Contact,
    contact: &ContactEquations,
) -> Contact {
    // A piece of a surface has a number behind a point.
    let name = &match declared.switch {
        Some(_) => format!("switching_function_{}", builder.switches() + 1),
        None => declared.name.text.replace('.', "__"),
    };
    let rows = &contact.rows;
    let gap = builder.kernel(&format!("gap_{name}"), &rows.values[..1]);
    let dry = declared.bound.is_some();
    let normal_velocity = if dry { Sym::ZERO } else { rows.values[1] };
    let mut point = vec![rows.values[0], normal_velocity, contact.curvature];
    point.push(match contact.inverse_inertia {
        InverseInertia::Formula(inverse_inertia) => inverse_inertia,
        InverseInertia::Solved => Sym::ZERO,
    });
    point.extend(&contact.normal);
    point.extend(&rows.values[2..]);
    let point = builder.kernel(&format!("contact_{name}"), &point);
    let kernel = format!("contact_{{}}_{name}");
    let solved = contact.direction.as_ref();
    let solved = solved.map(|solved| (format!("direction_{name}"), solved));
    let solves = matches!(contact.inverse_inertia, InverseInertia::Solved);
    Contact {
        name: declared.name.text.clone(),
        unit: inferred(declared.unit),
        documentation: text(&declared.documentation),
        custom_direction: declared.along.is_some(),
        held: declared.held.clone(),
        sequence: declared.sequence,
        alternatives: declared.alternatives.clone(),
        dry,
        loads: (!contact.followed.is_empty()).then(|| {
            let kernel = builder.kernel(&format!("loads_{name}"), &contact.loads);
            (contact.followed.clone(), kernel)
        }),
        switch: declared.switch.as_ref().map(|_| contact.passes),
        reset: reset(builder, name, declared),
        gap,
        point,
        inertia_from_motion: solves && solved.is_none(),
        rows: all_rows(builder, &kernel, rows, solved),
        restitution: declared
            .restitution
            .map(|value| builder.unlisted(&format!("restitution_{name}"), &[value])),
        friction: declared
            .friction
            .as_ref()
            .zip(contact.friction.as_ref())
            .map(|(declared, derived)| {
                let across = contact.across.as_ref();
                let across = across.map(|across| side(builder, name, "across", across));
                friction(builder, name, (declared, across), derived)
            }),
    }
}

fn reset(builder: &mut Builder<'_>, name: &str, declared: &scene::Contact) -> Option<usize> {
    let velocities = declared.velocities_set(builder.scene.coordinates.len())?;
    Some(builder.kernel(&format!("reset_{name}"), &velocities))
}

fn friction(
    builder: &mut Builder<'_>,
    name: &str,
    (declared, across): (&scene::Friction, Option<(usize, Rows)>),
    friction: &FrictionEquations,
) -> Friction {
    let (tangent, rows) = side(builder, name, "tangent", friction);
    Friction {
        coefficient: builder.unlisted(&format!("friction_{name}"), &[declared.coefficient]),
        kinetic: declared
            .kinetic
            .map(|value| builder.unlisted(&format!("kinetic_friction_{name}"), &[value])),
        share: declared
            .share
            .map(|value| builder.kernel(&format!("friction_share_{name}"), &[value])),
        tangent,
        rows,
        across,
    }
}

/// The kernels of a tangential side, which are called `what`: what is known at a point, and the rows.
fn side(
    builder: &mut Builder<'_>,
    name: &str,
    what: &str,
    friction: &FrictionEquations,
) -> (usize, Rows) {
    let rows = &friction.rows;
    let mut point = vec![rows.values[0], friction.curvature];
    point.extend(&friction.tangent);
    point.extend(&rows.values[1..]);
    let tangent = builder.kernel(&format!("{what}_{name}"), &point);
    let kernel = format!("{what}_{{}}_{name}");
    let direction = match what {
        "tangent" => "friction_direction",
        _ => "across_direction",
    };
    let solved = friction.direction.as_ref();
    let solved = solved.map(|solved| (format!("{direction}_{name}"), solved));
    (tangent, all_rows(builder, &kernel, rows, solved))
}

/// Rows that are formulas, followed by the solution of a linear system with this name if there is one. `kernel` is the
/// name of the kernels, `{}` in it what they compute.
fn all_rows(
    builder: &mut Builder<'_>,
    kernel: &str,
    rows: &Explicit,
    solved: Option<(String, &Directed)>,
) -> Rows {
    let [jacobian, hessian] = ["jacobian", "hessian"].map(|what| kernel.replace("{}", what));
    let jacobian = builder.kernel(&jacobian, &rows.jacobian.values);
    let Some((name, solved)) = solved else {
        return Rows {
            kernels: [jacobian, builder.kernel(&hessian, &rows.hessian.values)],
            jacobian: Pattern::of(&rows.jacobian),
            hessian: Pattern::of(&rows.hessian),
            solved: None,
        };
    };
    let formulas = rows.values.len();
    let n = builder.scene.coordinates.len();
    let (by, solved_entries, mut hessian_entries) = solver(builder, &name, solved);
    let mut jacobian_entries = rows.jacobian.entries.clone();
    let below = solved_entries.iter();
    jacobian_entries.extend(below.map(|&(row, column)| (row + formulas, column)));
    hessian_entries.extend(&rows.hessian.entries);
    hessian_entries.sort_unstable();
    hessian_entries.dedup();
    let places = rows.hessian.entries.iter();
    let places = places.filter_map(|entry| hessian_entries.binary_search(entry).ok());
    Rows {
        solved: Some(SolvedRows {
            by,
            formulas,
            places: places.collect(),
        }),
        kernels: [jacobian, builder.kernel(&hessian, &rows.hessian.values)],
        jacobian: Pattern {
            rows: formulas + n,
            columns: builder.inputs,
            entries: jacobian_entries,
        },
        hessian: Pattern {
            rows: builder.inputs,
            columns: builder.inputs,
            entries: hessian_entries,
        },
    }
}

/// Rows and columns of the entries of a pattern.
type Places = Vec<(usize, usize)>;

/// What a direction with this name is solved for with, and the patterns of its Jacobian and its Hessian.
fn solver(builder: &mut Builder<'_>, name: &str, solved: &Directed) -> (Solver, Places, Places) {
    let n = builder.scene.coordinates.len();
    match (solved, builder.inertia) {
        (Directed::System(system), _) => (
            Solver::System(builder.system(name, system)),
            system.jacobian_pattern(n),
            system.hessian_pattern(),
        ),
        (Directed::Columns(columns), inertia) => {
            let patterns = inertia.map(|inertia| {
                let jacobian = inertia.jacobian_pattern(columns, n);
                (jacobian, inertia.hessian_pattern(columns))
            });
            let (jacobian, hessian) = patterns.unwrap_or_default();
            let vectors = builder.vectors(name, columns);
            (Solver::Inertia(vectors), jacobian, hessian)
        }
    }
}
