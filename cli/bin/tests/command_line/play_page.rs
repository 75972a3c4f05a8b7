//! The page itself, with its module: in node, and visited by a browser.

use std::process::Command;

use serde_json::{Value, json};

use crate::browser::{Origin, browser, visit};
use crate::play::{printed, text};
use crate::support::{Scratch, solved};

/// Largest difference of a number in the module, which has its own sine and cosine, from that of this machine,
/// relative to the largest values.
const SAME: f64 = 1e-9;
/// Files with mistakes that the module answers, unless the environment asks for more.
const MUTATED: u64 = 300;

/// A visitor with its tools, at the end of the page.
fn visiting(visitor: &str) -> String {
    format!("<script>\n{TOOLS}\n{visitor}</script>\n")
}

/// The page, in a folder of its own.
fn page(arguments: &str) -> (Scratch, String) {
    let scratch = Scratch::new("play-page");
    solved(&format!("play {arguments} --out {}", scratch.text()));
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
    let file = scratch.write("play.html", page);
    let program = format!("{}\n{script}", include_str!("module.mjs"));
    let program = scratch.write("run.mjs", program);
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
    let (_scratch, page) = page("");
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
    let (_scratch, page) = page("");
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
    let (_scratch, page) = page("");
    let Some(answers) = answers(&page, "deep();") else {
        return;
    };
    let (mistaken, solved) = (json!("mistaken"), json!("solved"));
    assert_eq!(answers[..4], vec![mistaken; 4]);
    assert_eq!(answers[4..], vec![solved; 5]);
}

/// What visitors have at hand.
const TOOLS: &str = include_str!("visits/tools.js");

/// Edits, mistakes, mends, simulates, solves and stops.
const VISITOR: &str = include_str!("visits/author.js");

