//! From the relaxed solution to an exact one: fix one side of each pair and solve the smooth program.

use super::branch::{Attempt, solve_branch};
use super::certificate::{Certifier, StationarityType};
use super::forced::mark_forced;
use super::watch::Watch;
use super::{Certificate, Mpcc, Residuals, Settings, Solution, Status};
use crate::nlp;

/// A paired variable below this counts as zero.
const ZERO: f64 = 1e-7;
/// Most changes of the fixed sides after the first crossover.
const MOST_REPAIRS: usize = 10;

/// An exact point.
#[derive(Debug, Clone)]
pub(crate) struct Exact {
    point: nlp::Solution,
    certificate: Certificate,
    /// The sides that are fixed at zero.
    vanishes: Vec<bool>,
    pub(crate) repairs: usize,
}

impl Exact {
    /// A solved branch with its certificate.
    fn new(
        problem: &mut dyn Mpcc,
        settings: &Settings,
        vanishes: Vec<bool>,
        mut point: nlp::Solution,
        watch: &mut Watch<'_>,
    ) -> Self {
        clean(problem, &vanishes, &mut point);
        let mut judge = Judge::new(problem, settings, vanishes.clone(), point);
        let certificate = judge.certify(problem, watch);
        Self {
            certificate,
            point: judge.point,
            vanishes,
            repairs: 0,
        }
    }

    /// Writes the point to a solution and returns the choice of sides.
    pub(crate) fn describe(self, problem: &dyn Mpcc, solution: &mut Solution) -> Vec<bool> {
        let point = self.point;
        let pairs = problem.complementarities().iter();
        solution.residuals = Residuals {
            primal: point.residuals.primal,
            dual: point.residuals.dual,
            complementarity: pairs.fold(0.0, |most: f64, &(i, j)| {
                most.max(point.x[i].min(point.x[j]))
            }),
        };
        solution.status = match self.certificate.b_stationary {
            Some(true) => Status::Solved,
            Some(false) => Status::NotStationary,
            None => Status::Uncertified,
        };
        solution.objective = point.objective;
        solution.x = point.x;
        solution.multipliers = point.multipliers;
        solution.multipliers_lower = point.multipliers_lower;
        solution.multipliers_upper = point.multipliers_upper;
        solution.violations = point.violations;
        solution.certificate = Some(self.certificate);
        self.vanishes
    }
}

/// From a run that goes on if this fails.
pub(crate) const PAUSED: [Attempt; 1] = [Attempt::new(1e-6, 1e-5)];
/// From the end of a relaxed run.
pub(crate) const FINAL: [Attempt; 3] = [
    Attempt::new(1e-6, 1e-5),
    Attempt::new(1e-6, 1e-7),
    Attempt::new(1e-3, 1e-8),
];
/// After a step along a descent direction, the first also from another choice of sides.
const NEAR: [Attempt; 3] = [
    Attempt::new(1e-4, 1e-5),
    Attempt::new(1e-6, 1e-7),
    Attempt::new(1e-2, 1e-8),
];

/// Which variables to fix at zero: the choice of the problem if it has one, else the smaller side of each
/// pair.
fn vanishing_sides(problem: &dyn Mpcc, x: &[f64], nu: &[f64]) -> Vec<bool> {
    let mut vanishes = vec![false; x.len()];
    if problem.vanishing_sides(x, &mut vanishes) {
        let covered = problem
            .complementarities()
            .iter()
            .all(|&(i, j)| vanishes[i] || vanishes[j]);
        if covered {
            return vanishes;
        }
        vanishes.fill(false);
    }
    // decided pairs first, so that a variable shared with an undecided pair settles that pair too
    for undecided in [false, true] {
        for &(i, j) in problem.complementarities() {
            let both_small = x[i].max(x[j]) <= 1e3 * ZERO;
            if both_small != undecided || vanishes[i] || vanishes[j] {
                continue;
            }
            let first = if both_small {
                nu[i] >= nu[j]
            } else {
                x[i] <= x[j]
            };
            vanishes[if first { i } else { j }] = true;
        }
    }
    vanishes
}

