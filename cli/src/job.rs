//! A job: a scene and the words behind it, which run until their end or until they are stopped, and leave a result.
//!
//! Every way into the program makes one of these: the commands, calls on texts, hosts such as Python. What a job came to is one [`Run`],
//! from which all that leaves the program is made.

use std::fmt;
use std::ops::Range;

use hangtime::Progress;
use hangtime::derivative::Gradient;
use hangtime::estimation::Estimate;
use hangtime::ocp::{Previous, Solution};
use hangtime::simulation::{EventKind, Simulation};

use crate::Quantity;
use crate::arguments::{
    ControlsName, GridName, LimitArguments, Method, SimulateArguments, SolveArguments,
    SolveFormulation,
};
use crate::drawing::Drawing;
use crate::ending::{Ending, Stop};
use crate::failure::BadInput;
use crate::json::{Columns, part, quantities};
use crate::method::name_of;
use crate::sampling::{Side, State, extreme, largest_joint_force};
use crate::settings::ChosenScene;
use crate::table::counted;
use crate::task::{
    FitTask, OptimumTask, SimulationTask, fit_facts, optimum_facts, simulation_facts,
};
#[cfg(feature = "terminal")]
use crate::{PublishedData, files::ResultFiles, fit, simulate, solve, thumbnail::thumbnail};

/// What is to be computed.
enum Task {
    Simulate(SimulationTask),
    Plan(OptimumTask),
    Fit(FitTask),
}

/// A scene and what is to be done with it.
pub(crate) struct Job {
    task: Task,
    limits: LimitArguments,
    /// Name of the files of its result, without extension.
    stem: String,
}

/// What a job is asked now and then: it goes on while there is no reason to stop.
pub(crate) type Asked<'a> = dyn FnMut(&Progress) -> Option<Stop> + Send + 'a;

impl Job {
    /// A simulation.
    pub(crate) fn simulate(
        chosen: ChosenScene,
        arguments: &SimulateArguments,
    ) -> Result<Self, BadInput> {
        let mut stem = chosen.scene.name.to_owned();
        let method = arguments.method.method.unwrap_or_default();
        if method != Method::default() {
            stem = format!("{stem}-{}", name_of(method));
        }
        Ok(Self {
            task: Task::Simulate(SimulationTask::new(chosen, arguments)?),
            limits: arguments.limits.clone(),
            stem,
        })
    }

    /// A problem of optimal control, or an estimation where the scene compares with measurements.
    pub(crate) fn solve(chosen: ChosenScene, arguments: &SolveArguments) -> Result<Self, BadInput> {
        let mut stem = chosen.scene.name.to_owned();
        let task = if chosen.model.structure().experiments.is_empty() {
            stem += "-optimal";
            let others = [
                (arguments.formulation != SolveFormulation::default())
                    .then(|| name_of(arguments.formulation)),
                (arguments.controls != ControlsName::default())
                    .then(|| name_of(arguments.controls)),
                (arguments.grid != GridName::default()).then(|| name_of(arguments.grid)),
            ];
            for other in others.into_iter().flatten() {
                stem = format!("{stem}-{other}");
            }
            Task::Plan(OptimumTask::new(chosen, arguments)?)
        } else {
            stem += "-fitted";
            Task::Fit(FitTask::new(chosen, arguments)?)
        };
        Ok(Self {
            task,
            limits: arguments.limits.clone(),
            stem,
        })
    }

    /// Starts from the motion of an earlier plan for the same scene; nothing of what has no plan.
    pub(crate) fn start_from(&mut self, previous: &Previous) {
        if let Task::Plan(task) = &mut self.task {
            task.start_from(previous);
        }
    }

    /// The scene with its settings.
    pub(crate) fn chosen(&self) -> &ChosenScene {
        match &self.task {
            Task::Simulate(task) => &task.chosen,
            Task::Plan(task) => &task.chosen,
            Task::Fit(task) => &task.chosen,
        }
    }

    /// What it may take.
    pub(crate) fn limits(&self) -> &LimitArguments {
        &self.limits
    }

