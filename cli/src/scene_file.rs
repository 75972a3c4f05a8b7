//! A scene from a file, in place of one from the list.

use std::path::Path;

use hangtime::model::Model;
use hangtime_scene_files::{SceneError, TextScene};

use crate::failure::BadInput;
use crate::scene::Scene;

/// The end of the name of a scene file.
pub(crate) const EXTENSION: &str = "hang";

/// Whether what stands for a scene is the path of a file.
pub(crate) fn is_path(scene: &str) -> bool {
    Path::new(scene)
        .extension()
        .is_some_and(|extension| extension == EXTENSION)
}

/// Reads the scene of a file.
pub(crate) fn read(file: &str) -> Result<TextScene, BadInput> {
    let scene = hangtime_scene_files::read(Path::new(file)).map_err(refusal)?;
    if !scene.warnings().is_empty() {
        eprintln!("{}", scene.warnings());
    }
    Ok(scene)
}

/// The warnings about the text of a scene, a sentence each, as they stand in the report.
pub(crate) fn warned(scene: &Scene) -> impl Iterator<Item = String> {
    let report = scene.text.map_or("", |text| text.warnings());
    let first = report.lines().filter(|line| line.starts_with("warning"));
    first.map(|line| line.trim_end().to_owned())
}

/// Reads the text of a scene file, whatever stands in it.
pub(crate) fn read_text(file: &str) -> Result<String, BadInput> {
    if !is_path(file) {
        return Err(BadInput::new(format!(
            "`{file}`: give a scene file, whose name ends with .{EXTENSION}"
        )));
    }
    hangtime_scene_files::read_text(Path::new(file)).map_err(refusal)
}

/// The text of a scene file, and the same in the settled style.
pub(crate) fn formatted(file: &str) -> Result<(String, String), BadInput> {
    hangtime_scene_files::format(Path::new(file)).map_err(refusal)
}

pub(crate) fn refusal(error: SceneError) -> BadInput {
    match error {
        SceneError::Mistakes { report, .. } => BadInput::report(&report),
        other => BadInput::new(other.to_string()),
    }
}

/// Reads the scene of a file as an entry of the list of scenes, which stays in memory until the program ends.
pub(crate) fn load(file: &str) -> Result<&'static Scene, BadInput> {
    Ok(entry(file, read(file)?))
}

/// The scene of a text, as [`load`] gives that of the file `name`.
pub(crate) fn load_text(name: &str, text: &str) -> Result<&'static Scene, BadInput> {
    let file = format!("{name}.{EXTENSION}");
    let scene = hangtime_scene_files::of_text(&file, text);
    Ok(entry(&file, scene.map_err(refusal)?))
}

/// A scene of the list with the text of its file read.
pub(crate) fn load_unread(scene: &Scene, text: &'static str) -> Result<&'static Scene, BadInput> {
    let read = load_text(scene.name, text)?;
    Ok(Box::leak(Box::new(Scene {
        text: read.text,
        unread: None,
        source: Some(text),
        ..*scene
    })))
}

/// A scene with another text.
pub(crate) fn load_changed(scene: &Scene, text: &str) -> Result<&'static Scene, BadInput> {
    let read = load_text(scene.name, text)?;
    Ok(Box::leak(Box::new(Scene {
        text: read.text,
        source: scene.source.map(|_| &*text.to_owned().leak()),
        ..*scene
    })))
}

/// The scene of a file as an entry of the list of scenes.
pub(crate) fn entry(file: &str, scene: TextScene) -> &'static Scene {
    let model: &'static TextScene = Box::leak(Box::new(scene));
    let declaration = model.declaration();
    let name: &'static str = name(file).leak();
    let title = declaration.documentation.lines().map(str::trim);
    let title = title.take_while(|line| !line.is_empty());
    let title = title.collect::<Vec<_>>().join(" ");
    let title = title.trim_end_matches('.');
    let folder = Path::new(file).parent().and_then(Path::to_str);
    let scene = Scene {
        text: Some(model),
        folder: folder.unwrap_or_default().to_owned().leak(),
        ..Scene::new(
            name,
            match title {
                "" => "a scene from a file",
                title => title.to_owned().leak(),
            },
            &[],
        )
    };
    Box::leak(Box::new(scene))
}

/// The name of the file without its ending, as far as it can be part of other names of files. Where it cannot be that as it
/// is, a number that follows from it stands behind, so that files of different names have results of different names.
pub(crate) fn name(file: &str) -> String {
    let stem = Path::new(file).file_stem().unwrap_or_default();
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let stem = stem.to_string_lossy();
    let name: String = stem
        .chars()
        .map(|c| if fits(c) { c } else { '-' })
        .collect();
    match name.trim_start_matches(['-', '_']) {
        "" => "scene".to_owned(),
        same if same == stem => name,
        other => format!("{other}-{:08x}", fingerprint(stem.as_bytes())),
    }
}

/// A number of 32 bits that follows from bytes (FNV-1a, <http://www.isthe.com/chongo/tech/comp/fnv/>).
fn fingerprint(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0x811c_9dc5, |hash, byte| {
        (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193)
    })
}

#[cfg(test)]
mod tests {
    use super::{is_path, name};

    #[test]
    fn name_of_a_file_is_that_of_its_results() {
        assert!(
            is_path("a/b.hang") && !is_path("ski-jump") && !is_path("hang") && !is_path(".hang")
        );
        for (file, wanted) in [("scenes/ski-jump.hang", "ski-jump"), ("..hang", "scene")] {
            assert_eq!(name(file), wanted);
        }
        // Names that cannot be those of results are told apart all the same.
        let files = [
            "a b.hang",
            "a&b.hang",
            "a-b.hang",
            "a\u{e4}b.hang",
            "-a-b.hang",
        ];
        let names: std::collections::HashSet<String> =
            files.iter().map(|file| name(file)).collect();
        assert_eq!(names.len(), files.len(), "{names:?}");
        assert!(names.iter().all(|name| name.starts_with("a-b")));
    }
}
