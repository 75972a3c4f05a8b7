//! Largest values in what a motion is judged by: `max`, `min` and `|x|` in an objective, and `peak(...)`.
//!
//! Where less of it is better, the largest of some values is an unknown that is not below any of them (the epigraph form: Boyd,
//! Vandenberghe, Convex Optimization, 4.1.3). Under an integral it is one at each stage of a program, at the end of the motion and over all of
//! it one of the whole program. Where more of it would be better there is no such form, and it is refused.

use super::checker::Checker;
use super::pieces;
use super::rules::smooth;
use crate::ast::Expr;
use crate::declaration::Over;
use crate::derive::simplify;
use crate::diagnostics::{Checked, Place, Reported};
use crate::evaluate::{Kink, Peak};
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::Epigraph;

/// A term times `weight` in which every maximum is an unknown, where less of the sum is better; `over` is when its maxima hold that do
/// not stand in `peak(...)`.
pub(super) fn lifted(
    checker: &mut Checker<'_>,
    (value, expr): (Sym, &Expr),
    weight: Sym,
    over: Over,
) -> Checked<Sym> {
    let kinks = std::mem::take(&mut checker.scope.kinks);
    let value = lift(checker, (value, expr), weight, (over, &kinks))?;
    peaks(checker, &[value], (expr.place, weight), &kinks)?;
    Ok(value)
}

/// The largest values over the motion that some functions read, times a weight, where less of it is better.
pub(super) fn peaks(
    checker: &mut Checker<'_>,
    values: &[Sym],
    (place, weight): (Place, Sym),
    kinks: &[Kink],
) -> Checked<()> {
    for peak in std::mem::take(&mut checker.scope.peaks) {
        for &value in values {
            let slope = slope(value, peak.variable);
            if !slope.is_structural_zero() && !grows(checker, (slope * weight, place), &peak.shown)?
            {
                return Err(refused(checker, place, &peak.shown));
            }
        }
        if graph::variables(values).contains(&peak.variable) {
            declare_peak(checker, &peak, place, kinks)?;
        }
    }
    Ok(())
}

/// Replaces the maxima and minima in a value by unknowns; what contains others was made after them.
fn lift(
    checker: &mut Checker<'_>,
    (mut value, expr): (Sym, &Expr),
    weight: Sym,
    (over, kinks): (Over, &[Kink]),
) -> Checked<Sym> {
    for kink in kinks.iter().rev() {
        let slope = slope(value, kink.variable);
        if slope.is_structural_zero() {
            continue;
        }
        let shown = expr.to_string();
        if grows(checker, (slope * weight, expr.place), &shown)? != kink.largest {
            return Err(refused(checker, expr.place, &shown));
        }
        let unknown = Variable::Epigraph(checker.scope.epigraphs);
        checker.scope.epigraphs += 1;
        // The smallest of some values is minus the largest of theirs with the other sign.
        let sign = if kink.largest { 1.0 } else { -1.0 };
        let unknown = Sym::variable(unknown);
        value = graph::substitute(&[value], |variable| {
            (variable == kink.variable).then(|| unknown.scaled(sign))
        })[0];
        let parts = kink.parts.iter().map(|part| unknown - part.scaled(sign));
        let mut rows = Vec::new();
        for part in parts.collect::<Vec<Sym>>() {
            rows.extend(pieces::all_pieces(part, expr.place, checker, kinks)?);
        }
        for &row in &rows {
            smooth(row, expr, checker)?;
        }
        checker.task.epigraphs.push(Epigraph {
            variable: variable_of(unknown),
            shown,
            over,
            rows,
            at_start: Vec::new(),
        });
    }
    Ok(value)
}

/// The variable that a symbol is.
fn variable_of(unknown: Sym) -> Variable {
    graph::variables(&[unknown])
        .into_iter()
        .next()
        .unwrap_or(Variable::Epigraph(0))
}

/// Declares the unknown that is the largest value over a motion, with what it is at least: where the value depends on the state and the
/// time alone, at the start as well, where programs state nothing else.
fn declare_peak(
    checker: &mut Checker<'_>,
    peak: &Peak,
    place: Place,
    kinks: &[Kink],
) -> Checked<()> {
    let row = Sym::variable(peak.variable) - peak.value;
    let rows = pieces::all_pieces(row, place, checker, kinks)?;
    let size = checker.scope.state_size;
    let component = |variable| match variable {
        Variable::Coordinate(i) => Some(i),
        Variable::Velocity(i) => Some(size + i),
        _ => None,
    };
    let known_at_start = |variable: Variable| {
        component(variable).is_some()
            || variable == peak.variable
            || matches!(variable, Variable::Time | Variable::Parameter(_))
    };
    let mut at_start = Vec::new();
    for &row in &rows {
        let variables = graph::variables(&[row]);
        if !variables.iter().copied().all(known_at_start) {
            continue;
        }
        let read = variables.into_iter().filter_map(component);
        let read = read.map(|k| (k, String::new(), place));
        checker.scope.starts.extend(read);
        at_start.extend(graph::substitute(&[row], |variable| match variable {
            Variable::Time => Some(Sym::ZERO),
            _ => component(variable).map(|k| Sym::variable(Variable::Start(k))),
        }));
    }
    checker.task.epigraphs.push(Epigraph {
        variable: peak.variable,
        shown: peak.shown.clone(),
        over: Over::Motion,
        rows,
        at_start,
    });
    Ok(())
}

/// How a value changes with a variable that it is linear in.
fn slope(value: Sym, variable: Variable) -> Sym {
    simplify(graph::partial(&[value], variable)[0])
}

/// E12: whether a slope, which depends on parameters alone, is above 0 for the defaults of these.
fn grows(checker: &mut Checker<'_>, (slope, place): (Sym, Place), shown: &str) -> Checked<bool> {
    let moves = graph::depends_on(slope, Variable::moves);
    match checker.at_default(slope) {
        Some(value) if !moves && value != 0.0 => return Ok(value > 0.0),
        _ => {}
    }
    let message = format!(
        "`{shown}`: `max`, `min`, `|x|` and `peak` are added up in an objective, with numbers and parameters as factors, whose sign is \
         known; write another factor or a power inside, as in `|w*x|` and `peak(x^2)`"
    );
    Err(checker.diagnostics.report("E12", place, message))
}

/// E12: where a maximum is to be large, or a minimum small.
fn refused(checker: &mut Checker<'_>, place: Place, shown: &str) -> Reported {
    let message = format!(
        "`{shown}` would be better the larger a maximum, a size or a peak is, or the smaller a minimum: each of their parts leads to an \
         optimum of its own, which no condition tells apart; write the part that is meant, or ask for it in `constraint` or `finally`"
    );
    checker.diagnostics.report("E12", place, message)
}
