//! Measured motions: `measured name: "file" { target within deviation, ..., start { ... } }`.

use super::cursor::Cursor;
use super::expression::expression;
use super::pieces::{assignments, block, entries, name, target};
use crate::ast::{Assignment, Documentation, Measured, MeasuredQuantity, Name, Statement};
use crate::diagnostics::Checked;
use proc_macro2::TokenTree;

/// The word in front of a standard deviation.
const WITHIN: &str = "within";
/// The word in front of start values.
const START: &str = "start";
/// What the statement looks like, for messages.
const EXAMPLE: &str = "measured flight: \"throw.csv\" { z within 1 [cm] }";

/// An entry of the block.
enum Entry {
    Quantity(Box<MeasuredQuantity>),
    Start(Vec<Assignment>),
}

/// Parses what stands behind the word `measured`.
pub(super) fn measured(cursor: &mut Cursor, documentation: Documentation) -> Checked<Statement> {
    let name = name(cursor, "the name of the experiment")?;
    let file = file(cursor, &name)?;
    let inner = block(cursor, &name)?;
    let entries = entries(inner, |cursor| {
        if cursor.at_word(START)
            && let Some(word) = cursor.eat_name()
        {
            return Ok(Entry::Start(assignments(cursor, &word)?));
        }
        Ok(Entry::Quantity(Box::new(quantity(cursor)?)))
    });
    let mut measured = Measured {
        documentation,
        name,
        file,
        quantities: Vec::new(),
        start: Vec::new(),
    };
    for entry in entries {
        match entry {
            Entry::Quantity(quantity) => measured.quantities.push(*quantity),
            Entry::Start(start) => measured.start.extend(start),
        }
    }
    Ok(Statement::Measured(Box::new(measured)))
}

/// `: "file"`.
fn file(cursor: &mut Cursor, name: &Name) -> Checked<String> {
    if !cursor.eat_symbol(":") {
        let wanted = format!("`:` and the file of the measurements, as in `{EXAMPLE}`");
        return Err(cursor.unexpected(&wanted));
    }
    let place = cursor.place();
    let literal = match cursor.peek() {
        Some(TokenTree::Literal(literal)) => literal.to_string(),
        _ => String::new(),
    };
    let Ok(file) = syn::parse_str::<syn::LitStr>(&literal) else {
        let wanted = format!("the name of a file in quotation marks, as in `{EXAMPLE}`");
        return Err(cursor.unexpected(&wanted));
    };
    cursor.advance();
    let file = file.value();
    if file.trim().is_empty() {
        let message = format!(
            "`{}` has no file; write the name of the file with its measurements, as in `{EXAMPLE}`",
            name.text
        );
        return Err(cursor.said().syntax(place, message));
    }
    Ok(file)
}

/// `target within deviation`.
fn quantity(cursor: &mut Cursor) -> Checked<MeasuredQuantity> {
    let (target, velocity) = target(cursor)?;
    if !cursor.eat_word(WITHIN) {
        let wanted = format!(
            "`within` and the standard deviation of the measurements, as in `{} within 1 [cm]`",
            target.text
        );
        return Err(cursor.unexpected(&wanted));
    }
    let within = expression(cursor)?;
    Ok(MeasuredQuantity {
        target,
        velocity,
        within,
    })
}
