//! Measured motions, and the objective that compares with them, `minimize misfit(name)`.

use super::checker::Checker;
use super::states;
use super::values::{self, StartValues, Target};
use crate::ast::{Expr, Kind, Measured, MeasuredQuantity, Name, Operator, Scene, Statement};
use crate::declaration;
use crate::diagnostics::{Checked, Place, closest, list};
use crate::evaluate::Meaning;
use crate::graph::Sym;
use crate::scene::Experiment;
use crate::words;

/// From how many standard deviations on a residual counts linearly: 95 % of the efficiency of squares where the errors are
/// normal (Huber, *Robust Statistics*, 1981).
const HUBER: f64 = 1.345;

/// A term of the objective.
struct Term {
    experiment: Name,
    huber: Option<f64>,
}

/// Whether an objective contains a misfit; a function that the scene calls so is none.
pub(super) fn is_misfit(checker: &Checker<'_>, objective: &Expr) -> bool {
    !checker.scope.names.contains_key(words::MISFIT) && objective.calls(words::MISFIT)
}

/// The experiments that the objective compares with, in their order of declaration; none in a scene without a misfit.
pub(super) fn experiments(
    checker: &mut Checker<'_>,
    declared: &Scene,
    start: &StartValues,
) -> Vec<Experiment> {
    let measured: Vec<&Measured> = declared
        .statements
        .iter()
        .filter_map(|statement| match statement {
            Statement::Measured(measured) => Some(&**measured),
            _ => None,
        })
        .collect();
    let objectives = declared.statements.iter();
    let objectives: Vec<(Place, &Expr)> = objectives
        .filter_map(|statement| match statement {
            Statement::Minimize { keyword, value } => Some((*keyword, value)),
            _ => None,
        })
        .collect();
    let terms = terms(checker, &measured, &objectives);
    if !terms.is_empty() {
        without_others(checker, declared, objectives[0].0);
    }
    let mut experiments = Vec::new();
    for (index, known) in measured.iter().enumerate() {
        let name = &known.name;
        if measured[..index]
            .iter()
            .any(|other| other.name.text == name.text)
        {
            let message = format!("`{}` is measured twice; rename one", name.text);
            checker.diagnostics.report("E19", name.place(), message);
            continue;
        }
        let checked = experiment(checker, known, start);
        checker.tell_units();
        let Some(term) = terms.iter().find(|term| term.experiment.text == name.text) else {
            let message = format!(
                "nothing compares with the measured `{0}`; write `minimize misfit({0})`, or add it to the objective",
                name.text
            );
            if checker.diagnostics.mistakes() == 0 {
                checker.diagnostics.report("E15", name.place(), message);
            }
            continue;
        };
        if let Ok(checked) = checked {
            experiments.push(Experiment {
                huber: term.huber,
                ..checked
            });
        }
    }
    experiments
}

/// The misfits that the objective adds up.
fn terms(
    checker: &mut Checker<'_>,
    measured: &[&Measured],
    objectives: &[(Place, &Expr)],
) -> Vec<Term> {
    let mut terms: Vec<Term> = Vec::new();
    let misfits = objectives
        .iter()
        .filter(|(_, expr)| is_misfit(checker, expr));
    let misfits: Vec<&(Place, &Expr)> = misfits.collect();
    if misfits.is_empty() {
        return terms;
    }
    if let [_, (keyword, _), ..] = objectives {
        let message = "a scene has one `minimize`; add the terms up in it";
        checker.diagnostics.syntax(*keyword, message);
    }
    for (_, expr) in misfits {
        let mut parts = Vec::new();
        if summands(checker, expr, &mut parts).is_err() {
            continue;
        }
        for part in parts {
            if let Ok(term) = term(checker, part, measured) {
                if terms
                    .iter()
                    .any(|known| known.experiment.text == term.experiment.text)
                {
                    let message = format!(
                        "the misfit of `{}` is added twice; its weight is declared by `within`",
                        term.experiment.text
                    );
                    checker.diagnostics.report("E15", part.place, message);
                }
                terms.push(term);
            }
        }
    }
    terms
}

