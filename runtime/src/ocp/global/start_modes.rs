//! What the contacts do at the start of a motion.

use crate::model::Pieces;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::mode::{closed_mode, is_frictional, sliding_velocity, zero_velocity};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::has_free_start;
use crate::ocp::tuning::equal::{MET, ROUNDING};
use crate::simulation::ContactMode;

/// What the contacts do at the start of a motion.
pub(in crate::ocp) fn modes_at_start(setting: Setting, motion: &Trajectory) -> Vec<ContactMode> {
    let Setting {
        model,
        problem,
        units,
        ..
    } = setting;
    let mut input = motion.start(model, problem);
    let zero = zero_velocity(&input[input.len() / 2..], units.slow());
    input.resize(model.declaration().inputs(), 0.0);
    let free = has_free_start(model);
    let pieces = Pieces::at(model, &input);
    let near = if free { MET } else { ROUNDING };
    (0..model.declaration().contacts.len())
        .map(|contact| {
            if pieces.is_idle(contact) || model.gap(contact, &input) > near * units.gap[contact] {
                return ContactMode::Open;
            }
            let frictional = is_frictional(model, contact);
            let slides = frictional.then(|| sliding_velocity(model, contact, &input, 0.0));
            closed_mode(frictional, slides.unwrap_or(0.0), zero)
        })
        .collect()
}

/// Whether a contact may hold from the start on: it touches there, or free initial values may let it touch.
pub(in crate::ocp) fn may_be_closed_at_start(setting: Setting, contact: usize) -> bool {
    let Setting {
        model,
        problem,
        units,
        ..
    } = setting;
    if has_free_start(model) {
        return true;
    }
    let mut input = problem.start();
    input.resize(model.declaration().inputs(), 0.0);
    model.gap(contact, &input) <= ROUNDING * units.gap[contact]
}
