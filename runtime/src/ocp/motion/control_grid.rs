//! Controls over the intervals of a motion, of equal length as a rule: constant on each, or linear between nodes.

use crate::simulation::ControlSignal;

/// Controls on the intervals of a problem.
///
/// ```
/// use hangtime::prelude::*;
///
/// # hangtime::model! {
/// #     /// A cart that is pushed to 1 m.
/// #     pub Cart {
/// #         parameters { m: kg = 2 }
/// #         coordinates { y: m }
/// #         controls { u: N in -1..=1 }
/// #         lagrangian m/2*dot(y)^2
/// #         forces { y: u }
/// #         minimize time
/// #         finally { y == 1[m] }
/// #     }
/// # }
/// let cart = Cart::default();
/// let solution = solve(&cart).intervals(4).controls(ControlShape::Linear).run()?;
/// // One value a node.
/// assert_eq!(solution.controls.len(), 5);
/// # Ok::<(), InputError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ControlShape {
    /// Constant on each interval; they may jump between intervals.
    #[default]
    Constant,
    /// Linear on each interval and continuous over the ends of the intervals: one value a node, one node more than
    /// intervals. Bounds at the nodes hold everywhere. The contact sequence is looked for with constant controls.
    Linear,
}

impl ControlShape {
    /// Name used on the command line and in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
        }
    }
}

/// Ends of the finite elements of a phase in each interval, as shares of its length.
pub(in crate::ocp) type Mesh = Vec<Vec<f64>>;

/// Controls as a function of time, in units of intervals.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::ocp) struct ControlGrid {
    pub(in crate::ocp) shape: ControlShape,
    /// One vector an interval, or one more where they are linear.
    values: Vec<Vec<f64>>,
    /// Where intervals begin and the last one ends, as shares of the motion; without them all are of equal length.
    nodes: Option<Vec<f64>>,
}

impl ControlGrid {
    /// At least one interval.
    pub(in crate::ocp) fn new(shape: ControlShape, values: Vec<Vec<f64>>) -> Self {
        Self {
            shape,
            values,
            nodes: None,
        }
    }

    /// These controls on intervals that begin at these shares of the motion, the last of them its end.
    pub(in crate::ocp) fn with_nodes(self, nodes: Vec<f64>) -> Self {
        Self {
            nodes: Some(nodes),
            ..self
        }
    }

    /// Whether its intervals are divided among phases instead of being of equal length.
    pub(in crate::ocp) fn is_aligned(&self) -> bool {
        self.nodes.is_some() && self.intervals() > 1
    }

    /// The same controls with each interval of constant ones divided into so many.
    pub(in crate::ocp) fn divided(&self, parts: usize) -> Self {
        let nodes = self.nodes.as_ref().map(|nodes| {
            let ends = nodes.windows(2).flat_map(|ends| {
                let part = (ends[1] - ends[0]) / parts as f64;
                (0..parts).map(move |k| ends[0] + k as f64 * part)
            });
            ends.chain(nodes.last().copied()).collect()
        });
        let values = self.values.iter();
        Self {
            shape: self.shape,
            values: values
                .flat_map(|u| std::iter::repeat_n(u.clone(), parts))
                .collect(),
            nodes,
        }
    }

    /// When each interval begins and the last one ends, of a motion of that length \[s\].
    pub(in crate::ocp) fn times(&self, horizon: f64) -> Vec<f64> {
        match &self.nodes {
            Some(nodes) => nodes.iter().map(|share| horizon * share).collect(),
            None => equal_times(self.intervals(), horizon),
        }
    }

    /// Constant on each interval.
    pub(in crate::ocp) fn constant(values: Vec<Vec<f64>>) -> Self {
        Self::new(ControlShape::Constant, values)
    }

    /// Values of the intervals, or at the nodes.
    pub(in crate::ocp) fn values(&self) -> &[Vec<f64>] {
        &self.values
    }

    pub(in crate::ocp) fn intervals(&self) -> usize {
        match self.shape {
            ControlShape::Constant => self.values.len(),
            ControlShape::Linear => self.values.len() - 1,
        }
    }

    /// Controls right after the start.
    pub(in crate::ocp) fn start(&self) -> &[f64] {
        &self.values[0]
    }

    /// The interval at `place`, in units of intervals of equal length, on the later side of an end.
    pub(in crate::ocp) fn interval_at(&self, place: f64) -> usize {
        let share = place / self.intervals() as f64;
        let interval = match &self.nodes {
            None => place.max(0.0) as usize,
            Some(nodes) => nodes.partition_point(|node| *node <= share).max(1) - 1,
        };
        interval.min(self.intervals() - 1)
    }

    /// Controls at such a place, on the later side of a jump.
    pub(in crate::ocp) fn at(&self, place: f64) -> Vec<f64> {
        self.within(self.interval_at(place), place)
    }

