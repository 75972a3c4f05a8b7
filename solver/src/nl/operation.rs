//! What a node of an expression does: its value and its partial derivatives.

use num_dual::{Dual2_64, DualNum};

/// A smooth function of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Function {
    Tanh,
    Tan,
    Sqrt,
    Sinh,
    Sin,
    Log10,
    Log,
    Exp,
    Cosh,
    Cos,
    Atanh,
    Atan,
    Asinh,
    Asin,
    Acosh,
    Acos,
}

impl Function {
    fn of<D: DualNum<Primitive = f64>>(self, x: &D) -> D {
        match self {
            // A quotient of hyperbolic functions, as num-dual has it, overflows where this is one.
            Self::Tanh if x.re().abs() > 1.0 => {
                let sign = x.re().signum();
                let small = (x.clone() * (-2.0 * sign)).exp();
                (-small.clone() + 1.0) / (small + 1.0) * sign
            }
            Self::Tanh => x.tanh(),
            Self::Tan => x.tan(),
            Self::Sqrt => x.sqrt(),
            Self::Sinh => x.sinh(),
            Self::Sin => x.sin(),
            Self::Log10 => x.log10(),
            Self::Log => x.ln(),
            Self::Exp => x.exp(),
            Self::Cosh => x.cosh(),
            Self::Cos => x.cos(),
            Self::Atanh => x.atanh(),
            Self::Atan => x.atan(),
            Self::Asinh => x.asinh(),
            Self::Asin => x.asin(),
            Self::Acosh => x.acosh(),
            Self::Acos => x.acos(),
        }
    }
}

/// What a node does with its operands `a` and `b`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Operation {
    Function(Function),
    /// `a^c` with a constant exponent.
    Power(f64),
    /// `a^b`.
    GeneralPower,
    Product,
    Quotient,
    Atan2,
    Absolute,
    Minimum,
    Maximum,
    /// 1 where the relation holds, else 0; not differentiated.
    Relation(Relation),
    /// `a` where the condition is not 0, else `b`.
    Select,
}

/// What is asked of two numbers; a logical value is a number that is not 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Relation {
    Less,
    LessOrEqual,
    Equal,
    GreaterOrEqual,
    Greater,
    NotEqual,
    Or,
    And,
}

impl Relation {
    fn holds(self, a: f64, b: f64) -> bool {
        match self {
            Self::Less => a < b,
            Self::LessOrEqual => a <= b,
            Self::Equal => a == b,
            Self::GreaterOrEqual => a >= b,
            Self::Greater => a > b,
            Self::NotEqual => a != b,
            Self::Or => a != 0.0 || b != 0.0,
            Self::And => a != 0.0 && b != 0.0,
        }
    }
}

/// First and second partial derivatives with respect to both operands.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Partials {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) aa: f64,
    pub(super) ab: f64,
    pub(super) bb: f64,
}

impl Operation {
    /// Operands that count for derivatives.
    pub(super) fn arity(self) -> usize {
        match self {
            Self::Relation(_) => 0,
            Self::Function(_) | Self::Power(_) | Self::Absolute => 1,
            Self::GeneralPower
            | Self::Product
            | Self::Quotient
            | Self::Atan2
            | Self::Minimum
            | Self::Maximum
            | Self::Select => 2,
        }
    }

    /// Which second derivatives may differ from zero: those of `aa`, `ab`, `bb`.
    pub(super) fn curvature(self) -> [bool; 3] {
        match self {
            Self::Function(_) | Self::Power(_) => [true, false, false],
            Self::Product => [false, true, false],
            Self::Quotient => [false, true, true],
            Self::GeneralPower | Self::Atan2 => [true; 3],
            _ => [false; 3],
        }
    }

    pub(super) fn value(self, a: f64, b: f64, condition: f64) -> f64 {
        match self {
            Self::Function(function) => function.of(&a),
            Self::Power(exponent) => power(a, exponent),
            Self::GeneralPower => a.powf(b),
            Self::Product => a * b,
            Self::Quotient => a / b,
            Self::Atan2 => a.atan2(b),
            Self::Absolute => a.abs(),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::Relation(relation) => f64::from(relation.holds(a, b)),
            Self::Select if condition != 0.0 => a,
            Self::Select => b,
        }
    }

