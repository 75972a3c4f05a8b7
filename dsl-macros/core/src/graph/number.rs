//! The handle as a number: [`num_dual::DualNum`] and everything that it asks for.
//!
//! What a symbol cannot answer is answered honestly: a comparison of two unknowns is `None`, the
//! real part of an unknown is NaN. Functions that branch on values (`abs`, Bessel functions) have no
//! meaning here and give NaN; the parser refuses them long before.

use super::{Compose, Function, Function2, Sym, product, sum};
use num_dual::{DualNum, DualStruct, Mappable};
use num_traits::{FromPrimitive, Inv, Num, One, Signed, Zero};
use std::fmt;
use std::ops::{
    Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign,
};

fn nan() -> Sym {
    Sym::number(f64::NAN)
}

macro_rules! binary {
    ($($operator:ident $method:ident $assign:ident $method_assign:ident: |$a:ident, $b:ident| $value:expr;)*) => {$(
        impl $operator for Sym {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $value
            }
        }
        impl $operator<&Self> for Sym {
            type Output = Self;
            fn $method(self, other: &Self) -> Self {
                $operator::$method(self, *other)
            }
        }
        impl $operator<f64> for Sym {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                $operator::$method(self, Self::number(other))
            }
        }
        impl $assign for Sym {
            fn $method_assign(&mut self, other: Self) {
                *self = $operator::$method(*self, other);
            }
        }
        impl $assign<f64> for Sym {
            fn $method_assign(&mut self, other: f64) {
                *self = $operator::$method(*self, Self::number(other));
            }
        }
    )*};
}

binary! {
    Add add AddAssign add_assign: |a, b| sum([(a, 1.0), (b, 1.0)]);
    Sub sub SubAssign sub_assign: |a, b| sum([(a, 1.0), (b, -1.0)]);
    Mul mul MulAssign mul_assign: |a, b| product([(a, 2), (b, 2)]);
    Div div DivAssign div_assign: |a, b| product([(a, 2), (b, -2)]);
    Rem rem RemAssign rem_assign: |a, b| match (a.as_number(), b.as_number()) {
        (Some(a), Some(b)) => Self::number(a % b),
        _ => nan(),
    };
}

impl Neg for Sym {
    type Output = Self;
    fn neg(self) -> Self {
        sum([(self, -1.0)])
    }
}

impl Neg for &Sym {
    type Output = Sym;
    fn neg(self) -> Sym {
        -*self
    }
}

impl Inv for Sym {
    type Output = Self;
    fn inv(self) -> Self {
        self.power(-2)
    }
}

impl Zero for Sym {
    fn zero() -> Self {
        Self::ZERO
    }
    fn is_zero(&self) -> bool {
        self.is_structural_zero()
    }
}

impl One for Sym {
    fn one() -> Self {
        Self::ONE
    }
}

impl Num for Sym {
    type FromStrRadixErr = num_traits::ParseFloatError;
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Self::number)
    }
}

impl Signed for Sym {
    fn abs(&self) -> Self {
        self.as_number().map_or_else(nan, |x| Self::number(x.abs()))
    }
    fn abs_sub(&self, _other: &Self) -> Self {
        nan()
    }
    fn signum(&self) -> Self {
        self.as_number()
            .map_or_else(nan, |x| Self::number(x.signum()))
    }
    fn is_positive(&self) -> bool {
        self.as_number().is_some_and(|x| x > 0.0)
    }
    fn is_negative(&self) -> bool {
        self.as_number().is_some_and(|x| x < 0.0)
    }
}

impl PartialOrd<f64> for Sym {
    fn partial_cmp(&self, other: &f64) -> Option<std::cmp::Ordering> {
        self.as_number()?.partial_cmp(other)
    }
}

impl PartialEq<f64> for Sym {
    fn eq(&self, other: &f64) -> bool {
        self.as_number() == Some(*other)
    }
}

impl FromPrimitive for Sym {
    fn from_i64(value: i64) -> Option<Self> {
        f64::from_i64(value).map(Self::number)
    }
    fn from_u64(value: u64) -> Option<Self> {
        f64::from_u64(value).map(Self::number)
    }
    fn from_f64(value: f64) -> Option<Self> {
        Some(Self::number(value))
    }
}

impl From<f64> for Sym {
    fn from(value: f64) -> Self {
        Self::number(value)
    }
}

