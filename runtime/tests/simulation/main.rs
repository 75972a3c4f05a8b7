//! Simulators against closed forms, certified values, and each other.

mod common;
mod conformance;
mod dry_friction;
mod edges;
mod event_scales;
mod fesd_laws_against_event_driven;
mod fesd_time_freezing;
mod front_door;
mod impulses;
mod linear_controls;
mod modes_after_events;
mod random_motions;
mod time_stepping;
