//! The checked declaration: every expression a node of the graph, in SI units.

use crate::ast::{Documentation, Name, WrittenUnit};
use crate::declaration::{Measured, Over};
use crate::graph::{self, Compose, Function, Sym, Variable};
use hangtime_units::Unit;
use proc_macro2::TokenStream;
use std::iter;

/// A checked scene.
pub(crate) struct CheckedScene {
    pub(crate) documentation: Documentation,
    pub(crate) visibility: TokenStream,
    pub(crate) name: Name,
    pub(crate) parameters: Vec<Parameter>,
    /// The declared coordinates, and behind them one for each state, whose velocity the state is.
    pub(crate) coordinates: Vec<Coordinate>,
    pub(crate) controls: Vec<Coordinate>,
    /// States of first order, as declared.
    pub(crate) states: Vec<Coordinate>,
    pub(crate) lagrangian: Sym,
    /// Generalized forces in the units of the coordinates as declared, one a coordinate; of states their rates.
    pub(crate) forces: Vec<Sym>,
    pub(crate) contacts: Vec<Contact>,
    pub(crate) joints: Vec<Joint>,
    pub(crate) positive: Vec<Positive>,
    /// Initial coordinates and velocities, in declared units.
    pub(crate) start: (Vec<Sym>, Vec<Sym>),
    pub(crate) horizon: Option<Sym>,
    pub(crate) explicit_time: bool,
    pub(crate) optimal_control: Option<OptimalControl>,
    pub(crate) outputs: Vec<Output>,
    pub(crate) picture: Option<Picture>,
    /// Parameters (indices) by which all functions are differentiated besides their inputs; none unless asked for.
    pub(crate) differentiated: Vec<u16>,
    /// Parameters that optimal control is to find.
    pub(crate) free_parameters: Vec<FreeParameter>,
    /// Measured motions that the objective compares with.
    pub(crate) experiments: Vec<Experiment>,
    /// The parameters that are coordinates without motion here, the last ones; none unless asked for.
    pub(crate) held: Vec<u16>,
    /// Components of the start `(q, v)` that are free, and that functions of optimal control read as `Start`, increasing.
    pub(crate) remembered: Vec<usize>,
    /// Whether these are coordinates without motion here, behind all others.
    pub(crate) remembers: bool,
    /// What the largest values in optimal control are here; `None` where they are not unknowns.
    pub(crate) lifted: Option<Lifted>,
}

/// Largest values as unknowns of a program.
#[derive(Clone, Default)]
pub(crate) struct Lifted {
    /// Number of coordinates without motion that are one, the last ones.
    pub(crate) coordinates: usize,
    /// Of the last controls, which are one at each instant, the numbers of their conditions, the last constraints.
    pub(crate) controls: Vec<usize>,
}

/// A function of parameters that is above zero, in SI units.
pub(crate) struct Positive {
    pub(crate) what: String,
    pub(crate) unit: Option<Unit>,
    pub(crate) value: Sym,
}

/// A parameter that optimal control is to find.
pub(crate) struct FreeParameter {
    /// Index of the parameter.
    pub(crate) index: u16,
    /// In the declared unit; functions of parameters that are not free.
    pub(crate) bounds: (Sym, Sym),
}

/// A measured motion.
pub(crate) struct Experiment {
    pub(crate) name: Name,
    pub(crate) documentation: Documentation,
    /// The file of the measurements, as written.
    pub(crate) file: String,
    /// What was measured, with its standard deviation in the declared unit.
    pub(crate) quantities: Vec<(Measured, f64)>,
    /// Initial coordinates and velocities, if it has a start of its own.
    pub(crate) start: Option<(Vec<Sym>, Vec<Sym>)>,
    /// Of how many standard deviations on a residual counts linearly.
    pub(crate) huber: Option<f64>,
}

impl CheckedScene {
    /// Number of declared coordinates, those of a mechanism.
    pub(crate) fn mechanical(&self) -> usize {
        self.coordinates.len() - self.states.len()
    }

    /// Whether largest values are unknowns of its optimal control.
    pub(crate) fn has_epigraphs(&self) -> bool {
        let task = self.optimal_control.as_ref();
        task.is_some_and(|task| !task.epigraphs.is_empty())
    }

