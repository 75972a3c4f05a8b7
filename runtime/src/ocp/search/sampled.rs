//! Orders of impacts that no guess leads to, as one more bounce before the goal: simulated motions, of which one is kept for each order.
//!
//! Motions from random free initial values under random controls are simulated. Wherever one of them may end it has an order of events,
//! a distance to goals, bounds and path constraints, and a cost. Of each order the best is kept, and changed at random to find better
//! ones and further orders (an archive of elites, Mouret and Clune 2015). The best of all orders are what programs start from.

use std::collections::BTreeMap;

use super::replay::{parts, simulated};
use crate::model::{Model, OptimalControlDeclaration, held};
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::global::guess::{guess, random, uniform};
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::ControlGrid;
use crate::ocp::motion::model_input::drive;
use crate::ocp::motion::targets::goal_values;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::Horizon;
use crate::ocp::program::runner::Runner;
use crate::ocp::settings::Guess;
use crate::ocp::tuning::sampled::{
    ALIKE, BEST, CHANGED, CHANGES, DRAWN, EVENTS, LEAST_PLACES, LONGER, LONGER_THAN_BEFORE,
    NARROWED, NARROWER, OF_EACH_KIND, OF_RANGE, PILOTS, PLACES, TOLERANCE, TRIED, WITHIN,
};
use crate::simulation::{Event, EventDriven, EventKind, InputError, simulate_once};

/// What happens, one after the other: contacts, and whether they are struck.
pub(super) type Order = Vec<(usize, bool)>;

/// Least and largest values of coordinates and controls between which random controls are drawn.
pub(in crate::ocp) type Range = (Vec<f64>, Vec<f64>);

/// What a motion is made of.
#[derive(Clone)]
pub(super) struct Throw {
    /// `(q, v)`.
    start: Vec<f64>,
    controls: ControlGrid,
    /// Length \[s\].
    horizon: f64,
}

/// A place where a motion may end.
#[derive(Clone)]
pub(super) struct End {
    pub(super) throw: Throw,
    order: Order,
    /// What is missing from each goal, and by how much bounds and path constraints are violated on the way.
    pub(super) missing: Vec<f64>,
    /// Number of impacts, one by one.
    pub(super) impacts: usize,
    cost: f64,
}

/// How good an end is: distance, cost, and distance among those that are alike; smaller is better.
pub(super) type Rank = (u64, f64, f64);

/// What random motions have come to.
#[derive(Default)]
pub(in crate::ocp) struct Sampled {
    /// The best motion of each order, the best ones first.
    pub(in crate::ocp) motions: Vec<Candidate>,
    /// What most of the drawn ones miss less of each goal.
    pub(in crate::ocp) units: Vec<f64>,
    /// Size that the cost of most of the best ones does not exceed.
    pub(in crate::ocp) cost: f64,
}

/// The best motion of each order, the best ones first.
pub(in crate::ocp) fn sampled(
    runner: &mut Runner,
    setting: Setting,
) -> Result<Vec<Candidate>, InputError> {
    let range = drawing_range(setting)?;
    Ok(best_of_each_order(runner, (setting, &range), (DRAWN, CHANGED), TRIED)?.motions)
}

/// The same of so many motions that are drawn and that are made of the best ones, and of at most so many orders.
pub(in crate::ocp) fn best_of_each_order(
    runner: &mut Runner,
    (setting, range): (Setting, &Range),
    (drawn_motions, changed): (u64, usize),
    most: usize,
) -> Result<Sampled, InputError> {
    let model = setting.model;
    if model
        .declaration()
        .contacts
        .iter()
        .all(|contact| contact.dry)
    {
        return Ok(Sampled::default());
    }
    let mut archive = drawn((setting, range), drawn_motions, EVENTS)?;
    let mut random = uniform(drawn_motions);
    for k in 0..changed {
        if archive.best.is_empty() || !runner.goes_on("random motions") {
            break;
        }
        let parent = archive.parent(k, &mut random);
        let child = archive.changed(setting, parent, CHANGES[k % CHANGES.len()], &mut random);
        for end in ends_of_changed(setting, &child, EVENTS) {
            archive.add(end);
        }
    }
    let mut found = Vec::new();
    let ends = archive.sorted();
    // No further than the nearest one by more than a unit of the conditions.
    let far = ends.first().map_or(0.0, |end| 1.0 + archive.rank(end).2);
    let near = ends.into_iter().filter(|end| archive.rank(end).2 <= far);
    for end in near.take(most) {
        let Throw {
            start,
            controls,
            horizon,
        } = end.throw.clone();
        let motion = Trajectory {
            horizon,
            controls,
            time: vec![0.0],
            states: vec![start],
        };
        // One that is refused, as in no time, is none.
        let tolerance = runner.settings.replay_tolerance;
        let candidate = simulated(setting, &motion, tolerance).ok().flatten();
        found.extend(candidate);
    }
    Ok(Sampled {
        motions: found,
        cost: archive.usual_cost(),
        units: archive.units,
    })
}

