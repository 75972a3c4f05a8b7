//! Detection of the first violated sign condition inside a solved element.
//!
//! The switching functions are those of the time-freezing system: an open contact closes when its gap
//! falls through zero, or, after a release, when `max(g, v_n)` falls below zero (the region `g < 0 < v_n`
//! still carries the free dynamics); an active one opens when its force does. A sticking contact slips when
//! its friction reaches the bound `mu r`, and one that slides stops when its sliding velocity vanishes.

use super::driver::Stop;
use crate::fesd::active_contact::{find, force_count};
use crate::fesd::contact_size::ContactSize;
use crate::fesd::contacts::{Contacts, ModeError};
use crate::fesd::finite_element::{ElementError, FiniteElement};
use crate::model::Model;
use crate::rk::ButcherTableau;

/// Share of the way in an element below which a penetration after a release may be its local error.
const DEEP: f64 = 1e-3;
/// Share of a gap that the cubic through neighbouring samples may miss.
const RESOLVED: f64 = 0.05;

/// Relative size of a negative normal contact acceleration that is rounding error.
pub(super) const FORCE_TOLERANCE: f64 = 1e-12;

/// Which sign condition ends the element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SwitchKind {
    /// The gap of an open contact closes.
    Entry,
    /// A contact that was released closes again: `max(g, v_n)` falls below zero.
    Reentry,
    /// The force of an active contact vanishes.
    Exit,
    /// The friction of a sticking contact reaches its bound.
    Slipping,
    /// The sliding velocity of an active contact vanishes.
    Stopping,
}

/// A violated sign condition and where the dense output puts its root.
#[derive(Debug, Clone, Copy)]
pub(super) struct Switch {
    pub(super) kind: SwitchKind,
    pub(super) contact: usize,
    /// Place in the element, `0..=1`.
    pub(super) theta: f64,
    /// Place at which the condition is known to be violated.
    pub(super) violated: f64,
    /// Slope of the switching function with respect to time at the root.
    pub(super) slope: f64,
}

/// What the detector knows of the element's start.
pub(super) struct ElementStart<'a> {
    /// Input vector at the start.
    pub(super) x: &'a [f64],
    /// Gaps of all contacts.
    pub(super) gaps: &'a [f64],
    /// Normal velocities of all contacts.
    pub(super) velocities: &'a [f64],
    /// Sliding velocities of all contacts.
    pub(super) sliding: &'a [f64],
    /// Forces of the active contacts: `r` of each, then `s` of those that stick.
    pub(super) forces: &'a [f64],
    /// Acceleration with contact forces.
    pub(super) acceleration: &'a [f64],
    /// Time [s].
    pub(super) time: f64,
}

