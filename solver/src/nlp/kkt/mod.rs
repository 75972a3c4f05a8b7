//! The Newton system and its shifts.

mod inertia_correction;
mod kkt_system;

pub(super) use inertia_correction::InertiaCorrection;
pub(super) use kkt_system::KktSystem;
