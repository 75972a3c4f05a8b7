//! Optimal control by the trapezoidal rule: one element a node, whose values feed the rows of both intervals beside it.

use std::f64::consts::PI;

use hangtime_solver::nlp::{DualNum, Element, Target};

use super::{INF, Stated, Statement, x};

/// The end of the horizon: given, or unknown with bounds and start.
enum Horizon {
    Given(f64),
    Unknown(f64, f64, f64),
}

/// Bounds and start of a state at a node.
type State = ((f64, f64), f64);

/// Text of a cost, of states and control.
type Cost = dyn Fn(&[String], &str) -> String;

/// What the unknowns of a control problem are.
struct Grid<'g> {
    name: &'g str,
    intervals: usize,
    horizon: Horizon,
    /// Bounds and start of the states at node `k`.
    states: &'g dyn Fn(usize) -> Vec<State>,
    control: (f64, f64),
    /// Right-hand sides and cost of the time integral as text, of states and control.
    rates: &'g dyn Fn(&[String], &str) -> Vec<String>,
    cost: Option<&'g Cost>,
}

/// A node and what its functions are added to.
struct Node {
    states: Vec<usize>,
    control: usize,
    /// Targets of each right-hand side; a given horizon is in the coefficients.
    rates: Vec<Vec<(Target, f64)>>,
    /// Weight of the cost, likewise.
    cost: (Target, f64),
}

/// States at both ends fixed where a value is given, the start linear in between.
fn ends(
    intervals: usize,
    first: &[f64],
    last: &[Option<f64>],
    guess: &dyn Fn(f64) -> Vec<f64>,
) -> impl Fn(usize) -> Vec<State> {
    move |k| {
        let start = guess(k as f64 / intervals as f64);
        let bound = |i: usize| match (k, last[i]) {
            (0, _) => (first[i], first[i]),
            (k, Some(value)) if k == intervals => (value, value),
            _ => (-INF, INF),
        };
        (0..first.len()).map(|i| (bound(i), start[i])).collect()
    }
}

/// Unknowns, rows and texts; the elements remain to be added, node by node. With an unknown horizon its variable comes
/// first.
fn discretize(grid: &Grid<'_>) -> (Statement, Option<usize>, Vec<Node>) {
    let mut s = Statement::new(grid.name);
    let (horizon, time, factor) = match grid.horizon {
        Horizon::Given(value) => (None, value.to_string(), value),
        Horizon::Unknown(lower, upper, start) => {
            let variable = s.variable(lower, upper, start);
            (Some(variable), x(variable), 1.0)
        }
    };
    let length = grid.intervals as f64;
    let mut nodes: Vec<Node> = Vec::new();
    let mut previous: Vec<String> = Vec::new();
    for k in 0..=grid.intervals {
        let states: Vec<usize> = (grid.states)(k)
            .into_iter()
            .map(|((lower, upper), start)| s.variable(lower, upper, start))
            .collect();
        let control = s.variable(grid.control.0, grid.control.1, 0.0);
        let names: Vec<String> = states.iter().map(|&i| x(i)).collect();
        let rates = (grid.rates)(&names, &x(control));
        let weight = if k == 0 || k == grid.intervals {
            0.5
        } else {
            1.0
        } / length;
        if let Some(cost) = grid.cost {
            s.minimize
                .push(format!("{time}*{weight}*({})", cost(&names, &x(control))));
        }
        let mut node = Node {
            rates: vec![Vec::new(); states.len()],
            cost: (Target::Objective, weight * factor),
            states,
            control,
        };
        if let Some(old) = nodes.last_mut() {
            let half = 0.5 / length;
            for i in 0..node.states.len() {
                let (new_state, old_state) = (node.states[i], old.states[i]);
                let row = s.equality(format!(
                    "{} - {} - {time}*{half}*({} + {})",
                    x(new_state),
                    x(old_state),
                    rates[i],
                    previous[i]
                ));
                s.linear(row, &[(1.0, new_state), (-1.0, old_state)]);
                node.rates[i].push((row, -half * factor));
                old.rates[i].push((row, -half * factor));
            }
        }
        previous = rates;
        nodes.push(node);
    }
    (s, horizon, nodes)
}

