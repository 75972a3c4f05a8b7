//! What a run writes down.

use super::super::audit::Checks;
use super::super::dynamics::Dynamics;
use super::super::search::EventSearch;
use crate::simulation::event_log::EventLog;
use crate::simulation::explicit_time::ExplicitTime;
use crate::simulation::{Event, EventKind, Simulation, SimulationStatus, accumulation};

/// The motion of a run with its events, and how many of these there were, listed or not.
pub(super) struct Journal {
    log: EventLog,
    pub(super) result: Simulation,
}

impl Journal {
    /// Nothing so far, to be written into an empty result.
    pub(super) fn of(result: Simulation) -> Self {
        Self {
            log: EventLog::default(),
            result,
        }
    }

    /// Events so far, listed or not.
    pub(super) fn events(&self) -> usize {
        self.log.count(self.result.events.len())
    }

    /// Lists what happened to contacts at an instant, `(t, y)` with `y = (q, v, ..)`, before which there were these velocities; a status
    /// where events accumulate within the length of the motion \[s\].
    pub(super) fn list(
        &mut self,
        dynamics: &Dynamics<'_>,
        happened: Vec<(EventKind, usize)>,
        ((t, y), before): ((f64, &[f64]), &[f64]),
        horizon: f64,
    ) -> Result<(), SimulationStatus> {
        let n = dynamics.n;
        let event = |(kind, contact): (EventKind, usize)| {
            let declared = &dynamics.model.declaration().contacts[contact];
            Event {
                time: t,
                kind: kind.of(declared),
                contact,
                contact_name: declared.name,
                modes: dynamics.contact_modes(),
                q: y[..n].to_vec(),
                v_before: before.to_vec(),
                v_after: y[n..2 * n].to_vec(),
                contact_impulse: Vec::new(),
                friction_impulse: Vec::new(),
            }
        };
        self.result.events.extend(happened.into_iter().map(event));
        if let Some(status) = accumulation::of(&self.result.events, horizon) {
            return Err(status);
        }
        self.log.tidy(&mut self.result.events);
        Ok(())
    }

    /// The result of a run that has ended, for that reason if it was not to the end.
    pub(super) fn closed(
        self,
        (dynamics, search, checks): (&Dynamics<'_>, &EventSearch<'_>, Checks<'_>),
        ended: Option<SimulationStatus>,
    ) -> Simulation {
        let events = self.events();
        let mut result = self.result;
        result.residuals = checks.verdict.residuals;
        result.notes = checks.remarks.notes(dynamics.model.declaration());
        result.doubts = checks.remarks.doubts();
        let interpolated = search.interpolated.iter();
        let interpolated = interpolated.map(|function| function.name(dynamics.model));
        result.interpolated = Some(interpolated.collect());
        let explicit_time = checks.explicit_time.as_ref();
        result
            .notes
            .extend(explicit_time.and_then(ExplicitTime::note));
        result.counts.evaluations = dynamics.evaluations;
        result.counts.events = events;
        if let Some(status) = ended.or_else(|| checks.verdict.status(dynamics.model)) {
            result.status = status;
        }
        result
    }
}
