//! The order of work: starts, growing shares of the measurements, and what is known at the best end.

use super::covariance::{Knowledge, in_words};
use super::least_squares::{Local, Residuals as _, minimize};
use super::measurements::Measurements;
use super::motions::Motions;
use super::result::{Estimate, EstimatedParameter, FittedExperiment, LocalFit, Status};
use crate::model::{Model, ParameterDeclaration};
use crate::yardstick;
use crate::{InputError, Observer, refusal};
use hangtime_solver::clock::ThreadTime;

/// Shares of the measurements, from the first on, that are fitted one after the other: the first motion up to its first events
/// says most of the parameters, where all of it has an optimum for each number of impacts.
const SHARES: [f64; 4] = [0.15, 0.3, 0.6, 1.0];
/// Starts that are made where the first one leads to nothing that describes the measurements.
const FURTHER: usize = 8;
/// Spread of the residuals above which the measurements are not described.
const DESCRIBED: f64 = 3.0;
/// The first prime numbers: bases in which starts are spread (Halton 1960).
const BASES: [usize; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];

/// How parameters are looked for.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Settings {
    /// Starts: the declared values, then values spread over the ranges. Default one, and 7 more where that leads to no optimum,
    /// or to one with residuals of more than three standard deviations.
    pub starts: Option<usize>,
    /// Free parameters (indices) that keep their values.
    pub given_parameters: Vec<usize>,
}

/// Finds the free parameters of a scene by which its motions are most like the measured ones: weighted least squares of the
/// differences at the times of the measurements, or a robust loss of them, see [`Experiment`](crate::model::Experiment).
///
/// The method is that of Levenberg and Marquardt within the ranges of the parameters, with exact derivatives through impacts and
/// all other events. Where there are none, as at a motion that grazes a surface, differences take their place for the step; an
/// end with differences is not called solved.
///
/// # Errors
/// [`InputError`] if the scene compares with nothing or has no free parameters, if measurements do not fit, and for scenes
/// whose motions are not differentiated by parameters.
pub fn estimate(
    model: &dyn Model,
    measurements: &[Measurements],
    settings: &Settings,
    observer: &mut Observer<'_>,
) -> Result<Estimate, InputError> {
    let clock = ThreadTime::now();
    if model.structure().experiments.is_empty() {
        return Err(refusal::unsupported(
            format!(
                "a fit of `{}`, which compares with no measurements,",
                model.declaration().name
            ),
            "declare `measured` and `minimize misfit(...)`",
        ));
    }
    let mut motions = Motions::new(model, measurements, &settings.given_parameters, observer)?;
    if motions.free().is_empty() {
        return Err(InputError::new(format!(
            "`{}` has no free parameter that is looked for; declare one, as in `free e in 0..=1 = 0.5`, or simulate",
            model.declaration().name
        )));
    }
    if settings.starts == Some(0) {
        return Err(refusal::out_of_range(
            "the number of starts",
            0.0,
            "",
            "at least 1",
        ));
    }
    let declared = first_start(model, &motions)?;
    motions.check(&declared)?;
    let mut ends: Vec<(Local, usize)> = Vec::new();
    let mut starts = 0;
    while starts < settings.starts.unwrap_or(FURTHER) && !motions.is_stopped() {
        let enough = ends
            .first()
            .is_some_and(|(best, _)| best.optimal && best.at.obstacle.is_none() && describes(best));
        if settings.starts.is_none() && enough {
            break;
        }
        let start = spread(&declared, &motions.bounds(), starts);
        starts += 1;
        if let Some(end) = from(&mut motions, &start) {
            keep(&mut ends, end);
        }
    }
    let mut estimate = judged(model, &mut motions, &ends, measurements);
    estimate.starts = starts;
    estimate.simulations = motions.simulations;
    estimate.seconds = clock.elapsed().as_secs_f64();
    Ok(estimate)
}

/// The declared values.
fn first_start(model: &dyn Model, motions: &Motions<'_, '_>) -> Result<Vec<f64>, InputError> {
    let known = motions.free().iter().zip(motions.bounds());
    known
        .map(|(&index, (lower, upper))| {
            let (value, declared) = (
                model.parameter(index),
                &model.declaration().parameters[index],
            );
            if (lower..=upper).contains(&value) {
                return Ok(value);
            }
            Err(refusal::out_of_range(
                format!("free parameter `{}`", declared.name),
                value,
                declared.unit,
                format!("within its range {lower}..={upper}"),
            ))
        })
        .collect()
}

