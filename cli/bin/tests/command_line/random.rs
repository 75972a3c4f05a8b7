//! Random command lines: whatever is asked for, the program ends by itself with status 0, 2 or 3, within 2 GB of address
//! space and 60 s of CPU time, and complains in short lines.
//!
//! A small set with a fixed seed runs with the other tests. For more:
//! `HANGTIME_RANDOM_LINES=5000 HANGTIME_RANDOM_SEED=2 cargo test --release --workspace --test command_line random`,
//! and `HANGTIME_MUTATED_PROGRAMS=2000` for `.nl` files with mistakes.

#![cfg(unix)]

use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

use crate::nlp::file as program;
use crate::support::{Random, Scratch, json};

/// Lines unless the environment asks for others: some seconds in the development profile.
const LINES: u64 = 40;
/// Longest line on the standard error stream: what the messages are cut to, and `error: `.
const LONGEST: usize = 900;

/// Numbers and texts that nobody means.
const ODD: [&str; 16] = [
    "",
    "0",
    "-1",
    "-0",
    "NaN",
    "-inf",
    "1e999",
    "5e-324",
    "1e300",
    "99999999999999999999",
    "0x10",
    "1,5",
    "3 apples",
    "\u{1b}[2J\u{7}",
    "\u{202e}m",
    "((((((((((((((((((((((((((((((((((",
];

fn number(random: &mut Random, most: f64) -> String {
    if random.chance(0.1) {
        random.pick(&ODD).to_owned()
    } else {
        (most.powf(random.share()) as u64).to_string()
    }
}

fn quantity(random: &mut Random, usual: f64) -> String {
    if random.chance(0.1) {
        return random.pick(&ODD).to_owned();
    }
    format!(
        "{}{}",
        random.around(usual),
        random.pick(&["", "", "", "s", "ms", "m"])
    )
}

fn settings(random: &mut Random, scene: &Value, line: &mut Vec<String>) {
    for parameter in scene["parameters"].as_array().unwrap() {
        if random.chance(0.6) {
            continue;
        }
        let name = parameter["name"].as_str().unwrap();
        let value = if random.chance(0.05) {
            random.pick(&ODD).to_owned()
        } else {
            random
                .around(parameter["default"].as_f64().unwrap())
                .to_string()
        };
        line.extend(["--set".to_owned(), format!("{name}={value}")]);
    }
    if random.chance(0.03) {
        let long = "x".repeat(4000);
        line.extend(["--set".to_owned(), format!("{long}={long}")]);
    }
}

fn simulate(random: &mut Random, line: &mut Vec<String>) {
    let method = random.pick(&["fesd", "fesd", "event", "moreau", "smooth", "fixed"]);
    line.extend(["--method", method].map(str::to_owned));
    let mut option = |random: &mut Random, share: f64, name: &str, value: String| {
        if random.chance(share) {
            line.extend([name.to_owned(), value]);
        }
    };
    let stepped = if matches!(method, "fesd" | "moreau" | "fixed") {
        0.5
    } else {
        0.02
    };
    let steps = number(random, 3e6);
    option(random, stepped, "--steps", steps);
    let elements = if method == "fesd" { 0.2 } else { 0.02 };
    let count = number(random, 2e3);
    option(random, elements, "--elements", count);
    let count = number(random, 12.0);
    option(random, elements, "--stages", count);
    let scheme = random
        .pick(&["radau-iia", "gauss-legendre", "euler"])
        .to_owned();
    option(random, elements, "--scheme", scheme);
    let tolerance = random.around(1e-6).to_string();
    option(random, 0.1, "--tolerance", tolerance);
    let formulation = random.pick(&["active-set", "time-freezing"]).to_owned();
    option(random, elements / 2.0, "--formulation", formulation);
    let horizon = quantity(random, 2.0);
    option(random, 0.4, "--horizon", horizon);
    let rows = number(random, 1e6);
    option(random, 0.2, "--rows", rows);
    let wide = if method == "smooth" { 0.5 } else { 0.02 };
    let width = random.around(1e-2).to_string();
    option(random, wide, "--width", width);
    if random.chance(0.03) {
        line.push("--no-exit-condition".to_owned());
    }
}

