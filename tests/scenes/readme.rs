//! README shows programs that are compiled and run elsewhere: the texts must not part.

const README: &str = include_str!("../../README.md");

/// The part of `source` from `start` on, up to the line that closes the block.
fn block<'a>(source: &'a str, start: &str) -> &'a str {
    let from = source.find(start).expect("the block begins");
    let rest = &source[from..];
    let end = rest.find("\n}\n").expect("the block ends");
    &rest[..end + 3]
}

#[test]
fn readme_model_is_the_shipped_scene() {
    let source = include_str!("../../models/src/ski_jump.rs");
    assert!(README.contains(block(source, "hangtime::model! {")));
}

#[test]
fn readme_programs_are_the_examples() {
    for source in [
        include_str!("../../examples/ball_on_slope.rs"),
        include_str!("../../examples/own_command_line.rs"),
    ] {
        let from = source.find("use std").expect("the program begins");
        assert!(README.contains(&source[from..]));
    }
}
