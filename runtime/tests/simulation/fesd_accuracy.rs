//! What the default simulation promises, and where it says that it cannot: accuracy, scales of gaps, cascades
//! of impacts, and what is not a number.

#![allow(clippy::unwrap_used, reason = "test code")]

use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    EventDriven, EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
    StepFormulation,
};

hangtime::model! {
    /// A mass on a spring, away from a wall that it never reaches.
    pub Oscillator {
        parameters { m: kg = 2, k: N/m = 50, start_x: m = 0.3 }
        coordinates { x: m }
        lagrangian m/2*dot(x)^2 - k/2*x^2
        surface wall: x + 1[m] >= 0
        impact wall: inelastic
        start { x: start_x }
        horizon 20 [s]
    }
}

hangtime::model! {
    /// Two balls on a stiff spring fall on a floor and bounce.
    pub SpringPair {
        parameters { m_1: kg = 0.9, m_2: kg = 2.3, k: N/m = 26000, g: m/s^2 = 9.81, e = 0.6 }
        coordinates { z_1: m, z_2: m }
        lagrangian m_1/2*dot(z_1)^2 + m_2/2*dot(z_2)^2 - g*(m_1*z_1 + m_2*z_2) - k/2*(z_2 - z_1 - 0.7[m])^2
        surface floor: z_1 >= 0
        impact floor: restitution e
        start { z_1: 0.4 [m], z_2: 1.1 [m] }
        horizon 0.8 [s]
    }
}

hangtime::model! {
    /// A ball over a floor whose gap is measured in its own unit, far from the origin.
    pub FarBall {
        parameters { m: kg = 1, g: m/s^2 = 9.81, factor = 1, x0: m = 0, height: m = 0.0002 }
        coordinates { x: m, z: m }
        lagrangian m/2*|dot((x, z))|^2 - m*g*z
        surface floor: factor*z >= 0
        impact floor: inelastic
        start { x: x0, z: height }
    }
}

hangtime::model! {
    /// A mass on a cosine track somewhere in the plane.
    pub MovedTrack {
        parameters { m: kg = 1, a: m = 0.3, k: 1/m = 1.3, g: m/s^2 = 9.81, v: m/s = 5, x0: m = 0, z0: m = 0 }
        coordinates { x: m, z: m }
        fn track(x) = a*cos(k*(x - x0)) + z0
        lagrangian m/2*|dot((x, z))|^2 - m*g*z
        surface track: z - track(x) >= 0
        impact track: inelastic
        start { x: x0, z: z0 + a, dot(x): v }
        horizon 2.5 [s]
    }
}

hangtime::model! {
    /// A ball that bounces to rest.
    pub Bouncing {
        parameters { m: kg = 1, g: m/s^2 = 8, e = 0.97, height: m = 0.5 }
        coordinates { z: m }
        lagrangian m/2*dot(z)^2 - m*g*z
        surface floor: z >= 0
        impact floor: restitution e
        start { z: height }
    }
}

hangtime::model! {
    /// A block that slides to rest.
    pub Sliding {
        parameters { m: kg = 3, g: m/s^2 = 2, mu = 0.5, v: m/s = 0.4 }
        coordinates { x: m, z: m }
        lagrangian m/2*|dot((x, z))|^2 - m*g*z
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        start { dot(x): v }
        horizon 1.6 [s]
    }
}

hangtime::model! {
    /// Three bodies on a line above a floor.
    pub Column {
        parameters { m_1: kg = 1, m_2: kg = 1, m_3: kg = 1, g: m/s^2 = 10, e_0 = 0, e_1 = 0, e_2 = 0, h: m = 0.4, v_3: m/s = -1.5 }
        coordinates { z_1: m, z_2: m, z_3: m }
        lagrangian m_1/2*dot(z_1)^2 + m_2/2*dot(z_2)^2 + m_3/2*dot(z_3)^2 - g*(m_1*z_1 + m_2*z_2 + m_3*z_3)
        surface floor: z_1 >= 0
        surface lower: z_2 - z_1 >= 0
        surface upper: z_3 - z_2 >= 0
        impact floor: restitution e_0
        impact lower: restitution e_1
        impact upper: restitution e_2
        start { z_1: h, z_2: 1.7*h, z_3: 2.6*h, dot(z_3): v_3 }
        horizon 2 [s]
    }
}

hangtime::model! {
    /// A ball in flight over ground that ends at x = 1 m.
    pub EndOfGround {
        parameters { m: kg = 1, g: m/s^2 = 9.81, v: m/s = 1.7 }
        coordinates { x: m, z: m }
        lagrangian m/2*|dot((x, z))|^2 - m*g*z
        surface ground: z + sqrt((1[m] - x)*1[m]) >= 0
        impact ground: inelastic
        start { z: 9 [m], dot(x): v }
        horizon 1.2 [s]
    }
}

