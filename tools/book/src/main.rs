//! Builds the book into offline pages: `cargo run --release --bin hangtime-book [FOLDER]`, by default `out/book`.
//!
//! Figures are made by the commands that the book shows (those with `--out figures`), run by this program itself, and
//! taken from `docs/charts`. They are left in `docs/book/src/figures` as well, where mdBook looks for them.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::io::{Error, Result};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use hangtime_book::{Book, Kind, Step, dead_links, pages};
use hangtime_cli::CommandLine;
use hangtime_models::{hard_optima, hard_scenes, scenes};

/// The first argument by which this program is the command line, for commands of the book.
const AS_COMMAND_LINE: &str = "--as-command-line";

fn main() -> ExitCode {
    let mut arguments = env::args_os();
    let program = arguments.next().unwrap_or_default();
    let folder = arguments.next();
    if folder
        .as_deref()
        .is_some_and(|first| first == AS_COMMAND_LINE)
    {
        return CommandLine::new(scenes())
            .with_hard(hard_scenes())
            .with_hard_optima(hard_optima())
            .run([program].into_iter().chain(arguments));
    }
    let folder = folder.unwrap_or_else(|| OsString::from("out/book"));
    match build(Path::new(&folder)) {
        Ok(pages) => {
            println!(
                "{pages} pages in {}",
                Path::new(&folder).join("index.html").display()
            );
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Writes pages and figures; how many pages.
fn build(folder: &Path) -> Result<usize> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let source = docs.join("book/src");
    let book = Book::read(&source)?;
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
    let pages = pages(&book);
    for page in &pages {
        fs::write(folder.join(&page.file), &page.html)?;
    }
    Ok(pages.len())
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
