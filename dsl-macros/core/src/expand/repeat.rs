//! Repetition: what indices run over is written once for each of their members, with numbers in the place of indices.

use super::index::{self, Fault, Known, Member};
use super::tokens::{
    around, group_in, grouped, inside, is_punct, items, joined, keyword, number, place_of, punct,
    undocumented,
};
use crate::diagnostics::{Checked, Diagnostics, Place, Reported};
use proc_macro2::{Delimiter, Group, Span, TokenStream, TokenTree};

/// Deepest groups that are looked into; deeper ones are refused where they are read.
pub(super) const DEEPEST: usize = 200;
/// Most tokens that are written: some hundred for each of the members that a repetition may have.
const LONGEST: usize = 1 << 22;

/// Blocks whose entries declare names: behind a colon stands a unit.
pub(super) const DECLARING: [&str; 5] =
    ["parameters", "coordinates", "controls", "states", "outputs"];

/// Indices between commas.
fn listed(indices: &[i64], span: Span) -> Vec<TokenTree> {
    let numbers = indices.iter().map(|&index| number(index, span));
    joined(numbers.map(|number| vec![number]), ',', span)
}

/// Where a unit behind a colon ends.
pub(super) fn unit_end(tokens: &[TokenTree]) -> usize {
    let ends = |token: &TokenTree| match token {
        TokenTree::Punct(mark) => mark.as_char() == '=' || mark.as_char() == ',',
        TokenTree::Ident(word) => word == "in",
        _ => false,
    };
    tokens.iter().position(ends).unwrap_or(tokens.len())
}

/// Whether `(k in 1..=n: ...)` stands in a group; where its colon is.
pub(super) fn comprehension(tokens: &[TokenTree]) -> Option<usize> {
    let colon = tokens.iter().position(|token| is_punct(Some(token), ':'))?;
    index::is_repetition(&tokens[..colon]).then_some(colon)
}

/// The indices in brackets that repeat the statement or entry in which they stand, and the way to them: a place a group.
fn first_repetition(tokens: &[TokenTree]) -> Option<(Group, Vec<usize>)> {
    let within = |(at, token): (usize, &TokenTree)| {
        let TokenTree::Group(group) = token else {
            return None;
        };
        let inner = inside(group);
        match group.delimiter() {
            Delimiter::Brace => None,
            Delimiter::Bracket if index::is_repetition(&inner) => Some((group.clone(), vec![at])),
            _ if comprehension(&inner).is_some() => None,
            _ => first_repetition(&inner).map(|(found, mut way)| {
                way.insert(0, at);
                (found, way)
            }),
        }
    };
    tokens.iter().enumerate().find_map(within)
}

/// The same tokens with numbers in the place of the indices to which a way leads.
fn bound(tokens: &[TokenTree], way: &[usize], indices: &[i64]) -> Vec<TokenTree> {
    let mut tokens = tokens.to_vec();
    if let [at, way @ ..] = way
        && let TokenTree::Group(group) = &tokens[*at]
    {
        let inner = match way {
            [] => listed(indices, group.span()),
            _ => bound(&inside(group), way, indices),
        };
        tokens[*at] = around(group, inner);
    }
    tokens
}

pub(super) struct Repeat<'a> {
    pub(super) diagnostics: &'a mut Diagnostics,
    /// Tokens that have been written.
    written: usize,
    /// Names that were declared with indices of which none runs.
    pub(super) empty: Vec<String>,
    /// How many parts are around.
    pub(super) parts: usize,
    depth: usize,
}

impl<'a> Repeat<'a> {
    pub(super) fn new(diagnostics: &'a mut Diagnostics) -> Self {
        Self {
            diagnostics,
            written: 0,
            empty: Vec::new(),
            parts: 0,
            depth: 0,
        }
    }

    /// Whether the scene is short enough to be read.
    pub(super) fn is_bounded(&self) -> Checked<()> {
        match self.written <= LONGEST {
            true => Ok(()),
            false => Err(Reported),
        }
    }

    fn refuse(&mut self, Fault { place, message }: Fault) -> Reported {
        self.diagnostics.report("E26", place, message)
    }

    fn members(
        &mut self,
        tokens: &[TokenTree],
        place: Place,
        known: &Known,
    ) -> Checked<Vec<Member>> {
        if self.is_bounded().is_err() {
            let message =
                format!("the repetitions of the scene have more than {LONGEST} words; count fewer");
            return Err(self.diagnostics.report("E22", place, message));
        }
        index::members(tokens, place, known).map_err(|fault| self.refuse(fault))
    }

