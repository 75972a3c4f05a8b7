//! Controls that are linear in the physical time on each interval.
//!
//! The clock of stage `m` tells where between the nodes `u_k` and `u_{k+1}` its control is, with the length `T` of the motion and
//! its start `t_0`:
//!
//! ```text
//! 0 = T (u_m - u_k) - (u_{k+1} - u_k) (N (t_m - t_0) - k T)      over the guess of T
//! ```
//!
//! A jump has one control, as its clock stands. Between nodes within bounds every control is.

use super::Transcription;
use super::numbered::Ramp;

/// Length of the motion, and how far the clock is past the node before, both over the guess of the length, the second one
/// in intervals times the length.
fn lengths(ramp: &Ramp, transcription: &Transcription<'_>, x: &[f64]) -> (f64, f64) {
    let guess = transcription.task.horizon;
    let count = transcription.task.intervals as f64;
    let length = transcription.horizon(x) / guess;
    let elapsed = x[ramp.clock] - transcription.task.start.time;
    (length, count * elapsed / guess - ramp.interval * length)
}

/// How far the control is from the node before, and the node behind.
fn differences(ramp: &Ramp, x: &[f64]) -> (f64, f64) {
    let [before, after] = ramp.nodes.map(|node| x[node]);
    (x[ramp.control] - before, after - before)
}

/// Writes the rows.
pub(super) fn write_rows(transcription: &Transcription<'_>, x: &[f64], c: &mut [f64]) {
    for ramp in &transcription.ramps {
        let (length, past) = lengths(ramp, transcription, x);
        let (own, all) = differences(ramp, x);
        c[ramp.row] = length * own - all * past;
    }
}

/// Entries of the Jacobian of the rows, always in the same order.
pub(super) fn add_jacobian(
    transcription: &Transcription<'_>,
    x: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let guess = transcription.task.horizon;
    let count = transcription.task.intervals as f64;
    for ramp in &transcription.ramps {
        let (length, past) = lengths(ramp, transcription, x);
        let (own, all) = differences(ramp, x);
        add(ramp.row, ramp.control, length);
        add(ramp.row, ramp.nodes[0], past - length);
        add(ramp.row, ramp.nodes[1], -past);
        add(ramp.row, ramp.clock, -count * all / guess);
        if let Some(horizon) = transcription.horizon {
            add(ramp.row, horizon, (own + ramp.interval * all) / guess);
        }
    }
}

/// Entries of the Hessian of the weighted rows, always in the same order.
pub(super) fn add_hessian(
    transcription: &Transcription<'_>,
    multipliers: &[f64],
    add: &mut dyn FnMut(usize, usize, f64),
) {
    let guess = transcription.task.horizon;
    let count = transcription.task.intervals as f64;
    for ramp in &transcription.ramps {
        let weight = multipliers[ramp.row] / guess;
        let [before, after] = ramp.nodes;
        add(ramp.clock, before, count * weight);
        add(ramp.clock, after, -count * weight);
        if let Some(horizon) = transcription.horizon {
            add(ramp.control, horizon, weight);
            add(before, horizon, -(1.0 + ramp.interval) * weight);
            add(after, horizon, ramp.interval * weight);
        }
    }
}

/// Gives the controls of all blocks the values that nodes and clocks ask for.
pub(super) fn set_controls(transcription: &Transcription<'_>, x: &mut [f64]) {
    for ramp in &transcription.ramps {
        let (length, past) = lengths(ramp, transcription, x);
        let (_, all) = differences(ramp, x);
        x[ramp.control] = x[ramp.nodes[0]] + all * past / length;
    }
}

/// The control whose row that is.
pub(super) fn control_of_row(transcription: &Transcription<'_>, row: usize) -> Option<usize> {
    let mut ramps = transcription.ramps.iter();
    let ramp = ramps.find(|ramp| ramp.row == row)?;
    Some(ramp.control)
}