    /// The length of a simulation \[s\]; nothing of a search, whose end is not known.
    pub(crate) fn horizon(&self) -> Option<f64> {
        match &self.task {
            Task::Simulate(task) => Some(task.problem.horizon),
            Task::Plan(_) | Task::Fit(_) => None,
        }
    }

    /// What tells how far it is, in words of its problem, and which share of it is done, where that is known; it hears of all progress and
    /// is asked for words now and then.
    pub(crate) fn teller(
        &self,
    ) -> impl FnMut(&Progress, bool) -> Option<(Option<f64>, String)> + Send + use<> {
        let horizon = self.horizon();
        let plans = matches!(self.task, Task::Plan(_));
        let contacts = !self.chosen().model.declaration().contacts.is_empty();
        let mut best = None;
        move |now, asked| {
            best = now.best.or(best);
            let share = horizon.map(|horizon| now.time / horizon);
            asked.then(|| {
                let doing = match horizon {
                    Some(end) => format!("{:.3} s of {end:.3} s of the motion", now.time),
                    None if plans => told(now, best, contacts),
                    None => {
                        let seconds = now.seconds;
                        format!("comparing motions with what was measured, {seconds:.0} s")
                    }
                };
                (share, doing)
            })
        }
    }

    /// Runs it.
    pub(crate) fn run(self, asked: &mut Asked<'_>) -> Result<Run, BadInput> {
        let mut stop = None;
        let mut goes_on = |now: &Progress| {
            stop = stop.or_else(|| asked(now));
            stop.is_none()
        };
        let (work, ending) = match self.task {
            Task::Simulate(task) => {
                let simulation = task.run(&mut goes_on)?;
                let gradient = task.gradient(&simulation)?.map(Box::new);
                let ending = Ending::of_simulation(&simulation, stop, &self.limits);
                let simulation = Box::new(simulation);
                (Work::Simulated(task, simulation, gradient), ending)
            }
            Task::Plan(mut task) => {
                let solution = task.run(&mut goes_on)?;
                let ending = Ending::of_bounded(&solution, stop, &self.limits);
                (Work::Planned(task, Box::new(solution)), ending)
            }
            Task::Fit(mut task) => {
                let estimate = task.run(&mut goes_on)?;
                let ending = Ending::of_estimate(&estimate, stop, &self.limits);
                (Work::Fitted(task, Box::new(estimate)), ending)
            }
        };
        Ok(Run {
            work,
            ending,
            stem: self.stem,
        })
    }
}

/// What a solve does, in words of its problem: what it looks for, how many motions it has computed, and the best of them.
fn told(now: &Progress, best: Option<f64>, contacts: bool) -> String {
    let doing = match (now.step, contacts) {
        ("start", _) => "getting ready",
        ("random motions", _) => "trying random motions",
        ("reachable states", _) => "looking how far the controls reach",
        ("collocation", true) => "computing when the contacts of one order happen",
        ("collocation", false) => "computing the motion",
        (_, true) => "looking for which contacts happen",
        (_, false) => "looking for a motion",
    };
    let best = match (now.motion, best) {
        (Some(motion), _) => format!("best so far {motion}"),
        (None, Some(best)) => format!("best objective so far {best:.6}"),
        (None, None) => "no motion to the goals yet".to_owned(),
    };
    format!(
        "{doing}: {best}, {} tried, {:.0} s",
        counted(now.programs, "motion"),
        now.seconds
    )
}

/// What a task came to.
pub(crate) enum Work {
    /// A motion, and its derivatives where they were asked for.
    Simulated(SimulationTask, Box<Simulation>, Option<Box<Gradient>>),
    /// A plan.
    Planned(OptimumTask, Box<Solution>),
    /// An estimate.
    Fitted(FitTask, Box<Estimate>),
}

/// A run that has ended.
pub struct Run {
    pub(crate) work: Work,
    pub(crate) ending: Ending,
    /// Name of its files, without extension.
    pub(crate) stem: String,
}

impl fmt::Debug for Run {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Run")
            .field("ending", &self.ending)
            .finish_non_exhaustive()
    }
}

