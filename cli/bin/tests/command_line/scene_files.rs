//! Scenes from files.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::support::{Scratch, embedded, hangtime, json, refused, solved};

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
        assert!(stderr.contains("`hangtime explain syntax`"), "{stderr}");
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

#[test]
fn scene_file_is_found_by_its_name_alone_and_its_warnings_are_notes() {
    let scratch = Scratch::new("named-scene");
    fs::create_dir_all(&scratch.0).unwrap();
    let unused = THROWN.replace("g: m/s^2", "spare: kg = 3, g: m/s^2");
    fs::write(scratch.0.join("thrown.hang"), unused).unwrap();
    let run = |words: &[&str]| {
        std::process::Command::new(env!("CARGO_BIN_EXE_hangtime"))
            .args(words)
            .current_dir(&scratch.0)
            .output()
            .unwrap()
    };
    let output = run(&["simulate", "thrown", "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let stderr = String::from_utf8(output.stderr).unwrap();
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let warning = "warning[E16]: parameter `spare` is never used";
    let notes = document["notes"].as_array().unwrap();
    let said = |note: &&serde_json::Value| note.as_str().unwrap().starts_with(warning);
    assert!(stderr.starts_with(warning), "{stderr}");
    assert_eq!(notes.iter().filter(said).count(), 1, "{notes:?}");
    // A shipped scene goes before a file beside it, and a name that is neither is refused as before.
    fs::write(scratch.0.join("incline.hang"), "no scene").unwrap();
    assert_eq!(run(&["simulate", "incline"]).status.code(), Some(0));
    let output = run(&["simulate", "thrwn"]);
    assert!(
        String::from_utf8(output.stderr)
            .unwrap()
            .contains("unknown scene `thrwn`")
    );
}

/// A ball that is thrown along a rough floor, with what is recorded of it.
const THROWN: &str = "parameters { m: kg = 2, g: m/s^2 = 9.81 } coordinates { y: m, z: m } \
    lagrangian m/2*|dot((y, z))|^2 - m*g*z surface floor: z >= 0 impact floor: inelastic, friction 0.1 \
    outputs { speed: km/h = |dot((y, z))|, push: N = force(floor), rub: N = friction_force(floor), twice: s = 2*t } \
    picture { circle ball at (y, z) radius 0.2[m], curve floor: (w, 0) over w } \
    start { dot(y): 3 } horizon 1 [s]";

#[test]
fn outputs_stand_beside_the_motion_in_every_file() {
    let scratch = Scratch::new("recorded-scene");
    fs::create_dir_all(&scratch.0).unwrap();
    let file = scratch.0.join("thrown.hang");
    fs::write(&file, THROWN).unwrap();
    let file = file.to_str().unwrap();
    let document = json(&["simulate", file, "--json", "--out", scratch.text()]);
    let names = serde_json::json!([
        { "name": "speed", "unit": "km/h" },
        { "name": "push", "unit": "N" },
        { "name": "rub", "unit": "N" },
        { "name": "twice", "unit": "s" },
    ]);
    assert_eq!(document["quantities"]["outputs"], names);
    let trajectory = &document["trajectory"];
    let rows = trajectory["outputs"].as_array().unwrap();
    assert_eq!(rows.len(), trajectory["time"].as_array().unwrap().len());
    for (row, time) in rows.iter().zip(trajectory["time"].as_array().unwrap()) {
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let t = number(time);
        // It slides all the time, and friction brakes it with 0.1 g.
        let wanted = [3.6 * (3.0 - 0.981 * t), 2.0 * 9.81, -0.2 * 9.81, 2.0 * t];
        for (value, wanted) in row.as_array().unwrap().iter().zip(wanted) {
            // The promise of the method is 1e-6; a quadratic is exact up to rounding.
            assert!(
                (number(value) - wanted).abs() < 1e-10,
                "{t}: {value} {wanted}"
            );
        }
    }
    let table = scratch.read("thrown-trajectory.csv");
    let head = table.lines().next().unwrap();
    assert!(
        head.ends_with("speed [km/h],push [N],rub [N],twice [s]"),
        "{head}"
    );
    let page = scratch.read("thrown.html");
    let frames = embedded(&page, "frames");
    let readings = frames["readings"].as_array().unwrap();
    assert_eq!(readings.last().unwrap()["name"], "twice");
    // The force acts where the ball touches the floor, straight up and against the motion.
    let force = &frames["forces"][0][0];
    assert_eq!((&force["on"], &force["torque"]), (&0.into(), &0.0.into()));
    assert!(force["at"][1].as_f64().unwrap().abs() < 1e-9, "{force}");
    assert!(
        (force["force"][1].as_f64().unwrap() - 19.62).abs() < 1e-6,
        "{force}"
    );
    assert!(scratch.read("thrown-time.svg").contains("rub [N]"));
    let text = solved(&["explain", file]);
    assert!(
        text.contains("outputs     speed [km/h], push [N], rub [N], twice [s]"),
        "{text}"
    );
    assert!(text.contains("push = force(floor)"), "{text}");
    // What a scene does not declare is in no file.
    let plain = json(&["simulate", "hills", "--json"]);
    assert!(plain["trajectory"].get("outputs").is_none());
    assert!(plain["quantities"].get("outputs").is_none());
}

/// A lander with legs that bear so much.
const LANDER: &str = "parameters { m: kg = 2, g: m/s^2 = 10, bearable: N s = 10 } coordinates { z: m } \
    controls { u: N in 0..=30 } lagrangian m/2*dot(z)^2 - m*g*z forces { z: u } \
    surface ground: z >= 0 impact ground: inelastic minimize time + sum(impulse(ground)^2)*1e-9 [1/N^2/s] \
    constraint soft: impulse(ground) <= bearable constraint strong: force(ground) <= 90 [N] \
    finally { z == 0, dot(z) == 0 } start { z: 12.5 } horizon 2 [s]";

#[test]
fn forces_and_impulses_are_explained_solved_for_and_told_where_a_program_leaves_them_out() {
    let scratch = Scratch::new("forces-scene");
    fs::create_dir_all(&scratch.0).unwrap();
    let file = scratch.0.join("lander.hang");
    fs::write(&file, LANDER).unwrap();
    let file = file.to_str().unwrap();
    let text = solved(&["explain", file]);
    for line in [
        "constraint  soft [N s] >= 0 at every impact",
        "constraint  strong [N] >= 0\n",
        "constraint(soft) = bearable - impulse(ground)",
        "Jacobian of the impact functions: 2 x 5, 2 nonzeros",
        "columns: z, z', time, sum 0\n",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let solution = json(&["solve", file, "--intervals", "2", "--json"]);
    let objective = solution["objective"].as_f64().unwrap();
    assert!((objective - 2.0).abs() < 1e-6, "{objective}");
    let frozen = [
        "solve",
        file,
        "--intervals",
        "2",
        "--formulation",
        "time-freezing",
    ];
    let solution = json(&[&frozen[..], &["--json"]].concat());
    let objective = solution["objective"].as_f64().unwrap();
    assert!((objective - 2.0).abs() < 1e-6, "{objective}");
    // The exact program has forces and impulses, too.
    let report = &solution["time_freezing"];
    assert_eq!(report["left_out"].as_array().map(Vec::len), Some(0));
    let own = report["objective"].as_f64().unwrap();
    assert!((own - 2.0).abs() < 1e-6, "{own}");
    assert!(!solved(&frozen).contains("without"));
}

#[test]
fn fmt_writes_the_settled_style_or_says_what_is_not_in_it() {
    let scratch = Scratch::new("formatted-scene");
    fs::create_dir_all(&scratch.0).unwrap();
    let file = scratch.0.join("thrown.hang");
    fs::write(&file, THROWN).unwrap();
    let file = file.to_str().unwrap();
    let refusal = refused(&["fmt", "--check", &shipped("hills"), file]);
    assert!(
        refusal.contains("thrown.hang: not in the settled style; run `hangtime fmt"),
        "{refusal}"
    );
    assert_eq!(scratch.read("thrown.hang"), THROWN);
    let text = solved(&["fmt", &shipped("hills"), file]);
    assert!(
        text.ends_with("thrown.hang; 1 file in the settled style already\n"),
        "{text}"
    );
    let formatted = scratch.read("thrown.hang");
    assert!(
        formatted
            .starts_with("parameters { m: kg = 2, g: m/s^2 = 9.81 }\ncoordinates { y: m, z: m }\n")
    );
    assert!(
        formatted.ends_with("start { dot(y): 3 }\nhorizon 1 [s]\n"),
        "{formatted}"
    );
    assert!(solved(&["fmt", "--check", file]).starts_with("1 file in the settled style"));
    // The folder holds the file and nothing else.
    assert_eq!(scratch.names(), ["thrown.hang"]);
    fs::write(file, "coordinates { z: m } lagrangian").unwrap();
    assert!(!hangtime(&["fmt", file]).status.success());
    assert_eq!(
        scratch.read("thrown.hang"),
        "coordinates { z: m } lagrangian"
    );
    assert!(refused(&["fmt", "hills"]).contains("ends with .hang"));
}
