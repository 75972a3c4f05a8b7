//! A text derived once more, for what has to know about some of its parameters.

use crate::thread::on_a_thread;
use hangtime_dsl::description::Description;
use hangtime_dsl::{describe_differentiated, describe_held};

/// What parameters are in a scene that is derived once more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Again {
    /// Functions have derivatives by them.
    Differentiated,
    /// They are coordinates without motion.
    Held,
}

/// A scene of that text, derived once more with those parameters (indices); an error is the first mistake.
pub(crate) fn derived(
    scene: &Description,
    text: &str,
    (again, parameters): (Again, &[usize]),
) -> Result<Description, String> {
    let known = parameters.iter();
    let names: Vec<&str> = known
        .filter_map(|&index| Some(scene.parameters.get(index)?.name.as_str()))
        .collect();
    let derived = on_a_thread(&scene.name, |stem| match again {
        Again::Differentiated => describe_differentiated(text, stem, &names),
        Again::Held => describe_held(text, stem, &names),
    });
    let derived = derived.map_err(|error| format!("no thread for a derivation: {error}"))?;
    let (description, _) = derived.map_err(|mistakes| {
        let first = mistakes.into_iter().find(|mistake| !mistake.warning);
        first.map_or_else(String::new, |mistake| mistake.message)
    })?;
    Ok(description)
}
