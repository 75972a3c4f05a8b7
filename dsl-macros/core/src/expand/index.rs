//! Indices: whole numbers, the ranges that they run over, and the conditions that they meet.

use crate::diagnostics::Place;
use proc_macro2::{Delimiter, Ident, Spacing, TokenTree};
use std::cmp::Ordering;

/// Most members of one repetition: the pairs of 500 bodies, which is the most coordinates that a scene has.
const MOST: usize = 500 * 500 / 2;

/// What an index or a count is, innermost last.
pub(super) type Known = Vec<(String, i64)>;

/// What is wrong with an index, and where.
pub(super) struct Fault {
    pub(super) place: Place,
    pub(super) message: String,
}

type Found<T> = Result<T, Fault>;

fn fault<T>(place: Place, message: impl Into<String>) -> Found<T> {
    let message = message.into();
    Err(Fault { place, message })
}

/// One member of a repetition: what is known in it, and the indices of its name.
pub(super) struct Member {
    pub(super) known: Known,
    pub(super) indices: Vec<i64>,
}

/// The place of tokens, or that of what stands around them if there are none.
pub(super) fn place_of(tokens: &[TokenTree], around: Place) -> Place {
    match tokens {
        [first, .., last] => Place::at(first.span()).to(Place::at(last.span())),
        [only] => Place::at(only.span()),
        [] => around,
    }
}

pub(super) fn is_punct(token: Option<&TokenTree>, mark: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == mark)
}

/// Tokens between commas; a comma at the end ends nothing.
pub(super) fn items(tokens: &[TokenTree]) -> impl Iterator<Item = &[TokenTree]> {
    tokens
        .split(|token| is_punct(Some(token), ','))
        .filter(|item| !item.is_empty())
}

/// The name of an index and the tokens of its range, if an item is `name in range`.
fn runs(item: &[TokenTree]) -> Option<(&Ident, &[TokenTree])> {
    match item {
        [TokenTree::Ident(name), TokenTree::Ident(word), range @ ..] if word == "in" => {
            Some((name, range))
        }
        _ => None,
    }
}

/// Whether indices run here.
pub(super) fn is_repetition(tokens: &[TokenTree]) -> bool {
    items(tokens).any(|item| runs(item).is_some())
}

/// All members of `i in 1..=n, j in 1..i, i != 2`; an item that is neither a range nor a condition is an index that stays.
pub(super) fn members(tokens: &[TokenTree], around: Place, known: &Known) -> Found<Vec<Member>> {
    let known = known.clone();
    let mut members = vec![Member {
        known,
        indices: Vec::new(),
    }];
    for item in items(tokens) {
        let place = place_of(item, around);
        if let Some((name, range)) = runs(item) {
            let mut more = Vec::new();
            for member in members {
                let (lower, upper) = range_of(range, place, &member.known)?;
                if upper.saturating_sub(lower) >= MOST as i64 || more.len() >= MOST {
                    return fault(
                        place,
                        format!("more than {MOST} members; count fewer in one repetition"),
                    );
                }
                more.extend((lower..=upper).map(|value| {
                    let (mut known, mut indices) = (member.known.clone(), member.indices.clone());
                    known.push((name.to_string(), value));
                    indices.push(value);
                    Member { known, indices }
                }));
            }
            members = more;
        } else if let Some(split) = comparison(item) {
            let mut kept = Vec::new();
            for member in members {
                if compare(item, split, place, &member.known)? {
                    kept.push(member);
                }
            }
            members = kept;
        } else {
            for member in &mut members {
                let index = whole(item, place, &member.known)?;
                member.indices.push(index);
            }
        }
    }
    Ok(members)
}

/// The first and the last whole number of `a..=b` or `a..b`.
fn range_of(tokens: &[TokenTree], around: Place, known: &Known) -> Found<(i64, i64)> {
    let split = tokens
        .windows(2)
        .position(|pair| is_punct(pair.first(), '.') && is_punct(pair.last(), '.'));
    let Some(split) = split else {
        return fault(
            around,
            "an index runs over a range of whole numbers, as in `k in 1..=n`",
        );
    };
    let lower = whole(&tokens[..split], around, known)?;
    let rest = &tokens[split + 2..];
    match is_punct(rest.first(), '=') {
        true => Ok((lower, whole(&rest[1..], around, known)?)),
        false => Ok((lower, whole(rest, around, known)?.saturating_sub(1))),
    }
}

