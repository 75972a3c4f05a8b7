//! The functions of one contact.

use super::builder::{Builder, Vectors, pattern, places};
use super::declared::inferred;
use crate::declaration::{
    ContactDeclaration, FrictionDeclaration, ImpactLaw, SparsityPattern, Switching, list, text,
};
use crate::derive::{ContactEquations, Directed, Explicit, FrictionEquations, InverseInertia};
use crate::graph::Sym;
use crate::scene;

/// The kernels of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Of dry friction whose bound follows forces: kernel of what a unit of each adds to the given normal acceleration.
    pub loads: Option<usize>,
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
#[derive(Debug, Clone, Copy, PartialEq)]
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rows {
    /// Kernels of Jacobian and Hessian of the formulas.
    pub kernels: (usize, usize),
    /// The rows behind the formulas.
    pub solved: Option<SolvedRows>,
}

/// Rows that are the first part of the solution of a linear system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolvedRows {
    /// What they are solved for with.
    pub by: Solver,
    /// Number of rows before them.
    pub formulas: usize,
    /// Number of nonzeros of the formulas' Jacobian, which stand first.
    pub nonzeros: usize,
    /// Where each value of the formulas' Hessian is added to the Hessian of all rows.
    pub places: &'static [usize],
}

/// What a direction is solved for with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Solver {
    /// The linear system with this index.
    System(usize),
    /// The inertia of the scene.
    Inertia(Vectors),
}

/// What is declared of a contact, and its kernels.
pub(super) fn contact(
    builder: &mut Builder<'_>,
    declared: &scene::Contact,
    contact: &ContactEquations,
) -> (ContactDeclaration, Contact) {
    let name = &called(builder, declared);
    let rows = &contact.rows;
    let gap = builder.kernel(&format!("gap_{name}"), &rows.values[..1]);
    let point = point(builder, name, declared, contact);
    let solved = contact.direction.as_ref();
    let solved = solved.map(|solved| (format!("direction_{name}"), solved));
    let solves = matches!(contact.inverse_inertia, InverseInertia::Solved);
    let inertia_from_motion = solves && solved.is_none();
    let loads = (!contact.followed.is_empty())
        .then(|| builder.kernel(&format!("loads_{name}"), &contact.loads));
    let reset = reset(builder, name, declared);
    let (rows, [jacobian, hessian]) =
        all_rows(builder, &format!("contact_{{}}_{name}"), rows, solved);
    let restitution = restitution(builder, name, declared);
    let across = contact.across.as_ref();
    let both = declared.friction.as_ref().zip(contact.friction.as_ref());
    let friction = both.map(|(declared, derived)| {
        let across = across.map(|across| side(builder, name, "across", across));
        friction(builder, name, (declared, across), derived)
    });
    let kernels = Contact {
        loads,
        reset,
        gap,
        point,
        inertia_from_motion,
        rows,
        restitution,
        friction: friction.map(|(_, kernels)| kernels),
    };
    let switching = declared.switch.as_ref().map(|_| match contact.passes {
        _ if reset.is_some() => Switching::Resets,
        true => Switching::Passes,
        false => Switching::Slides,
    });
    let declaration = ContactDeclaration {
        dry: declared.bound.is_some(),
        loads: list(contact.followed.iter().copied()),
        switch: switching,
        ..surface(
            declared,
            friction.map(|(declared, _)| declared),
            [jacobian, hessian],
        )
    };
    (declaration, kernels)
}

/// What kernels of a contact are called by.
pub(super) fn called(builder: &Builder<'_>, declared: &scene::Contact) -> String {
    match declared.switch {
        Some(_) => format!("switching_function_{}", builder.switches() + 1),
        // A piece of a surface has a number behind a point.
        None => declared.name.text.replace('.', "__"),
    }
}

/// What is declared of a surface whose rows have these patterns of their Jacobian and Hessian.
pub(super) fn surface(
    declared: &scene::Contact,
    friction: Option<FrictionDeclaration>,
    [jacobian, hessian]: [SparsityPattern; 2],
) -> ContactDeclaration {
    ContactDeclaration {
        name: text(&declared.name.text),
        unit: inferred(declared.unit),
        law: match declared.restitution {
            Some(_) => ImpactLaw::Restitution,
            None => ImpactLaw::Inelastic,
        },
        friction,
        dry: false,
        loads: &[],
        switch: None,
        custom_direction: declared.along.is_some(),
        held: list(declared.held.iter().copied()),
        sequence: declared.sequence,
        alternatives: list(declared.alternatives.iter().copied()),
        jacobian,
        hessian,
        documentation: text(&declared.documentation),
    }
}

/// The kernel of the coefficient of restitution, if there is one.
pub(super) fn restitution(
    builder: &mut Builder<'_>,
    name: &str,
    declared: &scene::Contact,
) -> Option<usize> {
    let value = declared.restitution?;
    Some(builder.unlisted(&format!("restitution_{name}"), &[value]))
}

