//! Orders of impacts that no guess leads to, as one more bounce before the goal: simulated motions, of which one is kept for each order.
//!
//! Motions from random free initial values under random controls are simulated. Wherever one of them may end it has an order of events,
//! a distance to goals, bounds and path constraints, and a cost. Of each order the best is kept, and changed at random to find better
//! ones and further orders (an archive of elites, Mouret and Clune 2015). The best of all orders are what programs start from.

use std::collections::{BTreeMap, BTreeSet};

use super::policy::policy;
use super::replay::simulated;
use super::throw::{End, Order, Throw, ends, ends_of_changed};
use crate::model::held;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::global::guess::{guess, random, uniform};
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::ControlGrid;
use crate::ocp::motion::targets::goal_values;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::problem::Horizon;
use crate::ocp::program::runner::Runner;
use crate::ocp::settings::Guess;
use crate::ocp::tuning::beginnings::MOST_PHASES;
use crate::ocp::tuning::sampled::{
    ALIKE, BEST, CHANGES, EVENTS, LONGER, NARROWED, NARROWER, OF_EACH_KIND, OF_RANGE, PILOTS,
    POLICIES, TOLERANCE, WITHIN,
};
use crate::simulation::InputError;

/// Least and largest values of coordinates and controls between which random controls are drawn.
pub(in crate::ocp) type Range = (Vec<f64>, Vec<f64>);

/// How good an end is: distance, cost, and distance among those that are alike; smaller is better.
pub(super) type Rank = (u64, f64, f64);

/// What random motions have come to.
#[derive(Default)]
pub(in crate::ocp) struct Sampled {
    /// The best motion of each order, the best ones first.
    pub(in crate::ocp) motions: Vec<Candidate>,
    /// The one without controls, up to where it comes nearest to the goals.
    pub(in crate::ocp) ride: Option<Candidate>,
    /// The cheapest one that misses nothing.
    pub(in crate::ocp) meeting: Option<Trajectory>,
    /// What most of the drawn ones miss less of each goal.
    pub(in crate::ocp) units: Vec<f64>,
    /// Size that the cost of most of the best ones does not exceed.
    pub(in crate::ocp) cost: f64,
}

/// The best motion of each order, the best ones first: of so many motions that are drawn and that are made of the best ones, and of at most
/// so many orders; other ones at each turn, from 0.
pub(in crate::ocp) fn best_of_each_order(
    runner: &mut Runner,
    (setting, range): (Setting, &Range),
    (drawn_motions, changed): (u64, usize),
    (most, turn): (usize, u64),
) -> Result<Sampled, InputError> {
    let model = setting.model;
    let strikes = model
        .declaration()
        .contacts
        .iter()
        .any(|contact| !contact.dry);
    // Where nothing is struck, all that switches is in the order.
    let most_events = if strikes { EVENTS } else { MOST_PHASES };
    let first = turn * drawn_motions;
    let mut archive = drawn((setting, range), first..first + drawn_motions, most_events)?;
    let straight = guess(model, setting.problem, &Guess::Straight, setting.bounds)?;
    let driven = !model.declaration().controls.is_empty();
    let policies = turn * POLICIES..(turn + 1) * POLICIES;
    for seed in policies.filter(|_| driven) {
        let throw = policy(setting, &straight, seed);
        let longest = match setting.problem.horizon {
            Horizon::Fixed(horizon) => horizon,
            Horizon::Free { .. } => throw.horizon,
        };
        for end in ends(setting, &throw, longest, most_events) {
            archive.add_order(end);
        }
    }
    let ride = archive.ride((setting, &straight), most_events);
    let mut random = uniform(first + drawn_motions);
    for k in 0..changed {
        if archive.best.is_empty() || !runner.goes_on("random motions") {
            break;
        }
        let parent = archive.parent(k, &mut random);
        let child = archive.changed(setting, parent, CHANGES[k % CHANGES.len()], &mut random);
        for end in ends_of_changed(setting, &child, most_events) {
            archive.add(end);
        }
    }
    let tolerance = runner.settings.replay_tolerance;
    let motion = |end: &End| {
        let motion = end.throw.over(end.throw.horizon);
        // One that is refused, as in no time, is none.
        simulated(setting, &motion, tolerance).ok().flatten()
    };
    let best = archive.sorted().into_iter().take(most);
    Ok(Sampled {
        motions: best.filter_map(&motion).collect(),
        ride: ride.as_ref().and_then(&motion),
        meeting: archive
            .meeting
            .as_ref()
            .map(|end| end.throw.over(end.throw.horizon)),
        cost: archive.usual_cost(),
        units: archive.units,
    })
}

