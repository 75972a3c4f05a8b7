//! The event-driven simulator against certified solutions and closed forms.

mod common;

use common::gold::{self, SkiJumpGold};
use common::scenes::{self, GRAVITY};
use common::{distance, energies, gap_at, index_at, last, start};
use hangtime::model::Model;
use hangtime::simulation::{
    ControlSignal, EventDriven, EventKind, InitialValueProblem, InputError, Simulation,
    SimulationStatus, Simulator,
};

fn accurate() -> EventDriven {
    EventDriven {
        tolerance: 1e-13,
        ..EventDriven::default()
    }
}

fn run(simulator: &EventDriven, model: &dyn Model, problem: &InitialValueProblem) -> Simulation {
    simulator
        .simulate(model, problem, &mut |_| {})
        .expect("the problem is accepted")
}

/// Kinds and contacts of the events, in order.
fn sequence(simulation: &Simulation) -> Vec<(EventKind, usize)> {
    simulation
        .events
        .iter()
        .map(|event| (event.kind, event.contact))
        .collect()
}

/// What holds after every run that reached the horizon.
fn check_consistency(model: &dyn Model, simulation: &Simulation) {
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let trajectory = &simulation.trajectory;
    for pair in trajectory.time.windows(2) {
        assert!(pair[0] <= pair[1]);
    }
    for (numerical, physical) in trajectory
        .numerical_time
        .windows(2)
        .zip(trajectory.time.windows(2))
    {
        // Numerical time passes at least as fast as physical time; both carry rounding error.
        assert!(numerical[1] - numerical[0] >= physical[1] - physical[0] - 1e-13);
    }
    for k in 0..trajectory.time.len() {
        for contact in 0..trajectory.contact_force[k].len() {
            let gap = gap_at(model, trajectory, contact, k);
            assert!(gap >= -1e-11, "gap {gap:e} at {}", trajectory.time[k]);
            let force = trajectory.contact_force[k][contact];
            assert!(force >= -1e-9, "force {force:e}");
            if force > 0.0 {
                assert!(gap.abs() <= 1e-12, "gap {gap:e} in contact");
            }
        }
    }
}

/// Distance of a run from the certified solution: take-off time, landing time, largest error of a state.
fn errors(simulation: &Simulation, gold: &SkiJumpGold) -> [f64; 3] {
    let events = &simulation.events;
    let first = usize::from(gold.touch.is_some());
    let (take_off, landing) = (&events[first], &events[first + 1]);
    let mut state = distance(&take_off.q, &gold.take_off.1[..2])
        .max(distance(&take_off.v_before, &gold.take_off.1[2..]))
        .max(distance(&landing.q, &gold.landing.1))
        .max(distance(&landing.v_before, &gold.landing.2))
        .max(distance(&landing.v_after, &gold.landing.3));
    for (time, exact) in &gold.states {
        let k = index_at(&simulation.trajectory, *time);
        assert!((simulation.trajectory.time[k] - time).abs() <= 1e-15);
        state = state
            .max(distance(&simulation.trajectory.q[k], &exact[..2]))
            .max(distance(&simulation.trajectory.v[k], &exact[2..]));
    }
    [
        (take_off.time - gold.take_off.0).abs(),
        (landing.time - gold.landing.0).abs(),
        state,
    ]
}

fn ski_jump(simulator: &EventDriven, gold: &SkiJumpGold) -> Simulation {
    let model = scenes::ski_jump();
    let simulator = EventDriven {
        output_times: 5,
        ..simulator.clone()
    };
    let simulation = run(&simulator, &model, &start(&gold.start, &[0.0; 2], 5.0));
    check_consistency(&model, &simulation);
    simulation
}

#[test]
fn ski_jump_from_the_table_agrees_with_certified_solution() {
    for gold in [&gold::SURFACE_START, &gold::CODE_START] {
        let simulation = ski_jump(&accurate(), gold);
        assert_eq!(
            sequence(&simulation),
            [(EventKind::LiftOff, 0), (EventKind::Impact, 1)]
        );
        // Some 80 steps at 1e-13 and amplification by the curved table (about 10) stay below 1e-11.
        let errors = errors(&simulation, gold);
        assert!(errors.iter().all(|&error| error < 1e-11), "{errors:?}");
        // The table is a quartic with terms up to 200 m: rounding alone leaves some 1e-13.
        assert!(simulation.residuals.primal <= 1e-12);
        assert!(simulation.residuals.dual <= 1e-12);
        assert!(simulation.residuals.complementarity <= 1e-11);
    }
}

