//! How the builder is called.

use std::ffi::OsString;
use std::path::PathBuf;

/// The first argument by which the pictures of the list of scenes are written.
const PICTURES: &str = "--pictures";
/// What may be asked for.
pub const USAGE: &str = "hangtime-book [FOLDER] writes the book, by default to out/book; hangtime-book --pictures [NAME ...] writes the pictures of \
     the list of scenes";

/// What the builder is asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Asked {
    /// How it is called.
    Help,
    /// The pictures of scenes, of all without names.
    Pictures(Vec<String>),
    /// The book, in this folder.
    Book(PathBuf),
}

impl Asked {
    /// Reads the arguments behind the name of the program.
    ///
    /// # Errors
    /// Options that do not exist: no folder is called like one.
    pub fn read(arguments: &[OsString]) -> Result<Self, String> {
        let Some(first) = arguments.first() else {
            return Ok(Self::Book(PathBuf::from("out/book")));
        };
        match first.to_string_lossy().as_ref() {
            "-h" | "--help" => Ok(Self::Help),
            PICTURES => {
                let names = arguments[1..].iter();
                let names = names.filter_map(|name| name.clone().into_string().ok());
                Ok(Self::Pictures(names.collect()))
            }
            option if option.starts_with('-') => Err(format!("`{option}` is no option; {USAGE}")),
            _ => Ok(Self::Book(PathBuf::from(first))),
        }
    }
}
