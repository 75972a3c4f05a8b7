//! Names in force: what they stand for, and what is said of those that are not declared.

use super::kink::{Kink, Peak, Switch, has_switch};
use super::units::Units;
use super::value::{Number, Value};
use crate::ast::{Expr, Name};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported, closest, list};
use crate::graph::{self, Sym, Variable};
use crate::words;
use std::collections::{BTreeMap, HashSet};
use std::ops::Range;
use std::rc::Rc;

/// What a name stands for.
#[derive(Clone)]
pub(crate) enum Meaning {
    Value(Value),
    Function(Rc<UserFunction>),
}

/// `fn name(arguments) = body`.
pub(crate) struct UserFunction {
    pub(crate) arguments: Vec<Name>,
    pub(crate) body: Expr,
}

/// What an expression is for, which decides what it may use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Role {
    /// The motion: dynamics, surfaces, laws.
    #[default]
    Motion,
    /// A surface, which may have edges.
    Surface,
    /// The bound of a dry friction, which knows normal forces of surfaces.
    Bound,
    /// What is added up during the motion: the running cost, which knows contact forces.
    Running,
    /// What holds all the time, or at every impact: constraints, which know contact forces or impulses.
    Constraint,
    /// What counts at the final instant: final cost and terminal conditions, which know the final time, contact forces, and
    /// sums over impacts.
    End,
    /// What is added up over all impacts, which knows impulses.
    Impact,
    /// What is recorded of a motion, which knows contact forces and impulses, and may have edges.
    Record,
    /// What is drawn, which may have edges.
    Draw,
}

/// What an output contains that not every statement may use.
#[derive(Clone, Copy)]
pub(crate) struct Contents {
    /// Forces or impulses of contacts.
    pub(crate) contacts: bool,
    /// Edges.
    pub(crate) edges: bool,
}

/// What the final time is called elsewhere.
const FINAL_TIMES: [&str; 6] = ["T", "tf", "t_f", "tend", "t_end", "t_final"];

/// All names in force, and which of them have been used.
#[derive(Default)]
pub(crate) struct Scope {
    pub(crate) role: Role,
    /// Number of the first velocity that is a state.
    pub(crate) first_state: u16,
    /// Number of coordinates and states, which is where velocities begin in `(q, v)`.
    pub(crate) state_size: u16,
    /// Whether a force is evaluated.
    pub(crate) acts: bool,
    /// Whether a condition is evaluated, which is taken apart into smooth ones.
    pub(crate) takes_apart: bool,
    /// Whether what is evaluated is given a name, for whatever may use it.
    pub(crate) defers: bool,
    /// Switches of what acts.
    pub(crate) switches: Vec<Switch>,
    pub(crate) units: Units,
    pub(crate) names: BTreeMap<String, Meaning>,
    pub(crate) used: HashSet<String>,
    /// Names that are declared further down.
    pub(crate) later: HashSet<String>,
    /// Surfaces declared so far, in order, with the contacts that they are.
    pub(crate) surfaces: Vec<(String, Range<usize>)>,
    /// Dry frictions declared so far, in order.
    pub(crate) dry: Vec<String>,
    /// Joints declared so far, in order, with the equations that they are.
    pub(crate) joints: Vec<(String, Range<usize>)>,
    /// Where optimal control first reads the force of a joint.
    pub(crate) planned: Option<Place>,
    /// Maxima and minima in the surface being evaluated.
    pub(crate) kinks: Vec<Kink>,
    /// Contacts of which the friction is recorded, by which function.
    pub(crate) rubbing: Vec<(usize, String, Place)>,
    /// What the outputs declared so far contain.
    pub(crate) recorded: BTreeMap<String, Contents>,
    /// Components of the start `(q, v)` that are read by `start(...)`, as written there.
    pub(crate) starts: Vec<(u16, String, Place)>,
    /// Largest values over the motion that were asked for since these were last looked at.
    pub(crate) peaks: Vec<Peak>,
    /// Number of unknowns that the language made for largest values.
    pub(crate) epigraphs: u16,
    /// What is added up over all impacts.
    pub(crate) sums: Vec<Sym>,
    /// Arguments of the functions being evaluated, innermost last.
    pub(super) frames: Vec<Vec<(String, Value)>>,
    /// Functions being evaluated.
    pub(super) active: Vec<String>,
    pub(super) evaluated: usize,
    pub(super) depth: usize,
    pub(super) arguments: u16,
}