#[test]
fn ski_jump_dropped_onto_the_table_agrees_with_certified_solution() {
    for gold in [&gold::DROP, &gold::CODE_DROP] {
        let simulation = ski_jump(&accurate(), gold);
        assert_eq!(
            sequence(&simulation),
            [
                (EventKind::Impact, 0),
                (EventKind::LiftOff, 0),
                (EventKind::Impact, 1)
            ]
        );
        // The touch-down is the root of z - table = 1e-3 - g t^2 / 2; the start rounds to 7e-15 m, and
        // the gap's rate there is 0.14 m/s.
        let touch = gold.touch.unwrap();
        assert!((simulation.events[0].time - touch).abs() < 1e-12);
        let errors = errors(&simulation, gold);
        assert!(errors.iter().all(|&error| error < 1e-11), "{errors:?}");
    }
}

#[test]
fn ski_jump_smaller_tolerance_gives_smaller_error() {
    let sweep: Vec<f64> = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
        .into_iter()
        .map(|tolerance| {
            let simulator = EventDriven {
                tolerance,
                ..EventDriven::default()
            };
            let [_, _, state] = errors(
                &ski_jump(&simulator, &gold::SURFACE_START),
                &gold::SURFACE_START,
            );
            // Errors per step add up, and slopes of 2 and the take-off amplify them: 1e3 is ample.
            assert!(state < 1e3 * tolerance, "{state:e} at {tolerance:e}");
            state
        })
        .collect();
    // Two decades of tolerance are worth at least one of error.
    assert!(
        sweep.windows(2).all(|pair| pair[1] < 0.1 * pair[0]),
        "{sweep:?}"
    );
}

#[test]
fn ski_jump_counts_are_those_of_the_method() {
    let simulation = ski_jump(&EventDriven::default(), &gold::SURFACE_START);
    let counts = &simulation.counts;
    insta::assert_snapshot!(
        format!("{} steps, {} evaluations", counts.elements, counts.evaluations),
        @"32 steps, 599 evaluations"
    );
}

#[test]
fn numerical_time_of_the_ski_jump_is_independent_of_the_steps() {
    // dtau = (1 + r / a_bar) dt in contact, dt in flight, |v_n| / a_bar at the landing.
    let end = |tolerance| {
        let simulation = ski_jump(
            &EventDriven {
                tolerance,
                ..EventDriven::default()
            },
            &gold::SURFACE_START,
        );
        *simulation.trajectory.numerical_time.last().unwrap()
    };
    let (coarse, fine) = (end(1e-8), end(1e-13));
    assert!((coarse - fine).abs() < 1e-6);
    assert!(fine > 5.0 && fine < 5.1);
}

#[test]
fn ball_falls_once_and_rests() {
    let model = scenes::ball();
    let simulation = run(&accurate(), &model, &start(&[0.0, 1.0], &[1.5, 0.0], 1.0));
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::Impact, 0)]);
    let event = &simulation.events[0];
    let (time, speed) = ((2.0 / GRAVITY).sqrt(), (2.0 * GRAVITY).sqrt());
    // A parabola is integrated exactly: rounding error only.
    assert!((event.time - time).abs() < 1e-15);
    assert!(distance(&event.v_before, &[1.5, -speed]) < 1e-14);
    assert_eq!(event.v_after, [1.5, 0.0]);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[1.5, 0.0]) < 1e-14);
    assert_eq!(v, [1.5, 0.0]);
    let force = simulation.trajectory.contact_force.last().unwrap()[0];
    assert!((force - 0.5 * GRAVITY).abs() < 1e-14);
    // The jump takes |v_n| / a_bar, contact runs at 1 + g / a_bar.
    let a_bar = 981.0;
    let numerical = time + speed / a_bar + (1.0 - time) * (1.0 + GRAVITY / a_bar);
    let found = simulation.trajectory.numerical_time.last().unwrap();
    assert!((found - numerical).abs() < 1e-14);
}

