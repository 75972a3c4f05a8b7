//! Random Lagrangians over the grammar, derived, and compared with nested dual numbers.

use crate::ast::Scene;
use crate::derive::{self, Solution, Sparse};
use crate::diagnostics::Diagnostics;
use crate::graph::{self, Variable};
use crate::scene::CheckedScene;
use crate::testing::{Evaluator, Nested, Point, run};
use crate::{check, parse};
use std::fmt::Write;

/// Models per test run; the requirement is 200.
const MODELS: u64 = 120;

/// A small generator of random numbers (splitmix64), so that runs repeat exactly.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// Uniform in -1..1.
    fn number(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A function of some of the names that is smooth and moderate for arguments between -1 and 1.
fn formula(random: &mut Random, names: &[String], depth: u32) -> String {
    let pick = |random: &mut Random| names[random.below(names.len() as u64) as usize].clone();
    if depth == 0 {
        return match random.below(4) {
            0 => format!("{}", 1 + random.below(4)),
            1 => ["a", "b"][random.below(2) as usize].to_owned(),
            _ => pick(random),
        };
    }
    let inner = |random: &mut Random| formula(random, names, depth - 1);
    match random.below(12) {
        0 | 1 => format!("({} + {})", inner(random), inner(random)),
        2 => format!("({} - {})", inner(random), inner(random)),
        3 | 4 => format!("{}*{}", inner(random), inner(random)),
        5 => format!("sin({})", inner(random)),
        6 => format!("cos({})", inner(random)),
        7 => format!("({})^2", inner(random)),
        8 => format!("({})/(3 + sin({}))", inner(random), inner(random)),
        9 => format!("sqrt(2 + cos({}))", inner(random)),
        10 => format!("f({})", inner(random)),
        _ => format!("diff(f)({})", inner(random)),
    }
}

/// A place, half of the time multiplied by a matrix that is not singular.
fn turned(random: &mut Random, names: &[String], place: &str) -> String {
    let angle = formula(random, names, 1);
    match random.below(8) {
        0 => format!("rotation({angle})*{place}"),
        1 => format!("transpose(rotation({angle}))*{place}"),
        2 => format!("((1, ({angle})/4), (0, b))*{place}"),
        3 => format!("(rotation(a)*((b, 0), (({angle})/3, 1)) + ((1, 0), (0, 2)))*{place}"),
        _ => place.to_owned(),
    }
}

/// Source of a random scene: point masses at random places, a random potential, random forces.
fn source(random: &mut Random) -> String {
    let n = 1 + random.below(4) as usize;
    let names: Vec<String> = (1..=n).map(|i| format!("q{i}")).collect();
    let mut text = String::from("S { parameters { a = 0.7, b = 1.3, m = 2 } coordinates {");
    for name in &names {
        let _ = write!(text, "{name}, ");
    }
    text.push_str("} controls { u } ");
    let functions = [
        "tanh(s) + s^2",
        "s*exp(-s)",
        "a*(1 - cos(b*s))",
        "atan(s + 1)",
        "ln(3 + s^2)",
    ];
    let _ = write!(
        text,
        "fn f(s) = {} ",
        functions[random.below(functions.len() as u64) as usize]
    );
    let mut kinetic = Vec::new();
    for (i, name) in names.iter().enumerate() {
        // Masses may move along their own coordinate plus anything of the others: never singular.
        let depth = random.below(3) as u32;
        let (first, second) = (
            formula(random, &names, depth),
            formula(random, &names, depth),
        );
        let place = format!("({name} + ({first})/5, ({second})/4)");
        let place = turned(random, &names, &place);
        let _ = write!(text, "let p{i} = {place} ");
        kinetic.push(format!("m/2*|dot(p{i})|^2 + dot({name})^2"));
    }
    let mut potential = formula(random, &names, 3);
    if random.below(4) == 0 {
        let _ = write!(potential, " - p0 . (rotation({})*p0)/7", names[0]);
    }
    let _ = write!(
        text,
        "lagrangian {} - ({potential}) + b*f(a) forces {{ q1: u*cos({}) - a*dot(q1)*b*m }} }}",
        kinetic.join(" + "),
        formula(random, &names, 1),
    );
    text
}

#[expect(
    clippy::needless_range_loop,
    reason = "indices of a matrix read better"
)]
/// The free acceleration at a point, by nested dual numbers and elimination.
fn acceleration(evaluator: &Evaluator<'_>, point: &Point) -> Vec<Nested> {
    let n = point.q.len();
    let (first, second) = (point.tag, point.tag + 1);
    let one = Nested::Real(1.0);
    let mut m = vec![vec![Nested::Real(0.0); n]; n];
    let mut right = Vec::with_capacity(n);
    for i in 0..n {
        let with = |q: bool, moving: bool, j: Option<usize>| {
            let mut shifted = point.clone();
            shifted.tag += 2;
            if moving {
                for (q, v) in shifted.q.iter_mut().zip(&point.v) {
                    *q = Nested::dual(first, q.clone(), v.clone());
                }
            }
            if let Some(j) = j {
                shifted.v[j] = Nested::dual(first, shifted.v[j].clone(), one.clone());
            }
            let slot = if q {
                &mut shifted.q[i]
            } else {
                &mut shifted.v[i]
            };
            *slot = Nested::dual(second, slot.clone(), one.clone());
            evaluator.scalar(evaluator.lagrangian, &shifted).eps(second)
        };
        for j in 0..n {
            m[i][j] = with(false, false, Some(j)).eps(first);
        }
        let mut value = with(true, false, None).add(&with(false, true, None).eps(first).negated());
        if let Some(force) = evaluator.forces.get(evaluator.coordinates[i]) {
            // Forces may contain velocities, which `dot` yields by a dual of its own.
            let mut at = point.clone();
            at.tag += 2;
            value = value.add(&evaluator.scalar(force, &at));
        }
        right.push(value);
    }
    for k in 0..n {
        let inverse = m[k][k].apply("recip");
        for i in k + 1..n {
            let factor = m[i][k].times(&inverse).negated();
            for j in k..n {
                m[i][j] = m[i][j].add(&factor.times(&m[k][j]));
            }
            right[i] = right[i].add(&factor.times(&right[k]));
        }
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            right[i] = right[i].add(&m[i][k].times(&right[k]).negated());
        }
        right[i] = right[i].times(&m[i][i].apply("recip"));
    }
    right
}

