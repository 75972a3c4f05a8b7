//! Free final times where rest costs nothing, against closed forms: the shortest of the motions that cost the same, or no best length.

use hangtime::model::Model;
use hangtime::ocp::{ControlShape, Settings, Solution, Status};

use crate::support::attempt;

fn solve(model: &dyn Model, intervals: usize, controls: ControlShape) -> Solution {
    let mut settings = Settings::default();
    settings.controls = controls;
    attempt(model, intervals, &settings)
}

fn notes(solution: &Solution) -> &[String] {
    &solution.motion.as_ref().expect("a motion").notes
}

hangtime::model! {
    /// A block on rough ground that is pushed to where friction holds it.
    Pushed {
        parameters { rough: N = 2, way: m = 1 }
        coordinates { x: m }
        controls { u: N }
        lagrangian dot(x)^2/2*1 [kg]
        dry friction ground: bound rough, sliding dot(x)
        forces { x: u }
        minimize integral(u^2)
        finally { x == way, dot(x) == 0 [m/s], time >= 0.1 [s] }
        horizon 1 [s]
    }
}

#[test]
fn push_against_friction_takes_its_own_time_and_waits_for_nothing() {
    // The Hamiltonian vanishes at rest where the push begins: u falls from 2 F to 0 over T = sqrt(6 d m/F), and costs 4 F^2 T/3. Waiting
    // before and after it costs nothing.
    for (rough, way) in [(2.0_f64, 1.0_f64), (0.7, 3.0)] {
        let pushed = Pushed { rough, way };
        let solution = solve(&pushed, 4, ControlShape::Linear);
        let time = (6.0 * way / rough).sqrt();
        assert_eq!(solution.status, Status::Solved, "{solution}");
        let cost = 4.0 * rough * rough * time / 3.0;
        assert!((solution.objective / cost - 1.0).abs() < 1e-7, "{solution}");
        // A price of a millionth on the time moves it by as much.
        assert!((solution.horizon / time - 1.0).abs() < 1e-5, "{solution}");
        assert!(
            notes(&solution)
                .iter()
                .any(|note| note.contains("shortest"))
        );
    }
}

hangtime::model! {
    /// A cart between stops, the far one of which it has to reach.
    BetweenStops {
        coordinates { x: m }
        controls { u: N in -5..=5 }
        lagrangian dot(x)^2/2*1 [kg]
        forces { x: u }
        surface far: x <= 1 [m]
        surface near: x >= -1 [m]
        impact far, near: inelastic
        minimize integral(u^2)
        finally { x == 1 [m], dot(x) == 0 [m/s], time >= 0.1 [s] }
        horizon 2 [s]
    }
}

hangtime::model! {
    /// A cart that has to be elsewhere.
    Sent {
        coordinates { x: m }
        controls { u: N in -5..=5 }
        lagrangian dot(x)^2/2*1 [kg]
        forces { x: u }
        minimize integral(u^2)
        finally { x == 1 [m], dot(x) == 0 [m/s], time >= 0.1 [s] }
        horizon 2 [s]
    }
}

#[test]
fn motion_that_costs_less_the_longer_it_lasts_has_no_best_length() {
    // 3 d^2/T^3 up to the stop, 12 d^2/T^3 to rest: the longer the better.
    for (model, factor) in [
        (&BetweenStops::default() as &dyn Model, 3.0),
        (&Sent::default(), 12.0),
    ] {
        let solution = solve(model, 4, ControlShape::Constant);
        assert_eq!(solution.status, Status::Unbounded, "{solution}");
        let diagnosis = solution.diagnosis().expect("a diagnosis");
        assert!(
            diagnosis.contains("finally { time <= 10 [s] }"),
            "{diagnosis}"
        );
        // No optimum is claimed; but a motion it is, and one that costs less than all of half the length.
        let least = |length: f64| factor / length.powi(3);
        let (found, length) = (solution.objective, solution.horizon);
        assert!(found > least(length) * (1.0 - 1e-6), "{solution}");
        assert!(found < least(length / 2.0), "{solution}");
    }
}

hangtime::model! {
    /// A cart that has to be elsewhere within a time.
    InTime {
        parameters { late: s = 3 }
        coordinates { x: m }
        controls { u: N }
        lagrangian dot(x)^2/2*1 [kg]
        forces { x: u }
        minimize integral(u^2)
        finally { x == 1 [m], dot(x) == 0 [m/s], time <= late }
        horizon 2 [s]
    }
}

#[test]
fn motion_that_may_not_last_longer_takes_all_of_its_time() {
    // 12 d^2/T^3, by a control that is linear.
    for late in [3.0, 0.9] {
        let solution = solve(&InTime { late }, 4, ControlShape::Linear);
        assert_eq!(solution.status, Status::Solved, "{solution}");
        assert!((solution.horizon / late - 1.0).abs() < 1e-7, "{solution}");
        let least = 12.0 / late.powi(3);
        assert!(
            (solution.objective / least - 1.0).abs() < 1e-7,
            "{solution}"
        );
        assert!(
            !notes(&solution)
                .iter()
                .any(|note| note.contains("shortest"))
        );
    }
}

hangtime::model! {
    /// A body on a spring that stands on the floor, where it is to stand still.
    Standing {
        parameters { k: N/m = 100, g: m/s^2 = 10, least: s = 0.3 }
        coordinates { z: m, foot: m }
        controls { u: N }
        lagrangian (dot(z)^2 + dot(foot)^2)/2*1 [kg] - g*1 [kg]*(z + foot) - k/2*(z - foot - 1 [m])^2
        forces { z: u, foot: -u }
        surface floor: foot >= 0
        impact floor: inelastic
        minimize integral(u^2)
        finally { z == 0.9 [m], time >= least }
        start { z: 0.9 [m] }
        horizon 1 [s]
    }
}

#[test]
fn standing_still_for_nothing_lasts_as_short_as_it_may() {
    for least in [0.3, 0.85] {
        let standing = Standing {
            least,
            ..Standing::default()
        };
        let solution = solve(&standing, 4, ControlShape::Constant);
        // A short flight costs as little as one likes, so that programs of neighbours may not end.
        let found = matches!(solution.status, Status::Solved | Status::Uncertified);
        assert!(found, "{solution}");
        assert!(solution.objective < 1e-12, "{solution}");
        // A bound that a price of 1e-6 presses on is kept to the tolerance by that, 1e-9/1e-6.
        assert!((solution.horizon - least).abs() < 1e-3, "{solution}");
    }
}

hangtime::model! {
    /// A block that slides until friction stops it, as far as it is asked to.
    Sliding {
        parameters { rough: N = 0.8 }
        coordinates { x: m }
        controls { u: N in -1..=1 }
        lagrangian dot(x)^2/2*1 [kg]
        dry friction ground: bound rough, sliding dot(x)
        forces { x: u }
        minimize integral(u^2)
        finally { x >= 0.4 [m], dot(x) == 0 [m/s], time >= 0.1 [s] }
        start { dot(x): 1 [m/s] }
        horizon 4 [s]
    }
}

#[test]
fn motion_that_rests_at_its_end_for_nothing_ends_when_it_has_come_to_rest() {
    let solution = solve(&Sliding { rough: 0.55 }, 4, ControlShape::Constant);
    assert_eq!(solution.status, Status::Solved, "{solution}");
    assert!(solution.objective < 1e-9, "{solution}");
    // A push back of a hundred-thousandth would end it as much sooner for next to nothing.
    assert!((solution.horizon * 0.55 - 1.0).abs() < 1e-3, "{solution}");
}
