//! What acts between the stages of a step: a push that is over before the next stage, a magnet or a bump that is passed.
//!
//! Neither stages nor error estimates, which read stages, know of it. Where functions of a scene are confined to a part of a step, as
//! their bounds tell, accelerations at places of each such part are compared with the polynomial through those of a few nodes of the step.

use std::f64::consts::PI;

/// Nodes of the polynomial: one of degree 7, as accurate as the steps of either method.
const NODES: usize = 8;
/// Gauss's three places of a part, and their weights.
const PLACES: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// The largest share of a velocity by which what is hidden in a step of this `length` changes it: of each by its `size`, from
/// accelerations `at` places of the step.
pub(super) fn largest_share(
    parts: &[[f64; 2]],
    n: usize,
    length: f64,
    at: impl FnMut(f64, &mut [f64]),
    size: impl Fn(usize) -> f64,
) -> f64 {
    let change = mean_change(parts, n, at).into_iter().enumerate();
    let shares = change.map(|(k, change)| change * length / size(k));
    shares.fold(0.0, f64::max)
}

/// Mean size of the difference between the accelerations `at` places of a step, from 0 to 1, and the polynomial through those of its
/// nodes, for each of `n` velocities. In each of the `parts` nothing is hidden.
fn mean_change(parts: &[[f64; 2]], n: usize, mut at: impl FnMut(f64, &mut [f64])) -> Vec<f64> {
    // Those of Chebyshev, with their barycentric weights.
    let angle = |j: usize| PI * (2 * j + 1) as f64 / (2 * NODES) as f64;
    let nodes: [f64; NODES] = std::array::from_fn(|j| 0.5 - 0.5 * angle(j).cos());
    let weights: [f64; NODES] =
        std::array::from_fn(|j| angle(j).sin() * if j % 2 == 0 { 1.0 } else { -1.0 });
    let mut known = vec![0.0; NODES * n];
    for (node, accelerations) in nodes.iter().zip(known.chunks_exact_mut(n)) {
        at(*node, accelerations);
    }
    let (mut found, mut change) = (vec![0.0; n], vec![0.0; n]);
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
        for (k, change) in change.iter_mut().enumerate() {
            let nodes = shares.iter().zip(known.chunks_exact(n));
            let expected = nodes.map(|(share, node)| share * node[k]).sum::<f64>() / total;
            *change += (found[k] - expected).abs() * share * (to - from);
        }
    }
    change
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
        let change = mean_change(&parts, 1, polynomial);
        assert!(change[0] < 1e-14, "{change:?}");
        // The mean of a push of a hundredth of the step.
        let push = |theta: f64, a: &mut [f64]| a[0] = (-((theta - 0.37) / 0.01).powi(2)).exp();
        let change = mean_change(&parts, 1, push);
        assert!((change[0] - 0.01 * PI.sqrt()).abs() < 1e-4, "{change:?}");
    }
}
