//! `hangtime check`, `hangtime fmt` and `hangtime new`: for those who write scene files.

use std::fs::{self, File};
use std::io::{ErrorKind, Write as _};
use std::path::Path;

use hangtime::model::Model as _;

use crate::arguments::{CheckArguments, FormatArguments, NewArguments};
use crate::failure::BadInput;
use crate::report::Report;
use crate::scene_file::{EXTENSION, formatted, is_path, read};
use crate::table::counted;

/// A scene to begin with; it simulates and solves as it stands.
pub(crate) const TEMPLATE: &str = include_str!("template.hang");

/// Reports the mistakes of a scene file.
pub(crate) fn check(arguments: &CheckArguments) -> Result<Report, BadInput> {
    let file = &arguments.file;
    must_be_path(file)?;
    let scene = read(file)?;
    let declaration = scene.declaration();
    Ok(Report::of(format!(
        "{file}: no mistakes; `{}` has {}, {} and {}\n",
        declaration.name,
        match declaration.states.len() {
            0 => counted(declaration.mechanical(), "coordinate"),
            states => format!(
                "{}, {}",
                counted(declaration.mechanical(), "coordinate"),
                counted(states, "state")
            ),
        },
        counted(declaration.controls.len(), "control"),
        counted(declaration.contacts.len(), "contact"),
    )))
}

fn must_be_path(file: &str) -> Result<(), BadInput> {
    if is_path(file) {
        return Ok(());
    }
    Err(BadInput::new(format!(
        "`{file}`: give a scene file, whose name ends with .{EXTENSION}"
    )))
}

/// Writes scene files in the settled style, or tells which of them are not.
pub(crate) fn format(arguments: &FormatArguments) -> Result<Report, BadInput> {
    let mut changed = Vec::new();
    for file in &arguments.files {
        must_be_path(file)?;
        let (before, after) = formatted(file)?;
        if before == after {
            continue;
        }
        changed.push(file.as_str());
        if !arguments.check {
            replace(file, &after).map_err(|error| {
                BadInput::new(format!(
                    "{file}: {error}; the file is left as it is, choose one that can be written"
                ))
            })?;
        }
    }
    let rest = arguments.files.len() - changed.len();
    let rest = format!("{} in the settled style already", counted(rest, "file"));
    if changed.is_empty() {
        return Ok(Report::of(format!("{rest}\n")));
    }
    let list = changed.join(", ");
    if arguments.check {
        return Err(BadInput::new(format!(
            "{list}: not in the settled style; run `hangtime fmt {}`",
            changed.join(" ")
        )));
    }
    Ok(Report::of(format!("wrote {list}; {rest}\n")))
}

/// Puts a new file in the place of one, whole or not at all.
fn replace(file: &str, text: &str) -> std::io::Result<()> {
    let path = fs::canonicalize(file)?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut written = tempfile::NamedTempFile::new_in(folder)?;
    written.write_all(text.as_bytes())?;
    written.as_file().sync_all()?;
    fs::set_permissions(written.path(), fs::metadata(&path)?.permissions())?;
    written.persist(&path)?;
    Ok(())
}

/// Writes a scene to begin with.
pub(crate) fn new(arguments: &NewArguments) -> Result<Report, BadInput> {
    let name = arguments
        .name
        .strip_suffix(".hang")
        .unwrap_or(&arguments.name);
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if !name.chars().all(fits) || !name.starts_with(|c: char| c.is_ascii_alphanumeric()) {
        return Err(BadInput::new(format!(
            "`{name}`: name the scene with ASCII letters, digits, `-` and `_`, a letter or digit first"
        )));
    }
    let file = format!("{name}.{EXTENSION}");
    let text = TEMPLATE.replace("NAME", &file);
    let written = File::create_new(Path::new(&file))
        .and_then(|mut created| created.write_all(text.as_bytes()));
    written.map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => BadInput::new(format!(
            "{file}: the file exists and is left as it is; choose another name"
        )),
        _ => BadInput::new(format!(
            "{file}: {error}; choose a folder that can be written to"
        )),
    })?;
    Ok(Report::of(format!(
        "wrote {file}; `hangtime simulate {file} --out out` plays it\n"
    )))
}
