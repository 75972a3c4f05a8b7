//! One suite over all factorizations: the same systems, the same demands.

#![allow(clippy::unwrap_used, reason = "test code")]

use hangtime::linalg::{
    Inertia, KktFactorization, MultifrontalLdl, RefinedSolver, SimplicialLdl, SymmetricPattern,
};
use nalgebra::{DMatrix, SymmetricEigen};

/// Deterministic pseudo-random numbers in (-1, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
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
    /// Whether it is factorizable without pivoting.
    quasi_definite: bool,
}

type Maker = fn(&SymmetricPattern, usize) -> Box<dyn KktFactorization + Send>;

fn back_ends() -> [(&'static str, Maker); 2] {
    [
        ("simplicial", |pattern, primal| {
            Box::new(SimplicialLdl::new(pattern, primal).unwrap())
        }),
        ("multifrontal", |pattern, primal| {
            Box::new(MultifrontalLdl::new(pattern, primal).unwrap())
        }),
    ]
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
        quasi_definite: definite,
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

#[test]
fn factor_and_solve_every_back_end_gives_inertia_and_solution() {
    for (name, make) in back_ends() {
        for system in systems() {
            if name == "simplicial" && !system.quasi_definite {
                continue;
            }
            let eigenvalues = SymmetricEigen::new(dense(&system)).eigenvalues;
            let smallest = eigenvalues
                .iter()
                .fold(f64::INFINITY, |a, e| a.min(e.abs()));
            if smallest < 1e-4 {
                // the sign of such an eigenvalue is a matter of rounding
                continue;
            }
            let expected = Inertia {
                positive: eigenvalues.iter().filter(|e| **e > 0.0).count(),
                negative: eigenvalues.iter().filter(|e| **e < 0.0).count(),
                zero: 0,
            };
            let (pattern, values) = assemble(&system);
            let back_end = make(&pattern, system.primal);
            let mut solver = RefinedSolver::new(pattern, system.primal, back_end);
            let inertia = solver.factor(&values, 0.0, 0.0).unwrap();
            assert_eq!(inertia, expected, "{name}, {}", system.name);
            let mut random = Random(7);
            let x: Vec<f64> = (0..system.n).map(|_| random.next()).collect();
            let mut b = vec![0.0; system.n];
            solver.pattern().multiply_add(&values, &x, &mut b);
            let mut solution = vec![0.0; system.n];
            let quality = solver.solve(&b, &mut solution);
            // condition numbers reach 1e5 / smallest eigenvalue 1e-4
            assert!(
                quality.residual < 1e-10,
                "{name}, {}: {quality:?}",
                system.name
            );
            for (a, b) in x.iter().zip(&solution) {
                assert!((a - b).abs() < 1e-5, "{name}, {}: {a} {b}", system.name);
            }
        }
    }
}
