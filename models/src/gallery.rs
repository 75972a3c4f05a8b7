//! Scenes to choose from, one file each in `gallery/`: what each asks, and the answer that it gives by default.
//!
//! Objectives are the least ones known on so many control intervals, as `hangtime solve SCENE --intervals N` finds them.

use hangtime_cli::{Question, Scene};

macro_rules! gallery {
    ($($group:literal { $($name:literal: $title:literal, $asked:literal => $answer:literal ($intervals:literal: $best:literal);)* })*) => {
        &[$($(
            Scene::unread($name, $title, include_str!(concat!("../gallery/", $name, ".hang")))
                .in_group($group)
                .asking(Question { asked: $asked, answer: $answer, known: ($intervals, $best) }),
        )*)*]
    };
}

/// All scenes of the gallery.
pub(crate) const GALLERY: &[Scene] = gallery! {
    "flights and bounces" {
        "wall-ball": "a ball is played off a wall and comes back to the hand",
            "With how little effort does it come back?" => "ANSWER_wall-ball" (10: 0.0);
        "juggler": "a paddle keeps a ball in the air for two seconds",
            "With how little effort are paddle and ball as they were?" => "ANSWER_juggler" (10: 0.0);
        "catch": "a hand catches a falling ball and brings it to rest",
            "With how little effort?" => "ANSWER_catch" (10: 0.0);
    }
    "friction" {
        "rough-block": "a block on a rough floor is pushed from rest to rest",
            "Is it better to push all the time, or to let it slide?" => "ANSWER_rough-block" (10: 0.0);
        "plate-and-box": "a box slips on a driven plate to its place",
            "How soon can it be there?" => "ANSWER_plate-and-box" (10: 0.0);
    }
    "vehicles" {
        "two-bumps": "a bike and its rider cross two bumps in least time",
            "How soon are they across?" => "ANSWER_two-bumps" (10: 0.0);
        "two-wheels": "a rigid bike on two wheels crosses waves in least time",
            "How soon is it across?" => "ANSWER_two-wheels" (10: 0.0);
        "rolling-bike": "a bike rolls on two tyres by friction, its rider leans and pushes",
            "How soon does it cross a wave of a pump track?" => "ANSWER_rolling-bike" (10: 0.0);
        "gap-jump": "a bike and its rider jump a gap from a kicker",
            "With how little effort do they land on the other side?" => "ANSWER_gap-jump" (10: 0.0);
        "spinning-wheel": "a driven wheel goes five metres from rest to rest",
            "How soon, where too much torque spins it?" => "ANSWER_spinning-wheel" (10: 0.0);
    }
    "legs" {
        "hop": "a body on a massive foot hops from flat ground",
            "With how little effort does the foot rise by 0.3 m?" => "ANSWER_hop" (10: 0.0);
        "hop-forward": "a body on a springy leg hops forward on rough ground",
            "With how little effort does it hop a metre?" => "ANSWER_hop-forward" (10: 0.0);
        "biped": "a body on two legs walks half a metre on rough ground",
            "With how little effort does it walk?" => "ANSWER_biped" (10: 0.0);
        "push-off": "a ski jumper pushes off with the legs",
            "How far away are they after two and a half seconds?" => "ANSWER_push-off" (10: 0.0);
    }
    "machines" {
        "lander": "a lander with a sprung leg touches down on the Moon",
            "With how little thrust does it land and stay?" => "ANSWER_lander" (10: 0.0);
        "crane": "a crane between two walls swings its load beyond them",
            "With how little effort?" => "ANSWER_crane" (10: 0.0);
        "cart-pole": "a pole on a cart between two walls is swung up",
            "With how little effort, if the walls may be used?" => "ANSWER_cart-pole" (10: 0.0);
        "pendulum-with-stop": "a pendulum with a weak motor and a stop is swung up",
            "With how little effort?" => "ANSWER_pendulum-with-stop" (10: 0.0);
    }
    "games" {
        "curling": "a curling stone has to come to rest in the house",
            "With how little effort of a hand that stays behind a line?" => "ANSWER_curling" (10: 0.0);
        "billiards": "a ball strikes another one into a pocket",
            "What is the softest shot that does it?" => "ANSWER_billiards" (10: 0.0);
        "cradle-of-carts": "a driven cart sets two others in motion, one by the other",
            "With how little effort?" => "ANSWER_cradle-of-carts" (10: 0.0);
    }
};
