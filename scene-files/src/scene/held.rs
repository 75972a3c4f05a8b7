//! Scenes with parameters as coordinates without motion.

use super::{Shared, TextScene};
use crate::thread::on_a_thread;
use std::sync::Arc;

/// Derives `scene` once more with those parameters as coordinates, unless that was done before, at its parameters.
pub(super) fn with_held(scene: &TextScene, parameters: &[usize]) -> Result<TextScene, String> {
    let known = || {
        let known = scene.shared.with_held.lock().ok()?;
        let (_, shared) = known.iter().find(|(of, _)| of == parameters)?;
        Some(Arc::clone(shared))
    };
    let shared = match known() {
        Some(shared) => shared,
        None => {
            let derived = derive(scene, parameters)?;
            if let Ok(mut known) = scene.shared.with_held.lock() {
                known.push((parameters.to_vec(), Arc::clone(&derived)));
            }
            derived
        }
    };
    let mut with_held = TextScene {
        parameters: scene.parameters.clone(),
        folded: Vec::new(),
        shared,
    };
    with_held.fold();
    Ok(with_held)
}

fn derive(scene: &TextScene, parameters: &[usize]) -> Result<Arc<Shared>, String> {
    let declared = &scene.description().parameters;
    let names: Vec<&str> = parameters
        .iter()
        .filter_map(|&index| Some(declared.get(index)?.name.as_str()))
        .collect();
    let text = scene.shared.text.as_str();
    let derived = on_a_thread(&scene.description().name, |stem| {
        hangtime_dsl::describe_held(text, stem, &names)
    });
    let derived = derived.map_err(|error| format!("no thread for a derivation: {error}"))?;
    let (description, _) = derived.map_err(|mistakes| {
        let first = mistakes.into_iter().find(|mistake| !mistake.warning);
        first.map_or_else(String::new, |mistake| mistake.message)
    })?;
    match TextScene::new(description, text, String::new()) {
        Ok(scene) => Ok(scene.shared),
        Err(_) => Err(format!(
            "a function derived with `{}` as unknowns has too many values; split the mechanism into smaller scenes",
            names.join("`, `")
        )),
    }
}
