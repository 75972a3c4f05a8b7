//! How large a discrete system is, and what each part of it is there for.

use std::collections::BTreeMap;

use hangtime_solver::ProblemSize;
use hangtime_solver::nlp::NlpProblem;

/// What variables, equations and derivatives are there for, from what every motion has to what few scenes ask for. An
/// entry of a Jacobian or Hessian belongs to the later one of the two that it joins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Purpose {
    /// Coordinates and velocities.
    State,
    /// Physical time as a state of the time-freezing system, and numerical lengths.
    Clock,
    /// Joints.
    Joint,
    /// Lengths of the finite elements.
    ElementLength,
    /// Forces of contacts.
    ContactForce,
    /// Gaps of contacts.
    Gap,
    /// Step functions of the contacts.
    StepFunction,
    /// Sums over an element.
    CrossComplementarity,
    /// Times of contact switches.
    SwitchTime,
    /// Velocities after impacts, and impulses.
    Impact,
    /// Terminal conditions.
    Goal,
    /// Bounds of coordinates between the ends of the intervals.
    Bound,
    /// Path constraints.
    PathConstraint,
    /// Forces and impulses in objective and conditions.
    ForceTerm,
    /// Controls.
    Control,
    /// A final time that is free.
    FinalTime,
    /// The time where the scene reads it.
    ExplicitTime,
    /// Initial values that are free.
    FreeStart,
    /// Several contacts at once.
    SeveralContacts,
    /// Friction.
    Friction,
    /// Bounces.
    Restitution,
    /// Edges.
    Edge,
    /// Not classified.
    Other,
}

impl Purpose {
    /// Name of the group, and why it is there in a short phrase.
    const fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::State => ("state", "coordinates and velocities at the stages"),
            Self::Clock => ("clock", "time-freezing: a clock state, numerical lengths"),
            Self::Joint => ("joints", "hold positions and velocities of joints"),
            Self::ElementLength => ("element lengths", "switches lie on ends of elements"),
            Self::ContactForce => ("contact force", "holds the normal velocity at zero"),
            Self::Gap => (
                "gap",
                "bodies do not pass through surfaces, nor drift off them",
            ),
            Self::StepFunction => ("step functions", "free, jump or contact, as pairs"),
            Self::CrossComplementarity => ("cross complementarity", "one mode in each element"),
            Self::SwitchTime => ("switch times", "phases of the contact sequence"),
            Self::Impact => ("impacts", "velocities after them, impulses"),
            Self::Goal => ("goals", "declared by `finally`"),
            Self::Bound => ("bounds", "bounds of a coordinate between the nodes"),
            Self::PathConstraint => ("path constraints", "declared by `constraint`"),
            Self::ForceTerm => (
                "declared forces",
                "forces and impulses in objective and conditions",
            ),
            Self::Control => ("controls", "declared by `controls`"),
            Self::FinalTime => (
                "free final time",
                "`time` occurs in the objective or a goal",
            ),
            Self::ExplicitTime => ("explicit time", "the scene reads `t`"),
            Self::FreeStart => ("free start", "initial values declared free"),
            Self::SeveralContacts => ("several contacts", "products of step functions"),
            Self::Friction => ("friction", "declared by `friction`"),
            Self::Restitution => ("restitution", "declared by `restitution`"),
            Self::Edge => ("edges", "which piece of a surface with an edge acts"),
            Self::Other => ("other", "not classified"),
        }
    }
}

/// What variables, equations and derivatives that are there for one reason take. An entry of a Jacobian or Hessian belongs
/// to the rarer one of the two groups that it joins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SizeGroup {
    /// Name of the group, as in `"contact force"`.
    pub name: &'static str,
    /// Why it is there, in a short phrase.
    pub why: &'static str,
    /// How much.
    pub size: ProblemSize,
}

/// The size of one formulation of a scene: what its solver sees. Variables whose bounds fix them are numbers, and rows
/// without bounds do not exist.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct FormulationSize {
    /// Which formulation.
    pub formulation: String,
    /// On which grid.
    pub discretization: String,
    /// Its groups, none of them empty, from what every motion has to what few scenes ask for.
    pub groups: Vec<SizeGroup>,
}

impl FormulationSize {
    /// Sum of all groups.
    #[must_use]
    pub fn size(&self) -> ProblemSize {
        let mut size = ProblemSize::default();
        self.groups.iter().for_each(|group| size += group.size);
        size
    }
}

/// Groups under construction.
#[derive(Debug, Default)]
pub(crate) struct Tally(BTreeMap<Purpose, ProblemSize>);

impl Tally {
    /// The numbers of a purpose.
    pub(crate) fn of(&mut self, purpose: Purpose) -> &mut ProblemSize {
        self.0.entry(purpose).or_default()
    }

    /// The groups that are not empty.
    pub(crate) fn groups(self) -> Vec<SizeGroup> {
        let groups = self.0.into_iter().map(|(purpose, size)| {
            let (name, why) = purpose.words();
            SizeGroup { name, why, size }
        });
        groups
            .filter(|group| group.size != ProblemSize::default())
            .collect()
    }
}

/// The groups of a program with complementarity pairs, as its variables and rows are classified. What the solver takes
/// out is not counted: fixed variables, and rows without bounds.
pub(crate) fn groups_of(
    program: &dyn NlpProblem,
    pairs: &[(usize, usize)],
    variable: &dyn Fn(usize) -> Purpose,
    row: &dyn Fn(usize) -> Purpose,
) -> Vec<SizeGroup> {
    let (variables, rows) = (program.variables(), program.constraints());
    let (mut lower, mut upper) = (vec![0.0; variables], vec![0.0; variables]);
    program.variable_bounds(&mut lower, &mut upper);
    let free = lower.iter().zip(&upper).enumerate();
    let columns: Vec<Option<Purpose>> = free
        .map(|(i, (lower, upper))| (lower < upper).then(|| variable(i)))
        .collect();
    let (mut lower, mut upper) = (vec![0.0; rows], vec![0.0; rows]);
    program.constraint_bounds(&mut lower, &mut upper);
    let mut tally = Tally::default();
    let mut of_rows: Vec<Option<Purpose>> = Vec::with_capacity(rows);
    for (i, (lower, upper)) in lower.iter().zip(&upper).enumerate() {
        let bounded = lower.is_finite() || upper.is_finite();
        let purpose = bounded.then(|| row(i));
        if let Some(purpose) = purpose {
            let size = tally.of(purpose);
            if lower == upper {
                size.equalities += 1;
            } else {
                size.inequalities += 1;
            }
        }
        of_rows.push(purpose);
    }
    for purpose in columns.iter().flatten() {
        tally.of(*purpose).variables += 1;
    }
    for (i, j) in program.jacobian_pattern() {
        if let Some((row, column)) = of_rows[i].zip(columns[j]) {
            tally.of(row.max(column)).jacobian_nonzeros += 1;
        }
    }
    for (i, j) in program.hessian_pattern() {
        if let Some((one, other)) = columns[i].zip(columns[j]) {
            tally.of(one.max(other)).hessian_nonzeros += 1;
        }
    }
    for &(i, j) in pairs {
        if let Some((one, other)) = columns[i].zip(columns[j]) {
            tally.of(one.max(other)).complementarities += 1;
        }
    }
    tally.groups()
}
