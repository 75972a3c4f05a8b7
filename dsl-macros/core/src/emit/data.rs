//! Static data as Rust source: what [`Debug`] shows of it, which names types, fields and values as the source does, but for paths.

use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream, TokenTree};
use quote::quote;
use std::fmt::Debug;

/// A value of types that the runtime has in `hangtime::scene::data`, with variants of enumerations in `hangtime::scene::variants`.
/// Lists are references to arrays.
pub(super) fn tokens(value: &impl Debug) -> TokenStream {
    let shown = format!("{value:?}").parse();
    shown.map_or_else(|_| TokenStream::new(), with_paths)
}

fn with_paths(shown: TokenStream) -> TokenStream {
    let mut tokens = TokenStream::new();
    let mut shown = shown.into_iter().peekable();
    while let Some(token) = shown.next() {
        match token {
            TokenTree::Group(group) => {
                let inside = Group::new(group.delimiter(), with_paths(group.stream()));
                let is_list = group.delimiter() == Delimiter::Bracket;
                tokens.extend(is_list.then(|| quote!(&)));
                tokens.extend([TokenTree::Group(inside)]);
            }
            TokenTree::Ident(ident) => {
                let fields = matches!(shown.peek(), Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace);
                tokens.extend(path(&ident, fields));
            }
            token => tokens.extend([token]),
        }
    }
    tokens
}

/// What a name stands for: a type if `fields` follow, a variant, a field or a value.
fn path(name: &Ident, fields: bool) -> TokenStream {
    let text = name.to_string();
    let own = Ident::new(&text, Span::call_site());
    match text.as_str() {
        "Some" | "None" => quote!(::core::option::Option::#own),
        "inf" => quote!(::core::primitive::f64::INFINITY),
        "NaN" => quote!(::core::primitive::f64::NAN),
        _ if fields => quote!(::hangtime::scene::data::#own),
        _ if text.starts_with(|letter: char| letter.is_ascii_uppercase()) => {
            quote!(::hangtime::scene::variants::#own)
        }
        _ => quote!(#own),
    }
}
