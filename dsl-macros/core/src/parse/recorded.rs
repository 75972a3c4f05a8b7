//! `at(time, value)` in what a motion is judged by: a state that is set to the value at that time, which stands in its place.
//!
//! The states of one time are set together, by a statement `at` that the parser adds, or by the one with the same time that the scene has.

use crate::ast::{Assignment, Condition, Expr, Kind, Name, Statement};
use crate::diagnostics::{Checked, Diagnostics, Reported};
use crate::words;

/// A time, and the states that are set then.
struct Moment {
    time: Expr,
    values: Vec<Assignment>,
    /// The last statement that reads one of them.
    last: usize,
}

/// Puts states in the place of all values at times.
pub(super) fn record(statements: &mut Vec<Statement>, diagnostics: &mut Diagnostics) {
    let mut moments: Vec<Moment> = Vec::new();
    for (index, statement) in statements.iter_mut().enumerate() {
        let read: Vec<&mut Expr> = match statement {
            Statement::Minimize { value, .. } => vec![value],
            Statement::Finally(conditions) | Statement::At { conditions, .. } => conditions
                .iter_mut()
                .flat_map(|Condition { left, right, .. }| [left, right])
                .collect(),
            _ => continue,
        };
        for expr in read {
            replace(expr, (index, None), &mut moments, diagnostics);
        }
    }
    // Those read last stand last, so that places before them stay.
    moments.sort_by_key(|moment| std::cmp::Reverse(moment.last));
    for moment in moments {
        let shown = moment.time.to_string();
        let same = statements.iter_mut().find_map(|statement| match statement {
            Statement::At { time, values, .. } if time.to_string() == shown => Some(values),
            _ => None,
        });
        match same {
            Some(values) => values.extend(moment.values),
            None => {
                let statement = Statement::At {
                    time: moment.time,
                    gate: None,
                    conditions: Vec::new(),
                    values: moment.values,
                };
                statements.insert(moment.last, statement);
            }
        }
    }
}

/// Replaces the values at times in an expression of a statement; `inside` is the function that it is an argument of, if that judges all of
/// the motion.
fn replace(
    expr: &mut Expr,
    (statement, inside): (usize, Option<&str>),
    moments: &mut Vec<Moment>,
    diagnostics: &mut Diagnostics,
) {
    let Kind::Call {
        function,
        arguments,
    } = &mut expr.kind
    else {
        for child in expr.children_mut() {
            replace(child, (statement, inside), moments, diagnostics);
        }
        return;
    };
    if function.text != words::AT {
        let whole = [words::INTEGRAL, words::PEAK, words::SUM, words::START];
        let function = function.text.clone();
        let inside = match whole.contains(&function.as_str()) {
            true => Some(function.as_str()),
            false => inside,
        };
        for argument in arguments {
            replace(argument, (statement, inside), moments, diagnostics);
        }
        return;
    }
    let name = Name {
        text: String::new(),
        ident: function.ident.clone(),
    };
    let arguments = arguments.clone();
    match at(
        expr,
        (name, &arguments),
        (statement, inside),
        moments,
        diagnostics,
    ) {
        Ok(state) => expr.kind = Kind::Name(state),
        Err(Reported) => diagnostics.poison(words::AT),
    }
}

/// The state that records what is asked for by `at(time, value)`.
fn at(
    whole: &Expr,
    (mut name, arguments): (Name, &[Expr]),
    (statement, inside): (usize, Option<&str>),
    moments: &mut Vec<Moment>,
    diagnostics: &mut Diagnostics,
) -> Checked<Name> {
    let shown = whole.to_string();
    let [time, value] = arguments else {
        let message = format!(
            "`at` takes 2 arguments, a time and what is asked for then, as in `at(1 [s], x)`; found {}",
            arguments.len()
        );
        return Err(diagnostics.report("E02", whole.place, message));
    };
    let why = match inside {
        Some(words::AT) => Some("inside of another `at`; write one value for each time".to_owned()),
        Some(inside) => Some(format!(
            "inside of `{inside}`, which asks for all of the motion, also before that time; write it outside"
        )),
        None => None,
    };
    if let Some(why) = why {
        let message = format!("`{shown}` is one number of the motion, and stands {why}");
        return Err(diagnostics.report("E15", whole.place, message));
    }
    let mut value = value.clone();
    replace(
        &mut value,
        (statement, Some(words::AT)),
        moments,
        diagnostics,
    );
    name.text = shown;
    let assignment = Assignment {
        target: name.clone(),
        velocity: false,
        value,
    };
    let at = time.to_string();
    let known = moments
        .iter_mut()
        .find(|known| known.time.to_string() == at);
    match known {
        Some(known) => {
            known.last = statement;
            let mut values = known.values.iter();
            if !values.any(|known| known.target.text == name.text) {
                known.values.push(assignment);
            }
        }
        None => moments.push(Moment {
            time: time.clone(),
            values: vec![assignment],
            last: statement,
        }),
    }
    Ok(name)
}
