//! Linear programs with pairs: branch and bound over the sides, with cuts.
//!
//! Where a point of the program leaves both sides of a pair off zero, it may still lie in the hull of what the two choices of a side
//! leave. If it does not, an inequality that holds in both, and so at every point with that pair, cuts it off (a disjunctive cut; Balas,
//! SIAM Journal on Algebraic and Discrete Methods 6, 1985). Copies of a program that share a row that holds are proved by a few cuts
//! each, where branches multiply.

use super::linear_program::{LinearProgram, Outcome};
use super::watch::Watch;

/// Part of the radius that counts as none: a hundred times what the linear programs leave of their rows.
pub(crate) const NONE: f64 = 1e-6;

/// Least distance from the hull, in units of the radius, that is worth a cut; 1e-4 to 3e-2 end alike (docs/experiments/complementarity.md).
const DEPTH: f64 = 1e-3;

/// Linear programs a pair after which cuts begin: random programs with 3 to 12 pairs are decided before.
const BRANCHES: usize = 2;

/// What became of a search.
#[derive(Debug, PartialEq)]
pub(crate) enum End {
    /// A point of which one side of every pair vanishes.
    Point(Vec<f64>),
    /// There is none of a value below the limit.
    Absent,
    /// Not decided.
    Open,
}

/// What became of a program without the pairs.
enum Found {
    Point(Vec<f64>),
    Absent,
    Failed,
}

/// Sides that vanish, and a point with them where it is known.
type Node = (Vec<usize>, Option<Vec<f64>>);

/// A linear program with pairs `0 <= d_i - l_i  _|_  d_j - l_j >= 0` in which a point of a value below `limit` is looked for.
pub(crate) struct PairedProgram<'p> {
    /// Without the pairs; gets a row a cut.
    pub(crate) program: LinearProgram,
    pub(crate) pairs: &'p [(usize, usize)],
    pub(crate) limit: f64,
    /// Linear programs solved, and their limit.
    pub(crate) programs: usize,
    pub(crate) most_programs: usize,
}

impl PairedProgram<'_> {
    /// Looks at the last of `open` first, and at what is left of it with one side of the pair most violated, the smaller one first.
    /// [`BRANCHES`] programs a pair find most points and proofs; beyond them it begins anew, with a cut in the place of
    /// branches wherever there is one.
    pub(crate) fn search(&mut self, mut open: Vec<Node>, watch: &mut Watch<'_>) -> End {
        let free = self.program.upper.clone();
        let (mut is_proved, mut cuts) = (true, false);
        while let Some((decided, known)) = open.pop() {
            if self.programs >= self.most_programs || watch.stop.is_some() {
                return End::Open;
            }
            if !cuts && self.programs > BRANCHES * self.pairs.len() {
                (is_proved, cuts) = (true, true);
                open = vec![(Vec::new(), None)];
                continue;
            }
            for &side in &decided {
                self.program.upper[side] = self.program.lower[side];
            }
            let found = known.map_or_else(|| self.solve(watch), Found::Point);
            self.program.upper.copy_from_slice(&free);
            let d = match found {
                Found::Point(d) => d,
                Found::Absent => continue,
                Found::Failed => {
                    is_proved = false;
                    continue;
                }
            };
            let off = |i: usize| d[i] - self.program.lower[i];
            let least = |&(i, j): &(usize, usize)| off(i).min(off(j));
            let worst = self.pairs.iter();
            let worst = worst.max_by(|a, b| least(a).total_cmp(&least(b)));
            let Some(&(i, j)) = worst.filter(|pair| least(pair) > NONE) else {
                return End::Point(d);
            };
            let (first, last) = if off(i) <= off(j) { (i, j) } else { (j, i) };
            if cuts && self.cut((i, j), &d, watch) {
                open.push((decided, None));
                continue;
            }
            for side in [last, first] {
                open.push(([decided.as_slice(), &[side]].concat(), None));
            }
        }
        if is_proved { End::Absent } else { End::Open }
    }

    /// The program without the pairs.
    fn solve(&mut self, watch: &mut Watch<'_>) -> Found {
        self.programs += 1;
        match self.program.solve_below(self.limit, watch) {
            Outcome::Solution(d, value, _) if value < self.limit => Found::Point(d),
            Outcome::Failed => Found::Failed,
            _ => Found::Absent,
        }
    }

    /// Adds a row that every point with this pair fulfils and `d` does not; whether there is one.
    fn cut(&mut self, pair: (usize, usize), d: &[f64], watch: &mut Watch<'_>) -> bool {
        self.programs += 1;
        let hull = hull(&self.program, pair, d);
        let y = match hull.solve_below(f64::INFINITY, watch) {
            Outcome::Solution(_, distance, y) if distance > DEPTH => y,
            _ => return false,
        };
        let (normal, most) = inequality(&hull, &y);
        let entries: Vec<(usize, f64)> = normal.into_iter().enumerate().collect();
        self.program.add_row((f64::NEG_INFINITY, most), &entries);
        true
    }
}

