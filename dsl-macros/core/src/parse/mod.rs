//! Tokens to syntax tree. Own code instead of a Rust parser: formulas read as on paper, and every
//! mistake is reported in the words of the language, all of them in one run.

mod control;
mod cursor;
mod documentation;
mod expression;
mod joint;
mod law;
mod measured;
mod number;
mod picture;
mod pieces;
mod profile;
mod recorded;
mod slips;
mod statement;
mod unit;

pub(crate) use law::law_of;

use crate::ast::{Name, Scene, Statement};
use crate::diagnostics::{Checked, Diagnostics};
use crate::{expand, words};
use cursor::{Cursor, Said};
use documentation::documentation;
use proc_macro2::{Delimiter, Span, TokenStream, TokenTree};
use std::cell::RefCell;
use std::rc::Rc;

/// Parses one declaration. What could be read is returned even when mistakes were reported.
pub(crate) fn scene(input: TokenStream, diagnostics: &mut Diagnostics) -> Checked<Scene> {
    let said = Rc::new(RefCell::new(std::mem::take(diagnostics)));
    let scene = declaration(Cursor::new(input, Span::call_site(), Rc::clone(&said)));
    *diagnostics = said.take();
    let mut scene = scene?;
    recorded::record(&mut scene.statements, diagnostics);
    Ok(scene)
}

/// What stands in the braces of a declaration.
pub(crate) fn body(input: TokenStream) -> Option<TokenStream> {
    let groups = input.into_iter().filter_map(|token| match token {
        TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => Some(group),
        _ => None,
    });
    groups.last().map(|group| group.stream())
}

/// The declaration at the cursor.
fn declaration(mut cursor: Cursor) -> Checked<Scene> {
    let documentation = documentation(&mut cursor);
    let visibility = visibility(&mut cursor);
    let Some(name) = cursor.eat_name() else {
        return Err(cursor.said().syntax(
            cursor.place(),
            format!(
                "expected the name of the scene, found {}; write `pub Name {{ ... }}`",
                cursor.describe()
            ),
        ));
    };
    let Some(body) = cursor.eat_group(Delimiter::Brace) else {
        let remedy = match name.text.as_str() {
            "model" | "hangtime" => "; leave out `model!` and its braces here",
            _ => "",
        };
        return Err(cursor.said().syntax(
            cursor.place(),
            format!(
                "expected `{{` after the name `{}`, found {}{remedy}",
                name.text,
                cursor.describe()
            ),
        ));
    };
    if !cursor.is_empty() {
        cursor.said().syntax(
            cursor.place(),
            format!(
                "unexpected {} after the scene; declare one scene in each `model!`",
                cursor.describe()
            ),
        );
    }
    let statements = expand::expanded(body.stream(), &mut cursor.said())?;
    let mut inner = Cursor::new(statements, body.span_close(), cursor.all_said());
    note_names(inner.clone());
    let statements = statement::statements(&mut inner);
    Ok(Scene {
        documentation,
        visibility,
        name,
        statements,
    })
}

/// Notes which names the scene declares, so that messages about what stands before them know.
fn note_names(mut cursor: Cursor) {
    while !cursor.is_empty() {
        if cursor.eat_word("let") || cursor.eat_word("fn") || cursor.eat_word("free") {
            if let Some(name) = cursor.eat_name() {
                cursor.said().declare(&name.text);
            }
            continue;
        }
        let block = ["parameters", "coordinates", "controls", "states", "outputs"]
            .iter()
            .any(|word| cursor.at_word(word));
        cursor.advance();
        if let Some(group) = cursor.eat_group(Delimiter::Brace).filter(|_| block) {
            let mut inner = cursor.inside(&group);
            // A name stands at the begin, behind a comma or behind documentation.
            let mut begins = true;
            while !inner.is_empty() {
                if let Some(name) = inner.ident().filter(|_| begins) {
                    cursor.said().declare(&expand::decoded(name.to_string()));
                }
                begins = inner.at_symbol(",")
                    || matches!(inner.peek(), Some(TokenTree::Group(group))
                        if group.delimiter() == Delimiter::Bracket);
                inner.advance();
            }
        }
    }
}

/// What a stub needs of a scene with mistakes.
pub(crate) struct Outline {
    pub(crate) visibility: TokenStream,
    pub(crate) name: Name,
    pub(crate) parameters: Vec<Name>,
}

/// The outline of a scene, as far as it can be told from input with mistakes.
pub(crate) fn outline(input: TokenStream) -> Option<Outline> {
    let mut silent = Diagnostics::default();
    let Ok(scene) = scene(input.clone(), &mut silent) else {
        let mut cursor = Cursor::new(input, Span::call_site(), Said::default());
        documentation(&mut cursor);
        return Some(Outline {
            visibility: visibility(&mut cursor),
            name: cursor.eat_name().filter(is_plain)?,
            parameters: Vec::new(),
        });
    };
    let mut parameters: Vec<Name> = Vec::new();
    for statement in scene.statements {
        if let Statement::Parameters(quantities) = statement {
            for quantity in quantities {
                if is_plain(&quantity.name)
                    && !parameters
                        .iter()
                        .any(|known| known.text == quantity.name.text)
                {
                    parameters.push(quantity.name);
                }
            }
        }
    }
    is_plain(&scene.name).then_some(Outline {
        visibility: scene.visibility,
        name: scene.name,
        parameters,
    })
}

/// Whether a name can be emitted as an identifier.
fn is_plain(name: &Name) -> bool {
    !words::is_rust_word(&name.text)
}

fn visibility(cursor: &mut Cursor) -> TokenStream {
    let mut tokens = TokenStream::new();
    if cursor.at_word("pub") {
        tokens.extend(cursor.advance());
        if let Some(group) = cursor.eat_group(Delimiter::Parenthesis) {
            tokens.extend([TokenTree::Group(group)]);
        }
    }
    tokens
}
