//! Where in the plane a contact force acts, and along which direction.
//!
//! A force `F` on a body at `p(q)` is the generalized force `(dp/dq)' F`. The one of a contact is `n lambda_n + b
//! lambda_t`. The arrow belongs to the body that can carry it, and is the least-squares solution there.

use crate::Plane;
use hangtime::model::{Model, contact_point, tangent_point};
use serde::Serialize;

use crate::sampling::State;

/// Step of the central differences of a position, relative to the size of the coordinate.
const STEP: f64 = 1e-6;
/// A determinant that is smaller than this share of the squared trace counts as zero: the body moves along a line.
const SINGULAR: f64 = 1e-9;

/// The force of one contact in the plane.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Arrow {
    /// Index of the body that carries it.
    pub(super) body: usize,
    /// Horizontal and vertical component.
    pub(super) force: [f64; 2],
}

impl Arrow {
    pub(super) fn magnitude(&self) -> f64 {
        self.force[0].hypot(self.force[1])
    }
}

/// The force of every contact.
pub(super) fn arrows(plane: &Plane, model: &dyn Model, state: &State) -> Vec<Arrow> {
    let jacobians = jacobians(plane, model, &state.q);
    (0..state.contact_force.len())
        .map(|contact| {
            let generalized = generalized_force(model, contact, state);
            if generalized.iter().all(|&component| component == 0.0) {
                return Arrow::default();
            }
            let arrows = jacobians.iter().enumerate();
            arrows
                .map(|(body, jacobian)| {
                    let (force, residual) = least_squares(jacobian, &generalized);
                    (Arrow { body, force }, residual)
                })
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .map(|(arrow, _)| arrow)
                .filter(|arrow| arrow.magnitude().is_finite())
                .unwrap_or_default()
        })
        .collect()
}

/// `n lambda_n + b lambda_t`.
fn generalized_force(model: &dyn Model, contact: usize, state: &State) -> Vec<f64> {
    let n = state.q.len();
    let mut x: Vec<f64> = Vec::with_capacity(model.declaration().inputs());
    x.extend(state.q.iter().chain(&state.v).chain(&state.u));
    if model.declaration().explicit_time {
        x.push(state.time);
    }
    let mut point = vec![0.0; contact_point::length(n)];
    model.contact(contact, &x, &mut point);
    let normal = &point[contact_point::NORMAL..contact_point::NORMAL + n];
    let force = state.contact_force[contact];
    let mut generalized: Vec<f64> = normal.iter().map(|n| n * force).collect();
    if let Some(&friction) = state.friction_force.get(contact)
        && model.declaration().contacts[contact].friction.is_some()
    {
        let mut point = vec![0.0; tangent_point::length(n)];
        model.tangent(contact, &x, &mut point);
        let tangent = &point[tangent_point::TANGENT..tangent_point::TANGENT + n];
        for (sum, b) in generalized.iter_mut().zip(tangent) {
            *sum += b * friction;
        }
    }
    generalized
}

/// For each body the derivative of its position by each coordinate.
fn jacobians(plane: &Plane, model: &dyn Model, q: &[f64]) -> Vec<Vec<[f64; 2]>> {
    let mut jacobians = vec![Vec::with_capacity(q.len()); plane.bodies.len()];
    let mut shifted = q.to_vec();
    for i in 0..q.len() {
        let step = STEP * q[i].abs().max(1.0);
        shifted[i] = q[i] + step;
        let ahead = plane.bodies_at(model, &shifted);
        shifted[i] = q[i] - step;
        let behind = plane.bodies_at(model, &shifted);
        shifted[i] = q[i];
        for (jacobian, (a, b)) in jacobians.iter_mut().zip(ahead.iter().zip(&behind)) {
            jacobian.push([0, 1].map(|axis| (a[axis] - b[axis]) / (2.0 * step)));
        }
    }
    jacobians
}

/// The force `F` that minimizes `|J' F - Q|`, and that distance.
fn least_squares(jacobian: &[[f64; 2]], generalized: &[f64]) -> ([f64; 2], f64) {
    let mut a = [[0.0; 2]; 2];
    let mut b = [0.0; 2];
    for (column, q) in jacobian.iter().zip(generalized) {
        for i in 0..2 {
            b[i] += column[i] * q;
            for j in 0..2 {
                a[i][j] += column[i] * column[j];
            }
        }
    }
    let trace = a[0][0] + a[1][1];
    let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    let force = if determinant > SINGULAR * trace * trace {
        [
            (a[1][1] * b[0] - a[0][1] * b[1]) / determinant,
            (a[0][0] * b[1] - a[1][0] * b[0]) / determinant,
        ]
    } else {
        // Along one line: the pseudo-inverse of t u u' is u u' / t.
        [0, 1].map(|i| (a[i][0] * b[0] + a[i][1] * b[1]) / (trace * trace))
    };
    let residual = jacobian.iter().zip(generalized).map(|(column, q)| {
        let difference = column[0] * force[0] + column[1] * force[1] - q;
        difference * difference
    });
    (force, residual.sum::<f64>().sqrt())
}

#[cfg(test)]
mod tests {
    use super::{Arrow, arrows};
    use crate::sampling::State;
    use crate::settings::{ChosenScene, find};

    fn arrow(scene: &str, q: &[f64], force: f64, contact: usize) -> Arrow {
        let chosen = ChosenScene::new(find(crate::testing::SCENES, scene).unwrap(), &[]).unwrap();
        let declaration = chosen.model.declaration();
        let mut contact_force = vec![0.0; declaration.contacts.len()];
        contact_force[contact] = force;
        let state = State {
            time: 0.0,
            q: q.to_vec(),
            v: vec![0.0; q.len()],
            u: vec![0.0; declaration.controls.len()],
            contact_force,
            friction_force: Vec::new(),
        };
        let plane = chosen.scene.plane.unwrap();
        arrows(&plane, chosen.model.as_ref(), &state)[contact]
    }

    #[test]
    fn arrows_of_a_mass_on_a_track_are_the_normal_of_the_track() {
        // The gap is the height above the track: the force is `lambda (-track', 1)` on the mass, with
        // track' = 0.4 sin 2y.
        let arrow = arrow("wave", &[0.7, 0.0], 200.0, 0);
        let slope = 0.4 * 1.4_f64.sin();
        assert_eq!(arrow.body, 0);
        // Central differences with a step of 1e-6 lose about 1e-10 of a slope.
        assert!((arrow.force[0] + 200.0 * slope).abs() < 1e-6, "{arrow:?}");
        assert!((arrow.force[1] - 200.0).abs() < 1e-6, "{arrow:?}");
    }

    #[test]
    fn arrows_of_a_point_mass_are_the_gradient_of_the_gap() {
        // slope: z - 7 + y/2, so the force is lambda (1/2, 1).
        let arrow = arrow("slide", &[50.0, 20.0], 100.0, 1);
        assert!((arrow.force[0] - 50.0).abs() < 1e-6, "{arrow:?}");
        assert!((arrow.force[1] - 100.0).abs() < 1e-6, "{arrow:?}");
    }
}
