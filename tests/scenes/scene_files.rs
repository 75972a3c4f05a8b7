//! Shipped scenes and examples as texts without a compiler: the same values. Other compiled scenes stand in `tests/declarations`.

use hangtime::prelude::*;
use hangtime_models::{scene_texts, scenes};
use hangtime_scene_files::{SceneError, TextScene, of_text};

use crate::{bike_on_two_wheels, own_command_line, teaching_models};

#[path = "../declarations/same.rs"]
mod same;
#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/sledge.rs"]
mod sledge;

fn loaded(file: &str, text: &str) -> TextScene {
    of_text(file, text).unwrap_or_else(|error| panic!("{file}: {error}"))
}

#[test]
fn shipped_scene_from_its_file_evaluates_to_what_is_compiled() {
    let variants = scenes().iter().flat_map(|scene| scene.variants);
    assert_eq!(variants.clone().count(), scene_texts().len());
    for (variant, (name, text)) in variants.zip(scene_texts()) {
        same::assert_same(&*(variant.model)(), &loaded(name, text));
    }
}

#[test]
fn example_from_its_text_evaluates_to_what_is_compiled() {
    let examples: [&dyn Model; 9] = [
        &teaching_models::ball_on_slope::BallOnSlope::default(),
        &bike_on_two_wheels::example::Bike::default(),
        &own_command_line::example::Sledge::default(),
        &sledge::Sledge::default(),
        &teaching_models::block_on_incline::BlockOnIncline::default(),
        &teaching_models::bouncing_ball::BouncingBall::default(),
        &teaching_models::double_pendulum_with_stop::Knee::default(),
        &teaching_models::elastic_ball_in_box::ElasticBallInBox::default(),
        &teaching_models::pendulum_against_wall::PendulumAgainstWall::default(),
    ];
    for compiled in examples {
        let text = loaded("example.hang", compiled.text());
        same::assert_same(compiled, &text);
    }
}

#[test]
fn mistakes_are_shown_with_their_line() {
    let text = scene_texts()[0].1.replace("- m*g*z", "- m*g*zz");
    let Err(SceneError::Mistakes { mistakes, report }) = of_text("ski-jump.hang", &text) else {
        panic!("a name that is not declared is refused");
    };
    assert_eq!(mistakes.len(), 1);
    assert_eq!(&text[mistakes[0].place.clone()], "zz");
    let lines: Vec<&str> = report.lines().collect();
    assert!(
        lines[0].starts_with("error[E01]: `zz` is not declared"),
        "{report}"
    );
    let line = text[..mistakes[0].place.start].lines().count();
    assert!(
        lines[1]
            .trim_start()
            .starts_with(&format!("--> ski-jump.hang:{line}:")),
        "{report}"
    );
    assert!(lines[3].contains("lagrangian"), "{report}");
    assert_eq!(lines[3].find("zz"), lines[4].find("^^"), "{report}");
}

struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

/// The text with one change, as slips of fingers and editors make it.
fn mutated(text: &str, random: &mut Random) -> String {
    const PIECES: [&str; 24] = [
        "'",
        "(",
        ")",
        "{",
        "}",
        "[",
        "]",
        "\"",
        "/*",
        "//",
        "\n",
        "\u{b7}",
        "^",
        "*",
        "-",
        "1e308",
        "dot(",
        "diff(",
        "lagrangian ",
        "^(y)",
        "1/0",
        "surface ",
        ",",
        "0.",
    ];
    let mut characters: Vec<char> = text.chars().collect();
    let at = random.below(characters.len());
    let length = 1 + random.below(12);
    let end = (at + length).min(characters.len());
    match random.below(5) {
        0 => {
            characters.drain(at..end);
        }
        1 => {
            let copy: Vec<char> = characters[at..end].to_vec();
            let to = random.below(characters.len());
            characters.splice(to..to, copy);
        }
        2 => {
            let piece = PIECES[random.below(PIECES.len())];
            characters.splice(at..at, piece.chars());
        }
        3 => {
            let piece = PIECES[random.below(PIECES.len())].repeat(1 + random.below(300));
            characters.splice(at..at, piece.chars());
        }
        _ => {
            let other = random.below(characters.len());
            characters.swap(at, other);
        }
    }
    characters.into_iter().collect()
}

/// Derives mutated scenes and evaluates what is left of them; how many were refused.
fn survive(cases: std::ops::Range<u64>) -> u64 {
    let mut refused = 0;
    for seed in cases {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(1));
        let mut text = scene_texts()[random.below(scene_texts().len())]
            .1
            .to_owned();
        for _ in 0..=random.below(3) {
            text = mutated(&text, &mut random);
        }
        match of_text("mutated.hang", &text) {
            Ok(scene) => {
                let n = scene.declaration().coordinates.len();
                let x = vec![0.3; scene.declaration().inputs()];
                scene.free_acceleration(&x, &mut vec![0.0; n]);
                scene.start(&mut vec![0.0; n], &mut vec![0.0; n]);
            }
            Err(SceneError::Mistakes { mistakes, report }) => {
                refused += 1;
                assert!(!mistakes.is_empty(), "refused without a message: {text}");
                for mistake in mistakes {
                    assert!(!mistake.message.contains('\n'), "{}", mistake.message);
                    assert!(mistake.place.end <= text.len(), "{}", mistake.message);
                }
                assert!(report.len() < 40_000, "{} bytes: {text}", report.len());
            }
            Err(error) => panic!("{error}"),
        }
    }
    refused
}

/// Mutated files, unless `HANGTIME_MUTATED_SCENES` asks for others: some seconds in the development profile.
const MUTATED: u64 = 400;

#[test]
fn mutated_files_are_answered_by_messages() {
    let asked = std::env::var("HANGTIME_MUTATED_SCENES");
    let files = asked.map_or(MUTATED, |text| text.parse().expect("a whole number"));
    let refused = survive(0..files);
    // If hardly any change broke a scene, the test would test nothing.
    assert!(
        (3 * files / 8..files).contains(&refused),
        "{refused} of {files}"
    );
}
