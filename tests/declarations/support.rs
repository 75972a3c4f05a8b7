//! An independent route to everything that a declaration derives: the generic Lagrangian at run time,
//! dual numbers of dual numbers, and elimination.

use hangtime::model::{Model, SparsityPattern, contact_point, tangent_point};
use num_dual::{Dual, Dual64, DualNum, HyperDual, HyperDual64};
use proptest::prelude::ProptestConfig;
use proptest::test_runner::RngSeed;

/// So many random cases, the same in every run.
pub(crate) fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(20_261_122),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// The generic functions that a declaration emits beside the derived ones.
pub(crate) trait Oracle: Model + Sized {
    /// The Lagrangian.
    fn lagrangian_of<D: DualNum<Primitive = f64> + Copy>(&self, q: &[D], v: &[D], t: D) -> D;
    /// The generalized forces.
    fn forces_of<D: DualNum<Primitive = f64> + Copy>(
        &self,
        q: &[D],
        v: &[D],
        u: &[D],
        t: D,
    ) -> Vec<D>;
    /// The gap of one contact.
    fn gap_of<D: DualNum<Primitive = f64> + Copy>(&self, contact: usize, q: &[D], t: D) -> D;
    /// The declared impulse direction of a contact, if it has one.
    fn along_of<D: DualNum<Primitive = f64> + Copy>(
        &self,
        _contact: usize,
        _q: &[D],
    ) -> Option<Vec<D>> {
        None
    }
    /// The sliding velocity of a contact, if it has friction.
    fn sliding_of<D: DualNum<Primitive = f64> + Copy>(
        &self,
        _contact: usize,
        _q: &[D],
        _v: &[D],
        _t: D,
    ) -> Option<D> {
        None
    }
    /// Running cost and path constraints, of the input vector.
    fn path_of<D: DualNum<Primitive = f64> + Copy>(&self, _x: &[D]) -> Vec<D> {
        Vec::new()
    }
    /// Final cost and terminal conditions, of coordinates, velocities and final time.
    fn terminal_of<D: DualNum<Primitive = f64> + Copy>(&self, _z: &[D]) -> Vec<D> {
        Vec::new()
    }
}

/// Implements [`Oracle`] by the emitted methods.
macro_rules! oracle {
    ($scene:ty $(, along $along:expr)? $(, sliding $sliding:expr)?
        $(, path $path:expr, terminal $terminal:expr)?) => {
        impl $crate::support::Oracle for $scene {
            fn lagrangian_of<D: num_dual::DualNum<Primitive = f64> + Copy>(
                &self, q: &[D], v: &[D], t: D,
            ) -> D {
                self.lagrangian(q, v, t)
            }
            fn forces_of<D: num_dual::DualNum<Primitive = f64> + Copy>(
                &self, q: &[D], v: &[D], u: &[D], t: D,
            ) -> Vec<D> {
                self.generalized_forces(q, v, u, t).to_vec()
            }
            fn gap_of<D: num_dual::DualNum<Primitive = f64> + Copy>(
                &self, contact: usize, q: &[D], t: D,
            ) -> D {
                self.gaps(q, t)[contact]
            }
            $(fn along_of<D: num_dual::DualNum<Primitive = f64> + Copy>(
                &self, _contact: usize, q: &[D],
            ) -> Option<Vec<D>> {
                Some($along(self, q))
            })?
            $(fn sliding_of<D: num_dual::DualNum<Primitive = f64> + Copy>(
                &self, contact: usize, q: &[D], v: &[D], t: D,
            ) -> Option<D> {
                $sliding(self, contact, q, v, t)
            })?
            $(fn path_of<D: num_dual::DualNum<Primitive = f64> + Copy>(&self, x: &[D]) -> Vec<D> {
                $path(self, x)
            }
            fn terminal_of<D: num_dual::DualNum<Primitive = f64> + Copy>(&self, z: &[D]) -> Vec<D> {
                $terminal(self, z)
            }
            )?
        }
    };
}

