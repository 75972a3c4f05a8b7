//! What a law reads: contacts as a model gives them at one point, for positions, velocities and accelerations alike.

use super::line::Line;
use super::rest::Rest;
use crate::linalg::banded::Entry;
use crate::linalg::products::dot;
use crate::model::{
    Frame, Loads, Model, Pieces, Space, Switching, contact_point, contains_ground,
    friction_coefficients, kinetic_coefficients, surfaces, tangent_point,
};

/// Number of coordinates from which on couplings are sums over those that do not vanish. Chosen: below, finding them takes as long.
const LARGE: usize = 16;
/// Number of lines from which on couplings are sums over those that do not vanish.
const MANY: usize = 6;

/// Contacts at a point, as last evaluated, and the coefficients of their laws; owns the memory for them.
///
/// Each simulator fills one with what it has, and asks the laws of this folder.
pub(crate) struct View<'a> {
    pub(crate) model: &'a dyn Model,
    /// Number of coordinates.
    pub(crate) n: usize,
    /// Number of contacts that are surfaces; the others, behind them, are dry friction.
    pub(crate) surfaces: usize,
    /// Which pieces of surfaces with edges act.
    pub(crate) pieces: Pieces,
    /// Which side of each switch that is only passed acts: the sign of minus its function, 0 for all others.
    pub(crate) sides: Vec<f64>,
    /// The rest in which the motion is, where switches meet.
    pub(crate) rest: Option<Rest>,
    /// Coefficients of friction, 0 for contacts without friction.
    friction: Vec<f64>,
    /// Coefficients of friction of contacts that slide.
    kinetic: Vec<f64>,
    /// What dry frictions follow of the forces of contacts.
    loads: Loads,
    /// Acceleration without contact forces.
    acceleration: Vec<f64>,
    /// The contacts, each laid out as in [`contact_point`].
    points: Vec<f64>,
    /// Their tangential sides, each laid out as in [`tangent_point`].
    tangents: Vec<f64>,
    /// Contacts in space: which, in which frames, the second tangential sides, and the directions along which they slide.
    space: Option<Space>,
}

impl<'a> View<'a> {
    pub(crate) fn new(model: &'a dyn Model) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let contacts = declaration.contacts.len();
        Self {
            model,
            n,
            surfaces: surfaces(model),
            pieces: Pieces::default(),
            sides: vec![0.0; contacts],
            rest: None,
            friction: friction_coefficients(model),
            kinetic: kinetic_coefficients(model),
            loads: Loads::default(),
            acceleration: vec![0.0; n],
            points: vec![0.0; contacts * contact_point::length(n)],
            tangents: vec![0.0; contacts * tangent_point::length(n)],
            space: Space::of(model),
        }
    }

    /// Evaluates the acceleration without contact forces at `x`.
    pub(crate) fn evaluate_free_acceleration(&mut self, x: &[f64]) {
        self.model.free_acceleration(x, &mut self.acceleration);
    }

    /// Evaluates the gap of a contact and what belongs to it at `x`.
    pub(crate) fn evaluate_normal(&mut self, contact: usize, x: &[f64]) {
        let length = contact_point::length(self.n);
        let point = &mut self.points[contact * length..(contact + 1) * length];
        self.pieces.contact(self.model, contact, x, point);
    }

    /// Evaluates the tangential side of a contact with friction at `x`.
    pub(crate) fn evaluate_tangent(&mut self, contact: usize, x: &[f64]) {
        let length = tangent_point::length(self.n);
        let tangent = &mut self.tangents[contact * length..(contact + 1) * length];
        self.model.tangent(contact, x, tangent);
        if let Some(space) = self.space.as_mut().filter(|space| space.contains(contact)) {
            space.evaluate(self.model, contact, x, tangent);
        }
    }

    /// Evaluates a contact, with its tangential side if it has friction, at `x`.
    pub(crate) fn evaluate_sides(&mut self, contact: usize, x: &[f64]) {
        self.evaluate_normal(contact, x);
        if self.has_friction(contact) {
            self.evaluate_tangent(contact, x);
        }
        self.loads.evaluate(self.model, contact, x);
    }

    /// The contact, laid out as in [`contact_point`].
    pub(crate) fn point(&self, contact: usize) -> &[f64] {
        let length = contact_point::length(self.n);
        &self.points[contact * length..(contact + 1) * length]
    }

