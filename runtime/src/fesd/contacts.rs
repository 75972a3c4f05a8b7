//! Contacts at a point: gaps, velocities, accelerations, and the forces of a given contact mode.
//!
//! A contact mode poses one equation a force: `v_n' = 0` for the normal acceleration `r_i` of an active
//! contact, which acts along `d_i`, or along `d_i -+ mu_i e_i` while it slips; and `v_t' = 0` for the
//! friction `s_i` of a sticking contact, which acts along `e_i`.

pub(crate) use super::line::Line;
pub(super) use super::line::{tangents, unbiased_lines};
pub(crate) use super::mode_error::ModeError;

use super::active_contact::ActiveContact;
use super::contact_size::ContactSize;
use super::coulomb::Cone;
use crate::linalg::dense;
use crate::model::rounding::rounding_error_at_start;
use crate::model::{
    Frame, Loads, Model, Pieces, Space, Switching, contact_point, contains_ground,
    friction_coefficients, kinetic_coefficients, surfaces, switching_terms, tangent_point,
};

/// Coupling of the force of a slipping contact to its own normal velocity below which no force holds the
/// contact: the friction presses as much as the force lifts.
const JAMMED: f64 = 1e-10;

/// Bound of dry friction below zero, as a share of its largest, that is no rounding error.
const NEGATIVE: f64 = 1e-9;

/// Evaluates contacts and their forces at a point; owns the memory for it.
// Many fields: the memory of an evaluation, and the sizes that the motion has had.
pub(crate) struct Contacts<'a> {
    pub(super) model: &'a dyn Model,
    pub(super) n: usize,
    /// Which pieces of surfaces with edges act.
    pub(crate) pieces: Pieces,
    /// Coefficients of friction, 0 for contacts without friction.
    friction: Vec<f64>,
    /// The same of contacts that slide.
    kinetic: Vec<f64>,
    /// What dry frictions follow of the forces of surfaces at the last evaluation.
    loads: Loads,
    /// Number of contacts that are surfaces.
    pub(crate) surfaces: usize,
    /// Which side of each switch that is only passed acts: the sign of minus its function, 0 for all others.
    pub(super) sides: Vec<f64>,
    acceleration: Vec<f64>,
    points: Vec<f64>,
    /// Tangential sides; empty if no contact has friction.
    tangents: Vec<f64>,
    /// Contacts in space: which, in which frames, the second tangential sides, and the directions along which they slide.
    space: Option<Space>,
    /// Largest sum of terms of each normal acceleration of the motion so far: the scale of its rounding error. At
    /// one instant the terms may cancel inside the model.
    scales: Vec<f64>,
    /// The same for the sliding accelerations.
    tangent_scales: Vec<f64>,
    /// Largest sizes of gaps and velocities of the motion so far.
    sizes: Vec<ContactSize>,
    /// The shortest time that the motion is told apart in [s]; 0 where no motion is followed.
    pub(crate) shortest: f64,
    /// A time over which what acts is smooth [s]; infinite where no motion is followed.
    pub(crate) moment: f64,
    lines: Vec<Line>,
    matrix: Vec<f64>,
    pivots: Vec<usize>,
    pub(super) shifted: Vec<f64>,
    /// Rates of the controls, empty where they are constant.
    pub(super) control_slopes: Vec<f64>,
    pub(crate) evaluations: usize,
}

impl<'a> Contacts<'a> {
    pub(crate) fn new(model: &'a dyn Model) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let contacts = declaration.contacts.len();
        let friction = friction_coefficients(model);
        let rough = friction.iter().any(|mu| *mu > 0.0);
        let tangents = if rough { contacts } else { 0 };
        Self {
            model,
            n,
            pieces: Pieces::default(),
            friction,
            kinetic: kinetic_coefficients(model),
            loads: Loads::default(),
            surfaces: surfaces(model),
            sides: vec![0.0; contacts],
            acceleration: vec![0.0; n],
            points: vec![0.0; contacts * contact_point::length(n)],
            tangents: vec![0.0; tangents * tangent_point::length(n)],
            space: Space::of(model),
            scales: vec![0.0; contacts],
            tangent_scales: vec![0.0; tangents],
            sizes: vec![ContactSize::default(); contacts],
            shortest: 0.0,
            moment: f64::INFINITY,
            lines: Vec::new(),
            matrix: Vec::new(),
            pivots: Vec::new(),
            shifted: vec![0.0; declaration.inputs()],
            control_slopes: Vec::new(),
            evaluations: 0,
        }
    }

