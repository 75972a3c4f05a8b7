//! Elementary functions: names and values.

use super::profile::Profile;

/// Functions of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Function {
    /// Sine.
    Sin,
    /// Cosine.
    Cos,
    /// Tangent.
    Tan,
    /// Arc sine.
    Asin,
    /// Arc cosine.
    Acos,
    /// Arc tangent.
    Atan,
    /// Hyperbolic sine.
    Sinh,
    /// Hyperbolic cosine.
    Cosh,
    /// Hyperbolic tangent.
    Tanh,
    /// Exponential function.
    Exp,
    /// Natural logarithm.
    Ln,
    /// Cube root.
    Cbrt,
    /// Square root of the square of a velocity, in what acts: its product with the velocity has a derivative at rest.
    Root,
    /// `1/sqrt(x)`, and 0 at rest, where what it is multiplied with in a derivative of such a product vanishes faster.
    InverseRoot,
    /// Absolute value: of what is recorded and drawn, and in what acts where it leaves no kink.
    Abs,
    /// Sign, the derivative of the absolute value.
    Sign,
    /// A function given by points.
    Profile(Profile),
}

/// Functions of two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Function2 {
    /// `atan2(y, x)`.
    Atan2,
    /// `base^exponent` with an exponent that is no multiple of 1/2.
    Power,
}

impl Function {
    /// Those that stand for themselves wherever they are written.
    pub const NAMED: [Self; 12] = [
        Self::Sin,
        Self::Cos,
        Self::Tan,
        Self::Asin,
        Self::Acos,
        Self::Atan,
        Self::Sinh,
        Self::Cosh,
        Self::Tanh,
        Self::Exp,
        Self::Ln,
        Self::Cbrt,
    ];

    /// The function with this name in the language, which is also its name in `f64`.
    pub(crate) fn named(name: &str) -> Option<Self> {
        let mut named = Self::NAMED.into_iter();
        named.find(|function| function.name() == name)
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
            Self::Root => "root",
            Self::InverseRoot => "inverse_root",
            Self::Abs => "abs",
            Self::Sign => "signum",
            Self::Profile(profile) => profile.name(),
        }
    }

    /// Its value, as `f64` computes it.
    #[must_use]
    pub fn value(self, x: f64) -> f64 {
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
            Self::Root => root(x),
            Self::InverseRoot => inverse_root(x),
            Self::Abs => x.abs(),
            Self::Sign => x.signum(),
            Self::Profile(profile) => profile.value(x),
        }
    }

    /// `f(-x)` in terms of `f(x)`: -1 for odd functions, 1 for even ones.
    pub(super) fn parity(self) -> Option<f64> {
        match self {
            Self::Sin | Self::Tan | Self::Asin | Self::Atan => Some(-1.0),
            Self::Sinh | Self::Tanh | Self::Cbrt => Some(-1.0),
            // At zero it is 1 from either side.
            Self::Sign => None,
            Self::Cos | Self::Cosh | Self::Abs => Some(1.0),
            Self::Acos | Self::Exp | Self::Ln | Self::Root => None,
            Self::InverseRoot | Self::Profile(_) => None,
        }
    }
}

/// Squares below are of rest: the third power of their inverse root, which second derivatives contain, has no value in `f64`.
const REST: f64 = 1e-200;

/// `sqrt(x)`, and 0 below 0, where what it is multiplied with is 0.
#[must_use]
pub fn root(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { x.sqrt() }
}

/// `1/sqrt(x)`, and 0 at rest.
#[must_use]
pub fn inverse_root(x: f64) -> f64 {
    if x < REST { 0.0 } else { 1.0 / x.sqrt() }
}

impl Function2 {
    /// Its name in `f64`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Atan2 => "atan2",
            Self::Power => "powf",
        }
    }

    /// Its value, as `f64` computes it.
    #[must_use]
    pub fn value(self, first: f64, second: f64) -> f64 {
        match self {
            Self::Atan2 => first.atan2(second),
            Self::Power => first.powf(second),
        }
    }
}
