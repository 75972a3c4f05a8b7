//! Visits of pages by a real browser, where one is found: Chromium or one of its relatives.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// Names under which Chromium and its relatives are installed.
const BROWSERS: [&str; 5] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
];
/// Notes whatever goes wrong, and sends the report.
const WITNESS: &str = r#"
<script>
const report = { errors: [] };
addEventListener("error", (event) => report.errors.push(event.message));
addEventListener("unhandledrejection", (event) => report.errors.push(String(event.reason)));
console.error = console.warn = (...words) => report.errors.push(words.join(" "));
// The server may be gone before it answers.
const send = () => fetch("REPORT/report", { method: "POST", mode: "no-cors", body: JSON.stringify(report) }).catch(() => {});
</script>
"#;
/// Chosen browser.
const VARIABLE: &str = "HANGTIME_BROWSER";

/// The browser to use: the chosen one, or one on the path; without one the reason is printed.
pub(crate) fn browser() -> Option<PathBuf> {
    if let Some(chosen) = std::env::var_os(VARIABLE) {
        return Some(chosen.into());
    }
    let path = std::env::var_os("PATH")?;
    let found = std::env::split_paths(&path)
        .flat_map(|folder| BROWSERS.map(|name| folder.join(name)))
        .find(|candidate| candidate.is_file());
    if found.is_none() {
        eprintln!(
            "skipped: no browser found; install chromium, or set {VARIABLE} to the path of one"
        );
    }
    found
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

/// Where a page is opened from.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Origin {
    /// A server.
    Server,
    /// The file system.
    #[cfg_attr(
        not(feature = "play"),
        expect(dead_code, reason = "only the page of `play` is opened so")
    )]
    File,
}

/// What the visitor saw, and what the browser said about the page on its console. The visitor is a script at the end of
/// the page that sends its `report`.
pub(crate) fn visit(
    browser: &Path,
    folder: &Path,
    page: &str,
    visitor: &str,
    origin: Origin,
) -> (Value, String) {
    visit_sized(browser, folder, page, visitor, origin, (1280, 800))
}

/// The same with a window of this width and height [px].
pub(crate) fn visit_sized(
    browser: &Path,
    folder: &Path,
    page: &str,
    visitor: &str,
    origin: Origin,
    (width, height): (u32, u32),
) -> (Value, String) {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}", server.local_addr().unwrap());
    let (before, after) = page.rsplit_once("</body>").unwrap();
    let page = format!("{before}{WITNESS}{visitor}{after}").replace("REPORT", &address);
    let opened = match origin {
        Origin::Server => address,
        Origin::File => {
            let file = folder.join("visited.html");
            std::fs::write(&file, &page).unwrap();
            format!("file://{}", file.display())
        }
    };
    let log = folder.join("browser.log");
    let child = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
        ])
        .arg(format!("--window-size={width},{height}"))
        .arg("--enable-logging=stderr")
        .arg(format!(
            "--user-data-dir={}",
            folder.join("profile").display()
        ))
        .arg(opened)
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
            Some("/") if origin == Origin::Server => ("200 OK", page.as_str()),
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