#[test]
fn both_sides_of_an_impact_are_in_the_trajectory() {
    let model = scenes::ball();
    let simulation = run(&accurate(), &model, &start(&[0.0, 1.0], &[0.0, 0.0], 1.0));
    let trajectory = &simulation.trajectory;
    let k = trajectory
        .time
        .windows(2)
        .position(|pair| pair[0] == pair[1])
        .unwrap();
    assert_eq!(trajectory.time[k], simulation.events[0].time);
    assert_eq!(trajectory.v[k], simulation.events[0].v_before);
    assert_eq!(trajectory.v[k + 1], simulation.events[0].v_after);
    assert_eq!(trajectory.contact_force[k], [0.0]);
    assert!(trajectory.contact_force[k + 1][0] > 0.0);
    assert!(trajectory.numerical_time[k + 1] > trajectory.numerical_time[k]);
}

#[test]
fn start_at_rest_on_the_surface_is_no_event() {
    let model = scenes::ball();
    let simulation = run(&accurate(), &model, &start(&[0.0; 2], &[2.0, 0.0], 1.0));
    check_consistency(&model, &simulation);
    assert!(simulation.events.is_empty());
    assert!(simulation.trajectory.contact_force[0][0] > 0.0);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[2.0, 0.0]) < 1e-14);
    assert_eq!(v, [2.0, 0.0]);
}

#[test]
fn start_into_the_surface_is_an_impact_at_time_zero() {
    let model = scenes::ball();
    let simulation = run(&accurate(), &model, &start(&[0.0; 2], &[2.0, -3.0], 1.0));
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::Impact, 0)]);
    let event = &simulation.events[0];
    assert_eq!(event.time, 0.0);
    assert_eq!(event.v_before, [2.0, -3.0]);
    assert_eq!(event.v_after, [2.0, 0.0]);
    assert_eq!(simulation.trajectory.v[0], [2.0, -3.0]);
    assert_eq!(simulation.trajectory.v[1], [2.0, 0.0]);
}

#[test]
fn start_on_the_surface_upwards_flies() {
    let model = scenes::ball();
    let simulation = run(&accurate(), &model, &start(&[0.0; 2], &[0.0, 3.0], 1.0));
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::Impact, 0)]);
    assert!((simulation.events[0].time - 6.0 / GRAVITY).abs() < 1e-15);
}

#[test]
fn grazing_parabola_that_misses_by_little_or_touches_is_no_impact() {
    // The crest of the wave at y = 0 under a falling parabola z = h - c y^2 with the apex at y = 0 never
    // comes close again; a mass thrown so that its path touches a crest at the apex' mirror point is
    // built from below: ground z = cos(y), path tangent to the crest y = 2 pi from above.
    let model = scenes::waves(1.0, 1.0);
    let crest = 2.0 * std::f64::consts::PI;
    // Path through (crest, 1 + miss), horizontal there, curvature -g / v^2 > -1: above the crest.
    let speed = 4.0;
    let time = 0.5;
    for miss in [1e-3, 1e-6, 1e-9, 0.0] {
        let q = [
            crest - speed * time,
            1.0 + miss - 0.5 * GRAVITY * time * time,
        ];
        let v = [speed, GRAVITY * time];
        let simulation = run(&accurate(), &model, &start(&q, &v, 2.0 * time));
        check_consistency(&model, &simulation);
        assert!(simulation.events.is_empty(), "miss {miss:e}");
    }
    for dip in [1e-3, 1e-6, 1e-9] {
        let q = [
            crest - speed * time,
            1.0 - dip - 0.5 * GRAVITY * time * time,
        ];
        let v = [speed, GRAVITY * time];
        let simulation = run(&accurate(), &model, &start(&q, &v, 2.0 * time));
        check_consistency(&model, &simulation);
        assert_eq!(simulation.events[0].kind, EventKind::Impact, "dip {dip:e}");
        // Gap = (1 - g / v^2) y^2 / 2 - dip to leading order, so the impact comes that much early.
        let early = (2.0 * dip / (1.0 - GRAVITY / (speed * speed))).sqrt() / speed;
        let error = simulation.events[0].time - (time - early);
        assert!(error.abs() < 0.1 * early, "dip {dip:e} {error:e} {early:e}");
    }
}