hangtime::model! {
    /// A rod that is pushed along rough ground, tip ahead.
    pub PushedRod {
        parameters { m: kg = 2, l: m = 1.2, j: kg m^2 = 0.06, g: m/s^2 = 9.81, mu = 1.4, theta0: rad = 1.1, vx: m/s = -8 }
        coordinates { x: m, z: m, theta: rad }
        let tip = (x - l/2*cos(theta), z - l/2*sin(theta))
        lagrangian m/2*(dot(x)^2 + dot(z)^2) + j/2*dot(theta)^2 - m*g*z
        surface ground: tip.z >= 0
        impact ground: inelastic, friction mu, sliding dot(tip.y)
        start { z: l/2*sin(theta0), theta: theta0, dot(x): vx }
        horizon 1 [s]
    }
}

fn run(simulator: &dyn Simulator, model: &dyn Model, horizon: Option<f64>) -> Simulation {
    let problem = InitialValueProblem::of(model, horizon).unwrap();
    simulator.simulate(model, &problem, &mut |_| true).unwrap()
}

fn solved(simulator: &dyn Simulator, model: &dyn Model, horizon: Option<f64>) -> Simulation {
    let simulation = run(simulator, model, horizon);
    assert_eq!(simulation.status, SimulationStatus::Solved);
    simulation
}

fn end(simulation: &Simulation) -> (&[f64], &[f64]) {
    let trajectory = &simulation.trajectory;
    (trajectory.q.last().unwrap(), trajectory.v.last().unwrap())
}

fn names(simulation: &Simulation) -> Vec<&str> {
    let kinds = simulation.events.iter().map(|event| event.kind.name());
    kinds.collect()
}

#[test]
fn default_on_a_stiff_spring_keeps_its_promise() {
    let model = SpringPair::default();
    let found = solved(&Fesd::default(), &model, None);
    let exact = EventDriven {
        tolerance: 1e-13,
        ..EventDriven::default()
    };
    let exact = solved(&exact, &model, None);
    let ((q, v), (q_exact, v_exact)) = (end(&found), end(&exact));
    // The promise: 1e-6 of the largest distance, about 1 m, and velocity, about 4 m/s.
    for (found, exact) in q.iter().zip(q_exact) {
        assert!((found - exact).abs() < 1e-6, "{found} {exact}");
    }
    for (found, exact) in v.iter().zip(v_exact) {
        assert!((found - exact).abs() < 4e-6, "{found} {exact}");
    }
    assert!(found.error_estimate.unwrap() <= 1e-6);
}

#[test]
fn tolerance_of_an_oscillation_is_kept_at_every_recorded_instant() {
    let model = Oscillator::default();
    let rate = (model.k / model.m).sqrt();
    for tolerance in [1e-4, 1e-7, 1e-10] {
        let simulator = Fesd::default().with_tolerance(tolerance);
        let simulation = solved(&simulator, &model, None);
        let trajectory = &simulation.trajectory;
        for ((time, q), v) in trajectory.time.iter().zip(&trajectory.q).zip(&trajectory.v) {
            let (x, dx) = (
                model.start_x * (rate * time).cos(),
                -rate * model.start_x * (rate * time).sin(),
            );
            // Distances from the start reach twice the amplitude.
            let error = (q[0] - x).abs().max((v[0] - dx).abs() / rate);
            assert!(
                error <= 2.0 * tolerance * model.start_x,
                "{time}: {error:e}"
            );
        }
    }
}

#[test]
fn coarse_grid_of_an_oscillation_reports_its_error_and_says_so() {
    let model = Oscillator::default();
    let rate = (model.k / model.m).sqrt();
    let exact = model.start_x * (rate * 20.0).cos();
    for (stages, steps) in [(1, 200), (2, 70), (3, 30)] {
        let simulator = Fesd::default()
            .with_scheme(Scheme::RadauIia, stages)
            .with_grid(steps, 1);
        let simulation = solved(&simulator, &model, None);
        let error = (end(&simulation).0[0] - exact).abs() / (2.0 * model.start_x);
        let estimate = simulation.error_estimate.unwrap();
        assert!(error > 1e-2, "{stages}: {error:e}");
        assert!(estimate > 0.3 * error, "{stages}: {estimate:e} {error:e}");
        assert!(
            simulation
                .notes
                .iter()
                .any(|note| note.contains("take more steps"))
        );
    }
}