fn agree(what: &str, source: &str, found: f64, wanted: f64, scale: f64) {
    // The requirement is 1e-10; condition numbers of the random mass matrices reach 1e3.
    let error = (found - wanted).abs();
    assert!(
        error <= 1e-10 * scale.max(1.0),
        "{what}: {found:e} instead of {wanted:e} in\n{source}"
    );
}

/// Accelerations agree, measured by the largest.
fn agree_all(source: &str, found: &[f64], wanted: &[Nested]) {
    let scale = wanted.iter().fold(0.0_f64, |s, w| s.max(w.real().abs()));
    for (found, wanted) in found.iter().zip(wanted) {
        agree("acceleration", source, *found, wanted.real(), scale);
    }
}

/// Compares a sparse matrix with a dense one; whether each structural nonzero is one.
fn compare(
    what: &str,
    source: &str,
    sparse: &Sparse,
    values: &[f64],
    wanted: &[Vec<f64>],
    nonzero: &mut [bool],
) {
    let scale = wanted.iter().flatten().fold(0.0_f64, |s, w| s.max(w.abs()));
    let mut dense = vec![vec![0.0; sparse.columns]; sparse.rows];
    for (k, &(i, j)) in sparse.entries.iter().enumerate() {
        dense[i][j] = values[k];
        nonzero[k] |= wanted[i][j].abs() > 1e-9 * scale;
    }
    for (found, wanted) in dense.iter().flatten().zip(wanted.iter().flatten()) {
        agree(what, source, *found, *wanted, scale);
    }
}

/// The acceleration at the inputs `x` of `n` coordinates, with a dual number of its own along each input in `seeds`.
fn accelerations(evaluator: &Evaluator<'_>, x: &[f64], n: usize, seeds: &[usize]) -> Vec<Nested> {
    let mut q: Vec<Nested> = x.iter().map(|&x| Nested::Real(x)).collect();
    for (tag, &seed) in seeds.iter().enumerate() {
        let tag = tag as u32 + 1;
        q[seed] = Nested::dual(tag, q[seed].clone(), Nested::Real(1.0));
    }
    let u = q.split_off(2 * n);
    let v = q.split_off(n);
    let tag = seeds.len() as u32 + 1;
    let t = Nested::Real(0.0);
    acceleration(evaluator, &Point { q, v, u, t, tag })
}

