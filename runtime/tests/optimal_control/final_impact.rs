//! Impacts right after the end.

use crate::support::solve as certified;
use hangtime::ocp::Settings;

hangtime::model! {
    /// A door that is closed in a second, no faster than it may be in the end: the motion may end before it slams.
    Door {
        parameters { fastest = 10 }
        coordinates { phi }
        controls { u in -20..=20 }
        lagrangian dot(phi)^2/2
        forces { phi: u }
        surface frame: phi >= 0
        impact frame: inelastic
        minimize integral(u^2) + sum(2*impulse(frame)^2)
        finally { phi == 0, dot(phi) >= -fastest }
        start { phi: 1.5 }
        horizon 1
    }
}

#[test]
fn impact_right_after_the_end_is_said_to_be_no_part_of_the_motion() {
    let door = Door::default();
    let solution = certified(&door, 10, &Settings::default());
    // phi(1) - 1.5 = sum of w_k u_k: the least effort is along w
    let step = 0.1;
    let weights: Vec<f64> = (0..10)
        .map(|k| step * (1.0 - step * (f64::from(k) + 0.5)))
        .collect();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    let effort = step * 1.5 * 1.5 / squares;
    assert!((solution.objective - effort).abs() < 1e-8 * effort);
    let velocity = -1.5 * step * weights.iter().sum::<f64>() / squares;
    let struck = solution.struck_after_the_end(&door);
    assert!(
        matches!(struck[..], [(0, found)] if (found - velocity).abs() < 1e-7),
        "{struck:?} instead of {velocity}"
    );

    // to rest
    let closed = Door { fastest: 0.0 };
    let solution = certified(&closed, 10, &Settings::default());
    assert_eq!(solution.struck_after_the_end(&closed), []);
}
