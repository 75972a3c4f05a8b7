//! Scenes on which methods of simulation fail, each in one respect, and what is right there.

use hangtime_cli::{HardScene, Right};

/// The scene of a file, with what is right and why.
macro_rules! hard {
    ($name:literal, $right:expr, $why:literal) => {
        HardScene {
            name: $name,
            text: include_str!(concat!("../hard/", $name, ".hang")),
            right: $right,
            why: $why,
        }
    };
}

/// All of them, by name. `hangtime chart --stability` shows what every method makes of them.
#[must_use]
pub fn hard_scenes() -> &'static [HardScene] {
    &SCENES
}

static SCENES: [HardScene; 67] = [
    hard!(
        "almost-flat-rod",
        Right::Agreed,
        "As `flat-rod` with an angle of 1e-12: the tips hit one after the other, within rounding error."
    ),
    hard!(
        "balanced",
        Right::Formula(|_, _| vec![0.0, 1.0]),
        "It stands on the top, where nothing pushes it to either side. Every disturbance would make it slide off; a method must not begin to slide by itself."
    ),
    hard!(
        "below-painleve",
        Right::Agreed,
        "A uniform rod at an angle of tangent 2: the tip moves by (1 + 3 cos (cos - mu sin)) / m for the force on it, which is above zero up to mu = 4/3. Here the force is 40 times the weight, and stops the slip within a millisecond."
    ),
    hard!(
        "blunt-corner",
        Right::Agreed,
        "Two surfaces with an obtuse angle between them, reached at once: Moreau's law in one linear complementarity problem, which has one solution."
    ),
    hard!(
        "bouncing-carts",
        Right::Formula(|_, _| vec![1.556_904_332_93, 2.056_101_770_12, 3.183_644_484_64]),
        "Event-driven integration at 1e-13 and Moreau-Jean's method, which knows no events, with 160,000 steps, agree to 3e-5."
    ),
    hard!(
        "bowl",
        Right::Agreed,
        "A body slides to and fro in a bowl, many times; on curved ground errors of the position must not add up."
    ),
    hard!(
        "carts-between-stops",
        Right::Formula(|_, _| vec![1.251_993_040_23, 1.968_304_852_98]),
        "Event-driven integration at 1e-13 and Moreau-Jean's method, which knows no events, with 160,000 steps, agree to 2e-5."
    ),
    hard!(
        "corner",
        Right::Formula(|_, t| vec![t - 1.0, t - 1.0]),
        "Without gravity the ball reaches floor and wall after 1 s, both at once; their normals are orthogonal, so both velocities turn round."
    ),
    hard!(
        "curved-gap",
        Right::Formula(|_, t| {
            let [fall, down] = [(2.0 / 9.81_f64).sqrt(), (2.0 * 9.81_f64).sqrt()];
            let up = t - fall;
            vec![t, down / 2.0 * up - 9.81 / 2.0 * up * up]
        }),
        "The surface is where the gap vanishes, whatever the gap is elsewhere: one bounce with half of the velocity."
    ),
    hard!(
        "dome",
        Right::Agreed,
        "A body without friction leaves a dome of radius r where it has come down by r/3: there its weight no longer bends its path enough."
    ),
    hard!(
        "eight-beads",
        Right::Formula(|_, t| {
            let velocities = [1.31, -0.73, 0.417, 1.93, -1.13, 0.219, -1.61, 0.937];
            let starts = (1..=8).map(f64::from);
            let mut ends: Vec<f64> = starts
                .zip(velocities)
                .map(|(start, v): (f64, f64)| {
                    let way = (start + v * t).rem_euclid(18.0);
                    way.min(18.0 - way)
                })
                .collect();
            ends.sort_by(f64::total_cmp);
            ends
        }),
        "Equal beads exchange their velocities, as if they passed through each other: the places are those of eight that are alone between the walls, in order."
    ),
    hard!(
        "elastic-floor",
        Right::Formula(|_, t| {
            let fall = (2.0 / 9.81_f64).sqrt();
            let since = (t - fall).rem_euclid(2.0 * fall) - fall;
            vec![t, 1.0 - 9.81 / 2.0 * since * since]
        }),
        "With restitution 1 the fall and the rise repeat for ever."
    ),
    hard!(
        "falling-stack",
        Right::Formula(|_, _| vec![0.0, 0.1, 0.2]),
        "Three inelastic blocks that touch fall together and end on the floor, one on the other."
    ),
    hard!(
        "far-from-origin",
        Right::Formula(|_, t| {
            let [fall, down] = [(2.0 / 9.81_f64).sqrt(), (2.0 * 9.81_f64).sqrt()];
            let up = t - fall;
            vec![1e6 + t, down / 2.0 * up - 9.81 / 2.0 * up * up]
        }),
        "Translations change nothing: a free fall from 1 m and one bounce, a thousand kilometres from the origin."
    ),
    hard!(
        "fast-rotation",
        Right::Agreed,
        "A rod that turns 30 times a second while it falls: its tips come near the floor twice a turn before one touches it."
    ),
    hard!(
        "flat-rod",
        Right::Formula(|_, t| vec![t, 0.0, 0.0]),
        "Both tips reach the floor at once; the impact law is symmetric, so the rod does not turn."
    ),
    hard!(
        "flight-into-corner",
        Right::Formula(|_, _| vec![0.0, 0.0]),
        "Two surfaces with an acute angle between them, reached at once from above: an inelastic impact leaves no velocity that points into the ground, and gravity holds the body in the corner."
    ),
    hard!(
        "grazing-apex",
        Right::Formula(|_, t| vec![t, 2.0 * t - t * t]),
        "A thrown ball whose highest point is the ceiling, which it touches with the velocity 0: an impact of no impulse changes nothing."
    ),
    hard!(
        "heavy-on-light",
        Right::Formula(|_, _| vec![0.0, 1.0]),
        "It stands, and the lower contact carries a million times the weight of the light body."
    ),
    hard!(
        "held-cart",
        Right::Formula(|_, _| vec![-0.293_986_685_884, 1.514_933_500_05, 3.115_603_647_04]),
        "Event-driven integration at 1e-13 and Moreau-Jean's method, which knows no events, with 160,000 steps, agree to 2e-5."
    ),
    hard!(
        "hinged-bar",
        Right::Formula(|_, _| {
            let angle = -(0.3_f64).asin();
            vec![0.5 * angle.cos(), 0.5 * angle.sin(), angle]
        }),
        "After infinitely many bounces it rests on the stop, 0.3 m below the hinge at a length of 1 m."
    ),
    hard!(
        "impact-at-horizon",
        Right::Formula(|_, t| vec![t, 0.0]),
        "With g = 8 m/s^2 it falls 1 m in half a second."
    ),
    hard!(
        "impact-at-stage",
        Right::Formula(|_, t| {
            let (fall, down) = (0.500_861_394_587_342_7, 8.0 * 0.500_861_394_587_342_7);
            let up = t - fall;
            vec![t, down / 2.0 * up - 4.0 * up * up]
        }),
        "A fall of 90 elements and (4 - sqrt 6)/10 of the next one, and one bounce with half of the velocity."
    ),
    hard!(
        "impact-at-step-end",
        Right::Formula(|_, t| vec![t, 2.0 * (t - 0.5) - 4.0 * (t - 0.5) * (t - 0.5)]),
        "With g = 8 m/s^2 it falls 1 m in half a second, where a step of any even number ends, with 4 m/s; it goes up with 2 m/s."
    ),
    hard!(
        "impact-ends-stick",
        Right::Formula(|_, t| {
            let since = t - 0.25;
            let way = 20.0 / 6.0 * since.max(0.0).powi(3);
            vec![way, 0.0, 1.25 * since - 5.0 * since * since]
        }),
        "The block slips from mu m g = 5 N on, after a quarter of a second, when the ball from 0.3125 m arrives with 2.5 m/s; each of them moves as if it were alone."
    ),
    hard!(
        "infinite-start",
        Right::Stop,
        "The force 1/t is infinite at the start."
    ),
    hard!(
        "jammed-carts",
        Right::Formula(|_, _| vec![
            -0.146_608_077_491,
            0.673_344_867_267,
            1.073_344_867_27,
            1.573_344_867_27
        ]),
        "Event-driven integration at 1e-13 and Moreau-Jean's method, which knows no events, with 200,000 steps, agree to 3e-5."
    ),
    hard!(
        "large-gap",
        Right::Formula(|_, t| {
            let [fall, down] = [(2.0 / 9.81_f64).sqrt(), (2.0 * 9.81_f64).sqrt()];
            let up = t - fall;
            vec![t, down / 2.0 * up - 9.81 / 2.0 * up * up]
        }),
        "The surface is where the gap vanishes, whatever the gap is elsewhere: one bounce with half of the velocity."
    ),
    hard!(
        "leaning-ladder",
        Right::Formula(|_, _| {
            let angle = 1.0_f64;
            vec![angle.cos(), angle.sin(), angle]
        }),
        "Friction jams it where the tangent of its angle is at least (1 - mu^2)/(2 mu) = 0.75: it stays at 1 rad. The four forces are not determined, the motion is."
    ),
    hard!(
        "leaving-at-once",
        Right::Formula(|_, t| vec![t, 2.0 - 9.81 / 2.0 * t * t]),
        "It touches the ceiling at the start and falls at once: a free fall."
    ),
    hard!(
        "lift",
        Right::Formula(|_, t| vec![t, (t - 0.5).max(0.0).powi(3) / 6.0 * 20.0]),
        "A force of 20 N/s t lifts the body from g = 10 m/s^2 on; the contact force vanishes after half a second, where steps of even number end, and the gap grows with the third power of time."
    ),
    hard!(
        "long-fall",
        Right::Formula(|_, t| vec![t, 1e14 - 9.81 / 2.0 * t * t]),
        "A free fall of a million seconds; no surface is near."
    ),
    hard!(
        "long-zeno",
        Right::Formula(|_, t| vec![t / 2.0, 0.0]),
        "As `zeno`, with rest after 0.45 s (1 + e) / (1 - e) = 17.6 s and hundreds of bounces before."
    ),
    hard!(
        "mass-ratio",
        Right::Formula(|_, t| {
            let after = 1e6 / (1e6 + 1.0);
            let met = vec![1.0 + after * (t - 1.0); 2];
            if t < 1.0 { vec![t, 1.0] } else { met }
        }),
        "They meet after 1 s and go on together; momentum is kept, so their velocity is M / (M + m)."
    ),
    hard!(
        "megametre",
        Right::Formula(|_, t| {
            let [fall, down] = [(2.0 * 1e6 / 9.81_f64).sqrt(), (2.0 * 1e6 * 9.81_f64).sqrt()];
            let up = t - fall;
            vec![t * 1e6, down / 2.0 * up - 9.81 / 2.0 * up * up]
        }),
        "A free fall from a thousand kilometres, one bounce with half of the velocity; scales change nothing but scales."
    ),
    hard!(
        "micrometre",
        Right::Formula(|_, t| {
            let [fall, down] = [
                (2.0 * 1e-6 / 9.81_f64).sqrt(),
                (2.0 * 1e-6 * 9.81_f64).sqrt(),
            ];
            let up = t - fall;
            vec![t * 1e-6, down / 2.0 * up - 9.81 / 2.0 * up * up]
        }),
        "A free fall from a micrometre, one bounce with half of the velocity; scales change nothing but scales."
    ),
    hard!(
        "moving-wall",
        Right::Agreed,
        "The law holds for the velocity relative to the wall, so each impact takes energy from the wall or gives it some."
    ),
    hard!(
        "narrow-gap",
        Right::Formula(|_, t| {
            let line = (5e-4 + 10.0 * t).rem_euclid(2e-3);
            vec![line.min(2e-3 - line)]
        }),
        "The walls fold the line along which the body moves: 10,000 impacts in a second, several in any step."
    ),
    hard!(
        "near-corner",
        Right::Formula(|_, t| vec![(t - 1.0).abs(), (t - 1.0 - 1e-6).abs()]),
        "Without gravity the wall turns the velocity along y, and the floor that along z: two impacts in one step."
    ),
    hard!(
        "newtons-cradle",
        Right::Agreed,
        "Three equal elastic balls that touch: Moreau's law, all contacts at once, and not a sequence of impacts."
    ),
    hard!(
        "not-a-number",
        Right::Stop,
        "The force is the root of 1 m - y, which has no value after the body has passed 1 m."
    ),
    hard!(
        "painleve",
        Right::Stop,
        "Above mu = 4/3 at an angle of tangent 2 the force on the tip of a uniform rod presses it into the floor by friction more than it lifts it, so neither slip nor stick has a force (Painleve 1895; Genot and Brogliato 1999). Time stepping goes on with an impulse that stops the slip."
    ),
    hard!(
        "parting-carts",
        Right::Formula(|_, _| vec![
            0.324_988_861_7,
            0.870_851_580_284,
            2.191_138_525,
            2.718_561_791_54,
            4.082_469_155_05
        ]),
        "Event-driven integration at 1e-13 and Moreau-Jean's method, which knows no events, with 200,000 steps, agree to 2e-5."
    ),
    hard!(
        "pole",
        Right::Stop,
        "A force c/(1 m - y) draws the body to 1 m, where it becomes infinite in finite time."
    ),
    hard!(
        "rest",
        Right::Formula(|_, t| vec![t, 0.0]),
        "It stands on the floor at the start, and the force of the floor holds it."
    ),
    hard!(
        "resting-threshold",
        Right::Formula(|_, _| vec![4.0, -3.0]),
        "The coefficient of friction is the slope of the incline, 3/4, and the block is at rest: it stays, at the edge of the friction cone."
    ),
    hard!(
        "shaken-floor",
        Right::Agreed,
        "The floor accelerates downwards by more than gravity twice a second; the body takes off tangentially, and lands."
    ),
    hard!(
        "sharp-corner",
        Right::Agreed,
        "Two surfaces with an acute angle between them, reached by a slide along one of them."
    ),
    hard!(
        "short-horizon",
        Right::Formula(|_, t| vec![t, -9.81 / 2.0 * t * t]),
        "A free fall of a nanosecond from the ceiling."
    ),
    hard!(
        "slack-string",
        Right::Agreed,
        "The string is slack at first; where it becomes tight it takes the radial velocity, and the body swings."
    ),
    hard!(
        "sliding-ladder",
        Right::Agreed,
        "Two contacts slide at once. The head leaves the wall at two thirds of its height at the start, a result of textbooks; the foot slides on."
    ),
    hard!(
        "sliding-threshold",
        Right::Formula(|_, t| vec![t * 0.8, -t * 0.6]),
        "The coefficient of friction is the slope of the incline, 3/4: the forces along it cancel, and it slides at a constant speed."
    ),
    hard!(
        "slight-graze",
        Right::Agreed,
        "As `grazing-apex` with a velocity that is larger by 1e-9: the ball hits the ceiling with some 1e-5 m/s and loses them."
    ),
    hard!(
        "slight-penetration",
        Right::Formula(|_, t| vec![t, 1.0]),
        "A penetration of one rounding error is a contact: the floor holds it."
    ),
    hard!(
        "small-gap",
        Right::Formula(|_, t| {
            let [fall, down] = [(2.0 / 9.81_f64).sqrt(), (2.0 * 9.81_f64).sqrt()];
            let up = t - fall;
            vec![t, down / 2.0 * up - 9.81 / 2.0 * up * up]
        }),
        "The surface is where the gap vanishes, whatever the gap is elsewhere: one bounce with half of the velocity."
    ),
    hard!(
        "stiff-spring",
        Right::Agreed,
        "A spring of 1e6 N/m under a falling mass: 160 oscillations a second between rare impacts."
    ),
    hard!(
        "stop-at-step-end",
        Right::Formula(|_, t| {
            let t = t.min(0.5);
            vec![2.0 * t - 2.0 * t * t, 0.0]
        }),
        "Braked by mu g = 4 m/s^2 from 2 m/s it stops after half a second, where a step of any even number ends."
    ),
    hard!(
        "stop-in-bowl",
        Right::Agreed,
        "Friction takes the energy of a swing; the body ends at rest where the slope is less than the coefficient of friction."
    ),
    hard!(
        "tangent-flight",
        Right::Formula(|_, t| vec![t, -t * t]),
        "A parabola of flight and its tangent: they touch after one second with the relative velocity 0."
    ),
    hard!(
        "three-feet",
        Right::Formula(|_, t| vec![t, 0.0, 0.0]),
        "Three feet on a floor carry the weight in many ways; the motion is the same in all of them."
    ),
    hard!(
        "tumbling-rod",
        Right::Formula(|_, _| vec![0.596_149_985_716, 0.244_795_294_951, -0.280_453_146_564]),
        "Event-driven integration at 1e-13 and Moreau-Jean's method, which knows no events, with 200,000 steps, agree to 2e-6."
    ),
    hard!(
        "turning-friction",
        Right::Agreed,
        "The floor sticks, slips one way and slips the other way, as a force of the time wants it."
    ),
    hard!(
        "twisting",
        Right::Formula(|_, _| vec![0.0, 0.0]),
        "From one turn to the next the way shrinks to a third and the time by the square root of it: infinitely many switches until it rests after (4/3) sqrt(2) / (1 - 1/sqrt(3)) = 4.46 s."
    ),
    hard!(
        "two-slips",
        Right::Formula(|_, t| {
            let way = 20.0 / 6.0 * (t - 0.25).max(0.0).powi(3);
            vec![way, 0.0, way, 0.0]
        }),
        "Both blocks begin to slip when the force 20 N/s t is mu m g = 5 N, after a quarter of a second."
    ),
    hard!(
        "weightless-slide",
        Right::Formula(|_, t| vec![t, -t * t]),
        "The ground is the parabola of flight: gap, its velocity and the force vanish all the time, and every contact mode gives the same motion."
    ),
    hard!(
        "zeno",
        Right::Formula(|_, t| vec![t / 2.0, 0.0]),
        "Impacts at 2 t0 (e + e^2 + ...) after the first at t0 = sqrt(2 h / g) = 0.45 s, so it rests on the floor after 4.06 s."
    ),
    hard!("zero-parameter", Right::Stop, "The force c/0 is infinite."),
];