/// An evaluation of expressions over the names in force, which reports its mistakes.
pub(crate) struct Evaluation<'a> {
    pub(crate) scope: &'a mut Scope,
    pub(crate) diagnostics: &'a mut Diagnostics,
}

impl Scope {
    pub(super) fn name(&mut self, name: &Name, diagnostics: &mut Diagnostics) -> Checked<Value> {
        let local = self
            .frames
            .last()
            .and_then(|frame| frame.iter().find(|(known, _)| *known == name.text));
        if let Some((_, value)) = local {
            return Ok(value.clone());
        }
        match self.names.get(&name.text) {
            Some(Meaning::Value(value))
                if self.is_recorded(name, |known| known.contacts)
                    && let Some(why) = recorded_only(self.role, value) =>
            {
                let message = format!("`{}` contains {why}", name.text);
                Err(diagnostics.report("E24", name.place(), message))
            }
            Some(Meaning::Value(_))
                if !matches!(self.role, Role::Record | Role::Draw)
                    && self.is_recorded(name, |known| known.edges) =>
            {
                let message = format!(
                    "`{}` contains `max`, `min` or `|x|`, which have no derivative at the edge; it can be used in `outputs` \
                     and `picture` only",
                    name.text
                );
                Err(diagnostics.report("E12", name.place(), message))
            }
            Some(Meaning::Value(value))
                if self.role != Role::Record && !self.may_switch() && has_switch(&value.syms()) =>
            {
                let message = format!(
                    "`{}` contains a switch, which belongs to `forces`, `rates` and `outputs` only; everywhere else use \
                     smooth functions",
                    name.text
                );
                Err(diagnostics.report("E12", name.place(), message))
            }
            Some(Meaning::Value(value)) => {
                self.used.insert(name.text.clone());
                Ok(value.clone())
            }
            Some(Meaning::Function(_)) => Err(diagnostics.report(
                "E02",
                name.place(),
                format!(
                    "`{0}` is a function; write its argument, as in `{0}(y)`",
                    name.text
                ),
            )),
            None if name.text == "pi" => Ok(Value::Scalar(Number {
                sym: Sym::number(std::f64::consts::PI),
                unit: self.units.one(),
            })),
            None if name.text == "t"
                || name.text == words::FINAL_TIME && self.role == Role::End =>
            {
                self.used.insert(name.text.clone());
                Ok(Value::Scalar(Number {
                    sym: Sym::variable(Variable::Time),
                    unit: self.units.second(),
                }))
            }
            None => Err(self.undeclared(name, diagnostics)),
        }
    }

    pub(super) fn undeclared(&self, name: &Name, diagnostics: &mut Diagnostics) -> Reported {
        let text = &name.text;
        if diagnostics.is_poisoned(text) {
            return Reported;
        }
        if self.later.contains(text) {
            return diagnostics.report(
                "E01",
                name.place(),
                format!("`{text}` is declared further down; move its declaration up"),
            );
        }
        if words::is_function(text) {
            return diagnostics.report(
                "E02",
                name.place(),
                format!("`{text}` is a function; write its argument, as in `{text}(y)`"),
            );
        }
        let frame = self.frames.last().into_iter().flatten();
        let known: Vec<&str> = frame
            .map(|(name, _)| name.as_str())
            .chain(self.names.keys().map(String::as_str))
            .collect();
        if let Some(of) = words::velocity_of(text, &known) {
            return diagnostics.report(
                "E01",
                name.place(),
                format!("`{text}` is not declared; the velocity of `{of}` is `dot({of})`"),
            );
        }
        let factors = factors(text, &known);
        let message = match closest(text, known.iter().copied()) {
            _ if text.eq_ignore_ascii_case("pi") => {
                format!("`{text}` is not declared; the number is `pi`")
            }
            _ if text == words::FINAL_TIME => {
                "`time` is the final time, known to final costs in `minimize` and to `finally` only; the \
                 time at each instant is `t`"
                    .to_owned()
            }
            _ if self.role == Role::End && FINAL_TIMES.contains(&text.as_str()) => {
                format!("`{text}` is not declared; the final time is `time`, as in `minimize time`")
            }
            _ if !factors.is_empty() => {
                let product = factors.join("*");
                format!("`{text}` is not declared; write `{product}` if the product is meant")
            }
            Some(near) => format!("`{text}` is not declared; did you mean `{near}`?"),
            None if self.acts => format!(
                "`{text}` is not declared; a force that is to be found is a control, `controls {{ {text}: N }}`, and one that \
                 is given a parameter"
            ),
            None if known.is_empty() => {
                format!("`{text}` is not declared; add it to `parameters` or `coordinates`")
            }
            None => format!(
                "`{text}` is not declared; add it to `parameters` or `coordinates` (declared: {})",
                list(known)
            ),
        };
        diagnostics.report("E01", name.place(), message)
    }