#[test]
fn ball_above_a_floor_is_not_moved_onto_it_wherever_it_is_and_whatever_the_unit_of_its_gap() {
    for (x0, factor) in [(0.0, 1.0), (4e5, 1.0), (-3e7, 1.0), (0.0, 1e-8), (4e5, 1e7)] {
        let model = FarBall {
            x0,
            factor,
            ..FarBall::default()
        };
        let horizon = 0.6 * (2.0 * model.height / model.g).sqrt();
        for simulator in [Fesd::default(), Fesd::default().with_grid(20, 2)] {
            let simulation = solved(&simulator, &model, Some(horizon));
            let height = model.height * (1.0 - 0.36);
            // Rounding of numbers of the size of the height.
            assert!(
                (end(&simulation).0[1] - height).abs() < 1e-15,
                "{x0} {factor}"
            );
            assert!(simulation.events.is_empty());
        }
    }
}

#[test]
fn start_inside_the_floor_is_refused_far_from_the_origin() {
    let model = FarBall {
        x0: 3e5,
        ..FarBall::default()
    };
    let mut problem = InitialValueProblem::of(&model, Some(0.1)).unwrap();
    problem.q[1] = -2e-5;
    let refused = Fesd::default().simulate(&model, &problem, &mut |_| true);
    assert!(refused.unwrap_err().to_string().contains("E08"));
}

#[test]
fn ride_over_waves_takes_the_same_work_wherever_the_track_is() {
    let here = solved(&Fesd::default(), &MovedTrack::default(), None);
    assert!(here.events.len() > 2);
    for (x0, z0) in [(3e4, 0.0), (0.0, 2e5), (2e5, 3e5)] {
        let model = MovedTrack {
            x0,
            z0,
            ..MovedTrack::default()
        };
        let there = solved(&Fesd::default(), &model, None);
        assert_eq!(names(&there), names(&here));
        let distance = (end(&there).0[0] - x0) - end(&here).0[0];
        // Rounding of coordinates of 3e5 m is 6e-11 m; take-offs and landings enlarge it.
        assert!(distance.abs() < 1e-6, "{x0} {z0}: {distance:e}");
        assert_eq!(there.counts.fallbacks, 0);
        assert!(
            there.counts.newton < 2 * here.counts.newton,
            "{} {}",
            there.counts.newton,
            here.counts.newton
        );
    }
}

#[test]
fn ball_that_keeps_almost_all_its_speed_comes_to_rest_at_the_limit_of_its_bounces() {
    for e in [0.95, 0.97, 0.985] {
        let model = Bouncing {
            e,
            ..Bouncing::default()
        };
        let rest = (2.0 * model.height / model.g).sqrt() * (1.0 + e) / (1.0 - e);
        for simulator in [Fesd::default(), Fesd::default().with_grid(60, 1)] {
            let simulation = solved(&simulator, &model, Some(1.1 * rest));
            let last = simulation.events.last().unwrap();
            // Bounces that are left out take 2 e v / g / (1 - e) together, v the rest velocity of 3e-6 m/s.
            let left_out = 2.0 * e * 3e-6 / model.g / (1.0 - e);
            assert!(
                (rest - last.time).abs() < 2.0 * left_out,
                "{e}: {} {rest}",
                last.time
            );
            assert!(end(&simulation).0[0].abs() < 1e-12);
        }
    }
}

#[test]
fn ball_that_bounces_too_often_is_told_to_raise_the_rest_velocity() {
    let model = Bouncing {
        e: 0.9995,
        ..Bouncing::default()
    };
    let rest = (2.0 * model.height / model.g).sqrt() * (1.0 + model.e) / (1.0 - model.e);
    let limited = Fesd {
        most_events: 5_000,
        ..Fesd::default().with_grid(60, 1)
    };
    let simulation = run(&limited, &model, Some(1.1 * rest));
    let diagnosis = simulation.status.diagnosis().unwrap();
    assert_eq!(simulation.status.name(), "event_limit");
    assert!(
        diagnosis.message.contains("raise the rest velocity"),
        "{}",
        diagnosis.message
    );
    assert_eq!(diagnosis.contact, Some(0));
    // Without the limit it comes to rest, where the closed form says.
    let simulation = run(&Fesd::default().with_grid(60, 1), &model, Some(1.1 * rest));
    assert!(simulation.status.is_solved(), "{}", simulation.status);
    assert!(simulation.events.len() > 5_000);
    let last = simulation.events.last().unwrap().time;
    assert!((last / rest - 1.0).abs() < 1e-3, "{last} {rest}");
}

#[test]
fn block_that_stops_at_the_end_of_a_step_sticks_without_a_fallback() {
    let model = Sliding::default();
    let stop = model.v / (model.mu * model.g);
    // 0.4 s of 1.6 s: the end of the fifteenth of sixty steps, the eighth of 32.
    for simulator in [
        Fesd::default().with_grid(60, 3),
        Fesd::default().with_grid(32, 1),
        Fesd::default(),
        Fesd::default().with_grid(4, 1).with_tolerance(1e-8),
    ] {
        let simulation = solved(&simulator, &model, None);
        assert_eq!(simulation.counts.fallbacks, 0, "{simulator:?}");
        assert_eq!(names(&simulation), ["stick"], "{simulator:?}");
        assert!((simulation.events[0].time - stop).abs() < 1e-12);
    }
}

