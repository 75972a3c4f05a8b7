//! Scenes from files.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::support::{Scratch, hangtime, json, refused, solved};

/// Runs the binary in a folder.
fn inside(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hangtime"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

/// The path of a shipped scene.
fn shipped(name: &str) -> String {
    format!(
        "{}/../../models/scenes/{name}.hang",
        env!("CARGO_MANIFEST_DIR")
    )
}

#[test]
fn new_scene_simulates_and_solves_and_is_never_overwritten() {
    let scratch = Scratch::new("new-scene");
    fs::create_dir_all(&scratch.0).unwrap();
    for arguments in [
        &["new", "ride"][..],
        &["check", "ride.hang"],
        &["simulate", "ride.hang", "--out", "out"],
        &["solve", "ride.hang", "--intervals", "8"],
        &["explain", "ride.hang"],
    ] {
        let output = inside(&scratch.0, arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {stderr}");
        assert_eq!(stderr, "", "{arguments:?}");
    }
    assert!(
        scratch.read("out/ride.svg").contains("snow"),
        "the ground is drawn"
    );
    fs::write(scratch.0.join("ride.hang"), "mine").unwrap();
    let output = inside(&scratch.0, &["new", "ride"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("the file exists"));
    assert_eq!(scratch.read("ride.hang"), "mine");
    assert!(refused(&["new", "../ride"]).contains("ASCII letters"));
}

#[test]
fn watched_scene_runs_again_when_its_file_changes() {
    let scratch = Scratch::new("watched-scene");
    fs::create_dir_all(&scratch.0).unwrap();
    let file = scratch.0.join("incline.hang");
    fs::copy(shipped("incline"), &file).unwrap();
    let mut running = Command::new(env!("CARGO_BIN_EXE_hangtime"))
        .args(["check", file.to_str().unwrap(), "--watch"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(running.stdout.take().unwrap()).lines();
    let mut next = || lines.next().unwrap().unwrap();
    assert!(next().contains("has 2 coordinates, 0 controls and 1 contact"));
    let text = fs::read_to_string(&file).unwrap();
    fs::write(
        &file,
        text + "surface roof: z <= 100[m] impact roof: inelastic",
    )
    .unwrap();
    assert!(next().contains("has 2 coordinates, 0 controls and 2 contacts"));
    running.kill().unwrap();
    running.wait().unwrap();
    assert!(refused(&["simulate", "incline", "--watch"]).contains("looks at a scene file"));
}

#[test]
fn file_of_a_shipped_scene_gives_its_results() {
    let settings = ["--set", "start_y=8.264m", "--json"];
    let [listed, from_file] = ["ski-jump", &shipped("ski-jump")].map(|scene| {
        let result = json(&[&["simulate", scene][..], &settings].concat());
        (
            result["events"].clone(),
            result["final"].clone(),
            result["parameters"].clone(),
        )
    });
    assert_eq!(listed, from_file);
}

#[test]
fn mistakes_of_a_file_are_shown_in_its_lines() {
    let scratch = Scratch::new("mistaken-scene");
    fs::create_dir_all(&scratch.0).unwrap();
    let text = fs::read_to_string(shipped("bouncing-ball")).unwrap();
    let file = scratch.0.join("ball.hang");
    let file = file.to_str().unwrap();
    fs::write(file, text.replace("lagrangian", "lagrangian z'^2 + \u{1b}")).unwrap();
    for command in [
        &["check", file][..],
        &["simulate", file, "--json"],
        &["explain", file],
    ] {
        let output = hangtime(command);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert_eq!(output.stdout, b"");
        assert!(
            stderr.starts_with("error: write `dot(z)` for the rate of `z`, instead of `z'`\n"),
            "{stderr}"
        );
        assert!(
            stderr.contains("ball.hang:") && stderr.contains("^^"),
            "{stderr}"
        );
        assert!(
            !stderr.contains('\u{1b}'),
            "a terminal would obey: {stderr}"
        );
    }
    assert!(refused(&["simulate", "nowhere.hang"]).contains("scene file `nowhere.hang`"));
    assert!(refused(&["check", "ski-jump"]).contains("ends with .hang"));
    fs::write(file, [0xff, 0xfe]).unwrap();
    assert!(refused(&["check", file]).contains("save it as UTF-8"));
    assert!(solved(&["check", &shipped("incline")]).contains("no mistakes"));
}
