//! Random command lines: whatever is asked for, the program ends by itself with status 0, 2 or 3, within 2 GB of address
//! space and 60 s of CPU time, and complains in short lines.
//!
//! A small set with a fixed seed runs with the other tests. For more:
//! `HANGTIME_RANDOM_LINES=5000 HANGTIME_RANDOM_SEED=2 cargo test --release -p hangtime-bin random`.

#![cfg(unix)]

use std::process::{Command, Output, Stdio};

use serde_json::Value;

use crate::support::{Scratch, json};

/// Lines unless the environment asks for others: some seconds in the development profile.
const LINES: u64 = 40;
/// Longest line on the standard error stream: what the messages are cut to, and `error: `.
const LONGEST: usize = 900;

/// Numbers from a seed (splitmix64).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In 0..1.
    fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn chance(&mut self, share: f64) -> bool {
        self.share() < share
    }

    fn pick<'a, T: ?Sized>(&mut self, choices: &[&'a T]) -> &'a T {
        choices[self.bits() as usize % choices.len()]
    }

    /// Log-uniform over six decades around a value.
    fn around(&mut self, value: f64) -> f64 {
        let factor = 10_f64.powf(6.0 * self.share() - 3.0);
        if value == 0.0 { factor } else { value * factor }
    }
}

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

/// One line; files go to `out`.
fn line(random: &mut Random, scenes: &[Value], out: &str) -> Vec<String> {
    let command = random.pick(&[
        "simulate",
        "simulate",
        "simulate",
        "simulate",
        "solve",
        "solve",
        "explain",
        "list",
        "chart",
        "fly",
        "man",
        "completions",
    ]);
    let mut line = vec![command.to_owned()];
    let scene = &scenes[random.bits() as usize % scenes.len()];
    match command {
        "list" => {}
        "man" => line.push(random.pick(&["solve", "simulate", "fly"]).to_owned()),
        "completions" => line.push(random.pick(&["bash", "zsh", "dos"]).to_owned()),
        _ if random.chance(0.03) => line.push(random.pick(&ODD).to_owned()),
        _ => line.push(scene["name"].as_str().unwrap().to_owned()),
    }
    if matches!(command, "simulate" | "solve" | "explain") {
        settings(random, scene, &mut line);
    }
    match command {
        "simulate" => simulate(random, &mut line),
        "solve" => solve(random, &mut line),
        _ => {}
    }
    if matches!(command, "simulate" | "solve" | "chart") {
        line.extend(["--time-limit".to_owned(), "1s".to_owned()]);
        if command == "chart" || random.chance(0.3) {
            line.extend(["--out".to_owned(), out.to_owned()]);
        }
    }
    if matches!(command, "simulate" | "solve" | "list") && random.chance(0.4) {
        line.push("--json".to_owned());
    }
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

#[test]
fn random_command_lines_end_with_status_0_2_or_3() {
    let scratch = Scratch::new("random");
    let scenes = json(&["list", "--json"])["scenes"].take();
    let scenes = scenes.as_array().unwrap();
    let mut random = Random(from_environment("HANGTIME_RANDOM_SEED", 1));
    let mut statuses = [0; 4];
    for _ in 0..from_environment("HANGTIME_RANDOM_LINES", LINES) {
        let line = line(&mut random, scenes, scratch.text());
        let output = bounded(&line);
        let stderr = String::from_utf8_lossy(&output.stderr);
        let status = output.status.code();
        assert!(
            matches!(status, Some(0 | 2 | 3)),
            "hangtime {line:?}: {:?}: {stderr}",
            output.status
        );
        statuses[status.unwrap() as usize] += 1;
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
    }
    println!(
        "status 0, 2, 3: {}, {}, {}",
        statuses[0], statuses[2], statuses[3]
    );
    // The lines are such that most of the program is reached.
    assert!(statuses[0] > 0 && statuses[2] > 0, "{statuses:?}");
}
