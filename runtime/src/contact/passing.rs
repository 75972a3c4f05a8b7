//! Which sides of switches act that are only passed, where their functions vanish together with their rates.
//!
//! A choice of sides gives a motion, and it agrees with itself if a moment later each function has the sign of its side:
//!
//! ```text
//! v' = a - sum_k sigma_k D_k e_k,   sigma_k = +-1:     sigma_k c_k(t + h) >= 0 for all k
//! ```
//!
//! One choice that agrees is the motion, two are two motions; so is a function that does not leave zero whatever its side, which matters. Where none agrees every side leads back, and the motion stays if it is at
//! rest under a mixture of the sides, `0 = a - sum_k sigma_k D_k e_k` with `|sigma_k| <= 1` and without velocity: an equilibrium of
//! Filippov's inclusion. It stays for certain unless motions close to it turn round it in ever longer times: those
//! have left it a finite time ago.
//!
//! Source: Filippov, *Differential Equations with Discontinuous Righthand Sides* (1988), paragraphs 15 and 22.

use super::balance::Balance;
use super::line::Line;
use super::mode_error::ModeError;
use super::rest::Rest;
use super::touching::Touching;
use super::view::View;
use crate::model::{Model, pair_size, switching_terms};

/// Most switches whose sides are tried in all ways.
pub(crate) const MOST: usize = 6;
/// Multiples of the moment after which functions are looked at, until they have a sign.
const MOMENTS: [f64; 5] = [1.0, 10.0, 1e2, 1e3, 1e4];
/// Steps to each of them, so that also what four integrations do not move has a sign.
const LOOKAHEAD: usize = 3;
/// Rounding errors of a function up to which it has no sign.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Share of the terms of an acceleration up to which it is zero where a rest is looked for.
const BALANCED: f64 = 1e-9;
/// The same where a rest goes on: its end is a place in time, which this is the accuracy of.
const HOLDS: f64 = 1e-13;
/// Share of the terms of an acceleration above which a choice of sides leaves a rest at once.
const LEAVES: f64 = 1e-6;
/// Sweeps over the parts of the sides in a mixture.
const SWEEPS: usize = 1_000;
/// Times at which it is looked whether a rest goes on, and halvings of the time between two of them.
const LOOKS: usize = 64;
const HALVINGS: usize = 60;
/// Turns of a motion around a rest that are compared, and steps in the time of the first switch.
const TURNS: usize = 4;
const STEPS_A_SWITCH: f64 = 8.0;
const MOST_STEPS: usize = 2_000;
/// Growth of the time of a turn over all turns that is none: steps of fourth order, and terms that vanish with the moment.
const GROWS: f64 = 1e-3;

/// Where functions vanish.
pub(crate) struct Place<'p> {
    /// Input vector, `(q, v, u[, t])`.
    pub(crate) x: &'p [f64],
    /// Rates of its part behind the velocities; none where they are zero.
    pub(crate) rates: &'p [f64],
    /// Contacts that touch.
    pub(crate) touching: &'p [usize],
    /// Sliding velocities of all contacts up to which they are at rest.
    pub(crate) zeros: &'p [f64],
    /// A time that is short beside those in which what acts varies \[s\].
    pub(crate) moment: f64,
}

/// What follows from there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Follows {
    /// The sides that act, which the view has now.
    Sides,
    /// The motion rests.
    Rest(Rest),
    /// There are several motions; this switch tells them apart.
    Several(usize),
    /// The motion stays where the function of this switch and its rate vanish, and moves on otherwise.
    Holds(usize),
}

