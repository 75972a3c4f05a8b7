//! Families of scenes with many contacts, as texts: `n` bodies each.

use std::fmt::Write as _;

/// `one(1), one(2), ..` joined.
fn each(n: usize, by: &str, one: impl Fn(usize) -> String) -> String {
    (1..=n).map(one).collect::<Vec<_>>().join(by)
}

/// A number in `0..1` for each pair of numbers, always the same.
fn scattered(i: usize, salt: usize) -> f64 {
    let hash = (i * 2_654_435_761 + salt * 40_503 + 12_345) % 1_000_003;
    hash as f64 / 1_000_003.0
}

/// `n` equal balls that touch in a row, of which the first flies onto the others with a `speed`.
pub(crate) fn row(n: usize, law: &str, speed: f64) -> String {
    let contacts = each(n - 1, " ", |i| {
        format!("surface c{i}: x{} - x{i} - 0.1 [m] >= 0", i + 1)
    });
    format!(
        "parameters {{ m: kg = 1 }} coordinates {{ {} }} lagrangian {} {contacts} impact {}: {law} start {{ x1: -0.3 [m], \
         dot(x1): {speed} [m/s], {} }} horizon 1 [s]",
        each(n, ", ", |i| format!("x{i}: m")),
        each(n, " + ", |i| format!("m/2*dot(x{i})^2")),
        each(n - 1, ", ", |i| format!("c{i}")),
        each(n - 1, ", ", |i| format!(
            "x{}: {:.1} [m]",
            i + 1,
            0.1 * i as f64
        )),
    )
}

/// `n` boxes above each other that fall onto each other.
pub(crate) fn tower(n: usize) -> String {
    let contacts = each(n, " ", |i| match i {
        1 => "surface c1: z1 - 0.05 [m] >= 0".to_owned(),
        _ => format!("surface c{i}: z{i} - z{} - 0.1 [m] >= 0", i - 1),
    });
    format!(
        "parameters {{ m: kg = 1, g: m/s^2 = 9.81 }} coordinates {{ {} }} lagrangian {} {contacts} impact {}: inelastic \
         start {{ {} }} horizon 1 [s]",
        each(n, ", ", |i| format!("z{i}: m")),
        each(n, " + ", |i| format!("m/2*dot(z{i})^2 - m*g*z{i}")),
        each(n, ", ", |i| format!("c{i}")),
        each(n, ", ", |i| format!(
            "z{i}: {:.3} [m]",
            0.11 * i as f64 - 0.05
        )),
    )
}

/// `n` boxes that may tilt and shift on each other, two corners each, with a coefficient of friction or without.
pub(crate) fn stack(n: usize, friction: Option<f64>) -> String {
    let mut lets = String::new();
    let mut contacts = String::new();
    for i in 1..=n {
        let _ = write!(
            lets,
            " let n{i} = (-sin(a{i}), cos(a{i})) let t{i} = (cos(a{i}), sin(a{i})) let c{i} = (x{i}, z{i}) \
             let l{i} = c{i} - 0.1 [m]*t{i} - 0.05 [m]*n{i} let r{i} = c{i} + 0.1 [m]*t{i} - 0.05 [m]*n{i}"
        );
        for side in ["l", "r"] {
            let (gap, slides) = if i == 1 {
                (format!("{side}1.z"), format!("dot({side}1.y)"))
            } else {
                let j = i - 1;
                (
                    format!("({side}{i}.y - x{j})*n{j}.y + ({side}{i}.z - z{j})*n{j}.z - 0.05 [m]"),
                    format!(
                        "(dot({side}{i}.y) - dot(x{j}))*t{j}.y + (dot({side}{i}.z) - dot(z{j}))*t{j}.z + 0.05 [m]*dot(a{j})"
                    ),
                )
            };
            let law = friction.map_or(String::new(), |mu| {
                format!(", friction {mu}, sliding {slides}")
            });
            let _ = write!(
                contacts,
                " surface {side}_{i}: {gap} >= 0 impact {side}_{i}: inelastic{law}"
            );
        }
    }
    format!(
        "parameters {{ m: kg = 1, g: m/s^2 = 9.81 }} coordinates {{ {} }}{lets} lagrangian {}{contacts} start {{ {} }} \
         horizon 0.5 [s]",
        each(n, ", ", |i| format!("x{i}: m, z{i}: m, a{i}")),
        each(n, " + ", |i| format!(
            "m/2*|dot(c{i})|^2 + m*(0.05 [m^2])/24*dot(a{i})^2 - m*g*z{i}"
        )),
        each(n, ", ", |i| format!(
            "x{i}: {:.4} [m], z{i}: {:.4} [m]",
            0.02 * (scattered(i, 1) - 0.5),
            0.102 * i as f64 - 0.05
        )),
    )
}

/// `n` blocks on a rough floor, with springs between them and to a wall.
pub(crate) fn rough_blocks(n: usize) -> String {
    let spring = |i: usize| match i {
        1 => "20 [N/m]*x1^2".to_owned(),
        _ => format!("20 [N/m]*(x{i} - x{})^2", i - 1),
    };
    format!(
        "parameters {{ m: kg = 1, g: m/s^2 = 9.81 }} coordinates {{ {} }} lagrangian {} - {} {} start {{ {} }} horizon 1 [s]",
        each(n, ", ", |i| format!("x{i}: m, z{i}: m")),
        each(n, " + ", |i| format!(
            "m/2*(dot(x{i})^2 + dot(z{i})^2) - m*g*z{i}"
        )),
        each(n, " - ", spring),
        each(n, " ", |i| format!(
            "surface c{i}: z{i} >= 0 impact c{i}: inelastic, friction 0.3, sliding dot(x{i})"
        )),
        each(n, ", ", |i| format!(
            "x{i}: {:.4} [m]",
            0.6 * (scattered(i, 2) - 0.5)
        )),
    )
}

