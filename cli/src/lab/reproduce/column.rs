//! One motion of a case, and the numbers that are read from it.

use crate::{ComparedValue, Measure, Quantity};
use hangtime::simulation::{Event, EventKind, InitialValueProblem, Simulation};

use super::case::Case;
use crate::method::ChosenMethod;
use crate::quantity;
use crate::sampling::{State, dense, state_at};

/// Newton steps towards the time at which a coordinate reaches a value: from an interpolated time, two are enough.
const NEWTON_STEPS: usize = 3;

/// A motion beside others.
pub(super) struct Column {
    /// Head of the column.
    pub(super) name: &'static str,
    pub(super) simulation: Simulation,
    /// Largest residual of a simulation; distance of the re-simulation of an optimum.
    pub(super) residual: f64,
    /// How to come to a state between instants that are far from each other without loss.
    pub(super) rerun: Option<(ChosenMethod, InitialValueProblem)>,
}

impl Column {
    /// The state at a time.
    pub(super) fn state_at(&self, case: &Case, time: f64) -> Option<State> {
        let trajectory = &self.simulation.trajectory;
        let model = case.chosen.model.as_ref();
        let Some((method, problem)) = self.rerun.as_ref().filter(|_| time > 0.0) else {
            return state_at(model, trajectory, time);
        };
        let problem = InitialValueProblem {
            horizon: time,
            ..problem.clone()
        };
        let run = method.simulate(model, &problem, &mut |_| true).ok()?;
        let last = run.trajectory.time.len().checked_sub(1)?;
        Some(State::of(model, &run.trajectory, last))
    }

    /// A value in its unit.
    pub(super) fn measure(&self, case: &Case, value: ComparedValue) -> Option<f64> {
        let trajectory = &self.simulation.trajectory;
        let end = || trajectory.time.len().checked_sub(1);
        let model = case.chosen.model.as_ref();
        let convert = |quantity, number| quantity::converted(model, quantity, number, value.unit);
        match value.measure {
            Measure::FinalTime => trajectory.time.last().copied(),
            Measure::Final(quantity) => {
                let state = State::of(model, trajectory, end()?);
                convert(quantity, state.value(quantity)?)
            }
            Measure::Gain(quantity) => {
                let [start, end] =
                    [0, end()?].map(|k| State::of(model, trajectory, k).value(quantity));
                Some(convert(quantity, end?)? - convert(quantity, start?)?)
            }
            Measure::At(time, quantity) => {
                let state = self.state_at(case, time)?;
                convert(quantity, state.value(quantity)?)
            }
            Measure::EventTime(kind) => Some(self.event(kind)?.time),
            Measure::EventCoordinate(kind, index) => {
                convert(Quantity::Coordinate(index), self.event(kind)?.q[index])
            }
            Measure::Reach(index, target) => self.reach(case, index, target),
        }
    }

    fn event(&self, kind: EventKind) -> Option<&Event> {
        let mut events = self.simulation.events.iter();
        events.find(|event| event.kind == kind)
    }

    /// First time at which coordinate `index` reaches `target`.
    fn reach(&self, case: &Case, index: usize, target: f64) -> Option<f64> {
        let states = dense(case.chosen.model.as_ref(), &self.simulation.trajectory);
        let [before, after] = states.windows(2).find_map(|pair| {
            let [a, b] = [pair[0].q[index] - target, pair[1].q[index] - target];
            (a * b <= 0.0 && a != b).then_some([&pair[0], &pair[1]])
        })?;
        let share = (target - before.q[index]) / (after.q[index] - before.q[index]);
        let mut time = before.time + share * (after.time - before.time);
        for _ in 0..NEWTON_STEPS {
            let state = self.state_at(case, time)?;
            let next = time - (state.q[index] - target) / state.v[index];
            if !(before.time..=after.time).contains(&next) {
                break;
            }
            time = next;
        }
        Some(time)
    }
}
