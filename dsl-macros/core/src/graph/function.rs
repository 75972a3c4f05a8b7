//! Elementary functions: names, values, derivatives.
//!
//! The derivative rules are the graph's own, because some textbook forms fail where mechanisms go:
//! `sinh/cosh` overflows in `tanh`, `y/x` divides by zero in `atan2`.

use super::limits::checked;
use super::{Node, Sym, Variable, intern, passes, product};

/// Functions of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Ln,
    Cbrt,
}

/// Functions of two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Function2 {
    /// `atan2(y, x)`.
    Atan2,
    /// `base^exponent` with an exponent that is no multiple of 1/2.
    Power,
}

impl Function {
    /// The function with this name in the language, which is also its name in `f64`.
    pub(crate) fn named(name: &str) -> Option<Self> {
        ALL.into_iter().find(|function| function.name() == name)
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Tan => "tan",
            Self::Asin => "asin",
            Self::Acos => "acos",
            Self::Atan => "atan",
            Self::Sinh => "sinh",
            Self::Cosh => "cosh",
            Self::Tanh => "tanh",
            Self::Exp => "exp",
            Self::Ln => "ln",
            Self::Cbrt => "cbrt",
        }
    }

    pub(crate) fn value(self, x: f64) -> f64 {
        match self {
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Tanh => x.tanh(),
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Cbrt => x.cbrt(),
        }
    }

    /// `f'(x)`.
    pub(crate) fn derivative(self, x: Sym) -> Sym {
        let own = x.call(self);
        match self {
            Self::Sin => x.call(Self::Cos),
            Self::Cos => -x.call(Self::Sin),
            Self::Tan => Sym::ONE + own.square(),
            Self::Asin => (Sym::ONE - x.square()).power(-1),
            Self::Acos => -(Sym::ONE - x.square()).power(-1),
            Self::Atan => (Sym::ONE + x.square()).power(-2),
            Self::Sinh => x.call(Self::Cosh),
            Self::Cosh => x.call(Self::Sinh),
            Self::Tanh => Sym::ONE - own.square(),
            Self::Exp => own,
            Self::Ln => x.power(-2),
            Self::Cbrt => own.power(-4).scaled(1.0 / 3.0),
        }
    }

    /// `f''(x)`, by dual numbers over the rule of the first derivative.
    pub(crate) fn second_derivative(self, x: Sym) -> Sym {
        let [hole, _] = holes();
        let slope = self.derivative(Sym::variable(hole));
        let second = passes::partial(&[slope], hole);
        put(second[0], [(hole, x), (hole, x)])
    }

    /// `f(-x)` in terms of `f(x)`: -1 for odd functions, 1 for even ones.
    fn parity(self) -> Option<f64> {
        match self {
            Self::Sin | Self::Tan | Self::Asin | Self::Atan => Some(-1.0),
            Self::Sinh | Self::Tanh | Self::Cbrt => Some(-1.0),
            Self::Cos | Self::Cosh => Some(1.0),
            Self::Acos | Self::Exp | Self::Ln => None,
        }
    }
}

const ALL: [Function; 12] = [
    Function::Sin,
    Function::Cos,
    Function::Tan,
    Function::Asin,
    Function::Acos,
    Function::Atan,
    Function::Sinh,
    Function::Cosh,
    Function::Tanh,
    Function::Exp,
    Function::Ln,
    Function::Cbrt,
];

impl Function2 {
    /// Its name in `f64`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Atan2 => "atan2",
            Self::Power => "powf",
        }
    }

    pub(crate) fn value(self, first: f64, second: f64) -> f64 {
        match self {
            Self::Atan2 => first.atan2(second),
            Self::Power => first.powf(second),
        }
    }

    /// Nonzero second derivatives with respect to pairs of arguments.
    pub(crate) fn second_derivatives(self, first: Sym, second: Sym) -> Vec<(Sym, Sym, Sym)> {
        let [x, y] = holes();
        let (by_x, by_y) = self.derivatives(Sym::variable(x), Sym::variable(y));
        let slopes = [by_x, by_y];
        let (by_x, by_y) = (passes::partial(&slopes, x), passes::partial(&slopes, y));
        let at = |formula| put(formula, [(x, first), (y, second)]);
        let mut all = vec![(first, first, at(by_x[0])), (second, second, at(by_y[1]))];
        let mixed = at(by_y[0]);
        // With equal arguments both mixed derivatives fall on the same pair.
        all.push(if first == second {
            (first, second, mixed.scaled(2.0))
        } else {
            (first, second, mixed)
        });
        all.retain(|(_, _, value)| !value.is_structural_zero());
        all
    }

    /// Both partial derivatives.
    pub(crate) fn derivatives(self, first: Sym, second: Sym) -> (Sym, Sym) {
        match self {
            Self::Atan2 => {
                let inverse = (first.square() + second.square()).power(-2);
                (second * inverse, -first * inverse)
            }
            Self::Power => {
                let lowered = call2(self, first, second - Sym::ONE);
                let own = call2(self, first, second);
                (second * lowered, own * first.call(Function::Ln))
            }
        }
    }
}

/// Stand-ins for arguments, which no expression of a scene contains.
fn holes() -> [Variable; 2] {
    [
        Variable::Argument(u16::MAX),
        Variable::Argument(u16::MAX - 1),
    ]
}

fn put(formula: Sym, arguments: [(Variable, Sym); 2]) -> Sym {
    passes::substitute(&[formula], |variable| {
        let found = arguments.iter().find(|(hole, _)| *hole == variable);
        found.map(|&(_, argument)| argument)
    })[0]
}

pub(super) fn call(function: Function, x: Sym) -> Sym {
    if let Some(x) = x.as_number() {
        let vanishes = function == Function::Exp;
        return Sym::number(checked(function.value(x), vanishes, x.is_finite()));
    }
    if let Some(sign) = function.parity() {
        let opposite = -x;
        if sign_is_reversed(x) {
            return call(function, opposite).scaled(sign);
        }
    }
    intern(Node::Call(function, x))
}

/// Whether the negative of `x` is the form that is kept: canonical for `x` and `-x`.
fn sign_is_reversed(x: Sym) -> bool {
    let Node::Sum(terms) = x.node() else {
        return false;
    };
    let negative = terms
        .iter()
        .filter(|&&(_, bits)| f64::from_bits(bits) < 0.0)
        .count();
    match (2 * negative).cmp(&terms.len()) {
        std::cmp::Ordering::Less => false,
        std::cmp::Ordering::Equal => f64::from_bits(terms[0].1) < 0.0,
        std::cmp::Ordering::Greater => true,
    }
}

pub(super) fn call2(function: Function2, first: Sym, second: Sym) -> Sym {
    match (function, first.as_number(), second.as_number()) {
        (_, Some(first), Some(second)) => {
            let vanishes = function == Function2::Power && first != 0.0;
            let finite = first.is_finite() && second.is_finite();
            Sym::number(checked(function.value(first, second), vanishes, finite))
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
