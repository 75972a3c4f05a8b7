//! States between the instants that a trajectory keeps.

use crate::Quantity;
use hangtime::model::Model;
use hangtime::simulation::{Trajectory, joint_forces};

use crate::thinning::kept;

/// About how many states a line is drawn through.
const POINTS: usize = 600;
/// Most instants of the trajectory that a line is drawn through: no screen shows more.
const MOST_DRAWN: usize = 5_000;
/// Most states drawn between two instants of the trajectory.
const MOST_BETWEEN: usize = 40;

/// In shorter intervals [s], relative to the time, rounding dominates the slope of the coordinates.
const SHORT: f64 = 1e-8;

/// The state of a motion at one instant.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct State {
    /// Time [s].
    pub(crate) time: f64,
    /// Coordinates.
    pub(crate) q: Vec<f64>,
    /// Velocities.
    pub(crate) v: Vec<f64>,
    /// Controls.
    pub(crate) u: Vec<f64>,
    /// Normal contact forces.
    pub(crate) contact_force: Vec<f64>,
    /// Tangential contact forces; empty in a scene without friction.
    pub(crate) friction_force: Vec<f64>,
    /// Impulses of all impacts so far.
    pub(crate) impulses: Vec<f64>,
    /// What the scene declares in `outputs`.
    pub(crate) outputs: Vec<f64>,
}

impl State {
    /// The value of a quantity.
    pub(crate) fn value(&self, quantity: Quantity) -> Option<f64> {
        let (values, index) = match quantity {
            Quantity::Coordinate(index) => (&self.q, index),
            Quantity::Velocity(index) => (&self.v, index),
            Quantity::Control(index) => (&self.u, index),
            Quantity::ContactForce(index) => (&self.contact_force, index),
            Quantity::FrictionForce(index) => (&self.friction_force, index),
            Quantity::Output(index) => (&self.outputs, index),
        };
        values.get(index).copied()
    }

    /// Instant `k` of the trajectory.
    pub(crate) fn of(model: &dyn Model, trajectory: &Trajectory, k: usize) -> Self {
        let state = Self {
            time: trajectory.time[k],
            q: trajectory.q[k].clone(),
            v: trajectory.v[k].clone(),
            u: trajectory.u[k].clone(),
            contact_force: trajectory.contact_force[k].clone(),
            friction_force: trajectory
                .friction_force
                .get(k)
                .cloned()
                .unwrap_or_default(),
            impulses: trajectory.impulses(k),
            outputs: Vec::new(),
        };
        state.recorded(model)
    }

    /// The state with the outputs of the scene.
    fn recorded(self, model: &dyn Model) -> Self {
        let count = model.outputs().len();
        if count == 0 {
            return self;
        }
        let mut x = self.q.clone();
        x.extend(self.v.iter().chain(&self.u).chain([&self.time]));
        let mut contacts = self.contact_force.clone();
        contacts.extend(&self.friction_force);
        contacts.resize(2 * self.contact_force.len(), 0.0);
        contacts.extend(&self.impulses);
        if model.declaration().joints.is_some() {
            contacts.resize(4 * self.contact_force.len(), 0.0);
            let (normal, rubs) = (&self.contact_force, &self.friction_force);
            contacts.extend(joint_forces(model, &x, normal, rubs));
        }
        let mut outputs = vec![f64::NAN; count];
        model.output_values(&x, &contacts, &mut outputs);
        Self { outputs, ..self }
    }

    /// The state at the share `s` of the interval from instant `k` to the next: coordinates on the cubic through
    /// both states and their velocities, velocities as its derivative, forces and controls on a straight line: where these
    /// jump, the trajectory keeps both sides.
    fn between(model: &dyn Model, trajectory: &Trajectory, k: usize, s: f64) -> Self {
        let t0 = trajectory.time[k];
        let h = trajectory.time[k + 1] - t0;
        let (q0, q1) = (&trajectory.q[k], &trajectory.q[k + 1]);
        let (v0, v1) = (&trajectory.v[k], &trajectory.v[k + 1]);
        let cubic = (0..q0.len()).map(|i| {
            let rise = q1[i] - q0[i];
            let (a, b) = (h * v0[i] - rise, rise - h * v1[i]);
            let q = q0[i] + s * (rise + (1.0 - s) * ((1.0 - s) * a + s * b));
            let slope = rise + (1.0 - s) * (1.0 - 3.0 * s) * a + s * (2.0 - 3.0 * s) * b;
            let v = if h > SHORT * t0.abs().max(1.0) {
                slope / h
            } else {
                v0[i] + s * (v1[i] - v0[i])
            };
            (q, v)
        });
        let (q, v) = cubic.unzip();
        let straight = |rows: &[Vec<f64>]| match (rows.get(k), rows.get(k + 1)) {
            (Some(from), Some(to)) => {
                let ends = from.iter().zip(to);
                ends.map(|(from, to)| from + s * (to - from)).collect()
            }
            _ => Vec::new(),
        };
        let state = Self {
            time: t0 + s * h,
            q,
            v,
            u: straight(&trajectory.u),
            contact_force: straight(&trajectory.contact_force),
            friction_force: straight(&trajectory.friction_force),
            impulses: trajectory.impulses(k),
            outputs: Vec::new(),
        };
        state.recorded(model)
    }
}

