//! Random scenes over the grammar, with the values of their formulas.

use crate::differences::rates;
use crate::draw::Draw;
use std::fmt::Write;

/// The stream of random numbers of a seed.
pub(crate) fn stream(seed: u64) -> Draw {
    Draw {
        state: seed.wrapping_mul(0x5851_f42d_4c95_7f2d),
    }
}

/// Parameters of all scenes.
const A: f64 = 0.7;
const B: f64 = 1.3;
const M: f64 = 2.0;

/// The value of a formula at an input vector `(q, v, u)`.
type Value = Box<dyn Fn(&[f64]) -> f64>;

/// Components of a place at an input vector.
type Place = Box<dyn Fn(&[f64]) -> Vec<f64>>;

/// A function of one number in the language, with its values and slopes.
type Curve = (&'static str, [fn(f64) -> f64; 2]);

/// Functions of which each scene has one as `f`.
const CURVES: [Curve; 5] = [
    (
        "tanh(s) + s^2",
        [|s| s.tanh() + s * s, |s| 1.0 - s.tanh().powi(2) + 2.0 * s],
    ),
    (
        "s*exp(-s)",
        [|s| s * (-s).exp(), |s| (1.0 - s) * (-s).exp()],
    ),
    (
        "a*(1 - cos(b*s))",
        [|s| A * (1.0 - (B * s).cos()), |s| A * B * (B * s).sin()],
    ),
    (
        "atan(s + 1)",
        [|s| (s + 1.0).atan(), |s| 1.0 / (1.0 + (s + 1.0).powi(2))],
    ),
    (
        "ln(3 + s^2)",
        [|s| (3.0 + s * s).ln(), |s| 2.0 * s / (3.0 + s * s)],
    ),
];

/// A scene, its Lagrangian and the force on its first coordinate.
pub(crate) struct Written {
    pub(crate) text: String,
    pub(crate) lagrangian: Value,
    pub(crate) force: Value,
}

/// A function of the first `n` inputs that is smooth and moderate for arguments between -1 and 1.
fn formula(random: &mut Draw, (n, f): (usize, Curve), depth: u32) -> (String, Value) {
    if depth == 0 {
        let (text, value) = match random.below(4) {
            0 => {
                let number = 1 + random.below(4);
                (number.to_string(), number as f64)
            }
            1 => [("a".to_owned(), A), ("b".to_owned(), B)][random.below(2)].clone(),
            _ => {
                let i = random.below(n);
                return (format!("q{}", i + 1), Box::new(move |x| x[i]));
            }
        };
        return (text, Box::new(move |_| value));
    }
    let kind = random.below(12);
    let (x, first) = formula(random, (n, f), depth - 1);
    let (text, curve): (String, fn(f64) -> f64) = match kind {
        5 => (format!("sin({x})"), f64::sin),
        6 => (format!("cos({x})"), f64::cos),
        7 => (format!("({x})^2"), |x| x * x),
        9 => (format!("sqrt(2 + cos({x}))"), |x| (2.0 + x.cos()).sqrt()),
        10 => (format!("f({x})"), f.1[0]),
        11 => (format!("diff(f)({x})"), f.1[1]),
        _ => {
            let (y, second) = formula(random, (n, f), depth - 1);
            let (text, both): (String, fn(f64, f64) -> f64) = match kind {
                0 | 1 => (format!("({x} + {y})"), |x, y| x + y),
                2 => (format!("({x} - {y})"), |x, y| x - y),
                3 | 4 => (format!("{x}*{y}"), |x, y| x * y),
                _ => (format!("({x})/(3 + sin({y}))"), |x, y| x / (3.0 + y.sin())),
            };
            return (text, Box::new(move |x| both(first(x), second(x))));
        }
    };
    (text, Box::new(move |x| curve(first(x))))
}

/// A place, half of the time multiplied by a matrix that is not singular.
fn turned(
    random: &mut Draw,
    scene: (usize, Curve),
    (place, components): (String, [Value; 2]),
) -> (String, Place) {
    let (angle, turn) = formula(random, scene, 1);
    let (text, matrix): (String, fn(f64) -> [f64; 4]) = match random.below(8) {
        0 => (format!("rotation({angle})*{place}"), |x| {
            [x.cos(), -x.sin(), x.sin(), x.cos()]
        }),
        1 => (format!("transpose(rotation({angle}))*{place}"), |x| {
            [x.cos(), x.sin(), -x.sin(), x.cos()]
        }),
        2 => (format!("((1, ({angle})/4), (0, b))*{place}"), |x| {
            [1.0, x / 4.0, 0.0, B]
        }),
        3 => (
            format!("(rotation(a)*((b, 0), (({angle})/3, 1)) + ((1, 0), (0, 2)))*{place}"),
            |x| {
                let (s, c) = A.sin_cos();
                [1.0 + c * B - s * x / 3.0, -s, s * B + c * x / 3.0, 2.0 + c]
            },
        ),
        _ => (place, |_| [1.0, 0.0, 0.0, 1.0]),
    };
    let place = move |x: &[f64]| {
        let [a, b, c, d] = matrix(turn(x));
        let [y, z] = components.each_ref().map(|component| component(x));
        vec![a * y + b * z, c * y + d * z]
    };
    (text, Box::new(place))
}

/// A random scene: point masses at random places, a random potential, random forces.
pub(crate) fn source(random: &mut Draw) -> Written {
    let n = 1 + random.below(4);
    let mut text = String::from("S { parameters { a = 0.7, b = 1.3, m = 2 } coordinates {");
    (1..=n).for_each(|i| text += &format!("q{i}, "));
    let f = CURVES[random.below(CURVES.len())];
    let _ = write!(text, "}} controls {{ u }} fn f(s) = {} ", f.0);
    let scene = (n, f);
    let (mut kinetic, mut places) = (Vec::new(), Vec::new());
    for i in 0..n {
        // Masses may move along their own coordinate plus anything of the others: never singular.
        let depth = random.below(3) as u32;
        let [first, second] = [(); 2].map(|()| formula(random, scene, depth));
        let place = format!("(q{} + ({})/5, ({})/4)", i + 1, first.0, second.0);
        let components: [Value; 2] = [
            Box::new(move |x| x[i] + first.1(x) / 5.0),
            Box::new(move |x| second.1(x) / 4.0),
        ];
        let (place, components) = turned(random, scene, (place, components));
        let _ = write!(text, "let p{i} = {place} ");
        kinetic.push(format!("m/2*|dot(p{i})|^2 + dot(q{})^2", i + 1));
        places.push(components);
    }
    let (mut potential, energy) = formula(random, scene, 3);
    let bound = random.below(4) == 0;
    if bound {
        potential += " - p0 . (rotation(q1)*p0)/7";
    }
    let (share, along) = formula(random, scene, 1);
    let _ = write!(
        text,
        "lagrangian {} - ({potential}) + b*f(a) forces {{ q1: u*cos({share}) - a*dot(q1)*b*m }} }}",
        kinetic.join(" + "),
    );
    let square = |vector: &[f64]| vector.iter().map(|c| c * c).sum::<f64>();
    let lagrangian = move |x: &[f64]| {
        let moving = places.iter().map(|place| square(&rates(n, x, place)));
        let kinetic = M / 2.0 * moving.sum::<f64>() + square(&x[n..2 * n]);
        let share = if bound { x[0].cos() / 7.0 } else { 0.0 };
        kinetic - energy(x) + share * square(&places[0](x)) + B * f.1[0](A)
    };
    Written {
        text,
        lagrangian: Box::new(lagrangian),
        force: Box::new(move |x| x[2 * n] * along(x).cos() - A * x[n] * B * M),
    }
}
