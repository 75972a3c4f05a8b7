//! Counts, and parts: statements that are declared once and used under names.

use super::index::{self, Known};
use super::names::{self, Names, Scope, encoded};
use super::repeat::Repeat;
use super::tokens::{
    group_in, grouped, inside, is_punct, items, keyword, place_of, punct, undocumented, word,
};
use crate::diagnostics::{Diagnostics, Place, closest};
use crate::words;
use proc_macro2::{Delimiter, Group, Ident, TokenStream, TokenTree};
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::rc::Rc;

/// Deepest parts of parts.
const DEEPEST: usize = 16;

/// A statement, and where its names are looked for.
pub(super) type Placed = (Vec<TokenTree>, Rc<Scope>);

/// Whether `count n =`, `part leg(` or `use "leg.hang"` is there.
pub(crate) fn is_declaration(tokens: &[TokenTree]) -> bool {
    match tokens {
        [TokenTree::Ident(word), TokenTree::Literal(file), ..] if *word == "use" => {
            file.to_string().starts_with('"')
        }
        [TokenTree::Ident(word), TokenTree::Ident(_), next, ..] => {
            *word == "count" && is_punct(Some(next), '=')
                || *word == "part" && group_in(Some(next), Delimiter::Parenthesis).is_some()
        }
        _ => false,
    }
}

/// Whether a statement begins here that is written out: a declaration, or `left: leg(..)`, behind that token.
pub(super) fn begins_written_out(tokens: &[TokenTree], before: Option<&TokenTree>) -> bool {
    let named = match before {
        Some(TokenTree::Ident(word)) => words::takes_next(&word.to_string()),
        Some(TokenTree::Punct(mark)) => mark.as_char() != ';',
        _ => false,
    };
    !named && (is_declaration(tokens) || a_use(tokens).is_some() || is_written_out(tokens))
}

/// Whether a statement of bodies is there: `body crate`, `gravity (0, -g)`, also without the name that is missing.
fn is_written_out(tokens: &[TokenTree]) -> bool {
    match tokens {
        [TokenTree::Ident(word), TokenTree::Ident(name), ..] => {
            let (word, name) = (word.to_string(), name.to_string());
            // `inertia shape angle phi` is about something that is called so.
            let behind = tokens.get(2);
            let is_value = words::is_clause(&name)
                && ![':', '.', ','].iter().any(|&mark| is_punct(behind, mark))
                && group_in(behind, Delimiter::Bracket).is_none();
            words::is_of_bodies(&word) && !words::is_keyword(&name) && !is_value
        }
        [TokenTree::Ident(word), next, ..] => {
            let is_vector = group_in(Some(next), Delimiter::Parenthesis).is_some();
            let is_value = is_vector || matches!(next, TokenTree::Literal(_));
            *word == "gravity" && is_value
                || words::is_of_bodies(&word.to_string()) && is_punct(Some(next), ':')
        }
        _ => false,
    }
}

/// Whether a token belongs to the statement of a body before it: the name at its begin, and the first `at` of a body or a shape.
fn is_of_body(token: &TokenTree, statement: &[TokenTree]) -> bool {
    let is_at = |token: &TokenTree| matches!(token, TokenTree::Ident(word) if word == words::AT);
    let statement = undocumented(statement);
    let word = keyword(statement);
    let is_name = !matches!(token, TokenTree::Ident(name) if words::is_keyword(&name.to_string()));
    words::is_of_bodies(&word) && statement.len() == 1 && is_name
        || is_at(token)
            && ["body", "shape"].contains(&word.as_str())
            && !statement.iter().any(is_at)
}

