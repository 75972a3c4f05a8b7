//! Certificates: points that descend are never certified, whatever sides a problem proposes.
//!
//! The problems are `min sum_k h_k/2 (x_k - t_k)^2 + w s`, `0 <= x_i _|_ x_j >= 0`, where `x = A u` with free variables `u` in
//! which the objective is stated, so that rows and infinite bounds take part; `s >= 0` is a bounded variable with a
//! multiplier `w` of its own. Since `A` is regular every pair is decided by itself: with `x_i = 0` the best is
//! `x_j = max(t_j, 0)`, and that descends along `x_i` exactly if `x_j = 0` and `t_i > 0`.

#![allow(clippy::unwrap_used, reason = "test code")]

use crate::mpcc_problems::deciding;
use hangtime_solver::mpcc::{self, Settings, Status};

/// A problem whose first sides are proposed by the test.
#[derive(Debug, Clone)]
struct Planted {
    /// `h_k`, `t_k`, upper bound of `x_k`.
    curvature: Vec<f64>,
    target: Vec<f64>,
    upper: Vec<f64>,
    /// `A` by rows.
    map: Vec<Vec<f64>>,
    weight: f64,
    pairs: Vec<(usize, usize)>,
    /// Sides that are proposed.
    proposed: Vec<usize>,
}

impl Planted {
    /// `x` first, then `u`, then `s`.
    fn solve(&self) -> mpcc::Solution {
        let n = self.target.len();
        let mut text = format!(
            "problem planted {0}\nstart {1}\n",
            2 * n + 1,
            "1 ".repeat(2 * n + 1)
        );
        text += &format!(
            "bounds {0} 0 inf\nminimize {1}*x{0}\n",
            2 * n + 1,
            self.weight
        );
        for k in 0..n {
            let terms = self.map[k].iter().zip(n + 1..);
            let terms: Vec<String> = terms.map(|(a, u)| format!("{a}*x{u}")).collect();
            let (x, mapped) = (k + 1, terms.join(" + "));
            let (h, t) = (self.curvature[k], self.target[k]);
            text += &format!(
                "bounds {x} 0 {}\nrow 0 0 x{x} - ({mapped})\n",
                self.upper[k]
            );
            text += &format!("minimize 0.5*{h}*({mapped} - {t})^2\n");
        }
        for (i, j) in &self.pairs {
            text += &format!("pair {} {}\n", i + 1, j + 1);
        }
        let mut problem = deciding(&text, self.proposed.clone());
        mpcc::solve(&mut problem, &Settings::default()).unwrap()
    }
}

/// Deterministic pseudo-random numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn choose<T: Copy>(&mut self, of: &[T]) -> T {
        of[((self.next() * of.len() as f64) as usize).min(of.len() - 1)]
    }
}

/// A random problem with `pairs` pairs, whose targets are zero, of either sign, and away from zero else; `scale` is the
/// gradient of the variable that takes no part.
fn random(random: &mut Random, pairs: usize, scale: f64) -> Planted {
    let n = 2 * pairs;
    let mut problem = Planted {
        curvature: Vec::new(),
        target: Vec::new(),
        upper: Vec::new(),
        map: Vec::new(),
        weight: scale,
        pairs: Vec::new(),
        proposed: Vec::new(),
    };
    for k in 0..n {
        problem
            .curvature
            .push(10.0_f64.powf(2.0 * random.next() - 1.0));
        let size = 0.2 + 2.0 * random.next();
        problem
            .target
            .push(size * random.choose(&[-1.0, 0.0, 0.0, 1.0]));
        problem
            .upper
            .push(random.choose(&[f64::INFINITY, f64::INFINITY, 100.0]));
        // diagonally dominant, so that `A` is regular
        let mut row: Vec<f64> = (0..n).map(|_| (random.next() - 0.5) / n as f64).collect();
        row[k] += 1.0;
        problem.map.push(row);
    }
    for k in 0..pairs {
        problem.pairs.push((2 * k, 2 * k + 1));
        problem.proposed.push(2 * k + random.choose(&[0, 1]));
    }
    problem
}

/// Whether each pair of `x` is at one of its local solutions, to `accuracy`.
fn is_local_solution(problem: &Planted, x: &[f64], accuracy: f64) -> bool {
    problem.pairs.iter().all(|&(i, j)| {
        // the side that vanishes, and the other one
        let (zero, other) = if x[i] <= x[j] { (i, j) } else { (j, i) };
        let best = problem.target[other].max(0.0);
        x[zero] == 0.0
            && (x[other] - best).abs() <= accuracy
            && (best > 0.0 || problem.target[zero] <= 0.0)
    })
}

