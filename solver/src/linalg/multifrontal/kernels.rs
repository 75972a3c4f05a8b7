//! Kernels of dense fronts: columns padded to whole blocks of four rows, in the vectors of the machine.
//!
//! Fronts have a handful of rows, so that loops must be short to enter and leave: padding removes remainders, and explicit
//! vectors keep the compiler from preparing for long columns.

use pulp::Simd;

/// Number of entries of a column of `rows` rows, whole blocks.
pub(crate) fn padded(rows: usize) -> usize {
    rows.next_multiple_of(4)
}

/// Vectors of a column and what does not fill one: nothing where vectors have at most four entries.
#[inline(always)]
fn parts<S: Simd>(column: &[f64]) -> (&[S::f64s], &[f64]) {
    S::as_simd_f64s(column)
}

/// `y <- y - f x`.
#[inline(always)]
pub(crate) fn subtract<S: Simd>(simd: S, y: &mut [f64], f: f64, x: &[f64]) {
    let (x, x_tail) = parts::<S>(x);
    let (y, y_tail) = S::as_mut_simd_f64s(y);
    let factor = simd.splat_f64s(f);
    for (y, x) in y.iter_mut().zip(x) {
        *y = simd.sub_f64s(*y, simd.mul_f64s(factor, *x));
    }
    for (y, x) in y_tail.iter_mut().zip(x_tail) {
        *y -= f * x;
    }
}

/// `y <- y - (f u + g v)`.
#[inline(always)]
pub(crate) fn subtract_two<S: Simd>(
    simd: S,
    y: &mut [f64],
    [f, g]: [f64; 2],
    u: &[f64],
    v: &[f64],
) {
    let ((u, u_tail), (v, v_tail)) = (parts::<S>(u), parts::<S>(v));
    let (y, y_tail) = S::as_mut_simd_f64s(y);
    let (f_all, g_all) = (simd.splat_f64s(f), simd.splat_f64s(g));
    for ((y, u), v) in y.iter_mut().zip(u).zip(v) {
        let sum = simd.add_f64s(simd.mul_f64s(f_all, *u), simd.mul_f64s(g_all, *v));
        *y = simd.sub_f64s(*y, sum);
    }
    for ((y, u), v) in y_tail.iter_mut().zip(u_tail).zip(v_tail) {
        *y -= f * u + g * v;
    }
}

/// `y <- y - ((f_0 x_0 + f_1 x_1) + (f_2 x_2 + f_3 x_3))`.
#[inline(always)]
pub(crate) fn subtract_four<S: Simd>(simd: S, y: &mut [f64], f: &[f64; 4], x: [&[f64]; 4]) {
    let [(a, a_tail), (b, b_tail), (c, c_tail), (d, d_tail)] = x.map(parts::<S>);
    let (y, y_tail) = S::as_mut_simd_f64s(y);
    let all = f.map(|f| simd.splat_f64s(f));
    for ((((y, a), b), c), d) in y.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        let first = simd.add_f64s(simd.mul_f64s(all[0], *a), simd.mul_f64s(all[1], *b));
        let second = simd.add_f64s(simd.mul_f64s(all[2], *c), simd.mul_f64s(all[3], *d));
        *y = simd.sub_f64s(*y, simd.add_f64s(first, second));
    }
    let tails = y_tail.iter_mut().zip(a_tail).zip(b_tail);
    for (((y, a), b), (c, d)) in tails.zip(c_tail.iter().zip(d_tail)) {
        *y -= (f[0] * a + f[1] * b) + (f[2] * c + f[3] * d);
    }
}

/// `(x, y) <- (i x + j y, j x + k y)`.
#[inline(always)]
pub(crate) fn transform_two<S: Simd>(simd: S, x: &mut [f64], y: &mut [f64], [i, j, k]: [f64; 3]) {
    let (x, x_tail) = S::as_mut_simd_f64s(x);
    let (y, y_tail) = S::as_mut_simd_f64s(y);
    let [i_all, j_all, k_all] = [i, j, k].map(|a| simd.splat_f64s(a));
    for (x, y) in x.iter_mut().zip(y) {
        let (u, v) = (*x, *y);
        *x = simd.add_f64s(simd.mul_f64s(i_all, u), simd.mul_f64s(j_all, v));
        *y = simd.add_f64s(simd.mul_f64s(j_all, u), simd.mul_f64s(k_all, v));
    }
    for (x, y) in x_tail.iter_mut().zip(y_tail) {
        (*x, *y) = (i * *x + j * *y, j * *x + k * *y);
    }
}

/// `x <- f x`.
#[inline(always)]
pub(crate) fn multiply<S: Simd>(simd: S, x: &mut [f64], f: f64) {
    let (x, tail) = S::as_mut_simd_f64s(x);
    let factor = simd.splat_f64s(f);
    for x in x {
        *x = simd.mul_f64s(factor, *x);
    }
    for x in tail {
        *x *= f;
    }
}

