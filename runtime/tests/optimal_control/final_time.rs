//! Final times far from the guess, problems without an optimum, and goals that the motion without controls reaches.

use crate::support::one_start;
use hangtime::model::Model;
use hangtime::ocp::{self, Formulation, Guess, Problem, Settings, Solution, Status};
use hangtime::ocp::{ControlShape, TimeFreezingSettings};

fn solve(model: &dyn Model, settings: &Settings) -> Solution {
    ocp::solve(model, &Problem::of(model, 6), settings, &mut |_| true).expect("a good problem")
}

hangtime::model! {
    /// A cart that is pushed from rest over a line.
    Cart {
        parameters { m: kg = 3, far: m = 2 }
        coordinates { y: m }
        controls { u: N in -1..=1.5 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize time
        finally { y == far }
    }
}

#[test]
fn least_time_is_found_however_far_it_is_from_the_guess() {
    // Pushed all the way, 1.5 t^2 / 2 / 3 = y: the guess is 1 s.
    for far in [4e-4, 2.0, 900.0, 4e4] {
        let cart = Cart {
            far,
            ..Cart::default()
        };
        let time = (4.0 * far).sqrt();
        for controls in [ControlShape::Constant, ControlShape::Linear] {
            let mut settings = one_start();
            settings.controls = controls;
            settings.largest_distance *= far.max(1.0);
            let solution = solve(&cart, &settings);
            assert_eq!(
                solution.status,
                Status::Solved,
                "{far}: {:?}",
                solution.diagnosis()
            );
            // The goal is met to 1e-9 m, and the time goes with its root.
            assert!(
                (solution.horizon / time - 1.0).abs() < 2e-6,
                "{far}: {} against {time}",
                solution.horizon
            );
            let (shortest, longest) = solution.final_times;
            assert!(shortest < time && time < longest, "{shortest} {longest}");
        }
    }
}

#[test]
fn guess_of_the_final_time_does_not_decide_about_the_optimum() {
    let cart = Cart::default();
    let time = 8.0_f64.sqrt();
    for guess in [0.02, 70.0, 400.0] {
        let mut problem = Problem::of(&cart, 6);
        problem.horizon = ocp::Horizon::Free { guess: Some(guess) };
        for formulation in [
            Formulation::Phases,
            Formulation::TimeFreezing(TimeFreezingSettings::default()),
        ] {
            let mut settings = one_start();
            settings.formulation = formulation;
            let solution = ocp::solve(&cart, &problem, &settings, &mut |_| true).unwrap();
            assert_eq!(
                solution.status,
                Status::Solved,
                "{guess}: {:?}",
                solution.diagnosis()
            );
            assert!(
                (solution.horizon - time).abs() < 1e-6,
                "{guess}: {}",
                solution.horizon
            );
        }
    }
}

#[test]
fn previous_motion_of_quite_another_length_is_a_start_as_well() {
    let near = Cart {
        far: 1e-3,
        ..Cart::default()
    };
    let mut settings = one_start();
    let previous = solve(&near, &settings).previous.unwrap();
    settings.guess = Guess::Previous(Box::new(previous));
    let solution = solve(&Cart::default(), &settings);
    assert!((solution.horizon - 8.0_f64.sqrt()).abs() < 1e-6);
}

hangtime::model! {
    /// A cart that is to take as long as it can.
    Idler {
        parameters { m: kg = 3 }
        coordinates { y: m }
        controls { u: N in -1..=1 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize -time
        finally { y >= -1[m] }
    }
}

hangtime::model! {
    /// A cart that is pushed as hard as one likes.
    Rocket {
        parameters { m: kg = 3 }
        coordinates { y: m }
        controls { u: N }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize time
        finally { y == 2[m], dot(y) == 0[m/s] }
    }
}

#[test]
fn problem_without_an_optimum_is_called_unbounded() {
    for model in [&Idler::default() as &dyn Model, &Rocket::default()] {
        let solution = solve(model, &one_start());
        let name = model.declaration().name;
        assert_eq!(solution.status, Status::Unbounded, "{name}");
        assert_eq!(solution.status.name(), "unbounded");
        let diagnosis = solution.diagnosis().unwrap();
        assert!(diagnosis.contains("bound the controls"), "{diagnosis}");
        // The range was moved by at least a factor of twenty.
        let (shortest, longest) = solution.final_times;
        assert!(longest / shortest > 1e3, "{shortest} {longest}");
    }
}

#[test]
fn least_time_without_an_end_is_told_by_the_first_start_on_the_first_grid() {
    let rocket = Rocket::default();
    let problem = Problem::of(&rocket, 30);
    let solve = |settings: &Settings| ocp::solve(&rocket, &problem, settings, &mut |_| true);
    let solution = solve(&Settings::default()).unwrap();
    assert_eq!(solution.status, Status::Unbounded);
    // Other starts and finer grids cannot beat it by more than its own final time.
    assert!(solution.horizon < 1e-3);
    assert!(solution.optima.iter().all(|optimum| optimum.starts == [0]));
    assert_eq!(solution.controls.len(), 30);
    // 16 starts and the grids with 10, 15 and 30 intervals took 1700 programs.
    assert!(
        solution.counts.programs < 150,
        "{}",
        solution.counts.programs
    );
}

hangtime::model! {
    /// A cart at rest that nothing moves, which is to be elsewhere.
    Parked {
        parameters { m: kg = 3 }
        coordinates { y: m }
        lagrangian m/2*dot(y)^2
        finally { y == 2[m] }
        horizon 1 [s]
    }
}

#[test]
fn goal_of_a_motion_without_controls_is_infeasible_by_its_distance() {
    let parked = Parked::default();
    let problem = Problem::of(&parked, 30);
    let solution = ocp::solve(&parked, &problem, &Settings::default(), &mut |_| true).unwrap();
    assert_eq!(solution.status, Status::Infeasible);
    let worst = &solution.violations[0];
    assert!((worst.amount - 2.0).abs() < 1e-6, "{worst:?}");
    let diagnosis = solution.diagnosis().unwrap();
    assert!(
        diagnosis.contains("with a final time of 1.000 s"),
        "{diagnosis}"
    );
}

#[test]
fn goal_beyond_the_bounds_is_infeasible_with_the_final_times_that_were_looked_at() {
    let cart = Walled::default();
    let solution = solve(&cart, &one_start());
    assert_eq!(solution.status, Status::Infeasible);
    let diagnosis = solution.diagnosis().unwrap();
    assert!(diagnosis.contains("with final times from"), "{diagnosis}");
}

hangtime::model! {
    /// A cart that has less time than full force back and forth takes, `2 sqrt(m d / u) = 2 s`.
    Late {
        parameters { m: kg = 1, late: s = 1.8 }
        coordinates { y: m }
        controls { u: N in -1..=1 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize integral(u^2)
        finally { y == 1 [m], dot(y) == 0, time <= late, time >= 0.5 [s] }
        start { y: 0 [m] }
        horizon 1.5 [s]
    }
}

#[test]
fn too_short_a_time_is_said_with_the_times_that_goals_allow_and_what_is_missed() {
    let late = Late::default();
    let solution = solve(&late, &one_start());
    assert_eq!(solution.status, Status::NotFound);
    let (shortest, longest) = solution.final_times;
    assert!((shortest - 0.5).abs() < 1e-12 && (longest - 1.8).abs() < 1e-12);
    let diagnosis = solution.diagnosis().unwrap();
    assert!(
        diagnosis.contains("final times from 0.500 to 1.800 s"),
        "{diagnosis}"
    );
    let nearest = solution.nearest.as_ref().unwrap();
    // Each of place, velocity and time can be met alone, but not all of them together.
    assert!(!nearest.misses.is_empty());
    let miss = |name: &str| {
        let found = nearest.misses.iter().find(|miss| miss.name == name);
        found.map_or(0.0, |miss| miss.amount)
    };
    // Within `T` full force comes no further than `T^2 / 4` to rest; with a speed of `v` left no further than `T^2/4 + v T/2 - v^2/4`.
    let (time, speed) = (1.8 + miss("time <= late"), miss("dot(y) == 0"));
    let farthest = time * time / 4.0 + speed * time / 2.0 - speed * speed / 4.0;
    // Up to a thousandth of what most motions miss counts as met.
    assert!(1.0 - miss("y == 1 [m]") <= farthest + 1e-3, "{nearest:?}");
}

hangtime::model! {
    /// A cart that is to be where its bounds do not let it go.
    Walled {
        parameters { m: kg = 3 }
        coordinates { y: m in -1..=1 }
        controls { u: N in -1..=1 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        minimize time
        finally { y == 1.5[m] }
    }
}

hangtime::model! {
    /// A bike whose rider pushes against it, on waves; what the rider can do is a parameter.
    Waves {
        parameters {
            m_b: kg = 9, m_r: kg = 60, g: m/s^2 = 14, a: m = 0.2, k: 1/m = 3.4, speed: km/h = 23,
            low: m = 0.3, high: m = 0.5, pull: N = -108, push: N = 380, far: m = 5,
        }
        coordinates { y: m, s: m, l: m in low..=high }
        controls { u: N in pull..=push }
        fn track(y) = a*(1 - cos(k*y))
        let bike = (y, track(y) + s)
        let rider = (y, track(y) + s + l)
        lagrangian m_b/2*|dot(bike)|^2 + m_r/2*|dot(rider)|^2 - m_b*g*bike.z - m_r*g*rider.z
        forces { l: u }
        surface ground: s >= 0
        impact ground: inelastic, along (-diff(track)(y), 1, 0)
        minimize time
        finally { y == far }
        start { l: (low + high)/2, dot(y): speed }
        horizon 2 [s]
    }
}

/// When the ride without controls is at the goal [s], if it gets there within two seconds.
fn coasting(model: &Waves) -> Option<f64> {
    let run = hangtime::simulate(model).run().expect("a good problem");
    let place = |time: f64| run.at(time).expect("before the end")["y"];
    let (mut before, mut after) = (0.0, 2.0);
    if place(after) < model.far {
        return None;
    }
    while after - before > 1e-9 {
        let middle = (before + after) / 2.0;
        if place(middle) < model.far {
            before = middle;
        } else {
            after = middle;
        }
    }
    Some(after)
}

#[test]
fn goal_that_the_ride_without_controls_reaches_is_never_called_infeasible() {
    // The link keeps its length without controls, whatever its bounds are; fast bikes fly from wave to wave.
    let mut flights = 0;
    for (k, speed, g, low, high, push, intervals) in [
        (3.1, 29.5, 19.0, 0.30, 0.31, 20.0, 6),
        (2.4, 31.0, 12.0, 0.35, 0.40, 250.0, 7),
    ] {
        let model = Waves {
            speed,
            k,
            g,
            low,
            high,
            pull: -0.8 * push,
            push,
            ..Waves::default()
        };
        let ride = coasting(&model).expect("fast enough");
        let jumps = hangtime::simulate(&model).run().unwrap().events.len();
        flights += usize::from(jumps > 0);
        let problem = Problem::of(&model, intervals);
        let solution = ocp::solve(&model, &problem, &one_start(), &mut |_| true).unwrap();
        let (status, diagnosis) = (solution.status, solution.diagnosis());
        assert!(solution.motion.is_some(), "{k}: {status:?} {diagnosis:?}");
        // The ride is one of the motions to choose from.
        assert!(
            solution.objective < ride + 1e-4,
            "{k}: {status:?} {} against {ride}",
            solution.objective
        );
    }
    assert_eq!(flights, 2);
}
