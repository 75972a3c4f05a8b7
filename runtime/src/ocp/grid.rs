//! Refinement of the grid: more elements in the intervals over which a plan departs from the motion.
//!
//! The error of an interval is the distance between plan and event-driven simulation at its end, where both start from
//! the same state. What errors grow to until the end is not known beforehand, but the re-simulation shows how much
//! larger than their sum its distance is.

use super::confirm::largest_difference;
use super::path::Path;
use super::search::Search;
use crate::simulation::{EventDriven, Simulator as _};

/// Rounds in which the grid is refined.
pub(super) const ROUNDS: usize = 4;
/// Most elements of a phase.
const MOST_ELEMENTS: usize = 64;
/// Largest growth of the number of elements in a round: far from its end the order of the scheme promises too much.
const MOST_GROWTH: f64 = 4.0;
/// Share of the allowed distance that the refined intervals aim for.
const AIM: f64 = 0.5;

impl Search<'_, '_> {
    /// Divides the elements of the intervals whose errors are too large for a distance within the allowed one, where the
    /// re-simulation ends at `distance` from the plan; says whether there are any.
    pub(super) fn refine_grid(&mut self, path: &Path, distance: f64) -> bool {
        let intervals = self.setting.problem.intervals;
        let errors = if self.setting.model.declaration().explicit_time {
            // A simulation cannot start at another time than 0: all intervals share the distance.
            vec![distance / intervals as f64; intervals]
        } else {
            self.errors(path)
        };
        let sum: f64 = errors.iter().sum();
        let growth = distance / sum;
        let growth = if growth.is_finite() {
            growth.max(1.0)
        } else {
            1.0
        };
        let allowed = AIM * self.settings.largest_distance / (growth * intervals as f64);
        let order = (2 * self.setting.tableau.stages() - 1) as f64;
        let mut refined = false;
        for (elements, error) in self.elements.iter_mut().zip(errors) {
            let wanted = (error / allowed).powf(1.0 / order).ceil();
            let wanted = wanted.clamp(1.0, MOST_GROWTH) as usize;
            let more = (*elements * wanted).min(MOST_ELEMENTS.max(*elements));
            refined |= more > *elements;
            *elements = more;
        }
        refined
    }

    /// The error of each interval.
    fn errors(&self, path: &Path) -> Vec<f64> {
        let problem = self.setting.problem;
        let (n, intervals) = (problem.q.len(), problem.intervals);
        let length = path.horizon / intervals as f64;
        let simulator = EventDriven {
            tolerance: self.settings.resimulation_tolerance,
            output_times: 1,
            ..EventDriven::default()
        };
        (0..intervals)
            .map(|k| {
                let start = path.at(k as f64 * length, true);
                let end = path.at((k + 1) as f64 * length, false);
                let controls = path.controls.signal_of(k, length);
                let motion = problem.initial_value_problem(&start[..2 * n], length, controls);
                // A start that rounding puts below a surface tells nothing about the accuracy.
                let simulation = simulator.simulate(self.setting.model, &motion, &mut |_| true);
                let reached = simulation.ok().and_then(|mut s| s.trajectory.q.pop());
                reached.map_or(0.0, |reached| largest_difference(&reached, &end[..n]))
            })
            .collect()
    }
}
