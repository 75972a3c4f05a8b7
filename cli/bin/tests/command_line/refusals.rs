//! Bad input.

use std::path::Path;

use crate::support::{Scratch, hangtime, refused, solved};

/// What the message says, and the words of the command.
const REFUSED: &[(&str, &[&str])] = &[
    (
        "unknown scene `ski-jmp`; did you mean `ski-jump`?",
        &["simulate", "ski-jmp"],
    ),
    (
        "has no parameter `starty`; did you mean `start_y`?",
        &["simulate", "ski-jump", "--set", "starty=8"],
    ),
    (
        "parameter `m` = -80 kg: must be above 0",
        &["simulate", "ski-jump", "--set", "m=-80"],
    ),
    ("`m` = 0 kg", &["simulate", "ski-jump", "--set", "m=0"]),
    (
        "parameter `g` = `NaN` is not finite",
        &["simulate", "ski-jump", "--set", "g=NaN"],
    ),
    (
        "parameter `g` = `inf` is not finite",
        &["simulate", "ski-jump", "--set", "g=inf"],
    ),
    ("finite", &["simulate", "ski-jump", "--set", "g=1e999"]),
    (
        "cannot be converted",
        &["simulate", "ski-jump", "--set", "start_y=8s"],
    ),
    (
        "given twice",
        &["simulate", "ski-jump", "--set", "m=1", "--set", "m=2"],
    ),
    ("write NAME=VALUE", &["simulate", "ski-jump", "--set", "m"]),
    ("write NAME=VALUE", &["simulate", "ski-jump", "--set", "m="]),
    (
        "parameter `speed` [km/h]: `kg` cannot be converted to `km/h`: they measure different \
         things; leave the unit out, or write one that converts to km/h",
        &["simulate", "pump-track", "--set", "speed=15kg"],
    ),
    (
        "has no form `law=other`; choose one of: law=paper, law=holding",
        &["simulate", "pump-track", "--set", "law=other"],
    ),
    (
        "unknown scene `Ski-Jump`; did you mean `ski-jump`?",
        &["simulate", "Ski-Jump"],
    ),
    (
        "start inside the ground (E08): gap `slope`",
        &["simulate", "ski-jump", "--set", "start_y=40"],
    ),
    ("from 1 to", &["simulate", "ski-jump", "--steps", "0"]),
    ("from 1 to", &["simulate", "ski-jump", "--steps", "1e3"]),
    (
        "at most 1000000: the states",
        &["simulate", "ski-jump", "--steps", "99999999999"],
    ),
    (
        "--steps 2000 of --elements 600 are 1200000 elements, more than 1000000",
        &[
            "simulate",
            "ski-jump",
            "--steps",
            "2000",
            "--elements",
            "600",
        ],
    ),
    ("from 1 to", &["simulate", "ski-jump", "--steps", "-3"]),
    ("from 1 to", &["simulate", "ski-jump", "--elements", "0"]),
    ("from 1 to 9", &["simulate", "ski-jump", "--stages", "10"]),
    ("from 1 to 9", &["simulate", "ski-jump", "--stages", "0"]),
    (
        "restitution of `floor` (E10) = 7: must be in 0..=1",
        &["explain", "bouncing-ball", "--set", "e=7"],
    ),
    (
        "coefficient of friction of `floor` (E10) = -1: must be at least 0",
        &["explain", "rough-ball", "--set", "mu=-1"],
    ),
    ("above 0", &["simulate", "ski-jump", "--horizon", "-1"]),
    (
        "give a finite time",
        &["simulate", "ski-jump", "--horizon", "nan"],
    ),
    (
        "'--horizon <TIME[UNIT]>'",
        &["simulate", "ski-jump", "--horizon", "soon"],
    ),
    (
        "give a time such as",
        &["simulate", "ski-jump", "--horizon", "3kg"],
    ),
    (
        "--steps has no meaning for --method event",
        &["simulate", "ski-jump", "--method", "event", "--steps", "30"],
    ),
    (
        "--scheme has no meaning for --method moreau",
        &[
            "simulate",
            "ski-jump",
            "--method",
            "moreau",
            "--scheme",
            "radau-iia",
        ],
    ),
    (
        "unknown scene `ski\\u{1b}[31m`",
        &["simulate", "ski\u{1b}[31m"],
    ),
    (
        "possible values: fesd, event",
        &["simulate", "ski-jump", "--method", "magic"],
    ),
    (
        "--width has no meaning for --method event",
        &["simulate", "ski-jump", "--method", "event", "--width", "3"],
    ),
    (
        "--elements and --tolerance exclude each other",
        &[
            "simulate",
            "ski-jump",
            "--elements",
            "2",
            "--tolerance",
            "1e-9",
        ],
    ),
    (
        "tolerance = 1",
        &["simulate", "ski-jump", "--tolerance", "1"],
    ),
    (
        "similar argument exists: '--steps'",
        &["simulate", "ski-jump", "--step", "3"],
    ),
    ("<SCENE>", &["simulate"]),
    ("unrecognized subcommand 'fly'", &["fly"]),
];

