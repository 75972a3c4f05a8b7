//! Normal forms of sums and products. Everything that creates a node passes through here.

use super::elementary::Function;
use super::limits::{Fault, checked, note, spend, times};
use super::node::{Node, Sym, intern};
use std::rc::Rc;

/// Coefficients that cancel up to this many units of rounding are taken to cancel: 0.1 + 0.2 - 0.3
/// is zero on paper. Each coefficient comes from a few operations on written constants.
const CANCELLATION: f64 = 4.0 * f64::EPSILON;

/// `sum of coefficient * term` in normal form.
pub(crate) fn sum(terms: impl IntoIterator<Item = (Sym, f64)>) -> Sym {
    let mut flat: Vec<(Sym, f64)> = Vec::new();
    for (term, coefficient) in terms {
        match term.node() {
            _ if coefficient == 0.0 => {}
            Node::Number(bits) => {
                flat.push((Sym::ONE, times(coefficient, f64::from_bits(bits))));
            }
            Node::Sum(inner) => {
                if !spend(inner.len()) {
                    return Sym::ZERO;
                }
                flat.extend(
                    inner
                        .iter()
                        .map(|&(term, bits)| (term, times(coefficient, f64::from_bits(bits)))),
                );
            }
            _ => flat.push((term, coefficient)),
        }
    }
    if !spend(flat.len()) {
        return Sym::ZERO;
    }
    flat.sort_by_key(|&(term, _)| term);
    let mut merged: Vec<(Sym, f64)> = Vec::with_capacity(flat.len());
    for (term, coefficient) in flat {
        match merged.last_mut() {
            Some((last, total)) if *last == term => {
                *total = added(*total, coefficient);
            }
            _ => merged.push((term, coefficient)),
        }
    }
    merged.retain(|&(_, coefficient)| coefficient != 0.0);
    match merged.as_slice() {
        [] => Sym::ZERO,
        [(Sym::ONE, constant)] => Sym::number(*constant),
        [(term, 1.0)] => *term,
        _ => intern(Node::Sum(
            merged
                .into_iter()
                .map(|(term, coefficient)| (term, coefficient.to_bits()))
                .collect(),
        )),
    }
}

/// The sum of two coefficients.
fn added(a: f64, b: f64) -> f64 {
    let sum = a + b;
    if sum.abs() <= CANCELLATION * a.abs().max(b.abs()) {
        if sum != 0.0 {
            note(Fault::Cancellation);
        }
        return 0.0;
    }
    if (sum == a && b != 0.0) || (sum == b && a != 0.0) {
        note(Fault::Absorption);
    }
    checked(sum, a.is_finite() && b.is_finite())
}

/// `product of factor^(halves / 2)` in normal form.
pub(crate) fn product(factors: impl IntoIterator<Item = (Sym, i32)>) -> Sym {
    let mut coefficient = 1.0;
    let mut flat: Vec<(Sym, i32)> = factors
        .into_iter()
        .filter(|&(_, halves)| halves != 0)
        .collect();
    if let [(only, 2)] = flat.as_slice() {
        return *only;
    }
    // Merging can turn a root into a whole power, whose base then opens; hence the loop. It settles
    // after a few rounds; any round's result is correct.
    for _ in 0..16 {
        if !spend(flat.len()) {
            return Sym::ZERO;
        }
        let mut opened = Vec::with_capacity(flat.len());
        let mut settled = true;
        for &(factor, halves) in &flat {
            settled &= halves % 2 == 0 && factor.splits_at_once();
            open(factor, halves, &mut coefficient, &mut opened);
        }
        opened.sort_by_key(|&(factor, _)| factor);
        let mut merged: Vec<(Sym, i32)> = Vec::with_capacity(opened.len());
        for (factor, halves) in opened {
            match merged.last_mut() {
                Some((last, total)) if *last == factor => *total += halves,
                _ => merged.push((factor, halves)),
            }
        }
        merged.retain(|&(_, halves)| halves != 0);
        if settled || merged == flat {
            flat = merged;
            break;
        }
        flat = merged;
    }
    if coefficient == 0.0 {
        return Sym::ZERO;
    }
    let monomial = match flat.as_slice() {
        [] => return Sym::number(coefficient),
        [(only, 2)] => *only,
        _ => intern(Node::Product(flat.into())),
    };
    if coefficient == 1.0 {
        monomial
    } else {
        sum([(monomial, coefficient)])
    }
}

