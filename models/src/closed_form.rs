//! Motions that are known as formulas, switch by switch: what charts measure errors against.

use std::f64::consts::{PI, TAU};

use hangtime::model::Model;
use hangtime_cli::parameter;

/// Impacts after which a ball counts as one that bounces for ever.
const MOST_IMPACTS: usize = 1_000;

/// Horizontal position and height of a ball that bounces along a floor with or without friction (`bouncing-ball`,
/// `rough-ball`); `None` beyond the last of many bounces.
pub(crate) fn bounces(model: &dyn Model, time: f64) -> Option<Vec<f64>> {
    let [g, e, height, speed] = ["g", "e", "height", "speed"].map(|name| parameter(model, name));
    let mu = Some(parameter(model, "mu")).filter(|mu| mu.is_finite());
    let fall = (2.0 * height / g).sqrt();
    if time <= fall {
        return Some(vec![speed * time, height - g / 2.0 * time * time]);
    }
    let (mut y, mut along, mut start, mut down) = (speed * fall, speed, fall, g * fall);
    for _ in 0..MOST_IMPACTS {
        let lost = mu.unwrap_or_default() * (1.0 + e) * down;
        along = along.signum() * (along.abs() - lost).max(0.0);
        let (up, flight) = (e * down, 2.0 * e * down / g);
        let t = time - start;
        if t <= flight {
            return Some(vec![y + along * t, up * t - g / 2.0 * t * t]);
        }
        y += along * flight;
        start += flight;
        down = up;
    }
    None
}

/// A block that slides down an incline and stops (`incline`); `None` where it does not stick.
pub(crate) fn incline(model: &dyn Model, time: f64) -> Option<Vec<f64>> {
    let [g, angle, mu, speed] = ["g", "incline", "mu", "speed"].map(|name| parameter(model, name));
    // Parameters are in their declared units.
    let angle = angle.to_radians();
    let braking = g * (mu * angle.cos() - angle.sin());
    if braking <= 0.0 || speed < 0.0 {
        return None;
    }
    let t = time.min(speed / braking);
    let way = speed * t - braking / 2.0 * t * t;
    Some(vec![way * angle.cos(), -way * angle.sin()])
}

/// A block that a spring drags (`stick-slip`): it slips, sticks and slips; `None` beyond that, or where it begins
/// otherwise.
pub(crate) fn stick_slip(model: &dyn Model, time: f64) -> Option<Vec<f64>> {
    let [m, g, k, mu, pull, stretch] =
        ["m", "g", "k", "mu", "pull", "stretch"].map(|name| parameter(model, name));
    let omega = (k / m).sqrt();
    let least = mu * m * g / k;
    let beyond = stretch - least;
    // It slips at the start, and sticks where it comes to rest.
    if !(0.0..2.0 * least).contains(&beyond) || pull <= 0.0 {
        return None;
    }
    let position = |time: f64, stretched: f64| stretch + pull * time - stretched;
    let phase = (beyond * omega).atan2(pull);
    let stuck = 2.0 * (PI - phase) / omega;
    if time <= stuck {
        let (sine, cosine) = (omega * time).sin_cos();
        let stretched = least + beyond * cosine + pull / omega * sine;
        return Some(vec![position(time, stretched), 0.0]);
    }
    let rest = position(stuck, least - beyond);
    let slips = stuck + beyond / pull;
    if time <= slips {
        return Some(vec![rest, 0.0]);
    }
    let t = time - slips;
    let way = pull * t - pull / omega * (omega * t).sin();
    (omega * t < TAU).then(|| vec![rest + way, 0.0])
}

/// A ball in a box that takes no energy (`box`); `None` where it does not reach the ceiling, or bounces very often.
pub(crate) fn elastic_box(model: &dyn Model, time: f64) -> Option<Vec<f64>> {
    let [g, width, height, speed] =
        ["g", "width", "height", "speed"].map(|name| parameter(model, name));
    // The walls only fold the line along which the ball moves.
    let line = (width / 4.0 + speed * time).rem_euclid(2.0 * width);
    let y = line.min(2.0 * width - line);
    let energy = speed * speed + g * height;
    let [bottom, top] = [energy, energy - 2.0 * g * height].map(f64::sqrt);
    if !top.is_finite() {
        return None;
    }
    let rise = (bottom - top) / g;
    // Time since the floor, of a period of rise and fall.
    let since = ((bottom - speed) / g + time).rem_euclid(2.0 * rise);
    let t = since.min(2.0 * rise - since);
    Some(vec![y, bottom * t - g / 2.0 * t * t])
}
