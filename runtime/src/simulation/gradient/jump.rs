//! How velocities right after an impact change with those before and with where and when it happens.
//!
//! The law holds for neighbouring motions with the same contacts that strike, stick and slide:
//!
//! ```text
//! v+ = v- + sum_j C_j y_j        v_n,i+ + e_i v_n,i- = 0        v_t,i+ = 0 where a contact sticks
//! ```

use super::acceleration::{Acceleration, Hold, solved};
use super::matrix::{Matrix, add, largest};
use super::wanted::Wanted;
use crate::linalg::dense;
use crate::model::{contact_point, tangent_point};
use crate::simulation::{ContactMode, Direction};

/// Share of the largest velocity that counts as none after an impact.
const AT_REST: f64 = 1e-8;
/// Share of the jump that one impact of the contacts that strike may miss.
const MISSED: f64 = 1e-6;
/// Share of the velocity that the law returns below which a contact does not bounce.
const ENDED: f64 = 1e-3;

/// An impact.
pub(super) struct Impact<'i> {
    /// The input vectors right before and right after.
    pub(super) before: &'i [f64],
    pub(super) after: &'i [f64],
    /// Contacts that strike, or that hold.
    pub(super) struck: &'i [usize],
    pub(super) time: f64,
    /// Derivatives of `(q, v)` right before, at the instant that moves along.
    pub(super) moved: &'i Matrix,
    /// Derivatives of the time of the impact.
    pub(super) times: &'i [f64],
}

/// What an impact leaves.
pub(super) struct Jump {
    /// Derivatives of the velocities right after, at the instant that moves along.
    pub(super) velocities: Matrix,
    /// Derivatives of the normal impulses of all contacts and then of their tangential ones.
    pub(super) impulses: Matrix,
}

/// Derivatives of an impact; the `acceleration` has another mode afterwards.
///
/// # Errors
/// Why there are none.
pub(super) fn jump(
    acceleration: &mut Acceleration<'_>,
    wanted: &Wanted,
    impact: &Impact<'_>,
) -> Result<Jump, String> {
    let n = acceleration.n;
    let v = |x: &[f64]| x[n..2 * n].to_vec();
    let (v_before, v_after) = (v(impact.before), v(impact.after));
    let earlier = conditions_before(acceleration, wanted, impact);
    let modes = modes_of(acceleration, impact);
    acceleration.set_mode(&modes);
    acceleration.keep_independent(impact.after);
    acceleration.load(impact.after);
    let holds = acceleration.holds.clone();
    let mut matrix = acceleration.coupling();
    let mut pivots = vec![0; holds.len()];
    dense::factorize(&mut matrix.values, &mut pivots).map_err(|_| together(impact.time))?;
    let step: Vec<f64> = v_after.iter().zip(&v_before).map(|(a, b)| a - b).collect();
    let mut impulses: Vec<f64> = holds
        .iter()
        .map(|&hold| {
            (0..n)
                .map(|k| acceleration.covector(hold, k).0 * step[k])
                .sum()
        })
        .collect();
    dense::solve(&matrix.values, &pivots, &mut impulses);
    for (k, step) in step.iter().enumerate() {
        let terms = holds.iter().zip(&impulses);
        let made: f64 = terms
            .map(|(&hold, y)| acceleration.direction(hold, k) * y)
            .sum();
        if (made - step).abs() > MISSED * largest(&v_before).max(largest(&v_after)) {
            return Err(together(impact.time));
        }
    }
    let mut velocities = as_they_are(acceleration, wanted, impact, &impulses);
    let right = wanted_changes(acceleration, wanted, impact, (&velocities, &earlier));
    let change = solved(&matrix, &pivots, right);
    for k in 0..n {
        for (j, &hold) in holds.iter().enumerate() {
            let component = acceleration.direction(hold, k);
            add(velocities.row_mut(k), component, change.row(j));
        }
    }
    let impulses = of_impulses(acceleration, wanted, impact, (&impulses, &change));
    Ok(Jump {
        velocities,
        impulses,
    })
}

/// The change of the velocities after the impact with the impulses as they are.
fn as_they_are(
    acceleration: &Acceleration<'_>,
    wanted: &Wanted,
    impact: &Impact<'_>,
    impulses: &[f64],
) -> Matrix {
    let (n, m) = (acceleration.n, wanted.count());
    let mut velocities = Matrix::zeros(n, m);
    let mut by = vec![0.0; acceleration.columns];
    for k in 0..n {
        by.fill(0.0);
        for (&hold, y) in acceleration.holds.iter().zip(impulses) {
            acceleration.add_direction(hold, k, *y, &mut by);
        }
        for (column, value) in velocities.row_mut(k).iter_mut().enumerate() {
            let turned = place(acceleration, wanted, impact, &by, column);
            *value = impact.moved.row(n + k)[column] + turned;
        }
    }
    velocities
}

/// What impulses have to change so that the law holds, with a row for each velocity that is held: with these changes of the
/// velocities without them, and of what restitution gives back.
fn wanted_changes(
    acceleration: &Acceleration<'_>,
    wanted: &Wanted,
    impact: &Impact<'_>,
    (velocities, earlier): (&Matrix, &Matrix),
) -> Matrix {
    let (n, m) = (acceleration.n, wanted.count());
    let mut right = Matrix::zeros(acceleration.holds.len(), m);
    for (i, &hold) in acceleration.holds.iter().enumerate() {
        let (_, by) = velocity(acceleration, hold);
        for column in 0..m {
            let mut wants = -place(acceleration, wanted, impact, by, column);
            if let Hold::Normal { contact, .. } = hold {
                wants -= earlier.row(contact)[column];
            }
            let has = (0..n).map(|k| acceleration.covector(hold, k).0 * velocities.row(k)[column]);
            right.row_mut(i)[column] = wants - has.sum::<f64>();
        }
    }
    right
}

