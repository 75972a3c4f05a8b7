//! How large the system of an element is, from the patterns of the model.

use crate::contact::ActiveContact;
use crate::model::{Model, contact_point, surfaces, tangent_point};
use crate::size::{Purpose, SizeGroup, Tally};

/// Which entries of the blocks of a Newton matrix are not always 0.
struct Pattern {
    n: usize,
    /// Derivatives of the acceleration with respect to `q`, and to `q` or `v`, row-major.
    by_q: Vec<bool>,
    by_state: Vec<bool>,
    /// Derivatives of the velocities of the constraints with respect to `q` and to `v`, one row a constraint.
    turning: Vec<Vec<bool>>,
    gradients: Vec<Vec<bool>>,
    /// Directions of the forces.
    directions: Vec<Vec<bool>>,
}

/// Whether two rows have an entry in the same place.
fn meet(one: &[bool], other: &[bool]) -> bool {
    one.iter().zip(other).any(|(a, b)| *a && *b)
}

impl Pattern {
    fn of(model: &dyn Model, active: &[ActiveContact], x: &[f64]) -> Self {
        let declaration = model.declaration();
        let n = declaration.coordinates.len();
        let mut pattern = Self {
            n,
            by_q: vec![false; n * n],
            by_state: vec![false; n * n],
            turning: Vec::new(),
            gradients: Vec::new(),
            directions: Vec::new(),
        };
        for &(row, column) in declaration.free_jacobian.entries {
            let (row, column) = (row as usize, column as usize);
            if column < 2 * n {
                pattern.by_state[row * n + column % n] = true;
            }
            if column < n {
                pattern.by_q[row * n + column] = true;
            }
        }
        let mut point = vec![0.0; contact_point::length(n)];
        let mut tangent = vec![0.0; tangent_point::length(n)];
        for held in active {
            let entries = declaration.contacts[held.contact].jacobian.entries;
            model.contact(held.contact, x, &mut point);
            let values = &point[contact_point::direction(n)..];
            pattern.add(entries, (Some(0), 1, 2), values);
        }
        for (i, held) in active.iter().enumerate() {
            let contact = &declaration.contacts[held.contact];
            let Some(friction) = contact.friction.filter(|_| held.state.rubs()) else {
                continue;
            };
            model.tangent(held.contact, x, &mut tangent);
            let values = &tangent[tangent_point::direction(n)..];
            pattern.add(friction.jacobian.entries, (None, 0, 1), values);
            if let Some(across) = friction.across {
                model.across(held.contact, x, &mut tangent);
                let values = &tangent[tangent_point::direction(n)..];
                pattern.add(across.entries, (None, 0, 1), values);
            }
            let sides = if friction.across.is_some() { 2 } else { 1 };
            for _ in held.state.stuck()..sides {
                // It slips along one direction, which friction turns.
                let across = pattern.directions.pop().unwrap_or_default();
                pattern.turning.pop();
                pattern.gradients.pop();
                for (d, e) in pattern.directions[i].iter_mut().zip(across) {
                    *d |= e;
                }
            }
        }
        pattern
    }

    /// Adds a constraint whose gap, velocity and direction have these rows; `values` are those of the direction.
    fn add(
        &mut self,
        entries: &[(u32, u32)],
        (gap, velocity, direction): (Option<usize>, usize, usize),
        values: &[f64],
    ) {
        let n = self.n;
        let (mut turning, mut gradient) = (vec![false; n], vec![false; n]);
        let mut along: Vec<bool> = values.iter().take(n).map(|d| *d != 0.0).collect();
        for &(row, column) in entries {
            let (row, column) = (row as usize, column as usize);
            if Some(row) == gap && column < n {
                gradient[column] = true;
            } else if row == velocity && column < n {
                turning[column] = true;
            } else if row == velocity && column < 2 * n {
                gradient[column - n] = true;
            } else if row >= direction && column < n {
                self.by_q[(row - direction) * n + column] = true;
                self.by_state[(row - direction) * n + column] = true;
                along[row - direction] = true;
            }
        }
        self.turning.push(turning);
        self.gradients.push(gradient);
        self.directions.push(along);
    }
}

/// Purposes of the unknowns of a stage, which are those of its equations: accelerations, forces, corrections.
fn purposes(n: usize, active: &[ActiveContact], normals: usize) -> Vec<Purpose> {
    let sticking: usize = active.iter().map(|held| held.state.stuck()).sum();
    let forces = active.len() + sticking;
    let mut purposes = vec![Purpose::State; n];
    purposes.resize(n + normals, Purpose::ContactForce);
    purposes.resize(n + forces, Purpose::Friction);
    purposes.resize(n + forces + normals, Purpose::Gap);
    purposes
}

/// Adds the rows of joints that are held at the end of an element, each with what it moves the state by.
fn add_joints(tally: &mut Tally, model: &dyn Model) {
    let Some(joints) = model.declaration().joints else {
        return;
    };
    let rows = joints.equations().enumerate();
    let held: Vec<bool> = rows
        .filter(|&(row, _)| model.joint_row_held(row))
        .map(|(_, (joint, _))| joint.holonomic)
        .collect();
    let positions = held.iter().filter(|holonomic| **holonomic).count();
    let size = tally.of(Purpose::Joint);
    size.variables += held.len() + positions;
    size.equalities += held.len() + positions;
    // One small matrix moves both.
    size.jacobian_nonzeros += held.len() * held.len();
}

