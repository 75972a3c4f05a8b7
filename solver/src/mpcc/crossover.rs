//! From the relaxed solution to an exact one: fix one side of each pair and solve the smooth program.

use super::branch::{Attempt, solve_branch};
use super::certificate::{Certifier, ROUGH, StationarityType};
use super::forced::mark_forced;
use super::sides::choose_sides;
use super::watch::Watch;
use super::{Certificate, Mpcc, Residuals, Settings, Solution, Status};
use crate::nlp::{self, Variant};

/// A paired variable below this counts as zero.
const ZERO: f64 = 1e-7;
/// Part of an objective that is rounding error: the same point, reached again.
const ROUNDING: f64 = 1e-12;
/// Most changes of the fixed sides after the first crossover.
const MOST_REPAIRS: usize = 10;

/// An exact point.
#[derive(Debug, Clone)]
pub(crate) struct Exact {
    point: nlp::Solution,
    certificate: Certificate,
}

impl Exact {
    /// A solved branch with its certificate.
    fn new(
        problem: &mut dyn Mpcc,
        settings: &Settings,
        vanishes: Vec<bool>,
        point: nlp::Solution,
        watch: &mut Watch<'_>,
    ) -> Self {
        Self::below(problem, settings, (vanishes, point), f64::INFINITY, watch)
    }

    /// The exact point of a choice that a descent from a point of this objective led to.
    fn below(
        problem: &mut dyn Mpcc,
        settings: &Settings,
        (vanishes, mut point): (Vec<bool>, nlp::Solution),
        left: f64,
        watch: &mut Watch<'_>,
    ) -> Self {
        clean(problem, &vanishes, &mut point);
        let mut judge = Judge::new(problem, settings, vanishes, point);
        judge.left = left;
        let certificate = judge.certify(problem, watch);
        if certificate.b_stationary == Some(true) {
            judge.take_multipliers(problem, watch);
        }
        Self {
            certificate,
            point: judge.point,
        }
    }

    fn is_certified(&self) -> bool {
        self.certificate.b_stationary == Some(true)
    }

    /// Writes the point to a solution.
    pub(crate) fn describe(self, problem: &dyn Mpcc, solution: &mut Solution) {
        let point = self.point;
        let pairs = problem.complementarities().iter();
        solution.residuals = Residuals {
            primal: point.residuals.primal,
            dual: point.residuals.dual,
            complementarity: pairs.fold(0.0, |most: f64, &(i, j)| {
                most.max(point.x[i].min(point.x[j]))
            }),
        };
        solution.violation_stationarity = None;
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
    }
}

