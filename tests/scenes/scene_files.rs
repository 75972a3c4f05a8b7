//! Shipped scenes, examples and the zoo as texts without a compiler: the same values, motions and optima.

use hangtime::ocp::{self, Problem, Settings};
use hangtime::prelude::*;
use hangtime_models::scenes;
use hangtime_scene_files::{SceneError, TextScene, of_text};

use crate::{bike_on_two_wheels, own_command_line, teaching_models};

#[path = "../declarations/same.rs"]
mod same;
#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/sledge.rs"]
mod sledge;

/// The files of the shipped scenes.
const FILES: [(&str, &str); 11] = [
    (
        "ski-jump",
        include_str!("../../models/scenes/ski-jump.hang"),
    ),
    (
        "pump-track",
        include_str!("../../models/scenes/pump-track.hang"),
    ),
    (
        "pump-track-holding",
        include_str!("../../models/scenes/pump-track-holding.hang"),
    ),
    (
        "bouncing-ball",
        include_str!("../../models/scenes/bouncing-ball.hang"),
    ),
    ("incline", include_str!("../../models/scenes/incline.hang")),
    (
        "elastic-box",
        include_str!("../../models/scenes/elastic-box.hang"),
    ),
    (
        "rough-ball",
        include_str!("../../models/scenes/rough-ball.hang"),
    ),
    (
        "stick-slip",
        include_str!("../../models/scenes/stick-slip.hang"),
    ),
    ("hills", include_str!("../../models/scenes/hills.hang")),
    (
        "falling-rod",
        include_str!("../../models/scenes/falling-rod.hang"),
    ),
    (
        "three-blocks",
        include_str!("../../models/scenes/three-blocks.hang"),
    ),
];

fn loaded(file: &str, text: &str) -> TextScene {
    of_text(file, text).unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// The shipped scenes, compiled and from their files.
fn shipped() -> Vec<(Box<dyn Model>, TextScene)> {
    let variants = scenes().iter().flat_map(|scene| scene.variants);
    let files = FILES
        .iter()
        .map(|(name, text)| loaded(&format!("{name}.hang"), text));
    variants
        .map(|variant| (variant.model)())
        .zip(files)
        .collect()
}

/// Compares two simulations of one scene.
fn assert_same_motion(compiled: &dyn Model, text: &dyn Model) {
    let name = compiled.declaration().name;
    let [mine, theirs] =
        [compiled, text].map(|model| simulate(model).run().expect("a start above the ground"));
    assert_eq!(mine.status, theirs.status, "{name}");
    assert_eq!(mine.events.len(), theirs.events.len(), "{name}");
    for (a, b) in mine.events.iter().zip(&theirs.events) {
        assert_eq!(a.kind, b.kind, "{name}");
        assert!(
            (a.time - b.time).abs() <= 1e-12,
            "{name}: {} {}",
            a.time,
            b.time
        );
    }
    let [q, p] = [&mine, &theirs].map(|run| run.trajectory.q.last().cloned().unwrap_or_default());
    for (a, b) in q.iter().zip(&p) {
        assert!(
            (a - b).abs() <= 1e-12 * (1.0 + a.abs()),
            "{name}: {a} against {b}"
        );
    }
}

#[test]
fn shipped_scene_from_its_file_moves_as_the_compiled_one() {
    let pairs = shipped();
    assert_eq!(pairs.len(), FILES.len());
    for (compiled, text) in &pairs {
        same::assert_same(&**compiled, text);
        assert_same_motion(&**compiled, text);
    }
}

/// The first declaration in a Rust source.
fn declaration(source: &str) -> &str {
    let (_, source) = source.split_once("model! {").expect("a declaration");
    let mut depth = 1;
    let end = source.find(|c| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        depth == 0
    });
    &source[..end.expect("the declaration ends")]
}

