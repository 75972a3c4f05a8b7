//! Dynamic complementarity systems: the Filippov system of time-freezing with its set-valued parts
//! written as complementarity conditions.

mod heaviside;

pub(crate) use heaviside::{
    ALPHA, Group, HeavisideSystem, P, W, gap_gradient, gap_hessian, hessian, jacobian,
};