    pub(super) fn undeclared_function(
        &self,
        function: &Name,
        diagnostics: &mut Diagnostics,
    ) -> Reported {
        let text = function.text.as_str();
        if text == words::AT {
            let message = "`at(time, value)` is known to `minimize`, `finally` and `at` only, which judge a motion as a whole; elsewhere a state \
                           that `when t >= 1 [s] { ... }` sets says the same";
            return diagnostics.report("E15", function.place(), message);
        }
        let mut functions: Vec<&str> = words::FUNCTIONS.to_vec();
        functions.extend(words::SPECIAL_FUNCTIONS);
        functions.extend(words::MATRIX_FUNCTIONS);
        functions.extend(
            self.names
                .iter()
                .filter(|(_, meaning)| matches!(meaning, Meaning::Function(_)))
                .map(|(name, _)| name.as_str()),
        );
        let message = if self.later.contains(text) {
            format!("`{text}` is declared further down; move its declaration up")
        } else if let Some(remedy) = words::foreign(text) {
            format!("function `{text}` is not declared; {remedy}")
        } else {
            match closest(text, functions.iter().copied()) {
                Some(near) => {
                    format!("function `{text}` is not declared; did you mean `{near}`?")
                }
                None => format!(
                    "function `{text}` is not declared; declare it by `fn {text}(y) = ...`, or \
                     write `*` if a product is meant"
                ),
            }
        };
        diagnostics.report("E01", function.place(), message)
    }

    /// Whether switches may stand here: in forces and rates, and in what is given a name for them.
    pub(super) fn may_switch(&self) -> bool {
        self.role == Role::Motion && (self.acts || self.defers)
    }

    /// Whether a name is an output with such contents.
    fn is_recorded(&self, name: &Name, contents: impl Fn(&Contents) -> bool) -> bool {
        self.recorded.get(&name.text).is_some_and(contents)
    }

    pub(super) fn is_local(&self, name: &str) -> bool {
        self.frames
            .last()
            .is_some_and(|frame| frame.iter().any(|(known, _)| known == name))
    }
}

/// Why an output that contains forces or impulses of contacts has no meaning in this role; none if it has one.
fn recorded_only(role: Role, value: &Value) -> Option<&'static str> {
    let impulses = value
        .syms()
        .into_iter()
        .any(|value| graph::depends_on(value, Variable::is_impulse));
    match role {
        Role::Record => None,
        Role::Running | Role::Constraint | Role::End if !impulses => None,
        Role::Constraint => Some(
            "the sum of impulses until each instant, which is recorded only; a condition on each impact is written with \
             `impulse(...)` itself",
        ),
        Role::Running | Role::End | Role::Impact if impulses => Some(
            "the sum of impulses until each instant, which is recorded only; write `sum(...)` with `impulse(...)` itself, \
             which adds up over all impacts",
        ),
        Role::Impact => Some(
            "the force of a contact, which acts over a time, and `sum` adds up over impacts; write `integral(...)` in \
             `minimize`",
        ),
        _ => Some(
            "the force or the impulse of a contact, which follows from the motion; it can be used in `outputs`, \
             `minimize`, `constraint` and `finally` only",
        ),
    }
}

/// The different names that a word is made of without a gap; none if it is not.
fn factors<'a>(word: &str, known: &[&'a str]) -> Vec<&'a str> {
    // The last name of what ends at each byte.
    let mut last: Vec<Option<&str>> = vec![None; word.len() + 1];
    for begin in 0..word.len() {
        if begin > 0 && last[begin].is_none() {
            continue;
        }
        for name in known {
            if word.as_bytes()[begin..].starts_with(name.as_bytes()) {
                last[begin + name.len()].get_or_insert(name);
            }
        }
    }
    let mut factors = Vec::new();
    let mut end = word.len();
    while let Some(name) = last[end] {
        factors.push(name);
        end -= name.len();
    }
    factors.reverse();
    let different: HashSet<&str> = factors.iter().copied().collect();
    // What is twice in it is rather written twice by mistake.
    if different.len() < factors.len() {
        factors.clear();
    }
    factors
}
