//! Optimal control: what a cost, a constraint and a terminal condition may be.

use super::checker::{Asked, Checker, Cost, Free, Task};
use super::rules::smooth;
use super::values::{self, Target};
use super::{epigraph, pieces, states};
use crate::ast::{Condition, Expr, FreeStart, Kind, Link, Name, Operator, Relation};
use crate::declaration::Over;
use crate::diagnostics::{Checked, Place, Reported, all};
use crate::evaluate::{Kink, Number, Role, Value, at_impacts};
use crate::graph::{self, Compose, Sym, Variable};
use crate::scene::{self, OptimalControl};
use crate::words;

pub(super) fn minimize(checker: &mut Checker<'_>, keyword: Place, expr: &Expr) -> Checked<()> {
    if checker.task.cost.is_some() {
        return Err(checker.diagnostics.syntax(
            keyword,
            "a scene has one `minimize`; add the terms up in it",
        ));
    }
    let mut cost = Cost::default();
    let split = split(checker, expr, Sym::ONE, &mut cost);
    checker.task.cost = Some(cost);
    split.map(|_| ())
}

/// E15: adds an expression times a weight to the two parts of the objective; the expression with its unit, which is a number
/// of the motion as a whole.
fn split(checker: &mut Checker<'_>, expr: &Expr, weight: Sym, cost: &mut Cost) -> Checked<Value> {
    if !expr.calls(words::INTEGRAL) {
        return term(checker, (expr, Over::End), weight, cost);
    }
    match &expr.kind {
        Kind::Negate(inner) => split(checker, inner, -weight, cost),
        Kind::Chain(first, rest) if rest[0].operator.is_additive() => {
            let mut terms = vec![split(checker, first, weight, cost)];
            for link in rest {
                let weight = weight.scaled(link.operator.sign());
                terms.push(split(checker, &link.operand, weight, cost));
            }
            let terms = all(terms.into_iter())?;
            checker.scope.units.of_sum(first, rest, &terms);
            Ok(terms[0].clone())
        }
        Kind::Chain(first, rest) if is_weighted_integral(expr, rest) => {
            let (mut weight, mut integral) = (weight, &**first);
            let mut unit = checker.scope.units.one();
            for link in rest.iter().rev() {
                if link.operand.calls(words::INTEGRAL) {
                    integral = &link.operand;
                    continue;
                }
                let factor = factor(checker, &link.operand)?;
                (weight, unit) = match link.operator {
                    Operator::Divide => (weight / factor.sym, unit.over(&factor.unit)),
                    _ => (weight * factor.sym, unit.times(&factor.unit)),
                };
            }
            if !first.calls(words::INTEGRAL) {
                let factor = factor(checker, first)?;
                weight *= factor.sym;
                unit = unit.times(&factor.unit);
            }
            let integral = split(checker, integral, weight, cost)?;
            Ok(integral.map(|own| own.in_unit(own.unit.times(&unit))))
        }
        Kind::Call {
            function,
            arguments,
        } if function.text == words::INTEGRAL => match arguments.as_slice() {
            [argument] if !argument.calls(words::INTEGRAL) => term(checker, (argument, Over::Instants), weight, cost),
            [argument] => Err(meaningless(checker,
                argument.place,
                "`integral` inside `integral`: a running cost is integrated once, over the motion; \
                 add a coordinate for the inner one"
                    .to_owned(),
            )),
            other => Err(checker.diagnostics.report(
                "E02",
                expr.place,
                format!("`integral` takes 1 argument, found {}", other.len()),
            )),
        },
        _ => Err(meaningless(checker,
            expr.place,
            format!(
                "`integral` inside `{expr}`: an objective is a sum of final terms and of integrals, \
                 each possibly times a constant"
            ),
        )),
    }
}

fn meaningless(checker: &mut Checker<'_>, place: Place, message: String) -> Reported {
    checker.diagnostics.report("E15", place, message)
}

