//! A text derived once more, for what has to know about some of its parameters.

use super::data::Structure;
use super::text::{Again, Declared, Shared, TextScene};
use super::thread::on_a_thread;
use hangtime_dsl::description::Description;
use hangtime_dsl::{describe_differentiated, describe_held};
use std::sync::Arc;

/// What copies share of a scene that is derived once more from its text with those parameters (indices), unless that was done before.
///
/// # Errors
/// The first mistake, or that it is too large.
pub(super) fn derived(
    declared: &Declared,
    again: Again,
    parameters: &[usize],
) -> Result<Arc<Shared>, String> {
    if let Some(known) = declared.find(again, parameters) {
        return Ok(known);
    }
    let description = description(declared.structure, &declared.text, (again, parameters))?;
    let derived = TextScene::new(description, &declared.text, String::new());
    let shared = derived.map_err(|_| TOO_LARGE.to_owned())?.shared;
    declared.keep(again, parameters, &shared);
    Ok(shared)
}

/// What is derived from a text with those parameters; an error is the first mistake.
fn description(
    scene: &Structure,
    text: &str,
    (again, parameters): (Again, &[usize]),
) -> Result<Description, String> {
    let known = parameters.iter();
    let names: Vec<&str> = known
        .filter_map(|&index| Some(scene.declaration.parameters.get(index)?.name))
        .collect();
    let derived = on_a_thread(scene.declaration.name, |stem| match again {
        Again::Same | Again::Differentiated => describe_differentiated(text, stem, &names),
        Again::Held => describe_held(text, stem, &names),
    });
    let derived = derived.map_err(|error| format!("no thread for a derivation: {error}"))?;
    let (description, _) = derived.map_err(|mistakes| {
        let first = mistakes.into_iter().find(|mistake| !mistake.warning);
        first.map_or_else(String::new, |mistake| mistake.message)
    })?;
    Ok(description)
}

/// Why a scene with unknown parameters is refused.
const TOO_LARGE: &str = "a function derived with parameters as unknowns has too many values; split the mechanism into smaller scenes";