fn solve(random: &mut Random, line: &mut Vec<String>) {
    let formulation = random.pick(&["auto", "auto", "time-freezing"]);
    let controls = random.pick(&["constant", "linear"]);
    line.extend(["--formulation", formulation, "--controls", controls].map(str::to_owned));
    for (name, most) in [
        ("--intervals", 2e4),
        ("--elements", 2e3),
        ("--stages", 12.0),
        ("--starts", 2e3),
    ] {
        if random.chance(0.3) {
            let count = number(random, most);
            line.extend([name.to_owned(), count]);
        }
    }
}

/// A program from `nlp` with some bytes cut, changed, or put in.
fn mutated(random: &mut Random) -> Vec<u8> {
    let bounds = ["2 0", "2 0", "3", "1 1"];
    let (s, x, y) = (
        random.around(1.0),
        random.pick(&bounds),
        random.pick(&bounds),
    );
    let mut bytes = program(s, x, y).into_bytes();
    let pieces = [
        "9",
        "-",
        "\n",
        "o",
        "v",
        "n1e308\n",
        "4294967295",
        "\u{1b}[2J",
        "b",
        "C1\n",
        "#",
    ];
    for _ in 0..random.bits() % 3 {
        let at = random.bits() as usize % bytes.len().max(1);
        match random.bits() % 5 {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..(at + 1).min(bytes.len()))),
            2 if at < bytes.len() => bytes[at] ^= 1 << (random.bits() % 8),
            3 if at < bytes.len() => bytes[at] = random.bits() as u8,
            _ => drop(bytes.splice(at..at, random.pick(&pieces).bytes())),
        }
    }
    bytes
}

/// `nlp` of a file in `folder`, which is written.
fn nlp(random: &mut Random, folder: &Path, line: &mut Vec<String>) {
    let names = [
        "a.nl",
        "b c.nl",
        "\u{1b}[2J\u{9b}31m.nl",
        "no ending",
        "\n.nl",
    ];
    let path = folder.join(random.pick(&names));
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(&path, mutated(random)).unwrap();
    for ending in ["col", "row"] {
        let text = random.pick(&["", "x\ny\n", "\u{1b}[31m\n\u{202e}\n", "\n\n\n\n\n"]);
        std::fs::write(path.with_extension(ending), text).unwrap();
    }
    line.push(path.to_str().unwrap().to_owned());
    if random.chance(0.1) {
        let sol = random.pick(&["a.sol", "no/such/a.sol", "a.nl", "", "..", "\u{7}"]);
        line.extend([
            "--sol".to_owned(),
            folder.join(sol).to_str().unwrap().to_owned(),
        ]);
    }
}

/// Limits, directories, and other options that several commands have.
fn shared(random: &mut Random, command: &str, out: &str, line: &mut Vec<String>) {
    let runs = ["simulate", "solve", "chart", "reproduce", "nlp"].contains(&command);
    let mut option = |name: &str, value: &str| line.extend([name, value].map(str::to_owned));
    if runs && random.chance(0.97) {
        option("--time-limit", random.pick(&["1s", "200ms", "50ms"]));
    } else if runs {
        option(
            "--time-limit",
            random.pick(&["0", "-1s", "1e-300", "NaN", "1s 1s"]),
        );
    }
    if runs && random.chance(0.1) {
        option(
            "--memory-limit",
            random.pick(&["0.001", "0.05", "1", "1e9", "-0", "GB"]),
        );
    }
    let wants = matches!(command, "chart" | "reproduce");
    if wants || (matches!(command, "simulate" | "solve") && random.chance(0.3)) {
        let steering = format!("{out}\u{1b}[31m/\u{7}");
        let odd = ["/dev/null", "/proc/no", "", &steering];
        let odd = random.pick(&odd);
        option("--out", if random.chance(0.1) { odd } else { out });
    }
    if matches!(command, "simulate" | "solve" | "list" | "nlp") && random.chance(0.4) {
        line.push("--json".to_owned());
    }
    if random.chance(0.02) {
        line.push(
            random
                .pick(&["--help", "--version", "--jsn", "--", "\u{7}", "-v"])
                .to_owned(),
        );
    }
}

