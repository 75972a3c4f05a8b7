//! README shows programs that are compiled and run elsewhere: the texts must not part.

use crate::ball_on_slope::example::BallOnSlope;
use hangtime::prelude::*;

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/sledge.rs"]
pub(crate) mod sledge;

const README: &str = include_str!("../../README.md");

#[test]
fn readme_model_is_the_shipped_scene() {
    assert!(README.contains(include_str!("../../models/scenes/ski-jump.hang")));
}

#[test]
fn readme_programs_are_the_examples() {
    for source in [
        include_str!("../../examples/ball_on_slope.rs"),
        include_str!("../../examples/sledge.rs"),
    ] {
        let from = source.find("use hangtime").expect("the program begins");
        assert!(README.contains(&source[from..]));
    }
    let source = include_str!("../../examples/own_command_line.rs");
    let from = source.find("/// The scenes of this program.");
    let from = from.expect("the part begins");
    assert!(README.contains(&source[from..]));
}

/// The fenced block of README that begins after `start`, without the lines that hold measured rounding.
fn shown(start: &str) -> Vec<&'static str> {
    let rest = README.split_once(start).expect("the place is there").1;
    let block = rest.split_once("```text\n").expect("a block").1;
    let block = block.split_once("```").expect("its end").0;
    reproducible(block)
}

/// The lines without the distance of the re-simulation, which is rounding, and without the controls at the end, of which
/// many do as well.
fn reproducible(text: &str) -> Vec<&str> {
    let lines = text.lines();
    let lines = lines.filter(|line| !line.starts_with("the re-simulation ends"));
    let ends = lines.map(|line| line.split_once(", push =").map_or(line, |(state, _)| state));
    ends.collect()
}

#[test]
fn readme_shows_what_its_programs_print() {
    let ball = BallOnSlope {
        tilt: 0.4,
        ..BallOnSlope::default()
    };
    let printed = simulate(&ball).run().unwrap().to_string();
    assert_eq!(
        shown("cargo run --release --example ball_on_slope"),
        printed.lines().collect::<Vec<_>>()
    );
    let printed = solve(&sledge::Sledge::default()).intervals(10).run();
    let printed = printed.unwrap().to_string();
    assert_eq!(
        shown("cargo run --release --example sledge"),
        reproducible(&printed)
    );
}
