//! Rest where the functions of switches vanish together: how long it lasts, and motions that come to it by ever more switches in ever less
//! time.

use super::instant::Instant;
use super::place::{Place, sizes};
use crate::contact::{Rest, View};
use crate::model::Function;
use crate::yardstick;

/// Share of the horizon within which switches that lead to a rest follow each other.
pub(crate) const BURST: f64 = 1e-6;
/// Share up to which it is zero where a rest goes on: its end is a place in time, which this is the accuracy of.
const HOLDS: f64 = 1e-13;
/// Sweeps over the parts of the sides in a mixture.
const SWEEPS: usize = 1_000;
/// Times at which it is looked whether a rest goes on, and halvings of the time between two of them.
const LOOKS: usize = 64;
pub(super) const HALVINGS: usize = 60;

/// How long the motion rests from the present state on, at most a time `longest` \[s\], and whether it is over then; `None` where it does not
/// rest. The parts of the sides are those at the end.
pub(crate) fn lasts<'a>(now: &mut impl Instant<'a>, longest: f64) -> Option<(f64, bool)> {
    let rest = now.view().rest.clone()?;
    let (x, rates) = (now.input(), now.rates());
    let contacts = 0..now.view().sides.len();
    let zeros: Vec<f64> = contacts.map(|i| now.rest_speed(i)).collect();
    let place = Place {
        x: &x,
        rates: &rates,
        touching: &rest.contacts,
        zeros: &zeros,
        moment: longest,
        longest,
    };
    let view = now.view_mut();
    let lasts = balance_lasts(view, &place, longest);
    let over = lasts < longest;
    if !over && let Some(parts) = mixture(view, &place, lasts, yardstick::NOTHING) {
        view.rest = Some(Rest { parts, ..rest });
    }
    Some((lasts, over))
}

/// The switches of the last moment before the present instant, increasing, of a run to `horizon` with these times and contacts of events, the last
/// one first; and whether they have led to a state at rest, at which the motion is then. `acceleration` is the largest before them.
pub(crate) fn comes_to_rest<'a>(
    now: &mut impl Instant<'a>,
    events: impl Iterator<Item = (f64, usize)>,
    (horizon, acceleration): (f64, f64),
) -> Option<Vec<usize>> {
    let moment = BURST * horizon;
    let time = now.time();
    let recent = events.take_while(|(at, _)| time - at <= moment);
    let mut switches: Vec<usize> = recent
        .map(|(_, contact)| contact)
        .filter(|&contact| now.view().switch_of(contact).is_some())
        .collect();
    switches.sort_unstable();
    switches.dedup();
    if switches.is_empty() {
        return None;
    }
    let mut x = now.input();
    let (view, near) = (now.view_mut(), (moment, acceleration));
    let found = move_to_zero(view, &mut x, &switches, near);
    found.then(|| {
        now.put(&x);
        switches
    })
}

/// The parts of the sides with which nothing moves after a time `h` at rest, to this share of the terms.
pub(super) fn mixture(view: &mut View<'_>, at: &Place<'_>, h: f64, share: f64) -> Option<Vec<f64>> {
    let n = view.n;
    let moving = &at.x[n..n + view.model.declaration().mechanical()];
    let known = |&i: &usize| view.is_dry(i) && !view.is_in_space(i);
    if moving.iter().any(|v| *v != 0.0) || !at.touching.iter().all(known) {
        return None;
    }
    let x = at.moved(at.x, &vec![0.0; 2 * n], h);
    view.evaluate_free_acceleration(&x);
    at.touching.iter().for_each(|&i| view.evaluate_sides(i, &x));
    let columns = at.columns(view);
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
fn balance_lasts(view: &mut View<'_>, at: &Place<'_>, longest: f64) -> f64 {
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
    let x = at.moved(at.x, &vec![0.0; 2 * view.n], h);
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

/// Moves the state of `x` to the common zero of the functions of `switches`, at rest: the nearest one, as their gradients say. Whether
/// there is one within `farthest` of each velocity and state, and of what they cover in the time `moment` \[s\].
fn move_to_zero(
    view: &mut View<'_>,
    x: &mut [f64],
    switches: &[usize],
    (moment, acceleration): (f64, f64),
) -> bool {
    let (n, model) = (view.n, view.model);
    let mechanical = model.declaration().mechanical();
    let start = x.to_vec();
    x[n..n + mechanical].fill(0.0);
    for _ in 0..4 * switches.len() {
        for &i in switches {
            let Some(friction) = model.declaration().contacts[i].friction else {
                continue;
            };
            let entries = friction.jacobian.entries;
            let mut values = vec![0.0; entries.len()];
            model.jacobian(Function::Tangent(i), x, &mut values);
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