#[test]
fn example_from_its_text_moves_as_the_compiled_one() {
    let examples: [(&str, Box<dyn Model>); 9] = [
        (
            include_str!("../../examples/ball_on_slope.rs"),
            Box::new(teaching_models::ball_on_slope::BallOnSlope::default()),
        ),
        (
            include_str!("../../examples/bike_on_two_wheels.rs"),
            Box::new(bike_on_two_wheels::example::Bike::default()),
        ),
        (
            include_str!("../../examples/own_command_line.rs"),
            Box::new(own_command_line::example::Sledge::default()),
        ),
        (
            include_str!("../../examples/sledge.rs"),
            Box::new(sledge::Sledge::default()),
        ),
        (
            include_str!("../../examples/block_on_incline.rs"),
            Box::new(teaching_models::block_on_incline::BlockOnIncline::default()),
        ),
        (
            include_str!("../../examples/bouncing_ball.rs"),
            Box::new(teaching_models::bouncing_ball::BouncingBall::default()),
        ),
        (
            include_str!("../../examples/double_pendulum_with_stop.rs"),
            Box::new(teaching_models::double_pendulum_with_stop::Knee::default()),
        ),
        (
            include_str!("../../examples/elastic_ball_in_box.rs"),
            Box::new(teaching_models::elastic_ball_in_box::ElasticBallInBox::default()),
        ),
        (
            include_str!("../../examples/pendulum_against_wall.rs"),
            Box::new(teaching_models::pendulum_against_wall::PendulumAgainstWall::default()),
        ),
    ];
    for (source, compiled) in &examples {
        let text = loaded("example.hang", declaration(source));
        same::assert_same(&**compiled, &text);
        if compiled.horizon().is_some() {
            assert_same_motion(&**compiled, &text);
        }
    }
}

/// Scenes of the zoo, compiled: they have what the shipped ones have not, as losses, fixed and moved contacts, long horizons.
mod compiled {
    hangtime::model_file!("models/gallery/biped.hang");
    hangtime::model_file!("models/gallery/lander.hang");
    hangtime::model_file!("zoo/scenes/furuta-friction.hang");
    hangtime::model_file!("zoo/scenes/hollow-sledge.hang");
    hangtime::model_file!("zoo/scenes/peg-against-wall.hang");
}

#[test]
fn scene_of_the_zoo_from_its_text_evaluates_to_what_is_compiled() {
    let compiled: [(&str, Box<dyn Model>); 5] = [
        ("biped", Box::new(compiled::Biped::default())),
        ("lander", Box::new(compiled::Lander::default())),
        (
            "furuta-friction",
            Box::new(compiled::FurutaFriction::default()),
        ),
        ("hollow-sledge", Box::new(compiled::HollowSledge::default())),
        (
            "peg-against-wall",
            Box::new(compiled::PegAgainstWall::default()),
        ),
    ];
    for (name, compiled) in &compiled {
        let exhibit = hangtime_zoo::exhibits()
            .iter()
            .find(|exhibit| exhibit.name == *name);
        same::assert_same(&**compiled, &*exhibit.unwrap().model());
    }
}

#[test]
fn pump_track_from_its_file_has_the_optimum_of_the_compiled_one() {
    let (compiled, text) = &shipped()[1];
    let [mine, theirs] = [&**compiled, text as &dyn Model].map(|model| {
        let problem = Problem::of(model, 6);
        ocp::solve(model, &problem, &Settings::default(), &mut |_| true).unwrap()
    });
    assert!(mine.status.is_solved() && theirs.status.is_solved());
    assert!(
        (mine.objective - theirs.objective).abs() <= 1e-12,
        "{} {}",
        mine.objective,
        theirs.objective
    );
}

#[test]
fn mistakes_are_shown_with_their_line() {
    let text = FILES[0].1.replace("- m*g*z", "- m*g*zz");
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
        let mut text = FILES[random.below(FILES.len())].1.to_owned();
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
