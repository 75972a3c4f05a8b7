//! Forces of contacts that share a load in more than one way: a beam on three points, a box between others.
//!
//! A motion needs as many forces as there are independent contacts, and carries zeros for the others. Where contacts without
//! friction touch that the loaded ones hold in place, all forces `lambda` with
//!
//! ```text
//! N' M^-1 N lambda = N' M^-1 N lambda_0
//! ```
//!
//! give the same motion. The smallest of them are recorded, measured as the [impulses](super::impulse) are,
//! if none of them pulls; and the result says so.

use super::Simulation;
use crate::contact::shares::{self, Shares};
use crate::contact::{ActiveContact, ContactState, stuck, unbiased_lines};
use crate::fesd::contacts::{Contacts, Line};
use crate::linalg::dense;
use crate::linalg::least_norm::LeastNorm;
use crate::model::{Model, friction_share, pair_size};
use crate::yardstick;

/// Takes the smallest forces where several give the same motion, and says so.
pub(super) fn record(model: &dyn Model, result: &mut Simulation) {
    if model.declaration().contacts.len() < 2 {
        return;
    }
    let mut contacts = Contacts::new(model);
    let largest = |rows: &[Vec<f64>]| {
        let values = rows.iter().flatten();
        values.fold(0.0_f64, |most, value| most.max(value.abs()))
    };
    let sizes = (largest(&result.trajectory.q), largest(&result.trajectory.v));
    let (mut shared, mut left, mut decided) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..result.trajectory.time.len() {
        let touching = touching(&mut contacts, (model, sizes), result, k);
        if touching.iter().any(|&i| contacts.is_in_space(i)) {
            let told = match in_space(&mut contacts, &touching, sizes.1, (result, k)) {
                Told::Nothing => continue,
                Told::Smallest => &mut shared,
                Told::Left => &mut left,
                Told::Decide => &mut decided,
            };
            told.extend(touching);
            continue;
        }
        let Some(forces) = result.trajectory.contact_force.get_mut(k) else {
            break;
        };
        if touching.iter().all(|&i| forces[i] != 0.0) || touching.len() < 2 {
            continue;
        }
        let redundant = redundant(&contacts, &touching, forces);
        if redundant.is_empty() {
            continue;
        }
        let plain = touching.iter().all(|&i| contacts.friction(i) == 0.0);
        let found = if plain {
            smallest(&contacts, &touching, forces)
        } else {
            None
        };
        let told = match found {
            Some(found) => {
                for (&i, force) in touching.iter().zip(found) {
                    forces[i] = force;
                }
                &mut shared
            }
            None => &mut left,
        };
        told.extend(redundant);
    }
    say(model, result, [shared, left, decided]);
}

/// Notes the contacts whose forces are the smallest of several, one way of several, or decide the motion.
fn say(model: &dyn Model, result: &mut Simulation, told: [Vec<usize>; 3]) {
    let names = |mut contacts: Vec<usize>| {
        contacts.sort_unstable();
        contacts.dedup();
        let declared = model.declaration().contacts;
        let first = contacts.first().map(|&i| declared[i].name)?;
        Some(match contacts.len() {
            1 => format!("`{first}` shares its load with others"),
            more => format!(
                "`{first}` and {} more contacts share their load with others",
                more - 1
            ),
        })
    };
    let what = [
        "of the forces that give the same motion the smallest are recorded",
        "the forces that are recorded are one way of several, with the same motion",
        "the motion depends on it while they slide, and is that of the smallest forces",
    ];
    for (contacts, what) in told.into_iter().zip(what) {
        if let Some(names) = names(contacts) {
            let note = format!("{names} in more ways than one: {what}");
            result.notes.push(note);
        }
    }
}

/// What is to be said of the forces at one instant.
enum Told {
    Nothing,
    /// The smallest are recorded.
    Smallest,
    /// They are as they were found.
    Left,
    /// The motion depends on them.
    Decide,
}

