//! Families of scenes with many contacts, as texts: `n` bodies each.

/// `one(1), one(2), ..` joined.
fn each(n: usize, one: impl Fn(usize) -> String) -> String {
    (1..=n).map(one).collect::<Vec<_>>().join(", ")
}

/// A number in `0..1` for each pair of numbers, always the same.
fn scattered(i: usize, salt: usize) -> f64 {
    let hash = (i * 2_654_435_761 + salt * 40_503 + 12_345) % 1_000_003;
    hash as f64 / 1_000_003.0
}

/// `n` equal balls that touch in a row, of which the first flies onto the others with a `speed`.
pub(crate) fn row(n: usize, law: &str, speed: f64) -> String {
    format!(
        "count n = {n} parameters {{ m: kg = 1 }} coordinates {{ x[n]: m }}
        lagrangian sum(k in 1..=n: m/2*dot(x[k])^2)
        surface c[k in 1..n]: x[k + 1] - x[k] - 0.1 [m] >= 0
        impact c[k in 1..n]: {law}
        start {{ x[1]: -0.3 [m], dot(x[1]): {speed} [m/s], x[k in 2..=n]: (k - 1)/10*1 [m] }}
        horizon 1 [s]"
    )
}

/// `n` boxes above each other that fall onto each other.
pub(crate) fn tower(n: usize) -> String {
    format!(
        "count n = {n} parameters {{ m: kg = 1, g: m/s^2 = 9.81 }} coordinates {{ z[n]: m }}
        lagrangian sum(k in 1..=n: m/2*dot(z[k])^2 - m*g*z[k])
        surface c[k in 1..=n]: z[k] - if k > 1 {{ z[k - 1] + 0.1 [m] }} else {{ 0.05 [m] }} >= 0
        impact c[k in 1..=n]: inelastic
        start {{ z[k in 1..=n]: 0.11 [m]*k - 0.05 [m] }}
        horizon 1 [s]"
    )
}

/// `n` boxes that may tilt and shift on each other, two corners each.
pub(crate) fn stack(n: usize) -> String {
    let start = each(n, |i| {
        let (x, z) = (0.02 * (scattered(i, 1) - 0.5), 0.102 * i as f64 - 0.05);
        format!("x[{i}]: {x:.4} [m], z[{i}]: {z:.4} [m]")
    });
    format!(
        "count n = {n} parameters {{ m: kg = 1, g: m/s^2 = 9.81 }} coordinates {{ x[n]: m, z[n]: m, a[n]: rad }}
        let up[i in 1..=n] = (-sin(a[i]), cos(a[i]))
        let c[i in 1..=n] = (x[i], z[i])
        let foot[i in 1..=n, s in 0..=1] = c[i] + (2*s - 1)*0.1 [m]*(cos(a[i]), sin(a[i])) - 0.05 [m]*up[i]
        fn above(p, q, d) = (p.y - q.y)*d.y + (p.z - q.z)*d.z - 0.05 [m]
        lagrangian sum(i in 1..=n: m/2*|dot(c[i])|^2 + m*(0.05 [m^2])/24*dot(a[i])^2 - m*g*z[i])
        surface stands[i in 1..=n, s in 0..=1]:
            if i > 1 {{ above(foot[i, s], c[i - 1], up[i - 1]) }} else {{ foot[1, s].z }} >= 0
        impact stands[i in 1..=n, s in 0..=1]: inelastic
        start {{ {start} }}
        horizon 0.5 [s]"
    )
}

/// `n` blocks on a rough floor, with springs between them and to a wall.
pub(crate) fn rough_blocks(n: usize) -> String {
    let start = each(n, |i| {
        format!("x[{i}]: {:.4} [m]", 0.6 * (scattered(i, 2) - 0.5))
    });
    format!(
        "count n = {n} parameters {{ m: kg = 1, g: m/s^2 = 9.81 }} coordinates {{ x[n]: m, z[n]: m }}
        lagrangian sum(k in 1..=n: m/2*(dot(x[k])^2 + dot(z[k])^2) - m*g*z[k])
            - 20 [N/m]*(x[1]^2 + sum(k in 2..=n: (x[k] - x[k - 1])^2))
        surface c[k in 1..=n]: z[k] >= 0
        impact c[k in 1..=n]: inelastic, friction 0.3, sliding dot(x[k])
        start {{ {start} }}
        horizon 1 [s]"
    )
}