/// Adds `coefficient x_variable` to a right-hand side.
fn linear_rate(s: &mut Statement, rate: &[(Target, f64)], coefficient: f64, variable: usize) {
    for &(row, factor) in rate {
        s.linear(row, &[(factor * coefficient, variable)]);
    }
}

/// `(1 - b^2) a` and `a^2 + b^2 + u^2`.
struct VanDerPol;

impl Element<3, 2> for VanDerPol {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [a, b, u]: &[D; 3]) -> [D; 2] {
        let square = *b * *b;
        [*a - square * *a, *a * *a + square + *u * *u]
    }
}

pub(crate) fn van_der_pol(name: &str, intervals: usize) -> Stated {
    let (mut s, _, nodes) = discretize(&Grid {
        name,
        intervals,
        horizon: Horizon::Given(10.0),
        states: &ends(intervals, &[0.0, 1.0], &[None, None], &|_| vec![0.0, 0.0]),
        control: (-0.75, 1.0),
        rates: &|x, u| {
            vec![
                format!("((1 - {1}^2)*{0} - {1} + {u})", x[0], x[1]),
                x[0].clone(),
            ]
        },
        cost: Some(&|x, u| format!("{}^2 + {}^2 + {u}^2", x[0], x[1])),
    });
    for node in &nodes {
        let [a, b] = node.states[..] else { continue };
        s.builder.element(
            VanDerPol,
            [a, b, node.control],
            [&node.rates[0], &[node.cost]],
        );
        linear_rate(&mut s, &node.rates[0], -1.0, b);
        linear_rate(&mut s, &node.rates[0], 1.0, node.control);
        linear_rate(&mut s, &node.rates[1], 1.0, a);
    }
    s.finish()
}

/// Slides of a bead: `T v sin(u + 0.7)`, `T v cos(u + 0.7)`, `T 9.81 cos(u + 0.7)`.
struct Bead;

impl Element<3, 3> for Bead {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [t, v, u]: &[D; 3]) -> [D; 3] {
        let (sine, cosine) = (*u + 0.7).sin_cos();
        let fall = *t * cosine;
        [*t * *v * sine, fall * *v, fall * 9.81]
    }
}

/// Minimizes the final time.
fn minimize_time(s: &mut Statement, horizon: Option<usize>) -> usize {
    let time = horizon.expect("a free horizon");
    s.minimize.push(x(time));
    s.linear(Target::Objective, &[(1.0, time)]);
    time
}

pub(super) fn brachistochrone(intervals: usize) -> Stated {
    let guess = |s: f64| vec![2.0 * s, 2.0 * s, 5.0 * s];
    let last = [Some(2.0), Some(2.0), None];
    let (mut s, horizon, nodes) = discretize(&Grid {
        name: "brachistochrone",
        intervals,
        horizon: Horizon::Unknown(0.1, 20.0, 2.0),
        states: &ends(intervals, &[0.0; 3], &last, &guess),
        control: (-3.0, 3.0),
        rates: &|x, u| {
            vec![
                format!("{}*sin({u} + 0.7)", x[2]),
                format!("{}*cos({u} + 0.7)", x[2]),
                format!("9.81*cos({u} + 0.7)"),
            ]
        },
        cost: None,
    });
    let time = minimize_time(&mut s, horizon);
    for node in &nodes {
        let [a, b, c] = &node.rates[..] else { continue };
        s.builder
            .element(Bead, [time, node.states[2], node.control], [a, b, c]);
    }
    s.finish()
}

/// `T v` and `T u`.
struct Integrator;

impl Element<3, 2> for Integrator {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [t, v, u]: &[D; 3]) -> [D; 2] {
        [*t * *v, *t * *u]
    }
}

