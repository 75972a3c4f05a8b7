//! Expansion into sums of monomials, for cancellation that the normal form does not see.

use super::normal::factors_of;
use super::{Compose, Function, Node, Sym, product, sum};

/// Products over sums multiplied out, as far as no more than `limit` terms arise; powers of sums with
/// negative or broken exponents stay as they are.
pub(crate) fn expand(sym: Sym, limit: usize) -> Option<Sym> {
    let terms = expanded_terms(sym, limit)?;
    Some(sum(terms))
}

fn expanded_terms(sym: Sym, limit: usize) -> Option<Vec<(Sym, f64)>> {
    match sym.node() {
        Node::Sum(terms) => {
            let mut all = Vec::new();
            for &(term, bits) in terms.iter() {
                let coefficient = f64::from_bits(bits);
                for (inner, own) in expanded_terms(term, limit)? {
                    all.push((inner, own * coefficient));
                }
                if all.len() > limit {
                    return None;
                }
            }
            Some(all)
        }
        Node::Product(factors) => {
            let mut all = vec![(Sym::ONE, 1.0)];
            for &(factor, halves) in factors.iter() {
                let (times, each) = match factor.node() {
                    Node::Sum(_) if halves > 0 && halves % 2 == 0 => {
                        (halves / 2, expanded_terms(factor, limit)?)
                    }
                    _ => (1, vec![(product([(factor, halves)]), 1.0)]),
                };
                for _ in 0..times {
                    if all.len() * each.len() > limit {
                        return None;
                    }
                    let mut next = Vec::with_capacity(all.len() * each.len());
                    for &(left, a) in &all {
                        for &(right, b) in &each {
                            next.push((left * right, a * b));
                        }
                    }
                    // Collect, so that powers of sums do not grow needlessly.
                    all = terms_of(sum(next));
                }
            }
            Some(all)
        }
        Node::Number(bits) => Some(vec![(Sym::ONE, f64::from_bits(bits))]),
        _ => Some(vec![(sym, 1.0)]),
    }
}

/// An expression as a list of terms with coefficients.
fn terms_of(sym: Sym) -> Vec<(Sym, f64)> {
    match sym.node() {
        Node::Sum(terms) => terms
            .iter()
            .map(|&(term, bits)| (term, f64::from_bits(bits)))
            .collect(),
        Node::Number(bits) => vec![(Sym::ONE, f64::from_bits(bits))],
        _ => vec![(sym, 1.0)],
    }
}

/// An expanded expression with every `replaced(x)^2` written as one minus the square of the other, sine
/// and cosine.
pub(crate) fn pythagoras(sym: Sym, replaced: Function, limit: usize) -> Option<Sym> {
    let other = match replaced {
        Function::Sin => Function::Cos,
        Function::Cos => Function::Sin,
        _ => return None,
    };
    let mut terms = terms_of(sym);
    loop {
        let mut changed = false;
        let mut next = Vec::with_capacity(terms.len());
        for (term, coefficient) in terms {
            let mut factors = factors_of(term);
            let found = factors.iter().position(|&(factor, halves)| {
                halves >= 4
                    && matches!(factor.node(), Node::Call(function, _) if function == replaced)
            });
            let Some(position) = found else {
                next.push((term, coefficient));
                continue;
            };
            let Node::Call(_, argument) = factors[position].0.node() else {
                return None;
            };
            changed = true;
            factors[position].1 -= 4;
            next.push((product(factors.iter().copied()), coefficient));
            factors.push((argument.call(other), 4));
            next.push((product(factors), -coefficient));
        }
        let collected = sum(next);
        if !changed {
            return Some(collected);
        }
        terms = terms_of(collected);
        if terms.len() > limit {
            return None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Variable, reset};
    use super::*;

    #[test]
    fn expand_multiplies_out_and_cancels() {
        reset();
        let a = Sym::variable(Variable::Coordinate(0));
        let b = Sym::variable(Variable::Coordinate(1));
        let difference = (a + b).square() - a.square() - b.square();
        assert_eq!(expand(difference, 100), Some((a * b).scaled(2.0)));
        assert_eq!(expand((a + b).power(40), 5), None);
    }

    #[test]
    fn pythagoras_removes_squares() {
        reset();
        let a = Sym::variable(Variable::Coordinate(0));
        let (s, c) = (a.call(Function::Sin), a.call(Function::Cos));
        let one = s.square() + c.square();
        assert_eq!(pythagoras(one, Function::Cos, 100), Some(Sym::ONE));
        assert_eq!(
            pythagoras(c.power(8), Function::Cos, 100),
            expand((Sym::ONE - s.square()).square(), 100)
        );
    }
}
