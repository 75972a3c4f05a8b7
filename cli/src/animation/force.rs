//! Where in the plane a contact force acts, and along which direction.
//!
//! A force `F` on a body at `p(q)` with the angle `a(q)`, and its moment `m` about `p`, are the generalized force
//! `(dp/dq)' F + (da/dq)' m`. The one of a contact is `n lambda_n + b lambda_t`. The arrow belongs to the first body
//! that can carry it, alone or against another body that takes the reaction, by least squares, and begins where the
//! line on which `F` has the moment `m` enters the outline of the body.

use hangtime::model::{Model, contact_point, tangent_point};
use serde::Serialize;

use crate::drawing::Drawing;
use crate::sampling::State;

/// Step of the central differences of a place, relative to the size of the coordinate.
const STEP: f64 = 1e-6;
/// What is added to the squares, as a share of them, where a body does not move along all loads.
const SINGULAR: f64 = 1e-9;
/// Forces that no body can carry within this share of themselves are not drawn.
const CARRIED: f64 = 1e-4;

/// The force of one contact in the plane.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Arrow {
    /// Index of the body that carries it.
    pub(super) body: usize,
    /// Where it acts, from the place of the body.
    pub(super) from: [f64; 2],
    /// Horizontal and vertical component.
    pub(super) force: [f64; 2],
}

impl Arrow {
    pub(super) fn magnitude(&self) -> f64 {
        self.force[0].hypot(self.force[1])
    }
}

/// The force of every contact.
pub(super) fn arrows(drawing: &Drawing<'_>, model: &dyn Model, state: &State) -> Vec<Arrow> {
    let jacobians = jacobians(drawing, state);
    let placed = drawing.at(state);
    let reach = |body: usize| drawing.bodies[body].reach();
    let between = |one: usize, other: usize| {
        let [[y, z], [b, c]] = [placed.places[one], placed.places[other]];
        let reaches = [reach(one), reach(other)];
        relative(
            [&jacobians[one], &jacobians[other]],
            [y - b, z - c],
            reaches,
        )
    };
    let bodies = 0..jacobians.len();
    let pairs = bodies
        .clone()
        .flat_map(|one| bodies.clone().map(move |other| (one, other)));
    let mut pairs: Vec<_> = pairs.filter(|(one, other)| one != other).collect();
    // both bodies are touched where the force acts, and of a small one any place is near that
    pairs.sort_by(|a, b| reach(a.0).total_cmp(&reach(b.0)));
    let alone = jacobians.iter().cloned().enumerate().collect();
    let pairs = pairs.into_iter();
    let loaded = [
        alone,
        pairs
            .map(|(one, other)| (one, between(one, other)))
            .collect(),
    ];
    (0..state.contact_force.len())
        .map(|contact| {
            let generalized = generalized_force(model, contact, state);
            let Some((body, [y, z, moment])) = load(&loaded, &generalized) else {
                return Arrow::default();
            };
            let outline = placed.outline(body, &drawing.bodies[body]);
            let moment = moment * drawing.bodies[body].reach();
            let arrow = Arrow {
                body,
                from: entry(placed.places[body], &outline, [y, z], moment),
                force: [y, z],
            };
            let finite = arrow.force.iter().chain(&arrow.from).all(|x| x.is_finite());
            if finite { arrow } else { Arrow::default() }
        })
        .collect()
}

/// Bodies with the derivatives of what a load on them moves along.
type Loaded = Vec<(usize, Vec<[f64; 3]>)>;

