//! How velocities right after an impact change with those before and with where and when it happens.
//!
//! The law holds for neighbouring motions with the same contacts that strike, stick and slide:
//!
//! ```text
//! v+ = v- + sum_j C_j y_j        v_n,i+ + e_i v_n,i- = 0        v_t,i+ = 0 where a contact sticks
//! ```

use super::mode::Acceleration;
use super::outputs::of_contacts;
use super::tangent::{Matrix, Tangent, add};
use crate::contact::{Line, impact};
use crate::linalg::products::{dot, largest};
use crate::model::tangent_point;
use crate::simulation::{ContactMode, Direction};
use crate::yardstick;

/// Share of the largest velocity that counts as none after an impact.
const AT_REST: f64 = 1e-8;
/// An impact.
pub(super) struct Impact<'i> {
    /// The input vectors right before and right after.
    pub(super) before: &'i [f64],
    pub(super) after: &'i [f64],
    /// Contacts that strike, or that hold.
    pub(super) struck: &'i [usize],
    pub(super) time: f64,
}

/// What an impact leaves.
pub(super) struct Jump {
    /// Derivatives of the velocities right after, at the instant that moves along.
    pub(super) velocities: Matrix,
    /// Derivatives of the normal impulses of all contacts and then of their tangential ones.
    pub(super) impulses: Matrix,
}

impl Jump {
    /// Takes what the impact leaves.
    pub(super) fn apply(&self, tangent: &mut Tangent) {
        let n = tangent.layout.n;
        for k in 0..n {
            tangent
                .all
                .row_mut(n + k)
                .copy_from_slice(self.velocities.row(k));
        }
        let first = tangent.layout.impulses();
        for i in first..tangent.layout.cost() {
            add(tangent.all.row_mut(i), 1.0, self.impulses.row(i - first));
        }
    }
}

/// The struck contacts that do not bounce though their law says so: whose bounces have ended.
pub(super) fn ended(acceleration: &mut Acceleration<'_>, impact: &Impact<'_>) -> Vec<usize> {
    let struck = impact.struck.iter().copied();
    let ended = |&contact: &usize| {
        let returned = acceleration.normal_velocity(contact, impact.after).0;
        let speed = acceleration.normal_velocity(contact, impact.before).0;
        speed >= 0.0
            || returned <= -yardstick::VISIBLE * acceleration.model.restitution(contact) * speed
    };
    struck.filter(ended).collect()
}

/// Derivatives of an impact, from those right before at the instant that moves along; the `acceleration` has another mode afterwards.
///
/// # Errors
/// Why there are none.
pub(super) fn jump(
    acceleration: &mut Acceleration<'_>,
    moved: &Tangent,
    impact: &Impact<'_>,
) -> Result<Jump, String> {
    let n = acceleration.n;
    let v = |x: &[f64]| x[n..2 * n].to_vec();
    let (v_before, v_after) = (v(impact.before), v(impact.after));
    let earlier = conditions_before(acceleration, moved, impact)?;
    let modes = modes_of(acceleration, impact);
    acceleration.set_mode(&modes);
    acceleration.keep_independent(impact.after);
    acceleration.load(impact.after, true);
    let factors = acceleration.factors();
    let factors = factors.ok_or_else(|| together(impact.time))?;
    let step: Vec<f64> = v_after.iter().zip(&v_before).map(|(a, b)| a - b).collect();
    let lines = acceleration.lines.iter();
    let impulses = lines
        .clone()
        .map(|&line| dot(acceleration.row(line).0, &step));
    let mut impulses: Vec<f64> = impulses.collect();
    factors.solve(&mut impulses);
    let mut left = step;
    for (&line, impulse) in lines.zip(&impulses) {
        acceleration.push(line, -impulse, &mut left);
    }
    if largest(&left) > yardstick::PROMISE * largest(&v_before).max(largest(&v_after)) {
        return Err(together(impact.time));
    }
    let mut velocities = as_they_are(acceleration, moved, &impulses);
    let right = wanted_changes(acceleration, moved, (&velocities, &earlier));
    let change = factors.solve_all(right);
    acceleration.push_rows(&change, 1.0, (&mut velocities, 0));
    let of = |by: &[f64]| place(moved, by);
    let (_, impulses) = of_contacts(acceleration, (&impulses, &change), moved, of);
    Ok(Jump {
        velocities,
        impulses,
    })
}