/// The summands of a sum of misfits.
fn summands<'e>(
    checker: &mut Checker<'_>,
    expr: &'e Expr,
    parts: &mut Vec<&'e Expr>,
) -> Checked<()> {
    match &expr.kind {
        Kind::Call { function, .. } if function.text == words::MISFIT => parts.push(expr),
        Kind::Chain(first, rest) if rest.iter().all(|link| link.operator == Operator::Add) => {
            summands(checker, first, parts)?;
            for link in rest {
                summands(checker, &link.operand, parts)?;
            }
        }
        _ => {
            let message = format!(
                "`{expr}` beside a misfit: such an objective is a sum of misfits, as in `misfit(one) + misfit(other)`, and how \
                 much a measurement counts is declared by `within`"
            );
            return Err(checker.diagnostics.report("E15", expr.place, message));
        }
    }
    Ok(())
}

/// One call, `misfit(name)`, `misfit(name, huber)` or `misfit(name, huber(1.5))`.
fn term(checker: &mut Checker<'_>, expr: &Expr, measured: &[&Measured]) -> Checked<Term> {
    let arguments = match &expr.kind {
        Kind::Call { arguments, .. } => &arguments[..],
        _ => &[],
    };
    let (Some(Kind::Name(name)), 1..=2) = (
        arguments.first().map(|argument| &argument.kind),
        arguments.len(),
    ) else {
        let message = format!(
            "`{expr}`: a misfit is of one measured motion, `misfit(name)`, and may have a loss, `misfit(name, huber)`"
        );
        return Err(checker.diagnostics.report("E02", expr.place, message));
    };
    if !measured.iter().any(|known| known.name.text == name.text) {
        let names = || measured.iter().map(|known| known.name.text.as_str());
        let message = match closest(&name.text, names()) {
            Some(near) => format!("`{}` is not measured; did you mean `{near}`?", name.text),
            None if measured.is_empty() => format!(
                "`{0}` is not measured; declare it, as in `measured {0}: \"data.csv\" {{ z within 1 [cm] }}`",
                name.text
            ),
            None => format!(
                "`{}` is not measured (measured: {})",
                name.text,
                list(names())
            ),
        };
        return Err(checker.diagnostics.report("E01", name.place(), message));
    }
    let huber = arguments
        .get(1)
        .map(|loss| huber(checker, loss))
        .transpose()?;
    Ok(Term {
        experiment: name.clone(),
        huber,
    })
}

/// The loss of a misfit.
fn huber(checker: &mut Checker<'_>, loss: &Expr) -> Checked<f64> {
    match &loss.kind {
        Kind::Name(name) if name.text == words::HUBER => return Ok(HUBER),
        Kind::Call {
            function,
            arguments,
        } if function.text == words::HUBER => {
            if let [argument] = &arguments[..]
                && let Kind::Number {
                    value, unit: None, ..
                } = argument.kind
                && value > 0.0
                && value.is_finite()
            {
                return Ok(value);
            }
        }
        _ => {}
    }
    let message = format!(
        "`{loss}` is no loss; write `huber`, beyond {HUBER} standard deviations linear, or `huber(2)` for another bound above 0"
    );
    Err(checker.diagnostics.report("E15", loss.place, message))
}

/// What a misfit is not compatible with: conditions belong to a motion that is planned.
fn without_others(checker: &mut Checker<'_>, declared: &Scene, objective: Place) {
    let planned = declared
        .statements
        .iter()
        .find_map(|statement| match statement {
            Statement::Constraint { name, .. } => Some((name.place(), "`constraint`")),
            Statement::Finally(_) => Some((objective, "`finally`")),
            Statement::Free(_) => Some((objective, "`free { ... }`")),
            _ => None,
        });
    if let Some((place, what)) = planned {
        let message = format!(
            "{what} in a scene that minimizes a misfit is not supported; the ranges of parameters are declared with them, and an \
             initial value that is to be found is a parameter, as in `free v0: m/s in 0..=9 = 3` and `start {{ dot(y): v0 }}`"
        );
        checker.diagnostics.report("E15", place, message);
    }
}

