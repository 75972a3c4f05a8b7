//! What acts between the stages of a step: a push that is over before the next stage, a magnet, a bump or a slick patch that is passed.
//!
//! Neither stages nor error estimates, which read stages, know of it. Where functions of a scene are confined to a part of a step, as
//! their bounds tell, accelerations at places of each such part are compared with the polynomial through those of a few nodes of the step.
//! What holds a contact may vanish without any acceleration: so are forces, and what friction lacks to its bound.

use crate::yardstick;
use std::f64::consts::PI;

/// Nodes of the polynomial: one of degree 7, as accurate as the steps of either method.
const NODES: usize = 8;
/// Gauss's three places of a part, and their weights.
const PLACES: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];
/// Whether something acts in a step of this `length` that its nodes do not show: whether it changes a velocity by more than `most`, or a force
/// may vanish. In each of the `parts` nothing is hidden; `at` evaluates `n` accelerations at a place, from 0 to 1, and behind them as many
/// `forces` that are positive as long as the mode lasts.
pub(super) fn acts(
    parts: &[[f64; 2]],
    (n, forces): (usize, usize),
    length: f64,
    mut at: impl FnMut(f64, &mut [f64]),
    most: impl Fn(usize) -> f64,
) -> bool {
    // Those of Chebyshev, with their barycentric weights.
    let angle = |j: usize| PI * (2 * j + 1) as f64 / (2 * NODES) as f64;
    let nodes: [f64; NODES] = std::array::from_fn(|j| 0.5 - 0.5 * angle(j).cos());
    let weights: [f64; NODES] =
        std::array::from_fn(|j| angle(j).sin() * if j % 2 == 0 { 1.0 } else { -1.0 });
    let mut known = vec![0.0; NODES * (n + forces)];
    for (node, values) in nodes.iter().zip(known.chunks_exact_mut(n + forces)) {
        at(*node, values);
    }
    let of = |k: usize| known[k..].iter().step_by(n + forces);
    let (mut found, mut change) = (vec![0.0; n + forces], vec![0.0; n]);
    for ([from, to], (place, share)) in parts
        .iter()
        .flat_map(|part| PLACES.map(|place| (part, place)))
    {
        let theta = from + place * (to - from);
        if nodes.contains(&theta) {
            continue;
        }
        at(theta, &mut found);
        let shares = nodes.iter().zip(weights);
        let shares: Vec<f64> = shares
            .map(|(node, weight)| weight / (theta - node))
            .collect();
        let total: f64 = shares.iter().sum();
        for (k, found) in found.iter().enumerate() {
            let expected = shares.iter().zip(of(k)).map(|(share, node)| share * node);
            let missed = (found - expected.sum::<f64>() / total).abs();
            if let Some(change) = change.get_mut(k) {
                *change += missed * share * (to - from);
                continue;
            }
            let largest = of(k).fold(0.0_f64, |most, value| most.max(value.abs()));
            if *found <= missed && missed > yardstick::PROMISE * largest {
                return true;
            }
        }
    }
    let mut change = change.iter().enumerate();
    change.any(|(k, change)| change * length > most(k))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomial_has_no_hidden_part_and_a_push_has_its_own() {
        let parts: Vec<[f64; 2]> = (0..64)
            .map(|k| [f64::from(k) / 64.0, f64::from(k + 1) / 64.0])
            .collect();
        let polynomial = |theta: f64, a: &mut [f64]| a[0] = 3.0 - 2.0 * theta + theta.powi(7);
        assert!(!acts(&parts, (1, 0), 1.0, polynomial, |_| 1e-14));
        // The mean of a push of a hundredth of the step.
        let push = |theta: f64| (-((theta - 0.37) / 0.01).powi(2)).exp();
        for (sign, hidden) in [(-1.0, true), (1.0, false)] {
            let most = 0.01 * PI.sqrt() + sign * 1e-4;
            let at = |theta: f64, a: &mut [f64]| a[0] = push(theta);
            assert_eq!(acts(&parts, (1, 0), 1.0, at, |_| most), hidden);
            // One that takes a force away, or leaves some of it.
            let force = |theta: f64, r: &mut [f64]| r[0] = 1.0 + 1.5 * sign * push(theta);
            assert_eq!(acts(&parts, (0, 1), 1.0, force, |_| 0.0), hidden);
        }
    }
}
