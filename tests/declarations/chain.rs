//! A chain of ten links compiles in the dev profile with its default debug information, and moves as
//! it should.

use crate::support::compare;
use hangtime::model::Model;

hangtime::model! {
    /// Ten rods with point masses at their ends, in absolute angles, above a floor.
    pub Chain10 {
        parameters { m: kg = 0.4, l: m = 0.3, g: m/s^2 = 9.81 }
        coordinates { q1, q2, q3, q4, q5, q6, q7, q8, q9, q10 }
        fn link(angle) = l*(sin(angle), -cos(angle))
        fn kinetic(p) = m/2*|dot(p)|^2
        let p1 = link(q1)
        let p2 = p1 + link(q2)
        let p3 = p2 + link(q3)
        let p4 = p3 + link(q4)
        let p5 = p4 + link(q5)
        let p6 = p5 + link(q6)
        let p7 = p6 + link(q7)
        let p8 = p7 + link(q8)
        let p9 = p8 + link(q9)
        let p10 = p9 + link(q10)
        lagrangian kinetic(p1) + kinetic(p2) + kinetic(p3) + kinetic(p4) + kinetic(p5)
            + kinetic(p6) + kinetic(p7) + kinetic(p8) + kinetic(p9) + kinetic(p10)
            - m*g*(p1.z + p2.z + p3.z + p4.z + p5.z + p6.z + p7.z + p8.z + p9.z + p10.z)
        surface floor: p10.z >= -2.9 [m]
        impact floor: inelastic
        start { q10: pi/2 }
    }
}

oracle!(Chain10);

const N: usize = 10;

/// A configuration that is neither symmetric nor at rest.
fn state() -> Vec<f64> {
    (0..2 * N)
        .map(|i| 0.9 * (1.7 * i as f64 + 0.4).sin())
        .collect()
}

#[test]
fn chain_of_ten_agrees_with_dual_numbers() {
    let weights: Vec<f64> = (0..2 + N).map(|i| (i as f64 + 0.3).cos()).collect();
    assert_eq!(compare(&Chain10::default(), &state(), &weights), Ok(()));
}

/// One step of the classical Runge-Kutta method.
fn step(model: &dyn Model, x: &mut [f64], h: f64) {
    let slope = |x: &[f64]| {
        let mut slope = vec![0.0; 2 * N];
        slope[..N].copy_from_slice(&x[N..]);
        model.free_acceleration(x, &mut slope[N..]);
        slope
    };
    let moved = |x: &[f64], k: &[f64], h: f64| -> Vec<f64> {
        x.iter().zip(k).map(|(x, k)| x + h * k).collect()
    };
    let k1 = slope(x);
    let k2 = slope(&moved(x, &k1, h / 2.0));
    let k3 = slope(&moved(x, &k2, h / 2.0));
    let k4 = slope(&moved(x, &k3, h));
    for i in 0..2 * N {
        x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    }
}

#[test]
fn chain_of_ten_free_flight_conserves_energy_to_fourth_order() {
    let model = Chain10::default();
    let total = |x: &[f64]| {
        let mut energy = [0.0; 2];
        model.energy(x, &mut energy);
        energy[0] + energy[1]
    };
    let drift = |steps: usize| {
        let mut x = state();
        let before = total(&x);
        for _ in 0..steps {
            step(&model, &mut x, 0.05 / steps as f64);
        }
        (total(&x) - before).abs()
    };
    let (coarse, fine) = (drift(50), drift(100));
    // Order 4 divides the drift by 16 (energy: 16 to 32) when the step is halved; 10 leaves room for
    // the next term of the expansion. An error in the equations leaves a drift that does not fall.
    assert!(fine < coarse / 10.0, "{coarse:e} {fine:e}");
    assert!(fine < 1e-6 * total(&state()).abs(), "{fine:e}");
}
