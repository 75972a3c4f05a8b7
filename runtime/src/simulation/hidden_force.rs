//! What acts between the places that a long step looks at: a push that is over before the next stage, a magnet or a bump that is passed.
//!
//! Neither stages nor error estimates, which read stages, know of it. Accelerations are computed at places closer together and compared
//! with the polynomial through those of a few nodes of the step; what is over between two of these places is not seen.

use std::f64::consts::PI;

/// Places in the whole horizon.
pub(super) const PLACES: f64 = 1000.0;
/// Nodes of the polynomial: one of degree 7, as accurate as the steps of either method.
const NODES: usize = 8;

/// Whether a step of this `length` has places that are closer together than its nodes, in a run to the `horizon`.
pub(super) fn has_places(length: f64, horizon: f64) -> bool {
    (length / horizon * PLACES).ceil() > NODES as f64
}

/// Mean size of the difference between the accelerations `at` places of a step, from 0 to 1, and the polynomial through those of its
/// nodes, for each of `n` velocities; none for a step so short, beside the `horizon`, that its nodes are as close as the places.
pub(super) fn mean_change(
    (length, horizon): (f64, f64),
    n: usize,
    mut at: impl FnMut(f64, &mut [f64]),
) -> Option<Vec<f64>> {
    if !has_places(length, horizon) {
        return None;
    }
    let parts = (length / horizon * PLACES).ceil();
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
    for part in 1..parts as usize {
        let theta = part as f64 / parts;
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
            *change += (found[k] - expected).abs() / parts;
        }
    }
    Some(change)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomial_has_no_hidden_part_and_a_push_has_its_own() {
        let polynomial = |theta: f64, a: &mut [f64]| a[0] = 3.0 - 2.0 * theta + theta.powi(7);
        let change = mean_change((1.0, 2.0), 1, polynomial).unwrap();
        assert!(change[0] < 1e-14, "{change:?}");
        // The mean of a push of a hundredth of the step, sampled at 500 places.
        let push = |theta: f64, a: &mut [f64]| a[0] = (-((theta - 0.37) / 0.01).powi(2)).exp();
        let change = mean_change((1.0, 2.0), 1, push).unwrap();
        assert!((change[0] - 0.01 * PI.sqrt()).abs() < 1e-4, "{change:?}");
        assert!(mean_change((1.0, 1e4), 1, push).is_none());
    }
}
