//! Scenes from files.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::process::Stdio;

use crate::support::{Scratch, embedded, hangtime, json, program, refused, solved};

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
    for line in [
        "new ride",
        "check ride.hang",
        "simulate ride.hang --out out",
        "solve ride.hang --intervals 8",
        "explain ride.hang",
    ] {
        let said = scratch.run(line);
        assert_eq!((said.status, &*said.err), (Some(0), ""), "{line}");
    }
    assert!(
        scratch.read("out/ride.svg").contains("snow"),
        "the ground is drawn"
    );
    scratch.write("ride.hang", "mine");
    let said = scratch.run("new ride");
    assert_eq!(said.status, Some(2));
    assert!(said.err.contains("the file exists"), "{}", said.err);
    assert_eq!(scratch.read("ride.hang"), "mine");
}

#[test]
fn watched_scene_runs_again_when_its_file_changes() {
    let scratch = Scratch::new("watched-scene");
    let text = fs::read_to_string(shipped("incline")).unwrap();
    let file = scratch.write("incline.hang", &text);
    let mut running = program()
        .args(["check", &file, "--watch"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(running.stdout.take().unwrap()).lines();
    let mut next = || lines.next().unwrap().unwrap();
    assert!(next().contains("has 2 coordinates, 0 controls and 1 contact"));
    scratch.write(
        "incline.hang",
        text + "surface roof: z <= 100[m] impact roof: inelastic",
    );
    assert!(next().contains("has 2 coordinates, 0 controls and 2 contacts"));
    running.kill().unwrap();
    running.wait().unwrap();
}

#[test]
fn file_of_a_shipped_scene_gives_its_results() {
    let [listed, from_file] = ["ski-jump", &shipped("ski-jump")].map(|scene| {
        let result = json(&format!("simulate {scene} --set start_y=8.264m --json"));
        ["events", "final", "parameters"].map(|part| result[part].clone())
    });
    assert_eq!(listed, from_file);
}

#[test]
fn mistakes_of_a_file_are_shown_in_its_lines() {
    let scratch = Scratch::new("mistaken-scene");
    let text = fs::read_to_string(shipped("bouncing-ball")).unwrap();
    let mistaken = text.replace("lagrangian", "lagrangian z'^2 + \u{1b}");
    let file = scratch.write("ball.hang", mistaken);
    for line in ["check", "simulate --json", "explain"] {
        let said = hangtime(&format!("{line} {file}"));
        let stderr = said.err;
        assert_eq!((said.status, &*said.out), (Some(2), ""), "{stderr}");
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
    assert!(solved(&format!("check {}", shipped("incline"))).contains("no mistakes"));
}

#[test]
fn scene_file_is_found_by_its_name_alone_and_its_warnings_are_notes() {
    let scratch = Scratch::new("named-scene");
    let unused = THROWN.replace("g: m/s^2", "spare: kg = 3, g: m/s^2");
    scratch.write("thrown.hang", unused);
    let said = scratch.run("simulate thrown --json");
    assert_eq!(said.status, Some(0));
    let warning = "warning[E16]: parameter `spare` is never used";
    assert!(said.err.starts_with(warning), "{}", said.err);
    assert_eq!(said.json()["notes"].to_string().matches(warning).count(), 1);
    // A shipped scene goes before a file beside it.
    scratch.write("incline.hang", "no scene");
    assert_eq!(scratch.run("simulate incline").status, Some(0));
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
    let file = scratch.write("thrown.hang", THROWN);
    let document = json(&format!("simulate {file} --json --out {}", scratch.text()));
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
    let text = solved(&format!("explain {file}"));
    assert!(
        text.contains("outputs     speed [km/h], push [N], rub [N], twice [s]"),
        "{text}"
    );
    assert!(text.contains("push = force(floor)"), "{text}");
    // What a scene does not declare is in no file.
    let plain = json("simulate hills --json");
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
    let file = scratch.write("lander.hang", LANDER);
    let text = solved(&format!("explain {file}"));
    for line in [
        "constraint  soft [N s] >= 0 at every impact",
        "constraint  strong [N] >= 0\n",
        "constraint(soft) = bearable - impulse(ground)",
        "Jacobian of the impact functions: 2 x 5, 2 nonzeros",
        "columns: z, z', time, sum 0\n",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let solution = json(&format!("solve {file} --intervals 2 --json"));
    let objective = solution["objective"].as_f64().unwrap();
    assert!((objective - 2.0).abs() < 1e-6, "{objective}");
    let frozen = format!("solve {file} --intervals 2 --formulation time-freezing");
    let solution = json(&format!("{frozen} --json"));
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
    let file = scratch.write("thrown.hang", THROWN);
    let refusal = refused(&format!("fmt --check {} {file}", shipped("hills")));
    assert!(
        refusal.contains("thrown.hang: not in the settled style; run `hangtime fmt"),
        "{refusal}"
    );
    assert_eq!(scratch.read("thrown.hang"), THROWN);
    let text = solved(&format!("fmt {} {file}", shipped("hills")));
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
    assert!(solved(&format!("fmt --check {file}")).starts_with("1 file in the settled style"));
    // The folder holds the file and nothing else.
    assert_eq!(scratch.names(), ["thrown.hang"]);
    scratch.write("thrown.hang", "coordinates { z: m } lagrangian");
    assert_ne!(hangtime(&format!("fmt {file}")).status, Some(0));
    assert_eq!(
        scratch.read("thrown.hang"),
        "coordinates { z: m } lagrangian"
    );
}

/// A row of masses, of which a file in another folder has the springs, and that one the walls from beside it.
const ROW: &str = "use \"parts/spring.hang\" count n = 3 coordinates { x[n]: m }
    lagrangian += sum(k in 1..=n: 1 [kg]/2*dot(x[k])^2) s[k in 1..n]: spring(x[k], x[k + 1])
    start { x[k in 1..=n]: 1 [m]*k^2 } horizon 1 [s]";

#[test]
fn counts_are_settings_and_used_files_are_found_from_where_they_are_named() {
    let scratch = Scratch::new("counted-scene");
    let file = scratch.write("row.hang", ROW);
    std::fs::create_dir_all(scratch.0.join("parts")).unwrap();
    let spring = "use \"wall.hang\"\npart spring(a, b) {\n    lagrangian += -1 [N/m]/2*(a - b)^2 w: wall(a) }";
    scratch.write("parts/spring.hang", spring);
    let wall = "part wall(a) { surface w: a >= 0 impact w: restitution 1 }";
    scratch.write("parts/wall.hang", wall);
    // Equal masses on equal springs keep the place of their centre: of 1, 4 and of 1, 4, 9, 16.
    for (n, centre) in [(2, 2.5), (4, 7.5)] {
        let result = json(&format!("simulate {file} --set n={n} --json"));
        let places = result["final"]["q"].as_array().unwrap();
        assert_eq!(places.len(), n);
        let sum: f64 = places.iter().map(|place| place.as_f64().unwrap()).sum();
        assert!((sum / n as f64 - centre).abs() < 1e-9, "{sum}");
    }
    let refusal = refused(&format!("simulate {file} --set n=2.5"));
    assert!(
        refusal.contains("count `n` is a whole number, as in n=3"),
        "{refusal}"
    );
    let table = format!("{}/t.csv", scratch.text());
    solved(&format!(
        "sweep {file} --over n=2,3 --record final.x[2] --out {table}"
    ));
    let table = scratch.read("t.csv");
    assert_eq!(
        table.lines().filter(|line| line.contains("solved")).count(),
        2,
        "{table}"
    );
    // A mistake is told in its file, for every number.
    scratch.write("parts/wall.hang", wall.replace(">= 0", ">= 0 [s]"));
    for line in ["check", "simulate --set n=2", "simulate --set n=4"] {
        let said = hangtime(&format!("{line} {file}"));
        assert_eq!(said.status, Some(2));
        assert!(said.err.contains("parts/wall.hang:1:27"), "{}", said.err);
    }
}