#[test]
fn flight_over_short_waves_hits_the_crest_it_meets_first() {
    // Twenty crests pass below within the time of a few steps of the parabola.
    let model = scenes::waves(0.05, 20.0);
    let simulation = run(&accurate(), &model, &start(&[0.0, 1.0], &[5.0, 0.0], 1.0));
    check_consistency(&model, &simulation);
    let event = &simulation.events[0];
    // First root of 1 - g t^2 / 2 - 0.05 cos(100 t), by scanning and bisecting.
    let gap = |t: f64| 1.0 - 0.5 * GRAVITY * t * t - 0.05 * (100.0 * t).cos();
    let mut high = (0..)
        .map(|k| f64::from(k) * 1e-4)
        .find(|&t| gap(t) < 0.0)
        .unwrap();
    let mut low = high - 1e-4;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if gap(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    assert!((event.time - high).abs() < 1e-14);
}

#[test]
fn pendulum_meets_the_wall_and_stays() {
    let model = scenes::pendulum(0.25);
    let simulation = run(&accurate(), &model, &start(&[-0.5], &[0.0], 4.0));
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation)[0], (EventKind::Impact, 0));
    let event = &simulation.events[0];
    // Energy: v^2 / 2 = g (cos 0.25 - cos 0.5).
    let speed = (2.0 * GRAVITY * (0.25_f64.cos() - 0.5_f64.cos())).sqrt();
    assert!(distance(&event.q, &[0.25]) < 1e-12);
    assert!(distance(&event.v_before, &[speed]) < 1e-11);
    assert!(event.v_after[0].abs() < 1e-15);
    // Gravity pulls away from the wall: an impact, then a swing back that no longer reaches it, and
    // grazes it again at full period.
    let energies = energies(&model, &simulation);
    for pair in energies.windows(2) {
        assert!(pair[1] <= pair[0] + 1e-11, "energy grows: {pair:?}");
    }
}

#[test]
fn pendulum_leaning_on_the_wall_rests() {
    let model = scenes::pendulum(-0.25);
    let simulation = run(&accurate(), &model, &start(&[-0.5], &[0.0], 3.0));
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::Impact, 0)]);
    let (q, v) = last(&simulation.trajectory);
    assert!((q[0] + 0.25).abs() < 1e-12);
    assert!(v[0].abs() < 1e-14);
    let force = simulation.trajectory.contact_force.last().unwrap()[0];
    // Torque balance about the pivot: force times lever cos(0.25) against g sin(0.25).
    assert!((force - GRAVITY * 0.25_f64.tan()).abs() < 1e-11);
}

#[test]
fn sliding_off_a_disc_takes_off_at_two_thirds_of_its_height() {
    let model = scenes::disc();
    let speed: f64 = 0.7;
    let simulation = run(&accurate(), &model, &start(&[0.0, 1.0], &[speed, 0.0], 0.9));
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::LiftOff, 0)]);
    let event = &simulation.events[0];
    // g z = v^2 on the unit disc with v^2 = speed^2 + 2 g (1 - z).
    let height = (speed * speed + 2.0 * GRAVITY) / (3.0 * GRAVITY);
    // The inverted pendulum amplifies by exp(sqrt(g) t), about 10, up to the take-off.
    assert!((event.q[1] - height).abs() < 1e-11);
    let velocity = (GRAVITY * height).sqrt();
    let across = (1.0 - height * height).sqrt();
    let exact = [velocity * height, -velocity * across];
    assert!(distance(&event.v_before, &exact) < 1e-11);
    assert_eq!(event.v_before, event.v_after);
    // After it a parabola.
    let time = 0.9 - event.time;
    let (q, _) = last(&simulation.trajectory);
    let exact = [
        event.q[0] + event.v_after[0] * time,
        event.q[1] + event.v_after[1] * time - 0.5 * GRAVITY * time * time,
    ];
    assert!(distance(q, &exact) < 1e-14);
}

