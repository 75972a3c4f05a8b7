//! Runs of equal steps on registers.

use super::steps::Kind;
use hangtime_dsl::description::{Function, Function2};
use std::cell::Cell;

/// The values of a program; an index of 16 bits needs no check.
pub(super) type Registers = [f64; 1 << 16];

thread_local! {
    static REGISTERS: Cell<Option<Box<Registers>>> = const { Cell::new(None) };
}

/// Lends the registers of this thread, so that no call allocates. Inlined: what `work` captures would go through memory, where the
/// processor waits for what was just written in parts and is read as a whole, longer than a short kernel takes.
#[inline(always)]
pub(super) fn lend(work: impl FnOnce(&mut Registers)) {
    if let Some(mut registers) = REGISTERS.take().or_else(registers) {
        work(&mut registers);
        REGISTERS.set(Some(registers));
    }
}

fn registers() -> Option<Box<Registers>> {
    // Made on the heap: half a megabyte may be more than the stack has left.
    vec![0.0; 1 << 16].into_boxed_slice().try_into().ok()
}

/// Equal steps, one after the other: the registers of their results and operands.
#[derive(Debug)]
#[repr(u8)]
pub(super) enum Run {
    Add(Box<[[u16; 3]]>),
    Subtract(Box<[[u16; 3]]>),
    Multiply(Box<[[u16; 3]]>),
    Divide(Box<[[u16; 3]]>),
    Negate(Box<[[u16; 2]]>),
    Root(Box<[[u16; 2]]>),
    ProductPlus(Box<[[u16; 4]]>),
    ProductMinus(Box<[[u16; 4]]>),
    LessProduct(Box<[[u16; 4]]>),
    SumOfProducts(Box<[[u16; 5]]>),
    DifferenceOfProducts(Box<[[u16; 5]]>),
    ProductOfThree(Box<[[u16; 4]]>),
    Call(Function, Box<[[u16; 2]]>),
    Call2(Function2, Box<[[u16; 3]]>),
    SineAndCosine(Box<[[u16; 3]]>),
}

impl Run {
    /// Steps of one kind from all their registers.
    pub(super) fn new(kind: Kind, registers: &[u16]) -> Self {
        match kind {
            Kind::Add => Self::Add(steps(registers)),
            Kind::Subtract => Self::Subtract(steps(registers)),
            Kind::Multiply => Self::Multiply(steps(registers)),
            Kind::Divide => Self::Divide(steps(registers)),
            Kind::Negate => Self::Negate(steps(registers)),
            Kind::Root => Self::Root(steps(registers)),
            Kind::ProductPlus => Self::ProductPlus(steps(registers)),
            Kind::ProductMinus => Self::ProductMinus(steps(registers)),
            Kind::LessProduct => Self::LessProduct(steps(registers)),
            Kind::SumOfProducts => Self::SumOfProducts(steps(registers)),
            Kind::DifferenceOfProducts => Self::DifferenceOfProducts(steps(registers)),
            Kind::ProductOfThree => Self::ProductOfThree(steps(registers)),
            Kind::Call(function) => Self::Call(function, steps(registers)),
            Kind::Call2(function) => Self::Call2(function, steps(registers)),
            Kind::SineAndCosine => Self::SineAndCosine(steps(registers)),
        }
    }

    /// Evaluates them.
    #[inline(always)]
    pub(super) fn go(&self, r: &mut Registers) {
        match self {
            Self::Add(steps) => two(steps, r, |a, b| a + b),
            Self::Subtract(steps) => two(steps, r, |a, b| a - b),
            Self::Multiply(steps) => two(steps, r, |a, b| a * b),
            Self::Divide(steps) => two(steps, r, |a, b| a / b),
            Self::Negate(steps) => one(steps, r, |a| -a),
            Self::Root(steps) => one(steps, r, f64::sqrt),
            Self::ProductPlus(steps) => three(steps, r, |a, b, c| a * b + c),
            Self::ProductMinus(steps) => three(steps, r, |a, b, c| a * b - c),
            Self::LessProduct(steps) => three(steps, r, |a, b, c| c - a * b),
            Self::SumOfProducts(steps) => four(steps, r, |a, b, c, d| a * b + c * d),
            Self::DifferenceOfProducts(steps) => four(steps, r, |a, b, c, d| a * b - c * d),
            Self::ProductOfThree(steps) => three(steps, r, |a, b, c| a * b * c),
            Self::Call(function, steps) => one(steps, r, |a| function.value(a)),
            Self::Call2(function, steps) => two(steps, r, |a, b| function.value(a, b)),
            Self::SineAndCosine(steps) => {
                for &[sine, cosine, a] in steps {
                    let values = r[usize::from(a)].sin_cos();
                    (r[usize::from(sine)], r[usize::from(cosine)]) = values;
                }
            }
        }
    }
}

fn steps<const N: usize>(registers: &[u16]) -> Box<[[u16; N]]> {
    registers.as_chunks().0.into()
}

/// Steps of one number.
#[inline(always)]
fn one(steps: &[[u16; 2]], r: &mut Registers, step: impl Fn(f64) -> f64) {
    for &[result, a] in steps {
        r[usize::from(result)] = step(r[usize::from(a)]);
    }
}

/// Steps of two numbers.
#[inline(always)]
fn two(steps: &[[u16; 3]], r: &mut Registers, step: impl Fn(f64, f64) -> f64) {
    for &[result, a, b] in steps {
        let [a, b] = [a, b].map(|register| r[usize::from(register)]);
        r[usize::from(result)] = step(a, b);
    }
}

/// Steps of three numbers.
#[inline(always)]
fn three(steps: &[[u16; 4]], r: &mut Registers, step: impl Fn(f64, f64, f64) -> f64) {
    for &[result, a, b, c] in steps {
        let [a, b, c] = [a, b, c].map(|register| r[usize::from(register)]);
        r[usize::from(result)] = step(a, b, c);
    }
}

/// Steps of four numbers.
#[inline(always)]
fn four(steps: &[[u16; 5]], r: &mut Registers, step: impl Fn(f64, f64, f64, f64) -> f64) {
    for &[result, a, b, c, d] in steps {
        let [a, b, c, d] = [a, b, c, d].map(|register| r[usize::from(register)]);
        r[usize::from(result)] = step(a, b, c, d);
    }
}
