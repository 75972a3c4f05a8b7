//! How a plan and its re-simulation differ in kind.

use crate::model::{Model, contact_point};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::model_input::drive;
use crate::ocp::motion::read_sequence::{landed_as, seen};
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::search::replay::read_replay;
use crate::ocp::settings::Settings;
use crate::simulation::{ContactMode, Simulation};

/// The first difference in kind between a plan and its re-simulation, in words.
pub(super) fn compare(
    setting: Setting,
    settings: &Settings,
    plan: &Sequence,
    trajectory: &Trajectory,
    replay: &Simulation,
) -> Option<String> {
    let Setting { model, problem, .. } = setting;
    let simulated = Trajectory::of_simulation(
        model,
        replay,
        trajectory.horizon,
        trajectory.controls.clone(),
    );
    // A slip over less than the distance that is let pass is none.
    let slowest = setting.largest_distance(settings, trajectory) / trajectory.horizon;
    let read = landed_as(plan, read_replay(setting, replay, trajectory), model);
    let plan = seen(plan, model, trajectory, slowest);
    let mut read = seen(&read, model, &simulated, slowest);
    leave_at_once(setting, &plan, trajectory, settings, &mut read);
    disagreement(
        model,
        &plan.without_passages(),
        &read.without_passages(),
        problem.intervals,
        trajectory.horizon,
    )
}

/// Leaves out what contacts that are open in the plan do from the start, if they open before the plan is further from them than
/// is let pass.
fn leave_at_once(
    setting: Setting,
    plan: &Sequence,
    trajectory: &Trajectory,
    settings: &Settings,
    read: &mut Sequence,
) {
    let Setting { model, problem, .. } = setting;
    let interval = trajectory.horizon / problem.intervals as f64;
    let distance = |contact: usize, time: f64| {
        let mut point = vec![0.0; contact_point::length(problem.q.len())];
        let state = trajectory.at(time, true);
        let controls = trajectory.controls.at(0.0);
        let mut input = state[..2 * problem.q.len()].to_vec();
        input.extend(drive(model, &controls, time));
        model.contact(contact, &input, &mut point);
        time * point[contact_point::NORMAL_VELOCITY].abs()
    };
    for contact in 0..read.initially.len() {
        let own = |switch: &&Switch| switch.contact == contact;
        let first = read.switches.iter().find(own).copied();
        if let Some(opening) = first.filter(Switch::opens)
            && !read.initially[contact].is_open()
            && plan.initially[contact].is_open()
            && distance(contact, opening.time * interval)
                <= setting.largest_distance(settings, trajectory)
        {
            read.initially[contact] = ContactMode::Open;
            read.switches.retain(|switch| *switch != opening);
        }
    }
}

/// The first difference in kind between the switches of a plan and of its re-simulation over `horizon`, in words.
fn disagreement(
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
