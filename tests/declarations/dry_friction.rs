//! Dry friction without a surface, of systems of a few, several and many coordinates, for which directions are formulas,
//! eliminations and linear systems: values against their definition, derivatives against differences.

#![allow(deprecated, reason = "warned of: a floor that nothing touches")]

use hangtime::model::{Model, SparsityPattern, contact_point, tangent_point};

hangtime::model! {
    /// Two links with dry hinges.
    pub Arm {
        parameters { m: kg = 1, l: m = 0.5, g: m/s^2 = 9.81, f: N m = 0.4 }
        coordinates { a: rad, b: rad }
        let elbow = l*(sin(a), -cos(a))
        let tip = elbow + l*(sin(b), -cos(b))
        lagrangian m/2*(|dot(elbow)|^2 + |dot(tip)|^2) - m*g*(elbow.z + tip.z)
        /// Holds the arm.
        dry friction shoulder: bound f, sliding dot(a)
        dry friction hinge: bound f*(1 + sin(b - a)^2), sliding dot(b) - dot(a) - 0.1 [rad/s]
        surface floor: tip.z >= -3 [m]
        impact floor: inelastic, friction 0.3, sliding dot(tip.y)
    }
}

hangtime::model! {
    /// A train of six cars, coupled by one that slides on them all, with brakes that take hold with time.
    pub Train {
        parameters { m: kg = 2, k: N/m = 40, f: N = 3, rise: 1/s = 0.5, w: m = 1 }
        coordinates { a: m, b: m, c: m, d: m, e: m, h: m }
        lagrangian m/2*(dot(a)^2 + dot(b)^2 + dot(c)^2 + dot(d)^2 + dot(e)^2 + dot(h)^2)
            + m/2*(2 + sin(a/w))*dot(a + b + c)^2 + m/2*(1 + (d/w)^2)*dot(c + e + h)^2 - k/2*(a - h)^2
        dry friction first: bound f*exp(rise*t), sliding dot(a)
        dry friction last: sliding dot(h)*(1 + (e/w)^2) - dot(d), bound f*(1 + (a*b/w^2)^2)
    }
}

hangtime::model! {
    /// The same with nine.
    pub LongTrain {
        parameters { m: kg = 2, k: N/m = 40, f: N = 3, w: m = 1 }
        coordinates { a: m, b: m, c: m, d: m, e: m, h: m, i: m, j: m, l: m }
        lagrangian m/2*(dot(a)^2 + dot(b)^2 + dot(c)^2 + dot(d)^2 + dot(e)^2 + dot(h)^2 + dot(i)^2 + dot(j)^2 + dot(l)^2)
            + m/2*(2 + sin(a/w))*dot(a + b + c + l)^2 + m/2*(1 + (d/w)^2)*dot(c + e + h)^2 - k/2*(a - h)^2
        dry friction first: bound f, sliding dot(a)
        dry friction last: sliding dot(l)*(1 + (e/w)^2) - dot(d), bound f*(1 + (a*b/w^2)^2)
    }
}

/// A state at which nothing vanishes by chance.
fn state(model: &dyn Model) -> Vec<f64> {
    let inputs = model.declaration().inputs();
    (0..inputs)
        .map(|k| 0.6 * (1.3 * k as f64 + 0.4).sin())
        .collect()
}

fn contact(model: &dyn Model, contact: usize, x: &[f64]) -> Vec<f64> {
    let mut point = vec![f64::NAN; contact_point::length(model.declaration().coordinates.len())];
    model.contact(contact, x, &mut point);
    point
}

fn tangent(model: &dyn Model, contact: usize, x: &[f64]) -> Vec<f64> {
    let mut point = vec![f64::NAN; tangent_point::length(model.declaration().coordinates.len())];
    model.tangent(contact, x, &mut point);
    point
}

fn dry(model: &dyn Model) -> impl Iterator<Item = usize> {
    let contacts = model.declaration().contacts.iter().enumerate();
    contacts.filter(|(_, contact)| contact.dry).map(|(i, _)| i)
}

#[test]
fn force_and_direction_are_what_they_are_declared_to_be() {
    let bounds = |model: &dyn Model, x: &[f64]| -> Vec<f64> {
        let growth = |share: f64| 1.0 + share * share;
        match model.declaration().name {
            "Arm" => vec![0.4, 0.4 * growth((x[1] - x[0]).sin())],
            "Train" => vec![3.0 * (0.5 * x[12]).exp(), 3.0 * growth(x[0] * x[1])],
            _ => vec![3.0, 3.0 * growth(x[0] * x[1])],
        }
    };
    let scenes: [&dyn Model; 3] = [&Arm::default(), &Train::default(), &LongTrain::default()];
    for model in scenes {
        let n = model.declaration().coordinates.len();
        let x = state(model);
        let mut mass = vec![0.0; n * n];
        model.mass_matrix(&x, &mut mass);
        for (i, bound) in dry(model).zip(bounds(model, &x)) {
            let (point, side) = (contact(model, i, &x), tangent(model, i, &x));
            let along = &side[tangent_point::TANGENT..][..n];
            let scale: f64 = (0..n).map(|k| along[k].powi(2) / mass[k * n + k]).sum();
            assert!((point[contact_point::INVERSE_INERTIA] - scale).abs() < 1e-14 * scale);
            let pressed = -point[contact_point::CURVATURE];
            assert!(
                (pressed - scale * bound).abs() < 1e-14 * pressed,
                "{pressed}"
            );
            assert_eq!(point[contact_point::GAP], 0.0);
            assert_eq!(point[contact_point::NORMAL_VELOCITY], 0.0);
            assert!(
                point[contact_point::NORMAL..]
                    .iter()
                    .all(|value| *value == 0.0)
            );
            let direction = &side[tangent_point::direction(n)..];
            for (row, along) in mass.chunks(n).zip(along) {
                let product: f64 = row.iter().zip(direction).map(|(m, e)| m * e).sum();
                assert!((product * scale - along).abs() < 1e-13, "{product}");
            }
        }
    }
    // Behind the surface, wherever it is declared.
    assert_eq!(dry(&Arm::default()).collect::<Vec<_>>(), [1, 2]);
    let shoulder = &Arm::default().declaration().contacts[1];
    assert_eq!(
        (shoulder.name, shoulder.documentation),
        ("shoulder", "Holds the arm.")
    );
}

