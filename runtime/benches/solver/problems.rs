//! Scalable nonlinear programs, written as text so that another solver can read the very same ones.

use std::f64::consts::PI;
use std::fmt::Write;

/// A problem under construction.
struct Text {
    name: String,
    start: Vec<f64>,
    bounds: Vec<(f64, f64)>,
    objective: Vec<String>,
    rows: Vec<(f64, f64, String)>,
}

impl Text {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            start: Vec::new(),
            bounds: Vec::new(),
            objective: Vec::new(),
            rows: Vec::new(),
        }
    }

    /// New variable; returns its name.
    fn variable(&mut self, lower: f64, upper: f64, start: f64) -> String {
        self.start.push(start);
        self.bounds.push((lower, upper));
        format!("x{}", self.start.len())
    }

    fn variables(&mut self, count: usize, lower: f64, upper: f64, start: f64) -> Vec<String> {
        (0..count)
            .map(|_| self.variable(lower, upper, start))
            .collect()
    }

    fn row(&mut self, lower: f64, upper: f64, expression: String) {
        self.rows.push((lower, upper, expression));
    }

    fn equality(&mut self, expression: String) {
        self.row(0.0, 0.0, expression);
    }

    fn finish(self) -> (String, String) {
        let mut text = String::new();
        let join = |numbers: &[f64]| {
            numbers
                .iter()
                .map(f64::to_string)
                .collect::<Vec<_>>()
                .join(" ")
        };
        let _ = writeln!(text, "problem {} {}", self.name, self.start.len());
        let _ = writeln!(text, "start {}", join(&self.start));
        for (k, (lower, upper)) in self.bounds.iter().enumerate() {
            if lower.is_finite() || upper.is_finite() {
                let _ = writeln!(text, "bounds {} {lower} {upper}", k + 1);
            }
        }
        for term in &self.objective {
            let _ = writeln!(text, "minimize {term}");
        }
        for (lower, upper, expression) in &self.rows {
            let _ = writeln!(text, "row {lower} {upper} {expression}");
        }
        (self.name, text)
    }
}

const INF: f64 = f64::INFINITY;

/// Chained Rosenbrock function with trigonometric-exponential constraints (Luksan and Vlcek 1999, 5.1).
fn luksan_vlcek_1(n: usize, inequality: bool) -> (String, String) {
    let mut t = Text::new(&format!("lukvl{}1", if inequality { "i" } else { "e" }));
    for i in 0..n {
        t.variable(-INF, INF, if i % 2 == 0 { -1.2 } else { 1.0 });
    }
    for i in 1..n {
        t.objective
            .push(format!("100*(x{i}^2 - x{})^2 + (x{i} - 1)^2", i + 1));
    }
    for k in 1..=n - 2 {
        let (a, b, c) = (k, k + 1, k + 2);
        t.row(
            if inequality { -1.0 } else { 0.0 },
            0.0,
            format!(
                "3*x{b}^3 + 2*x{c} - 5 + sin(x{b} - x{c})*sin(x{b} + x{c}) + 4*x{b} - x{a}*exp(x{a} - x{b}) - 3"
            ),
        );
    }
    t.finish()
}

/// Chained Wood function with Broyden banded constraints (Luksan and Vlcek 1999, 5.2, first form).
fn luksan_vlcek_2(n: usize) -> (String, String) {
    let mut t = Text::new("lukvle2");
    for i in 0..n {
        let odd = if i % 2 == 0 { -2.0 } else { 1.0 };
        t.variable(-INF, INF, odd);
    }
    for i in 1..=n / 2 - 1 {
        let (a, b, c, d) = (2 * i - 1, 2 * i, 2 * i + 1, 2 * i + 2);
        t.objective.push(format!(
            "100*(x{a}^2 - x{b})^2 + (x{a} - 1)^2 + 90*(x{c}^2 - x{d})^2 + (x{c} - 1)^2 + 10*(x{b} + x{d} - 2)^2 + 0.1*(x{b} - x{d})^2"
        ));
    }
    for k in 6..=n - 2 {
        let mut expression = format!("(2 + 5*x{k}^2)*x{k} + 1");
        for i in (k - 5)..=(k + 1) {
            let _ = write!(expression, " + x{i}*(1 + x{i})");
        }
        t.equality(expression);
    }
    t.finish()
}