#[test]
fn page_from_the_file_system_edits_mends_simulates_stops_and_solves() {
    let Some(browser) = browser() else {
        return;
    };
    let (scratch, page) = page("");
    // No more than what a mail carries; the module is most of it.
    assert!(page.len() < 4_000_000, "{}", page.len());
    let (report, console) = visit(
        &browser,
        &scratch.0,
        &page,
        &visiting(VISITOR),
        Origin::File,
    );
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
const WRITER: &str = include_str!("visits/writer.js");

#[test]
fn page_keeps_scenes_by_name_over_visits_and_undoes_over_scenes() {
    let Some(browser) = browser() else {
        return;
    };
    let (scratch, page) = page("");
    let script = visiting(WRITER);
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
    assert_eq!(
        first["begun"],
        json!([
            "scene",
            "//! A sledge with a propeller, on a hill with a drop behind it."
        ])
    );
    assert_eq!(first["renamed"], "my-sledge");
    // Steps of a scene are its own, and stay while others are open.
    assert_eq!(first["other"], format!("{ski_jump}// one\n"));
    assert_eq!(first["named"], 1);
    let second = &visits[1];
    assert_eq!(second["name"], "my-sledge");
    assert!(second["text"].as_str().unwrap().contains("hill: m = 2"));
    assert_eq!(
        [&second["own"], &second["kept"]],
        [&json!(["my-sledge"]), &json!("kept in this browser")]
    );
    assert_eq!(second["linked"], json!(["my-sledge-2", ""]));
    assert_eq!(second["deleted"], json!(["ski-jump", ["my-sledge"]]));
    let broken = second["broken"].as_str().unwrap();
    assert!(
        broken.contains("a part of it is lost or was changed"),
        "{broken}"
    );
    assert_eq!(second["original"], json!([true, true]));
    assert_eq!(visits[2]["name"], "my-sledge");
}

/// Reads, chooses, points, saves, and solves again.
const READER: &str = include_str!("visits/reader.js");

/// What the gallery and the reference have shown.
fn assert_reads(report: &Value) {
    let listed = hangtime_models::scenes();
    let cards = report["cards"].as_array().unwrap();
    for scene in listed {
        let card = cards.iter().find(|card| card[0] == scene.name).unwrap();
        let told = card[2].as_str().unwrap();
        assert_eq!(card[1], !scene.picture.is_empty(), "{}", scene.name);
        assert!(
            told.contains(scene.title) && told.contains(&scene.about()),
            "{told}"
        );
        if let Some(question) = scene.question {
            assert!(
                told.contains(question.asked) && told.contains(question.answer),
                "{told}"
            );
        }
    }
    let mut groups: Vec<&str> = listed.iter().map(|scene| scene.group).collect();
    groups.dedup();
    for group in groups {
        assert!(
            report["groups"].as_array().unwrap().contains(&json!(group)),
            "{group}"
        );
    }
    let hop = listed.iter().find(|scene| scene.name == "hop").unwrap();
    let question = hop.question.unwrap();
    let asked = format!("{}{}", question.asked, question.answer);
    assert_eq!(report["chosen"], json!(["hop", hop.unread, asked, false]));
    assert_eq!(report["tried"], json!(["ball", "solved", true]));
    assert_eq!(report["found"], "Bodies and forces: Air drag");
    assert_eq!(report["opened"][0], "bodies.md");
    assert!(report["opened"][1].as_u64().unwrap() >= 4);
    assert_eq!(report["back"], "first_scene.md");
    let mistakes = report["report"].as_str().unwrap();
    assert!(
        mistakes.contains("error[E01]") && !mistakes.contains("hangtime explain"),
        "{mistakes}"
    );
    assert_eq!(report["page"], "E01: undeclared name");
    assert_eq!(report["closed"], true);
}

/// What the curves and the files have shown.
fn assert_points_and_saves(report: &Value) {
    let axes = report["axes"].as_array().unwrap();
    assert!(
        axes.len() > 1 && axes.iter().all(|axis| *axis == axes[0]),
        "{axes:?}"
    );
    let cursors = report["cursors"].as_array().unwrap();
    assert!(
        cursors.len() == axes.len() && cursors.iter().all(|cursor| *cursor == cursors[0]),
        "{cursors:?}"
    );
    assert_eq!(cursors[0][1], "visible");
    assert!(report["read"][0].as_str().unwrap().starts_with("t = "));
    assert!(
        report["left"]
            .as_array()
            .unwrap()
            .iter()
            .all(|seen| seen == "hidden")
    );
    assert_eq!(
        report["svg"],
        json!([[true, true, false], [true, true, false]])
    );
    let png = json!([0x89, 0x50, 0x4e, 0x47]);
    assert_eq!(report["png"], json!([png, png]));
    let heading = report["csv"][0].as_str().unwrap();
    assert!(
        heading.starts_with("time [s],x [m],dx/dt [m/s],z [m],dz/dt [m/s]"),
        "{heading}"
    );
    assert_eq!(report["csv"][1], report["csv"][2]);
    match report["film"][0].as_str() {
        // The first bytes of Matroska, and nothing to compare in others.
        Some("video/webm") => assert_eq!(
            report["film"],
            json!(["video/webm", [0x1a, 0x45, 0xdf, 0xa3], true])
        ),
        _ => eprintln!("skipped: this browser films {}", report["film"]),
    }
}

#[test]
fn page_shows_the_gallery_reads_points_saves_and_solves_again() {
    let Some(browser) = browser() else {
        return;
    };
    let (scratch, page) = page("");
    let script = visiting(READER);
    let (report, console) = visit(&browser, &scratch.0, &page, &script, Origin::Server);
    assert_eq!(console, "");
    assert_eq!(report["errors"], json!([]), "{report}");
    assert_eq!(report["plays"], true);
    assert_reads(&report);
    assert_points_and_saves(&report);
    assert!(
        report["solved"]
            .as_str()
            .unwrap()
            .starts_with("solved, certificate "),
        "{report}"
    );
    assert_eq!(report["dim"], true);
    let again = report["again"].as_str().unwrap();
    assert!(
        again.starts_with("solved again, from the plan before, certificate "),
        "{again}"
    );
    let settings = ["--intervals", "6", "--set", "speed=16km/h"];
    let cold: Value = serde_json::from_str(&printed(
        "solve",
        "pump-track",
        text("pump-track"),
        &settings,
    ))
    .unwrap();
    let [warm, cold] =
        [&report["objective"], &cold["objective"]].map(|objective| objective.as_f64().unwrap());
    // The tolerance of the interior point method, 1e-8, of either.
    assert!((warm - cold).abs() < 1e-7, "{warm} {cold}");
}

#[test]
fn page_of_a_file_opens_with_it() {
    let scratch = Scratch::new("play-own");
    let file = scratch.write("own.hang", "// </script>\ncoordinates { z: m }\n");
    let (_folder, page) = page(&file);
    let scenes = crate::support::embedded(&page, "shipped");
    let own = "// </script>\ncoordinates { z: m }\n";
    assert_eq!([&scenes[0]["name"], &scenes[0]["text"]], ["own", own]);
    // Those of the list, and one that is a form of another.
    assert_eq!(
        scenes.as_array().unwrap().len(),
        1 + hangtime_models::scenes().len() + 1
    );
}
