//! Scales: far from the origin, large and small lengths and masses, stiff springs, fast rotation.

use super::assert_outcomes;

pub(super) const SCENES: &[&str] = &[
    "curved-gap",
    "far-from-origin",
    "fast-rotation",
    "heavy-on-light",
    "large-gap",
    "mass-ratio",
    "megametre",
    "micrometre",
    "small-gap",
    "stiff-spring",
];

#[test]
fn scales_change_nothing_but_scales() {
    assert_outcomes(SCENES);
}
