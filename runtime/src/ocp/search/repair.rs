//! Following improving neighbours of a contact sequence.

use hangtime_solver::mpcc::Stationarity;

use super::at_nodes::{all_at_once, at_nodes, warped};
use super::attempt::{Attempt, Attempts, Local, Purpose, Verdict};
use super::neighbours::Neighbour;
use super::pressure::Pressure;
use super::resting::resting;
use super::stationary::{Held, held};
use super::together::{Insertion, learn_together};
use super::{edge_neighbours, friction_neighbours, neighbours};
use crate::ocp::collocation::layout::Cut;
use crate::ocp::collocation::limits::touching_gap;
use crate::ocp::effort::Effort;
use crate::ocp::motion::sequence::{Sequence, Signature};
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::Runner;
use crate::ocp::settings::Settings;
use crate::ocp::tuning::neighbours::{DISTANT, INSERTED, NOTHING};
use crate::simulation::InputError;

/// Follows improving neighbours of the best, and sequences in other basins, until there is none, and says what was proved about the one it
/// ends at.
pub(in crate::ocp) fn certificate(
    runner: &mut Runner,
    attempts: &mut Attempts,
) -> Result<Stationarity, InputError> {
    let mut explored = false;
    loop {
        let Some(best) = &attempts.best else {
            return Ok(Stationarity::None);
        };
        let around = Around::of(best, attempts, runner);
        // Of several on the way to a better basin the last one is worth a proof.
        explored = explored && explore(runner, attempts, &around)?;
        if explored {
            runner.counts.repairs += 1;
            continue;
        }
        let compared = compare(runner, attempts, &around)?;
        if compared == Compared::Incomplete {
            return Ok(Stationarity::None);
        }
        explored = compared != Compared::Improved && explore(runner, attempts, &around)?;
        if compared != Compared::Improved && !explored {
            return Ok(match compared {
                Compared::Undecided => Stationarity::None,
                _ if !around.neighbours.iter().any(|near| near.adjoins) => Stationarity::S,
                _ => Stationarity::B,
            });
        }
        runner.counts.repairs += 1;
    }
}

/// The sequences around the best, and its motion to start them from.
struct Around {
    neighbours: Vec<Neighbour>,
    /// Those with shorter contacts and flights where some are inserted; of a proof only.
    nearer: Vec<Neighbour>,
    /// No neighbours, but often in another basin: nothing is claimed about them.
    explored: Vec<Sequence>,
    /// That of the best.
    sequence: Sequence,
    guess: Trajectory,
    cuts: Vec<Cut>,
}

impl Around {
    fn of(best: &Local, attempts: &Attempts, runner: &Runner) -> Self {
        let multipliers = best.solution.multipliers.iter();
        let largest = multipliers.fold(f64::MIN_POSITIVE, |largest, y| largest.max(y.abs()));
        let pressure = Pressure {
            program: &best.program,
            solution: &best.solution,
            slacks: &best.slacks,
            largest: if largest > NOTHING * runner.settings.tolerance {
                largest
            } else {
                f64::INFINITY
            },
            // Where motions are looked for, sequences that nothing presses for are worth a try.
            distant: if attempts.setting.units.is_exact() {
                DISTANT
            } else {
                0.0
            },
            sequence: &best.sequence,
            intervals: attempts.setting.problem.intervals,
            inserted: INSERTED[0],
            touching: touching_gap(runner.settings),
            units: attempts.setting.units,
        };
        let nearer = match runner.effort {
            Effort::Conclude => neighbours_of(&Pressure {
                inserted: INSERTED[1],
                ..pressure
            }),
            Effort::Quick => Vec::new(),
        };
        let explored = basins(&pressure, runner.settings, runner.effort.proves());
        Self {
            neighbours: neighbours_of(&pressure),
            nearer,
            explored,
            sequence: best.sequence.clone(),
            guess: best.trajectory.clone(),
            cuts: best.cuts.clone(),
        }
    }

    fn attempt<'t>(&'t self, sequence: &'t Sequence, purpose: Purpose) -> Attempt<'t> {
        Attempt {
            sequence,
            guess: &self.guess,
            cuts: &self.cuts,
            purpose,
        }
    }
}

/// A rule that makes sequences in other basins.
type Basins = fn(&Pressure) -> Vec<Sequence>;

/// Sequences in other basins, by the rules of the search that are followed; those of the whole motion where it may be the result.
fn basins(pressure: &Pressure, settings: &Settings, proves: bool) -> Vec<Sequence> {
    let rules: [(&str, Basins); 4] = [
        ("shortened", neighbours::shortened),
        ("sliding-moved", friction_neighbours::shifted),
        ("at-nodes", at_nodes),
        ("all-at-once", all_at_once),
    ];
    let of_whole = |name: &str| matches!(name, "at-nodes" | "all-at-once");
    let rules = rules.into_iter();
    let followed = rules.filter(|(name, _)| settings.uses(name) && (proves || !of_whole(name)));
    distinct(followed.flat_map(|(_, rule)| rule(pressure)))
}

/// The sequences, each once.
fn distinct(sequences: impl Iterator<Item = Sequence>) -> Vec<Sequence> {
    let mut known: Vec<Signature> = Vec::new();
    let mut found: Vec<Sequence> = sequences.collect();
    found.retain(|sequence| {
        let signature = sequence.signature();
        let is_new = !known.contains(&signature);
        known.push(signature);
        is_new
    });
    found
}