/// Whether a statement begins at the first of these tokens.
fn begins_any(tokens: &[TokenTree], before: Option<&TokenTree>) -> bool {
    let Some(TokenTree::Ident(word)) = tokens.first() else {
        return false;
    };
    let word = word.to_string();
    let called = group_in(tokens.get(1), Delimiter::Parenthesis).is_some();
    // A time in parentheses has braces or a range behind it.
    let is_time = matches!(tokens.get(2), Some(TokenTree::Ident(word)) if word == "in")
        || group_in(tokens.get(2), Delimiter::Brace).is_some();
    let is_value = called && (word == words::START || word == words::AT && !is_time);
    !is_punct(before, '.')
        && (words::STATEMENTS.contains(&word.as_str()) && !is_value
            || begins_written_out(tokens, before))
}

/// The statements that tokens hold, each with its documentation.
pub(super) fn statements(tokens: &[TokenTree]) -> Vec<&[TokenTree]> {
    let mut found = Vec::new();
    let (mut begin, mut documented) = (0, false);
    for at in 0..tokens.len() {
        let before = at.checked_sub(1).and_then(|before| tokens.get(before));
        let documents = is_punct(tokens.get(at), '#') && !is_punct(before, '#');
        let begins =
            begins_any(&tokens[at..], before) && !is_of_body(&tokens[at], &tokens[begin..at]);
        if !documented && (documents || begins) {
            found.push(&tokens[begin..at]);
            begin = at;
        }
        documented = documents || documented && !begins;
    }
    found.push(&tokens[begin..]);
    found.retain(|statement| !statement.is_empty());
    found
}

struct Part {
    /// Each argument, and its unit with the colon in front.
    arguments: Vec<(Ident, Vec<TokenTree>)>,
    body: Vec<TokenTree>,
}

/// A part in use: `left: leg(hip, a)`.
struct Use<'a> {
    name: &'a Ident,
    indices: Option<&'a TokenTree>,
    part: &'a Ident,
    arguments: &'a Group,
}

fn a_use(tokens: &[TokenTree]) -> Option<Use<'_>> {
    let [TokenTree::Ident(name), rest @ ..] = tokens else {
        return None;
    };
    let indexed = group_in(rest.first(), Delimiter::Bracket).is_some();
    let (indices, rest) = rest.split_at(usize::from(indexed));
    match rest {
        [colon, TokenTree::Ident(part), arguments, ..] if is_punct(Some(colon), ':') => Some(Use {
            name,
            indices: indices.first(),
            part,
            arguments: group_in(Some(arguments), Delimiter::Parenthesis)?,
        }),
        _ => None,
    }
}

fn ends(token: &TokenTree) -> bool {
    is_punct(Some(token), ',') || is_punct(Some(token), ';')
}

/// What stands behind a declaration or the use of a part, which is read as a statement and so refused.
fn behind(statement: &[TokenTree]) -> &[TokenTree] {
    let statement = undocumented(statement);
    let length = match keyword(statement).as_str() {
        _ if !is_declaration(statement) => {
            let is_last = |token| group_in(Some(token), Delimiter::Parenthesis).is_some();
            statement.iter().position(is_last).map(|last| last + 1)
        }
        "use" => Some(2),
        "part" => Some(4),
        _ => Some(statement.len() - behind_count(statement).len()),
    };
    let rest = length
        .and_then(|length| statement.get(length..))
        .unwrap_or_default();
    &rest[rest.iter().take_while(|token| ends(token)).count()..]
}

/// What stands behind the number of a count, but for more of them, which are refused there.
fn behind_count(statement: &[TokenTree]) -> &[TokenTree] {
    let end = statement.iter().position(ends).unwrap_or(statement.len());
    match &statement[end..] {
        [_, TokenTree::Ident(_), sign, rest @ ..] if is_punct(Some(sign), '=') => {
            behind_count(rest)
        }
        rest => rest,
    }
}

