//! What a declaration has said so far, and what every rule asks of it.

use crate::ast::{Assignment, Documentation, Expr, Name, Relation};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported, closest, list};
use crate::dimension::Dimension;
use crate::evaluate::{Evaluation, Meaning, Number, Scope, Value, expression};
use crate::graph::{self, Sym, Variable};
use crate::scene::{self, Coordinate, Parameter};
use crate::words;
use std::collections::HashMap;

/// A surface, or a smooth piece of one with edges, before its law is known.
pub(super) struct Surface {
    pub(super) documentation: Documentation,
    pub(super) name: Name,
    pub(super) gap: Sym,
    /// Its number among the pieces, from 0, and how many there are.
    pub(super) piece: usize,
    pub(super) pieces: usize,
    /// The number of its sliding velocity, from 0, and how many there are: one for each piece that is another function.
    pub(super) slides: (usize, usize),
    /// Indices of the other pieces of the same maximum.
    pub(super) alternatives: Vec<usize>,
}

impl Surface {
    /// Its name as a contact.
    pub(super) fn contact_name(&self) -> Name {
        let mut name = self.name.clone();
        if self.pieces > 1 {
            name.text = format!("{}.{}", name.text, self.piece + 1);
        }
        name
    }
}

/// A sum of which parts are used by name.
pub(super) struct Abbreviation {
    pub(super) name: Name,
    pub(super) what: &'static str,
}

/// What has been declared so far.
pub(super) struct Checker<'a> {
    pub(super) scope: Scope,
    pub(super) diagnostics: &'a mut Diagnostics,
    pub(super) parameters: Vec<Parameter>,
    pub(super) free_parameters: Vec<scene::FreeParameter>,
    pub(super) coordinates: Vec<Coordinate>,
    pub(super) controls: Vec<Coordinate>,
    pub(super) states: Vec<Coordinate>,
    /// Rates in SI units, by state.
    pub(super) rates: Vec<(usize, Sym)>,
    pub(super) abbreviations: Vec<Abbreviation>,
    pub(super) lagrangian: Option<(Sym, Place)>,
    pub(super) dissipation: Option<Sym>,
    /// Generalized force in SI units, by coordinate.
    pub(super) forces: Vec<(usize, Sym)>,
    pub(super) surfaces: Vec<Surface>,
    pub(super) laws: Laws,
    pub(super) start: Vec<Assignment>,
    pub(super) horizon: Option<Sym>,
    pub(super) task: Task,
    /// Times at which conditions hold.
    pub(super) moments: Vec<Moment>,
    pub(super) shown: Shown,
}

/// What a list of quantities is of.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Of {
    Coordinates,
    Controls,
    States,
}

/// Laws of contact, joints, and numbers that are above zero.
#[derive(Default)]
pub(super) struct Laws {
    pub(super) impacts: Vec<CheckedLaw>,
    /// The law of each surface, by its name.
    pub(super) of_surfaces: HashMap<String, usize>,
    pub(super) sliding: Vec<Sliding>,
    pub(super) dry: Vec<DryFriction>,
    pub(super) resets: Vec<Reset>,
    pub(super) joints: Vec<scene::Joint>,
    pub(super) positive: Vec<scene::Positive>,
}

/// A sliding velocity, whose surfaces may stand below.
pub(super) struct Sliding {
    pub(super) surfaces: Vec<Name>,
    pub(super) expr: Expr,
    pub(super) unit: Dimension,
}

/// What is set where a condition comes true.
pub(super) struct Reset {
    pub(super) documentation: Documentation,
    pub(super) name: Name,
    /// Positive where the condition holds, in SI units.
    pub(super) function: Sym,
    /// States and velocities, by their places among the velocities of all coordinates, with their values in declared units.
    pub(super) values: Vec<(usize, Sym)>,
}

/// A time and its conditions, as far as they are evaluated.
pub(super) struct Moment {
    /// In seconds.
    pub(super) time: Sym,
    pub(super) place: Place,
    pub(super) shown: String,
    /// The states that record its conditions.
    pub(super) states: Vec<usize>,
    /// The states of values that are asked for then.
    pub(super) values: Vec<usize>,
    /// States that are read then.
    pub(super) read: Vec<usize>,
}

/// Dry friction without a surface.
pub(super) struct DryFriction {
    pub(super) documentation: Documentation,
    pub(super) name: Name,
    /// Largest force, in SI units, as far as it follows no force of a surface.
    pub(super) bound: Sym,
    /// Surfaces whose normal forces are added to that, each times a factor.
    pub(super) loads: Vec<(u16, Sym)>,
    /// Equations of joints whose forces are added, each times a factor.
    pub(super) joint_loads: Vec<(u16, Sym)>,
    pub(super) sliding: Sym,
}

