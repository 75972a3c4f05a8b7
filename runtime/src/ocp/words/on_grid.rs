//! Words on the control grid: in which interval, or at which end of one, each switch is.
//!
//! A switch stays where it is put while a program on the grid is solved, so that every choice of places is a program of its own. They
//! begin with the intervals in which switches are off the grid, and with the nearest ends where controls jump there, which is in another
//! basin; then switches that press on an end of their interval are moved through it, and others to the nearest end. As off the grid goals may be missed at a price, so that places without a motion say where it presses.

use super::off_grid::{Goals, Timed, solved};
use super::word::Word;
use crate::ocp::collocation::discretization::{Lengths, Setting};
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::control_grid::{ControlGrid, ControlShape};
use crate::ocp::motion::sequence::{Place, Sequence, Switch};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::Runner;
use crate::ocp::tuning::equal::{MET, OPTIMUM};
use crate::ocp::tuning::on_grid::{
    AT_AN_END, BARRIER, BESIDE_A_JUMP, DEARER, DEARER_ROUNDS, ENTRY, ITERATIONS, JUMP, MOVES, NEAR,
    NEARBY, NO_NEARER, PRESSES, SHIFTS,
};
use crate::rk::ButcherTableau;

/// Where the switches of an instant are: in an interval, or at its start.
type Slot = (usize, Place);

/// A word on the grid, solved with these places.
pub(in crate::ocp) struct Placed {
    places: Vec<Slot>,
    /// Of the instants, in intervals.
    times: Vec<f64>,
    pub(in crate::ocp) merit: f64,
    pub(in crate::ocp) missed: f64,
    /// Whether it costs less than the word does off the grid, by more than that is let be: mostly an element that is too long for what
    /// happens in it.
    is_below: bool,
    pub(in crate::ocp) candidate: Candidate,
}

/// The grid, and what a miss costs.
pub(in crate::ocp) struct Grid<'a, 'g> {
    pub(in crate::ocp) setting: Setting<'a>,
    pub(in crate::ocp) tableau: &'g ButcherTableau,
    pub(in crate::ocp) goals: &'g Goals,
    /// Finite elements of a phase in each interval.
    pub(in crate::ocp) elements: &'g [usize],
}

impl Placed {
    /// Whether it reaches the goals.
    pub(in crate::ocp) fn reaches(&self) -> bool {
        self.missed <= MET
    }

    /// Those that reach the goals first, of these the ones that cost no less than their word, then by merit.
    pub(in crate::ocp) fn rank(&self) -> (bool, bool, f64) {
        (!self.reaches(), self.is_below, self.merit)
    }

    /// Whether it is better than another one by more than nothing.
    fn improves(&self, other: &Self) -> bool {
        let gain = other.merit - self.merit > OPTIMUM * other.merit.abs();
        let of = |placed: &Self| (!placed.reaches(), placed.is_below);
        of(self) < of(other) || of(self) == of(other) && gain
    }
}

impl Grid<'_, '_> {
    /// The better of two ways to put a word on the grid: each switch in the interval in which it is off the grid, and those at the nearest
    /// end where controls jump.
    pub(in crate::ocp) fn rounded(&self, runner: &mut Runner, timed: &Timed) -> Option<Placed> {
        let horizon = timed.motion.horizon;
        let intervals = self.setting.problem.intervals;
        let trajectory = self.driven(timed);
        let times = timed.draft.times.iter();
        let times: Vec<f64> = times
            .map(|time| time / horizon * intervals as f64)
            .collect();
        let [inside, at_jumps] =
            [false, true].map(|at_jumps| places(self.setting, timed, at_jumps));
        let differs = at_jumps != inside && runner.settings.uses("at-jumps");
        let mut placed = |places: &[Slot]| {
            let going_on = !runner.stopped();
            going_on.then(|| self.placed(runner, timed, (places, &times), &trajectory, None))?
        };
        let one = placed(&inside);
        let other = differs.then(|| placed(&at_jumps)).flatten();
        match (one, other) {
            (Some(one), Some(other)) if other.rank() < one.rank() => Some(other),
            (one, other) => one.or(other),
        }
    }