/// Checks the sign conditions on a fixed grid of the element's dense output.
pub(super) struct Detector<'a> {
    model: &'a dyn Model,
    pub(super) tableau: &'a ButcherTableau,
    /// Sampled places `0 < theta <= 1`.
    pub(super) thetas: Vec<f64>,
    /// Dense output weights, one row a sample.
    weights: Vec<f64>,
    pub(super) scratch: Vec<f64>,
    pub(super) x: Vec<f64>,
    pub(super) forces: Vec<f64>,
    previous_forces: Vec<f64>,
    /// Gaps at the start and all samples, one row a contact.
    gaps: Vec<f64>,
    open: Vec<usize>,
    /// Sizes of gaps and velocities of all contacts at the start.
    pub(super) sizes: Vec<ContactSize>,
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
            thetas,
            weights,
            scratch: vec![0.0; stages],
            x: vec![0.0; declaration.inputs()],
            forces: vec![0.0; 2 * contacts],
            previous_forces: vec![0.0; 2 * contacts],
            gaps: vec![0.0; contacts * (samples + 1)],
            open: Vec::with_capacity(contacts),
            sizes: vec![ContactSize::default(); contacts],
            frictions: vec![0.0; contacts * (samples + 1)],
        }
    }

    /// The first violation in `element`, if any.
    pub(super) fn first_violation(
        &mut self,
        element: &FiniteElement<'_>,
        contacts: &mut Contacts<'_>,
        start: &ElementStart<'_>,
    ) -> Result<Option<Switch>, Stop> {
        let active = element.active();
        self.open.clear();
        let row = self.thetas.len() + 1;
        for (i, &gap) in start.gaps.iter().enumerate() {
            if find(active, i).is_none() {
                self.open.push(i);
                self.gaps[i * row] = gap;
            }
        }
        if self.open.is_empty() && active.is_empty() {
            return Ok(None);
        }
        for (i, size) in self.sizes.iter_mut().enumerate() {
            *size = contacts.size(i, start.time);
        }
        self.previous_forces[..start.forces.len()].copy_from_slice(start.forces);
        self.start_frictions(active, contacts, start);
        for k in 0..self.thetas.len() {
            self.interpolate(element, k);
            let mut first = self.first_entry(element, contacts, start, k)?;
            self.first_exit(element, contacts, k, &mut first)
                .map_err(beyond)?;
            self.first_friction(element, contacts, start, k, &mut first)?;
            if first.is_some() {
                return Ok(first);
            }
            if self.hides_a_crossing(element, contacts, k) {
                return Err(Stop::Unresolved);
            }
        }
        Ok(None)
    }

    /// Whether the gap of an open contact varies between samples `k - 2`, `k - 1` and `k` by more than they
    /// show: the cubic through the outer values and slopes misses the inner value by so much that the gap
    /// may have vanished in between.
    fn hides_a_crossing(
        &mut self,
        element: &FiniteElement<'_>,
        contacts: &mut Contacts<'_>,
        k: usize,
    ) -> bool {
        if k == 0 {
            return false;
        }
        let samples = self.thetas.len();
        let mut suspects = Vec::new();
        for &i in &self.open {
            let row = &self.gaps[i * (samples + 1)..(i + 1) * (samples + 1)];
            let (a, b, c) = (row[k - 1], row[k], row[k + 1]);
            let least = a.min(b).min(c);
            let released = row[..k]
                .iter()
                .all(|gap| *gap <= self.sizes[i].touching_gap());
            if !released && least > 0.0 && (a - 2.0 * b + c).abs() > least {
                suspects.push((i, a, b, c, least));
            }
        }
        if suspects.is_empty() {
            return false;
        }
        // Slopes at the outer samples by the normal velocities there.
        let width =
            (self.thetas[k] - if k >= 2 { self.thetas[k - 2] } else { 0.0 }) * element.length();
        suspects.into_iter().any(|(i, a, b, c, least)| {
            contacts.evaluate_contacts(&self.x, [i]);
            let after = contacts.normal_velocity(i);
            let outer = if k >= 2 { self.thetas[k - 2] } else { 0.0 };
            self.tableau.dense_weights(outer, &mut self.scratch);
            element.interpolate(outer, &self.scratch, &mut self.x);
            contacts.evaluate_contacts(&self.x, [i]);
            let before = contacts.normal_velocity(i);
            self.interpolate(element, k);
            let cubic = 0.5 * (a + c) + 0.125 * width * (before - after);
            let missed = (cubic - b).abs();
            missed > least && missed > RESOLVED * a.max(b).max(c)
        })
    }

    pub(super) fn interpolate(&mut self, element: &FiniteElement<'_>, k: usize) {
        let stages = self.tableau.stages();
        let weights = &self.weights[k * stages..(k + 1) * stages];
        element.interpolate(self.thetas[k], weights, &mut self.x);
    }

    /// Place of the sample before `k`.
    pub(super) fn left(&self, k: usize) -> f64 {
        if k == 0 { 0.0 } else { self.thetas[k - 1] }
    }

    /// Open contacts that close between samples `k - 1` and `k`.
    fn first_entry(
        &mut self,
        element: &FiniteElement<'_>,
        contacts: &mut Contacts<'_>,
        start: &ElementStart<'_>,
        k: usize,
    ) -> Result<Option<Switch>, Stop> {
        let samples = self.thetas.len();
        let mut first = None;
        for index in 0..self.open.len() {
            let i = self.open[index];
            let size = self.sizes[i];
            let row = &mut self.gaps[i * (samples + 1)..(i + 1) * (samples + 1)];
            let gap = self.model.gap(i, &self.x);
            if !gap.is_finite() {
                return Err(beyond(ModeError::NotFinite));
            }
            row[k + 1] = gap;
            let before = row[k];
            // A contact that was just released separates more slowly than the element's local error at
            // first: until it has, only the end of the element tells.
            let released = row[..=k].iter().all(|gap| *gap <= size.touching_gap());
            if released && gap < -size.gap_rounding() {
                let depth = DEEP * element.length() * size.speed();
                if (start.velocities[i] > size.velocity_rounding() || gap < -depth)
                    && let Some(switch) =
                        self.return_after_release(element, i, k, size.gap_rounding())
                {
                    keep_first(&mut first, switch);
                    self.interpolate(element, k);
                    continue;
                }
                self.interpolate(element, k);
            }
            if released && k + 1 < samples {
                continue;
            }
            if gap < -size.gap_rounding() {
                contacts.evaluate_contacts(&self.x, [i]);
                let velocity = contacts.normal_velocity(i);
                let kind = if !released && before > 0.0 {
                    SwitchKind::Entry
                } else if velocity < -size.velocity_rounding() {
                    SwitchKind::Reentry
                } else {
                    continue;
                };
                let (before, after) = match kind {
                    SwitchKind::Entry => (before, gap),
                    _ => (
                        self.margin_before(element, contacts, start, i, k),
                        gap.max(velocity),
                    ),
                };
                let switch = self.between(kind, i, element, k, before, after);
                keep_first(&mut first, switch);
            } else if !released
                && let Some((lower, upper)) = self.possible_dip(element, contacts, start, i, k)
            {
                if let Some(switch) = self.dip(element, i, lower, upper, size.gap_rounding()) {
                    keep_first(&mut first, switch);
                }
                self.interpolate(element, k);
            }
        }
        Ok(first)
    }

    /// The entry of a contact that was released at the start of the element and is closed at sample `k`: if
    /// its gap is positive somewhere before, by more than rounding error, it falls through zero in between.
    fn return_after_release(
        &mut self,
        element: &FiniteElement<'_>,
        contact: usize,
        k: usize,
        gap_rounding: f64,
    ) -> Option<Switch> {
        let mut value = |theta: f64| {
            self.tableau.dense_weights(theta, &mut self.scratch);
            element.interpolate(theta, &self.scratch, &mut self.x);
            self.model.gap(contact, &self.x)
        };
        // Flights lower than the rounding error end in contact; of higher ones one of the places is close to
        // the top.
        let lowest = 0.5 * gap_rounding;
        let violated = self.thetas[k];
        let mut right = violated;
        let mut left = 0.5 * violated;
        for _ in 0..30 {
            if value(left) > lowest {
                break;
            }
            right = left;
            left *= 0.5;
        }
        let height = value(left);
        if height <= lowest {
            return None;
        }
        let slope = (value(right) - height) / ((right - left) * element.length());
        let (left, right) = bisect(&mut value, left, right);
        Some(Switch {
            kind: SwitchKind::Entry,
            contact,
            theta: left,
            violated: right,
            slope,
        })
    }

    /// Interval in which the gap of `contact` has a minimum that could dip below zero, if there is one that
    /// sample `k` reveals.
    fn possible_dip(
        &self,
        element: &FiniteElement<'_>,
        contacts: &mut Contacts<'_>,
        start: &ElementStart<'_>,
        contact: usize,
        k: usize,
    ) -> Option<(f64, f64)> {
        let samples = self.thetas.len();
        let row = &self.gaps[contact * (samples + 1)..(contact + 1) * (samples + 1)];
        let place = |index: usize| {
            if index == 0 {
                0.0
            } else {
                self.thetas[index - 1]
            }
        };
        if k == 0 {
            let reach = -start.velocities[contact] * self.thetas[0] * element.length();
            return (row[1] >= row[0] && row[0] < reach).then_some((0.0, self.thetas[0]));
        }
        let drop = (row[k - 1] - row[k]).max(row[k + 1] - row[k]);
        if row[k] <= row[k - 1] && row[k] <= row[k + 1] && row[k] < drop {
            return Some((place(k - 1), place(k + 1)));
        }
        if k + 1 == samples && row[k + 1] < row[k] && row[k + 1] < row[k] - row[k + 1] {
            contacts.evaluate_contacts(&self.x, [contact]);
            if contacts.normal_velocity(contact) > 0.0 {
                return Some((place(k), place(k + 1)));
            }
        }
        None
    }

    /// `max(g, v_n)` at sample `k - 1`, at least zero.
    fn margin_before(
        &mut self,
        element: &FiniteElement<'_>,
        contacts: &mut Contacts<'_>,
        start: &ElementStart<'_>,
        contact: usize,
        k: usize,
    ) -> f64 {
        if k == 0 {
            contacts.evaluate_contacts(start.x, [contact]);
        } else {
            self.interpolate(element, k - 1);
            contacts.evaluate_contacts(&self.x, [contact]);
            self.interpolate(element, k);
        }
        contacts
            .gap(contact)
            .max(contacts.normal_velocity(contact))
            .max(0.0)
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

    /// Active contacts whose force vanishes between samples `k - 1` and `k`.
    fn first_exit(
        &mut self,
        element: &FiniteElement<'_>,
        contacts: &mut Contacts<'_>,
        k: usize,
        first: &mut Option<Switch>,
    ) -> Result<(), ModeError> {
        let active = element.active();
        if active.is_empty() {
            return Ok(());
        }
        contacts.evaluate(&self.x, active.iter().map(|held| held.contact));
        contacts.contact_forces(active, &mut self.forces[..force_count(active)])?;
        for (slot, held) in active.iter().enumerate() {
            let i = held.contact;
            let (before, after) = (self.previous_forces[slot].max(0.0), self.forces[slot]);
            if after < -FORCE_TOLERANCE * contacts.phi_scale(i) {
                let switch = self.between(SwitchKind::Exit, i, element, k, before, after);
                keep_first(first, switch);
            }
        }
        self.previous_forces.copy_from_slice(&self.forces);
        Ok(())
    }

    /// Minimizes the gap of the dense output between `lower` and `upper` by golden section; a minimum below
    /// zero is an entry on its falling side.
    fn dip(
        &mut self,
        element: &FiniteElement<'_>,
        contact: usize,
        lower: f64,
        upper: f64,
        gap_rounding: f64,
    ) -> Option<Switch> {
        let mut value = |theta: f64| {
            self.tableau.dense_weights(theta, &mut self.scratch);
            element.interpolate(theta, &self.scratch, &mut self.x);
            self.model.gap(contact, &self.x)
        };
        let start = value(lower);
        let (bottom, depth) = lowest(&mut value, lower, upper);
        if depth >= -gap_rounding {
            return None;
        }
        let (left, _) = bisect(&mut value, lower, bottom);
        Some(Switch {
            kind: SwitchKind::Entry,
            contact,
            theta: left,
            violated: bottom,
            slope: (depth - start) / ((bottom - lower) * element.length()),
        })
    }
}

