//! Names of members and of parts: `theta[3]` and `left.knee` become one name each, if they are declared.

use super::index::{self, Fault};
use super::repeat::{DECLARING, DEEPEST, unit_end};
use super::tokens::{around, group_in, inside, is_product, is_punct, items, keyword, undocumented};
use crate::diagnostics::{Diagnostics, Place, closest};
use crate::words;
use proc_macro2::{Delimiter, Group, Ident, Span, TokenTree};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::rc::Rc;

/// What stands in an identifier for an opened bracket before a minus sign, one alone, and a point: middle dots, of which Rust allows
/// identifiers to be made without a warning, and the language none.
const SIGNS: [(&str, &str); 3] = [("[-", "···"), ("[", "··"), (".", "·")];

/// A name as one identifier.
pub(super) fn encoded(name: &str) -> String {
    let signs = SIGNS.into_iter();
    signs.fold(name.replace(']', ""), |text, (sign, dots)| {
        text.replace(sign, dots)
    })
}

/// A whole name as the identifier that stands for it.
pub(super) fn ident(whole: &str, span: Span) -> Ident {
    Ident::new(&encoded(whole), span)
}

/// The name that an identifier stands for.
pub(crate) fn decoded(text: String) -> String {
    if text.is_ascii() || !text.contains('·') {
        return text;
    }
    let mut name = String::new();
    let mut open = false;
    let signs = SIGNS.into_iter();
    let text = signs.fold(text, |text, (sign, dots)| text.replace(dots, sign));
    for c in text.chars() {
        if open && (c == '[' || c == '.') {
            name.push(']');
            open = false;
        }
        open |= c == '[';
        name.push(c);
    }
    if open {
        name.push(']');
    }
    name
}

/// A name with indices.
pub(super) fn member(name: &str, indices: &[i64]) -> String {
    let indices = indices.iter().map(|index| format!("[{index}]"));
    indices.fold(name.to_owned(), |name, index| name + &index)
}

/// A whole name without the indices at its end, and these.
fn split(whole: &str) -> (&str, Vec<i64>) {
    let own = whole.rfind('.').map_or(0, |point| point + 1);
    let Some(open) = whole[own..].find('[').map(|open| own + open) else {
        return (whole, Vec::new());
    };
    let numbers = whole[open..].split(['[', ']']);
    let numbers = numbers.filter_map(|number| number.parse().ok());
    (&whole[..open], numbers.collect())
}

/// Where names are looked for: in a part, then in the scene.
#[derive(Default)]
pub(super) struct Scope {
    /// What names of the part begin with; empty for the scene itself.
    pub(super) prefix: String,
    /// Arguments that are names, and what they name where the part is used.
    pub(super) aliases: HashMap<String, (Vec<TokenTree>, Rc<Scope>)>,
}

/// Every name that has indices or belongs to a part.
#[derive(Default)]
pub(super) struct Names {
    /// Which indices a name has.
    families: HashMap<String, BTreeSet<Vec<i64>>>,
    known: HashSet<String>,
    parts: HashSet<String>,
    /// Parts that are places themselves.
    places: HashSet<String>,
}

impl Names {
    pub(super) fn declare(&mut self, name: &str, indices: &[i64]) {
        if !indices.is_empty() {
            let family = self.families.entry(name.to_owned()).or_default();
            family.insert(indices.to_vec());
        }
        self.known.insert(member(name, indices));
    }

    /// Notes names that have indices of which none runs.
    pub(super) fn declare_none(&mut self, empty: Vec<String>, prefix: &str) {
        for name in empty {
            self.families.entry(format!("{prefix}{name}")).or_default();
        }
    }

    /// The whole name of a part in use; none if another one has it.
    pub(super) fn declare_part(&mut self, name: &str, indices: &[i64]) -> Option<String> {
        self.declare(name, indices);
        let whole = member(name, indices);
        self.parts.insert(whole.clone()).then_some(whole)
    }

    /// The same of a part that is a place as well: a body.
    pub(super) fn declare_body(&mut self, name: &str, indices: &[i64]) -> Option<String> {
        let whole = self.declare_part(name, indices)?;
        self.places.insert(whole.clone());
        Some(whole)
    }

    /// Declares what may have points in its name; whether it is new.
    pub(super) fn declare_path(&mut self, whole: &str) -> bool {
        for (point, _) in whole.match_indices('.') {
            let part = &whole[..point];
            let (name, numbers) = split(part);
            self.declare(name, &numbers);
            self.parts.insert(part.to_owned());
        }
        let (name, numbers) = split(whole);
        let is_new = !self.has(whole);
        self.declare(name, &numbers);
        is_new
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.families.contains_key(name) || self.known.contains(name)
    }