/// What follows where the functions of the `passed` switches vanish, and of some of them the rates: sides are written to the view.
pub(crate) fn follows(
    view: &mut View<'_>,
    at: &Place<'_>,
    passed: &[usize],
) -> Result<Follows, ModeError> {
    let signs = signs_of_all(view, at, passed)?;
    let side = |choice: usize, k: usize| if choice >> k & 1 == 0 { 1.0 } else { -1.0 };
    let never: Vec<bool> = (0..passed.len())
        .map(|k| signs.iter().all(|signs| signs[k] == 0.0))
        .collect();
    let agrees = |&choice: &usize| {
        let mut all = signs[choice].iter().enumerate();
        all.all(|(k, &sign)| {
            let side = side(choice, k);
            if never[k] {
                side > 0.0
            } else {
                sign * side >= 0.0
            }
        })
    };
    let found: Vec<usize> = (0..signs.len()).filter(agrees).collect();
    if let [first, second, ..] = found[..] {
        let differ = (0..passed.len()).find(|&k| side(first, k) != side(second, k));
        return Ok(Follows::Several(passed[differ.unwrap_or(0)]));
    }
    for (k, contact) in passed.iter().enumerate().filter(|(k, _)| never[*k]) {
        // It vanishes from here on, and its sign is anything.
        if matters(view, at, passed, k)? {
            return Ok(Follows::Several(*contact));
        }
    }
    if let [only] = found[..] {
        set_sides(view, passed, |k| side(only, k));
        let leaves = leaves_at_once(view, at)?;
        set_sides(view, passed, |_| 0.0);
        if leaves && rest(view, at).is_some() {
            return Ok(Follows::Several(passed[0]));
        }
        set_sides(view, passed, |k| side(only, k));
        return Ok(Follows::Sides);
    }
    if !jumps(view, at, passed)? {
        // What acts is continuous, so that there is one motion; its functions are rounding error.
        set_sides(view, passed, |_| 1.0);
        return Ok(Follows::Sides);
    }
    set_sides(view, passed, |_| 0.0);
    match rest(view, at) {
        None => Ok(Follows::Holds(passed[0])),
        Some(_) if turns_outwards(view, at, passed)? => Ok(Follows::Several(passed[0])),
        Some(rest) => Ok(Follows::Rest(rest)),
    }
}

/// Of every choice of sides the signs of the functions a moment later, the first that they show.
fn signs_of_all(
    view: &mut View<'_>,
    at: &Place<'_>,
    passed: &[usize],
) -> Result<Vec<Vec<f64>>, ModeError> {
    let mut signs = vec![vec![0.0; passed.len()]; 1 << passed.len()];
    for multiple in MOMENTS {
        for (choice, signs) in signs.iter_mut().enumerate() {
            if signs.iter().all(|sign| *sign != 0.0) {
                continue;
            }
            set_sides(
                view,
                passed,
                |k| if choice >> k & 1 == 0 { 1.0 } else { -1.0 },
            );
            let h = multiple * at.moment / LOOKAHEAD as f64;
            let mut later = at.x.to_vec();
            for _ in 0..LOOKAHEAD {
                later = after(view, at, &later, h, false)?;
            }
            for (sign, &contact) in signs.iter_mut().zip(passed) {
                if *sign == 0.0 {
                    *sign = sign_at(view, contact, &later);
                }
            }
        }
    }
    Ok(signs)
}

fn set_sides(view: &mut View<'_>, passed: &[usize], side: impl Fn(usize) -> f64) {
    for (k, &contact) in passed.iter().enumerate() {
        view.sides[contact] = side(k);
    }
}

/// The sign of the function of a switch at `x`, 0 within its rounding error.
fn sign_at(view: &mut View<'_>, contact: usize, x: &[f64]) -> f64 {
    view.evaluate_tangent(contact, x);
    let value = view.sliding_velocity(contact);
    if value.abs() > ROUNDING * switching_terms(view.model, contact, x) {
        value.signum()
    } else {
        0.0
    }
}

/// The acceleration at `x` with the sides of the view; contacts without one stick where they are at rest, unless all are `fixed`.
fn acceleration(
    view: &mut View<'_>,
    at: &Place<'_>,
    x: &[f64],
    fixed: bool,
) -> Result<Vec<f64>, ModeError> {
    view.evaluate_free_acceleration(x);
    for &i in at.touching {
        view.evaluate_sides(i, x);
    }
    let in_cone = |i: usize| !fixed && !view.passes(i) && pair_size(view.sliding(i)) <= at.zeros[i];
    let touching = Touching::new(view, at.touching, in_cone);
    let lines = touching.lines.iter();
    let offsets: Vec<f64> = lines
        .map(|&line| view.free_line_acceleration(line))
        .collect();
    let balance = Balance::first(touching, view, &offsets)?;
    let mut acceleration = view.free_acceleration().to_vec();
    balance.push(view, &balance.forces, &mut acceleration);
    Ok(acceleration)
}