/// Where the sign of a comparison begins, and how many characters it has.
fn comparison(tokens: &[TokenTree]) -> Option<(usize, usize)> {
    tokens
        .iter()
        .enumerate()
        .find_map(|(at, token)| match token {
            TokenTree::Punct(punct) if "<>=!".contains(punct.as_char()) => {
                let equal = punct.spacing() == Spacing::Joint && is_punct(tokens.get(at + 1), '=');
                Some((at, 1 + usize::from(equal)))
            }
            _ => None,
        })
}

fn compare(
    tokens: &[TokenTree],
    (at, length): (usize, usize),
    around: Place,
    known: &Known,
) -> Found<bool> {
    let left = whole(&tokens[..at], around, known)?;
    let right = whole(&tokens[at + length..], around, known)?;
    let order = left.cmp(&right);
    let mark = match &tokens[at] {
        TokenTree::Punct(punct) => punct.as_char(),
        _ => '=',
    };
    Ok(match (mark, length) {
        ('<', 1) => order == Ordering::Less,
        ('<', _) => order != Ordering::Greater,
        ('>', 1) => order == Ordering::Greater,
        ('>', _) => order != Ordering::Less,
        ('=', 2) => order == Ordering::Equal,
        ('!', 2) => order != Ordering::Equal,
        _ => return fault(around, "indices are compared by `<`, `<=`, `==`, `!=`"),
    })
}

/// Whether a comparison of indices is true; none if it is one of anything else.
pub(super) fn is_true(tokens: &[TokenTree], known: &Known) -> Option<bool> {
    let around = Place::at(tokens.first()?.span());
    compare(tokens, comparison(tokens)?, around, known).ok()
}

/// The whole number that an expression of indices and counts is.
pub(super) fn whole(tokens: &[TokenTree], around: Place, known: &Known) -> Found<i64> {
    let mut reader = Reader {
        tokens,
        at: 0,
        around,
        known,
    };
    let value = reader.sum()?;
    match reader.tokens.get(reader.at) {
        None => Ok(value),
        Some(token) => fault(
            Place::at(token.span()),
            format!(
                "`{token}` has no meaning in an index; it is made of whole numbers, counts, `+`, `-`, `*`, `/`, `%`"
            ),
        ),
    }
}

struct Reader<'a> {
    tokens: &'a [TokenTree],
    at: usize,
    around: Place,
    known: &'a Known,
}

impl Reader<'_> {
    /// The next token if it is one of these marks.
    fn mark(&mut self, marks: &str) -> Option<char> {
        match self.tokens.get(self.at) {
            Some(TokenTree::Punct(punct)) if marks.contains(punct.as_char()) => {
                self.at += 1;
                Some(punct.as_char())
            }
            _ => None,
        }
    }

    fn sum(&mut self) -> Found<i64> {
        let mut value = self.product()?;
        while let Some(mark) = self.mark("+-") {
            let operand = self.product()?;
            value = self.join(value, mark, operand)?;
        }
        Ok(value)
    }

    fn product(&mut self) -> Found<i64> {
        let mut value = self.atom()?;
        while let Some(mark) = self.mark("*/%") {
            let operand = self.atom()?;
            value = self.join(value, mark, operand)?;
        }
        Ok(value)
    }

    fn join(&self, left: i64, mark: char, right: i64) -> Found<i64> {
        let value = match mark {
            '+' => left.checked_add(right),
            '-' => left.checked_sub(right),
            '*' => left.checked_mul(right),
            '%' => left.checked_rem_euclid(right),
            _ => left
                .checked_div(right)
                .filter(|quotient| quotient * right == left),
        };
        match value {
            Some(value) => Ok(value),
            None => fault(
                place_of(self.tokens, self.around),
                format!("{left} {mark} {right} is no whole number"),
            ),
        }
    }

    fn atom(&mut self) -> Found<i64> {
        if self.mark("-").is_some() {
            return Ok(self.atom()?.saturating_neg());
        }
        let Some(token) = self.tokens.get(self.at) else {
            return fault(self.around, "an index is missing here");
        };
        self.at += 1;
        let place = Place::at(token.span());
        match token {
            TokenTree::Group(group)
                if matches!(group.delimiter(), Delimiter::Parenthesis | Delimiter::None) =>
            {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                whole(&inner, place, self.known)
            }
            TokenTree::Ident(name) => {
                let known = self.known.iter().rev();
                match known.clone().find(|(known, _)| name == known) {
                    Some(&(_, value)) => Ok(value),
                    None => fault(
                        place,
                        format!(
                            "`{name}` is no index here and no count; write `count {name} = 3`, or let it run as in `{name} in 1..=3`"
                        ),
                    ),
                }
            }
            other => match other.to_string().parse() {
                Ok(value) => Ok(value),
                Err(_) => fault(place, format!("`{other}` is no whole number")),
            },
        }
    }
}
