//! Problems of the calculus of variations and on grids.

use std::f64::consts::PI;

use hangtime_solver::nlp::{DualNum, Element, Target};

use super::{INF, Stated, Statement, x};

/// `x sqrt(1 + u^2)` and `sqrt(1 + u^2)`.
struct ArcLength;

impl Element<2, 2> for ArcLength {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x, u]: &[D; 2]) -> [D; 2] {
        let length = (*u * *u + 1.0).sqrt();
        [*x * length, length]
    }
}

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
    let mut targets = vec![(Vec::new(), Vec::new()); nodes + 1];
    let mut before: Option<usize> = None;
    for k in 0..nodes {
        let (c, d, u, w) = (height[k], height[k + 1], slope[k], slope[k + 1]);
        let [tc, td, tu, tw] = [c, d, u, w].map(x);
        let half = 0.5 * h;
        let row = s.equality(format!("{td} - {tc} - {half}*({tu} + {tw})"));
        s.linear(row, &[(1.0, d), (-1.0, c), (-half, u), (-half, w)]);
        s.minimize.push(format!(
            "{half}*({tc}*sqrt(1 + {tu}^2) + {td}*sqrt(1 + {tw}^2))"
        ));
        let length = s.variable(-INF, INF, 4.0 * (k as f64 + 1.0) * h);
        let text = before.map_or_else(|| String::from("0"), x);
        let row = s.equality(format!(
            "{} - {text} - {half}*(sqrt(1 + {tu}^2) + sqrt(1 + {tw}^2))",
            x(length)
        ));
        s.linear(row, &[(1.0, length)]);
        if let Some(before) = before {
            s.linear(row, &[(-1.0, before)]);
        }
        before = Some(length);
        for (energy, lengths) in &mut targets[k..=k + 1] {
            energy.push((Target::Objective, half));
            lengths.push((row, -half));
        }
    }
    for (k, (energy, lengths)) in targets.iter().enumerate() {
        s.builder
            .element(ArcLength, [height[k], slope[k]], [energy, lengths]);
    }
    let end = before.expect("at least one node");
    let row = s.row(4.0, 4.0, x(end));
    s.linear(row, &[(1.0, end)]);
    s.finish()
}

/// `exp(y)`, and `(y - target)^2`.
struct State {
    target: f64,
}

impl Element<1, 2> for State {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [y]: &[D; 1]) -> [D; 2] {
        [y.exp(), (*y - self.target).powi(2)]
    }
}

/// `(u - target)^2`.
struct Deviation {
    target: f64,
}

impl Element<1, 1> for Deviation {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [u]: &[D; 1]) -> [D; 1] {
        [(*u - self.target).powi(2)]
    }
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
            let mut terms = vec![(4.0, y[k]), (-h * h, u[k])];
            let mut neighbour = |inside: bool, k: usize| {
                if inside {
                    text += &format!(" - {}", x(y[k]));
                    terms.push((-1.0, y[k]));
                }
            };
            neighbour(j + 1 < side, k + 1);
            neighbour(i + 1 < side, k + side);
            neighbour(j > 0, k.wrapping_sub(1));
            neighbour(i > 0, k.wrapping_sub(side));
            let row = s.equality(format!(
                "{text} - {}*(exp({}) + {})",
                h * h,
                x(y[k]),
                x(u[k])
            ));
            s.linear(row, &terms);
            let weight = 0.5 * h * h;
            s.minimize.push(format!(
                "{weight}*(({} - {target})^2 + 0.001*({} - {forcing})^2)",
                x(y[k]),
                x(u[k])
            ));
            s.builder.element(
                State { target },
                [y[k]],
                [&[(row, -h * h)], &[(Target::Objective, weight)]],
            );
            let deviation = Deviation { target: forcing };
            s.add(Target::Objective, 0.001 * weight, deviation, [u[k]]);
        }
    }
    s.finish()
}

/// A grid point of the surface: unknown, or given on the edge.
#[derive(Clone, Copy)]
enum Height {
    Unknown(usize),
    Given(f64),
}

/// Area over a triangle pair whose corners (centre, right, up) are among the `N` unknowns or given.
struct Area<const N: usize> {
    h: f64,
    /// Place among the unknowns, or value.
    corners: [Height; 3],
}

impl<const N: usize> Element<N, 1> for Area<N> {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, x: &[D; N]) -> [D; 1] {
        let [centre, right, up] = self.corners.map(|corner| match corner {
            Height::Unknown(place) => x[place],
            Height::Given(value) => D::from(value),
        });
        let (p, q) = ((right - centre) / self.h, (up - centre) / self.h);
        [(p * p + q * q + 1.0).sqrt() * (self.h * self.h)]
    }
}

/// Minimal surface over an obstacle, bounds only (COPS 3.0, problem 17).
pub(super) fn obstacle_surface(side: usize) -> Stated {
    let mut s = Statement::new("obstacle_surface");
    let h = 1.0 / (side + 1) as f64;
    let mut heights = vec![vec![Height::Given(0.0); side + 2]; side + 2];
    for (i, line) in heights.iter_mut().enumerate().take(side + 1).skip(1) {
        for (j, height) in line.iter_mut().enumerate() {
            let (a, b) = (i as f64 * h, j as f64 * h);
            let edge = 1.0 - (2.0 * a - 1.0).powi(2);
            *height = if j == 0 || j == side + 1 {
                Height::Given(edge)
            } else {
                let middle = (a - 0.5).abs() < 0.25 && (b - 0.5).abs() < 0.25;
                let lower = if middle { 1.0 } else { 0.0 };
                Height::Unknown(s.variable(lower, INF, edge.max(lower)))
            };
        }
    }
    let text = |height: Height| match height {
        Height::Unknown(variable) => x(variable),
        Height::Given(value) => value.to_string(),
    };
    for i in 0..=side {
        for j in 0..=side {
            let corners = [heights[i][j], heights[i + 1][j], heights[i][j + 1]];
            let [c, r, u] = corners.map(text);
            s.minimize.push(format!(
                "{}*sqrt(1 + (({r} - {c})/{h})^2 + (({u} - {c})/{h})^2)",
                h * h
            ));
            let mut unknowns = Vec::new();
            let corners = corners.map(|corner| match corner {
                Height::Unknown(variable) => {
                    unknowns.push(variable);
                    Height::Unknown(unknowns.len() - 1)
                }
                given => given,
            });
            let objective = Target::Objective;
            match unknowns[..] {
                [] => {
                    let [area] = Area::<0> { h, corners }.evaluate(&[]);
                    s.builder.constant(objective, area);
                }
                [a] => s.add(objective, 1.0, Area { h, corners }, [a]),
                [a, b] => s.add(objective, 1.0, Area { h, corners }, [a, b]),
                [a, b, c] => s.add(objective, 1.0, Area { h, corners }, [a, b, c]),
                _ => unreachable!("three corners"),
            }
        }
    }
    s.finish()
}