/// Adds the signs that are watched of contacts.
fn add_signs(tally: &mut Tally, model: &dyn Model, active: &[ActiveContact], stages: usize) {
    let surfaces = surfaces(model);
    // One sign of the gap or the force of each contact is watched, and one of each friction.
    for contact in 0..model.declaration().contacts.len() {
        let held = active.iter().find(|held| held.contact == contact);
        if contact < surfaces {
            let sign = held.map_or(Purpose::Gap, |_| Purpose::ContactForce);
            tally.of(sign).inequalities += stages;
        }
        if held.is_some_and(|held| held.state.rubs()) {
            tally.of(Purpose::Friction).inequalities += stages;
        }
    }
}

/// The groups of an element with that many `stages` in a contact mode, in physical time, or in numerical time if the clock
/// is `slowed`. `x` is an input of the model at which directions show which of their components are not always 0.
pub(crate) fn groups(
    model: &dyn Model,
    active: &[ActiveContact],
    stages: usize,
    slowed: bool,
    x: &[f64],
) -> Vec<SizeGroup> {
    let pattern = Pattern::of(model, active, x);
    let surfaces = surfaces(model);
    let contacts = active.iter().filter(|held| held.contact < surfaces).count();
    let (n, forces) = (pattern.n, pattern.directions.len());
    let purposes = purposes(n, active, contacts);
    let row_of = |matrix: &[bool], k: usize| matrix[k * n..(k + 1) * n].to_vec();
    let explicit_time = model.declaration().explicit_time;
    // Whether an entry is in all blocks, and whether in those of a stage with itself.
    let entry = |row: usize, column: usize| -> (bool, bool) {
        let clock = slowed && (n..n + contacts).contains(&column);
        let (row_by_q, row_by_state) = if row < n {
            (row_of(&pattern.by_q, row), row_of(&pattern.by_state, row))
        } else if row < n + forces {
            let (turning, gradient) = (&pattern.turning[row - n], &pattern.gradients[row - n]);
            let both = turning.iter().zip(gradient).map(|(a, b)| *a || *b);
            (turning.clone(), both.collect())
        } else {
            let gradient = &pattern.gradients[row - n - forces];
            (gradient.clone(), gradient.clone())
        };
        if column == row && (n + contacts..n + active.len()).contains(&row) {
            // A given force.
            return (false, true);
        }
        let through = clock && (row_by_state.contains(&true) || (row < n && explicit_time));
        if column < n {
            (row_by_state[column], row == column)
        } else if column < n + forces {
            (through, row < n && pattern.directions[column - n][row])
        } else {
            let correction = &pattern.directions[column - n - forces];
            (meet(&row_by_q, correction), false)
        }
    };
    let mut tally = Tally::default();
    for (row, &purpose) in purposes.iter().enumerate() {
        let size = tally.of(purpose);
        size.variables += stages;
        size.equalities += stages;
        for (column, &other) in purposes.iter().enumerate() {
            tally.of(purpose.max(other)).jacobian_nonzeros += match entry(row, column) {
                (true, _) => stages * stages,
                (false, true) => stages,
                (false, false) => 0,
            };
        }
    }
    add_signs(&mut tally, model, active, stages);
    add_joints(&mut tally, model);
    tally.groups()
}

#[cfg(test)]
mod tests {
    use super::super::{FiniteElement, State, assembly, newton};
    use super::*;
    use crate::contact::ContactState;
    use crate::model::ControlPiece;
    use crate::rk::{ButcherTableau, Scheme};

    crate::model! {
        /// A point mass on wavy ground that rubs, in a wind.
        Wave {
            parameters { m: kg = 2, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2, w: N*s/m = 0.1 }
            coordinates { y: m, z: m }
            lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
            forces { y: -w*dot(y) + 1[N/s]*t }
            surface ground: z >= a*cos(k*y)
            impact ground: inelastic, friction 0.3
            start { z: a }
        }
    }

    /// Nonzero entries of the assembled matrix of a solved element.
    fn counted(model: &Wave, mode: &[ActiveContact], numerical: bool, v: f64) -> usize {
        let tableau = ButcherTableau::new(Scheme::RadauIia, 3).unwrap();
        let mut element = FiniteElement::new(model, &tableau);
        if numerical {
            element = element.in_numerical_time(20.0);
        }
        element.set_mode(mode);
        let (y, a, k) = (0.4_f64, 0.2, 2.0);
        let start = State {
            time: 0.1,
            q: vec![y, a * (k * y).cos()],
            v: vec![v, -a * k * (k * y).sin() * v],
        };
        newton::solve(&mut element, &start, 0.01, &ControlPiece::default()).unwrap();
        assembly::assemble(&mut element);
        element.matrix.iter().filter(|entry| **entry != 0.0).count()
    }

    #[test]
    fn nonzeros_are_those_of_the_assembled_matrix() {
        let model = Wave::default();
        let held = |state| vec![ActiveContact { contact: 0, state }];
        // At a point that is not special, so that nothing vanishes by chance.
        let x = [0.4, 0.2 * 0.8_f64.cos(), 0.3, -0.1, 0.1];
        for numerical in [false, true] {
            for (mode, v) in [
                (Vec::new(), 0.7),
                (held(ContactState::Frictionless), 0.7),
                (held(ContactState::slip(1.0)), 0.7),
                (held(ContactState::Stick), 0.0),
            ] {
                let groups = groups(&model, &mode, 3, numerical, &x);
                let sum: usize = groups.iter().map(|g| g.size.jacobian_nonzeros).sum();
                let counted = counted(&model, &mode, numerical, v);
                assert_eq!(sum, counted, "{mode:?}, numerical time: {numerical}");
            }
        }
    }
}