/// How far `d` is from the hull of what the two choices of a vanishing side leave of a program,
///
/// ```text
///     min t  s.t.  |d_1 + d_2 - d|_inf <= t,  d_c in lambda_c P_c,  lambda_1 + lambda_2 = 1
/// ```
///
/// over `d_1`, `d_2`, `lambda_1`, `lambda_2`, `t`; the first rows are those with `d`, two a variable, the next is that of `lambda`.
fn hull(of: &LinearProgram, (first, second): (usize, usize), d: &[f64]) -> LinearProgram {
    let n = d.len();
    let t = 2 * n + 2;
    let widest = of.upper.iter().zip(&of.lower).map(|(u, l)| u - l);
    let mut hull = LinearProgram {
        gradient: vec![0.0; t + 1],
        pattern: Vec::new(),
        values: Vec::new(),
        row_lower: Vec::new(),
        row_upper: Vec::new(),
        lower: of.lower.iter().map(|l| l.min(0.0)).collect(),
        upper: of.upper.iter().map(|u| u.max(0.0)).collect(),
    };
    hull.gradient[t] = 1.0;
    hull.lower.extend_from_within(..);
    hull.upper.extend_from_within(..);
    hull.lower.extend([0.0; 3]);
    hull.upper.extend([1.0, 1.0, widest.fold(0.0, f64::max)]);
    let any = f64::INFINITY;
    for (k, &d) in d.iter().enumerate() {
        hull.add_row((d, any), &[(k, 1.0), (n + k, 1.0), (t, 1.0)]);
        hull.add_row((-any, d), &[(k, 1.0), (n + k, 1.0), (t, -1.0)]);
    }
    hull.add_row((1.0, 1.0), &[(2 * n, 1.0), (2 * n + 1, 1.0)]);
    let mut rows = vec![Vec::new(); of.row_lower.len()];
    for (&(row, k), &value) in of.pattern.iter().zip(&of.values) {
        rows[row].push((k, value));
    }
    for (copy, side) in [first, second].into_iter().enumerate() {
        // `lower <= a'd <= upper` times `lambda`
        let mut scaled = |entries: &[(usize, f64)], (lower, upper): (f64, f64)| {
            let own = |at: f64| {
                let own = entries.iter().map(|&(k, a)| (copy * n + k, a));
                own.chain([(2 * n + copy, -at)]).collect::<Vec<_>>()
            };
            if lower == upper {
                hull.add_row((0.0, 0.0), &own(lower));
                return;
            }
            if lower.is_finite() {
                hull.add_row((0.0, any), &own(lower));
            }
            if upper.is_finite() {
                hull.add_row((-any, 0.0), &own(upper));
            }
        };
        for (k, (&lower, &upper)) in of.lower.iter().zip(&of.upper).enumerate() {
            let upper = if k == side { lower } else { upper };
            scaled(&[(k, 1.0)], (lower, upper));
        }
        for (entries, bounds) in rows.iter().zip(of.row_lower.iter().zip(&of.row_upper)) {
            scaled(entries, (*bounds.0, *bounds.1));
        }
    }
    hull
}

/// `a` and `b` of `a'd <= b` for all points of a hull, by multipliers of its rows: without `d` and `t` they leave a lower bound of zero.
fn inequality(hull: &LinearProgram, y: &[f64]) -> (Vec<f64>, f64) {
    let t = hull.gradient.len() - 1;
    let n = (t - 2) / 2;
    let normal = y[..2 * n].chunks_exact(2).map(|y| y[0] + y[1]).collect();
    let mut reduced = vec![0.0; t + 1];
    for (&(row, k), value) in hull.pattern.iter().zip(&hull.values) {
        reduced[k] -= value * y[row];
    }
    let rooms = hull.lower.iter().zip(&hull.upper).zip(&reduced);
    let least = |((lower, upper), r): ((&f64, &f64), &f64)| (r * lower).min(r * upper);
    let left = y[2 * n] + rooms.take(t).map(least).sum::<f64>();
    (normal, -left)
}

#[cfg(test)]
mod tests {
    use super::super::Settings;
    use super::*;
    use crate::linalg::conformance::Random;
    use crate::nlp::IterationInfo;

    const ANY: f64 = f64::INFINITY;
    const LIMIT: f64 = -1e-6;

