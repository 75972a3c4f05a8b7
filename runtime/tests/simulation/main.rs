//! Simulators against closed forms, certified values, and each other.

mod common;
mod conformance;
mod event_contact_modes;
mod event_driven;
mod event_properties;
mod event_scales;
mod fesd_accuracy;
mod fesd_against_event_driven;
mod fesd_complementarity;

mod fesd_friction;
mod fesd_laws_against_event_driven;
mod fesd_properties;
mod fesd_restitution;
mod fesd_shared_friction;
mod fesd_time_freezing;
mod friction_coupled;
mod friction_event;
mod friction_time_stepping;
mod front_door;
mod hidden_switches;
mod impact_clusters;
mod linear_controls;
mod modes_after_events;
mod promises;
mod restitution_event;
mod time_stepping;
