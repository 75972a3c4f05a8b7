//! What every simulation does after a step: it tells the observer, and keeps its trajectory within bounds.

use hangtime_solver::clock::Instant;

use crate::model::Model;

use super::recorder::Recorder;
use super::{
    ControlSignal, Diagnosis, InitialValueProblem, Simulation, SimulationStatus, Trajectory,
};
use crate::{Observer, Progress};

/// Times as many points as are asked for that a trajectory has where jumps alone take more.
const WITH_JUMPS: usize = 4;

/// The observer of a run and the length of its trajectory.
pub(super) struct Watch<'o> {
    observer: &'o mut Observer<'o>,
    start: Instant,
    progress: Progress,
    /// Most points of a trajectory.
    most_points: usize,
    /// Most points of this run: more where jumps alone take more.
    points: usize,
    /// Whether the observer sees the time of this run.
    shown: bool,
    /// Of the points that belong to no jump every so many are kept.
    stride: usize,
    /// Points that have been through this before.
    thinned: usize,
    /// Points after these before the next one that is kept.
    skip: usize,
    /// Whether jumps have been left out as well.
    jumps_left_out: bool,
    /// Whether no controls are given.
    uncontrolled: bool,
}

impl<'o> Watch<'o> {
    pub(super) fn new(problem: &InitialValueProblem, observer: &'o mut Observer<'o>) -> Self {
        Self {
            observer,
            start: Instant::now(),
            progress: Progress::new("simulation"),
            most_points: problem.points,
            points: problem.points,
            shown: true,
            stride: 1,
            thinned: 0,
            skip: 0,
            jumps_left_out: false,
            uncontrolled: matches!(problem.controls, ControlSignal::Zero),
        }
    }

    /// The motion is computed once more, with a trajectory of its own. Where it is not `shown`, the observer may stop it
    /// but does not see its time; where it is, the time goes on where it has been further before.
    pub(super) fn restart(&mut self, shown: bool) {
        self.points = self.most_points;
        self.stride = 1;
        self.thinned = 0;
        self.skip = 0;
        self.jumps_left_out = false;
        self.shown = shown;
    }

    /// Reports the end of an accepted step, the `step`-th.
    ///
    /// # Errors
    /// [`SimulationStatus::Interrupted`] if the observer stops the run.
    pub(super) fn reach(
        &mut self,
        time: f64,
        step: usize,
        trajectory: &mut Trajectory,
    ) -> Result<(), SimulationStatus> {
        if trajectory.time.len() > self.points {
            self.thin(trajectory);
        }
        if self.shown {
            self.progress.time = self.progress.time.max(time);
        }
        self.progress.iterations = step;
        if self.goes_on() {
            return Ok(());
        }
        Err(interrupted(time, step))
    }

    /// Reports that a step takes long; `false` if the observer stops the run.
    pub(super) fn goes_on(&mut self) -> bool {
        self.progress.seconds = self.start.elapsed().as_secs_f64();
        (self.observer)(&self.progress)
    }

    fn thin(&mut self, trajectory: &mut Trajectory) {
        let fresh = trajectory.time.len() - self.thinned;
        trajectory.thin(self.thinned, self.skip, self.stride);
        // The last point is kept for now and counted again, so that the distances go on evenly.
        self.skip = match (fresh - 1).checked_sub(self.skip) {
            None => self.skip + 1 - fresh,
            Some(since) => since.next_multiple_of(self.stride) - since,
        };
        if 2 * trajectory.time.len() > self.points {
            trajectory.thin(0, 0, 2);
            self.stride *= 2;
        }
        self.thinned = trajectory.time.len() - 1;
        if 4 * self.thinned > 3 * self.points {
            if self.points < WITH_JUMPS * self.most_points {
                self.points *= 2;
            } else {
                trajectory.thin_jumps();
                self.thinned = trajectory.time.len() - 1;
                self.jumps_left_out = true;
            }
        }
    }

