//! Switches in forces and rates, as contacts whose normal force is given.
//!
//! What acts is linear in the signs `s_k` of the switching functions `c_k`, so that by Filippov's rule
//!
//! ```text
//! f = f_0 + sum_k a_k s_k        |s_k| <= 1,  s_k = sign c_k unless c_k = 0
//! ```
//!
//! which is the law of dry friction with the bound 1 and the sliding velocity `-c_k`, but for its direction: `a_k` instead of the
//! gradient of `c_k`. The convex combination of Stewart is `(1 + s_k)/2`. Of a kink, `|c_k| = c_k s_k`, the direction vanishes with
//! `c_k`.

use super::branch;
use super::checker::Checker;
use crate::ast::Name;
use crate::derive::simplify;
use crate::diagnostics::Checked;
use crate::evaluate::Switch;
use crate::graph::{self, Compose, Function, Sym, Variable};
use crate::scene::{Action, Contact};

/// Takes the switches out of the forces, and puts a contact for each that is needed behind the others.
pub(super) fn append(
    checker: &mut Checker<'_>,
    forces: &mut [Sym],
    contacts: &mut Vec<Contact>,
) -> Checked<()> {
    let mut switches = std::mem::take(&mut checker.scope.switches);
    for switch in &switches {
        if is_smooth(switch, forces) {
            let size = switch.function.call(Function::Abs);
            replace(forces, |variable| {
                (variable == switch.variable).then_some(size)
            });
        }
    }
    branch::linear(&mut switches, forces);
    for output in &mut checker.shown.outputs {
        branch::linear(&mut switches, std::slice::from_mut(&mut output.value));
    }
    one_after_the_other(&switches, forces);
    let acting = graph::variables(forces);
    let acting: Vec<&Switch> = switches
        .iter()
        .filter(|switch| acting.contains(&switch.variable))
        .collect();
    let still = |variable| matches!(variable, Variable::Switch(_)).then_some(Sym::ZERO);
    let (before, first) = (checker.diagnostics.mistakes(), contacts.len());
    for (k, switch) in acting.iter().enumerate() {
        let slopes = graph::partial(forces, switch.variable);
        if let Some(other) = acting[..=k]
            .iter()
            .rev()
            .find(|other| depends(&slopes, other))
        {
            product(checker, switch, other);
            continue;
        }
        let mut action: Vec<Sym> = slopes.into_iter().map(simplify).collect();
        if switch.kink {
            action.iter_mut().for_each(|a| *a *= switch.function);
        }
        let action = Action {
            usual: graph::substitute(&action, |variable| usual(checker, variable)),
            kink: switch.kink || vanishes(switch, &action),
            force: action,
        };
        contacts.push(contact(switch, action));
    }
    shown(checker, &switches, &acting, first);
    replace(forces, still);
    checker.diagnostics.none_since(before)
}

/// Writes products of switches one of which never is 1 before the other one as sums: where `c_2 - c_1` is a number or a function of
/// parameters, above 0, `s_1 s_2 = 1 + s_1 - s_2`, also where either slides; below 0 the two change places.
fn one_after_the_other(switches: &[Switch], forces: &mut [Sym]) {
    let jumps: Vec<&Switch> = switches.iter().filter(|switch| !switch.kink).collect();
    for (k, second) in jumps.iter().enumerate() {
        for first in &jumps[..k] {
            let of_both = graph::partial(&graph::partial(forces, first.variable), second.variable);
            let of_both: Vec<Sym> = of_both.into_iter().map(simplify).collect();
            let (one, other) = (
                Sym::variable(first.variable),
                Sym::variable(second.variable),
            );
            let apart = |sign: f64| {
                let apart = simplify(second.function - first.function.scaled(sign));
                let stays = !graph::depends_on(apart, Variable::moves);
                stays.then(|| apart.call(Function::Sign))
            };
            let sum = match (apart(1.0), apart(-1.0)) {
                (Some(apart), _) => Sym::ONE + (one - other) * apart,
                (_, Some(apart)) => (one + other) * apart - Sym::ONE,
                _ => continue,
            };
            for (force, of_both) in forces.iter_mut().zip(of_both) {
                *force = simplify(*force + of_both * (sum - one * other));
            }
        }
    }
}