    /// A statement or an entry for each member of what repeats it.
    pub(super) fn each(
        &mut self,
        tokens: &[TokenTree],
        known: &Known,
    ) -> Vec<(Vec<TokenTree>, Known)> {
        let Some((group, way)) = first_repetition(tokens) else {
            return vec![(tokens.to_vec(), known.clone())];
        };
        let mut found = Vec::new();
        let members = self.members(&inside(&group), Place::at(group.span_open()), known);
        if let ([at], Ok([])) = (&way[..], members.as_deref())
            && let Some(TokenTree::Ident(name)) = tokens[..*at].last()
        {
            self.empty.push(name.to_string());
        }
        for member in members.unwrap_or_default() {
            self.written += tokens.len();
            let bound = bound(tokens, &way, &member.indices);
            found.extend(self.each(&bound, &member.known));
        }
        found
    }

    /// The entries of a block; `declares` tells that units stand behind colons.
    fn entries(&mut self, tokens: &[TokenTree], known: &Known, declares: bool) -> Vec<TokenTree> {
        let mut written = Vec::new();
        for entry in tokens.split(|token| is_punct(Some(token), ',')) {
            let entry = match declares {
                true => counted(entry),
                false => entry.to_vec(),
            };
            let members = self.each(&entry, known);
            let span = entry.first().map_or_else(Span::call_site, TokenTree::span);
            let members: Vec<_> = members
                .iter()
                .map(|(tokens, known)| match declares {
                    true => self.declaration(tokens, known),
                    false => self.tokens(tokens, known),
                })
                .collect();
            if !written.is_empty() && !members.is_empty() {
                written.push(punct(',', span));
            }
            written.extend(joined(members.into_iter(), ',', span));
        }
        written
    }

    /// `name: unit in range = value`, whose unit stays as it is.
    pub(super) fn declaration(&mut self, tokens: &[TokenTree], known: &Known) -> Vec<TokenTree> {
        let name = undocumented(tokens).iter().find_map(|token| match token {
            TokenTree::Ident(name) if *name != "let" && *name != "free" => Some(name),
            _ => None,
        });
        if let Some(name) = name
            && known.iter().any(|(known, _)| name == known)
        {
            let message = format!("`{name}` is an index or a count here; choose another name");
            let place = Place::at(name.span());
            self.diagnostics.report("E19", place, message);
            return Vec::new();
        }
        let colon = tokens.iter().position(|token| is_punct(Some(token), ':'));
        let colon = colon.unwrap_or(tokens.len());
        let (head, rest) = tokens.split_at(colon);
        let end = unit_end(rest);
        let mut written = self.tokens(head, known);
        written.extend_from_slice(&rest[..end]);
        written.extend(self.tokens(&rest[end..], known));
        written
    }

