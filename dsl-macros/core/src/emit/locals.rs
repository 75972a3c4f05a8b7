//! Names of local variables that nothing around the scene can take: where a constant `x` is in scope, `let x` is a
//! pattern that tests for its value.

use proc_macro2::{Delimiter, Ident, Spacing, TokenStream, TokenTree};
use std::collections::HashSet;

/// The code with two underscores in front of every local variable and argument; `scene` is a type, whatever it is called.
pub(super) fn reserved(code: TokenStream, scene: &str) -> TokenStream {
    let mut bound = HashSet::new();
    collect(&code, false, &mut bound);
    bound.remove(scene);
    renamed(code, false, &bound)
}

/// Whether a token is this mark.
fn is_mark(token: Option<&TokenTree>, mark: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == mark)
}

/// Whether a single colon follows, which begins a type or a value of a field, and no path.
fn is_followed_by_colon(token: Option<&TokenTree>) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == ':' && punct.spacing() == Spacing::Alone)
}

/// Notes what `let`, the arguments of functions and those of closures bind.
fn collect(code: &TokenStream, in_parentheses: bool, bound: &mut HashSet<String>) {
    let tokens: Vec<TokenTree> = code.clone().into_iter().collect();
    for (at, token) in tokens.iter().enumerate() {
        match token {
            TokenTree::Group(group) => {
                let inside = group.delimiter() == Delimiter::Parenthesis;
                collect(&group.stream(), inside, bound);
            }
            TokenTree::Ident(ident) => {
                let text = ident.to_string();
                let before = at.checked_sub(1).map(|before| &tokens[before]);
                let after = tokens.get(at + 1);
                let is_let = matches!(before, Some(TokenTree::Ident(word)) if word == "let" || word == "mut");
                let is_argument = in_parentheses && is_followed_by_colon(after);
                let of_closure =
                    is_mark(before, '|') && (is_mark(after, '|') || is_mark(after, ':'));
                if (is_let || is_argument || of_closure)
                    && !matches!(text.as_str(), "_" | "mut" | "self")
                {
                    bound.insert(text);
                }
            }
            _ => {}
        }
    }
}

/// Renames what is bound, but no fields, functions or paths of the same name.
fn renamed(code: TokenStream, in_braces: bool, bound: &HashSet<String>) -> TokenStream {
    let tokens: Vec<TokenTree> = code.into_iter().collect();
    let name = |at: usize, ident: &Ident| {
        let before = at.checked_sub(1).map(|before| &tokens[before]);
        let after = tokens.get(at + 1);
        let is_function = matches!(before, Some(TokenTree::Ident(word)) if word == "fn");
        let is_inside = is_mark(before, '.') || is_mark(before, ':') && is_path(&tokens[..at]);
        let begins = before.is_none() || is_mark(before, ',');
        let is_field = in_braces && begins && is_followed_by_colon(after);
        let text = ident.to_string();
        if is_function || is_inside || is_field || !bound.contains(&text) {
            return ident.clone();
        }
        Ident::new(&format!("__{text}"), ident.span())
    };
    let renamed = tokens.iter().enumerate().map(|(at, token)| match token {
        TokenTree::Ident(ident) => TokenTree::Ident(name(at, ident)),
        TokenTree::Group(group) => {
            let inside = group.delimiter() == Delimiter::Brace;
            let mut new =
                proc_macro2::Group::new(group.delimiter(), renamed(group.stream(), inside, bound));
            new.set_span(group.span());
            TokenTree::Group(new)
        }
        other => other.clone(),
    });
    renamed.collect()
}

/// Whether the tokens end with a double colon.
fn is_path(tokens: &[TokenTree]) -> bool {
    matches!(tokens, [.., TokenTree::Punct(first), TokenTree::Punct(second)]
        if first.as_char() == ':' && first.spacing() == Spacing::Joint && second.as_char() == ':')
}

#[cfg(test)]
mod tests {
    use super::reserved;

    #[test]
    fn locals_and_arguments_are_renamed_and_nothing_else() {
        let code = "impl S { fn x(&self, x: &[f64], p: &S) -> f64 { let mut t1 = p.x + x[0]; let f = |c| c * t1; let q: &S = p; \
                    t1 = Self::x(self, x, p); D { x: ::p::x(x), t1: 2 + f(t1) } } }";
        let wanted = "impl S { fn x(&self, __x: &[f64], __p: &S) -> f64 { let mut __t1 = __p.x + __x[0]; let __f = |__c| \
                      __c * __t1; let __q: &S = __p; __t1 = Self::x(self, __x, __p); D { x: ::p::x(__x), t1: 2 + __f(__t1) } } }";
        let [code, wanted] = [code, wanted].map(|text| text.parse().unwrap());
        let code: proc_macro2::TokenStream = reserved(code, "S");
        let wanted: proc_macro2::TokenStream = wanted;
        assert_eq!(code.to_string(), wanted.to_string());
    }
}
