//! Contacts at a point: gaps, velocities, accelerations, and the forces of a given contact mode.
//!
//! A contact mode poses one equation a force: `v_n' = 0` for the normal acceleration `r_i` of an active
//! contact, which acts along `d_i`, or along `d_i -+ mu_i e_i` while it slips; and `v_t' = 0` for the
//! friction `s_i` of a sticking contact, which acts along `e_i`.

use crate::linalg::products::dot;
use crate::yardstick;
use std::ops::{Deref, DerefMut};

pub(crate) use crate::contact::{Line, ModeError};

use super::contact_size::ContactSize;
use crate::contact::shares::{self, Shares};
use crate::contact::{ActiveContact, Extent, View, tangents};
use crate::linalg::banded::{Banded, Unfactorized};
use crate::linalg::dense;
use crate::model::rounding::rounding_error_at_start;
use crate::model::{Model, switching_terms};

/// Coupling of the force of a slipping contact to its own normal velocity below which no force holds the
/// contact: the friction presses as much as the force lifts.
const JAMMED: f64 = 1e-10;

/// Number of lines from which on the band of their couplings is looked at, and share of the largest entry of a column up to which a pivot
/// counts as zero, as in [`dense`].
const MANY: usize = 32;
const SINGULAR: f64 = 1e-14;

/// Share of its terms up to which a sum is rounding error.
const CANCELS: f64 = 8.0 * f64::EPSILON;

/// Evaluates contacts and their forces at a point: the [`View`] that laws read, and the sizes that the motion has had.
pub(crate) struct Contacts<'a> {
    view: View<'a>,
    /// How far and how fast the motion has been.
    extent: Extent,
    /// Sum of the terms of each normal acceleration where the motion is, the scale of its rounding error, of which the motion so far has
    /// the largest: at one instant they may cancel inside the model.
    scales: Vec<f64>,
    /// Sums of the terms of the sliding accelerations.
    tangent_scales: Vec<f64>,
    /// Sizes of gaps and velocities where the motion is.
    sizes: Vec<ContactSize>,
    /// Rounding errors of the gaps as measured at the start.
    rounding: Vec<f64>,
    /// The shortest time that the motion is told apart in [s]; 0 where no motion is followed.
    pub(crate) shortest: f64,
    /// A time over which what acts is smooth [s]; infinite where no motion is followed.
    pub(crate) moment: f64,
    lines: Vec<Line>,
    matrix: Vec<f64>,
    pivots: Vec<usize>,
    band: Banded,
    /// Whether the forces of the last solution are not the only ones.
    shared: bool,
    pub(super) shifted: Vec<f64>,
    /// Rates of the controls, empty where they are constant.
    pub(super) control_slopes: Vec<f64>,
    pub(crate) evaluations: usize,
}

impl<'a> Deref for Contacts<'a> {
    type Target = View<'a>;

    fn deref(&self) -> &View<'a> {
        &self.view
    }
}

impl DerefMut for Contacts<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.view
    }
}

impl<'a> Contacts<'a> {
    pub(crate) fn new(model: &'a dyn Model) -> Self {
        let declaration = model.declaration();
        let contacts = declaration.contacts.len();
        Self {
            view: View::new(model),
            extent: Extent::default(),
            scales: vec![0.0; contacts],
            tangent_scales: vec![0.0; contacts],
            sizes: vec![ContactSize::default(); contacts],
            rounding: vec![0.0; contacts],
            shortest: 0.0,
            moment: f64::INFINITY,
            lines: Vec::new(),
            matrix: Vec::new(),
            pivots: Vec::new(),
            band: Banded::default(),
            shared: false,
            shifted: vec![0.0; declaration.inputs()],
            control_slopes: Vec::new(),
            evaluations: 0,
        }
    }

    /// Rates of the controls from now on; empty where they are constant.
    pub(crate) fn set_control_slopes(&mut self, slopes: &[f64]) {
        self.control_slopes.clear();
        self.control_slopes.extend(slopes);
    }

    /// Rates of what the model reads besides coordinates and velocities: controls, and the time.
    pub(crate) fn rates(&self) -> Vec<f64> {
        let declaration = self.model.declaration();
        let mut rates = self.control_slopes.clone();
        rates.resize(declaration.controls.len(), 0.0);
        if declaration.explicit_time {
            rates.push(1.0);
        }
        rates
    }

