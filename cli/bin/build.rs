//! Builds the module of the page, if the feature `play` asks for it: the package `hangtime-play` for WebAssembly, by
//! the same toolchain, in a folder of its own.

use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    #[cfg(feature = "play")]
    module::build()?;
    Ok(())
}

/// How the book sets its formulas; its package is none that this one could depend on, as it is not published.
#[cfg(feature = "play")]
#[expect(unreachable_pub, reason = "in the book's package it is public")]
#[path = "../../tools/book/src/formula.rs"]
mod formula;

/// The reference of the language, likewise.
#[cfg(feature = "play")]
#[path = "../../tools/book/src/language.rs"]
mod language;

#[cfg(feature = "play")]
mod module {
    use std::env;
    use std::error::Error;
    use std::fmt::Write as _;
    use std::fs::{self, File};
    use std::path::{Path, PathBuf};
    use std::process::Command;

    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write as _;

    const TARGET: &str = "wasm32-unknown-unknown";
    /// Vectors of two numbers, which all browsers have; they save a fifth of the time of `solve`.
    const FLAGS: &str = "-Ctarget-feature=+simd128";
    /// What the module is made of, from the folder of this package.
    const SOURCES: [&str; 8] = [
        "../../Cargo.lock",
        "../../dsl-macros",
        "../../play",
        "../../runtime/src",
        "../../scene-files/src",
        "../../solver/src",
        "../../units/src",
        "../src",
    ];

    /// The book, from the folder of this package.
    const BOOK: &str = "../../docs/book/src";
    /// The root of the repository, from the book.
    const ROOT: &str = "../../..";

    pub(crate) fn build() -> Result<(), Box<dyn Error>> {
        let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").ok_or("no manifest")?);
        let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("no output directory")?);
        for source in SOURCES {
            println!("cargo:rerun-if-changed={source}");
        }
        // `target/release/build/hangtime-bin-.../out`: all profiles share what was built for the module.
        let target = out.ancestors().nth(4).ok_or("no target folder")?;
        let folder = target.join("module");
        let built = Command::new(env::var_os("CARGO").ok_or("no cargo")?)
            .current_dir(here.join("../../play"))
            .args(["build", "--lib", "--profile", "play", "--target", TARGET])
            .arg("--target-dir")
            .arg(&folder)
            .env("CARGO_ENCODED_RUSTFLAGS", FLAGS)
            // Wrappers of the outer build, such as that of clippy, are not for this one.
            .env_remove("RUSTC_WRAPPER")
            .env_remove("RUSTC_WORKSPACE_WRAPPER")
            .status()?;
        if !built.success() {
            return Err(format!(
                "the module of the page was not built; `rustup target add {TARGET}` brings what may be missing"
            )
            .into());
        }
        let module = fs::read(folder.join(TARGET).join("play/hangtime_play.wasm"))?;
        let mut packed = GzEncoder::new(File::create(out.join("module.gz"))?, Compression::best());
        packed.write_all(&module)?;
        packed.finish()?;
        let book = here.join(BOOK);
        println!("cargo:rerun-if-changed={BOOK}");
        fs::write(out.join("chapters.rs"), chapters(&book)?)?;
        Ok(())
    }

    /// The chapters that the summary of the book links to, as an array in Rust.
    fn chapters(book: &Path) -> Result<String, Box<dyn Error>> {
        let mut array = String::from("&[");
        for line in fs::read_to_string(book.join("SUMMARY.md"))?.lines() {
            let link = line
                .split_once('[')
                .and_then(|(_, rest)| rest.split_once("]("));
            let Some((title, file)) = link else { continue };
            let file = file.trim_end_matches(')');
            let text = if file == crate::language::FILE {
                crate::language::chapter(&fs::read_to_string(
                    book.join(ROOT).join(crate::language::SOURCE),
                )?)
            } else if crate::language::GENERATED.contains(&file) {
                // Of what only the book's own program knows.
                continue;
            } else {
                fs::read_to_string(book.join(file))?
            };
            let text = crate::formula::in_markdown(&text)?;
            write!(
                array,
                "PlayChapter {{ file: {file:?}, title: {title:?}, text: {text:?} }},"
            )?;
        }
        Ok(array + "]")
    }
}