pub(super) fn double_integrator(intervals: usize) -> Stated {
    let (mut s, horizon, nodes) = discretize(&Grid {
        name: "double_integrator",
        intervals,
        horizon: Horizon::Unknown(0.1, 20.0, 2.0),
        states: &ends(intervals, &[0.0, 0.0], &[Some(1.0), Some(0.0)], &|s| {
            vec![s, 0.5]
        }),
        control: (-1.0, 1.0),
        rates: &|x, u| vec![x[1].clone(), u.to_owned()],
        cost: None,
    });
    let time = minimize_time(&mut s, horizon);
    for node in &nodes {
        let [a, b] = &node.rates[..] else { continue };
        s.builder
            .element(Integrator, [time, node.states[1], node.control], [a, b]);
    }
    s.finish()
}

/// Accelerations of cart and pole of (angle, rate, force), and the squared force.
struct CartPole;

impl Element<3, 3> for CartPole {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [q, w, u]: &[D; 3]) -> [D; 3] {
        let (sine, cosine) = q.sin_cos();
        let fling = sine * *w * *w * 0.15;
        let mass = sine * sine * 0.3 + 1.0;
        [
            (fling + *u + cosine * sine * (0.3 * 9.81)) / mass,
            -(cosine * (fling + *u) + sine * (1.3 * 9.81)) / (mass * 0.5),
            *u * *u,
        ]
    }
}

pub(super) fn cart_pole(name: &str, intervals: usize) -> Stated {
    let last = [Some(1.0), Some(PI), Some(0.0), Some(0.0)];
    let (mut s, _, nodes) = discretize(&Grid {
        name,
        intervals,
        horizon: Horizon::Given(2.0),
        states: &ends(intervals, &[0.0; 4], &last, &|s| vec![s, PI * s, 0.0, 0.0]),
        control: (-20.0, 20.0),
        rates: &|x, u| {
            let (c, s) = (format!("cos({})", x[1]), format!("sin({})", x[1]));
            let w = &x[3];
            vec![
                x[2].clone(),
                x[3].clone(),
                format!("(0.15*{s}*{w}^2 + {u} + 0.3*9.81*{c}*{s})/(1 + 0.3*{s}^2)"),
                format!("-(0.15*{c}*{s}*{w}^2 + {u}*{c} + 1.3*9.81*{s})/(0.5*(1 + 0.3*{s}^2))"),
            ]
        },
        cost: Some(&|_, u| format!("{u}^2")),
    });
    for node in &nodes {
        let [_, q, v, w] = node.states[..] else {
            continue;
        };
        s.builder.element(
            CartPole,
            [q, w, node.control],
            [&node.rates[2], &node.rates[3], &[node.cost]],
        );
        linear_rate(&mut s, &node.rates[0], 1.0, v);
        linear_rate(&mut s, &node.rates[1], 1.0, w);
    }
    s.finish()
}

/// `T w`, `T (u - 9.81 sin q)` and `T u^2 / 100` of (T, q, w, u).
struct Pendulum;

impl Element<4, 3> for Pendulum {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [t, q, w, u]: &[D; 4]) -> [D; 3] {
        [*t * *w, *t * (*u - q.sin() * 9.81), *t * *u * *u * 0.01]
    }
}

pub(super) fn pendulum(intervals: usize) -> Stated {
    let (mut s, horizon, nodes) = discretize(&Grid {
        name: "pendulum_swing_up",
        intervals,
        horizon: Horizon::Unknown(0.1, 20.0, 2.0),
        states: &ends(intervals, &[0.0, 0.0], &[Some(PI), Some(0.0)], &|s| {
            vec![PI * s, 0.5]
        }),
        control: (-3.0, 3.0),
        rates: &|x, u| vec![x[1].clone(), format!("({u} - 9.81*sin({}))", x[0])],
        cost: Some(&|_, u| format!("0.01*{u}^2")),
    });
    let time = minimize_time(&mut s, horizon);
    for node in &nodes {
        let [a, b] = &node.rates[..] else { continue };
        let variables = [time, node.states[0], node.states[1], node.control];
        s.builder.element(Pendulum, variables, [a, b, &[node.cost]]);
    }
    s.finish()
}

