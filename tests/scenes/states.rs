//! Switches of what acts: order of the elements through one, and random scenes by both methods. Closed forms stand in `tests/cases`.

use hangtime::prelude::*;
use hangtime::rk::Scheme;
use hangtime_scene_files::of_text;

/// The oscillator of the finite elements with switch detection: it turns one way inside of the unit circle and the other way
/// outside, and grows like `exp(t)`; on the circle at 1 (Nurkanovic et al., Numerische Mathematik 2024).
const OSCILLATOR: &str =
    "parameters { w = 6.283185307179586 } states { x, y } let c = x^2 + y^2 - 1
    rates { x: if c >= 0 { x - w*y } else { x + w*y }, y: if c >= 0 { w*x + y } else { -w*x + y } }
    start { x: 0.36787944117144233 } horizon 1.5707963267948966";

/// Where it is at its horizon.
fn end_of_the_oscillator() -> [f64; 2] {
    let time = std::f64::consts::FRAC_PI_2;
    let (size, angle) = ((time - 1.0).exp(), std::f64::consts::TAU * (time - 2.0));
    [size * angle.cos(), size * angle.sin()]
}

#[test]
fn oscillator_has_the_order_of_the_scheme_through_its_switch() {
    let scene = of_text("scene.hang", OSCILLATOR).expect("a scene");
    let [x, y] = end_of_the_oscillator();
    for (kind, stages, grids) in [
        (Scheme::RadauIia, 1, [400, 800, 1600]),
        (Scheme::RadauIia, 2, [40, 80, 160]),
        (Scheme::RadauIia, 3, [20, 40, 80]),
        (Scheme::RadauIia, 4, [10, 20, 40]),
        (Scheme::GaussLegendre, 1, [100, 200, 400]),
        (Scheme::GaussLegendre, 2, [20, 40, 80]),
        (Scheme::GaussLegendre, 3, [10, 20, 40]),
        (Scheme::GaussLegendre, 4, [7, 14, 28]),
    ] {
        let errors = grids.map(|steps| {
            let method = Fesd::default()
                .with_scheme(kind, stages)
                .with_grid(steps, 1);
            let motion = simulate(&scene).method(method).run().expect("a run");
            assert!(
                motion.status.is_solved(),
                "{stages} {steps}: {}",
                motion.status
            );
            let v = motion.trajectory.v.last().expect("a motion");
            (v[0] - x).hypot(v[1] - y)
        });
        // Radau IIA: 2 s - 1, Gauss-Legendre: 2 s; the leading term dominates within some per cent on these grids.
        let order = (errors[1] / errors[2]).log2();
        let even = 2 * u32::try_from(stages).expect("few");
        let wanted = f64::from(even - u32::from(kind == Scheme::RadauIia));
        assert!(
            (order - wanted).abs() < 0.35,
            "{stages} stages: {order}, {errors:?}"
        );
    }
}

/// Numbers between -1 and 1 with two decimals.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 40) as f64 / f64::from(1 << 23) - 1.0) * 100.0
    }

    fn factor(&mut self) -> String {
        format!("({:.2})", self.number().round() / 100.0)
    }

    /// A linear function of three states, and the time.
    fn linear(&mut self) -> String {
        let terms = ["x", "y", "z", "sin(2*t)"].map(|name| format!("{}*{name}", self.factor()));
        format!("{} + {}", terms.join(" + "), self.factor())
    }
}

#[test]
fn random_relays_and_kinks_agree_with_the_event_driven_method() {
    let (mut solved, mut slides, mut crosses) = (0, 0, 0);
    for seed in 0..24 {
        let mut random = Random(seed);
        let switches = [
            format!("2*sign({})", random.linear()),
            format!("if {} >= 0 {{ 1 }} else {{ -1 }}", random.linear()),
            format!("2*max({}, 0)", random.linear()),
        ];
        let rates = ["x", "y", "z"].map(|name| {
            let acting: Vec<String> = (0..3)
                .map(|k| format!("{}*s{k}", random.factor()))
                .collect();
            format!(
                "{name}: {} - {name} + {}",
                random.linear(),
                acting.join(" + ")
            )
        });
        let lets: Vec<String> = switches
            .iter()
            .enumerate()
            .map(|(k, s)| format!("let s{k} = {s}"))
            .collect();
        let text = format!(
            "states {{ x, y, z }} {} rates {{ {} }} start {{ x: {}, y: {}, z: {} }} horizon 4",
            lets.join(" "),
            rates.join(", "),
            random.factor(),
            random.factor(),
            random.factor(),
        );
        let scene = of_text("scene.hang", &text).expect("a scene");
        let mut fesd = simulate(&scene).run().expect("a run");
        let event = simulate(&scene)
            .method(EventDriven::default())
            .run()
            .expect("a run");
        // A motion that is not unique is so for both.
        assert_eq!(
            fesd.status.is_solved(),
            event.status.is_solved(),
            "{text}: {} {}",
            fesd.status,
            event.status
        );
        if !fesd.status.is_solved() {
            continue;
        }
        solved += 1;
        slides += fesd
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Slide)
            .count();
        crosses += fesd
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Switch)
            .count();
        let (one, other) = (
            fesd.trajectory.v.pop().expect("an end"),
            event.trajectory.v.last().expect("an end"),
        );
        let size = other
            .iter()
            .fold(1.0_f64, |size, value| size.max(value.abs()));
        for (a, b) in one.iter().zip(other) {
            // Both promise 1e-6 of the largest values.
            assert!((a - b).abs() < 2e-6 * size, "{text}: {one:?} {other:?}");
        }
    }
    assert!(
        solved == 24 && slides > 10 && crosses > 50,
        "{solved} solved, {slides} slide, {crosses} switch"
    );
}
