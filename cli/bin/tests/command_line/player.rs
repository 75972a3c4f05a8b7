//! The page that plays a motion, in a real browser where one is found.
//!
//! The test serves the page with a script at its end that presses, drags and looks, and sends back what it saw.

use serde_json::Value;

use crate::browser::{Origin, browser, visit};
use crate::support::{Scratch, solved};

/// Presses and drags, and reports what the page shows.
const VISITOR: &str = r##"
<script>
const element = (id) => document.getElementById(id);
const body = () => Number(document.querySelector("#stage circle").getAttribute("cx"));
const arrow = () => document.querySelector("#stage path").getAttribute("d");
const look = () => ({ clock: element("clock").value, scrub: Number(element("scrub").value), body: body(),
  arrow: arrow(), button: element("play").textContent, arrows: document.querySelectorAll("#stage path").length });
const drag = (time) => { element("scrub").value = time; element("scrub").dispatchEvent(new Event("input")); };
report.start = look();
drag(Number(element("scrub").max) / 2);
report.dragged = look();
drag(0);
element("rate").value = "0.5";
element("play").click();
report.pressed = look();
const pressed = performance.now();
let last = pressed;
report.longest = 0;
const frames = (count, then) => requestAnimationFrame((instant) => {
  report.longest = Math.max(report.longest, (instant - last) / 1000);
  last = instant;
  count > 0 ? frames(count - 1, then) : then(instant);
});
frames(40, (instant) => {
  report.playing = look();
  report.elapsed = (instant - pressed) / 1000;
  element("play").click();
  report.paused = look();
  frames(10, () => {
    report.later = look();
    document.querySelectorAll("#events button")[0].click();
    report.event = look();
    drag(Number(element("scrub").max));
    report.end = look();
    element("play").click();
    report.again = look();
    send();
  });
});
</script>
"##;

/// Seconds on the clock.
fn clock(seen: &Value) -> f64 {
    let text = seen["clock"].as_str().unwrap();
    text.split_whitespace().next().unwrap().parse().unwrap()
}

/// Simulates a scene and plays it; `check` sees the report.
fn play(name: &str, line: &str, check: impl Fn(&Value)) {
    let Some(browser) = browser() else {
        return;
    };
    let scratch = Scratch::new(&format!("player-{name}"));
    solved(&format!("{line} --out {}", scratch.text()));
    let page = scratch.read(&format!("{name}.html"));
    let (report, console) = visit(&browser, &scratch.0, &page, VISITOR, Origin::Server);
    assert_eq!(console, "");
    assert_eq!(report["errors"], serde_json::json!([]));
    check(&report);
}

/// What holds for every motion of `seconds`.
fn assert_plays(report: &Value, seconds: f64) {
    let at = |moment: &str| clock(&report[moment]);
    // The clock shows four decimals.
    const SHOWN: f64 = 1e-4;
    assert_eq!(at("start"), 0.0);
    assert_eq!(report["start"]["button"], "play");
    assert!((at("dragged") - seconds / 2.0).abs() < SHOWN, "{report}");
    assert_ne!(report["dragged"]["body"], report["start"]["body"]);
    assert_eq!(report["pressed"]["button"], "pause");
    // At half speed; the visitor sees a frame before or after the player does, and the player starts its clock with a
    // frame, so they may be two frames apart.
    let elapsed = report["elapsed"].as_f64().unwrap();
    assert!(at("playing") > 0.0, "{report}");
    let apart = 2.0 * report["longest"].as_f64().unwrap();
    assert!(
        (at("playing") - 0.5 * elapsed).abs() < 0.5 * apart + SHOWN,
        "{report}"
    );
    assert_ne!(report["playing"]["body"], report["pressed"]["body"]);
    assert_eq!(report["paused"]["button"], "play");
    assert_eq!(report["later"]["clock"], report["paused"]["clock"]);
    assert!((at("end") - seconds).abs() < SHOWN, "{report}");
    // Pressed at the end, it starts over.
    assert_eq!(at("again"), 0.0);
    assert_eq!(report["again"]["button"], "pause");
}

#[test]
fn player_of_a_ski_jump_plays_scrubs_and_shows_the_force_in_contact_only() {
    play("ski-jump", "simulate ski-jump", |report| {
        assert_plays(report, 5.0);
        assert_eq!(report["start"]["arrows"], 2);
        // On the table at the start; in the air half way, at 2.5 s.
        assert_ne!(report["start"]["arrow"], "");
        assert_eq!(report["dragged"]["arrow"], "");
        // The first event is the take-off.
        assert!((clock(&report["event"]) - 1.7854).abs() < 1e-4);
    });
}

