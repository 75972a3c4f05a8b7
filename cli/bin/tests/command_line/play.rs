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
    assert!(
        told.iter()
            .all(|(share, doing)| share.is_none() && doing.contains("program ")),
        "{told:?}"
    );
    assert!(!told.is_empty());
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

    /// Edits, mistakes, mends, simulates, solves and stops.
    const VISITOR: &str = r##"
<script>
const wait = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));
const until = async (what) => { while (!what()) await wait(5); };
const idle = () => page.answer && page.scene && !runner.busy && !checker.busy && !page.again;
const type = (content) => { text.value = content; text.dispatchEvent(new Event("input")); };
const look = () => ({ status: element("status").value, result: page.answer.result, command: element("command").textContent,
  figures: document.querySelectorAll("#plots svg path").length, readings: page.answer.motion.readings.length, stage: document.querySelectorAll("#stage [data-body]").length,
  equations: document.querySelectorAll("#equations math").length });
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
  report.link = await unpackLink(await packLink());
  const bomb = await through(new Uint8Array(3e8), new CompressionStream("deflate-raw"));
  report.bomb = await through(bomb, new DecompressionStream("deflate-raw")).then(() => "unpacked", (error) => error.name);
  const press = (key) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
  press(" ");
  await until(() => page.player.time() > 0);
  press(" ");
  report.keys = [page.player.playing(), ..."End Home .".split(" ").map((key) => { press(key); return page.player.time(); })];
  location.hash = await packLink();
  page.answer = null;
  await until(idle);
  report.opened = look();
  page.answer = null;
  element("scenes").value = "pump-track";
  element("scenes").dispatchEvent(new Event("change"));
  await until(idle);
  element("solve").click();
  await until(() => element("status").value.includes("program"));
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
        let (report, console) = visit(&browser, &scratch.0, &page, VISITOR, Origin::File);
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
        assert_eq!(
            report["link"],
            json!({ "name": "ski-jump", "content": mended, "values": { "start_y": 9 } })
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

    #[test]
    fn page_of_a_file_opens_with_it() {
        let scratch = Scratch::new("play-own");
        std::fs::create_dir_all(&scratch.0).unwrap();
        let file = scratch.0.join("own.hang");
        std::fs::write(&file, "// </script>\ncoordinates { z: m }\n").unwrap();
        let (_folder, page) = page(&[file.to_str().unwrap()]);
        let scenes = crate::support::embedded(&page, "shipped");
        assert_eq!(
            scenes[0],
            json!({ "name": "own", "text": "// </script>\ncoordinates { z: m }\n" })
        );
        assert_eq!(
            scenes.as_array().unwrap().len(),
            1 + hangtime_models::scene_texts().len()
        );
    }
}
