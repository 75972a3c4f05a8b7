//! Poles that a run has passed between two of its instants.
//!
//! A step goes from one side of a pole to the other and notices nothing where no stage of it is near. A divisor tells: it changes its
//! sign there, and what it divides does not.

use super::Simulation;
use crate::enclosure::Bounds;
use crate::model::{Explicit, Model};

/// The first time \[s\] at which the accelerations, or the gap of the contact named, pass a pole between two instants of a run.
pub(super) fn first_passed(run: &Simulation, model: &dyn Model) -> Option<(f64, Option<usize>)> {
    let declaration = model.declaration();
    let mut bounds = Bounds::new(model);
    let surfaces = (0..declaration.contacts.len()).filter(|&i| !declaration.contacts[i].dry);
    let gaps = surfaces.map(|i| (Explicit::Gap(i), Some(i)));
    let functions = std::iter::once((Explicit::Motion, None)).chain(gaps);
    let trajectory = &run.trajectory;
    let mut x = vec![0.0; declaration.inputs()];
    let [mut before, mut here] = [Vec::new(), Vec::new()];
    let mut first: Option<(f64, Option<usize>)> = None;
    for (function, contact) in functions {
        for k in 0..trajectory.time.len() {
            let state = [&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]];
            let state = state.into_iter().flatten().copied();
            let state = state.chain(std::iter::once(trajectory.time[k]));
            x.iter_mut().zip(state).for_each(|(x, value)| *x = value);
            std::mem::swap(&mut before, &mut here);
            bounds.quotients(function, &x, &mut here);
            if k == 0 || trajectory.time[k] <= trajectory.time[k - 1] {
                continue;
            }
            let passes = |(a, b): &(&[f64; 2], &[f64; 2])| a[1] * b[1] < 0.0 && a[0] * b[0] > 0.0;
            if let Some((a, b)) = before.iter().zip(&here).find(passes) {
                let share = a[1] / (a[1] - b[1]);
                let [from, to] = [trajectory.time[k - 1], trajectory.time[k]];
                let time = from + share * (to - from);
                if first.is_none_or(|(known, _)| time < known) {
                    first = Some((time, contact));
                }
                break;
            }
        }
    }
    first
}
