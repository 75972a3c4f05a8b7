//! Expressions as a person would write them.

use crate::graph::{self, Node, Sym, Variable};
use crate::scene::CheckedScene;
use std::fmt::Write;

/// Longest formula that is printed in full; longer ones are summarised by their operation count.
const LONGEST: usize = 600;

const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const POWER: u8 = 3;

/// The expression in the names of the scene; velocities are written `y'`.
pub(crate) fn formula(scene: &CheckedScene, sym: Sym) -> String {
    formula_with(scene, sym, &[])
}

/// The expression in the names of the scene and those of further variables: `Argument(i)` is called `names[i]`.
pub(crate) fn formula_with(scene: &CheckedScene, sym: Sym, names: &[String]) -> String {
    let mut printer = Printer {
        scene,
        names,
        text: String::new(),
    };
    match printer.write(sym, 0) {
        Ok(()) => printer.text,
        Err(TooLong) => format!("({} operations)", crate::tape::operations(&[sym])),
    }
}

/// A constant without the roundings of its last digit: 0.4^2 is 0.16.
fn number(value: f64) -> String {
    let short = format!("{value:.14e}").parse().unwrap_or(value);
    let shown = if (short - value).abs() <= 4.0 * f64::EPSILON * value.abs() {
        short
    } else {
        value
    };
    if shown != 0.0 && shown.abs() < 1e-4 {
        format!("{shown:e}")
    } else {
        shown.to_string()
    }
}

struct TooLong;

struct Printer<'a> {
    scene: &'a CheckedScene,
    names: &'a [String],
    text: String,
}

