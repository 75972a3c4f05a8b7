//! Systems whose eigenvalues and solutions are known; and ill-conditioned chains of saddle point blocks, which are what pivoting is for.

use nalgebra::{DMatrix, SymmetricEigen};

use super::{Inertia, MultifrontalLdl, RefinedSolver, SymmetricPattern};

/// Deterministic pseudo-random numbers in (-1, 1).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        ((self.0 >> 11) as f64 / (1_u64 << 53) as f64) * 2.0 - 1.0
    }

    fn index(&mut self, n: usize) -> usize {
        (((self.next() + 1.0) * 0.5 * n as f64) as usize).min(n - 1)
    }
}

/// A matrix by entries of its lower triangle; the first `primal` rows are primal.
struct System {
    name: String,
    n: usize,
    primal: usize,
    entries: Vec<(usize, usize, f64)>,
}

/// `[W J'; J -C]` with random sparse `W` (definite or not), `J`, and `C = c I`.
fn saddle(seed: u64, primal: usize, dual: usize, definite: bool, c: f64) -> System {
    let mut random = Random(seed);
    let mut entries = Vec::new();
    for i in 0..primal {
        let diagonal = if definite {
            4.0 + random.next()
        } else if random.next() > 0.0 {
            0.0
        } else {
            random.next()
        };
        entries.push((i, i, diagonal));
        if i > 0 {
            entries.push((i, random.index(i), random.next()));
        }
    }
    for row in 0..dual {
        entries.push((primal + row, row, 1.0 + 0.5 * random.next()));
        for _ in 0..2 {
            entries.push((primal + row, random.index(primal), random.next()));
        }
        entries.push((primal + row, primal + row, -c));
    }
    System {
        name: format!("saddle {seed} {primal}+{dual} definite {definite} c {c}"),
        n: primal + dual,
        primal,
        entries,
    }
}

fn systems() -> Vec<System> {
    let mut systems = Vec::new();
    for seed in 0..20 {
        for (primal, dual) in [(3, 1), (8, 5), (20, 12), (40, 30)] {
            systems.push(saddle(seed, primal, dual, true, 0.0));
            systems.push(saddle(seed + 100, primal, dual, true, 1e-2));
            systems.push(saddle(seed + 200, primal, dual, false, 0.0));
        }
    }
    systems
}

fn dense(system: &System) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(system.n, system.n);
    for &(i, j, a) in &system.entries {
        matrix[(i, j)] += a;
        if i != j {
            matrix[(j, i)] += a;
        }
    }
    matrix
}

fn assemble(system: &System) -> (SymmetricPattern, Vec<f64>) {
    let positions: Vec<(usize, usize)> = system.entries.iter().map(|&(i, j, _)| (i, j)).collect();
    let (pattern, map) = SymmetricPattern::new(system.n, &positions).unwrap();
    let mut values = vec![0.0; pattern.stored()];
    for (&k, &(_, _, a)) in map.iter().zip(&system.entries) {
        values[k] += a;
    }
    (pattern, values)
}

/// Inertia against that of the eigenvalues, and a solve against a known solution.
fn check(system: &System) {
    let eigenvalues = SymmetricEigen::new(dense(system)).eigenvalues;
    let smallest = eigenvalues
        .iter()
        .fold(f64::INFINITY, |a, e| a.min(e.abs()));
    if smallest < 1e-4 {
        // the sign of such an eigenvalue is a matter of rounding
        return;
    }
    let expected = Inertia {
        positive: eigenvalues.iter().filter(|e| **e > 0.0).count(),
        negative: eigenvalues.iter().filter(|e| **e < 0.0).count(),
        zero: 0,
    };
    let (pattern, values) = assemble(system);
    let mut solver = RefinedSolver::new(pattern.clone(), system.primal).unwrap();
    solver.values_mut().copy_from_slice(&values);
    let inertia = solver.factor(0.0, 0.0).unwrap();
    assert_eq!(inertia, expected, "{}", system.name);
    let mut random = Random(7);
    let x: Vec<f64> = (0..system.n).map(|_| random.next()).collect();
    let mut b = vec![0.0; system.n];
    pattern.multiply_add(&values, &x, &mut b);
    let mut solution = vec![0.0; system.n];
    let residual = solver.solve(&b, &mut solution);
    // condition numbers reach 1e5 / smallest eigenvalue 1e-4
    assert!(residual < 1e-10, "{}: {residual:e}", system.name);
    for (a, b) in x.iter().zip(&solution) {
        assert!((a - b).abs() < 1e-5, "{}: {a} {b}", system.name);
    }
}

#[test]
fn factor_and_solve_give_inertia_and_solution() {
    systems().iter().for_each(check);
}

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
fn backward_errors(chain: &Chain, factorization: &mut MultifrontalLdl) -> [f64; 4] {
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
fn multifrontal_without_shifts_is_backward_stable() {
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
