//! The handle as a number: sums, differences, products and quotients.

use super::{Compose, Sym, product, sum};
use std::fmt;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

macro_rules! binary {
    ($($operator:ident $method:ident $assign:ident $method_assign:ident: |$a:ident, $b:ident| $value:expr;)*) => {$(
        impl $operator for Sym {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $value
            }
        }
        impl $assign for Sym {
            fn $method_assign(&mut self, other: Self) {
                *self = $operator::$method(*self, other);
            }
        }
    )*};
}

binary! {
    Add add AddAssign add_assign: |a, b| sum([(a, 1.0), (b, 1.0)]);
    Sub sub SubAssign sub_assign: |a, b| sum([(a, 1.0), (b, -1.0)]);
    Mul mul MulAssign mul_assign: |a, b| product([(a, 2), (b, 2)]);
    Div div DivAssign div_assign: |a, b| product([(a, 2), (b, -2)]);
}

impl Neg for Sym {
    type Output = Self;
    fn neg(self) -> Self {
        self.scaled(-1.0)
    }
}

impl std::iter::Sum for Sym {
    fn sum<I: Iterator<Item = Self>>(items: I) -> Self {
        sum(items.map(|item| (item, 1.0)))
    }
}

impl fmt::Display for Sym {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.as_number() {
            Some(value) => write!(f, "{value}"),
            None => write!(f, "e{}", self.index()),
        }
    }
}

impl fmt::Debug for Sym {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.node())
    }
}
