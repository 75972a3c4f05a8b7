//! What stays the same over all contact sequences on a grid.

use crate::model::{Model, contact_point, tangent_point};
use crate::ocp::motion::control_grid::ControlShape;
use crate::ocp::motion::final_times::FinalTimes;
use crate::ocp::motion::mode::is_frictional;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::Problem;
use crate::ocp::program::units::Units;
use crate::ocp::settings::Settings;
use crate::rk::ButcherTableau;

/// Everything that stays the same over all sequences.
#[derive(Clone, Copy)]
pub(in crate::ocp) struct Setting<'a> {
    pub(in crate::ocp) model: &'a dyn Model,
    pub(in crate::ocp) problem: &'a Problem,
    pub(in crate::ocp) tableau: &'a ButcherTableau,
    pub(in crate::ocp) units: &'a Units,
    pub(in crate::ocp) bounds: (&'a [f64], &'a [f64]),
    /// Whether each coordinate is a parabola on each interval.
    pub(in crate::ocp) parabolas: &'a [bool],
    pub(in crate::ocp) shape: ControlShape,
    pub(in crate::ocp) lengths: Lengths<'a>,
    /// Sizes of the goals, where these may be missed at a price: [`Collocation::penalize`](super::program::Collocation::penalize).
    pub(in crate::ocp) elastic: Option<&'a [f64]>,
    /// Distances that the method keeps by itself, shortest phases and least impacts, as a share of the usual ones.
    pub(in crate::ocp) kept: f64,
    /// Price of a longer motion: [`Settings::haste`].
    pub(in crate::ocp) haste: f64,
    /// Finite elements that are not all of the same length.
    pub(in crate::ocp) mesh: Option<&'a [Vec<f64>]>,
}

impl<'a> Setting<'a> {
    /// A grid as the settings ask for it, with intervals of equal length and all distances that the method keeps.
    pub(in crate::ocp) fn new(
        (model, problem): (&'a dyn Model, &'a Problem),
        settings: &Settings,
        (tableau, units): (&'a ButcherTableau, &'a Units),
        (bounds, parabolas): ((&'a [f64], &'a [f64]), &'a [bool]),
    ) -> Self {
        Self {
            model,
            problem,
            tableau,
            units,
            bounds,
            parabolas,
            shape: settings.controls,
            lengths: Lengths::Equal,
            elastic: None,
            kept: 1.0,
            haste: settings.haste,
            mesh: None,
        }
    }

    /// Ends of the finite elements of a phase in an interval, so many, as shares of its length.
    pub(in crate::ocp) fn ends(&self, interval: usize, elements: usize) -> Vec<f64> {
        match self.mesh {
            Some(mesh) => mesh[interval].clone(),
            None => (1..=elements).map(|e| e as f64 / elements as f64).collect(),
        }
    }

    /// Largest distance between a plan and its re-simulation that is let pass in any coordinate.
    pub(in crate::ocp) fn largest_distance(&self, settings: &Settings, plan: &Trajectory) -> f64 {
        let shares = self.units.shares_of_distances(plan).into_iter();
        settings.largest_distance * shares.reduce(f64::min).unwrap_or(1.0)
    }

    /// Distance of two final states of a plan, as one of a plan whose lengths are of the order of the units of the scene.
    pub(in crate::ocp) fn departure(&self, plan: &Trajectory, a: &[f64], b: &[f64]) -> f64 {
        let shares = self.units.shares_of_distances(plan).into_iter();
        let parts = shares.zip(a.iter().zip(b));
        let parts = parts.map(|(share, (a, b))| (a - b).abs() / share);
        parts.fold(0.0, f64::max)
    }

    /// The final times that its programs look at.
    pub(in crate::ocp) fn final_times(&self) -> FinalTimes {
        FinalTimes::around(self.problem, self.units.time)
    }
}

/// Lengths of the control intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::ocp) enum Lengths<'a> {
    /// One length for all.
    Equal,
    /// Each one free, so that switches may be at any time; of constant controls, with bounds of coordinates at nodes.
    Free,
    /// Those of a phase between two switches make it up, and the phases make up the motion.
    Phases(&'a [Span]),
}

/// The control intervals between two switches of a motion whose switches may be at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::ocp) struct Span {
    /// Number of intervals.
    pub(in crate::ocp) pieces: usize,
    /// Whether each of them has a length of its own; else they divide the phase evenly.
    pub(in crate::ocp) free: bool,
    /// When it begins and ends in the guess \[s\].
    pub(in crate::ocp) from: f64,
    pub(in crate::ocp) to: f64,
    /// Its length to start with \[s\].
    pub(in crate::ocp) duration: f64,
    /// Finite elements of each interval.
    pub(in crate::ocp) elements: usize,
    /// Largest share of the motion that the length of an interval of its own may be.
    pub(in crate::ocp) longest: Option<f64>,
}

impl<'a> Lengths<'a> {
    /// Whether phases have control intervals of their own.
    pub(in crate::ocp) fn are_of_phases(self) -> bool {
        matches!(self, Self::Phases(_))
    }

    /// The phase that an interval belongs to, and its place there.
    pub(in crate::ocp) fn span(self, interval: usize) -> Option<(&'a Span, usize)> {
        let Self::Phases(spans) = self else {
            return None;
        };
        let mut first = 0;
        spans.iter().find_map(|span| {
            let place = interval.checked_sub(first)?;
            first += span.pieces;
            (place < span.pieces).then_some((span, place))
        })
    }
}

/// Which coordinates are parabolas while the controls are constant: their acceleration is affine in the
/// controls alone, and no contact acts on them.
pub(in crate::ocp) fn parabolas(model: &dyn Model, start: &[f64]) -> Vec<bool> {
    let declaration = model.declaration();
    let n = declaration.coordinates.len();
    let mut x = start.to_vec();
    x.resize(declaration.inputs(), 0.0);
    let mut point = vec![0.0; contact_point::length(n)];
    let mut tangent = vec![0.0; tangent_point::length(n)];
    let places = 2 * n..2 * n + declaration.controls.len();
    let controls = |column: u32| places.contains(&(column as usize));
    let affine = !declaration
        .free_hessian
        .entries
        .iter()
        .any(|&(i, j)| controls(i) && controls(j));
    (0..n)
        .map(|k| {
            let mut jacobian = declaration.free_jacobian.entries.iter();
            let free = jacobian.all(|&(row, column)| row as usize != k || controls(column));
            let pushed = declaration.contacts.iter().enumerate().any(|(i, contact)| {
                model.contact(i, &x, &mut point);
                let mut entries = contact.jacobian.entries.iter();
                let friction = contact.friction.filter(|_| is_frictional(model, i));
                let dragged = friction.is_some_and(|friction| {
                    model.tangent(i, &x, &mut tangent);
                    let mut entries = friction.jacobian.entries.iter();
                    tangent[tangent_point::direction(n) + k] != 0.0
                        || entries.any(|&(row, _)| row as usize == 1 + k)
                });
                dragged
                    || point[contact_point::direction(n) + k] != 0.0
                    || entries.any(|&(row, _)| row as usize == 2 + k)
            });
            let terms = declaration
                .optimal_control
                .map(|declared| declared.contacts);
            let mut resets = terms.iter().flat_map(|terms| terms.resets);
            let set = resets.any(|&(_, velocity)| velocity == k);
            affine && free && !pushed && !set
        })
        .collect()
}