/// From a run that goes on if this fails.
const PAUSED: [Attempt; 1] = [Attempt::new(1e-6, 1e-5)];
/// From the end of a relaxed run.
const FINAL: [Attempt; 3] = [
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

/// Where no rule has found a certified point: each of these may take many iterations.
const PATIENT: [Attempt; 2] = [Attempt::patient(1e-4, 1e-7), Attempt::patient(1e-1, 1e-8)];

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

/// Crossover from a relaxed solution, with repairs while the certificate finds descent. At the end of the last run, where the
/// smaller sides lead nowhere, a linear program chooses the sides.
pub(crate) fn cross_over(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    relaxed: &nlp::Solution,
    is_last: bool,
    watch: &mut Watch<'_>,
) -> Option<Exact> {
    let attempts: &[Attempt] = if is_last { &FINAL } else { &PAUSED };
    let start = nlp::WarmStart::from_solution(relaxed);
    let mut vanishes = choose(problem, &start);
    let attempt_all = |problem: &mut dyn Mpcc, vanishes: &[bool], start: &_, watch: &mut _| {
        let mut attempts = attempts.iter();
        attempts
            .find_map(|&attempt| solve_branch(problem, settings, vanishes, start, attempt, watch))
    };
    let point = match attempt_all(problem, &vanishes, &start, watch) {
        Some(point) => point,
        None if !is_last => return None,
        None => {
            let (sides, x) = choose_sides(problem, relaxed, watch)?;
            vanishes = sides;
            mark_forced(problem, &x, &mut vanishes);
            let start = nlp::WarmStart { x, ..start };
            attempt_all(problem, &vanishes, &start, watch)?
        }
    };
    Some(watch.with_all(|watch| {
        let exact = Exact::new(problem, settings, vanishes, point, watch);
        descend(problem, settings, exact, &NEAR, watch)
    }))
}

/// Repairs while the certificate finds descent.
fn descend(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    mut exact: Exact,
    attempts: &[Attempt],
    watch: &mut Watch<'_>,
) -> Exact {
    for _ in 0..MOST_REPAIRS {
        let Some(next) = repair(problem, settings, &exact, attempts, watch) else {
            break;
        };
        exact = next;
    }
    exact
}

/// The sides that vanish near a point, with what linear rows force to zero besides.
pub(crate) fn choose(problem: &mut dyn Mpcc, at: &nlp::WarmStart) -> Vec<bool> {
    let mut vanishes = vanishing_sides(problem, &at.x, &at.multipliers_lower);
    mark_forced(problem, &at.x, &mut vanishes);
    vanishes
}

/// Solves the program of a choice of sides with many iterations, or looks for a feasible point of it only.
pub(crate) fn patient_point(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    vanishes: &[bool],
    start: &nlp::WarmStart,
    until_feasible: bool,
    watch: &mut Watch<'_>,
) -> Option<nlp::Solution> {
    PATIENT.iter().find_map(|&attempt| {
        let attempt = if until_feasible {
            attempt.until_feasible()
        } else {
            attempt
        };
        solve_branch(problem, settings, vanishes, start, attempt, watch)
    })
}

/// The certificate of a point of a choice of sides, or of a lower one.
pub(crate) fn descend_from(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    vanishes: Vec<bool>,
    point: nlp::Solution,
    watch: &mut Watch<'_>,
) -> Exact {
    watch.with_all(|watch| {
        let exact = Exact::new(problem, settings, vanishes, point, watch);
        descend(problem, settings, exact, &NEAR[..2], watch)
    })
}

/// The sides that stay at zero along a descent direction of the certificate. A side may belong to several pairs, and what one
/// of them clearly says counts more than what another one leaves to rounding.
fn sides_along(problem: &dyn Mpcc, exact: &Exact, descent: &[f64]) -> Vec<bool> {
    let pairs = problem.complementarities();
    let x = &exact.point.x;
    let biactive = &exact.certificate.biactive;
    // What linear rows forced to zero is left out: other sides may set it free.
    let mut vanishes = vec![false; x.len()];
    for (k, &(i, j)) in pairs.iter().enumerate() {
        if biactive.binary_search(&k).is_err() && !vanishes[i] && !vanishes[j] {
            vanishes[if x[i] <= x[j] { i } else { j }] = true;
        }
    }
    let moved = |i: usize| x[i] + RADIUS * descent[i];
    let apart = |k: usize| (moved(pairs[k].0) - moved(pairs[k].1)).abs();
    let mut by_clearness = biactive.clone();
    by_clearness.sort_by(|&a, &b| apart(b).total_cmp(&apart(a)));
    for k in by_clearness {
        let (i, j) = pairs[k];
        if !vanishes[i] && !vanishes[j] {
            vanishes[if moved(i) <= moved(j) { i } else { j }] = true;
        }
    }
    vanishes
}

/// A lower point of the branch that contains the descent direction of the certificate.
fn repair(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    exact: &Exact,
    attempts: &[Attempt],
    watch: &mut Watch<'_>,
) -> Option<Exact> {
    let descent = exact.certificate.descent.as_ref()?;
    let mut vanishes = sides_along(problem, exact, descent);
    mark_forced(problem, &exact.point.x, &mut vanishes);
    let mut start = nlp::WarmStart::from_solution(&exact.point);
    for (x, d) in start.x.iter_mut().zip(descent) {
        *x += 1e-3 * d;
    }
    let objective = exact.point.objective;
    let lower = objective - ROUNDING * objective.abs();
    let point = attempts.iter().find_map(|&attempt| {
        solve_branch(problem, settings, &vanishes, &start, attempt, watch)
            .filter(|next| next.objective < lower)
    })?;
    let found = (vanishes, point);
    Some(Exact::below(problem, settings, found, lower, watch))
}

/// The exact point of a choice of sides where it is lower than an objective by more than what its accuracy leaves.
fn lower(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    than: f64,
    (sides, start, attempts): (Vec<bool>, &nlp::WarmStart, &[Attempt]),
    watch: &mut Watch<'_>,
) -> Option<Exact> {
    let mut attempts = attempts.iter();
    let point = attempts
        .find_map(|&attempt| solve_branch(problem, settings, &sides, start, attempt, watch))?;
    let least = 10.0 * settings.interior_point.tolerance * than.abs().max(1.0);
    (point.objective < than - least).then(|| Exact::new(problem, settings, sides, point, watch))
}

/// Crosses over from a relaxed solution to a certified point that is better than the one known, with repairs, and takes it; whether there
/// is one.
pub(crate) fn cross_lower(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    relaxed: &nlp::Solution,
    known: &mut Solution,
    watch: &mut Watch<'_>,
) -> bool {
    let start = nlp::WarmStart::from_solution(relaxed);
    let sides = choose(problem, &start);
    let from = (sides, &start, &FINAL[..]);
    let Some(exact) = lower(problem, settings, known.objective, from, watch) else {
        return false;
    };
    let exact = descend(problem, settings, exact, &NEAR, watch);
    let is_better = exact.is_certified();
    if is_better {
        exact.describe(problem, known);
    }
    is_better
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
/// Share of its distance from zero that a side has to go to the end of the path for it to vanish there: half of what it goes where
/// its multiplier vanishes as well.
const GOES: f64 = 0.25;
/// Sides of this many roots of it that no program could be solved without are positive.
const CLEAR: f64 = 10.0;
/// Sides larger than this never vanish.
const MOST_NEAR: f64 = 1e-2;
/// Radius of the linear programs of the certificate, so that such sides can be left.
const RADIUS: f64 = 0.1;

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
    /// Pairs whose sides both vanish in every choice.
    forced: Vec<usize>,
    /// Pairs of which it could not be decided.
    undecided: Vec<bool>,
    /// Objective of the point whose descent led here: a path that came down from there does not go back.
    left: f64,
    /// Steps of the variables from the point to the end of its path, empty where they tell nothing; `None` before anybody asks.
    to_end: Option<Vec<f64>>,
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
            forced: Vec::new(),
            undecided: vec![false; pairs.len()],
            pairs,
            point,
            vanishes,
            left: f64::INFINITY,
            to_end: None,
        }
    }

    /// Root of the barrier parameter where the path ends, as far as side `i` is concerned.
    fn root(&self, i: usize) -> f64 {
        // the barrier parameter is one of the scaled objective; the product is in the caller's unit
        let product = self.point.x[i] * self.point.multipliers_lower[i];
        self.point.barrier_parameter.max(product).sqrt()
    }

    /// Whether side `i` is small on the scale of the path.
    fn is_small(&self, i: usize) -> bool {
        self.point.x[i] <= (NEARNESS * self.root(i)).clamp(ZERO, MOST_NEAR)
    }

    /// Whether side `i` may vanish where the path goes to.
    fn is_near(&self, i: usize) -> bool {
        let x = self.point.x[i];
        let goes = self.to_end.as_ref().and_then(|steps| steps.get(i));
        x <= ZERO || self.is_small(i) && goes.is_none_or(|step| -step >= GOES * x)
    }

    /// Looks where the path goes to, if a pair hangs on it.
    fn look_ahead(&mut self, problem: &mut dyn Mpcc, watch: &mut Watch<'_>) {
        let hangs = |k: usize| {
            let (i, j) = self.pairs[k];
            self.open[k] && self.is_doubtful(k) && self.is_small(i) && self.is_small(j)
        };
        if self.to_end.is_some() || !(0..self.pairs.len()).any(hangs) {
            return;
        }
        let steps = if self.point.residuals.dual <= ROUGH {
            let mut branch = Variant {
                fixed: self.vanishes.clone(),
                ..Variant::of(problem)
            };
            let settings = &self.settings.interior_point;
            let start = nlp::WarmStart::from_solution(&self.point);
            let (steps, factorizations) = nlp::end_of_path(&mut branch, settings, &start);
            watch.factorizations += factorizations;
            steps
        } else {
            None
        };
        self.to_end = Some(steps.unwrap_or_default());
    }

    /// Whether pair `k` may be biactive, though a side is not zero.
    fn is_doubtful(&self, k: usize) -> bool {
        let (i, j) = self.pairs[k];
        let larger = self.point.x[i].max(self.point.x[j]);
        larger > ZERO
    }

    /// Whether the larger side of pair `k` is positive as far as the end of the path can tell.
    fn is_clear(&self, k: usize) -> bool {
        let (i, j) = self.pairs[k];
        [i, j]
            .iter()
            .any(|&i| self.point.x[i] > CLEAR * self.root(i))
    }

    /// Variables without a pair that are fixed at zero, as linear rows with vanishing sides force them there.
    fn held_by_rows(&self) -> Vec<usize> {
        let mut held = self.vanishes.clone();
        for &(i, j) in &self.pairs {
            held[i] = false;
            held[j] = false;
        }
        (0..held.len()).filter(|&i| held[i]).collect()
    }

    /// The certificate of the point, which moves to where undecided sides vanish.
    fn certify(&mut self, problem: &mut dyn Mpcc, watch: &mut Watch<'_>) -> Certificate {
        let mut certificate = self.certify_open(problem, watch);
        if !self.forced.is_empty() {
            // nothing hangs on these pairs, but the signs of their multipliers belong to the kind of the point
            let certifier = Certifier::new(problem, &self.pairs, &self.point, RADIUS);
            let kinds = self.forced.iter().map(|&k| certifier.classify(k));
            let kind = kinds.fold(certificate.stationarity, Ord::min);
            certificate.stationarity = kind;
            certificate.biactive.extend(&self.forced);
            certificate.biactive.sort_unstable();
        }
        certificate
    }

    /// Takes the multipliers of the certificate where those of the point are rough.
    fn take_multipliers(&mut self, problem: &mut dyn Mpcc, watch: &mut Watch<'_>) {
        let certifier = Certifier::new(problem, &self.pairs, &self.point, RADIUS);
        if let Some((rows, variables, left)) = certifier.multipliers(watch) {
            self.point.multipliers = rows;
            for (i, z) in variables.into_iter().enumerate() {
                self.point.multipliers_lower[i] = z.max(0.0);
                self.point.multipliers_upper[i] = (-z).max(0.0);
            }
            clean(problem, &self.vanishes, &mut self.point);
            self.point.residuals.dual = left;
        }
    }

    /// The certificate without the pairs that leave nothing to decide.
    fn certify_open(&mut self, problem: &mut dyn Mpcc, watch: &mut Watch<'_>) -> Certificate {
        loop {
            self.look_ahead(problem, watch);
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
                let held = self.held_by_rows();
                let mut certificate = certifier.certify(biactive, &held, watch);
                if certificate.b_stationary.is_none() && watch.stop.is_none() {
                    let forced = self.forced(problem, &certificate.biactive);
                    if !forced.is_empty() {
                        forced.iter().for_each(|&k| self.open[k] = false);
                        self.forced.extend(forced);
                        continue;
                    }
                }
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
                let (vague, used): (Vec<usize>, Vec<usize>) =
                    used.into_iter().partition(|&k| self.undecided[k]);
                let positive = vague.iter().all(|&k| self.is_clear(k));
                if !positive {
                    certificate.b_stationary = None;
                    return certificate;
                }
                if !vague.is_empty() {
                    vague.iter().for_each(|&k| self.open[k] = false);
                    continue;
                }
                if used.is_empty() {
                    return certificate;
                }
                doubtful = used;
            }
            self.decide(problem, &doubtful, watch);
        }
    }

    /// Those of some pairs `(i, j)` in which a linear row forces `x_i = 0` to zero with `x_j`: every choice has `x_i = 0`,
    /// which leaves nothing to decide.
    fn forced(&self, problem: &mut dyn Mpcc, pairs: &[usize]) -> Vec<usize> {
        let x = &self.point.x;
        let mut is_forced = |k: usize| {
            let (i, j) = self.pairs[k];
            // the certificate keeps the smaller side at zero, the first of equal ones
            let (stays, other) = if x[i] <= x[j] { (i, j) } else { (j, i) };
            let mut vanishes = vec![false; x.len()];
            vanishes[other] = true;
            mark_forced(problem, x, &mut vanishes);
            vanishes[stays] && x[stays] == 0.0
        };
        pairs.iter().copied().filter(|&k| is_forced(k)).collect()
    }

    /// Decides whether these pairs vanish, together.
    fn decide(&mut self, problem: &mut dyn Mpcc, doubtful: &[usize], watch: &mut Watch<'_>) {
        match self.vanish(problem, doubtful, watch) {
            Some(true) => {}
            Some(false) if doubtful.len() == 1 => self.open[doubtful[0]] = false,
            _ => doubtful.iter().for_each(|&k| self.undecided[k] = true),
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
        let both = point.objective <= self.point.objective + least && point.objective < self.left;
        let distance = point.x.iter().zip(&self.point.x);
        let distance = distance.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
        if both {
            (self.point, self.vanishes, self.to_end) = (point, vanishes, None);
            Some(true)
        } else if distance <= RADIUS {
            Some(false)
        } else {
            // a solution elsewhere says nothing
            None
        }
    }
}
