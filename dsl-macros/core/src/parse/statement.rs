//! Statements: keyword, then a block, a list or an expression. After a mistake parsing goes on at the
//! next keyword, or behind the next comma of a list.

use super::cursor::Cursor;
use super::documentation::documentation;
use super::expression::expression;
use super::pieces::{Bounds, assignments, block, entries, equals, name, range, said_of};
use super::{control, joint, law, measured, picture, profile, slips, unit};
use crate::ast::{Documentation, Expr, Name, Positive, Quantity, Relation, Statement};
use crate::diagnostics::{Checked, Place, Reported, closest, list};
use crate::words;
use proc_macro2::{Delimiter, TokenTree};

/// Parses the body of a scene.
pub(super) fn statements(cursor: &mut Cursor) -> Vec<Statement> {
    let mut statements = Vec::new();
    while !cursor.is_empty() {
        let documentation = documentation(cursor);
        if cursor.is_empty() {
            break;
        }
        match statement(cursor, documentation) {
            Ok(mut statement) => {
                if let Statement::At { gate, .. } = &mut statement {
                    let gate = gate.take().map(|gate| Statement::Parameters(vec![*gate]));
                    statements.extend(gate);
                }
                statements.push(statement);
            }
            Err(Reported) => skip_to_statement(cursor),
        }
        while cursor.eat_symbol(";") || cursor.eat_symbol(",") {}
    }
    statements
}

fn skip_to_statement(cursor: &mut Cursor) {
    cursor.skip_until(|cursor| {
        cursor.ident().is_some_and(|ident| {
            let word = ident.to_string();
            begins_statement(&word) || is_misspelt_block(cursor, &word)
        })
    });
}

/// Whether a comma is there, and behind it something that begins no statement.
fn another_one_follows(cursor: &Cursor) -> bool {
    let mut next = cursor.clone();
    if !next.eat_symbol(",") || next.is_empty() || next.at_symbol("#") {
        return false;
    }
    let word = next.ident().map(ToString::to_string);
    word.is_none_or(|word| !begins_statement(&word) && !is_misspelt_block(&next, &word))
}

/// Whether a name with a block behind it was meant to begin a statement.
fn is_misspelt_block(cursor: &Cursor, word: &str) -> bool {
    matches!(cursor.peek_at(1), Some(TokenTree::Group(group))
        if group.delimiter() == Delimiter::Brace)
        && closest(word, words::STATEMENTS).is_some()
}

fn begins_statement(word: &str) -> bool {
    words::STATEMENTS.contains(&word)
}

/// An abbreviation; without its value its name is known all the same.
fn abbreviation(cursor: &mut Cursor) -> Checked<Statement> {
    let name = name(cursor, "the name of the abbreviation")?;
    if name.text == words::POSITIVE {
        return positive(cursor);
    }
    let unit = match cursor.eat_symbol(":") {
        true => unit::declared(cursor).unwrap_or(None),
        false => None,
    };
    let value = said_of(&name, cursor, |cursor| {
        equals(cursor)?;
        expression(cursor)
    })?;
    Ok(Statement::Let { name, unit, value })
}

fn statement(cursor: &mut Cursor, documentation: Documentation) -> Checked<Statement> {
    let keyword = cursor.place();
    let Some(word) = cursor.eat_name() else {
        let error = cursor.unexpected("a statement such as `parameters` or `lagrangian`");
        cursor.advance();
        return Err(error);
    };
    match word.text.as_str() {
        "parameters" => {
            let quantities = quantities(cursor, &word)?.into_iter();
            Ok(Statement::Parameters(quantities.map(in_unit).collect()))
        }
        "coordinates" => Ok(Statement::Coordinates(quantities(cursor, &word)?)),
        "controls" => Ok(Statement::Controls(quantities(cursor, &word)?)),
        "states" => Ok(Statement::States(quantities(cursor, &word)?)),
        "rates" => Ok(Statement::Rates(assignments(cursor, &word)?)),
        "let" => abbreviation(cursor),
        "fn" => function(cursor),
        "profile" => profile::profile(cursor),
        "lagrangian" => {
            cursor.eat_symbol("=");
            let value = expression(cursor)?;
            Ok(Statement::Lagrangian { keyword, value })
        }
        "dissipation" => {
            cursor.eat_symbol("=");
            let value = expression(cursor)?;
            Ok(Statement::Dissipation { keyword, value })
        }
        "forces" => Ok(Statement::Forces(assignments(cursor, &word)?)),
        "surface" => surface(cursor, documentation),
        "impact" => law::impact(cursor),
        "dry" => law::dry_friction(cursor, documentation),
        "joint" => joint::joint(cursor, documentation),
        "when" => control::when(cursor, &word, documentation),
        "at" => control::at(cursor, &word),
        "start" => Ok(Statement::Start(assignments(cursor, &word)?)),
        "horizon" => {
            let value = expression(cursor)?;
            Ok(Statement::Horizon { keyword, value })
        }
        "minimize" => {
            cursor.eat_symbol("=");
            let value = expression(cursor)?;
            Ok(Statement::Minimize { keyword, value })
        }
        "constraint" => control::constraint(cursor, documentation),
        "finally" => control::finally(cursor, &word),
        "free" if control::is_parameter(cursor) => {
            let quantity = in_unit(quantity(cursor)?);
            control::free_parameter(cursor, quantity, documentation)
        }
        "free" => control::free(cursor, &word),
        "measured" => measured::measured(cursor, documentation),
        "outputs" => Ok(Statement::Outputs(quantities(cursor, &word)?)),
        "picture" => picture::picture(cursor, &word),
        _ => Err(unknown_statement(cursor, &word)),
    }
}