/// Scalar product.
#[inline(always)]
pub(crate) fn dot<S: Simd>(simd: S, x: &[f64], y: &[f64]) -> f64 {
    let ((x, x_tail), (y, y_tail)) = (parts::<S>(x), parts::<S>(y));
    let mut sum = simd.splat_f64s(0.0);
    for (x, y) in x.iter().zip(y) {
        sum = simd.add_f64s(sum, simd.mul_f64s(*x, *y));
    }
    let tail: f64 = x_tail.iter().zip(y_tail).map(|(x, y)| x * y).sum();
    simd.reduce_sum_f64s(sum) + tail
}

/// Scalar products of four columns with `y`.
#[inline(always)]
pub(crate) fn dot_four<S: Simd>(simd: S, x: [&[f64]; 4], y: &[f64]) -> [f64; 4] {
    let [(a, a_tail), (b, b_tail), (c, c_tail), (d, d_tail)] = x.map(parts::<S>);
    let (y, y_tail) = parts::<S>(y);
    let mut sums = [simd.splat_f64s(0.0); 4];
    for ((((y, a), b), c), d) in y.iter().zip(a).zip(b).zip(c).zip(d) {
        sums[0] = simd.add_f64s(sums[0], simd.mul_f64s(*a, *y));
        sums[1] = simd.add_f64s(sums[1], simd.mul_f64s(*b, *y));
        sums[2] = simd.add_f64s(sums[2], simd.mul_f64s(*c, *y));
        sums[3] = simd.add_f64s(sums[3], simd.mul_f64s(*d, *y));
    }
    let mut sums = sums.map(|sum| simd.reduce_sum_f64s(sum));
    for (sum, tail) in sums.iter_mut().zip([a_tail, b_tail, c_tail, d_tail]) {
        *sum += tail.iter().zip(y_tail).map(|(x, y)| x * y).sum::<f64>();
    }
    sums
}

/// Largest absolute entry.
#[inline(always)]
pub(crate) fn largest<S: Simd>(simd: S, x: &[f64]) -> f64 {
    let (x, tail) = parts::<S>(x);
    let mut largest = simd.splat_f64s(0.0);
    for x in x {
        largest = simd.max_f64s(largest, simd.abs_f64s(*x));
    }
    let largest = simd.reduce_max_f64s(largest);
    tail.iter()
        .fold(largest, |m, a| if a.abs() > m { a.abs() } else { m })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a check in the vectors of the machine and without any.
    struct Agree;

    impl pulp::WithSimd for Agree {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            let column =
                |seed: f64| -> Vec<f64> { (0..12).map(|i| (seed * i as f64).sin()).collect() };
            let x: Vec<Vec<f64>> = [0.3, 0.7, 1.1, 1.9].map(column).to_vec();
            let y = column(2.3);
            let f = [2.0, -3.0, 0.5, 4.0];
            let all = [&x[0][..], &x[1], &x[2], &x[3]];
            for used in [1, 2, 4] {
                let mut result = y.clone();
                match used {
                    1 => subtract(simd, &mut result, f[0], &x[0]),
                    2 => subtract_two(simd, &mut result, [f[0], f[1]], &x[0], &x[1]),
                    _ => subtract_four(simd, &mut result, &f, all),
                }
                for i in 0..12 {
                    let sum: f64 = (0..used).map(|k| f[k] * x[k][i]).sum();
                    assert!((result[i] - (y[i] - sum)).abs() < 1e-14);
                }
            }
            let products = dot_four(simd, all, &y);
            for k in 0..4 {
                let sum: f64 = x[k].iter().zip(&y).map(|(x, y)| x * y).sum();
                assert!((products[k] - sum).abs() < 1e-14);
                assert!((dot(simd, &x[k], &y) - sum).abs() < 1e-14);
                let greatest = x[k].iter().fold(0.0, |m: f64, a| m.max(a.abs()));
                assert_eq!(largest(simd, &x[k]), greatest);
            }
            let (mut u, mut v) = (x[0].clone(), x[1].clone());
            transform_two(simd, &mut u, &mut v, [2.0, 3.0, 5.0]);
            multiply(simd, &mut v, 7.0);
            for i in 0..12 {
                assert!((u[i] - (2.0 * x[0][i] + 3.0 * x[1][i])).abs() < 1e-14);
                assert!((v[i] - 7.0 * (3.0 * x[0][i] + 5.0 * x[1][i])).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn kernels_agree_with_sums_written_out() {
        pulp::Arch::new().dispatch(Agree);
        pulp::WithSimd::with_simd(Agree, pulp::Scalar);
    }

    #[test]
    fn padded_is_whole_blocks() {
        assert_eq!([0, 1, 4, 5].map(padded), [0, 4, 4, 8]);
    }
}
