//! Forces and impulses in the program of a known motion.

use hangtime_solver::nlp::{NlpProblem, check_derivatives};

use super::time_freezing::TimeFreezing;
use crate::ocp::motion::control_grid::ControlGrid;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::{Horizon, Problem};
use crate::ocp::settings::TimeFreezingSettings;
use crate::rk::Scheme;
use crate::time_freezing::task::{Guess, Span, Task};

crate::model! {
    /// A bead that strikes a floor on which it slides, and a wall that throws it back, and reads what both do to it.
    StruckBead {
        parameters { m: kg = 2, g: m/s^2 = 9.81, k: 1/m = 1.5 }
        coordinates { y: m, z: m }
        controls { u: N }
        lagrangian m/2*(dot(y)^2 + (2 + sin(k*y))*dot(z)^2) - m*g*z
        forces { y: u*cos(k*y) }
        surface floor: z - sin(k*y)/(4*k) >= 0
        surface wall: 1[m] - y - k*z^2/8 >= 0
        impact floor: inelastic, friction 0.4, sliding dot(y) + cos(k*y)/4*dot(z)
        impact wall: restitution 0.6
        minimize sum(impulse(wall)^2 + y*friction_impulse(floor)^2/1[m])/1[N^2*s^2] + force(floor)/1[N]
            + integral(force(floor)^2/1[N^2] + u*friction_force(floor)/1[N^2])/1[s]
        constraint grip: force(floor) - u^2/1[N] >= 0
        constraint pace: dot(y)^2 + z*u*1[m/(N*s^2)] >= 0
        constraint soft: impulse(floor) <= 3[N*s]
        finally { friction_force(floor)*y == 2[N*m], sum(impulse(floor))*dot(y) <= 5[J] }
    }
}

/// The program of a bead that flies, strikes the wall and is thrown back, flies, and lands on the floor, where it slides.
fn struck(bead: &StruckBead, scheme: Scheme) -> TimeFreezing<'_> {
    // Weights of floor and wall, of sliding on the floor, and of fall and rise at the wall.
    let open = [[true, false], [true, false], [false, false], [false, false]];
    let fall = [[true, false], [false, true], [false, false], [true, false]];
    let rise = [[true, false], [false, true], [false, false], [false, true]];
    let land = [[false, true], [true, false], [true, false], [false, false]];
    let slide = [[true, true], [true, false], [true, false], [false, false]];
    let span = |weights: [[bool; 2]; 4], jumps: bool, [from, to]: [f64; 2], share: f64| {
        let point = |time: f64| {
            let states = [0.4, 0.3, 0.5, -0.8, time, 0.2, 0.1];
            let alpha = |contact: usize| match weights[contact] {
                [true, true] => share,
                [free, _] => f64::from(u8::from(free)),
            };
            [&states[..], &[alpha(0), alpha(1), 1.0, 0.6]].concat()
        };
        Span {
            length: if jumps { 0.05 } else { to - from },
            jumps,
            weights: weights.to_vec(),
            points: vec![point(from), point(to)],
        }
    };
    let first = vec![
        span(open, false, [0.0, 0.1], 1.0),
        span(fall, true, [0.1, 0.1], 1.0),
        span(rise, true, [0.1, 0.1], 1.0),
        span(open, false, [0.1, 0.2], 1.0),
    ];
    let second = vec![
        span(open, false, [0.2, 0.3], 1.0),
        span(land, true, [0.3, 0.3], 0.0),
        span(slide, false, [0.3, 0.4], 0.7),
    ];
    let mut problem = Problem::of(bead, 2);
    problem.horizon = Horizon::Fixed(0.4);
    (problem.q, problem.v) = (vec![0.4, 0.3], vec![0.5, -0.8]);
    let state = vec![0.4, 0.3, 0.5, -0.8, 0.0, 0.0];
    let guess = Trajectory {
        horizon: 0.4,
        controls: ControlGrid::constant(vec![vec![0.8]; 2]),
        time: vec![0.0, 0.4],
        states: vec![state.clone(), state],
    };
    let task = Task {
        time: 0.0,
        linear: false,
        slopes: Vec::new(),
        intervals: 2,
        elements: 4,
        coordinate_bounds: (vec![f64::NEG_INFINITY; 2], vec![f64::INFINITY; 2]),
        guess: Guess::Known(vec![first, second]),
    };
    let mut settings = TimeFreezingSettings::default();
    (settings.scheme, settings.auxiliary_acceleration) = (scheme, 50.0);
    let program = TimeFreezing::transcribed((bead, &problem, &settings), &guess, task);
    program.expect("valid")
}

/// Names of the variables or rows that begin so.
fn named(names: &[String], start: &str) -> usize {
    names.iter().filter(|name| name.starts_with(start)).count()
}

#[test]
fn forces_and_impulses_stand_where_contacts_act_and_their_derivatives_are_right() {
    let bead = StruckBead::default();
    let mut program = struck(&bead, Scheme::RadauIia);
    assert!(!program.leaves_out_forces());
    let count = program.variables();
    let names: Vec<String> = (0..count).map(|i| program.variable_name(i)).collect();
    let rows: Vec<String> = (0..program.constraints())
        .map(|i| program.constraint_name(i))
        .collect();
    // The normal force and that of sliding at two stages of the two last elements; the impulse of the wall; both of the floor.
    assert_eq!(named(&names, "force of floor at stage"), 4);
    assert_eq!(
        named(&names, "force along the sliding velocity of floor"),
        4
    );
    assert_eq!(
        named(&names, "impulse of wall from element 1 of interval 0"),
        1
    );
    assert_eq!(
        named(&names, "impulse of floor from element 1 of interval 1"),
        1
    );
    assert_eq!(
        named(&names, "impulse along the sliding velocity of floor"),
        1
    );
    // Conditions on forces hold at the stages of phases: five elements of eight are none of the jumps. Only the floor's impulse is bounded.
    assert_eq!(named(&rows, "`grip`"), 2 * 5);
    assert_eq!(named(&rows, "`pace`"), 2 * 8);
    assert_eq!(named(&rows, "`soft` in an impact"), 1);
    let mut x = vec![0.0; count];
    program.initial_point(&mut x);
    // What is guessed satisfies its rows.
    let mut values = vec![0.0; rows.len()];
    program.constraint_values(&x, &mut values);
    for (row, name) in rows.iter().enumerate() {
        if ["force ", "impulse ", "sum 0", "sum 1"]
            .iter()
            .any(|own| name.starts_with(own))
        {
            let variable = names.iter().position(|own| own == name);
            assert!(values[row].abs() < 1e-12, "{name}: {}", values[row]);
            assert!(x[variable.expect("a variable")] != 0.0, "{name}");
        }
    }
    for (i, value) in x.iter_mut().enumerate() {
        *value += 0.1 + 0.05 * (i as f64).sin();
    }
    let compared = check_derivatives(&mut program, Some(&x)).expect("finite at the start");
    assert!(compared.iter().all(|entry| !entry.missing));
    assert!(compared[0].error < 1e-6, "{:?}", compared[0]);
}

#[test]
fn scheme_without_a_stage_at_the_end_leaves_out_forces_there() {
    let bead = StruckBead::default();
    let program = struck(&bead, Scheme::GaussLegendre);
    assert!(program.leaves_out_forces());
    let rows = (0..program.constraints()).map(|row| program.constraint_name(row));
    let goals = rows.filter(|name| name.ends_with("at the end"));
    assert_eq!(goals.filter(|name| name.starts_with('`')).count(), 1);
}