    /// The best that a word comes to with single instants an interval earlier and later, and with all behind them, as long as the grid costs
    /// more than it has to: from the motion off the grid, warped to there.
    pub(in crate::ocp) fn shifted(
        &self,
        runner: &mut Runner,
        timed: &Timed,
        placed: Placed,
    ) -> Placed {
        let mut best = placed;
        let mut tried: Vec<Vec<Slot>> = vec![best.places.clone()];
        let bound = timed.merit + NEAR * timed.merit.abs();
        let nearby = match runner.settings.uses("near") {
            true => self.nearby(timed),
            false => Vec::new(),
        };
        let most = SHIFTS + nearby.len();
        'again: while best.is_below || !best.reaches() || best.merit > bound {
            let shifts = self.shifts(&best).into_iter();
            for (places, times) in shifts.chain(nearby.iter().cloned()) {
                if tried.len() > most || runner.stopped() || runner.ledger.is_spent() {
                    break 'again;
                }
                if tried.contains(&places) || !is_in_order(&places) {
                    continue;
                }
                tried.push(places.clone());
                let guess = self.warped(timed, &times);
                let found = self.placed(runner, timed, (&places, &times), &guess, Some(&best));
                if let Some(found) = found
                    && found.improves(&best)
                {
                    best = found;
                    continue 'again;
                }
            }
            break;
        }
        best
    }

    /// Places of all instants, the nearest to the times off the grid first: in their intervals, at the ends of these, and in the next ones.
    fn nearby(&self, timed: &Timed) -> Vec<(Vec<Slot>, Vec<f64>)> {
        let intervals = self.setting.problem.intervals;
        let horizon = timed.motion.horizon;
        let count = timed.draft.times.len();
        let mut all: Vec<Near> = vec![Near::default()];
        for (index, time) in timed.draft.times.iter().enumerate() {
            let ends = timed.word().ends_with_impact && index + 1 == count;
            let time = time / horizon * intervals as f64;
            let choices = match ends {
                true => vec![((intervals, Place::Start), time)],
                false => choices(time, intervals),
            };
            let more = all.iter().flat_map(|near| {
                let choices = choices.iter();
                choices.filter_map(|(at, to)| near.and(*at, *to, (to - time).abs()))
            });
            let mut more: Vec<Near> = more.collect();
            more.sort_by(|a, b| a.distance.total_cmp(&b.distance));
            more.truncate(NEARBY);
            all = more;
        }
        all.into_iter()
            .map(|near| (near.places, near.times))
            .collect()
    }

    /// Single instants an interval earlier and later, and then with all behind them.
    fn shifts(&self, placed: &Placed) -> Vec<(Vec<Slot>, Vec<f64>)> {
        let intervals = self.setting.problem.intervals as isize;
        let count = placed.places.len();
        let mut found = Vec::new();
        for all_behind in [false, true] {
            for first in 0..count {
                let last = if all_behind { count } else { first + 1 };
                if all_behind && last < first + 2 {
                    continue;
                }
                for step in [-1, 1] {
                    let (mut places, mut times) = (placed.places.clone(), placed.times.clone());
                    for k in first..last {
                        let to = places[k].0 as isize + step;
                        if (0..intervals).contains(&to) {
                            places[k] = (to as usize, Place::Inside);
                            let begin = to as f64;
                            times[k] =
                                (times[k] + step as f64).clamp(begin + ENTRY, begin + 1.0 - ENTRY);
                        }
                    }
                    if places != placed.places {
                        found.push((places, times));
                    }
                }
            }
        }
        found
    }

    /// The motion of a word off the grid with its instants at other times, in intervals.
    fn warped(&self, timed: &Timed, times: &[f64]) -> Trajectory {
        let motion = self.driven(timed);
        let interval = motion.horizon / self.setting.problem.intervals as f64;
        let own = timed.draft.times.iter();
        let pairs: Vec<(f64, f64)> = own.zip(times).map(|(a, b)| (*a, interval * b)).collect();
        let inside = pairs.iter().all(|(a, _)| *a > 0.0 && *a < motion.horizon);
        let ordered = pairs
            .windows(2)
            .all(|pair| pair[0].0 < pair[1].0 && pair[0].1 < pair[1].1);
        match inside && ordered {
            true => motion.warped(&pairs),
            false => motion,
        }
    }

    /// The motion of a word off the grid with the controls of the intervals of the grid.
    fn driven(&self, timed: &Timed) -> Trajectory {
        let horizon = timed.motion.horizon;
        let intervals = self.setting.problem.intervals;
        let end = |k: usize| horizon * k as f64 / intervals as f64;
        let controls = (0..intervals).map(|k| timed.motion.controls_between(end(k), end(k + 1)));
        Trajectory {
            controls: ControlGrid::constant(controls.collect()),
            ..timed.motion.clone()
        }
    }

    /// The best that switches come to which are moved through the ends of their intervals.
    pub(in crate::ocp) fn moved(
        &self,
        runner: &mut Runner,
        timed: &Timed,
        placed: Placed,
    ) -> Placed {
        let mut best = placed;
        let mut tried: Vec<Vec<Slot>> = vec![best.places.clone()];
        let mut moves = 0;
        'again: while moves < MOVES {
            for (instant, to) in self.moves(&best) {
                let mut places = best.places.clone();
                places[instant] = to;
                if tried.contains(&places) || !is_in_order(&places) || runner.stopped() {
                    continue;
                }
                tried.push(places.clone());
                moves += 1;
                let with = (&places[..], &best.times[..]);
                let guess = &best.candidate.trajectory;
                let found = self.placed(runner, timed, with, guess, Some(&best));
                if let Some(found) = found
                    && found.improves(&best)
                {
                    best = found;
                    continue 'again;
                }
                if moves >= MOVES {
                    break;
                }
            }
            break;
        }
        best
    }

    /// Other places of single instants, those first that press on an end of their interval.
    fn moves(&self, placed: &Placed) -> Vec<(usize, Slot)> {
        let intervals = self.setting.problem.intervals;
        let (mut pressing, mut others) = (Vec::new(), Vec::new());
        for (instant, (&(interval, place), &time)) in
            placed.places.iter().zip(&placed.times).enumerate()
        {
            if interval >= intervals {
                continue;
            }
            let share = time - interval as f64;
            let mut push = |presses: bool, at: Slot| {
                let inside = at.0 < intervals && (at.0 > 0 || at.1 == Place::Inside);
                let list = if presses { &mut pressing } else { &mut others };
                list.extend(inside.then_some((instant, at)));
            };
            match place {
                Place::Inside if share < PRESSES && interval > 0 => {
                    push(true, (interval, Place::Start));
                    push(true, (interval - 1, Place::Inside));
                }
                Place::Inside if share > 1.0 - PRESSES => {
                    push(true, (interval + 1, Place::Start));
                    push(true, (interval + 1, Place::Inside));
                }
                Place::Inside => push(false, (time.round() as usize, Place::Start)),
                Place::Start => {
                    push(false, (interval - 1, Place::Inside));
                    push(false, (interval, Place::Inside));
                }
            }
        }
        pressing.extend(others);
        pressing
    }

    /// Solves a word with its instants at these places; what misses its goals only as far as it may still be better than the best places:
    /// dearer misses lower no objective.
    fn placed(
        &self,
        runner: &mut Runner,
        timed: &Timed,
        (places, times): (&[Slot], &[f64]),
        guess: &Trajectory,
        best: Option<&Placed>,
    ) -> Option<Placed> {
        let word = timed.word();
        let sequence = sequence(word, places, times, self.setting.problem.intervals)?;
        let setting = Setting {
            tableau: self.tableau,
            shape: ControlShape::Constant,
            lengths: Lengths::Equal,
            elastic: Some(&self.goals.sizes),
            ..self.setting
        };
        let with = (BARRIER, ITERATIONS);
        let mut goals = self.goals.clone();
        let from = (&sequence, guess, self.elements);
        let (mut program, mut solution) = solved(runner, setting, from, &mut goals, with)?;
        // What misses, once more where that is dearer, from where it ended.
        for _ in 0..DEARER_ROUNDS {
            let missed = program.missed(&solution.x);
            if missed <= MET || runner.stopped() {
                break;
            }
            let meets = best.filter(|best| best.reaches() && !best.is_below);
            if meets.is_some_and(|best| best.merit <= solution.objective) {
                break;
            }
            goals = goals.at(DEARER * goals.price?);
            let (from, ordered) = program.result(&solution.x);
            let from = (&ordered, &from, self.elements);
            let Some((again, other)) = solved(runner, setting, from, &mut goals, with) else {
                break;
            };
            if again.missed(&other.x) > NO_NEARER * missed {
                break;
            }
            (program, solution) = (again, other);
        }
        let (trajectory, sequence) = program.result(&solution.x);
        let missed = program.missed(&solution.x);
        let mut first = 0;
        let times = word.instants.iter().map(|instant| {
            first += instant.len();
            sequence.switches[first - instant.len()].time
        });
        Some(Placed {
            places: places.to_vec(),
            times: times.collect(),
            merit: solution.objective,
            missed,
            is_below: solution.objective < timed.merit - NEAR * timed.merit.abs(),
            candidate: Candidate {
                objective: solution.objective,
                trajectory,
                sequence,
            },
        })
    }
}

