//! The book in `docs/book`: chapters in Markdown, the scenes and commands in them, and pages that need no network.
//!
//! The layout is that of mdBook (`src/SUMMARY.md` lists the chapters), which builds the same sources. This builder is
//! one more package of the workspace because it also makes the figures, by the commands that the book shows, and
//! because whoever has a Rust toolchain then needs no other tool.
//!
//! What a fenced block is follows from its first words:
//!
//! ```text
//! hang,NAME.hang            a scene: the file that the commands after it read
//! hang,NAME.hang,more       statements that are added to the end of that file
//! hang,NAME.hang,mistaken   a scene that is refused
//! console                   `$ hangtime ...` and what it prints; `...` stands for lines that are left out
//! rust,PATH                 a part of the file PATH of the repository
//! math                      a formula in a line of its own, as `$...$` is one within a sentence
//! ```

mod book;
mod formula;
mod gallery;
mod highlight;
mod language;
mod links;
mod open;
mod page;
mod pages;
mod reference;
mod search;
mod steps;
mod transcript;
mod usage;

pub use book::{Book, Chapter};
pub use formula::{in_markdown, mathml};
pub use links::dead_links;
pub use open::{PAGE, fragment};
pub use page::Page;
pub use pages::pages;
pub use reference::{Entry, Structure, fields_of_documents, words_of_results};
pub use steps::{Data, Excerpt, Kind, Run, SceneText, Step};
pub use usage::{Asked, USAGE};