/// The input vector after a time `h` from `x`, by one step of the classical Runge-Kutta method.
fn after(
    view: &mut View<'_>,
    at: &Place<'_>,
    x: &[f64],
    h: f64,
    fixed: bool,
) -> Result<Vec<f64>, ModeError> {
    let n = view.n;
    let mut sum = vec![0.0; 2 * n];
    let mut slope = vec![0.0; 2 * n];
    for (node, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
        let stage = moved(at, x, &slope, node * h);
        slope[..n].copy_from_slice(&stage[n..2 * n]);
        slope[n..].copy_from_slice(&acceleration(view, at, &stage, fixed)?);
        for (sum, slope) in sum.iter_mut().zip(&slope) {
            *sum += weight / 6.0 * slope;
        }
    }
    Ok(moved(at, x, &sum, h))
}

/// `x` after a time `h` in which coordinates and velocities have this `slope`.
fn moved(at: &Place<'_>, x: &[f64], slope: &[f64], h: f64) -> Vec<f64> {
    let mut moved = x.to_vec();
    for (value, slope) in moved.iter_mut().zip(slope) {
        *value += h * slope;
    }
    for (value, rate) in moved[slope.len()..].iter_mut().zip(at.rates) {
        *value += h * rate;
    }
    moved
}

/// Whether the acceleration with the sides of the view is none of a rest.
fn leaves_at_once(view: &mut View<'_>, at: &Place<'_>) -> Result<bool, ModeError> {
    let acceleration = acceleration(view, at, at.x, false)?;
    let columns = columns(view, at);
    let scale = sizes(view, &columns);
    let mut rows = acceleration.iter().zip(&scale);
    Ok(rows.any(|(a, scale)| a.abs() > LEAVES * scale))
}

/// Whether what acts jumps with the sides of the `passed` switches.
fn jumps(view: &mut View<'_>, at: &Place<'_>, passed: &[usize]) -> Result<bool, ModeError> {
    acceleration(view, at, at.x, true)?;
    let columns = columns(view, at);
    let scale = sizes(view, &columns);
    let contacts = at.touching.iter().zip(&columns);
    let mut of_passed = contacts.filter(|(contact, _)| passed.contains(contact));
    Ok(of_passed.any(|(_, column)| {
        let mut rows = column.iter().zip(&scale);
        rows.any(|(g, scale)| g.abs() > BALANCED * scale)
    }))
}

/// Whether the motion depends on the side of the `k`-th of the `passed` switches, with the side 1 of the others.
fn matters(
    view: &mut View<'_>,
    at: &Place<'_>,
    passed: &[usize],
    k: usize,
) -> Result<bool, ModeError> {
    set_sides(view, passed, |_| 1.0);
    let one = acceleration(view, at, at.x, false)?;
    let columns = columns(view, at);
    let scale = sizes(view, &columns);
    view.sides[passed[k]] = -1.0;
    let other = acceleration(view, at, at.x, false)?;
    let mut rows = one.iter().zip(&other).zip(&scale);
    Ok(rows.any(|((one, other), scale)| (one - other).abs() > BALANCED * scale))
}

/// What the side 1 of each contact that touches takes from the acceleration, as last evaluated.
fn columns(view: &View<'_>, at: &Place<'_>) -> Vec<Vec<f64>> {
    let column = |&i: &usize| {
        let force = -view.free_line_acceleration(Line::normal(i)) * view.friction(i);
        let direction = view.slip_direction(i).iter();
        direction.map(|e| force * e).collect()
    };
    at.touching.iter().map(column).collect()
}

/// Sizes of the terms of each acceleration.
fn sizes(view: &View<'_>, columns: &[Vec<f64>]) -> Vec<f64> {
    let free = view.free_acceleration().iter().enumerate();
    free.map(|(row, a)| columns.iter().map(|column| column[row].abs()).sum::<f64>() + a.abs())
        .collect()
}

/// The rest at the place and a moment later, if there is one.
fn rest(view: &mut View<'_>, at: &Place<'_>) -> Option<Rest> {
    let parts = mixture(view, at, 0.0, BALANCED)?;
    mixture(view, at, at.moment, BALANCED)?;
    Some(Rest {
        contacts: at.touching.to_vec(),
        parts,
    })
}

