//! The velocities that a contact mode holds at zero, and the directions of the forces that hold them.

use super::redundancy::Redundancy;
use crate::contact::{ActiveContact, force_count, sum_of_sizes};
use crate::linalg::products::dot;
use crate::linalg::products::products;
use crate::model::{
    Frame, Function, Model, contact_point, friction_coefficients, kinetic_coefficients, surfaces,
    tangent_point,
};

/// The constraints of a contact mode at one point: first the normals of the active contacts, those of dry friction last,
/// then the tangents of those that stick. Owns the memory for them.
///
/// The normal of dry friction holds no velocity: its force is given.
pub(super) struct Constraints<'a> {
    model: &'a dyn Model,
    n: usize,
    active: Vec<ActiveContact>,
    friction: Vec<f64>,
    /// Coefficients of friction of contacts that slide.
    kinetic: Vec<f64>,
    /// What given forces follow of those of surfaces: both constraints, and the factor.
    pub(super) loads: Vec<(usize, usize, f64)>,
    /// Number of contacts of the scene that are surfaces, and of those that are active.
    surfaces: usize,
    pub(super) normals: usize,
    /// Gaps of the active surfaces.
    pub(super) gaps: Vec<f64>,
    /// Rounding error of the gaps at the last evaluation, the largest of them.
    pub(super) gap_rounding: f64,
    /// Time over which the constraints are held, which their rounding errors scale with \[s\].
    length: f64,
    /// Inverse inertia of the contact of each constraint.
    inertia: Vec<f64>,
    /// Which constraints follow from others, of velocities and of positions.
    pub(super) redundancy: [Redundancy; 2],
    /// Whether those of this mode are known to be independent.
    independent: bool,
    /// Velocities of all constraints; of dry friction the given normal acceleration.
    pub(super) velocities: Vec<f64>,
    /// Derivatives of the velocities with respect to `v`, one row a constraint: `n_i`, then `b_i`.
    pub(super) gradients: Vec<f64>,
    /// Directions of the forces, one row a constraint: `d_i`, or `d_i -+ mu_i e_i` in slip; then `e_i`.
    pub(super) directions: Vec<f64>,
    /// Derivatives of the velocities with respect to `q`, one row a constraint.
    pub(super) turning: Vec<f64>,
    point: Vec<f64>,
    tangent: Vec<f64>,
    /// Frames of contacts in space; empty without any.
    frames: Vec<Frame>,
    /// The second tangential side of one of them.
    across: Vec<f64>,
    contact_jacobian: Vec<f64>,
    tangent_jacobian: Vec<f64>,
}

impl<'a> Constraints<'a> {
    pub(super) fn new(model: &'a dyn Model) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let contacts = declaration.contacts.iter();
        let largest = |sizes: &mut dyn Iterator<Item = usize>| sizes.max().unwrap_or(0);
        let tangents = contacts.clone().filter_map(|contact| contact.friction);
        Self {
            model,
            n,
            active: Vec::new(),
            friction: friction_coefficients(model),
            kinetic: kinetic_coefficients(model),
            loads: Vec::new(),
            surfaces: surfaces(model),
            normals: 0,
            gaps: Vec::new(),
            gap_rounding: 0.0,
            length: 0.0,
            inertia: Vec::new(),
            redundancy: Default::default(),
            independent: false,
            velocities: Vec::new(),
            gradients: Vec::new(),
            directions: Vec::new(),
            turning: Vec::new(),
            point: vec![0.0; contact_point::length(n)],
            tangent: vec![0.0; tangent_point::length(n)],
            frames: Vec::new(),
            across: vec![0.0; tangent_point::length(n)],
            contact_jacobian: vec![0.0; largest(&mut contacts.map(|c| c.jacobian.entries.len()))],
            tangent_jacobian: vec![0.0; largest(&mut tangents.map(|t| t.jacobian.entries.len()))],
        }
    }

