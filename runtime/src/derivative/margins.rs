//! What keeps a sequence of events: margins that vanish where it becomes another one.

use super::event::{force_size, friction_left};
use super::mode::Acceleration;
use super::place::Place;
use super::step::stage_input;
use super::tangent::Tangent;
use crate::linalg::products::largest;
use crate::model::{ControlPiece, Switching, contact_point, tangent_point};
use crate::simulation::ContactMode;

/// Steps of the search for the least value of a margin, whose error is the square of that of its place.
const SEARCH: usize = 8;

/// What a margin is one of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Of {
    Gap,
    Force,
    /// Friction that a sticking contact has left, in this sense.
    Left(f64),
    /// Velocity of a sliding contact, in this sense.
    Sliding(f64),
}

impl Of {
    pub(super) fn words(self, name: &str, switch: bool) -> String {
        match self {
            Self::Gap => format!("`{name}` is touched"),
            Self::Force => format!("`{name}` opens"),
            Self::Left(_) if switch => format!("`{name}` is left"),
            Self::Left(_) => format!("`{name}` begins to slide"),
            Self::Sliding(_) if switch => format!("`{name}` switches"),
            Self::Sliding(_) => format!("`{name}` comes to rest"),
        }
    }
}

/// A margin at an instant.
#[derive(Debug, Clone)]
pub(super) struct Margin {
    pub(super) contact: usize,
    pub(super) of: Of,
    pub(super) value: f64,
    pub(super) rate: f64,
    /// Its derivatives by inputs and parameters.
    pub(super) by: Vec<f64>,
    /// Size of its terms in the motion.
    pub(super) size: f64,
    /// Whether it is one of a condition that sets something.
    pub(super) resets: bool,
}

/// The margins at instant `k`, where the acceleration is evaluated.
pub(super) fn margins(at: &mut Place<'_>, k: usize) -> Vec<Margin> {
    let time = at.run.trajectory.time[k];
    let (x, controls) = (at.input(k), at.controls(time));
    margins_at(at, (&x, time), &controls)
}

/// The margins of the mode, where the acceleration is evaluated at `x` at a time: always of the same contacts in the same order, and the
/// same ones but for conditions that cease to hold.
fn margins_at(
    at: &mut Place<'_>,
    (x, time): (&[f64], f64),
    controls: &ControlPiece,
) -> Vec<Margin> {
    let rates = at.rates(x, controls.slopes());
    let contacts = at.acceleration.model.declaration().contacts;
    let mut margins = Vec::new();
    for (contact, declared) in contacts.iter().enumerate() {
        let resets = declared.switch == Some(Switching::Resets);
        let mut put = |acceleration: &Acceleration<'_>, of, value, by: Vec<f64>, size| {
            margins.push(Margin {
                rate: acceleration.layout.rate(&by, &rates).0,
                contact,
                of,
                value,
                by,
                size,
                resets,
            });
        };
        let mode = at.modes.get(contact).copied().unwrap_or(ContactMode::Open);
        if mode == ContactMode::Open {
            // Of an edge, the pieces that do not act are no gaps.
            if !declared.dry && declared.alternatives.is_empty() {
                at.acceleration.load_contact(contact, x);
                let (gap, by) = at.acceleration.point(contact, contact_point::GAP);
                let (by, size) = (by.to_vec(), at.gap_sizes[contact]);
                put(&at.acceleration, Of::Gap, gap, by, size);
            }
            continue;
        }
        let acceleration = &at.acceleration;
        if let Some((force, by)) = acceleration.force(contact, false).filter(|_| !declared.dry) {
            let curvature = acceleration.point(contact, contact_point::CURVATURE).0;
            let size = force_size(acceleration, contact).max(curvature.abs());
            let size = size.max(at.terms(by, (x, time)));
            put(acceleration, Of::Force, force, by.to_vec(), size);
        }
        if let ContactMode::Slip(direction) = mode {
            let component = tangent_point::SLIDING_VELOCITY;
            let (value, by) = acceleration.tangent(contact, component);
            // A condition that ceases to hold is no event.
            let sense = if resets {
                value.signum()
            } else {
                direction.sign()
            };
            let size = match declared.switch {
                Some(_) => at.terms(by, (x, time)),
                None => at.sizes[1] * largest(by),
            };
            let by = by.iter().map(|by| sense * by).collect();
            put(acceleration, Of::Sliding(sense), sense * value, by, size);
        }
        if mode == ContactMode::Stick {
            for sense in [1.0, -1.0] {
                if let Some((value, by, size)) = friction_left(acceleration, contact, sense) {
                    let by = by.iter().map(|by| sense * by).collect();
                    put(acceleration, Of::Left(sense), sense * value, by, size);
                }
            }
        }
    }
    margins
}

/// The least value of a margin within the step that ends at instant `k` and was solved last, and its time and derivatives there: between a
/// place where it falls and one where it grows. `before` are the derivatives at the start of the step.
pub(super) fn least(
    at: &mut Place<'_>,
    k: usize,
    [from, to]: [&Margin; 2],
    before: &Tangent,
) -> Option<Least> {
    let controls = at.controls(at.run.trajectory.time[k - 1]);
    let step = at.step_to(k, &controls);
    let h = step.to.time - step.from.time;
    // The rate's zero by false position, with the weight of an end that stays twice halved (Illinois).
    let (mut low, mut high) = ((0.0, from.rate), (1.0, to.rate));
    let mut fell = None;
    let mut found = None;
    for _ in 0..SEARCH {
        let theta = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
        let (q, v) = at.steps.within(step, theta);
        let time = step.from.time + theta * h;
        let x = stage_input(&at.acceleration, (&q, &v), time, &controls);
        if !at.acceleration.evaluate(&x) {
            break;
        }
        let margins = margins_at(at, (&x, time), &controls);
        let own = |margin: &Margin| margin.contact == from.contact && margin.of == from.of;
        let Some(margin) = margins.into_iter().find(own) else {
            break;
        };
        let falls = margin.rate < 0.0;
        let weight = if fell == Some(falls) { 0.5 } else { 1.0 };
        if falls {
            (low, high.1) = ((theta, margin.rate), weight * high.1);
        } else {
            (high, low.1) = ((theta, margin.rate), weight * low.1);
        }
        fell = Some(falls);
        found = Some((margin, theta, x, time));
    }
    let (margin, theta, x, time) = found?;
    let within = at
        .steps
        .derivatives_within((at.acceleration.n, h), before, theta);
    let jumps = matches!(margin.of, Of::Sliding(_)) && at.jumps(margin.contact, &x);
    Some(Least {
        changes: within.of(&margin.by),
        terms: within.sizes(&margin.by),
        time,
        jumps,
        margin,
    })
}

/// The least value of a margin within a step.
pub(super) struct Least {
    pub(super) margin: Margin,
    pub(super) time: f64,
    /// Its derivatives by column, and the sums of the sizes of their terms.
    pub(super) changes: Vec<f64>,
    pub(super) terms: Vec<f64>,
    /// Whether accelerations are others behind it.
    pub(super) jumps: bool,
}
