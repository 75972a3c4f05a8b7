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

use super::{Block, Interval, Transcription};

/// A control at a block.
#[derive(Clone)]
pub(super) struct Ramp {
    pub(super) row: usize,
    /// Its variable, and those of the nodes before and after it.
    pub(super) control: usize,
    nodes: [usize; 2],
    clock: usize,
    /// Interval, which is the number of the node before it.
    interval: f64,
}

impl Ramp {
    /// The ramps of a block of interval `k`, their rows from `first` on; none where controls are constant or given.
    pub(super) fn of(
        block: &Block,
        (states, time): (usize, usize),
        (k, interval): (usize, &Interval),
        first: usize,
    ) -> Vec<Self> {
        let nodes = interval.controls.iter().zip(&interval.ends);
        let controls = block.variables[states..].iter();
        let ramps = controls.zip(nodes).zip(first..);
        let ramp = |((&control, (&before, &after)), row)| {
            Some(Self {
                row,
                control: control?,
                nodes: [before, after],
                clock: block.variables[time]?,
                interval: k as f64,
            })
        };
        ramps.filter_map(ramp).collect()
    }

    /// Length of the motion, and how far the clock is past the node before, both over the guess of the length, the second one
    /// in intervals times the length.
    fn lengths(&self, transcription: &Transcription<'_>, x: &[f64]) -> (f64, f64) {
        let guess = transcription.task.horizon;
        let count = transcription.task.intervals as f64;
        let length = transcription.horizon(x) / guess;
        let elapsed = x[self.clock] - transcription.task.start.time;
        (length, count * elapsed / guess - self.interval * length)
    }

    fn differences(&self, x: &[f64]) -> (f64, f64) {
        let [before, after] = self.nodes.map(|node| x[node]);
        (x[self.control] - before, after - before)
    }
}

/// Writes the rows.
pub(super) fn write_rows(transcription: &Transcription<'_>, x: &[f64], c: &mut [f64]) {
    for ramp in &transcription.ramps {
        let (length, past) = ramp.lengths(transcription, x);
        let (own, all) = ramp.differences(x);
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
        let (length, past) = ramp.lengths(transcription, x);
        let (own, all) = ramp.differences(x);
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
        let (length, past) = ramp.lengths(transcription, x);
        let (_, all) = ramp.differences(x);
        x[ramp.control] = x[ramp.nodes[0]] + all * past / length;
    }
}

/// The control whose row that is.
pub(super) fn control_of_row(transcription: &Transcription<'_>, row: usize) -> Option<usize> {
    let mut ramps = transcription.ramps.iter();
    let ramp = ramps.find(|ramp| ramp.row == row)?;
    Some(ramp.control)
}
