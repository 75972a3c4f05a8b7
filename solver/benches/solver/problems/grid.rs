//! Problems of the calculus of variations and on grids.

use std::f64::consts::PI;

use super::{INF, Stated, Statement, x};

/// Shape of least potential energy of a chain of given length between two points (COPS 3.0, problem 3); a running
/// length, so that no row is dense.
pub(super) fn hanging_chain(nodes: usize) -> Stated {
    let mut s = Statement::new("hanging_chain");
    let h = 1.0 / nodes as f64;
    let mut height = Vec::new();
    let mut slope = Vec::new();
    for k in 0..=nodes {
        let at = k as f64 * h;
        let (lower, upper) = match k {
            0 => (1.0, 1.0),
            k if k == nodes => (3.0, 3.0),
            _ => (-INF, INF),
        };
        height.push(s.variable(lower, upper, 4.0 * at * (0.5 * at - 0.25) + 1.0));
        slope.push(s.variable(-INF, INF, 4.0 * (at - 0.25)));
    }
    let mut before: Option<usize> = None;
    for k in 0..nodes {
        let [c, d, u, w] = [height[k], height[k + 1], slope[k], slope[k + 1]].map(x);
        let half = 0.5 * h;
        s.equality(format!("{d} - {c} - {half}*({u} + {w})"));
        s.minimize(format!(
            "{half}*({c}*sqrt(1 + {u}^2) + {d}*sqrt(1 + {w}^2))"
        ));
        let length = s.variable(-INF, INF, 4.0 * (k as f64 + 1.0) * h);
        let text = before.map_or_else(|| String::from("0"), x);
        s.equality(format!(
            "{} - {text} - {half}*(sqrt(1 + {u}^2) + sqrt(1 + {w}^2))",
            x(length)
        ));
        before = Some(length);
    }
    let end = before.expect("at least one node");
    s.row(4.0, 4.0, x(end));
    s.finish()
}

/// Elliptic control with bounds on state and control on a square grid (Mittelmann 2001).
pub(super) fn elliptic_control(side: usize) -> Stated {
    let mut s = Statement::new("elliptic_control");
    let h = 1.0 / (side + 1) as f64;
    let mut field = |upper, lower| -> Vec<usize> {
        (0..side * side)
            .map(|_| s.variable(lower, upper, 0.0))
            .collect()
    };
    let y = field(0.371, -INF);
    let u = field(9.0, -8.0);
    for i in 0..side {
        for j in 0..side {
            let (a, b) = ((i + 1) as f64 * h, (j + 1) as f64 * h);
            let target = 1.0 + 2.0 * (a * (a - 1.0) + b * (b - 1.0));
            let forcing = (PI * a).sin() * (PI * b).sin();
            let k = i * side + j;
            let mut text = format!("4*{}", x(y[k]));
            let mut neighbour = |inside: bool, k: usize| {
                if inside {
                    text += &format!(" - {}", x(y[k]));
                }
            };
            neighbour(j + 1 < side, k + 1);
            neighbour(i + 1 < side, k + side);
            neighbour(j > 0, k.wrapping_sub(1));
            neighbour(i > 0, k.wrapping_sub(side));
            s.equality(format!(
                "{text} - {}*(exp({}) + {})",
                h * h,
                x(y[k]),
                x(u[k])
            ));
            let weight = 0.5 * h * h;
            s.minimize(format!(
                "{weight}*(({} - {target})^2 + 0.001*({} - {forcing})^2)",
                x(y[k]),
                x(u[k])
            ));
        }
    }
    s.finish()
}

/// Minimal surface over an obstacle, bounds only (COPS 3.0, problem 17).
pub(super) fn obstacle_surface(side: usize) -> Stated {
    let mut s = Statement::new("obstacle_surface");
    let h = 1.0 / (side + 1) as f64;
    let mut heights = vec![vec![String::from("0"); side + 2]; side + 2];
    for (i, line) in heights.iter_mut().enumerate().take(side + 1).skip(1) {
        for (j, height) in line.iter_mut().enumerate() {
            let (a, b) = (i as f64 * h, j as f64 * h);
            let edge = 1.0 - (2.0 * a - 1.0).powi(2);
            *height = if j == 0 || j == side + 1 {
                edge.to_string()
            } else {
                let middle = (a - 0.5).abs() < 0.25 && (b - 0.5).abs() < 0.25;
                let lower = if middle { 1.0 } else { 0.0 };
                x(s.variable(lower, INF, edge.max(lower)))
            };
        }
    }
    for i in 0..=side {
        for j in 0..=side {
            let [c, r, u] = [&heights[i][j], &heights[i + 1][j], &heights[i][j + 1]];
            s.minimize(format!(
                "{}*sqrt(1 + (({r} - {c})/{h})^2 + (({u} - {c})/{h})^2)",
                h * h
            ));
        }
    }
    s.finish()
}
