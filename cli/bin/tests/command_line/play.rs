//! The page on which scenes are written, and the calls behind it.
//!
//! The page itself is tested where the program has one:
//! `cargo test --workspace --features play --test command_line play`.

use hangtime_cli::Calls;
use serde_json::{Value, json};

use crate::support::{Scratch, hangtime};

/// The text of a shipped scene.
fn text(scene: &str) -> &'static str {
    let texts = hangtime_models::scene_texts().iter();
    texts.clone().find(|(name, _)| *name == scene).unwrap().1
}

/// What the command prints for the file of a scene, whatever its exit status is.
fn printed(command: &str, scene: &str, text: &str, settings: &[&str]) -> String {
    let scratch = Scratch::new("play");
    std::fs::create_dir_all(&scratch.0).unwrap();
    let file = scratch.0.join(format!("{scene}.hang"));
    std::fs::write(&file, text).unwrap();
    let mut arguments = vec![command, file.to_str().unwrap(), "--json"];
    arguments.extend(settings);
    String::from_utf8(hangtime(&arguments).stdout).unwrap()
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
    std::fs::create_dir_all(&scratch.0).unwrap();
    let file = scratch.0.join("ball.hang");
    std::fs::write(&file, text).unwrap();
    let file = file.to_str().unwrap();
    let stderr = String::from_utf8(hangtime(&["check", file]).stderr).unwrap();
    let report = answer["report"].as_str().unwrap();
    assert_eq!(stderr.trim_end().replace(file, "ball.hang"), report);
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
    std::fs::create_dir_all(&scratch.0).unwrap();
    let file = scratch.0.join("x.hang");
    std::fs::write(&file, untidy).unwrap();
    crate::support::solved(&["fmt", file.to_str().unwrap()]);
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
        let explained = hangtime(&["explain", code]).stdout;
        let text = page(code)["text"].as_str().unwrap().to_owned();
        assert_eq!(text.trim_end(), String::from_utf8(explained).unwrap().trim_end(), "{code}");
    }
    let refusal = page("E99")["refusal"].as_str().unwrap().to_owned();
    assert!(refusal.starts_with("there is no page about `E99`"), "{refusal}");
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
    assert_eq!((&warm["warm"], &cold["warm"]), (&json!(true), &json!(false)));
    let objective = |answer: &Value| answer["result"]["objective"].as_f64().unwrap();
    assert_eq!(warm["result"]["status"], "solved");
    // Both are certified to the tolerance of the interior point method, 1e-8.
    assert!((objective(&warm) - objective(&cold)).abs() < 1e-7, "{} {}", objective(&warm), objective(&cold));
    // Less work, which is why it is asked for: no words are searched.
    let programs = |answer: &Value| answer["result"]["iterations"]["interior_point"].as_u64().unwrap();
    assert!(programs(&warm) < programs(&cold), "{} {}", programs(&warm), programs(&cold));
    // Another text is another scene.
    assert_eq!(solve(true, "speed=15km/h", &format!("{text}\n"))["warm"], false);
}

