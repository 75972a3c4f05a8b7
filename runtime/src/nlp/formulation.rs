//! The user's problem in the solver's form: fixed variables removed, free rows dropped, objective and
//! rows scaled, ranges told from equalities.

use super::scaling::row_scaling;
use super::{Counts, InputError, NlpProblem, Settings};

/// Bounds of this size or larger count as absent.
const INFINITE: f64 = 1e19;

/// A kept constraint row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum RowKind {
    /// `c(x) = value`, scaled.
    Equality(f64),
    /// `lower <= c(x) <= upper`, scaled and relaxed.
    Range(f64, f64),
}

/// An entry of a matrix without fixed variables and free rows.
#[derive(Debug, Clone, Copy)]
struct Kept {
    /// Position in the user's values.
    position: u32,
    row: u32,
    column: u32,
}

/// The reduced problem and the buffers to evaluate it; what nothing was removed from is evaluated in place.
pub(crate) struct Formulation<'a> {
    problem: &'a mut dyn NlpProblem,
    /// Original index of each free variable.
    pub(crate) variables: Vec<usize>,
    /// Original index of each kept row.
    pub(crate) rows: Vec<usize>,
    pub(crate) kinds: Vec<RowKind>,
    /// Relaxed bounds of the free variables; infinite where absent.
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    /// Product constraints `x_i x_j <= sigma`, as free variables.
    pub(crate) products: Vec<(usize, usize)>,
    pub(crate) start: Vec<f64>,
    pub(crate) objective_scale: f64,
    pub(crate) row_scales: Vec<f64>,
    /// Whether a row is scaled.
    is_scaled: bool,
    jacobian: Vec<Kept>,
    hessian: Vec<Kept>,
    /// (row, column) of all entries of the user's Jacobian.
    jacobian_pattern: Vec<(usize, usize)>,
    x_user: Vec<f64>,
    gradient_user: Vec<f64>,
    c_user: Vec<f64>,
    y_user: Vec<f64>,
    jacobian_user: Vec<f64>,
    hessian_user: Vec<f64>,
    pub(crate) counts: Counts,
}