/// What is recorded and drawn.
#[derive(Default)]
pub(super) struct Shown {
    pub(super) outputs: Vec<scene::Output>,
    pub(super) picture: Option<scene::Picture>,
}

/// The law of one surface.
#[derive(Clone)]
pub(super) struct CheckedLaw {
    pub(super) surface: Name,
    pub(super) restitution: Option<Sym>,
    pub(super) friction: Option<CheckedFriction>,
    pub(super) along: Option<Vec<Sym>>,
    pub(super) held: Vec<usize>,
    pub(super) sequence: bool,
}

#[derive(Clone)]
pub(super) struct CheckedFriction {
    /// Of sliding; `SPEED` in it is the size of the sliding velocity.
    pub(super) coefficient: Sym,
    /// At rest, if that is another one.
    pub(super) at_rest: Option<Sym>,
    /// Sliding velocities, one for each piece of the surface, or two where it is in space.
    pub(super) sliding: Option<Vec<Vec<Sym>>>,
    pub(super) place: Place,
}

/// The task of optimal control as far as it is declared.
#[derive(Default)]
pub(super) struct Task {
    pub(super) cost: Option<Cost>,
    /// As declared.
    pub(super) constraints: Vec<Asked>,
    pub(super) goals: Vec<Asked>,
    /// Unknowns that are the largest of some values.
    pub(super) epigraphs: Vec<scene::Epigraph>,
    pub(super) free: Vec<Free>,
}

/// A condition: one for every piece of it, and the unit of both sides.
pub(super) struct Asked {
    pub(super) pieces: Vec<scene::Condition>,
    pub(super) unit: Dimension,
}

/// The two parts of an objective.
#[derive(Default)]
pub(super) struct Cost {
    pub(super) running: Option<Sym>,
    pub(super) terminal: Option<Sym>,
}

/// An initial value that is to be found.
pub(super) struct Free {
    /// Index into `(q, v)`.
    pub(super) index: usize,
    pub(super) bounds: Option<(Sym, Sym)>,
    pub(super) shown: String,
    pub(super) place: Place,
}

