//! The contact sequence from the complementarity problem of finite elements on the time-freezing system.

use cpu_time::ThreadTime;

use super::control_grid::ControlGrid;
use super::global::Relaxed;
use super::mode::{Mode, is_rough, sliding_velocity};
use super::path::{Path, drive, with_forces};
use super::search::{Search, refused};
use super::sequence::Sequence;
use super::settings::Guess;
use super::solution::{Size, TimeFreezingReport};
use super::time_freezing::{TimeFreezing, TimeFreezingMotion, TimeFreezingSettings};
use crate::mpcc::{self, Mpcc as _};
use crate::nlp;
use crate::simulation::InputError;

/// Mean step function of an element above which its contact is open: in flight it is 1, in contact
/// `a_bar / (a_bar + r)` for a normal acceleration `r`.
const OPEN: f64 = 0.99;
/// Most iterations of one rule. The programs are larger than those of the other phases.
const ITERATIONS: usize = 1500;

impl Search<'_, '_> {
    /// Solves the relaxed complementarity problem and reads path and contact sequence from it.
    pub(super) fn time_freezing(
        &mut self,
        settings: &TimeFreezingSettings,
    ) -> Result<Vec<Relaxed>, InputError> {
        let clock = ThreadTime::try_now();
        let (model, problem) = (self.setting.model, self.setting.problem);
        let settings = TimeFreezingSettings {
            simulated_guess: settings.simulated_guess || self.settings.guess == Guess::Ride,
            ..settings.clone()
        };
        let mut program = TimeFreezing::new(model, problem, &settings)?;
        let mut relaxation = mpcc::Settings {
            crossover: false,
            final_relaxation: settings.complementarity,
            ..mpcc::Settings::default()
        };
        relaxation.interior_point.tolerance = settings.complementarity;
        relaxation.interior_point.maximum_iterations =
            self.settings.maximum_iterations.max(ITERATIONS);
        self.watch
            .begin("time-freezing program", &self.counts, None);
        let mut observer = |info: &nlp::IterationInfo| self.watch.iteration(info, 1.0);
        let solution = mpcc::solve_observed(&mut program, &relaxation, &mut observer)
            .map_err(|error| refused(&error))?;
        self.counts.programs += 1;
        self.counts.global_iterations += solution.iterations;
        self.counts.factorizations += solution.factorizations;
        let products = program.complementarities().iter();
        let products = products.map(|&(i, j)| (solution.x[i] * solution.x[j]).max(0.0));
        let motion = program.motion(&solution.x);
        self.time_freezing = Some(TimeFreezingReport {
            status: solution.status,
            objective: solution.objective,
            horizon: motion.horizon,
            primal: solution.residuals.primal,
            complementarity: products.fold(0.0, f64::max),
            iterations: solution.iterations,
            size: Size::of(&program, program.complementarities().len()),
            seconds: clock
                .and_then(|clock| clock.try_elapsed())
                .map_or(f64::NAN, |elapsed| elapsed.as_secs_f64()),
        });
        let near = match solution.status {
            mpcc::Status::Failed(status) => {
                self.note_failure(status, solution.violations);
                status == nlp::Status::Acceptable
            }
            mpcc::Status::Infeasible => {
                self.note_failure(nlp::Status::Infeasible, solution.violations);
                false
            }
            _ => true,
        };
        if !near {
            return Ok(Vec::new());
        }
        let path = self.path_of(&motion);
        Ok(vec![Relaxed {
            objective: solution.objective,
            sequence: self.sequence_of(&motion, &settings, &path),
            path,
        }])
    }

    /// What the contacts do in each element; a jump belongs to the contact after it. How they slide follows from the
    /// velocity at the end: in a pair whose product is relaxed, both may be as large as its root.
    fn sequence_of(
        &self,
        motion: &TimeFreezingMotion,
        settings: &TimeFreezingSettings,
        path: &Path,
    ) -> Sequence {
        let zero = settings.complementarity.sqrt();
        let model = self.setting.model;
        let interval = motion.horizon / self.setting.problem.intervals as f64;
        let states = motion.q.iter().zip(&motion.v).zip(&motion.time);
        let modes: Vec<Vec<Mode>> = motion
            .step_functions
            .iter()
            .zip(states)
            .map(|(alpha, ((q, v), &time))| {
                let state = [&q[..], v].concat();
                let mode = |(contact, &alpha): (usize, &f64)| {
                    if alpha >= OPEN {
                        return Mode::Open;
                    }
                    let rough = is_rough(model, contact);
                    let slides = rough.then(|| sliding_velocity(model, contact, &state, time));
                    Mode::closed(rough, slides.unwrap_or(0.0), zero)
                };
                alpha.iter().enumerate().map(mode).collect()
            })
            .collect();
        let ends: Vec<f64> = motion.time.iter().map(|time| time / interval).collect();
        Sequence::of_elements(
            self.modes_at_start(path),
            &modes,
            (settings.elements, &ends),
            0.0,
        )
    }

    fn path_of(&self, motion: &TimeFreezingMotion) -> Path {
        let (model, problem) = (self.setting.model, self.setting.problem);
        let per_interval = motion.time.len() / problem.intervals;
        let mut states = vec![problem.start()];
        let ends = motion.q.iter().zip(&motion.v);
        states.extend(ends.map(|(q, v)| [&q[..], &v[..]].concat()));
        let states = states.into_iter().enumerate().map(|(i, state)| {
            let interval = i.saturating_sub(1) / per_interval;
            let time = i.checked_sub(1).map_or(0.0, |end| motion.time[end]);
            with_forces(
                model,
                state,
                &drive(model, &motion.controls[interval], time),
            )
        });
        Path {
            states: states.collect(),
            time: std::iter::once(&0.0).chain(&motion.time).copied().collect(),
            horizon: motion.horizon,
            controls: ControlGrid::constant(motion.controls.clone()),
        }
    }
}