impl<'a> Formulation<'a> {
    /// Reduces `problem`; `products` are pairs of the user's variables, `start` replaces the
    /// problem's own starting point.
    pub(crate) fn new(
        problem: &'a mut dyn NlpProblem,
        settings: &Settings,
        products: &[(usize, usize)],
        start: Option<&[f64]>,
    ) -> Result<Self, InputError> {
        let n_user = problem.variables();
        let m_user = problem.constraints();
        let (mut x_lower, mut x_upper) = (vec![0.0; n_user], vec![0.0; n_user]);
        problem.variable_bounds(&mut x_lower, &mut x_upper);
        let (mut c_lower, mut c_upper) = (vec![0.0; m_user], vec![0.0; m_user]);
        problem.constraint_bounds(&mut c_lower, &mut c_upper);
        let ordered = |name: &dyn Fn() -> String, lower: f64, upper: f64| {
            if lower <= upper {
                Ok(())
            } else {
                Err(InputError::Bounds {
                    name: name(),
                    lower,
                    upper,
                })
            }
        };
        for i in 0..n_user {
            ordered(&|| problem.variable_name(i), x_lower[i], x_upper[i])?;
        }
        for i in 0..m_user {
            ordered(&|| problem.constraint_name(i), c_lower[i], c_upper[i])?;
        }

        let mut x_user = vec![0.0; n_user];
        match start {
            Some(x) if x.len() == n_user => x_user.copy_from_slice(x),
            Some(x) => {
                return Err(InputError::WarmStart {
                    what: "the point",
                    expected: n_user,
                    found: x.len(),
                });
            }
            None => problem.initial_point(&mut x_user),
        }
        if let Some(i) = x_user.iter().position(|x| !x.is_finite()) {
            return Err(InputError::Start {
                name: problem.variable_name(i),
                value: x_user[i],
            });
        }

        let mut variables = Vec::new();
        let mut free = vec![None; n_user];
        for i in 0..n_user {
            if x_lower[i] == x_upper[i] {
                x_user[i] = x_lower[i];
            } else {
                free[i] = Some(variables.len());
                variables.push(i);
            }
        }
        let rows: Vec<usize> = (0..m_user)
            .filter(|&i| c_lower[i] > -INFINITE || c_upper[i] < INFINITE)
            .collect();
        let mut kept = vec![None; m_user];
        for (row, &i) in rows.iter().enumerate() {
            kept[i] = Some(row);
        }

        let jacobian_pattern = problem.jacobian_pattern();
        let hessian_pattern = problem.hessian_pattern();
        check_pattern("jacobian", &jacobian_pattern, m_user, n_user, false)?;
        check_pattern("hessian", &hessian_pattern, n_user, n_user, true)?;
        let size = n_user.max(m_user);
        if u32::try_from(size.max(jacobian_pattern.len()).max(hessian_pattern.len())).is_err() {
            return Err(InputError::Size {
                variables: n_user,
                constraints: m_user,
            });
        }
        let jacobian = kept_entries(&jacobian_pattern, &kept, &free);
        let hessian = kept_entries(&hessian_pattern, &free, &free);

        // scaling at the user's point, projected on the bounds
        for i in 0..n_user {
            x_user[i] = x_user[i].max(x_lower[i]).min(x_upper[i]);
        }
        let mut gradient_user = vec![0.0; n_user];
        let mut jacobian_user = vec![0.0; jacobian_pattern.len()];
        problem.gradient(&x_user, &mut gradient_user);
        problem.jacobian_values(&x_user, &mut jacobian_user);
        let mut largest = vec![0.0_f64; rows.len()];
        for kept in &jacobian {
            let largest = &mut largest[kept.row as usize];
            *largest = largest.max(jacobian_user[kept.position as usize].abs());
        }
        let objective_gradient = variables
            .iter()
            .map(|&i| gradient_user[i].abs())
            .fold(0.0, f64::max);
        let objective_scale = row_scaling(objective_gradient, settings.scaling_gradient);
        let row_scales: Vec<f64> = largest
            .iter()
            .map(|&g| row_scaling(g, settings.scaling_gradient))
            .collect();

        let paired = |i: usize| products.iter().any(|&(a, b)| a == i || b == i);
        let is_paired: Vec<bool> = if products.is_empty() {
            vec![false; n_user]
        } else {
            (0..n_user).map(paired).collect()
        };
        let relax = settings.bound_relaxation;
        let relaxed = |bound: f64, sign: f64| {
            if bound.abs() >= INFINITE {
                sign * f64::INFINITY
            } else {
                bound + sign * relax * bound.abs().max(1.0)
            }
        };
        let (mut lower, mut upper) = (Vec::new(), Vec::new());
        for &i in &variables {
            lower.push(if is_paired[i] {
                x_lower[i]
            } else {
                relaxed(x_lower[i], -1.0)
            });
            upper.push(relaxed(x_upper[i], 1.0));
        }
        let kinds = rows
            .iter()
            .zip(&row_scales)
            .map(|(&i, &scale)| {
                if c_lower[i] == c_upper[i] {
                    RowKind::Equality(scale * c_lower[i])
                } else {
                    RowKind::Range(
                        relaxed(scale * c_lower[i], -1.0),
                        relaxed(scale * c_upper[i], 1.0),
                    )
                }
            })
            .collect();
        let products = products
            .iter()
            .filter_map(|&(a, b)| Some((free[a]?, free[b]?)))
            .collect();
        let start = variables.iter().map(|&i| x_user[i]).collect();
        Ok(Self {
            problem,
            variables,
            rows,
            kinds,
            lower,
            upper,
            products,
            start,
            objective_scale,
            is_scaled: row_scales.iter().any(|&scale| scale != 1.0),
            row_scales,
            jacobian,
            hessian,
            jacobian_pattern,
            x_user,
            gradient_user,
            c_user: vec![0.0; m_user],
            y_user: vec![0.0; m_user],
            jacobian_user,
            hessian_user: vec![0.0; hessian_pattern.len()],
            counts: Counts::default(),
        })
    }

    pub(crate) fn problem(&self) -> &dyn NlpProblem {
        self.problem
    }