#[test]
fn sliding_on_without_a_crest_never_takes_off() {
    // v_y^2 |h''| stays below g: at the top 16 / 2 < 9.81, and the slope takes over from there.
    let model = scenes::waves(0.5, 1.0);
    let simulation = run(&accurate(), &model, &start(&[0.0, 0.5], &[4.0, 0.0], 3.0));
    check_consistency(&model, &simulation);
    assert!(simulation.events.is_empty());
    assert!(simulation.residuals.primal < 1e-12);
    let energies = energies(&model, &simulation);
    let first = energies[0];
    // Frictionless and without impact: conserved to the tolerance of some hundred steps.
    assert!(energies.iter().all(|energy| (energy - first).abs() < 1e-10));
}

#[test]
fn block_in_a_corner_stops_at_the_wall_and_rests_on_both() {
    let model = scenes::corner();
    let simulation = run(&accurate(), &model, &start(&[0.0, 0.0], &[2.0, 0.0], 1.0));
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::Impact, 1)]);
    assert!((simulation.events[0].time - 0.5).abs() < 1e-15);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[1.0, 0.0]) < 1e-15);
    assert_eq!(v, [0.0, 0.0]);
}

#[test]
fn flight_into_a_corner_closes_both_gaps_at_once() {
    let model = scenes::corner();
    let time = (2.0 / GRAVITY).sqrt();
    let simulation = run(
        &accurate(),
        &model,
        &start(&[0.0, 1.0], &[1.0 / time, 0.0], 1.0),
    );
    check_consistency(&model, &simulation);
    let mut kinds = sequence(&simulation);
    kinds.sort_by_key(|&(_, contact)| contact);
    assert_eq!(kinds, [(EventKind::Impact, 0), (EventKind::Impact, 1)]);
    assert!((simulation.events[0].time - time).abs() < 1e-14);
    assert!((simulation.events[1].time - time).abs() < 1e-14);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[1.0, 0.0]) < 1e-14);
    assert_eq!(v, [0.0, 0.0]);
}

#[test]
fn dependent_normals_carry_the_weight_once() {
    let model = scenes::corner_with_double_floor();
    let simulation = run(&accurate(), &model, &start(&[0.0, 0.5], &[2.0, 0.0], 1.0));
    check_consistency(&model, &simulation);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[1.0, 0.0]) < 1e-14);
    assert!(distance(v, &[0.0, 0.0]) < 1e-14);
    let force = simulation.trajectory.contact_force.last().unwrap();
    // The second floor has gap 3 z: the weight 2 g is force 0 plus three times force 2.
    assert!((force[0] + 3.0 * force[2] - 2.0 * GRAVITY).abs() < 1e-13);
}

/// Velocities after a level bar of unit mass hits the ground with both tips at speed `speed`.
fn level_bar(front: f64, rear: f64, radius: f64) -> (Simulation, f64) {
    let model = scenes::bar(front, rear, radius);
    let height: f64 = 0.3;
    let simulation = run(
        &accurate(),
        &model,
        &start(&[0.0, height, 0.0], &[1.0, 0.0, 0.0], 0.5),
    );
    check_consistency(&model, &simulation);
    (simulation, (2.0 * height / GRAVITY).sqrt())
}

#[test]
fn level_bar_landing_on_both_tips_stops_whatever_the_sign_of_the_coupling() {
    // D_12 = 1 - front rear / radius^2: -1, 0 and 0.75.
    for radius in [0.5_f64.sqrt(), 1.0, 2.0] {
        let (simulation, time) = level_bar(1.0, 1.0, radius);
        let kinds: Vec<_> = sequence(&simulation);
        assert_eq!(kinds, [(EventKind::Impact, 0), (EventKind::Impact, 1)]);
        assert!((simulation.events[0].time - time).abs() < 1e-14);
        assert!(distance(&simulation.events[0].v_after, &[1.0, 0.0, 0.0]) < 1e-14);
        let (q, v) = last(&simulation.trajectory);
        assert!(distance(q, &[0.5, 0.0, 0.0]) < 1e-13);
        assert!(distance(v, &[1.0, 0.0, 0.0]) < 1e-13);
        assert!(simulation.notes.iter().any(|note| note.contains("Moreau")));
    }
}