/// `x` split into coordinates, velocities, controls and time.
fn split<'a, M: Oracle, D: DualNum<Primitive = f64> + Copy>(
    model: &M,
    x: &'a [D],
) -> (&'a [D], &'a [D], &'a [D], D) {
    let declaration = model.declaration();
    let (n, nu) = (declaration.coordinates.len(), declaration.controls.len());
    let t = if declaration.explicit_time {
        x[2 * n + nu]
    } else {
        D::from(0.0)
    };
    (&x[..n], &x[n..2 * n], &x[2 * n..2 * n + nu], t)
}

fn constant<D: DualNum<Primitive = f64> + Copy>(x: &[D]) -> Vec<HyperDual<D>> {
    x.iter().map(|&x| HyperDual::from_re(x)).collect()
}

/// Mass matrix, row by row.
pub(crate) fn mass<M: Oracle, D: DualNum<Primitive = f64> + Copy>(
    model: &M,
    x: &[D],
) -> Vec<Vec<D>> {
    let (q, v, _, t) = split(model, x);
    let n = q.len();
    let mut m = vec![vec![D::from(0.0); n]; n];
    for i in 0..n {
        for j in 0..=i {
            let mut v = constant(v);
            v[i].eps1 += D::from(1.0);
            v[j].eps2 += D::from(1.0);
            let entry = model
                .lagrangian_of(&constant(q), &v, HyperDual::from_re(t))
                .eps1eps2;
            (m[i][j], m[j][i]) = (entry, entry);
        }
    }
    m
}

/// Free acceleration from the Lagrangian by hyper-dual numbers and elimination.
pub(crate) fn acceleration<M: Oracle, D: DualNum<Primitive = f64> + Copy>(
    model: &M,
    x: &[D],
) -> Vec<D> {
    let (q, v, u, t) = split(model, x);
    let n = q.len();
    let mut right = model.forces_of(q, v, u, t);
    for (i, right) in right.iter_mut().enumerate() {
        // First direction: along the motion; second: the velocity, then the coordinate.
        let mut moving: Vec<HyperDual<D>> = constant(q);
        for (moving, &v) in moving.iter_mut().zip(v) {
            moving.eps1 = v;
        }
        let mut velocity = constant(v);
        velocity[i].eps2 = D::from(1.0);
        let mut time = HyperDual::from_re(t);
        time.eps1 = D::from(1.0);
        *right -= model.lagrangian_of(&moving, &velocity, time).eps1eps2;
        let mut displaced: Vec<Dual<D>> = q.iter().map(|&q| Dual::from_re(q)).collect();
        displaced[i].eps = D::from(1.0);
        let v: Vec<Dual<D>> = v.iter().map(|&v| Dual::from_re(v)).collect();
        *right += model.lagrangian_of(&displaced, &v, Dual::from_re(t)).eps;
    }
    solve(mass(model, x), right, n)
}

#[expect(
    clippy::needless_range_loop,
    reason = "indices of a matrix read better"
)]
/// Gaussian elimination without pivoting, for positive definite matrices.
fn solve<D: DualNum<Primitive = f64> + Copy>(
    mut m: Vec<Vec<D>>,
    mut b: Vec<D>,
    n: usize,
) -> Vec<D> {
    for k in 0..n {
        for i in k + 1..n {
            let factor = m[i][k] / m[k][k];
            for j in k..n {
                let pivot = m[k][j];
                m[i][j] -= factor * pivot;
            }
            let pivot = b[k];
            b[i] -= factor * pivot;
        }
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            let known = b[k];
            b[i] -= m[i][k] * known;
        }
        b[i] /= m[i][i];
    }
    b
}

