//! What a user sees when a declaration has mistakes: every message, at the user's token, and nothing
//! else. `TRYBUILD=overwrite cargo test -p hangtime --test ui` records changed messages.

#[test]
fn mistakes_are_reported_at_the_users_token() {
    // Cases that compile stand in `tests/declarations/hygiene.rs`: one here would build every dependency again.
    trybuild::TestCases::new().compile_fail("tests/ui/*/*.rs");
}
