//! Explicit functions of a scene as data: operations that may be carried out on other things than numbers, such as ranges of them.

/// What an explicit function of the input vector is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Explicit {
    /// The gap of a surface: one value.
    Gap(usize),
    /// Of a contact normal velocity, curvature and normal, `(v_n, curvature, n_1..n_nq)`, see
    /// [`contact_point`](super::contact_point); of dry friction its bound is there.
    Normal(usize),
    /// Of a contact with friction sliding velocity, curvature and tangent, `(v_t, curvature, b_1..b_nq)`, see
    /// [`tangent_point`](super::tangent_point).
    Tangent(usize),
    /// Of a contact with friction in space second sliding velocity, curvature and tangent.
    Across(usize),
    /// Accelerations without contact, or the matrix and the right-hand side of the linear system that they solve.
    Motion,
}

/// A function as operations in order of evaluation.
#[derive(Debug, Clone, Copy)]
pub struct Tape<'a> {
    /// The operations; their operands are earlier ones, by position.
    pub operations: &'a [Operation],
    /// Positions of the operations that are the values.
    pub outputs: &'a [u32],
}

/// One operation on the results of earlier ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Operation {
    /// The value of a parameter; behind all parameters, 1 for each equation of a joint that is held and 0 for others.
    Parameter(u32),
    /// A component of the input vector.
    Input(u32),
    /// A number.
    Constant(f64),
    /// Sum.
    Add(u32, u32),
    /// Difference.
    Subtract(u32, u32),
    /// Product.
    Multiply(u32, u32),
    /// Quotient.
    Divide(u32, u32),
    /// The negative.
    Negate(u32),
    /// Square root.
    Root(u32),
    /// A function of one number.
    Call(Function, u32),
    /// `atan2(y, x)`.
    Atan2(u32, u32),
    /// A base to an exponent that is no multiple of 1/2.
    Power(u32, u32),
    /// Something else.
    Unknown,
}

/// Functions of one number.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    /// Square root, of the square of a velocity.
    Root,
    /// `1/sqrt(x)`, and 0 at rest.
    InverseRoot,
    /// Absolute value.
    Abs,
    /// Sign, 1 at zero.
    Sign,
    /// The derivative of some order of a function given by points: polynomials in the distance from the places where they begin to
    /// hold, constant first; the first of them holds in front of all places.
    Profile(&'static [(f64, [f64; 6])], u8),
}

impl Function {
    /// Whether it does nothing in some places that it does not do in others, but where its argument vanishes.
    pub(crate) fn is_the_same_everywhere(self) -> bool {
        use Function::{Abs, Acos, Asin, Cbrt, Cos, Root, Sign, Sin};
        matches!(self, Sin | Cos | Asin | Acos | Cbrt | Root | Abs | Sign)
    }
}
