//! What the language says: texts of messages, pages, slips that people make, malformed declarations.

mod advice;
mod design;
mod format;
mod fuzz;
mod joints;
mod messages;
mod pages;
mod sensitivities;
mod shown;
mod slips;
mod states;
mod stumbles;
mod texts;
mod tokens;
