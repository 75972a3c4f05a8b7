//! Indices: whole numbers, the ranges that they run over, and the conditions that they meet.

use super::tokens::{around, inside, is_punct, items, number, place_of};
use crate::diagnostics::Place;
use proc_macro2::{Ident, TokenStream, TokenTree};
use syn::{BinOp, Expr, Lit, UnOp};

/// Most members of one repetition: the pairs of 500 bodies, which is the most coordinates that a scene has.
const MOST: usize = 500 * 500 / 2;
/// Longest expression of an index, in characters: it is read recursively.
const LONGEST: usize = 400;

/// What an index or a count is, innermost last.
pub(super) type Known = Vec<(String, i64)>;

/// What is wrong with an index, and where.
pub(super) struct Fault {
    pub(super) place: Place,
    pub(super) message: String,
}

pub(super) type Found<T> = Result<T, Fault>;

pub(super) fn fault<T>(place: Place, message: impl Into<String>) -> Found<T> {
    let message = message.into();
    Err(Fault { place, message })
}

/// One member of a repetition: what is known in it, and the indices of its name.
#[derive(Clone)]
pub(super) struct Member {
    pub(super) known: Known,
    pub(super) indices: Vec<i64>,
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
    let mut members = vec![Member {
        known: known.clone(),
        indices: Vec::new(),
    }];
    for item in items(tokens) {
        let place = place_of(item, around);
        let mut more = Vec::new();
        for mut member in members {
            let Some((name, range)) = runs(item) else {
                match value(item, place, &member.known)? {
                    Value::Number(index) => member.indices.push(index),
                    Value::Truth(true) => {}
                    Value::Truth(false) => continue,
                }
                more.push(member);
                continue;
            };
            let (lower, upper) = range_of(range, place, &member.known)?;
            if upper.saturating_sub(lower) >= MOST as i64 || more.len() >= MOST {
                let message = format!("more than {MOST} members; count fewer in one repetition");
                return fault(place, message);
            }
            more.extend((lower..=upper).map(|value| {
                let mut member = member.clone();
                member.known.push((name.to_string(), value));
                member.indices.push(value);
                member
            }));
        }
        members = more;
    }
    Ok(members)
}

/// The first and the last whole number of `a..=b` or `a..b`.
fn range_of(tokens: &[TokenTree], around: Place, known: &Known) -> Found<(i64, i64)> {
    let mut pairs = tokens.windows(2);
    let split = pairs.position(|pair| pair.iter().all(|token| is_punct(Some(token), '.')));
    let Some(split) = split else {
        let message = "an index runs over a range of whole numbers, as in `k in 1..=n`";
        return fault(around, message);
    };
    let lower = whole(&tokens[..split], around, known)?;
    let rest = &tokens[split + 2..];
    match is_punct(rest.first(), '=') {
        true => Ok((lower, whole(&rest[1..], around, known)?)),
        false => Ok((lower, whole(rest, around, known)?.saturating_sub(1))),
    }
}

/// What an expression of indices and counts is.
enum Value {
    Number(i64),
    /// Whether a comparison holds.
    Truth(bool),
}

/// The whole number that an expression of indices and counts is.
pub(super) fn whole(tokens: &[TokenTree], around: Place, known: &Known) -> Found<i64> {
    match value(tokens, around, known)? {
        Value::Number(value) => Ok(value),
        Value::Truth(_) => fault(place_of(tokens, around), "a comparison is no whole number"),
    }
}

/// Whether a comparison of indices is true; none if it is one of anything else.
pub(super) fn is_true(tokens: &[TokenTree], known: &Known) -> Option<bool> {
    let around = Place::at(tokens.first()?.span());
    match value(tokens, around, known).ok()? {
        Value::Truth(holds) => Some(holds),
        Value::Number(_) => None,
    }
}

fn value(tokens: &[TokenTree], around: Place, known: &Known) -> Found<Value> {
    if tokens.is_empty() {
        return fault(around, "an index is missing here");
    }
    if let [TokenTree::Literal(number)] = tokens
        && let Ok(number) = number.to_string().parse()
    {
        return Ok(Value::Number(number));
    }
    let place = place_of(tokens, around);
    let numbers = numbers(tokens, known)?;
    let shown = numbers.to_string();
    let expression = match shown.len() <= LONGEST {
        true => syn::parse2::<Expr>(numbers).ok(),
        false => None,
    };
    let Some(expression) = expression else {
        let message = format!(
            "`{shown}` has no meaning as an index; it is made of whole numbers, counts, `+`, `-`, `*`, `/`, `%`, and compared by \
             `<`, `<=`, `==`, `!=`"
        );
        return fault(place, message);
    };
    let value = compared(&expression).map(Value::Truth);
    let value = value.or_else(|| computed(&expression).map(Value::Number));
    value.map_or_else(|| fault(place, format!("`{shown}` is no whole number")), Ok)
}

/// Tokens with numbers in the place of indices and counts.
fn numbers(tokens: &[TokenTree], known: &Known) -> Found<TokenStream> {
    let number = |token: &TokenTree| match token {
        TokenTree::Ident(name) => match known.iter().rev().find(|(known, _)| name == known) {
            Some(&(_, value)) => Ok(number(value, name.span())),
            None => fault(
                Place::at(name.span()),
                format!(
                    "`{name}` is no index here and no count; write `count {name} = 3`, or let it run as in `{name} in 1..=3`"
                ),
            ),
        },
        TokenTree::Group(group) => {
            let inner = numbers(&inside(group), known)?;
            Ok(around(group, inner.into_iter().collect()))
        }
        other => Ok(other.clone()),
    };
    tokens.iter().map(number).collect()
}

fn compared(expression: &Expr) -> Option<bool> {
    let Expr::Binary(binary) = expression else {
        return None;
    };
    let holds: fn(&i64, &i64) -> bool = match binary.op {
        BinOp::Lt(_) => i64::lt,
        BinOp::Le(_) => i64::le,
        BinOp::Gt(_) => i64::gt,
        BinOp::Ge(_) => i64::ge,
        BinOp::Eq(_) => i64::eq,
        BinOp::Ne(_) => i64::ne,
        _ => return None,
    };
    Some(holds(&computed(&binary.left)?, &computed(&binary.right)?))
}

fn computed(expression: &Expr) -> Option<i64> {
    match expression {
        Expr::Paren(inner) => computed(&inner.expr),
        Expr::Group(inner) => computed(&inner.expr),
        Expr::Unary(unary) if matches!(unary.op, UnOp::Neg(_)) => {
            computed(&unary.expr)?.checked_neg()
        }
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(number) if number.suffix().is_empty() => number.base10_parse().ok(),
            _ => None,
        },
        Expr::Binary(binary) => {
            let (left, right) = (computed(&binary.left)?, computed(&binary.right)?);
            match binary.op {
                BinOp::Add(_) => left.checked_add(right),
                BinOp::Sub(_) => left.checked_sub(right),
                BinOp::Mul(_) => left.checked_mul(right),
                BinOp::Rem(_) => left.checked_rem_euclid(right),
                BinOp::Div(_) => left.checked_div(right).filter(|_| left % right == 0),
                _ => None,
            }
        }
        _ => None,
    }
}
