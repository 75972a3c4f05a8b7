//! Discs on a rough plane: Euler's disc and a spinning coin against an independent integration, `tools/peers/discs.py`, by momenta and without
//! angles, contact law or multipliers.

use super::{ends, events, motions_under};
use hangtime::prelude::*;

/// A thin disc whose lowest point touches the ground; `turns` about its axis, `slide` the velocity of that point.
fn disc(mu: &str, start: &str, horizon: &str) -> String {
    format!(
        "parameters {{ m: kg = 0.8, r: m = 0.25, g: m/s^2 = 9.81, mu = {mu} }}
        coordinates {{ x: m, y: m, z: m, heading: rad, lean: rad, spin: rad }}
        let turns = dot(spin) + dot(heading)*sin(lean)
        let rest = dot(lean)^2 + (dot(heading)*cos(lean))^2
        let aside = r*dot(lean)*cos(lean)
        let slide = (dot(x) + r*turns*cos(heading) + aside*sin(heading), dot(y) + r*turns*sin(heading) - aside*cos(heading))
        lagrangian m/2*(dot(x)^2 + dot(y)^2 + dot(z)^2) + m*r^2/8*rest + m*r^2/4*turns^2 - m*g*z
        surface ground: z >= r*cos(lean)
        impact ground: inelastic, friction mu, sliding slide
        start {{ {start} }} horizon {horizon}"
    )
}

#[test]
fn disc_on_its_rim_rolls_as_its_independent_integration() {
    // It rolls from the start, so that the cone holds it all the time.
    let text = disc(
        "5",
        "z: r*cos(1.1), lean: 1.1, dot(heading): 9, dot(lean): 0.4, dot(spin): -8.5, dot(z): -0.4 [1/s]*r*sin(1.1),
         dot(x): -r*(9 [1/s]*sin(1.1) - 8.5 [1/s]), dot(y): r*0.4 [1/s]*cos(1.1)",
        "1.5 [s]",
    );
    let wanted = [
        ("x", 0.013410297418),
        ("y", 0.002473850543),
        ("lean", 1.208932586835),
        ("dot(x)", -0.206629005483),
        ("dot(y)", 0.160896547040),
    ];
    // A tolerance of 1e-10 of the largest values, which are some ten.
    for motion in motions_under(&text, Some(1e-10), &ControlSignal::Zero) {
        assert!(motion.events.is_empty(), "{motion}");
        ends(&motion, &wanted, 1e-8);
    }
}

#[test]
fn spinning_coin_slides_then_rolls_as_its_independent_integration() {
    let text = disc(
        "0.4",
        "z: r*cos(0.3), lean: 0.3, dot(heading): 12, dot(spin): -4,
         dot(x): 0.4 [m/s] - r*(12 [1/s]*sin(0.3) - 4 [1/s]), dot(y): -0.7 [m/s]",
        "0.8 [s]",
    );
    let wanted = [
        ("x", 0.446259881931),
        ("y", -0.111599354761),
        ("lean", -0.096754168004),
        ("dot(x)", 0.480913049243),
        ("dot(y)", 0.279887313433),
    ];
    // The integration goes over to rolling at a speed of 1e-8.
    for motion in motions_under(&text, Some(1e-10), &ControlSignal::Zero) {
        events(&motion, &[(EventKind::Stick, 0.042981633291)], 1e-8);
        ends(&motion, &wanted, 1e-7);
    }
}