#[test]
fn solve_random_problems_with_planted_sides_certifies_local_solutions_only() {
    let mut generator = Random(12);
    let mut others = Vec::new();
    let mut planted = 0;
    for case in 0..400 {
        let scale = generator.choose(&[0.0, 1.0, 1e3, 1e6]);
        let problem = random(&mut generator, 1 + case % 4, scale);
        planted += usize::from(problem.proposed.iter().any(|&side| {
            let other = side ^ 1;
            problem.target[side] > 0.0 && problem.target[other] <= 0.0
        }));
        let solution = problem.solve();
        // a side with a zero multiplier ends at sqrt(mu / h), h >= 0.1 and mu = 1e-10 at most, in an objective that is
        // scaled by 100 / scale
        let accuracy = 3.0 * (1e-10 * (scale / 100.0).max(1.0) / 0.1).sqrt();
        let right = is_local_solution(&problem, &solution.x, accuracy);
        assert!(
            solution.status != Status::Solved || right,
            "case {case}: {:?} {:?} certified at {:?}",
            problem,
            solution.certificate,
            solution.x
        );
        // beside a gradient of 1e6 the tolerance of the crossover, which is absolute, may be out of reach
        if solution.status != Status::Solved && scale < 1e6 {
            others.push(format!("{case} (scale {scale:e}): {}", solution.status));
        }
    }
    // most of the problems propose sides that descend; the method leaves these
    assert!(planted > 150, "{planted}");
    assert!(others.is_empty(), "{others:#?}");
}

/// One pair with targets `t`, and sides proposed so that the first one vanishes.
fn one_pair(target: [f64; 2], curvature: [f64; 2], upper: f64, scale: f64) -> Planted {
    Planted {
        curvature: curvature.to_vec(),
        target: target.to_vec(),
        upper: vec![upper; 2],
        map: vec![vec![1.0, 0.0], vec![0.0, 1.0]],
        weight: scale,
        pairs: vec![(0, 1)],
        proposed: vec![0],
    }
}

#[test]
fn solve_descent_towards_an_infinite_bound_is_found() {
    // with the first side at zero the point (0, 0) has multipliers (-2.1, 1.2), and descends to (0.7, 0)
    for upper in [f64::INFINITY, 1e20, 1e6, 50.0] {
        let problem = one_pair([0.7, -0.4], [3.0, 3.0], upper, 0.5);
        let solution = problem.solve();
        assert_eq!(solution.status, Status::Solved, "{upper}");
        assert!((solution.x[0] - 0.7).abs() < 1e-7 && solution.x[1] == 0.0);
    }
}

#[test]
fn solve_side_with_zero_multiplier_is_biactive_and_left() {
    // the second side goes to zero with sqrt(mu): 1e-6 to 1e-3 with these curvatures
    for curvature in [1e-5, 1e-2, 7.0] {
        let problem = one_pair([0.6, 0.0], [2.0, curvature], f64::INFINITY, 0.0);
        let solution = problem.solve();
        assert_eq!(solution.status, Status::Solved, "{curvature}");
        assert!((solution.x[0] - 0.6).abs() < 1e-7, "{:?}", solution.x);
        assert_eq!(solution.x[1], 0.0);
    }
}

#[test]
fn solve_small_positive_side_is_not_taken_for_zero() {
    // (0, 2e-4) is a local solution: the first side may not leave zero before the second has gone there, uphill
    let problem = one_pair([0.6, 2e-4], [2.0, 40.0], f64::INFINITY, 0.0);
    let solution = problem.solve();
    assert_eq!(solution.status, Status::Solved);
    assert!(
        is_local_solution(&problem, &solution.x, 1e-7),
        "{:?}",
        solution.x
    );
}

#[test]
fn solve_descent_beside_a_steep_variable_is_found() {
    // a gradient of 1e7 elsewhere does not make a descent of 0.5 small
    let problem = one_pair([0.5, -0.5], [1.0, 1.0], f64::INFINITY, 1e7);
    let solution = problem.solve();
    assert!(
        solution.status != Status::Solved || is_local_solution(&problem, &solution.x, 1e-6),
        "{:?} {:?}",
        solution.x,
        solution.certificate
    );
}
