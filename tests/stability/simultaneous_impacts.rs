//! Simultaneous impacts, with couplings of both signs, and impacts within rounding error of each other.

use super::assert_outcomes;

pub(super) const SCENES: &[&str] = &[
    "almost-flat-rod",
    "blunt-corner",
    "corner",
    "falling-stack",
    "flat-rod",
    "flight-into-corner",
    "near-corner",
    "newtons-cradle",
    "sharp-corner",
];

#[test]
fn impacts_at_once_follow_one_law() {
    assert_outcomes(SCENES);
}
