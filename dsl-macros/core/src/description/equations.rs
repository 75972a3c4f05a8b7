//! The derived equations as a person would write them.

use super::readable::{formula, formula_with};
use crate::derive::{ContactEquations, Equations, InverseInertia, Solution, simplify};
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{CheckedScene, Condition, Contact, OptimalControl};
use crate::words;

/// Longest vector that is written out; a longer one is given by the names of its components.
const LONGEST: usize = 240;

/// Left and right sides.
pub(super) fn readable(scene: &CheckedScene, equations: &Equations) -> Vec<[String; 2]> {
    let mut list = List {
        scene,
        names: scene
            .coordinates
            .iter()
            .map(|coordinate| coordinate.name.text.as_str())
            .collect(),
        readable: equations.readable,
        all: Vec::new(),
    };
    list.motion(equations);
    for (i, contact) in scene.contacts.iter().enumerate() {
        list.contact(contact, &equations.contacts.values(i));
    }
    list.joints(equations);
    if !scene.contacts.is_empty() {
        list.free_dynamics(equations);
    }
    for (i, contact) in scene.contacts.iter().enumerate() {
        // Dry friction acts in the free dynamics.
        if contact.bound.is_none() {
            list.auxiliary_dynamics(contact, &equations.contacts.values(i));
        }
    }
    if let Some(task) = &scene.optimal_control {
        list.optimal_control(task);
    }
    for output in &scene.outputs {
        list.add(output.name.text.clone(), simplify(output.value));
    }
    list.all.into_iter().map(Into::into).collect()
}

struct List<'a> {
    scene: &'a CheckedScene,
    /// Names of the coordinates.
    names: Vec<&'a str>,
    /// Whether accelerations and directions are formulas that a person can read.
    readable: bool,
    all: Vec<(String, String)>,
}

