//! Optimal control scenes that the solver was not made for, each with the best value that is known and how it was found.
//!
//! All quantities are in SI units. Half of the scenes served to develop the search ([`Half::Developed`]); what is claimed
//! is reported on the other half as well, which nobody tuned on ([`Half::Reported`]).

mod carts;
mod friction;
mod known;
mod legs;
mod pendulums;
mod riders;
mod throws;

use hangtime::model::Model;

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
pub struct Exhibit {
    /// Its name.
    pub name: &'static str,
    /// Which half of the set it belongs to.
    pub half: Half,
    /// The scene with the parameters it declares.
    pub model: fn() -> Box<dyn Model>,
}

macro_rules! exhibits {
    ($($half:ident $name:literal $scene:path;)*) => {
        &[$(Exhibit {
            name: $name,
            half: Half::$half,
            model: || Box::new(<$scene>::default()),
        }),*]
    };
}

/// All scenes.
#[must_use]
pub fn exhibits() -> &'static [Exhibit] {
    exhibits! {
        Developed "three-carts" carts::ThreeCarts;
        Reported "push-and-roll" carts::PushAndRoll;
        Developed "fast-cart" carts::FastCart;
        Reported "cradle-of-carts" carts::CradleOfCarts;
        Developed "crane-between-walls" carts::CraneBetweenWalls;
        Reported "peg-against-wall" carts::PegAgainstWall;
        Developed "rough-block" friction::RoughBlock;
        Reported "curling-stone" friction::CurlingStone;
        Developed "soft-landing" friction::SoftLanding;
        Reported "blocks-on-spring" friction::BlocksOnSpring;
        Developed "plate-and-box" friction::PlateAndBox;
        Reported "spinning-wheel" friction::SpinningWheel;
        Reported "uphill-block" friction::UphillBlock;
        Developed "weak-throw" throws::WeakThrow;
        Reported "throw-from-plate" throws::ThrowFromPlate;
        Developed "catch-ball" throws::CatchBall;
        Reported "juggler" throws::Juggler;
        Reported "wall-ball" throws::WallBall;
        Developed "weak-pendulum" pendulums::WeakPendulum;
        Developed "pendulum-with-stop" pendulums::PendulumWithStop;
        Reported "cart-pole-walls" pendulums::CartPoleWalls;
        Developed "cart-pole-friction" pendulums::CartPoleFriction;
        Reported "acrobot-stops" pendulums::AcrobotStops;
        Reported "furuta-friction" pendulums::FurutaFriction;
        Developed "hop" legs::Hop;
        Reported "hop-forward" legs::HopForward;
        Developed "lander" legs::Lander;
        Reported "biped" legs::Biped;
        Developed "thrust-hop" legs::ThrustHop;
        Developed "two-bumps" riders::TwoBumps;
        Reported "two-wheels" riders::TwoWheels;
        Developed "push-off" riders::PushOff;
        Reported "hollow-sledge" riders::HollowSledge;
    }
}
