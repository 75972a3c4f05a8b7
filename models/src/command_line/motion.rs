//! From a simulation to a picture of the motion in its plane.

use hangtime::model::Model;
use hangtime::simulation::{EventKind, Simulation, Trajectory};
use hangtime_models::{Plane, PublishedMarker};

use super::figure::{Motion, Path};

/// Points drawn between two instants of the trajectory.
const POINTS_BETWEEN: usize = 8;
/// Ground drawn on either side of the motion, as a share of its horizontal extent.
const GROUND_AROUND: f64 = 0.25;
/// Time between two positions of the time lapse where none is published [s].
const DEFAULT_INTERVAL: f64 = 0.2;

/// Coordinates at physical time `t`: the cubic through the states of the two neighbouring instants
/// and their velocities. It is exact where the acceleration is constant, and misses by
/// `h^4 |q''''| / 384` between two instants that are `h` apart otherwise.
///
/// `None` outside the trajectory.
pub(crate) fn coordinates_at(trajectory: &Trajectory, t: f64) -> Option<Vec<f64>> {
    let next = trajectory.time.partition_point(|&time| time <= t);
    let last = next.checked_sub(1)?;
    if next == trajectory.time.len() {
        return (trajectory.time[last] == t).then(|| trajectory.q[last].clone());
    }
    let h = trajectory.time[next] - trajectory.time[last];
    let s = (t - trajectory.time[last]) / h;
    let (q0, q1) = (&trajectory.q[last], &trajectory.q[next]);
    let (v0, v1) = (&trajectory.v[last], &trajectory.v[next]);
    Some(
        (0..q0.len())
            .map(|i| {
                let rise = q1[i] - q0[i];
                let (a, b) = (h * v0[i] - rise, rise - h * v1[i]);
                q0[i] + s * (rise + (1.0 - s) * ((1.0 - s) * a + s * b))
            })
            .collect(),
    )
}

/// The picture of a simulation, beside published markers if there are any.
pub(crate) fn motion(
    title: String,
    plane: &Plane,
    model: &dyn Model,
    simulation: &Simulation,
    published: Vec<PublishedMarker>,
    interval: Option<f64>,
) -> Motion {
    let trajectory = &simulation.trajectory;
    let positions = |q: &[f64]| (plane.positions)(model, q);
    let interval = interval.unwrap_or(DEFAULT_INTERVAL);
    let end = trajectory.time.last().copied().unwrap_or_default();
    // A quotient that rounding put just below a whole number still counts as that number.
    let lapses = (end / interval + 1e-9) as usize;
    let time_lapse: Vec<Vec<[f64; 2]>> = (0..=lapses)
        .filter_map(|k| coordinates_at(trajectory, (k as f64 * interval).min(end)))
        .map(|q| positions(&q))
        .collect();
    let path: Vec<Vec<[f64; 2]>> = instants(trajectory)
        .filter_map(|t| coordinates_at(trajectory, t))
        .map(|q| positions(&q))
        .collect();
    let body = |rows: &[Vec<[f64; 2]>], body: usize| rows.iter().map(|row| row[body]).collect();
    let published_positions = published.iter().map(|marker| marker.position);
    let seen = path.iter().flatten().copied().chain(published_positions);
    let (from, to) = seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), [y, _]| {
        (from.min(y), to.max(y))
    });
    // Some ground on either side of the motion.
    let around = GROUND_AROUND * (to - from);
    Motion {
        title,
        axes: plane.axes,
        ground: if from <= to {
            (plane.ground)(model, from - around, to + around)
        } else {
            Vec::new()
        },
        paths: plane
            .bodies
            .iter()
            .enumerate()
            .map(|(index, name)| Path {
                name,
                points: body(&path, index),
                time_lapse: body(&time_lapse, index),
            })
            .collect(),
        start: trajectory
            .q
            .first()
            .map(|q| positions(q))
            .unwrap_or_default(),
        impacts: simulation
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Impact)
            .flat_map(|event| positions(&event.q))
            .collect(),
        published,
        interval,
    }
}

/// The instants of the trajectory and some between them.
fn instants(trajectory: &Trajectory) -> impl Iterator<Item = f64> {
    let between = trajectory.time.windows(2).flat_map(|pair| {
        let (from, to) = (pair[0], pair[1]);
        let points = if to > from { POINTS_BETWEEN } else { 0 };
        (0..points).map(move |i| from + (to - from) * i as f64 / points as f64)
    });
    between.chain(trajectory.time.last().copied())
}

#[cfg(test)]
mod tests {
    use hangtime::simulation::Trajectory;

    use super::coordinates_at;

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
    fn coordinates_at_constant_acceleration_is_exact() {
        let trajectory = thrown();
        for t in [0.0_f64, 0.1, 0.5, 0.77, 1.0] {
            let q = coordinates_at(&trajectory, t).unwrap()[0];
            // A handful of roundings of numbers below 3.
            assert!((q - (3.0 * t - 3.0 * t * t)).abs() < 1e-15, "{t}: {q}");
        }
    }

    #[test]
    fn coordinates_at_after_an_impact_uses_the_velocity_after_it() {
        assert_eq!(coordinates_at(&thrown(), 1.5), Some(vec![0.0]));
        assert_eq!(coordinates_at(&thrown(), 2.0), Some(vec![0.0]));
    }

    #[test]
    fn coordinates_at_outside_the_trajectory_is_none() {
        assert_eq!(coordinates_at(&thrown(), 2.5), None);
        assert_eq!(coordinates_at(&Trajectory::default(), 0.0), None);
    }
}
