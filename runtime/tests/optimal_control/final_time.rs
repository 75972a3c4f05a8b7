//! Final times that goals allow, where there is no motion within them.

use crate::support::{attempt, one_start};
use hangtime::ocp::Status;

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
    let solution = attempt(&late, 6, &one_start());
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
