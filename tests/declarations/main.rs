//! What `model!` derives from a declaration, against independent routes.

#[macro_use]
mod support;

mod chain;
mod contact_laws;
mod derivatives;
mod dry_friction;
mod forces;
mod hygiene;
mod impact_laws;
mod joints;
mod optimal_control_functions;
mod profiles;
mod repetition;
mod same;
mod scene_texts;
mod shown;
