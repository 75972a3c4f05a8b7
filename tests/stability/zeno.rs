//! Infinitely many impacts in finite time, and very many.

use super::assert_outcomes;

pub(super) const SCENES: &[&str] = &["elastic-floor", "long-zeno", "narrow-gap", "zeno"];

#[test]
fn bounces_end_where_their_series_ends() {
    assert_outcomes(SCENES);
}
