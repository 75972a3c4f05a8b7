//! How a run ended: by itself, or because it was asked to.

use hangtime::estimation::{self, Estimate};
use hangtime::nl;
use hangtime::ocp::{Solution, Status};
use hangtime::simulation::{Simulation, SimulationStatus};

use crate::arguments::LimitArguments;
use crate::failure::one_line;

/// Why a run was asked to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Stop {
    /// Ctrl-C.
    Interrupt = 1,
    /// The limit on wall-clock time.
    Time,
    /// The limit on memory.
    Memory,
    /// The limit of the system on CPU time.
    SystemTime,
    /// The system asked to terminate (SIGTERM).
    Terminate,
}

impl Stop {
    /// Name of the status.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Interrupt | Self::Terminate => "interrupted",
            Self::Time | Self::SystemTime => "time_limit",
            Self::Memory => "memory_limit",
        }
    }

    /// The line about the run `name` on the standard error stream.
    pub(crate) fn line(self, name: &str, limits: &LimitArguments) -> String {
        one_line(&format!(
            "{name}: {}: {}",
            self.name(),
            self.diagnosis(limits)
        ))
    }

    /// What happened and how to mend it.
    pub(crate) fn diagnosis(self, limits: &LimitArguments) -> String {
        match self {
            Self::Interrupt => "stopped by Ctrl-C".to_owned(),
            Self::Terminate => "stopped by a signal to terminate (SIGTERM)".to_owned(),
            Self::Time => format!(
                "ended after {} s; raise --time-limit, or ask for less",
                limits.time_limit.unwrap_or_default()
            ),
            Self::Memory => format!(
                "ended at the limit on memory; raise --memory-limit ({} GB), or ask for less",
                limits.memory_limit
            ),
            Self::SystemTime => {
                "ended near the system's limit on CPU time; raise it (ulimit -t), or ask for less"
                    .to_owned()
            }
        }
    }

    /// The reason with this number, if there is one.
    pub(crate) fn of(number: u8) -> Option<Self> {
        let all = [
            Self::Interrupt,
            Self::Time,
            Self::Memory,
            Self::SystemTime,
            Self::Terminate,
        ];
        all.into_iter().find(|stop| *stop as u8 == number)
    }
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Ending {
    /// Name of the status.
    pub(crate) status: &'static str,
    /// Why it did not end with a solution, in one line.
    pub(crate) diagnosis: Option<String>,
}

impl Ending {
    /// Of what ended by itself.
    fn new(status: &'static str, diagnosis: Option<String>) -> Self {
        Self { status, diagnosis }
    }

    /// This ending, or what `stop` says, if that asked the run to end.
    fn or(self, stop: Option<Stop>, limits: &LimitArguments) -> Self {
        match stop {
            Some(stop) => Self::new(stop.name(), Some(stop.diagnosis(limits))),
            None => self,
        }
    }

    /// Of a solve that ended by itself.
    pub(crate) fn of(solution: &Solution) -> Self {
        Self::new(solution.status.name(), solution.diagnosis())
    }

    /// Of a solve that `stop` asked to end, if anything did.
    pub(crate) fn of_bounded(
        solution: &Solution,
        stop: Option<Stop>,
        limits: &LimitArguments,
    ) -> Self {
        let own = Self::of(solution);
        let found = own.diagnosis.clone();
        let stop = stop.filter(|stop| *stop != Stop::Interrupt);
        let mut ended = own.or(
            stop.filter(|_| solution.status == Status::Interrupted),
            limits,
        );
        if let (Some(said), Some(found)) = (&mut ended.diagnosis, found)
            && *said != found
        {
            *said += &format!("; {found}");
        }
        ended
    }

    /// Of an estimation that `stop` asked to end, if anything did.
    pub(crate) fn of_estimate(
        estimate: &Estimate,
        stop: Option<Stop>,
        limits: &LimitArguments,
    ) -> Self {
        let interrupted = estimate.status == estimation::Status::Interrupted;
        let own = Self::new(estimate.status.name(), estimate.diagnosis.clone());
        own.or(stop.filter(|_| interrupted), limits)
    }

    /// Of a simulation that `stop` asked to end, if anything did.
    pub(crate) fn of_simulation(
        simulation: &Simulation,
        stop: Option<Stop>,
        limits: &LimitArguments,
    ) -> Self {
        let interrupted = matches!(simulation.status, SimulationStatus::Interrupted(_));
        Self::of_whole(simulation).or(stop.filter(|_| interrupted), limits)
    }

    /// Of a simulation that ended by itself.
    pub(crate) fn of_whole(simulation: &Simulation) -> Self {
        let status = &simulation.status;
        let said = status.diagnosis().map(|known| known.message.clone());
        Self::new(status.name(), said)
    }

    /// Of a program from a file that `stop` asked to end, if anything did.
    pub(crate) fn of_program(
        solution: &nl::Solution,
        stop: Option<Stop>,
        limits: &LimitArguments,
    ) -> Self {
        let interrupted = solution.status == nl::Status::Interrupted;
        let own = Self::new(solution.status.name(), solution.diagnosis());
        own.or(stop.filter(|_| interrupted), limits)
    }

    /// The line about the simulation `name`, with the time that it reached, if it did not end with a solution.
    pub(crate) fn line_of(&self, name: &str, simulation: &Simulation) -> Option<String> {
        let time = simulation.status.diagnosis()?.time;
        let said = self.diagnosis.as_deref().unwrap_or_default();
        let status = self.status;
        Some(one_line(&format!(
            "{name}: {status} at t = {time} s: {said}"
        )))
    }

    /// The line about the run `name` on the standard error stream, if it did not end with a solution.
    pub(crate) fn line(&self, name: &str) -> Option<String> {
        let diagnosis = self.diagnosis.as_ref()?;
        Some(one_line(&format!("{name}: {}: {diagnosis}", self.status)))
    }
}

#[cfg(test)]
mod tests {
    use super::Stop;

    #[test]
    fn reasons_to_end_come_back_from_their_numbers() {
        for stop in [
            Stop::Interrupt,
            Stop::Time,
            Stop::Memory,
            Stop::SystemTime,
            Stop::Terminate,
        ] {
            assert_eq!(Stop::of(stop as u8), Some(stop));
        }
        assert_eq!(Stop::of(0), None);
    }
}
