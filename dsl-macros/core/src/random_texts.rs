//! Random scenes over the grammar.

use std::fmt::Write;

/// A small generator of random numbers (splitmix64), so that runs repeat exactly.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x5851_f42d_4c95_7f2d))
    }

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
    pub(crate) fn number(&mut self) -> f64 {
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
pub(crate) fn source(random: &mut Random) -> String {
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
