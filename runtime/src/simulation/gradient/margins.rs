//! What keeps a sequence of events: margins that vanish where it becomes another one.

use super::acceleration::Acceleration;
use super::cause::{force_size, friction_left};
use crate::model::{Switching, contact_point, switching_terms, tangent_point};
use crate::simulation::ContactMode;

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
    /// Size of its terms.
    pub(super) size: f64,
}

/// The margins of a mode, where the acceleration is evaluated at `x`: always of the same contacts in the same order, and the same ones but for
/// conditions that cease to hold.
pub(super) fn margins(
    acceleration: &mut Acceleration<'_>,
    modes: &[ContactMode],
    (x, control_rates): (&[f64], &[f64]),
) -> Vec<Margin> {
    let (n, model) = (acceleration.n, acceleration.model);
    let v = x[n..2 * n].to_vec();
    let mut margins = Vec::new();
    for (contact, declared) in model.declaration().contacts.iter().enumerate() {
        let mode = modes.get(contact).copied().unwrap_or(ContactMode::Open);
        let mut put = |acceleration: &Acceleration<'_>, of, (value, by): (f64, Vec<f64>), size| {
            let (rate, _) = acceleration.rate(&by, &v, control_rates);
            margins.push(Margin {
                contact,
                of,
                value,
                rate,
                by,
                size,
            });
        };
        if mode == ContactMode::Open {
            // Of an edge, the pieces that do not act are no gaps.
            if !declared.dry && declared.alternatives.is_empty() {
                acceleration.load_contact(contact, x);
                let (gap, by) = acceleration.point(contact, contact_point::GAP);
                let own = (gap, by.to_vec());
                put(acceleration, Of::Gap, own, gap.abs());
            }
            continue;
        }
        if let Some((force, by)) = acceleration.force(contact, false) {
            let own = (force, by.to_vec());
            let curvature = acceleration.point(contact, contact_point::CURVATURE).0;
            let size = force_size(acceleration, contact, false).max(curvature.abs());
            put(acceleration, Of::Force, own, size);
        }
        if let ContactMode::Slip(direction) = mode {
            let (value, by) = acceleration.tangent(contact, tangent_point::SLIDING_VELOCITY);
            // A condition that ceases to hold is no event.
            let sense = match declared.switch {
                Some(Switching::Resets) => value.signum(),
                _ => direction.sign(),
            };
            let own = (sense * value, by.iter().map(|by| sense * by).collect());
            let size = match declared.switch {
                Some(_) => switching_terms(model, contact, x),
                None => value.abs(),
            };
            put(acceleration, Of::Sliding(sense), own, size);
        }
        if mode == ContactMode::Stick {
            for sense in [1.0, -1.0] {
                if let Some((value, by, size)) = friction_left(acceleration, contact, sense) {
                    let own = (sense * value, by.iter().map(|by| sense * by).collect());
                    put(acceleration, Of::Left(sense), own, size);
                }
            }
        }
    }
    margins
}