/// Chained Cragg-Levy function with tridiagonal constraints (Luksan and Vlcek 1999, 5.4).
fn luksan_vlcek_4(n: usize) -> (String, String) {
    let mut t = Text::new("lukvle4");
    for i in 0..n {
        let odd = if i % 4 == 0 { 1.0 } else { 2.0 };
        t.variable(-INF, INF, odd);
    }
    for i in 1..=n / 2 - 1 {
        let (a, b, c, d) = (2 * i - 1, 2 * i, 2 * i + 1, 2 * i + 2);
        t.objective.push(format!(
            "(exp(x{a}) - x{b})^4 + 100*(x{b} - x{c})^6 + (sin(x{c} - x{d})/cos(x{c} - x{d}))^4 + x{a}^8 + (x{d} - 1)^2"
        ));
    }
    for k in 1..=n - 2 {
        let (a, b, c) = (k, k + 1, k + 2);
        t.equality(format!(
            "8*x{b}*(x{b}^2 - x{a}) - 2*(1 - x{b}) + 4*(x{b} - x{c}^2)"
        ));
    }
    t.finish()
}

/// Chained HS46 with constraints of HS46 (Luksan and Vlcek 1999, 5.7).
fn luksan_vlcek_7(n: usize) -> (String, String) {
    let mut t = Text::new("lukvle7");
    for i in 0..n {
        t.variable(-INF, INF, [2.0, 1.5, 0.5][i % 3]);
    }
    for i in 1..=(n - 2) / 3 {
        let j = 3 * (i - 1);
        let (a, b, c, d, e) = (j + 1, j + 2, j + 3, j + 4, j + 5);
        t.objective.push(format!(
            "(x{a} - x{b})^2 + (x{c} - 1)^2 + (x{d} - 1)^4 + (x{e} - 1)^6"
        ));
        t.equality(format!("x{a}^2*x{d} + sin(x{d} - x{e}) - 1"));
        t.equality(format!("x{b} + x{c}^4*x{d}^2 - 2"));
    }
    t.finish()
}

/// Optimal control by the trapezoidal rule: states, one control, dynamics as text of (state, control).
#[expect(clippy::too_many_arguments, reason = "the parts of one definition")]
fn control(
    name: &str,
    intervals: usize,
    horizon: Option<f64>,
    first: &[f64],
    last: &[Option<f64>],
    guess: &dyn Fn(f64) -> Vec<f64>,
    control_bounds: (f64, f64),
    dynamics: &dyn Fn(&[String], &str) -> Vec<String>,
    cost: &dyn Fn(&[String], &str) -> Option<String>,
) -> (String, String) {
    let mut t = Text::new(name);
    let states = first.len();
    let time = match horizon {
        Some(horizon) => horizon.to_string(),
        None => {
            let time = t.variable(0.1, 20.0, 2.0);
            t.objective.push(time.clone());
            time
        }
    };
    let mut previous: Option<(Vec<String>, String)> = None;
    for k in 0..=intervals {
        let at = k as f64 / intervals as f64;
        let start = guess(at);
        let mut x = Vec::new();
        for i in 0..states {
            let (lower, upper) = if k == 0 {
                (first[i], first[i])
            } else if k == intervals {
                last[i].map_or((-INF, INF), |v| (v, v))
            } else {
                (-INF, INF)
            };
            x.push(t.variable(lower, upper, start[i]));
        }
        let u = t.variable(control_bounds.0, control_bounds.1, 0.0);
        if let Some(cost) = cost(&x, &u) {
            let weight = if k == 0 || k == intervals { 0.5 } else { 1.0 };
            t.objective
                .push(format!("{time}*{}*({cost})", weight / intervals as f64));
        }
        if let Some((x_old, u_old)) = previous {
            let (f, f_old) = (dynamics(&x, &u), dynamics(&x_old, &u_old));
            for i in 0..states {
                t.equality(format!(
                    "{} - {} - {time}*{}*({} + {})",
                    x[i],
                    x_old[i],
                    0.5 / intervals as f64,
                    f[i],
                    f_old[i]
                ));
            }
        }
        previous = Some((x, u));
    }
    t.finish()
}