/// What an integral is multiplied by.
fn factor(checker: &mut Checker<'_>, expr: &Expr) -> Checked<Number> {
    let value = in_role(checker, Role::Running, |checker| checker.number(expr))?;
    checker.free_of(&[value.sym], Variable::moves, (Some("E15"), expr.place), |moving| {
        format!(
            "an integral times `{expr}`, which depends on {moving}: a weight may depend on parameters only; move it into the integral"
        )
    })?;
    Ok(value)
}

/// A term of the objective: at each instant, or at the end.
fn term(
    checker: &mut Checker<'_>,
    (expr, over): (&Expr, Over),
    weight: Sym,
    cost: &mut Cost,
) -> Checked<Value> {
    let is_running = over == Over::Instants;
    checker.scope.takes_apart = true;
    let own = match is_running {
        true => in_role(checker, Role::Running, |checker| checker.number(expr)),
        false => at_the_end(checker, expr, "the final cost"),
    };
    checker.scope.takes_apart = false;
    let own = own?;
    let value = own.sym;
    if !moves(checker, value) {
        let message = match &expr.kind {
            _ if !is_running => format!(
                "`{expr}` is the same for every motion, so it cannot be minimized; leave it out"
            ),
            kind => {
                let product = match kind {
                    Kind::Number {
                        value, unit: None, ..
                    } if *value == 1.0 => "time".to_owned(),
                    Kind::Chain(_, rest)
                        if rest[0].operator.is_additive() && !expr.parenthesized =>
                    {
                        format!("({expr})*time")
                    }
                    _ => format!("{expr}*time"),
                };
                format!(
                    "the integral of the constant `{expr}` is that times the final time; write `{product}`"
                )
            }
        };
        return Err(meaningless(checker, expr.place, message));
    }
    smooth(value, expr, checker)?;
    let value = epigraph::lifted(checker, (value, expr), weight, over)?;
    let (part, unit) = match is_running {
        true => (
            &mut cost.running,
            own.unit.times(&checker.scope.units.second()),
        ),
        false => (&mut cost.terminal, own.unit.clone()),
    };
    *part = Some(part.unwrap_or(Sym::ZERO) + weight * value);
    Ok(Value::Scalar(own.in_unit(unit)))
}

/// A number at the final instant, where a control has no value.
fn at_the_end(checker: &mut Checker<'_>, expr: &Expr, what: &str) -> Checked<Number> {
    let known = checker.scope.sums.len();
    let own = in_role(checker, Role::End, |checker| checker.number(expr))?;
    let value = own.sym;
    let parts = within(value, &checker.scope.kinks);
    checker.free_of(&parts, Variable::is_control, (Some("E15"), expr.place), |control| {
        let remedy = match what {
            "the final cost" => format!("write `integral({expr})`"),
            _ => "a condition on it is a `constraint`".to_owned(),
        };
        format!(
            "{what} depends on {control}, which acts over a time and has no value at the final instant; {remedy}"
        )
    })?;
    smooth(value, expr, checker)?;
    let new = checker.scope.sums[known..].to_vec();
    for sum in new {
        smooth(sum, expr, checker)?;
    }
    Ok(own)
}

/// A value and what is in its maxima.
fn within(value: Sym, kinks: &[Kink]) -> Vec<Sym> {
    let mut all = vec![value];
    for kink in kinks.iter().rev() {
        if graph::variables(&all).contains(&kink.variable) {
            all.extend(&kink.parts);
        }
    }
    all
}

fn in_role<T>(checker: &mut Checker<'_>, role: Role, run: impl FnOnce(&mut Checker<'_>) -> T) -> T {
    checker.scope.role = role;
    let result = run(checker);
    checker.scope.role = Role::Motion;
    result
}