/// The state at physical time `t`, after the jump if there is one. The coordinates are exact where the acceleration
/// is constant, and miss by `h^4 |q''''| / 384` between two instants that are `h` apart otherwise.
///
/// `None` outside the trajectory.
pub(crate) fn state_at(model: &dyn Model, trajectory: &Trajectory, t: f64) -> Option<State> {
    let next = trajectory.time.partition_point(|&time| time <= t);
    let last = next.checked_sub(1)?;
    if next == trajectory.time.len() {
        return (trajectory.time[last] == t).then(|| State::of(model, trajectory, last));
    }
    let h = trajectory.time[next] - trajectory.time[last];
    let s = (t - trajectory.time[last]) / h;
    Some(State::between(model, trajectory, last, s))
}

/// The states of the trajectory and some between them, enough for a smooth line, or a part of them, if there are very
/// many. Where the motion jumps, the states before and after the jump follow each other.
pub(crate) fn dense(model: &dyn Model, trajectory: &Trajectory) -> Vec<State> {
    let instants = trajectory.time.len();
    if instants == 0 {
        return Vec::new();
    }
    if instants > MOST_DRAWN {
        let kept = kept(&trajectory.time, MOST_DRAWN);
        return kept
            .into_iter()
            .map(|k| State::of(model, trajectory, k))
            .collect();
    }
    let between = POINTS.div_ceil(instants).clamp(1, MOST_BETWEEN);
    let mut states = Vec::with_capacity(instants * (between + 1));
    for k in 0..instants - 1 {
        states.push(State::of(model, trajectory, k));
        if trajectory.time[k + 1] > trajectory.time[k] {
            let shares = (1..between).map(|i| i as f64 / between as f64);
            states.extend(shares.map(|s| State::between(model, trajectory, k, s)));
        }
    }
    states.push(State::of(model, trajectory, instants - 1));
    states.dedup();
    states
}

/// Which end of the values of a quantity is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    /// The smallest one.
    Smallest,
    /// The largest one.
    Largest,
}

/// The largest or the smallest value of a quantity along a motion, on both sides of its jumps: the best of many states, and what is better
/// right beside that, by golden sections.
pub(crate) fn extreme(
    model: &dyn Model,
    trajectory: &Trajectory,
    quantity: Quantity,
    side: Side,
) -> Option<f64> {
    /// Sections after which an interval is shorter by 1e-9; a smooth extreme is known to rounding then.
    const SECTIONS: usize = 43;
    let ratio = (5.0_f64.sqrt() - 1.0) / 2.0;
    let sign = match side {
        Side::Smallest => -1.0,
        Side::Largest => 1.0,
    };
    let states = dense(model, trajectory);
    let value = |state: &State| Some(sign * state.value(quantity)?).filter(|x| x.is_finite());
    let known = states.iter().enumerate();
    let known = known.filter_map(|(k, state)| Some((k, value(state)?)));
    let (place, mut best) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let [mut from, mut to] =
        [place.saturating_sub(1), (place + 1).min(states.len() - 1)].map(|k| states[k].time);
    let at = |t: f64| state_at(model, trajectory, t).and_then(|state| value(&state));
    for _ in 0..SECTIONS {
        let [early, late] = [to - ratio * (to - from), from + ratio * (to - from)];
        let (Some(a), Some(b)) = (at(early), at(late)) else {
            break;
        };
        best = best.max(a).max(b);
        if a > b {
            to = late;
        } else {
            from = early;
        }
    }
    Some(sign * best)
}