/// The values of a start: the declared ones first, then points spread evenly over the ranges.
fn spread(declared: &[f64], bounds: &[(f64, f64)], start: usize) -> Vec<f64> {
    if start == 0 {
        return declared.to_vec();
    }
    let ranges = bounds.iter().enumerate();
    ranges
        .map(|(j, (lower, upper))| {
            let base = BASES[j % BASES.len()];
            // Beyond as many parameters as bases the sequence begins later.
            let mut rest = start + j / BASES.len();
            let (mut share, mut digit) = (0.0, 1.0);
            while rest > 0 {
                digit /= base as f64;
                share += digit * (rest % base) as f64;
                rest /= base;
            }
            lower + share * (upper - lower)
        })
        .collect()
}

/// Whether residuals are as large as measurements deviate.
fn describes(end: &Local) -> bool {
    end.at.misfit() <= DESCRIBED * DESCRIBED * end.at.residuals.len() as f64
}

/// The better end from one start: of all measurements at once, or of growing shares of them.
fn from(motions: &mut Motions<'_, '_>, start: &[f64]) -> Option<Local> {
    let bounds = motions.bounds();
    let at_once = minimize(motions, start, &bounds);
    if motions.is_stopped() {
        return at_once;
    }
    let mut x = start.to_vec();
    let (mut grown, mut steps) = (None, 0);
    for share in SHARES {
        motions.look_at(share);
        grown = minimize(motions, &x, &bounds);
        if let Some(end) = &mut grown {
            steps += end.steps;
            end.steps = steps;
            x.clone_from(&end.x);
        }
    }
    motions.look_at(1.0);
    match (at_once, grown) {
        (Some(one), Some(other)) => Some(if is_better(&other, &one) { other } else { one }),
        (one, other) => one.or(other),
    }
}

/// Whether an end has less misfit, or as much with its conditions fulfilled.
fn is_better(one: &Local, other: &Local) -> bool {
    let (own, its) = (one.at.misfit(), other.at.misfit());
    if (own - its).abs() <= yardstick::PROMISE * own.max(its) {
        return one.optimal && !other.optimal;
    }
    own < its
}

/// Keeps an end among the others, the best first; equal ones are counted.
fn keep(ends: &mut Vec<(Local, usize)>, end: Local) {
    let is_same = |known: &Local| {
        let (own, its) = (end.at.misfit(), known.at.misfit());
        (own - its).abs() <= yardstick::PROMISE * own.max(its).max(yardstick::PROMISE)
    };
    if let Some((known, count)) = ends.iter_mut().find(|(known, _)| is_same(known)) {
        *count += 1;
        if is_better(&end, known) {
            *known = end;
        }
        return;
    }
    let place = ends.partition_point(|(known, _)| !is_better(&end, known));
    ends.insert(place, (end, 1));
}

/// The result of the best end.
fn judged(
    model: &dyn Model,
    motions: &mut Motions<'_, '_>,
    ends: &[(Local, usize)],
    measurements: &[Measurements],
) -> Estimate {
    let mut estimate = nothing(ends);
    let Some((best, _)) = ends.first() else {
        if motions.is_stopped() {
            estimate.status = Status::Interrupted;
        }
        let why = motions.failure.take().unwrap_or_default();
        estimate.diagnosis = Some(format!(
            "there is no motion to compare with: {why}; begin with other values"
        ));
        return estimate;
    };
    let vague = describe(&mut estimate, model, motions, best);
    for (index, data) in measurements.iter().enumerate() {
        if let Some(compared) = motions.confirmed(index, &best.x) {
            estimate.experiments.push(FittedExperiment {
                declared: &model.structure().experiments[index],
                times: data.times.clone(),
                measured: data.values.clone(),
                computed: compared.computed,
                motion: compared.simulation,
            });
        }
    }
    (estimate.status, estimate.diagnosis) = status(best, &estimate, motions.is_stopped());
    notes(&mut estimate, &vague);
    estimate
}

/// An estimate of which nothing is known but where searches ended.
fn nothing(ends: &[(Local, usize)]) -> Estimate {
    Estimate {
        status: Status::Failed,
        diagnosis: None,
        parameters: Vec::new(),
        misfit: f64::NAN,
        measurements: 0,
        distance: f64::NAN,
        covariance: Vec::new(),
        undetermined: Vec::new(),
        experiments: Vec::new(),
        optima: ends
            .iter()
            .map(|(end, starts)| local(end, *starts))
            .collect(),
        starts: 0,
        steps: 0,
        simulations: 0,
        seconds: 0.0,
        notes: Vec::new(),
    }
}

