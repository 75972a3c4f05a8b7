//! Grazing: surfaces that are touched with no velocity, or hardly any.

use super::assert_outcomes;

pub(super) const SCENES: &[&str] = &[
    "grazing-apex",
    "slight-graze",
    "tangent-flight",
    "weightless-slide",
];

#[test]
fn grazing_contacts_change_nothing_that_they_should_not() {
    assert_outcomes(SCENES);
}