#[test]
fn bad_input_is_refused_in_one_line_and_leaves_no_file() {
    let scratch = Scratch::new("refused");
    let out = scratch.text();
    for (words, arguments) in REFUSED {
        let mut arguments = arguments.to_vec();
        if arguments[0] == "simulate" && arguments.len() > 1 {
            arguments.extend(["--out", out]);
        }
        let line = refused(&arguments);
        assert!(line.contains(words), "{arguments:?}: {line}");
        assert!(!Path::new(out).exists(), "{arguments:?} left {out}");
    }
    for arguments in [
        &["explain", "E99"] as &[&str],
        &["explain", "ski"],
        &["chart", "pump"],
        &["chart", "hills", "box", "--set", "m=2"],
        &["chart", "hills", "hills"],
        &["chart", "hills", "--horizon", "-1s"],
        &["solve", "ski-jump", "--set", "a=1"],
        &["solve", "pump-track", "--scheme", "radau-iia"],
        &["man", "fly"],
        &["completions", "dos"],
    ] {
        refused(arguments);
    }
}

#[test]
fn output_directory_that_cannot_be_written_is_refused_before_the_run() {
    let scratch = Scratch::new("file");
    std::fs::write(&scratch.0, "a file, not a directory").unwrap();
    let below = format!("{}/out", scratch.text());
    for arguments in [
        &["simulate", "ski-jump", "--out", &below] as &[&str],
        &["simulate", "ski-jump", "--out", scratch.text()],
        &["reproduce", "--out", &below],
        &["chart", "--out", &below],
    ] {
        let line = refused(arguments);
        assert!(line.contains("output directory"), "{line}");
        assert!(line.contains("give --out a directory"), "{line}");
    }
    assert_eq!(
        std::fs::read_to_string(&scratch.0).unwrap(),
        "a file, not a directory"
    );
    std::fs::remove_file(&scratch.0).unwrap();
}

#[test]
fn settings_that_would_do_nothing_are_refused_with_what_to_leave_out() {
    let complementarity = ["--formulation", "complementarity", "--steps", "20"];
    for (words, arguments) in [
        (
            "leave out one of the two",
            &["--tolerance", "1e-8"] as &[&str],
        ),
        ("which locates no take-off", &["--no-exit-condition"]),
    ] {
        let line = refused(&[&["simulate", "ski-jump"][..], &complementarity, arguments].concat());
        assert!(
            line.contains("has no meaning") && line.contains(words),
            "{line}"
        );
    }
    for arguments in [
        &["simulate", "ski-jump", "--rows", "5"] as &[&str],
        &["solve", "pump-track", "--rows", "5"],
        &["explain", "E07", "--set", "m=3"],
        &["explain", "E07", "--size", "--json"],
        &["explain", "syntax", "--size"],
    ] {
        let line = refused(arguments);
        assert!(
            line.contains("no meaning") && line.contains("leave"),
            "{arguments:?}: {line}"
        );
    }
}

#[test]
fn settings_are_checked_as_the_defaults_of_a_scene_are() {
    let scratch = Scratch::new("settings");
    std::fs::create_dir_all(&scratch.0).unwrap();
    let file = scratch.0.join("ball.hang");
    let text = "parameters { m: kg = 1, high: m = 1, most: N = 5, long: s = 1 }
        coordinates { x: m, z: m in -1..=10 }
        controls { u: N in -most..=most }
        lagrangian m/2*(dot(x)^2 + dot(z)^2)
        forces { x: u }
        minimize integral(u^2)
        finally { x == 1[m] }
        start { z: high }
        horizon long";
    std::fs::write(&file, text).unwrap();
    let file = file.to_str().unwrap();
    for (setting, words) in [
        (
            "high=20",
            "start of `z` = 20 m: must be within its bounds -1..=10",
        ),
        (
            "most=-5",
            "lower bound of `u` = 5 N: must be at most the upper one, -5",
        ),
        (
            "long=inf",
            "`long` = `inf` is not finite; give a finite number",
        ),
        ("long=NaN", "`long` = `NaN` is not finite"),
        ("long=1e400", "`long` = `1e400` is not finite"),
        (
            "long=1e300",
            "horizon = 1e300 s: must be from 1e-100 to 1e100",
        ),
        ("long=0", "horizon = 0 s: must be above 0"),
        (
            "long=1,5",
            "`1,5` is no number; write decimals behind a point",
        ),
        ("long=1 000", "`1 000` is no number"),
        ("m=0", "parameter `m` = 0 kg: must be above 0"),
        ("m=1[s]", "`s` cannot be converted to `kg`"),
    ] {
        for command in ["simulate", "solve"] {
            let line = refused(&[command, file, "--set", setting]);
            assert!(line.contains(words), "{command} {setting}: {line}");
        }
    }
    for (time, words) in [
        ("inf", "give a finite time above 0"),
        ("nan", "give a finite time above 0"),
        ("1e300", "horizon = 1e300 s: must be from 1e-100"),
    ] {
        let line = refused(&["simulate", file, "--horizon", time]);
        assert!(line.contains(words), "{time}: {line}");
    }
    let shown = solved(&[
        "simulate",
        file,
        "--set",
        "m=2000[g]",
        "--set",
        "most=1e-300",
    ]);
    assert!(
        shown.contains("m = 2 kg") && shown.contains("most = 1e-300 N"),
        "{shown}"
    );
    // What the defaults say is said at their place.
    let out = hangtime(&["explain", file, "--set", "high=-2m"]);
    assert_eq!(out.status.code(), Some(2));
}

#[cfg(unix)]
#[test]
fn limit_on_a_fine_grid_returns_the_motion_that_coarser_ones_led_to() {
    // Its first program takes seconds before it iterates.
    let arguments = [
        "solve",
        "pump-track",
        "--intervals",
        "10000",
        "--time-limit",
        "1500ms",
        "--json",
    ];
    let output = hangtime(&arguments);
    assert_eq!(output.status.code(), Some(3));
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["status"], "time_limit");
    assert!(document["iterations"]["programs"].as_u64().is_some());
}