    /// The scene.
    pub(crate) fn model(&self) -> &'a dyn Model {
        self.model
    }

    /// Rates of the controls from now on; empty where they are constant.
    pub(crate) fn set_control_slopes(&mut self, slopes: &[f64]) {
        self.control_slopes.clear();
        self.control_slopes.extend(slopes);
    }

    fn point(&self, contact: usize) -> &[f64] {
        let length = contact_point::length(self.n);
        &self.points[contact * length..(contact + 1) * length]
    }

    fn tangent(&self, contact: usize) -> &[f64] {
        let length = tangent_point::length(self.n);
        &self.tangents[contact * length..(contact + 1) * length]
    }

    /// Contact direction `d_i` of the last evaluation.
    fn direction(&self, contact: usize) -> &[f64] {
        &self.point(contact)[contact_point::direction(self.n)..]
    }

    /// Friction direction `e_i` of the last evaluation.
    fn friction_direction(&self, contact: usize) -> &[f64] {
        &self.tangent(contact)[tangent_point::direction(self.n)..]
    }

    /// Contacts in space, if this is one.
    fn space(&self, contact: usize) -> Option<&Space> {
        let space = self.space.as_ref();
        space.filter(|space| space.contains(contact))
    }

    /// Whether a contact slides along two directions.
    pub(crate) fn is_in_space(&self, contact: usize) -> bool {
        self.space(contact).is_some()
    }

    /// The frames in which contacts in space slide; none without any.
    pub(crate) fn frames(&self) -> &[Frame] {
        self.space.as_ref().map_or(&[], Space::frames)
    }

    /// The second tangential side of a contact in space at the last evaluation.
    fn across(&self, contact: usize) -> &[f64] {
        self.space(contact)
            .map_or(&[], |space| space.across(contact))
    }

    /// Both sliding velocities of a contact at the last evaluation; the second is 0 in the plane.
    pub(crate) fn sliding(&self, contact: usize) -> (f64, f64) {
        let across = self.space(contact).map(|space| space.across(contact));
        let across = across.map_or(0.0, |across| across[tangent_point::SLIDING_VELOCITY]);
        (self.sliding_velocity(contact), across)
    }

    /// The direction in which friction of a contact acts that slides.
    fn slip_direction(&self, contact: usize) -> &[f64] {
        match self.space(contact) {
            Some(space) => space.slipping(contact),
            None => self.friction_direction(contact),
        }
    }

    /// Turns the frame of a contact in space so that it points along what is `to` in it, or along its sliding velocity where that
    /// has a direction.
    pub(crate) fn align(&mut self, contact: usize, to: Option<(f64, f64)>) {
        let length = tangent_point::length(self.n);
        let Some(space) = self.space.as_mut().filter(|space| space.contains(contact)) else {
            return;
        };
        let tangent = &mut self.tangents[contact * length..(contact + 1) * length];
        match to {
            Some(to) => space.align(contact, to, tangent),
            None => space.align_with_sliding(contact, tangent),
        }
    }

    /// Takes note of the speed below which the sliding of a contact in space has no direction, at `time`.
    pub(crate) fn measure_sliding(&mut self, contact: usize, time: f64) {
        if !self.is_in_space(contact) {
            return;
        }
        let rest = self.size(contact, time).at_rest();
        let largest = self.sizes[contact].sliding;
        if let Some(space) = &mut self.space {
            space.measure(contact, largest, rest);
        }
    }

    /// Speed up to which a contact is at rest along the ground.
    pub(crate) fn rest_speed(&self, contact: usize, time: f64) -> f64 {
        let rest = self.size(contact, time).at_rest();
        match self.space(contact) {
            Some(space) => rest.max(space.frames()[contact].soft),
            None => rest,
        }
    }

    /// Coefficient of friction, 0 for a contact without friction.
    pub(crate) fn friction(&self, contact: usize) -> f64 {
        self.friction[contact]
    }

    /// Coefficient of friction of a contact while it slides.
    pub(crate) fn kinetic(&self, contact: usize) -> f64 {
        self.kinetic[contact]
    }

    /// The law of a contact whose normal is the line `normal`.
    pub(super) fn cone(&self, contact: usize, normal: usize) -> Cone {
        Cone {
            normal,
            friction: self.friction[contact],
            kinetic: self.kinetic[contact],
            across: None,
        }
    }

    /// Whether a contact is dry friction without a surface, whose normal force is given.
    pub(crate) fn is_dry(&self, contact: usize) -> bool {
        contact >= self.surfaces
    }

    /// How the motion meets the zeros of a switch, if the contact is one.
    pub(crate) fn switch(&self, contact: usize) -> Option<Switching> {
        self.model.declaration().contacts[contact].switch
    }

    /// Whether the bound of a dry friction is not negative at the last evaluation.
    pub(crate) fn check_bounds(&self) -> Result<(), ModeError> {
        let negative = |&i: &usize| -self.normal_acceleration(i) < -NEGATIVE * self.scales[i];
        match (self.surfaces..self.friction.len()).find(negative) {
            Some(contact) => Err(ModeError::NegativeBound(contact)),
            None => Ok(()),
        }
    }

    /// Gap of the last evaluation.
    pub(crate) fn gap(&self, contact: usize) -> f64 {
        self.point(contact)[contact_point::GAP]
    }

    /// Gradient of the gap at the last evaluation.
    pub(crate) fn normal(&self, contact: usize) -> &[f64] {
        &self.point(contact)[contact_point::NORMAL..][..self.n]
    }

    /// Normal velocity of the last evaluation.
    pub(crate) fn normal_velocity(&self, contact: usize) -> f64 {
        self.point(contact)[contact_point::NORMAL_VELOCITY]
    }

    /// Sliding velocity of the last evaluation, for a contact with friction.
    pub(crate) fn sliding_velocity(&self, contact: usize) -> f64 {
        self.tangent(contact)[tangent_point::SLIDING_VELOCITY]
    }

    /// The sliding velocity, or where it vanishes for a switch that is only passed a number with the sign of the side that acts.
    pub(super) fn side(&self, contact: usize) -> f64 {
        match self.sides[contact] {
            0.0 => self.sliding_velocity(contact),
            side => side,
        }
    }

    /// Acceleration without contact forces at the last evaluation.
    pub(super) fn free_acceleration(&self) -> &[f64] {
        &self.acceleration
    }

    /// Contact force `lambda_i = r_i / D_i` for a normal contact acceleration, `lambda_t,i = s_i / D_i` for a
    /// tangential one.
    pub(crate) fn force(&self, contact: usize, r: f64) -> f64 {
        r / self.point(contact)[contact_point::INVERSE_INERTIA]
    }

    /// Evaluates the listed contacts at `x`, without forces.
    pub(crate) fn evaluate_contacts(
        &mut self,
        x: &[f64],
        contacts: impl IntoIterator<Item = usize>,
    ) {
        let length = contact_point::length(self.n);
        let tangent_length = tangent_point::length(self.n);
        for i in contacts {
            let point = &mut self.points[i * length..(i + 1) * length];
            self.pieces.contact(self.model, i, x, point);
            if self.friction[i] > 0.0 {
                let tangent = &mut self.tangents[i * tangent_length..(i + 1) * tangent_length];
                self.model.tangent(i, x, tangent);
                if let Some(space) = self.space.as_mut().filter(|space| space.contains(i)) {
                    space.evaluate(self.model, i, x, tangent);
                }
            }
            self.loads.evaluate(self.model, i, x);
        }
        self.evaluations += 1;
    }

    /// Whether the ground of a contact that was evaluated with the velocities `v` moves.
    pub(crate) fn ground_moves(&self, contact: usize, v: &[f64]) -> bool {
        contains_ground(self.normal_velocity(contact), self.normal(contact), v)
            || self.friction[contact] > 0.0 && {
                let along = &self.tangent(contact)[tangent_point::TANGENT..][..self.n];
                contains_ground(self.sliding_velocity(contact), along, v)
            }
    }

    /// Sizes of gap and velocities of a contact that was evaluated at `x`.
    fn size_at(&self, x: &[f64], contact: usize) -> ContactSize {
        let (q, v) = (&x[..self.n], &x[self.n..2 * self.n]);
        let point = self.point(contact);
        let normal = &point[contact_point::NORMAL..][..self.n];
        let sliding = if self.friction[contact] > 0.0 {
            let tangent = self.tangent(contact);
            let along = &tangent[tangent_point::TANGENT..][..self.n];
            let terms = sum_of_sizes(along, v).max(tangent[tangent_point::SLIDING_VELOCITY].abs());
            let across = match self.is_in_space(contact) {
                true => {
                    let across = &self.across(contact)[tangent_point::TANGENT..][..self.n];
                    sum_of_sizes(across, v)
                }
                false => 0.0,
            };
            terms
                .max(across)
                .max(switching_terms(self.model, contact, x))
        } else {
            0.0
        };
        ContactSize {
            gap: sum_of_sizes(normal, q).max(point[contact_point::GAP].abs()),
            velocity: sum_of_sizes(normal, v).max(point[contact_point::NORMAL_VELOCITY].abs()),
            sliding,
            ..ContactSize::default()
        }
    }

    /// Largest sizes of gap and velocities of a contact so far, at `time`.
    pub(crate) fn size(&self, contact: usize, time: f64) -> ContactSize {
        let tangential = self.tangential_scale(contact);
        let times = (time, self.shortest);
        self.sizes[contact].at(times, self.phi_scale(contact), tangential)
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
        self.model.free_acceleration(x, &mut self.acceleration);
        self.evaluate_contacts(x, contacts);
    }

    /// Remembers how large gaps and velocities of all contacts are, which were evaluated at the state `x` of
    /// the motion. States that are only tried may be far beyond it.
    pub(crate) fn remember_sizes(&mut self, x: &[f64]) {
        for i in 0..self.sizes.len() {
            let size = self.size_at(x, i);
            self.sizes[i].include(size);
        }
    }

    /// Remembers what the measured rounding errors of the gaps at the start `x` say of the sizes of their terms, which may cancel inside
    /// of the model. The `moment` is short beside the motion.
    pub(crate) fn remember_rounding_at_start(&mut self, x: &[f64], moment: f64) {
        self.evaluate(x, 0..self.sizes.len());
        for i in 0..self.sizes.len() {
            let gap = |x: &[f64]| self.pieces.gap(self.model, i, x);
            let error = rounding_error_at_start(x, &self.acceleration, moment, gap);
            self.sizes[i].include(ContactSize::of_rounding_error(error));
        }
    }

    /// Remembers how large the accelerations of all contacts are, which were evaluated at a state of the
    /// motion.
    pub(crate) fn remember_scales(&mut self) {
        for i in 0..self.scales.len() {
            self.scales[i] = self.phi_scale(i);
            if self.friction[i] > 0.0 {
                self.tangent_scales[i] = self.tangent_terms(i);
            }
        }
    }

    /// Largest sum of terms of the sliding acceleration so far.
    fn tangent_terms(&self, contact: usize) -> f64 {
        self.tangent_scales[contact].max(self.terms(Line::Tangent {
            contact,
            sense: 1.0,
        }))
    }

    /// Gradient of the velocity of a line, up to its sign, and the velocity-dependent part of the
    /// acceleration.
    fn row(&self, line: Line) -> (&[f64], f64) {
        match line {
            Line::Normal { contact, .. } => {
                let point = self.point(contact);
                (
                    &point[contact_point::NORMAL..][..self.n],
                    point[contact_point::CURVATURE],
                )
            }
            Line::Tangent { contact, .. } => {
                let tangent = self.tangent(contact);
                (
                    &tangent[tangent_point::TANGENT..][..self.n],
                    tangent[tangent_point::CURVATURE],
                )
            }
            Line::Across { contact } => {
                let across = self.across(contact);
                (
                    &across[tangent_point::TANGENT..][..self.n],
                    across[tangent_point::CURVATURE],
                )
            }
        }
    }

    /// Sum of the sizes of the terms of a line's acceleration.
    fn terms(&self, line: Line) -> f64 {
        let (row, curvature) = self.row(line);
        let terms: f64 = row
            .iter()
            .zip(&self.acceleration)
            .map(|(n, a)| (n * a).abs())
            .sum();
        terms + curvature.abs()
    }

    /// Velocity of a line at the last evaluation.
    pub(super) fn velocity(&self, line: Line) -> f64 {
        match line {
            Line::Normal { contact, .. } => self.normal_velocity(contact),
            Line::Tangent { contact, sense } => sense * self.sliding_velocity(contact),
            Line::Across { contact } => self.sliding(contact).1,
        }
    }

    /// Acceleration of a line without contact forces at the last evaluation.
    pub(super) fn free_line_acceleration(&self, line: Line) -> f64 {
        let (row, curvature) = self.row(line);
        line.sense() * (dot(row, &self.acceleration) + curvature)
    }

    /// Normal acceleration of a contact without contact forces at the last evaluation, `phi_i`.
    pub(crate) fn normal_acceleration(&self, contact: usize) -> f64 {
        self.free_line_acceleration(Line::Normal {
            contact,
            slope: 0.0,
        })
    }

    /// Sliding acceleration of a contact under `acceleration` at the last evaluation.
    pub(crate) fn sliding_acceleration(&self, contact: usize, acceleration: &[f64]) -> f64 {
        let (along, curvature) = self.row(Line::Tangent {
            contact,
            sense: 1.0,
        });
        dot(along, acceleration) + curvature
    }

    /// Scale of the rounding error of the normal acceleration of a contact.
    pub(crate) fn phi_scale(&self, contact: usize) -> f64 {
        self.scales[contact].max(self.terms(Line::Normal {
            contact,
            slope: 0.0,
        }))
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
        if self.friction[contact] == 0.0 {
            return 0.0;
        }
        self.tangent_terms(contact) + self.friction[contact] * self.phi_scale(contact)
    }

    /// Acceleration of line `row` for a unit force on line `column`.
    pub(crate) fn coupling(&self, row: Line, column: Line) -> f64 {
        let sign = row.sense();
        if let (Line::Normal { contact, .. }, Line::Normal { contact: other, .. }) = (row, column)
            && self.is_dry(contact)
        {
            return self.loads.coupling(contact, other);
        }
        let (gradient, _) = self.row(row);
        let along = match column {
            Line::Normal {
                contact,
                slope: 0.0,
            } => dot(gradient, self.direction(contact)),
            Line::Normal { contact, slope } => {
                dot(gradient, self.direction(contact))
                    + slope * dot(gradient, self.slip_direction(contact))
            }
            Line::Tangent { contact, sense } => {
                sense * dot(gradient, self.friction_direction(contact))
            }
            Line::Across { contact } => dot(
                gradient,
                &self.across(contact)[tangent_point::direction(self.n)..],
            ),
        };
        sign * along
    }

    /// Couplings of `lines`, row-major.
    pub(crate) fn couplings(&self, lines: &[Line]) -> Vec<f64> {
        let mut matrix = Vec::with_capacity(lines.len() * lines.len());
        for &row in lines {
            for &column in lines {
                matrix.push(self.coupling(row, column));
            }
        }
        matrix
    }

    /// Adds a force of size `value` on `line` to `acceleration`, or an impulse to a velocity.
    pub(super) fn push(&self, line: Line, value: f64, acceleration: &mut [f64]) {
        let add = |target: &mut [f64], direction: &[f64], value: f64| {
            for (component, d) in target.iter_mut().zip(direction) {
                *component += d * value;
            }
        };
        match line {
            Line::Normal { contact, slope } => {
                add(acceleration, self.direction(contact), value);
                if slope != 0.0 {
                    add(acceleration, self.slip_direction(contact), slope * value);
                }
            }
            Line::Tangent { contact, sense } => add(
                acceleration,
                self.friction_direction(contact),
                sense * value,
            ),
            Line::Across { contact } => add(
                acceleration,
                &self.across(contact)[tangent_point::direction(self.n)..],
                value,
            ),
        }
    }

    /// Ratio `s / r` of a contact in the given tangential state; 0 where it sticks.
    fn slope(&self, active: ActiveContact) -> f64 {
        let coefficient = match active.tangential.sense() {
            0.0 => self.friction[active.contact],
            _ => self.kinetic[active.contact],
        };
        active.tangential.share() * coefficient
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

    /// Forces of the `active` contacts at the last evaluation, which hold the accelerations of their lines at
    /// zero: first the normal contact accelerations `r`, then the friction `s` of those that stick.
    pub(crate) fn contact_forces(
        &mut self,
        active: &[ActiveContact],
        forces: &mut [f64],
    ) -> Result<(), ModeError> {
        if let [single] = active
            && !single.sticks()
        {
            let line = Line::Normal {
                contact: single.contact,
                slope: 0.0,
            };
            forces[0] = -self.free_line_acceleration(line);
            let slope = self.slope(*single);
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
        self.matrix.clear();
        for &row in &lines {
            for &column in &lines {
                let entry = self.coupling(row, column);
                self.matrix.push(entry);
            }
        }
        self.pivots.resize(lines.len(), 0);
        for (value, &line) in forces.iter_mut().zip(&lines) {
            *value = -self.free_line_acceleration(line);
        }
        self.lines = lines;
        dense::factorize(&mut self.matrix, &mut self.pivots).map_err(|_| ModeError::Dependent)?;
        dense::solve(&self.matrix, &self.pivots, forces);
        Ok(())
    }

    /// Normal acceleration for a unit force of a contact with `s = slope r`; `n' d = 1` by the scaling of the
    /// contact direction.
    fn lift(&self, contact: usize, slope: f64) -> f64 {
        let (normal, _) = self.row(Line::Normal { contact, slope });
        1.0 + slope * dot(normal, self.slip_direction(contact))
    }

    /// Normal acceleration for a unit force of a contact that slides in the given sense.
    pub(crate) fn lift_in_slip(&self, contact: usize, sense: f64) -> f64 {
        self.lift(contact, -sense * self.kinetic[contact])
    }

    /// Acceleration with the `forces` of the `active` contacts at the last evaluation.
    pub(crate) fn constrained_acceleration(
        &mut self,
        active: &[ActiveContact],
        forces: &[f64],
        result: &mut [f64],
    ) {
        result.copy_from_slice(&self.acceleration);
        let mut lines = std::mem::take(&mut self.lines);
        self.lines(active, &mut lines);
        for (&line, &force) in lines.iter().zip(forces) {
            self.push(line, force, result);
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
            stuck += held.stuck();
            match held.stuck() {
                0 => self.slope(held) * r,
                1 => forces[stuck - 1],
                // Of a contact in space the size.
                _ => forces[stuck - 2].hypot(forces[stuck - 1]),
            }
        })
    }
}

/// Sum of the sizes of the terms of a scalar product.
pub(super) fn sum_of_sizes(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x * y).abs()).sum()
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