/// The largest force of a joint along a motion: of its equations `rows` among those of all joints, the root of the sum of the squares.
pub(crate) fn largest_joint_force(
    model: &dyn Model,
    trajectory: &Trajectory,
    rows: &std::ops::Range<usize>,
) -> Option<f64> {
    let size = |k: usize| {
        let mut x = [&trajectory.q[k][..], &trajectory.v[k], &trajectory.u[k]].concat();
        x.push(trajectory.time[k]);
        let rubs = trajectory.friction_force.get(k).map_or(&[][..], |row| row);
        let forces = joint_forces(model, &x, &trajectory.contact_force[k], rubs);
        let squares = forces.get(rows.clone())?.iter().map(|force| force * force);
        Some(squares.sum::<f64>().sqrt())
    };
    (0..trajectory.time.len()).filter_map(size).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use hangtime::simulation::Trajectory;

    use super::{Side, dense, extreme, state_at};
    use crate::Quantity;
    use crate::testing::Slide;

    /// A ball thrown up at 3 m/s that stops on the ground at t = 1 s; the jump is kept twice.
    fn thrown() -> Trajectory {
        let mut trajectory = Trajectory::default();
        let state = |t: f64| ([3.0 * t - 3.0 * t * t], [3.0 - 6.0 * t]);
        for t in [0.0, 0.5, 1.0] {
            let (q, v) = state(t);
            trajectory.push(t, t, &q, &v, &[], &[]);
        }
        trajectory.push(1.0, 1.1, &[0.0], &[0.0], &[], &[]);
        trajectory.push(2.0, 2.1, &[0.0], &[0.0], &[], &[]);
        trajectory
    }

    #[test]
    fn state_at_constant_acceleration_is_exact() {
        let trajectory = thrown();
        for t in [0.0_f64, 0.1, 0.5, 0.77, 0.999] {
            let state = state_at(&Slide::default(), &trajectory, t).unwrap();
            // A handful of roundings of numbers below 3 and of their quotients by 0.5.
            assert!((state.q[0] - (3.0 * t - 3.0 * t * t)).abs() < 1e-14, "{t}");
            assert!((state.v[0] - (3.0 - 6.0 * t)).abs() < 1e-14, "{t}");
        }
    }

    #[test]
    fn extremes_are_found_between_instants_and_on_both_sides_of_a_jump() {
        let of = |quantity, side| extreme(&Slide::default(), &thrown(), quantity, side).unwrap();
        // The top of 3 t - 3 t^2 at t = 1/2, here with an instant right there; the speed before the impact.
        assert!((of(Quantity::Coordinate(0), Side::Largest) - 0.75).abs() < 1e-14);
        assert_eq!(of(Quantity::Velocity(0), Side::Smallest), -3.0);
        // A cubic whose top is between two instants.
        let mut trajectory = Trajectory::default();
        trajectory.push(0.0, 0.0, &[0.0], &[1.0], &[], &[]);
        trajectory.push(1.0, 1.0, &[0.0], &[-0.5], &[], &[]);
        // q = s (1 - s) ((1 - s) + s/2) has its slope 1 - 3 s + 3 s^2/2 vanish at s = 1 - 1/sqrt(3).
        let s = 1.0 - 1.0 / 3.0_f64.sqrt();
        let top = s * (1.0 - s) * (1.0 - s / 2.0);
        let found = extreme(
            &Slide::default(),
            &trajectory,
            Quantity::Coordinate(0),
            Side::Largest,
        );
        assert!((found.unwrap() - top).abs() < 1e-14);
    }

    #[test]
    fn state_at_an_impact_is_the_one_after_it() {
        let q = |t| state_at(&Slide::default(), &thrown(), t).map(|state| (state.q[0], state.v[0]));
        assert_eq!(q(1.0), Some((0.0, 0.0)));
        assert_eq!(q(1.5), Some((0.0, 0.0)));
        assert_eq!(q(2.0), Some((0.0, 0.0)));
    }

    #[test]
    fn state_at_in_an_interval_of_rounding_has_a_velocity_between_its_ends() {
        let mut trajectory = Trajectory::default();
        let (early, late) = (1.0, 1.0_f64.next_up().next_up());
        trajectory.push(early, early, &[5.0], &[3.0], &[], &[]);
        trajectory.push(late, late, &[5.0_f64.next_up()], &[3.0], &[], &[]);
        let state = state_at(&Slide::default(), &trajectory, 1.0_f64.next_up()).unwrap();
        assert_eq!(state.v, [3.0]);
    }

    #[test]
    fn state_at_outside_the_trajectory_is_none() {
        assert_eq!(state_at(&Slide::default(), &thrown(), 2.5), None);
        assert_eq!(
            state_at(&Slide::default(), &Trajectory::default(), 0.0),
            None
        );
    }

    #[test]
    fn dense_states_keep_both_sides_of_a_jump() {
        let states = dense(&Slide::default(), &thrown());
        assert!(states.is_sorted_by(|a, b| a.time <= b.time));
        let speeds = states.iter().filter(|state| state.time == 1.0);
        let speeds: Vec<f64> = speeds.map(|state| state.v[0]).collect();
        assert_eq!(speeds, [-3.0, 0.0]);
        assert!(dense(&Slide::default(), &Trajectory::default()).is_empty());
    }
}