    /// Its tangential side, laid out as in [`tangent_point`].
    pub(crate) fn tangent_point(&self, contact: usize) -> &[f64] {
        let length = tangent_point::length(self.n);
        &self.tangents[contact * length..(contact + 1) * length]
    }

    /// Gap.
    pub(crate) fn gap(&self, contact: usize) -> f64 {
        self.point(contact)[contact_point::GAP]
    }

    /// Normal velocity.
    pub(crate) fn normal_velocity(&self, contact: usize) -> f64 {
        self.point(contact)[contact_point::NORMAL_VELOCITY]
    }

    /// Gradient of the gap, `n_i`.
    pub(crate) fn normal(&self, contact: usize) -> &[f64] {
        &self.point(contact)[contact_point::NORMAL..][..self.n]
    }

    /// Contact direction `d_i`.
    pub(crate) fn direction(&self, contact: usize) -> &[f64] {
        &self.point(contact)[contact_point::direction(self.n)..][..self.n]
    }

    /// Sliding velocity, for a contact with friction.
    pub(crate) fn sliding_velocity(&self, contact: usize) -> f64 {
        self.tangent_point(contact)[tangent_point::SLIDING_VELOCITY]
    }

    /// Tangent `b_i`.
    pub(crate) fn tangent(&self, contact: usize) -> &[f64] {
        &self.tangent_point(contact)[tangent_point::TANGENT..][..self.n]
    }

    /// Friction direction `e_i`.
    pub(crate) fn friction_direction(&self, contact: usize) -> &[f64] {
        &self.tangent_point(contact)[tangent_point::direction(self.n)..][..self.n]
    }

