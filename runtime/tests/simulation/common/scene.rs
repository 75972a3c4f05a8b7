//! A scene given by mass matrix, forces, potential and gaps, generic over dual numbers, as a [`Model`].

use hangtime::model::{
    ContactDeclaration, ControlDeclaration, CoordinateDeclaration, Declaration,
    FrictionDeclaration, ImpactLaw, Model, SparsityPattern, contact_point, tangent_point,
};
use num_dual::{Dual, Dual2, DualNum, HyperDual};

/// A real or dual number.
pub trait Number: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Number for T {}

/// A mechanical system `M(q) v' = f(q, v, u)` with `N` coordinates, `U` controls and gaps.
pub trait Scene<const N: usize, const U: usize>: Clone + Send + Sync + 'static {
    /// Names of the coordinates.
    fn coordinates(&self) -> [&'static str; N];
    /// Names of the contacts.
    fn contacts(&self) -> &'static [&'static str];
    /// Mass matrix.
    fn mass<D: Number>(&self, q: &[D; N]) -> [[D; N]; N];
    /// Right-hand side `f` of the equations of motion, everything but contact forces.
    fn force<D: Number>(&self, q: &[D; N], v: &[D; N], u: &[D; U]) -> [D; N];
    /// Potential energy.
    fn potential(&self, q: &[f64; N]) -> f64;
    /// Gap of a contact.
    fn gap<D: Number>(&self, contact: usize, q: &[D; N]) -> D;
    /// Impulse direction of a contact, up to its length, if it is not `M^-1 grad g`.
    fn direction<D: Number>(&self, _contact: usize, _q: &[D; N]) -> Option<[D; N]> {
        None
    }
    /// Coefficient of restitution of a contact.
    fn restitution(&self, _contact: usize) -> f64 {
        0.0
    }
    /// Coefficient of friction of a contact.
    fn friction(&self, _contact: usize) -> f64 {
        0.0
    }
    /// Sliding velocity of a contact, linear in `v` up to a constant, if it declares friction.
    fn sliding<D: Number>(&self, _contact: usize, _q: &[D; N], _v: &[D; N]) -> Option<D> {
        None
    }
}

/// A [`Scene`] with the declaration and the dense derivatives that a [`Model`] has.
#[derive(Debug, Clone)]
pub struct HandWritten<S, const N: usize, const U: usize> {
    pub scene: S,
    declaration: &'static Declaration,
}

impl<S: Scene<N, U>, const N: usize, const U: usize> HandWritten<S, N, U> {
    /// Declares the scene. What is declared lives as long as the test program.
    pub fn new(scene: S) -> Self {
        let coordinates: Vec<_> = scene
            .coordinates()
            .into_iter()
            .map(|name| CoordinateDeclaration {
                name,
                unit: "m",
                documentation: "",
            })
            .collect();
        let controls = vec![
            ControlDeclaration {
                name: "u",
                unit: "N",
                documentation: "",
            };
            U
        ];
        let inputs = 2 * N + U;
        let contacts: Vec<_> = scene
            .contacts()
            .iter()
            .enumerate()
            .map(|(i, &name)| ContactDeclaration {
                name,
                unit: "m",
                law: if scene.restitution(i) == 0.0 {
                    ImpactLaw::Inelastic
                } else {
                    ImpactLaw::Restitution
                },
                friction: scene
                    .sliding(i, &[1.0; N], &[1.0; N])
                    .map(|_| FrictionDeclaration {
                        jacobian: dense(1 + N, inputs),
                        hessian: triangle(inputs),
                    }),
                held: &[],
                custom_direction: scene.direction(i, &[1.0; N]).is_some(),
                jacobian: dense(2 + N, inputs),
                hessian: triangle(inputs),
                documentation: "",
            })
            .collect();
        let declaration = Declaration {
            name: "HandWritten",
            documentation: "",
            parameters: &[],
            coordinates: coordinates.leak(),
            controls: controls.leak(),
            contacts: contacts.leak(),
            explicit_time: false,
            free_jacobian: dense(N, inputs),
            free_hessian: triangle(inputs),
            optimal_control: None,
            kernels: &[],
            equations: &[],
        };
        Self {
            scene,
            declaration: Box::leak(Box::new(declaration)),
        }
    }

    fn split<D: Number>(x: &[D]) -> ([D; N], [D; N], [D; U]) {
        (
            std::array::from_fn(|k| x[k]),
            std::array::from_fn(|k| x[N + k]),
            std::array::from_fn(|k| x[2 * N + k]),
        )
    }