impl std::iter::Sum for Sym {
    fn sum<I: Iterator<Item = Self>>(items: I) -> Self {
        sum(items.map(|item| (item, 1.0)))
    }
}

impl<'a> std::iter::Sum<&'a Self> for Sym {
    fn sum<I: Iterator<Item = &'a Self>>(items: I) -> Self {
        sum(items.map(|item| (*item, 1.0)))
    }
}

impl std::iter::Product for Sym {
    fn product<I: Iterator<Item = Self>>(items: I) -> Self {
        product(items.map(|item| (item, 2)))
    }
}

impl<'a> std::iter::Product<&'a Self> for Sym {
    fn product<I: Iterator<Item = &'a Self>>(items: I) -> Self {
        product(items.map(|item| (*item, 2)))
    }
}

impl DualStruct for Sym {
    type Real = f64;
    type Inner = f64;
    fn re(&self) -> f64 {
        self.as_number().unwrap_or(f64::NAN)
    }
    fn from_inner(inner: &f64) -> Self {
        Self::number(*inner)
    }
}

impl Mappable<Self> for Sym {
    type Output<O> = O;
    fn map_dual<M: Fn(Self) -> O, O>(self, f: M) -> O {
        f(self)
    }
}

impl DualNum for Sym {
    type Primitive = f64;
    const NDERIV: usize = 0;
    type InnerDual = f64;

    fn from_re(re: f64) -> Self {
        Self::number(re)
    }
    fn scale(self, factor: &f64) -> Self {
        self.scaled(*factor)
    }
    fn recip(&self) -> Self {
        self.power(-2)
    }
    fn powi(&self, n: i32) -> Self {
        self.power(2 * n)
    }
    fn powf(&self, n: f64) -> Self {
        self.call2(Function2::Power, Self::number(n))
    }
    fn powd(&self, exponent: Self) -> Self {
        self.call2(Function2::Power, exponent)
    }
    fn sqrt(&self) -> Self {
        self.power(1)
    }
    fn cbrt(&self) -> Self {
        self.call(Function::Cbrt)
    }
    fn exp(&self) -> Self {
        self.call(Function::Exp)
    }
    fn exp2(&self) -> Self {
        self.scaled(std::f64::consts::LN_2).call(Function::Exp)
    }
    fn exp_m1(&self) -> Self {
        self.call(Function::Exp) - Self::ONE
    }
    fn ln(&self) -> Self {
        self.call(Function::Ln)
    }
    fn log(&self, base: f64) -> Self {
        self.ln().scaled(base.ln().recip())
    }
    fn log2(&self) -> Self {
        self.ln().scaled(std::f64::consts::LOG2_E)
    }
    fn log10(&self) -> Self {
        self.ln().scaled(std::f64::consts::LOG10_E)
    }
    fn ln_1p(&self) -> Self {
        (Self::ONE + *self).ln()
    }
    fn sin(&self) -> Self {
        self.call(Function::Sin)
    }
    fn cos(&self) -> Self {
        self.call(Function::Cos)
    }
    fn tan(&self) -> Self {
        self.call(Function::Tan)
    }
    fn sin_cos(&self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    fn asin(&self) -> Self {
        self.call(Function::Asin)
    }
    fn acos(&self) -> Self {
        self.call(Function::Acos)
    }
    fn atan(&self) -> Self {
        self.call(Function::Atan)
    }
    fn atan2(&self, other: Self) -> Self {
        self.call2(Function2::Atan2, other)
    }
    fn sinh(&self) -> Self {
        self.call(Function::Sinh)
    }
    fn cosh(&self) -> Self {
        self.call(Function::Cosh)
    }
    fn tanh(&self) -> Self {
        self.call(Function::Tanh)
    }
    fn asinh(&self) -> Self {
        (*self + (self.square() + Self::ONE).power(1)).ln()
    }
    fn acosh(&self) -> Self {
        (*self + (self.square() - Self::ONE).power(1)).ln()
    }
    fn atanh(&self) -> Self {
        ((Self::ONE + *self) / (Self::ONE - *self)).ln().scaled(0.5)
    }
    fn sph_j0(&self) -> Self {
        nan()
    }
    fn sph_j1(&self) -> Self {
        nan()
    }
    fn sph_j2(&self) -> Self {
        nan()
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
