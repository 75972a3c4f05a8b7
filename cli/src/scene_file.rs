//! A scene from a file, in place of one from the list.

use std::path::Path;

use hangtime::model::{Declaration, Model};
use hangtime_scene_files::{SceneError, TextScene};

use crate::failure::BadInput;
use crate::scene::{GroundLine, Plane, Scene, heights};

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

/// Reads the text of a scene file, whatever stands in it.
pub(crate) fn read_text(file: &str) -> Result<String, BadInput> {
    if !is_path(file) {
        return Err(BadInput::new(format!(
            "`{file}`: give a scene file, whose name ends with .{EXTENSION}"
        )));
    }
    hangtime_scene_files::read_text(Path::new(file)).map_err(refusal)
}

fn refusal(error: SceneError) -> BadInput {
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

/// The scene of a file as an entry of the list of scenes.
pub(crate) fn entry(file: &str, scene: TextScene) -> &'static Scene {
    let model: &'static TextScene = Box::leak(Box::new(scene));
    let declaration = model.declaration();
    let name: &'static str = name(file).leak();
    let title = declaration.documentation.lines().map(str::trim);
    let title = title.take_while(|line| !line.is_empty());
    let title = title.collect::<Vec<_>>().join(" ");
    let title = title.trim_end_matches('.');
    let scene = Scene {
        text: Some(model),
        plane: plane(name, declaration),
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

/// The name of the file without its ending, as far as it can be part of other names of files.
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
        name => name.to_owned(),
    }
}

/// How a scene is drawn that says nothing about it: as one body, if its first two coordinates are called like a
/// horizontal position and a height, and have the same unit.
fn plane(name: &'static str, declaration: &Declaration) -> Option<Plane> {
    let [across, up, ..] = declaration.coordinates else {
        return None;
    };
    let drawn = matches!((across.name, up.name), ("x", "y" | "z") | ("y", "z"));
    if !drawn || across.unit != up.unit {
        return None;
    }
    let axis = |name: &str| -> &'static str {
        let unit = if across.unit.is_empty() {
            "1"
        } else {
            across.unit
        };
        format!("{name} [{unit}]").leak()
    };
    Some(Plane {
        unit: across.unit,
        ground,
        ..Plane::of_one_body(
            Box::leak(Box::new([name])),
            [axis(across.name), axis(up.name)],
        )
    })
}

/// The ground lines of the surfaces whose gaps are linear in the height.
fn ground(model: &dyn Model, from: f64, to: f64) -> Vec<GroundLine> {
    let mut point = vec![0.0; model.declaration().inputs()];
    let mut is_line = |contact: usize, y: f64| {
        let [low, middle, high] = [0.0, 1.0, 2.0].map(|z| {
            point[..2].copy_from_slice(&[y, z]);
            model.gap(contact, &point)
        });
        let bend = low - 2.0 * middle + high;
        // Roundings, relative to what is added.
        middle != low && bend.abs() <= 1e-9 * (low.abs() + middle.abs() + high.abs())
    };
    let lines = heights(model, from, to).into_iter().enumerate();
    lines
        .filter(|&(contact, _)| is_line(contact, from) && is_line(contact, to))
        .map(|(_, line)| line)
        .collect()
}

#[cfg(test)]
mod tests {
    use hangtime_scene_files::of_text;

    use super::{Model as _, ground, is_path, name, plane};

    #[test]
    fn name_of_a_file_is_that_of_its_results() {
        assert!(
            is_path("a/b.hang") && !is_path("ski-jump") && !is_path("hang") && !is_path(".hang")
        );
        for (file, wanted) in [
            ("scenes/ski-jump.hang", "ski-jump"),
            ("a b\u{e4}.hang", "a-b-"),
            ("../-x.hang", "x"),
            ("..hang", "scene"),
        ] {
            assert_eq!(name(file), wanted);
        }
    }

    #[test]
    fn picture_of_one_body_shows_the_lines_that_are_heights() {
        let text = "coordinates { x: m, z: m } lagrangian 1[kg]/2*|dot((x, z))|^2 \
                    surface floor: z >= x/2 impact floor: inelastic \
                    surface wall: x <= 3[m] impact wall: inelastic \
                    surface disc: x^2 + z^2 >= 1[m^2] impact disc: inelastic start { x: 2, z: 3 }";
        let ball = of_text("ball.hang", text).unwrap();
        let drawn = plane("ball", ball.declaration()).unwrap();
        assert_eq!((drawn.axes, drawn.unit), (["x [m]", "z [m]"], "m"));
        let lines = ground(&ball, 0.0, 4.0);
        assert_eq!(lines.len(), 1);
        assert_eq!((lines[0].name, lines[0].points[200]), ("floor", [4.0, 2.0]));
        let carts = text.replace("x", "a").replace("z", "b");
        let carts = carts.replace("mab", "max");
        let two = of_text("carts.hang", &carts).unwrap();
        assert!(plane("carts", two.declaration()).is_none());
    }
}