#[test]
fn player_of_a_solved_ride_plays_and_scrubs() {
    play(
        "pump-track-optimal",
        "solve pump-track --intervals 12",
        |report| {
            let text = report["start"]["clock"].as_str().unwrap();
            let seconds = text.split_whitespace().nth(3).unwrap();
            assert_plays(report, seconds.parse().unwrap());
            assert_ne!(report["start"]["arrow"], "");
        },
    );
}

/// What the player of a scene file draws at the start, in the middle and at the end, by node; `None` where there is none.
fn drawn(name: &str, text: &str) -> Option<Value> {
    let scratch = Scratch::new(&format!("drawn-{name}"));
    let file = scratch.write(&format!("{name}.hang"), text);
    solved(&format!("simulate {file} --out {}", scratch.text()));
    let script = scratch.write("stage.mjs", include_str!("visits/stage.js"));
    let page = scratch.0.join(format!("{name}.html"));
    let run = std::process::Command::new("node")
        .arg(script)
        .arg(page)
        .output();
    let Ok(run) = run else {
        eprintln!("skipped: no node found, which runs the player without a browser");
        return None;
    };
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(run.status.success(), "{name}: {said}");
    Some(serde_json::from_slice(&run.stdout).unwrap())
}

/// A plank that is a line leans against a wall and slides down.
const PLANK: &str = "parameters { l: m = 3 } coordinates { x: m, z: m, phi: rad } \
    let foot = (x + l/2*cos(phi), z - l/2*sin(phi)) let top = (x - l/2*cos(phi), z + l/2*sin(phi)) \
    lagrangian 5[kg]/2*|dot((x, z))|^2 + 4[kg m^2]/2*dot(phi)^2 - 50[N]*z \
    surface floor: foot.z >= 0 surface wall: top.x >= 0 impact floor, wall: inelastic \
    picture { PICTURE } \
    start { phi: 1.1, x: 1.5[m]*cos(1.1), z: 1.5[m]*sin(1.1) } horizon 0.4 [s]";

#[test]
fn player_of_every_kind_of_picture_moves_and_shows_forces_on_what_they_act_on() {
    let link = "link foot to top";
    let body = "rectangle plank at (x, z) size (l, 5[cm]) angle -phi";
    let ground = "curve ground: (w, 0) over w in 0..=4 [m]";
    let spring = "spring (0, 0) to top";
    for picture in [
        link.to_owned(),
        body.to_owned(),
        format!("{link}, {ground}"),
        format!("{spring}, {link}"),
        format!("point middle at (x, z), {link}"),
        format!("{ground}, {body}, {spring}"),
    ] {
        let Some(report) = drawn("plank", &PLANK.replace("PICTURE", &picture)) else {
            return;
        };
        assert_ne!(
            report[0]["lines"], report[2]["lines"],
            "{picture} does not move"
        );
        let forces = report[0]["forces"].as_array().unwrap();
        let names: Vec<&str> = forces
            .iter()
            .map(|force| force[0].as_str().unwrap())
            .collect();
        assert_eq!(names, ["floor", "wall"], "{picture}: {report}");
        // The part is the plank: behind the point that is its middle, and before or behind a spring.
        let plank = match picture.starts_with("point") || picture.starts_with("spring") {
            true => "1",
            false => "0",
        };
        assert!(
            forces.iter().all(|force| force[1] == plank),
            "{picture}: {forces:?}"
        );
        assert!(
            forces
                .iter()
                .all(|force| force[2].as_str().unwrap().ends_with(" N"))
        );
    }
}

#[test]
fn player_of_a_linkage_against_a_stop_shows_a_torque_on_the_part_that_turns() {
    let text = "coordinates { a: rad, b: rad } let knee = 1[m]*(cos(a), sin(a)) let tip = knee + 0.5[m]*(cos(b), sin(b)) \
        lagrangian 1[kg]/2*(|dot(knee)|^2 + |dot(tip)|^2) - 10[N]*(knee.z + tip.z) \
        surface stop: b >= 0.2 [rad] impact stop: inelastic picture { link (0, 0) to knee, link knee to tip } \
        start { a: 1.2, b: 0.2 } horizon 0.1 [s]";
    let Some(report) = drawn("linkage", text) else {
        return;
    };
    let force = &report[0]["forces"][0];
    assert_eq!(
        (force[0].as_str(), force[1].as_str()),
        (Some("stop"), Some("1")),
        "{report}"
    );
    assert!(
        force[2].as_str().unwrap().starts_with("torque of stop: "),
        "{force}"
    );
}
