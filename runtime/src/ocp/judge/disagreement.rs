//! How a plan and its re-simulation differ in kind.

use crate::model::Model;
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::simulation::ContactMode;

/// The first difference in kind between the switches of a plan and of its re-simulation over `horizon`, in words.
pub(super) fn disagreement(
    model: &dyn Model,
    plan: &Sequence,
    read: &Sequence,
    intervals: usize,
    horizon: f64,
) -> Option<String> {
    let contacts = model.declaration().contacts;
    let initially = plan.initially.iter().zip(&read.initially);
    let other = initially
        .zip(contacts)
        .find(|((plan, read), _)| plan != read);
    if let Some(((mode, read), contact)) = other {
        return Some(format!(
            "`{}` is {mode} at the start of the plan, and {read} at that of the re-simulation",
            contact.name
        ));
    }
    let kind = |s: &Switch| (s.contact, s.closes, s.mode);
    let words = |sequence: &Sequence, index: usize| match sequence.switches.get(index) {
        None => "nothing".to_owned(),
        Some(switch) => {
            let name = contacts[switch.contact].name;
            let time = switch.time * (horizon / intervals as f64);
            match (switch.closes, switch.mode) {
                (true, ContactMode::Open) => format!("`{name}` is touched at {time:.6} s"),
                (false, ContactMode::Open) => format!("`{name}` opens at {time:.6} s"),
                (true, ContactMode::Frictionless) => format!("`{name}` closes at {time:.6} s"),
                (_, mode) => format!("`{name}` is {mode} from {time:.6} s on"),
            }
        }
    };
    // A simulation may end on either side of an impact at the final time.
    let lasting = plan.switches.iter().filter(|s| s.interval < intervals);
    let longest = lasting.count().max(read.switches.len());
    (0..longest)
        .find(|&i| plan.switches.get(i).map(kind) != read.switches.get(i).map(kind))
        .map(|i| {
            let (planned, simulated) = (words(plan, i), words(read, i));
            format!(
                "switch {}: in the plan {planned}, in the re-simulation {simulated}",
                i + 1
            )
        })
}