    /// A component of the start, in its declared unit.
    pub(crate) fn start_component(&self, k: usize) -> Sym {
        let n = self.start.0.len();
        if k < n {
            self.start.0[k]
        } else {
            self.start.1[k - n]
        }
    }
}

/// A quantity that is recorded.
pub(crate) struct Output {
    pub(crate) name: Name,
    /// As declared.
    pub(crate) unit: Option<WrittenUnit>,
    /// As it follows from the expression, where none is declared.
    pub(crate) inferred: Option<Unit>,
    pub(crate) documentation: Documentation,
    /// In SI units.
    pub(crate) value: Sym,
}

/// What is drawn of a motion, with lengths in SI units and angles in radians.
#[derive(Default)]
pub(crate) struct Picture {
    pub(crate) shapes: Vec<Shape>,
    /// Unit of the lengths that are shown, as written, and how many SI units it is.
    pub(crate) unit: (String, f64),
    /// Names of the axes, the horizontal one first.
    pub(crate) axes: [String; 2],
    /// The coordinates that are the place of a point, if surfaces may be drawn as places of that.
    pub(crate) ground: Option<[usize; 2]>,
}

/// A place in the picture.
pub(crate) type Point = [Sym; 2];

/// One entry of a picture.
pub(crate) enum Shape {
    /// A rigid body.
    Body {
        name: String,
        at: Point,
        angle: Sym,
        form: Form,
    },
    /// A link or a spring.
    Line { spring: bool, ends: [Point; 2] },
    /// A curve over `Argument(0)`.
    Curve {
        name: String,
        point: Point,
        range: Option<[Sym; 2]>,
    },
}

impl Shape {
    /// Whether it is a body or a curve of this name.
    pub(crate) fn is_called(&self, text: &str) -> bool {
        match self {
            Self::Body { name, .. } | Self::Curve { name, .. } => name == text,
            Self::Line { .. } => false,
        }
    }
}

/// What a body looks like where its angle is zero, around its place.
pub(crate) enum Form {
    Point,
    Circle { radius: Sym },
    Rectangle { size: Point },
    Polygon { corners: Vec<Point> },
}

/// Objective, constraints, terminal conditions and free initial values. Functions are in SI units.
#[derive(Clone)]
pub(crate) struct OptimalControl {
    pub(crate) running_cost: Option<Sym>,
    /// Here and in the goals, `Time` is the final time.
    pub(crate) final_cost: Option<Sym>,
    pub(crate) constraints: Vec<Condition>,
    /// Constraints that hold at every impact of a contact that they name.
    pub(crate) at_impacts: Vec<Condition>,
    /// What is added up over all impacts: `Variable::Sum` counts them.
    pub(crate) sums: Vec<Sym>,
    pub(crate) goals: Vec<Condition>,
    /// Unknowns that are the largest of some values, which the functions above read as `Epigraph`.
    pub(crate) epigraphs: Vec<Epigraph>,
    pub(crate) free_time: bool,
    /// Indices into `(q, v)`, increasing, with bounds in declared units.
    pub(crate) free_start: Vec<(usize, Option<(Sym, Sym)>)>,
}

impl OptimalControl {
    /// All functions that a motion is judged by.
    pub(crate) fn functions_mut(&mut self) -> impl Iterator<Item = &mut Sym> {
        let lists = [&mut self.constraints, &mut self.at_impacts, &mut self.goals];
        let conditions = lists.into_iter().flatten();
        let epigraphs = self.epigraphs.iter_mut();
        let rows = epigraphs.flat_map(|known| known.rows.iter_mut().chain(&mut known.at_start));
        let costs = self.running_cost.iter_mut().chain(&mut self.final_cost);
        let conditions = conditions.map(|condition| &mut condition.function);
        conditions.chain(rows).chain(costs).chain(&mut self.sums)
    }

    /// Replaces each of them.
    pub(crate) fn map_functions(&mut self, replace: impl Fn(Sym) -> Sym) {
        self.functions_mut().for_each(|own| *own = replace(*own));
    }
}

