//! Coefficients of friction: numbers, functions of the speed of sliding and of the place, and two of them for rest and sliding.
//!
//! A coefficient that changes, `mu(|v_t|, q, t)`, is a factor of the direction in which friction acts, `e = mu M^-1 b / D`, so that
//! the law itself keeps a coefficient that is a number: 1, or the ratio of that at rest to that of sliding.

use super::checker::{CheckedFriction, Checker, Surface};
use crate::ast::Expr;
use crate::derive::simplify;
use crate::diagnostics::Checked;
use crate::dimension::Dimension;
use crate::evaluate::{Meaning, Number, Value};
use crate::graph::{self, Compose, Function, Sym, Variable};
use crate::scene::Friction;
use crate::words;

/// What stands for the size of the sliding velocity until that is known.
const SPEED: Variable = Variable::Argument(12_000);

/// Cosine of an angle, or ratio beside 1, that is rounding of what a scene writes.
const NOTHING: f64 = 1e-9;

/// Evaluates what may contain the speed of sliding in this unit, by the word for it unless a declaration has taken that.
pub(super) fn with_speed<T>(
    checker: &mut Checker<'_>,
    unit: Dimension,
    evaluate: impl FnOnce(&mut Checker<'_>) -> T,
) -> T {
    let taken = checker.scope.names.contains_key(words::SPEED);
    if !taken {
        let sym = Sym::variable(SPEED);
        let speed = Meaning::Value(Value::Scalar(Number { sym, unit }));
        checker.scope.names.insert(words::SPEED.to_owned(), speed);
    }
    let value = evaluate(checker);
    if !taken {
        checker.scope.names.remove(words::SPEED);
    }
    value
}

/// Puts the size of the sliding velocity where the speed is meant.
pub(super) fn at_speed(value: Sym, sliding: Sym) -> Sym {
    let speed = sliding.call(Function::Abs);
    graph::substitute(&[value], |variable| (variable == SPEED).then_some(speed))[0]
}

/// The value at rest.
fn still(value: Sym) -> Sym {
    let still = |variable| (variable == SPEED).then_some(Sym::ZERO);
    simplify(graph::substitute(&[value], still)[0])
}

/// E03: a coefficient has no unit.
pub(super) fn ratio(checker: &mut Checker<'_>, expr: &Expr, own: &Number, of: &str) {
    let units = &mut checker.scope.units;
    let reason = format!("a coefficient of {of} is a ratio");
    units.expect(expr, &own.unit, &units.one(), &reason);
}

/// The coefficient of sliding, and that at rest if it is another one.
pub(super) fn coefficients(
    checker: &mut Checker<'_>,
    sliding: &Expr,
    at_rest: Option<&Expr>,
    speed: Dimension,
) -> Checked<(Sym, Option<Sym>)> {
    let own = with_speed(checker, speed, |checker| checker.number(sliding))?;
    ratio(checker, sliding, &own, "friction");
    let value = own.sym;
    let wrong = |variable| match variable {
        Variable::Parameter(_) | Variable::Coordinate(_) | Variable::Time => false,
        other => other != SPEED,
    };
    checker.free_of(&[value], wrong, (Some("E07"), sliding.place), |wrong| {
        format!(
            "the coefficient of friction depends on {wrong}; it may depend on positions, the time and `speed`, the size of the \
             sliding velocity"
        )
    })?;
    checker.coefficient(still(value), sliding, "friction", f64::INFINITY)?;
    let Some(expr) = at_rest else {
        return Ok((value, None));
    };
    let rest = checker.number(expr)?;
    ratio(checker, expr, &rest, "friction");
    let rest = checker.constant(rest.sym, expr, "the coefficient of friction at rest")?;
    checker.coefficient(rest, expr, "friction", f64::INFINITY)?;
    let values = (checker.at_default(rest), checker.at_default(still(value)));
    if let (Some(rest), Some(slides)) = values
        && rest < slides
    {
        let message = format!(
            "the coefficient of friction at rest is {rest}, below {slides} of sliding: a body would hold on less than it is braked, \
             and could neither rest nor slide; exchange them"
        );
        return Err(checker.diagnostics.report("E10", expr.place, message));
    }
    Ok((value, Some(rest)))
}

/// The law of friction with its sliding velocity.
pub(super) fn completed(
    friction: &CheckedFriction,
    sliding: Sym,
    checker: &mut Checker<'_>,
) -> Checked<Friction> {
    let law = |coefficient, kinetic, share| Friction {
        coefficient,
        kinetic,
        share,
        sliding,
        across: None,
    };
    let is_number = |value| !graph::depends_on(value, Variable::moves);
    if is_number(friction.coefficient) {
        return Ok(match friction.at_rest {
            None => law(friction.coefficient, None, None),
            Some(at_rest) => law(at_rest, Some(friction.coefficient), None),
        });
    }
    let slowly = still(friction.coefficient);
    if slowly.is_structural_zero() || checker.at_default(slowly) == Some(0.0) {
        let message = "the coefficient of friction vanishes at rest, so that nothing holds the contact there and its force is \
                       smooth; write one that is above 0 at rest";
        return Err(checker.diagnostics.report("E10", friction.place, message));
    }
    let share = Some(at_speed(friction.coefficient, sliding));
    let Some(at_rest) = friction.at_rest else {
        return Ok(law(Sym::ONE, None, share));
    };
    let ratio = simplify(at_rest * slowly.power(-2));
    if !is_number(ratio) {
        let message = "beside `static` the coefficient of sliding may change with `speed` alone; leave `static` out, or write a \
                       coefficient of sliding that is the same at all places and times";
        return Err(checker.diagnostics.report("E07", friction.place, message));
    }
    Ok(law(ratio, Some(Sym::ONE), share))
}

/// Says where sliding velocities of a point mass are not along the surface, in the scale of its gap and perpendicular to each other, as far
/// as parameters tell: the power of `s <= mu r` against them is that of another force then.
pub(super) fn scaled_like_the_gap(
    friction: &CheckedFriction,
    sliding: &[Sym],
    surface: &Surface,
    checker: &mut Checker<'_>,
) {
    let n = checker.coordinates.len();
    let velocities = Variable::velocities(n);
    let normal = graph::gradient(surface.gap, &Variable::coordinates(n));
    let rows = sliding.iter().map(|&one| graph::gradient(one, &velocities));
    let rows: Vec<Vec<Sym>> = std::iter::once(normal).chain(rows).collect();
    let product = |i: usize, j: usize| {
        let terms = rows[i].iter().zip(&rows[j]).map(|(a, b)| *a * *b);
        let sum = simplify(terms.fold(Sym::ZERO, |sum, term| sum + term));
        checker.at_default(sum).unwrap_or(f64::NAN)
    };
    let cosine = |i, j| product(i, j) / (product(i, i) * product(j, j)).sqrt();
    let ratio = |i| (product(i, i) / product(0, 0)).sqrt();
    let name = &surface.name.text;
    let apart = |value: &f64| value.abs() > NOTHING;
    let all = 1..rows.len();
    let into = all.clone().map(|i| cosine(0, i)).find(apart);
    let beside = (rows.len() > 2).then(|| cosine(1, 2)).filter(apart);
    let what = if let Some(cosine) = into {
        format!(
            "is not along the surface, the cosine of its angle with the rate of the gap is {cosine:.3}"
        )
    } else if let Some(cosine) = beside {
        format!("is not perpendicular to the other one, the cosine of their angle is {cosine:.3}")
    } else if let Some(ratio) = all.map(ratio).find(|ratio| apart(&(ratio - 1.0))) {
        format!("is {ratio:.4} times what the rate of the gap is at the same speed")
    } else {
        return;
    };
    let message = format!(
        "a sliding velocity of `{name}` {what}, so that friction is another force than `mu N`; give the velocity of the touching point \
         along the surface, scaled like the gap, in space two that are perpendicular to each other, as in `sliding (dot(x), dot(y))`"
    );
    checker.diagnostics.warn("E20", friction.place, message);
}

/// The law of friction in space, with two sliding velocities.
pub(super) fn in_space(
    friction: &CheckedFriction,
    (sliding, across): (Sym, Sym),
    surface: &Surface,
    checker: &mut Checker<'_>,
) -> Checked<Friction> {
    let name = &surface.name.text;
    if graph::depends_on(friction.coefficient, |variable| variable == SPEED) {
        let message = format!(
            "friction of `{name}` has two sliding velocities, and its coefficient `speed`; in space it is the same at every speed, as in \
             `friction 0.3` or `friction static 0.4, kinetic 0.3`"
        );
        return Err(checker.diagnostics.report("E07", friction.place, message));
    }
    let n = checker.coordinates.len();
    let velocities = Variable::velocities(n);
    let [first, second] = [sliding, across].map(|one| graph::gradient(one, &velocities));
    let apart = |i: usize, j: usize| simplify(first[i] * second[j] - first[j] * second[i]);
    let mut pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
    if pairs.all(|(i, j)| apart(i, j).is_structural_zero()) {
        let message = format!(
            "the two sliding velocities of `{name}` are along one direction; give those of the touching point along two directions of \
             the surface that are perpendicular to each other, as in `sliding (dot(x), dot(y))`"
        );
        return Err(checker.diagnostics.report("E20", friction.place, message));
    }
    let completed = completed(friction, sliding, checker)?;
    Ok(Friction {
        across: Some(across),
        ..completed
    })
}
