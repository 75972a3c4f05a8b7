//! Orders of convergence of the program of the time-freezing system itself through impacts, switches, slides and what conditions set.
//! Nothing is free in these scenes, so that its objective is where its own motion ends; the motion that is planned over the sequence has
//! no part in that.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{attempt, one_start};
use hangtime::model::Model;
use hangtime::ocp::{Formulation, Settings, Status, TimeFreezingSettings};
use hangtime::prelude::*;
use hangtime::rk::Scheme;

hangtime::model! {
    /// A pendulum in drag that a stop throws back.
    Thrown {
        parameters { g: m/s^2 = 9.81, m: kg = 1, l: m = 1, c: N*m*s^3 = 0.3, e = 0.6 }
        coordinates { phi }
        lagrangian m*l^2/2*dot(phi)^2 + m*g*l*cos(phi)
        forces { phi: -c*dot(phi)^3 }
        surface stop: phi >= 0.3
        impact stop: restitution e
        minimize phi
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
        minimize y
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
        minimize phi
        start { phi: 1.2 }
        horizon 0.8 [s]
    }
}

hangtime::model! {
    /// A state that comes to a jump of its rate and slides along it, by which the other one moves.
    Held {
        states { x, y }
        rates { x: (0.5 + 0.3*sin(2*y) - x^2)*1[1/s] - sign(x)*1[1/s], y: (1 + y*sign(x))*1[1/s] }
        minimize y
        start { x: 0.4, y: 0.1 }
        horizon 2 [s]
    }
}

hangtime::model! {
    /// A heater that is switched on where it is cold, and warms at once, and off where it is warm.
    Heated {
        parameters { cold = -0.3, warm = 0.4 }
        states { x, on }
        rates { x: (-1 - 4*x^2 + 3*on)*1[1/s], on: 0 [1/s] }
        when x <= cold { on = 1 + x^2 }
        when x >= warm { on = on/4 }
        minimize x
        start { x: 0.3 }
        horizon 2.5 [s]
    }
}

/// The optimum of the exact program of a scene with so many elements.
fn optimum(model: &dyn Model, (scheme, stages): (Scheme, usize), elements: usize) -> f64 {
    let mut freezing = TimeFreezingSettings::default();
    (freezing.scheme, freezing.stages, freezing.elements) = (scheme, stages, elements);
    let mut settings = Settings::default();
    settings.starts = Some(1);
    settings.formulation = Formulation::TimeFreezing(freezing);
    let report = attempt(model, 1, &settings).time_freezing.unwrap();
    assert_eq!(report.residuals.complementarity, 0.0, "{report:?}");
    report.objective
}

/// The order by which the optimum tends to where a motion ends.
fn order(
    (model, name): (&dyn Model, &str),
    scheme: (Scheme, usize),
    [coarse, fine]: [usize; 2],
) -> f64 {
    let exactly = EventDriven {
        tolerance: 1e-13,
        ..EventDriven::default()
    };
    let motion = simulate(model).method(exactly).run().unwrap();
    let time = *motion.trajectory.time.last().unwrap();
    let end = motion.at(time).unwrap()[name];
    let error = |elements| (optimum(model, scheme, elements) - end).abs();
    (error(coarse) / error(fine)).log2() / (fine as f64 / coarse as f64).log2()
}

#[test]
fn order_is_that_of_the_scheme_through_all_that_happens() {
    // Numbers of elements between which errors fall, until they are those of rounding.
    let smooth = [[4, 32], [4, 32], [4, 16]];
    let scenes: [(&dyn Model, &str, [[usize; 2]; 3]); 5] = [
        (&Thrown::default(), "phi", smooth),
        (&Landed::default(), "y", smooth),
        (&Passed::default(), "phi", smooth),
        (&Held::default(), "y", smooth),
        (&Heated::default(), "x", [[8, 16]; 3]),
    ];
    for (scene, name, elements) in scenes {
        for (stages, elements) in (2..=4).zip(elements) {
            let radau = (Scheme::RadauIia, stages);
            let measured = order((scene, name), radau, elements);
            let expected = (2 * stages - 1) as f64;
            assert!(
                measured > expected - 0.3,
                "{name}, {stages} stages: {measured}"
            );
        }
    }
}

#[test]
fn gauss_schemes_keep_theirs_without_a_stage_at_the_end() {
    let scenes: [(&dyn Model, &str); 4] = [
        (&Thrown::default(), "phi"),
        (&Landed::default(), "y"),
        (&Passed::default(), "phi"),
        (&Held::default(), "y"),
    ];
    for (scene, name) in scenes {
        for stages in [2, 3] {
            let gauss = (Scheme::GaussLegendre, stages);
            let measured = order((scene, name), gauss, [8, 16]);
            let expected = (2 * stages) as f64;
            assert!(
                measured > expected - 0.3,
                "{name}, {stages} stages: {measured}"
            );
        }
    }
}

hangtime::model! {
    /// A sledge that is pushed over rough hills from rest to rest.
    Hills {
        parameters { m: kg = 2, g: m/s^2 = 10, mu = 0.25, d: m = 2, b: m = 0.1, k: 1/m = 3 }
        coordinates { y: m, z: m }
        controls { u: N in -15..=15 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= b*sin(k*y)
        impact floor: inelastic, friction mu
        minimize time
        finally { y == d, dot(y) == 0 }
    }
}

#[test]
fn sliding_over_hills_is_as_accurate_as_the_scheme() {
    // Two stages are of order 3. The largest distance is there to keep the grid as it is.
    let error = |elements: usize| {
        let mut settings = one_start();
        settings.stages = 2;
        settings.elements = elements;
        settings.largest_distance = 1.0;
        let solution = attempt(&Hills::default(), 8, &settings);
        assert_eq!(
            solution.status,
            Status::Solved,
            "{:?}",
            solution.diagnosis()
        );
        solution.resimulation_error
    };
    let errors = [error(2), error(4), error(8)];
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((2.5..3.7).contains(&order), "{errors:?}");
    }
}