    /// Takes note of the speed below which the sliding of a contact in space has no direction, at `time`.
    pub(crate) fn measure_sliding(&mut self, contact: usize, time: f64) {
        if !self.is_in_space(contact) {
            return;
        }
        let rest = self.size(contact, time).at_rest();
        let largest = self.sizes[contact].sliding;
        self.view.measure_sliding(contact, largest, rest);
    }

    /// Speed up to which a contact is at rest along the ground.
    pub(crate) fn rest_speed(&self, contact: usize, time: f64) -> f64 {
        let rest = self.size(contact, time).at_rest();
        match self.space(contact) {
            Some(space) => rest.max(space.frames()[contact].soft),
            None => rest,
        }
    }

    /// Whether the bound of a dry friction that follows no force is not negative at the last evaluation.
    pub(crate) fn check_bounds(&self) -> Result<(), ModeError> {
        let negative = |&i: &usize| {
            let given = -self.normal_acceleration(i);
            given < -yardstick::NOTHING * self.scales[i] && !self.follows(i)
        };
        match (self.surfaces..self.scales.len()).find(negative) {
            Some(contact) => Err(ModeError::NegativeBound(contact)),
            None => Ok(()),
        }
    }

    /// Whether bounds that follow forces are not negative, where the `active` contacts have these `forces`.
    pub(crate) fn check_followed(
        &self,
        active: &[ActiveContact],
        forces: &[f64],
    ) -> Result<(), ModeError> {
        let mut pairs = active.iter().zip(forces);
        let negative = |&(held, &force): &(&ActiveContact, &f64)| {
            let scale = self.scales[held.contact].max(force.abs());
            force < -yardstick::NOTHING * scale
                && self.is_dry(held.contact)
                && self.follows(held.contact)
        };
        match pairs.find(negative) {
            Some((held, _)) => Err(ModeError::NegativeBound(held.contact)),
            None => Ok(()),
        }
    }

    /// Evaluates the listed contacts at `x`, without forces.
    pub(crate) fn evaluate_contacts(
        &mut self,
        x: &[f64],
        contacts: impl IntoIterator<Item = usize>,
    ) {
        for i in contacts {
            self.view.evaluate_sides(i, x);
        }
        self.evaluations += 1;
    }

    /// Sizes of gap and velocities of a contact that was evaluated at `x`.
    fn size_at(&self, x: &[f64], contact: usize) -> ContactSize {
        let normal = self.normal(contact);
        let speed = |slopes: &[f64]| self.extent.velocities(slopes);
        let sliding = if self.has_friction(contact) {
            let terms = speed(self.tangent(contact));
            let across = match self.is_in_space(contact) {
                true => speed(self.row(Line::Across { contact }).0),
                false => 0.0,
            };
            terms
                .max(self.sliding_velocity(contact).abs())
                .max(across)
                .max(switching_terms(self.model, contact, x))
        } else {
            0.0
        };
        let gap = self.extent.places(normal).max(self.gap(contact).abs());
        ContactSize {
            gap: gap.max(self.rounding[contact] / f64::EPSILON),
            velocity: speed(normal).max(self.normal_velocity(contact).abs()),
            sliding,
            ..ContactSize::default()
        }
    }

    /// Sizes of gap and velocities of a contact where the motion is, at `time`.
    pub(crate) fn size(&self, contact: usize, time: f64) -> ContactSize {
        let tangential = self.tangential_scale(contact);
        let times = (time, self.shortest);
        self.sizes[contact].at(times, self.phi_scale(contact), tangential)
    }

    /// By how much the way of the motion has changed the gap of a contact.
    pub(crate) fn range(&self, contact: usize) -> f64 {
        self.extent.ways(self.normal(contact))
    }

    /// Normal velocity up to which a contact does not leave: a flight lower than the rounding error of its gap
    /// is none, so that impacts that follow each other ever faster end in contact.
    pub(crate) fn resting_velocity(&self, contact: usize, time: f64) -> f64 {
        let size = self.size(contact, time);
        let flight = (2.0 * self.phi_scale(contact) * size.gap_rounding()).sqrt();
        size.touching_velocity().max(flight)
    }

    /// Evaluates the free acceleration and the listed contacts at `x`.
    pub(crate) fn evaluate(&mut self, x: &[f64], contacts: impl IntoIterator<Item = usize>) {
        self.view.evaluate_free_acceleration(x);
        self.evaluate_contacts(x, contacts);
    }

