//! Quadratic programs, flows in networks, and the polygon with its dense rows.

use std::f64::consts::PI;

use hangtime_solver::nlp::{DualNum, Element, Target};

use super::{INF, Stated, Statement, random, x};

/// `weight (x - target)^2`.
struct Square {
    weight: f64,
    target: f64,
}

impl Element<1, 1> for Square {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x]: &[D; 1]) -> [D; 1] {
        [(*x - self.target).powi(2) * self.weight]
    }
}

/// `(x - y)^2 / 2`.
struct HalfDifference;

impl Element<2, 1> for HalfDifference {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x, y]: &[D; 2]) -> [D; 1] {
        [(*x - *y).powi(2) * 0.5]
    }
}

/// Convex quadratic program with random sparse rows, from a fixed generator.
pub(super) fn random_quadratic(n: usize, m: usize) -> Stated {
    let mut s = Statement::new("random_quadratic");
    let mut random = random(12345);
    for _ in 0..n {
        s.variable(0.0, 1.0, 0.5);
    }
    for i in 0..n {
        let (target, j) = (3.0 * random() - 1.0, (random() * n as f64) as usize);
        s.minimize.push(format!(
            "({0} - {target})^2 + 0.5*({0} - {1})^2",
            x(i),
            x(j)
        ));
        let weight = 1.0;
        s.add(Target::Objective, 1.0, Square { weight, target }, [i]);
        s.add(Target::Objective, 1.0, HalfDifference, [i, j]);
    }
    for k in 0..m {
        let base = k * (n - 8) / m;
        let mut text = String::from("-2");
        let mut terms = Vec::new();
        for _ in 0..4 {
            let j = base + (random() * 7.0) as usize;
            // six digits, as in the text
            let coefficient = ((0.5 + random()) * 1e6).round() / 1e6;
            text += &format!(" + {coefficient}*{}", x(j));
            terms.push((coefficient, j));
        }
        let row = s.row(-INF, 0.0, text);
        s.builder.constant(row, -2.0);
        s.linear(row, &terms);
    }
    s.finish()
}

/// `weight exp(x) + x^2`.
struct Flow {
    weight: f64,
}

impl Element<1, 1> for Flow {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [x]: &[D; 1]) -> [D; 1] {
        [x.exp() * self.weight + *x * *x]
    }
}

/// Optimal power-like network of quadratic flows: conservation at nodes of a ring with chords.
pub(super) fn network_flow(nodes: usize) -> Stated {
    let mut s = Statement::new("network_flow");
    let mut balance = vec![(String::from("0"), Vec::new()); nodes];
    for k in 0..nodes {
        for offset in [1, 7] {
            let target = (k + offset) % nodes;
            let weight = 0.1 * (1 + k % 3) as f64;
            let flow = s.variable(-2.0, 2.0, 0.1);
            let text = format!("{weight}*exp({0}) + {0}^2", x(flow));
            s.minimize(text, Flow { weight }, [flow]);
            balance[k].0 += &format!(" + {}", x(flow));
            balance[k].1.push((1.0, flow));
            balance[target].0 += &format!(" - {}", x(flow));
            balance[target].1.push((-1.0, flow));
        }
        let supply = s.variable(0.0, 3.0, 1.0);
        let weight = 1.0 + (k % 5) as f64;
        let text = format!("{weight}*{}^2", x(supply));
        let target = 0.0;
        s.minimize(text, Square { weight, target }, [supply]);
        balance[k].0 += &format!(" - {}", x(supply));
        balance[k].1.push((-1.0, supply));
    }
    for (k, (text, terms)) in balance.into_iter().enumerate() {
        let demand = 0.2 + 0.6 * (k % 2) as f64;
        let row = s.equality(format!("{text} + {demand}"));
        s.builder.constant(row, demand);
        s.linear(row, &terms);
    }
    s.finish()
}

/// `-r q sin(a - b) / 2` of (r, q, a, b).
struct Triangle;

impl Element<4, 1> for Triangle {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [r, q, a, b]: &[D; 4]) -> [D; 1] {
        [*r * *q * (*a - *b).sin() * -0.5]
    }
}

/// Squared distance of two points in polar coordinates.
struct Distance;

impl Element<4, 1> for Distance {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [r, q, a, b]: &[D; 4]) -> [D; 1] {
        [*r * *r + *q * *q - *r * *q * (*a - *b).cos() * 2.0]
    }
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
        let v = [r[k + 1], r[k], angle[k + 1], angle[k]];
        let [a, b, c, d] = v.map(x);
        s.minimize(format!("-0.5*{a}*{b}*sin({c} - {d})"), Triangle, v);
        let row = s.row(0.0, INF, format!("{c} - {d}"));
        s.linear(row, &[(1.0, angle[k + 1]), (-1.0, angle[k])]);
        for j in k + 1..vertices - 1 {
            let v = [r[k], r[j], angle[k], angle[j]];
            let [a, b, c, d] = v.map(x);
            let text = format!("{a}^2 + {b}^2 - 2*{a}*{b}*cos({c} - {d})");
            let row = s.row(-INF, 1.0, text);
            s.add(row, 1.0, Distance, v);
        }
    }
    s.finish()
}