pub(super) fn finally(checker: &mut Checker<'_>, goals: &[Condition]) -> Checked<()> {
    let before = checker.diagnostics.mistakes();
    for goal in goals {
        checker.scope.takes_apart = goal.relation != Relation::Equal;
        let left = at_the_end(checker, &goal.left, "a terminal condition");
        let right = at_the_end(checker, &goal.right, "a terminal condition");
        checker.scope.takes_apart = false;
        let (Ok(left), Ok(right)) = (left, right) else {
            continue;
        };
        let what = "both sides of a terminal condition";
        if let Ok(goal) =
            checked_condition(checker, goal, (&goal.to_string(), what), (&left, &right))
        {
            checker.task.goals.push(goal);
        }
    }
    checker.diagnostics.none_since(before)
}

pub(super) fn constraint(
    checker: &mut Checker<'_>,
    name: &Name,
    condition: &Condition,
) -> Checked<()> {
    if checker.task.constraints.iter().any(|known| {
        known
            .pieces
            .iter()
            .any(|piece| piece.name == name.text || piece.name == format!("{}.1", name.text))
    }) {
        return Err(checker.diagnostics.report(
            "E19",
            name.place(),
            format!("constraint `{}` is declared twice; rename one", name.text),
        ));
    }
    let side = |checker: &mut Checker<'_>, expr: &Expr| {
        in_role(checker, Role::Constraint, |checker| {
            let value = checker.number(expr)?;
            smooth(value.sym, expr, checker)?;
            Ok(value)
        })
    };
    checker.scope.takes_apart = condition.relation != Relation::Equal;
    let (left, right) = (
        side(checker, &condition.left),
        side(checker, &condition.right),
    );
    checker.scope.takes_apart = false;
    let (left, right) = (left?, right?);
    let what = format!("both sides of constraint `{}`", name.text);
    let constraint = checked_condition(checker, condition, (&name.text, &what), (&left, &right))?;
    if constraint.pieces.iter().any(is_at_impacts) {
        for (value, expr) in [(left, &condition.left), (right, &condition.right)] {
            at_impacts(value.sym, expr, checker.diagnostics)?;
        }
    }
    checker.task.constraints.push(constraint);
    Ok(())
}

/// Whether a constraint holds at impacts, not all the time.
fn is_at_impacts(constraint: &scene::Condition) -> bool {
    graph::depends_on(constraint.function, Variable::is_impulse)
}

/// A condition with its sides evaluated: one for each piece, where it has edges.
fn checked_condition(
    checker: &mut Checker<'_>,
    condition: &Condition,
    (name, sides): (&str, &str),
    (own, its): (&Number, &Number),
) -> Checked<Asked> {
    let pair = [(&condition.left, own), (&condition.right, its)];
    let own = checker.difference(pair, condition.relation, sides);
    let function = own.sym;
    let kinks = checker.scope.kinks.clone();
    let mut pieces = pieces::all_hold(function, (&condition.left, &condition.right), checker)?;
    if pieces.len() > 1 {
        // What always holds, as `0 <= 1` of `max(x, 0) <= 1`, is no condition.
        pieces.retain(|&piece| moves(checker, piece) || !holds_always(checker, piece));
    }
    if pieces.is_empty() || pieces.iter().any(|&piece| !moves(checker, piece)) {
        return Err(meaningless(
            checker,
            condition.left.place.to(condition.right.place),
            format!(
                "`{}` is the same for every motion, so it is no condition; use coordinates, \
                 velocities or the time",
                condition
            ),
        ));
    }
    let less = Sym::number(-1.0);
    let place = condition.left.place.to(condition.right.place);
    let is_peak = |variable| matches!(variable, Variable::Epigraph(_));
    if condition.relation == Relation::Equal && graph::depends_on(function, is_peak) {
        let message = format!(
            "`{condition}` asks a largest value to be exactly that; ask for at most that much, by `<=`"
        );
        return Err(checker.diagnostics.report("E12", place, message));
    }
    epigraph::peaks(checker, &pieces, (place, less), &kinks)?;
    let several = pieces.len() > 1;
    let conditions = pieces.into_iter().enumerate();
    let conditions = conditions.map(|(k, function)| scene::Condition {
        name: match several {
            true => format!("{name}.{}", k + 1),
            false => name.to_owned(),
        },
        documentation: condition.documentation.clone(),
        function,
        equality: condition.relation == Relation::Equal,
        unit: None,
    });
    Ok(Asked {
        pieces: conditions.collect(),
        unit: own.unit,
    })
}

