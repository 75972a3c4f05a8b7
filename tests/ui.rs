//! Messages of the macro where the compiler shows them, one case a mistake, and what it accepts anywhere.

#[test]
fn mistakes_are_reported_at_the_users_token() {
    trybuild::TestCases::new().compile_fail("tests/ui/*/*.rs");
}

#[test]
fn scenes_compile_whatever_names_are_in_scope() {
    trybuild::TestCases::new().pass("tests/ui_pass/*.rs");
}