/// An unknown that is the largest of some values where less of it is better.
#[derive(Clone)]
pub(crate) struct Epigraph {
    pub(crate) variable: Variable,
    /// What it stands for, or the term that this stands in, as written.
    pub(crate) shown: String,
    pub(crate) over: Over,
    /// What is not negative: the unknown less each value.
    pub(crate) rows: Vec<Sym>,
    /// What is not negative at the start of the motion, as far as it is known there.
    pub(crate) at_start: Vec<Sym>,
}

impl Epigraph {
    /// The largest value, where it belongs to an instant; 0 otherwise.
    pub(crate) fn value(&self) -> Sym {
        if self.over == Over::Motion {
            return Sym::ZERO;
        }
        let own = |variable| (variable == self.variable).then_some(Sym::ZERO);
        let values = graph::substitute(&self.rows, own).into_iter();
        let largest = values.map(|value| -value).reduce(|a, b| {
            let apart = (a - b).call(Function::Abs);
            (a + b + apart).scaled(0.5)
        });
        largest.unwrap_or(Sym::ZERO)
    }
}

/// `function >= 0` or `function == 0`.
#[derive(Clone)]
pub(crate) struct Condition {
    pub(crate) name: String,
    pub(crate) documentation: Documentation,
    pub(crate) function: Sym,
    pub(crate) equality: bool,
    pub(crate) unit: Option<Unit>,
}

/// A number that can be changed at run time.
pub(crate) struct Parameter {
    pub(crate) name: Name,
    pub(crate) unit: Option<WrittenUnit>,
    pub(crate) documentation: Documentation,
    /// Value in the declared unit.
    pub(crate) default: f64,
}

/// A coordinate, a control or a state.
pub(crate) struct Coordinate {
    pub(crate) name: Name,
    pub(crate) unit: Option<WrittenUnit>,
    pub(crate) documentation: Documentation,
    /// In the declared unit.
    pub(crate) bounds: Option<(Sym, Sym)>,
}

/// Equations between positions, or linear ones between velocities.
pub(crate) struct Joint {
    pub(crate) name: Name,
    pub(crate) documentation: Documentation,
    /// Of the positions, or of the velocities times a second.
    pub(crate) unit: Option<Unit>,
    /// What vanishes, one function a component, in SI units.
    pub(crate) rows: Vec<Sym>,
    /// Whether they are functions of positions; of velocities otherwise.
    pub(crate) holonomic: bool,
}

/// A surface with its law, or dry friction without a surface.
#[derive(Clone)]
pub(crate) struct Contact {
    pub(crate) name: Name,
    pub(crate) documentation: Documentation,
    pub(crate) gap: Sym,
    /// Indices of the other pieces of the same maximum of gaps: it acts only where its gap is the largest of theirs.
    pub(crate) alternatives: Vec<usize>,
    pub(crate) unit: Option<Unit>,
    /// The declared impulse direction, in the units of the velocities as declared.
    pub(crate) along: Option<Vec<Sym>>,
    /// Coordinates that are rigid under the impulse, increasing.
    pub(crate) held: Vec<usize>,
    /// Whether contacts that touch are struck one after the other.
    pub(crate) sequence: bool,
    /// Coefficient of restitution; `None` for an inelastic contact.
    pub(crate) restitution: Option<Sym>,
    pub(crate) friction: Option<Friction>,
    /// Largest force of dry friction, in SI units; such a contact has no gap, and its coefficient is 1.
    pub(crate) bound: Option<Sym>,
    /// Surfaces (indices of contacts) whose normal forces are added to that, each times a factor.
    pub(crate) loads: Vec<(u16, Sym)>,
    /// Equations of joints, counted over all of them, whose forces are added to it in the same way.
    pub(crate) joint_loads: Vec<(u16, Sym)>,
    /// Of a switch what it acts by: it is dry friction with the bound 1, against minus its function.
    pub(crate) switch: Option<Action>,
    /// Velocities (indices) that are set where the function of a switch that does nothing else comes to be positive, with what they are
    /// set to, in declared units.
    pub(crate) reset: Vec<(usize, Sym)>,
}

