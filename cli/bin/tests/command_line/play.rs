//! The page on which scenes are written, and the calls behind it.
//!
//! The page itself is tested where the program has one, in `play_page`:
//! `cargo test --workspace --features play --test command_line play`.

use hangtime_cli::Calls;
use serde_json::{Value, json};

use crate::support::{Scratch, hangtime};

/// The text of a shipped scene.
pub(crate) fn text(scene: &str) -> &'static str {
    let texts = hangtime_models::scene_texts().iter();
    let compiled = texts.clone().find(|(name, _)| *name == scene);
    let listed = hangtime_models::scenes()
        .iter()
        .find(|listed| listed.name == scene);
    let unread = listed.and_then(|listed| listed.unread);
    compiled.map(|(_, text)| *text).or(unread).unwrap()
}

/// What the command prints for the file of a scene, whatever its exit status is.
pub(crate) fn printed(command: &str, scene: &str, text: &str, settings: &[&str]) -> String {
    let scratch = Scratch::new("play");
    let file = scratch.write(&format!("{scene}.hang"), text);
    hangtime(&format!("{command} {file} --json {}", settings.join(" "))).out
}

fn answer(request: &Value) -> String {
    Calls::default().answer(&request.to_string(), &mut |_, _| {})
}

/// A document without its times of computation.
fn timeless(document: &str) -> String {
    let (before, rest) = document.split_once("\"seconds\":{").unwrap();
    let (_, after) = rest.split_once('}').unwrap();
    let without = format!("{before}{after}");
    let parts = without.split("\"cpu\":").enumerate();
    let parts = parts.map(|(index, part)| match (index, part.split_once(',')) {
        (1.., Some((_, after))) => after,
        _ => part,
    });
    parts.collect()
}

#[test]
fn results_of_calls_are_those_of_the_commands_letter_by_letter() {
    let free: &[&str] = &[];
    for (call, scene, settings) in [
        ("simulate", "ski-jump", free),
        ("solve", "jump-on-sledge", free),
        (
            "simulate",
            "falling-rod",
            &["--set", "mu=0.3", "--set", "speed=2km/h"],
        ),
        (
            "simulate",
            "rough-ball",
            &["--method", "event", "--horizon", "500ms"],
        ),
        (
            "simulate",
            "stick-slip",
            &["--method", "moreau", "--steps", "300"],
        ),
        ("solve", "pump-track", &["--intervals", "6"]),
    ] {
        let request =
            json!({ "call": call, "name": scene, "text": text(scene), "settings": settings });
        let answer = answer(&request);
        let result = answer.strip_prefix("{\"result\":").unwrap();
        let (result, _) = result.split_once(",\"facts\":").unwrap();
        let printed = printed(call, scene, text(scene), settings);
        assert_eq!(
            timeless(result),
            timeless(printed.trim_end()),
            "{call} {scene}"
        );
    }
}

#[test]
fn mistakes_in_a_call_have_their_place_and_the_report_of_the_command() {
    let text = "// \u{1f600}\ncoordinates { z: m }\nlagrangian 1[kg]/2*dot(z)^2 - 1[N]*zz\n";
    let request = json!({ "call": "check", "name": "ball", "text": text });
    let answer: Value = serde_json::from_str(&answer(&request)).unwrap();
    let mistake = &answer["mistakes"][0];
    assert_eq!(mistake["code"], "E01");
    assert_eq!([&mistake["line"], &mistake["column"]], [3, 36]);
    // The face is two units of UTF-16: 5 + 1 in the first line, 21 in the second, 35 before the name.
    assert_eq!(mistake["place"], json!([62, 64]));
    let scratch = Scratch::new("play-mistake");
    let file = scratch.write("ball.hang", text);
    let stderr = hangtime(&format!("check {file}")).err;
    let report = answer["report"].as_str().unwrap();
    assert_eq!(stderr.trim_end().replace(&file, "ball.hang"), report);
}

#[test]
fn calls_that_cannot_be_answered_say_why_in_one_line() {
    let refusal = |request: &str| -> String {
        let answer = Calls::default().answer(request, &mut |_, _| {});
        let answer: Value = serde_json::from_str(&answer).unwrap();
        answer["refusal"].as_str().unwrap().to_owned()
    };
    let ask = |call: &str, settings: Value| {
        refusal(
            &json!({ "call": call, "name": "x", "text": text("ski-jump"), "settings": settings })
                .to_string(),
        )
    };
    assert!(refusal("{").starts_with("the request is not understood"));
    assert!(
        ask("simulat", json!([]))
            .starts_with("there is no call `simulat`; did you mean `simulate`?")
    );
    assert!(ask("simulate", json!(["--set", "mass=3"])).contains("has no parameter `mass`"));
    assert!(ask("simulate", json!(["--steps", "many"])).contains("give a whole number"));
    assert!(ask("solve", json!([])).contains("declares no objective"));
}