    fn acceleration<D: Number>(&self, x: &[D]) -> [D; N] {
        let (q, v, u) = Self::split(x);
        solve(self.scene.mass(&q), self.scene.force(&q, &v, &u))
    }

    /// `(g, v_n, curvature, D, n, d)`.
    fn point<D: Number>(&self, contact: usize, x: &[D]) -> (D, D, D, D, [D; N], [D; N]) {
        let (q, v, _) = Self::split(x);
        let along: [Dual2<D>; N] = std::array::from_fn(|k| Dual2::new(q[k], v[k], D::from(0.0)));
        let gap = self.scene.gap(contact, &along);
        let normal: [D; N] = std::array::from_fn(|k| {
            let at: [Dual<D>; N] =
                std::array::from_fn(|j| Dual::new(q[j], D::from(if j == k { 1.0 } else { 0.0 })));
            self.scene.gap(contact, &at).eps
        });
        let steepest = solve(self.scene.mass(&q), normal);
        let inverse_inertia = dot(&normal, &steepest);
        let along = self.scene.direction(contact, &q).unwrap_or(steepest);
        let length = dot(&normal, &along);
        (
            gap.re,
            gap.v1,
            gap.v2,
            inverse_inertia,
            normal,
            along.map(|d| d / length),
        )
    }

    /// `(v_t, curvature, b, e)`.
    fn tangent_sides<D: Number>(&self, contact: usize, x: &[D]) -> (D, D, [D; N], [D; N]) {
        let (q, v, _) = Self::split(x);
        let along: [Dual<D>; N] = std::array::from_fn(|k| Dual::new(q[k], v[k]));
        let sliding = self.sliding(contact, &along, &v.map(|v| Dual::new(v, D::from(0.0))));
        let tangent: [D; N] = std::array::from_fn(|k| {
            let at: [Dual<D>; N] =
                std::array::from_fn(|j| Dual::new(v[j], D::from(if j == k { 1.0 } else { 0.0 })));
            self.sliding(contact, &q.map(|q| Dual::new(q, D::from(0.0))), &at)
                .eps
        });
        let (_, _, _, inverse_inertia, _, _) = self.point(contact, x);
        let direction = solve(self.scene.mass(&q), tangent).map(|e| e / inverse_inertia);
        (sliding.re, sliding.eps, tangent, direction)
    }

    fn sliding<D: Number>(&self, contact: usize, q: &[D; N], v: &[D; N]) -> D {
        self.scene
            .sliding(contact, q, v)
            .expect("asked for contacts with friction only")
    }

    fn tangent_rows<D: Number>(&self, contact: usize, x: &[D]) -> Vec<D> {
        let (sliding, _, _, direction) = self.tangent_sides(contact, x);
        let mut rows = vec![sliding];
        rows.extend(direction);
        rows
    }

    fn rows<D: Number>(&self, contact: usize, x: &[D]) -> Vec<D> {
        let (gap, normal_velocity, _, _, _, direction) = self.point(contact, x);
        let mut rows = vec![gap, normal_velocity];
        rows.extend(direction);
        rows
    }
}

impl<S: Scene<N, U>, const N: usize, const U: usize> Model for HandWritten<S, N, U> {
    fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    fn parameter(&self, index: usize) -> f64 {
        panic!("no parameter {index} is declared")
    }

    fn set_parameter(&mut self, index: usize, _value: f64) {
        panic!("no parameter {index} is declared")
    }

    fn start(&self, q: &mut [f64], v: &mut [f64]) {
        q.fill(0.0);
        v.fill(0.0);
    }

    fn horizon(&self) -> Option<f64> {
        None
    }