/// Gradient of a gap.
fn normal<M: Oracle, D: DualNum<Primitive = f64> + Copy>(
    model: &M,
    contact: usize,
    x: &[D],
) -> Vec<D> {
    let (q, _, _, t) = split(model, x);
    (0..q.len())
        .map(|i| {
            let mut q: Vec<Dual<D>> = q.iter().map(|&q| Dual::from_re(q)).collect();
            q[i].eps = D::from(1.0);
            model.gap_of(contact, &q, Dual::from_re(t)).eps
        })
        .collect()
}

/// `H b`, with the inverse inertia of the system whose held coordinates are locked.
fn mobility<M: Oracle, D: DualNum<Primitive = f64> + Copy>(
    model: &M,
    contact: usize,
    x: &[D],
    mut b: Vec<D>,
) -> Vec<D> {
    let mut m = mass(model, x);
    let n = m.len();
    for &held in model.declaration().contacts[contact].held {
        m[held].fill(D::from(0.0));
        for row in &mut m {
            row[held] = D::from(0.0);
        }
        m[held][held] = D::from(1.0);
        b[held] = D::from(0.0);
    }
    solve(m, b, n)
}

fn inner<D: DualNum<Primitive = f64> + Copy>(a: &[D], b: &[D]) -> D {
    a.iter()
        .zip(b)
        .fold(D::from(0.0), |sum, (&a, &b)| sum + a * b)
}

/// Rows `(g, v_n, d)` of a contact.
pub(crate) fn contact_rows<M: Oracle, D: DualNum<Primitive = f64> + Copy>(
    model: &M,
    contact: usize,
    x: &[D],
) -> Vec<D> {
    let (q, v, _, t) = split(model, x);
    let moving: Vec<Dual<D>> = q.iter().zip(v).map(|(&q, &v)| Dual::new(q, v)).collect();
    let motion = model.gap_of(contact, &moving, Dual::new(t, D::from(1.0)));
    let normal = normal(model, contact, x);
    let w = model
        .along_of(contact, q)
        .unwrap_or_else(|| mobility(model, contact, x, normal.clone()));
    let product = inner(&normal, &w);
    let mut rows = vec![motion.re, motion.eps];
    rows.extend(w.iter().map(|&w| w / product));
    rows
}

/// Sliding velocity and its derivatives by the velocities, for a contact with friction.
fn slip<M: Oracle, D: DualNum<Primitive = f64> + Copy>(
    model: &M,
    contact: usize,
    x: &[D],
) -> (D, Vec<D>) {
    let (q, v, _, t) = split(model, x);
    let sliding = |q: &[Dual<D>], v: &[Dual<D>], t| {
        model
            .sliding_of(contact, q, v, t)
            .expect("the oracle knows the sliding velocity")
    };
    let q: Vec<Dual<D>> = q.iter().map(|&q| Dual::from_re(q)).collect();
    let v: Vec<Dual<D>> = v.iter().map(|&v| Dual::from_re(v)).collect();
    let t = Dual::from_re(t);
    let tangent = (0..v.len())
        .map(|i| {
            let mut v = v.clone();
            v[i].eps = D::from(1.0);
            sliding(&q, &v, t).eps
        })
        .collect();
    (sliding(&q, &v, t).re, tangent)
}

/// Rows `(v_t, e)` of a contact with friction.
fn tangent_rows<M: Oracle, D: DualNum<Primitive = f64> + Copy>(
    model: &M,
    contact: usize,
    x: &[D],
) -> Vec<D> {
    let (velocity, tangent) = slip(model, contact, x);
    let normal = normal(model, contact, x);
    let inverse_inertia = inner(&normal, &mobility(model, contact, x, normal.clone()));
    let mut rows = vec![velocity];
    let e = mobility(model, contact, x, tangent);
    rows.extend(e.iter().map(|&e| e / inverse_inertia));
    rows
}

/// Relative tolerance: products and quotients of a few hundred roundings, times the condition of the
/// mass matrices in these tests (below 1e3) or of the directions of contacts ([`STEEPEST`]).
pub(crate) const TOLERANCE: f64 = 1e-12;