    /// A statement in which nothing more runs but in its blocks.
    pub(super) fn statement(&mut self, tokens: &[TokenTree], known: &Known) -> Vec<TokenTree> {
        match keyword(tokens).as_str() {
            "free" | "let" => self.declaration(tokens, known),
            "profile" => tokens.to_vec(),
            block if DECLARING.contains(&block) => {
                let written = tokens.iter().map(|token| match token {
                    TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                        around(group, self.entries(&inside(group), known, true))
                    }
                    other => other.clone(),
                });
                written.collect()
            }
            _ => self.tokens(tokens, known),
        }
    }

    /// Tokens with numbers in the place of indices and counts.
    pub(super) fn tokens(&mut self, tokens: &[TokenTree], known: &Known) -> Vec<TokenTree> {
        let mut written: Vec<TokenTree> = Vec::with_capacity(tokens.len());
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            at += 1;
            match token {
                TokenTree::Ident(name)
                    if *name == "if" && self.chosen(tokens, &mut at, known, &mut written) => {}
                TokenTree::Ident(name) if !is_punct(written.last(), '.') => {
                    let value = known.iter().rev().find(|(known, _)| name == known);
                    written.push(match value {
                        Some(&(_, value)) => number(value, name.span()),
                        None => token.clone(),
                    });
                }
                TokenTree::Group(group) if self.depth < DEEPEST => {
                    self.depth += 1;
                    self.group(group, known, &mut written);
                    self.depth -= 1;
                }
                other => written.push(other.clone()),
            }
        }
        self.written += written.len();
        written
    }

    /// `if i < j { a } else { b }` of indices: one of both, and the cursor behind it.
    fn chosen(
        &mut self,
        tokens: &[TokenTree],
        at: &mut usize,
        known: &Known,
        written: &mut Vec<TokenTree>,
    ) -> bool {
        let is_brace = |token: &TokenTree| group_in(Some(token), Delimiter::Brace).is_some();
        let rest = &tokens[*at..];
        let Some(open) = rest.iter().position(is_brace) else {
            return false;
        };
        let [TokenTree::Group(yes), TokenTree::Ident(word), others @ ..] = &rest[open..] else {
            return false;
        };
        let Some(holds) = index::is_true(&rest[..open], known).filter(|_| word == "else") else {
            return false;
        };
        // What follows `else` is a block, or one more `if` with its blocks.
        let Some(mut end) = others.iter().position(is_brace) else {
            return false;
        };
        while matches!(others.get(end + 1), Some(TokenTree::Ident(word)) if word == "else")
            && let Some(next) = others[end + 2..].iter().position(is_brace)
        {
            end += 2 + next;
        }
        let other = match &others[..=end] {
            [TokenTree::Group(no)] => inside(no),
            more => more.to_vec(),
        };
        let value = match holds {
            true => inside(yes),
            false => other,
        };
        let value = self.tokens(&value, known);
        written.push(grouped(Delimiter::Parenthesis, value, yes.span()));
        *at += open + 2 + end + 1;
        true
    }

    fn group(&mut self, group: &Group, known: &Known, written: &mut Vec<TokenTree>) {
        let inner = inside(group);
        // A bracket behind a number is a unit.
        let is_unit = matches!(written.last(), Some(TokenTree::Literal(_)));
        match group.delimiter() {
            Delimiter::Bracket if is_unit => written.push(group.clone().into()),
            Delimiter::Bracket => {
                let indices: Result<Vec<i64>, Fault> = items(&inner)
                    .map(|item| index::whole(item, Place::at(group.span_open()), known))
                    .collect();
                let named = matches!(written.last(), Some(TokenTree::Ident(_)));
                written.push(match indices {
                    Ok(indices) if named => around(group, listed(&indices, group.span())),
                    _ => around(group, self.tokens(&inner, known)),
                });
            }
            Delimiter::Brace => {
                let entries = self.entries(&inner, known, false);
                written.push(around(group, entries));
            }
            _ => match comprehension(&inner) {
                Some(colon) => self.list(group, inner.split_at(colon), known, written),
                None if index::is_repetition(&inner) => {
                    let place = place_of(&inner, Place::at(group.span_open()));
                    let message =
                        "behind indices stands a colon, as in `sum(k in 1..=n: x[k])`".to_owned();
                    self.refuse(Fault { place, message });
                    written.pop_if(|last| matches!(last, TokenTree::Ident(_)));
                    written.push(number(0, group.span()));
                }
                None => {
                    let tokens = self.tokens(&inner, known);
                    written.push(around(group, tokens));
                }
            },
        }
    }

    /// `sum(k in 1..=n: value)`, and the same as a list in the parentheses of anything else.
    fn list(
        &mut self,
        group: &Group,
        (indices, value): (&[TokenTree], &[TokenTree]),
        known: &Known,
        written: &mut Vec<TokenTree>,
    ) {
        let span = group.span();
        let is_sum = matches!(written.last(), Some(TokenTree::Ident(word)) if word == "sum");
        let members = self.members(indices, Place::at(group.span_open()), known);
        if !is_sum && matches!(&members, Ok(members) if members.is_empty()) {
            let place = place_of(indices, Place::at(group.span_open()));
            let message = "no index runs here, so that the list is empty; count one member at least (a `sum` of none is 0)";
            self.diagnostics.report("E26", place, message);
        }
        let mut values = Vec::new();
        for member in members.unwrap_or_default() {
            let value = self.tokens(&value[1..], &member.known);
            values.push(match is_sum {
                true => vec![grouped(Delimiter::Parenthesis, value, span)],
                false => value,
            });
        }
        let mut list = joined(values.into_iter(), if is_sum { '+' } else { ',' }, span);
        if list.is_empty() {
            list.push(number(0, span));
        }
        if is_sum {
            written.pop();
        }
        written.push(around(group, list));
    }
}

/// An entry that declares `name[n]` with `name[_ in 1..=n]` in its place.
fn counted(entry: &[TokenTree]) -> Vec<TokenTree> {
    let mut entry = entry.to_vec();
    let is_name = |token: &TokenTree| matches!(token, TokenTree::Ident(_));
    let at = entry.iter().position(is_name).map_or(0, |named| named + 1);
    if let Some(group) = group_in(entry.get(at), Delimiter::Bracket)
        && is_punct(entry.get(at + 1), ':')
        && let inner = inside(group)
        && !index::is_repetition(&inner)
    {
        let span = group.span();
        let ranges = items(&inner).map(|count| {
            let head: TokenStream = "_ in 1..=".parse().unwrap_or_default();
            let head = head.into_iter().map(|mut token| {
                token.set_span(span);
                token
            });
            head.chain(count.iter().cloned()).collect()
        });
        entry[at] = around(group, joined(ranges, ',', span));
    }
    entry
}
