//! What is measured of a motion at given times, between its instants, with its derivatives.

use super::outputs::{forces, outputs};
use super::place::Place;
use super::step::{Step, stage_input};
use super::tangent::{Matrix, Tangent};
use crate::model::Measured;
use crate::simulation::Instant;
use crate::yardstick;

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
        (time <= limit + yardstick::ROUNDING * limit.abs()).then_some(time)
    }

    /// What is measured at the start, where the acceleration is evaluated.
    pub(super) fn begin(&mut self, at: &Place<'_>, tangent: &Tangent) {
        let trajectory = &at.run.trajectory;
        let state = (&trajectory.q[0][..], &trajectory.v[0][..]);
        let impulses = trajectory.impulses(0);
        let instant = trajectory.instant(0, &impulses);
        while self.next(trajectory.time[0]).is_some() {
            let by = self.reads_outputs();
            let by = by.then(|| outputs(&at.acceleration, instant, tangent));
            self.put(state, &instant.outputs(at.acceleration.model));
            self.put_derivatives(tangent, by.as_ref());
        }
    }

    /// What is measured within the step to instant `k`, which was `solved`, or else on the cubic between its instants, with derivatives from
    /// those `before` it, if there are still all of them.
    pub(super) fn within(
        &mut self,
        at: &mut Place<'_>,
        (k, solved): (usize, bool),
        before: Option<&Tangent>,
    ) {
        let controls = at.controls(at.time(k - 1));
        let step = at.step_to(k, &controls);
        while let Some(time) = self.next(step.to.time) {
            let theta = ((time - step.from.time) / step.length()).clamp(0.0, 1.0);
            let (q, v) = match solved {
                true => at.steps.within(step, theta),
                false => cubic(step, theta),
            };
            let size = (q.len(), step.length());
            let tangent = before.map(|before| at.steps.derivatives_within(size, before, theta));
            let (mut recorded, mut recorded_by) = (Vec::new(), None);
            if self.reads_outputs() {
                let x = stage_input(&at.acceleration, (&q, &v), time, &controls);
                at.acceleration.evaluate(&x);
                let (model, layout) = (at.acceleration.model, at.acceleration.layout);
                let forces = forces(&at.acceleration, &Tangent::zeros(layout, 0)).0;
                let (contact_force, friction_force) = forces.split_at(forces.len() / 2);
                let instant = Instant {
                    time,
                    q: &q,
                    v: &v,
                    u: &x[2 * layout.n..layout.time()],
                    contact_force,
                    friction_force,
                    impulses: &at.run.trajectory.impulses(k - 1),
                };
                recorded = instant.outputs(model);
                let by = tangent.as_ref();
                recorded_by = by.map(|by| outputs(&at.acceleration, instant, by));
            }
            self.put((&q, &v), &recorded);
            if let Some(tangent) = &tangent {
                self.put_derivatives(tangent, recorded_by.as_ref());
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
    /// each step.
    pub(super) fn go_on(&mut self, at: &mut Place<'_>) {
        let run = at.run;
        at.modes.clone_from(&run.initial_modes);
        let mut passed = 0;
        for k in 1..run.trajectory.time.len() {
            let [from, to] = [at.time(k - 1), at.time(k)];
            while let Some(event) = run.events.get(passed).filter(|event| event.time <= from) {
                at.modes.clone_from(&event.modes);
                passed += 1;
            }
            if to <= from || self.next(to).is_none() {
                continue;
            }
            let controls = at.controls(from);
            let step = at.step_to(k, &controls);
            let known = at.enter(k - 1).is_ok();
            let solved = known && at.steps.values(&mut at.acceleration, step).is_some();
            self.within(at, (k, solved), None);
        }
    }
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
