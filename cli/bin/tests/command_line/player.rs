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
fn play(name: &str, arguments: &[&str], check: impl Fn(&Value)) {
    let Some(browser) = browser() else {
        return;
    };
    let scratch = Scratch::new(&format!("player-{name}"));
    let mut arguments = arguments.to_vec();
    arguments.extend(["--out", scratch.text()]);
    solved(&arguments);
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
    play("ski-jump", &["simulate", "ski-jump"], |report| {
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
    let arguments = ["solve", "pump-track", "--intervals", "12"];
    play("pump-track-optimal", &arguments, |report| {
        let text = report["start"]["clock"].as_str().unwrap();
        let seconds = text.split_whitespace().nth(3).unwrap();
        assert_plays(report, seconds.parse().unwrap());
        assert_ne!(report["start"]["arrow"], "");
    });
}
