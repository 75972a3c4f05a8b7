//! The residuals of all experiments as a function of what is looked for.

use super::least_squares::{Evaluation, Residuals};
use super::measurements::Measurements;
use crate::derivative::{Observed, observe};
use crate::model::{Experiment, Measured, Model};
use crate::scene::TextScene;
use crate::simulation::{
    EventDriven, Fesd, InitialValueProblem, Simulation, Simulator, simulate_once,
};
use crate::{InputError, Observer, Progress};
use hangtime_solver::clock::Instant;

/// Tolerance of the motions: what residuals are compared with is far above it.
const TOLERANCE: f64 = 1e-12;
/// Share of a range that differences are taken over where there are no derivatives: between rounding of a motion and its
/// curvature.
const DIFFERENCE: f64 = 1e-6;

/// One experiment with the scene as it is there.
struct One<'a> {
    declared: &'static Experiment,
    model: TextScene,
    measured: Vec<Measured>,
    data: &'a Measurements,
}

/// All experiments of a scene.
pub(super) struct Motions<'a, 'o> {
    experiments: Vec<One<'a>>,
    /// The parameters (indices) that are looked for, their names and ranges.
    free: Vec<usize>,
    names: Vec<String>,
    bounds: Vec<(f64, f64)>,
    /// Share of the times of each experiment that counts, from the first on.
    share: f64,
    observer: &'a mut Observer<'o>,
    stopped: bool,
    /// Motions that were simulated.
    pub(super) simulations: usize,
    best: f64,
    clock: Instant,
    /// Why the last motion could not be compared.
    pub(super) failure: Option<String>,
}

/// What is known of one experiment at some values.
pub(super) struct Compared {
    pub(super) simulation: Simulation,
    /// By time and quantity, in their units.
    pub(super) computed: Vec<Vec<f64>>,
}

impl<'a, 'o> Motions<'a, 'o> {
    /// Those of the experiments of `model` with their measurements, by its free parameters without those that are `given`.
    ///
    /// # Errors
    /// [`InputError`] for measurements that do not fit, and scenes that are not differentiated by their parameters.
    pub(super) fn new(
        model: &'a dyn Model,
        data: &'a [Measurements],
        given: &[usize],
        observer: &'a mut Observer<'o>,
    ) -> Result<Self, InputError> {
        let declared = model.structure().experiments;
        if data.len() != declared.len() {
            return Err(crate::refusal::wrong_length(
                "the list of measurements",
                data.len(),
                declared.len(),
            ));
        }
        let mut experiments = Vec::with_capacity(data.len());
        for (index, (declared, data)) in declared.iter().zip(data).enumerate() {
            data.check(declared, model.declaration().controls)?;
            let model = model
                .in_experiment(index)
                .map_err(InputError::unsupported)?;
            experiments.push(One {
                declared,
                model,
                measured: declared
                    .quantities
                    .iter()
                    .map(|known| known.measured)
                    .collect(),
                data,
            });
        }
        let all = model.free_parameters();
        let (mut lower, mut upper) = (vec![0.0; all.len()], vec![0.0; all.len()]);
        model.free_parameter_bounds(&mut lower, &mut upper);
        let ranges = all.iter().zip(lower.into_iter().zip(upper));
        let (free, bounds): (Vec<usize>, Vec<(f64, f64)>) = ranges
            .filter(|(index, _)| !given.contains(index))
            .map(|(&index, range)| (index, range))
            .unzip();
        let parameters = model.declaration().parameters;
        Ok(Self {
            experiments,
            names: free
                .iter()
                .map(|&k| parameters[k].name.to_owned())
                .collect(),
            free,
            bounds,
            share: 1.0,
            observer,
            stopped: false,
            simulations: 0,
            best: f64::INFINITY,
            clock: Instant::now(),
            failure: None,
        })
    }

    /// The parameters (indices) that are looked for.
    pub(super) fn free(&self) -> &[usize] {
        &self.free
    }

