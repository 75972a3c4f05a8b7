//! The page that plays a motion, in a real browser where one is found.
//!
//! The test serves the page with a script at its end that presses, drags and looks, and sends back what it saw. Set
//! `HANGTIME_BROWSER` to choose a browser; Chromium and its relatives understand the options.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::support::{Scratch, solved};

/// Names under which Chromium and its relatives are installed.
const BROWSERS: [&str; 5] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
];
/// Chosen browser.
const VARIABLE: &str = "HANGTIME_BROWSER";

/// Presses and drags, and reports what the page shows.
const VISITOR: &str = r##"
<script>
const report = { errors: [] };
window.addEventListener("error", (event) => report.errors.push(event.message));
const note = (...words) => report.errors.push(words.join(" "));
console.error = note;
console.warn = note;
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
    // The server may be gone before it answers.
    fetch("report", { method: "POST", body: JSON.stringify(report) }).catch(() => {});
  });
});
</script>
"##;

/// The browser to use: the chosen one, or one on the path.
fn browser() -> Option<PathBuf> {
    if let Some(chosen) = std::env::var_os(VARIABLE) {
        return Some(chosen.into());
    }
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .flat_map(|folder| BROWSERS.map(|name| folder.join(name)))
        .find(|candidate| candidate.is_file())
}

/// A browser that ends with the test.
struct Visit(Child);

impl Drop for Visit {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// One request of the browser: its first line and its body.
fn request(stream: &TcpStream) -> std::io::Result<(String, String)> {
    // Browsers open connections ahead of time and then say nothing.
    stream.set_read_timeout(Some(Duration::from_secs(1)))?;
    let mut reader = BufReader::new(stream);
    let mut first = String::new();
    reader.read_line(&mut first)?;
    let mut length = 0;
    loop {
        let mut line = String::new();
        reader.read_line(&mut line)?;
        let line = line.trim().to_ascii_lowercase();
        if let Some(value) = line.strip_prefix("content-length:") {
            length = value.trim().parse().unwrap();
        }
        if line.is_empty() {
            break;
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body)?;
    Ok((first, String::from_utf8(body).unwrap()))
}

/// What the visitor saw, and what the browser said about the page on its console.
fn visit(browser: &Path, folder: &Path, page: &str) -> (Value, String) {
    let page = page.replace("</body>", &format!("{VISITOR}</body>"));
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let log = folder.join("browser.log");
    let child = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
        ])
        .arg("--enable-logging=stderr")
        .arg(format!(
            "--user-data-dir={}",
            folder.join("profile").display()
        ))
        .arg(format!("http://{}/", server.local_addr().unwrap()))
        .stdout(Stdio::null())
        .stderr(File::create(&log).unwrap())
        .spawn()
        .unwrap();
    let visit = Visit(child);
    server.set_nonblocking(true).unwrap();
    // Only a browser that hangs needs so long.
    let end = Instant::now() + Duration::from_secs(120);
    let report = loop {
        assert!(Instant::now() < end, "the browser sent no report");
        let Ok((mut stream, _)) = server.accept() else {
            std::thread::sleep(Duration::from_millis(5));
            continue;
        };
        stream.set_nonblocking(false).unwrap();
        let Ok((first, body)) = request(&stream) else {
            continue;
        };
        let (status, content) = match first.split_whitespace().nth(1) {
            Some("/") => ("200 OK", page.as_str()),
            Some("/report") => break serde_json::from_str(&body).unwrap(),
            // Browsers ask for it unasked.
            Some("/favicon.ico") => ("204 No Content", ""),
            None => continue,
            Some(other) => panic!("the page loads `{other}`"),
        };
        let length = content.len();
        write!(
            stream,
            "HTTP/1.1 {status}\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: {length}\r\n\
             Connection: close\r\n\r\n{content}"
        )
        .unwrap();
    };
    drop(visit);
    let log = String::from_utf8_lossy(&std::fs::read(&log).unwrap()).into_owned();
    let console = log.lines().filter(|line| line.contains("CONSOLE"));
    (report, console.collect::<Vec<_>>().join("\n"))
}

/// Seconds on the clock.
fn clock(seen: &Value) -> f64 {
    let text = seen["clock"].as_str().unwrap();
    text.split_whitespace().next().unwrap().parse().unwrap()
}

/// Simulates a scene and plays it; `check` sees the report.
fn play(name: &str, arguments: &[&str], check: impl Fn(&Value)) {
    let Some(browser) = browser() else {
        eprintln!(
            "skipped: no browser found; install chromium, or set {VARIABLE} to the path of one"
        );
        return;
    };
    let scratch = Scratch::new(&format!("player-{name}"));
    let mut arguments = arguments.to_vec();
    arguments.extend(["--out", scratch.text()]);
    solved(&arguments);
    let page = scratch.read(&format!("{name}.html"));
    let (report, console) = visit(&browser, &scratch.0, &page);
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
