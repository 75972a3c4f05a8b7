//! Running the binary, and looking at what it leaves.

use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::Value;

/// The words of a command line: those of a text, between its spaces, or a list of them.
pub(crate) trait Line {
    fn words(&self) -> Vec<&str>;
}

impl<T: AsRef<str> + ?Sized> Line for &T {
    fn words(&self) -> Vec<&str> {
        self.as_ref().split_whitespace().collect()
    }
}

impl Line for Vec<&str> {
    fn words(&self) -> Vec<&str> {
        self.clone()
    }
}

/// What a run has said.
pub(crate) struct Said {
    pub(crate) status: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Said {
    /// What `command` says.
    pub(crate) fn by(command: &mut Command) -> Self {
        let output = command.output().unwrap();
        let [out, err] =
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        Self {
            status: output.status.code(),
            out,
            err,
        }
    }

    /// Its standard output.
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap()
    }
}

/// The binary.
pub(crate) fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_hangtime"))
}

/// Runs the binary.
pub(crate) fn hangtime(line: impl Line) -> Said {
    Said::by(program().args(line.words()))
}

/// Standard output of a run that must succeed in silence.
pub(crate) fn solved(line: impl Line) -> String {
    let said = hangtime(line.words());
    assert_eq!(
        (said.status, &*said.err),
        (Some(0), ""),
        "{:?}",
        line.words()
    );
    said.out
}

pub(crate) fn json(line: impl Line) -> Value {
    serde_json::from_str(&solved(line)).unwrap()
}

/// The document of a run that ends with status 3, and the line that says why.
pub(crate) fn unsolved(line: impl Line) -> (Value, String) {
    let said = hangtime(line);
    assert_eq!(said.status, Some(3), "{}", said.err);
    assert_eq!(said.err.lines().count(), 1, "{}", said.err);
    (said.json(), said.err)
}

/// A path for one test, removed at the end.
pub(crate) struct Scratch(pub(crate) PathBuf);

impl Scratch {
    pub(crate) fn new(name: &str) -> Self {
        // Tests of one process run side by side.
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let process = std::process::id();
        let path = std::env::temp_dir().join(format!("hangtime-cli-{name}-{process}-{count}"));
        let _ = std::fs::remove_dir_all(&path);
        Self(path)
    }

    pub(crate) fn text(&self) -> &str {
        self.0.to_str().unwrap()
    }

    pub(crate) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(&self.0)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    pub(crate) fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).unwrap()
    }

    /// Writes a file; its path.
    pub(crate) fn write(&self, name: &str, text: impl AsRef<[u8]>) -> String {
        std::fs::create_dir_all(&self.0).unwrap();
        let path = self.0.join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    }

    /// Runs the binary in it.
    pub(crate) fn run(&self, line: impl Line) -> Said {
        Said::by(program().current_dir(&self.0).args(line.words()))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// One line that says what, where and how to mend it; status 2; nothing on the standard output.
pub(crate) fn refused(line: impl Line) -> String {
    let said = hangtime(line.words());
    let words = line.words();
    assert_eq!(
        (said.status, &*said.out),
        (Some(2), ""),
        "{words:?}: {}",
        said.err
    );
    let line = said
        .err
        .strip_prefix("error: ")
        .and_then(|line| line.strip_suffix('\n'));
    let line = line.unwrap_or_else(|| panic!("{words:?} should complain: {}", said.err));
    assert!(!line.contains('\n'), "{words:?}: {line}");
    line.to_owned()
}

/// The files of one result, in alphabetical order.
pub(crate) fn result_files(stem: &str) -> [String; 6] {
    [
        "-events.csv",
        "-time.svg",
        "-trajectory.csv",
        ".html",
        ".json",
        ".svg",
    ]
    .map(|ending| format!("{stem}{ending}"))
}

/// The JSON that a page carries in its script element `id`.
pub(crate) fn embedded(page: &str, id: &str) -> Value {
    let opening = format!("<script type=\"application/json\" id=\"{id}\">");
    let (_, rest) = page.split_once(&opening).unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

/// The page of a result loads nothing from elsewhere, carries the JSON of the result, and its frames are the motion.
pub(crate) fn assert_page_shows_its_result(scratch: &Scratch, stem: &str) {
    let page = scratch.read(&format!("{stem}.html"));
    for outside in ["<link", " src=", "@import", "url(http", "fetch(", "import "] {
        assert!(!page.contains(outside), "the page loads `{outside}`");
    }
    for (opened, closed) in [
        ("<script", "</script>"),
        ("<svg", "</svg>"),
        ("<div", "</div>"),
    ] {
        assert_eq!(page.matches(opened).count(), page.matches(closed).count());
    }
    let document: Value = serde_json::from_str(&scratch.read(&format!("{stem}.json"))).unwrap();
    if document["quantities"]["q"].as_array().unwrap().is_empty() {
        // Nothing moves in a scene of states only: its page has nothing to play.
        assert!(!page.contains("<script"));
        return;
    }
    assert_eq!(embedded(&page, "result"), document);
    let frames = embedded(&page, "frames");
    let times = frames["time"].as_array().unwrap();
    assert!(times.len() >= 200);
    // At a jump there is a frame on either side.
    assert!(times.is_sorted_by(|a, b| a.as_f64() <= b.as_f64()));
    assert_eq!(times.last().unwrap(), &document["final"]["time"]);
    for rows in ["positions", "forces"] {
        assert_eq!(frames[rows].as_array().unwrap().len(), times.len());
    }
    let events = document["events"].as_array().unwrap();
    assert_eq!(frames["events"].as_array().unwrap().len(), events.len());
    for event in events {
        assert!(times.contains(&event["time"]), "no frame at {event}");
    }
}

/// The same of a scene whose first coordinate is a horizontal position within its bodies.
pub(crate) fn assert_page_shows_its_ride(scratch: &Scratch, stem: &str) {
    assert_page_shows_its_result(scratch, stem);
    let page = scratch.read(&format!("{stem}.html"));
    let document: Value = serde_json::from_str(&scratch.read(&format!("{stem}.json"))).unwrap();
    let frames = embedded(&page, "frames");
    let end = frames["positions"].as_array().unwrap().last().unwrap();
    let bodies = end.as_array().unwrap();
    let across = bodies.iter().map(|body| body[0].as_f64().unwrap());
    let y = document["final"]["q"][0].as_f64().unwrap();
    let (least, most) = across.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| {
        (a.min(y), b.max(y))
    });
    assert!(least <= y && y <= most, "{least} <= {y} <= {most}");
}

/// Numbers from a seed (splitmix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In 0..1.
    pub(crate) fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn chance(&mut self, share: f64) -> bool {
        self.share() < share
    }

    pub(crate) fn pick<'a, T: ?Sized>(&mut self, choices: &[&'a T]) -> &'a T {
        choices[self.bits() as usize % choices.len()]
    }

    /// Log-uniform over six decades around a value.
    pub(crate) fn around(&mut self, value: f64) -> f64 {
        let factor = 10_f64.powf(6.0 * self.share() - 3.0);
        if value == 0.0 { factor } else { value * factor }
    }
}
