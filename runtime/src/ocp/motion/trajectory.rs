//! A motion with its controls: what one phase of the solution hands to the next.

use super::control_grid::ControlGrid;
use super::model_input::drive;
use crate::model::{Model, contact_point, held};
use crate::ocp::problem::Problem;
use crate::simulation::{ControlSignal, Simulation};
use crate::yardstick;

/// States over time, piecewise linear, with controls on intervals.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::ocp) struct Trajectory {
    /// Length \[s\].
    pub(in crate::ocp) horizon: f64,
    /// Controls on its intervals.
    pub(in crate::ocp) controls: ControlGrid,
    /// Instants \[s\], not decreasing; twice at a jump.
    pub(in crate::ocp) time: Vec<f64>,
    /// `(q, v, r)` at each instant, where `r` are the normal accelerations that the contacts provide.
    pub(in crate::ocp) states: Vec<Vec<f64>>,
}

impl Trajectory {
    /// The motion of a simulation.
    pub(in crate::ocp) fn of_simulation(
        model: &dyn Model,
        simulation: &Simulation,
        horizon: f64,
        controls: ControlGrid,
    ) -> Self {
        let declaration = model.declaration();
        let mut point = vec![0.0; contact_point::length(declaration.coordinates.len())];
        let trajectory = &simulation.trajectory;
        let states = (0..trajectory.time.len()).map(|i| {
            let mut x = trajectory.q[i].clone();
            x.extend(&trajectory.v[i]);
            let plain = x.len();
            x.extend(drive(model, &trajectory.u[i], trajectory.time[i]));
            let forces: Vec<f64> = (0..declaration.contacts.len())
                .map(|contact| {
                    model.contact(contact, &x, &mut point);
                    trajectory.contact_force[i][contact] * point[contact_point::INVERSE_INERTIA]
                })
                .collect();
            x.truncate(plain);
            x.extend(forces);
            x
        });
        Self {
            horizon,
            controls,
            time: trajectory.time.clone(),
            states: states.collect(),
        }
    }

    /// The `(q, v)` that a path starts at, where it is free, and the declared one elsewhere.
    pub(in crate::ocp) fn start(&self, model: &dyn Model, problem: &Problem) -> Vec<f64> {
        let ranges = problem.start_ranges(model).into_iter();
        let start = ranges.zip(&self.states[0]);
        let mut start: Vec<f64> = start
            .map(|((lower, upper), value)| value.max(lower).min(upper))
            .collect();
        held::complete_start(model, &mut start);
        start
    }

    /// The motion up to its last jump, stretched to the whole length, if that is a jump in the last interval: a
    /// start for a motion that ends with an impact.
    pub(in crate::ocp) fn up_to_last_jump(&self, intervals: usize) -> Self {
        let mut shorter = self.clone();
        let jumps = |k: &usize| {
            let passed = self.time[*k] - self.time[k - 1];
            passed <= yardstick::ROUNDING * self.horizon && self.states[k - 1] != self.states[*k]
        };
        let late = |k: &usize| {
            self.time[*k] > 0.0 && self.horizon - self.time[*k] < self.horizon / intervals as f64
        };
        let Some(last) = (1..self.time.len()).rev().find(jumps).filter(late) else {
            return shorter;
        };
        let factor = self.horizon / self.time[last];
        shorter.time.truncate(last + 1);
        shorter.states.truncate(last + 1);
        shorter.time.iter_mut().for_each(|time| *time *= factor);
        shorter.time[last - 1] = self.horizon;
        shorter.time[last] = self.horizon;
        shorter
    }

    /// This motion over another time: states as they are, at other instants.
    pub(in crate::ocp) fn stretched(mut self, horizon: f64) -> Self {
        let factor = horizon / self.horizon;
        self.time.iter_mut().for_each(|time| *time *= factor);
        self.horizon = horizon;
        self
    }

    /// These states with what happens at some instants, in their order, at others; between them time passes evenly.
    pub(in crate::ocp) fn warped(&self, instants: &[(f64, f64)]) -> Self {
        let mut all = vec![(0.0, 0.0)];
        all.extend(instants);
        all.push((self.horizon, self.horizon));
        let at = |time: f64| {
            let next = all.partition_point(|(from, _)| *from < time);
            let next = next.clamp(1, all.len() - 1);
            let ((from, to), (next_from, next_to)) = (all[next - 1], all[next]);
            if next_from > from {
                to + (time - from) / (next_from - from) * (next_to - to)
            } else {
                next_to
            }
        };
        Self {
            time: self.time.iter().map(|&time| at(time)).collect(),
            ..self.clone()
        }
    }

