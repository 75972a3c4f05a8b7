//! Derivation of scenes with parameters as coordinates without motion.

use crate::thread::on_a_thread;
use hangtime_dsl::description::Description;

/// A scene of that text, derived once more with those parameters (indices) as coordinates.
pub(crate) fn derived(
    scene: &Description,
    text: &str,
    parameters: &[usize],
) -> Result<Description, String> {
    let known = parameters.iter();
    let names: Vec<&str> = known
        .filter_map(|&index| Some(scene.parameters.get(index)?.name.as_str()))
        .collect();
    let derived = on_a_thread(&scene.name, |stem| {
        hangtime_dsl::describe_held(text, stem, &names)
    });
    let derived = derived.map_err(|error| format!("no thread for a derivation: {error}"))?;
    let (description, _) = derived.map_err(|mistakes| {
        let first = mistakes.into_iter().find(|mistake| !mistake.warning);
        first.map_or_else(String::new, |mistake| mistake.message)
    })?;
    Ok(description)
}
