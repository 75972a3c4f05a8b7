//! Stick and slip: a block on a rough floor, dragged by a spring whose other end moves at a constant speed.
//!
//! While it slips, the stretch of the spring oscillates about `mu m g / k`; while it sticks, the stretch grows at the
//! speed of the other end. So the motion is known as a formula, switch by switch.

use hangtime_cli::{Scene, Variant};

use crate::closed_form;

hangtime::model_file!("scenes/stick-slip.hang");

/// Its entry in the list of scenes.
pub(crate) const SCENE: Scene = Scene {
    closed_form: Some(closed_form::stick_slip),
    ..Scene::new(
        "stick-slip",
        "a spring drags a block that sticks and slips",
        &[Variant::new(|| Box::new(StickSlip::default()))],
    )
};