/// What a switch acts by, one force a coordinate in declared units.
#[derive(Clone)]
pub(crate) struct Action {
    pub(crate) force: Vec<Sym>,
    /// The force with each control as large as it is usually, so that what is measured by it has derivatives where a control is 0.
    pub(crate) usual: Vec<Sym>,
    /// Whether it vanishes with the function, as that of a kink does.
    pub(crate) kink: bool,
}

impl Contact {
    /// Nothing but its name, and its documentation.
    pub(crate) fn new(name: Name, documentation: Documentation) -> Self {
        Self {
            name,
            documentation,
            gap: Sym::ZERO,
            alternatives: Vec::new(),
            unit: None,
            along: None,
            held: Vec::new(),
            sequence: false,
            restitution: None,
            friction: None,
            bound: None,
            loads: Vec::new(),
            joint_loads: Vec::new(),
            switch: None,
            reset: Vec::new(),
        }
    }

    /// Dry friction: no gap, and a normal force that is given, `bound`, with the coefficient 1.
    pub(crate) fn dry(
        name: Name,
        documentation: Documentation,
        (sliding, bound): (Sym, Sym),
    ) -> Self {
        Self {
            friction: Some(Friction {
                coefficient: Sym::ONE,
                kinetic: None,
                share: None,
                sliding,
                across: None,
            }),
            bound: Some(bound),
            ..Self::new(name, documentation)
        }
    }

    /// All functions that say how it acts.
    pub(crate) fn functions_mut(&mut self) -> impl Iterator<Item = &mut Sym> {
        let action = self.switch.iter_mut();
        let action = action.flat_map(|action| action.force.iter_mut().chain(&mut action.usual));
        let friction = self.friction.iter_mut().flat_map(|law| {
            let sliding = iter::once(&mut law.sliding);
            sliding.chain(&mut law.share).chain(&mut law.across)
        });
        let loads = self.loads.iter_mut().chain(&mut self.joint_loads);
        iter::once(&mut self.gap)
            .chain(&mut self.bound)
            .chain(loads.map(|(_, factor)| factor))
            .chain(self.along.iter_mut().flatten())
            .chain(friction)
            .chain(action)
            .chain(self.reset.iter_mut().map(|(_, value)| value))
    }

    /// All `n` velocities right after it has come true, if it is a condition that sets some of them.
    pub(crate) fn velocities_set(&self, n: usize) -> Option<Vec<Sym>> {
        let velocities = (0..n).map(|i| Sym::variable(Variable::Velocity(i as u16)));
        let mut velocities: Vec<Sym> = velocities.collect();
        for &(index, value) in &self.reset {
            velocities[index] = value;
        }
        (!self.reset.is_empty()).then_some(velocities)
    }

    /// Largest force of dry friction, with the forces that it follows.
    pub(crate) fn whole_bound(&self) -> Option<Sym> {
        let force = |i: u16| Sym::variable(Variable::ContactForce(i));
        let loads = self.loads.iter();
        let loads: Sym = loads.map(|&(i, factor)| factor * force(i)).sum();
        let of_joint = |i: u16| Sym::variable(Variable::JointForce(i));
        let joints = self.joint_loads.iter();
        let joints: Sym = joints.map(|&(i, factor)| factor * of_joint(i)).sum();
        let follows = !self.loads.is_empty() || !self.joint_loads.is_empty();
        self.bound.map(|bound| match follows {
            false => bound,
            true => bound + loads + joints,
        })
    }
}

/// Coulomb friction of a contact.
#[derive(Clone, Copy)]
pub(crate) struct Friction {
    /// Function of parameters: the coefficient at rest, and of sliding unless that is another one.
    pub(crate) coefficient: Sym,
    /// That of sliding, if it is another one.
    pub(crate) kinetic: Option<Sym>,
    /// What both are multiplied by, if it changes with the sliding velocity or the place.
    pub(crate) share: Option<Sym>,
    /// Sliding velocity, linear in the velocities, in SI units.
    pub(crate) sliding: Sym,
    /// In space the second one, perpendicular to that.
    pub(crate) across: Option<Sym>,
}

/// How many SI units one declared unit is.
pub(crate) fn scale(unit: Option<&WrittenUnit>) -> f64 {
    unit.map_or(1.0, |written| written.unit.scale)
}
