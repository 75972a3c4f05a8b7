//! Orders of convergence of the program of the time-freezing system itself, through impacts, switches and slides: no motion is
//! polished here, as nothing is free but the lengths of its elements.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use hangtime::model::Model;
use hangtime::mpcc;
use hangtime::nlp::NlpProblem as _;
use hangtime::ocp::{Horizon, Problem, TimeFreezing, TimeFreezingSettings};
use hangtime::prelude::*;
use hangtime::rk::Scheme;

hangtime::model! {
    /// A pendulum in drag that a stop throws back.
    Thrown {
        parameters { g: m/s^2 = 9.81, m: kg = 1, l: m = 1, c: N*m*s^2 = 0.3, e = 0.6 }
        coordinates { phi }
        lagrangian m*l^2/2*dot(phi)^2 + m*g*l*cos(phi)
        forces { phi: -c*dot(phi)^3*1[s] }
        surface stop: phi >= 0.3
        impact stop: restitution e
        start { phi: 1.2 }
        horizon 0.8 [s]
    }
}

hangtime::model! {
    /// A mass that falls into a bowl, and slides on in it.
    Landed {
        parameters { g: m/s^2 = 9.81, m: kg = 1, c: 1/m = 0.5, drag: kg/s = 0.2 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: -drag*dot(y), z: -drag*dot(z) }
        surface bowl: z >= c*y^2
        impact bowl: inelastic
        start { y: -1 [m], z: 0.8 [m], dot(y): 1 [m/s] }
        horizon 0.8 [s]
    }
}

hangtime::model! {
    /// A pendulum that is braked on one side.
    Passed {
        parameters { g: m/s^2 = 9.81, m: kg = 1, l: m = 1, c: N*m*s = 2 }
        coordinates { phi }
        lagrangian m*l^2/2*dot(phi)^2 + m*g*l*cos(phi)
        forces { phi: if phi >= 0.2 { 0 [N*m] } else { -c*dot(phi) } }
        start { phi: 1.2 }
        horizon 0.8 [s]
    }
}

hangtime::model! {
    /// A state that comes to a jump of its rate and slides along it, by which the other one moves.
    Held {
        states { x, y }
        rates { x: (0.5 + 0.3*sin(2*y) - x^2)*1[1/s] - sign(x)*1[1/s], y: (1 + y*sign(x))*1[1/s] }
        start { x: 0.4, y: 0.1 }
        horizon 2 [s]
    }
}

/// The state at the end of the program of a scene with so many intervals.
fn end(model: &dyn Model, (scheme, stages): (Scheme, usize), intervals: usize) -> Vec<f64> {
    let mut problem = Problem::of(model, intervals);
    problem.horizon = Horizon::Fixed(model.horizon().unwrap());
    let mut settings = TimeFreezingSettings::default();
    (settings.scheme, settings.stages) = (scheme, stages);
    let mut program = TimeFreezing::new(model, &problem, &settings).unwrap();
    let mut solver = mpcc::Settings::default();
    solver.interior_point.tolerance = 1e-12;
    let solution = mpcc::solve(&mut program, &solver).unwrap();
    assert!(solution.status.is_solved(), "{:?}", solution.status);
    assert_eq!(solution.residuals.complementarity, 0.0);
    let coordinates = model.declaration().coordinates;
    let last = |name: String| {
        let start = format!("{name} at ");
        let own =
            (0..program.variables()).filter(|&i| program.variable_name(i).starts_with(&start));
        solution.x[own.last().unwrap()]
    };
    let positions = coordinates.iter().map(|known| known.name.to_owned());
    let velocities = coordinates
        .iter()
        .map(|known| format!("dot({})", known.name));
    positions.chain(velocities).map(last).collect()
}

#[test]
fn explore() {
    let scenes: [(&str, Box<dyn Model>); 4] = [
        ("thrown", Box::new(Thrown::default())),
        ("landed", Box::new(Landed::default())),
        ("passed", Box::new(Passed::default())),
        ("held", Box::new(Held::default())),
    ];
    let exactly = EventDriven {
        tolerance: 1e-13,
        ..EventDriven::default()
    };
    for (name, model) in &scenes {
        let exact = simulate(&**model).method(exactly.clone()).run().unwrap();
        let (q, v) = (
            exact.trajectory.q.last().unwrap(),
            exact.trajectory.v.last().unwrap(),
        );
        let exact: Vec<f64> = q.iter().chain(v).copied().collect();
        println!("{name} {exact:?}");
        for (scheme, stages) in [
            (Scheme::RadauIia, 1),
            (Scheme::RadauIia, 2),
            (Scheme::RadauIia, 3),
            (Scheme::RadauIia, 4),
            (Scheme::GaussLegendre, 1),
            (Scheme::GaussLegendre, 2),
            (Scheme::GaussLegendre, 3),
        ] {
            let mut errors = Vec::new();
            for intervals in [1, 2, 4, 8] {
                let end = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| end(&**model, (scheme, stages), intervals)));
                errors.push(end.map_or(f64::NAN, |end| {
                    end.iter()
                        .zip(&exact)
                        .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()))
                }));
            }
            let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
            println!("{name} {scheme:?} {stages}: {errors:?} {orders:.2?}");
        }
    }
}
