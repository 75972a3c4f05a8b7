//! Steps in which something acts that their stages do not show.

use crate::simulation::event::dop853::{Dop853, System};
use crate::simulation::event::dynamics::{Dynamics, Switch};
use crate::simulation::event::error_scale::ErrorScale;
use crate::simulation::hidden_force;

/// Change of a velocity, as a share of what errors are measured by, above which it counts: a tenth of what a run promises.
const COUNTS: f64 = 1e-7;
/// Change as a multiple of the tolerance above which it counts: beside that steps differ by themselves.
const BESIDE_TOLERANCE: f64 = 100.0;

/// Whether something acts in the step of length `h` from `t` on, in each of whose `parts` nothing is hidden, that its stages do not show.
/// The continuous extension of the `method` is ready.
pub(super) fn acts(
    dynamics: &mut Dynamics<'_>,
    method: &Dop853,
    scale: &ErrorScale,
    (t, h): (f64, f64),
    (parts, tolerance): (&[[f64; 2]], f64),
) -> bool {
    let n = dynamics.n;
    let (mut state, mut slope) = (vec![0.0; 2 * n + 1], vec![0.0; 2 * n + 1]);
    let functions = 0..dynamics.functions();
    let may_vanish = |&function: &usize| match dynamics.switch(function) {
        // That of dry friction is given.
        Switch::NormalForce(i) => !dynamics.is_dry(i),
        switch => switch.is_force(),
    };
    let functions: Vec<usize> = functions.filter(may_vanish).collect();
    let at = |place: f64, values: &mut [f64]| {
        method.interpolate(place, &mut state[..2 * n]);
        dynamics.derivative(t + place * h, &state, &mut slope);
        values[..n].copy_from_slice(&slope[n..2 * n]);
        for (value, &function) in values[n..].iter_mut().zip(&functions) {
            *value = dynamics.switching.values[function];
        }
    };
    let most = COUNTS.max(BESIDE_TOLERANCE * tolerance);
    let most = |k| most * scale.allowed(n + k, h, 1.0);
    hidden_force::acts(parts, (n, functions.len()), h, at, most)
}
