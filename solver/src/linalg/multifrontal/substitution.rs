//! Forward and backward substitution with the factors, front by front, in blocks of four columns.

use pulp::Simd;

use super::factors::{Factors, FrontRecord};
use super::kernels::{dot, dot_four, padded, subtract, subtract_four, subtract_two};

/// Solves with `L B L'` in place, in the permuted and scaled right-hand side `x`; `w` is a work array.
pub(super) fn solve(factors: &Factors, x: &mut [f64], w: &mut Vec<f64>) {
    pulp::Arch::new().dispatch(Substitution {
        fronts: &factors.fronts,
        factor: &factors.values,
        names: &factors.rows,
        inverse: &factors.inverse,
        x,
        w,
    });
}

struct Substitution<'m> {
    fronts: &'m [FrontRecord],
    factor: &'m [f64],
    names: &'m [u32],
    inverse: &'m [[f64; 2]],
    x: &'m mut [f64],
    /// The rows of one front.
    w: &'m mut Vec<f64>,
}

impl pulp::WithSimd for Substitution<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            fronts,
            mut factor,
            mut names,
            mut inverse,
            x,
            w,
        } = self;
        let (all_factors, all_names) = (factor, names);
        for front in fronts {
            let (rows, pivots) = (front.rows as usize, front.pivots as usize);
            let stride = padded(rows);
            let (panel, other) = factor.split_at(stride * pivots);
            let (rows_here, other_names) = names.split_at(rows);
            let (inverse_here, other_inverse) = inverse.split_at(pivots);
            gather(rows_here, stride, x, w);
            forward(simd, panel, stride, w);
            divide(inverse_here, w);
            for (&name, w) in rows_here.iter().zip(&*w) {
                x[name as usize] = *w;
            }
            (factor, names, inverse) = (other, other_names, other_inverse);
        }
        (factor, names) = (all_factors, all_names);
        for front in fronts.iter().rev() {
            let (rows, pivots) = (front.rows as usize, front.pivots as usize);
            let stride = padded(rows);
            let (other, panel) = factor.split_at(factor.len() - stride * pivots);
            let (other_names, rows_here) = names.split_at(names.len() - rows);
            gather(rows_here, stride, x, w);
            backward(simd, panel, stride, w);
            for (&name, w) in rows_here.iter().zip(&w[..pivots]) {
                x[name as usize] = *w;
            }
            (factor, names) = (other, other_names);
        }
    }
}

/// The rows of a front, padded by zeros.
#[inline(always)]
fn gather(names: &[u32], stride: usize, x: &[f64], w: &mut Vec<f64>) {
    w.clear();
    w.extend(names.iter().map(|&name| x[name as usize]));
    w.resize(stride, 0.0);
}

/// `w <- L^-1 w` for the columns of one front; only what is below their diagonals is read.
#[inline(always)]
fn forward<S: Simd>(simd: S, panel: &[f64], stride: usize, w: &mut [f64]) {
    for (k, columns) in panel.chunks(4 * stride).enumerate() {
        let (above, below) = w.split_at_mut(4 * k + 4);
        let Some(head) = above.last_chunk_mut::<4>() else {
            return;
        };
        let mut columns = columns.chunks_exact(stride).map(|c| c.split_at(4 * k + 4));
        let mut next = |i: usize| {
            let (above, rest) = columns.next()?;
            let l = above.last_chunk::<4>()?;
            for t in i + 1..4 {
                head[t] -= l[t] * head[i];
            }
            Some(rest)
        };
        match [next(0), next(1), next(2), next(3)] {
            [Some(a), Some(b), Some(c), Some(d)] => {
                subtract_four(simd, below, head, [a, b, c, d]);
            }
            [Some(a), Some(b), Some(c), None] => {
                subtract_two(simd, below, [head[0], head[1]], a, b);
                subtract(simd, below, head[2], c);
            }
            [Some(a), Some(b), ..] => subtract_two(simd, below, [head[0], head[1]], a, b),
            [Some(a), ..] => subtract(simd, below, head[0], a),
            _ => {}
        }
    }
}