    /// The controls as a signal.
    pub(in crate::ocp) fn signal(&self) -> ControlSignal {
        self.controls.signal(self.horizon)
    }

    /// The controls averaged over a span of time; in a span of no length those after it.
    pub(in crate::ocp) fn controls_between(&self, from: f64, to: f64) -> Vec<f64> {
        let values = self.controls.values();
        let ends = self.controls.times(self.horizon);
        let (from, to) = (from.clamp(0.0, self.horizon), to.clamp(0.0, self.horizon));
        let mut sum = vec![0.0; values[0].len()];
        let mut passed = 0.0;
        for (value, ends) in values.iter().zip(ends.windows(2)) {
            let overlap = (ends[1].min(to) - ends[0].max(from)).max(0.0);
            passed += overlap;
            for (sum, u) in sum.iter_mut().zip(value) {
                *sum += overlap * u;
            }
        }
        if passed <= 0.0 {
            let place = ends.partition_point(|&end| end <= from);
            return values[(place.max(1) - 1).min(values.len() - 1)].clone();
        }
        sum.iter().map(|sum| sum / passed).collect()
    }

    /// `(q, v, r)` at time `t`, on the later side of a jump if `after`.
    pub(in crate::ocp) fn at(&self, t: f64, after: bool) -> Vec<f64> {
        let next = if after {
            self.time.partition_point(|&time| time <= t)
        } else {
            self.time.partition_point(|&time| time < t)
        };
        let last = self.time.len() - 1;
        if next == 0 || next > last {
            return self.states[next.min(last)].clone();
        }
        let (from, to) = (self.time[next - 1], self.time[next]);
        let share = if to > from {
            (t - from) / (to - from)
        } else {
            1.0
        };
        let pair = self.states[next - 1].iter().zip(&self.states[next]);
        pair.map(|(a, b)| a + share * (b - a)).collect()
    }
}

pub(in crate::ocp) fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |largest: f64, (a, b)| largest.max((a - b).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A coordinate that moves at 1 to the time 2, where its velocity jumps to -1, and back until 3.
    fn bounce() -> Trajectory {
        Trajectory {
            horizon: 3.0,
            controls: ControlGrid::constant(vec![vec![0.0]; 2]),
            time: vec![0.0, 2.0, 2.0, 3.0],
            states: vec![
                vec![0.0, 1.0],
                vec![2.0, 1.0],
                vec![2.0, -1.0],
                vec![1.0, -1.0],
            ],
        }
    }

    #[test]
    fn state_at_a_jump_is_that_of_the_side_asked_for() {
        let motion = bounce();
        assert_eq!(motion.at(2.0, false), [2.0, 1.0]);
        assert_eq!(motion.at(2.0, true), [2.0, -1.0]);
        assert_eq!(motion.at(0.5, true), [0.5, 1.0]);
        assert_eq!(motion.at(9.0, true), [1.0, -1.0]);
    }

    #[test]
    fn motion_up_to_a_jump_in_its_last_interval_is_stretched_to_the_whole_length() {
        let shorter = bounce().up_to_last_jump(2);
        assert_eq!(shorter.time, [0.0, 3.0, 3.0]);
        assert_eq!(shorter.at(3.0, true), [2.0, -1.0]);
        // With three intervals the jump lies at the end of the second one.
        assert_eq!(bounce().up_to_last_jump(3), bounce());
    }

    #[test]
    fn controls_between_are_weighted_by_the_parts_of_intervals() {
        let nodes = vec![0.0, 1.0 / 3.0, 1.0];
        let driven = Trajectory {
            controls: ControlGrid::constant(vec![vec![1.0], vec![4.0]]).with_nodes(nodes),
            ..bounce()
        };
        assert_eq!(driven.controls_between(0.0, 1.0), [1.0]);
        assert_eq!(driven.controls_between(0.5, 2.0), [3.0]);
        assert_eq!(driven.controls_between(2.0, 2.0), [4.0]);
        assert_eq!(driven.controls.at(1.0), [4.0]);
    }

    #[test]
    fn warped_motion_jumps_at_the_other_instant_and_lasts_as_long() {
        let earlier = bounce().warped(&[(2.0, 1.0)]);
        assert_eq!(earlier.time, [0.0, 1.0, 1.0, 3.0]);
        assert_eq!(earlier.at(1.0, false), [2.0, 1.0]);
        assert_eq!(earlier.at(1.0, true), [2.0, -1.0]);
        assert_eq!(bounce().warped(&[]), bounce());
    }

    #[test]
    fn stretched_motion_goes_through_the_same_states() {
        let longer = bounce().stretched(6.0);
        assert_eq!(
            (longer.horizon, longer.at(1.0, true)),
            (6.0, vec![0.5, 1.0])
        );
    }
}
