//! What `model!` derives from a declaration, against independent routes.

mod derivation;
mod differences;
mod emission;
mod formulas;
mod hygiene;
mod random_texts;
mod same;
mod values;