#[test]
fn scenes_to_choose_from_are_the_shipped_files() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/scenes");
    let files = std::fs::read_dir(folder).unwrap();
    let mut files: Vec<String> = files
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .collect();
    let texts = hangtime_models::scene_texts().iter();
    let mut listed: Vec<String> = texts.map(|(name, _)| format!("{name}.hang")).collect();
    files.sort();
    listed.sort();
    assert_eq!(listed, files);
}

#[test]
fn text_is_formatted_by_a_call() {
    let untidy = "coordinates{z:m}lagrangian 1[kg]/2*dot(z)^2";
    let request = json!({ "call": "fmt", "name": "x", "text": untidy });
    let formatted: Value = serde_json::from_str(&answer(&request)).unwrap();
    let scratch = Scratch::new("play-fmt");
    let file = scratch.write("x.hang", untidy);
    crate::support::solved(&format!("fmt {file}"));
    assert_eq!(formatted["text"], scratch.read("x.hang"));
    assert_ne!(formatted["text"], untidy);
}

#[test]
fn progress_of_a_call_is_told_while_it_runs() {
    let request = json!({ "call": "solve", "name": "pump-track", "text": text("pump-track"), "settings": ["--intervals", "6"] });
    let mut told = Vec::new();
    let _ = Calls::default().answer(&request.to_string(), &mut |share, doing| {
        told.push((share, doing.to_owned()))
    });
    // In words of the problem: no residual, no iteration.
    for (share, doing) in &told {
        assert!(share.is_none() && doing.contains(" motion"), "{doing}");
        let foreign = ["program", "iteration", "residual", "collocation"];
        assert!(!foreign.iter().any(|word| doing.contains(word)), "{doing}");
    }
    assert!(!told.is_empty());
}

#[test]
fn page_about_a_mistake_is_answered_and_one_that_is_not_there_refused() {
    let page = |code: &str| -> Value {
        let request = json!({ "call": "page", "name": code, "text": "" });
        serde_json::from_str(&answer(&request)).unwrap()
    };
    for code in ["E03", "e3", "syntax"] {
        let explained = hangtime(&format!("explain {code}")).out;
        let text = page(code)["text"].as_str().unwrap().to_owned();
        assert_eq!(text.trim_end(), explained.trim_end(), "{code}");
    }
    let refusal = page("E99")["refusal"].as_str().unwrap().to_owned();
    assert!(
        refusal.starts_with("there is no page about `E99`"),
        "{refusal}"
    );
}

#[test]
fn solve_that_may_start_from_the_last_plan_finds_the_optimum_of_one_from_nothing() {
    let mut calls = Calls::default();
    let mut solve = |warm: bool, speed: &str, text: &str| -> Value {
        let settings = ["--intervals", "6", "--set", speed];
        let request = json!({ "call": "solve", "name": "pump-track", "text": text, "settings": settings, "warm": warm });
        serde_json::from_str(&calls.answer(&request.to_string(), &mut |_, _| {})).unwrap()
    };
    let text = text("pump-track");
    // Nothing was solved before.
    assert_eq!(solve(true, "speed=15km/h", text)["warm"], false);
    let warm = solve(true, "speed=15.5km/h", text);
    let cold = solve(false, "speed=15.5km/h", text);
    assert_eq!(
        (&warm["warm"], &cold["warm"]),
        (&json!(true), &json!(false))
    );
    let objective = |answer: &Value| answer["result"]["objective"].as_f64().unwrap();
    assert_eq!(warm["result"]["status"], "solved");
    // Both are certified to the tolerance of the interior point method, 1e-8.
    assert!(
        (objective(&warm) - objective(&cold)).abs() < 1e-7,
        "{} {}",
        objective(&warm),
        objective(&cold)
    );
    // Less work, which is why it is asked for: no words are searched.
    let programs = |answer: &Value| {
        answer["result"]["iterations"]["interior_point"]
            .as_u64()
            .unwrap()
    };
    assert!(
        programs(&warm) < programs(&cold),
        "{} {}",
        programs(&warm),
        programs(&cold)
    );
    // Another text is another scene.
    assert_eq!(
        solve(true, "speed=15km/h", &format!("{text}\n"))["warm"],
        false
    );
}