fn neighbours_of(pressure: &Pressure) -> Vec<Neighbour> {
    let mut neighbours = neighbours::directed(pressure);
    let inserted = neighbours::insertions(pressure).into_iter();
    neighbours.extend(inserted.map(Neighbour::adjoining));
    neighbours.extend(friction_neighbours::sliding(pressure));
    neighbours.extend(resting(pressure));
    neighbours.extend(edge_neighbours::edges(pressure));
    neighbours
}

/// What the comparison with the neighbours came to.
#[derive(PartialEq)]
enum Compared {
    /// One is better.
    Improved,
    /// None is better.
    Best,
    /// None is known to be better, but programs failed.
    Undecided,
    /// The search was stopped, or ran out of programs.
    Incomplete,
}

fn compare(
    runner: &mut Runner,
    attempts: &mut Attempts,
    around: &Around,
) -> Result<Compared, InputError> {
    let mut undecided = false;
    let mut asked = false;
    for neighbour in &around.neighbours {
        let Neighbour { sequence, adjoins } = neighbour;
        // Of one that does not adjoin nothing is claimed.
        let purpose = if runner.effort.proves() && *adjoins {
            Purpose::Compare
        } else {
            Purpose::Explore
        };
        let asks = !asked && *adjoins && Insertion::of(sequence, &around.sequence).is_some();
        if asks && attempts.known(sequence).is_none() {
            asked = true;
            decide_together(runner, attempts, around)?;
        }
        let verdict = match attempts.known(sequence) {
            Some(verdict) => verdict,
            None if runner.is_exhausted() && *adjoins => return Ok(Compared::Incomplete),
            None if runner.is_exhausted() => continue,
            None if purpose == Purpose::Explore && attempts.was_tried(sequence) => {
                Verdict::Undecided
            }
            None => decide(runner, attempts, around, neighbour, purpose)?,
        };
        undecided |= match verdict {
            Verdict::Better => return Ok(Compared::Improved),
            // One try from one barrier parameter is no proof that a sequence allows no motion.
            Verdict::NotBetter(least) => {
                *adjoins && least.is_infinite() && purpose == Purpose::Explore
            }
            Verdict::Undecided => *adjoins,
        };
    }
    Ok(if undecided {
        Compared::Undecided
    } else {
        Compared::Best
    })
}

/// Decides of the neighbours with further phases what one program tells of many.
fn decide_together(
    runner: &mut Runner,
    attempts: &mut Attempts,
    around: &Around,
) -> Result<(), InputError> {
    let neighbours = around.neighbours.iter().filter(|near| near.adjoins);
    let insertions: Vec<Insertion> = neighbours
        .filter(|near| attempts.known(&near.sequence).is_none())
        .filter_map(|near| Insertion::of(&near.sequence, &around.sequence))
        .collect();
    let best = around.attempt(&around.sequence, Purpose::Compare);
    learn_together(attempts, runner, insertions, best)
}

/// Decides a neighbour: one that adjoins by the multipliers of its new phases where these tell, or else by an attempt, and
/// where that comes to nothing once more from nearer.
fn decide(
    runner: &mut Runner,
    attempts: &mut Attempts,
    around: &Around,
    neighbour: &Neighbour,
    purpose: Purpose,
) -> Result<Verdict, InputError> {
    let sequence = &neighbour.sequence;
    let attempt = around.attempt(sequence, purpose);
    if purpose == Purpose::Explore {
        return attempts.attempt(runner, attempt);
    }
    let held = held(attempts, runner, attempt)?;
    let (start, apart) = match held {
        Held::Stationary(objective) => {
            let verdict = Verdict::NotBetter(objective);
            attempts.learn(sequence, verdict);
            return Ok(verdict);
        }
        Held::Better(start) => (Some(*start), None),
        Held::Apart(objective) => (None, Some(objective)),
        Held::Open => (None, None),
    };
    let mut verdict = attempts.attempt_from(runner, attempt, start)?;
    let signature = sequence.signature();
    let mut nearer = around.nearer.iter().map(|nearer| &nearer.sequence);
    if let Some(nearer) = nearer.find(|nearer| nearer.signature() == signature)
        && nearer != sequence
        && verdict == Verdict::Undecided
    {
        verdict = attempts.attempt(runner, around.attempt(nearer, purpose))?;
    }
    if let Some(objective) = apart
        && verdict == Verdict::Undecided
    {
        verdict = Verdict::NotBetter(objective);
        attempts.learn(sequence, verdict);
    }
    Ok(verdict)
}

/// Whether one of the explored sequences is better.
fn explore(
    runner: &mut Runner,
    attempts: &mut Attempts,
    around: &Around,
) -> Result<bool, InputError> {
    for sequence in &around.explored {
        if runner.is_exhausted() {
            break;
        }
        if !attempts.was_tried(sequence) {
            let intervals = attempts.setting.problem.intervals;
            let guess = &warped(&around.guess, (&around.sequence, sequence), intervals);
            let attempt = Attempt {
                guess,
                ..around.attempt(sequence, Purpose::Explore)
            };
            if attempts.attempt(runner, attempt)? == Verdict::Better {
                return Ok(true);
            }
        }
    }
    Ok(false)
}
