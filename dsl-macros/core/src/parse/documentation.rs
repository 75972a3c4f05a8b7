//! Doc comments.

use super::cursor::Cursor;
use crate::ast::Documentation;
use proc_macro2::{Delimiter, TokenStream};

/// Doc comments, which reach the macro as `#[doc = "text"]`.
pub(super) fn documentation(cursor: &mut Cursor) -> Documentation {
    let mut lines = Vec::new();
    while cursor.at_symbol("#") {
        let place = cursor.place();
        cursor.advance();
        let Some(group) = cursor.eat_group(Delimiter::Bracket) else {
            cursor
                .said()
                .syntax(place, "unexpected `#`; only doc comments may stand here");
            continue;
        };
        match doc_line(group.stream()) {
            Some(line) => lines.push(line.trim().to_owned()),
            None => {
                cursor.said().syntax(
                    place,
                    "attributes are not part of the language; only doc comments may stand here",
                );
            }
        }
    }
    lines.join("\n").trim().to_owned()
}

/// The text of `doc = "text"`, if the content of an attribute is that.
fn doc_line(attribute: TokenStream) -> Option<String> {
    let syn::Meta::NameValue(meta) = syn::parse2(attribute).ok()? else {
        return None;
    };
    match meta.value {
        syn::Expr::Lit(syn::ExprLit {
            lit: syn::Lit::Str(text),
            ..
        }) if meta.path.is_ident("doc") => Some(text.value()),
        _ => None,
    }
}
