//! Scenes from files, which run without a compiler.
//!
//! A file `NAME.hang` holds what stands inside `hangtime::model! { ... }`, or only the statements. [`read`] derives it
//! and gives a [`TextScene`], a [`hangtime::model::Model`] like any other:
//!
//! ```
//! use hangtime::prelude::*;
//!
//! let ball = hangtime_scene_files::of_text("ball.hang", "
//!     parameters { m: kg = 1, g: m/s^2 = 9.81, height: m = 1 }
//!     coordinates { z: m }
//!     lagrangian m/2*dot(z)^2 - m*g*z
//!     surface floor: z >= 0
//!     impact floor: inelastic
//!     start { z: height }
//!     horizon 1 [s]
//! ")?;
//! let fall = simulate(&ball).run()?;
//! assert!((fall.events[0].time - (2.0 / 9.81_f64).sqrt()).abs() < 1e-9);
//!
//! let refusal = hangtime_scene_files::of_text("ball.hang", "coordinates { z: m } lagrangian z'").unwrap_err();
//! assert!(refusal.to_string().contains("dot(z)"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A file is data: it can name no path and no command, and whatever it holds takes bounded time and memory.

mod report;

pub use hangtime::scene::TextScene;
pub use hangtime_dsl::TextMistake;

use hangtime::scene::{self, TooLarge};
use std::fmt;
use std::io;
use std::path::Path;

/// As [`scene::on_a_thread`], for the text of a file.
fn on_a_thread<T: Send>(file: &str, work: impl FnOnce(&str) -> T + Send) -> Result<T, SceneError> {
    let stem = Path::new(file).file_stem().unwrap_or_default();
    scene::on_a_thread(&stem.to_string_lossy(), work).map_err(|error| {
        SceneError::Unreadable(format!(
            "scene file `{file}`: no thread for its derivation: {error}"
        ))
    })
}

/// Why a scene was refused.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneError {
    /// The file was not read, or is no text; one line says why.
    Unreadable(String),
    /// The text has mistakes.
    Mistakes {
        /// All of them, and warnings.
        mistakes: Vec<TextMistake>,
        /// The same for people: file, line, column, the line itself with a mark below it.
        report: String,
    },
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(line) => f.write_str(line),
            Self::Mistakes { report, .. } => f.write_str(report),
        }
    }
}

impl std::error::Error for SceneError {}

/// Reads a scene from a file.
///
/// What the scene declares stays in memory until the program ends, some kilobytes for each file that is read.
///
/// # Errors
/// The file cannot be read, or its text has mistakes.
pub fn read(file: &Path) -> Result<TextScene, SceneError> {
    of_text(&file.display().to_string(), &read_text(file)?)
}

/// The text of a scene file, and the same in the settled style of [`hangtime_dsl::format_text`].
///
/// # Errors
/// The file cannot be read, or its text has mistakes.
pub fn format(file: &Path) -> Result<(String, String), SceneError> {
    let whole = read_text(file)?;
    let formatted = format_text(&file.display().to_string(), &whole)?;
    let (_, own, _) = hangtime_dsl::in_used(&whole, &(0..0));
    Ok((own.to_owned(), formatted))
}

/// A text in the settled style; `file` is what its messages call the file.
///
/// # Errors
/// The text has mistakes.
pub fn format_text(file: &str, text: &str) -> Result<String, SceneError> {
    let formatted = on_a_thread(file, |stem| hangtime_dsl::format_text(text, stem))?;
    formatted.map_err(|mistakes| SceneError::Mistakes {
        report: report::report(file, text, &mistakes),
        mistakes,
    })
}

/// Reads the text of a scene file, whatever stands in it, with those of the files that it uses behind it, which are found from
/// where it stands ([`hangtime_dsl::with_used`]).
///
/// # Errors
/// A file cannot be read, is too long for a scene, or is no text.
pub fn read_text(file: &Path) -> Result<String, SceneError> {
    let used = |name: &str| alone(&file.with_file_name(name)).map_err(|error| error.to_string());
    hangtime_dsl::with_used(&alone(file)?, used).map_err(SceneError::Unreadable)
}

/// The text of a file.
fn alone(file: &Path) -> Result<String, SceneError> {
    let shown = file.display();
    let unreadable = |why: String| SceneError::Unreadable(format!("scene file `{shown}`: {why}"));
    let bytes = hangtime_dsl::read_whole(file, hangtime_dsl::LONGEST).map_err(|error| {
        unreadable(match error.kind() {
            io::ErrorKind::InvalidInput => error.to_string(),
            _ => format!("{error}; give the path of a file that can be read"),
        })
    })?;
    String::from_utf8(bytes).map_err(|error| {
        let place = error.utf8_error().valid_up_to();
        unreadable(format!(
            "byte {place} is no text in UTF-8; save it as UTF-8"
        ))
    })
}

/// Derives a scene from a text; `file` is what its messages call the file, and the name of a scene without one follows
/// from it.
///
/// What the scene declares stays in memory until the program ends.
///
/// ```
/// let text = "parameters { m: kg = 1, k: N/m = 2 } coordinates { z: m } lagrangian m/2*dot(z)^2";
/// let scene = hangtime_scene_files::of_text("ball.hang", text)?;
/// assert!(scene.warnings().starts_with("warning[E16]: parameter `k` is never used"));
/// assert!(scene.warnings().ends_with("ball.hang: 1 warning"));
/// let scene = hangtime_scene_files::of_text("ball.hang", &text.replace(", k: N/m = 2", ""))?;
/// assert!(scene.warnings().is_empty());
/// # Ok::<(), hangtime_scene_files::SceneError>(())
/// ```
///
/// # Errors
/// The text has mistakes.
pub fn of_text(file: &str, text: &str) -> Result<TextScene, SceneError> {
    let refuse = |mistakes: Vec<TextMistake>| SceneError::Mistakes {
        report: report::report(file, text, &mistakes),
        mistakes,
    };
    let derived = on_a_thread(file, |stem| hangtime_dsl::describe_text(text, stem))?;
    let (description, warnings) = derived.map_err(refuse)?;
    let report = report::report(file, text, &warnings);
    TextScene::new(description, text, report).map_err(|TooLarge| {
        refuse(vec![TextMistake {
            code: Some("E22"),
            message:
                "a derived function has too many values; split the mechanism into smaller scenes"
                    .to_owned(),
            warning: false,
            place: 0..0,
        }])
    })
}