#[test]
fn tip_impact_on_a_resting_tip_follows_the_sign_of_the_coupling() {
    // The rear tip rests, the front tip hits with the vertical speed w: v = (w', angular velocity).
    // Moreau: D_12 <= 0 stops both; D_12 > 0 lifts the rear tip with velocity D_12 / D_11 w.
    for (radius, lifts) in [(0.5_f64.sqrt(), false), (2.0, true)] {
        let model = scenes::bar(1.0, 1.0, radius);
        let omega = -2.0;
        // Rear tip at rest: z' + omega (-1) = 0.
        let simulation = run(
            &accurate(),
            &model,
            &start(&[0.0; 3], &[0.0, omega, omega], 0.02),
        );
        assert_eq!(simulation.status, SimulationStatus::Solved);
        let event = &simulation.events[0];
        assert_eq!(
            (event.time, event.kind, event.contact),
            (0.0, EventKind::Impact, 0)
        );
        let (d11, d12) = (1.0 + 1.0 / radius.powi(2), 1.0 - 1.0 / radius.powi(2));
        let front = event.v_after[1] + event.v_after[2];
        let rear = event.v_after[1] - event.v_after[2];
        assert!(front.abs() < 1e-14);
        let expected = if lifts { d12 / d11 * -2.0 * omega } else { 0.0 };
        assert!((rear - expected).abs() < 1e-14, "{rear} {expected}");
    }
}

#[test]
fn rocking_bar_comes_to_rest_after_ever_faster_impacts() {
    // D_12 > 0: each impact of a tip lifts the other one with D_12 / D_11 of the speed: impacts
    // accumulate geometrically until velocities are rounding error, then the bar lies still.
    let model = scenes::bar(1.0, 1.0, 2.0);
    let simulation = run(
        &EventDriven::default(),
        &model,
        &start(&[0.0, 0.1, 0.1_f64.asin()], &[0.0; 3], 3.0),
    );
    assert_eq!(simulation.status, SimulationStatus::Solved);
    let (q, v) = last(&simulation.trajectory);
    assert!(distance(q, &[0.0; 3]) < 1e-9);
    assert!(distance(v, &[0.0; 3]) < 1e-9);
    let energies = energies(&model, &simulation);
    for pair in energies.windows(2) {
        // Tolerance 1e-9 and energies of order 1.
        assert!(pair[1] <= pair[0] + 1e-9);
    }
    assert!(simulation.events.len() > 10);
}

#[test]
fn limit_on_events_ends_the_run_with_a_diagnosis() {
    let model = scenes::bar(1.0, 1.0, 2.0);
    let simulator = EventDriven {
        max_events: 8,
        ..EventDriven::default()
    };
    let simulation = run(
        &simulator,
        &model,
        &start(&[0.0, 0.1, 0.1_f64.asin()], &[0.0; 3], 3.0),
    );
    let SimulationStatus::AmbiguousContact(diagnosis) = &simulation.status else {
        panic!("{:?}", simulation.status);
    };
    assert!(
        diagnosis.message.contains("switches"),
        "{}",
        diagnosis.message
    );
    assert!(diagnosis.contact.is_some());
    assert!(diagnosis.time < 3.0);
    assert!(!simulation.trajectory.time.is_empty());
}

