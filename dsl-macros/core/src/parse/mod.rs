//! Tokens to syntax tree. Own code instead of a Rust parser: formulas read as on paper, and every
//! mistake is reported in the words of the language, all of them in one run.

mod cursor;
mod expression;
mod statement;
mod unit;

use crate::ast::{Documentation, Name, Scene};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported};
use cursor::Cursor;
use proc_macro2::{Delimiter, Span, TokenStream, TokenTree};

/// Parses one declaration. What could be read is returned even when mistakes were reported.
pub(crate) fn scene(input: TokenStream, diagnostics: &mut Diagnostics) -> Checked<Scene> {
    let mut cursor = Cursor::new(input, Span::call_site());
    let documentation = documentation(&mut cursor, diagnostics);
    let visibility = visibility(&mut cursor);
    let Some(name) = cursor.eat_name() else {
        return Err(diagnostics.syntax(
            cursor.place(),
            format!(
                "expected the name of the scene, found {}; write `pub Name {{ ... }}`",
                cursor.describe()
            ),
        ));
    };
    let Some(body) = cursor.eat_group(Delimiter::Brace) else {
        return Err(diagnostics.syntax(
            cursor.place(),
            format!(
                "expected `{{` after the name `{}`, found {}",
                name.text,
                cursor.describe()
            ),
        ));
    };
    if !cursor.is_empty() {
        diagnostics.syntax(
            cursor.place(),
            format!(
                "unexpected {} after the scene; declare one scene in each `model!`",
                cursor.describe()
            ),
        );
    }
    let statements = statement::statements(&mut Cursor::inside(&body), diagnostics);
    Ok(Scene {
        documentation,
        visibility,
        name,
        statements,
    })
}

/// The name of the scene, as far as it can be told from input with mistakes: for the stub.
pub(crate) fn name_of(input: TokenStream) -> Option<(TokenStream, Name)> {
    let mut cursor = Cursor::new(input, Span::call_site());
    documentation(&mut cursor, &mut Diagnostics::default());
    let visibility = visibility(&mut cursor);
    Some((visibility, cursor.eat_name()?))
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

/// Doc comments, which reach the macro as `#[doc = "text"]`.
fn documentation(cursor: &mut Cursor, diagnostics: &mut Diagnostics) -> Documentation {
    let mut documentation = Documentation::default();
    while cursor.at_symbol("#") {
        let place = cursor.place();
        cursor.advance();
        let Some(group) = cursor.eat_group(Delimiter::Bracket) else {
            diagnostics.syntax(place, "unexpected `#`; only doc comments may stand here");
            continue;
        };
        let mut inner = Cursor::inside(&group);
        let is_doc = inner.eat_word("doc") && inner.eat_symbol("=");
        match (is_doc, inner.advance()) {
            (true, Some(TokenTree::Literal(line))) => documentation.lines.push(line),
            _ => {
                diagnostics.syntax(
                    place,
                    "attributes are not part of the language; only doc comments may stand here",
                );
            }
        }
    }
    documentation
}

/// Reports what was found instead of `expected`.
fn unexpected(cursor: &Cursor, diagnostics: &mut Diagnostics, expected: &str) -> Reported {
    let place: Place = cursor.place();
    diagnostics.syntax(
        place,
        format!("expected {expected}, found {}", cursor.describe()),
    )
}
