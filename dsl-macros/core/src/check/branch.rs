//! Branches of what acts: each is evaluated everywhere, and multiplied with 0 where the other one acts.
//!
//! What acts is some function of the sign `s` of a switching function `c` and of its size. As `s` has two values it is linear in it,
//!
//! ```text
//! f(s, |c|) = (f_+ + f_-)/2 + s (f_+ - f_-)/2        f_+ = f(1, c)    f_- = f(-1, -c)
//! ```
//!
//! which is also Filippov's mixture where `c` is held at zero.

use crate::derive::simplify;
use crate::evaluate::Switch;
use crate::graph::{self, Compose, Function, Sym, Variable};

/// Writes what acts as linear in the sign of each function, if it is not, and branches with values everywhere.
pub(super) fn linear(switches: &mut Vec<Switch>, values: &mut [Sym]) {
    let mut done = 0;
    while let Some(switch) = switches.get(done).cloned() {
        done += 1;
        let same = |known: &&Switch| known.function == switch.function;
        if switches[..done - 1].iter().any(|known| same(&known)) {
            continue;
        }
        let own: Vec<Switch> = switches.iter().filter(same).cloned().collect();
        let side = |value: Sym, sign: f64| {
            let at = |variable| {
                let known = own.iter().find(|known| known.variable == variable)?;
                Some(match known.kink {
                    true => switch.function.scaled(sign),
                    false => Sym::number(sign),
                })
            };
            graph::substitute(&[value], at)[0]
        };
        let is_own = |variable| own.iter().any(|known| known.variable == variable);
        for value in values
            .iter_mut()
            .filter(|value| graph::contains(**value, is_own))
        {
            let sides = [1.0, -1.0].map(|sign| side(*value, sign));
            let [yes, no] = [(0, 1.0), (1, -1.0)]
                .map(|(k, sign): (usize, f64)| acting(sides[k], switch.function.scaled(sign)));
            if [yes, no] == sides && is_linear(*value, &own) {
                continue;
            }
            let sign = sign_of(&switch, switches);
            *value = simplify((yes + no).scaled(0.5) + (yes - no).scaled(0.5) * sign);
        }
    }
}

/// Whether a value is linear in what stands for one function.
fn is_linear(value: Sym, own: &[Switch]) -> bool {
    let is_own = |variable| own.iter().any(|known| known.variable == variable);
    own.iter().all(|known| {
        let slope = simplify(graph::partial(&[value], known.variable)[0]);
        !graph::depends_on(slope, is_own)
    })
}

/// What stands for the sign of the function of a switch.
fn sign_of(switch: &Switch, switches: &mut Vec<Switch>) -> Sym {
    let known = switches.iter();
    let mut known = known.filter(|known| !known.kink && known.function == switch.function);
    if let Some(known) = known.next() {
        return Sym::variable(known.variable);
    }
    let variable = Variable::Switch(switches.len() as u16);
    switches.push(Switch {
        variable,
        kink: false,
        ..switch.clone()
    });
    Sym::variable(variable)
}

/// A branch that acts where `condition` is positive, with values wherever it does not: a root of what the condition keeps from
/// being negative is 0 beyond that.
///
/// ```text
/// sqrt(a c + b) = sqrt(a) root(c) for b = 0, sqrt(a max(c, 0) + b) otherwise
/// ```
///
/// What has no value for another reason has none here either.
fn acting(value: Sym, condition: Sym) -> Sym {
    graph::with_roots(value, |base, halves| {
        let (slope, rest) = by(base, condition)?;
        if !rest.is_structural_zero() {
            let largest = (condition + condition.call(Function::Abs)).scaled(0.5);
            return Some((slope * largest + rest).power(halves));
        }
        let root = match halves > 0 {
            true => condition.call(Function::Root) * condition.power(halves - 1),
            false => condition.call(Function::InverseRoot) * condition.power(halves + 1),
        };
        Some(slope.power(halves) * root)
    })
}

/// `a` and `b` of an expression `a condition + b`, if they do not move.
fn by(base: Sym, condition: Sym) -> Option<(Sym, Sym)> {
    let still = |sym: Sym| !graph::depends_on(sym, Variable::moves);
    let mut variables = graph::variables(&[condition]).into_iter();
    let variable = variables.find(|variable| variable.moves())?;
    let of = |sym| simplify(graph::partial(&[sym], variable)[0]);
    let slope = simplify(of(base) * of(condition).power(-2));
    if slope.is_structural_zero() || !still(slope) {
        return None;
    }
    let rest = simplify(base - slope * condition);
    still(rest).then_some((slope, rest))
}