/// The best end of each order.
pub(super) struct Archive {
    best: BTreeMap<Order, (Rank, End)>,
    /// Units of what is missing.
    pub(super) units: Vec<f64>,
    /// Ranges of the values that were drawn: of starts, and of controls.
    starts: Vec<(f64, f64)>,
    controls: Vec<(f64, f64)>,
}

/// The archive of random motions, as far as they have no more than `most_events`.
pub(super) fn drawn(
    (setting, range): (Setting, &Range),
    count: u64,
    most_events: usize,
) -> Result<Archive, InputError> {
    let Setting {
        model,
        problem,
        bounds,
        ..
    } = setting;
    let straight = guess(model, problem, &Guess::Straight, bounds)?;
    let mut throws = Vec::new();
    let mut all = Vec::new();
    for seed in 0..count {
        let (throw, ends) = one_drawn(setting, &straight, range, (seed, most_events));
        all.extend(ends);
        throws.push(throw);
    }
    let starts = throws.iter().map(|throw| &throw.start);
    let controls = throws.iter().flat_map(|throw| throw.controls.values());
    let mut archive = Archive {
        best: BTreeMap::new(),
        units: units(setting, &all),
        starts: ranges(starts),
        controls: ranges(controls),
    };
    all.into_iter().for_each(|end| archive.add(end));
    Ok(archive)
}

/// A motion under random controls in a range, and where it may end.
fn one_drawn(
    setting: Setting,
    straight: &Trajectory,
    range: &Range,
    (seed, most_events): (u64, usize),
) -> (Throw, Vec<End>) {
    let Setting { model, problem, .. } = setting;
    let (motion, start) = random(straight.clone(), model, problem, seed, (&range.0, &range.1));
    let throw = Throw {
        start: start.unwrap_or_else(|| problem.start()),
        controls: motion.controls,
        horizon: motion.horizon,
    };
    let longest = match problem.horizon {
        Horizon::Fixed(horizon) => horizon,
        Horizon::Free { .. } => LONGER * throw.horizon,
    };
    let ends = ends(setting, &throw, longest, most_events);
    (throw, ends)
}

/// The bounds from which random controls are drawn: the declared ones, or a part of them around what is nearest to zero as long as
/// motions come nearer to the goals in it. So bounds that no control comes near do not decide what random motions find.
pub(in crate::ocp) fn drawing_range(setting: Setting) -> Result<Range, InputError> {
    let Setting {
        model,
        problem,
        bounds: (lower, upper),
        ..
    } = setting;
    let n = problem.q.len();
    let straight = guess(model, problem, &Guess::Straight, setting.bounds)?;
    let within = |share: f64| {
        let (mut from, mut to) = (lower.to_vec(), upper.to_vec());
        for k in n..lower.len() {
            let nearest = 0.0_f64.clamp(lower[k], upper[k]);
            if (upper[k] - lower[k]).is_finite() {
                from[k] = nearest + share * (lower[k] - nearest);
                to[k] = nearest + share * (upper[k] - nearest);
            }
        }
        (from, to)
    };
    let ends = |range: &Range| {
        let one = |seed| one_drawn(setting, &straight, range, (seed, EVENTS)).1;
        (0..PILOTS).map(one).collect::<Vec<Vec<End>>>()
    };
    let mut best = within(1.0);
    let first = ends(&best);
    let units = units(setting, &first.concat());
    let mut least = usual_distance(&units, &first);
    for narrower in 1..=NARROWER {
        let range = within(NARROWED.powi(narrower));
        let distance = usual_distance(&units, &ends(&range));
        // Nearer is no more than half as far.
        if distance >= 0.5 * least {
            break;
        }
        (best, least) = (range, distance);
    }
    Ok(best)
}

