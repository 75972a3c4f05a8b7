//! Dynamic complementarity systems: the Filippov system of time-freezing with its set-valued parts
//! written as complementarity conditions.

mod heaviside;

pub(crate) use heaviside::{
    ALPHA, BETA, HeavisideSystem, LAMBDA_MINUS, LAMBDA_PLUS, P, PER_CONTACT, W,
};