    /// Active contacts.
    pub(super) fn active(&self) -> &[ActiveContact] {
        &self.active
    }

    /// Number of constraints that hold positions as well.
    pub(super) fn positions(&self) -> usize {
        self.gaps.len()
    }

    /// Whether the force of a constraint is given.
    pub(super) fn is_given(&self, constraint: usize) -> bool {
        (self.normals..self.active.len()).contains(&constraint)
    }

    /// Number of constraints.
    pub(super) fn count(&self) -> usize {
        self.velocities.len()
    }

    /// Changes the contact mode.
    pub(super) fn set_mode(&mut self, active: &[ActiveContact]) {
        self.active.clear();
        self.active.extend_from_slice(active);
        let count = force_count(active);
        let of_surface = |held: &&ActiveContact| held.contact < self.surfaces;
        self.normals = active.iter().filter(of_surface).count();
        self.gaps.resize(self.normals, 0.0);
        self.independent = false;
        self.redundancy = Default::default();
        self.inertia.resize(count, 0.0);
        self.velocities.resize(count, 0.0);
        self.gradients.resize(count * self.n, 0.0);
        self.directions.resize(count * self.n, 0.0);
        self.turning.resize(count * self.n, 0.0);
    }

    /// Sets the frames in which contacts in space slide.
    pub(super) fn set_frames(&mut self, frames: &[Frame]) {
        self.frames.clear();
        self.frames.extend_from_slice(frames);
    }

    /// Lets the frames of contacts in space that slip point along their sliding velocities at the start `x` of an element.
    pub(super) fn align(&mut self, x: &[f64]) {
        for place in 0..self.active.len() {
            let held = self.active[place];
            if held.state.sense() == 0.0 || !self.is_in_space(held.contact) {
                continue;
            }
            self.evaluate_sides(held.contact, x);
            let velocity = (
                self.tangent[tangent_point::SLIDING_VELOCITY],
                self.across[tangent_point::SLIDING_VELOCITY],
            );
            let frame = &mut self.frames[held.contact];
            if velocity.0.hypot(velocity.1) > frame.soft {
                frame.align(velocity);
            }
        }
    }

    fn is_in_space(&self, contact: usize) -> bool {
        let friction = self.model.declaration().contacts[contact].friction;
        !self.frames.is_empty() && friction.is_some_and(|friction| friction.across.is_some())
    }

    /// Evaluates the tangential side of a contact, in space both of them in their frame.
    fn evaluate_sides(&mut self, contact: usize, x: &[f64]) {
        self.model.tangent(contact, x, &mut self.tangent);
        if self.is_in_space(contact) {
            self.model
                .values(Function::Across(contact), x, &mut self.across);
            self.frames[contact].turn(&mut self.tangent, &mut self.across);
        }
    }

    /// Finds the constraints that follow from others as last evaluated; once in a mode, unless there are some.
    pub(super) fn find_redundancy(&mut self) {
        let count = self.count();
        if self.independent || count < 2 {
            return;
        }
        let (couplings, measures) = (self.couplings(), self.measures());
        let positions = self.positions();
        let of_positions: Vec<f64> = couplings
            .chunks_exact(count)
            .take(positions)
            .flat_map(|row| &row[..positions])
            .copied()
            .collect();
        self.redundancy = [
            Redundancy::of(&couplings, &measures),
            Redundancy::of(&of_positions, &measures[..positions]),
        ];
        self.independent = self.redundancy.iter().all(Redundancy::is_empty);
    }

    /// Takes the smallest of forces that give the same motion as last evaluated, where some constraints follow from others.
    pub(super) fn turn_redundancy(&mut self) {
        if !self.redundancy[0].is_empty() {
            let (couplings, measures) = (self.couplings(), self.measures());
            self.redundancy[0].turn(couplings, &measures);
        }
    }