    fn with_watch<T>(work: impl FnOnce(&mut Watch<'_>) -> T) -> T {
        let settings = Settings::default();
        let mut observer = |_: &IterationInfo| true;
        work(&mut Watch::new(&settings, &mut observer))
    }

    /// What a search comes to, and its linear programs.
    fn search(program: &LinearProgram, pairs: &[(usize, usize)]) -> (End, usize) {
        let mut search = PairedProgram {
            program: program.clone(),
            pairs,
            limit: LIMIT,
            programs: 0,
            most_programs: 200,
        };
        let end = with_watch(|watch| search.search(vec![(Vec::new(), None)], watch));
        (end, search.programs)
    }

    /// Pairs `(3 k, 3 k + 1)`, free variables `3 k + 2` and no rows yet, all within one.
    fn plain(count: usize, random: &mut Random) -> (LinearProgram, Vec<(usize, usize)>) {
        let n = 3 * count;
        let program = LinearProgram {
            gradient: (0..n).map(|_| random.next()).collect(),
            pattern: Vec::new(),
            values: Vec::new(),
            row_lower: Vec::new(),
            row_upper: Vec::new(),
            lower: (0..n)
                .map(|i| if i % 3 == 2 { -1.0 } else { 0.0 })
                .collect(),
            upper: vec![1.0; n],
        };
        (program, (0..count).map(|k| (3 * k, 3 * k + 1)).collect())
    }

    /// `min -w'c` where `c_k <= s_k a_k`, `c_k <= t_k b_k` and `a_k` complements `b_k`, so that no `c_k` is positive; rows over all
    /// variables, `shared` of them, tie the copies together.
    fn copies(
        count: usize,
        shared: usize,
        random: &mut Random,
    ) -> (LinearProgram, Vec<(usize, usize)>) {
        let (mut program, pairs) = plain(count, random);
        program.gradient.fill(0.0);
        for &(a, b) in &pairs {
            let c = b + 1;
            program.gradient[c] = -1.0 + 0.5 * random.next();
            for side in [a, b] {
                let slope = 2.0 + random.next();
                program.add_row((-ANY, 0.0), &[(c, 1.0), (side, -slope)]);
            }
        }
        for _ in 0..shared {
            let all: Vec<_> = (0..3 * count).map(|i| (i, random.next())).collect();
            program.add_row((-ANY, 0.0), &all);
        }
        (program, pairs)
    }

    #[test]
    fn search_says_what_all_branches_say() {
        let mut random = Random(4);
        let mut said = [0; 2];
        for case in 0..120 {
            let count = 1 + case % 5;
            let (mut program, pairs) = if case % 4 == 0 {
                copies(count, 1, &mut random)
            } else {
                plain(count, &mut random)
            };
            for _ in 0..4 * count {
                let all = (0..3 * count).map(|i| (i, random.next()));
                let some: Vec<_> = all.filter(|&(_, a)| a.abs() > 0.4).collect();
                program.add_row((-ANY, 0.0), &some);
            }
            let descends = (0..1 << count).any(|sides: usize| {
                let mut branch = program.clone();
                for (k, &(i, j)) in pairs.iter().enumerate() {
                    branch.upper[if sides >> k & 1 == 0 { i } else { j }] = 0.0;
                }
                let outcome = with_watch(|watch| branch.solve_below(LIMIT, watch));
                matches!(outcome, Outcome::Solution(_, value, _) if value < LIMIT)
            });
            let (end, _) = search(&program, &pairs);
            assert_ne!(end, End::Open, "{case}");
            assert_eq!(matches!(end, End::Point(_)), descends, "{case}");
            said[usize::from(descends)] += 1;
        }
        assert!(said.iter().all(|&n| n >= 30), "{said:?}");
    }

    #[test]
    fn cut_holds_in_both_branches_and_not_at_the_point() {
        let mut random = Random(9);
        for _ in 0..20 {
            let (program, pairs) = copies(3, 1, &mut random);
            let solved = with_watch(|watch| program.solve(watch));
            let (d, _) = solved.expect("a bounded program");
            let hull = hull(&program, pairs[0], &d);
            let Outcome::Solution(_, distance, y) = with_watch(|w| hull.solve_below(ANY, w)) else {
                panic!("a bounded program");
            };
            let (normal, most) = inequality(&hull, &y);
            let at: f64 = normal.iter().zip(&d).map(|(a, d)| a * d).sum();
            // as deep as the point is far, in the norm of all sizes that belongs to the largest one
            assert!(
                (at - most - distance).abs() < 1e-6,
                "{at} {most} {distance}"
            );
            for side in [pairs[0].0, pairs[0].1] {
                let mut branch = program.clone();
                branch.upper[side] = 0.0;
                branch.gradient = normal.iter().map(|a| -a).collect();
                let highest = with_watch(|watch| branch.solve(watch)).expect("a bounded program");
                assert!(-highest.1 <= most + 1e-8, "{} {most}", -highest.1);
            }
        }
    }

    #[test]
    fn copies_that_share_rows_take_programs_in_proportion() {
        // branches alone take 2^k - 1 with one row of the free variables
        let mut random = Random(2);
        for shared in [1, 3] {
            for count in [4, 8, 12, 16] {
                let (program, pairs) = copies(count, shared, &mut random);
                let (end, programs) = search(&program, &pairs);
                assert_eq!(end, End::Absent, "{count} {shared}");
                assert!(programs <= 6 * count, "{count} {shared}: {programs}");
            }
        }
    }
}
