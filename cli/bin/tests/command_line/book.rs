//! The book: its scenes run, its commands print what it shows, its links lead somewhere.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use hangtime_book::{Book, Chapter, Kind, Run, SceneText, Step, dead_links, pages};
use serde_json::json;

use crate::browser::{Origin, browser, visit};
use crate::support::Scratch;

/// The root of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn book() -> Book {
    Book::read(&root().join("docs/book/src")).unwrap()
}

/// Exit status and everything that is printed.
fn run(folder: &Path, arguments: &[String]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_hangtime"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap();
    let printed = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(printed).unwrap())
}

/// Writes a scene and checks it; what is wrong.
fn write(folder: &Path, scene: &SceneText) -> Option<String> {
    let path = folder.join(&scene.file);
    let before = match scene.kind {
        Kind::More => fs::read_to_string(&path).unwrap(),
        Kind::Whole | Kind::Mistaken => String::new(),
    };
    fs::write(&path, before + &scene.text).unwrap();
    let command = |words: &[&str]| -> (Option<i32>, String) {
        let words = words.iter().copied().chain([scene.file.as_str()]);
        run(folder, &words.map(str::to_owned).collect::<Vec<_>>())
    };
    let expected = if scene.kind == Kind::Mistaken { 2 } else { 0 };
    let (status, printed) = command(&["check"]);
    if status != Some(expected) {
        return Some(format!("{}: {printed}", scene.file));
    }
    // Added statements stand at the end, wherever the style would have them.
    if scene.kind != Kind::Whole {
        return None;
    }
    let (status, printed) = command(&["fmt", "--check"]);
    (status != Some(0)).then_some(printed)
}

fn compare(folder: &Path, command: &Run) -> Option<String> {
    let (_, printed) = run(folder, &command.arguments);
    let difference = command.difference(&printed)?;
    Some(format!(
        "`hangtime {}`: {difference}",
        command.arguments.join(" ")
    ))
}

/// Follows a chapter in a fresh folder; what is not as it says. Figures that it shows are counted among the files that
/// its commands leave.
fn follow(chapter: &Chapter) -> (Vec<String>, Vec<String>) {
    let scratch = Scratch::new("book");
    fs::create_dir_all(&scratch.0).unwrap();
    let wrong = |step: &Step| match step {
        Step::Scene(scene) => write(&scratch.0, scene),
        Step::Data(data) => {
            fs::write(scratch.0.join(&data.file), &data.text).unwrap();
            None
        }
        Step::Run(command) => compare(&scratch.0, command),
        Step::Excerpt(excerpt) => {
            let source = fs::read_to_string(root().join(&excerpt.file)).unwrap();
            let parts = excerpt.text.split("// ...\n");
            let lost = parts.filter(|part| !source.contains(part.trim_end()));
            lost.map(|part| format!("not in {}: {part}", excerpt.file))
                .next()
        }
    };
    let steps = chapter.steps();
    let wrong = steps.iter().filter_map(wrong);
    let wrong = wrong
        .map(|said| format!("{}: {said}", chapter.file))
        .collect();
    let drawn = fs::read_dir(scratch.0.join("figures"))
        .into_iter()
        .flatten();
    let drawn = drawn.map(|file| file.unwrap().file_name().into_string().unwrap());
    (wrong, drawn.collect())
}

#[test]
fn scenes_commands_and_links_of_the_book_are_as_it_says() {
    let book = book();
    let followed: Vec<_> = thread::scope(|scope| {
        let chapters = book.chapters.iter();
        let running: Vec<_> = chapters
            .map(|chapter| scope.spawn(move || follow(chapter)))
            .collect();
        running
            .into_iter()
            .map(|chapter| chapter.join().unwrap())
            .collect()
    });
    let (wrong, figures): (Vec<_>, Vec<_>) = followed.into_iter().unzip();
    let wrong = wrong.concat();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    let figures = figures.concat();
    let charts = root().join("docs/charts");
    let dead = dead_links(&book, |name| {
        figures.iter().any(|figure| figure == name) || charts.join(name).exists()
    });
    assert_eq!(dead, [""; 0]);
}

