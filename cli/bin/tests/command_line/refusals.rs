//! Bad input: what is said of it, word by word, stands in a snapshot.

use std::fmt::Write as _;

use crate::nlp::file as program;
use crate::support::{Scratch, refused, solved, unsolved};

/// Lines that are refused in a folder with [`FILES`].
const REFUSED: &str = "
    simulate
    simulate ski-jmp
    simulate Ski-Jump
    simulate ski\u{1b}[31m
    simulate thrwn
    simulate nowhere.hang
    simulate ski-jump --set starty=8
    simulate ski-jump --set m=-80
    simulate ski-jump --set m=0
    simulate ski-jump --set g=NaN
    simulate ski-jump --set g=inf
    simulate ski-jump --set g=1e999
    simulate ski-jump --set start_y=8s
    simulate ski-jump --set start_y=40
    simulate ski-jump --set m=1 --set m=2
    simulate ski-jump --set m
    simulate ski-jump --set m=
    simulate pump-track --set speed=15kg
    simulate pump-track --set law=other
    simulate ski-jump --steps 0
    simulate ski-jump --steps 1e3
    simulate ski-jump --steps 99999999999
    simulate ski-jump --steps -3
    simulate ski-jump --step 3
    simulate ski-jump --steps 2000 --elements 600
    simulate ski-jump --elements 0
    simulate ski-jump --elements 2 --tolerance 1e-9
    simulate ski-jump --stages 10
    simulate ski-jump --stages 0
    simulate ski-jump --horizon -1
    simulate ski-jump --horizon nan
    simulate ski-jump --horizon soon
    simulate ski-jump --horizon 3kg
    simulate ski-jump --method event --steps 30
    simulate ski-jump --method event --width 3
    simulate ski-jump --method moreau --scheme radau-iia
    simulate ski-jump --method magic
    simulate ski-jump --tolerance 1
    simulate ski-jump --no-exit-condition --steps 20 --tolerance 1e-8
    simulate incline --watch
    simulate ball.hang --horizon inf
    simulate ball.hang --horizon 1e300
    simulate rod.hang --method smooth
    simulate bouncing-ball --gradient-of z
    simulate bouncing-ball --gradient e --gradient-of height
    simulate bouncing-ball --gradient springiness
    simulate bouncing-ball --gradient e --method moreau
    solve ski-jump
    solve ski-jump --set a=1
    solve pump-track --scheme radau-iia
    solve pump-track --stages 12
    solve ball.hang --horizon -1
    solve ramp.hang --gradient angle
    solve ramp.hang --set angle=0.6 --gradient mu
    solve fitted.hang
    solve fitted.hang --intervals 3
    solve whole.hang --set e=0.7
    solve lost.hang
    explain bouncing-ball --set e=7
    explain rough-ball --set mu=-1
    explain ball.hang --set high=-2m
    explain E99
    explain ski
    explain E07 --set m=3
    explain E07 --size --json
    explain syntax --size
    list --group leg
    chart pump
    chart hills box --set m=2
    chart hills hills
    chart hills --horizon -1s
    check ski-jump
    check bytes.hang
    fmt hills
    fmt --check ball.hang
    new ../ride
    nlp cut.nl
    nlp short.nl
    nlp missing.nl
    nlp .
    missing -AMPL
    sweep ball.hang --over high=1,2 --what solve --over high=1,2 --out t.csv
    sweep ball.hang --over high=1,2 --record final.y --out t.csv
    sweep ball.hang --over high=1,2 --shard 5/4 --out t.csv
    sweep ball.hang --over high=1,2 --warm --out t.csv
    sweep ball.hang --over high=1,2 --what solve --warm=1 --out t.csv
    sweep ball.hang --over high=1,2 --out no/t.csv
    sweep rod.hang --over l=1,2 --what solve --out t.csv
    sweep pump-track --what solve --warm --over speed=4,5 --over law=holding --out t.csv
    sweep --out t.csv
    man fly
    completions dos
    fly
";
/// Settings that are refused by whatever command reads `ball.hang`.
const SETTINGS: &str =
    "high=20 most=-5 long=inf long=NaN long=1e400 long=1e300 long=0 long=1,5 m=0 m=1[s]";
/// Scenes and data, by name.
const FILES: [(&str, &str); 8] = [
    (
        "ball.hang",
        "parameters { m: kg = 1, high: m = 1, most: N = 5, long: s = 1 } coordinates { x: m, z: m in -1..=10 } \
         controls { u: N in -most..=most } lagrangian m/2*(dot(x)^2 + dot(z)^2) forces { x: u } \
         minimize integral(u^2) finally { x == 1[m] } start { z: high } horizon long",
    ),
    ("rod.hang", crate::joints::ROD),
    ("ramp.hang", crate::design::RAMP),
    ("fitted.hang", crate::fit::DROP),
    ("drop.csv", "t [s], z [m]\n0.1, 0.95\n0.2, o.8\n"),
    ("whole.csv", "t [s], z [m]\n0.1, 0.95\n0.2, 0.8\n"),
    ("cut.nl", ""),
    ("short.nl", ""),
];

/// What a line is refused with; lists of scenes grow.
fn refusal(folder: &Scratch, line: &str) -> String {
    let said = folder.run(line);
    assert_eq!(
        (said.status, &*said.out),
        (Some(2), ""),
        "{line}: {}",
        said.err
    );
    let error = said.err.strip_prefix("error: ").unwrap_or_default();
    assert_eq!(error.matches('\n').count(), 1, "{line}: {}", said.err);
    let (words, _) = error
        .split_once(" (scenes: ")
        .unwrap_or((error.trim_end(), ""));
    words.to_owned()
}

// Systems say in words of their own that there is no file.
#[cfg(target_os = "linux")]
#[test]
fn bad_input_is_refused_in_one_line_and_leaves_no_file() {
    let folder = Scratch::new("refused");
    for (name, text) in FILES {
        folder.write(name, text);
    }
    let whole = program(0.0, "2 0", "3");
    folder.write("cut.nl", &whole[..120]);
    folder.write("short.nl", whole[..whole.len() - 2].trim_end());
    folder.write(
        "lost.hang",
        crate::fit::DROP.replace("drop.csv", "lost.csv"),
    );
    folder.write(
        "whole.hang",
        crate::fit::DROP.replace("drop.csv", "whole.csv"),
    );
    folder.write("bytes.hang", [0xff, 0xfe]);
    let names = folder.names();
    let settings = SETTINGS.split(' ').flat_map(|setting| {
        ["simulate", "solve"].map(|command| format!("{command} ball.hang --set {setting}"))
    });
    let lines = REFUSED
        .lines()
        .map(|line| line.trim().to_owned())
        .chain(settings);
    let mut all = String::new();
    for mut line in lines.filter(|line| !line.is_empty()) {
        let _ = writeln!(
            all,
            "{}\n  {}",
            line.escape_debug(),
            refusal(&folder, &line)
        );
        if line.starts_with("simulate ") {
            line += " --out out";
            refusal(&folder, &line);
        }
        assert_eq!(folder.names(), names, "{line}");
    }
    insta::assert_snapshot!(all);
    let spaced = vec!["simulate", "ski-jump", "--set", "m=1 000"];
    assert!(refused(spaced).contains("`1 000` is no number"));
    for nothing in ["simulate ski-jump --rows 5", "solve pump-track --rows 5"] {
        assert!(refused(nothing).contains("--rows has no meaning without --json or --out"));
    }
    let file = format!("{}/ball.hang", folder.text());
    let shown = solved(&format!(
        "simulate {file} --set m=2000[g] --set most=1e-300"
    ));
    assert!(
        shown.contains("m = 2 kg") && shown.contains("most = 1e-300 N"),
        "{shown}"
    );
}

#[test]
fn output_directory_that_cannot_be_written_is_refused_before_the_run() {
    let folder = Scratch::new("file");
    let file = folder.write("file", "a file, not a directory");
    for line in ["simulate ski-jump", "reproduce", "chart"] {
        for out in [&file, &format!("{file}/out")] {
            let line = refused(&format!("{line} --out {out}"));
            assert!(line.contains("output directory"), "{line}");
            assert!(line.contains("give --out a directory"), "{line}");
        }
    }
    assert_eq!(folder.read("file"), "a file, not a directory");
}

#[cfg(unix)]
#[test]
fn limit_on_a_fine_grid_returns_the_motion_that_coarser_ones_led_to() {
    // Its first program takes seconds before it iterates.
    let (document, _) = unsolved("solve pump-track --intervals 10000 --time-limit 1500ms --json");
    assert_eq!(document["status"], "time_limit");
    assert!(document["iterations"]["programs"].as_u64().is_some());
}