    /// Motion of each constraint by the force of each as last evaluated, row-major.
    fn couplings(&self) -> Vec<f64> {
        let count = self.count();
        let mut couplings = vec![0.0; count * count];
        for (row, column, value) in products(&self.gradients, &self.directions, self.n) {
            if !self.is_given(row) {
                couplings[row * count + column] = value;
            }
        }
        for row in self.normals..self.active.len() {
            couplings[row * count + row] = 1.0;
        }
        couplings
    }

    /// Measures of the forces and of the equations of the constraints as last evaluated, by the inertia of each.
    fn measures(&self) -> Vec<(f64, f64)> {
        let n = self.n;
        let own = |row: usize| {
            let gradient = &self.gradients[row * n..(row + 1) * n];
            let direction = &self.directions[row * n..(row + 1) * n];
            dot(gradient, direction).abs()
        };
        let measure = |row: usize, coupling: f64| {
            let inertia = self.inertia[row].abs();
            let unit = (coupling / inertia).sqrt();
            if unit > 0.0 && inertia > 0.0 {
                (unit, 1.0 / (unit * inertia))
            } else {
                (1.0, 1.0)
            }
        };
        // By a normal force without friction the contact itself moves by 1.
        let mut measures: Vec<(f64, f64)> = (0..self.active.len())
            .map(|row| match self.is_given(row) {
                true => (1.0, 1.0),
                false => measure(row, 1.0),
            })
            .collect();
        for held in &self.active {
            let first = measures.len();
            let rows = first..first + held.state.stuck();
            let largest = rows.clone().map(own).fold(0.0, f64::max);
            measures.extend(rows.map(|row| measure(row, largest)));
        }
        measures
    }

    /// Sets the length of the element that holds the constraints.
    pub(super) fn set_length(&mut self, length: f64) {
        self.length = length;
    }

    /// Whether the tangential side of an active contact matters.
    fn needs_tangent(&self, held: ActiveContact) -> bool {
        held.state.rubs()
    }

    /// Ratio `s / r` of an active contact.
    fn slope(&self, held: ActiveContact) -> f64 {
        let frictions = (self.friction[held.contact], self.kinetic[held.contact]);
        held.state.force_ratio(frictions)
    }

    /// What the given force of an active contact follows, where it follows any.
    fn evaluate_loads(&mut self, place: usize, x: &[f64]) {
        let contact = self.active[place].contact;
        let followed = self.model.declaration().contacts[contact].loads;
        if followed.is_empty() {
            return;
        }
        let mut factors = vec![0.0; followed.len()];
        self.model.loads(contact, x, &mut factors);
        let contacts = self.friction.len();
        for (&other, factor) in followed.iter().zip(factors) {
            let on = self
                .active
                .iter()
                .position(|held| held.contact == other % contacts);
            let Some(on) = on else { continue };
            let (on, factor) = match other < contacts {
                true => (on, factor),
                false => self.rubbing(on, factor),
            };
            self.loads.push((place, on, factor));
        }
    }

    /// The unknown that the friction of an active contact is, or follows, and a factor of that friction as one of it.
    fn rubbing(&self, place: usize, factor: f64) -> (usize, f64) {
        let held = self.active[place];
        if held.state.sticks() {
            let before = self.active[..place].iter();
            let stuck: usize = before.map(|held| held.state.stuck()).sum();
            return (self.active.len() + stuck, factor);
        }
        (place, factor * self.slope(held))
    }