/// The median over motions of how near they come to the goals.
fn usual_distance(units: &[f64], motions: &[Vec<End>]) -> f64 {
    let nearest = |ends: &Vec<End>| {
        let distances = ends.iter().map(|end| distance(&end.missing, units));
        distances.fold(f64::INFINITY, f64::min)
    };
    let mut all: Vec<f64> = motions.iter().map(nearest).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::INFINITY)
}

/// What is missing, in units.
fn distance(missing: &[f64], units: &[f64]) -> f64 {
    let terms = missing.iter().zip(units);
    let terms = terms.filter(|(_, unit)| **unit > 0.0);
    let squares: f64 = terms.map(|(value, unit)| (value / unit).powi(2)).sum();
    squares.sqrt()
}

/// Range of each component.
fn ranges<'v>(values: impl Iterator<Item = &'v Vec<f64>>) -> Vec<(f64, f64)> {
    let mut ranges: Vec<(f64, f64)> = Vec::new();
    for value in values {
        ranges.resize(value.len(), (f64::INFINITY, f64::NEG_INFINITY));
        for (range, &x) in ranges.iter_mut().zip(value) {
            *range = (range.0.min(x), range.1.max(x));
        }
    }
    ranges
}

/// Units of the conditions: what most of the ends miss by less, or else the most that one misses; of bounds a share of the range.
fn units(setting: Setting, ends: &[End]) -> Vec<f64> {
    let count = ends.first().map_or(0, |end| end.missing.len());
    let declared = setting.model.declaration().optimal_control;
    let goals = declared.map_or(0, |declared| declared.goals.len());
    let (lower, upper) = setting.bounds;
    let coordinates = setting.problem.q.len();
    let unit = |k: usize| {
        let mut values: Vec<f64> = ends.iter().map(|end| end.missing[k].abs()).collect();
        values.sort_by(f64::total_cmp);
        let usual = values[(WITHIN * values.len() as f64) as usize];
        if usual > 0.0 {
            usual
        } else {
            values[values.len() - 1]
        }
    };
    let of_bound = |k: usize| {
        let bounded = k.checked_sub(goals).filter(|k| *k < coordinates)?;
        let range = upper[bounded] - lower[bounded];
        range.is_finite().then_some(OF_RANGE * range)
    };
    let of_condition = |k: usize| of_bound(k).unwrap_or_else(|| unit(k));
    (0..count).map(of_condition).collect()
}

impl Archive {
    /// The best end of each order.
    pub(super) fn ends(&self) -> impl Iterator<Item = &End> {
        self.best.values().map(|(_, end)| end)
    }

    pub(super) fn rank(&self, end: &End) -> Rank {
        let distance = distance(&end.missing, &self.units);
        ((distance / ALIKE) as u64, end.cost, distance)
    }

    /// Size that the cost of most of the best ends does not exceed.
    fn usual_cost(&self) -> f64 {
        let mut costs: Vec<f64> = self.ends().map(|end| end.cost.abs()).collect();
        costs.sort_by(f64::total_cmp);
        let place = (WITHIN * costs.len() as f64) as usize;
        costs.get(place).copied().unwrap_or(0.0)
    }

    /// Adds an end if it is the best of its order.
    fn add(&mut self, end: End) {
        let rank = self.rank(&end);
        let known = self.best.get(&end.order);
        let better = known.is_none_or(|known| compare(&rank, &known.0).is_lt());
        if rank.2.is_finite() && rank.1.is_finite() && better {
            self.best.insert(end.order.clone(), (rank, end));
        }
    }

    /// The best of each order, the best first.
    fn sorted(&self) -> Vec<&End> {
        let mut found: Vec<&(Rank, End)> = self.best.values().collect();
        found.sort_by(|a, b| {
            let lengths = a.1.order.len().cmp(&b.1.order.len());
            compare(&a.0, &b.0).then(lengths)
        });
        found.into_iter().map(|(_, end)| end).collect()
    }

    /// A motion to be changed: one of the best in turn with any one.
    fn parent(&self, turn: usize, random: &mut impl FnMut() -> f64) -> Throw {
        let all = self.sorted();
        let count = if turn.is_multiple_of(2) {
            all.len().min(BEST)
        } else {
            all.len()
        };
        let place = (0.5 * (random() + 1.0) * count as f64) as usize;
        all[place.min(count - 1)].throw.clone()
    }

