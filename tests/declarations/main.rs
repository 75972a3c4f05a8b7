//! What `model!` derives from a declaration, against independent routes.

mod derivation;
mod differences;
#[allow(dead_code, reason = "the bench draws more")]
#[path = "../../benches/agreement/draw.rs"]
mod draw;
mod emission;
mod formulas;
mod hygiene;
mod random_texts;
mod same;
mod values;
