//! Quadratic programs, flows in networks, and the polygon with its dense rows.

use std::f64::consts::PI;

use super::{INF, Stated, Statement, random, x};

/// Convex quadratic program with random sparse rows, from a fixed generator.
pub(super) fn random_quadratic(n: usize, m: usize) -> Stated {
    let mut s = Statement::new("random_quadratic");
    let mut random = random(12345);
    for _ in 0..n {
        s.variable(0.0, 1.0, 0.5);
    }
    for i in 0..n {
        let (target, j) = (3.0 * random() - 1.0, (random() * n as f64) as usize);
        s.minimize(format!(
            "({0} - {target})^2 + 0.5*({0} - {1})^2",
            x(i),
            x(j)
        ));
    }
    for k in 0..m {
        let base = k * (n - 8) / m;
        let mut text = String::from("-2");
        for _ in 0..4 {
            let j = base + (random() * 7.0) as usize;
            // six digits, as in the text
            let coefficient = ((0.5 + random()) * 1e6).round() / 1e6;
            text += &format!(" + {coefficient}*{}", x(j));
        }
        s.row(-INF, 0.0, text);
    }
    s.finish()
}

/// Optimal power-like network of quadratic flows: conservation at nodes of a ring with chords.
pub(super) fn network_flow(nodes: usize) -> Stated {
    let mut s = Statement::new("network_flow");
    let mut balance = vec![String::from("0"); nodes];
    for k in 0..nodes {
        for offset in [1, 7] {
            let target = (k + offset) % nodes;
            let weight = 0.1 * (1 + k % 3) as f64;
            let flow = s.variable(-2.0, 2.0, 0.1);
            s.minimize(format!("{weight}*exp({0}) + {0}^2", x(flow)));
            balance[k] += &format!(" + {}", x(flow));
            balance[target] += &format!(" - {}", x(flow));
        }
        let supply = s.variable(0.0, 3.0, 1.0);
        let weight = 1.0 + (k % 5) as f64;
        s.minimize(format!("{weight}*{}^2", x(supply)));
        balance[k] += &format!(" - {}", x(supply));
    }
    for (k, text) in balance.into_iter().enumerate() {
        let demand = 0.2 + 0.6 * (k % 2) as f64;
        s.equality(format!("{text} + {demand}"));
    }
    s.finish()
}

/// Polygon of largest area with unit diameter (COPS 3.0, problem 1), without the diameters through the last vertex,
/// which lies in the origin.
pub(super) fn polygon(vertices: usize) -> Stated {
    let mut s = Statement::new("polygon");
    let mut r = Vec::new();
    let mut angle = Vec::new();
    for k in 0..vertices {
        let last = k + 1 == vertices;
        let at = (k + 1) as f64 / vertices as f64;
        let largest = if last { 0.0 } else { 1.0 };
        r.push(s.variable(0.0, largest, 4.0 * at * (1.0 - at)));
        angle.push(s.variable(if last { PI } else { 0.0 }, PI, PI * at));
    }
    for k in 0..vertices - 1 {
        let [a, b, c, d] = [r[k + 1], r[k], angle[k + 1], angle[k]].map(x);
        s.minimize(format!("-0.5*{a}*{b}*sin({c} - {d})"));
        s.row(0.0, INF, format!("{c} - {d}"));
        for j in k + 1..vertices - 1 {
            let [a, b, c, d] = [r[k], r[j], angle[k], angle[j]].map(x);
            let text = format!("{a}^2 + {b}^2 - 2*{a}*{b}*cos({c} - {d})");
            s.row(-INF, 1.0, text);
        }
    }
    s.finish()
}
