//! Which sides can vanish near a relaxed point: the linear program with complementarity constraints there.
//!
//! At `sigma` both sides of a pair may be of size `sqrt(sigma)`, and the smaller one of them says little; with many such
//! pairs the branch of the smaller sides often has no feasible point. So the linear program
//!
//! ```text
//!     min grad f'd  s.t.  c_l <= c + r J d <= c_u,  x_l <= x + r d <= x_u,  0 <= x_i + r d_i  _|_  x_j + r d_j >= 0,  |d|_inf <= 1
//! ```
//!
//! decides by branch and bound, depth first, the side of the smaller value first: its first feasible point is taken (as in phase I
//! of Kirches, Larson, Leyffer and Manns, SIAM Journal on Optimization 32, 2022).

use super::Mpcc;
use super::branch_and_cut::{End, PairedProgram};
use super::certificate::Certifier;
use super::watch::Watch;
use crate::nlp;

/// Radius of the linear program: a hundred times the root of the last `sigma`.
const RADIUS: f64 = 1e-2;
/// Most linear programs.
const MOST_PROGRAMS: usize = 60;
/// A pair is undecided where its smaller side is at least this part of the larger one: on the path their product is `sigma`, so
/// both are within a factor of ten of its root.
const UNDECIDED: f64 = 1e-2;
/// The sides that vanish at a feasible point of the linear program, and that point; `None` if none was found.
pub(crate) fn choose_sides(
    problem: &mut dyn Mpcc,
    relaxed: &nlp::Solution,
    watch: &mut Watch<'_>,
) -> Option<(Vec<bool>, Vec<f64>)> {
    let pairs = problem.complementarities().to_vec();
    let x = &relaxed.x;
    let (undecided, decided): (Vec<usize>, Vec<usize>) = (0..pairs.len()).partition(|&k| {
        let (a, b) = (x[pairs[k].0], x[pairs[k].1]);
        a.max(b) <= RADIUS && a.min(b) >= UNDECIDED * a.max(b)
    });
    let certifier = Certifier::new(problem, &pairs, relaxed, RADIUS);
    let mut program = certifier.linear_program(&(0..pairs.len()).collect::<Vec<_>>());
    let mut vanishes = vec![false; x.len()];
    for k in decided {
        let (i, j) = pairs[k];
        vanishes[if x[i] <= x[j] { i } else { j }] = true;
    }
    for side in (0..x.len()).filter(|&i| vanishes[i]) {
        program.upper[side] = program.lower[side];
    }
    let undecided: Vec<(usize, usize)> = undecided.into_iter().map(|k| pairs[k]).collect();
    let mut search = PairedProgram {
        program,
        pairs: &undecided,
        limit: f64::INFINITY,
        programs: 0,
        most_programs: MOST_PROGRAMS,
    };
    let End::Point(d) = search.search(vec![(Vec::new(), None)], watch) else {
        return None;
    };
    let off = |i: usize| d[i] - search.program.lower[i];
    for &(i, j) in &undecided {
        vanishes[if off(i) <= off(j) { i } else { j }] = true;
    }
    let point = x.iter().zip(&d).map(|(x, d)| x + RADIUS * d).collect();
    Some((vanishes, point))
}

#[cfg(test)]
mod tests {
    use super::super::Settings;
    use super::*;
    use crate::polynomials::Polynomials;

    const PAIRS: [(usize, usize); 3] = [(0, 1), (2, 3), (4, 5)];

    /// `x_1 + x_2 = 1.7e-4`, `x_0 + x_5 = 2.3e-4` over three pairs `(0, 1)`, `(2, 3)`, `(4, 5)`, minimize `x_0`.
    fn two_sums() -> Polynomials {
        let row = |sum: f64, i: &'static [usize], j: &'static [usize]| {
            (sum, sum, vec![(1.0, i), (1.0, j)])
        };
        Polynomials {
            bounds: vec![(0.0, f64::INFINITY); 6],
            start: vec![1e-4; 6],
            objective: vec![(1.0, &[0])],
            rows: vec![row(1.7e-4, &[1], &[2]), row(2.3e-4, &[0], &[5])],
            pairs: PAIRS.to_vec(),
        }
    }

    #[test]
    fn choose_sides_where_no_smaller_sides_fit_finds_those_that_do() {
        let settings = Settings::default();
        let mut observer = |_: &nlp::IterationInfo| true;
        let mut watch = Watch::new(&settings, &mut observer);
        let mut relaxed =
            nlp::solve(&mut two_sums(), &settings.interior_point).expect("a valid program");
        // products of 1e-8, and with the smaller sides x_1, x_2 at zero the first row fails
        relaxed.x = vec![1.1e-4, 0.9e-4, 0.8e-4, 1.2e-4, 0.9e-4, 1.2e-4];
        let chosen = choose_sides(&mut two_sums(), &relaxed, &mut watch);
        let (vanishes, x) = chosen.expect("sides");
        for (i, j) in PAIRS {
            let side = if vanishes[i] { i } else { j };
            assert!(vanishes[side] && x[side].abs() < 1e-7, "{vanishes:?} {x:?}");
        }
        assert!(!(vanishes[1] && vanishes[2]), "{vanishes:?}");
        // the point fulfils both rows
        for (i, j, sum) in [(1, 2, 1.7e-4), (0, 5, 2.3e-4)] {
            assert!((x[i] + x[j] - sum).abs() < 1e-9, "{x:?}");
        }
    }
}
