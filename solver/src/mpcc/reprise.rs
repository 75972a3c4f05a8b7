//! Other optima near a certified one, found by relaxing its pairs again.

use super::crossover::cross_lower;
use super::finish::relax;
use super::run::{PAUSE_RELAXATION, make_path, paused};
use super::watch::Watch;
use super::{Mpcc, RelaxationRule, Settings, Solution};
use crate::linalg::norms::norm_inf;
use crate::nlp::{self, InputError, Products};

/// A way back into the relaxed problem.
struct Reprise {
    rule: RelaxationRule,
    /// First barrier and relaxation parameter, and distance from bounds to start at.
    mu: f64,
    sigma: f64,
    push: f64,
}

/// The ways, in the order in which they are tried. Of 203 programs of nosnoc's and of Leyffer's collection that are certified the
/// first one leads to a better optimum of six, and the second one to one of two others.
const REPRISES: [Reprise; 2] = [
    Reprise {
        rule: RelaxationRule::RollOff,
        mu: 1e-3,
        sigma: 1e-2,
        push: 1e-3,
    },
    Reprise {
        rule: RelaxationRule::Continuation,
        mu: 1e-2,
        sigma: 1.0,
        push: 1e-2,
    },
];

/// Pairs up to which the first certified point is left: of 430 programs with so few, among them random ones, a reprise leads to a better
/// optimum of one, and doubles the iterations.
const FEW: usize = 16;

/// Iterations that reprises may take, where those before were fewer: the programs of the table in docs/experiments/solver.md ask for 230 on.
const ITERATIONS: usize = 300;

/// Relaxes a certified point again, from where it is, and goes on from each that is certified and better, until none is or the iterations
/// are used up, as many as before. A relaxed run from the start of the problem decides all sides on one way; from an exact point it can go
/// back on those that it decided worst.
pub(crate) fn reprise(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    solution: &mut Solution,
    watch: &mut Watch<'_>,
) -> Result<(), InputError> {
    let mut gradient = vec![0.0; solution.x.len()];
    problem.gradient(&solution.x, &mut gradient);
    // without a gradient any feasible point is as good
    if problem.complementarities().len() <= FEW || norm_inf(&gradient) == 0.0 {
        return Ok(());
    }
    let limit = watch.used() + watch.used().max(ITERATIONS);
    let mut ways = REPRISES.iter();
    while let Some(way) = ways.next() {
        if watch.used() >= limit || watch.stop.is_some() {
            break;
        }
        let (relaxed, sigma) = again(problem, settings, (solution, way), watch)?;
        if cross_lower(problem, settings, &relaxed, solution, watch) {
            (solution.rule, solution.relaxation_parameter) = (way.rule, sigma);
            solution.history = relaxed.history;
            ways = REPRISES.iter();
        }
    }
    Ok(())
}

/// A relaxed run from an exact point, and the `sigma` that it ends at.
fn again(
    problem: &mut dyn Mpcc,
    settings: &Settings,
    (from, way): (&Solution, &Reprise),
    watch: &mut Watch<'_>,
) -> Result<(nlp::Solution, f64), InputError> {
    let run = nlp::Settings {
        bound_push: way.push,
        bound_fraction: way.push,
        ..paused(&settings.interior_point)
    };
    let start = from.warm_start(way.mu);
    let mut products = Products {
        pairs: problem.complementarities().to_vec(),
        ..Products::default()
    };
    let mut path = make_path(
        way.rule,
        (way.mu, way.sigma),
        run.tolerance,
        PAUSE_RELAXATION,
    );
    let relaxed = relax(
        problem,
        &run,
        (&mut products, &mut *path),
        Some(&start),
        watch,
    )?;
    Ok((relaxed, products.sigma))
}