#[test]
fn three_bodies_that_collapse_on_the_floor_gain_no_energy_and_rest() {
    let columns = [
        Column {
            m_1: 0.3,
            m_2: 0.2,
            m_3: 2.5,
            e_0: 0.9,
            e_1: 0.4,
            e_2: 0.2,
            ..Column::default()
        },
        Column {
            m_1: 0.2,
            m_2: 4.0,
            m_3: 3.0,
            e_0: 0.5,
            e_1: 0.6,
            e_2: 0.5,
            ..Column::default()
        },
        Column {
            m_1: 1e-5,
            m_2: 1.0,
            m_3: 1e5,
            ..Column::default()
        },
    ];
    for model in columns {
        let energy = |q: &[f64], v: &[f64]| {
            [model.m_1, model.m_2, model.m_3]
                .iter()
                .zip(q.iter().zip(v))
                .map(|(m, (q, v))| m * (0.5 * v * v + model.g * q))
                .sum::<f64>()
        };
        let simulation = solved(&Fesd::default().with_grid(60, 3), &model, None);
        let trajectory = &simulation.trajectory;
        let mut before = energy(&trajectory.q[0], &trajectory.v[0]);
        let first = before;
        for (q, v) in trajectory.q.iter().zip(&trajectory.v) {
            let now = energy(q, v);
            // Rounding of the sum; flights are parabolas.
            assert!(now <= before + 1e-10 * first, "{now} after {before}");
            before = now;
        }
        // All of it is gone within two seconds: the last bounces are slower than the rest velocity.
        let (q, v) = end(&simulation);
        assert!(
            q.iter().chain(v).all(|value| value.abs() < 1e-5),
            "{q:?} {v:?}"
        );
    }
}

#[test]
fn gap_that_becomes_no_number_ends_the_run_by_name() {
    let model = EndOfGround::default();
    for simulator in [Fesd::default(), Fesd::default().with_grid(30, 2)] {
        let simulation = run(&simulator, &model, None);
        assert_eq!(
            simulation.status.name(),
            "not_finite",
            "{:?}",
            simulation.status
        );
        let reached = simulation.status.diagnosis().unwrap().time;
        // At x = 1 m, where the root ends, up to the shortest element that was tried.
        assert!((reached - 1.0 / model.v).abs() < 1e-3, "{reached}");
    }
}

#[test]
fn run_that_jams_at_its_start_keeps_the_start_and_names_the_contact() {
    let model = PushedRod::default();
    let simulation = run(&Fesd::default(), &model, None);
    let diagnosis = simulation.status.diagnosis().unwrap();
    assert_eq!(simulation.status.name(), "ambiguous_contact");
    assert_eq!(simulation.trajectory.time, [0.0]);
    assert_eq!(diagnosis.contact, Some(0));
    assert!(
        diagnosis.message.contains("touching ground"),
        "{}",
        diagnosis.message
    );
}

#[test]
fn time_freezing_program_estimates_its_error_by_the_length_of_its_elements() {
    // A fall on a floor, which keeps the horizontal motion: its time is all that can be wrong.
    let model = Sliding {
        mu: 0.2,
        v: 1.5,
        ..Sliding::default()
    };
    let mut problem = InitialValueProblem::of(&model, Some(0.9)).unwrap();
    problem.q[1] = 0.3;
    let end_of = |simulator: &Fesd| {
        let simulation = simulator.simulate(&model, &problem, &mut |_| true).unwrap();
        assert_eq!(simulation.status, SimulationStatus::Solved);
        simulation
    };
    let exact = end_of(&Fesd::default().with_tolerance(1e-9));
    let found = end_of(
        &Fesd::default()
            .with_grid(8, 3)
            .with_formulation(StepFormulation::Complementarity),
    );
    let error = (end(&found).0[0] - end(&exact).0[0]).abs() / end(&exact).0[0];
    let estimate = found.error_estimate.unwrap();
    assert!(
        estimate >= error && estimate > 1e-3,
        "{estimate:e} {error:e}"
    );
    assert!(
        found
            .notes
            .iter()
            .any(|note| note.contains("of the largest values"))
    );
}

#[test]
fn horizon_of_many_years_does_not_hide_an_impact() {
    let model = FarBall {
        height: 1.0,
        ..FarBall::default()
    };
    let simulation = run(&Fesd::default(), &model, Some(3e9));
    let impacts = simulation.events.iter();
    assert_eq!(
        impacts
            .filter(|event| event.kind == EventKind::Impact)
            .count(),
        1
    );
}
