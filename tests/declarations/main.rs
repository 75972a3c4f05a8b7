//! What `model!` derives from a declaration, against independent routes.

#[path = "../../dsl-macros/core/src/random_texts.rs"]
mod random_texts;

mod derivation;
mod differences;
mod emission;
mod hygiene;
mod same;
mod values;
