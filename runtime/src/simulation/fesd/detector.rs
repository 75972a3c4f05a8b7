//! The samples of an element's dense output on which sign conditions are checked.

use super::stop::Stop;
use super::switch::{ElementStart, Switch, SwitchKind};
use crate::contact::ActiveContact;
use crate::enclosure::{
    Along, Crossing, Form, Interpolated, Sample, Watched, positive_before, root,
};
use crate::fesd::contact_size::ContactSize;
use crate::fesd::contacts::Contacts;
use crate::fesd::finite_element::FiniteElement;
use crate::model::{Model, Pieces};
use crate::rk::ButcherTableau;
use std::collections::BTreeSet;

/// Checks the sign conditions on a fixed grid of the element's dense output.
// Many fields: buffers of one element.
pub(super) struct Detector<'a> {
    pub(super) model: &'a dyn Model,
    pub(super) tableau: &'a ButcherTableau,
    /// Explicit functions on the dense output.
    pub(super) along: Along<'a>,
    /// Functions that were looked at by some of their values.
    pub(super) interpolated: BTreeSet<Interpolated>,
    /// Contacts of which bounds tell that they slide in their sense all along the element.
    pub(super) steady: Vec<bool>,
    /// Which pieces of surfaces with edges act.
    pub(super) pieces: Pieces,
    /// Sampled places `0 < theta <= 1`.
    pub(super) thetas: Vec<f64>,
    /// Dense output weights, one row a sample.
    pub(super) weights: Vec<f64>,
    pub(super) scratch: Vec<f64>,
    pub(super) x: Vec<f64>,
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
            along: Along::new(model, tableau.stages() + 1),
            interpolated: BTreeSet::new(),
            steady: vec![false; contacts],
            pieces: Pieces::default(),
            thetas,
            weights,
            scratch: vec![0.0; stages],
            x: vec![0.0; declaration.inputs()],
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

    /// Takes up the dense output of an element from this input vector and time on.
    pub(super) fn enclose(&mut self, element: &FiniteElement<'_>, start: &ElementStart<'_>) {
        let n = self.model.declaration().coordinates.len();
        self.along.begin(start.time, element.length(), &self.pieces);
        for end in [0, 1] {
            let controls = self.along.controls_at(end);
            controls.copy_from_slice(&start.x[2 * n..][..controls.len()]);
        }
        let (tableau, scratch, x) = (self.tableau, &mut self.scratch, &mut self.x);
        self.along.follow(|theta, out| {
            tableau.dense_weights(theta, scratch);
            element.interpolate(theta, scratch, x);
            out.copy_from_slice(&x[..2 * n]);
        });
    }

    /// Whether bounds tell that the gap of a contact is nowhere below `-zero` in the element.
    pub(super) fn stays_open(&mut self, contact: usize, zero: f64) -> bool {
        self.along.knows_gap(contact) && self.along.gap(contact, [0.0, 1.0]).low >= -zero
    }

    /// Tells which active contacts slide in their sense all along the element.
    pub(super) fn tell_steady(&mut self, active: &[ActiveContact]) {
        self.steady.fill(false);
        for held in active.iter().filter(|held| held.state.sense() != 0.0) {
            let i = held.contact;
            let zero = self.sizes[i].sliding_rounding();
            let range = self.along.sliding(i, [0.0, 1.0]);
            self.steady[i] = range.scaled(held.state.sense()).low >= -zero;
        }
    }

    /// Takes note of the functions of a mode that are looked at by some of their values.
    pub(super) fn note(&mut self, active: &[ActiveContact]) {
        for held in active {
            let i = held.contact;
            let declared = &self.model.declaration().contacts[i];
            if !declared.dry {
                self.interpolated.insert(Interpolated::Force(i));
            }
            if declared.friction.is_some() && held.state.sticks() {
                self.interpolated.insert(Interpolated::Friction(i));
            } else if declared.friction.is_some() && !self.along.knows_sliding(i) {
                self.interpolated.insert(Interpolated::Sliding(i));
            }
        }
        for &i in &self.open {
            if !self.along.knows_gap(i) {
                self.interpolated.insert(Interpolated::Gap(i));
            }
        }
    }

    /// Where the gap or the sliding velocity of a contact, in this `sense`, first falls below zero between samples `k - 1` and `k`, with
    /// these values there, after it has been positive.
    pub(super) fn falls(
        &mut self,
        (element, contacts): (&FiniteElement<'_>, &mut Contacts<'_>),
        (kind, contact, sense): (SwitchKind, usize, f64),
        k: usize,
        (before, after): (f64, f64),
    ) -> Result<Option<Switch>, Stop> {
        let ends = [(self.left(k), before), (self.thetas[k], after)];
        let [from, to] = ends.map(|(at, value)| Sample { at, value });
        let size = self.sizes[contact];
        let (watched, zero) = match kind {
            SwitchKind::Stopping => {
                let form = Form::Signed(sense);
                (Watched::Sliding(contact, form), size.sliding_rounding())
            }
            _ => (Watched::Gap(contact), size.gap_rounding()),
        };
        let (tableau, scratch, x) = (self.tableau, &mut self.scratch, &mut self.x);
        let (pieces, model) = (&self.pieces, self.model);
        let mut value = |theta: f64| {
            tableau.dense_weights(theta, scratch);
            element.interpolate(theta, scratch, x);
            if kind == SwitchKind::Stopping {
                contacts.evaluate_contacts(x, [contact]);
                sense * contacts.sliding_velocity(contact)
            } else {
                pieces.gap(model, contact, x)
            }
        };
        let zero = zero.max(-2.0 * before);
        let (left, right) = match watched.first_fall(&mut self.along, &mut value, (from, to), zero)
        {
            Crossing::Nowhere => return Ok(None),
            Crossing::Undecided => return Err(Stop::Unresolved),
            Crossing::Between(left, right) => (left, right),
        };
        // What sinks from its start on is not known to have been positive.
        let left = positive_before(&mut value, from, left, right, zero);
        if left.value <= zero {
            return Ok(None);
        }
        let theta = root(&mut value, left, right);
        Ok(Some(Switch {
            kind,
            contact,
            theta,
            violated: right.at,
            slope: (right.value - left.value) / ((right.at - left.at) * element.length()),
        }))
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
