//! Shipped scenes and examples: certified solutions, closed forms, and each other.

mod agreement;
mod bike_on_two_wheels;
mod both;
mod charts;
mod closed_forms;
mod convergence_order;
mod design;
mod enclosed;
mod estimation;
mod four_bar;
mod gradient;
mod joints;
mod largest;
mod many_contacts;
mod own_command_line;
mod periodic;
mod published_data;
mod published_results;
mod pump_track;
mod random;
mod scene_files;
#[path = "../stability/mod.rs"]
mod stability;
mod states;
mod switches_meet;
mod teaching_models;
mod zoo;