#[test]
fn control_jumps_lift_the_foot_and_let_it_fall() {
    // Pulled up with more than the weight from 0.2 s on, let go at 0.5 s.
    let model = scenes::hopper();
    let weight = 3.0 * GRAVITY;
    let rest = 0.5 - 2.0 * GRAVITY / scenes::STIFFNESS;
    let problem = InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: vec![0.0, 0.2, 0.5],
            values: vec![vec![0.0], vec![1.5 * weight], vec![0.0]],
        },
        ..start(&[0.0, rest], &[0.0, 0.0], 1.5)
    };
    let simulation = run(&accurate(), &model, &problem);
    check_consistency(&model, &simulation);
    assert_eq!(
        sequence(&simulation)[..2],
        [(EventKind::LiftOff, 0), (EventKind::Impact, 0)]
    );
    // The body swings as rest + amplitude (1 - cos w (t - 0.2)) with amplitude u / k, w^2 = k / 2; the
    // foot lifts where the spring pulls with its weight: k x = 3 g with x the way above rest.
    let amplitude = 1.5 * weight / scenes::STIFFNESS;
    let omega = (scenes::STIFFNESS / 2.0).sqrt();
    let way = weight / scenes::STIFFNESS;
    let expected = 0.2 + (1.0 - way / amplitude).acos() / omega;
    assert!((simulation.events[0].time - expected).abs() < 1e-12);
    for time in [0.2, 0.5] {
        let points: Vec<_> = (0..simulation.trajectory.time.len())
            .filter(|&k| simulation.trajectory.time[k] == time)
            .collect();
        assert_eq!(points.len(), 2, "both sides of the jump at {time}");
        assert_ne!(
            simulation.trajectory.u[points[0]],
            simulation.trajectory.u[points[1]]
        );
    }
}

#[test]
fn control_jump_on_the_foot_itself_releases_and_closes_the_contact_at_that_time() {
    // A ball whose control is its vertical force, at rest on the ground: jumps decide at once.
    let model = scenes::lifted_ball();
    let problem = InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: vec![0.0, 0.25, 0.5],
            values: vec![vec![0.0], vec![2.0 * GRAVITY], vec![0.0]],
        },
        ..start(&[0.0], &[0.0], 2.0)
    };
    let simulation = run(&accurate(), &model, &problem);
    check_consistency(&model, &simulation);
    assert_eq!(
        sequence(&simulation),
        [(EventKind::LiftOff, 0), (EventKind::Impact, 0)]
    );
    assert_eq!(simulation.events[0].time, 0.25);
    // Up with g for 0.25 s, then down with g: from height g/32 at speed g/4 upwards.
    let fall = 0.25 + (0.0625_f64 + 2.0 * 0.03125).sqrt();
    assert!((simulation.events[1].time - (0.5 + fall)).abs() < 1e-14);
}

#[test]
fn force_that_just_reaches_zero_and_returns_keeps_the_contact() {
    // The control force on the ball rises to exactly its weight and stays: contact without force.
    let model = scenes::lifted_ball();
    let problem = InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: vec![0.0, 0.5, 1.0],
            values: vec![vec![0.0], vec![GRAVITY], vec![0.0]],
        },
        ..start(&[0.0], &[0.0], 2.0)
    };
    let simulation = run(&accurate(), &model, &problem);
    check_consistency(&model, &simulation);
    assert!(simulation.events.is_empty(), "{:?}", simulation.events);
    assert_eq!(last(&simulation.trajectory), (&[0.0][..], &[0.0][..]));
}

#[test]
fn soft_landing_is_a_contact_without_impact() {
    // Thrust against gravity such that the ball arrives with velocity zero: z = (t - 1)^2 / 2.
    let model = scenes::lifted_ball();
    let problem = InitialValueProblem {
        controls: ControlSignal::PiecewiseConstant {
            times: vec![0.0, 1.0],
            values: vec![vec![GRAVITY + 1.0], vec![0.0]],
        },
        ..start(&[0.5], &[-1.0], 2.0)
    };
    let simulation = run(&accurate(), &model, &problem);
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::Contact, 0)]);
    assert!((simulation.events[0].time - 1.0).abs() < 1e-12);
    let (q, v) = last(&simulation.trajectory);
    assert!(q[0].abs() < 1e-12 && v[0].abs() < 1e-12);
}

#[test]
fn custom_impulse_direction_carries_impulse_and_force() {
    // The pump track's law with one mass: in contact v_y' = -h' (g + h'' v_y^2), and the impact adds
    // h' v_s- to v_y.
    let model = scenes::track_scene();
    let simulation = run(&accurate(), &model, &start(&[0.3, 0.2], &[1.0, 0.0], 1.0));
    check_consistency(&model, &simulation);
    let event = &simulation.events[0];
    assert_eq!(event.kind, EventKind::Impact);
    let slope = 0.4 * (2.0 * event.q[0]).sin();
    let expected = event.v_before[0] + slope * event.v_before[1];
    assert!((event.v_after[0] - expected).abs() < 1e-14);
    assert_eq!(event.v_after[1], 0.0);
    assert!(simulation.residuals.primal <= 1e-14);
}