/// Records the smallest forces that the laws allow at the `k`-th instant, of contacts that touch in space, where they are not the only ones.
/// Contacts slower than rounding of the largest `speed` stick.
fn in_space(
    contacts: &mut Contacts<'_>,
    touching: &[usize],
    speed: f64,
    (result, k): (&mut Simulation, usize),
) -> Told {
    let trajectory = &mut result.trajectory;
    let loaded = |i: usize| trajectory.contact_force[k][i] != 0.0;
    if touching.len() < 2 || !touching.iter().any(|&i| loaded(i)) {
        return Told::Nothing;
    }
    let (mut normals, mut tangents) = (Vec::new(), Vec::new());
    for &contact in touching {
        let sliding = contacts.sliding(contact);
        let mut slope = 0.0;
        if contacts.has_friction(contact) && pair_size(sliding) > yardstick::NOTHING * speed {
            contacts.align(contact, Some(sliding));
            slope = -contacts.kinetic(contact) * contacts.side(contact).signum();
        } else if contacts.has_friction(contact) {
            let state = ContactState::sticking(contacts.is_in_space(contact));
            tangents.extend(stuck(contact, state));
        }
        normals.push(Line::Normal { contact, slope });
    }
    let lines = [normals, tangents].concat();
    let matrix = contacts.couplings(&lines);
    let (mut factors, mut pivots) = (matrix.clone(), vec![0; lines.len()]);
    if dense::factorize_independent(&mut factors, &mut pivots) {
        return Told::Nothing;
    }
    let (q, v, u) = (&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]);
    let mut x = [&q[..], v, u].concat();
    x.resize(result.declaration.inputs(), trajectory.time[k]);
    contacts.evaluate_free_acceleration(&x);
    let right = lines
        .iter()
        .map(|&line| -contacts.free_line_acceleration(line));
    let right: Vec<f64> = right.collect();
    let Ok(shares) = Shares::of(contacts, &lines, &matrix, &right) else {
        return Told::Left;
    };
    let rooms = shares::rooms(contacts, &lines);
    // At the end of a slide, or of a contact, these are the lines of neither side.
    let found = match shares.contradict(contacts, &lines) {
        true => None,
        false => shares.smallest(&rooms),
    };
    let Some(found) = found.filter(|found| shares::obey(&rooms, found)) else {
        return Told::Left;
    };
    for room in rooms {
        let contact = lines[room.normal].contact();
        let Line::Normal { slope, .. } = lines[room.normal] else {
            continue;
        };
        let along = |line: Option<usize>| line.map_or(0.0, |line| found[line]);
        let [first, second] = room.tangents.map(along);
        let friction = pair_size((first, second)) + slope.abs() * found[room.normal];
        let normal = contacts.force(contact, found[room.normal]);
        trajectory.contact_force[k][contact] = normal.max(0.0);
        if contacts.is_in_space(contact)
            && let Some(forces) = trajectory.friction_force.get_mut(k)
        {
            let share = friction_share(contacts.model, contact, &x);
            forces[contact] = contacts.force(contact, friction) * share;
        }
    }
    if shares.decide {
        Told::Decide
    } else {
        Told::Smallest
    }
}

/// The surfaces that touch and rest in their normal direction at a point of the trajectory, evaluated there.
fn touching(
    contacts: &mut Contacts<'_>,
    (model, (place, speed)): (&dyn Model, (f64, f64)),
    result: &Simulation,
    k: usize,
) -> Vec<usize> {
    let trajectory = &result.trajectory;
    let (q, v, u) = (&trajectory.q[k], &trajectory.v[k], &trajectory.u[k]);
    let mut x = [&q[..], v, u].concat();
    x.resize(result.declaration.inputs(), trajectory.time[k]);
    // Of a surface with an edge one piece acts, whatever the others do.
    let declared = model.declaration().contacts;
    let near = |&i: &usize| {
        declared[i].alternatives.is_empty()
            && contacts.pieces.gap(model, i, &x).abs() <= yardstick::NOTHING * place
    };
    let mut near: Vec<usize> = (0..contacts.surfaces).filter(near).collect();
    if near.len() < 2 {
        return near;
    }
    contacts.evaluate_contacts(&x, near.iter().copied());
    near.retain(|&i| contacts.normal_velocity(i).abs() <= yardstick::NOTHING * speed);
    near
}

/// Those without a force that the loaded ones hold in place.
fn redundant(contacts: &Contacts<'_>, touching: &[usize], forces: &[f64]) -> Vec<usize> {
    let active: Vec<ActiveContact> = touching
        .iter()
        .filter(|&&i| forces[i] != 0.0)
        .map(|&contact| ActiveContact {
            contact,
            state: ContactState::Frictionless,
        })
        .collect();
    let held = |&contact: &usize| {
        let line = Line::Normal {
            contact,
            slope: 0.0,
        };
        forces[contact] == 0.0
            && shares::is_free(contacts, &unbiased_lines(&active), line).is_ok_and(|free| !free)
    };
    touching.iter().copied().filter(held).collect()
}

/// The smallest forces with the same motion; `None` if one of them would pull.
fn smallest(contacts: &Contacts<'_>, touching: &[usize], forces: &[f64]) -> Option<Vec<f64>> {
    let line = |&contact: &usize| Line::Normal {
        contact,
        slope: 0.0,
    };
    let lines: Vec<Line> = touching.iter().map(line).collect();
    // Measured by the inertia of its contact, each equation weighs the same: 1.
    let units: Vec<f64> = touching
        .iter()
        .map(|&i| contacts.force(i, 1.0).sqrt())
        .collect();
    let couplings = contacts.couplings(&lines);
    let rows = couplings.chunks_exact(lines.len()).zip(&units);
    let matrix: Vec<f64> = rows
        .flat_map(|(row, unit)| {
            row.iter()
                .zip(&units)
                .map(move |(k, other)| unit * k / other)
        })
        .collect();
    let known: Vec<f64> = touching
        .iter()
        .zip(&units)
        .map(|(&i, unit)| forces[i] / unit)
        .collect();
    let right: Vec<f64> = matrix
        .chunks_exact(lines.len())
        .map(|row| row.iter().zip(&known).map(|(k, x)| k * x).sum())
        .collect();
    let found = LeastNorm::of(&matrix, right.len())?.solve(&right).0;
    let found: Vec<f64> = found.iter().zip(&units).map(|(x, unit)| x * unit).collect();
    let largest = found
        .iter()
        .fold(0.0_f64, |most, force| most.max(force.abs()));
    let pushes = found
        .iter()
        .all(|force| *force >= -yardstick::NOTHING * largest);
    pushes.then(|| found.into_iter().map(|force| force.max(0.0)).collect())
}