    /// Their ranges.
    pub(super) fn bounds(&self) -> Vec<(f64, f64)> {
        self.bounds.clone()
    }

    /// Looks at that share of the times of each experiment from now on.
    pub(super) fn look_at(&mut self, share: f64) {
        self.share = share;
    }

    /// Sees whether the scene can be compared at all, at these values.
    ///
    /// # Errors
    /// [`InputError`] as of a simulation and of its derivatives.
    pub(super) fn check(&mut self, x: &[f64]) -> Result<(), InputError> {
        for index in 0..self.experiments.len() {
            self.set(index, x);
            let one = &self.experiments[index];
            let (problem, run) = simulated(one, one.data.end(), &mut |_| true)?;
            observe(
                &one.model,
                (&problem, &run),
                &self.names,
                (&one.measured, &one.data.times),
            )?;
        }
        Ok(())
    }

    /// The motion of an experiment at these values, confirmed by a second run, with what was measured of it; and whether there is
    /// one.
    pub(super) fn confirmed(&mut self, index: usize, x: &[f64]) -> Option<Compared> {
        self.set(index, x);
        let one = &self.experiments[index];
        let problem = problem(one, one.data.end()).ok()?;
        let event = EventDriven {
            tolerance: TOLERANCE,
            ..EventDriven::default()
        };
        let simulation = match event.simulate(&one.model, &problem, &mut |_| true).ok()? {
            run if run.status.is_solved() => run,
            run => match Fesd::default().simulate(&one.model, &problem, &mut |_| true) {
                Ok(other) if other.status.is_solved() => other,
                _ => run,
            },
        };
        let seen = observe(
            &one.model,
            (&problem, &simulation),
            &self.names,
            (&one.measured, &one.data.times),
        );
        Some(Compared {
            computed: seen.map(|seen| seen.values).unwrap_or_default(),
            simulation,
        })
    }

    fn set(&mut self, index: usize, x: &[f64]) {
        let model = &mut self.experiments[index].model;
        for (&parameter, &value) in self.free.iter().zip(x) {
            model.set_parameter(parameter, value);
        }
    }

    /// What is seen of one experiment at these values; `None` where it has no motion to the last time that counts.
    fn seen(&mut self, index: usize, x: &[f64]) -> Option<Observed> {
        self.set(index, x);
        self.simulations += 1;
        let one = &self.experiments[index];
        let count = counted(one, self.share);
        let times = &one.data.times[..count];
        let end = times.last().copied().filter(|end| *end > 0.0)?;
        let (best, start) = (self.best, &self.clock);
        let mut stopped = self.stopped;
        let simulations = self.simulations;
        let observer = &mut self.observer;
        let run = simulated(one, end, &mut |now| {
            let now = Progress {
                step: "fit",
                iterations: simulations,
                best: best.is_finite().then_some(best),
                seconds: start.elapsed().as_secs_f64(),
                ..*now
            };
            stopped |= !observer(&now);
            !stopped
        });
        self.stopped = stopped;
        let (problem, run) = match run {
            Ok(run) => run,
            Err(error) => {
                self.failure = Some(error.to_string());
                return None;
            }
        };
        if !run.status.is_solved() {
            self.failure = Some(format!("`{}`: {}", one.declared.name, run.status));
            return None;
        }
        let observed = observe(
            &one.model,
            (&problem, &run),
            &self.names,
            (&one.measured, times),
        );
        observed.ok().filter(|seen| seen.values.len() == count)
    }

