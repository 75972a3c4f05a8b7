//! The user's problem in the solver's form: fixed variables removed, free rows dropped, objective and
//! rows scaled, ranges told from equalities.

use super::scaling::row_scaling;
use crate::nlp::{Fault, InputError, NlpProblem};
use crate::seconds::timed;

/// Bounds of this size or larger count as absent.
const INFINITE: f64 = 1e19;

/// A kept constraint row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum RowKind {
    /// `c(x) = value`, scaled.
    Equality(f64),
    /// `lower <= c(x) <= upper`, scaled.
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
    /// Unit of the objective as it was given, and factor of the objective with what scales its slopes in that unit.
    pub(crate) objective_unit: f64,
    pub(crate) objective_scale: f64,
    pub(crate) row_scales: Vec<f64>,
    /// Whether a row is scaled.
    is_scaled: bool,
    entries: Entries,
    user: UserValues,
    /// CPU time of evaluations \[s\].
    pub(crate) evaluate: f64,
}

/// Patterns of the derivatives.
struct Entries {
    jacobian: Vec<Kept>,
    hessian: Vec<Kept>,
    /// (row, column) of all entries of the user's Jacobian.
    user_jacobian: Vec<(usize, usize)>,
}

/// Buffers in the user's variables and rows.
struct UserValues {
    x: Vec<f64>,
    gradient: Vec<f64>,
    c: Vec<f64>,
    y: Vec<f64>,
    jacobian: Vec<f64>,
    hessian: Vec<f64>,
}

/// Bounds as the user gave them.
struct Bounds {
    x_lower: Vec<f64>,
    x_upper: Vec<f64>,
    c_lower: Vec<f64>,
    c_upper: Vec<f64>,
}

impl Bounds {
    /// The bounds of a problem.
    ///
    /// # Errors
    /// [`InputError`] names the first variable or row whose bounds are not in order.
    fn of(problem: &dyn NlpProblem) -> Result<Self, InputError> {
        let (n, m) = (problem.variables(), problem.constraints());
        let mut bounds = Self {
            x_lower: vec![0.0; n],
            x_upper: vec![0.0; n],
            c_lower: vec![0.0; m],
            c_upper: vec![0.0; m],
        };
        problem.variable_bounds(&mut bounds.x_lower, &mut bounds.x_upper);
        problem.constraint_bounds(&mut bounds.c_lower, &mut bounds.c_upper);
        let variables = bounds.x_lower.iter().zip(&bounds.x_upper).enumerate();
        let rows = bounds.c_lower.iter().zip(&bounds.c_upper).enumerate();
        for (is_row, (i, (&lower, &upper))) in variables
            .map(|bounds| (false, bounds))
            .chain(rows.map(|bounds| (true, bounds)))
        {
            // neither is not a number
            let in_order = lower <= upper;
            if !in_order {
                let name = if is_row {
                    problem.constraint_name(i)
                } else {
                    problem.variable_name(i)
                };
                return Err(InputError::from(Fault::Bounds { name, lower, upper }));
            }
        }
        Ok(bounds)
    }

    /// Whether variable `i` can move.
    fn is_free(&self, i: usize) -> bool {
        self.x_lower[i] != self.x_upper[i]
    }

    /// Holds variables without bounds at `x` that nothing depends on: they would make every Newton matrix singular.
    fn hold_idle(
        &mut self,
        x: &[f64],
        gradient: &[f64],
        [jacobian, hessian, products]: [&[(usize, usize)]; 3],
    ) {
        let bounds = self.x_lower.iter().zip(&self.x_upper);
        let mut is_idle: Vec<bool> = (bounds.zip(gradient))
            .map(|((&l, &u), g)| *g == 0.0 && l <= -INFINITE && u >= INFINITE)
            .collect();
        for &(_, i) in jacobian {
            is_idle[i] = false;
        }
        for &(i, j) in hessian.iter().chain(products) {
            (is_idle[i], is_idle[j]) = (false, false);
        }
        for (i, _) in is_idle.iter().enumerate().filter(|(_, is_idle)| **is_idle) {
            (self.x_lower[i], self.x_upper[i]) = (x[i], x[i]);
        }
    }

