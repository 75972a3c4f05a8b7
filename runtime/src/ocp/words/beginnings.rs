//! Words to begin with: of simulated motions under random controls and under policies, of what they begin with, of the ride without
//! controls, of steps and visits of contacts, of relaxed time-freezing programs, and the one without switches.

use super::library::Library;
use super::off_grid::Goals;
use super::word::Draft;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::global::guess::{guess, uniform};
use crate::ocp::global::start_modes::modes_at_start;
use crate::ocp::global::time_freezing::refuse_resets;
use crate::ocp::global::time_freezing_search::candidate;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::mode::{closed_mode, is_condition, is_frictional};
use crate::ocp::motion::passages::with_passages;
use crate::ocp::motion::sequence::{Sequence, Switch};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::previous::Previous;
use crate::ocp::problem::has_free_start;
use crate::ocp::program::runner::Runner;
use crate::ocp::search::replay::simulations;
use crate::ocp::search::sampled::{Range, Sampled, best_of_each_order};
use crate::ocp::settings::{Guess, TimeFreezingSettings};
use crate::ocp::tuning::beginnings::{
    CHANGED, DRAWN, LEARNED, MOST_PHASES, OF_EACH_LENGTH, PHASES, RELAXED, STEP, STEPS, TRIES,
    VISIT, VISITS, WORDS,
};
use crate::simulation::{ContactMode, InputError};

/// The source whose words come from time-freezing programs.
const FREEZING: &str = "relaxed";
/// The source whose word is that of a plan on the grid.
pub(super) const PLAN: &str = "plan";

/// A word to begin with, and the motion that it is of.
pub(in crate::ocp) struct Beginning {
    pub(super) draft: Draft,
    pub(super) motion: Trajectory,
    pub(super) source: &'static str,
}

/// What the search begins with.
#[derive(Default)]
pub(in crate::ocp) struct Begun {
    pub(in crate::ocp) words: Vec<Beginning>,
    /// What motions went through.
    pub(in crate::ocp) library: Library,
    /// The cheapest simulated motion that misses nothing.
    pub(in crate::ocp) meeting: Option<Trajectory>,
    /// Simulated motions on the grid: without controls, and of the best orders.
    pub(in crate::ocp) motions: Vec<Candidate>,
}

/// Words to begin with, first that of a plan on the grid, and the goals as motions miss them; random controls are drawn from a range, other ones at each turn, from 0. Of a
/// known motion there is its own word alone.
pub(in crate::ocp) fn beginnings(
    runner: &mut Runner,
    (setting, guessed): (Setting, &Trajectory),
    (plan, range, turn): (Option<&Previous>, &Range, u64),
) -> Result<(Begun, Goals), InputError> {
    let mut library = Library::default();
    let mut found: Vec<Beginning> = Vec::new();
    let mut motions: Vec<Candidate> = Vec::new();
    if let Guess::Previous(previous) = &runner.settings.guess {
        let known = previous.candidate(guessed, setting.problem.intervals);
        let (draft, motion) = read(setting, known);
        library.learn(&draft.word);
        add(&mut found, (draft, motion), "known");
        let goals = Goals::of(setting, &Sampled::default());
        let begun = Begun {
            words: found,
            library,
            ..Begun::default()
        };
        return Ok((begun, goals));
    }
    let sampled = best_of_each_order(runner, (setting, range), (DRAWN, CHANGED), (LEARNED, turn))?;
    let goals = Goals::of(setting, &sampled);
    let mut drafts: Vec<(Draft, Trajectory)> = Vec::new();
    motions.extend(sampled.ride);
    for candidate in sampled.motions {
        motions.push(candidate.clone());
        let (draft, motion) = read(setting, candidate);
        library.learn(&draft.word);
        if draft.word.phases() <= MOST_PHASES {
            drafts.push((draft, motion));
        }
    }
    if let Some(plan) = plan {
        let trajectory = plan.trajectory(setting.model, setting.problem)?;
        let intervals = setting.problem.intervals;
        let word = read(setting, plan.candidate(&trajectory, intervals));
        learn(&mut library, &mut found, word, PLAN);
    }
    for (draft, motion) in drafts.iter().take(WORDS) {
        add(&mut found, (draft.clone(), motion.clone()), "sample");
    }
    for phases in 1..=PHASES {
        add_beginnings(&mut found, &drafts, phases);
    }
    let tolerance = runner.settings.replay_tolerance;
    for candidate in simulations(setting, guessed, tolerance).unwrap_or_default() {
        learn(&mut library, &mut found, read(setting, candidate), "ride");
    }
    let empty = Sequence::without_switches(modes_at_start(setting, guessed));
    let length = guessed.horizon / setting.problem.intervals as f64;
    let draft = Draft::read(&empty, length, guessed.horizon);
    add(&mut found, (draft, guessed.clone()), "empty");
    let visits = visits(setting, &empty, guessed).into_iter();
    let steps = steps(setting, &empty).into_iter();
    let made = steps.map(|one| (one, "steps"));
    for (sequence, source) in made.chain(visits.map(|one| (one, "visits"))) {
        let draft = Draft::read(&sequence, length, guessed.horizon);
        add(&mut found, (draft, guessed.clone()), source);
    }
    found.retain(|one| one.source == PLAN || runner.settings.uses(one.source));
    // Where there is a plan already it brings nothing.
    if plan.is_none() && runner.settings.uses(FREEZING) {
        let simulated = motions.iter().map(|motion| &motion.trajectory);
        for word in relaxed(runner, setting, simulated.take(RELAXED)) {
            learn(&mut library, &mut found, word, FREEZING);
        }
    }
    let begun = Begun {
        words: found,
        library,
        meeting: sampled.meeting,
        motions,
    };
    Ok((begun, goals))
}