#[test]
fn jumps_of_controls_and_velocities_have_a_frame_to_either_side() {
    let settings = ["--intervals", "6"];
    let request = json!({ "call": "solve", "name": "pump-track", "text": text("pump-track"), "settings": settings });
    let answer: Value = serde_json::from_str(&answer(&request)).unwrap();
    let motion = &answer["motion"];
    let column = |values: &Value| -> Vec<f64> { values.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
    let time = column(&motion["time"]);
    let readings = motion["readings"].as_array().unwrap().iter();
    let control = readings.clone().find(|reading| reading["name"] == "u").unwrap();
    let u = column(&control["values"]);
    assert!(time.is_sorted());
    let changes: Vec<usize> = (1..u.len()).filter(|&k| u[k] != u[k - 1]).collect();
    // Constant on each interval: it changes where two frames have the same time, at ends of intervals, and nowhere else.
    assert!(!changes.is_empty() && changes.len() <= 5, "{}", changes.len());
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
    let refusal = crate::support::refused(&["play"]);
    assert!(refusal.contains("--features play"), "{refusal}");
}

#[cfg(feature = "play")]
mod page {
    use std::process::Command;

    use serde_json::{Value, json};

    use super::{printed, text};
    use crate::browser::{Origin, browser, visit};
    use crate::support::{Scratch, solved};

    /// Largest difference of a number in the module, which has its own sine and cosine, from that of this machine,
    /// relative to the largest values.
    const SAME: f64 = 1e-9;
    /// Files with mistakes that the module answers, unless the environment asks for more.
    const MUTATED: u64 = 300;

    /// The page, in a folder of its own.
    fn page(arguments: &[&str]) -> (Scratch, String) {
        let scratch = Scratch::new("play-page");
        let mut all = vec!["play"];
        all.extend(arguments);
        all.extend(["--out", scratch.text()]);
        solved(&all);
        let page = scratch.read("play.html");
        (scratch, page)
    }

    /// Whether numbers agree wherever they stand in two documents, and everything else is equal.
    fn assert_same(one: &Value, other: &Value, place: &str) {
        match (one, other) {
            (Value::Array(one), Value::Array(other)) => {
                assert_eq!(one.len(), other.len(), "{place}");
                for (index, (one, other)) in one.iter().zip(other).enumerate() {
                    assert_same(one, other, &format!("{place}[{index}]"));
                }
            }
            (Value::Object(one), Value::Object(other)) => {
                assert!(one.keys().eq(other.keys()), "{place}");
                for ((name, one), other) in one.iter().zip(other.values()) {
                    assert_same(one, other, &format!("{place}.{name}"));
                }
            }
            (Value::Number(one), Value::Number(other)) => {
                let [one, other] = [one, other].map(|number| number.as_f64().unwrap());
                let size = one.abs().max(other.abs()).max(1.0);
                assert!((one - other).abs() <= SAME * size, "{place}: {one} {other}");
            }
            _ => assert_eq!(one, other, "{place}"),
        }
    }

    /// The parts of a result that say what happens: work is counted differently where roundings differ.
    fn assert_same_motion(seen: &Value, native: &Value) {
        for part in [
            "scene",
            "parameters",
            "status",
            "stationarity",
            "objective",
            "horizon",
            "final",
        ] {
            assert_same(&seen[part], &native[part], part);
        }
        let events = |document: &Value| -> Vec<Value> {
            let events = document["events"].as_array().unwrap().iter();
            events
                .map(|e| json!([e["kind"], e["contact"], e["time"], e["q"]]))
                .collect()
        };
        assert_same(&json!(events(seen)), &json!(events(native)), "events");
    }

    /// Answers of the module of a page to requests, without a browser.
    fn answers(page: &str, script: &str) -> Option<Vec<Value>> {
        let scratch = Scratch::new("play-node");
        std::fs::create_dir_all(&scratch.0).unwrap();
        let (file, program) = (scratch.0.join("play.html"), scratch.0.join("run.mjs"));
        std::fs::write(&file, page).unwrap();
        std::fs::write(
            &program,
            format!("{}\n{script}", include_str!("module.mjs")),
        )
        .unwrap();
        let run = Command::new("node").arg(&program).arg(&file).output();
        let Ok(run) = run else {
            eprintln!("skipped: no node found, which runs the module without a browser");
            return None;
        };
        assert!(
            run.status.success(),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        let lines = String::from_utf8(run.stdout).unwrap();
        Some(
            lines
                .lines()
                .map(|line| serde_json::from_str(line).unwrap())
                .collect(),
        )
    }

    #[test]
    fn module_simulates_and_solves_as_this_machine_does() {
        let (_scratch, page) = page(&[]);
        let mut cases: Vec<(&str, &str, &[&str])> = Vec::new();
        for (scene, _) in hangtime_models::scene_texts() {
            cases.push(("simulate", scene, &[]));
        }
        cases.push((
            "solve",
            "pump-track",
            &["--intervals", "6", "--set", "speed=15km/h"],
        ));
        let requests: Vec<Value> = cases
            .iter()
            .map(|(call, scene, settings)| {
                json!({ "call": call, "name": scene, "text": text(scene), "settings": settings })
            })
            .collect();
        let script = format!(
            "for (const request of {}) console.log(JSON.stringify(call(request).result));",
            json!(requests)
        );
        let Some(answers) = answers(&page, &script) else {
            return;
        };
        assert_eq!(answers.len(), cases.len());
        for ((call, scene, settings), seen) in cases.iter().zip(&answers) {
            let native = printed(call, scene, text(scene), settings);
            assert_same_motion(seen, &serde_json::from_str(&native).unwrap());
        }
    }

    #[test]
    fn module_answers_texts_with_mistakes() {
        let (_scratch, page) = page(&[]);
        let wanted = std::env::var("HANGTIME_MUTATED_SCENES").ok();
        let count = wanted.map_or(MUTATED, |count| count.parse().unwrap());
        let script = format!(
            "mutate({count}, {});",
            json!(hangtime_models::scene_texts())
        );
        let Some(answers) = answers(&page, &script) else {
            return;
        };
        let summary = &answers[0];
        assert_eq!(summary["traps"], json!([]));
        let of = |kind: &str| summary[kind].as_u64().unwrap();
        assert_eq!(of("mistaken") + of("refused") + of("done"), count);
        assert!(
            of("mistaken") > count / 4 && of("done") > count / 50,
            "{summary}"
        );
        eprintln!("{summary}");
    }

    #[test]
    fn module_answers_texts_that_lead_deep() {
        let (_scratch, page) = page(&[]);
        let Some(answers) = answers(&page, "deep();") else {
            return;
        };
        let (mistaken, solved) = (json!("mistaken"), json!("solved"));
        assert_eq!(answers[..4], vec![mistaken; 4]);
        assert_eq!(answers[4..], vec![solved; 5]);
    }

    /// What visitors have at hand.
    const TOOLS: &str = r##"
<script>
const wait = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));
const until = async (what) => { while (!what()) await wait(5); };
const idle = () => page.answer && page.scene && !runner.busy && !checker.busy && !page.again;
const type = (content) => { text.value = content; text.dispatchEvent(new Event("input")); };
const look = () => ({ status: element("status").value, result: page.answer.result, command: element("command").textContent,
  figures: document.querySelectorAll("#plots svg path").length, readings: page.answer.motion.readings.length, stage: document.querySelectorAll("#stage [data-body]").length,
  equations: document.querySelectorAll("#equations math").length });
</script>
"##;

    /// Edits, mistakes, mends, simulates, solves and stops.
    const VISITOR: &str = r##"
<script>
(async () => {
  await until(idle);
  report.seconds = performance.now() / 1000;
  report.first = look();
  const original = text.value;
  type(original.replace("m*g*z", "m*g*zz"));
  await until(() => !element("messages").hidden);
  report.mistake = { text: element("report").textContent, marked: element("marks").querySelector("mark").textContent };
  document.querySelector("#jumps button").click();
  report.jump = [text.selectionStart, text.selectionEnd, document.activeElement.id];
  page.answer = null;
  type(original.replace("80", "90"));
  await until(idle);
  report.mended = { ...look(), hidden: element("messages").hidden, slider: element("p-m").value };
  page.answer = null;
  element("p-start_y").value = 9;
  element("p-start_y").dispatchEvent(new Event("input"));
  await until(idle);
  report.slid = look();
  const link = () => packLink({ name: page.name, text: text.value, values: Object.fromEntries(page.values) });
  report.link = await unpackLink(await link());
  report.cut = await unpackLink((await link()).slice(0, 60)).then(() => "read", (error) => error.name);
  const bomb = await through(new Uint8Array(3e8), new CompressionStream("deflate-raw"));
  report.bomb = await through(bomb, new DecompressionStream("deflate-raw")).then(() => "unpacked", (error) => error.name);
  const press = (key) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
  report.plays = page.player.playing();
  page.player.pause();
  page.player.show(0);
  press(" ");
  await until(() => page.player.time() > 0);
  press(" ");
  report.keys = [page.player.playing(), ..."End Home .".split(" ").map((key) => { press(key); return page.player.time(); })];
  location.hash = await link();
  page.answer = null;
  await until(idle);
  report.opened = look();
  page.answer = null;
  element("scenes").value = "pump-track";
  element("scenes").dispatchEvent(new Event("change"));
  await until(idle);
  element("solve").click();
  await until(() => element("status").value.includes("motion"));
  element("stop").click();
  await until(() => !runner.busy && element("stop").disabled);
  report.stopped = element("status").value;
  page.answer = null;
  element("intervals").value = 6;
  element("solve").click();
  await until(idle);
  report.solved = look();
  send();
})();
</script>
"##;

    #[test]
    fn page_from_the_file_system_edits_mends_simulates_stops_and_solves() {
        let Some(browser) = browser() else {
            return;
        };
        let (scratch, page) = page(&[]);
        // No more than what a mail carries; the module is most of it.
        assert!(page.len() < 4_000_000, "{}", page.len());
        let (report, console) = visit(&browser, &scratch.0, &page, &(TOOLS.to_owned() + VISITOR), Origin::File);
        assert_eq!(console, "");
        assert_eq!(report["errors"], json!([]), "{report}");
        eprintln!("first picture after {} s", report["seconds"]);
        let ski_jump = text("ski-jump");
        let simulated = |text: &str, settings: &[&str]| -> Value {
            serde_json::from_str(&printed("simulate", "ski-jump", text, settings)).unwrap()
        };
        assert_same_motion(&report["first"]["result"], &simulated(ski_jump, &[]));
        assert_eq!(report["first"]["stage"], 1);
        assert_eq!(report["first"]["figures"], report["first"]["readings"]);
        assert!(report["first"]["equations"].as_u64().unwrap() > 10);
        let mistake = report["mistake"]["text"].as_str().unwrap();
        assert!(
            mistake.starts_with("error[E01]: `zz` is not declared"),
            "{mistake}"
        );
        assert_eq!(report["mistake"]["marked"], "zz");
        let place = ski_jump.find("m*g*z").unwrap() + 4;
        assert_eq!(report["jump"], json!([place, place + 2, "text"]));
        let mended = ski_jump.replace("80", "90");
        assert_eq!(report["mended"]["hidden"], true);
        assert_eq!(report["mended"]["slider"], "90");
        assert_same_motion(&report["mended"]["result"], &simulated(&mended, &[]));
        assert_eq!(
            report["slid"]["command"],
            "hangtime simulate ski-jump.hang --set start_y=9"
        );
        assert_same_motion(
            &report["slid"]["result"],
            &simulated(&mended, &["--set", "start_y=9"]),
        );
        assert_eq!(report["bomb"], "RangeError");
        assert_eq!(report["cut"], "SyntaxError");
        assert_eq!(report["plays"], true);
        assert_eq!(
            report["link"],
            json!({ "name": "ski-jump", "text": mended, "values": { "start_y": 9 } })
        );
        let first = &report["slid"]["result"]["events"][0]["time"];
        assert_eq!(report["keys"], json!([false, 5, 0, first]));
        assert_eq!(report["opened"]["command"], report["slid"]["command"]);
        assert_eq!(
            report["opened"]["result"]["final"],
            report["slid"]["result"]["final"]
        );
        assert_eq!(report["stopped"], "stopped");
        let native = printed(
            "solve",
            "pump-track",
            text("pump-track"),
            &["--intervals", "6"],
        );
        assert_same_motion(
            &report["solved"]["result"],
            &serde_json::from_str(&native).unwrap(),
        );
        let status = report["solved"]["status"].as_str().unwrap();
        assert!(status.starts_with("solved, certificate "), "{status}");
    }

    /// Writes, undoes, names, and comes back.
    const WRITER: &str = r##"
<script>
(async () => {
  await until(idle);
  const visits = JSON.parse(sessionStorage.getItem("visits") ?? "[]");
  const own = () => [...document.querySelectorAll("#scenes optgroup")].find(({ label }) => label === "yours")?.querySelectorAll("option") ?? [];
  const seen = { name: page.name, text: text.value, own: [...own()].map(({ value }) => value), kept: element("kept").textContent, hash: location.hash };
  visits.push(seen);
  const original = text.value;
  const control = (key, shiftKey = false) => text.dispatchEvent(new KeyboardEvent("keydown", { key, ctrlKey: true, shiftKey, cancelable: true }));
  const choose = async (name) => {
    page.answer = null;
    element("scenes").value = name;
    element("scenes").dispatchEvent(new Event("change"));
    await until(idle);
  };
  if (visits.length === 1) {
    type(`${original}// one\n`);
    await wait(1.2 * Past.pause);
    type(`${original}// one\n// two\n`);
    control("z");
    seen.undone = text.value;
    control("z");
    seen.first = text.value;
    control("z");
    control("z", true);
    control("y");
    seen.redone = text.value;
    seen.edited = element("scenes").selectedOptions[0].textContent;
    await until(idle);
    element("new").click();
    seen.begun = [page.name, text.value.split("\n")[0]];
    page.answer = null;
    await until(idle);
    window.prompt = () => "my sledge.hang";
    element("rename").click();
    seen.renamed = page.name;
    type(text.value.replace("hill: m = 1", "hill: m = 2"));
    await until(idle);
    await choose("ski-jump");
    control("z");
    seen.other = text.value;
    control("z", true);
    await choose("my-sledge");
    seen.named = own().length;
  } else if (visits.length === 2) {
    // A link to a scene whose name is taken by another text.
    location.hash = await packLink({ name: "my-sledge", text: "// another\ncoordinates { z: m }\nhorizon 1 [s]\nlagrangian 1[kg]/2*dot(z)^2\n" });
    page.answer = null;
    await until(idle);
    seen.linked = [page.name, location.hash];
    window.confirm = () => true;
    element("delete").click();
    seen.deleted = [page.name, [...own()].map(({ value }) => value)];
    location.hash = "#scene=broken!";
    await until(() => element("kept").classList.contains("bad"));
    seen.broken = element("kept").textContent;
    await choose("ski-jump");
    element("original").click();
    seen.original = [text.value === JSON.parse(element("shipped").textContent)[0].text, store.text("ski-jump") === undefined];
    store.open("my-sledge");
  }
  sessionStorage.setItem("visits", JSON.stringify(visits));
  if (visits.length < 3) {
    history.replaceState(null, "", location.pathname);
    location.reload();
    return;
  }
  report.visits = visits;
  send();
})();
</script>
"##;

    #[test]
    fn page_keeps_scenes_by_name_over_visits_and_undoes_over_scenes() {
        let Some(browser) = browser() else {
            return;
        };
        let (scratch, page) = page(&[]);
        let script = TOOLS.to_owned() + WRITER;
        let (report, console) = visit(&browser, &scratch.0, &page, &script, Origin::Server);
        assert_eq!(console, "");
        assert_eq!(report["errors"], json!([]), "{report}");
        let visits = &report["visits"];
        let ski_jump = text("ski-jump");
        let edited = format!("{ski_jump}// one\n// two\n");
        let first = &visits[0];
        assert_eq!([&first["name"], &first["text"]], ["ski-jump", ski_jump]);
        assert_eq!(first["undone"], format!("{ski_jump}// one\n"));
        assert_eq!(first["first"], ski_jump);
        assert_eq!(first["redone"], edited);
        assert_eq!(first["edited"], "ski-jump (edited)");
        assert_eq!(first["begun"], json!(["scene", "//! A sledge with a propeller, on a hill with a drop behind it."]));
        assert_eq!(first["renamed"], "my-sledge");
        // Steps of a scene are its own, and stay while others are open.
        assert_eq!(first["other"], format!("{ski_jump}// one\n"));
        assert_eq!(first["named"], 1);
        let second = &visits[1];
        assert_eq!(second["name"], "my-sledge");
        assert!(second["text"].as_str().unwrap().contains("hill: m = 2"));
        assert_eq!([&second["own"], &second["kept"]], [&json!(["my-sledge"]), &json!("kept in this browser")]);
        assert_eq!(second["linked"], json!(["my-sledge-2", ""]));
        assert_eq!(second["deleted"], json!(["ski-jump", ["my-sledge"]]));
        let broken = second["broken"].as_str().unwrap();
        assert!(broken.contains("a part of it is lost or was changed"), "{broken}");
        assert_eq!(second["original"], json!([true, true]));
        assert_eq!(visits[2]["name"], "my-sledge");
    }

    /// Reads, chooses, points, saves, and solves again.
    const READER: &str = r##"
<script>
const bytes = async (content) => [...new Uint8Array(await (content instanceof Blob ? content : new Blob([content])).arrayBuffer())];
HTMLAnchorElement.prototype.click = () => {};
(async () => {
  await until(idle);
  report.plays = page.player.playing();
  element("choose").click();
  const cards = [...document.querySelectorAll("#cards .card")];
  report.groups = [...document.querySelectorAll("#cards h3")].map(({ textContent }) => textContent);
  report.cards = cards.map((card) => [card.dataset.scene, card.querySelector("svg") !== null, card.textContent]);
  page.answer = null;
  cards.find(({ dataset }) => dataset.scene === "hop").click();
  await until(idle);
  report.chosen = [page.name, text.value, element("asked").textContent, element("gallery").open];

  reading.open("first_scene.md");
  page.answer = null;
  element("sheet").querySelector("figure.scene button").click();
  await until(idle);
  report.tried = [page.name, element("status").value.split(" ")[0], document.body.classList.contains("reading")];
  element("find").value = "air drag";
  element("find").dispatchEvent(new Event("input"));
  report.found = element("sheet").querySelector("a").textContent;
  element("sheet").querySelector("a").click();
  report.opened = [element("chapter").value, element("sheet").querySelectorAll("math").length];
  element("sheet").querySelector("[data-anchor] ~ p a")?.click();
  element("back").click();
  report.back = element("chapter").value;
  const ball = text.value;
  type(ball.replace("g*z", "gg*z"));
  await until(() => document.querySelector("#jumps .page"));
  report.report = element("report").textContent;
  document.querySelector("#jumps .page").click();
  await until(() => element("sheet").querySelector("h2")?.textContent.startsWith("E01"));
  report.page = element("sheet").querySelector("h2").textContent;
  page.answer = null;
  type(ball);
  await until(idle);
  element("close").click();
  report.closed = element("reading").hidden;

  report.axes = page.plots.axes();
  const [first, second] = page.plots.figures().map(({ svg }) => svg);
  const box = first.getBoundingClientRect();
  first.dispatchEvent(new PointerEvent("pointermove", { clientX: box.left + 0.4 * box.width, clientY: box.top + 20, bubbles: true }));
  const cursors = () => [...document.querySelectorAll("#plots .cursor")].map((line) => [line.getAttribute("x1"), line.style.visibility]);
  report.cursors = cursors();
  report.read = [...document.querySelectorAll("#plots .read")].map(({ textContent }) => textContent);
  first.dispatchEvent(new PointerEvent("pointerleave"));
  report.left = cursors().map(([, seen]) => seen);

  report.svg = [];
  for (const what of ["motion-svg", "curves-svg"]) {
    const parsed = new DOMParser().parseFromString(await exportAs(what), "image/svg+xml");
    report.svg.push([parsed.querySelector("parsererror") === null, parsed.querySelectorAll("path, polyline, circle").length > 2, parsed.documentElement.outerHTML.includes("var(")]);
  }
  report.png = [];
  for (const what of ["motion-png", "curves-png"]) report.png.push((await bytes(await exportAs(what))).slice(0, 4));
  const csv = (await exportAs("csv")).trim().split("
");
  report.csv = [csv[0], csv.length - 1, page.answer.motion.time.length];
  report.film = exportsOf.kind() ? null : "none";
  if (exportsOf.kind()) {
    element("rate").value = "2";
    const film = await exportAs("film");
    report.film = [film.type, (await bytes(film)).slice(0, 4), film.size > 2000];
  }

  page.answer = null;
  choose("pump-track");
  await until(idle);
  element("intervals").value = 6;
  page.answer = null;
  element("solve").click();
  await until(idle);
  report.solved = element("status").value;
  page.answer = null;
  page.values.set("speed", 16);
  changed();
  report.dim = element("motion").classList.contains("old");
  await until(idle);
  report.again = element("status").value;
  report.objective = page.answer.result.objective;
  send();
})();
</script>
"##;

    #[test]
    fn page_shows_the_gallery_reads_points_saves_and_solves_again() {
        let Some(browser) = browser() else {
            return;
        };
        let (scratch, page) = page(&[]);
        let script = TOOLS.to_owned() + READER;
        let (report, console) = visit(&browser, &scratch.0, &page, &script, Origin::Server);
        assert_eq!(console, "");
        assert_eq!(report["errors"], json!([]), "{report}");
        assert_eq!(report["plays"], true);
        let listed = hangtime_models::scenes();
        let cards = report["cards"].as_array().unwrap();
        for scene in listed {
            let card = cards.iter().find(|card| card[0] == scene.name).unwrap();
            let told = card[2].as_str().unwrap();
            assert_eq!(card[1], !scene.picture.is_empty(), "{}", scene.name);
            assert!(told.contains(scene.title), "{told}");
            if let Some(question) = scene.question {
                assert!(told.contains(question.asked) && told.contains(question.answer), "{told}");
            }
        }
        let mut groups: Vec<&str> = listed.iter().map(|scene| scene.group).collect();
        groups.dedup();
        for group in groups {
            assert!(report["groups"].as_array().unwrap().contains(&json!(group)), "{group}");
        }
        let hop = listed.iter().find(|scene| scene.name == "hop").unwrap();
        let question = hop.question.unwrap();
        let asked = format!("{}{}", question.asked, question.answer);
        assert_eq!(report["chosen"], json!(["hop", hop.unread, asked, false]));
        assert_eq!(report["tried"], json!(["ball", "solved", true]));
        assert_eq!(report["found"], "Bodies and forces: Air drag");
        assert_eq!(report["opened"][0], "bodies.md");
        assert!(report["opened"][1].as_u64().unwrap() >= 4);
        assert_eq!(report["back"], "bodies.md");
        let mistakes = report["report"].as_str().unwrap();
        assert!(mistakes.contains("error[E01]") && !mistakes.contains("hangtime explain"), "{mistakes}");
        assert_eq!(report["page"], "E01: undeclared name");
        assert_eq!(report["closed"], true);
        let axes = report["axes"].as_array().unwrap();
        assert!(axes.len() > 1 && axes.iter().all(|axis| *axis == axes[0]), "{axes:?}");
        let cursors = report["cursors"].as_array().unwrap();
        assert!(cursors.len() == axes.len() && cursors.iter().all(|cursor| *cursor == cursors[0]), "{cursors:?}");
        assert_eq!(cursors[0][1], "visible");
        assert!(report["read"][0].as_str().unwrap().starts_with("t = "));
        assert!(report["left"].as_array().unwrap().iter().all(|seen| seen == "hidden"));
        assert_eq!(report["svg"], json!([[true, true, false], [true, true, false]]));
        let png = json!([0x89, 0x50, 0x4e, 0x47]);
        assert_eq!(report["png"], json!([png, png]));
        let heading = report["csv"][0].as_str().unwrap();
        assert!(heading.starts_with("time [s],x [m],dx/dt [m/s],z [m],dz/dt [m/s]"), "{heading}");
        assert_eq!(report["csv"][1], report["csv"][2]);
        match report["film"][0].as_str() {
            // The first bytes of Matroska, and nothing to compare in others.
            Some("video/webm") => assert_eq!(report["film"], json!(["video/webm", [0x1a, 0x45, 0xdf, 0xa3], true])),
            _ => eprintln!("skipped: this browser films {}", report["film"]),
        }
        assert!(report["solved"].as_str().unwrap().starts_with("solved, certificate "), "{report}");
        assert_eq!(report["dim"], true);
        let again = report["again"].as_str().unwrap();
        assert!(again.starts_with("solved again, from the plan before, certificate "), "{again}");
        let settings = ["--intervals", "6", "--set", "speed=16km/h"];
        let cold: Value = serde_json::from_str(&printed("solve", "pump-track", text("pump-track"), &settings)).unwrap();
        let [warm, cold] = [&report["objective"], &cold["objective"]].map(|objective| objective.as_f64().unwrap());
        // The tolerance of the interior point method, 1e-8, of either.
        assert!((warm - cold).abs() < 1e-7, "{warm} {cold}");
    }

    #[test]
    fn page_of_a_file_opens_with_it() {
        let scratch = Scratch::new("play-own");
        std::fs::create_dir_all(&scratch.0).unwrap();
        let file = scratch.0.join("own.hang");
        std::fs::write(&file, "// </script>\ncoordinates { z: m }\n").unwrap();
        let (_folder, page) = page(&[file.to_str().unwrap()]);
        let scenes = crate::support::embedded(&page, "shipped");
        let own = "// </script>\ncoordinates { z: m }\n";
        assert_eq!([&scenes[0]["name"], &scenes[0]["text"]], ["own", own]);
        // Those of the list, and one that is a form of another.
        assert_eq!(scenes.as_array().unwrap().len(), 1 + hangtime_models::scenes().len() + 1);
    }
}