/// The parts of the sides with which nothing moves after a time `h` at rest, to this share of the terms.
fn mixture(view: &mut View<'_>, at: &Place<'_>, h: f64, share: f64) -> Option<Vec<f64>> {
    let n = view.n;
    let moving = &at.x[n..n + view.model.declaration().mechanical()];
    let known = |&i: &usize| view.is_dry(i) && !view.is_in_space(i);
    if moving.iter().any(|v| *v != 0.0) || !at.touching.iter().all(known) {
        return None;
    }
    let x = moved(at, at.x, &vec![0.0; 2 * n], h);
    view.evaluate_free_acceleration(&x);
    at.touching.iter().for_each(|&i| view.evaluate_sides(i, &x));
    let columns = columns(view, at);
    let scale = sizes(view, &columns);
    let mut left: Vec<f64> = view.free_acceleration().to_vec();
    let mut parts: Vec<f64> = at
        .touching
        .iter()
        .map(|&i| {
            let value = view.sliding_velocity(i);
            if value.abs() > at.zeros[i] {
                value.signum()
            } else {
                0.0
            }
        })
        .collect();
    let free: Vec<bool> = parts.iter().map(|part| *part == 0.0).collect();
    let take = |left: &mut [f64], column: &[f64], part: f64| {
        left.iter_mut()
            .zip(column)
            .for_each(|(left, g)| *left -= part * g);
    };
    for (column, part) in columns.iter().zip(&parts) {
        take(&mut left, column, *part);
    }
    let weight = |row: usize| {
        if scale[row] > 0.0 {
            scale[row].powi(-2)
        } else {
            0.0
        }
    };
    for _ in 0..SWEEPS {
        let mut change = 0.0_f64;
        for (k, column) in columns.iter().enumerate().filter(|(k, _)| free[*k]) {
            let rows = column.iter().zip(&left).enumerate();
            let (square, product) = rows.fold((0.0, 0.0), |sum, (row, (g, left))| {
                (sum.0 + weight(row) * g * g, sum.1 + weight(row) * g * left)
            });
            if square > 0.0 {
                let part = (parts[k] + product / square).clamp(-1.0, 1.0);
                take(&mut left, column, part - parts[k]);
                change = change.max((part - parts[k]).abs());
                parts[k] = part;
            }
        }
        if change <= f64::EPSILON {
            break;
        }
    }
    let mut rows = left.iter().zip(&scale);
    rows.all(|(left, scale)| left.abs() <= share * scale)
        .then_some(parts)
}

/// How long the rest goes on with the same signs of all functions, at most a time `longest` \[s\]; beyond its end by less than what can be told.
pub(crate) fn lasts(view: &mut View<'_>, at: &Place<'_>, longest: f64) -> f64 {
    if at.rates.iter().all(|rate| *rate == 0.0) {
        return longest;
    }
    let begun = signs_after(view, at, 0.0);
    let mut goes_on = |time: f64| {
        mixture(view, at, time, HOLDS).is_some() && signs_after(view, at, time) == begun
    };
    let mut before = 0.0;
    for look in 1..=LOOKS {
        let time = longest * look as f64 / LOOKS as f64;
        if !goes_on(time) {
            let (mut left, mut right) = (before, time);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (left + right);
                if goes_on(middle) {
                    left = middle;
                } else {
                    right = middle;
                }
            }
            return right;
        }
        before = time;
    }
    longest
}

/// Signs of the functions after a time `h` at rest, 0 of those that vanish.
fn signs_after(view: &mut View<'_>, at: &Place<'_>, h: f64) -> Vec<f64> {
    let x = moved(at, at.x, &vec![0.0; 2 * view.n], h);
    let sign = |&i: &usize| {
        view.evaluate_tangent(i, &x);
        let value = view.sliding_velocity(i);
        if value.abs() > at.zeros[i] {
            value.signum()
        } else {
            0.0
        }
    };
    at.touching.iter().map(sign).collect()
}

/// The parts of the sides after a time `h` of the rest.
pub(crate) fn parts_after(view: &mut View<'_>, at: &Place<'_>, h: f64) -> Option<Vec<f64>> {
    mixture(view, at, h, BALANCED)
}