/// One measured motion.
fn experiment(
    checker: &mut Checker<'_>,
    measured: &Measured,
    start: &StartValues,
) -> Checked<Experiment> {
    let before = checker.diagnostics.mistakes();
    let mut quantities: Vec<(declaration::Measured, f64)> = Vec::new();
    for quantity in &measured.quantities {
        let Ok(known) = of_quantity(checker, quantity) else {
            continue;
        };
        if quantities.iter().any(|(other, _)| *other == known.0) {
            let message = format!(
                "`{}` is measured twice in `{}`; keep one",
                quantity.target.text, measured.name.text
            );
            checker
                .diagnostics
                .report("E19", quantity.target.place(), message);
        }
        quantities.push(known);
    }
    if measured.quantities.is_empty() && checker.diagnostics.mistakes() == before {
        let message = format!(
            "`{}` measures nothing; write what, as in `z within 1 [cm]`",
            measured.name.text
        );
        checker.diagnostics.syntax(measured.name.place(), message);
    }
    let own = values::assigned(checker, &measured.start);
    let start = match measured.start.is_empty() {
        true => None,
        false => own.or(start).values().ok(),
    };
    checker.diagnostics.none_since(before)?;
    Ok(Experiment {
        name: measured.name.clone(),
        documentation: measured.documentation.clone(),
        file: measured.file.clone(),
        quantities,
        start,
        huber: None,
    })
}

/// What is measured, and its standard deviation in the declared unit.
fn of_quantity(
    checker: &mut Checker<'_>,
    quantity: &MeasuredQuantity,
) -> Checked<(declaration::Measured, f64)> {
    let name = &quantity.target;
    let output = checker
        .shown
        .outputs
        .iter()
        .position(|output| output.name.text == name.text);
    let state = states::index(checker, name);
    let output = output.filter(|_| !quantity.velocity && state.is_none());
    let (measured, target) = if let Some(output) = output {
        let unit = checker.shown.outputs[output].unit.as_ref();
        let target = Target::declared(name, unit);
        (declaration::Measured::Output(output), target)
    } else if is_other(checker, name) {
        let message = format!(
            "`{0}` is no coordinate, state or output, which are what can be measured; record it, as in `outputs {{ \
             seen = {0} }}`, and measure that",
            name.text
        );
        return Err(checker.diagnostics.report("E15", name.place(), message));
    } else {
        let (place, target) = Target::of(checker, name, quantity.velocity)?;
        let measured = match place.checked_sub(checker.coordinates.len() + checker.states.len()) {
            Some(index) => declaration::Measured::Velocity(index),
            None => declaration::Measured::Coordinate(place),
        };
        (measured, target)
    };
    let because = ["it is the standard deviation of the measured ", ""];
    let within = values::in_declared_unit(checker, &quantity.within, &target, because)?;
    match within.as_number() {
        Some(value) if value > 0.0 && value.is_finite() => Ok((measured, value)),
        _ => {
            let message = format!(
                "the standard deviation of the measured `{}` is `{}`; it must be a number above 0",
                name.text, quantity.within
            );
            Err(checker
                .diagnostics
                .report("E17", quantity.within.place, message))
        }
    }
}

/// Whether a name is declared as something that cannot be measured.
fn is_other(checker: &Checker<'_>, name: &Name) -> bool {
    let coordinates = checker.coordinates.iter();
    let coordinate = coordinates
        .chain(&checker.states)
        .any(|known| known.name.text == name.text);
    matches!(
        checker.scope.names.get(&name.text),
        Some(Meaning::Value(_) | Meaning::Function(_))
    ) && !coordinate
}

/// What experiments read of parameters besides the motion.
pub(super) fn functions(checker: &Checker<'_>, experiments: &[Experiment]) -> Vec<Sym> {
    let mut functions = Vec::new();
    for experiment in experiments {
        if let Some(start) = &experiment.start {
            functions.extend(start.0.iter().chain(&start.1));
        }
        for (measured, _) in &experiment.quantities {
            if let declaration::Measured::Output(index) = measured {
                functions.extend(checker.shown.outputs.get(*index).map(|output| output.value));
            }
        }
    }
    functions
}