    /// The derivatives at `(a, b)`; `value` is the value there.
    pub(super) fn partials(self, a: f64, b: f64, condition: f64, value: f64) -> Partials {
        let chosen = |first: bool| Partials {
            a: f64::from(first),
            b: f64::from(!first),
            ..Partials::default()
        };
        match self {
            Self::Function(function) => {
                let dual = function.of(&Dual2_64::from_re(a).derivative());
                Partials {
                    a: dual.v1,
                    aa: dual.v2,
                    ..Partials::default()
                }
            }
            Self::Power(exponent) => Partials {
                a: exponent * power(a, exponent - 1.0),
                aa: exponent * (exponent - 1.0) * power(a, exponent - 2.0),
                ..Partials::default()
            },
            Self::GeneralPower => {
                let (logarithm, below) = (a.ln(), a.powf(b - 1.0));
                Partials {
                    a: b * below,
                    b: value * logarithm,
                    aa: b * (b - 1.0) * a.powf(b - 2.0),
                    ab: below * (1.0 + b * logarithm),
                    bb: value * logarithm * logarithm,
                }
            }
            Self::Product => Partials {
                a: b,
                b: a,
                ab: 1.0,
                ..Partials::default()
            },
            Self::Quotient => Partials {
                a: 1.0 / b,
                b: -value / b,
                ab: -1.0 / (b * b),
                bb: 2.0 * value / (b * b),
                aa: 0.0,
            },
            Self::Atan2 => {
                let square = a * a + b * b;
                let (p, q) = (a / square, b / square);
                Partials {
                    a: q,
                    b: -p,
                    aa: -2.0 * p * q,
                    ab: p * p - q * q,
                    bb: 2.0 * p * q,
                }
            }
            Self::Absolute => Partials {
                a: if a < 0.0 { -1.0 } else { 1.0 },
                ..Partials::default()
            },
            Self::Minimum => chosen(a <= b),
            Self::Maximum => chosen(a >= b),
            Self::Select => chosen(condition != 0.0),
            Self::Relation(_) => Partials::default(),
        }
    }
}

/// `a^c`; whole exponents keep their sign rules.
fn power(a: f64, exponent: f64) -> f64 {
    if exponent == 2.0 {
        a * a
    } else if exponent == 1.0 {
        a
    } else if exponent == 0.0 {
        1.0
    } else {
        a.powf(exponent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partials_of_every_operation_agree_with_central_differences() {
        let functions = [
            (Function::Tanh, 0.4),
            (Function::Tanh, -1.4),
            (Function::Tanh, 800.0),
            (Function::Tan, 0.4),
            (Function::Sqrt, 1.7),
            (Function::Sinh, 0.4),
            (Function::Sin, 0.4),
            (Function::Log10, 1.7),
            (Function::Log, 1.7),
            (Function::Exp, 0.4),
            (Function::Cosh, 0.4),
            (Function::Cos, 0.4),
            (Function::Atanh, 0.4),
            (Function::Atan, 0.4),
            (Function::Asinh, 0.4),
            (Function::Asin, 0.4),
            (Function::Acosh, 1.7),
            (Function::Acos, 0.4),
        ];
        let functions = functions.map(|(function, at)| (Operation::Function(function), at, 0.3));
        let others = [
            (Operation::Power(3.0), -1.3, 0.0),
            (Operation::Power(2.5), 1.3, 0.0),
            (Operation::GeneralPower, 1.3, -0.7),
            (Operation::Product, 1.3, -0.7),
            (Operation::Quotient, 1.3, -0.7),
            (Operation::Atan2, 1.3, -0.7),
            (Operation::Absolute, -1.3, 0.2),
            (Operation::Minimum, 1.3, -0.7),
            (Operation::Maximum, 1.3, -0.7),
            (Operation::Select, 1.3, -0.7),
        ];
        // differences of third order over a step of 1e-5: 1e-10 of truncation, 1e-11 of rounding
        let step = 1e-5;
        for (operation, a, b) in functions.into_iter().chain(others) {
            let at = |a: f64, b: f64| {
                let value = operation.value(a, b, 1.0);
                (value, operation.partials(a, b, 1.0, value))
            };
            let (_, exact) = at(a, b);
            let (above, below) = (at(a + step, b), at(a - step, b));
            let (right, left) = (at(a, b + step), at(a, b - step));
            let slope = |high: f64, low: f64| (high - low) / (2.0 * step);
            for (name, exact, difference) in [
                ("a", exact.a, slope(above.0, below.0)),
                ("b", exact.b, slope(right.0, left.0)),
                ("aa", exact.aa, slope(above.1.a, below.1.a)),
                ("ab", exact.ab, slope(right.1.a, left.1.a)),
                ("bb", exact.bb, slope(right.1.b, left.1.b)),
            ] {
                assert!(
                    (exact - difference).abs() < 1e-8,
                    "{operation:?} {name}: {exact} but {difference}"
                );
            }
        }
    }
}
