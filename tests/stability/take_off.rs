//! Leaving a surface: where the contact force vanishes, or the ground goes away.

use super::assert_outcomes;

pub(super) const SCENES: &[&str] = &[
    "balanced",
    "dome",
    "lift",
    "moving-wall",
    "shaken-floor",
    "slack-string",
];

#[test]
fn contacts_open_where_their_force_vanishes() {
    assert_outcomes(SCENES);
}