/// Places of the first instants, their times in intervals, and how far they are from the times off the grid in all.
#[derive(Default)]
struct Near {
    places: Vec<Slot>,
    times: Vec<f64>,
    distance: f64,
}

impl Near {
    /// The same with one more, so far from its time; none where that comes before the last one.
    fn and(&self, at: Slot, time: f64, distance: f64) -> Option<Self> {
        let last = self.places.last();
        let twice = at.1 == Place::Start && last == Some(&at);
        (!twice && last.is_none_or(|last| *last <= at)).then(|| Self {
            places: [&self.places[..], &[at]].concat(),
            times: [&self.times[..], &[time]].concat(),
            distance: self.distance + distance,
        })
    }
}

/// Where an instant may be whose time, in intervals, is that.
fn choices(time: f64, intervals: usize) -> Vec<(Slot, f64)> {
    let own = (time.max(0.0) as usize).min(intervals - 1);
    let inside = |interval: usize| {
        let begin = interval as f64;
        let time = time.clamp(begin + ENTRY, begin + 1.0 - ENTRY);
        ((interval, Place::Inside), time)
    };
    let end = |end: usize| ((end, Place::Start), end as f64);
    let ends = [own, own + 1].into_iter();
    let ends = ends.filter(|end| (1..intervals).contains(end)).map(end);
    let next = [own.checked_sub(1), Some(own + 1)].into_iter().flatten();
    let next = next.filter(|next| *next < intervals).map(inside);
    [((own, Place::Inside), time)]
        .into_iter()
        .chain(ends)
        .chain(next)
        .collect()
}