    /// Whether row `i` has a bound.
    fn is_kept(&self, i: usize) -> bool {
        self.c_lower[i] > -INFINITE || self.c_upper[i] < INFINITE
    }

    /// Bounds of the free variables, infinite where there is none.
    fn variable_bounds(&self, variables: &[usize]) -> (Vec<f64>, Vec<f64>) {
        let lower = |&i: &usize| bound(self.x_lower[i], f64::NEG_INFINITY);
        let upper = |&i: &usize| bound(self.x_upper[i], f64::INFINITY);
        (
            variables.iter().map(lower).collect(),
            variables.iter().map(upper).collect(),
        )
    }

    /// Equalities and ranges of the kept rows, scaled.
    fn kinds(&self, rows: &[usize], scales: &[f64]) -> Vec<RowKind> {
        let kind = |(&i, &scale): (&usize, &f64)| {
            if self.c_lower[i] == self.c_upper[i] {
                RowKind::Equality(scale * self.c_lower[i])
            } else {
                RowKind::Range(
                    bound(scale * self.c_lower[i], f64::NEG_INFINITY),
                    bound(scale * self.c_upper[i], f64::INFINITY),
                )
            }
        };
        rows.iter().zip(scales).map(kind).collect()
    }
}

/// A bound, or `none` where its size says that there is none.
fn bound(value: f64, none: f64) -> f64 {
    if value.abs() < INFINITE { value } else { none }
}

/// Which of some things are kept, in order.
struct Numbering {
    /// Old index of each kept one.
    old: Vec<usize>,
    /// New index of each.
    new: Vec<Option<usize>>,
}

impl Numbering {
    fn new(length: usize, is_kept: impl Fn(usize) -> bool) -> Self {
        let old: Vec<usize> = (0..length).filter(|&i| is_kept(i)).collect();
        let mut new = vec![None; length];
        for (k, &i) in old.iter().enumerate() {
            new[i] = Some(k);
        }
        Self { old, new }
    }
}

/// The point to start from, the problem's own without another.
///
/// # Errors
/// [`InputError`] for a point of the wrong length, [`InputError`] names a component that is not finite.
fn starting_point(problem: &dyn NlpProblem, start: Option<&[f64]>) -> Result<Vec<f64>, InputError> {
    let n = problem.variables();
    let mut x = vec![0.0; n];
    match start {
        Some(start) if start.len() == n => x.copy_from_slice(start),
        Some(start) => {
            return Err(InputError::from(Fault::WarmStart {
                what: "the point",
                expected: n,
                found: start.len(),
            }));
        }
        None => problem.initial_point(&mut x),
    }
    match x.iter().position(|x| !x.is_finite()) {
        Some(i) => Err(InputError::from(Fault::Start {
            name: problem.variable_name(i),
            value: x[i],
        })),
        None => Ok(x),
    }
}

/// Scales of the kept rows by their largest derivatives.
fn row_scales(jacobian: &[Kept], values: &[f64], rows: usize) -> Vec<f64> {
    let mut largest = vec![0.0_f64; rows];
    for kept in jacobian {
        let largest = &mut largest[kept.row as usize];
        *largest = largest.max(values[kept.position as usize].abs());
    }
    largest.into_iter().map(row_scaling).collect()
}