impl List<'_> {
    fn add(&mut self, left: String, right: Sym) {
        let right = formula(self.scene, right);
        self.all.push((left, right));
    }

    /// The components of a direction, if they can be read.
    fn components<'b>(&self, direction: &'b [Sym]) -> &'b [Sym] {
        if self.readable { direction } else { &[] }
    }

    fn motion(&mut self, equations: &Equations) {
        let (n, mechanical) = (self.names.len(), self.scene.mechanical());
        let names = self.names.clone();
        for i in 0..mechanical {
            for j in 0..=i {
                let entry = equations.mass[i * n + j];
                if !entry.is_structural_zero() {
                    self.add(format!("M({}, {})", names[i], names[j]), entry);
                }
            }
        }
        if mechanical > 0 {
            self.add("kinetic energy".to_owned(), equations.energy[0]);
            self.add("potential energy".to_owned(), equations.energy[1]);
        }
        match &equations.acceleration {
            Solution::Explicit(solution) if self.readable => {
                let pairs = names.iter().zip(&solution.values);
                for (name, &acceleration) in pairs.take(mechanical) {
                    self.add(format!("{name}''"), acceleration);
                }
            }
            _ => {
                for (name, &right) in names.iter().zip(&equations.right).take(mechanical) {
                    self.add(format!("(M q'')({name})"), right);
                }
            }
        }
        for (state, &rate) in self.scene.states.iter().zip(&equations.right[mechanical..]) {
            self.add(format!("{}'", state.name.text), rate);
        }
    }

    /// What joints hold; the accelerations and directions of contacts are those of the system in which they do.
    fn joints(&mut self, equations: &Equations) {
        let Some(derived) = &equations.joints else {
            return;
        };
        let count = derived.values.len() / 2;
        let (positions, velocities) = derived.values.split_at(count);
        let mut row = 0;
        for joint in &self.scene.joints {
            for i in 0..joint.rows.len() {
                let name = match joint.rows.len() {
                    1 => joint.name.text.clone(),
                    _ => format!("{}.{}", joint.name.text, i + 1),
                };
                if joint.holonomic {
                    self.add(format!("joint({name}) = 0"), positions[row]);
                }
                let rate = if joint.holonomic { "'" } else { "" };
                self.add(format!("joint({name}){rate} = 0"), velocities[row]);
                row += 1;
            }
        }
        let law = "M q'' = f + G' force, G = d joint'/dq', and M^-1 of contacts is that where all joints hold";
        self.all.push(("joints".to_owned(), law.to_owned()));
    }

    fn contact(&mut self, contact: &Contact, derived: &ContactEquations) {
        let name = &contact.name.text;
        if let (Some(bound), Some(derived)) = (contact.whole_bound(), &derived.friction) {
            if !contact.reset.is_empty() {
                self.add(format!("when({name})"), simplify(-derived.rows.values[0]));
                let names = self.names.clone();
                for &(index, value) in &contact.reset {
                    let state = index.checked_sub(self.scene.mechanical());
                    let set = match state.and_then(|state| self.scene.states.get(state)) {
                        Some(state) => state.name.text.clone(),
                        None => format!("{}'", names[index]),
                    };
                    self.add(format!("{set} after {name}"), value);
                }
                return;
            }
            if contact.switch.is_some() {
                self.add(format!("switch({name})"), simplify(-derived.rows.values[0]));
                let law = "-1..=1, the sign of its function where that is not 0".to_owned();
                self.all.push((format!("value({name})"), law));
                return;
            }
            self.add(format!("slip({name})"), derived.rows.values[0]);
            self.add(format!("bound({name})"), bound);
            let law = format!(
                "|friction_force({name})| <= bound({name}), against slip({name}) where that is not 0"
            );
            self.all.push((format!("dry friction({name})"), law));
            return;
        }
        self.add(format!("gap({name})"), derived.rows.values[0]);
        self.add(format!("gap({name})'"), derived.rows.values[1]);
        if let InverseInertia::Formula(inverse_inertia) = derived.inverse_inertia
            && self.readable
        {
            self.add(format!("D({name})"), inverse_inertia);
        }
        self.direction(
            "d",
            "n = grad gap",
            contact,
            self.components(&derived.rows.values[2..]),
        );
        if let Some(coefficient) = contact.restitution {
            self.add(format!("restitution({name})"), coefficient);
        }
        if let (Some(friction), Some(derived)) = (&contact.friction, &derived.friction) {
            match friction.share {
                Some(share) => self.add(format!("friction({name})"), share),
                None => {
                    let coefficient = friction.kinetic.unwrap_or(friction.coefficient);
                    self.add(format!("friction({name})"), coefficient);
                }
            }
            if friction.kinetic.is_some() {
                let at_rest = match friction.share {
                    Some(_) => "friction at rest over friction",
                    None => "friction at rest",
                };
                self.add(format!("{at_rest}({name})"), friction.coefficient);
            }
            self.add(format!("slip({name})"), derived.rows.values[0]);
            if let Some(across) = friction.across {
                self.add(format!("slip across({name})"), simplify(across));
                let law = format!(
                    "|force along both| <= friction({name})*force({name}), against the velocity where that is not 0"
                );
                self.all.push((format!("cone({name})"), law));
            }
            self.direction(
                "e",
                "b = d slip/dv",
                contact,
                self.components(&derived.rows.values[1..]),
            );
        }
    }

    /// Costs and the functions of conditions.
    fn optimal_control(&mut self, task: &OptimalControl) {
        let path = names(
            "running cost",
            task.running_cost,
            "constraint",
            &task.constraints,
        );
        for (name, function) in path {
            self.add(name, simplify(function));
        }
        for (name, function) in names("", None, "constraint", &task.at_impacts) {
            self.add(name, simplify(function));
        }
        for (name, function) in names("final cost", task.final_cost, "goal", &task.goals) {
            let named = graph::substitute(&[simplify(function)], |variable| {
                (variable == Variable::Time).then(|| Sym::variable(Variable::Argument(0)))
            });
            let right = formula_with(self.scene, named[0], &[words::FINAL_TIME.to_owned()]);
            self.all.push((name, right));
        }
    }

    /// Components of a direction, or what they solve.
    fn direction(&mut self, letter: &str, vector: &str, contact: &Contact, components: &[Sym]) {
        let name = &contact.name.text;
        if components.is_empty() {
            let held: Vec<&str> = contact.held.iter().map(|&i| self.names[i]).collect();
            let locked = if held.is_empty() {
                String::new()
            } else {
                format!(" with {} locked", held.join(", "))
            };
            let of = vector.chars().next().unwrap_or_default();
            self.all.push((
                format!("{letter}({name})"),
                format!("H {of}/D, {vector}, H = M^-1{locked}, D = n' H n"),
            ));
        }
        for (coordinate, &component) in self.names.clone().iter().zip(components) {
            self.add(format!("{letter}({name}, {coordinate})"), component);
        }
    }

    /// `(q, v, t)' = f_free` between impacts.
    fn free_dynamics(&mut self, equations: &Equations) {
        let rates = self.names.iter().map(|name| format!("{name}'"));
        let formulas = match &equations.acceleration {
            Solution::Explicit(solution) if self.readable => self.short(&solution.values, &[]),
            _ => None,
        };
        let accelerations =
            formulas.unwrap_or_else(|| self.names.iter().map(|name| format!("{name}''")).collect());
        let components: Vec<String> = rates.chain(accelerations).chain(["1".to_owned()]).collect();
        let right = format!("({})", components.join(", "));
        self.all.push(("f_free".to_owned(), right));
    }

    /// The components of a vector, if they are short enough to be written into one line.
    fn short(&self, vector: &[Sym], names: &[String]) -> Option<Vec<String>> {
        let components: Vec<String> = vector
            .iter()
            .map(|&component| formula_with(self.scene, component, names))
            .collect();
        let length: usize = components.iter().map(String::len).sum();
        let complete = components.iter().all(|text| !text.ends_with("operations)"));
        (complete && length <= LONGEST).then_some(components)
    }

    /// The auxiliary dynamics of time-freezing, `(q, v, t)' = f_aux` while the clock stands still, and
    /// where they act: `v' = a_bar (d -+ mu e)` with any `a_bar > 0`, while the gap is negative and closing.
    /// With restitution the gap goes on moving while the coordinates rest, and opens again at `e^2` times
    /// that rate, so that it has the velocity `-e v_n-` where it is zero again. Sources: Nurkanovic,
    /// Albrecht, Brogliato, Diehl, "The time-freezing reformulation for numerical optimal control of
    /// complementarity Lagrangian systems with state jumps" (Automatica 158, 2023), for the inelastic law
    /// and friction.
    fn auxiliary_dynamics(&mut self, contact: &Contact, derived: &ContactEquations) {
        let name = &contact.name.text;
        let frozen = if contact.restitution.is_some() {
            format!("gap({name}) < 0, which goes on by gap({name})' while q rests")
        } else {
            format!("gap({name}) < 0 and gap({name})' < 0")
        };
        self.all.push((format!("frozen({name})"), frozen));
        let normal = Some(self.components(&derived.rows.values[2..])).filter(|d| !d.is_empty());
        match (&contact.friction, &derived.friction) {
            (Some(friction), Some(tangent)) => {
                let tangential =
                    Some(self.components(&tangent.rows.values[1..])).filter(|e| !e.is_empty());
                for (region, sign, shown) in [("slip > 0", -1.0, '-'), ("slip < 0", 1.0, '+')] {
                    let mu = friction
                        .kinetic
                        .unwrap_or(friction.coefficient)
                        .scaled(sign);
                    let direction: Option<Vec<Sym>> = normal.zip(tangential).map(|(d, e)| {
                        let pairs = d.iter().zip(e);
                        pairs.map(|(&d, &e)| simplify(d + mu * e)).collect()
                    });
                    let words = format!("(d({name}) {shown} friction({name})*e({name}))");
                    let field = self.field(direction.as_deref(), &words);
                    self.all.push((format!("f_aux({name}, {region})"), field));
                }
            }
            _ => {
                let field = self.field(normal, &format!("d({name})"));
                self.all.push((format!("f_aux({name})"), field));
            }
        }
        if contact.restitution.is_some() {
            self.all.push((
                format!("f_aux({name}) opening"),
                format!("restitution({name})^2*f_aux({name}) where gap({name})' > 0"),
            ));
        }
    }

    /// Rates of coordinates, velocities and clock for a direction of the impulse, which is called `words`
    /// where there is no formula for it, or a long one.
    fn field(&self, direction: Option<&[Sym]>, words: &str) -> String {
        let a_bar = Sym::variable(Variable::Argument(0));
        let written = direction.and_then(|direction| {
            let rates: Vec<Sym> = direction.iter().map(|&d| simplify(a_bar * d)).collect();
            self.short(&rates, &["a_bar".to_owned()])
        });
        match written {
            Some(rates) => format!("({}{}, 0)", "0, ".repeat(rates.len()), rates.join(", ")),
            None => format!("(0, a_bar*{words}, 0)"),
        }
    }
}

/// The functions of optimal control, and what they are called.
fn names(
    cost: &str,
    costs: Option<Sym>,
    kind: &str,
    conditions: &[Condition],
) -> Vec<(String, Sym)> {
    let conditions = conditions
        .iter()
        .map(|condition| (format!("{kind}({})", condition.name), condition.function));
    costs
        .map(|function| (cost.to_owned(), function))
        .into_iter()
        .chain(conditions)
        .collect()
}
