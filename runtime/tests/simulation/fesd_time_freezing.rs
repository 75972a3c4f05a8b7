//! The time-freezing system in numerical time, element by element in a fixed region: against closed forms and the
//! event-driven simulator, its orders through impacts, and what it says of its errors.

#![allow(clippy::unwrap_used, reason = "a failed step fails the test")]

use crate::common::laws::{Feet, Ground, Rod, Room};
use crate::common::scenes;
use crate::common::{distance, event, last, order, start};
use hangtime::model::{Model, contact_point, tangent_point};
use hangtime::rk::Scheme;
use hangtime::simulation::{
    ControlSignal, EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
    StepFormulation,
};

hangtime::model! {
    /// A mass that a spring holds, on a belt.
    Belt {
        parameters { m: kg = 1, g: m/s^2 = 9.81, k: N/m = 16, speed: m/s = 0.5 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z - k/2*y^2
        surface ground: z >= 0
        impact ground: inelastic, friction 0.4, sliding dot(y) - speed
    }
}

hangtime::model! {
    /// A point mass on a disc of unit radius whose centre is `above` the floor.
    Dome {
        parameters { m: kg = 1, g: m/s^2 = 9.81, radius: m = 1, above: m = 1, mu = 0 }
        coordinates { y: m, z: m }
        let r = |(y, z)|
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        surface dome: r >= radius
        surface floor: z >= -above
        impact dome: inelastic
        impact floor: inelastic, friction mu, sliding dot(y)
        start { z: radius }
    }
}

hangtime::model! {
    /// Three blocks in a row with springs between them and to a wall.
    Blocks {
        parameters { m: kg = 1, g: m/s^2 = 9.81, k: N/m = 40, mu = 0.3 }
        coordinates { a: m, b: m, c: m, p: m, q: m, r: m }
        lagrangian m/2*|dot((a, b, c))|^2 + m/2*|dot((p, q, r))|^2 - m*g*(p + q + r) - k/2*(a^2 + (b - a)^2 + (c - b)^2)
        surface first: p >= 0
        surface second: q >= 0
        surface third: r >= 0
        impact first: inelastic, friction mu, sliding dot(a)
        impact second: inelastic, friction mu, sliding dot(b)
        impact third: inelastic, friction mu, sliding dot(c)
    }
}

hangtime::model! {
    /// Two balls one above the other with a spring between them; the lower one bounces.
    TwoBalls {
        parameters { m: kg = 1, g: m/s^2 = 9.81, k: N/m = 1e4, length: m = 0.2, e = 0.8 }
        coordinates { low: m, high: m }
        lagrangian m/2*|dot((low, high))|^2 - m*g*(low + high) - k/2*(high - low - length)^2
        surface floor: low >= 0
        impact floor: restitution e
    }
}

hangtime::model! {
    /// A block that a force of the physical time drags along the floor and lifts.
    Driven {
        parameters { m: kg = 1, g: m/s^2 = 9.81, drag: N = 5, lift: N = 12, omega: 1/s = 4, mu = 0.3 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z
        forces { y: drag*cos(omega*t), z: lift*sin(omega*t) }
        surface floor: z >= 0
        impact floor: inelastic, friction mu, sliding dot(y)
    }
}

/// A scene, a start, and its name.
struct Case {
    name: &'static str,
    model: Box<dyn Model>,
    problem: InitialValueProblem,
}

fn case(name: &'static str, model: impl Model + 'static, problem: InitialValueProblem) -> Case {
    Case {
        name,
        model: Box::new(model),
        problem,
    }
}

/// A thrust along the ground that turns round and ends.
fn thrust() -> InitialValueProblem {
    InitialValueProblem {
        controls: ControlSignal::PiecewiseLinear {
            times: vec![0.0, 0.5, 1.0, 1.5],
            values: vec![vec![0.0], vec![9.0], vec![-9.0], vec![0.0]],
        },
        ..start(&[0.0, 0.0], &[0.0, 0.0], 2.0)
    }
}

/// Rods that fall on two tips, and the ski jump from two heights.
fn falls() -> Vec<Case> {
    vec![
        case(
            "falling rod",
            Feet::default(),
            start(&[0.0, 0.8, 0.3], &[0.2, 0.0, 0.0], 1.0),
        ),
        case(
            "falling rod with friction",
            Feet {
                front: 0.8,
                gyration: 0.6,
                mu: 0.2,
                ..Feet::default()
            },
            start(&[0.0, 0.8, 0.3], &[0.5, 0.0, 0.0], 1.0),
        ),
        case(
            "ski jump from the table",
            scenes::ski_jump(),
            start(&[10.2759, 45.001_581_073_295_704], &[0.0; 2], 5.0),
        ),
        case(
            "ski jump from above",
            scenes::ski_jump(),
            start(&[10.2759, 50.0], &[0.0; 2], 5.0),
        ),
    ]
}

/// Scenes without restitution.
fn inelastic() -> Vec<Case> {
    let rough = |mu: f64| Ground {
        mu,
        ..Ground::default()
    };
    let slope = Ground {
        slope: 0.3,
        ..rough(0.5)
    };
    let above = slope.height_at(0.0) + 0.5;
    let waves = Ground {
        height: 0.2,
        number: 3.0,
        ..rough(0.0)
    };
    let mut cases = vec![
        case(
            "ball with friction",
            rough(0.3),
            start(&[0.0, 1.0], &[2.0, 0.0], 1.5),
        ),
        case("curved track", waves, start(&[0.0, 0.2], &[3.0, 0.0], 1.6)),
        case(
            "track in its own coordinates",
            scenes::track_scene(),
            start(&[0.0, 0.0], &[4.0, 0.0], 1.5),
        ),
        case(
            "dome",
            Dome {
                mu: 0.4,
                ..Dome::default()
            },
            start(&[0.0, 1.0], &[0.7, 0.0], 1.2),
        ),
        case(
            "slope with friction",
            slope,
            start(&[0.0, above], &[1.0, 0.0], 2.0),
        ),
        case(
            "stick-slip",
            Belt::default(),
            start(&[-0.1, 0.0], &[0.0; 2], 3.0),
        ),
        case(
            "three blocks",
            Blocks::default(),
            start(&[0.3, 0.1, -0.2, 0.0, 0.0, 0.0], &[0.0; 6], 1.5),
        ),
        case("thrust with friction", rough(0.4), thrust()),
        case(
            "driven block",
            Driven::default(),
            start(&[0.0, 0.0], &[0.0, 0.0], 3.0),
        ),
    ];
    cases.extend(falls());
    cases
}

/// Scenes with restitution.
fn elastic() -> Vec<Case> {
    vec![
        case(
            "two balls on a spring",
            TwoBalls::default(),
            start(&[0.3, 0.5], &[0.0; 2], 1.0),
        ),
        case(
            "elastic box",
            Room {
                e: 1.0,
                ..Room::default()
            },
            start(&[0.3, 0.4], &[2.0, 1.0], 2.0),
        ),
        case(
            "bouncing ball with friction",
            Ground {
                e: 0.6,
                mu: 0.2,
                ..Ground::default()
            },
            start(&[0.0, 1.0], &[2.0, 0.0], 1.2),
        ),
    ]
}

fn time_freezing() -> Fesd {
    Fesd::default().with_formulation(StepFormulation::TimeFreezing)
}

fn run(simulator: &Fesd, case: &Case) -> Simulation {
    let run = simulator.simulate(&*case.model, &case.problem, &mut |_| true);
    run.expect("the problem is accepted")
}

fn exact(case: &Case) -> Simulation {
    let exact = event::run(&event::accurate(), &*case.model, &case.problem);
    assert_eq!(exact.status, SimulationStatus::Solved, "{}", case.name);
    exact
}

/// Largest difference of event times, states right after events, and states at the end.
fn apart(a: &Simulation, b: &Simulation, name: &str) -> f64 {
    assert_eq!(event::sequence(a), event::sequence(b), "{name}");
    let ((q, v), (p, w)) = (last(&a.trajectory), last(&b.trajectory));
    let end = distance(q, p).max(distance(v, w));
    let events = a.events.iter().zip(&b.events);
    events.fold(end, |most, (a, b)| {
        let after = distance(&a.q, &b.q).max(distance(&a.v_after, &b.v_after));
        most.max((a.time - b.time).abs()).max(after)
    })
}

/// The largest coordinate or velocity of a run.
fn size(run: &Simulation) -> f64 {
    let rows = run.trajectory.q.iter().chain(&run.trajectory.v);
    rows.flatten()
        .fold(0.0, |most, value| most.max(value.abs()))
}

fn solved(simulator: &Fesd, case: &Case) -> Simulation {
    let run = run(simulator, case);
    assert_eq!(run.status, SimulationStatus::Solved, "{}", case.name);
    // Five milliseconds a step are allowed, of which there are at least a hundred.
    assert!(run.seconds.total < 0.5, "{}: {:?}", case.name, run.seconds);
    run
}

#[test]
fn scenes_agree_with_the_event_driven_simulator() {
    for case in inelastic().into_iter().chain(elastic()) {
        let exact = exact(&case);
        // Bounces of balls on a stiff spring make 3e-11 of rounding errors.
        let tight = solved(&time_freezing().with_tolerance(1e-10), &case);
        let error = apart(&tight, &exact, case.name);
        assert!(error <= 1e-9, "{}: {error:e}", case.name);
        let [numerical, expected] =
            [&tight, &exact].map(|run| *run.trajectory.numerical_time.last().unwrap());
        assert!(
            (numerical - expected).abs() <= 1e-9,
            "{}: {numerical} {expected}",
            case.name
        );
        event::check_consistency(&*case.model, &tight);
        // What is promised where nothing is named.
        let default = solved(&time_freezing(), &case);
        let error = apart(&default, &exact, case.name) / size(&exact);
        assert!(error <= 1e-6, "{}: {error:e}", case.name);
    }
}

#[test]
fn grids_estimate_their_errors() {
    for case in inelastic().into_iter().chain(elastic()) {
        let exact = exact(&case);
        for (stages, steps, elements) in [
            (2, 60, 3),
            (3, 60, 3),
            (4, 60, 3),
            (3, 20, 1),
            (3, 7, 2),
            (5, 12, 2),
        ] {
            let grid = time_freezing()
                .with_scheme(Scheme::RadauIia, stages)
                .with_grid(steps, elements);
            let found = run(&grid, &case);
            let name = format!("{}, {stages} stages, {steps} x {elements}", case.name);
            if !found.status.is_solved() {
                // Grids may be too coarse, which has a name.
                assert_eq!(found.status.name(), "step_failed", "{name}");
                continue;
            }
            let estimate = found.error_estimate.unwrap();
            if event::sequence(&found) == event::sequence(&exact) {
                let error = apart(&found, &exact, &name) / size(&exact);
                assert!(
                    error <= 10.0 * estimate + 1e-11,
                    "{name}: {error:e} {estimate:e}"
                );
            } else {
                assert!(estimate > 1e-4, "{name}: {estimate:e}");
            }
        }
    }
}

#[test]
fn order_is_kept_through_impacts_in_states_and_event_times() {
    let named = [
        "curved track",
        "stick-slip",
        "three blocks",
        "ski jump from the table",
        "ski jump from above",
    ];
    for case in inelastic() {
        if !named.contains(&case.name) {
            continue;
        }
        let exact = solved(
            &time_freezing()
                .with_scheme(Scheme::RadauIia, 7)
                .with_grid(160, 1),
            &case,
        );
        for (stages, steps) in [
            (2, [160, 320, 640]),
            (3, [80, 160, 320]),
            (4, [40, 80, 160]),
        ] {
            let (mut states, mut times) = (Vec::new(), Vec::new());
            for count in steps {
                let grid = time_freezing()
                    .with_scheme(Scheme::RadauIia, stages)
                    .with_grid(count, 1);
                let found = run(&grid, &case);
                assert_eq!(
                    event::sequence(&found),
                    event::sequence(&exact),
                    "{}",
                    case.name
                );
                let ((q, v), (p, w)) = (last(&found.trajectory), last(&exact.trajectory));
                states.push(distance(q, p).max(distance(v, w)));
                let pairs = found.events.iter().zip(&exact.events);
                times.push(pairs.fold(0.0_f64, |most, (a, b)| most.max((a.time - b.time).abs())));
            }
            let expected = (2 * stages - 1) as f64;
            for (what, errors) in [("state", &states), ("events", &times)] {
                let points: Vec<_> = steps.iter().copied().zip(errors.clone()).collect();
                let measured = order(&points);
                assert!(
                    (measured - expected).abs() < 0.3,
                    "{}, {stages} stages, {what}: {measured} {errors:?}",
                    case.name
                );
            }
        }
    }
}

/// Where the published auxiliary dynamics of one contact end: `a_bar (d -+ mu e)` by the sign of the sliding velocity,
/// sticking where that holds, until the normal velocity is `-e` times that before.
fn by_regions(rod: &Rod, q: &[f64], v: &[f64]) -> (Vec<f64>, bool) {
    let n = q.len();
    let input = |v: &[f64]| [q, v].concat();
    let (mut point, mut tangent) = (
        vec![0.0; contact_point::length(n)],
        vec![0.0; tangent_point::length(n)],
    );
    let mut v = v.to_vec();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    rod.contact(0, &input(&v), &mut point);
    let (mut senses, end) = (Vec::new(), -rod.e * point[contact_point::NORMAL_VELOCITY]);
    for _ in 0..4 {
        rod.contact(0, &input(&v), &mut point);
        rod.tangent(0, &input(&v), &mut tangent);
        let (normal, d) = (
            &point[contact_point::NORMAL..][..n],
            &point[contact_point::direction(n)..],
        );
        let (along, e) = (
            &tangent[tangent_point::TANGENT..][..n],
            &tangent[tangent_point::direction(n)..],
        );
        let (v_n, v_t) = (
            point[contact_point::NORMAL_VELOCITY],
            tangent[tangent_point::SLIDING_VELOCITY],
        );
        if v_n >= end - 1e-12 {
            break;
        }
        let held = -dot(along, d) / dot(along, e);
        let slope = if v_t.abs() > 1e-12 {
            -rod.mu * v_t.signum()
        } else if held.abs() <= rod.mu {
            held
        } else {
            rod.mu * held.signum()
        };
        let field: Vec<f64> = d.iter().zip(e).map(|(d, e)| d + slope * e).collect();
        let (rise, slip) = (dot(normal, &field), dot(along, &field));
        let stop = if v_t * slip < 0.0 {
            -v_t / slip
        } else {
            f64::INFINITY
        };
        let time = ((end - v_n) / rise).min(stop);
        senses.push(if v_t.abs() > 1e-12 {
            v_t.signum()
        } else {
            slip.signum() * f64::from(slip.abs() > 1e-12)
        });
        for (v, f) in v.iter_mut().zip(&field) {
            *v += time * f;
        }
    }
    (v, senses.contains(&1.0) && senses.contains(&-1.0))
}

#[test]
fn jump_ends_where_the_auxiliary_dynamics_by_regions_end() {
    let (mut turned, mut cases) = (0, 0);
    for k in 0..400 {
        let share = |salt: f64| (f64::from(k) * salt).fract();
        let (angle, mu, e) = (
            0.2 + 2.7 * share(0.618_034),
            0.9 * share(0.414_214),
            0.8 * share(0.732_051),
        );
        let rod = Rod {
            mu,
            e,
            ..Rod::default()
        };
        let q = [0.0, angle.sin(), angle];
        let v = [
            4.0 * share(0.236_068) - 2.0,
            -1.0 - share(0.645_751),
            6.0 * share(0.162_278) - 3.0,
        ];
        let problem = start(&q, &v, 1e-3);
        let run = time_freezing()
            .simulate(&rod, &problem, &mut |_| true)
            .unwrap();
        let Some(impact) = run
            .events
            .first()
            .filter(|event| event.kind == EventKind::Impact)
        else {
            continue;
        };
        let (expected, turns) = by_regions(&rod, &q, &v);
        cases += 1;
        let error = distance(&impact.v_after, &expected);
        turned += usize::from(turns);
        // Friction that turns round within the jump is what the published dynamics and the declared law, which knows
        // the impulse only, disagree on.
        assert_eq!(turns, error > 1e-9, "{k}: {error:e}");
    }
    assert!(cases > 300 && turned > 20, "{cases} {turned}");
}