    /// Derivatives of everything that is seen of one experiment by differences, by time and quantity.
    fn differences(&mut self, index: usize, x: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let mut by: Vec<Vec<Vec<f64>>> = Vec::new();
        for j in 0..x.len() {
            let (lower, upper) = self.bounds[j];
            let way = DIFFERENCE * (upper - lower);
            let moved = |to: f64| {
                let mut moved = x.to_vec();
                moved[j] = to.clamp(lower, upper);
                moved
            };
            let ends = [moved(x[j] - way), moved(x[j] + way)];
            let width = ends[1][j] - ends[0][j];
            let [below, above] = [self.seen(index, &ends[0])?, self.seen(index, &ends[1])?];
            by.resize_with(below.values.len(), Vec::new);
            for ((by, below), above) in by.iter_mut().zip(&below.values).zip(&above.values) {
                by.resize_with(below.len(), Vec::new);
                for ((by, below), above) in by.iter_mut().zip(below).zip(above) {
                    by.push((above - below) / width);
                }
            }
        }
        Some(by)
    }

    fn evaluation(&mut self, x: &[f64]) -> Option<Evaluation> {
        let mut evaluation = Evaluation {
            residuals: Vec::new(),
            columns: vec![Vec::new(); x.len()],
            linear_from: Vec::new(),
            obstacle: None,
        };
        for index in 0..self.experiments.len() {
            let seen = self.seen(index, x)?;
            let by = match seen.obstacle {
                None => seen.by,
                Some(why) => {
                    let name = self.experiments[index].declared.name;
                    evaluation.obstacle = Some(format!("`{name}`: {why}"));
                    self.differences(index, x)?
                }
            };
            let One { declared, data, .. } = &self.experiments[index];
            let rows = seen.values.iter().zip(&by).zip(&data.values);
            for ((computed, by), measured) in rows {
                for (k, quantity) in declared.quantities.iter().enumerate() {
                    if measured[k].is_nan() {
                        continue;
                    }
                    let residual = (computed[k] - measured[k]) / quantity.within;
                    if !residual.is_finite() || by[k].iter().any(|by| !by.is_finite()) {
                        return None;
                    }
                    evaluation.residuals.push(residual);
                    evaluation
                        .linear_from
                        .push(declared.huber.unwrap_or(f64::INFINITY));
                    for (column, by) in evaluation.columns.iter_mut().zip(&by[k]) {
                        column.push(by / quantity.within);
                    }
                }
            }
        }
        Some(evaluation)
    }
}

impl Residuals for Motions<'_, '_> {
    fn evaluate(&mut self, x: &[f64]) -> Option<Evaluation> {
        let evaluation = self.evaluation(x)?;
        if self.share == 1.0 {
            self.best = self.best.min(evaluation.misfit());
        }
        Some(evaluation)
    }

    fn is_stopped(&self) -> bool {
        self.stopped
    }
}

/// How many times of an experiment count: at least those up to the first one behind the start.
fn counted(one: &One<'_>, share: f64) -> usize {
    let times = &one.data.times;
    let first = times.partition_point(|&time| time <= 0.0) + 1;
    let count = (share * times.len() as f64).ceil() as usize;
    count.max(first).min(times.len())
}

/// The motion of an experiment up to a time, under the controls that it had.
fn problem(one: &One<'_>, end: f64) -> Result<InitialValueProblem, InputError> {
    let mut problem = InitialValueProblem::of(&one.model, Some(end))?;
    problem.controls.clone_from(&one.data.controls);
    problem.points = usize::MAX;
    Ok(problem)
}

/// One experiment up to a time, by the method that locates events most accurately, and by finite elements where that fails.
fn simulated(
    one: &One<'_>,
    end: f64,
    observer: &mut Observer<'_>,
) -> Result<(InitialValueProblem, Simulation), InputError> {
    let problem = problem(one, end)?;
    let event = EventDriven {
        tolerance: TOLERANCE,
        ..EventDriven::default()
    };
    let run = simulate_once(&event, &one.model, &problem)?;
    let goes_on = observer(&Progress::new("fit"));
    if run.status.is_solved() || !goes_on {
        return Ok((problem, run));
    }
    let other = Fesd::default().simulate(&one.model, &problem, observer)?;
    Ok((problem, if other.status.is_solved() { other } else { run }))
}
