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
    /// Of a solve that ended by itself.
    pub(crate) fn of(solution: &Solution) -> Self {
        Self {
            status: solution.status.name(),
            diagnosis: solution.diagnosis(),
        }
    }

    /// Of a solve that `stop` asked to end, if anything did.
    pub(crate) fn of_bounded(
        solution: &Solution,
        stop: Option<Stop>,
        limits: &LimitArguments,
    ) -> Self {
        let own = Self::of(solution);
        match stop.filter(|_| solution.status == Status::Interrupted) {
            Some(stop) if stop != Stop::Interrupt => Self {
                status: stop.name(),
                diagnosis: Some(match own.diagnosis {
                    Some(own) => format!("{}; {own}", stop.diagnosis(limits)),
                    None => stop.diagnosis(limits),
                }),
            },
            _ => own,
        }
    }

    /// Of an estimation that `stop` asked to end, if anything did.
    pub(crate) fn of_estimate(
        estimate: &Estimate,
        stop: Option<Stop>,
        limits: &LimitArguments,
    ) -> Self {
        match stop.filter(|_| estimate.status == estimation::Status::Interrupted) {
            Some(stop) => Self {
                status: stop.name(),
                diagnosis: Some(stop.diagnosis(limits)),
            },
            None => Self {
                status: estimate.status.name(),
                diagnosis: estimate.diagnosis.clone(),
            },
        }
    }

    /// Of a simulation that `stop` asked to end, if anything did.
    pub(crate) fn of_simulation(
        simulation: &Simulation,
        stop: Option<Stop>,
        limits: &LimitArguments,
    ) -> Self {
        let status = &simulation.status;
        match stop.filter(|_| matches!(status, SimulationStatus::Interrupted(_))) {
            Some(stop) => Self {
                status: stop.name(),
                diagnosis: Some(stop.diagnosis(limits)),
            },
            None => Self::of_whole(simulation),
        }
    }

    /// Of a simulation that ended by itself.
    pub(crate) fn of_whole(simulation: &Simulation) -> Self {
        let status = &simulation.status;
        Self {
            status: status.name(),
            diagnosis: status
                .diagnosis()
                .map(|diagnosis| diagnosis.message.clone()),
        }
    }

    /// Of a program from a file that `stop` asked to end, if anything did.
    pub(crate) fn of_program(
        solution: &nl::Solution,
        stop: Option<Stop>,
        limits: &LimitArguments,
    ) -> Self {
        match stop.filter(|_| solution.status == nl::Status::Interrupted) {
            Some(stop) => Self {
                status: stop.name(),
                diagnosis: Some(stop.diagnosis(limits)),
            },
            None => Self {
                status: solution.status.name(),
                diagnosis: solution.diagnosis(),
            },
        }
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
