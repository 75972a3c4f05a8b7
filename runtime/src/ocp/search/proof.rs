//! What is proved of a plan: its neighbours are followed where they are better, and decided where they are not.

use hangtime_solver::mpcc::Stationarity;

use super::adjoining::neighbours;
use super::attempt::{Attempt, Attempts, Local, Purpose, Verdict};
use super::basins::{basins, warped};
use super::neighbour::Neighbour;
use super::pressing::Pressing;
use super::released::{Held, Insertion, held, learn_together};
use crate::ocp::collocation::layout::Cut;
use crate::ocp::motion::sequence::Sequence;
use crate::ocp::motion::trajectory::Trajectory;
use crate::ocp::program::runner::Runner;
use crate::ocp::tuning::neighbours::INSERTED;

/// Follows improving neighbours of the best, and sequences in other basins, until there is none, and says what was proved about the one it
/// ends at.
pub(in crate::ocp) fn certificate(runner: &mut Runner, attempts: &mut Attempts) -> Stationarity {
    let mut explored = false;
    loop {
        let Some(best) = &attempts.best else {
            return Stationarity::None;
        };
        let around = Around::of(best, attempts, runner);
        // Of several on the way to a better basin the last one is worth a proof.
        explored = explored && around.explore(runner, attempts);
        if explored {
            runner.counts.repairs += 1;
            continue;
        }
        let compared = around.compare(runner, attempts);
        if compared == Compared::Incomplete {
            return Stationarity::None;
        }
        explored = compared != Compared::Improved && around.explore(runner, attempts);
        if compared != Compared::Improved && !explored {
            return match compared {
                Compared::Undecided => Stationarity::None,
                _ if !around.neighbours.iter().any(|near| near.adjoins) => Stationarity::S,
                _ => Stationarity::B,
            };
        }
        runner.counts.repairs += 1;
    }
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
        let proves = runner.effort.proves();
        let [plan, nearer] =
            INSERTED.map(|inserted| Pressing::new(best, attempts, runner.settings, inserted));
        Self {
            neighbours: neighbours(&plan),
            nearer: if proves {
                neighbours(&nearer)
            } else {
                Vec::new()
            },
            explored: basins(&plan, runner.settings, proves),
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

    /// Asks for the neighbours, one after the other, up to one that is better.
    fn compare(&self, runner: &mut Runner, attempts: &mut Attempts) -> Compared {
        let mut undecided = false;
        let mut asked = false;
        for Neighbour { sequence, adjoins } in &self.neighbours {
            // Of one that does not adjoin nothing is claimed.
            let purpose = if runner.effort.proves() && *adjoins {
                Purpose::Compare
            } else {
                Purpose::Explore
            };
            let asks = !asked && *adjoins && Insertion::of(sequence, &self.sequence).is_some();
            if asks && attempts.known(sequence).is_none() {
                asked = true;
                self.decide_together(runner, attempts);
            }
            let verdict = match attempts.known(sequence) {
                Some(verdict) => verdict,
                None if runner.is_exhausted() && *adjoins => return Compared::Incomplete,
                None if runner.is_exhausted() => continue,
                None if purpose == Purpose::Explore && attempts.was_tried(sequence) => {
                    Verdict::Undecided
                }
                None if purpose == Purpose::Explore => {
                    attempts.attempt(runner, self.attempt(sequence, purpose))
                }
                None => self.decide(runner, attempts, sequence),
            };
            undecided |= match verdict {
                Verdict::Better => return Compared::Improved,
                // One try from one barrier parameter is no proof that a sequence allows no motion.
                Verdict::NotBetter(least) => {
                    *adjoins && least.is_infinite() && purpose == Purpose::Explore
                }
                Verdict::Undecided => *adjoins,
            };
        }
        match undecided {
            true => Compared::Undecided,
            false => Compared::Best,
        }
    }

    /// Decides of the neighbours with further phases what one program tells of many.
    fn decide_together(&self, runner: &mut Runner, attempts: &mut Attempts) {
        let neighbours = self.neighbours.iter().filter(|near| near.adjoins);
        let unknown = neighbours.filter(|near| attempts.known(&near.sequence).is_none());
        let insertions = unknown.filter_map(|near| Insertion::of(&near.sequence, &self.sequence));
        let insertions: Vec<Insertion> = insertions.collect();
        let best = self.attempt(&self.sequence, Purpose::Compare);
        learn_together(attempts, runner, insertions, best);
    }

    /// Decides a neighbour that adjoins: by the multipliers of its new phases where these tell, or else by an attempt, and where that comes to
    /// nothing once more from nearer.
    fn decide(&self, runner: &mut Runner, attempts: &mut Attempts, sequence: &Sequence) -> Verdict {
        let attempt = self.attempt(sequence, Purpose::Compare);
        let (start, apart) = match held(attempts, runner, attempt) {
            Held::Stationary(objective) => {
                let verdict = Verdict::NotBetter(objective);
                attempts.learn(sequence, verdict);
                return verdict;
            }
            Held::Better(start) => (Some(*start), None),
            Held::Apart(objective) => (None, Some(objective)),
            Held::Open => (None, None),
        };
        let mut verdict = attempts.attempt_from(runner, attempt, start);
        let signature = sequence.signature();
        let mut nearer = self.nearer.iter().map(|nearer| &nearer.sequence);
        if let Some(nearer) = nearer.find(|nearer| nearer.signature() == signature)
            && nearer != sequence
            && verdict == Verdict::Undecided
        {
            verdict = attempts.attempt(runner, self.attempt(nearer, Purpose::Compare));
        }
        if let Some(objective) = apart
            && verdict == Verdict::Undecided
        {
            verdict = Verdict::NotBetter(objective);
            attempts.learn(sequence, verdict);
        }
        verdict
    }

    /// Whether one of the sequences in other basins is better.
    fn explore(&self, runner: &mut Runner, attempts: &mut Attempts) -> bool {
        for sequence in &self.explored {
            if runner.is_exhausted() {
                break;
            }
            if !attempts.was_tried(sequence) {
                let intervals = attempts.setting.problem.intervals;
                let guess = &warped(&self.guess, (&self.sequence, sequence), intervals);
                let attempt = Attempt {
                    guess,
                    ..self.attempt(sequence, Purpose::Explore)
                };
                if attempts.attempt(runner, attempt) == Verdict::Better {
                    return true;
                }
            }
        }
        false
    }
}