/// Numbers above zero, behind a text with a line for all that is said of them.
fn positive(cursor: &mut Cursor) -> Checked<Statement> {
    let literal = cursor.peek().map(ToString::to_string).unwrap_or_default();
    let text = syn::parse_str::<syn::LitStr>(&literal).map(|text| text.value());
    let Ok([code, of, part, message]) = text.map(|text| {
        let mut lines = text.split('\n').map(str::to_owned);
        [(); 4].map(|()| lines.next().unwrap_or_default())
    }) else {
        return Err(cursor.unexpected("a text"));
    };
    cursor.advance();
    equals(cursor)?;
    Ok(Statement::Positive(Positive {
        code: if code == "E27" { "E27" } else { "E10" },
        message,
        of,
        part,
        value: expression(cursor)?,
    }))
}

fn unknown_statement(cursor: &mut Cursor, word: &Name) -> Reported {
    let text = word.text.as_str();
    let written = words::example(text);
    let message = match closest(text, words::STATEMENTS) {
        _ if written.is_some() => format!(
            "`{text}` is written as in `{}`",
            written.unwrap_or_default()
        ),
        _ if slips::is_equation_of_motion(cursor) => slips::EQUATIONS_FOLLOW.to_owned(),
        _ if text == "friction" => {
            "`friction` is part of an impact law; write `impact name: ..., friction mu`, or \
             `dry friction name: bound f, sliding dot(q)` for friction without a surface"
                .to_owned()
        }
        _ if words::LAW_PARTS.contains(&text) => format!(
            "`{text}` is part of an impact law; write `impact name: ..., {text} ...`, with commas \
             between the parts"
        ),
        near => {
            if let Some(near) = near {
                slips::expect_name_of(near, cursor, 0);
            }
            words::unknown_statement(text, near).unwrap_or_else(|| {
                format!(
                    "unknown statement `{text}`; a statement begins with {}",
                    list(words::STATEMENTS)
                )
            })
        }
    };
    // What a misspelt block declares is known by name, so that its uses give no messages.
    if let Some(group) = cursor.eat_group(Delimiter::Brace) {
        let mut inner = cursor.inside(&group);
        while !inner.is_empty() {
            if let Some(name) = inner.eat_name() {
                cursor.said().poison(&name.text);
            } else {
                inner.advance();
            }
        }
    }
    cursor.said().syntax(word.place(), message)
}

fn quantities(cursor: &mut Cursor, word: &Name) -> Checked<Vec<Quantity>> {
    let inner = block(cursor, word)?;
    Ok(entries(inner, quantity))
}

fn quantity(cursor: &mut Cursor) -> Checked<Quantity> {
    let documentation = documentation(cursor);
    let place = cursor.place();
    if cursor.ident().is_none()
        && let Some((name, [lower, upper], message)) = between(cursor)
    {
        cursor.said().syntax(place, message);
        return Ok(Quantity {
            documentation,
            name,
            unit: None,
            bounds: Some((lower, upper)),
            value: None,
            free: false,
        });
    }
    let name = name(cursor, "a name")?;
    let unit = if cursor.eat_symbol(":") {
        // A faulty unit has been reported and skipped; the quantity is declared all the same.
        unit::declared(cursor).unwrap_or(None)
    } else {
        unit::in_brackets(cursor, &name)
    };
    let (bounds, value) = said_of(&name, cursor, bounds_and_value)?;
    Ok(Quantity {
        documentation,
        name,
        unit,
        bounds,
        value,
        free: false,
    })
}