/// Crossover from a relaxed solution, with repairs while the certificate finds descent.
pub(crate) fn cross_over(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    relaxed: &nlp::Solution,
    attempts: &[Attempt],
    watch: &mut Watch<'_>,
) -> Option<Exact> {
    let mut vanishes = vanishing_sides(problem, &relaxed.x, &relaxed.multipliers_lower);
    mark_forced(problem, &relaxed.x, &mut vanishes);
    let start = nlp::WarmStart::from_solution(relaxed);
    let point = attempts
        .iter()
        .find_map(|&attempt| solve_branch(problem, settings, &vanishes, &start, attempt, watch))?;
    let mut exact = Exact::new(problem, settings, vanishes, point, watch);
    while exact.repairs < MOST_REPAIRS {
        let Some(next) = repair(problem, settings, &exact, watch) else {
            break;
        };
        exact = Exact {
            repairs: exact.repairs + 1,
            ..next
        };
    }
    Some(exact)
}

/// A lower point of the branch that contains the descent direction of the certificate.
fn repair(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    exact: &Exact,
    watch: &mut Watch<'_>,
) -> Option<Exact> {
    let descent = exact.certificate.descent.as_ref()?;
    let mut vanishes = exact.vanishes.clone();
    let moved = |i: usize| exact.point.x[i] + RADIUS * descent[i];
    for &k in &exact.certificate.biactive {
        let (i, j) = problem.complementarities()[k];
        let first = moved(i) <= moved(j);
        vanishes[i] = first;
        vanishes[j] = !first;
    }
    for &(i, j) in problem.complementarities() {
        if !vanishes[i] && !vanishes[j] {
            let first = exact.point.x[i] <= exact.point.x[j];
            vanishes[if first { i } else { j }] = true;
        }
    }
    mark_forced(problem, &exact.point.x, &mut vanishes);
    let mut start = nlp::WarmStart::from_solution(&exact.point);
    for (x, d) in start.x.iter_mut().zip(descent) {
        *x += 1e-3 * d;
    }
    let point = NEAR.iter().find_map(|&attempt| {
        solve_branch(problem, settings, &vanishes, &start, attempt, watch)
            .filter(|next| next.objective < exact.point.objective)
    })?;
    Some(Exact::new(problem, settings, vanishes, point, watch))
}

/// Iterations that neighbours may take at least, and at most as a part of those before: a step of a scene has few
/// and cheap ones, and in a long motion each of many may cost as much as the others without a gain.
const NEIGHBOUR_ITERATIONS: usize = 150;
const NEIGHBOUR_PART: usize = 4;

/// Tries the neighbours of a certified point that the problem knows of, in their order, and goes on from each that
/// is certified and better, until none is, [`Settings::maximum_neighbours`] are tried, or their iterations are used up.
pub(crate) fn improve(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    solution: &mut Solution,
    vanishes: &mut Vec<bool>,
    watch: &mut Watch<'_>,
) {
    let before = watch.iterations;
    let limit = before + NEIGHBOUR_ITERATIONS.max(before / NEIGHBOUR_PART);
    loop {
        let mut improved = false;
        for index in 0.. {
            let spent =
                solution.neighbours >= settings.maximum_neighbours || watch.iterations >= limit;
            if spent || watch.stop.is_some() {
                return;
            }
            let mut start = nlp::WarmStart {
                x: solution.x.clone(),
                multipliers: solution.multipliers.clone(),
                multipliers_lower: solution.multipliers_lower.clone(),
                multipliers_upper: solution.multipliers_upper.clone(),
                barrier_parameter: settings.interior_point.tolerance,
            };
            let mut sides = vanishes.clone();
            if !problem.neighbour(index, &mut start.x, &mut sides) {
                break;
            }
            solution.neighbours += 1;
            mark_forced(problem, &start.x, &mut sides);
            let point = solve_branch(problem, settings, &sides, &start, NEAR[0], watch);
            let least =
                10.0 * settings.interior_point.tolerance * solution.objective.abs().max(1.0);
            let Some(point) = point.filter(|p| p.objective < solution.objective - least) else {
                continue;
            };
            let next = Exact::new(problem, settings, sides, point, watch);
            if next.certificate.b_stationary == Some(true) {
                *vanishes = next.describe(problem, solution);
                improved = true;
            }
        }
        if !improved {
            return;
        }
    }
}

