//! Forces without a value: poles, roots of negative numbers, divisions by zero.

use super::assert_outcomes;

pub(super) const SCENES: &[&str] = &["infinite-start", "not-a-number", "pole", "zero-parameter"];

#[test]
fn functions_without_a_value_stop_a_run_with_a_name() {
    assert_outcomes(SCENES);
}