impl Checker<'_> {
    fn evaluation(&mut self) -> Evaluation<'_> {
        Evaluation {
            scope: &mut self.scope,
            diagnostics: self.diagnostics,
        }
    }

    /// What is declared of a kind so far.
    pub(super) fn list(&mut self, of: Of) -> &mut Vec<Coordinate> {
        match of {
            Of::Coordinates => &mut self.coordinates,
            Of::Controls => &mut self.controls,
            Of::States => &mut self.states,
        }
    }

    /// Evaluates an expression.
    pub(super) fn value(&mut self, expr: &Expr) -> Checked<Value> {
        expression::value(&mut self.evaluation(), expr)
    }

    /// Evaluates an expression that must be a number.
    pub(super) fn number(&mut self, expr: &Expr) -> Checked<Number> {
        expression::scalar(&mut self.evaluation(), expr)
    }

    /// The unit of what a name stands for, if that is a number.
    pub(super) fn unit_of(&mut self, name: &str) -> Dimension {
        match self.scope.names.get(name) {
            Some(Meaning::Value(Value::Scalar(number))) => number.unit.clone(),
            _ => self.scope.units.unknown(name),
        }
    }

    /// The difference of both sides of a comparison, not negative where it holds, in the unit of both.
    pub(super) fn difference(
        &mut self,
        [(left, own), (right, its)]: [(&Expr, &Number); 2],
        relation: Relation,
        sides: &str,
    ) -> Number {
        let units = &mut self.scope.units;
        units.angles((left, own), (right, its));
        let place = left.place.to(right.place);
        units.same(place, (left, &own.unit), (right, &its.unit), sides);
        own.with(match relation {
            Relation::AtLeast | Relation::Equal => own.sym - its.sym,
            Relation::AtMost => its.sym - own.sym,
        })
    }

    /// Whether a number is in the unit of what it belongs to, or bare, which is meant in that unit.
    pub(super) fn given(&mut self, expr: &Expr, own: &Number, wanted: &Dimension, reason: &str) {
        if !expr.is_bare() {
            self.scope.units.expect(expr, &own.unit, wanted, reason);
        }
    }

    /// Tells what was found about units.
    pub(super) fn tell_units(&mut self) {
        let found = std::mem::take(&mut self.scope.units.found);
        self.diagnostics.absorb(found);
    }

    /// Evaluates an expression in which a name stands for a number.
    pub(super) fn value_over(&mut self, named: (&str, Number), expr: &Expr) -> Checked<Value> {
        expression::value_over(&mut self.evaluation(), named, expr)
    }

    /// A variable as the user knows it.
    pub(super) fn in_words(&self, variable: Variable) -> String {
        let name = |list: &[Coordinate], i: u16| {
            list.get(usize::from(i))
                .map_or_else(String::new, |known| known.name.text.clone())
        };
        match variable {
            Variable::Coordinate(i) => format!("the coordinate `{}`", name(&self.coordinates, i)),
            Variable::Velocity(i) if i >= self.scope.first_state => {
                format!(
                    "the state `{}`",
                    name(&self.states, i - self.scope.first_state)
                )
            }
            Variable::Velocity(i) => format!("the velocity `dot({})`", name(&self.coordinates, i)),
            Variable::Control(i) => format!("the control `{}`", name(&self.controls, i)),
            Variable::Time => "the time `t`".to_owned(),
            Variable::ContactForce(_) | Variable::FrictionForce(_) => {
                "the force of a contact".to_owned()
            }
            Variable::ContactImpulse(_) | Variable::FrictionImpulse(_) => {
                "the impulse of a contact".to_owned()
            }
            Variable::JointForce(_) => "the force of a joint".to_owned(),
            Variable::Sum(_) => "a sum over impacts".to_owned(),
            Variable::Switch(_) => "a switch".to_owned(),
            _ => "a parameter".to_owned(),
        }
    }

    /// A component of the start `(q, v)` as it is written, where states have their coordinates.
    pub(super) fn component(&self, k: usize) -> String {
        let n = self.coordinates.len();
        match k.checked_sub(n) {
            None => self.coordinates[k].name.text.clone(),
            Some(k) => match k.checked_sub(n - self.states.len()) {
                None => format!("dot({})", self.coordinates[k].name.text),
                Some(state) => self.states[state].name.text.clone(),
            },
        }
    }

    /// Whether a condition sets a state, so that it needs no rate.
    pub(super) fn is_set(&self, state: usize) -> bool {
        let index = self.coordinates.len() + state;
        let mut values = self.laws.resets.iter().flat_map(|reset| &reset.values);
        values.any(|&(known, _)| known == index)
    }

    /// A name whose declaration failed: uses of it are not reported as undeclared, as the stand-in is
    /// never emitted.
    pub(super) fn poison(&mut self, name: &Name) -> Checked<()> {
        self.diagnostics.poison(&name.text);
        Err(Reported)
    }

    /// Whether a name may be declared.
    pub(super) fn new_name(&mut self, name: &Name, what: &str) -> Checked<()> {
        let text = name.text.as_str();
        let is_function = words::FUNCTIONS.contains(&text)
            || words::SPECIAL_FUNCTIONS.contains(&text)
            || words::NONSMOOTH.contains(&text)
            || text == words::INTEGRAL;
        let (code, why) = if self.scope.names.contains_key(text) {
            ("E19", format!(" is declared twice; rename this {what}"))
        } else if words::RESERVED.contains(&text) {
            let meaning = match text {
                "t" | "time" => "the physical time",
                "pi" => "the number pi",
                _ => "the clock of the time-freezing reformulation",
            };
            (
                "E11",
                format!(" is reserved for {meaning}; choose another name"),
            )
        } else if words::is_rust_word(text) && !self.diagnostics.is_data {
            let why = " is a word of Rust and cannot be a field; choose another name";
            ("E11", why.to_owned())
        } else if text.starts_with("__") || text == "_" {
            let why = ": names that begin with `__` are reserved; choose another name";
            ("E11", why.to_owned())
        } else if is_function {
            let why = " is the name of a function; choose another name";
            ("E19", why.to_owned())
        } else {
            return Ok(());
        };
        let message = format!("`{text}`{why}");
        Err(self.diagnostics.report(code, name.place(), message))
    }

    /// A value that may depend on parameters only.
    pub(super) fn constant(&mut self, sym: Sym, expr: &Expr, what: &str) -> Checked<Sym> {
        self.free_of(&[sym], Variable::moves, (None, expr.place), |moving| {
            format!("{what} depends on {moving}; it may depend on parameters only")
        })?;
        Ok(sym)
    }

    /// That values depend on no variable that is `wrong`; `message` says what is the matter with one, which it is given in words.
    pub(super) fn free_of(
        &mut self,
        values: &[Sym],
        wrong: impl Fn(Variable) -> bool,
        (code, place): (Option<&'static str>, Place),
        message: impl FnOnce(String) -> String,
    ) -> Checked<()> {
        let mut variables = graph::variables(values).into_iter();
        match variables.find(|&variable| wrong(variable)) {
            None => Ok(()),
            Some(variable) => {
                let message = message(self.in_words(variable));
                Err(self.diagnostics.report(code, place, message))
            }
        }
    }

    /// E10: a coefficient of the law `of` that lies between 0 and a bound for the defaults of the parameters, if these say what it
    /// is.
    pub(super) fn coefficient(
        &mut self,
        sym: Sym,
        expr: &Expr,
        of: &str,
        most: f64,
    ) -> Checked<Sym> {
        let Some(value) = self.at_default(sym) else {
            return Ok(sym);
        };
        if (0.0..=most).contains(&value) {
            return Ok(sym);
        }
        let shown = match expr.to_string() {
            text if text == value.to_string() => text,
            text => format!("{text} = {value}"),
        };
        let message = if most.is_finite() {
            format!(
                "coefficient of {of} {shown} is outside [0, 1]: 0 keeps no normal velocity, 1 all of it"
            )
        } else {
            format!(
                "coefficient of {of} {shown} is below 0: the force would drive the sliding instead of \
                 braking it; change its sign"
            )
        };
        Err(self.diagnostics.report("E10", expr.place, message))
    }

    /// The free parameter that a value depends on, if it depends on one.
    pub(super) fn free_parameter_in(&self, value: Sym) -> Option<&str> {
        let read = graph::variables(&[value]);
        let mut free = self.free_parameters.iter();
        let found = free.find(|free| read.contains(&Variable::Parameter(free.index)))?;
        Some(self.parameters[usize::from(found.index)].name.text.as_str())
    }

    /// A bound of `of`, which is the same for all values of free parameters.
    pub(super) fn fixed_bound(&mut self, bound: Sym, expr: &Expr, of: &str) -> Checked<Sym> {
        let Some(name) = self.free_parameter_in(bound) else {
            return Ok(bound);
        };
        let message = format!(
            "a bound of `{of}` depends on the free parameter `{name}`; write it as a condition, such as \
             `constraint limit: {of} <= {expr}`"
        );
        Err(self.diagnostics.syntax(expr.place, message))
    }

    pub(super) fn coordinate_index(&mut self, name: &Name) -> Checked<usize> {
        if let Some(index) = self
            .coordinates
            .iter()
            .position(|known| known.name.text == name.text)
        {
            return Ok(index);
        }
        if self.diagnostics.is_poisoned(&name.text) {
            return Err(Reported);
        }
        let names: Vec<String> = self
            .coordinates
            .iter()
            .map(|known| known.name.text.clone())
            .collect();
        let names = || names.iter().map(String::as_str);
        let mut states = self.states.iter();
        let message = if states.any(|known| known.name.text == name.text) {
            format!(
                "`{0}` is a state, not a coordinate; what it changes by stands in `rates {{ {0}: ... }}`",
                name.text
            )
        } else if self.scope.names.contains_key(&name.text) {
            format!(
                "`{}` is not a coordinate (coordinates: {})",
                name.text,
                list(names())
            )
        } else {
            let of = words::velocity_of(&name.text, &names().collect::<Vec<_>>());
            match closest(&name.text, names()) {
                _ if of.is_some() => format!(
                    "`{}` is not declared; the velocity of `{1}` is `dot({1})`",
                    name.text,
                    of.unwrap_or_default()
                ),
                Some(near) => format!("`{}` is not declared; did you mean `{near}`?", name.text),
                None => format!(
                    "`{}` is not declared (coordinates: {})",
                    name.text,
                    list(names())
                ),
            }
        };
        Err(self.diagnostics.report("E01", name.place(), message))
    }

    /// The number that a value is for the defaults of the parameters; `None` where a default is missing or wrong.
    pub(super) fn at_default(&self, value: Sym) -> Option<f64> {
        self.with_defaults(value).as_number()
    }

    /// A value for the defaults of the parameters.
    pub(super) fn with_defaults(&self, value: Sym) -> Sym {
        graph::substitute(&[value], |variable| match variable {
            Variable::Parameter(i) => {
                let known = self.parameters.get(usize::from(i));
                let default = known.map(|known| known.default);
                default.filter(|value| !value.is_nan()).map(Sym::number)
            }
            _ => None,
        })[0]
    }

    /// E17: a start value lies between bounds, for the defaults of the parameters.
    pub(super) fn within(&mut self, value: Sym, bounds: (Sym, Sym), place: Place, shown: &str) {
        let (Some(low), Some(high), Some(value)) = (
            self.at_default(bounds.0),
            self.at_default(bounds.1),
            self.at_default(value),
        ) else {
            return;
        };
        if !(low..=high).contains(&value) {
            self.diagnostics.report(
                "E17",
                place,
                format!("`{shown}` starts at {value}, outside its bounds {low}..={high}"),
            );
        }
    }
}