/// Splits a factor into a coefficient and factors that are no products, no numbers and no multiples.
fn open(factor: Sym, halves: i32, coefficient: &mut f64, opened: &mut Vec<(Sym, i32)>) {
    let whole = halves % 2 == 0;
    match factor.node() {
        Node::Number(bits) => {
            let value = f64::from_bits(bits);
            if whole {
                multiply(coefficient, value, halves / 2);
            } else if value >= 0.0 {
                multiply(coefficient, value.sqrt(), halves);
            } else {
                // The root of a negative number is none.
                note(Fault::Overflow);
                opened.push((factor, halves));
            }
        }
        Node::Product(inner) if whole => {
            opened.extend(
                inner
                    .iter()
                    .map(|&(inner, own)| (inner, own * (halves / 2))),
            );
        }
        Node::Sum(terms) => match terms.as_ref() {
            [(term, bits)] => {
                let value = f64::from_bits(*bits);
                if whole {
                    multiply(coefficient, value, halves / 2);
                    open(*term, halves, coefficient, opened);
                } else if value > 0.0 {
                    multiply(coefficient, value.sqrt(), halves);
                    open(*term, halves, coefficient, opened);
                } else {
                    opened.push((factor, halves));
                }
            }
            terms if whole => {
                if !spend(terms.len()) {
                    return;
                }
                let (scale, common, rest) = content(terms);
                multiply(coefficient, scale, halves / 2);
                for (base, own) in common {
                    opened.push((base, own * (halves / 2)));
                }
                opened.push((rest, halves));
            }
            _ => opened.push((factor, halves)),
        },
        // The square of a root is what it is the root of.
        Node::Call(Function::Root, square) if halves >= 4 => {
            open(square, 2 * (halves / 4), coefficient, opened);
            if halves % 4 != 0 {
                opened.push((factor, halves % 4));
            }
        }
        _ => opened.push((factor, halves)),
    }
}

/// A coefficient times a number to a power.
fn multiply(coefficient: &mut f64, value: f64, exponent: i32) {
    let power = checked(power_of_number(value, exponent), value.is_finite());
    *coefficient = times(*coefficient, power);
}

/// Repeated multiplication, as the emitted code would do.
fn power_of_number(value: f64, exponent: i32) -> f64 {
    let magnitude = (0..exponent.unsigned_abs().min(4096)).fold(1.0, |power, _| power * value);
    if exponent < 0 {
        1.0 / magnitude
    } else {
        magnitude
    }
}

/// Whether the negative of a sum is the form that is kept: canonical for a sum and its negative.
pub(super) fn is_reversed(terms: &[(Sym, u64)]) -> bool {
    let negative = |&(_, bits): &(Sym, u64)| f64::from_bits(bits) < 0.0;
    let count = terms.iter().filter(|&term| negative(term)).count();
    match (2 * count).cmp(&terms.len()) {
        std::cmp::Ordering::Less => false,
        std::cmp::Ordering::Equal => terms.first().is_some_and(negative),
        std::cmp::Ordering::Greater => true,
    }
}