/// Rates of two concentrations, and the squared distance of the control from one half.
struct Catalyst;

impl Element<3, 3> for Catalyst {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [a, b, u]: &[D; 3]) -> [D; 3] {
        let exchange = *u * (*b * 10.0 - *a);
        [
            exchange,
            (*u - 1.0) * *b - exchange,
            (*u - 0.5).powi(2) * 0.0001,
        ]
    }
}

/// Mixing of two catalysts in a tubular reactor (COPS 3.0, problem 14).
pub(super) fn catalyst_mixing(intervals: usize) -> Stated {
    let (mut s, _, nodes) = discretize(&Grid {
        name: "catalyst_mixing",
        intervals,
        horizon: Horizon::Given(1.0),
        states: &ends(intervals, &[1.0, 0.0], &[None, None], &|_| vec![1.0, 0.0]),
        control: (0.0, 1.0),
        rates: &|x, u| {
            vec![
                format!("{u}*(10*{1} - {0})", x[0], x[1]),
                format!("({u}*({0} - 10*{1}) - (1 - {u})*{1})", x[0], x[1]),
            ]
        },
        cost: Some(&|_, u| format!("0.0001*({u} - 0.5)^2")),
    });
    for node in &nodes {
        let ([a, b], [fa, fb]) = (&node.states[..], &node.rates[..]) else {
            continue;
        };
        s.builder
            .element(Catalyst, [*a, *b, node.control], [fa, fb, &[node.cost]]);
    }
    if let Some([a, b]) = nodes.last().map(|node| &node.states[..]) {
        s.minimize.push(format!("{} + {} - 1", x(*a), x(*b)));
        s.linear(Target::Objective, &[(1.0, *a), (1.0, *b)]);
        s.builder.constant(Target::Objective, -1.0);
    }
    s.finish()
}

/// Rates of altitude, speed and mass, times the horizon, of (T, altitude, speed, mass, thrust).
struct Rocket;

impl Element<5, 3> for Rocket {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, [t, h, v, m, u]: &[D; 5]) -> [D; 3] {
        let drag = *v * *v * ((*h - 1.0) * -500.0).exp() * 310.0;
        [
            *t * *v,
            *t * ((*u - drag) / *m - h.powi(-2)),
            *t * *u * -2.0,
        ]
    }
}

/// Goddard rocket with free final time, unknowns altitude, speed, mass, thrust (COPS 3.0, problem 10).
pub(super) fn goddard(intervals: usize) -> Stated {
    let states = |k: usize| {
        let at = k as f64 / intervals as f64;
        let bounds = match k {
            0 => [(1.0, 1.0), (0.0, 0.0), (1.0, 1.0)],
            k if k == intervals => [(1.0, INF), (0.0, INF), (0.6, 0.6)],
            _ => [(1.0, INF), (0.0, INF), (0.6, 1.0)],
        };
        let start = [1.0, at * (1.0 - at), 1.0 - 0.4 * at];
        bounds.into_iter().zip(start).collect()
    };
    let (mut s, horizon, nodes) = discretize(&Grid {
        name: "goddard_rocket",
        intervals,
        horizon: Horizon::Unknown(0.01, 1.0, 0.2),
        states: &states,
        control: (0.0, 3.5),
        rates: &|x, u| {
            let drag = format!("310*{}^2*exp(-500*({} - 1))", x[1], x[0]);
            vec![
                x[1].clone(),
                format!("(({u} - {drag})/{} - 1/{}^2)", x[2], x[0]),
                format!("(-2*{u})"),
            ]
        },
        cost: None,
    });
    let time = horizon.expect("a free horizon");
    for node in &nodes {
        let ([h, v, m], [a, b, c]) = (&node.states[..], &node.rates[..]) else {
            continue;
        };
        s.builder
            .element(Rocket, [time, *h, *v, *m, node.control], [a, b, c]);
    }
    if let Some(node) = nodes.last() {
        s.minimize.push(format!("-{}", x(node.states[0])));
        s.linear(Target::Objective, &[(-1.0, node.states[0])]);
    }
    s.finish()
}