    /// (row, column) of the kept Jacobian entries, in the order of [`Formulation::jacobian`].
    pub(crate) fn jacobian_entries(&self) -> impl Iterator<Item = (usize, usize)> + Clone + '_ {
        let entry = |kept: &Kept| (kept.row as usize, kept.column as usize);
        self.jacobian.iter().map(entry)
    }

    /// (row, column) of the kept Hessian entries, in the order of [`Formulation::hessian`].
    pub(crate) fn hessian_entries(&self) -> impl Iterator<Item = (usize, usize)> + Clone + '_ {
        let entry = |kept: &Kept| (kept.row as usize, kept.column as usize);
        self.hessian.iter().map(entry)
    }

    /// The full point; `x` holds the free variables.
    pub(crate) fn full_point(&mut self, x: &[f64]) -> &[f64] {
        for (&i, &value) in self.variables.iter().zip(x) {
            self.x_user[i] = value;
        }
        &self.x_user
    }

    /// Scaled objective.
    pub(crate) fn objective(&mut self, x: &[f64]) -> f64 {
        self.counts.objectives += 1;
        let x = full_point(&self.variables, x, &mut self.x_user);
        self.objective_scale * self.problem.objective(x)
    }

    /// Scaled gradient of the objective.
    pub(crate) fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        let x = full_point(&self.variables, x, &mut self.x_user);
        if gradient.len() == x.len() {
            self.problem.gradient(x, gradient);
        } else {
            self.problem.gradient(x, &mut self.gradient_user);
            for (g, &i) in gradient.iter_mut().zip(&self.variables) {
                *g = self.gradient_user[i];
            }
        }
        if self.objective_scale != 1.0 {
            for g in gradient {
                *g *= self.objective_scale;
            }
        }
    }

    /// Scaled values of the kept rows.
    pub(crate) fn constraint_values(&mut self, x: &[f64], c: &mut [f64]) {
        self.counts.constraints += 1;
        let x = full_point(&self.variables, x, &mut self.x_user);
        if c.len() == self.c_user.len() {
            self.problem.constraint_values(x, c);
        } else {
            self.problem.constraint_values(x, &mut self.c_user);
            for (c, &i) in c.iter_mut().zip(&self.rows) {
                *c = self.c_user[i];
            }
        }
        if self.is_scaled {
            for (c, scale) in c.iter_mut().zip(&self.row_scales) {
                *c *= scale;
            }
        }
    }

    /// Scaled Jacobian of the kept rows and columns.
    pub(crate) fn jacobian(&mut self, x: &[f64], values: &mut [f64]) {
        self.counts.jacobians += 1;
        let x = full_point(&self.variables, x, &mut self.x_user);
        if values.len() == self.jacobian_user.len() {
            self.problem.jacobian_values(x, values);
        } else {
            self.problem.jacobian_values(x, &mut self.jacobian_user);
            for (value, kept) in values.iter_mut().zip(&self.jacobian) {
                *value = self.jacobian_user[kept.position as usize];
            }
        }
        if self.is_scaled {
            for (value, kept) in values.iter_mut().zip(&self.jacobian) {
                *value *= self.row_scales[kept.row as usize];
            }
        }
    }

    /// Hessian of `weight f + y' c` in scaled quantities.
    pub(crate) fn hessian(&mut self, x: &[f64], weight: f64, y: &[f64], values: &mut [f64]) {
        self.counts.hessians += 1;
        let x = full_point(&self.variables, x, &mut self.x_user);
        let weight = weight * self.objective_scale;
        let y = if self.is_scaled || y.len() != self.y_user.len() {
            // rows that are not kept have no multiplier
            for ((&i, scale), y) in self.rows.iter().zip(&self.row_scales).zip(y) {
                self.y_user[i] = scale * y;
            }
            &self.y_user
        } else {
            y
        };
        if values.len() == self.hessian_user.len() {
            self.problem.hessian_values(x, weight, y, values);
            return;
        }
        self.problem
            .hessian_values(x, weight, y, &mut self.hessian_user);
        for (value, kept) in values.iter_mut().zip(&self.hessian) {
            *value = self.hessian_user[kept.position as usize];
        }
    }

    /// The full unscaled problem at the full point: objective, gradient, constraints and Jacobian entries.
    pub(crate) fn unscaled(&mut self, x: &[f64]) -> Unscaled<'_> {
        self.full_point(x);
        let f = self.problem.objective(&self.x_user);
        self.problem.gradient(&self.x_user, &mut self.gradient_user);
        self.problem
            .constraint_values(&self.x_user, &mut self.c_user);
        self.problem
            .jacobian_values(&self.x_user, &mut self.jacobian_user);
        Unscaled {
            objective: f,
            gradient: &self.gradient_user,
            constraints: &self.c_user,
            pattern: &self.jacobian_pattern,
            jacobian: &self.jacobian_user,
        }
    }
}

/// The values of the full problem at a point, unscaled.
pub(crate) struct Unscaled<'a> {
    pub(crate) objective: f64,
    pub(crate) gradient: &'a [f64],
    pub(crate) constraints: &'a [f64],
    /// (row, column) of the entries of the Jacobian.
    pub(crate) pattern: &'a [(usize, usize)],
    pub(crate) jacobian: &'a [f64],
}

fn check_pattern(
    matrix: &'static str,
    pattern: &[(usize, usize)],
    rows: usize,
    columns: usize,
    lower: bool,
) -> Result<(), InputError> {
    match pattern
        .iter()
        .find(|&&(i, j)| i >= rows || j >= columns || (lower && j > i))
    {
        None => Ok(()),
        Some(&(row, column)) => Err(InputError::Pattern {
            matrix,
            row,
            column,
            rows,
            columns,
        }),
    }
}

fn kept_entries(
    pattern: &[(usize, usize)],
    rows: &[Option<usize>],
    columns: &[Option<usize>],
) -> Vec<Kept> {
    let mut entries = Vec::with_capacity(pattern.len());
    entries.extend(pattern.iter().enumerate().filter_map(|(k, &(i, j))| {
        Some(Kept {
            position: k as u32,
            row: rows[i]? as u32,
            column: columns[j]? as u32,
        })
    }));
    entries
}

/// The full point in the user's variables: `x` itself if none is fixed, or else `full` with the free `variables` set.
fn full_point<'p>(variables: &[usize], x: &'p [f64], full: &'p mut [f64]) -> &'p [f64] {
    if variables.len() == full.len() {
        return x;
    }
    for (&i, &value) in variables.iter().zip(x) {
        full[i] = value;
    }
    full
}