/// Multipliers of fixed sides have either sign; one number says it.
fn clean(problem: &dyn Mpcc, vanishes: &[bool], solution: &mut nlp::Solution) {
    for &(i, j) in problem.complementarities() {
        for k in [i, j] {
            if vanishes[k] {
                solution.multipliers_lower[k] -= solution.multipliers_upper[k];
                solution.multipliers_upper[k] = 0.0;
            }
        }
    }
}

/// Sides up to this many roots of the barrier parameter may vanish at the solution: a side with a zero multiplier ends at
/// `sqrt(mu / h)`, `h` the curvature of the Lagrangian along it.
const NEARNESS: f64 = 1e3;
/// Sides larger than this never vanish.
const MOST_NEAR: f64 = 1e-2;
/// Radius of the linear programs of the certificate, so that such sides can be left.
const RADIUS: f64 = 0.1;
/// Most programs that decide whether sides vanish.
const MOST_TRIALS: usize = 20;

/// Decides which pairs of a solved branch are biactive, and certifies it.
///
/// Which sides vanish at a solution the end of a central path shows only where multipliers are positive. Of a pair with one side
/// fixed, whose other side is small on the scale of the path, both are taken for zero first; where the linear programs have no
/// descent even then, the point is certified. Where the verdict hangs on the pair, the program with both sides at zero decides: if
/// its objective is not higher, its solution is the point that the path goes to, and is certified instead.
struct Judge<'s> {
    settings: &'s Settings,
    pairs: Vec<(usize, usize)>,
    point: nlp::Solution,
    /// The sides that are zero exactly at the point.
    vanishes: Vec<bool>,
    /// Pairs that can be biactive: without a side that its bounds hold at zero, or that is known to be positive.
    open: Vec<bool>,
    /// Pairs of which it could not be decided.
    undecided: Vec<bool>,
    trials: usize,
}

impl<'s> Judge<'s> {
    fn new(
        problem: &dyn Mpcc,
        settings: &'s Settings,
        vanishes: Vec<bool>,
        point: nlp::Solution,
    ) -> Self {
        let pairs = problem.complementarities().to_vec();
        let n = point.x.len();
        let (mut lower, mut upper) = (vec![0.0; n], vec![0.0; n]);
        problem.variable_bounds(&mut lower, &mut upper);
        Self {
            settings,
            open: pairs
                .iter()
                .map(|&(i, j)| upper[i] > 0.0 && upper[j] > 0.0)
                .collect(),
            undecided: vec![false; pairs.len()],
            pairs,
            point,
            vanishes,
            trials: 0,
        }
    }

    /// Whether side `i` may vanish where the path goes to.
    fn is_near(&self, i: usize) -> bool {
        let x = self.point.x[i];
        // the barrier parameter is one of the scaled objective; the product is in the caller's unit
        let product = x * self.point.multipliers_lower[i];
        let mu = self.point.barrier_parameter.max(product);
        x <= (NEARNESS * mu.sqrt()).clamp(ZERO, MOST_NEAR)
    }

    /// Whether pair `k` may be biactive, though a side is not zero.
    fn is_doubtful(&self, k: usize) -> bool {
        let (i, j) = self.pairs[k];
        let larger = self.point.x[i].max(self.point.x[j]);
        larger > ZERO
    }