    /// Evaluates gaps, velocities, gradients and directions at the input vector `x`.
    pub(super) fn evaluate(&mut self, x: &[f64]) {
        let n = self.n;
        let mut stuck = self.active.len();
        self.gap_rounding = 0.0;
        self.loads.clear();
        for i in self.normals..self.active.len() {
            self.evaluate_loads(i, x);
        }
        for (i, &held) in self.active.iter().enumerate() {
            self.model.contact(held.contact, x, &mut self.point);
            let given = self.is_given(i);
            if !given {
                self.gaps[i] = self.point[contact_point::GAP];
            }
            let normal = &self.point[contact_point::NORMAL..][..n];
            let size =
                sum_of_sizes(normal, &x[..n]) + self.length * sum_of_sizes(normal, &x[n..2 * n]);
            self.gap_rounding = self.gap_rounding.max(f64::EPSILON * size);
            self.inertia[i] = self.point[contact_point::INVERSE_INERTIA];
            self.velocities[i] = if given {
                -self.point[contact_point::CURVATURE]
            } else {
                self.point[contact_point::NORMAL_VELOCITY]
            };
            self.gradients[i * n..(i + 1) * n]
                .copy_from_slice(&self.point[contact_point::NORMAL..][..n]);
            let along = &self.point[contact_point::direction(n)..];
            self.directions[i * n..(i + 1) * n].copy_from_slice(along);
            if !self.needs_tangent(held) {
                continue;
            }
            let in_space = self.is_in_space(held.contact);
            self.model.tangent(held.contact, x, &mut self.tangent);
            if in_space {
                self.model
                    .values(Function::Across(held.contact), x, &mut self.across);
                self.frames[held.contact].turn(&mut self.tangent, &mut self.across);
            }
            let sides = [&self.tangent, &self.across];
            for side in &sides[..held.state.stuck()] {
                self.inertia[stuck] = self.inertia[i];
                self.velocities[stuck] = side[tangent_point::SLIDING_VELOCITY];
                self.gradients[stuck * n..(stuck + 1) * n]
                    .copy_from_slice(&side[tangent_point::TANGENT..][..n]);
                self.directions[stuck * n..(stuck + 1) * n]
                    .copy_from_slice(&side[tangent_point::direction(n)..]);
                stuck += 1;
            }
            if held.state.sticks() {
                continue;
            }
            let mut slope = self.slope(held);
            if in_space {
                let velocities = sides.map(|side| side[tangent_point::SLIDING_VELOCITY]);
                let frame = &self.frames[held.contact];
                let slide = frame.direction((velocities[0], velocities[1]));
                let across = &self.across[tangent_point::direction(n)..];
                for (d, e) in self.directions[i * n..].iter_mut().zip(across) {
                    *d += slope * slide.across * e;
                }
                slope *= slide.along;
            }
            let along = &self.tangent[tangent_point::direction(n)..];
            for (d, e) in self.directions[i * n..].iter_mut().zip(along) {
                *d += slope * e;
            }
        }
    }

    /// Evaluates everything at `x`, and adds the derivatives of the `forces` times their directions with
    /// respect to `q` and `v` to the row-major `by_q` and `by_v`. Directions of contacts depend on `q` only, those of switches
    /// on `v` as well, as does their given force.
    pub(super) fn differentiate(
        &mut self,
        x: &[f64],
        forces: &[f64],
        (by_q, by_v): (&mut [f64], &mut [f64]),
    ) {
        self.evaluate(x);
        self.turning.fill(0.0);
        let n = self.n;
        let contacts = self.model.declaration().contacts;
        let mut stuck = self.active.len();
        for i in 0..self.active.len() {
            let held = self.active[i];
            let declaration = &contacts[held.contact];
            let entries = declaration.jacobian.entries;
            let values = &mut self.contact_jacobian[..entries.len()];
            self.model
                .jacobian(Function::Contact(held.contact), x, values);
            let r = forces[i];
            for (&(row, column), value) in entries.iter().zip(&*values) {
                let (row, column) = (row as usize, column as usize);
                if column >= n {
                    if row == 1 && column < 2 * n && declaration.dry {
                        self.gradients[i * n + column - n] = *value;
                    }
                    continue;
                }
                match row {
                    0 => {}
                    1 => self.turning[i * n + column] = *value,
                    _ => by_q[(row - 2) * n + column] += r * value,
                }
            }
            if !self.needs_tangent(held) {
                continue;
            }
            let Some(friction) = &declaration.friction else {
                continue;
            };
            if self.is_in_space(held.contact) {
                self.differentiate_in_space(
                    x,
                    (held, stuck),
                    (r, forces),
                    (&mut *by_q, &mut *by_v),
                );
                stuck += held.state.stuck();
                continue;
            }
            let slope = self.slope(held);
            let entries = friction.jacobian.entries;
            let values = &mut self.tangent_jacobian[..entries.len()];
            self.model
                .jacobian(Function::Tangent(held.contact), x, values);
            let s = if held.state.sticks() {
                forces[stuck]
            } else {
                slope * r
            };
            for (&(row, column), value) in entries.iter().zip(&*values) {
                let (row, column) = (row as usize, column as usize);
                if column >= n {
                    if row > 0 && column < 2 * n {
                        by_v[(row - 1) * n + column - n] += s * value;
                    }
                    continue;
                }
                if row > 0 {
                    by_q[(row - 1) * n + column] += s * value;
                } else if held.state.sticks() {
                    self.turning[stuck * n + column] = *value;
                }
            }
            stuck += usize::from(held.state.sticks());
        }
    }