#[test]
fn every_chapter_is_a_page_that_needs_no_network() {
    let book = book();
    let mut files: Vec<String> = fs::read_dir(root().join("docs/book/src"))
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .filter(|file| file.ends_with(".md") && file != "SUMMARY.md")
        .collect();
    let mut listed: Vec<String> = book
        .chapters
        .iter()
        .map(|chapter| chapter.file.clone())
        .collect();
    files.sort();
    listed.sort();
    assert_eq!(listed, files, "the summary lists every chapter once");
    let pages = pages(&book);
    let exists = |target: &str| {
        let file = target.split('#').next().unwrap();
        file.is_empty()
            || file.starts_with("figures/")
            || pages.iter().any(|page| page.file == file)
    };
    for page in &pages {
        for outside in ["http", "@import", "url(", "fetch(", " src=\"/"] {
            assert!(
                !page.html.contains(outside),
                "{} contains `{outside}`",
                page.file
            );
        }
        for target in page.html.split("href=\"").skip(1) {
            let target = target.split('"').next().unwrap();
            assert!(exists(target), "{}: {target}", page.file);
            if let Some(place) = target.strip_prefix('#') {
                assert!(
                    page.html.contains(&format!("id=\"{place}\"")),
                    "{}: {target}",
                    page.file
                );
            }
        }
    }
}

#[test]
fn three_scenes_are_declared_and_drawn_within_thirty_lines() {
    let book = book();
    let mut chapters = book.chapters.iter();
    let chapter = chapters.find(|chapter| chapter.file == "three_scenes.md");
    let scenes: Vec<SceneText> = chapter
        .unwrap()
        .steps()
        .into_iter()
        .filter_map(|step| match step {
            Step::Scene(scene) if scene.kind == Kind::Whole => Some(scene),
            _ => None,
        })
        .collect();
    assert_eq!(scenes.len(), 3);
    for scene in scenes {
        let lines = scene.text.lines().count();
        assert!(lines <= 30, "{}: {lines} lines", scene.file);
        assert!(scene.text.contains("picture {"), "{}", scene.file);
    }
}

/// Presses keys on a page; links that turn pages are noted and not followed.
const KEYS: &str = r#"
<script>
const turned = [];
document.querySelector(".turn").addEventListener("click", (event) => {
  event.preventDefault();
  turned.push(event.target.closest("a").getAttribute("href"));
});
const press = (key, at) => at.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
press("ArrowRight", document.body);
press("ArrowLeft", document.body);
press("ArrowRight", document.querySelector("pre"));
press("c", document.body);
report.turned = turned;
report.focus = document.activeElement.textContent;
report.overflows = document.documentElement.scrollWidth > innerWidth;
send();
</script>
"#;

#[test]
fn keys_turn_pages_and_lead_to_the_contents() {
    let Some(browser) = browser() else {
        return;
    };
    let scratch = Scratch::new("book-keys");
    fs::create_dir_all(&scratch.0).unwrap();
    let pages = pages(&book());
    // A page without figures, as the visitor's server has none.
    let page = pages.iter().find(|page| page.file == "extending.html");
    let page = &page.unwrap().html;
    let (report, console) = visit(&browser, &scratch.0, page, KEYS, Origin::Server);
    assert_eq!(report["errors"], json!([]));
    assert_eq!(console, "");
    assert_eq!(report["turned"], json!(["not_yet.html", "failing.html"]));
    assert_eq!(report["focus"], "Extending");
    assert_eq!(report["overflows"], false);
}

#[test]
fn what_the_book_gets_wrong_is_found() {
    let chapter = |file: &str, text: &str| Chapter {
        file: file.to_owned(),
        title: file.to_owned(),
        text: text.to_owned(),
    };
    let lost = Book {
        chapters: vec![
            chapter(
                "a.md",
                "# Here\n[b](b.md#there) [c](c.md) [up](#here) ![f](figures/f.svg)",
            ),
            chapter(
                "b.md",
                "## There\n[no](a.md#there) ![g](figures/g.svg) [out](https://example.com)",
            ),
        ],
    };
    assert_eq!(
        dead_links(&lost, |figure| figure == "f.svg"),
        [
            "a.md: c.md",
            "b.md: a.md#there",
            "b.md: figures/g.svg",
            "b.md: https://example.com"
        ]
    );
    let shown = |block: &str| {
        let text = format!("```console\n$ hangtime list\n{block}\n```\n");
        match chapter("a.md", &text).steps().remove(0) {
            Step::Run(command) => command,
            other => panic!("{other:?} is no command"),
        }
    };
    let printed = "status  solved\n\nend     1.25 m\ntime    3 ms\nnote    one\n";
    for right in [
        "status solved\n...",
        "...\nend 1.2500000001 m\n...",
        "status solved\n...\nnote one",
        "status solved\nend 1.25 m\ntime 3 ms\nnote one",
        "...",
    ] {
        assert_eq!(shown(right).difference(printed), None, "{right}");
    }
    for wrong in [
        "status solved",
        "status failed\n...",
        "...\nend 1.2501 m\n...",
        "end 1.25 m\n...",
        "...\nnote one\n...\nend 1.25 m\n...",
        "status solved\n...\ntime 3 ms",
        "...\nend 1.25\n...",
    ] {
        assert!(shown(wrong).difference(printed).is_some(), "{wrong}");
    }
}