/// Between its stages an element may leave the domain of the model, or of the mode; a shorter one will not.
fn beyond(error: ModeError) -> Stop {
    Stop::Element(match error {
        ModeError::NotFinite => ElementError::NotFinite,
        ModeError::Jammed | ModeError::Dependent => ElementError::Singular,
    })
}

/// Place and value of the minimum of `value` between `lower` and `upper`, by golden section.
pub(super) fn lowest(value: &mut dyn FnMut(f64) -> f64, lower: f64, upper: f64) -> (f64, f64) {
    let (mut a, mut b) = (lower, upper);
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..60 {
        let (left, right) = (b - ratio * (b - a), a + ratio * (b - a));
        if value(left) <= value(right) {
            b = right;
        } else {
            a = left;
        }
    }
    let bottom = 0.5 * (a + b);
    (bottom, value(bottom))
}

/// Halves an interval 60 times around the root of a `value` that is positive on its left and not on its right.
pub(super) fn bisect(
    value: &mut dyn FnMut(f64) -> f64,
    mut left: f64,
    mut right: f64,
) -> (f64, f64) {
    for _ in 0..60 {
        let middle = 0.5 * (left + right);
        if value(middle) > 0.0 {
            left = middle;
        } else {
            right = middle;
        }
    }
    (left, right)
}

pub(super) fn keep_first(first: &mut Option<Switch>, candidate: Switch) {
    if first.is_none_or(|switch| candidate.theta < switch.theta) {
        *first = Some(candidate);
    }
}
