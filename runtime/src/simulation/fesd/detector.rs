//! The samples of an element's dense output on which sign conditions are checked.

use super::switch::{Switch, SwitchKind};
use crate::fesd::contact_size::ContactSize;
use crate::fesd::finite_element::FiniteElement;
use crate::model::{Model, Pieces};
use crate::rk::ButcherTableau;

/// Checks the sign conditions on a fixed grid of the element's dense output.
pub(super) struct Detector<'a> {
    pub(super) model: &'a dyn Model,
    pub(super) tableau: &'a ButcherTableau,
    /// Which pieces of surfaces with edges act.
    pub(super) pieces: Pieces,
    /// Sampled places `0 < theta <= 1`.
    pub(super) thetas: Vec<f64>,
    /// Dense output weights, one row a sample.
    pub(super) weights: Vec<f64>,
    pub(super) scratch: Vec<f64>,
    pub(super) x: Vec<f64>,
    /// Input vectors at the last two samples.
    samples: [Vec<f64>; 2],
    pub(super) forces: Vec<f64>,
    /// Normal forces of held contacts at the start and at all samples, a row for each contact.
    pub(super) normal_forces: Vec<f64>,
    /// Gaps at the start and all samples, one row a contact.
    pub(super) gaps: Vec<f64>,
    pub(super) open: Vec<usize>,
    /// Sizes of gaps and velocities of all contacts at the start.
    pub(super) sizes: Vec<ContactSize>,
    /// Largest gap of an active contact between the stages, as a share of what the motion has made of it; 0 where nobody
    /// asks for it.
    pub(super) drift: f64,
    /// Of active contacts with friction at the start and all samples, one row a contact: what the friction of
    /// a sticking one lacks to its bound, or the sliding velocity in the sense of the slip.
    pub(super) frictions: Vec<f64>,
}

impl<'a> Detector<'a> {
    pub(super) fn new(model: &'a dyn Model, tableau: &'a ButcherTableau) -> Self {
        let declaration = model.declaration();
        let contacts = declaration.contacts.len();
        let stages = tableau.stages();
        let samples = (2 * stages).max(8);
        let thetas: Vec<f64> = (1..=samples).map(|k| k as f64 / samples as f64).collect();
        let mut weights = vec![0.0; samples * stages];
        for (row, &theta) in weights.chunks_exact_mut(stages).zip(&thetas) {
            tableau.dense_weights(theta, row);
        }
        Self {
            model,
            tableau,
            pieces: Pieces::default(),
            thetas,
            weights,
            scratch: vec![0.0; stages],
            x: vec![0.0; declaration.inputs()],
            samples: [(); 2].map(|()| vec![0.0; declaration.inputs()]),
            // A normal force, and two of a contact in space that sticks.
            forces: vec![0.0; 3 * contacts],
            normal_forces: vec![0.0; contacts * (samples + 1)],
            gaps: vec![0.0; contacts * (samples + 1)],
            open: Vec::with_capacity(contacts),
            sizes: vec![ContactSize::default(); contacts],
            drift: 0.0,
            frictions: vec![0.0; contacts * (samples + 1)],
        }
    }

    pub(super) fn interpolate(&mut self, element: &FiniteElement<'_>, k: usize) {
        let stages = self.tableau.stages();
        let weights = &self.weights[k * stages..(k + 1) * stages];
        element.interpolate(self.thetas[k], weights, &mut self.x);
    }

    /// Begins with the input vector at the start of an element as the sample before the first one.
    pub(super) fn begin(&mut self, x: &[f64]) {
        self.samples[1].copy_from_slice(x);
    }

    /// Keeps the present input vector as the last sample.
    pub(super) fn keep_sample(&mut self) {
        self.samples.swap(0, 1);
        self.samples[1].copy_from_slice(&self.x);
    }

    /// The input vector at this share of the time `width` between the last two samples: coordinates by the cubic that has
    /// their velocities, the rest by straight lines.
    pub(super) fn place_between_samples(&mut self, share: f64, width: f64) {
        let n = self.model.declaration().coordinates.len();
        let [from, to] = &self.samples;
        let rest = 1.0 - share;
        for (x, (from, to)) in self.x.iter_mut().zip(from.iter().zip(to)) {
            *x = rest * from + share * to;
        }
        for k in 0..n {
            let (way, slopes) = (to[k] - from[k], (width * from[n + k], width * to[n + k]));
            self.x[k] += share * rest * (rest * (slopes.0 - way) - share * (slopes.1 - way));
        }
    }

    /// Gap of a contact at a place of the dense output.
    pub(super) fn gap_at(
        &mut self,
        element: &FiniteElement<'_>,
        contact: usize,
        theta: f64,
    ) -> f64 {
        self.tableau.dense_weights(theta, &mut self.scratch);
        element.interpolate(theta, &self.scratch, &mut self.x);
        self.pieces.gap(self.model, contact, &self.x)
    }

    /// Place of the sample before `k`.
    pub(super) fn left(&self, k: usize) -> f64 {
        if k == 0 { 0.0 } else { self.thetas[k - 1] }
    }

    /// Linear estimate of a root between samples `k - 1` and `k` from the values there.
    pub(super) fn between(
        &self,
        kind: SwitchKind,
        contact: usize,
        element: &FiniteElement<'_>,
        k: usize,
        before: f64,
        after: f64,
    ) -> Switch {
        let left = self.left(k);
        let width = self.thetas[k] - left;
        Switch {
            kind,
            contact,
            theta: left + before / (before - after) * width,
            violated: self.thetas[k],
            slope: (after - before) / (width * element.length()),
        }
    }
}