/// The kernel of what is known at a point, as far as it is formulas.
fn point(
    builder: &mut Builder<'_>,
    name: &str,
    declared: &scene::Contact,
    contact: &ContactEquations,
) -> usize {
    let rows = &contact.rows;
    let dry = declared.bound.is_some();
    let normal_velocity = if dry { Sym::ZERO } else { rows.values[1] };
    let mut point = vec![rows.values[0], normal_velocity, contact.curvature];
    point.push(match contact.inverse_inertia {
        InverseInertia::Formula(inverse_inertia) => inverse_inertia,
        InverseInertia::Solved => Sym::ZERO,
    });
    point.extend(&contact.normal);
    point.extend(&rows.values[2..]);
    builder.kernel(&format!("contact_{name}"), &point)
}

fn reset(builder: &mut Builder<'_>, name: &str, declared: &scene::Contact) -> Option<usize> {
    let velocities = declared.velocities_set(builder.scene.coordinates.len())?;
    Some(builder.kernel(&format!("reset_{name}"), &velocities))
}

/// The kernels of the coefficients of friction: the only one or that at rest, and that of sliding if it is another one.
pub(super) fn coefficients(
    builder: &mut Builder<'_>,
    name: &str,
    declared: &scene::Friction,
) -> (usize, Option<usize>) {
    let kinetic = |value| builder.unlisted(&format!("kinetic_friction_{name}"), &[value]);
    let kinetic = declared.kinetic.map(kinetic);
    let coefficient = builder.unlisted(&format!("friction_{name}"), &[declared.coefficient]);
    (coefficient, kinetic)
}

fn friction(
    builder: &mut Builder<'_>,
    name: &str,
    (declared, across): (&scene::Friction, Option<Side>),
    friction: &FrictionEquations,
) -> (FrictionDeclaration, Friction) {
    let (tangent, rows, [jacobian, hessian]) = side(builder, name, "tangent", friction);
    let (coefficient, kinetic) = coefficients(builder, name, declared);
    let kernels = Friction {
        coefficient,
        kinetic,
        share: declared
            .share
            .map(|value| builder.kernel(&format!("friction_share_{name}"), &[value])),
        tangent,
        rows,
        across: across.map(|(tangent, rows, _)| (tangent, rows)),
    };
    let declaration = FrictionDeclaration {
        jacobian,
        hessian,
        kinetic: declared.kinetic.is_some(),
        share: declared.share.is_some(),
        across: across.map(|(_, _, [jacobian, _])| jacobian),
    };
    (declaration, kernels)
}

/// Kernel of what is known at a point, rows, and the patterns of their Jacobian and Hessian.
type Side = (usize, Rows, [SparsityPattern; 2]);

/// The kernels of a tangential side, which are called `what`.
fn side(builder: &mut Builder<'_>, name: &str, what: &str, friction: &FrictionEquations) -> Side {
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
    let (rows, patterns) = all_rows(builder, &kernel, rows, solved);
    (tangent, rows, patterns)
}

/// Rows that are formulas, followed by the solution of a linear system with this name if there is one, and the patterns of their
/// Jacobian and Hessian. `kernel` is the name of the kernels, `{}` in it what they compute.
fn all_rows(
    builder: &mut Builder<'_>,
    kernel: &str,
    rows: &Explicit,
    solved: Option<(String, &Directed)>,
) -> (Rows, [SparsityPattern; 2]) {
    let [jacobian, hessian] = ["jacobian", "hessian"].map(|what| kernel.replace("{}", what));
    let jacobian = builder.kernel(&jacobian, &rows.jacobian.values);
    let Some((name, solved)) = solved else {
        let kernels = (jacobian, builder.kernel(&hessian, &rows.hessian.values));
        let patterns = [pattern(&rows.jacobian), pattern(&rows.hessian)];
        let solved = None;
        return (Rows { kernels, solved }, patterns);
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
    let of_formulas = rows.hessian.entries.iter();
    let of_formulas = of_formulas.filter_map(|entry| hessian_entries.binary_search(entry).ok());
    let rows = Rows {
        solved: Some(SolvedRows {
            by,
            formulas,
            nonzeros: rows.jacobian.entries.len(),
            places: list(of_formulas),
        }),
        kernels: (jacobian, builder.kernel(&hessian, &rows.hessian.values)),
    };
    let pattern = |rows, entries: &[(usize, usize)]| SparsityPattern {
        rows,
        columns: builder.inputs,
        entries: places(entries),
    };
    let jacobian = pattern(formulas + n, &jacobian_entries);
    (rows, [jacobian, pattern(builder.inputs, &hessian_entries)])
}

/// Rows and columns of the entries of a pattern.
type Entries = Vec<(usize, usize)>;

/// What a direction with this name is solved for with, and the patterns of its Jacobian and its Hessian.
fn solver(builder: &mut Builder<'_>, name: &str, solved: &Directed) -> (Solver, Entries, Entries) {
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
