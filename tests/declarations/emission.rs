//! Compiled scenes against their files, which are derived when they are read.

use crate::same::assert_same;
use hangtime::model::Model;

/// Tests that these scenes of files are the same when they are compiled.
macro_rules! compiled {
    ($($file:literal: $scene:ident,)*) => {
        mod scenes {
            $(hangtime::model_file!($file);)*
        }

        #[test]
        fn compiled_scene_evaluates_to_what_its_file_does() {
            $({
                let text = include_str!(concat!("../../", $file));
                let read = hangtime_scene_files::of_text($file, text);
                let read = read.unwrap_or_else(|error| panic!("{error}"));
                assert_same(&scenes::$scene::default(), &read as &dyn Model);
            })*
        }
    };
}

compiled! {
    "models/gallery/biped.hang": Biped,
    "models/gallery/hopper.hang": Hopper,
    "models/gallery/lander.hang": Lander,
    "models/gallery/thermostat.hang": Thermostat,
    "tests/declarations/scenes/belt.hang": Belt,
    "tests/declarations/scenes/cart.hang": Cart,
    "tests/declarations/scenes/edges.hang": Edges,
    "tests/declarations/scenes/forces.hang": Forces,
    "tests/declarations/scenes/functions.hang": Functions,
    "tests/declarations/scenes/joints.hang": Joints,
    "tests/declarations/scenes/long-train.hang": LongTrain,
    "tests/declarations/scenes/repeated.hang": Repeated,
    "tests/declarations/scenes/rough-bodies.hang": RoughBodies,
    "tests/declarations/scenes/rough-rod.hang": RoughRod,
    "tests/declarations/scenes/shown.hang": Shown,
    "tests/declarations/scenes/top.hang": Top,
    "zoo/scenes/furuta-friction.hang": FurutaFriction,
    "zoo/scenes/hollow-sledge.hang": HollowSledge,
    "zoo/scenes/peg-against-wall.hang": PegAgainstWall,
}