/// Whether a motion that begins beside the rest turns round it in ever longer times.
fn turns_outwards(
    view: &mut View<'_>,
    at: &Place<'_>,
    passed: &[usize],
) -> Result<bool, ModeError> {
    let switches: Vec<usize> = at.touching.to_vec();
    set_sides(view, &switches, |_| 1.0);
    let mut x = after(view, at, at.x, at.moment, true)?;
    for &i in &switches {
        view.sides[i] = 0.0;
        view.evaluate_tangent(i, &x);
        view.sides[i] = if view.sliding_velocity(i) < 0.0 {
            -1.0
        } else {
            1.0
        };
    }
    let mut h = at.moment / STEPS_A_SWITCH;
    let (mut time, mut switched, mut turns) = (0.0, 0.0, Vec::new());
    for _ in 0..MOST_STEPS {
        let Some((to, step, crossed)) = step_to_switch(view, at, &switches, &x, h)? else {
            break;
        };
        x = to;
        time += step;
        let Some(contact) = crossed else {
            continue;
        };
        view.sides[contact] = -view.sides[contact];
        h = (time - switched) / STEPS_A_SWITCH;
        switched = time;
        if contact == passed[0] && view.sides[contact] > 0.0 {
            turns.push(time);
            if turns.len() > TURNS + 1 {
                break;
            }
        }
    }
    set_sides(view, &switches, |_| 0.0);
    let times: Vec<f64> = turns.windows(2).map(|pair| pair[1] - pair[0]).collect();
    Ok(match (times.first(), times.last()) {
        (Some(first), Some(last)) if times.len() >= TURNS => *last > (1.0 + GROWS) * first,
        _ => false,
    })
}

/// A step of length `h`, or to the first switch within it, which is said; nothing where a side leads back at once.
type ToSwitch = Option<(Vec<f64>, f64, Option<usize>)>;

fn step_to_switch(
    view: &mut View<'_>,
    at: &Place<'_>,
    switches: &[usize],
    x: &[f64],
    h: f64,
) -> Result<ToSwitch, ModeError> {
    let crossed = |view: &mut View<'_>, to: &[f64]| {
        switches.iter().copied().find(|&i| {
            view.evaluate_tangent(i, to);
            view.sides[i] * view.sliding_velocity(i) < 0.0
        })
    };
    let to = after(view, at, x, h, true)?;
    if crossed(view, &to).is_none() {
        return Ok(Some((to, h, None)));
    }
    let (mut left, mut right) = (0.0, h);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (left + right);
        let to = after(view, at, x, middle, true)?;
        match crossed(view, &to) {
            Some(_) => right = middle,
            None => left = middle,
        }
    }
    if right <= f64::EPSILON * h {
        return Ok(None);
    }
    let to = after(view, at, x, right, true)?;
    let contact = crossed(view, &to);
    Ok(Some((to, right, contact)))
}

/// Moves the state of `x` to the common zero of the functions of `switches`, at rest: the nearest one, as their gradients say. Whether
/// there is one within `farthest` of each velocity and state, and of what they cover in the time `moment` \[s\].
pub(crate) fn move_to_zero(
    model: &dyn Model,
    view: &mut View<'_>,
    x: &mut [f64],
    switches: &[usize],
    (moment, acceleration): (f64, f64),
) -> bool {
    let (n, mechanical) = (view.n, model.declaration().mechanical());
    let start = x.to_vec();
    x[n..n + mechanical].fill(0.0);
    for _ in 0..4 * switches.len() {
        for &i in switches {
            let Some(friction) = model.declaration().contacts[i].friction else {
                continue;
            };
            let entries = friction.jacobian.entries;
            let mut values = vec![0.0; entries.len()];
            model.tangent_jacobian(i, x, &mut values);
            view.evaluate_tangent(i, x);
            let value = view.sliding_velocity(i);
            let moves =
                |column: usize| column < mechanical || (n + mechanical..2 * n).contains(&column);
            let own = entries.iter().zip(&values);
            let row: Vec<(usize, f64)> = own
                .filter(|(entry, _)| entry.0 == 0 && moves(entry.1 as usize))
                .map(|(entry, slope)| (entry.1 as usize, *slope))
                .collect();
            let square: f64 = row.iter().map(|(_, slope)| slope * slope).sum();
            if square > 0.0 {
                for (column, slope) in row {
                    x[column] -= value * slope / square;
                }
            }
        }
    }
    let farthest = moment * acceleration;
    let near = |(k, (now, before)): (usize, (&f64, &f64))| {
        (now - before).abs() <= if k < n { moment * farthest } else { farthest }
    };
    x[..2 * n].iter().zip(&start).enumerate().all(near)
}