/// One line; files go to `out`, and those to read are in `folder`.
fn line(random: &mut Random, scenes: &[Value], out: &str, folder: &Path) -> Vec<String> {
    let command = random.pick(&[
        "simulate",
        "simulate",
        "simulate",
        "simulate",
        "solve",
        "solve",
        "nlp",
        "nlp",
        "explain",
        "explain",
        "list",
        "chart",
        "reproduce",
        "fly",
        "man",
        "completions",
    ]);
    let mut line = vec![command.to_owned()];
    let scene = &scenes[random.bits() as usize % scenes.len()];
    match command {
        "list" | "reproduce" => {}
        "nlp" => nlp(random, folder, &mut line),
        "man" => line.push(random.pick(&["solve", "simulate", "nlp", "fly"]).to_owned()),
        "completions" => line.push(random.pick(&["bash", "zsh", "fish", "dos"]).to_owned()),
        "explain" if random.chance(0.4) => {
            let code = number(random, 40.0);
            line.push(random.pick(&["E", "e0", "", "E-"]).to_owned() + &code);
        }
        _ if random.chance(0.03) => line.push(random.pick(&ODD).to_owned()),
        _ => line.push(scene["name"].as_str().unwrap().to_owned()),
    }
    if matches!(command, "simulate" | "solve" | "explain" | "chart") {
        settings(random, scene, &mut line);
    }
    match command {
        "simulate" => simulate(random, &mut line),
        "solve" => solve(random, &mut line),
        _ => {}
    }
    shared(random, command, out, &mut line);
    line
}

/// Runs the program within the limits.
fn bounded(line: &[String]) -> Output {
    Command::new("sh")
        .args(["-c", "ulimit -v 2000000; ulimit -t 60; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_hangtime"))
        .args(line)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

fn from_environment(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().expect("a whole number"))
}

/// The status of a line, of which everything that is asked of all lines holds.
fn checked(line: &[String]) -> usize {
    let output = bounded(line);
    let stderr = String::from_utf8_lossy(&output.stderr);
    let Some(status @ (0 | 2 | 3)) = output.status.code() else {
        panic!("hangtime {line:?}: {:?}: {stderr}", output.status);
    };
    for complaint in stderr.lines() {
        let length = complaint.chars().count();
        assert!(
            complaint.starts_with("error: ") && length < LONGEST,
            "hangtime {line:?}: {length} characters: {complaint}"
        );
        assert!(
            !complaint.contains(char::is_control),
            "hangtime {line:?}: {complaint:?}"
        );
    }
    let stdout = String::from_utf8(output.stdout).unwrap();
    let steers = |c: char| c.is_control() && c != '\n' && c != '\t';
    assert!(!stdout.contains(steers), "hangtime {line:?}: {stdout:?}");
    let document = stdout
        .starts_with('{')
        .then(|| serde_json::from_str::<Value>(&stdout));
    assert!(
        document.is_none_or(|document| document.is_ok()),
        "hangtime {line:?}: {stdout}"
    );
    status as usize
}

#[test]
fn random_command_lines_end_with_status_0_2_or_3() {
    let scratch = Scratch::new("random");
    let out = format!("{}/out", scratch.text());
    let files = Scratch::new("random-files");
    let scenes = json("list --json")["scenes"].take();
    let scenes = scenes.as_array().unwrap();
    let mut random = Random(from_environment("HANGTIME_RANDOM_SEED", 1));
    let mut statuses = [0; 4];
    for _ in 0..from_environment("HANGTIME_RANDOM_LINES", LINES) {
        let line = line(&mut random, scenes, &out, &files.0);
        statuses[checked(&line)] += 1;
    }
    println!(
        "status 0, 2, 3: {}, {}, {}",
        statuses[0], statuses[2], statuses[3]
    );
    // The lines are such that most of the program is reached.
    assert!(statuses[0] > 0 && statuses[2] > 0, "{statuses:?}");
}

#[test]
fn mutated_programs_end_with_status_0_2_or_3() {
    let files = Scratch::new("mutated");
    let mut random = Random(from_environment("HANGTIME_RANDOM_SEED", 1));
    let mut statuses = [0; 4];
    for _ in 0..from_environment("HANGTIME_MUTATED_PROGRAMS", LINES) {
        let mut line = vec!["nlp".to_owned()];
        nlp(&mut random, &files.0, &mut line);
        line.extend(["--time-limit", "1s"].map(str::to_owned));
        statuses[checked(&line)] += 1;
    }
    println!(
        "status 0, 2, 3: {}, {}, {}",
        statuses[0], statuses[2], statuses[3]
    );
    assert!(statuses[0] > 0 && statuses[2] > 0, "{statuses:?}");
}