/// Whether an argument names something: `hip`, `left.p[2]`.
fn is_name(tokens: &[TokenTree]) -> bool {
    let mut pointed = true;
    tokens.iter().all(|token| match token {
        TokenTree::Ident(_) => std::mem::take(&mut pointed),
        TokenTree::Group(group) => !pointed && group.delimiter() == Delimiter::Bracket,
        TokenTree::Punct(mark) => mark.as_char() == '.' && !std::mem::replace(&mut pointed, true),
        TokenTree::Literal(_) => false,
    })
}

/// The statements of `let p[k in 1..=n] = .., p[0] = ..`, those without running indices first, and of `impact a[..], b[..]: law`.
fn apart(statement: &[TokenTree]) -> Vec<Vec<TokenTree>> {
    if keyword(statement) == "impact" {
        return impacts(statement);
    }
    let pieces: Vec<&[TokenTree]> = items(statement).collect();
    let is_let = keyword(statement) == "let";
    let is_value = |piece: &&[TokenTree]| matches!(piece, [TokenTree::Ident(_), TokenTree::Group(_), sign, ..] if is_punct(Some(sign), '='));
    if !is_let || pieces.len() < 2 || !pieces[1..].iter().all(is_value) {
        return vec![statement.to_vec()];
    }
    let values = pieces[1..].iter().map(|piece| {
        let keyword = word("let", piece[0].span());
        [&[keyword], *piece].concat()
    });
    values.chain([pieces[0].to_vec()]).collect()
}

/// A statement for each of the surfaces whose indices run by themselves, and for those without indices; others go with the one before.
fn impacts(statement: &[TokenTree]) -> Vec<Vec<TokenTree>> {
    let colon = statement
        .iter()
        .position(|token| is_punct(Some(token), ':'));
    let (head, law) = statement.split_at(colon.unwrap_or(statement.len()));
    let runs = |token: &TokenTree| {
        group_in(Some(token), Delimiter::Bracket)
            .is_some_and(|group| index::is_repetition(&inside(group)))
    };
    let mut found: Vec<Vec<TokenTree>> = Vec::new();
    let mut is_running = false;
    for name in head.split(|token| is_punct(Some(token), ',')) {
        let own = name.iter().any(runs);
        let indexed = name
            .iter()
            .any(|token| group_in(Some(token), Delimiter::Bracket).is_some());
        match found.last_mut() {
            None => found.push(name.to_vec()),
            Some(_) if is_running && (own || !indexed) => found.push([&head[..1], name].concat()),
            Some(last) => {
                last.push(punct(',', head[0].span()));
                last.extend_from_slice(name);
            }
        }
        is_running = own || is_running && indexed;
    }
    found
        .into_iter()
        .map(|head| [&head, law].concat())
        .collect()
}

#[derive(Default)]
pub(super) struct Parts {
    parts: HashMap<String, Part>,
    /// Counts of the scene, which are known in its parts too.
    pub(super) counts: Known,
}