fn van_der_pol(intervals: usize) -> (String, String) {
    control(
        "van_der_pol",
        intervals,
        Some(10.0),
        &[0.0, 1.0],
        &[None, None],
        &|_| vec![0.0, 0.0],
        (-0.75, 1.0),
        &|x, u| {
            vec![
                format!("((1 - {1}^2)*{0} - {1} + {u})", x[0], x[1]),
                x[0].clone(),
            ]
        },
        &|x, u| Some(format!("{}^2 + {}^2 + {u}^2", x[0], x[1])),
    )
}

fn brachistochrone(intervals: usize) -> (String, String) {
    control(
        "brachistochrone",
        intervals,
        None,
        &[0.0, 0.0, 0.0],
        &[Some(2.0), Some(2.0), None],
        &|s| vec![2.0 * s, 2.0 * s, 5.0 * s],
        (-3.0, 3.0),
        &|x, u| {
            vec![
                format!("{}*sin({u} + 0.7)", x[2]),
                format!("{}*cos({u} + 0.7)", x[2]),
                format!("9.81*cos({u} + 0.7)"),
            ]
        },
        &|_, _| None,
    )
}

fn double_integrator(intervals: usize) -> (String, String) {
    control(
        "double_integrator",
        intervals,
        None,
        &[0.0, 0.0],
        &[Some(1.0), Some(0.0)],
        &|s| vec![s, 0.5],
        (-1.0, 1.0),
        &|x, u| vec![x[1].clone(), u.to_owned()],
        &|_, _| None,
    )
}

fn cart_pole(intervals: usize) -> (String, String) {
    control(
        "cart_pole",
        intervals,
        Some(2.0),
        &[0.0, 0.0, 0.0, 0.0],
        &[Some(1.0), Some(PI), Some(0.0), Some(0.0)],
        &|s| vec![s, PI * s, 0.0, 0.0],
        (-20.0, 20.0),
        &|x, u| {
            let (c, s) = (format!("cos({})", x[1]), format!("sin({})", x[1]));
            let w = &x[3];
            vec![
                x[2].clone(),
                x[3].clone(),
                format!("(0.15*{s}*{w}^2 + {u} + 0.3*9.81*{c}*{s})/(1 + 0.3*{s}^2)"),
                format!("-(0.15*{c}*{s}*{w}^2 + {u}*{c} + 1.3*9.81*{s})/(0.5*(1 + 0.3*{s}^2))"),
            ]
        },
        &|_, u| Some(format!("{u}^2")),
    )
}

fn pendulum(intervals: usize) -> (String, String) {
    control(
        "pendulum_swing_up",
        intervals,
        None,
        &[0.0, 0.0],
        &[Some(PI), Some(0.0)],
        &|s| vec![PI * s, 0.5],
        (-3.0, 3.0),
        &|x, u| vec![x[1].clone(), format!("{u} - 9.81*sin({})", x[0])],
        &|_, u| Some(format!("0.01*{u}^2")),
    )
}

/// Mixing of two catalysts in a tubular reactor (COPS 3.0, problem 14).
fn catalyst_mixing(intervals: usize) -> (String, String) {
    let (name, mut text) = control(
        "catalyst_mixing",
        intervals,
        Some(1.0),
        &[1.0, 0.0],
        &[None, None],
        &|_| vec![1.0, 0.0],
        (0.0, 1.0),
        &|x, u| {
            vec![
                format!("{u}*(10*{1} - {0})", x[0], x[1]),
                format!("({u}*({0} - 10*{1}) - (1 - {u})*{1})", x[0], x[1]),
            ]
        },
        &|_, u| Some(format!("0.0001*({u} - 0.5)^2")),
    );
    let last = 3 * (intervals + 1) - 2;
    text = text.replacen(
        "minimize ",
        &format!("minimize x{last} + x{} - 1\nminimize ", last + 1),
        1,
    );
    (name, text)
}