    /// Declares what a statement declares.
    pub(super) fn declare_all(&mut self, statement: &[TokenTree], scope: &Scope) {
        let tokens = undocumented(statement).get(1..).unwrap_or_default();
        let block = group_in(tokens.first(), Delimiter::Brace).map_or_else(Vec::new, inside);
        let entries = || items(&block).map(undocumented);
        match keyword(statement).as_str() {
            "picture" => entries().for_each(|entry| self.head(entry.get(1..), scope)),
            block if DECLARING.contains(&block) => {
                entries().for_each(|entry| self.head(Some(entry), scope));
            }
            "dry" => self.head(tokens.get(1..), scope),
            "let" | "fn" | "surface" | "joint" | "constraint" | "profile" | "measured" | "free" => {
                self.head(Some(tokens), scope);
            }
            _ => {}
        }
    }

    /// Declares the name at the begin, with the indices behind it.
    fn head(&mut self, tokens: Option<&[TokenTree]>, scope: &Scope) {
        let Some([TokenTree::Ident(name), rest @ ..]) = tokens else {
            return;
        };
        let indices = rest.first().and_then(indices).unwrap_or_default();
        let name = decoded(name.to_string());
        // What was written out has its whole name.
        let is_whole = name.contains(['.', '[']);
        if !is_whole && (!indices.is_empty() || !scope.prefix.is_empty()) {
            self.declare(&format!("{}{name}", scope.prefix), &indices);
        }
    }

    /// Tokens with all names of members and parts put together.
    pub(super) fn resolved(
        &self,
        tokens: &[TokenTree],
        scope: &Scope,
        diagnostics: &mut Diagnostics,
    ) -> Vec<TokenTree> {
        let pictured = keyword(tokens) == "picture";
        self.resolved_in((tokens, pictured), scope, diagnostics)
    }

    /// The same of a statement, or of an entry of `picture`.
    pub(super) fn resolved_in(
        &self,
        (tokens, pictured): (&[TokenTree], bool),
        scope: &Scope,
        diagnostics: &mut Diagnostics,
    ) -> Vec<TokenTree> {
        let keyword = keyword(tokens);
        let mut found = Resolver {
            names: self,
            scope,
            diagnostics,
            depth: 0,
            pictured,
            declares: DECLARING.contains(&keyword.as_str())
                || matches!(keyword.as_str(), "let" | "free" | "profile"),
        };
        found.tokens(tokens)
    }
}

/// The whole numbers in brackets.
pub(super) fn indices(token: &TokenTree) -> Option<Vec<i64>> {
    numbers(bracket(Some(token))?).ok()
}

fn numbers(group: &Group) -> Result<Vec<i64>, Fault> {
    let (inner, place) = (inside(group), Place::at(group.span_open()));
    items(&inner)
        .map(|item| index::whole(item, place, &Vec::new()))
        .collect()
}

fn bracket(token: Option<&TokenTree>) -> Option<&Group> {
    group_in(token, Delimiter::Bracket)
}

/// Whether a name behind others is that of a component or of a part.
fn is_component(before: &[TokenTree], name: &TokenTree) -> bool {
    let is_place = ["x", "y", "z"].contains(&name.to_string().as_str());
    let of_vector = |point: &TokenTree| is_place || !is_product(point, name);
    is_punct(before.last(), '.') && before.last().is_some_and(of_vector)
}

struct Resolver<'a> {
    names: &'a Names,
    scope: &'a Scope,
    diagnostics: &'a mut Diagnostics,
    depth: usize,
    /// Whether words of a picture may be meant.
    pictured: bool,
    /// Whether a unit stands behind a colon.
    declares: bool,
}