/// What is known at the best end: parameters, covariance and what is not determined. The parameters that are known vaguely only.
fn describe(
    estimate: &mut Estimate,
    model: &dyn Model,
    motions: &Motions<'_, '_>,
    best: &Local,
) -> Vec<usize> {
    let bounds = motions.bounds();
    let gradient = best.at.gradient();
    let ends_at = |j: usize| {
        let (lower, upper) = bounds[j];
        (best.x[j] <= lower && gradient[j] > 0.0) || (best.x[j] >= upper && gradient[j] < 0.0)
    };
    let moves: Vec<bool> = (0..best.x.len()).map(|j| !ends_at(j)).collect();
    let knowledge = Knowledge::at(&best.at, &moves, &bounds);
    let declared: Vec<&ParameterDeclaration> = motions
        .free()
        .iter()
        .map(|&index| &model.declaration().parameters[index])
        .collect();
    let undetermined = knowledge.undetermined.iter();
    estimate.undetermined = undetermined
        .map(|direction| in_words(direction, &bounds, &declared))
        .collect();
    for (j, known) in declared.iter().enumerate() {
        let variance = knowledge.covariance[j][j];
        estimate.parameters.push(EstimatedParameter {
            index: motions.free()[j],
            name: known.name,
            unit: known.unit,
            value: best.x[j],
            deviation: (moves[j] && variance.is_finite()).then(|| variance.sqrt()),
            range: bounds[j],
            at_bound: !moves[j],
            gradient: gradient[j],
        });
    }
    estimate.misfit = best.at.misfit();
    estimate.measurements = best.at.residuals.len();
    estimate.distance = best.distance;
    estimate.steps = best.steps;
    estimate.covariance = knowledge.covariance;
    knowledge.vague
}

fn local(end: &Local, starts: usize) -> LocalFit {
    LocalFit {
        misfit: end.at.misfit(),
        values: end.x.clone(),
        optimal: end.optimal,
        starts,
    }
}

/// What can be said of the best end, and why it is not more.
fn status(best: &Local, estimate: &Estimate, stopped: bool) -> (Status, Option<String>) {
    let moving = estimate.experiments.iter();
    let lost = moving
        .map(|known| (known.declared.name, &known.motion.status))
        .find(|(_, status)| !status.is_solved());
    if stopped {
        return (
            Status::Interrupted,
            Some("ended before the search did".to_owned()),
        );
    }
    if !best.optimal {
        let why = format!(
            "the search ends {:.1e} standard deviations away from where the derivatives of the misfit vanish; begin with other \
             values or from more starts (`--starts`)",
            best.distance
        );
        return (Status::NotConverged, Some(why));
    }
    if let Some(why) = &best.at.obstacle {
        let why = format!(
            "at the values that were found the motion has no derivative, so that differences say that they are the best ones: \
             {why}"
        );
        return (Status::Uncertified, Some(why));
    }
    if let Some((name, status)) = lost {
        let why = format!("the motion of `{name}` is not confirmed: {status}");
        return (Status::Uncertified, Some(why));
    }
    if let Some(first) = estimate.undetermined.first() {
        let why = format!("{}; measure something else, or give a value", first.text);
        return (Status::Undetermined, Some(why));
    }
    (Status::Solved, None)
}

/// What else is worth knowing.
fn notes(estimate: &mut Estimate, vague: &[usize]) {
    for &j in vague {
        let known = &estimate.parameters[j];
        estimate.notes.push(format!(
            "the measurements say little of `{}`: its standard deviation is above its range",
            known.name
        ));
    }
    for known in estimate.parameters.iter().filter(|known| known.at_bound) {
        estimate.notes.push(format!(
            "`{}` ends at a bound of its range, which the measurements would move it beyond",
            known.name
        ));
    }
    let spread = estimate.spread();
    if spread > DESCRIBED {
        estimate.notes.push(format!(
            "the residuals are {spread:.1} times as large as the standard deviations that `within` declares: the scene is not what \
             was measured, the deviations are larger, or a better optimum lies elsewhere (`--starts`)"
        ));
    }
}
