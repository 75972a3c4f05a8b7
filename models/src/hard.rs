//! Scenes on which methods of simulation fail, each in one respect, and what is right there.

use hangtime_cli::{HardScene, Right};

/// The scene of a file, which says why, and what is right.
macro_rules! hard {
    ($name:literal, $right:expr) => {
        HardScene {
            name: $name,
            text: include_str!(concat!("../hard/", $name, ".hang")),
            right: $right,
        }
    };
}

/// All of them, by name. `hangtime chart --stability` shows what every method makes of them.
#[must_use]
pub fn hard_scenes() -> &'static [HardScene] {
    &SCENES
}

static SCENES: [HardScene; 67] = [
    hard!("almost-flat-rod", Right::Agreed),
    hard!("balanced", Right::Formula(|_, _| vec![0.0, 1.0])),
    hard!("below-painleve", Right::Agreed),
    hard!("blunt-corner", Right::Agreed),
    hard!(
        "bouncing-carts",
        Right::Formula(|_, _| vec![1.556_904_332_93, 2.056_101_770_12, 3.183_644_484_64])
    ),
    hard!("bowl", Right::Agreed),
    hard!(
        "carts-between-stops",
        Right::Formula(|_, _| vec![1.251_993_040_23, 1.968_304_852_98])
    ),
    hard!("corner", Right::Formula(|_, t| vec![t - 1.0, t - 1.0])),
    hard!(
        "curved-gap",
        Right::Formula(|_, t| {
            let [fall, down] = [(2.0 / 9.81_f64).sqrt(), (2.0 * 9.81_f64).sqrt()];
            let up = t - fall;
            vec![t, down / 2.0 * up - 9.81 / 2.0 * up * up]
        })
    ),
    hard!("dome", Right::Agreed),
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
        })
    ),
    hard!(
        "elastic-floor",
        Right::Formula(|_, t| {
            let fall = (2.0 / 9.81_f64).sqrt();
            let since = (t - fall).rem_euclid(2.0 * fall) - fall;
            vec![t, 1.0 - 9.81 / 2.0 * since * since]
        })
    ),
    hard!("falling-stack", Right::Formula(|_, _| vec![0.0, 0.1, 0.2])),
    hard!(
        "far-from-origin",
        Right::Formula(|_, t| {
            let [fall, down] = [(2.0 / 9.81_f64).sqrt(), (2.0 * 9.81_f64).sqrt()];
            let up = t - fall;
            vec![1e6 + t, down / 2.0 * up - 9.81 / 2.0 * up * up]
        })
    ),
    hard!("fast-rotation", Right::Agreed),
    hard!("flat-rod", Right::Formula(|_, t| vec![t, 0.0, 0.0])),
    hard!("flight-into-corner", Right::Formula(|_, _| vec![0.0, 0.0])),
    hard!(
        "grazing-apex",
        Right::Formula(|_, t| vec![t, 2.0 * t - t * t])
    ),
    hard!("heavy-on-light", Right::Formula(|_, _| vec![0.0, 1.0])),
    hard!(
        "held-cart",
        Right::Formula(|_, _| vec![-0.293_986_685_884, 1.514_933_500_05, 3.115_603_647_04])
    ),
    hard!(
        "hinged-bar",
        Right::Formula(|_, _| {
            let angle = -(0.3_f64).asin();
            vec![0.5 * angle.cos(), 0.5 * angle.sin(), angle]
        })
    ),
    hard!("impact-at-horizon", Right::Formula(|_, t| vec![t, 0.0])),
    hard!(
        "impact-at-stage",
        Right::Formula(|_, t| {
            let (fall, down) = (0.500_861_394_587_342_7, 8.0 * 0.500_861_394_587_342_7);
            let up = t - fall;
            vec![t, down / 2.0 * up - 4.0 * up * up]
        })
    ),
    hard!(
        "impact-at-step-end",
        Right::Formula(|_, t| vec![t, 2.0 * (t - 0.5) - 4.0 * (t - 0.5) * (t - 0.5)])
    ),
    hard!(
        "impact-ends-stick",
        Right::Formula(|_, t| {
            let since = t - 0.25;
            let way = 20.0 / 6.0 * since.max(0.0).powi(3);
            vec![way, 0.0, 1.25 * since - 5.0 * since * since]
        })
    ),
    hard!("infinite-start", Right::Stop),
    hard!(
        "jammed-carts",
        Right::Formula(|_, _| vec![
            -0.146_608_077_491,
            0.673_344_867_267,
            1.073_344_867_27,
            1.573_344_867_27
        ])
    ),
    hard!(
        "large-gap",
        Right::Formula(|_, t| {
            let [fall, down] = [(2.0 / 9.81_f64).sqrt(), (2.0 * 9.81_f64).sqrt()];
            let up = t - fall;
            vec![t, down / 2.0 * up - 9.81 / 2.0 * up * up]
        })
    ),
    hard!(
        "leaning-ladder",
        Right::Formula(|_, _| {
            let angle = 1.0_f64;
            vec![angle.cos(), angle.sin(), angle]
        })
    ),
    hard!(
        "leaving-at-once",
        Right::Formula(|_, t| vec![t, 2.0 - 9.81 / 2.0 * t * t])
    ),
    hard!(
        "lift",
        Right::Formula(|_, t| vec![t, (t - 0.5).max(0.0).powi(3) / 6.0 * 20.0])
    ),
    hard!(
        "long-fall",
        Right::Formula(|_, t| vec![t, 1e14 - 9.81 / 2.0 * t * t])
    ),
    hard!("long-zeno", Right::Formula(|_, t| vec![t / 2.0, 0.0])),
    hard!(
        "mass-ratio",
        Right::Formula(|_, t| {
            let after = 1e6 / (1e6 + 1.0);
            let met = vec![1.0 + after * (t - 1.0); 2];
            if t < 1.0 { vec![t, 1.0] } else { met }
        })
    ),
    hard!(
        "megametre",
        Right::Formula(|_, t| {
            let [fall, down] = [(2.0 * 1e6 / 9.81_f64).sqrt(), (2.0 * 1e6 * 9.81_f64).sqrt()];
            let up = t - fall;
            vec![t * 1e6, down / 2.0 * up - 9.81 / 2.0 * up * up]
        })
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
        })
    ),
    hard!("moving-wall", Right::Agreed),
    hard!(
        "narrow-gap",
        Right::Formula(|_, t| {
            let line = (5e-4 + 10.0 * t).rem_euclid(2e-3);
            vec![line.min(2e-3 - line)]
        })
    ),
    hard!(
        "near-corner",
        Right::Formula(|_, t| vec![(t - 1.0).abs(), (t - 1.0 - 1e-6).abs()])
    ),
    hard!("newtons-cradle", Right::Agreed),
    hard!("not-a-number", Right::Stop),
    hard!("painleve", Right::Stop),
    hard!(
        "parting-carts",
        Right::Formula(|_, _| vec![
            0.324_988_861_7,
            0.870_851_580_284,
            2.191_138_525,
            2.718_561_791_54,
            4.082_469_155_05
        ])
    ),
    hard!("pole", Right::Stop),
    hard!("rest", Right::Formula(|_, t| vec![t, 0.0])),
    hard!("resting-threshold", Right::Formula(|_, _| vec![4.0, -3.0])),
    hard!("shaken-floor", Right::Agreed),
    hard!("sharp-corner", Right::Agreed),
    hard!(
        "short-horizon",
        Right::Formula(|_, t| vec![t, -9.81 / 2.0 * t * t])
    ),
    hard!("slack-string", Right::Agreed),
    hard!("sliding-ladder", Right::Agreed),
    hard!(
        "sliding-threshold",
        Right::Formula(|_, t| vec![t * 0.8, -t * 0.6])
    ),
    hard!("slight-graze", Right::Agreed),
    hard!("slight-penetration", Right::Formula(|_, t| vec![t, 1.0])),
    hard!(
        "small-gap",
        Right::Formula(|_, t| {
            let [fall, down] = [(2.0 / 9.81_f64).sqrt(), (2.0 * 9.81_f64).sqrt()];
            let up = t - fall;
            vec![t, down / 2.0 * up - 9.81 / 2.0 * up * up]
        })
    ),
    hard!("stiff-spring", Right::Agreed),
    hard!(
        "stop-at-step-end",
        Right::Formula(|_, t| {
            let t = t.min(0.5);
            vec![2.0 * t - 2.0 * t * t, 0.0]
        })
    ),
    hard!("stop-in-bowl", Right::Agreed),
    hard!("tangent-flight", Right::Formula(|_, t| vec![t, -t * t])),
    hard!("three-feet", Right::Formula(|_, t| vec![t, 0.0, 0.0])),
    hard!(
        "tumbling-rod",
        Right::Formula(|_, _| vec![0.596_149_985_716, 0.244_795_294_951, -0.280_453_146_564])
    ),
    hard!("turning-friction", Right::Agreed),
    hard!("twisting", Right::Formula(|_, _| vec![0.0, 0.0])),
    hard!(
        "two-slips",
        Right::Formula(|_, t| {
            let way = 20.0 / 6.0 * (t - 0.25).max(0.0).powi(3);
            vec![way, 0.0, way, 0.0]
        })
    ),
    hard!("weightless-slide", Right::Formula(|_, t| vec![t, -t * t])),
    hard!("zeno", Right::Formula(|_, t| vec![t / 2.0, 0.0])),
    hard!("zero-parameter", Right::Stop),
];