/// Whether a value that does not move is not negative for the defaults of the parameters.
fn holds_always(checker: &Checker<'_>, value: Sym) -> bool {
    checker.at_default(value).is_some_and(|value| value >= 0.0)
}

pub(super) fn free(checker: &mut Checker<'_>, values: &[FreeStart]) -> Checked<()> {
    let before = checker.diagnostics.mistakes();
    for value in values {
        // Each reports its own mistakes; the next one is checked all the same.
        let _: Checked<()> = free_value(checker, value);
    }
    checker.diagnostics.none_since(before)
}

fn free_value(checker: &mut Checker<'_>, value: &FreeStart) -> Checked<()> {
    let (index, target) = Target::of(checker, &value.target, value.velocity)?;
    let shown = target.shown();
    if checker.task.free.iter().any(|known| known.index == index) {
        return Err(checker.diagnostics.syntax(
            value.target.place(),
            format!("`{shown}` is listed in `free` twice; keep one"),
        ));
    }
    let bounds = value
        .bounds
        .as_ref()
        .map(|bounds| values::range(checker, bounds, &target, ["it bounds ", ""]))
        .transpose()?;
    checker.task.free.push(Free {
        index,
        bounds,
        shown,
        place: value.target.place(),
    });
    Ok(())
}

/// The task of optimal control, if the scene declares any part of one.
pub(super) fn optimal_control(checker: &mut Checker<'_>) -> Option<OptimalControl> {
    let Task {
        cost,
        constraints,
        goals,
        mut free,
        epigraphs,
    } = std::mem::take(&mut checker.task);
    if cost.is_none() && constraints.is_empty() && goals.is_empty() && free.is_empty() {
        return None;
    }
    let units = &checker.scope.units;
    let all = |list: Vec<Asked>| -> Vec<scene::Condition> {
        let pieces = list.into_iter().flat_map(|asked| {
            let unit = units.known(&asked.unit);
            let pieces = asked.pieces.into_iter();
            pieces.map(move |piece| scene::Condition { unit, ..piece })
        });
        pieces.collect()
    };
    let (goals, mut constraints) = (all(goals), all(constraints));
    constraints.extend(states::constraints(checker));
    free.sort_by_key(|free| free.index);
    let cost = cost.unwrap_or_default();
    let (at_impacts, constraints) = constraints.into_iter().partition(is_at_impacts);
    Some(OptimalControl {
        running_cost: cost.running,
        final_cost: cost.terminal,
        constraints,
        at_impacts,
        sums: std::mem::take(&mut checker.scope.sums),
        goals,
        epigraphs,
        free_time: checker.scope.used.contains(words::FINAL_TIME),
        free_start: free
            .into_iter()
            .map(|free| (free.index, free.bounds))
            .collect(),
    })
}

/// Whether a value depends on the motion, or on a parameter that is to be found with it.
fn moves(checker: &Checker<'_>, value: Sym) -> bool {
    graph::depends_on(value, Variable::moves) || checker.free_parameter_in(value).is_some()
}

/// Whether a product holds one integral, which does not divide.
fn is_weighted_integral(product: &Expr, rest: &[Link]) -> bool {
    let integrals = product
        .children()
        .into_iter()
        .filter(|part| part.calls(words::INTEGRAL));
    integrals.count() == 1
        && !rest
            .iter()
            .any(|link| link.operator == Operator::Divide && link.operand.calls(words::INTEGRAL))
}