/// `n` discs in a box, every pair of which may touch.
pub(crate) fn discs(n: usize) -> String {
    let columns = (n as f64).sqrt().ceil() as usize;
    let start = each(n, |i| {
        let (column, row) = ((i - 1) % columns, (i - 1) / columns);
        let x = 0.15 + 0.3 * column as f64 + 0.06 * (scattered(i, 3) - 0.5);
        let z = 0.15 + 0.25 * row as f64 + 0.04 * (scattered(i, 4) - 0.5);
        let speed = scattered(i, 5) - 0.5;
        format!("x[{i}]: {x:.4} [m], z[{i}]: {z:.4} [m], dot(x[{i}]): {speed:.4} [m/s]")
    });
    format!(
        "count n = {n} count columns = {columns}
        parameters {{ m: kg = 1, g: m/s^2 = 9.81 }} coordinates {{ x[n]: m, z[n]: m }}
        let p[k in 1..=n] = (x[k], z[k])
        lagrangian sum(k in 1..=n: m/2*|dot(p[k])|^2 - m*g*z[k])
        surface floor[k in 1..=n]: z[k] - 0.1 [m] >= 0
        surface left[k in 1..=n]: x[k] - 0.1 [m] >= 0
        surface right[k in 1..=n]: 0.3 [m]*columns - 0.1 [m] - x[k] >= 0
        surface pair[i in 2..=n, j in 1..i]: |p[i] - p[j]| - 0.2 [m] >= 0
        impact floor[k in 1..=n]: inelastic
        impact left[k in 1..=n]: inelastic
        impact right[k in 1..=n]: inelastic
        impact pair[i in 2..=n, j in 1..i]: inelastic
        start {{ {start} }}
        horizon 0.5 [s]"
    )
}

/// A chain of `n` links that swings onto a floor, with the end of every link.
pub(crate) fn chain(n: usize) -> String {
    format!(
        "count n = {n} parameters {{ g: m/s^2 = 9.81, l: m = 0.1, h: m = {:.3} }} coordinates {{ q[n]: rad }}
        let p[k in 1..=n] = p[k - 1] + l*(sin(q[k]), -cos(q[k])), p[0] = (0 [m], h)
        lagrangian sum(k in 1..=n: 1 [kg]*|dot(p[k])|^2/2 - 1 [kg]*g*p[k].z)
        surface c[k in 1..=n]: p[k].z >= 0
        impact c[k in 1..=n]: inelastic
        start {{ q[k in 1..=n]: 0.8 + 0.02*k }}
        horizon 1 [s]",
        0.07 * n as f64,
    )
}

/// A chain of `n` links that hangs freely, from the angles on that link `i` has with the vertical.
pub(crate) fn hanging(n: usize, angle: impl Fn(usize) -> f64, horizon: f64) -> String {
    let start = each(n, |i| format!("q[{i}]: {:e}", angle(i)));
    format!(
        "count n = {n} parameters {{ g: m/s^2 = 9.81, l: m = 0.1 }} coordinates {{ q[n]: rad }}
        let p[k in 1..=n] = p[k - 1] + l*(sin(q[k]), -cos(q[k])), p[0] = (0, 0)
        lagrangian sum(k in 1..=n: 1 [kg]*|dot(p[k])|^2/2 - 1 [kg]*g*p[k].z)
        start {{ {start} }}
        horizon {horizon:e} [s]"
    )
}

/// An elastic bar of `n` masses and springs that flies onto a wall.
pub(crate) fn bar(n: usize) -> String {
    format!(
        "count n = {n} parameters {{ m: kg = 1, k: N/m = 100 }} coordinates {{ x[n]: m }}
        lagrangian sum(i in 1..=n: m/n/2*dot(x[i])^2) - sum(i in 1..n: k*n/2*(x[i + 1] - x[i] - 1 [m]/n)^2)
        surface wall: x[1] >= 0
        impact wall: inelastic
        start {{ x[i in 1..=n]: 0.1 [m] + (i - 1)*1 [m]/n, dot(x[i in 1..=n]): -1 [m/s] }}
        horizon 1 [s]"
    )
}
