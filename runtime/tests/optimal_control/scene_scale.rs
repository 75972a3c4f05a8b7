//! The same scene over lengths, masses and times from 1e-9 to 1e9: the same status, the same optimum, the same words.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use hangtime::ocp::{self, Problem, Settings, Status};

hangtime::model! {
    /// A cart that is pushed to a place with least effort, by up to four times what constant acceleration asks for.
    Pushed {
        parameters { m: kg = 1, far: m = 1, duration: s = 2 }
        coordinates { x: m }
        controls { u in -1..=1 }
        lagrangian m/2*dot(x)^2
        forces { x: 4*m*far/duration^2*u }
        minimize integral(u^2)
        finally { x == far }
        horizon duration
    }
}

hangtime::model! {
    /// A cart that is pushed in least time to a place in front of a wall.
    Stopped {
        parameters { m: kg = 1, far: m = 1, push: N = 1, share = 0.95 }
        coordinates { x: m }
        controls { u in -1..=1 }
        lagrangian m/2*dot(x)^2
        forces { x: push*u }
        surface wall: x <= far
        impact wall: inelastic
        minimize time
        finally { x == share*far }
        horizon 2 [s]
    }
}

/// Masses, lengths and times, mirrored as well.
const SIZES: [(f64, f64, f64); 8] = [
    (1.0, 1.0, 2.0),
    (1e-9, 3e-9, 2.0),
    (1e9, 2e-7, 0.03),
    (5.0, -1e-7, 40.0),
    (0.2, 4e-5, 2e-3),
    (1e-6, 7e3, 1e2),
    (1e4, 1e9, 1e5),
    (3.0, -6e5, 7.0),
];

#[test]
fn least_effort_over_any_length_in_any_time_is_that_of_the_closed_form() {
    for (m, far, duration) in SIZES {
        let cart = Pushed { m, far, duration };
        let intervals = 5;
        let problem = Problem::of(&cart, intervals);
        let solution = ocp::solve(&cart, &problem, &Settings::default(), &mut |_| true).unwrap();
        assert_eq!(
            solution.status,
            Status::Solved,
            "{m} {far} {duration}: {:?}",
            solution.diagnosis()
        );
        // A force in interval k acts over the time from its middle to the end, w_k = h^2 (N - k - 1/2); u = w_k / sum w^2 * T^2/4.
        let h = duration / intervals as f64;
        let squares: f64 = (0..intervals).map(|k| (k as f64 + 0.5).powi(2)).sum();
        let exact = h * (duration * duration / 4.0).powi(2) / (h.powi(4) * squares);
        assert!(
            (solution.objective / exact - 1.0).abs() < 1e-8,
            "{m} {far} {duration}: {} {exact}",
            solution.objective
        );
        let end = solution.at(solution.horizon).unwrap();
        assert!((end["x"] / far - 1.0).abs() < 1e-6, "{} {far}", end["x"]);
    }
}

#[test]
fn wall_behind_the_goal_is_about_to_be_struck_at_no_scale() {
    for far in [1e-7, 1e-5, 1e-2, 1.0, 50.0] {
        let cart = Stopped {
            far,
            push: far,
            ..Stopped::default()
        };
        let problem = Problem::of(&cart, 4);
        let solution = ocp::solve(&cart, &problem, &Settings::default(), &mut |_| true).unwrap();
        let exact = (2.0 * cart.share).sqrt();
        assert!(
            (solution.objective / exact - 1.0).abs() < 1e-8,
            "{far}: {} {exact}",
            solution.objective
        );
        assert_eq!(solution.struck_after_the_end(&cart), [], "{far}");
    }
}
