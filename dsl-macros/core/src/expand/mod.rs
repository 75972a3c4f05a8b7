//! Repetition and parts, which are written out before anything else is read: tokens of a scene to tokens of a scene without
//! them, each at the place where it was written. What repeats is copied, with numbers in the place of its indices; the
//! statements of a part stand where it is used, with its name in front of theirs. A scene without any of it is not touched.

mod body;
mod clause;
mod constants;
mod contact;
mod hinge;
mod index;
mod names;
mod part;
mod repeat;
mod shape;
mod space;
mod tokens;
mod written;

pub(crate) use names::decoded;
pub(crate) use part::{begins, counts, files, is_declaration};
pub(crate) use tokens::is_product;

use crate::diagnostics::{Checked, Diagnostics, Place};
use names::{Names, Scope};
use proc_macro2::{Delimiter, TokenStream, TokenTree};
use repeat::{DEEPEST, Repeat};
use std::rc::Rc;
use tokens::{group_in, grouped, inside, is_punct, joined, keyword, place_of, undocumented, word};
use written::Written;

/// Statements of a scene without repetition and parts.
///
/// # Errors
/// It is too long.
pub(crate) fn expanded(stream: TokenStream, diagnostics: &mut Diagnostics) -> Checked<TokenStream> {
    let tokens: Vec<TokenTree> = stream.clone().into_iter().collect();
    if !is_used(&tokens, 0) {
        return Ok(stream);
    }
    let (mut names, mut parts) = (Names::default(), part::Parts::default());
    let statements = part::statements(&tokens);
    for statement in &statements {
        parts.note(statement, diagnostics);
    }
    let declares = |statement: &&[TokenTree]| is_declaration(undocumented(statement));
    if let Some(part) = statements
        .iter()
        .find(|statement| keyword(statement) == "part")
        && statements.iter().all(declares)
    {
        let place = place_of(&undocumented(part)[..2], Place::at(tokens[0].span()));
        let message = "parts alone are no scene; another text takes them in, as by `use \"leg.hang\"`, and uses them under names, as in \
                       `left: leg(..)`";
        return Err(diagnostics.report("E27", place, message));
    }
    let (mut repeat, scope) = (Repeat::new(diagnostics), Rc::new(Scope::default()));
    let known = &parts.counts;
    let unrolled = parts.unrolled(&tokens, (known, &scope), &mut names, &mut repeat);
    repeat.is_bounded()?;
    let unrolled = written_out(unrolled, &mut names, diagnostics);
    for (statement, scope) in &unrolled {
        names.declare_all(statement, scope);
    }
    let resolved = unrolled
        .iter()
        .map(|(statement, scope)| names.resolved(statement, scope, diagnostics));
    let resolved = in_one(resolved.collect());
    Ok(resolved.into_iter().flatten().collect())
}

/// Statements without bodies, shapes and contacts.
fn written_out(
    statements: Vec<part::Placed>,
    names: &mut Names,
    diagnostics: &mut Diagnostics,
) -> Vec<part::Placed> {
    let in_space = space::is_there(&statements);
    let mut written = Written::new(names, diagnostics, in_space);
    for (statement, scope) in statements {
        written.scope = scope;
        let _: Checked<()> = match keyword(&statement).as_str() {
            "gravity" => body::gravity(&mut written, &statement),
            "body" => body::body(&mut written, &statement),
            "shape" => shape::shape(&mut written, &statement),
            "contact" => contact::contact(&mut written, &statement),
            "hinge" | "ball" | "weld" | "slider" | "rolling" => {
                hinge::joint(&mut written, &statement)
            }
            _ => written.other(statement),
        };
    }
    body::finished(written)
}

/// Whether tokens hold anything of what is written out.
fn is_used(tokens: &[TokenTree], depth: usize) -> bool {
    (0..tokens.len()).any(|at| {
        let rest = &tokens[at..];
        let before = at.checked_sub(1).and_then(|before| tokens.get(before));
        let named = matches!(rest[0], TokenTree::Ident(_));
        let here = match &rest[0] {
            TokenTree::Ident(_) if depth == 0 && part::begins_written_out(rest, before) => true,
            TokenTree::Punct(_) if is_punct(rest.first(), '+') => is_punct(rest.get(1), '='),
            TokenTree::Group(group) if depth < DEEPEST => {
                let inner = inside(group);
                let repeats = match group.delimiter() {
                    Delimiter::Bracket => index::is_repetition(&inner),
                    _ => repeat::comprehension(&inner).is_some(),
                };
                repeats || is_used(&inner, depth + 1)
            }
            _ => false,
        };
        // `theta[3]: rad` declares three.
        let bracket = group_in(rest.get(1), Delimiter::Bracket).is_some();
        here || bracket && named && is_punct(rest.get(2), ':')
    })
}

/// All `lagrangian += ..`, and `dissipation += ..`, as one statement each, in the place of the last.
fn in_one(mut statements: Vec<Vec<TokenTree>>) -> Vec<Vec<TokenTree>> {
    for name in ["lagrangian", "dissipation"] {
        let is_one = |statement: &Vec<TokenTree>| matches!(statement.first(), Some(TokenTree::Ident(first)) if first == name);
        let adds =
            |statement: &Vec<TokenTree>| is_one(statement) && is_punct(statement.get(1), '+');
        let Some(last) = statements.iter().rposition(adds) else {
            continue;
        };
        let span = statements[last][0].span();
        let among = |marks: [char; 2]| {
            move |token: &&TokenTree| marks.iter().any(|&mark| is_punct(Some(token), mark))
        };
        let of_it = statements.iter_mut().filter(|statement| is_one(statement));
        let terms: Vec<Vec<TokenTree>> = of_it
            .map(|statement| {
                let begin = 1 + statement[1..].iter().take_while(among(['+', '='])).count();
                let ends = statement.iter().rev().take_while(among([';', ','])).count();
                let end = statement.len() - ends;
                let term = statement[begin.min(end)..end].to_vec();
                statement.clear();
                let span = term.first().map_or(span, TokenTree::span);
                vec![grouped(Delimiter::None, term, span)]
            })
            .collect();
        statements[last].push(word(name, span));
        statements[last].extend(joined(terms.into_iter(), '+', span));
    }
    statements
}