    /// Remembers how large gaps and velocities of the listed contacts are, which were evaluated at the state `x` of
    /// the motion. States that are only tried may be far beyond it.
    pub(crate) fn remember_sizes(&mut self, x: &[f64], contacts: impl IntoIterator<Item = usize>) {
        let (q, v) = x[..2 * self.n].split_at(self.n);
        self.extent.include(q, v, self.view.free_acceleration());
        for i in contacts {
            let size = self.size_at(x, i);
            self.sizes[i].take(size);
        }
    }

    /// Remembers the acceleration of the motion.
    pub(crate) fn remember_acceleration(&mut self, a: &[f64]) {
        self.extent.accelerate(a);
    }

    /// Remembers what the measured rounding errors of the gaps at the start `x` say of the sizes of their terms, which may cancel inside
    /// of the model. The `moment` is short beside the motion.
    pub(crate) fn remember_rounding_at_start(&mut self, x: &[f64], moment: f64) {
        self.evaluate(x, 0..self.sizes.len());
        for i in 0..self.sizes.len() {
            let gap = |x: &[f64]| self.pieces.gap(self.model, i, x);
            let error = rounding_error_at_start(x, self.free_acceleration(), moment, gap);
            self.rounding[i] = error.max(0.0);
        }
    }

    /// Remembers how large the accelerations of the listed contacts are, which were evaluated at a state of the
    /// motion.
    pub(crate) fn remember_scales(&mut self, contacts: impl IntoIterator<Item = usize>) {
        for i in contacts {
            // A given force is no acceleration of the motion: the largest so far is its scale.
            let known = if self.is_dry(i) { self.scales[i] } else { 0.0 };
            self.scales[i] = self.present_scale(Line::normal(i)).max(known);
            if self.has_friction(i) {
                self.tangent_scales[i] = self.present_scale(Line::tangent(i));
            }
        }
    }

    /// Sum of the terms of a line's acceleration, of which the motion so far has the largest.
    fn present_scale(&self, line: Line) -> f64 {
        let known = self.extent.accelerations(self.row(line).0);
        self.terms(line).max(known)
    }

    /// Sum of the terms of the sliding acceleration, at least where the motion is.
    fn tangent_terms(&self, contact: usize) -> f64 {
        self.tangent_scales[contact].max(self.terms(Line::tangent(contact)))
    }

    /// Normal acceleration of a contact without contact forces at the last evaluation, `phi_i`.
    pub(crate) fn normal_acceleration(&self, contact: usize) -> f64 {
        self.free_line_acceleration(Line::normal(contact))
    }

    /// Sliding acceleration of a contact under `acceleration` at the last evaluation.
    pub(crate) fn sliding_acceleration(&self, contact: usize, acceleration: &[f64]) -> f64 {
        self.line_acceleration(Line::tangent(contact), acceleration)
    }

    /// Scale of the rounding error of the normal acceleration of a contact.
    pub(crate) fn phi_scale(&self, contact: usize) -> f64 {
        self.scales[contact].max(self.terms(Line::normal(contact)))
    }

    /// Scale of the rounding error of the acceleration of a line.
    pub(super) fn scale(&self, line: Line) -> f64 {
        match line {
            Line::Normal { contact, .. } => self.phi_scale(contact),
            Line::Tangent { contact, .. } | Line::Across { contact } => {
                self.tangential_scale(contact)
            }
        }
    }

    /// Scale of the rounding errors of friction and sliding acceleration.
    pub(crate) fn tangential_scale(&self, contact: usize) -> f64 {
        if !self.has_friction(contact) {
            return 0.0;
        }
        self.tangent_terms(contact) + self.friction(contact) * self.phi_scale(contact)
    }

    /// Ratio `s / r` of a contact in the given state; 0 where it sticks.
    fn slope(&self, active: ActiveContact) -> f64 {
        active
            .state
            .force_ratio(self.view.frictions(active.contact))
    }

    /// The lines that the `active` contacts hold: their normals, then the tangents of those that stick.
    pub(super) fn lines(&self, active: &[ActiveContact], lines: &mut Vec<Line>) {
        lines.clear();
        lines.extend(active.iter().map(|&held| Line::Normal {
            contact: held.contact,
            slope: self.slope(held),
        }));
        lines.extend(tangents(active));
    }

    /// The lines along which impulses hold the `active` contacts: with friction those that slide; dry friction has none.
    pub(crate) fn lines_of_impulses(&self, active: &[ActiveContact]) -> Vec<Line> {
        let normal = |held: &ActiveContact| match held.contact {
            contact if held.state.slips() && !self.is_dry(contact) => Line::Normal {
                contact,
                slope: self.slope(*held),
            },
            contact => Line::normal(contact),
        };
        active.iter().map(normal).chain(tangents(active)).collect()
    }