/// The first body that carries a generalized force, and the load on it: a force through its place if one is enough, on the body alone
/// (the first of `loaded`) rather than against another one.
fn load(loaded: &[Loaded; 2], generalized: &[f64]) -> Option<(usize, [f64; 3])> {
    let size = generalized.iter().map(|q| q * q).sum::<f64>().sqrt();
    let carried = |loaded: &Loaded, turning: f64| {
        let mut loads = loaded.iter().map(|(body, jacobian)| {
            let columns = jacobian.iter();
            let columns = columns.map(|[y, z, angle]| [*y, *z, turning * angle]);
            let (load, residual) = least_squares(&columns.collect::<Vec<_>>(), generalized);
            (residual, *body, load)
        });
        loads.find(|(residual, ..)| size > 0.0 && *residual <= CARRIED * size)
    };
    let ways = [0.0, 1.0].into_iter();
    let mut ways = ways.flat_map(|turning| loaded.iter().map(move |loaded| (loaded, turning)));
    let (_, body, load) = ways.find_map(|(loaded, turning)| carried(loaded, turning))?;
    Some((body, load))
}

/// Derivatives of the place and the angle of a body as seen from another one, which takes the reaction of a load where it acts: `apart` is
/// the place of the first from that of the other.
fn relative(
    [one, other]: [&[[f64; 3]]; 2],
    [y, z]: [f64; 2],
    [reach, other_reach]: [f64; 2],
) -> Vec<[f64; 3]> {
    let seen = one.iter().zip(other).map(|(one, other)| {
        let turn = if other_reach > 0.0 {
            other[2] / other_reach
        } else {
            0.0
        };
        [
            one[0] - (other[0] - turn * z),
            one[1] - (other[1] + turn * y),
            one[2] - reach * turn,
        ]
    });
    seen.collect()
}

/// Where the line on which a force has the moment enters an outline, from the place of the body; the point of the line
/// that is nearest to the place, if they do not meet.
fn entry(place: [f64; 2], outline: &[[f64; 2]], [y, z]: [f64; 2], moment: f64) -> [f64; 2] {
    let size = y.hypot(z);
    if outline.is_empty() || size == 0.0 {
        return [0.0; 2];
    }
    let along = [y / size, z / size];
    let nearest = [-along[1] * moment / size, along[0] * moment / size];
    // How far a corner is along the line, and beside it.
    let seen = |[a, b]: [f64; 2]| {
        let [a, b] = [a - place[0] - nearest[0], b - place[1] - nearest[1]];
        [a * along[0] + b * along[1], a * along[1] - b * along[0]]
    };
    let corners: Vec<[f64; 2]> = outline.iter().map(|&corner| seen(corner)).collect();
    let reach = corners
        .iter()
        .flatten()
        .fold(0.0_f64, |most, x| most.max(x.abs()));
    // A corner on the line counts in spite of roundings of the derivatives.
    let touching = corners
        .iter()
        .filter(|corner| corner[1].abs() <= CARRIED * reach);
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let crossed = sides.filter(|(a, b)| a[1] * b[1] < 0.0);
    let crossed = crossed.map(|(a, b)| a[0] + (b[0] - a[0]) * a[1] / (a[1] - b[1]));
    let first = touching
        .map(|corner| corner[0])
        .chain(crossed)
        .fold(f64::INFINITY, f64::min);
    let first = if first.is_finite() { first } else { 0.0 };
    [nearest[0] + first * along[0], nearest[1] + first * along[1]]
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

/// For each body the derivative of its place, and of its angle times its reach, by each coordinate.
fn jacobians(drawing: &Drawing<'_>, state: &State) -> Vec<Vec<[f64; 3]>> {
    let q = &state.q;
    let mut jacobians = vec![Vec::with_capacity(q.len()); drawing.bodies.len()];
    let mut shifted = q.clone();
    for i in 0..q.len() {
        let step = STEP * q[i].abs().max(1.0);
        let [ahead, behind] = [step, -step].map(|step| {
            shifted[i] = q[i] + step;
            drawing.placed(&shifted, &state.v, &state.u, state.time)
        });
        shifted[i] = q[i];
        for (body, jacobian) in jacobians.iter_mut().enumerate() {
            let [a, b] = [&ahead, &behind].map(|placed| {
                let [y, z] = placed.places[body];
                [y, z, placed.angles[body] * drawing.bodies[body].reach()]
            });
            jacobian.push([0, 1, 2].map(|axis| (a[axis] - b[axis]) / (2.0 * step)));
        }
    }
    jacobians
}

/// The load (two components of a force, and a moment) that minimizes `|J' F - Q|`, and that distance; the smallest such
/// load, if the body does not move along all of them.
fn least_squares(jacobian: &[[f64; 3]], generalized: &[f64]) -> ([f64; 3], f64) {
    let mut a = [[0.0; 4]; 3];
    for (column, q) in jacobian.iter().zip(generalized) {
        for i in 0..3 {
            a[i][3] += column[i] * q;
            for j in 0..3 {
                a[i][j] += column[i] * column[j];
            }
        }
    }
    let trace = a[0][0] + a[1][1] + a[2][2];
    for (i, row) in a.iter_mut().enumerate() {
        row[i] += SINGULAR * trace;
    }
    // Gauss-Jordan elimination; the matrix is positive definite.
    for k in 0..3 {
        let pivot = a[k].map(|x| x / a[k][k]);
        a[k] = pivot;
        for (_, row) in a.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row[k];
            for (x, p) in row.iter_mut().zip(pivot) {
                *x -= factor * p;
            }
        }
    }
    let load = a.map(|row| row[3]);
    let residual = jacobian.iter().zip(generalized).map(|(column, q)| {
        let carried: f64 = column.iter().zip(load).map(|(c, f)| c * f).sum();
        (carried - q) * (carried - q)
    });
    (load, residual.sum::<f64>().sqrt())
}