impl Run {
    /// Name of the status.
    #[must_use]
    pub fn status(&self) -> &'static str {
        self.ending.status
    }

    /// Why it did not end with a solution, in one line.
    #[must_use]
    pub fn diagnosis(&self) -> Option<&str> {
        self.ending.diagnosis.as_deref()
    }

    /// The line about it on the standard error stream, if it did not end with a solution.
    pub(crate) fn line(&self) -> Option<String> {
        let name = self.chosen().scene.name;
        match &self.work {
            Work::Simulated(_, simulation, _) => self.ending.line_of(name, simulation),
            Work::Planned(..) | Work::Fitted(..) => self.ending.line(name),
        }
    }

    /// Whether parameters were estimated.
    #[must_use]
    pub fn is_estimate(&self) -> bool {
        matches!(self.work, Work::Fitted(..))
    }

    /// Whether there is a motion; a simulation always has one.
    #[must_use]
    pub fn has_motion(&self) -> bool {
        self.motion().is_some()
    }

    /// Whether the run ended with a solution.
    #[must_use]
    pub fn is_solved(&self) -> bool {
        match &self.work {
            Work::Simulated(_, simulation, _) => simulation.status.is_solved(),
            Work::Planned(_, solution) => solution.status.is_solved(),
            Work::Fitted(_, estimate) => estimate.status.is_solved(),
        }
    }

    /// Whether another solve can start from it: whether it is a solve that found a motion.
    #[must_use]
    pub fn is_start(&self) -> bool {
        self.previous().is_some()
    }

    /// The plan that another solve may start from.
    pub(crate) fn previous(&self) -> Option<&Previous> {
        match &self.work {
            Work::Simulated(..) | Work::Fitted(..) => None,
            Work::Planned(_, solution) => solution.previous.as_ref(),
        }
    }

    /// A part of the trajectory by its name in the document, such as `q`, at the instants that the document has: numbers row after
    /// row. `None` where there is no such part, or no motion.
    #[must_use]
    pub fn part(&self, name: &str) -> Option<Columns> {
        let model = self.chosen().model.as_ref();
        part(model, &self.motion()?.trajectory, self.rows(), name)
    }

    /// Name and unit of every column of a part; a number has an empty unit.
    #[must_use]
    pub fn quantities(&self, part: &str) -> Vec<(String, String)> {
        quantities(self.chosen().model.as_ref(), part)
    }

    /// The scene with its settings, and with what was found.
    pub(crate) fn chosen(&self) -> &ChosenScene {
        match &self.work {
            Work::Simulated(task, ..) => &task.chosen,
            Work::Planned(task, _) => &task.chosen,
            Work::Fitted(task, _) => &task.chosen,
        }
    }

    /// Most rows of a trajectory in documents.
    pub(crate) fn rows(&self) -> usize {
        match &self.work {
            Work::Simulated(task, ..) => task.rows,
            Work::Planned(task, _) => task.rows,
            Work::Fitted(task, _) => task.rows,
        }
    }

    /// The motion; of an estimate that of its first experiment.
    pub(crate) fn motion(&self) -> Option<&Simulation> {
        match &self.work {
            Work::Simulated(_, simulation, _) => Some(simulation),
            Work::Planned(_, solution) => solution.motion.as_ref(),
            Work::Fitted(_, estimate) => estimate.experiments.first().map(|known| &known.motion),
        }
    }

    /// How its scene is drawn, if it is.
    pub(crate) fn drawing(&self) -> Option<Drawing<'_>> {
        let chosen = self.chosen();
        Drawing::of(chosen.model.as_ref(), chosen.scene.name)
    }

    /// The value of a quantity at the end of the motion.
    pub(crate) fn last(&self, quantity: Quantity) -> Option<f64> {
        let trajectory = &self.motion()?.trajectory;
        let last = trajectory.time.len().checked_sub(1)?;
        State::of(self.chosen().model.as_ref(), trajectory, last).value(quantity)
    }

    /// Its largest or its smallest value along the motion.
    pub(crate) fn extreme(&self, quantity: Quantity, side: Side) -> Option<f64> {
        let model = self.chosen().model.as_ref();
        extreme(model, &self.motion()?.trajectory, quantity, side)
    }

    /// When an event of a kind happens at a contact for the `count`-th time, from 1 \[s\].
    pub(crate) fn event_time(&self, kind: EventKind, contact: usize, count: usize) -> Option<f64> {
        let events = self.motion()?.events.iter();
        let mut events = events.filter(|event| event.kind == kind && event.contact == contact);
        events.nth(count.checked_sub(1)?).map(|event| event.time)
    }

    /// The largest force of a joint along the motion, by its equations among those of all joints.
    pub(crate) fn joint_force(&self, rows: &Range<usize>) -> Option<f64> {
        let model = self.chosen().model.as_ref();
        largest_joint_force(model, &self.motion()?.trajectory, rows)
    }

    /// What the command prints with `--json`, in one line.
    #[must_use]
    pub fn json(&self) -> String {
        match &self.work {
            Work::Simulated(task, simulation, gradient) => {
                task.json(simulation, gradient.as_deref(), &self.ending)
            }
            Work::Planned(task, solution) => task.json(solution, &self.ending),
            Work::Fitted(task, estimate) => task.json(estimate, &self.ending),
        }
    }

    /// What a page tells about it, as (name, value): facts and then notes of the motion.
    pub(crate) fn facts(&self) -> Vec<[String; 2]> {
        let mut facts = match &self.work {
            Work::Simulated(task, simulation, _) => {
                simulation_facts(&task.method, simulation, &self.ending)
            }
            Work::Planned(task, solution) => optimum_facts(&task.method, solution, &self.ending),
            Work::Fitted(_, estimate) => fit_facts(estimate, &self.ending),
        };
        let notes = self.motion().map_or(&[][..], |motion| &motion.notes).iter();
        facts.extend(notes.map(|note| ["note".to_owned(), note.clone()]));
        facts
    }
}