/// The content of a sum: a number and a monomial that every term carries, and what remains. The
/// remainder is the same for a sum and its negative.
fn content(terms: &[(Sym, u64)]) -> (f64, Vec<(Sym, i32)>, Sym) {
    let mut coefficients = terms.iter().map(|&(_, bits)| f64::from_bits(bits));
    let first = terms.first().map_or(1.0, |&(_, bits)| f64::from_bits(bits));
    let flip = is_reversed(terms);
    let magnitude = if coefficients.all(|c| c.abs() == first.abs()) {
        first.abs()
    } else {
        1.0
    };
    let scale = if flip { -magnitude } else { magnitude };

    let mut common: Vec<(Sym, i32)> = Vec::new();
    for (i, &(term, _)) in terms.iter().enumerate() {
        let own = whole_powers(term);
        if i == 0 {
            common = own;
        } else {
            common.retain_mut(|(base, halves)| {
                own.iter()
                    .find(|(its, _)| its == base)
                    .is_some_and(|&(_, its)| {
                        // Between x and 1/x nothing is shared.
                        if (its > 0) != (*halves > 0) {
                            return false;
                        }
                        *halves = if its > 0 {
                            its.min(*halves)
                        } else {
                            its.max(*halves)
                        };
                        true
                    })
            });
        }
        if common.is_empty() {
            break;
        }
    }
    if common.is_empty() && scale == 1.0 {
        let rest = intern(Node::Sum(Rc::from(terms)));
        return (1.0, common, rest);
    }
    let inverse: Vec<(Sym, i32)> = common
        .iter()
        .map(|&(base, halves)| (base, -halves))
        .collect();
    let rest = sum(terms.iter().map(|&(term, bits)| {
        let reduced = if inverse.is_empty() {
            term
        } else {
            let mut factors = factors_of(term);
            factors.extend(inverse.iter().copied());
            product(factors)
        };
        (reduced, f64::from_bits(bits) / scale)
    }));
    (scale, common, rest)
}

/// Factors of a term with even exponents.
fn whole_powers(term: Sym) -> Vec<(Sym, i32)> {
    let mut factors = factors_of(term);
    factors.retain(|&(_, halves)| halves % 2 == 0);
    factors
}

/// The term as a list of factors.
pub(crate) fn factors_of(term: Sym) -> Vec<(Sym, i32)> {
    if term == Sym::ONE {
        return Vec::new();
    }
    match term.node() {
        Node::Product(factors) => factors.to_vec(),
        _ => vec![(term, 2)],
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Compose, Variable, reset};
    use super::*;

    fn variables() -> (Sym, Sym, Sym) {
        reset();
        let q = |i| Sym::variable(Variable::Coordinate(i));
        (q(0), q(1), q(2))
    }

    #[test]
    fn sum_of_opposites_vanishes() {
        let (a, b, _) = variables();
        assert_eq!(sum([(a, 1.0), (a, -1.0)]), Sym::ZERO);
        assert_eq!(sum([(a, 0.1), (a, 0.2), (a, -0.3)]), Sym::ZERO);
        assert_eq!(sum([(a + b, 1.0), (b, -1.0)]), a);
        assert_eq!((a + b) - (b + a), Sym::ZERO);
    }

    #[test]
    fn product_merges_powers_and_signs() {
        let (a, b, c) = variables();
        assert_eq!(a * b / a, b);
        assert_eq!(a.power(1) * a.power(1), a);
        assert_eq!((a * b).power(1).square(), a * b);
        assert_ne!(
            a.square().power(1),
            a,
            "the root of a square is not the number"
        );
        assert_eq!((-a) * (-b), a * b);
        assert_eq!((a - b) * c, -((b - a) * c));
        assert_eq!((a - b) / (b - a), Sym::number(-1.0));
        assert_eq!(a * Sym::ZERO, Sym::ZERO);
    }

    #[test]
    fn product_with_a_sum_cancels_its_content() {
        let (a, b, c) = variables();
        let sum = a * b + a * c;
        assert_eq!(sum / a, b + c);
        assert_eq!(sum * (Sym::number(3.0) / a) / (b + c), Sym::number(3.0));
    }

    #[test]
    fn root_of_a_negative_multiple_stays_a_root() {
        let (a, _, _) = variables();
        let root = (-a).power(1);
        assert_eq!(root.square(), -a);
    }
}
