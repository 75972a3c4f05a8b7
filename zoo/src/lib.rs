//! Optimal control scenes that the solver was not made for, each with the best value that is known.
//!
//! Those that a lecture can use stand in the gallery that is shipped, `models/gallery`, and are read from there; the
//! others stand in `scenes`, with all quantities in SI units. Half of them served to develop the search
//! ([`Half::Developed`]); what is claimed is reported on the other half as well, which nobody tuned on
//! ([`Half::Reported`]).

mod known;

use hangtime::model::Model;
use hangtime_scene_files::of_text;

pub use known::best;

/// Which half of the set a scene belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Half {
    /// The search was developed on it.
    Developed,
    /// Figures are only reported on it.
    Reported,
}

/// A scene of the zoo.
#[derive(Debug, Clone, Copy)]
pub struct Exhibit {
    /// Its name, which is that of its file.
    pub name: &'static str,
    /// Which half of the set it belongs to.
    pub half: Half,
    /// The text of its file.
    pub text: &'static str,
}

impl Exhibit {
    /// The scene with the parameters it declares.
    ///
    /// # Panics
    /// If the text has a mistake, which its test would find.
    #[must_use]
    pub fn model(&self) -> Box<dyn Model> {
        let scene = of_text(&format!("{}.hang", self.name), self.text);
        Box::new(scene.unwrap_or_else(|mistake| panic!("{}: {mistake}", self.name)))
    }
}

macro_rules! exhibits {
    ($($half:ident $folder:literal $name:literal;)*) => {
        &[$(Exhibit {
            name: $name,
            half: Half::$half,
            text: include_str!(concat!("../../", $folder, "/", $name, ".hang")),
        }),*]
    };
}

/// All scenes.
#[must_use]
pub fn exhibits() -> &'static [Exhibit] {
    exhibits! {
        Developed "zoo/scenes" "three-carts";
        Reported "zoo/scenes" "push-and-roll";
        Developed "zoo/scenes" "fast-cart";
        Reported "models/gallery" "cradle-of-carts";
        Developed "models/gallery" "crane";
        Reported "zoo/scenes" "peg-against-wall";
        Developed "models/gallery" "rough-block";
        Reported "models/gallery" "curling";
        Developed "zoo/scenes" "soft-landing";
        Reported "zoo/scenes" "blocks-on-spring";
        Developed "models/gallery" "plate-and-box";
        Reported "models/gallery" "spinning-wheel";
        Reported "zoo/scenes" "uphill-block";
        Developed "zoo/scenes" "weak-throw";
        Reported "zoo/scenes" "throw-from-plate";
        Developed "models/gallery" "catch";
        Reported "models/gallery" "juggler";
        Reported "models/gallery" "wall-ball";
        Developed "zoo/scenes" "weak-pendulum";
        Developed "models/gallery" "pendulum-with-stop";
        Reported "models/gallery" "cart-pole";
        Developed "zoo/scenes" "cart-pole-friction";
        Reported "zoo/scenes" "acrobot-stops";
        Reported "zoo/scenes" "furuta-friction";
        Developed "models/gallery" "hop";
        Reported "models/gallery" "hop-forward";
        Developed "models/gallery" "lander";
        Reported "models/gallery" "biped";
        Developed "zoo/scenes" "thrust-hop";
        Developed "models/gallery" "two-bumps";
        Reported "models/gallery" "two-wheels";
        Developed "models/gallery" "push-off";
        Reported "zoo/scenes" "hollow-sledge";
    }
}