/// The change of the velocities after the impact with the impulses as they are.
fn as_they_are(acceleration: &Acceleration<'_>, moved: &Tangent, impulses: &[f64]) -> Matrix {
    let n = acceleration.n;
    let mut velocities = Matrix::zeros(n, moved.all.columns);
    let mut by = vec![0.0; acceleration.columns];
    for k in 0..n {
        by.fill(0.0);
        for (&line, y) in acceleration.lines.iter().zip(impulses) {
            acceleration.add_direction(line, k, *y, &mut by);
        }
        let row = velocities.row_mut(k);
        row.copy_from_slice(&place(moved, &by));
        add(row, 1.0, moved.all.row(n + k));
    }
    velocities
}

/// What impulses have to change so that the law holds, with a row for each velocity that is held: with these changes of the
/// velocities without them, and of what restitution gives back.
fn wanted_changes(
    acceleration: &Acceleration<'_>,
    moved: &Tangent,
    (velocities, earlier): (&Matrix, &Matrix),
) -> Matrix {
    let mut right = Matrix::zeros(acceleration.lines.len(), moved.all.columns);
    for (i, &line) in acceleration.lines.iter().enumerate() {
        let (_, by) = acceleration.velocity(line);
        let row = right.row_mut(i);
        add(row, -1.0, &place(moved, by));
        if let Line::Normal { contact, .. } = line {
            add(row, -1.0, earlier.row(contact));
        }
        for k in 0..acceleration.n {
            add(row, -acceleration.gradient(line, k).0, velocities.row(k));
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

/// Change of a function with these derivatives by all but the velocities.
fn place(moved: &Tangent, by: &[f64]) -> Vec<f64> {
    let n = moved.layout.n;
    let mut by = by.to_vec();
    by[n..2 * n].fill(0.0);
    moved.of(&by)
}

/// What each normal velocity after the impact must change by against its sign, because of that before: the change of
/// `e v_n-`.
///
/// # Errors
/// Where a velocity after the impact is another one, as of impacts one after the other.
fn conditions_before(
    acceleration: &mut Acceleration<'_>,
    moved: &Tangent,
    impact: &Impact<'_>,
) -> Result<Matrix, String> {
    let contacts = acceleration.model.declaration().contacts.len();
    let mut earlier = Matrix::zeros(contacts, moved.all.columns);
    let mut by_parameters = vec![0.0; acceleration.layout.parameters];
    let ended = ended(acceleration, impact);
    let n = acceleration.n;
    let fastest = largest(&impact.before[n..2 * n]);
    for &contact in impact
        .struck
        .iter()
        .filter(|contact| !ended.contains(contact))
    {
        let returned = acceleration.normal_velocity(contact, impact.after).0;
        let (speed, by) = acceleration.normal_velocity(contact, impact.before);
        let change = moved.of(by);
        let least = yardstick::PROMISE * fastest * largest(&by[n..2 * n]);
        let e = acceleration.model.restitution(contact);
        if (returned + e * speed).abs() > least {
            return Err(together(impact.time));
        }
        acceleration
            .derivatives
            .restitution(contact, &mut by_parameters);
        let row = earlier.row_mut(contact);
        add(row, e, &change);
        add(row, speed, &moved.of_parameters(&by_parameters));
    }
    Ok(earlier)
}

/// The velocities that contacts which strike, or are closed, leave by the law, where `ended` of them do not bounce; none where it has no solution.
pub(super) fn struck_alone(
    acceleration: &mut Acceleration<'_>,
    (struck, ended): (&[usize], &[usize]),
    before: &[f64],
) -> Option<Vec<f64>> {
    let n = acceleration.n;
    let mut restitution = Vec::with_capacity(struck.len());
    for contact in struck {
        acceleration.load_contact(*contact, before);
        let bounces = !ended.contains(contact);
        restitution.push(f64::from(u8::from(bounces)) * acceleration.model.restitution(*contact));
    }
    let mut after = before.to_vec();
    impact::strike(acceleration, struck, &restitution, &mut after[n..2 * n]).ok()?;
    Some(after)
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
