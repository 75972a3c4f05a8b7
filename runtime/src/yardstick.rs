//! The yardstick: shares of what a quantity is measured by, below which the quantity counts as none.
//!
//! A threshold of one of these values is stated by its name; one of another value stands where it is used, with its reason. Behind
//! [`DIGITS`] each is a thousand times the one before, so that what one leaves cannot be taken for what the next one asks. Where nothing
//! measures a quantity, its own unit does, and a comment says so.

/// Rounding error of a sum of some terms, as a share of the largest of them.
pub(crate) const DIGITS: f64 = 64.0 * f64::EPSILON;
/// Rounding error of what follows from a linear system, as a share of its terms: systems are solved to some `1e-15`, and their conditions
/// multiply that. Directions that differ by less than its root \[rad\] are one; instants that differ by less of a motion are one.
pub(crate) const ROUNDING: f64 = 1e-12;
/// What rounding makes of a quantity along a motion, as a share of its largest value: a thousandth of what runs promise.
pub(crate) const NOTHING: f64 = 1e-9;
/// Error that runs promise where none is asked for, as a share of the largest values of a motion.
pub(crate) const PROMISE: f64 = 1e-6;
/// What a curve in a figure shows, as a share of the largest value.
pub(crate) const VISIBLE: f64 = 1e-3;