/// Goddard rocket with free final time, unknowns altitude, speed, mass, thrust (COPS 3.0, problem 10).
fn goddard(intervals: usize) -> (String, String) {
    let (name, text) = control(
        "goddard_rocket",
        intervals,
        None,
        &[1.0, 0.0, 1.0],
        &[None, None, Some(0.6)],
        &|s| vec![1.0, s * (1.0 - s), 1.0 - 0.4 * s],
        (0.0, 3.5),
        &|x, u| {
            let drag = format!("310*{}^2*exp(-500*({} - 1))", x[1], x[0]);
            vec![
                x[1].clone(),
                format!("(({u} - {drag})/{} - 1/{}^2)", x[2], x[0]),
                format!("(-2*{u})"),
            ]
        },
        &|_, _| None,
    );
    let last = 1 + 4 * intervals + 1;
    let text = text
        .replacen("minimize x1\n", &format!("minimize -x{last}\n"), 1)
        .replacen("bounds 1 0.1 20", "bounds 1 0.01 1", 1)
        .replacen("start 2 ", "start 0.2 ", 1);
    // altitude, speed and mass in their physical ranges
    let mut bounds = String::new();
    for k in 1..=intervals {
        let first = 2 + 4 * k;
        let _ = writeln!(bounds, "bounds {first} 1 inf");
        let _ = writeln!(bounds, "bounds {} 0 inf", first + 1);
        if k < intervals {
            let _ = writeln!(bounds, "bounds {} 0.6 1", first + 2);
        }
    }
    (name, text + &bounds)
}

/// Shape of least potential energy of a chain of given length between two points (COPS 3.0, problem 3).
fn hanging_chain(nodes: usize) -> (String, String) {
    let mut t = Text::new("hanging_chain");
    let h = 1.0 / nodes as f64;
    let mut x = Vec::new();
    let mut u = Vec::new();
    for k in 0..=nodes {
        let s = k as f64 * h;
        let (l, up) = match k {
            0 => (1.0, 1.0),
            k if k == nodes => (3.0, 3.0),
            _ => (-INF, INF),
        };
        x.push(t.variable(l, up, 4.0 * 1.0 * s * (0.5 * s - 0.25) + 1.0));
        u.push(t.variable(-INF, INF, 4.0 * (s - 0.25)));
    }
    let mut length = Vec::new();
    for k in 0..nodes {
        t.equality(format!(
            "{} - {} - {}*({} + {})",
            x[k + 1],
            x[k],
            0.5 * h,
            u[k],
            u[k + 1]
        ));
        t.objective.push(format!(
            "{}*({}*sqrt(1 + {}^2) + {}*sqrt(1 + {}^2))",
            0.5 * h,
            x[k],
            u[k],
            x[k + 1],
            u[k + 1]
        ));
        // running length, so that no row is dense
        length.push(t.variable(-INF, INF, 4.0 * (k as f64 + 1.0) * h));
        let before = if k == 0 {
            String::from("0")
        } else {
            length[k - 1].clone()
        };
        t.equality(format!(
            "{} - {before} - {}*(sqrt(1 + {}^2) + sqrt(1 + {}^2))",
            length[k],
            0.5 * h,
            u[k],
            u[k + 1]
        ));
    }
    let end = length[nodes - 1].clone();
    t.row(4.0, 4.0, end);
    t.finish()
}