impl Parts {
    /// Notes a count or a part.
    pub(super) fn note(&mut self, statement: &[TokenTree], diagnostics: &mut Diagnostics) {
        let statement = undocumented(statement);
        let [
            TokenTree::Ident(word),
            TokenTree::Ident(name),
            next,
            rest @ ..,
        ] = statement
        else {
            return;
        };
        if !is_declaration(statement) {
            return;
        }
        let (text, place) = (name.to_string(), Place::at(name.span()));
        if self.counts.iter().any(|(known, _)| *known == text) || self.parts.contains_key(&text) {
            let message = format!("`{text}` is declared twice; rename this {word}");
            diagnostics.report("E19", place, message);
            return;
        }
        if *word == "count" {
            let end = rest.iter().position(ends).unwrap_or(rest.len());
            let value = index::whole(&rest[..end], place, &self.counts);
            let value = value.and_then(|value| match value < 0 {
                true => index::fault(
                    place,
                    format!("count `{text}` is {value}, where 0 is the least"),
                ),
                false => Ok(value),
            });
            let value = value.unwrap_or_else(|fault| {
                diagnostics.report("E26", fault.place, fault.message);
                1
            });
            self.counts.push((text, value));
            if let Some(TokenTree::Ident(next)) = rest.get(end + 1)
                && is_punct(rest.get(end + 2), '=')
            {
                let message = format!(
                    "`count` declares one number; write `count {next} = ..` as a statement of its own"
                );
                diagnostics.report("E26", Place::at(next.span()), message);
                self.note(&[&statement[..1], &rest[end + 1..]].concat(), diagnostics);
            }
            return;
        }
        let (TokenTree::Group(arguments), Some(TokenTree::Group(body))) = (next, rest.first())
        else {
            let message = format!(
                "part `{text}` needs its statements in braces, as in `part {text}(a: m) {{ coordinates {{ q: rad }} .. }}`"
            );
            diagnostics.report("E27", place, message);
            return;
        };
        let mut part = Part {
            arguments: Vec::new(),
            body: inside(body),
        };
        for argument in items(&inside(arguments)) {
            match argument {
                [TokenTree::Ident(name), unit @ ..]
                    if unit.is_empty() || is_punct(unit.first(), ':') =>
                {
                    part.arguments.push((name.clone(), unit.to_vec()));
                }
                _ => {
                    let message = "an argument of a part is a name, with a unit if it has one, as in `part leg(hip, a: m)`";
                    diagnostics.report("E27", place_of(argument, place), message);
                }
            }
        }
        self.parts.insert(text, part);
    }

    /// Statements without repetition, those of parts among them.
    pub(super) fn unrolled(
        &self,
        tokens: &[TokenTree],
        (known, scope): (&Known, &Rc<Scope>),
        names: &mut Names,
        repeat: &mut Repeat<'_>,
    ) -> Vec<Placed> {
        let mut found = Vec::new();
        for statement in statements(tokens).into_iter().flat_map(apart) {
            if is_declaration(undocumented(&statement)) {
                found.push((behind(&statement).to_vec(), Rc::clone(scope)));
                continue;
            }
            let members = repeat.each(&statement, known);
            names.declare_none(std::mem::take(&mut repeat.empty), &scope.prefix);
            for (tokens, known) in members {
                let written = repeat.statement(&tokens, &known);
                names.declare_none(std::mem::take(&mut repeat.empty), &scope.prefix);
                match a_use(undocumented(&written)) {
                    Some(used) => {
                        found.extend(self.used(&used, (&known, scope), names, repeat));
                        found.push((behind(&written).to_vec(), Rc::clone(scope)));
                    }
                    None => found.push((written, Rc::clone(scope))),
                }
            }
        }
        found
    }

    /// The statements of a part under a name.
    fn used(
        &self,
        used: &Use<'_>,
        (known, scope): (&Known, &Rc<Scope>),
        names: &mut Names,
        repeat: &mut Repeat<'_>,
    ) -> Vec<Placed> {
        let (text, place) = (used.part.to_string(), Place::at(used.part.span()));
        let parts = self.parts.keys().map(String::as_str);
        let refusal = match self.parts.get(&text) {
            None => match closest(&text, parts) {
                Some(near) => format!("there is no part `{text}`; did you mean `{near}`?"),
                None => format!(
                    "there is no part `{text}`; declare `part {text}(..) {{ .. }}`, or `use` the file that does"
                ),
            },
            Some(_) if repeat.parts >= DEEPEST => {
                format!(
                    "part `{text}` is used inside of itself, or parts stand in each other more than {DEEPEST} deep"
                )
            }
            Some(part) => {
                let own = inside(used.arguments);
                let own: Vec<&[TokenTree]> = items(&own).collect();
                if own.len() == part.arguments.len() {
                    repeat.parts += 1;
                    let found = self.placed((used, part), &own, (known, scope), names, repeat);
                    repeat.parts -= 1;
                    return found;
                }
                let wanted = part.arguments.iter().map(|(name, _)| name.to_string());
                let wanted: Vec<String> = wanted.collect();
                format!(
                    "part `{text}` takes {}, as in `{}: {text}({})`; found {}",
                    counted(wanted.len()),
                    used.name,
                    wanted.join(", "),
                    own.len()
                )
            }
        };
        repeat.diagnostics.report("E27", place, refusal);
        Vec::new()
    }

