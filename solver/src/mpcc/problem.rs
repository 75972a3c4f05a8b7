//! The problem class: a nonlinear program and pairs of variables.

use crate::nlp::{NlpProblem, Variant};

/// A nonlinear program with complementarity pairs between *variables* (vertical form): for each pair
/// `(i, j)`, `0 <= x_i  _|_  x_j >= 0`.
///
/// The lower bounds of paired variables are 0. A variable may belong to several pairs.
pub trait Mpcc: NlpProblem {
    /// The pairs, as variable indices.
    fn complementarities(&self) -> &[(usize, usize)];

    /// Name of pair `index` in diagnoses.
    fn complementarity_name(&self, index: usize) -> String {
        let (i, j) = self.complementarities()[index];
        format!("{} _|_ {}", self.variable_name(i), self.variable_name(j))
    }

    /// Chooses which paired variables vanish at the solution near `x`: writes `true` to `vanishes[i]`
    /// (all `false` on entry, length `n`) for each of them and returns `true`. At least one side of each
    /// pair has to vanish.
    ///
    /// The default returns `false`: the smaller side of each pair vanishes. Problems whose pairs belong
    /// together, such as the modes of a finite element, decide them together.
    fn vanishing_sides(&self, x: &[f64], vanishes: &mut [bool]) -> bool {
        let _ = (x, vanishes);
        false
    }
}

impl<P: Mpcc + ?Sized> Mpcc for Variant<'_, P> {
    fn complementarities(&self) -> &[(usize, usize)] {
        self.problem.complementarities()
    }

    fn complementarity_name(&self, index: usize) -> String {
        self.problem.complementarity_name(index)
    }

    fn vanishing_sides(&self, x: &[f64], vanishes: &mut [bool]) -> bool {
        self.problem.vanishing_sides(x, vanishes)
    }
}
