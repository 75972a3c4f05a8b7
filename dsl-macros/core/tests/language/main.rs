//! What the language says: texts of messages, pages, slips that people make, malformed declarations.

mod advice;
mod format;
mod fuzz;
mod messages;
mod pages;
mod sensitivities;
mod shown;
mod slips;
mod states;
mod stumbles;
mod texts;
mod tokens;
