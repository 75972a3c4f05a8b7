//! The book: its scenes run, its commands print what it shows, its links lead somewhere.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

use hangtime_book::{
    Asked, Book, Chapter, Kind, PAGE, Page, Run, SceneText, Step, dead_links, fields_of_documents,
    fragment, mathml, words_of_results,
};
use serde_json::json;

use crate::browser::{Origin, browser, visit};
use crate::support::{Said, Scratch, program};

/// The root of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn book() -> Book {
    Book::read(&root().join("docs/book/src"), &root()).unwrap()
}

/// Its pages, with links that open scenes.
fn pages(book: &Book) -> Vec<Page> {
    hangtime_book::pages(book, true).unwrap()
}

/// Exit status and everything that is printed.
fn run(folder: &Path, arguments: &[String]) -> (Option<i32>, String) {
    let said = Said::by(program().current_dir(folder).args(arguments));
    (said.status, said.out + &said.err)
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

/// README as a chapter.
fn readme() -> Chapter {
    Chapter {
        file: "README.md".to_owned(),
        title: "hangtime".to_owned(),
        text: fs::read_to_string(root().join("README.md")).unwrap(),
    }
}

#[test]
fn readme_is_short_and_its_scenes_commands_and_links_are_as_it_says() {
    let readme = readme();
    assert!(readme.text.lines().count() <= 100);
    let (wrong, _) = follow(&readme);
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    let steps = readme.steps();
    assert!(steps.iter().any(|step| matches!(step, Step::Excerpt(_))));
    // What it shows of a command is what the command prints, digit for digit.
    let scratch = Scratch::new("readme");
    fs::create_dir_all(&scratch.0).unwrap();
    let mut runs = 0;
    for step in steps {
        match step {
            Step::Scene(scene) => fs::write(scratch.0.join(&scene.file), &scene.text).unwrap(),
            Step::Run(command) => {
                let (_, printed) = run(&scratch.0, &command.arguments);
                let mut lines = printed.lines();
                let shown = command.shown.iter().filter(|line| *line != "...");
                for line in shown {
                    assert!(lines.any(|other| other == line), "{line}\n{printed}");
                }
                runs += 1;
            }
            Step::Data(_) | Step::Excerpt(_) => {}
        }
    }
    assert!(runs > 0);
    let targets = readme.text.split("](").skip(1);
    let targets = targets.map(|rest| rest.split(')').next().unwrap());
    let lost = targets.filter(|target| !root().join(target).exists());
    assert_eq!(lost.collect::<Vec<_>>(), [""; 0]);
}

#[test]
fn builder_that_is_asked_for_help_or_in_vain_writes_nothing() {
    let asked = |words: &[&str]| {
        let words: Vec<_> = words.iter().map(Into::into).collect();
        Asked::read(&words)
    };
    for help in ["-h", "--help"] {
        assert_eq!(asked(&[help]), Ok(Asked::Help));
    }
    for wrong in ["--out", "-o", "--picture"] {
        let refusal = asked(&[wrong, "x"]).unwrap_err();
        assert!(refusal.starts_with(&format!("`{wrong}` is no option; hangtime-book")));
    }
    assert_eq!(asked(&["x"]), Ok(Asked::Book("x".into())));
    assert_eq!(asked(&[]), Ok(Asked::Book("out/book".into())));
    let pictures = Asked::Pictures(vec!["hop".to_owned()]);
    assert_eq!(asked(&["--pictures", "hop"]), Ok(pictures));
}

#[test]
fn every_chapter_is_a_page_that_needs_no_network() {
    let book = book();
    let generated = |file: &str| {
        let mut chapters = book.chapters.iter();
        chapters.any(|chapter| chapter.file == file && chapter.is_generated())
    };
    let mut files: Vec<String> = fs::read_dir(root().join("docs/book/src"))
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .filter(|file| file.ends_with(".md") && file != "SUMMARY.md" && !generated(file))
        .collect();
    let written = book
        .chapters
        .iter()
        .filter(|chapter| !chapter.is_generated());
    let mut listed: Vec<String> = written.map(|chapter| chapter.file.clone()).collect();
    files.sort();
    listed.sort();
    assert_eq!(listed, files, "the summary lists every chapter once");
    let pages = pages(&book);
    let exists = |target: &str| {
        let file = target.split('#').next().unwrap();
        file.is_empty()
            || file.starts_with("figures/")
            || file == PAGE
            || pages.iter().any(|page| page.file == file)
    };
    for page in &pages {
        for outside in ["http", "@import", "url(", "fetch(", " src=\"/"] {
            let html = page.html.replace("http://www.w3.org/2000/svg", "");
            assert!(
                !html.contains(outside),
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
    assert_eq!(report["turned"], json!(["not_yet.html", "exercises.html"]));
    assert_eq!(report["focus"], "Extending");
    assert_eq!(report["overflows"], false);
}

#[test]
fn every_scene_of_the_book_and_of_the_list_opens_in_the_page() {
    let book = book();
    let opening = pages(&book);
    for (chapter, page) in book.chapters.iter().zip(&opening) {
        let mut files: Vec<(String, String)> = Vec::new();
        for step in chapter.steps() {
            let Step::Scene(scene) = step else { continue };
            let before = match scene.kind {
                Kind::More => files.iter().rev().find(|(file, _)| *file == scene.file),
                Kind::Whole | Kind::Mistaken => None,
            };
            let text = before.map_or("", |(_, text)| text).to_owned() + &scene.text;
            files.push((scene.file, text));
        }
        for (file, text) in files {
            let name = file.strip_suffix(".hang").unwrap();
            let link = format!("href=\"{PAGE}#{}\"", fragment(name, &text));
            assert!(page.html.contains(&link), "{}: {file}", chapter.file);
        }
    }
    let gallery = opening
        .iter()
        .find(|page| page.file == "gallery.html")
        .unwrap();
    for scene in hangtime_models::scenes() {
        let text = scene.unread.or(scene.source).unwrap();
        let link = format!("href=\"{PAGE}#{}\"", fragment(scene.name, text));
        let drawn = scene.picture.lines().nth(1).unwrap_or_default();
        for part in [&link, scene.title, drawn] {
            assert!(gallery.html.contains(part), "{}: {part}", scene.name);
        }
        let about = scene.about().replace('"', "&quot;");
        assert!(gallery.html.contains(&about), "{}", scene.name);
        if let Some(question) = scene.question {
            let asked = question.asked.replace('"', "&quot;");
            assert!(gallery.html.contains(&asked), "{}", scene.name);
        }
    }
    let bare = hangtime_book::pages(&book, false).unwrap();
    let link = format!("{PAGE}#");
    assert!(bare.iter().all(|page| !page.html.contains(&link)));
}

/// Words in backticks at the beginning of the rows of tables.
fn rows(markdown: &str) -> Vec<&str> {
    let rows = markdown.lines().filter_map(|line| line.strip_prefix("| `"));
    rows.filter_map(|row| row.split('`').next()).collect()
}

/// The names of all fields of a document, however deep.
fn fields(document: &serde_json::Value, found: &mut Vec<String>) {
    match document {
        serde_json::Value::Object(map) => {
            for (name, value) in map {
                // Names of parameters and joints are those of the scene.
                if !matches!(name.as_str(), "parameters" | "free" | "joints") {
                    fields(value, found);
                }
                found.push(name.clone());
            }
        }
        serde_json::Value::Array(list) => list.iter().for_each(|value| fields(value, found)),
        _ => {}
    }
}

/// The text of a chapter.
fn chapter(file: &str) -> String {
    let mut chapters = book().chapters.into_iter();
    chapters.find(|chapter| chapter.file == file).unwrap().text
}

/// The sources below a folder.
fn sources(folder: &Path, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(fs::read_to_string(path).unwrap());
        }
    }
}

/// The texts that `fn name` of an enumeration gives, where it has one.
fn names_of(source: &str, enumeration: &str) -> Vec<String> {
    let body = source.split_once(&format!("impl {enumeration} {{\n"));
    let body = body.and_then(|(_, rest)| rest.split("\n}\n").next()?.split_once("fn name("));
    let arms = body.and_then(|(_, rest)| rest.split("\n    }\n").next());
    let texts = arms.unwrap_or_default().split('"').skip(1).step_by(2);
    texts.map(str::to_owned).collect()
}

#[test]
fn every_status_has_a_line_in_the_book() {
    let words = words_of_results(&root()).unwrap();
    let text = chapter("statuses.md");
    let listed = rows(&text);
    let results = chapter("results.md");
    for (title, entries) in &words {
        // What to do where one of these is the status is in the chapter on results.
        let explained = ["Simulations", "Optimal control"].contains(title);
        for entry in entries {
            assert!(listed.contains(&entry.name.as_str()), "{}", entry.name);
            let told = results.contains(&format!("`{}`", entry.name));
            assert!(told || !explained, "{title}: {}", entry.name);
        }
    }
    // Every enumeration of statuses in the sources is among them.
    let mut texts = Vec::new();
    for folder in ["runtime/src", "solver/src", "cli/src"] {
        sources(&root().join(folder), &mut texts);
    }
    let mut count = 0;
    for text in &texts {
        for rest in text.split("pub enum ").skip(1) {
            let enumeration = rest.split([' ', '<']).next().unwrap();
            if !enumeration.ends_with("Status") {
                continue;
            }
            for name in names_of(text, enumeration) {
                assert!(listed.contains(&name.as_str()), "{enumeration}: {name}");
                count += 1;
            }
        }
    }
    // Simulation, optimal control, estimation, programs.
    assert!(count >= 31, "{count}");
    assert!(listed.contains(&"memory_limit"));
}

#[test]
fn every_setting_has_a_line_in_the_book() {
    let text = chapter("settings.md");
    let settings = rows(&text);
    for command in ["simulate", "solve", "sweep", "chart", "nlp", "play", "list"] {
        let (_, help) = run(&root(), &[command.to_owned(), "--help".to_owned()]);
        let lines = help.lines().map(str::trim_start);
        let options = lines.filter_map(|line| line.strip_prefix("--"));
        let options = options.filter_map(|line| line.split([' ', '=', '[']).next());
        // Of all commands alike.
        let common = ["help", "version", "watch"];
        let mut own = options.filter(|option| !common.contains(option)).peekable();
        assert!(own.peek().is_some(), "{help}");
        for option in own {
            let typed = format!("--{option}");
            let mut rows = settings.iter();
            let found = rows.any(|row| row.split(' ').next() == Some(&typed));
            assert!(found, "{command} {typed}");
        }
    }
}

#[test]
fn every_field_of_a_document_has_a_line_in_the_book() {
    let documents = fields_of_documents(&root()).unwrap();
    let structures = documents.iter().flat_map(|(_, structures)| structures);
    let entries = structures.flat_map(|structure| &structure.fields);
    let known: Vec<&str> = entries.map(|entry| entry.name.as_str()).collect();
    assert_eq!(rows(&chapter("columns.md")), known);
    for command in [
        "simulate falling-rod --gradient mu --json",
        "simulate thermostat --json",
        "solve pump-track --intervals 6 --formulation time-freezing --json",
    ] {
        let mut found = Vec::new();
        fields(&crate::support::json(command), &mut found);
        for name in found {
            // Outputs stand in gradients by their names.
            let output = name == "tip" || name == "on";
            assert!(
                output || known.contains(&name.as_str()),
                "{command}: {name}"
            );
        }
    }
}

#[test]
fn formulas_are_set_and_what_is_none_is_refused() {
    let set = |formula: &str| mathml(formula, false).unwrap();
    for (formula, markup) in [
        (
            "M^{-1} n",
            "<msup><mi>M</mi><mrow><mi>\u{2212}</mi><mn>1</mn></mrow></msup><mi>n</mi>",
        ),
        (
            "v_n^+ \\le 0",
            "<msubsup><mi>v</mi><mi>n</mi><mi>+</mi></msubsup><mo>\u{2264}</mo><mn>0</mn>",
        ),
        (
            "\\frac{1}{2}",
            "<mfrac><mrow><mn>1</mn></mrow><mrow><mn>2</mn></mrow></mfrac>",
        ),
        (
            "\\dot{q}",
            "<mover><mrow><mi>q</mi></mrow><mi>\u{2d9}</mi></mover>",
        ),
        (
            "\\begin{cases} a & b \\\\ c & d \\end{cases}",
            "<mtr><mtd><mi>c</mi></mtd><mtd><mi>d</mi></mtd></mtr>",
        ),
    ] {
        assert!(set(formula).contains(markup), "{}", set(formula));
    }
    for (wrong, said) in [
        ("\\frak{g}", "unknown primitive command"),
        ("x_", "expected a token"),
        ("{a", "closed with `}`"),
        ("a}", "unexpected group closing"),
        ("\\begin{cases} a", "closed with `\\end{cases}`"),
    ] {
        let refusal = mathml(wrong, true).unwrap_err();
        assert!(refusal.contains(said), "{refusal}");
    }
    // Where a formula stands in the text there is one, and no letter of its notation is left.
    let book = book();
    let theory = pages(&book)
        .into_iter()
        .find(|page| page.file == "theory.html")
        .unwrap();
    assert!(theory.html.matches("<math").count() > 20);
    // The page that searches holds the text as it is written.
    for page in pages(&book)
        .iter()
        .filter(|page| page.file != "search.html")
    {
        let shown: String = page
            .html
            .split("alttext=\"")
            .map(|part| part.split_once("\">").map_or(part, |(_, rest)| rest))
            .collect();
        assert!(
            !shown.contains("\\frac") && !shown.contains("\\lambda"),
            "{}",
            page.file
        );
    }
}

/// Searches, and reports what is found.
const SEARCH: &str = r##"
<script>
words.value = "terminal drag";
words.dispatchEvent(new Event("input"));
report.none = document.getElementById("count").value;
words.value = "air drag";
words.dispatchEvent(new Event("input"));
report.first = document.querySelector("#found a").getAttribute("href");
report.count = document.querySelectorAll("#found li").length;
document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "/", bubbles: true }));
report.focus = document.activeElement.id;
send();
</script>
"##;

#[test]
fn book_is_searched_in_the_browser() {
    let pages = pages(&book());
    let page = pages
        .iter()
        .find(|page| page.file == "search.html")
        .unwrap();
    assert!(
        pages
            .iter()
            .all(|page| page.html.contains("<form action=\"search.html\""))
    );
    let Some(browser) = browser() else {
        return;
    };
    let scratch = Scratch::new("book-search");
    fs::create_dir_all(&scratch.0).unwrap();
    let (report, console) = visit(&browser, &scratch.0, &page.html, SEARCH, Origin::Server);
    assert_eq!(report["errors"], json!([]));
    assert_eq!(console, "");
    assert_eq!(report["none"], "0 places");
    assert_eq!(report["first"], "bodies.html#air-drag");
    assert!(report["count"].as_u64().unwrap() >= 1);
    assert_eq!(report["focus"], "asked");
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