impl Resolver<'_> {
    fn tokens(&mut self, tokens: &[TokenTree]) -> Vec<TokenTree> {
        let mut written: Vec<TokenTree> = Vec::with_capacity(tokens.len());
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            match token {
                TokenTree::Ident(name) if !is_component(&written, token) => {
                    let (name, length) = self.name(name, &tokens[at + 1..]);
                    written.push(name.into());
                    at += length;
                }
                TokenTree::Group(group) if self.depth < DEEPEST => {
                    let is_unit = matches!(written.last(), Some(TokenTree::Literal(_)));
                    let is_unit = is_unit && group.delimiter() == Delimiter::Bracket;
                    written.push(match is_unit {
                        true => token.clone(),
                        false => {
                            self.depth += 1;
                            let inner = self.tokens(&inside(group));
                            self.depth -= 1;
                            around(group, inner)
                        }
                    });
                }
                _ if self.declares && is_punct(Some(token), ':') => {
                    let end = at + unit_end(&tokens[at..]);
                    written.extend_from_slice(&tokens[at..end]);
                    at = end;
                    continue;
                }
                other => written.push(other.clone()),
            }
            at += 1;
        }
        written
    }

    /// The whole of a name that begins here, and how many tokens more it takes.
    fn name(&mut self, first: &Ident, rest: &[TokenTree]) -> (Ident, usize) {
        let text = decoded(first.to_string());
        if self.pictured && words::is_of_picture(&text) {
            return (first.clone(), 0);
        }
        let names = self.names;
        let Some(mut name) = self.whole(&text, self.scope) else {
            return (first.clone(), 0);
        };
        let (mut length, mut place) = (0, Place::at(first.span()));
        loop {
            let indexed = bracket(rest.get(length)).is_some();
            let members = names.families.get(&name);
            if let Some(members) = members.filter(|members| indexed || !members.is_empty()) {
                place.end = rest.get(length).map_or(place.end, TokenTree::span);
                match self.indexed(&name, members, (rest.get(length), place)) {
                    Some(indices) => name = member(&name, &indices),
                    // A word of Rust, so that nothing else is said of it.
                    None => {
                        self.diagnostics.poison(&name);
                        let taken = length + usize::from(bracket(rest.get(length)).is_some());
                        return (Ident::new(&encoded(&name), first.span()), taken);
                    }
                }
                length += 1;
            }
            match &rest[length.min(rest.len())..] {
                [point, TokenTree::Ident(next), ..]
                    if is_punct(Some(point), '.') && names.parts.contains(&name) =>
                {
                    let part = name.clone();
                    name = format!("{part}.{next}");
                    length += 2;
                    if !names.has(&name) {
                        // A component of a place, or the product with a vector.
                        let is_place = ["x", "y", "z"].iter().any(|known| next == known);
                        if names.places.contains(&part)
                            && (is_place || is_product(point, &next.clone().into()))
                        {
                            (name, length) = (part, length - 2);
                            break;
                        }
                        self.no_such(&part, next);
                        self.diagnostics.poison(&name);
                        break;
                    }
                }
                _ => break,
            }
        }
        (Ident::new(&encoded(&name), first.span()), length)
    }

    /// The whole of a name as a part or the scene has it, if it is one of those that are put together.
    fn whole(&mut self, text: &str, scope: &Scope) -> Option<String> {
        match scope.aliases.get(text) {
            Some((named, outer)) => {
                if let [TokenTree::Ident(name)] = &named[..] {
                    let name = decoded(name.to_string());
                    return Some(self.whole(&name, outer).unwrap_or(name));
                }
                let named = self.names.resolved(named, outer, self.diagnostics);
                Some(decoded(named.first()?.to_string()))
            }
            None => {
                let own = format!("{}{text}", scope.prefix);
                let candidates = [own, text.to_owned()];
                candidates.into_iter().find(|name| self.names.has(name))
            }
        }
    }

    /// The indices of a name that has some.
    fn indexed(
        &mut self,
        name: &str,
        members: &BTreeSet<Vec<i64>>,
        (token, place): (Option<&TokenTree>, Place),
    ) -> Option<Vec<i64>> {
        let Some(first) = members.first() else {
            let message = format!("`{name}` has no members: no index runs where it is declared");
            self.diagnostics.report("E26", place, message);
            return None;
        };
        let indices = bracket(token).map(numbers).transpose();
        let fault = match indices {
            Ok(Some(indices)) if members.contains(&indices) => return Some(indices),
            Ok(Some(indices)) if indices.len() == first.len() => {
                Some(outside(name, &indices, members))
            }
            Ok(_) => None,
            Err(Fault { place, message }) => {
                self.diagnostics.report("E26", place, message);
                return None;
            }
        };
        let many = match first.len() {
            1 => "an index".to_owned(),
            more => format!("{more} indices"),
        };
        let message = fault.unwrap_or_else(|| {
            let example = member(name, first).replace("][", ", ");
            format!("`{name}` has {many}; write one of them, as in `{example}`")
        });
        let place = match bracket(token) {
            None => Place::at(place.start),
            Some(_) => place,
        };
        self.diagnostics.report("E26", place, message);
        None
    }

    fn no_such(&mut self, part: &str, next: &Ident) {
        let begin = format!("{part}.");
        let names = self.names.known.iter().chain(self.names.families.keys());
        let names = names.filter_map(|name| name.strip_prefix(&begin));
        let mut names: Vec<&str> = names.filter(|name| !name.contains(['.', '['])).collect();
        names.sort_unstable();
        names.dedup();
        let text = next.to_string();
        let message = match closest(&text, names.iter().copied()) {
            Some(near) => format!("part `{part}` has no `{text}`; did you mean `{part}.{near}`?"),
            None => format!(
                "part `{part}` has no `{text}`; it has {}",
                crate::diagnostics::list(names)
            ),
        };
        self.diagnostics
            .report("E27", Place::at(next.span()), message);
    }
}

/// What is said of indices that a name does not have.
fn outside(name: &str, indices: &[i64], members: &BTreeSet<Vec<i64>>) -> String {
    let shown = member(name, indices).replace("][", ", ");
    for (at, &index) in indices.iter().enumerate() {
        let values = || members.iter().filter_map(|member| member.get(at).copied());
        let (Some(lowest), Some(highest)) = (values().min(), values().max()) else {
            continue;
        };
        if !(lowest..=highest).contains(&index) {
            let which = match indices.len() {
                1 => "the index".to_owned(),
                _ => format!("index {}", at + 1),
            };
            return format!(
                "`{shown}` is not declared: {which} of `{name}` is {lowest} to {highest}, not {index}"
            );
        }
    }
    format!("`{shown}` is not declared: `{name}` leaves out these indices")
}
