//! Results in words, and their states by name and time.

use std::fmt;
use std::ops::Index;

use super::solution::Solution;
use crate::simulation::number;

/// Share of the largest value of a component to which a plan meets its goals, and more.
const FULFILLED: f64 = 1e-7;

impl Index<&str> for Solution {
    type Output = [f64];

    /// All values of one name along the re-simulated motion, as listed at [`State`](crate::simulation::State); none without a motion.
    ///
    /// # Panics
    /// If the scene knows no such name.
    fn index(&self, name: &str) -> &[f64] {
        match &self.motion {
            Some(motion) => &motion[name],
            None => &[],
        }
    }
}

impl fmt::Display for Solution {
    /// Status, objective, what is proved, the distance of plan and re-simulation, the switches of the plan, and the
    /// last state, a line each.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.status.name())?;
        if let Some(diagnosis) = self.diagnosis() {
            write!(f, ": {diagnosis}")?;
        }
        let Some(motion) = &self.motion else {
            return Ok(());
        };
        let (objective, horizon) = (number(self.objective), number(self.horizon));
        writeln!(f, "\nobjective {objective}, final time {horizon} s")?;
        for found in &self.parameters {
            writeln!(f, "{found}")?;
        }
        writeln!(f, "stationarity {}", self.certificate())?;
        write!(
            f,
            "the re-simulation ends {:.1e} away from the plan",
            self.resimulation_error
        )?;
        let contacts = motion.declaration.contacts;
        for &(time, kind, contact) in &self.planned_events {
            write!(
                f,
                "\n{} s: {kind} at {}",
                number(time),
                contacts[contact].name
            )?;
        }
        if let Some(last) = motion.last_for_people(FULFILLED) {
            write!(f, "\n{last}")?;
        }
        Ok(())
    }
}
