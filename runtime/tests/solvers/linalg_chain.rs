//! Ill-conditioned chains of saddle point blocks: what pivoting is for.

#![allow(clippy::unwrap_used, reason = "test code")]

use hangtime::linalg::{KktFactorization, MultifrontalLdl, SimplicialLdl, SymmetricPattern};

/// The Newton matrix of a control problem with `stages` steps of a damped rotation `x' = A x + B u`: the weights of states
/// and controls run through 16 orders of magnitude, as they do near the end of an interior point run, and the states of
/// every third stage have none. Unknowns are (x, u) by stages, then the multipliers of the steps, without any shift.
struct Chain {
    primal: usize,
    pattern: SymmetricPattern,
    values: Vec<f64>,
}

fn chain(stages: usize) -> Chain {
    let primal = 3 * stages + 2;
    let mut entries = Vec::new();
    for k in 0..stages {
        let weight = 10.0_f64.powi(((7 * k) % 17) as i32 - 8);
        if k % 3 != 1 {
            entries.push((3 * k, 3 * k, weight));
            entries.push((3 * k + 1, 3 * k + 1, 0.5 * weight));
        }
        entries.push((
            3 * k + 2,
            3 * k + 2,
            10.0_f64.powi(((5 * k) % 13) as i32 - 8),
        ));
        let (c, s) = (0.99 * 0.3_f64.cos(), 0.99 * 0.3_f64.sin());
        let step = [(0, [c, s, 0.1]), (1, [-s, c, 1.0])];
        for (i, row) in step {
            let dual = primal + 2 * k + i;
            for (j, a) in row.into_iter().enumerate() {
                entries.push((dual, 3 * k + j, a));
            }
            entries.push((dual, 3 * k + 3 + i, -1.0));
        }
    }
    // the end is weighted, so that the reduced Hessian is positive definite
    entries.push((primal - 2, primal - 2, 1.0));
    entries.push((primal - 1, primal - 1, 1.0));
    let positions: Vec<(usize, usize)> = entries.iter().map(|&(i, j, _)| (i, j)).collect();
    let (pattern, map) = SymmetricPattern::new(primal + 2 * stages, &positions).unwrap();
    let mut values = vec![0.0; pattern.stored()];
    for (&position, (_, _, a)) in map.iter().zip(&entries) {
        values[position] += a;
    }
    Chain {
        primal,
        pattern,
        values,
    }
}

/// Componentwise backward errors `max_i |b - K x|_i / (|K| |x| + |b|)_i` (Oettli and Prager 1964), the relative change of
/// the entries that makes `x` exact, of a solve and of its first steps of refinement.
fn backward_errors(chain: &Chain, factorization: &mut dyn KktFactorization) -> [f64; 4] {
    let n = chain.pattern.dimension();
    let b: Vec<f64> = (0..n).map(|i| (1.0 + i as f64).sin()).collect();
    let absolute = |x: &[f64]| -> Vec<f64> { x.iter().map(|a| a.abs()).collect() };
    let magnitudes = absolute(&chain.values);
    let mut x = vec![0.0; n];
    let mut residual = b.clone();
    [(); 4].map(|()| {
        factorization.solve(&mut residual);
        for (x, d) in x.iter_mut().zip(&residual) {
            *x += d;
        }
        let mut product = vec![0.0; n];
        chain.pattern.multiply_add(&chain.values, &x, &mut product);
        let mut size = absolute(&b);
        chain
            .pattern
            .multiply_add(&magnitudes, &absolute(&x), &mut size);
        for ((r, b), product) in residual.iter_mut().zip(&b).zip(&product) {
            *r = b - product;
        }
        residual
            .iter()
            .zip(&size)
            .fold(0.0, |m: f64, (r, size)| m.max(r.abs() / size))
    })
}

#[test]
fn multifrontal_without_shifts_is_backward_stable_where_static_shifts_lose_digits() {
    for stages in [30, 300, 3000] {
        let chain = chain(stages);
        let dual = 2 * stages;
        let mut pivoting = MultifrontalLdl::new(&chain.pattern, chain.primal).unwrap();
        let inertia = pivoting.factor(&chain.values, 0.0, 0.0).unwrap();
        assert_eq!(
            (inertia.positive, inertia.negative, inertia.zero),
            (chain.primal, dual, 0)
        );
        let errors = backward_errors(&chain, &mut pivoting);
        // one step of refinement leaves a few roundings of 1.1e-16 in each row
        assert!(errors[1] < 1e-15, "{stages} stages: {errors:?}");

        // static shifts of 1e-10 and 1e-9 are not small beside weights of 1e-8: each step regains two digits at most
        let mut shifted = SimplicialLdl::new(&chain.pattern, chain.primal).unwrap();
        shifted.factor(&chain.values, 0.0, 0.0).unwrap();
        let lost = backward_errors(&chain, &mut shifted);
        assert!(lost[1] > 1e-6 && lost[3] > 1e-10, "{stages}: {lost:?}");
    }
}

#[test]
fn multifrontal_large_shift_beside_small_rows_postpones_nothing() {
    // the shift of an inertia correction makes all other rows tiny beside it, but not zero
    let chain = chain(2000);
    let mut factorization = MultifrontalLdl::new(&chain.pattern, chain.primal).unwrap();
    factorization.factor(&chain.values, 0.0, 0.0).unwrap();
    let usual = factorization.factor_entries();
    for shift in [1e4, 1e8, 1e12, 1e17] {
        let inertia = factorization.factor(&chain.values, shift, 0.0).unwrap();
        assert_eq!((inertia.positive, inertia.negative), (chain.primal, 4000));
        let entries = factorization.factor_entries();
        assert!(entries <= usual, "{shift:e}: {entries} instead of {usual}");
        factorization.factor(&chain.values, 0.0, 0.0).unwrap();
    }
}
