//! Words to begin with: of simulated motions under random controls, of what they begin with, of the ride without controls, of steps, of a
//! contact-implicit program, and the one without switches.

use super::library::Library;
use super::off_grid::Goals;
use super::word::Draft;
use crate::ocp::collocation::discretization::Setting;
use crate::ocp::global::coarse_to_fine::{CoarseToFine, RelaxedMotions};
use crate::ocp::global::guess::guess;
use crate::ocp::global::start_modes::modes_at_start;
use crate::ocp::motion::candidate::Candidate;
use crate::ocp::motion::sequence::Sequence;
use crate::ocp::motion::targets::goal_values;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::Runner;
use crate::ocp::search::replay::simulations;
use crate::ocp::search::sampled::{Range, best_of_each_order};
use crate::ocp::search::stepping::stepping;
use crate::ocp::settings::Guess;
use crate::ocp::tuning::beginnings::{
    CHANGED, DRAWN, LEARNED, MOST_PHASES, OF_EACH_LENGTH, PHASES, STEPS, WORDS,
};
use crate::simulation::InputError;

/// The source whose words come from a contact-implicit program.
const IMPLICIT: &str = "contact-implicit";

/// A word to begin with, and the motion that it is of.
pub(in crate::ocp) struct Beginning {
    pub(super) draft: Draft,
    pub(super) motion: Trajectory,
    pub(super) source: &'static str,
}

/// Words to begin with and the library of what their motions went through; random controls are drawn from a range.
pub(in crate::ocp) fn beginnings(
    runner: &mut Runner,
    setting: Setting,
    range: &Range,
) -> Result<(Vec<Beginning>, (Library, Goals)), InputError> {
    let mut library = Library::default();
    let mut found: Vec<Beginning> = Vec::new();
    let sampled = best_of_each_order(runner, (setting, range), (DRAWN, CHANGED), LEARNED)?;
    let mut drafts: Vec<(Draft, Trajectory)> = Vec::new();
    for candidate in sampled.motions {
        let (draft, motion) = read(setting, candidate);
        library.learn(&draft.word);
        if draft.word.phases() <= MOST_PHASES {
            drafts.push((draft, motion));
        }
    }
    for (draft, motion) in drafts.iter().take(WORDS) {
        add(&mut found, (draft.clone(), motion.clone()), "sample");
    }
    for phases in 1..=PHASES {
        add_beginnings(&mut found, &drafts, phases);
    }
    let Setting {
        model,
        problem,
        bounds,
        ..
    } = setting;
    let straight = guess(model, problem, &Guess::Straight, bounds)?;
    let tolerance = runner.settings.replay_tolerance;
    for candidate in simulations(setting, &straight, tolerance).unwrap_or_default() {
        let (draft, motion) = read(setting, candidate);
        library.learn(&draft.word);
        if draft.word.phases() <= MOST_PHASES {
            add(&mut found, (draft, motion), "ride");
        }
    }
    let empty = Sequence::without_switches(modes_at_start(setting, &straight));
    let length = straight.horizon / problem.intervals as f64;
    let draft = Draft::read(&empty, length, straight.horizon);
    add(&mut found, (draft, straight.clone()), "empty");
    for sequence in steps(setting, &straight) {
        let draft = Draft::read(&sequence, length, straight.horizon);
        add(&mut found, (draft, straight.clone()), "steps");
    }
    found.retain(|beginning| runner.settings.uses(beginning.source));
    if runner.settings.uses(IMPLICIT)
        && let Some((draft, motion)) = implicit(runner, setting, &straight)?
    {
        library.learn(&draft.word);
        if draft.word.phases() <= MOST_PHASES {
            add(&mut found, (draft, motion), IMPLICIT);
        }
    }
    let goals = Goals {
        sizes: sizes(setting, &sampled.units),
        price: Some(sampled.cost)
            .filter(|cost| *cost > 0.0)
            .map(Goals::price_of),
    };
    Ok((found, (library, goals)))
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

/// The word of the first motion of contact-implicit programs around a guess.
fn implicit(
    runner: &mut Runner,
    setting: Setting,
    guess: &Trajectory,
) -> Result<Option<(Draft, Trajectory)>, InputError> {
    let mut relaxed = RelaxedMotions::default();
    let failure = runner.take_failure();
    let candidate = CoarseToFine::new(setting, guess).next(runner, &mut relaxed)?;
    runner.restore_failure(failure, true);
    Ok(candidate.map(|candidate| read(setting, candidate)))
}

/// Steps of feet that stand at first, as random controls never take them: of each, of two in turn, once and twice.
fn steps(setting: Setting, straight: &Trajectory) -> Vec<Sequence> {
    let modes = modes_at_start(setting, straight).into_iter().enumerate();
    let declared = setting.model.declaration().contacts;
    let standing = modes.filter(|(contact, mode)| !mode.is_open() && !declared[*contact].dry);
    if standing.count() < 2 {
        return Vec::new();
    }
    let mut steps = stepping(setting, straight);
    steps.truncate(STEPS);
    steps
}

/// Sizes of the goals: what most random motions miss less, or else the start does.
fn sizes(setting: Setting, units: &[f64]) -> Vec<f64> {
    let mut z = setting.problem.start();
    z.push(setting.units.time);
    let values = goal_values(setting.model, &z).into_iter().enumerate();
    let sizes = values.map(|(goal, value)| {
        let drawn = units.get(goal).copied().unwrap_or(0.0);
        let all = [drawn, value.abs(), 1.0];
        all.into_iter()
            .find(|size| *size > 0.0 && size.is_finite())
            .unwrap_or(1.0)
    });
    sizes.collect()
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