/// Largest condition of a direction `w / (n w)` of a contact with the normal `n` that is compared: `|n| |w| / (n w)`. One that is
/// declared may be tangent to the surface, where there is none.
const STEEPEST: f64 = 1e3;

/// Whether the direction of a contact is too near to its surface to be compared.
fn is_tangent<M: Oracle>(model: &M, contact: usize, x: &[f64]) -> bool {
    let Some(w) = model.along_of(contact, &x[..model.declaration().coordinates.len()]) else {
        return false;
    };
    let normal = normal(model, contact, x);
    let lengths = inner(&normal, &normal) * inner(&w, &w);
    lengths.sqrt() > STEEPEST * inner(&normal, &w).abs()
}

fn agree(what: &str, found: &[f64], wanted: &[f64]) -> Result<(), String> {
    if found.len() != wanted.len() {
        return Err(format!(
            "{what}: {} instead of {} values",
            found.len(),
            wanted.len()
        ));
    }
    let scale = wanted.iter().fold(1.0_f64, |scale, w| scale.max(w.abs()));
    for (i, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        let error = (found - wanted).abs();
        if error.is_nan() || error > TOLERANCE * scale {
            return Err(format!(
                "{what}[{i}]: {found:e} instead of {wanted:e}, relative error {:e}",
                error / scale
            ));
        }
    }
    Ok(())
}

fn dense(pattern: &SparsityPattern, values: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0; pattern.rows * pattern.columns];
    for (&(row, column), value) in pattern.entries.iter().zip(values) {
        all[row as usize * pattern.columns + column as usize] = *value;
    }
    all
}

fn check_first(
    what: &str,
    pattern: &SparsityPattern,
    values: &[f64],
    x: &[f64],
    f: impl Fn(&[Dual64]) -> Vec<Dual64>,
) -> Result<(), String> {
    if pattern.columns != x.len() {
        return Err(format!(
            "{what}: {} columns for {} inputs",
            pattern.columns,
            x.len()
        ));
    }
    let mut wanted = vec![0.0; pattern.rows * pattern.columns];
    for column in 0..x.len() {
        let mut seeded: Vec<Dual64> = x.iter().map(|&x| Dual64::from_re(x)).collect();
        seeded[column].eps = 1.0;
        for (row, value) in f(&seeded).into_iter().enumerate() {
            wanted[row * pattern.columns + column] = value.eps;
        }
    }
    agree(what, &dense(pattern, values), &wanted)
}

fn check_second(
    what: &str,
    pattern: &SparsityPattern,
    values: &[f64],
    x: &[f64],
    multipliers: &[f64],
    f: impl Fn(&[HyperDual64]) -> Vec<HyperDual64>,
) -> Result<(), String> {
    let n = x.len();
    let mut wanted = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let mut seeded: Vec<HyperDual64> = x.iter().map(|&x| HyperDual64::from_re(x)).collect();
            seeded[i].eps1 = 1.0;
            seeded[j].eps2 = 1.0;
            wanted[i * n + j] = f(&seeded)
                .iter()
                .zip(multipliers)
                .map(|(value, multiplier)| value.eps1eps2 * multiplier)
                .sum();
        }
    }
    agree(what, &dense(pattern, values), &wanted)
}

