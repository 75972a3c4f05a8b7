//! The derived equations as a person would write them.

use super::readable::{formula, formula_with};
use crate::derive::{
    ContactEquations, ControlEquations, Equations, InverseInertia, Solution, simplify,
};
use crate::graph::{self, Function, Sym, Variable};
use crate::scene::{CheckedScene, Condition, Contact, OptimalControl};
use crate::words;

/// Longest vector that is written out; a longer one is given by the names of its components.
const LONGEST: usize = 240;

/// Left and right sides.
pub(super) fn readable(scene: &CheckedScene, equations: &Equations) -> Vec<(String, String)> {
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
    for (contact, derived) in scene.contacts.iter().zip(&equations.contacts) {
        list.contact(contact, derived);
    }
    if !scene.contacts.is_empty() {
        list.free_dynamics(equations);
    }
    for (contact, derived) in scene.contacts.iter().zip(&equations.contacts) {
        list.auxiliary_dynamics(contact, derived);
    }
    if let (Some(task), Some(derived)) = (&scene.optimal_control, &equations.optimal_control) {
        list.optimal_control(task, derived);
    }
    list.all
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
        let n = self.names.len();
        let names = self.names.clone();
        for i in 0..n {
            for j in 0..=i {
                let entry = equations.mass[i * n + j];
                if !entry.is_structural_zero() {
                    self.add(format!("M({}, {})", names[i], names[j]), entry);
                }
            }
        }
        self.add("kinetic energy".to_owned(), equations.energy[0]);
        self.add("potential energy".to_owned(), equations.energy[1]);
        match &equations.acceleration {
            Solution::Explicit(solution) if self.readable => {
                for (name, &acceleration) in names.iter().zip(&solution.values) {
                    self.add(format!("{name}''"), acceleration);
                }
            }
            _ => {
                for (name, &right) in names.iter().zip(&equations.right) {
                    self.add(format!("(M q'')({name})"), right);
                }
            }
        }
    }

    fn contact(&mut self, contact: &Contact, derived: &ContactEquations) {
        let name = &contact.name.text;
        self.add(format!("gap({name})"), derived.rows.values[0]);
        self.add(format!("gap({name})'"), derived.rows.values[1]);
        if let InverseInertia::Formula(inverse_inertia) = derived.inverse_inertia
            && self.readable
        {
            self.add(format!("D({name})"), inverse_inertia);
        }
        self.direction("d", "n = grad gap", contact, self.components(&derived.rows.values[2..]));
        if let Some(coefficient) = contact.restitution {
            self.add(format!("restitution({name})"), coefficient);
        }
        if let (Some(friction), Some(derived)) = (&contact.friction, &derived.friction) {
            self.add(format!("friction({name})"), friction.coefficient);
            self.add(format!("slip({name})"), derived.rows.values[0]);
            self.direction("e", "b = d slip/dv", contact, self.components(&derived.rows.values[1..]));
        }
    }

    /// Costs and the functions of conditions.
    fn optimal_control(&mut self, task: &OptimalControl, derived: &ControlEquations) {
        let path = names(
            "running cost",
            task.running_cost,
            "constraint",
            &task.constraints,
        );
        for (name, &function) in path.into_iter().zip(&derived.path.values) {
            self.add(name, function);
        }
        let terminal = names("final cost", task.final_cost, "goal", &task.goals);
        for (name, function) in terminal.into_iter().zip(&derived.terminal.values) {
            let named = graph::substitute(&[*function], |variable| {
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
    /// where they act.
    ///
    /// Without restitution `v' = a_n (d -+ mu e)` with any `a_n > 0`; with it, a spring and a damper in
    /// the gap, `q' = d v_n` and `v' = d (-k_n g - c_n v_n)`, whose damping follows from the coefficient
    /// of restitution. Sources: Nurkanovic, Sartor, Albrecht, Diehl, "A time-freezing approach for
    /// numerical optimal control of nonsmooth differential equations with state jumps" (2021), for the
    /// elastic law; Nurkanovic, Albrecht, Brogliato, Diehl, "The time-freezing reformulation for numerical
    /// optimal control of complementarity Lagrangian systems with state jumps" (2023), for the inelastic
    /// one and for friction.
    fn auxiliary_dynamics(&mut self, contact: &Contact, derived: &ContactEquations) {
        let name = &contact.name.text;
        let elastic = contact.restitution.is_some();
        let frozen = if elastic {
            format!("gap({name}) < 0")
        } else {
            format!("gap({name}) < 0 and gap({name})' < 0")
        };
        self.all.push((format!("frozen({name})"), frozen));
        let normal = Some(self.components(&derived.rows.values[2..])).filter(|d| !d.is_empty());
        match (&contact.friction, &derived.friction) {
            (Some(friction), Some(tangent)) => {
                let tangential = Some(self.components(&tangent.rows.values[1..])).filter(|e| !e.is_empty());
                let coupling = match tangential {
                    Some(e) => product(&derived.normal, e),
                    None => Sym::ONE,
                };
                let coupled = elastic && !coupling.is_structural_zero();
                for (region, sign, shown) in [("slip > 0", -1.0, '-'), ("slip < 0", 1.0, '+')] {
                    let mu = friction.coefficient.scaled(sign);
                    // So that the normal velocity is that of spring and damper.
                    let scale = if elastic {
                        simplify(Sym::ONE + mu * coupling).power(-2)
                    } else {
                        Sym::ONE
                    };
                    let direction: Option<Vec<Sym>> = normal.zip(tangential).map(|(d, e)| {
                        let pairs = d.iter().zip(e);
                        pairs
                            .map(|(&d, &e)| simplify((d + mu * e) * scale))
                            .collect()
                    });
                    let mut words = format!("(d({name}) {shown} friction({name})*e({name}))");
                    if coupled {
                        words += &format!("/(1 {shown} friction({name})*n'e({name}))");
                    }
                    let field = self.field(name, direction.as_deref(), &words, elastic);
                    self.all.push((format!("f_aux({name}, {region})"), field));
                }
            }
            _ => {
                let field = self.field(name, normal, &format!("d({name})"), elastic);
                self.all.push((format!("f_aux({name})"), field));
            }
        }
        if let Some(coefficient) = contact.restitution {
            self.damper(name, coefficient);
        }
    }

    /// Rates of coordinates, velocities and clock for a direction of the impulse, which is called `words`
    /// where there is no formula for it, or a long one.
    fn field(
        &self,
        contact: &str,
        direction: Option<&[Sym]>,
        words: &str,
        elastic: bool,
    ) -> String {
        let gap = format!("gap({contact})");
        let names = ["a_n", "k_n", "c_n", gap.as_str(), &format!("{gap}'")].map(str::to_owned);
        let [a_n, k_n, c_n, gap, rate] =
            [0, 1, 2, 3, 4].map(|i| Sym::variable(Variable::Argument(i)));
        let (moving, force) = if elastic {
            (rate, -(k_n * gap) - c_n * rate)
        } else {
            (Sym::ZERO, a_n)
        };
        let written = direction.and_then(|direction| {
            let along = |factor: Sym| direction.iter().map(move |&d| simplify(factor * d));
            let components: Vec<Sym> = along(moving).chain(along(force)).collect();
            self.short(&components, &names)
        });
        if let Some(components) = written {
            return format!("({}, 0)", components.join(", "));
        }
        let along = |factor: Sym| match formula_with(self.scene, factor, &names) {
            zero if zero == "0" => zero,
            sum if sum.contains(' ') => format!("({sum})*{words}"),
            single => format!("{single}*{words}"),
        };
        format!("({}, {}, 0)", along(moving), along(force))
    }

    /// `c_n = 2 |ln e| sqrt(k_n / (pi^2 + ln^2 e))`: the half oscillation of a linear spring and damper
    /// turns a velocity into `-e` times itself.
    fn damper(&mut self, contact: &str, coefficient: Sym) {
        let names = [
            "k_n".to_owned(),
            "pi".to_owned(),
            format!("restitution({contact})"),
        ];
        let [k_n, pi, named] = [0, 1, 2].map(|i| Sym::variable(Variable::Argument(i)));
        let e = if coefficient.as_number().is_some() {
            named
        } else {
            coefficient
        };
        let logarithm = e.call(Function::Ln);
        let root = (k_n / (pi.square() + logarithm.square())).power(1);
        let right = (logarithm * root).scaled(-2.0);
        let right = formula_with(self.scene, right, &names);
        self.all.push((format!("c_n({contact})"), right));
    }
}

/// What the functions of optimal control are called.
fn names(cost: &str, has: Option<Sym>, kind: &str, conditions: &[Condition]) -> Vec<String> {
    let conditions = conditions
        .iter()
        .map(|condition| format!("{kind}({})", condition.name));
    has.map(|_| cost.to_owned())
        .into_iter()
        .chain(conditions)
        .collect()
}

fn product(a: &[Sym], b: &[Sym]) -> Sym {
    simplify(a.iter().zip(b).map(|(&a, &b)| a * b).sum())
}
