//! Powers, multiples and functions of expressions, and first derivatives of functions.
//!
//! The derivative rules are the graph's own, because some textbook forms fail where mechanisms go:
//! `sinh/cosh` overflows in `tanh`, `y/x` divides by zero in `atan2`.

use super::elementary::{Function, Function2};
use super::limits::checked;
use super::node::{Node, Sym, intern};
use super::normal::{is_reversed, product, sum};

/// Powers, multiples and functions of an expression.
pub(crate) trait Compose {
    /// `self` to a power counted in halves.
    fn power(self, halves: i32) -> Self;
    fn square(self) -> Self;
    fn scaled(self, factor: f64) -> Self;
    /// Its value as one quantity; see [`Node::Kept`]. Coefficients and signs stay outside.
    fn kept(self) -> Self;
    fn call(self, function: Function) -> Self;
    fn call2(self, function: Function2, other: Self) -> Self;
}

impl Compose for Sym {
    fn power(self, halves: i32) -> Self {
        product([(self, halves)])
    }

    fn square(self) -> Self {
        self.power(4)
    }

    fn scaled(self, factor: f64) -> Self {
        sum([(self, factor)])
    }

    fn kept(self) -> Self {
        match self.node() {
            Node::Sum(terms) => match terms.as_ref() {
                [(term, bits)] => sum([(term.kept(), f64::from_bits(*bits))]),
                _ => intern(Node::Kept(self)),
            },
            Node::Product(_) => intern(Node::Kept(self)),
            _ => self,
        }
    }

    fn call(self, function: Function) -> Self {
        call(function, self)
    }

    fn call2(self, function: Function2, other: Self) -> Self {
        call2(function, self, other)
    }
}

/// `f'(x)`.
pub(super) fn derivative(function: Function, x: Sym) -> Sym {
    let own = x.call(function);
    match function {
        Function::Sin => x.call(Function::Cos),
        Function::Cos => -x.call(Function::Sin),
        Function::Tan => Sym::ONE + own.square(),
        Function::Asin => (Sym::ONE - x.square()).power(-1),
        Function::Acos => -(Sym::ONE - x.square()).power(-1),
        Function::Atan => (Sym::ONE + x.square()).power(-2),
        Function::Sinh => x.call(Function::Cosh),
        Function::Cosh => x.call(Function::Sinh),
        Function::Tanh => Sym::ONE - own.square(),
        Function::Exp => own,
        Function::Ln => x.power(-2),
        Function::Cbrt => own.power(-4).scaled(1.0 / 3.0),
        Function::Root => x.call(Function::InverseRoot).scaled(0.5),
        Function::InverseRoot => own.power(6).scaled(-0.5),
        Function::Abs => x.call(Function::Sign),
        Function::Sign => Sym::ZERO,
        Function::Profile(profile) => x.call(Function::Profile(profile.derivative())),
    }
}

/// Both partial derivatives.
pub(super) fn derivatives(function: Function2, first: Sym, second: Sym) -> (Sym, Sym) {
    match function {
        Function2::Atan2 => {
            let inverse = (first.square() + second.square()).power(-2);
            (second * inverse, -first * inverse)
        }
        Function2::Power => {
            let lowered = call2(function, first, second - Sym::ONE);
            let own = call2(function, first, second);
            (second * lowered, own * first.call(Function::Ln))
        }
    }
}

fn call(function: Function, x: Sym) -> Sym {
    if let Some(x) = x.as_number() {
        return Sym::number(checked(function.value(x), x.is_finite()));
    }
    if let Some(sign) = function.parity() {
        let opposite = -x;
        if matches!(x.node(), Node::Sum(terms) if is_reversed(&terms)) {
            return call(function, opposite).scaled(sign);
        }
    }
    intern(Node::Call(function, x))
}

fn call2(function: Function2, first: Sym, second: Sym) -> Sym {
    match (function, first.as_number(), second.as_number()) {
        (_, Some(first), Some(second)) => {
            let finite = first.is_finite() && second.is_finite();
            Sym::number(checked(function.value(first, second), finite))
        }
        (Function2::Power, _, Some(exponent)) if is_half(exponent) => {
            product([(first, (2.0 * exponent) as i32)])
        }
        _ => intern(Node::Call2(function, first, second)),
    }
}

/// Whether an exponent is a multiple of 1/2 small enough for repeated multiplication.
fn is_half(exponent: f64) -> bool {
    (2.0 * exponent).fract() == 0.0 && exponent.abs() <= 64.0
}
