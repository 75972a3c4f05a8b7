//! Friction: the beginning and the end of slips, spontaneous and on several contacts at once (codimension 2).

use super::assert_outcomes;

pub(super) const SCENES: &[&str] = &[
    "impact-ends-stick",
    "resting-threshold",
    "sliding-threshold",
    "stop-at-step-end",
    "stop-in-bowl",
    "three-feet",
    "turning-friction",
    "two-slips",
];

#[test]
fn slips_begin_and_end_where_the_cone_says() {
    assert_outcomes(SCENES);
}