/// `w <- L'^-1 w` for the columns of one front.
#[inline(always)]
fn backward<S: Simd>(simd: S, panel: &[f64], stride: usize, w: &mut [f64]) {
    for (k, columns) in panel.chunks(4 * stride).enumerate().rev() {
        let (above, below) = w.split_at_mut(4 * k + 4);
        let Some(head) = above.last_chunk_mut::<4>() else {
            return;
        };
        let count = columns.len() / stride;
        let rest = |i: usize| &columns[i * stride + 4 * k + 4..(i + 1) * stride];
        let mut sums = [0.0; 4];
        if count == 4 {
            sums = dot_four(simd, [0, 1, 2, 3].map(rest), below);
        } else {
            for (i, sum) in sums.iter_mut().enumerate().take(count) {
                *sum = dot(simd, rest(i), below);
            }
        }
        for i in (0..count).rev() {
            let l = &columns[i * stride + 4 * k..i * stride + 4 * k + 4];
            let mut value = head[i] - sums[i];
            for t in i + 1..4 {
                value -= l[t] * head[t];
            }
            head[i] = value;
        }
    }
}

/// `w <- B^-1 w`, where `B^-1` has a diagonal and couplings to the next row.
#[inline(always)]
fn divide(inverse: &[[f64; 2]], w: &mut [f64]) {
    let (mut before, mut coupling) = (0.0, 0.0);
    for (k, &[diagonal, next]) in inverse.iter().enumerate() {
        let here = w[k];
        let after = w.get(k + 1).copied().unwrap_or(0.0);
        w[k] = diagonal * here + (coupling * before + next * after);
        (before, coupling) = (here, next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit lower triangular panel of `rows` rows; what is not to be read is not a number.
    fn panel(rows: usize, columns: usize) -> Vec<f64> {
        let stride = padded(rows);
        let mut panel = vec![0.0; columns * stride];
        for j in 0..columns {
            for i in 0..rows {
                let l = (1.0 + (7 * j + i) as f64).sin();
                panel[j * stride + i] = if i > j { l } else { f64::NAN };
            }
        }
        panel
    }

    #[test]
    fn forward_and_backward_solve_with_the_triangle_for_any_shape() {
        for rows in 1..11 {
            for columns in 1..=rows {
                let stride = padded(rows);
                let panel = panel(rows, columns);
                let l = |i: usize, j: usize| panel[j * stride + i];
                let exact: Vec<f64> = (0..rows).map(|i| 1.0 + i as f64).collect();
                // L x, where L continues by the identity, and L' x
                let mut product = vec![0.0; stride];
                let mut transposed = vec![0.0; stride];
                for i in 0..rows {
                    product[i] =
                        exact[i] + (0..i.min(columns)).map(|j| l(i, j) * exact[j]).sum::<f64>();
                    transposed[i] = exact[i];
                    if i < columns {
                        transposed[i] += (i + 1..rows).map(|t| l(t, i) * exact[t]).sum::<f64>();
                    }
                }
                forward(pulp::Scalar, &panel, stride, &mut product);
                backward(pulp::Scalar, &panel, stride, &mut transposed);
                for i in 0..rows {
                    // growth of at most 2^10 from entries below one
                    assert!((product[i] - exact[i]).abs() < 1e-10, "{rows}, {columns}");
                    assert!(
                        (transposed[i] - exact[i]).abs() < 1e-10,
                        "{rows}, {columns}"
                    );
                }
            }
        }
    }

    #[test]
    fn divide_couples_the_two_rows_of_a_pair() {
        // B^-1 = [2, 0 0; 0 3 5; 0 5 7]
        let mut w = [1.0, 10.0, 100.0, 0.0];
        divide(&[[2.0, 0.0], [3.0, 5.0], [7.0, 0.0]], &mut w);
        assert_eq!(w, [2.0, 530.0, 750.0, 0.0]);
    }
}
