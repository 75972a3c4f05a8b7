//! A step as the complementarity problem itself: the time-freezing system transcribed by FESD and solved by
//! the interior point method. The last resort where Newton's method in a fixed mode fails.

use super::driver::{Driver, Stop};
use crate::dcs::HeavisideSystem;
use crate::fesd::finite_element::State;
use crate::fesd::transcription::Transcription;
use crate::mpcc;
use crate::simulation::EventKind;
use crate::time_freezing::TimeFreezingSystem;

/// Finite elements that one switch with an impact needs: before, jump, after.
const ELEMENTS: usize = 3;
/// Residual up to which a solution of the program is a step.
const ACCEPTED: f64 = 1e-7;
/// Distance of a mean step function from 0 or 1 that counts as sustained contact.
const BETWEEN: f64 = 1e-4;

/// What a contact does during an element of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Free,
    Jump,
    Contact,
}

impl Phase {
    fn of(mean_alpha: f64) -> Self {
        if mean_alpha >= 1.0 - BETWEEN {
            Self::Free
        } else if mean_alpha <= BETWEEN {
            Self::Jump
        } else {
            Self::Contact
        }
    }
}

impl Driver<'_> {
    /// Advances to `end` by one complementarity problem.
    pub(super) fn solve_program(&mut self, end: f64) -> Result<(), Stop> {
        let system = TimeFreezingSystem::new(self.model, self.settings.auxiliary_acceleration);
        let mut program = Transcription::new(
            HeavisideSystem::new(system),
            self.tableau,
            &self.state,
            &self.u,
            end - self.state.time,
            self.settings.elements.max(ELEMENTS),
        );
        let solution = mpcc::solve(&mut program, &mpcc::Settings::default())
            .map_err(|_| Stop::Program("the step problem was refused"))?;
        self.counts.interior_point += solution.iterations - solution.crossover_iterations;
        self.counts.crossover += solution.crossover_iterations;
        self.counts.fallbacks += 1;
        let residuals = solution.residuals;
        // The step is a root of its equations: feasibility decides, optimality only chooses lengths.
        if residuals.primal.max(residuals.complementarity) > ACCEPTED {
            return Err(Stop::Program(
                "neither Newton's method nor the interior point method solved the step",
            ));
        }
        self.residuals.primal = self.residuals.primal.max(residuals.primal);
        self.residuals.complementarity = self
            .residuals
            .complementarity
            .max(residuals.complementarity);
        self.follow(&program, &solution.x)?;
        self.note("steps solved as complementarity problems are accurate to about 1e-7 only");
        Ok(())
    }

    /// Records elements and events of a solved program and settles at its end.
    fn follow(&mut self, program: &Transcription<'_>, x: &[f64]) -> Result<(), Stop> {
        let mut before = self.state.clone();
        let mut phases: Vec<Phase> = self
            .all_contacts
            .iter()
            .map(|i| {
                if self.active.contains(i) {
                    Phase::Contact
                } else {
                    Phase::Free
                }
            })
            .collect();
        let mut jump_start: Option<State> = None;
        for e in 0..program.elements() {
            let after = program.state(x, e);
            self.state.copy_from(&after);
            self.numerical_time += program.numerical_length(x, e);
            for i in self.all_contacts.clone() {
                let phase = Phase::of(program.mean_alpha(x, e, i));
                match (phases[i], phase) {
                    (Phase::Free | Phase::Contact, Phase::Jump) => {
                        jump_start.get_or_insert_with(|| before.clone());
                    }
                    (Phase::Contact, Phase::Free) => {
                        self.push_event(EventKind::LiftOff, i, before.v.clone());
                    }
                    (Phase::Free, Phase::Contact) => {
                        self.push_event(EventKind::Contact, i, before.v.clone());
                    }
                    _ => {}
                }
                if phases[i] == Phase::Jump && phase != Phase::Jump {
                    self.finish_jump(i, &mut jump_start, &before);
                }
                phases[i] = phase;
            }
            self.active = (0..phases.len())
                .filter(|&i| phases[i] == Phase::Contact)
                .collect();
            self.evaluate_state()?;
            self.record();
            before.copy_from(&after);
        }
        for (i, &phase) in phases.iter().enumerate() {
            if phase == Phase::Jump {
                self.finish_jump(i, &mut jump_start, &before);
            }
        }
        let close: Vec<usize> = (0..phases.len())
            .filter(|&i| phases[i] != Phase::Free)
            .collect();
        self.project(&close)?;
        self.settle(&close)?;
        Ok(())
    }

    /// The event of a jump that ended at `after`.
    fn finish_jump(&mut self, contact: usize, start: &mut Option<State>, after: &State) {
        let Some(begin) = start.take() else {
            return;
        };
        let present = std::mem::replace(&mut self.state, after.clone());
        self.push_event(EventKind::Impact, contact, begin.v);
        self.state = present;
    }
}