/// The sequence of a word with its instants at these places; `None` where that is no order.
fn sequence(word: &Word, places: &[Slot], times: &[f64], intervals: usize) -> Option<Sequence> {
    let mut switches: Vec<Switch> = Vec::new();
    for (instant, (&(interval, place), &time)) in word.instants.iter().zip(places.iter().zip(times))
    {
        let begin = interval as f64;
        let time = match place {
            Place::Start => begin,
            Place::Inside => time.clamp(begin, begin + 1.0),
        };
        switches.extend(instant.iter().map(|switch| Switch {
            interval,
            place,
            time,
            ..*switch
        }));
    }
    word.with_switches(switches).ordered(intervals)
}

/// The interval of each instant, or its nearest end where the controls jump there; an impact that ends the motion is at its end.
fn places(setting: Setting, timed: &Timed, at_jumps: bool) -> Vec<Slot> {
    let intervals = setting.problem.intervals;
    let n = setting.problem.q.len();
    let (lower, upper) = setting.bounds;
    let motion = &timed.motion;
    let horizon = motion.horizon;
    let count = timed.draft.times.len();
    let jumps = |time: f64| {
        let reach = BESIDE_A_JUMP * horizon;
        let before = motion.controls_between(time - reach, time);
        let after = motion.controls_between(time, time + reach);
        let changes = before.iter().zip(&after).enumerate();
        changes.fold(0.0, |most: f64, (k, (a, b))| {
            let range = upper[n + k] - lower[n + k];
            let size = a.abs().max(b.abs()).max(f64::MIN_POSITIVE);
            let range = if range.is_finite() { range } else { size };
            most.max((a - b).abs() / range)
        }) > JUMP
    };
    let place = |(index, &time): (usize, &f64)| {
        if timed.word().ends_with_impact && index + 1 == count {
            return (intervals, Place::Start);
        }
        let z = time / horizon * intervals as f64;
        let inside = ((z.max(0.0) as usize).min(intervals - 1), Place::Inside);
        if intervals < 2 || !at_jumps {
            return inside;
        }
        let end = (z.round() as usize).clamp(1, intervals - 1);
        match (z - end as f64).abs() <= AT_AN_END || jumps(time) {
            true => (end, Place::Start),
            false => inside,
        }
    };
    in_order(
        timed.draft.times.iter().enumerate().map(place).collect(),
        intervals,
    )
}

