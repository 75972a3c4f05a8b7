//! Optimal control by the trapezoidal rule.

use std::f64::consts::PI;

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

/// Unknowns and rows, and the states at the last node. With an unknown horizon its variable comes first.
fn discretize(grid: &Grid<'_>) -> (Statement, Vec<usize>) {
    let mut s = Statement::new(grid.name);
    let time = match grid.horizon {
        Horizon::Given(value) => value.to_string(),
        Horizon::Unknown(lower, upper, start) => x(s.variable(lower, upper, start)),
    };
    let length = grid.intervals as f64;
    let mut before: Option<(Vec<usize>, Vec<String>)> = None;
    for k in 0..=grid.intervals {
        let states = (grid.states)(k).into_iter();
        let states = states.map(|((lower, upper), start)| s.variable(lower, upper, start));
        let states: Vec<usize> = states.collect();
        let control = x(s.variable(grid.control.0, grid.control.1, 0.0));
        let names: Vec<String> = states.iter().map(|&i| x(i)).collect();
        let rates = (grid.rates)(&names, &control);
        let is_end = k == 0 || k == grid.intervals;
        let weight = if is_end { 0.5 } else { 1.0 } / length;
        if let Some(cost) = grid.cost {
            s.minimize(format!("{time}*{weight}*({})", cost(&names, &control)));
        }
        if let Some((old, previous)) = before {
            let half = 0.5 / length;
            for i in 0..states.len() {
                let (new, old, rate, last) = (x(states[i]), x(old[i]), &rates[i], &previous[i]);
                s.equality(format!("{new} - {old} - {time}*{half}*({rate} + {last})"));
            }
        }
        before = Some((states, rates));
    }
    (s, before.map_or_else(Vec::new, |last| last.0))
}

pub(crate) fn van_der_pol(name: &str, intervals: usize) -> Stated {
    let (s, _) = discretize(&Grid {
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
    s.finish()
}

pub(super) fn brachistochrone(intervals: usize) -> Stated {
    let guess = |s: f64| vec![2.0 * s, 2.0 * s, 5.0 * s];
    let last = [Some(2.0), Some(2.0), None];
    let (mut s, _) = discretize(&Grid {
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
    s.minimize(x(0));
    s.finish()
}

pub(super) fn double_integrator(intervals: usize) -> Stated {
    let (mut s, _) = discretize(&Grid {
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
    s.minimize(x(0));
    s.finish()
}

pub(super) fn cart_pole(name: &str, intervals: usize) -> Stated {
    let last = [Some(1.0), Some(PI), Some(0.0), Some(0.0)];
    let (s, _) = discretize(&Grid {
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
    s.finish()
}

pub(super) fn pendulum(intervals: usize) -> Stated {
    let (mut s, _) = discretize(&Grid {
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
    s.minimize(x(0));
    s.finish()
}

/// Mixing of two catalysts in a tubular reactor (COPS 3.0, problem 14).
pub(super) fn catalyst_mixing(intervals: usize) -> Stated {
    let (mut s, last) = discretize(&Grid {
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
    s.minimize(format!("{} + {} - 1", x(last[0]), x(last[1])));
    s.finish()
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
    let (mut s, last) = discretize(&Grid {
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
    s.minimize(format!("-{}", x(last[0])));
    s.finish()
}
