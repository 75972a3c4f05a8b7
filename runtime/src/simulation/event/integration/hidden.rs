//! Steps in which something acts that their stages do not show.

use super::Integration;
use crate::simulation::hidden_force::mean_change;

/// Change of a velocity, as a share of what errors are measured by, above which it counts: a tenth of what a run promises.
const COUNTS: f64 = 1e-7;

impl Integration<'_> {
    /// Whether something acts besides contacts in the step of length `h`, whose continuous extension is ready, that its stages do not show.
    pub(super) fn hides_a_force(&mut self, h: f64) -> bool {
        let (n, t) = (self.dynamics.n, self.t);
        let (dynamics, method) = (&mut self.dynamics, &self.method);
        let mut state = vec![0.0; 2 * n];
        let change = mean_change((h, self.problem.horizon), n, |place, acceleration| {
            method.interpolate(place, &mut state);
            dynamics.load(t + place * h, &state);
            dynamics
                .model
                .free_acceleration(dynamics.input(), acceleration);
        });
        let scale = &self.step.error_scale;
        let share = |(k, change): (usize, f64)| change * h / scale.allowed(n + k, h, 1.0);
        let shares = change.into_iter().flatten().enumerate().map(share);
        shares.fold(0.0, f64::max) > COUNTS
    }
}