fn is_in_order(places: &[Slot]) -> bool {
    places.windows(2).all(|pair| pair[0] <= pair[1])
}

/// Places none of which is before the one before it; of two at one end the later one is inside the interval.
fn in_order(places: Vec<Slot>, intervals: usize) -> Vec<Slot> {
    let mut all: Vec<Slot> = Vec::with_capacity(places.len());
    for mut place in places {
        if let Some(&last) = all.last() {
            place = place.max(last);
            if place == last && place.1 == Place::Start && place.0 < intervals {
                place.1 = Place::Inside;
            }
        }
        all.push(place);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instant_may_be_in_its_interval_at_its_ends_and_in_the_next_ones() {
        use Place::{Inside, Start};
        let places = |time| choices(time, 8).into_iter().map(|(at, _)| at);
        let middle = [
            (3, Inside),
            (3, Start),
            (4, Start),
            (2, Inside),
            (4, Inside),
        ];
        assert!(places(3.4).eq(middle));
        // Ends of the motion are no ends at which controls change.
        assert!(places(0.2).eq([(0, Inside), (1, Start), (1, Inside)]));
        assert!(places(8.0).eq([(7, Inside), (7, Start), (6, Inside)]));
        // One instant stays behind the other, and both are not at one end.
        let near = Near::default().and((3, Start), 3.0, 0.4);
        let near = near.expect("the first");
        assert!(near.and((3, Start), 3.0, 0.0).is_none());
        assert!(near.and((2, Inside), 2.9, 0.0).is_none());
        let both = near.and((3, Inside), 3.4, 0.1).expect("in order");
        assert!((both.distance - 0.5).abs() < 1e-12);
    }

    #[test]
    fn places_stay_in_order_and_two_at_an_end_are_at_it_and_after_it() {
        use Place::{Inside, Start};
        let given = vec![(3, Start), (3, Start), (2, Inside), (5, Inside)];
        let ordered = [(3, Start), (3, Inside), (3, Inside), (5, Inside)];
        assert_eq!(in_order(given, 8), ordered);
        assert!(is_in_order(&ordered));
    }
}