    fn placed(
        &self,
        (used, part): (&Use<'_>, &Part),
        arguments: &[&[TokenTree]],
        (known, scope): (&Known, &Rc<Scope>),
        names: &mut Names,
        repeat: &mut Repeat<'_>,
    ) -> Vec<Placed> {
        let name = format!("{}{}", scope.prefix, names::decoded(used.name.to_string()));
        let indices = used.indices.and_then(names::indices).unwrap_or_default();
        let Some(name) = names.declare_part(&name, &indices) else {
            let message = format!(
                "`{}` is declared twice; rename this use of a part",
                used.name
            );
            let place = Place::at(used.name.span());
            repeat.diagnostics.report("E19", place, message);
            return Vec::new();
        };
        let mut inner = Scope {
            prefix: format!("{name}."),
            ..Scope::default()
        };
        let mut counts = self.counts.clone();
        let mut found = Vec::new();
        for ((argument, unit), value) in part.arguments.iter().zip(arguments) {
            let around = Place::at(used.arguments.span_open());
            if unit.is_empty()
                && let Ok(whole) = index::whole(value, around, known)
            {
                counts.push((argument.to_string(), whole));
            } else if unit.is_empty() && is_name(value) {
                let named = (value.to_vec(), Rc::clone(scope));
                inner.aliases.insert(argument.to_string(), named);
            } else {
                let whole = format!("{name}.{argument}");
                names.declare(&whole, &[]);
                let span = argument.span();
                let mut statement = vec![word("let", span), word(&encoded(&whole), span)];
                statement.extend_from_slice(unit);
                statement.push(punct('=', span));
                let value = value.to_vec();
                let span = value.first().map_or(span, TokenTree::span);
                statement.push(grouped(Delimiter::None, value, span));
                found.push((statement, Rc::clone(scope)));
            }
        }
        found.extend(self.unrolled(&part.body, (&counts, &Rc::new(inner)), names, repeat));
        found
    }
}

fn counted(arguments: usize) -> String {
    match arguments {
        1 => "1 argument".to_owned(),
        more => format!("{more} arguments"),
    }
}

/// The files that a text uses.
pub(crate) fn files(tokens: TokenStream) -> Vec<String> {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let named = tokens.windows(2).filter(|pair| is_declaration(pair));
    let named = named.map(|pair| pair[1].to_string());
    named
        .map(|name| name.trim_matches('"').to_owned())
        .collect()
}

/// Where the statements of a text and of its parts begin, in bytes.
pub(crate) fn begins(tokens: TokenStream) -> HashSet<usize> {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut found = HashSet::new();
    for statement in statements(&tokens).into_iter().map(undocumented) {
        found.extend(
            statement
                .first()
                .map(|first| first.span().byte_range().start),
        );
        if let [_, _, _, TokenTree::Group(body), ..] = statement
            && keyword(statement) == "part"
        {
            found.extend(begins(body.stream()));
        }
    }
    found
}

/// The counts of a text, each with the bytes where its number stands.
pub(crate) fn counts(tokens: TokenStream) -> Vec<(String, Range<usize>)> {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut found = Vec::new();
    for statement in statements(&tokens) {
        match undocumented(statement) {
            [
                TokenTree::Ident(word),
                TokenTree::Ident(name),
                sign,
                TokenTree::Literal(value),
                ..,
            ] if *word == "count" && is_punct(Some(sign), '=') => {
                found.push((name.to_string(), value.span().byte_range()));
            }
            _ => {}
        }
    }
    found
}
