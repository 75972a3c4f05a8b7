//! Which impacts end a motion, where rounding may put them on either side of its final time.

use super::dynamics::{Dynamics, Switch};
use crate::model::contact_point;

/// What a motion is known to end with.
#[derive(Clone, Copy)]
pub(crate) struct Ending<'a> {
    /// What is no longer before the final time than this happens at it \[s\].
    pub(crate) near: f64,
    /// Gap up to which a contact that is to be struck is closed at the end \[its unit\].
    pub(crate) gap: f64,
    /// Contacts whose impacts end the motion, with those that touch at the same instant; no other impact does.
    pub(crate) struck: &'a [usize],
}

impl Ending<'_> {
    /// Whether the motion is over where the switching function `vanished` does, so long before its final time \[s\]: it closes a
    /// contact that is not to be struck any more.
    pub(super) fn is_over(
        self,
        dynamics: &Dynamics<'_>,
        vanished: Option<Switch>,
        before: f64,
    ) -> bool {
        before <= self.near
            && matches!(vanished, Some(Switch::Gap(contact))
                if !dynamics.pieces.is_idle(contact) && !self.struck.contains(&contact))
    }

    /// Whether `contact` is about to be struck at a time and state.
    pub(super) fn is_due(
        self,
        dynamics: &mut Dynamics<'_>,
        contact: usize,
        (t, y): (f64, &[f64]),
    ) -> bool {
        dynamics.load(t, y);
        dynamics.evaluate_sides(contact);
        let point = dynamics.point(contact);
        point[contact_point::NORMAL_VELOCITY] < 0.0 && point[contact_point::GAP] <= self.gap
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed step is a failed test")]
mod tests {
    use super::Ending;
    use crate::simulation::{ControlSignal, EventDriven, InitialValueProblem, simulate_to};

    crate::model! {
        /// A ball between a floor and a wall that it reaches in 1 s.
        Ball {
            coordinates { y, z }
            lagrangian (dot(y)^2 + dot(z)^2)/2
            surface floor: z >= 0
            surface wall: y <= 1
            impact floor, wall: restitution 0.5
        }
    }

    /// Velocities at the end, and the number of events.
    fn end(horizon: f64, struck: Option<&[usize]>) -> (Vec<f64>, usize) {
        let problem = InitialValueProblem {
            q: vec![0.0, 1.0],
            v: vec![1.0, -1.0],
            horizon,
            controls: ControlSignal::Zero,
            points: 1000,
        };
        let ending = struck.map(|struck| Ending {
            near: 1e-8,
            gap: 1e-8,
            struck,
        });
        let settings = EventDriven::default();
        let motion = simulate_to(&settings, &Ball::default(), &problem, ending).unwrap();
        assert_eq!(motion.trajectory.time.last(), Some(&horizon));
        (
            motion.trajectory.v.last().unwrap().clone(),
            motion.events.len(),
        )
    }

    #[test]
    fn impacts_at_the_final_time_are_those_that_are_known() {
        for horizon in [1.0 - 1e-10, 1.0, 1.0 + 1e-10] {
            assert_eq!(end(horizon, Some(&[])), (vec![1.0, -1.0], 0));
            assert_eq!(end(horizon, Some(&[0, 1])), (vec![-0.5, 0.5], 2));
        }
        // Where they are no matter of rounding they happen as they do.
        assert_eq!(end(1.0 - 1e-6, Some(&[0, 1])), (vec![1.0, -1.0], 0));
        assert_eq!(end(1.0 + 1e-6, Some(&[])), (vec![-0.5, 0.5], 2));
        assert_eq!(end(1.0 + 1e-10, None), (vec![-0.5, 0.5], 2));
    }
}