/// Compares everything that a scene derives with the independent route at one point.
///
/// # Errors
/// The first disagreement.
pub(crate) fn compare<M: Oracle>(model: &M, x: &[f64], weights: &[f64]) -> Result<(), String> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut m = vec![0.0; n * n];
    model.mass_matrix(x, &mut m);
    agree("mass matrix", &m, &mass(model, x).concat())?;
    let mut a = vec![0.0; n];
    model.free_acceleration(x, &mut a);
    agree("free acceleration", &a, &acceleration(model, x))?;
    let pattern = &declaration.free_jacobian;
    let mut values = vec![f64::NAN; pattern.entries.len()];
    model.free_jacobian(x, &mut values);
    check_first("free jacobian", pattern, &values, x, |x| {
        acceleration(model, x)
    })?;
    let pattern = &declaration.free_hessian;
    let mut values = vec![f64::NAN; pattern.entries.len()];
    model.free_hessian(x, &weights[..n], &mut values);
    check_second("free hessian", pattern, &values, x, &weights[..n], |x| {
        acceleration(model, x)
    })?;
    energy(model, x)?;
    for (i, contact) in declaration.contacts.iter().enumerate() {
        if is_tangent(model, i, x) {
            continue;
        }
        let wanted = contact_rows(model, i, x);
        let mut point = vec![f64::NAN; contact_point::length(n)];
        model.contact(i, x, &mut point);
        let mut rows = vec![model.gap(i, x), point[contact_point::NORMAL_VELOCITY]];
        rows.extend(&point[contact_point::direction(n)..]);
        agree("contact", &rows, &wanted)?;
        check_point(model, i, x, &point)?;
        let mut values = vec![f64::NAN; contact.jacobian.entries.len()];
        model.contact_jacobian(i, x, &mut values);
        check_first("contact jacobian", &contact.jacobian, &values, x, |x| {
            contact_rows(model, i, x)
        })?;
        let mut values = vec![f64::NAN; contact.hessian.entries.len()];
        model.contact_hessian(i, x, &weights[..2 + n], &mut values);
        check_second(
            "contact hessian",
            &contact.hessian,
            &values,
            x,
            &weights[..2 + n],
            |x| contact_rows(model, i, x),
        )?;
        check_friction(model, i, x, weights)?;
    }
    check_optimal_control(model, x, weights)
}

/// Path functions at `x`, and terminal functions at the coordinates and velocities in it and a final time.
fn check_optimal_control<M: Oracle>(model: &M, x: &[f64], weights: &[f64]) -> Result<(), String> {
    let declaration = model.declaration();
    let Some(task) = &declaration.optimal_control else {
        return Ok(());
    };
    let multipliers = &weights[..task.path_functions()];
    let mut values = vec![f64::NAN; multipliers.len()];
    model.path_functions(x, &mut values);
    agree("path functions", &values, &model.path_of(x))?;
    let pattern = &task.path_jacobian;
    let mut values = vec![f64::NAN; pattern.entries.len()];
    model.path_jacobian(x, &mut values);
    check_first("path jacobian", pattern, &values, x, |x| model.path_of(x))?;
    let pattern = &task.path_hessian;
    let mut values = vec![f64::NAN; pattern.entries.len()];
    model.path_hessian(x, multipliers, &mut values);
    check_second("path hessian", pattern, &values, x, multipliers, |x| {
        model.path_of(x)
    })?;

    let mut z = x[..2 * declaration.coordinates.len()].to_vec();
    z.push(1.7);
    let multipliers = &weights[..task.terminal_functions()];
    let mut values = vec![f64::NAN; multipliers.len()];
    model.terminal_functions(&z, &mut values);
    agree("terminal functions", &values, &model.terminal_of(&z))?;
    let pattern = &task.terminal_jacobian;
    let mut values = vec![f64::NAN; pattern.entries.len()];
    model.terminal_jacobian(&z, &mut values);
    check_first("terminal jacobian", pattern, &values, &z, |z| {
        model.terminal_of(z)
    })?;
    let pattern = &task.terminal_hessian;
    let mut values = vec![f64::NAN; pattern.entries.len()];
    model.terminal_hessian(&z, multipliers, &mut values);
    check_second("terminal hessian", pattern, &values, &z, multipliers, |z| {
        model.terminal_of(z)
    })
}