impl<'a> Formulation<'a> {
    /// Reduces `problem`; `products` are pairs of the user's variables, `start` replaces the
    /// problem's own starting point; the objective is scaled in `objective_unit`.
    pub(crate) fn new(
        problem: &'a mut dyn NlpProblem,
        products: &[(usize, usize)],
        start: Option<&[f64]>,
        objective_unit: f64,
    ) -> Result<Self, InputError> {
        let mut bounds = Bounds::of(problem)?;
        let mut x_user = starting_point(problem, start)?;
        let rows = Numbering::new(bounds.c_lower.len(), |i| bounds.is_kept(i));
        let (n_user, m_user) = (x_user.len(), bounds.c_lower.len());
        let jacobian_pattern = problem.jacobian_pattern();
        let hessian_pattern = problem.hessian_pattern();
        check_pattern("jacobian", &jacobian_pattern, m_user, n_user, false)?;
        check_pattern("hessian", &hessian_pattern, n_user, n_user, true)?;
        let size = n_user.max(m_user);
        if u32::try_from(size.max(jacobian_pattern.len()).max(hessian_pattern.len())).is_err() {
            return Err(InputError::from(Fault::Size {
                variables: n_user,
                constraints: m_user,
            }));
        }
        // scaling at the user's point, projected on the bounds
        for (i, x) in x_user.iter_mut().enumerate() {
            *x = x.max(bounds.x_lower[i]).min(bounds.x_upper[i]);
        }
        let mut gradient_user = vec![0.0; n_user];
        let mut jacobian_user = vec![0.0; jacobian_pattern.len()];
        problem.gradient(&x_user, &mut gradient_user);
        problem.jacobian_values(&x_user, &mut jacobian_user);
        let patterns = [&jacobian_pattern, &hessian_pattern, products];
        bounds.hold_idle(&x_user, &gradient_user, patterns);
        let free = Numbering::new(n_user, |i| bounds.is_free(i));
        let jacobian = kept_entries(&jacobian_pattern, &rows.new, &free.new);
        let hessian = kept_entries(&hessian_pattern, &free.new, &free.new);
        let row_scales = row_scales(&jacobian, &jacobian_user, rows.old.len());
        let of_free = |i: &usize| gradient_user[*i].abs();
        let largest = free.old.iter().map(of_free).fold(0.0, f64::max);
        let (lower, upper) = bounds.variable_bounds(&free.old);
        let paired = |&(a, b): &(usize, usize)| Some((free.new[a]?, free.new[b]?));
        Ok(Self {
            problem,
            kinds: bounds.kinds(&rows.old, &row_scales),
            lower,
            upper,
            products: products.iter().filter_map(paired).collect(),
            start: free.old.iter().map(|&i| x_user[i]).collect(),
            variables: free.old,
            rows: rows.old,
            objective_unit,
            objective_scale: row_scaling(largest / objective_unit) / objective_unit,
            is_scaled: row_scales.iter().any(|&scale| scale != 1.0),
            row_scales,
            entries: Entries {
                jacobian,
                hessian,
                user_jacobian: jacobian_pattern,
            },
            user: UserValues {
                x: x_user,
                gradient: gradient_user,
                c: vec![0.0; m_user],
                y: vec![0.0; m_user],
                jacobian: jacobian_user,
                hessian: vec![0.0; hessian_pattern.len()],
            },
            evaluate: 0.0,
        })
    }

    pub(crate) fn problem(&self) -> &dyn NlpProblem {
        self.problem
    }

