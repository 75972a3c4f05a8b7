//! What a user sees when a declaration has mistakes: every message, at the user's token, and nothing
//! else. `TRYBUILD=overwrite cargo test --test ui -- --ignored` records changed messages.

use std::fs;
use std::path::Path;

#[test]
#[ignore = "long"]
fn mistakes_are_reported_at_the_users_token() {
    // `model_file!` reads paths from the package in which the cases are built.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .parent()
        .expect("the target folder");
    let scenes = target.join("tests/trybuild/hangtime/scenes");
    fs::create_dir_all(&scenes).expect("a folder for scenes");
    fs::copy("tests/ui/files/ball.hang", scenes.join("ball.hang")).expect("the scene is copied");
    // Cases that compile stand in `tests/declarations/hygiene.rs`: one here would build every dependency again.
    trybuild::TestCases::new().compile_fail("tests/ui/*/*.rs");
}