#[test]
fn jumps_of_controls_and_velocities_have_a_frame_to_either_side() {
    let settings = ["--intervals", "6"];
    let request = json!({ "call": "solve", "name": "pump-track", "text": text("pump-track"), "settings": settings });
    let answer: Value = serde_json::from_str(&answer(&request)).unwrap();
    let motion = &answer["motion"];
    let column = |values: &Value| -> Vec<f64> {
        values
            .as_array()
            .unwrap()
            .iter()
            .map(|v| v.as_f64().unwrap())
            .collect()
    };
    let time = column(&motion["time"]);
    let readings = motion["readings"].as_array().unwrap().iter();
    let control = readings
        .clone()
        .find(|reading| reading["name"] == "u")
        .unwrap();
    let u = column(&control["values"]);
    assert!(time.is_sorted());
    let changes: Vec<usize> = (1..u.len()).filter(|&k| u[k] != u[k - 1]).collect();
    // Constant on each interval: it changes where two frames have the same time, at ends of intervals, and nowhere else.
    assert!(
        !changes.is_empty() && changes.len() <= 5,
        "{}",
        changes.len()
    );
    let interval = time.last().unwrap() / 6.0;
    for k in changes {
        assert_eq!(time[k], time[k - 1]);
        let nodes = time[k] / interval;
        assert!((nodes - nodes.round()).abs() < 1e-9, "{nodes}");
    }
}

#[cfg(not(feature = "play"))]
#[test]
fn program_without_its_page_says_how_to_build_it() {
    let refusal = crate::support::refused("play");
    assert!(refusal.contains("--features play"), "{refusal}");
}

/// What a script prints in node, line by line as JSON; `None` where there is no node.
fn node(script: &str) -> Option<Vec<Value>> {
    let scratch = Scratch::new("play-script");
    let file = scratch.write("run.mjs", script);
    let Ok(run) = std::process::Command::new("node").arg(&file).output() else {
        eprintln!("skipped: no node found, which runs the scripts of the page without a browser");
        return None;
    };
    let errors = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{errors}");
    let lines = String::from_utf8(run.stdout).unwrap();
    let lines = lines
        .lines()
        .map(|line| serde_json::from_str(line).unwrap());
    Some(lines.collect())
}

#[test]
fn links_that_the_book_makes_are_read_by_the_page_and_others_refused() {
    let text = "// a scene with \u{e4}, \u{1f600} and \"quotes\"\ncoordinates { z: m }\n";
    let script = format!(
        "{}\n{}\n
const read = (hash) => unpackLink(hash).then((scene) => console.log(JSON.stringify(scene)), (error) => console.log(JSON.stringify(error.name)));
await read({});
await read(await packLink({{ name: 'own', text: {text:?}, values: {{ m: 2 }} }}));
const {{ deflateRawSync }} = await import('node:zlib');
await read('#scene=' + deflateRawSync(Buffer.alloc(5e6)).toString('base64url'));
await read('#scene=' + 'A'.repeat(2e6));
await read('#scene=AAAA');
await read('#scene=' + deflateRawSync(Buffer.from('[1]')).toString('base64url'));
await read('#elsewhere');
",
        include_str!("../../../src/play/store.js"),
        include_str!("../../../src/play/links.js"),
        json!(format!("#{}", hangtime_book::fragment("ball", text))),
    );
    let Some(read) = node(&script) else { return };
    assert_eq!(
        read,
        [
            json!({ "name": "ball", "text": text, "values": {} }),
            json!({ "name": "own", "text": text, "values": { "m": 2 } }),
            json!("RangeError"),
            json!("RangeError"),
            json!("SyntaxError"),
            json!("SyntaxError"),
            json!(null),
        ]
    );
}

#[test]
fn steps_of_a_scene_are_what_was_typed_without_a_pause() {
    let script = format!(
        "{}
const past = new Past('a');
past.note('ab', 0); past.note('abc', 500); past.note('abcd', 2000);
const seen = [past.go(1), past.go(-1), past.go(-1), past.go(-1), past.go(1)];
past.note('x', 9000);
seen.push(past.has(1), past.has(-1), past.go(-1));
console.log(JSON.stringify(seen));
const taken = (name) => ['ball', 'ball-2'].includes(name);
console.log(JSON.stringify([freeName('ball', taken), freeName('cart', taken), cleanName(' ../a b.hang'), cleanName('\u{fc}')]));
",
        include_str!("../../../src/play/store.js")
    );
    let Some(lines) = node(&script) else { return };
    // Nothing lies ahead; then the steps back, the end, and one forward; a new text ends what was ahead.
    assert_eq!(
        lines[0],
        json!([null, "abc", "a", null, "abc", false, true, "abc"])
    );
    assert_eq!(lines[1], json!(["ball-3", "cart", "a-b", ""]));
}
