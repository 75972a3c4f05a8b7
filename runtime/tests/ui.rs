//! What a user sees when a declaration has mistakes: every message, at the user's token, and nothing
//! else. `TRYBUILD=overwrite cargo test -p hangtime --test ui` records changed messages.

use std::fs;
use std::path::Path;

#[test]
fn mistakes_are_reported_at_the_users_token() {
    // Cases are built in `tests/trybuild/hangtime` of the target folder, from where `model_file!` reads paths.
    let scene = Path::new(env!("CARGO_TARGET_TMPDIR")).join("ball.hang");
    fs::copy("tests/ui/files/ball.hang", scene).expect("the scene file is copied");
    // Cases that compile stand in `tests/declarations/hygiene.rs`: one here would build every dependency again.
    trybuild::TestCases::new().compile_fail("tests/ui/*/*.rs");
}