fn together(time: f64) -> String {
    format!(
        "at t = {time} s several impacts happen at one instant, or contacts share their impulses: which motion follows for \
         other parameters is not known"
    )
}

/// The velocity that a force holds, with its derivatives, where it was last evaluated.
fn velocity<'a>(acceleration: &'a Acceleration<'_>, hold: Hold) -> (f64, &'a [f64]) {
    match hold {
        Hold::Normal { contact, .. } => acceleration.point(contact, contact_point::NORMAL_VELOCITY),
        Hold::Tangent { contact } => acceleration.tangent(contact, tangent_point::SLIDING_VELOCITY),
    }
}

/// Change of a function with these derivatives by place, time and parameters, with the velocities as they are.
fn place(
    acceleration: &Acceleration<'_>,
    wanted: &Wanted,
    impact: &Impact<'_>,
    by: &[f64],
    column: usize,
) -> f64 {
    let n = acceleration.n;
    let mut sum: f64 = (0..n).map(|i| by[i] * impact.moved.row(i)[column]).sum();
    if acceleration.model.declaration().explicit_time {
        sum += by[acceleration.columns - wanted.parameters - 1] * impact.times[column];
    }
    sum + wanted.own(by, column)
}

/// What each normal velocity after the impact must change by against its sign, because of that before: the change of
/// `e v_n-`.
fn conditions_before(
    acceleration: &mut Acceleration<'_>,
    wanted: &Wanted,
    impact: &Impact<'_>,
) -> Matrix {
    let n = acceleration.n;
    let contacts = acceleration.model.declaration().contacts.len();
    let mut earlier = Matrix::zeros(contacts, wanted.count());
    let mut by_parameters = vec![0.0; wanted.parameters];
    for &contact in impact.struck {
        acceleration.load_contact(contact, impact.after);
        let (returned, _) = acceleration.point(contact, contact_point::NORMAL_VELOCITY);
        acceleration.load_contact(contact, impact.before);
        let (speed, by) = acceleration.point(contact, contact_point::NORMAL_VELOCITY);
        let e = acceleration.model.restitution(contact);
        // A contact that rests, and one whose bounces have ended, gives nothing back.
        if speed >= 0.0 || returned <= -ENDED * e * speed {
            continue;
        }
        wanted.derivatives.restitution(contact, &mut by_parameters);
        for column in 0..wanted.count() {
            let velocity = (0..n).map(|i| by[n + i] * impact.moved.row(n + i)[column]);
            let change = place(acceleration, wanted, impact, by, column) + velocity.sum::<f64>();
            let of_law = wanted.of_parameters(&by_parameters, column);
            earlier.row_mut(contact)[column] = e * change + of_law * speed;
        }
    }
    earlier
}

/// What the struck contacts do in the impact, by how they leave it.
fn modes_of(acceleration: &mut Acceleration<'_>, impact: &Impact<'_>) -> Vec<ContactMode> {
    let (n, model) = (acceleration.n, acceleration.model);
    let declared = model.declaration().contacts;
    let mut modes = vec![ContactMode::Open; declared.len()];
    let speed = largest(&impact.before[n..2 * n]);
    for &contact in impact.struck {
        modes[contact] = ContactMode::Frictionless;
        if declared[contact].friction.is_some() && acceleration.friction(contact).0 > 0.0 {
            acceleration.load_contact(contact, impact.after);
            let (sliding, by) = acceleration.tangent(contact, tangent_point::SLIDING_VELOCITY);
            let rest = AT_REST * speed * largest(&by[n..2 * n]);
            modes[contact] = if sliding.abs() <= rest {
                ContactMode::Stick
            } else {
                ContactMode::Slip(Direction::of(sliding))
            };
        }
    }
    modes
}

/// Derivatives of the impulses from those of the velocities that the contacts provide.
fn of_impulses(
    acceleration: &Acceleration<'_>,
    wanted: &Wanted,
    impact: &Impact<'_>,
    (provided, change): (&[f64], &Matrix),
) -> Matrix {
    let contacts = acceleration.model.declaration().contacts.len();
    let mut impulses = Matrix::zeros(2 * contacts, wanted.count());
    for (j, &hold) in acceleration.holds.iter().enumerate() {
        let (Hold::Normal { contact, .. } | Hold::Tangent { contact }) = hold;
        let (inertia, by) = acceleration.point(contact, contact_point::INVERSE_INERTIA);
        for column in 0..wanted.count() {
            let inertia_by = place(acceleration, wanted, impact, by, column);
            let impulse = provided[j] / inertia;
            let changed = (change.row(j)[column] - impulse * inertia_by) / inertia;
            match hold {
                Hold::Tangent { .. } => impulses.row_mut(contacts + contact)[column] = changed,
                Hold::Normal { sense, .. } => {
                    let (mu, mu_by) = acceleration.friction(contact);
                    let mu_by = wanted.of_parameters(mu_by, column);
                    impulses.row_mut(contact)[column] = changed;
                    if sense != 0.0 {
                        let rubbing = sense * (mu * changed + mu_by * impulse);
                        impulses.row_mut(contacts + contact)[column] = rubbing;
                    }
                }
            }
        }
    }
    impulses
}
