//! Builds the book into offline pages: `cargo run --release --bin hangtime-book [FOLDER]`, by default `out/book`.
//!
//! `hangtime-book --pictures [NAME ...]` writes the small pictures of the list of scenes instead, `models/pictures/NAME.svg`: of the optimum on the
//! control intervals for which the least objective is known, or of the motion where a scene asks nothing.
//!
//! Scenes open in the page of `hangtime play`, where that was written to the folder above, `out/play.html`, before.
//!
//! Figures are made by the commands that the book shows (those with `--out figures`), run by this program itself, and
//! taken from `docs/charts`. They are left in `docs/book/src/figures` as well, and chapters that the code writes in `docs/book/src`, where mdBook looks for them.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::io::{Error, Result};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use hangtime_book::{Asked, Book, Kind, PAGE, Step, USAGE, dead_links, pages};
use hangtime_cli::{CommandLine, HostScene, Scene};
use hangtime_models::{hard_optima, hard_scenes, scenes};

/// The first argument by which this program is the command line, for commands of the book.
const AS_COMMAND_LINE: &str = "--as-command-line";
fn main() -> ExitCode {
    let mut arguments = env::args_os();
    let program = arguments.next().unwrap_or_default();
    let arguments: Vec<OsString> = arguments.collect();
    if arguments
        .first()
        .is_some_and(|first| first == AS_COMMAND_LINE)
    {
        return CommandLine::new(scenes())
            .with_hard(hard_scenes())
            .with_hard_optima(hard_optima())
            .run([program].into_iter().chain(arguments.into_iter().skip(1)));
    }
    let done = match Asked::read(&arguments) {
        Ok(Asked::Help) => Ok(USAGE.to_owned()),
        Ok(Asked::Pictures(names)) => pictures(&names),
        Ok(Asked::Book(folder)) => built(&folder),
        Err(refusal) => Err(Error::other(refusal)),
    };
    match done {
        Ok(said) => {
            println!("{said}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Writes the pictures of scenes of the list, all of them without names.
fn pictures(names: &[String]) -> Result<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/pictures");
    let asked = |scene: &&Scene| names.is_empty() || names.iter().any(|name| name == scene.name);
    for scene in scenes().iter().filter(asked) {
        let picture =
            picture(scene).map_err(|said| Error::other(format!("{}: {said}", scene.name)))?;
        fs::write(folder.join(format!("{}.svg", scene.name)), picture)?;
    }
    Ok(format!("pictures in {}", folder.display()))
}

/// The picture of a scene; empty where nothing moves.
fn picture(scene: &Scene) -> std::result::Result<String, String> {
    let host = HostScene::open(scenes(), scene.name).map_err(|refusal| refusal.to_string())?;
    let run = match scene.question {
        Some(question) => {
            let intervals = Some(question.known.0).filter(|&intervals| intervals > 0);
            let words = intervals.map(|intervals| format!("--intervals={intervals}"));
            host.solve(words.as_slice(), &mut |_| true)
        }
        None => host.simulate(&[], &mut |_| true),
    };
    let run = run.map_err(|refusal| refusal.to_string())?;
    Ok(run.thumbnail().unwrap_or_default())
}

fn built(folder: &Path) -> Result<String> {
    let pages = build(folder)?;
    Ok(format!(
        "{pages} pages in {}",
        folder.join("index.html").display()
    ))
}

/// Writes pages and figures; how many pages.
fn build(folder: &Path) -> Result<usize> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let docs = root.join("docs");
    let source = docs.join("book/src");
    let book = Book::read(&source, &root)?;
    let figures = source.join("figures");
    if figures.exists() {
        fs::remove_dir_all(&figures)?;
    }
    copy_figures(&docs.join("charts"), &figures)?;
    draw(&book, &figures)?;
    let dead = dead_links(&book, |figure| figures.join(figure).exists());
    if !dead.is_empty() {
        return Err(Error::other(format!(
            "links that lead nowhere: {}",
            dead.join(", ")
        )));
    }
    copy_figures(&figures, &folder.join("figures"))?;
    for chapter in book
        .chapters
        .iter()
        .filter(|chapter| chapter.is_generated())
    {
        fs::write(source.join(&chapter.file), &chapter.text)?;
    }
    let opens = bring_page(folder)?;
    let pages = pages(&book, opens).map_err(Error::other)?;
    for page in &pages {
        fs::write(folder.join(&page.file), &page.html)?;
    }
    Ok(pages.len())
}

/// Puts the page of `hangtime play` beside the book, if it was written to the folder above; whether it is there.
fn bring_page(folder: &Path) -> Result<bool> {
    let page = folder.join(PAGE);
    let written = folder.join("..").join(PAGE);
    if written.exists() {
        fs::copy(written, &page)?;
    }
    if !page.exists() {
        println!(
            "without links that open scenes; `cargo run --release --features play -- play` writes the page in which they open, before the book"
        );
    }
    Ok(page.exists())
}

/// Runs the commands that leave figures, each chapter in a folder of its own.
fn draw(book: &Book, figures: &Path) -> Result<()> {
    for chapter in &book.chapters {
        let scratch = tempfile::tempdir()?;
        for step in chapter.steps() {
            match step {
                Step::Scene(scene) => {
                    let file = scratch.path().join(&scene.file);
                    let before = match scene.kind {
                        Kind::More => fs::read_to_string(&file)?,
                        Kind::Whole | Kind::Mistaken => String::new(),
                    };
                    fs::write(file, before + &scene.text)?;
                }
                Step::Data(data) => fs::write(scratch.path().join(&data.file), &data.text)?,
                Step::Run(command) if command.arguments.join(" ").contains("--out figures") => {
                    run(scratch.path(), &command.arguments)?;
                }
                Step::Run(_) | Step::Excerpt(_) => {}
            }
        }
        let drawn = scratch.path().join("figures");
        if drawn.exists() {
            copy_figures(&drawn, figures)?;
        }
    }
    Ok(())
}

fn run(folder: &Path, arguments: &[String]) -> Result<()> {
    let output = Command::new(env::current_exe()?)
        .current_dir(folder)
        .arg(AS_COMMAND_LINE)
        .args(arguments)
        .output()?;
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(Error::other(format!(
        "hangtime {}: {said}",
        arguments.join(" ")
    )))
}

/// Copies pictures and pages of motions.
fn copy_figures(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let path: PathBuf = entry?.path();
        let shown = path
            .extension()
            .is_some_and(|end| end == "svg" || end == "html");
        if let (true, Some(name)) = (shown, path.file_name()) {
            fs::copy(&path, to.join(name))?;
        }
    }
    Ok(())
}