/// Learns from a word, and adds it where it is short enough.
fn learn(
    library: &mut Library,
    found: &mut Vec<Beginning>,
    word: (Draft, Trajectory),
    source: &'static str,
) {
    library.learn(&word.0.word);
    if word.0.word.phases() <= MOST_PHASES {
        add(found, word, source);
    }
}

/// Adds what motions begin with, of that many phases.
fn add_beginnings(found: &mut Vec<Beginning>, drafts: &[(Draft, Trajectory)], phases: usize) {
    let mut count = 0;
    for (draft, motion) in drafts {
        let shorter = draft.up_to(phases);
        if count < OF_EACH_LENGTH
            && draft.word.phases() > phases
            && add(found, (shorter, motion.clone()), "beginning")
        {
            count += 1;
        }
    }
}

/// The words of relaxed time-freezing programs that start from simulations under the controls of these motions.
fn relaxed<'m>(
    runner: &mut Runner,
    setting: Setting,
    motions: impl Iterator<Item = &'m Trajectory>,
) -> Vec<(Draft, Trajectory)> {
    if refuse_resets(setting.model).is_err() {
        return Vec::new();
    }
    let failure = runner.take_failure();
    let formulation = TimeFreezingSettings::default();
    let mut words = Vec::new();
    for motion in motions {
        let found = candidate(runner, setting, &formulation, motion, true);
        if let Ok(Some((_, Some(candidate)))) = found {
            words.push(read(setting, candidate));
        }
    }
    runner.restore_failure(failure, true);
    runner.take_refusal();
    words
}

/// Steps of feet of which two or more stand at first, which random controls never take and no edit of a jump leads to: of each alone, of two
/// in turn, once and twice.
fn steps(setting: Setting, standing: &Sequence) -> Vec<Sequence> {
    let model = setting.model;
    let declared = model.declaration().contacts;
    let modes = standing.initially.iter().enumerate();
    let feet = modes.filter(|(contact, mode)| !mode.is_open() && !declared[*contact].dry);
    let feet: Vec<usize> = feet.map(|(contact, _)| contact).collect();
    if feet.len() < 2 {
        return Vec::new();
    }
    let intervals = setting.problem.intervals;
    let sequences = gaits(&feet).into_iter().filter_map(|gait| {
        let part = intervals as f64 / gait.len() as f64;
        let mut sequence = standing.clone();
        for (step, &foot) in gait.iter().enumerate() {
            let [off, on] = [STEP, 1.0 - STEP].map(|share| (step as f64 + share) * part);
            let mode = closed_mode(is_frictional(model, foot), 0.0, 0.0);
            let lifts = Switch::inside(foot, false, ContactMode::Open, off);
            let lands = Switch {
                impulse: mode,
                ..Switch::inside(foot, true, mode, on)
            };
            sequence.switches.extend([lifts, lands]);
        }
        sequence.ordered(intervals)
    });
    sequences.take(STEPS).collect()
}