/// The tangential side of a contact, if it has friction.
fn check_friction<M: Oracle>(
    model: &M,
    contact: usize,
    x: &[f64],
    weights: &[f64],
) -> Result<(), String> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let Some(friction) = &declaration.contacts[contact].friction else {
        return Ok(());
    };
    let mut point = vec![f64::NAN; tangent_point::length(n)];
    model.tangent(contact, x, &mut point);
    let mut rows = vec![point[tangent_point::SLIDING_VELOCITY]];
    rows.extend(&point[tangent_point::direction(n)..]);
    agree("tangent", &rows, &tangent_rows(model, contact, x))?;
    let (_, tangent) = slip(model, contact, x);
    agree("b", &point[tangent_point::TANGENT..][..n], &tangent)?;
    // v_t' = b' v' + curvature along a motion whose velocities do not change.
    let (q, v, _, t) = split(model, x);
    let moving: Vec<Dual64> = q.iter().zip(v).map(|(&q, &v)| Dual64::new(q, v)).collect();
    let constant: Vec<Dual64> = v.iter().map(|&v| Dual64::from_re(v)).collect();
    let rate = model.sliding_of(contact, &moving, &constant, Dual64::new(t, 1.0));
    agree(
        "tangent curvature",
        &[point[tangent_point::CURVATURE]],
        &[rate.map_or(f64::NAN, |rate| rate.eps)],
    )?;
    let mut values = vec![f64::NAN; friction.jacobian.entries.len()];
    model.tangent_jacobian(contact, x, &mut values);
    check_first("tangent jacobian", &friction.jacobian, &values, x, |x| {
        tangent_rows(model, contact, x)
    })?;
    let mut values = vec![f64::NAN; friction.hessian.entries.len()];
    let weights = &weights[..1 + n];
    model.tangent_hessian(contact, x, weights, &mut values);
    check_second(
        "tangent hessian",
        &friction.hessian,
        &values,
        x,
        weights,
        |x| tangent_rows(model, contact, x),
    )
}

/// Normal, curvature and inverse inertia of a contact.
fn check_point<M: Oracle>(
    model: &M,
    contact: usize,
    x: &[f64],
    point: &[f64],
) -> Result<(), String> {
    let (q, v, _, t) = split(model, x);
    let n = q.len();
    let normal = normal(model, contact, x);
    agree("normal", &point[contact_point::NORMAL..][..n], &normal)?;
    let moving: Vec<HyperDual64> = q
        .iter()
        .zip(v)
        .map(|(&q, &v)| HyperDual64::new(q, v, v, 0.0))
        .collect();
    let second = model
        .gap_of(contact, &moving, HyperDual64::new(t, 1.0, 1.0, 0.0))
        .eps1eps2;
    let inertia = inner(&normal, &mobility(model, contact, x, normal.clone()));
    agree(
        "curvature and inverse inertia",
        &[
            point[contact_point::CURVATURE],
            point[contact_point::INVERSE_INERTIA],
        ],
        &[second, inertia],
    )
}

/// Kinetic energy is half the quadratic form of the mass matrix for these scenes; the potential is what
/// remains of the Lagrangian at rest.
fn energy<M: Oracle>(model: &M, x: &[f64]) -> Result<(), String> {
    let (q, v, _, t) = split(model, x);
    let rest = model.lagrangian_of(q, &vec![0.0; q.len()], t);
    let power: f64 = (0..q.len())
        .map(|i| {
            let mut v: Vec<Dual64> = v.iter().map(|&v| Dual64::from_re(v)).collect();
            v[i].eps = 1.0;
            let q: Vec<Dual64> = q.iter().map(|&q| Dual64::from_re(q)).collect();
            model.lagrangian_of(&q, &v, Dual64::from_re(t)).eps * v[i].re
        })
        .sum();
    let kinetic = power - model.lagrangian_of(q, v, t) + rest;
    let mut found = [f64::NAN; 2];
    model.energy(x, &mut found);
    agree("energy", &found, &[kinetic, -rest])
}
