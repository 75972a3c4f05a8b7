//! Surfaces with edges, by every simulator: closed forms, and random motions by two methods.

#![allow(clippy::unwrap_used, reason = "a failed step fails the test")]

use crate::common::{distance, last};
use hangtime::baselines::{FixedStep, Moreau, Smooth};
use hangtime::prelude::*;
use hangtime::simulation::{InitialValueProblem, SimulationStatus, Simulator, StepFormulation};

const G: f64 = 9.81;

hangtime::model! {
    /// A block slides off the end of a table.
    Table {
        parameters { m: kg = 2, g: m/s^2 = 9.81, height: m = 0.8, edge: m = 0.5, speed: m/s = 1.5 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface table: max(z - height, y - edge) >= 0
        impact table: inelastic
        outputs { load: N = force(table) }
        start { z: height, dot(y): speed }
        horizon 0.7 [s]
    }
}

hangtime::model! {
    /// The same with friction.
    RoughTable {
        parameters { m: kg = 2, g: m/s^2 = 9.81, mu = 0.2, height: m = 0.8, edge: m = 0.5, speed: m/s = 1.5 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface table: max(z - height, y - edge) >= 0
        impact table: inelastic, friction mu
        start { z: height, dot(y): speed }
        horizon 0.8 [s]
    }
}

hangtime::model! {
    /// A ball slides up one side of a roof and lands on the other.
    Roof {
        parameters { m: kg = 1, g: m/s^2 = 9.81, slope = 0.5, speed: m/s = 4 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface roof: z >= -|slope*y|
        impact roof: inelastic
        start { y: -1 [m], z: -slope*1 [m], dot(y): speed, dot(z): slope*speed }
        horizon 1.5 [s]
    }
}

hangtime::model! {
    /// A ball slides into a valley and up its other side.
    Valley {
        parameters { m: kg = 1, g: m/s^2 = 9.81, slope = 0.5 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface valley: z >= |slope*y|
        impact valley: inelastic
        start { y: -1 [m], z: slope*1 [m] }
        horizon 0.9 [s]
    }
}

hangtime::model! {
    /// A ball among a hut and a post on a floor.
    Yard {
        parameters { m: kg = 1, g: m/s^2 = 9.81, e = 0.4, mu = 0.1, y0: m = 0, z0: m = 1.5, vy: m/s = 1, vz: m/s = 0 }
        coordinates { y: m, z: m }
        fn hut(y, z) = max(z - 0.6 [m], z + |y| - 0.8 [m])
        fn post(y, z) = max(z - 0.9 [m], |y - 2 [m]| - 0.3 [m])
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface ground: min(z, hut(y, z), post(y, z)) >= 0
        impact ground: restitution e, friction mu
        start { y: y0, z: z0, dot(y): vy, dot(z): vz }
        horizon 1.5 [s]
    }
}

hangtime::model! {
    /// A ball slides down a ramp that goes over into an arc, along which it stays.
    Hollow {
        parameters { m: kg = 1, g: m/s^2 = 9.81, slope = 0.5, radius: m = 1, side = 1, steep = 2 }
        coordinates { y: m, z: m }
        fn ramp(y) = -slope*side*y
        fn arc(y) = ramp(y) + y^2/(2*radius)
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface ground: z >= max(ramp(y), min(arc(y), ramp(y) + steep*side*y))
        impact ground: inelastic
        start { y: -side*1 [m], z: slope*1 [m] }
        horizon 1 [s]
    }
}

hangtime::model! {
    /// A block slides over the round end of a bar.
    Bar {
        parameters { m: kg = 2, g: m/s^2 = 9.81, r: m = 0.5, edge: m = 0.5, speed: m/s = 1 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface bar: min(max(z - r, y - edge), sqrt((y - edge)^2 + z^2) - r) >= 0
        impact bar: inelastic
        start { z: r, dot(y): speed }
        horizon 1 [s]
    }
}

hangtime::model! {
    /// A block comes to the end of a floor and to a leaning wall at the same instant.
    WallAtTheEnd {
        parameters { m: kg = 1, g: m/s^2 = 9.81, e = 0.5, tilt = 0.5, speed: m/s = 2 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface floor: max(z, y - 1 [m]) >= 0
        surface wall: 1 [m] + tilt*z - y >= 0
        impact floor: inelastic
        impact wall: restitution e
        start { dot(y): speed }
        horizon 1.2 [s]
    }
}

/// Every simulator for scenes without friction, with the error that its steps of `h` leave.
fn all(horizon: f64) -> Vec<(Box<dyn Simulator>, f64)> {
    let steps = 4000;
    let mut time_freezing = Fesd::default().with_grid(30, 2);
    time_freezing.formulation = StepFormulation::TimeFreezing;
    let event = EventDriven {
        tolerance: 1e-12,
        ..EventDriven::default()
    };
    let moreau = Moreau {
        steps,
        ..Moreau::default()
    };
    let fixed = FixedStep {
        steps,
        ..FixedStep::default()
    };
    let smooth = Smooth {
        width: 1e-3,
        tolerance: 1e-8,
        ..Smooth::default()
    };
    // Located switches: roundings, as parabolas are exact. The others notice each of two switches up to a step late,
    // with velocities of 5 m/s; the smoothed one some widths away.
    let late = 20.0 * horizon / steps as f64;
    vec![
        (Box::new(Fesd::default()), 1e-10),
        (Box::new(event), 1e-10),
        (Box::new(time_freezing), 1e-10),
        (Box::new(moreau), late),
        (Box::new(fixed), late),
        (Box::new(smooth), 2e-2),
    ]
}

/// Random numbers between two bounds.
fn random(mut seed: u64) -> impl FnMut(f64, f64) -> f64 {
    move |low, high| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        low + (high - low) * (seed >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn assert_ends(model: &dyn Model, end: [f64; 4], among: impl Fn(&str) -> bool) {
    let problem = InitialValueProblem::of(model, None).unwrap();
    for (simulator, tolerance) in all(problem.horizon) {
        if !among(simulator.name()) {
            continue;
        }
        let run = simulator.simulate(model, &problem, &mut |_| true).unwrap();
        assert!(run.status.is_solved(), "{}: {run}", simulator.name());
        let (q, v) = last(&run.trajectory);
        let off = distance(q, &end[..2]).max(distance(v, &end[2..]));
        assert!(off < tolerance, "{}: off by {off:e}", simulator.name());
    }
}

#[test]
fn block_leaves_the_end_of_a_table_as_a_horizontal_throw() {
    let table = Table::default();
    let fall = 0.7 - table.edge / table.speed;
    let end = [
        0.7 * table.speed,
        table.height - G / 2.0 * fall * fall,
        table.speed,
        -G * fall,
    ];
    assert_ends(&table, end, |_| true);
    let run = simulate(&table).run().unwrap();
    let kinds: Vec<_> = run
        .events
        .iter()
        .map(|e| (e.kind, e.contact_name))
        .collect();
    assert_eq!(kinds, [(EventKind::LiftOff, "table.1")]);
    assert!((run.events[0].time - table.edge / table.speed).abs() < 1e-13);
}

#[test]
fn impact_of_another_contact_at_an_edge_is_one_of_that_contact_alone() {
    // The velocity `(speed, 0)` changes along the normal `(-1, tilt)` of the wall, and by nothing else: what it leads to
    // leaves one side of the edge. After an upright wall the block slides back.
    for tilt in [0.5, 0.0] {
        let scene = WallAtTheEnd {
            tilt,
            ..WallAtTheEnd::default()
        };
        let push = (1.0 + scene.e) * scene.speed / (1.0 + tilt * tilt);
        let (v, w) = (scene.speed - push, tilt * push);
        let impact = 1.0 / scene.speed;
        let landing = impact + 2.0 * w / G;
        assert!(landing < 1.2);
        let end = [1.0 + v * (1.2 - impact), 0.0, v, 0.0];
        assert_ends(&scene, end, |name| {
            ["fesd", "event", "moreau"].contains(&name)
        });
        let run = simulate(&scene).steps(40).run().unwrap();
        let (q, _) = last(&run.trajectory);
        assert!(
            run.status.is_solved() && (q[0] - end[0]).abs() < 1e-10,
            "{run}"
        );
        let impacts = run.events.iter().filter(|e| e.kind == EventKind::Impact);
        let first = impacts.map(|e| e.contact_name).next();
        assert_eq!(first, Some("wall"), "{run}");
    }
}

#[test]
fn block_is_braked_up_to_the_end_of_a_rough_table_only() {
    let table = RoughTable::default();
    let (v0, brake) = (table.speed, table.mu * G);
    let v1 = (v0 * v0 - 2.0 * brake * table.edge).sqrt();
    let fall = 0.8 - (v0 - v1) / brake;
    let end = [
        table.edge + v1 * fall,
        table.height - G / 2.0 * fall * fall,
        v1,
        -G * fall,
    ];
    assert_ends(&table, end, |name| !["fixed", "smooth"].contains(&name));
    // Too slow, it stays.
    let slow = RoughTable {
        speed: 1.3,
        ..table
    };
    let run = simulate(&slow).run().unwrap();
    let rest = 1.3 * 1.3 / (2.0 * brake);
    assert!((last(&run.trajectory).0[0] - rest).abs() < 1e-10, "{run}");
}

#[test]
fn ball_flies_over_the_ridge_of_a_roof_and_lands_on_its_other_side() {
    let roof = Roof::default();
    let s = roof.slope;
    let along = G * s / (1.0 + s * s);
    let v1 = (roof.speed * roof.speed - 2.0 * along).sqrt();
    let (up, flight) = ((roof.speed - v1) / along, 4.0 * s * v1 / G);
    let landed = (v1 - s * (s * v1 - G * flight)) / (1.0 + s * s);
    let rest = 1.5 - up - flight;
    let y = v1 * flight + landed * rest + along / 2.0 * rest * rest;
    let v = landed + along * rest;
    assert_ends(&roof, [y, -s * y, v, -s * v], |_| true);
}

#[test]
fn ball_goes_through_a_valley_with_what_its_other_side_leaves() {
    let valley = Valley::default();
    let s = valley.slope;
    let along = G * s / (1.0 + s * s);
    let (down, v0) = ((2.0 / along).sqrt(), (2.0 * along).sqrt());
    let v1 = v0 * (1.0 - s * s) / (1.0 + s * s);
    let rest = 0.9 - down;
    let y = v1 * rest - along / 2.0 * rest * rest;
    let v = v1 - along * rest;
    assert_ends(&valley, [y, s * y, v, s * v], |_| true);
}

#[test]
fn ball_goes_over_from_a_ramp_into_an_arc_without_loss() {
    let mut random = random(20_261_122);
    for case in 0..40 {
        let hollow = Hollow {
            slope: random(0.2, 1.0),
            radius: random(0.5, 2.0),
            side: if case % 2 == 0 { 1.0 } else { -1.0 },
            steep: random(1.0, 4.0),
            ..Hollow::default()
        };
        let problem = InitialValueProblem::of(&hollow, None).unwrap();
        let event = EventDriven {
            tolerance: 1e-12,
            ..EventDriven::default()
        };
        let simulators: [&dyn Simulator; 2] = [&Fesd::default(), &event];
        for simulator in simulators {
            let run = simulator
                .simulate(&hollow, &problem, &mut |_| true)
                .unwrap();
            assert!(run.status.is_solved(), "{hollow:?}: {run}");
            let (q, v) = last(&run.trajectory);
            let y = q[0] * hollow.side;
            let ground = -hollow.slope * y + y.max(0.0).powi(2) / (2.0 * hollow.radius);
            assert!((q[1] - ground).abs() < 1e-9, "{hollow:?} at {q:?}");
            let fallen = 0.5 * (v[0] * v[0] + v[1] * v[1]) - G * (hollow.slope - q[1]);
            // Tolerance 1e-6 of its largest error for the one, 1e-12 a step for the other.
            assert!(
                fallen.abs() < 1e-6,
                "{}: {fallen:e}, {hollow:?}",
                simulator.name()
            );
        }
    }
}

#[test]
fn block_leaves_the_round_end_of_a_bar_where_its_weight_no_longer_holds_it() {
    let bar = Bar::default();
    // v^2 = v0^2 + 2 g r (1 - cos) has come to g r cos.
    let cosine = (bar.speed * bar.speed / (G * bar.r) + 2.0) / 3.0;
    let problem = InitialValueProblem::of(&bar, None).unwrap();
    let simulators: [&dyn Simulator; 2] = [&Fesd::default(), &EventDriven::default()];
    for simulator in simulators {
        let run = simulator.simulate(&bar, &problem, &mut |_| true).unwrap();
        let left = run.events.iter().rfind(|e| e.kind == EventKind::LiftOff);
        let left = left.unwrap();
        assert_eq!(left.contact_name, "bar.3");
        let off = (left.q[1] - bar.r * cosine).abs();
        assert!(off < 1e-6, "{}: {off:e}\n{run}", simulator.name());
        assert!(run.events.iter().all(|e| e.kind != EventKind::Impact));
    }
}

#[test]
fn ball_that_falls_on_a_ridge_from_above_rolls_down_one_side() {
    let roof = Roof::default();
    let mut problem = InitialValueProblem::of(&roof, Some(0.6)).unwrap();
    (problem.q, problem.v) = (vec![0.0, 0.2], vec![0.0, 0.0]);
    let event = EventDriven::default();
    let simulators: [&dyn Simulator; 2] = [&Fesd::default(), &event];
    let ends = simulators.map(|simulator| {
        let run = simulator.simulate(&roof, &problem, &mut |_| true).unwrap();
        assert!(run.status.is_solved(), "{run}");
        last(&run.trajectory).0.to_vec()
    });
    assert!(distance(&ends[0], &ends[1]) < 1e-9, "{ends:?}");
    assert!((ends[0][1] + roof.slope * ends[0][0].abs()).abs() < 1e-10);
    assert!(ends[0][0].abs() > 0.1, "{ends:?}");
}

#[test]
fn random_throws_among_edges_are_the_same_by_two_methods() {
    let mut random = random(20_261_121);
    let (mut solved, mut events, mut edges) = (0, 0, 0);
    for case in 0..100 {
        // Half of them slide over the tops and their edges.
        let (e, y0, z0, vz) = match case % 4 {
            0 => (0.0, random(-0.15, 0.15), 0.61, 0.0),
            2 => (0.0, random(1.75, 2.25), 0.91, 0.0),
            _ => (
                random(0.0, 0.8),
                random(-1.5, 3.5),
                random(1.0, 1.6),
                random(-2.0, 2.0),
            ),
        };
        let yard = Yard {
            e,
            mu: random(0.0, 0.4),
            y0,
            z0,
            vy: random(-3.0, 3.0),
            vz,
            ..Yard::default()
        };
        let problem = InitialValueProblem::of(&yard, None).unwrap();
        let run = Fesd::default()
            .simulate(&yard, &problem, &mut |_| true)
            .unwrap();
        let event = EventDriven {
            tolerance: 1e-11,
            ..EventDriven::default()
        };
        let other = event.simulate(&yard, &problem, &mut |_| true).unwrap();
        // Whatever is said to be solved lies above the ground.
        for q in &run.trajectory.q {
            let hut = (q[1] - 0.6).max(q[1] + q[0].abs() - 0.8);
            let post = (q[1] - 0.9).max((q[0] - 2.0).abs() - 0.3);
            assert!(q[1].min(hut).min(post) > -1e-9, "{case}: {yard:?} at {q:?}");
        }
        if run.status != SimulationStatus::Solved || other.status != SimulationStatus::Solved {
            continue;
        }
        solved += 1;
        events += run.events.len();
        edges += usize::from(run.events.iter().any(|e| {
            let ends = |at: f64| (e.q[0] - at).abs() < 1e-9;
            e.kind == EventKind::LiftOff && [-0.2, 0.2, 1.7, 2.3].into_iter().any(ends)
        }));
        let (ours, theirs) = (last(&run.trajectory), last(&other.trajectory));
        let off = distance(ours.0, theirs.0).max(distance(ours.1, theirs.1));
        assert!(
            off < 1e-5,
            "{case}: off by {off:e}, {yard:?}\n{run}\n{other}"
        );
    }
    assert!(solved >= 97, "{solved} solved");
    assert!(
        events > 500 && edges > 10,
        "{events} events, {edges} runs past an edge"
    );
}

#[test]
fn outer_edge_is_refused_by_name_where_it_is_not_known() {
    let step = Fesd::default().with_formulation(StepFormulation::Complementarity);
    let table = Table::default();
    let problem = InitialValueProblem::of(&table, None).unwrap();
    let refused = step.simulate(&table, &problem, &mut |_| true).unwrap_err();
    assert!(refused.to_string().contains("`table.1`"), "{refused}");
}

#[test]
fn force_of_a_surface_is_that_of_its_pieces() {
    let table = Table::default();
    let run = simulate(&table).run().unwrap();
    let (x, mut load) = ([0.1, 0.8, 1.5, 0.0, 0.05], [0.0]);
    table.output_values(&x, &[3.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], &mut load);
    assert_eq!(load, [7.0]);
    assert!((run.trajectory.contact_force[0][0] - table.m * G).abs() < 1e-12);
}
