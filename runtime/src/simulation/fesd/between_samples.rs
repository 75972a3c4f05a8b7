//! Contacts that close and open again between two samples of a long element.
//!
//! Samples of an element show what its polynomials can do. A surface may do more: a thin post stands between two of them.
//! Places closer together are looked at along the cubic through states and velocities of neighbouring samples; what is
//! thinner than they are apart in time is not seen.

use super::detector::Detector;
use super::switch::{Switch, SwitchKind, bisect, keep_first};
use crate::fesd::finite_element::FiniteElement;
use crate::simulation::hidden_force::PLACES;

/// The first open contact that is closed at a place between samples `k - 1` and `k`, at both of which it is open.
/// `horizon` is that of the run.
pub(super) fn first_entry(
    detector: &mut Detector<'_>,
    element: &FiniteElement<'_>,
    k: usize,
    horizon: f64,
) -> Option<Switch> {
    let (left, right) = (detector.left(k), detector.thetas[k]);
    let width = (right - left) * element.length();
    let parts = (width / horizon * PLACES).ceil();
    let mut first: Option<Switch> = None;
    for part in 1..parts as usize {
        let share = part as f64 / parts;
        detector.place_between_samples(share, width);
        let theta = left + share * (right - left);
        for index in 0..detector.open.len() {
            let contact = detector.open[index];
            let limit = detector.sizes[contact].touching_gap();
            let row = contact * (detector.thetas.len() + 1);
            let open = detector.gaps[row + k] > limit && detector.gaps[row + k + 1] > limit;
            let gap =
                |detector: &Detector<'_>| detector.pieces.gap(detector.model, contact, &detector.x);
            if !open || gap(detector) >= -limit {
                continue;
            }
            let mut value = |theta: f64| detector.gap_at(element, contact, theta);
            let depth = value(theta);
            if depth < -limit {
                let (before, _) = bisect(&mut value, left, theta);
                let after = theta;
                let slope = depth / ((after - before) * element.length());
                let switch = Switch {
                    kind: SwitchKind::Entry,
                    contact,
                    theta: before,
                    violated: after,
                    slope,
                };
                keep_first(&mut first, switch);
            }
            detector.place_between_samples(share, width);
        }
        if first.is_some() {
            break;
        }
    }
    first
}