impl Printer<'_> {
    fn push(&mut self, text: &str) -> Result<(), TooLong> {
        self.text.push_str(text);
        if self.text.len() > LONGEST {
            Err(TooLong)
        } else {
            Ok(())
        }
    }

    fn write(&mut self, sym: Sym, outer: u8) -> Result<(), TooLong> {
        match sym.node() {
            Node::Number(bits) => {
                let value = f64::from_bits(bits);
                if value < 0.0 && outer > SUM {
                    self.push(&format!("({})", number(value)))
                } else {
                    self.push(&number(value))
                }
            }
            Node::Variable(variable) => {
                let name = self.name(variable);
                self.push(&name)
            }
            Node::Sum(terms) => {
                let mut terms: Vec<(Sym, f64)> = terms
                    .iter()
                    .map(|&(term, bits)| (term, f64::from_bits(bits)))
                    .collect();
                if let [(term, coefficient)] = terms.as_slice() {
                    return self.scaled(*term, *coefficient, outer);
                }
                // Positive terms first, constants last among their sign.
                terms.sort_by_key(|&(term, coefficient)| (coefficient < 0.0, term == Sym::ONE));
                if outer > SUM {
                    self.push("(")?;
                }
                for (i, &(term, coefficient)) in terms.iter().enumerate() {
                    if i > 0 {
                        self.push(if coefficient < 0.0 { " - " } else { " + " })?;
                        self.scaled(term, coefficient.abs(), PRODUCT)?;
                    } else {
                        self.scaled(term, coefficient, PRODUCT)?;
                    }
                }
                if outer > SUM {
                    self.push(")")?;
                }
                Ok(())
            }
            Node::Product(factors) => self.fraction(&factors, None, outer),
            Node::Kept(inner) => self.write(inner, outer),
            Node::Call(function, argument) => {
                self.push(function.name())?;
                if let graph::Function::Profile(profile) = function {
                    self.push(&"'".repeat(usize::from(profile.order())))?;
                }
                self.push("(")?;
                self.write(argument, 0)?;
                self.push(")")
            }
            Node::Call2(graph::Function2::Power, base, exponent) => {
                self.write(base, POWER + 1)?;
                self.push("^")?;
                self.write(exponent, POWER + 1)
            }
            Node::Call2(function, first, second) => {
                self.push(function.name())?;
                self.push("(")?;
                self.write(first, 0)?;
                self.push(", ")?;
                self.write(second, 0)?;
                self.push(")")
            }
        }
    }

    fn scaled(&mut self, term: Sym, coefficient: f64, outer: u8) -> Result<(), TooLong> {
        if term == Sym::ONE {
            return self.write(Sym::number(coefficient), outer);
        }
        if coefficient == 1.0 {
            return self.write(term, outer);
        }
        if coefficient == -1.0 {
            self.push("-")?;
            return self.write(term, PRODUCT);
        }
        self.fraction(&graph::factors_of(term), Some(coefficient), outer)
    }

    fn fraction(
        &mut self,
        factors: &[(Sym, i32)],
        coefficient: Option<f64>,
        outer: u8,
    ) -> Result<(), TooLong> {
        let brackets = outer > PRODUCT;
        if brackets {
            self.push("(")?;
        }
        let mut first = true;
        // 0.5*x reads better as x/2.
        let mut divisor = None;
        if let Some(coefficient) = coefficient {
            let inverse = 1.0 / coefficient;
            if coefficient.abs() < 1.0 && inverse.fract() == 0.0 && inverse.abs() < 1000.0 {
                divisor = Some(inverse.abs());
                if coefficient < 0.0 {
                    self.push("-")?;
                }
            } else {
                self.push(&number(coefficient))?;
                first = false;
            }
        }
        // What has a name for this formula only stands first.
        let (named, others): (Vec<_>, Vec<_>) = factors
            .iter()
            .filter(|&&(_, halves)| halves > 0)
            .partition(|(base, _)| matches!(base.node(), Node::Variable(Variable::Argument(_))));
        for &(base, halves) in named.into_iter().chain(others) {
            if !first {
                self.push("*")?;
            }
            first = false;
            self.power(base, halves)?;
        }
        if first {
            self.push("1")?;
        }
        let below: Vec<(Sym, i32)> = factors
            .iter()
            .filter(|&&(_, halves)| halves < 0)
            .map(|&(base, halves)| (base, -halves))
            .collect();
        let count = below.len() + usize::from(divisor.is_some());
        if count > 0 {
            self.push("/")?;
            if count > 1 {
                self.push("(")?;
            }
            if let Some(divisor) = divisor {
                self.push(&number(divisor))?;
            }
            for (i, &(base, halves)) in below.iter().enumerate() {
                if i > 0 || divisor.is_some() {
                    self.push("*")?;
                }
                self.power(base, halves)?;
            }
            if count > 1 {
                self.push(")")?;
            }
        }
        if brackets {
            self.push(")")?;
        }
        Ok(())
    }

    fn power(&mut self, base: Sym, halves: i32) -> Result<(), TooLong> {
        match halves {
            1 => {
                self.push("sqrt(")?;
                self.write(base, 0)?;
                self.push(")")
            }
            2 => self.write(base, POWER),
            _ => {
                self.write(base, POWER + 1)?;
                let mut exponent = String::new();
                let _ = if halves % 2 == 0 {
                    write!(exponent, "^{}", halves / 2)
                } else {
                    write!(exponent, "^({halves}/2)")
                };
                self.push(&exponent)
            }
        }
    }

    fn contact(&self, i: u16) -> &str {
        let contact = self.scene.contacts.get(usize::from(i));
        contact.map_or("", |contact| &contact.name.text)
    }

    /// What belongs to an equation of a joint: `word(name)`, with its number behind a point if the joint has several.
    fn joint(&self, word: &str, row: u16) -> String {
        let mut first = 0;
        for joint in &self.scene.joints {
            let own = usize::from(row) - first;
            if own < joint.rows.len() {
                return match joint.rows.len() {
                    1 => format!("{word}({})", joint.name.text),
                    _ => format!("{word}({}).{}", joint.name.text, own + 1),
                };
            }
            first += joint.rows.len();
        }
        String::new()
    }

    fn name(&self, variable: Variable) -> String {
        let named = |list: &[crate::scene::Coordinate], i: u16, suffix: &str| {
            list.get(usize::from(i))
                .map_or_else(String::new, |known| format!("{}{suffix}", known.name.text))
        };
        match variable {
            Variable::Parameter(i) => {
                let Some(parameter) = self.scene.parameters.get(usize::from(i)) else {
                    return String::new();
                };
                parameter.name.text.clone()
            }
            Variable::Coordinate(i) => named(&self.scene.coordinates, i, ""),
            Variable::Velocity(i) => match usize::from(i).checked_sub(self.scene.mechanical()) {
                Some(state) => named(&self.scene.states, state as u16, ""),
                None => named(&self.scene.coordinates, i, "'"),
            },
            Variable::Control(i) => named(&self.scene.controls, i, ""),
            Variable::ContactForce(i) => format!("force({})", self.contact(i)),
            Variable::FrictionForce(i) => format!("friction_force({})", self.contact(i)),
            Variable::ContactImpulse(i) => format!("impulse({})", self.contact(i)),
            Variable::FrictionImpulse(i) => format!("friction_impulse({})", self.contact(i)),
            Variable::Time => "t".to_owned(),
            Variable::Provided(i) => format!("r({})", self.contact(i)),
            Variable::ProvidedSliding(i) => format!("s({})", self.contact(i)),
            Variable::Sum(i) => {
                let task = self.scene.optimal_control.as_ref();
                let summed = task.and_then(|task| task.sums.get(usize::from(i)));
                format!(
                    "sum({})",
                    summed.map_or_else(String::new, |&sum| formula(self.scene, sum))
                )
            }
            Variable::JointForce(i) => self.joint("force", i),
            Variable::JointHeld(i) => self.joint("held", i),
            Variable::Switch(i) => format!("s{i}"),
            Variable::Start(i) => format!("start{i}"),
            Variable::Epigraph(i) => format!("largest{i}"),
            Variable::Multiplier(i) => format!("lambda{i}"),
            Variable::Unknown(i) => format!("a{i}"),
            Variable::Argument(i) => {
                let name = self.names.get(usize::from(i)).cloned();
                name.unwrap_or_else(|| format!("arg{i}"))
            }
        }
    }
}
