//! Simulated motions, and where one of them may end: what it came through up to there, what it misses and what it costs.

use super::replay::parts;
use crate::model::{Function, Model, OptimalControlDeclaration, held};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::motion::control_grid::ControlGrid;
use crate::ocp::motion::model_input::drive;
use crate::ocp::motion::targets::goal_values;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::Horizon;
use crate::ocp::tuning::sampled::{LEAST_PLACES, LONGER_THAN_BEFORE, PLACES, TOLERANCE};
use crate::simulation::{Event, EventDriven, EventKind, simulate_once};

/// What happens, one after the other: contacts, and whether they are struck.
pub(super) type Order = Vec<(usize, bool)>;

/// What a motion is made of.
#[derive(Clone)]
pub(in crate::ocp) struct Throw {
    /// `(q, v)`.
    pub(in crate::ocp) start: Vec<f64>,
    pub(in crate::ocp) controls: ControlGrid,
    /// Length \[s\].
    pub(in crate::ocp) horizon: f64,
}

impl Throw {
    /// The start and the controls of its motion over a time.
    pub(in crate::ocp) fn over(&self, horizon: f64) -> Trajectory {
        Trajectory {
            horizon,
            controls: self.controls.clone(),
            time: vec![0.0],
            states: vec![self.start.clone()],
        }
    }
}

/// A place where a motion may end.
#[derive(Clone)]
pub(in crate::ocp) struct End {
    pub(in crate::ocp) throw: Throw,
    pub(super) order: Order,
    /// What is missing from each goal, and by how much bounds and path constraints are violated on the way.
    pub(in crate::ocp) missing: Vec<f64>,
    /// Number of impacts, one by one.
    pub(super) impacts: usize,
    pub(in crate::ocp) cost: f64,
}

/// Where a motion that another one was changed into may end.
pub(super) fn ends_of_changed(setting: Setting, throw: &Throw, most_events: usize) -> Vec<End> {
    let longest = match setting.problem.horizon {
        Horizon::Fixed(horizon) => horizon,
        Horizon::Free { .. } => LONGER_THAN_BEFORE * throw.horizon,
    };
    ends(setting, throw, longest, most_events)
}

/// Where a motion may end that is followed so long, and as far as it has no more than `most_events`; its last controls last.
pub(in crate::ocp) fn ends(
    setting: Setting,
    throw: &Throw,
    longest: f64,
    most_events: usize,
) -> Vec<End> {
    let Setting { model, problem, .. } = setting;
    let declaration = model.declaration();
    let Some(declared) = declaration.optimal_control else {
        return Vec::new();
    };
    let prolonged = Throw {
        controls: prolonged(throw, longest, problem.intervals),
        ..throw.clone()
    };
    let followed = prolonged.over(longest);
    let simulator = EventDriven {
        tolerance: TOLERANCE,
        output_times: LEAST_PLACES.max(PLACES * problem.intervals),
        ..EventDriven::default()
    };
    let value = problem.initial_value_problem(&throw.start, longest, followed.signal());
    let Ok(simulation) = simulate_once(&simulator, model, &value) else {
        return Vec::new();
    };
    let (trajectory, events) = (&simulation.trajectory, &simulation.events);
    let fixed = matches!(problem.horizon, Horizon::Fixed(_));
    let mut way = Way::new(setting, &declared);
    let mut ends = Vec::new();
    for (i, &time) in trajectory.time.iter().enumerate() {
        let state = [&trajectory.q[i][..], &trajectory.v[i]].concat();
        way.pass(setting, &declared, (&state, &trajectory.u[i], time));
        let order = order(model, events, (time, longest / parts(setting) as f64));
        if order.len() > most_events {
            break;
        }
        let last = time >= longest * (1.0 - TOLERANCE);
        if if fixed { last } else { time > 0.0 } {
            let z = [&state[..], &[time]].concat();
            let mut missing = goal_values(model, &z);
            missing.extend(&way.violations);
            let before = events.iter().take_while(|event| event.time <= time);
            ends.push(End {
                throw: Throw {
                    start: throw.start.clone(),
                    controls: up_to(&followed, time, problem.intervals),
                    horizon: time,
                },
                order,
                missing,
                impacts: before.filter(|e| e.kind == EventKind::Impact).count(),
                cost: way.cost + final_cost(setting, &declared, &z),
            });
        }
    }
    ends
}

/// The events up to a time: those of dry friction and switches, which follow where anything is struck, left out there; bounces of a contact
/// in one interval, by which simulations are read, are one.
fn order(model: &dyn Model, events: &[Event], (time, interval): (f64, f64)) -> Order {
    let contacts = model.declaration().contacts;
    let mut last: Vec<Option<(f64, bool)>> = vec![None; contacts.len()];
    let strikes = contacts.iter().any(|contact| !contact.dry);
    let mut order = Order::new();
    for event in events.iter().take_while(|event| event.time <= time) {
        let struck = event.kind == EventKind::Impact;
        let now = ((event.time / interval).floor(), struck);
        if strikes && contacts[event.contact].dry || last[event.contact] == Some(now) {
            continue;
        }
        last[event.contact] = Some(now);
        order.push((event.contact, struck));
    }
    order
}

