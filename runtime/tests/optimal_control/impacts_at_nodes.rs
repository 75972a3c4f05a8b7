//! Impacts that can only be where one interval of the controls ends and the next one begins.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::attempt;
use hangtime::ocp::{Settings, Status};

hangtime::model! {
    /// A cart sets another one of the same mass in motion, which has to be 2.4 m further 4 s after the start, at 0.8 m/s: as it
    /// cannot be held back, it has to move at this speed from 1 s on.
    Shunting {
        parameters { m: kg = 1, length: m = 1 }
        coordinates { engine: m, wagon: m }
        controls { force: N in -5..=5 }
        lagrangian m*(dot(engine)^2 + dot(wagon)^2)/2
        forces { engine: force }
        surface buffer: wagon - engine >= length
        impact buffer: inelastic
        minimize integral(force^2)
        finally { wagon == 4.6[m], dot(wagon) == 0.8[m/s] }
        start { wagon: 2.2 }
        horizon 4 [s]
    }
}

/// The engine has to be 1.2 m further after 1 s, at 1.6 m/s. With intervals of `h` the least integral of the squared force that does it is
/// `1.6^2 + 12*0.4^2/(1 - h^2)`: force `1.6 + b*(1/2 - t)` with the middles of the intervals for `t`, whose variance is `(1 - h^2)/12`.
#[test]
fn impact_at_the_end_of_an_interval_is_found() {
    for intervals in [8, 12, 16] {
        let solution = attempt(&Shunting::default(), intervals, &Settings::default());
        assert_eq!(solution.status, Status::Solved, "{intervals}");
        let h = 4.0 / intervals as f64;
        let exact = 1.6_f64.powi(2) + 12.0 * 0.4_f64.powi(2) / (1.0 - h * h);
        let excess = solution.objective / exact - 1.0;
        assert!(excess.abs() < 1e-10, "{intervals}: {excess:e}");
        let events = &solution.motion.as_ref().unwrap().events;
        assert!((events[0].time - 1.0).abs() < 1e-6, "{}", events[0].time);
    }
}

hangtime::model! {
    /// A pawl on a spring drives a carriage along a dry rail: it is drawn back, strikes the carriage, pushes it, and lets it glide.
    Pawl {
        parameters { pawl: kg = 0.2, carriage: kg = 0.5, k: N/m = 20, rub: N = 1, way: m = 0.3 }
        coordinates { p: m in -0.08..=0.08, c: m }
        controls { u: N in -12..=12 }
        lagrangian pawl/2*dot(p)^2 + carriage/2*dot(c)^2 - k/2*p^2
        forces { p: u }
        dry friction rail: bound rub, sliding dot(c)
        surface push: c >= p
        impact push: inelastic
        minimize integral(u^2)
        finally { c == way, dot(c) == 0 }
        start { c: 0.02 [m] }
        horizon 1.2 [s]
    }
}

#[test]
fn stroke_that_is_better_an_interval_later_or_earlier_is_found_there() {
    // On grids from the coarsest on, without looking beside them, a search comes to 5.68437, with the stroke where the coarse grid puts it.
    // An interval further away it is better. What a motion costs is the sum of squares of its controls, whoever finds it.
    let pawl = Pawl::default();
    let mut settings = Settings::default();
    settings.starts = Some(2);
    let solution = attempt(&pawl, 14, &settings);
    let found = solution.status.is_solved() || solution.status == Status::Uncertified;
    assert!(found, "{:?}", solution.diagnosis());
    assert!(solution.resimulation_error < 1e-6);
    let squares: f64 = solution.controls.iter().map(|u| u[0] * u[0]).sum();
    let effort = squares * 1.2 / 14.0;
    assert!((solution.objective - effort).abs() < 1e-9 * effort);
    assert!(effort < 0.995 * 5.68437, "{effort}");
}