    /// Forces of the `active` contacts at the last evaluation, which hold the accelerations of their lines at
    /// zero: first the normal contact accelerations `r`, then the friction `s` of those that stick.
    pub(crate) fn contact_forces(
        &mut self,
        active: &[ActiveContact],
        forces: &mut [f64],
    ) -> Result<(), ModeError> {
        if let [single] = active
            && !single.state.sticks()
        {
            forces[0] = -self.normal_acceleration(single.contact);
            let slope = self.slope(*single);
            self.shared = false;
            if slope != 0.0 {
                let lift = self.lift(single.contact, slope);
                if lift <= JAMMED {
                    return Err(ModeError::Jammed);
                }
                forces[0] /= lift;
            }
            return Ok(());
        }
        let mut lines = std::mem::take(&mut self.lines);
        self.lines(active, &mut lines);
        for (value, &line) in forces.iter_mut().zip(&lines) {
            *value = -self.free_line_acceleration(line);
        }
        let outcome = self.solve_lines(&lines, forces);
        self.lines = lines;
        outcome
    }

    /// Solves for forces on the lines; `forces` are the right-hand sides.
    fn solve_lines(&mut self, lines: &[Line], forces: &mut [f64]) -> Result<(), ModeError> {
        self.shared = false;
        if lines.len() >= MANY {
            let entries = self.view.sparse_couplings(lines);
            match self.band.factorize(lines.len(), &entries, SINGULAR) {
                Ok(()) => {
                    self.band.solve(forces);
                    return Ok(());
                }
                Err(Unfactorized::Singular | Unfactorized::Wide) => {}
            }
        }
        self.matrix = self.view.couplings(lines);
        self.pivots.resize(lines.len(), 0);
        if dense::factorize_independent(&mut self.matrix, &mut self.pivots) {
            dense::solve(&self.matrix, &self.pivots, forces);
            return Ok(());
        }
        let couplings = self.view.couplings(lines);
        let shares = Shares::of(&self.view, lines, &couplings, forces)?;
        if shares.contradict(&self.view, lines) {
            return Err(ModeError::Dependent);
        }
        self.shared = true;
        forces.copy_from_slice(&shares.inside(&shares::rooms(&self.view, lines)));
        Ok(())
    }

    /// Normal acceleration for a unit force of a contact with `s = slope r`; `n' d = 1` by the scaling of the
    /// contact direction.
    fn lift(&self, contact: usize, slope: f64) -> f64 {
        1.0 + slope * self.pull(contact)
    }

    /// Normal acceleration for a unit force of a contact that slides in the given sense.
    pub(crate) fn lift_in_slip(&self, contact: usize, sense: f64) -> f64 {
        self.lift(contact, -sense * self.kinetic(contact))
    }

    /// Acceleration with the `forces` of the `active` contacts at the last evaluation.
    pub(crate) fn constrained_acceleration(
        &mut self,
        active: &[ActiveContact],
        forces: &[f64],
        result: &mut [f64],
    ) {
        result.copy_from_slice(self.free_acceleration());
        let mut lines = std::mem::take(&mut self.lines);
        self.lines(active, &mut lines);
        for (&line, &force) in lines.iter().zip(forces) {
            self.push(line, force, result);
        }
        if self.shared {
            // Where forces act that are not all needed, sums of them cancel but for rounding.
            for (k, sum) in result.iter_mut().enumerate() {
                let terms = lines.iter().zip(forces);
                let terms =
                    terms.map(|(&line, force)| (self.line_direction(line)[k] * force).abs());
                let size = self.free_acceleration()[k].abs() + terms.sum::<f64>();
                if sum.abs() <= CANCELS * size {
                    *sum = 0.0;
                }
            }
        }
        self.lines = lines;
    }

    /// Tangential accelerations `s` of the `active` contacts among their `forces`.
    pub(crate) fn frictions(
        &self,
        active: &[ActiveContact],
        forces: &[f64],
    ) -> impl Iterator<Item = f64> {
        let mut stuck = active.len();
        active.iter().zip(forces).map(move |(&held, &r)| {
            stuck += held.state.stuck();
            match held.state.stuck() {
                0 => self.slope(held) * r,
                1 => forces[stuck - 1],
                // Of a contact in space the size.
                _ => forces[stuck - 2].hypot(forces[stuck - 1]),
            }
        })
    }
}

pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