/// Elliptic control with bounds on state and control on a square grid (Mittelmann 2001).
fn elliptic_control(side: usize) -> (String, String) {
    let mut t = Text::new("elliptic_control");
    let h = 1.0 / (side + 1) as f64;
    let y = t.variables(side * side, -INF, 0.371, 0.0);
    let u = t.variables(side * side, -8.0, 9.0, 0.0);
    let pi = PI;
    for i in 0..side {
        for j in 0..side {
            let (a, b) = ((i + 1) as f64 * h, (j + 1) as f64 * h);
            let target = 1.0 + 2.0 * (a * (a - 1.0) + b * (b - 1.0));
            let k = i * side + j;
            let neighbour = |di: isize, dj: isize| {
                let (p, q) = (i as isize + di, j as isize + dj);
                let inside = p >= 0 && q >= 0 && p < side as isize && q < side as isize;
                inside.then(|| y[p as usize * side + q as usize].clone())
            };
            let mut laplace = format!("4*{}", y[k]);
            for (di, dj) in [(0, 1), (1, 0), (0, -1), (-1, 0)] {
                if let Some(name) = neighbour(di, dj) {
                    let _ = write!(laplace, " - {name}");
                }
            }
            t.equality(format!("{laplace} - {}*(exp({}) + {})", h * h, y[k], u[k]));
            let forcing = (pi * a).sin() * (pi * b).sin();
            t.objective.push(format!(
                "{}*(({} - {target})^2 + 0.001*({} - {forcing})^2)",
                0.5 * h * h,
                y[k],
                u[k]
            ));
        }
    }
    t.finish()
}

/// Minimal surface over an obstacle, bounds only (COPS 3.0, problem 17).
fn obstacle_surface(side: usize) -> (String, String) {
    let mut t = Text::new("obstacle_surface");
    let h = 1.0 / (side + 1) as f64;
    let mut name = vec![vec![String::from("0"); side + 2]; side + 2];
    for (i, line) in name.iter_mut().enumerate() {
        for (j, cell) in line.iter_mut().enumerate() {
            let (a, b) = (i as f64 * h, j as f64 * h);
            let edge = 1.0 - (2.0 * a - 1.0).powi(2);
            if i == 0 || i == side + 1 {
                *cell = String::from("0");
            } else if j == 0 || j == side + 1 {
                *cell = edge.to_string();
            } else {
                let middle = (a - 0.5).abs() < 0.25 && (b - 0.5).abs() < 0.25;
                let lower = if middle { 1.0 } else { 0.0 };
                *cell = t.variable(lower, INF, edge.max(lower));
            }
        }
    }
    for i in 0..=side {
        for j in 0..=side {
            let (c, r, u) = (&name[i][j], &name[i + 1][j], &name[i][j + 1]);
            t.objective.push(format!(
                "{}*sqrt(1 + (({r} - {c})/{h})^2 + (({u} - {c})/{h})^2)",
                h * h
            ));
        }
    }
    t.finish()
}

/// Convex quadratic program with random sparse rows, from a fixed generator.
fn random_quadratic(n: usize, m: usize) -> (String, String) {
    let mut t = Text::new("random_quadratic");
    let mut state = 12345_u64;
    let mut random = move || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for _ in 0..n {
        t.variable(0.0, 1.0, 0.5);
    }
    for i in 1..=n {
        let (target, j) = (3.0 * random() - 1.0, 1 + (random() * n as f64) as usize);
        t.objective
            .push(format!("(x{i} - {target})^2 + 0.5*(x{i} - x{j})^2"));
    }
    for k in 0..m {
        let base = k * (n - 8) / m;
        let mut sum = String::from("-2");
        for _ in 0..4 {
            let j = base + 1 + (random() * 7.0) as usize;
            let _ = write!(sum, " + {:.6}*x{j}", 0.5 + random());
        }
        t.row(-INF, 0.0, sum);
    }
    t.finish()
}

/// Optimal power-like network of quadratic flows: conservation at nodes of a ring with chords.
fn network_flow(nodes: usize) -> (String, String) {
    let mut t = Text::new("network_flow");
    let mut balance = vec![String::from("0"); nodes];
    for k in 0..nodes {
        for offset in [1, 7] {
            let target = (k + offset) % nodes;
            let flow = t.variable(-2.0, 2.0, 0.1);
            t.objective.push(format!(
                "{}*exp({flow}) + {flow}^2",
                0.1 * (1 + k % 3) as f64
            ));
            let _ = write!(balance[k], " + {flow}");
            let _ = write!(balance[target], " - {flow}");
        }
        let supply = t.variable(0.0, 3.0, 1.0);
        t.objective
            .push(format!("{}*{supply}^2", 1.0 + (k % 5) as f64));
        let _ = write!(balance[k], " - {supply}");
    }
    for (k, expression) in balance.into_iter().enumerate() {
        t.equality(format!("{expression} + {}", 0.2 + 0.6 * (k % 2) as f64));
    }
    t.finish()
}