    fn bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        lower.fill(f64::NEG_INFINITY);
        upper.fill(f64::INFINITY);
    }

    fn free_acceleration(&self, x: &[f64], a: &mut [f64]) {
        a.copy_from_slice(&self.acceleration(x));
    }

    fn free_jacobian(&self, x: &[f64], values: &mut [f64]) {
        jacobian(x, values, |x| self.acceleration(x).to_vec());
    }

    fn free_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        hessian(x, multipliers, values, |x| self.acceleration(x).to_vec());
    }

    fn mass_matrix(&self, x: &[f64], m: &mut [f64]) {
        let (q, _, _) = Self::split(x);
        m.copy_from_slice(self.scene.mass(&q).as_flattened());
    }

    fn energy(&self, x: &[f64], energy: &mut [f64]) {
        let (q, v, _) = Self::split(x);
        let momentum = self.scene.mass(&q).map(|row| dot(&row, &v));
        energy[0] = 0.5 * dot(&momentum, &v);
        energy[1] = self.scene.potential(&q);
    }

    fn gap(&self, contact: usize, x: &[f64]) -> f64 {
        let (q, _, _) = Self::split(x);
        self.scene.gap(contact, &q)
    }

    fn contact(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        let (gap, normal_velocity, curvature, inverse_inertia, normal, direction) =
            self.point(contact, x);
        point[contact_point::GAP] = gap;
        point[contact_point::NORMAL_VELOCITY] = normal_velocity;
        point[contact_point::CURVATURE] = curvature;
        point[contact_point::INVERSE_INERTIA] = inverse_inertia;
        point[contact_point::NORMAL..][..N].copy_from_slice(&normal);
        point[contact_point::direction(N)..][..N].copy_from_slice(&direction);
    }

    fn contact_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        jacobian(x, values, |x| self.rows(contact, x));
    }

    fn contact_hessian(&self, contact: usize, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        hessian(x, multipliers, values, |x| self.rows(contact, x));
    }

    fn restitution(&self, contact: usize) -> f64 {
        self.scene.restitution(contact)
    }

    fn friction(&self, contact: usize) -> f64 {
        self.scene.friction(contact)
    }

    fn tangent(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        let (sliding, curvature, tangent, direction) = self.tangent_sides(contact, x);
        point[tangent_point::SLIDING_VELOCITY] = sliding;
        point[tangent_point::CURVATURE] = curvature;
        point[tangent_point::TANGENT..][..N].copy_from_slice(&tangent);
        point[tangent_point::direction(N)..][..N].copy_from_slice(&direction);
    }

    fn tangent_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        jacobian(x, values, |x| self.tangent_rows(contact, x));
    }

    fn tangent_hessian(&self, contact: usize, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        hessian(x, multipliers, values, |x| self.tangent_rows(contact, x));
    }

    fn boxed(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }
}

fn dense(rows: usize, columns: usize) -> SparsityPattern {
    let entries: Vec<(u32, u32)> = (0..rows as u32)
        .flat_map(|row| (0..columns as u32).map(move |column| (row, column)))
        .collect();
    SparsityPattern {
        rows,
        columns,
        entries: entries.leak(),
    }
}

fn triangle(order: usize) -> SparsityPattern {
    let entries: Vec<(u32, u32)> = (0..order as u32)
        .flat_map(|row| (0..=row).map(move |column| (row, column)))
        .collect();
    SparsityPattern {
        rows: order,
        columns: order,
        entries: entries.leak(),
    }
}

/// Dense Jacobian, row by row.
fn jacobian(x: &[f64], values: &mut [f64], f: impl Fn(&[Dual<f64>]) -> Vec<Dual<f64>>) {
    for column in 0..x.len() {
        let at: Vec<_> = x
            .iter()
            .enumerate()
            .map(|(k, &x)| Dual::new(x, f64::from(k == column)))
            .collect();
        for (row, value) in f(&at).into_iter().enumerate() {
            values[row * x.len() + column] = value.eps;
        }
    }
}

/// Lower triangle of the Hessian of `multipliers' f`, row by row.
fn hessian(
    x: &[f64],
    multipliers: &[f64],
    values: &mut [f64],
    f: impl Fn(&[HyperDual<f64>]) -> Vec<HyperDual<f64>>,
) {
    let mut next = 0;
    for row in 0..x.len() {
        for column in 0..=row {
            let at: Vec<_> = x
                .iter()
                .enumerate()
                .map(|(k, &x)| HyperDual::new(x, f64::from(k == row), f64::from(k == column), 0.0))
                .collect();
            values[next] = f(&at)
                .into_iter()
                .zip(multipliers)
                .map(|(f, multiplier)| f.eps1eps2 * multiplier)
                .sum();
            next += 1;
        }
    }
}

pub fn dot<D: Number, const N: usize>(a: &[D; N], b: &[D; N]) -> D {
    (0..N).fold(D::from(0.0), |sum, k| sum + a[k] * b[k])
}

/// Solves a symmetric positive definite system by elimination without pivoting.
fn solve<D: Number, const N: usize>(mut m: [[D; N]; N], mut right: [D; N]) -> [D; N] {
    for k in 0..N {
        for row in k + 1..N {
            let factor = m[row][k] / m[k][k];
            let pivot = m[k];
            for (entry, pivot) in m[row].iter_mut().zip(pivot) {
                *entry -= factor * pivot;
            }
            let product = factor * right[k];
            right[row] -= product;
        }
    }
    for row in (0..N).rev() {
        for column in row + 1..N {
            let product = m[row][column] * right[column];
            right[row] -= product;
        }
        right[row] /= m[row][row];
    }
    right
}