fn replace(values: &mut [Sym], by: impl Fn(Variable) -> Option<Sym>) {
    let replaced = graph::substitute(values, by);
    values.copy_from_slice(&replaced);
}

fn depends(slopes: &[Sym], switch: &Switch) -> bool {
    slopes
        .iter()
        .any(|&slope| graph::depends_on(simplify(slope), |variable| variable == switch.variable))
}

/// A control as large as it is usually: the root mean square of its bounds, or 1 in its unit.
fn usual(checker: &Checker<'_>, variable: Variable) -> Option<Sym> {
    let Variable::Control(i) = variable else {
        return None;
    };
    let bounds = checker.controls.get(usize::from(i))?.bounds;
    let size = bounds.map(|(low, high)| (low * low + high * high).scaled(0.5).power(1));
    let is_size = |size: &Sym| {
        let value = checker.at_default(*size);
        value.is_some_and(|value| value.is_finite() && value > 0.0)
    };
    Some(size.filter(is_size).unwrap_or(Sym::ONE))
}

fn contact(switch: &Switch, action: Action) -> Contact {
    let name = Name::at(switch.place, switch.shown.replace('\n', ""));
    let documentation = crate::ast::Documentation::default();
    Contact {
        switch: Some(action),
        ..Contact::dry(name, documentation, (-switch.function, Sym::ONE))
    }
}

/// Whether a kink leaves no jump of the derivatives of what acts: the slope by `|c|` vanishes with `c`. Any
/// other kink is a switch, which is right as well.
fn is_smooth(switch: &Switch, forces: &[Sym]) -> bool {
    if !switch.kink {
        return false;
    }
    let slopes = graph::partial(forces, switch.variable);
    vanishes(switch, &slopes)
}

/// Whether values vanish with the function of a switch, and with its size. Told where the function is linear in one of its
/// variables.
fn vanishes(switch: &Switch, slopes: &[Sym]) -> bool {
    let function = switch.function;
    let mut variables = graph::variables(&[function]).into_iter();
    variables.any(|variable| {
        let by = simplify(graph::partial(&[function], variable)[0]);
        if by.is_structural_zero() || graph::depends_on(by, |other| other == variable) {
            return false;
        }
        let zero = |other| (other == variable).then_some(Sym::ZERO);
        let rest = graph::substitute(&[function], zero)[0];
        let root = simplify(-rest * by.power(-2));
        let at_root = |other| {
            if other == variable {
                Some(root)
            } else {
                (other == switch.variable).then_some(Sym::ZERO)
            }
        };
        let slopes = graph::substitute(slopes, at_root).into_iter();
        slopes
            .into_iter()
            .all(|slope| simplify(slope).is_structural_zero())
    })
}

/// E12: what two switches do together is not said by what each does.
fn product(checker: &mut Checker<'_>, switch: &Switch, other: &Switch) {
    let message = format!(
        "what acts contains a product of the switches `{}` and `{}`, as of one inside of the other, and where both functions vanish \
         the motion is not determined by that; write a sum of terms with one switch each, or switches by functions that differ by \
         a number, as in `if x >= 2 {{ a }} else if x >= 1 {{ b }} else {{ c }}`",
        other.shown, switch.shown
    );
    checker.diagnostics.report("E12", switch.place, message);
}

/// Lets outputs know switches: those that act by the value that they have, also where the motion slides, the others by their
/// functions.
fn shown(checker: &mut Checker<'_>, switches: &[Switch], acting: &[&Switch], first: usize) {
    let value = |variable: Variable| {
        let switch = switches.iter().find(|known| known.variable == variable)?;
        let contact = acting.iter().position(|known| known.variable == variable);
        Some(match contact {
            _ if switch.kink => switch.function.call(Function::Abs),
            Some(k) => Sym::variable(Variable::FrictionForce((first + k) as u16)),
            None => switch.function.call(Function::Sign),
        })
    };
    for output in &mut checker.shown.outputs {
        output.value = graph::substitute(&[output.value], value)[0];
    }
}