/// The best end of each order.
pub(super) struct Archive {
    best: BTreeMap<Order, (Rank, End)>,
    /// The cheapest that misses nothing.
    meeting: Option<End>,
    /// The orders that only policies have led to.
    by_policy: BTreeSet<Order>,
    /// Units of what is missing.
    pub(super) units: Vec<f64>,
    /// Ranges of the values that were drawn: of starts, and of controls.
    starts: Vec<(f64, f64)>,
    controls: Vec<(f64, f64)>,
}

/// The archive of the random motions of these seeds, as far as they have no more than `most_events`.
pub(super) fn drawn(
    (setting, range): (Setting, &Range),
    seeds: std::ops::Range<u64>,
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
    let whole = (bounds.0.to_vec(), bounds.1.to_vec());
    for seed in seeds {
        // Half of them from all that is allowed: what motions stay near with little may need more to be reached.
        let range = if seed % 2 == 1 { &whole } else { range };
        let (throw, ends) = one_drawn(setting, &straight, range, (seed, most_events));
        all.extend(ends);
        throws.push(throw);
    }
    let starts = throws.iter().map(|throw| &throw.start);
    let controls = throws.iter().flat_map(|throw| throw.controls.values());
    let mut archive = Archive {
        best: BTreeMap::new(),
        meeting: None,
        by_policy: BTreeSet::new(),
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

/// Units of the conditions: what most of the ends miss by less, or else the most that one misses, but no more than the start misses, which
/// is no end; of bounds a share of the range.
fn units(setting: Setting, ends: &[End]) -> Vec<f64> {
    let count = ends.first().map_or(0, |end| end.missing.len());
    let declared = setting.model.declaration().optimal_control;
    let goals = declared.map_or(0, |declared| declared.goals.len());
    let (lower, upper) = setting.bounds;
    let coordinates = setting.problem.q.len();
    let mut start = setting.problem.start();
    start.push(setting.units.time);
    let at_start = goal_values(setting.model, &start);
    let unit = |k: usize| {
        let mut values: Vec<f64> = ends.iter().map(|end| end.missing[k].abs()).collect();
        values.sort_by(f64::total_cmp);
        let usual = values[(WITHIN * values.len() as f64) as usize];
        let usual = if usual > 0.0 {
            usual
        } else {
            values[values.len() - 1]
        };
        let missed = at_start.get(k).map_or(0.0, |missed| missed.abs());
        if missed > TOLERANCE * usual {
            usual.min(missed)
        } else {
            usual
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
        let meets = end.missing.iter().all(|missing| *missing == 0.0);
        let dearer = |known: &End| known.cost > end.cost;
        if meets && self.meeting.as_ref().is_none_or(dearer) {
            self.meeting = Some(end.clone());
        }
        let rank = self.rank(&end);
        let known = self.best.get(&end.order);
        let better = known.is_none_or(|known| compare(&rank, &known.0).is_lt());
        if rank.2.is_finite() && rank.1.is_finite() && better {
            self.best.insert(end.order.clone(), (rank, end));
        }
    }

    /// Adds where the motion without controls may end, and returns the best of these ends.
    fn ride(
        &mut self,
        (setting, straight): (Setting, &Trajectory),
        most_events: usize,
    ) -> Option<End> {
        let throw = Throw {
            start: setting.problem.start(),
            controls: straight.controls.clone(),
            horizon: straight.horizon,
        };
        let longest = match setting.problem.horizon {
            Horizon::Fixed(horizon) => horizon,
            Horizon::Free { .. } => LONGER * throw.horizon,
        };
        let ends = ends(setting, &throw, longest, most_events);
        ends.iter().for_each(|end| self.add_order(end.clone()));
        ends.into_iter()
            .min_by(|a, b| compare(&self.rank(a), &self.rank(b)))
    }

    /// Adds an end if there is none of its order from elsewhere, or it is better than one that was added so.
    fn add_order(&mut self, end: End) {
        let known = self.best.contains_key(&end.order);
        if !known || self.by_policy.contains(&end.order) {
            self.by_policy.insert(end.order.clone());
            self.add(end);
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
            let range = setting.final_times();
            let changed = throw.horizon * (share * random()).exp();
            throw.horizon = changed.clamp(range.shortest, range.longest);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn archive_keeps_the_best_end_of_each_order_and_cost_decides_among_those_that_are_alike() {
        let mut archive = Archive {
            meeting: None,
            best: BTreeMap::new(),
            by_policy: BTreeSet::new(),
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
        assert!(archive.meeting.is_none());
        archive.add(end(&[], 0.0, 8.0));
        archive.add(end(&[], 0.0, 7.0));
        archive.add(end(&twice, 0.0, 9.0));
        assert!(archive.meeting.take().is_some_and(|end| end.cost == 7.0));
        archive.best.clear();
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
