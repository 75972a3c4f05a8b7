//! Sparse `L D L'` without pivoting, on faer's simplicial kernels: the oracle of the tests of the pivoting factorization.

use faer::Side;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::simplicial::{self, SimplicialLdltRef};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};

use super::{FactorizationError, Inertia, KktFactorization, SymmetricPattern};

/// `L D L'` with an approximate minimum degree order and static shifts in place of pivoting.
///
/// The factorized matrix is `K + diag(delta_w + STATIC_PRIMAL, -(delta_c + STATIC_DUAL))`: without
/// pivoting a saddle point matrix is only factorizable in every order when it is quasi-definite, and
/// the static shifts make it so wherever `W` allows. They are part of the factors but not of the
/// system: [`super::RefinedSolver`] removes their effect by refinement. The inertia is that of `D`.
pub(crate) struct SimplicialLdl {
    primal: usize,
    symbolic: SymbolicCholesky<u32>,
    /// `permutation[new] = old`.
    permutation: Vec<u32>,
    /// Permuted upper triangle: pointers, rows, values, and where each pattern entry goes.
    column_pointers: Vec<u32>,
    row_indices: Vec<u32>,
    permuted_values: Vec<f64>,
    scatter: Vec<u32>,
    diagonal: Vec<u32>,
    factor_values: Vec<f64>,
    work: Vec<f64>,
    scratch: MemBuffer,
}

impl SimplicialLdl {
    /// Static shift of primal rows: 1e-10 costs no accuracy after refinement.
    const STATIC_PRIMAL: f64 = 1e-10;
    /// Static shift of dual rows.
    const STATIC_DUAL: f64 = 1e-9;

    /// Analyses the pattern; the first `primal` rows are primal, the others dual.
    ///
    /// # Errors
    /// [`FactorizationError::Analysis`] when memory or the index range does not suffice.
    pub(crate) fn new(
        pattern: &SymmetricPattern,
        primal: usize,
    ) -> Result<Self, FactorizationError> {
        let n = pattern.dimension();
        let lower = SymbolicSparseColMatRef::new_checked(
            n,
            n,
            pattern.column_pointers(),
            None,
            pattern.row_indices(),
        );
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..Default::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(lower, Side::Lower, SymmetricOrdering::Amd, parameters)
                .map_err(|_| FactorizationError::Analysis)?;
        let (permutation, inverse) = match symbolic.perm() {
            Some(order) => {
                let (forward, inverse) = order.arrays();
                (forward.to_vec(), inverse.to_vec())
            }
            None => ((0..n as u32).collect(), (0..n as u32).collect()),
        };
        let (column_pointers, row_indices, scatter) = permute_to_upper(pattern, &inverse);
        let diagonal = (0..n).map(|j| scatter[pattern.diagonal(j)]).collect();
        let factor_values = vec![0.0; symbolic.len_val()];
        let scratch = MemBuffer::new(simplicial::factorize_simplicial_numeric_ldlt_scratch::<
            u32,
            f64,
        >(n));
        Ok(Self {
            primal,
            symbolic,
            permutation,
            permuted_values: vec![0.0; row_indices.len()],
            column_pointers,
            row_indices,
            scatter,
            diagonal,
            factor_values,
            work: vec![0.0; n],
            scratch,
        })
    }
}

/// Upper triangle of the permuted matrix, columns sorted, and the scatter map from the pattern.
fn permute_to_upper(pattern: &SymmetricPattern, inverse: &[u32]) -> (Vec<u32>, Vec<u32>, Vec<u32>) {
    let n = pattern.dimension();
    let mut pointers = vec![0_u32; n + 1];
    let position = |i: u32, j: usize| {
        let (a, b) = (inverse[i as usize], inverse[j]);
        (a.min(b), a.max(b))
    };
    let column = |j: usize| {
        let ends = &pattern.column_pointers()[j..j + 2];
        ends[0] as usize..ends[1] as usize
    };
    for j in 0..n {
        for k in column(j) {
            pointers[position(pattern.row_indices()[k], j).1 as usize + 1] += 1;
        }
    }
    for j in 0..n {
        pointers[j + 1] += pointers[j];
    }
    let mut next = pointers.clone();
    let mut entries = vec![(0_u32, 0_u32); pattern.stored()];
    for j in 0..n {
        for k in column(j) {
            let (row, column) = position(pattern.row_indices()[k], j);
            let next = &mut next[column as usize];
            entries[*next as usize] = (row, k as u32);
            *next += 1;
        }
    }
    let mut scatter = vec![0; pattern.stored()];
    for ends in pointers.windows(2) {
        entries[ends[0] as usize..ends[1] as usize].sort_unstable();
    }
    let mut rows = Vec::with_capacity(entries.len());
    for (k, &(row, source)) in entries.iter().enumerate() {
        rows.push(row);
        scatter[source as usize] = k as u32;
    }
    (pointers, rows, scatter)
}

impl KktFactorization for SimplicialLdl {
    fn factor(
        &mut self,
        values: &[f64],
        delta_w: f64,
        delta_c: f64,
    ) -> Result<Inertia, FactorizationError> {
        let n = self.permutation.len();
        for (&position, &value) in self.scatter.iter().zip(values) {
            self.permuted_values[position as usize] = value;
        }
        for (row, &position) in self.diagonal.iter().enumerate() {
            self.permuted_values[position as usize] += if row < self.primal {
                delta_w + Self::STATIC_PRIMAL
            } else {
                -(delta_c + Self::STATIC_DUAL)
            };
        }
        let SymbolicCholeskyRaw::Simplicial(symbolic) = self.symbolic.raw() else {
            return Err(FactorizationError::Analysis);
        };
        let matrix = SparseColMatRef::new(
            SymbolicSparseColMatRef::new_checked(
                n,
                n,
                &self.column_pointers,
                None,
                &self.row_indices,
            ),
            &self.permuted_values,
        );
        let result = simplicial::factorize_simplicial_numeric_ldlt(
            &mut self.factor_values,
            matrix,
            LdltRegularization::default(),
            symbolic,
            MemStack::new(&mut self.scratch),
        );
        if result.is_err() {
            let finite = self.permuted_values.iter().all(|a| a.is_finite());
            return Err(if finite {
                FactorizationError::ZeroPivot
            } else {
                FactorizationError::NotFinite
            });
        }
        let negative = symbolic.col_ptr()[..n]
            .iter()
            .filter(|&&start| self.factor_values[start as usize] < 0.0)
            .count();
        Ok(Inertia {
            positive: n - negative,
            negative,
            zero: 0,
        })
    }

    fn solve(&mut self, right_hand_side: &mut [f64]) {
        for (w, &old) in self.work.iter_mut().zip(&self.permutation) {
            *w = right_hand_side[old as usize];
        }
        if let SymbolicCholeskyRaw::Simplicial(symbolic) = self.symbolic.raw() {
            let n = self.permutation.len();
            SimplicialLdltRef::new(symbolic, &self.factor_values).solve_in_place_with_conj(
                Conj::No,
                MatMut::from_column_major_slice_mut(&mut self.work, n, 1),
                Par::Seq,
                MemStack::new(&mut self.scratch),
            );
        }
        for (&w, &old) in self.work.iter().zip(&self.permutation) {
            right_hand_side[old as usize] = w;
        }
    }
}