/// What a motion has come through.
struct Way {
    /// The most by which each bound and path constraint was violated.
    violations: Vec<f64>,
    /// Running cost, and its value and time at the last place.
    cost: f64,
    last: Option<(f64, f64)>,
}

impl Way {
    fn new(setting: Setting, declared: &OptimalControlDeclaration) -> Self {
        Self {
            violations: vec![0.0; setting.problem.q.len() + declared.constraints.len()],
            cost: 0.0,
            last: None,
        }
    }

    /// Passes a place: bounds of the coordinates, path constraints, running cost.
    fn pass(
        &mut self,
        setting: Setting,
        declared: &OptimalControlDeclaration,
        (state, controls, time): (&[f64], &[f64], f64),
    ) {
        let (model, (lower, upper)) = (setting.model, setting.bounds);
        let n = setting.problem.q.len();
        let coordinates = (0..n).map(|k| (lower[k] - state[k]).max(state[k] - upper[k]).max(0.0));
        let mut values = vec![0.0; declared.path_functions()];
        let mut input = state.to_vec();
        input.extend(drive(model, controls, time));
        input.resize(model.declaration().path_inputs(), 0.0);
        held::complete_largest(model, &mut input);
        model.values(Function::Path, &input, &mut values);
        let own = &values[usize::from(declared.running_cost)..];
        let constraints = declared.constraints.iter().zip(own);
        let constraints = constraints.map(|(constraint, &value)| {
            if constraint.equality {
                value.abs()
            } else {
                (-value).max(0.0)
            }
        });
        let all = coordinates.chain(constraints);
        for (most, value) in self.violations.iter_mut().zip(all) {
            *most = most.max(value);
        }
        if declared.running_cost {
            if let Some((value, before)) = self.last {
                self.cost += 0.5 * (value + values[0]) * (time - before);
            }
            self.last = Some((values[0], time));
        }
    }
}

/// The final cost at `(q, v, T)`.
fn final_cost(setting: Setting, declared: &OptimalControlDeclaration, z: &[f64]) -> f64 {
    if !declared.final_cost {
        return 0.0;
    }
    let mut all = vec![0.0; declared.terminal_functions()];
    let mut z = z.to_vec();
    z.resize(setting.model.declaration().terminal_inputs(), 0.0);
    setting.model.values(Function::Terminal, &z, &mut all);
    all[0]
}

/// The controls of a motion on intervals of a longer one, the last of them to its end.
fn prolonged(throw: &Throw, longest: f64, intervals: usize) -> ControlGrid {
    let own = throw.controls.intervals() as f64;
    let at = |k: usize| {
        let share = (k as f64 + 0.5) / intervals as f64 * longest / throw.horizon;
        throw.controls.at(own * share.min(1.0))
    };
    ControlGrid::constant((0..intervals).map(at).collect())
}

/// The controls of a motion up to a time, on equal intervals up to there.
fn up_to(motion: &Trajectory, time: f64, intervals: usize) -> ControlGrid {
    let own = motion.controls.intervals() as f64;
    let at = |k: usize| {
        let share = (k as f64 + 0.5) / intervals as f64 * time / motion.horizon;
        motion.controls.at(own * share)
    };
    ControlGrid::constant((0..intervals).map(at).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_holds_what_surfaces_do_and_bounces_of_one_interval_once() {
        crate::model! {
            /// A ball between two plates, on a rail that rubs.
            Plates {
                parameters { m: kg = 1, f: N = 1, e = 0.5 }
                coordinates { y: m, z: m }
                controls { u: N }
                lagrangian m/2*|dot((y, z))|^2
                forces { y: u }
                surface low: z >= 0
                surface high: z <= 1[m]
                impact low, high: restitution e
                dry friction rail: bound f, sliding dot(y)
            }
        }
        let event = |time: f64, contact: usize, kind: EventKind| Event {
            time,
            kind,
            contact,
            contact_name: "",
            modes: Vec::new(),
            q: Vec::new(),
            v_before: Vec::new(),
            v_after: Vec::new(),
            contact_impulse: Vec::new(),
            friction_impulse: Vec::new(),
        };
        let (low, high, rail) = (0, 1, 2);
        let events = [
            event(0.1, low, EventKind::Impact),
            event(0.15, rail, EventKind::Slip),
            event(0.3, low, EventKind::Impact),
            event(0.6, high, EventKind::Impact),
            event(0.7, low, EventKind::Impact),
            event(1.2, low, EventKind::Impact),
            event(1.3, low, EventKind::LiftOff),
        ];
        let model = Plates::default();
        let order = |time: f64| order(&model, &events, (time, 1.0));
        let struck = |contact: usize| (contact, true);
        assert_eq!(order(0.9), [struck(low), struck(high)]);
        let all = [struck(low), struck(high), struck(low), (low, false)];
        assert_eq!(order(2.0), all);
    }
}