    /// Controls at a place of that interval, at its end on the earlier side of a jump.
    pub(in crate::ocp) fn within(&self, interval: usize, place: f64) -> Vec<f64> {
        match self.shape {
            ControlShape::Constant => self.values[interval].clone(),
            ControlShape::Linear => {
                let share = (place - interval as f64).clamp(0.0, 1.0);
                let ends = self.values[interval].iter().zip(&self.values[interval + 1]);
                ends.map(|(from, to)| from + share * (to - from)).collect()
            }
        }
    }

    /// The controls in another shape, on another number of intervals: those at the middle of each interval, or at the
    /// nodes, where a jump is met halfway.
    pub(in crate::ocp) fn resampled(&self, shape: ControlShape, intervals: usize) -> Self {
        let equal = self.nodes.is_none();
        if equal && shape == self.shape && intervals == self.intervals() {
            return self.clone();
        }
        let length = self.intervals() as f64 / intervals as f64;
        let middle = |k: usize| self.at((k as f64 + 0.5) * length);
        let values = match (shape, self.shape) {
            (ControlShape::Constant, _) => (0..intervals).map(middle).collect(),
            (ControlShape::Linear, ControlShape::Linear) => (0..=intervals)
                .map(|node| self.at(node as f64 * length))
                .collect(),
            (ControlShape::Linear, ControlShape::Constant) => (0..=intervals)
                .map(|node| {
                    let before = middle(node.max(1) - 1);
                    let after = middle(node.min(intervals - 1));
                    let sides = before.iter().zip(&after);
                    sides
                        .map(|(before, after)| 0.5 * (before + after))
                        .collect()
                })
                .collect(),
        };
        Self::new(shape, values)
    }

    /// The controls as a signal over `horizon`.
    pub(in crate::ocp) fn signal(&self, horizon: f64) -> ControlSignal {
        signal(self.shape, self.times(horizon), self.values.clone())
    }

    /// The controls of one interval as a signal that starts with it.
    pub(in crate::ocp) fn signal_of(&self, interval: usize, length: f64) -> ControlSignal {
        let count = match self.shape {
            ControlShape::Constant => 1,
            ControlShape::Linear => 2,
        };
        let values = self.values[interval..interval + count].to_vec();
        signal(self.shape, equal_times(1, length), values)
    }
}

/// When intervals of equal length begin and the last one ends \[s\].
fn equal_times(intervals: usize, horizon: f64) -> Vec<f64> {
    let time = |k: usize| match k == intervals {
        true => horizon,
        false => horizon * k as f64 / intervals as f64,
    };
    (0..=intervals).map(time).collect()
}

/// The signal of controls on intervals between these times \[s\], of which the last is no beginning of one.
pub(in crate::ocp) fn signal(
    shape: ControlShape,
    mut times: Vec<f64>,
    values: Vec<Vec<f64>>,
) -> ControlSignal {
    times.truncate(values.len());
    match shape {
        ControlShape::Constant => ControlSignal::PiecewiseConstant { times, values },
        ControlShape::Linear => ControlSignal::PiecewiseLinear { times, values },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(shape: ControlShape, values: &[f64]) -> ControlGrid {
        ControlGrid::new(shape, values.iter().map(|&u| vec![u]).collect())
    }

    #[test]
    fn grid_in_another_shape_keeps_what_both_can_express() {
        use ControlShape::{Constant, Linear};
        let steps = grid(Constant, &[1.0, 3.0]);
        assert_eq!(steps.resampled(Linear, 2), grid(Linear, &[1.0, 2.0, 3.0]));
        assert_eq!(
            steps.resampled(Constant, 4),
            grid(Constant, &[1.0, 1.0, 3.0, 3.0])
        );
        let ramp = grid(Linear, &[1.0, 3.0]);
        assert_eq!(ramp.resampled(Linear, 2), grid(Linear, &[1.0, 2.0, 3.0]));
        assert_eq!(ramp.resampled(Constant, 2), grid(Constant, &[1.5, 2.5]));
        assert_eq!(ramp.resampled(Linear, 1), ramp);
        assert_eq!(ramp.at(5.0), [3.0]);
    }

    #[test]
    fn controls_of_one_interval_as_a_signal_start_with_it() {
        let ramp = grid(ControlShape::Linear, &[1.0, 3.0, 2.0]);
        let signal = ramp.signal_of(1, 0.5);
        let mut u = [0.0];
        for (time, expected) in [(0.0, 3.0), (0.25, 2.5), (0.5, 2.0)] {
            signal.write(time, &mut u).expect("a full signal");
            assert_eq!(u, [expected], "{time}");
        }
        let steps = grid(ControlShape::Constant, &[1.0, 3.0]);
        steps
            .signal_of(1, 0.5)
            .write(0.1, &mut u)
            .expect("a full signal");
        assert_eq!(u, [3.0]);
    }

    #[test]
    fn controls_at_a_jump_are_those_after_it_and_stay_within_the_motion() {
        let steps = grid(ControlShape::Constant, &[1.0, 3.0]);
        let at: Vec<f64> = [-1.0, 0.0, 0.999, 1.0, 2.0, 7.0]
            .iter()
            .map(|&place| steps.at(place)[0])
            .collect();
        assert_eq!(at, [1.0, 1.0, 1.0, 3.0, 3.0, 3.0]);
    }
}