/// What leaves the program by files and for people.
#[cfg(feature = "terminal")]
impl Run {
    /// The result for people.
    pub(crate) fn tables(&self) -> String {
        match &self.work {
            Work::Simulated(task, simulation, gradient) => {
                simulate::tables(task, simulation, gradient.as_deref(), &self.ending)
            }
            Work::Planned(task, solution) => {
                solve::tables(&task.chosen, &task.method, solution, &self.ending)
            }
            Work::Fitted(task, estimate) => fit::tables(&task.chosen, estimate, &self.ending),
        }
    }

    /// The files that the command writes with `--out`, as (name, content): data, figures, and a page that plays the
    /// motion. Without a motion only the JSON document.
    #[must_use]
    pub fn files(&self) -> Vec<(String, String)> {
        self.files_with(&self.json())
    }

    /// The files of the run by name, with its JSON document, which is known.
    pub(crate) fn files_with(&self, json: &str) -> Vec<(String, String)> {
        let (chosen, stem) = (self.chosen(), &self.stem);
        let Some(simulation) = self.motion() else {
            return vec![(format!("{stem}.json"), json.to_owned())];
        };
        let (mut charts, mut further) = (Vec::new(), Vec::new());
        let title = match &self.work {
            Work::Simulated(task, ..) => task.method.settings.name.to_owned(),
            Work::Planned(_, solution) => {
                charts = solve::improvements(stem, chosen, solution);
                "optimal".to_owned()
            }
            Work::Fitted(_, estimate) => {
                further = fit::further(stem, estimate);
                fit::title(estimate)
            }
        };
        ResultFiles {
            stem: stem.clone(),
            title: format!("{}, {title}", chosen.scene.name),
            chosen,
            simulation,
            json,
            published: &PublishedData::default(),
            rows: self.rows(),
            index: None,
            facts: self.facts(),
            charts,
            further,
        }
        .contents()
    }

    /// A small picture of the motion as SVG, for lists of scenes; `None` where nothing moved.
    #[must_use]
    pub fn thumbnail(&self) -> Option<String> {
        let model = self.chosen().model.as_ref();
        thumbnail(self.drawing().as_ref(), model, self.motion()?)
    }
}
