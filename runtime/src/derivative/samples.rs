//! What is measured of a motion at given times, between its instants, with its derivatives.

use super::mode::Acceleration;
use super::outputs::{Instant, outputs};
use super::step::{At, Step, Steps, stage_input};
use super::tangent::{Matrix, Tangent};
use crate::model::{ControlPiece, Measured};
use crate::simulation::{ContactMode, InitialValueProblem, Simulation};

/// Share of a time by which it may lie behind the last instant: rounding.
const ROUNDING: f64 = 1e-12;

/// Values at increasing times, as far as they are known. At an event they are those right before it.
pub(super) struct Samples<'s> {
    quantities: &'s [Measured],
    times: &'s [f64],
    /// By time and then by quantity.
    pub(super) values: Vec<Vec<f64>>,
    /// Derivatives of each: as many as there are values unless these go on where derivatives end.
    pub(super) by: Vec<Vec<Vec<f64>>>,
}

impl<'s> Samples<'s> {
    pub(super) fn new(quantities: &'s [Measured], times: &'s [f64]) -> Self {
        Self {
            quantities,
            times,
            values: Vec::with_capacity(times.len()),
            by: Vec::with_capacity(times.len()),
        }
    }

    /// Whether outputs are among what is measured, which need forces.
    fn reads_outputs(&self) -> bool {
        let mut quantities = self.quantities.iter();
        quantities.any(|measured| matches!(measured, Measured::Output(_)))
    }

    /// The next time, if it is at most `limit`.
    fn next(&self, limit: f64) -> Option<f64> {
        let time = *self.times.get(self.values.len())?;
        (time <= limit + ROUNDING * limit.abs()).then_some(time)
    }

    /// What is measured at the start, where the `acceleration` is evaluated.
    pub(super) fn begin(
        &mut self,
        acceleration: &Acceleration<'_>,
        run: &Simulation,
        tangent: &Tangent,
    ) {
        let trajectory = &run.trajectory;
        let at = (&trajectory.q[0][..], &trajectory.v[0][..]);
        let instant = Instant::recorded(acceleration.model, trajectory, 0);
        while self.next(trajectory.time[0]).is_some() {
            let outputs_by = self
                .reads_outputs()
                .then(|| outputs(acceleration, &instant, tangent));
            self.put(at, &instant.values(acceleration));
            self.put_derivatives(tangent, outputs_by.as_ref());
        }
    }