#[cfg(test)]
mod tests {
    use super::{Arrow, Loaded, arrows, load, relative};
    use crate::drawing::Drawing;
    use crate::sampling::State;
    use crate::settings::{ChosenScene, find};

    fn arrow(scene: &'static str, q: &[f64], force: f64, contact: usize) -> Arrow {
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
            impulses: Vec::new(),
            outputs: Vec::new(),
        };
        let model = chosen.model.as_ref();
        arrows(&Drawing::of(model, scene).unwrap(), model, &state)[contact]
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
    fn force_between_a_block_and_a_plank_that_turn_together_goes_through_the_block() {
        // q = (angle of the plank, place along it, height above it), at an angle of 0.3, the block 1.2 out and 0.25 above its underside
        let (angle, along, above) = (0.3_f64, 1.2, 0.25);
        let (sin, cos) = angle.sin_cos();
        let place = [along * cos - above * sin, along * sin + above * cos];
        let plank = [[0.0, 0.0, 2.0], [0.0; 3], [0.0; 3]];
        let block = [
            [-place[1], place[0], 0.4],
            [cos, sin, 0.0],
            [-sin, cos, 0.0],
        ];
        // normal force 90 and friction -20 along the plank: nothing turns the plank, as the reaction acts on it
        let generalized = [0.0, -20.0, 90.0];
        let alone: Loaded = vec![(0, plank.to_vec()), (1, block.to_vec())];
        let between = relative([&block, &plank], place, [0.4, 2.0]);
        let (body, [y, z, moment]) = load(&[alone, vec![(1, between)]], &generalized).unwrap();
        assert_eq!(body, 1);
        assert!((y - (-20.0 * cos - 90.0 * sin)).abs() < 1e-5, "{y}");
        assert!((z - (-20.0 * sin + 90.0 * cos)).abs() < 1e-5, "{z}");
        assert!(moment.abs() < 1e-9, "{moment}");
    }

    #[test]
    fn arrows_of_a_point_mass_are_the_gradient_of_the_gap() {
        // slope: z - 7 + y/2, so the force is lambda (1/2, 1).
        let arrow = arrow("slide", &[50.0, 20.0], 100.0, 1);
        assert!((arrow.force[0] - 50.0).abs() < 1e-6, "{arrow:?}");
        assert!((arrow.force[1] - 100.0).abs() < 1e-6, "{arrow:?}");
    }
}