    /// The share of a contact in space in [`differentiate`](Self::differentiate): `stuck` is its first tangential constraint, `r` its
    /// normal force.
    fn differentiate_in_space(
        &mut self,
        x: &[f64],
        (held, stuck): (ActiveContact, usize),
        (r, forces): (f64, &[f64]),
        (by_q, by_v): (&mut [f64], &mut [f64]),
    ) {
        let n = self.n;
        self.evaluate_sides(held.contact, x);
        let frame = self.frames[held.contact];
        let velocity = (
            self.tangent[tangent_point::SLIDING_VELOCITY],
            self.across[tangent_point::SLIDING_VELOCITY],
        );
        let slide = frame.direction(velocity);
        let slip = self.slope(held) * r;
        let sides = if held.state.sticks() {
            (forces[stuck], forces[stuck + 1])
        } else {
            (slip * slide.along, slip * slide.across)
        };
        // Rows of both sliding velocities by the coordinates, and what turns both directions.
        let mut turning = [vec![0.0; n], vec![0.0; n]];
        let weights = frame.outside(sides);
        let friction = self.model.declaration().contacts[held.contact].friction;
        let patterns = friction.and_then(|known| Some([known.jacobian, known.across?]));
        let Some(patterns) = patterns else { return };
        for (k, pattern) in patterns.into_iter().enumerate() {
            let mut values = vec![0.0; pattern.entries.len()];
            match k {
                0 => self
                    .model
                    .jacobian(Function::Tangent(held.contact), x, &mut values),
                _ => self
                    .model
                    .jacobian(Function::Across(held.contact), x, &mut values),
            }
            let weight = if k == 0 { weights.0 } else { weights.1 };
            for (&(row, column), value) in pattern.entries.iter().zip(values) {
                let (row, column) = (row as usize, column as usize);
                match row {
                    _ if column >= n => {}
                    0 => turning[k][column] = value,
                    _ => by_q[(row - 1) * n + column] += weight * value,
                }
            }
        }
        let [first, second] = &mut turning;
        frame.turn(first, second);
        if held.state.sticks() {
            self.turning[stuck * n..(stuck + 1) * n].copy_from_slice(first);
            self.turning[(stuck + 1) * n..(stuck + 2) * n].copy_from_slice(second);
            return;
        }
        // The force turns with the velocity.
        let directions =
            [&self.tangent, &self.across].map(|side| &side[tangent_point::direction(n)..]);
        let gradients =
            [&self.tangent, &self.across].map(|side| &side[tangent_point::TANGENT..][..n]);
        let turning = [first, second];
        for row in 0..n {
            for k in 0..2 {
                let turned: f64 = (0..2)
                    .map(|side| slip * directions[side][row] * slide.by[side][k])
                    .sum();
                for column in 0..n {
                    by_q[row * n + column] += turned * turning[k][column];
                    by_v[row * n + column] += turned * gradients[k][column];
                }
            }
        }
    }
}