    /// Says in the result what was left out, and what the scene records.
    pub(super) fn finish(&self, model: &dyn Model, result: &mut Simulation) {
        result.trajectory.recorder = Recorder::of(model);
        if result.trajectory.misses_impulses() {
            result.notes.push(
                "this method does not tell impacts from lasting forces: outputs with impulses are no numbers; take one \
                 with events"
                    .into(),
            );
        }
        let listed = result.events.len();
        if result.counts.events > listed {
            result.notes.push(format!(
                "{listed} of {} events are listed, evenly, and impulses are not recorded",
                result.counts.events
            ));
        }
        if self.jumps_left_out {
            result.notes.push(
                "impacts are so many that the trajectory leaves out some: between two of its points there may be others".into(),
            );
        }
        if self.uncontrolled {
            result.notes.extend(excluded_zero(model));
        }
        if self.stride > 1 {
            result.notes.push(format!(
                "the trajectory keeps one of {} points between events, to stay below {} points; raise `points` of \
                 the problem in Rust for more",
                self.stride, self.points
            ));
        }
    }
}

/// What controls are without any given, where their declared bounds exclude that.
fn excluded_zero(model: &dyn Model) -> Option<String> {
    let declaration = model.declaration();
    let first = declaration.coordinates.len();
    let length = first + declaration.controls.len();
    let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; length], vec![f64::INFINITY; length]);
    model.bounds(&mut lower, &mut upper);
    let bounds = lower.iter().zip(&upper).skip(first);
    let excluded = declaration.controls.iter().zip(bounds);
    let excluded = excluded.filter(|(_, (low, high))| !(**low..=**high).contains(&0.0));
    let shown = |bound: f64| {
        if bound.is_finite() {
            bound.to_string()
        } else {
            String::new()
        }
    };
    let excluded: Vec<String> = excluded
        .map(|(control, (&low, &high))| {
            let range = format!("{}..={} {}", shown(low), shown(high), control.unit);
            format!("`{}` in {}", control.name, range.trim_end())
        })
        .collect();
    let verb = if excluded.len() == 1 {
        "excludes"
    } else {
        "exclude"
    };
    (!excluded.is_empty()).then(|| {
        format!(
            "controls are zero in a simulation; {} {verb} that",
            excluded.join(", ")
        )
    })
}

/// The status of a run that its observer stopped in the `step`-th step.
pub(super) fn interrupted(time: f64, step: usize) -> SimulationStatus {
    SimulationStatus::Interrupted(Diagnosis {
        time,
        step,
        contact: None,
        message: "the observer asked to stop".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(points: usize) -> InitialValueProblem {
        InitialValueProblem {
            q: vec![0.0],
            v: vec![0.0],
            horizon: 1.0,
            controls: super::super::ControlSignal::Zero,
            points,
        }
    }

    #[test]
    fn long_trajectory_keeps_its_ends_its_jumps_and_even_distances() {
        let problem = problem(200);
        let mut all = |_: &Progress| true;
        let mut watch = Watch::new(&problem, &mut all);
        let mut trajectory = Trajectory::default();
        let steps = 10_000;
        for k in 0..=steps {
            let time = f64::from(k);
            trajectory.push(time, time, &[time], &[1.0], &[], &[]);
            if k % 2500 == 1250 {
                trajectory.push(time, time, &[time], &[-1.0], &[], &[]);
            }
            assert!(watch.reach(time, 1, &mut trajectory).is_ok());
        }
        let times = &trajectory.time;
        assert!((100..=200).contains(&times.len()), "{}", times.len());
        assert_eq!((times[0], times[times.len() - 1]), (0.0, f64::from(steps)));
        let jumps = times.windows(2).filter(|pair| pair[0] == pair[1]);
        assert_eq!(jumps.count(), 4);
        // One of 64 or 128 is kept until here; points that have not been thinned yet follow at the end.
        let widest = times
            .windows(2)
            .fold(0.0_f64, |w, pair| w.max(pair[1] - pair[0]));
        assert!(widest <= 4.0 * f64::from(steps) / 200.0, "{widest}");
        assert!(
            trajectory
                .q
                .iter()
                .zip(times)
                .all(|(q, time)| q[0] == *time)
        );
        assert_eq!(trajectory.contact_force.len(), times.len());
    }

    #[test]
    fn observer_that_stops_a_run_gives_it_a_named_status() {
        let problem = problem(100);
        let mut until = |progress: &Progress| progress.time < 0.25;
        let mut watch = Watch::new(&problem, &mut until);
        let mut trajectory = Trajectory::default();
        assert!(watch.reach(0.125, 1, &mut trajectory).is_ok());
        let status = watch.reach(0.375, 2, &mut trajectory).unwrap_err();
        assert_eq!(status.name(), "interrupted");
        assert_eq!(status.diagnosis().unwrap().time, 0.375);
    }
}