/// Units other than SI, the time, vectors in space, matrices and every function of the language.
const SCENES: [&str; 4] = [
    "DoublePendulum {
        parameters {
            m_1: kg = 1.3, m_2: g = 700, l_1: cm = 80, l_2: m = 0.6, g: m/s^2 = 9.81,
            damping: N m s/rad = 0.1, shake: m = 0.05, omega: 1/s = 3, wall: m = 1.1,
        }
        coordinates { a: rad, b: deg }
        controls { torque: N m }
        let support = (0, shake*sin(omega*t))
        let p_1 = support + l_1*(sin(a), -cos(a))
        let p_2 = p_1 + l_2*(sin(a + b), -cos(a + b))
        lagrangian m_1/2*|dot(p_1)|^2 + m_2/2*|dot(p_2)|^2 - m_1*g*p_1.z - m_2*g*p_2.z
        forces { b: torque - damping*dot(b), a: -damping*dot(a) }
        surface post: p_2.y <= wall
        surface floor: p_2.z >= -120 [cm] + 0.1 [1/m]*p_2.y^2
        impact post, floor: inelastic
        start { b: 90 }
    }",
    "Functions {
        parameters { c = 1.5, e = 2.3 }
        coordinates { x, y, z }
        fn f(s) = sqrt(1 + s^2) + tanh(s)*exp(-s/3) + atan(s) + cbrt(3 + s)
        let p = (x, y + f(x), z*cosh(x/2))
        lagrangian |dot(p)|^2/2 + c*dot(z)^2*(2 + sin(x*y)) - ln(4 + x^2 + y) - atan2(y, 3 + x) - (4 + z)^e
            - diff(diff(f))(z)*tan(x/4) - asin(y/5)*acos(z/5) - sinh(x)*(3 + y)^1.5 - |p|^3/(2 + p[0]^2)
        forces { x: cross((x, y), (y, dot(x))), y: dot(p, (1, dot(y), z)) }
        surface wall: 5 + x - y^2 + sin(z) >= 0
        impact wall: inelastic
    }",
    "Top {
        parameters { m: kg = 0.4, l: m = 0.3, i_1: kg m^2 = 0.05, i_3: kg m^2 = 0.02, g: m/s^2 = 9.81 }
        coordinates { psi: rad, theta: rad, phi: rad }
        controls { u: N m }
        let r = rotation_z(psi)*rotation_x(theta)*rotation_z(phi)
        let w = transpose(r)*dot(r)
        let spin = (w[2][1], w[0][2], w[1][0])
        let tip = r*(0, 0, l)
        lagrangian spin . (diagonal(i_1, i_1, i_3)*spin)/2 - m*g*tip.z
        forces { phi: u }
        surface stop: tip.z >= 0.1*l
        impact stop: inelastic
    }",
    "Turntable {
        parameters { m: kg = 1.5, k: N/cm = 0.2, j: kg m^2 = 0.3, tilt: deg = 20 }
        coordinates { a: deg, x: cm, y: cm }
        let skew = ((1, 0.2), (-0.1, 1))
        let turn = rotation(a)*skew - ((0, sin(tilt)/10), (0, 0))
        let p = turn*(x, y)
        lagrangian m/2*|dot(p)|^2 + j/2*dot(a)^2 - k/2*(x, y) . (transpose(skew)*(skew*(x, y)))
        surface wall: p.y + 0.2*p.z <= 30 [cm]
        impact wall: inelastic
    }",
];

#[test]
fn formulas_are_what_the_syntax_says() {
    for source in SCENES {
        let mut random = Random(7);
        graph::reset();
        let tokens = source.parse().unwrap();
        let declared = parse::scene(tokens, &mut Diagnostics::default()).unwrap();
        let (scene, evaluator) = (checked(&declared, source), Evaluator::new(&declared));
        let n = scene.coordinates.len();
        let x: Vec<f64> = (0..=3 * n).map(|_| random.number()).collect();
        let input = |variable| match variable {
            Variable::Coordinate(i) => x[usize::from(i)],
            Variable::Velocity(i) => x[n + usize::from(i)],
            Variable::Control(i) => x[2 * n + usize::from(i)],
            Variable::Time => x[3 * n],
            Variable::Parameter(i) => scene.parameters[usize::from(i)].default,
            other => panic!("{other:?} is no input"),
        };
        let [q, v, u] = [0, 1, 2].map(|k| {
            let part = x[k * n..][..n].iter();
            part.map(|&x| Nested::Real(x)).collect()
        });
        let (t, tag) = (Nested::Real(x[3 * n]), 1);
        let point = Point { q, v, u, t, tag };
        let value = |expr| evaluator.scalar(expr, &point).real();
        let mut wanted = vec![value(evaluator.lagrangian)];
        let force = |name: &&str| {
            let force = evaluator.forces.get(name);
            force.map_or(0.0, |force| value(force) * evaluator.scale(name))
        };
        wanted.extend(evaluator.coordinates.iter().map(force));
        let gaps = evaluator.gaps.iter();
        wanted.extend(gaps.map(|&[free, other]| value(free) - value(other)));
        let mut outputs = vec![scene.lagrangian];
        outputs.extend(&scene.forces);
        outputs.extend(scene.contacts.iter().map(|contact| contact.gap));
        let found = run(&outputs, input);
        assert_eq!(found.len(), wanted.len());
        for (found, wanted) in found.into_iter().zip(wanted) {
            agree("formula", source, found, wanted, wanted.abs());
        }
    }
}