#[test]
fn two_contacts_slow_the_clock_by_the_product_of_their_weights() {
    // A block pressed into the corner: p = prod (1 - s_i p) with s = (g, 3) / a_bar.
    let model = scenes::pressed_corner(3.0);
    let simulator = EventDriven {
        auxiliary_acceleration: 20.0,
        ..accurate()
    };
    let simulation = run(&simulator, &model, &start(&[1.0, 0.0], &[0.0, 0.0], 1.0));
    check_consistency(&model, &simulation);
    let (a, b) = (GRAVITY / 20.0, 3.0 / 20.0);
    // p (1 + a + b) - 1 = a b p^2: the root that tends to 1.
    let sum = 1.0 + a + b;
    let p = (sum - (sum * sum - 4.0 * a * b).sqrt()) / (2.0 * a * b);
    let end = simulation.trajectory.numerical_time.last().unwrap();
    assert!((end - 1.0 / p).abs() < 1e-13);
}

#[test]
fn field_that_ends_stops_the_run_with_its_name() {
    let model = scenes::edge();
    let simulation = run(&accurate(), &model, &start(&[0.0], &[1.0], 5.0));
    let diagnosis = simulation.status.diagnosis().unwrap();
    assert!(
        matches!(
            simulation.status,
            SimulationStatus::NotFinite(_) | SimulationStatus::StepFailed(_)
        ),
        "{:?}",
        simulation.status
    );
    assert!(diagnosis.time > 0.5 && diagnosis.time < 1.0);
    let (q, _) = last(&simulation.trajectory);
    assert!(q[0] <= 1.0);
}

#[test]
fn field_that_is_not_a_number_at_the_start_is_reported_at_once() {
    let model = scenes::edge();
    let simulation = run(&accurate(), &model, &start(&[2.0], &[1.0], 5.0));
    let SimulationStatus::NotFinite(diagnosis) = &simulation.status else {
        panic!("{:?}", simulation.status);
    };
    assert_eq!(diagnosis.time, 0.0);
    assert!(diagnosis.message.contains("`y`"), "{}", diagnosis.message);
}

#[test]
fn limit_on_steps_ends_the_run_with_a_diagnosis() {
    let simulator = EventDriven {
        max_steps: 5,
        ..accurate()
    };
    let model = scenes::ski_jump();
    let simulation = run(
        &simulator,
        &model,
        &start(&gold::SURFACE_START.start, &[0.0; 2], 5.0),
    );
    assert!(matches!(simulation.status, SimulationStatus::StepLimit(_)));
}

#[test]
fn settings_out_of_range_are_refused() {
    let model = scenes::ball();
    let problem = start(&[0.0, 1.0], &[0.0; 2], 1.0);
    for simulator in [
        EventDriven {
            tolerance: 0.0,
            ..EventDriven::default()
        },
        EventDriven {
            tolerance: f64::NAN,
            ..EventDriven::default()
        },
        EventDriven {
            tolerance: 1.0,
            ..EventDriven::default()
        },
        EventDriven {
            max_step: Some(0.0),
            ..EventDriven::default()
        },
        EventDriven {
            max_step: Some(f64::NAN),
            ..EventDriven::default()
        },
        EventDriven {
            auxiliary_acceleration: 0.0,
            ..EventDriven::default()
        },
        EventDriven {
            max_steps: 0,
            ..EventDriven::default()
        },
    ] {
        let error = simulator
            .simulate(&model, &problem, &mut |_| {})
            .unwrap_err();
        assert!(
            matches!(error, InputError::OutOfRange { .. }),
            "{simulator:?}"
        );
    }
}

#[test]
fn progress_reports_the_times_of_accepted_steps() {
    let model = scenes::ball();
    let mut times = Vec::new();
    let simulation = EventDriven::default()
        .simulate(&model, &start(&[0.0, 1.0], &[0.0; 2], 1.0), &mut |t| {
            times.push(t)
        })
        .unwrap();
    assert_eq!(simulation.status, SimulationStatus::Solved);
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(times.last(), Some(&1.0));
}