    /// The certificate of the point, which moves to where undecided sides vanish.
    fn certify(&mut self, problem: &mut dyn Mpcc, watch: &mut Watch<'_>) -> Certificate {
        loop {
            let x = &self.point.x;
            let biactive: Vec<usize> = (0..self.pairs.len())
                .filter(|&k| {
                    let (i, j) = self.pairs[k];
                    self.open[k] && self.is_near(i) && self.is_near(j)
                })
                .collect();
            let certifier = Certifier::new(problem, &self.pairs, &self.point, RADIUS);
            let hangs = |k: usize| self.is_doubtful(k) && !self.undecided[k];
            let mut doubtful: Vec<usize> = biactive.clone();
            doubtful.retain(|&k| hangs(k) && certifier.classify(k) < StationarityType::Strong);
            if doubtful.is_empty() {
                let mut certificate = certifier.certify(biactive, watch);
                let Some(descent) = &certificate.descent else {
                    return certificate;
                };
                let used = |k: usize| {
                    let (i, j) = self.pairs[k];
                    let side = if x[i] <= x[j] { i } else { j };
                    self.is_doubtful(k) && certifier.moves(side, descent)
                };
                let used: Vec<usize> = certificate
                    .biactive
                    .iter()
                    .copied()
                    .filter(|&k| used(k))
                    .collect();
                if used.iter().any(|&k| self.undecided[k]) {
                    certificate.b_stationary = None;
                    return certificate;
                }
                if used.is_empty() {
                    return certificate;
                }
                doubtful = used;
            }
            // pairs that are not biactive to first order need no trial
            let (pairs, x) = (&self.pairs, &self.point.x);
            let larger = |k: usize| {
                let (i, j) = pairs[k];
                if x[i] > x[j] { i } else { j }
            };
            let (apart, doubtful): (Vec<usize>, Vec<usize>) = doubtful
                .into_iter()
                .partition(|&k| certifier.can_vanish(larger(k), watch) == Some(false));
            for k in apart {
                self.open[k] = false;
            }
            if !doubtful.is_empty() {
                self.decide(problem, &doubtful, watch);
            }
        }
    }

    /// Decides whether these pairs vanish: together, or else one by one until the first that does.
    fn decide(&mut self, problem: &mut dyn Mpcc, doubtful: &[usize], watch: &mut Watch<'_>) {
        if doubtful.len() > 1 && self.vanish(problem, doubtful, watch) == Some(true) {
            return;
        }
        for &k in doubtful {
            match self.vanish(problem, &[k], watch) {
                Some(true) => return,
                Some(false) => self.open[k] = false,
                None => self.undecided[k] = true,
            }
        }
    }

    /// Whether both sides of these pairs vanish where the path goes to: then the point moves there. `None` if the program
    /// with both at zero could not be solved.
    fn vanish(
        &mut self,
        problem: &mut dyn Mpcc,
        pairs: &[usize],
        watch: &mut Watch<'_>,
    ) -> Option<bool> {
        if self.trials >= MOST_TRIALS {
            return None;
        }
        self.trials += 1;
        let mut vanishes = self.vanishes.clone();
        let mut start = nlp::WarmStart::from_solution(&self.point);
        for &k in pairs {
            for side in [self.pairs[k].0, self.pairs[k].1] {
                vanishes[side] = true;
                start.x[side] = 0.0;
            }
        }
        mark_forced(problem, &start.x, &mut vanishes);
        let mut point = solve_branch(problem, self.settings, &vanishes, &start, PAUSED[0], watch)?;
        clean(problem, &vanishes, &mut point);
        // what is left on the central path: a product for each bound
        let products = (point.x.len() + point.multipliers.len()) as f64;
        let gap = |point: &nlp::Solution| {
            products * point.residuals.complementarity.max(point.barrier_parameter)
        };
        let least = gap(&point).max(gap(&self.point)) + 1e-12 * self.point.objective.abs();
        let both = point.objective <= self.point.objective + least;
        let distance = point.x.iter().zip(&self.point.x);
        let distance = distance.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        if both {
            (self.point, self.vanishes) = (point, vanishes);
            Some(true)
        } else if distance <= RADIUS {
            Some(false)
        } else {
            // a solution elsewhere says nothing
            None
        }
    }
}
