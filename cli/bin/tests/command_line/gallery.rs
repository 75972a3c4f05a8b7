//! Scenes to choose from: what they ask, and that the answers are those of `solve`.

use crate::support::{json, solved};

/// By how much of itself an objective may differ from the one that is known.
const ALIKE: f64 = 1e-6;

#[test]
fn answers_are_what_solve_finds() {
    for name in ["hop", "wall-ball", "rough-block"] {
        let scene = &json(&["list", name, "--json"])["scenes"][0];
        let known = scene["known"]["objective"].as_f64().unwrap();
        let intervals = scene["known"]["intervals"].to_string();
        let solution = json(&["solve", name, "--intervals", &intervals, "--json"]);
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
    let document = json(&["list", "--json"]);
    let scenes = document["scenes"].as_array().unwrap();
    let asking = scenes.iter().filter(|scene| !scene["question"].is_null());
    let asking: Vec<_> = asking.collect();
    assert!(asking.len() >= 19, "{}", asking.len());
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
    for scene in asking {
        let name = scene["name"].as_str().unwrap();
        let commands = scene["commands"].as_array().unwrap();
        assert!(commands.contains(&"solve".into()), "{name}");
        let file = format!(
            "{}/../../models/gallery/{name}.hang",
            env!("CARGO_MANIFEST_DIR")
        );
        solved(&["fmt", "--check", &file]);
    }
}
