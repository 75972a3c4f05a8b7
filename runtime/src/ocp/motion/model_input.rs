//! Input vectors of the model, and the accelerations that follow from them.

use crate::model::{Model, contact_point, tangent_point};
use crate::yardstick;

/// What the model reads besides the state: the controls, and the time where it depends on that.
pub(in crate::ocp) fn drive(model: &dyn Model, controls: &[f64], time: f64) -> Vec<f64> {
    let explicit = model.declaration().explicit_time;
    let time = explicit.then_some(time);
    controls.iter().copied().chain(time).collect()
}

/// `(q, v)` with the normal accelerations that keep the contacts closed, as far as they push.
pub(in crate::ocp) fn with_forces(model: &dyn Model, state: Vec<f64>, drive: &[f64]) -> Vec<f64> {
    let mut x = state;
    let plain = x.len();
    x.extend(drive);
    let forces: Vec<f64> = (0..model.declaration().contacts.len())
        .map(|contact| (-free_normal_acceleration(model, contact, &x)).max(0.0))
        .collect();
    x.truncate(plain);
    x.extend(forces);
    x
}

/// Acceleration of the coordinates at an input vector under forces of contacts: (contact, normal acceleration that it provides, tangential one).
pub(in crate::ocp) fn acceleration(
    model: &dyn Model,
    x: &[f64],
    forces: &[(usize, f64, f64)],
) -> Vec<f64> {
    let n = model.declaration().coordinates.len();
    let mut acceleration = vec![0.0; n];
    model.free_acceleration(x, &mut acceleration);
    let mut point = vec![0.0; contact_point::length(n)];
    let mut tangent = vec![0.0; tangent_point::length(n)];
    for &(contact, normal, tangential) in forces {
        point.fill(0.0);
        tangent.fill(0.0);
        model.contact(contact, x, &mut point);
        model.tangent(contact, x, &mut tangent);
        let along = &point[contact_point::direction(n)..][..n];
        let across = &tangent[tangent_point::direction(n)..][..n];
        for (a, (d, e)) in acceleration.iter_mut().zip(along.iter().zip(across)) {
            *a += normal * d + tangential * e;
        }
    }
    acceleration
}

/// Normal acceleration of a contact without its force, `n'a + curvature`, at an input vector; 0 where its terms cancel up to
/// rounding error, as of a wall beside a body that falls: programs are measured in it.
pub(in crate::ocp) fn free_normal_acceleration(
    model: &dyn Model,
    contact: usize,
    x: &[f64],
) -> f64 {
    let n = model.declaration().coordinates.len();
    let mut point = vec![0.0; contact_point::length(n)];
    let mut acceleration = vec![0.0; n];
    model.contact(contact, x, &mut point);
    model.free_acceleration(x, &mut acceleration);
    let normal = &point[contact_point::NORMAL..][..n];
    let along = normal.iter().zip(&acceleration).map(|(n, a)| n * a);
    let terms = along.chain([point[contact_point::CURVATURE]]);
    let (sum, size) = terms.fold((0.0, 0.0), |(sum, size), term| {
        (sum + term, size + f64::abs(term))
    });
    if f64::abs(sum) > yardstick::ROUNDING * size {
        sum
    } else {
        0.0
    }
}