/// Polygon of largest area with unit diameter (COPS 3.0, problem 1), pairs of near vertices only.
fn polygon(vertices: usize) -> (String, String) {
    let mut t = Text::new("polygon");
    let mut r = Vec::new();
    let mut angle = Vec::new();
    for k in 0..vertices {
        let last = k + 1 == vertices;
        let s = (k + 1) as f64 / vertices as f64;
        r.push(t.variable(0.0, if last { 0.0 } else { 1.0 }, 4.0 * s * (1.0 - s)));
        let pi = PI;
        angle.push(t.variable(if last { pi } else { 0.0 }, pi, pi * s));
    }
    for k in 0..vertices - 1 {
        t.objective.push(format!(
            "-0.5*{}*{}*sin({} - {})",
            r[k + 1],
            r[k],
            angle[k + 1],
            angle[k]
        ));
        t.row(0.0, INF, format!("{} - {}", angle[k + 1], angle[k]));
        for j in k + 1..vertices - 1 {
            t.row(
                -INF,
                1.0,
                format!(
                    "{0}^2 + {1}^2 - 2*{0}*{1}*cos({2} - {3})",
                    r[k], r[j], angle[k], angle[j]
                ),
            );
        }
    }
    t.finish()
}

/// An optimal control chain of about `3 intervals` unknowns.
pub(crate) fn chain(intervals: usize) -> (String, String) {
    van_der_pol(intervals)
}

/// A sparse program without the structure of time: random coupling within a band, `n` unknowns, `n/2` rows.
pub(crate) fn banded(n: usize) -> (String, String) {
    let mut t = Text::new("random_banded");
    let mut state = 99_u64;
    let mut random = move || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for _ in 0..n {
        t.variable(-1.0, 2.0, 0.5);
    }
    for i in 1..=n {
        let near = (i + 1 + (random() * 6.0) as usize).min(n);
        let target = 3.0 * random() - 1.0;
        t.objective
            .push(format!("(x{i} - {target})^4 + 0.5*(x{i} - x{near})^2"));
    }
    for row in 0..n / 2 {
        let base = (2 * row + 1).min(n - 8);
        let mut indices = || base + (random() * 8.0) as usize;
        let (a, b, c) = (indices(), indices(), indices());
        t.row(-0.5, 1.5, format!("x{a}*x{b} + sin(x{c})"));
    }
    t.finish()
}

/// All problems, each as (name, text).
pub(crate) fn problems() -> Vec<(String, String)> {
    vec![
        luksan_vlcek_1(5000, false),
        luksan_vlcek_1(5000, true),
        luksan_vlcek_2(2000),
        luksan_vlcek_4(4000),
        luksan_vlcek_7(5000),
        van_der_pol(1500),
        brachistochrone(800),
        double_integrator(1500),
        cart_pole(600),
        pendulum(800),
        catalyst_mixing(1000),
        goddard(600),
        hanging_chain(1000),
        elliptic_control(40),
        obstacle_surface(60),
        random_quadratic(6000, 3000),
        network_flow(2000),
        polygon(30),
        van_der_pol_fine(),
        cart_pole_fine(),
    ]
}

fn van_der_pol_fine() -> (String, String) {
    let (_, text) = van_der_pol(6000);
    let name = String::from("van_der_pol_fine");
    (name.clone(), text.replacen("van_der_pol", &name, 1))
}

fn cart_pole_fine() -> (String, String) {
    let (_, text) = cart_pole(2000);
    let name = String::from("cart_pole_fine");
    (name.clone(), text.replacen("cart_pole", &name, 1))
}
