//! Scenes to choose from: what they ask, and that the answers are those of `solve`.

use crate::support::{json, solved};

/// By how much of itself an objective may differ from the one that is known.
const ALIKE: f64 = 1e-6;

#[test]
fn answers_are_what_solve_finds() {
    for name in [
        "hop",
        "wall-ball",
        "rough-block",
        "pushing",
        "billiards",
        "bouncing-throw",
        "jump-on-sledge",
    ] {
        let scene = &json(&format!("list {name} --json"))["scenes"][0];
        let known = scene["known"]["objective"].as_f64().unwrap();
        let intervals = scene["known"]["intervals"].to_string();
        // An estimate plans nothing.
        let solution = match intervals.as_str() {
            "0" => json(&format!("solve {name} --json")),
            _ => json(&format!("solve {name} --intervals {intervals} --json")),
        };
        let found = solution["objective"].as_f64().unwrap();
        assert_eq!(solution["status"], "solved", "{name}");
        assert!(
            (found - known).abs() < ALIKE * known.abs(),
            "{name}: {found} {known}"
        );
    }
}

#[test]
fn scenes_that_ask_are_in_groups_can_be_solved_and_are_in_the_settled_style() {
    let document = json("list --json");
    let scenes = document["scenes"].as_array().unwrap();
    let asking = scenes.iter().filter(|scene| !scene["question"].is_null());
    let asking: Vec<_> = asking.collect();
    assert!(asking.len() >= 30, "{}", asking.len());
    assert!(scenes.iter().all(|scene| scene["group"] != ""));
    // A paragraph each, which `list` prints in lines.
    for scene in scenes {
        let about = scene["about"].as_str().unwrap_or_default();
        assert!(
            about.split_whitespace().count() > 15,
            "{}: {about}",
            scene["name"]
        );
    }
    let alone = &json("list hop --json")["scenes"][0];
    assert!(scenes.contains(alone), "{alone}");
    for scene in asking {
        let name = scene["name"].as_str().unwrap();
        let commands = scene["commands"].as_array().unwrap();
        assert!(commands.contains(&"solve".into()), "{name}");
        let file = format!(
            "{}/../../models/gallery/{name}.hang",
            env!("CARGO_MANIFEST_DIR")
        );
        solved(&format!("fmt --check {file}"));
    }
}

/// Left, right, top and bottom of every path of a picture.
fn extents(picture: &str) -> Vec<[f64; 4]> {
    let paths = picture.split(" d=\"").skip(1);
    let paths = paths.map(|rest| rest.split('"').next().unwrap());
    let extent = |path: &str| {
        let numbers = path
            .split(['M', 'L', ' '])
            .filter_map(|number| number.parse().ok());
        let numbers: Vec<f64> = numbers.collect();
        let along = |axis: usize| numbers.iter().skip(axis).step_by(2).copied();
        [
            along(0).fold(f64::INFINITY, f64::min),
            along(0).fold(f64::NEG_INFINITY, f64::max),
            along(1).fold(f64::INFINITY, f64::min),
            along(1).fold(f64::NEG_INFINITY, f64::max),
        ]
    };
    paths.map(extent).collect()
}

#[test]
fn pictures_of_scenes_that_ask_nothing_are_those_of_their_motions() {
    // Pictures have one decimal, and leave out points nearer than 0.15 to their lines.
    const ALIKE: f64 = 0.5;
    let scenes = hangtime_models::scenes();
    let mut drawn = 0;
    for scene in scenes.iter().filter(|scene| scene.question.is_none()) {
        let host = hangtime_cli::HostScene::open(scenes, scene.name).unwrap();
        let run = host.simulate(&[], &mut |_| true).unwrap();
        let picture = run.thumbnail().unwrap_or_default();
        let [now, kept] = [&picture, scene.picture].map(extents);
        let write = "write it anew by `hangtime-book --pictures`";
        assert_eq!(now.len(), kept.len(), "{}: {write}", scene.name);
        for (now, kept) in now.as_flattened().iter().zip(kept.as_flattened()) {
            assert!(
                (now - kept).abs() < ALIKE,
                "{}: {now} {kept}; {write}",
                scene.name
            );
        }
        drawn += usize::from(!picture.is_empty());
    }
    // All but the one whose motion is not unique.
    assert_eq!(
        drawn + 1,
        scenes
            .iter()
            .filter(|scene| scene.question.is_none())
            .count()
    );
    assert!(
        scenes
            .iter()
            .all(|scene| scene.question.is_none() || !scene.picture.is_empty())
    );
}