    /// (row, column) of the kept Jacobian entries, in the order of [`Formulation::jacobian`].
    pub(crate) fn jacobian_entries(&self) -> impl Iterator<Item = (usize, usize)> + Clone + '_ {
        let entry = |kept: &Kept| (kept.row as usize, kept.column as usize);
        self.entries.jacobian.iter().map(entry)
    }

    /// (row, column) of the kept Hessian entries, in the order of [`Formulation::hessian`].
    pub(crate) fn hessian_entries(&self) -> impl Iterator<Item = (usize, usize)> + Clone + '_ {
        let entry = |kept: &Kept| (kept.row as usize, kept.column as usize);
        self.entries.hessian.iter().map(entry)
    }

    /// The full point; `x` holds the free variables.
    pub(crate) fn full_point(&mut self, x: &[f64]) -> &[f64] {
        for (&i, &value) in self.variables.iter().zip(x) {
            self.user.x[i] = value;
        }
        &self.user.x
    }

    /// Scaled objective.
    pub(crate) fn objective(&mut self, x: &[f64]) -> f64 {
        let x = full_point(&self.variables, x, &mut self.user.x);
        self.objective_scale * timed(&mut self.evaluate, || self.problem.objective(x))
    }

    /// Scaled gradient of the objective.
    pub(crate) fn gradient(&mut self, x: &[f64], gradient: &mut [f64]) {
        let x = full_point(&self.variables, x, &mut self.user.x);
        if gradient.len() == x.len() {
            timed(&mut self.evaluate, || self.problem.gradient(x, gradient));
        } else {
            let user = &mut self.user.gradient;
            timed(&mut self.evaluate, || self.problem.gradient(x, user));
            for (g, &i) in gradient.iter_mut().zip(&self.variables) {
                *g = self.user.gradient[i];
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
        let x = full_point(&self.variables, x, &mut self.user.x);
        if c.len() == self.user.c.len() {
            timed(&mut self.evaluate, || self.problem.constraint_values(x, c));
        } else {
            let user = &mut self.user.c;
            timed(&mut self.evaluate, || {
                self.problem.constraint_values(x, user)
            });
            for (c, &i) in c.iter_mut().zip(&self.rows) {
                *c = self.user.c[i];
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
        let x = full_point(&self.variables, x, &mut self.user.x);
        if values.len() == self.user.jacobian.len() {
            timed(&mut self.evaluate, || {
                self.problem.jacobian_values(x, values)
            });
        } else {
            let user = &mut self.user.jacobian;
            timed(&mut self.evaluate, || self.problem.jacobian_values(x, user));
            for (value, kept) in values.iter_mut().zip(&self.entries.jacobian) {
                *value = self.user.jacobian[kept.position as usize];
            }
        }
        if self.is_scaled {
            for (value, kept) in values.iter_mut().zip(&self.entries.jacobian) {
                *value *= self.row_scales[kept.row as usize];
            }
        }
    }

    /// Hessian of `weight f + y' c` in scaled quantities.
    pub(crate) fn hessian(&mut self, x: &[f64], weight: f64, y: &[f64], values: &mut [f64]) {
        let x = full_point(&self.variables, x, &mut self.user.x);
        let weight = weight * self.objective_scale;
        let y = if self.is_scaled || y.len() != self.user.y.len() {
            // rows that are not kept have no multiplier
            for ((&i, scale), y) in self.rows.iter().zip(&self.row_scales).zip(y) {
                self.user.y[i] = scale * y;
            }
            &self.user.y
        } else {
            y
        };
        if values.len() == self.user.hessian.len() {
            timed(&mut self.evaluate, || {
                self.problem.hessian_values(x, weight, y, values);
            });
            return;
        }
        let user = &mut self.user.hessian;
        timed(&mut self.evaluate, || {
            self.problem.hessian_values(x, weight, y, user);
        });
        for (value, kept) in values.iter_mut().zip(&self.entries.hessian) {
            *value = self.user.hessian[kept.position as usize];
        }
    }

    /// The full unscaled problem at the full point: objective, gradient, constraints and Jacobian entries.
    pub(crate) fn unscaled(&mut self, x: &[f64]) -> Unscaled<'_> {
        self.full_point(x);
        let f = self.problem.objective(&self.user.x);
        self.problem.gradient(&self.user.x, &mut self.user.gradient);
        self.problem
            .constraint_values(&self.user.x, &mut self.user.c);
        self.problem
            .jacobian_values(&self.user.x, &mut self.user.jacobian);
        Unscaled {
            objective: f,
            gradient: &self.user.gradient,
            constraints: &self.user.c,
            pattern: &self.entries.user_jacobian,
            jacobian: &self.user.jacobian,
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
        Some(&(row, column)) => Err(InputError::from(Fault::Pattern {
            matrix,
            row,
            column,
            rows,
            columns,
        })),
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