/// Visits of contacts that are open at first, which a motion under random controls seldom makes: each closes and stays closed, or what stands
/// lifts off, comes to it, leaves it and stands again.
fn visits(setting: Setting, standing: &Sequence, guess: &Trajectory) -> Vec<Sequence> {
    let (model, intervals) = (setting.model, setting.problem.intervals);
    let declared = model.declaration().contacts;
    let modes = standing.initially.iter().enumerate();
    let (open, closed): (Vec<_>, Vec<_>) = modes
        .map(|(contact, mode)| (contact, mode.is_open()))
        .filter(|(contact, _)| !declared[*contact].dry && !is_condition(model, *contact))
        .partition(|(_, is_open)| *is_open);
    let place = |share: f64| share * intervals as f64;
    let leaves = |contact, share| Switch::inside(contact, false, ContactMode::Open, place(share));
    let closes = |contact, share| {
        let mode = closed_mode(is_frictional(model, contact), 0.0, 0.0);
        Switch {
            impulse: mode,
            ..Switch::inside(contact, true, mode, place(share))
        }
    };
    let with = |switches: Vec<Switch>| {
        let mut sequence = standing.clone();
        sequence.switches = switches;
        let sequence = with_passages(model, sequence, guess, false);
        sequence.ordered(intervals)
    };
    let all = |switch: &dyn Fn(usize, f64) -> Switch, share: f64| -> Vec<Switch> {
        let switches = closed.iter().enumerate().map(|(k, &(contact, _))| Switch {
            accompanies: k > 0,
            ..switch(contact, share)
        });
        switches.collect()
    };
    let visits = open.iter().flat_map(|&(contact, _)| {
        let [begin, end] = VISIT;
        let visit = vec![closes(contact, begin), leaves(contact, end)];
        let visit = [
            all(&leaves, 0.5 * begin),
            visit,
            all(&closes, 0.5 * (1.0 + end)),
        ];
        [vec![closes(contact, 0.5)], visit.concat()]
    });
    visits.filter_map(with).take(VISITS).collect()
}

/// Feet that step, one after the other: each alone, two in turn, each twice, two in turn twice.
fn gaits(feet: &[usize]) -> Vec<Vec<usize>> {
    let alone = feet.iter().map(|&one| vec![one]);
    let in_turn = feet.iter().flat_map(|&one| {
        let others = feet.iter().filter(move |&&other| other != one);
        others.map(move |&other| vec![one, other])
    });
    let once: Vec<Vec<usize>> = alone.chain(in_turn).collect();
    let twice = once.iter().map(|gait| gait.repeat(2));
    once.iter().cloned().chain(twice).collect()
}

/// Adds a word that is not there yet; whether it was added.
fn add(
    found: &mut Vec<Beginning>,
    (draft, motion): (Draft, Trajectory),
    source: &'static str,
) -> bool {
    let known = found.iter().any(|other| other.draft.word == draft.word);
    if !known {
        found.push(Beginning {
            draft,
            motion,
            source,
        });
    }
    !known
}

/// The word of a candidate.
fn read(setting: Setting, candidate: Candidate) -> (Draft, Trajectory) {
    let trajectory = candidate.trajectory;
    let length = trajectory.horizon / setting.problem.intervals as f64;
    let draft = Draft::read(&candidate.sequence, length, trajectory.horizon);
    (draft, trajectory)
}

/// A word as a motion under random controls goes through it, or else with random times, and a motion under random controls or one that is
/// bent out of shape; none where it cannot be simulated.
pub(super) fn another(
    setting: Setting,
    draft: &Draft,
    (seed, tolerance): (u64, f64),
) -> Option<(Draft, Trajectory)> {
    let Setting {
        model,
        problem,
        bounds,
        ..
    } = setting;
    // Random starts are those of simulated motions alone.
    let kind = match seed.is_multiple_of(2) && !has_free_start(model) {
        true => Guess::Perturbed(seed),
        false => Guess::Random(seed),
    };
    let motion = guess(model, problem, &kind, bounds).ok()?;
    if matches!(kind, Guess::Random(_)) {
        let first = u64::MAX - TRIES * seed;
        let mut drawn = (0..TRIES).filter_map(|k| {
            let kind = Guess::Random(first - k);
            let motion = guess(model, problem, &kind, bounds).ok()?;
            let candidates = simulations(setting, &motion, tolerance).ok()?;
            let (own, motion) = read(setting, candidates.into_iter().next()?);
            let own = own.up_to(draft.word.instants.len());
            (own.word == draft.word).then_some((own, motion))
        });
        if let Some(same) = drawn.next() {
            return Some(same);
        }
    }
    let mut random = uniform(!seed);
    let mut draft = draft.clone();
    draft.horizon = motion.horizon;
    let ends = draft.word.ends_with_impact;
    let times = draft.times.iter_mut();
    times.for_each(|time| *time = 0.5 * (random() + 1.0) * motion.horizon);
    draft.times.sort_by(f64::total_cmp);
    if let Some(last) = draft.times.last_mut().filter(|_| ends) {
        *last = motion.horizon;
    }
    Some((draft, motion))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_feet_step_alone_in_turn_and_twice() {
        let once = [vec![3], vec![5], vec![3, 5], vec![5, 3]];
        let twice = [vec![3, 3], vec![5, 5], vec![3, 5, 3, 5], vec![5, 3, 5, 3]];
        assert_eq!(gaits(&[3, 5]), [once, twice].concat());
    }
}