/// `n` discs in a box, every pair of which may touch.
pub(crate) fn discs(n: usize) -> String {
    let columns = (n as f64).sqrt().ceil() as usize;
    let width = 0.3 * columns as f64;
    let walls = each(n, " ", |i| {
        format!(
            "surface f{i}: z{i} - 0.1 [m] >= 0 surface l{i}: x{i} - 0.1 [m] >= 0 surface r{i}: {width:.1} [m] - 0.1 [m] - x{i} >= 0"
        )
    });
    let mut pairs = String::new();
    let mut names = each(n, ", ", |i| format!("f{i}, l{i}, r{i}"));
    for i in 2..=n {
        for j in 1..i {
            let _ = write!(pairs, " surface d{j}_{i}: |p{i} - p{j}| - 0.2 [m] >= 0");
            let _ = write!(names, ", d{j}_{i}");
        }
    }
    let start = |i: usize| {
        let (column, row) = ((i - 1) % columns, (i - 1) / columns);
        format!(
            "x{i}: {:.4} [m], z{i}: {:.4} [m], dot(x{i}): {:.4} [m/s]",
            0.15 + 0.3 * column as f64 + 0.06 * (scattered(i, 3) - 0.5),
            0.15 + 0.25 * row as f64 + 0.04 * (scattered(i, 4) - 0.5),
            scattered(i, 5) - 0.5,
        )
    };
    format!(
        "parameters {{ m: kg = 1, g: m/s^2 = 9.81 }} coordinates {{ {} }} {} lagrangian {} {walls}{pairs} \
         impact {names}: inelastic start {{ {} }} horizon 0.5 [s]",
        each(n, ", ", |i| format!("x{i}: m, z{i}: m")),
        each(n, " ", |i| format!("let p{i} = (x{i}, z{i})")),
        each(n, " + ", |i| format!("m/2*|dot(p{i})|^2 - m*g*z{i}")),
        each(n, ", ", start),
    )
}

/// A chain of `n` links that swings onto a floor, with the end of every link.
pub(crate) fn chain(n: usize) -> String {
    let joint = |i: usize| {
        let before = if i == 1 {
            "(0 [m], h)".to_owned()
        } else {
            format!("p{}", i - 1)
        };
        format!("let p{i} = {before} + l*(sin(q{i}), -cos(q{i}))")
    };
    format!(
        "parameters {{ g: m/s^2 = 9.81, l: m = 0.1, h: m = {:.3} }} coordinates {{ {} }} {} lagrangian {} {} impact {}: \
         inelastic start {{ {} }} horizon 1 [s]",
        0.07 * n as f64,
        each(n, ", ", |i| format!("q{i}")),
        each(n, " ", joint),
        each(n, " + ", |i| format!(
            "1 [kg]*|dot(p{i})|^2/2 - 1 [kg]*g*p{i}.z"
        )),
        each(n, " ", |i| format!("surface c{i}: p{i}.z >= 0")),
        each(n, ", ", |i| format!("c{i}")),
        each(n, ", ", |i| format!("q{i}: {:.2}", 0.8 + 0.02 * i as f64)),
    )
}

/// A chain of `n` links that hangs freely, from the angles on that link `i` has with the vertical.
pub(crate) fn hanging(n: usize, angle: impl Fn(usize) -> f64, horizon: f64) -> String {
    let joint = |i: usize| {
        let before = match i {
            1 => String::new(),
            _ => format!("p{} + ", i - 1),
        };
        format!("let p{i} = {before}l*(sin(q{i}), -cos(q{i}))")
    };
    format!(
        "parameters {{ g: m/s^2 = 9.81, l: m = 0.1 }} coordinates {{ {} }} {} lagrangian {} start {{ {} }} horizon \
         {horizon:e} [s]",
        each(n, ", ", |i| format!("q{i}")),
        each(n, " ", joint),
        each(n, " + ", |i| format!(
            "1 [kg]*|dot(p{i})|^2/2 - 1 [kg]*g*p{i}.z"
        )),
        each(n, ", ", |i| format!("q{i}: {:e}", angle(i))),
    )
}

/// An elastic bar of `n` masses and springs that flies onto a wall.
pub(crate) fn bar(n: usize) -> String {
    let spring = |i: usize| format!("k*{n}/2*(x{} - x{i} - {} [m])^2", i + 1, 1.0 / n as f64);
    let springs = match n {
        1 => String::new(),
        _ => format!(" - {}", each(n - 1, " - ", spring)),
    };
    format!(
        "parameters {{ m: kg = 1, k: N/m = 100 }} coordinates {{ {} }} lagrangian {}{springs} surface wall: x1 >= 0 \
         impact wall: inelastic start {{ {} }} horizon 1 [s]",
        each(n, ", ", |i| format!("x{i}: m")),
        each(n, " + ", |i| format!("m/{n}/2*dot(x{i})^2")),
        each(n, ", ", |i| format!(
            "x{i}: {:.6} [m], dot(x{i}): -1 [m/s]",
            0.1 + (i - 1) as f64 / n as f64
        )),
    )
}