/// A parameter without a declared unit in that of its value, `m = 1 [kg]`.
fn in_unit(quantity: Quantity) -> Quantity {
    let value = quantity.value.as_ref();
    let unit = quantity.unit.clone();
    let unit = unit.or_else(|| value.and_then(Expr::unit).cloned());
    Quantity { unit, ..quantity }
}

fn bounds_and_value(cursor: &mut Cursor) -> Checked<(Bounds, Option<Expr>)> {
    let bounds = range(cursor)?;
    let value = if cursor.eat_symbol("=") {
        Some(expression(cursor)?)
    } else {
        None
    };
    if value.is_some() && cursor.at_word("in") {
        let message = "bounds stand before the value, as in `u: N in -1..=1 = 0`";
        return Err(cursor.said().syntax(cursor.place(), message));
    }
    Ok((bounds, value))
}

fn function(cursor: &mut Cursor) -> Checked<Statement> {
    let name = name(cursor, "the name of the function")?;
    let said = said_of(&name, cursor, |cursor| {
        arguments_and_body(cursor, &name.text)
    });
    let (arguments, body) = said?;
    Ok(Statement::Function {
        name,
        arguments,
        body,
    })
}

fn arguments_and_body(cursor: &mut Cursor, function: &str) -> Checked<(Vec<Name>, Expr)> {
    let Some(group) = cursor.eat_group(Delimiter::Parenthesis) else {
        return Err(cursor.unexpected("`(` and the arguments"));
    };
    let before = cursor.said().mistakes();
    let arguments = entries(cursor.inside(&group), |cursor| {
        name(cursor, "the name of an argument")
    });
    if cursor.said().mistakes() > before {
        return Err(Reported);
    }
    if arguments.is_empty() {
        return Err(cursor.said().syntax(
            Place::at(group.span_open()),
            format!("function `{function}` has no argument; write `let {function} = ...` instead"),
        ));
    }
    equals(cursor)?;
    Ok((arguments, expression(cursor)?))
}

fn surface(cursor: &mut Cursor, documentation: Documentation) -> Checked<Statement> {
    let name = name(cursor, "the name of the surface")?;
    let sides = said_of(&name, cursor, |cursor| sides(cursor, &name.text));
    let (left, relation, right) = sides?;
    Ok(Statement::Surface {
        documentation,
        name,
        left,
        relation,
        right,
    })
}

/// Both sides of a surface, and how they compare.
fn sides(cursor: &mut Cursor, surface: &str) -> Checked<(Expr, Relation, Expr)> {
    if !cursor.eat_symbol(":") {
        return Err(
            cursor.unexpected("`:` after the surface's name, as in `surface ground: z >= 0`")
        );
    }
    let left = expression(cursor)?;
    let relation = if cursor.eat_symbol(">=") {
        Relation::AtLeast
    } else if cursor.eat_symbol("<=") {
        Relation::AtMost
    } else if cursor.at_symbol(">") || cursor.at_symbol("<") || cursor.at_symbol("=") {
        return Err(cursor.said().syntax(
            cursor.place(),
            "a surface is an inequality `>=` or `<=`; equality holds in contact",
        ));
    } else {
        return Err(cursor.unexpected("`>=` or `<=`"));
    };
    let right = expression(cursor)?;
    if control::relation_follows(cursor) {
        return Err(cursor.said().syntax(
            cursor.place(),
            format!("a surface compares two sides; declare two surfaces, the second one with `{right}` on its left"),
        ));
    }
    if another_one_follows(cursor) {
        let message = format!(
            "a surface is one inequality; declare one more for what follows, as in `surface {surface}_2: ...`, and name both in \
             the law, as in `impact {surface}, {surface}_2: inelastic`"
        );
        cursor.said().syntax(cursor.place(), message);
        skip_to_statement(cursor);
    }
    Ok((left, relation, right))
}

/// A quantity between its bounds, `lower <= name <= upper`: the name, both bounds, and what to write; the cursor moves
/// behind it.
fn between(cursor: &mut Cursor) -> Option<(Name, [Expr; 2], String)> {
    let mut ahead = cursor.silent();
    let bound = |ahead: &mut Cursor| expression(ahead).ok();
    let at_most = |ahead: &mut Cursor| ahead.eat_symbol("<=") || ahead.eat_symbol("<");
    let lower = bound(&mut ahead)?;
    let name = at_most(&mut ahead).then(|| ahead.eat_name()).flatten()?;
    let upper = at_most(&mut ahead).then(|| bound(&mut ahead)).flatten()?;
    cursor.follow(ahead);
    let message = format!(
        "bounds stand behind the name; write `{} in {lower}..={upper}`",
        name.text
    );
    Some((name, [lower, upper], message))
}
