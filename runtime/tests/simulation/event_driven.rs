//! The event-driven simulator against certified solutions and closed forms.

use crate::common::event::{accurate, check_consistency, run, sequence};
use crate::common::gold::{self, SkiJumpGold};
use crate::common::scenes::{self, GRAVITY};
use crate::common::{distance, energies, index_at, last, root, start};
use hangtime::simulation::{EventDriven, EventKind, Simulation, SimulationStatus, Simulator};

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
    for gold in [&gold::SURFACE_START, &gold::CODE_START, &gold::FIFTY_METRES] {
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
        @"30 steps, 1086 evaluations"
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
fn tossed_ball_falls_once_and_rests_as_certified() {
    // `bouncing_ball_inelastic`, closed form, 20 digits: case toss_0.5m_2mps.
    let model = scenes::ball();
    let simulator = EventDriven {
        output_times: 8,
        ..accurate()
    };
    let simulation = run(&simulator, &model, &start(&[0.0, 0.5], &[0.0, 2.0], 2.0));
    check_consistency(&model, &simulation);
    assert_eq!(sequence(&simulation), [(EventKind::Impact, 0)]);
    let event = &simulation.events[0];
    // A parabola is integrated exactly: rounding error only.
    assert!((event.time - 0.582_689_177_901_366_9).abs() < 1e-15);
    assert!((event.v_before[1] + 3.716_180_835_212_409_4).abs() < 1e-14);
    for (time, z, v_z) in [
        (0.25, 0.6934375, -0.4525),
        (0.5, 0.27375, -2.905),
        (1.0, 0.0, 0.0),
        (2.0, 0.0, 0.0),
    ] {
        let k = index_at(&simulation.trajectory, time);
        assert!((simulation.trajectory.q[k][1] - z).abs() < 1e-14);
        assert!((simulation.trajectory.v[k][1] - v_z).abs() < 1e-14);
    }
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
    let mut times = (0..).map(|k| f64::from(k) * 1e-4);
    let after = times.find(|&t| gap(t) < 0.0).unwrap();
    let struck = root(gap, after - 1e-4, after);
    assert!((event.time - struck).abs() < 1e-14);
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
            .simulate(&model, &problem, &mut |_| true)
            .unwrap_err();
        assert!(
            error.to_string().contains("must be"),
            "{simulator:?}: {error}"
        );
    }
}

#[test]
fn progress_reports_the_times_of_accepted_steps() {
    let model = scenes::ball();
    let mut times = Vec::new();
    let simulation = EventDriven::default()
        .simulate(&model, &start(&[0.0, 1.0], &[0.0; 2], 1.0), &mut |now| {
            times.push(now.time);
            true
        })
        .unwrap();
    assert_eq!(simulation.status, SimulationStatus::Solved);
    // A run to compare with may be stopped as well, but time does not pass in it.
    assert_eq!(times.first(), Some(&0.0));
    times.dedup();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(times.last(), Some(&1.0));
}