    /// What is measured within a step that was solved, from the derivatives `before` it, if there are still all of them.
    pub(super) fn within(
        &mut self,
        acceleration: &mut Acceleration<'_>,
        (steps, step): (&Steps, Step<'_>),
        (before, whole): (&Tangent, bool),
        (run, k): (&Simulation, usize),
    ) {
        let length = step.to.time - step.from.time;
        while let Some(time) = self.next(step.to.time) {
            let theta = ((time - step.from.time) / length).clamp(0.0, 1.0);
            let tangent = steps.derivatives_within((acceleration.n, length), before, theta);
            let (q, v) = steps.within(step, theta);
            let (mut recorded, mut recorded_by) = (Vec::new(), None);
            if self.reads_outputs() {
                let x = stage_input(acceleration, (&q, &v), time, step.controls);
                acceleration.evaluate(&x);
                let instant = at_time(acceleration, (&q, &v), (step, time), (run, k));
                recorded = instant.values(acceleration);
                recorded_by = Some(outputs(acceleration, &instant, &tangent));
            }
            self.put((&q, &v), &recorded);
            if whole {
                self.put_derivatives(&tangent, recorded_by.as_ref());
            }
        }
    }

    fn put(&mut self, (q, v): (&[f64], &[f64]), recorded: &[f64]) {
        let values = self.quantities.iter().map(|measured| match *measured {
            Measured::Coordinate(k) => q[k],
            Measured::Velocity(k) => v[k],
            Measured::Output(k) => recorded.get(k).copied().unwrap_or(f64::NAN),
        });
        self.values.push(values.collect());
    }

    fn put_derivatives(&mut self, tangent: &Tangent, recorded: Option<&Matrix>) {
        let (n, all) = (tangent.layout.n, &tangent.all);
        let unknown = || vec![f64::NAN; all.columns];
        let by = self.quantities.iter().map(|measured| match *measured {
            Measured::Coordinate(k) => all.row(k).to_vec(),
            Measured::Velocity(k) => all.row(n + k).to_vec(),
            Measured::Output(k) => recorded.map_or_else(unknown, |by| by.row(k).to_vec()),
        });
        self.by.push(by.collect());
    }

    /// Goes on behind the instant from which on there are no derivatives: with the values of the known motion, solved once more in
    /// each step; on the cubic between its instants where that leads elsewhere.
    pub(super) fn go_on(
        &mut self,
        acceleration: &mut Acceleration<'_>,
        steps: &mut Steps,
        (problem, run): (&InitialValueProblem, &Simulation),
    ) {
        let trajectory = &run.trajectory;
        let mut modes: Vec<ContactMode> = run.initial_modes.clone();
        let mut passed = 0;
        for k in 0..trajectory.time.len().saturating_sub(1) {
            let [from, to] = [trajectory.time[k], trajectory.time[k + 1]];
            while let Some(event) = run.events.get(passed).filter(|event| event.time <= from) {
                modes.clone_from(&event.modes);
                passed += 1;
            }
            if to <= from || self.next(to).is_none() {
                continue;
            }
            let mut controls = ControlPiece::default();
            let count = acceleration.model.declaration().controls.len();
            problem.controls.take_piece(from, count, &mut controls);
            let at = |k: usize| At {
                time: trajectory.time[k],
                q: &trajectory.q[k],
                v: &trajectory.v[k],
            };
            let step = Step {
                from: at(k),
                to: at(k + 1),
                controls: &controls,
            };
            let x = stage_input(acceleration, (step.from.q, step.from.v), from, &controls);
            acceleration.set_mode(&modes);
            acceleration.keep_independent(&x);
            let solved = steps.values(acceleration, step).is_some();
            while let Some(time) = self.next(to) {
                let theta = ((time - from) / (to - from)).clamp(0.0, 1.0);
                let (q, v) = match solved {
                    true => steps.within(step, theta),
                    false => cubic(step, theta),
                };
                let mut recorded = Vec::new();
                if self.reads_outputs() {
                    let x = stage_input(acceleration, (&q, &v), time, &controls);
                    acceleration.evaluate(&x);
                    recorded = at_time(acceleration, (&q, &v), (step, time), (run, k))
                        .values(acceleration);
                }
                self.put((&q, &v), &recorded);
            }
        }
    }
}

/// The instant within a step behind instant `k`, where the `acceleration` is evaluated.
fn at_time(
    acceleration: &Acceleration<'_>,
    (q, v): (&[f64], &[f64]),
    (step, time): (Step<'_>, f64),
    (run, k): (&Simulation, usize),
) -> Instant {
    let mut u = vec![0.0; acceleration.model.declaration().controls.len()];
    step.controls.write(time, &mut u);
    let x = [q, v, &u, &[time][..]].concat();
    Instant::evaluated(acceleration, x, &run.trajectory.impulses(k))
}

/// The state at the share `theta` of a step on the cubic through both ends.
fn cubic(Step { from, to, .. }: Step<'_>, theta: f64) -> (Vec<f64>, Vec<f64>) {
    let h = to.time - from.time;
    let rest = 1.0 - theta;
    let (mut q, mut v) = (from.q.to_vec(), from.v.to_vec());
    for k in 0..q.len() {
        let rise = to.q[k] - from.q[k];
        let (a, b) = (h * from.v[k] - rise, rise - h * to.v[k]);
        q[k] += theta * (rise + rest * (rest * a + theta * b));
        v[k] += theta * (to.v[k] - from.v[k]);
    }
    (q, v)
}