    /// Contacts in space, if this is one.
    pub(crate) fn space(&self, contact: usize) -> Option<&Space> {
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

    /// Takes note of the largest sliding velocity of a contact in space so far, and of the speed that counts as rest.
    pub(crate) fn measure_sliding(&mut self, contact: usize, largest: f64, rest: f64) {
        if let Some(space) = self.space.as_mut().filter(|space| space.contains(contact)) {
            space.measure(contact, largest, rest);
        }
    }

    /// The second tangential side of a contact in space, laid out as in [`tangent_point`]; empty in the plane.
    fn across_point(&self, contact: usize) -> &[f64] {
        let space = self.space(contact);
        space.map_or(&[], |space| space.across(contact))
    }

    /// Both sliding velocities of a contact; the second is 0 in the plane.
    pub(crate) fn sliding(&self, contact: usize) -> (f64, f64) {
        let across = self.across_point(contact);
        let across = across.get(tangent_point::SLIDING_VELOCITY);
        (
            self.sliding_velocity(contact),
            across.copied().unwrap_or_default(),
        )
    }

    /// The direction in which friction of a contact acts that slides.
    pub(crate) fn slip_direction(&self, contact: usize) -> &[f64] {
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

    /// Coefficient of friction, 0 for a contact without friction.
    pub(crate) fn friction(&self, contact: usize) -> f64 {
        self.friction[contact]
    }

    /// Coefficient of friction of a contact while it slides.
    pub(crate) fn kinetic(&self, contact: usize) -> f64 {
        self.kinetic[contact]
    }

    /// Coefficients of friction at rest and of sliding.
    pub(crate) fn frictions(&self, contact: usize) -> (f64, f64) {
        (self.friction[contact], self.kinetic[contact])
    }

    /// Whether a contact has a coefficient of friction above zero.
    pub(crate) fn has_friction(&self, contact: usize) -> bool {
        self.friction[contact] > 0.0
    }

    /// Whether a contact is dry friction without a surface, whose normal force is given.
    pub(crate) fn is_dry(&self, contact: usize) -> bool {
        contact >= self.surfaces
    }

    /// Whether the bound of a dry friction follows forces of contacts.
    pub(crate) fn follows(&self, contact: usize) -> bool {
        !self.model.declaration().contacts[contact].loads.is_empty()
    }

    /// How the motion meets the zeros of a switch, if the contact is one.
    pub(crate) fn switch_of(&self, contact: usize) -> Option<Switching> {
        self.model.declaration().contacts[contact].switch
    }

    /// Whether a contact is a switch whose function is only passed.
    pub(crate) fn passes(&self, contact: usize) -> bool {
        self.switch_of(contact).is_some_and(Switching::passes)
    }

    /// The sliding velocity, or where it vanishes for a switch that is only passed a number with the sign of the side that acts.
    pub(crate) fn side(&self, contact: usize) -> f64 {
        match self.sides[contact] {
            0.0 => self.sliding_velocity(contact),
            side => side,
        }
    }

    /// Whether the ground of a contact moves that was evaluated with the velocities `v`.
    pub(crate) fn ground_moves(&self, contact: usize, v: &[f64]) -> bool {
        contains_ground(self.normal_velocity(contact), self.normal(contact), v)
            || self.has_friction(contact)
                && contains_ground(self.sliding_velocity(contact), self.tangent(contact), v)
    }

    /// Kinetic energy at `x` \[J\], `v' M v / 2`.
    pub(crate) fn kinetic_energy(&self, x: &[f64]) -> f64 {
        let (n, v) = (self.n, &x[self.n..2 * self.n]);
        let mut mass = vec![0.0; n * n];
        self.model.mass_matrix(x, &mut mass);
        let momentum = mass.chunks_exact(n.max(1)).map(|row| dot(row, v));
        0.5 * momentum.zip(v).map(|(p, v)| p * v).sum::<f64>()
    }

    /// Acceleration without contact forces.
    pub(crate) fn free_acceleration(&self) -> &[f64] {
        &self.acceleration
    }

    /// Contact force `lambda_i = r_i / D_i` for a normal contact acceleration, `lambda_t,i = s_i / D_i` for a
    /// tangential one.
    pub(crate) fn force(&self, contact: usize, r: f64) -> f64 {
        r / self.point(contact)[contact_point::INVERSE_INERTIA]
    }

    /// Gradient of the velocity of a line, up to its sign, and the velocity-dependent part of the acceleration.
    pub(crate) fn row(&self, line: Line) -> (&[f64], f64) {
        let side = |side: &'_ [f64]| side[tangent_point::CURVATURE];
        match line {
            Line::Normal { contact, .. } => (
                self.normal(contact),
                self.point(contact)[contact_point::CURVATURE],
            ),
            Line::Tangent { contact, .. } => {
                (self.tangent(contact), side(self.tangent_point(contact)))
            }
            Line::Across { contact } => {
                let across = self.across_point(contact);
                (&across[tangent_point::TANGENT..][..self.n], side(across))
            }
        }
    }

    /// Direction of the force of a line, up to its sign and without the share of friction in a normal.
    pub(crate) fn line_direction(&self, line: Line) -> &[f64] {
        match line {
            Line::Normal { contact, .. } => self.direction(contact),
            Line::Tangent { contact, .. } => self.friction_direction(contact),
            Line::Across { contact } => {
                &self.across_point(contact)[tangent_point::direction(self.n)..][..self.n]
            }
        }
    }

    /// Velocity of a line.
    pub(crate) fn velocity(&self, line: Line) -> f64 {
        match line {
            Line::Normal { contact, .. } => self.normal_velocity(contact),
            Line::Tangent { contact, sense } => sense * self.sliding_velocity(contact),
            Line::Across { contact } => self.sliding(contact).1,
        }
    }

    /// Acceleration of a line under the acceleration `a`.
    pub(crate) fn line_acceleration(&self, line: Line, a: &[f64]) -> f64 {
        let (row, curvature) = self.row(line);
        line.sense() * (dot(row, a) + curvature)
    }

    /// Acceleration of a line without contact forces.
    pub(crate) fn free_line_acceleration(&self, line: Line) -> f64 {
        self.line_acceleration(line, &self.acceleration)
    }

    /// Sum of the sizes of the terms of a line's acceleration without contact forces.
    pub(crate) fn terms(&self, line: Line) -> f64 {
        let (row, curvature) = self.row(line);
        sum_of_sizes(row, &self.acceleration) + curvature.abs()
    }

    /// Acceleration (or velocity) of line `row` for a unit force (or impulse) on line `column`.
    pub(crate) fn coupling(&self, row: Line, column: Line) -> f64 {
        if let Line::Normal { contact, .. } = row
            && self.is_dry(contact)
        {
            return match column {
                Line::Normal {
                    contact: other,
                    slope,
                } if slope != 0.0 => {
                    let rubbing = slope * self.loads.rubbing(contact, other);
                    self.loads.coupling(contact, other) + rubbing
                }
                Line::Normal { contact: other, .. } => self.loads.coupling(contact, other),
                Line::Tangent {
                    contact: other,
                    sense,
                } => sense * self.loads.rubbing(contact, other),
                Line::Across { .. } => 0.0,
            };
        }
        let (gradient, _) = self.row(row);
        let along = dot(gradient, self.line_direction(column));
        let along = match column {
            Line::Normal { contact, slope } if slope != 0.0 => {
                along + slope * dot(gradient, self.slip_direction(contact))
            }
            _ => along,
        };
        row.sense() * column.sense() * along
    }

    /// Couplings of `lines`, row-major: the Delassus matrix.
    pub(crate) fn couplings(&self, lines: &[Line]) -> Vec<f64> {
        if self.n >= LARGE && lines.len() >= MANY {
            let order = lines.len();
            let mut matrix = vec![0.0; order * order];
            for (row, column, value) in self.sparse_couplings(lines) {
                matrix[row * order + column] = value;
            }
            return matrix;
        }
        let pairs = lines
            .iter()
            .flat_map(|&row| lines.iter().map(move |&column| (row, column)));
        pairs
            .map(|(row, column)| self.coupling(row, column))
            .collect()
    }

    /// The couplings of `lines` that do not vanish, row by row: a contact is between two bodies, however many there are.
    pub(crate) fn sparse_couplings(&self, lines: &[Line]) -> Vec<Entry> {
        // What moves each coordinate: the column, its component, and whether it is of its friction.
        let mut movers: Vec<Vec<(usize, f64, usize)>> = vec![Vec::new(); self.n];
        let nonzero = |(_, value): &(usize, &f64)| **value != 0.0;
        for (column, &line) in lines.iter().enumerate() {
            let along = self.line_direction(line).iter().enumerate();
            for (k, &d) in along.filter(nonzero) {
                movers[k].push((column, d, 0));
            }
            if let Line::Normal { contact, slope } = line
                && slope != 0.0
            {
                let along = self.slip_direction(contact).iter().enumerate();
                for (k, &e) in along.filter(nonzero) {
                    movers[k].push((column, e, 1));
                }
            }
        }
        let mut sums = vec![[0.0; 2]; lines.len()];
        let mut met = vec![false; lines.len()];
        let mut entries = Vec::new();
        for (row, &line) in lines.iter().enumerate() {
            if matches!(line, Line::Normal { contact, .. } if self.is_dry(contact)) {
                let values = lines.iter().map(|&other| self.coupling(line, other));
                let values = values.enumerate().filter(|(_, value)| *value != 0.0);
                entries.extend(values.map(|(column, value)| (row, column, value)));
                continue;
            }
            for (k, &component) in self.row(line).0.iter().enumerate().filter(nonzero) {
                for &(column, d, part) in &movers[k] {
                    sums[column][part] += component * d;
                    met[column] = true;
                }
            }
            for (column, &other) in lines.iter().enumerate() {
                if !std::mem::take(&mut met[column]) {
                    continue;
                }
                let [along, slip] = std::mem::take(&mut sums[column]);
                let value = match other {
                    Line::Normal { slope, .. } if slope != 0.0 => along + slope * slip,
                    _ => along,
                };
                if value != 0.0 {
                    entries.push((row, column, line.sense() * other.sense() * value));
                }
            }
        }
        entries
    }

    /// Adds a force of size `value` on `line` to an acceleration, or an impulse to a velocity.
    pub(crate) fn push(&self, line: Line, value: f64, to: &mut [f64]) {
        let mut add = |direction: &[f64], value: f64| {
            for (component, d) in to.iter_mut().zip(direction) {
                *component += d * value;
            }
        };
        add(self.line_direction(line), line.sense() * value);
        if let Line::Normal { contact, slope } = line
            && slope != 0.0
        {
            add(self.slip_direction(contact), slope * value);
        }
    }

    /// `n' (d + ratio e)`: the normal acceleration for one unit of a contact's `r` if its tangential force is `ratio` times as
    /// large. Not above zero, friction jams the contact.
    pub(crate) fn gain(&self, contact: usize, ratio: f64) -> f64 {
        let own = Line::normal(contact);
        self.coupling(own, own) + ratio * self.pull(contact)
    }

    /// What a unit of its own friction adds to the normal acceleration of a contact, `n' e`; of a bound that follows it, less what it adds
    /// to that.
    pub(crate) fn pull(&self, contact: usize) -> f64 {
        if self.is_dry(contact) && self.follows(contact) {
            return self.loads.rubbing(contact, contact);
        }
        dot(self.normal(contact), self.slip_direction(contact))
    }
}

/// Sum of the sizes of the terms of a scalar product.
pub(crate) fn sum_of_sizes(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x * y).abs()).sum()
}