/// The scene of a source that has no mistake.
fn checked(declared: &Scene, source: &str) -> CheckedScene {
    let mut diagnostics = Diagnostics::default();
    let Ok(scene) = check::scene(declared, &mut diagnostics) else {
        let texts: Vec<String> = diagnostics
            .into_mistakes()
            .iter()
            .map(crate::Mistake::text)
            .collect();
        panic!("{texts:?}\n{source}");
    };
    scene
}

#[test]
#[expect(
    clippy::needless_range_loop,
    reason = "indices of a matrix read better"
)]
fn random_models_agree_with_nested_dual_numbers_and_have_minimal_patterns() {
    let mut minimal = 0;
    for seed in 0..MODELS {
        let mut random = Random(seed.wrapping_mul(0x5851_f42d_4c95_7f2d));
        let source = source(&mut random);
        graph::reset();
        let mut diagnostics = Diagnostics::default();
        let tokens = source.parse().unwrap();
        let declared = parse::scene(tokens, &mut diagnostics).unwrap();
        let scene = checked(&declared, &source);
        let Ok(equations) = derive::equations(&scene) else {
            panic!("singular\n{source}");
        };
        let Solution::Explicit(solution) = &equations.acceleration else {
            panic!("random models are small");
        };
        let evaluator = Evaluator::new(&declared);
        let n = scene.coordinates.len();
        let inputs = equations.inputs.len();
        let mut first = vec![false; solution.jacobian.entries.len()];
        let mut second = vec![false; solution.hessian.entries.len()];
        for _ in 0..2 {
            let x: Vec<f64> = (0..inputs).map(|_| random.number()).collect();
            let weights: Vec<f64> = (0..n).map(|_| random.number()).collect();
            let input = |variable| match variable {
                Variable::Coordinate(i) => x[usize::from(i)],
                Variable::Velocity(i) => x[n + usize::from(i)],
                Variable::Control(i) => x[2 * n + usize::from(i)],
                Variable::Parameter(i) => scene.parameters[usize::from(i)].default,
                Variable::Multiplier(i) => weights[usize::from(i)],
                other => panic!("{other:?} is no input"),
            };
            let at = |seeds: &[usize]| accelerations(&evaluator, &x, n, seeds);
            let found = run(&solution.values, input);
            agree_all(&source, &found, &at(&[]));
            let mut wanted = vec![vec![0.0; inputs]; n];
            for j in 0..inputs {
                for (i, value) in at(&[j]).iter().enumerate() {
                    wanted[i][j] = value.eps(1).real();
                }
            }
            let values = run(&solution.jacobian.values, input);
            compare(
                "jacobian",
                &source,
                &solution.jacobian,
                &values,
                &wanted,
                &mut first,
            );
            let mut wanted = vec![vec![0.0; inputs]; inputs];
            for i in 0..inputs {
                for j in 0..=i {
                    wanted[i][j] = at(&[i, j])
                        .iter()
                        .zip(&weights)
                        .map(|(value, weight)| value.eps(2).eps(1).real() * weight)
                        .sum();
                }
            }
            let values = run(&solution.hessian.values, input);
            compare(
                "hessian",
                &source,
                &solution.hessian,
                &values,
                &wanted,
                &mut second,
            );
        }
        if first.iter().chain(&second).all(|&nonzero| nonzero) {
            minimal += 1;
        }
    }
    assert!(
        100 * minimal >= 95 * MODELS,
        "patterns of only {minimal} of {MODELS} models are minimal"
    );
}