    /// A motion with its values changed by up to that share of their ranges: all controls, those of one interval, or those of one that
    /// is taken out and put in elsewhere, which moves what is between in time.
    pub(super) fn changed(
        &self,
        setting: Setting,
        mut throw: Throw,
        share: f64,
        random: &mut impl FnMut() -> f64,
    ) -> Throw {
        let Setting {
            model,
            problem,
            bounds,
            ..
        } = setting;
        let n = problem.q.len();
        let allowed = problem.start_ranges(model);
        for ((x, range), (lower, upper)) in throw.start.iter_mut().zip(&self.starts).zip(allowed) {
            if lower < upper {
                *x = (*x + share * random() * (range.1 - range.0)).clamp(lower, upper);
            }
        }
        held::complete_start(model, &mut throw.start);
        if matches!(problem.horizon, Horizon::Free { .. }) {
            throw.horizon *= (share * random()).exp();
        }
        let mut values = throw.controls.values().to_vec();
        let intervals = values.len();
        let mut place =
            || ((0.5 * (random() + 1.0) * intervals as f64) as usize).min(intervals - 1);
        let (one, other) = (place(), place());
        let kind = random();
        if kind > OF_EACH_KIND {
            // What comes after an interval happens later, and another one is left out.
            let value = values.remove(other);
            values.insert(one, value);
        }
        for (k, controls) in values.iter_mut().enumerate() {
            if kind > -OF_EACH_KIND && k != one {
                continue;
            }
            for (u, control) in controls.iter_mut().zip(n..) {
                let range = self.controls[control - n];
                let moved = *u + share * random() * (range.1 - range.0);
                *u = moved.clamp(bounds.0[control], bounds.1[control]);
            }
        }
        throw.controls = ControlGrid::constant(values);
        throw
    }
}

fn compare(a: &Rank, b: &Rank) -> std::cmp::Ordering {
    let costs = a.1.total_cmp(&b.1);
    a.0.cmp(&b.0).then(costs).then(a.2.total_cmp(&b.2))
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
fn ends(setting: Setting, throw: &Throw, longest: f64, most_events: usize) -> Vec<End> {
    let Setting { model, problem, .. } = setting;
    let declaration = model.declaration();
    let Some(declared) = declaration.optimal_control else {
        return Vec::new();
    };
    let followed = Trajectory {
        horizon: longest,
        controls: prolonged(throw, longest, problem.intervals),
        time: vec![0.0],
        states: vec![throw.start.clone()],
    };
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

/// The events up to a time: those of dry friction, which follow, left out; bounces of a contact in one interval, by which simulations
/// are read, are one.
fn order(model: &dyn Model, events: &[Event], (time, interval): (f64, f64)) -> Order {
    let contacts = model.declaration().contacts;
    let mut last: Vec<Option<(f64, bool)>> = vec![None; contacts.len()];
    let mut order = Order::new();
    for event in events.iter().take_while(|event| event.time <= time) {
        let struck = event.kind == EventKind::Impact;
        let now = ((event.time / interval).floor(), struck);
        if contacts[event.contact].dry || last[event.contact] == Some(now) {
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
        model.path_functions(&input, &mut values);
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
    setting.model.terminal_functions(&z, &mut all);
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

    #[test]
    fn archive_keeps_the_best_end_of_each_order_and_cost_decides_among_those_that_are_alike() {
        let mut archive = Archive {
            best: BTreeMap::new(),
            units: vec![2.0],
            starts: Vec::new(),
            controls: Vec::new(),
        };
        let end = |order: &[(usize, bool)], missing: f64, cost: f64| End {
            throw: Throw {
                start: Vec::new(),
                controls: ControlGrid::constant(vec![Vec::new()]),
                horizon: 1.0,
            },
            order: order.to_vec(),
            missing: vec![missing],
            impacts: 0,
            cost,
        };
        let (once, twice) = ([(0, true)], [(0, true), (0, true)]);
        archive.add(end(&once, 1.0, -5.0));
        archive.add(end(&once, 0.02, 3.0));
        // Further from the goal by less than a twentieth of its unit, and cheaper.
        archive.add(end(&once, 0.08, 2.0));
        archive.add(end(&twice, 0.05, 1.0));
        archive.add(end(&twice, f64::NAN, 0.0));
        let found: Vec<(usize, f64)> = archive
            .sorted()
            .iter()
            .map(|end| (end.order.len(), end.cost))
            .collect();
        assert_eq!(found, [(2, 1.0), (1, 2.0)]);
    }
}