fn dense(pattern: &SparsityPattern, values: &[f64]) -> Vec<f64> {
    let mut matrix = vec![0.0; pattern.rows * pattern.columns];
    for (&(row, column), value) in pattern.entries.iter().zip(values) {
        matrix[row as usize * pattern.columns + column as usize] += value;
    }
    matrix
}

/// The rows of a dry friction: given normal acceleration, sliding velocity, direction.
fn rows(model: &dyn Model, i: usize, x: &[f64]) -> Vec<f64> {
    let n = model.declaration().coordinates.len();
    let side = tangent(model, i, x);
    let mut rows = vec![-contact(model, i, x)[contact_point::CURVATURE]];
    rows.push(side[tangent_point::SLIDING_VELOCITY]);
    rows.extend(&side[tangent_point::direction(n)..]);
    rows
}

/// Their Jacobian.
fn jacobian(model: &dyn Model, i: usize, x: &[f64]) -> Vec<f64> {
    let declared = &model.declaration().contacts[i];
    let friction = declared.friction.expect("friction");
    let mut pressed = vec![f64::NAN; declared.jacobian.entries.len()];
    let mut across = vec![f64::NAN; friction.jacobian.entries.len()];
    model.contact_jacobian(i, x, &mut pressed);
    model.tangent_jacobian(i, x, &mut across);
    let first = dense(&declared.jacobian, &pressed);
    let columns = declared.jacobian.columns;
    assert!(
        first[..columns]
            .iter()
            .chain(&first[2 * columns..])
            .all(|value| *value == 0.0)
    );
    [
        &first[columns..2 * columns],
        &dense(&friction.jacobian, &across)[..],
    ]
    .concat()
}

/// The Hessian of their weighted sum, both triangles.
fn hessian(model: &dyn Model, i: usize, x: &[f64], weights: &[f64]) -> Vec<f64> {
    let declared = &model.declaration().contacts[i];
    let friction = declared.friction.expect("friction");
    let n = model.declaration().coordinates.len();
    let mut pressed = vec![f64::NAN; declared.hessian.entries.len()];
    let mut across = vec![f64::NAN; friction.hessian.entries.len()];
    let mut of_contact = vec![0.0; 2 + n];
    of_contact[1] = weights[0];
    model.contact_hessian(i, x, &of_contact, &mut pressed);
    model.tangent_hessian(i, x, &weights[1..], &mut across);
    let lower = dense(&declared.hessian, &pressed).into_iter();
    let lower = lower.zip(dense(&friction.hessian, &across));
    let lower: Vec<f64> = lower.map(|(a, b)| a + b).collect();
    let size = x.len();
    let place = |k: usize| (k / size).max(k % size) * size + (k / size).min(k % size);
    (0..size * size).map(|k| lower[place(k)]).collect()
}

#[test]
fn derivatives_agree_with_differences() {
    const STEP: f64 = 1e-5;
    let scenes: [&dyn Model; 3] = [&Arm::default(), &Train::default(), &LongTrain::default()];
    for model in scenes {
        let x = state(model);
        for i in dry(model) {
            let count = rows(model, i, &x).len();
            let weights: Vec<f64> = (0..count).map(|k| 1.0 + 0.3 * k as f64).collect();
            let gradient = |x: &[f64]| -> Vec<f64> {
                let matrix = jacobian(model, i, x);
                let column = |k: usize| {
                    (0..count)
                        .map(|r| weights[r] * matrix[r * x.len() + k])
                        .sum()
                };
                (0..x.len()).map(column).collect()
            };
            let (first, second) = (jacobian(model, i, &x), hessian(model, i, &x, &weights));
            for k in 0..x.len() {
                let moved = |by: f64| {
                    let mut moved = x.clone();
                    moved[k] += by;
                    moved
                };
                let (ahead, behind) = (moved(STEP), moved(-STEP));
                let difference = |a: &[f64], b: &[f64], r: usize| (a[r] - b[r]) / (2.0 * STEP);
                let (a, b) = (rows(model, i, &ahead), rows(model, i, &behind));
                for r in 0..count {
                    // Values of about 10 leave 1e-16*10/1e-5, third derivatives of about 10 1e-10 times that.
                    let apart = first[r * x.len() + k] - difference(&a, &b, r);
                    assert!(apart.abs() < 1e-8, "row {r} by {k}: {apart:e}");
                }
                let (a, b) = (gradient(&ahead), gradient(&behind));
                for r in 0..x.len() {
                    let apart = second[r * x.len() + k] - difference(&a, &b, r);
                    assert!(apart.abs() < 1e-7, "entry ({r}, {k}): {apart:e}");
                }
            }
        }
    }
}
