//! `hangtime check` and `hangtime new`: for those who write scene files.

use std::fs::File;
use std::io::{ErrorKind, Write as _};
use std::path::Path;

use hangtime::model::Model as _;

use crate::arguments::{CheckArguments, NewArguments};
use crate::failure::BadInput;
use crate::report::Report;
use crate::scene_file::{EXTENSION, is_path, read};
use crate::table::counted;

/// A scene to begin with; it simulates and solves as it stands.
const TEMPLATE: &str = include_str!("template.hang");

/// Reports the mistakes of a scene file.
pub(crate) fn check(arguments: &CheckArguments) -> Result<Report, BadInput> {
    let file = &arguments.file;
    if !is_path(file) {
        return Err(BadInput::new(format!(
            "`{file}`: give a scene file, whose name ends with .{EXTENSION}"
        )));
    }
    let scene = read(file)?;
    let declaration = scene.declaration();
    Ok(Report::of(format!(
        "{file}: no mistakes; `{}` has {}, {} and {}\n",
        declaration.name,
        counted(declaration.coordinates.len(), "coordinate"),
        counted(declaration.controls.len(), "control"),
        counted(declaration.contacts.len(), "contact"),
    )))
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
