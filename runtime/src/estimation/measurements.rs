//! What was measured, as numbers.

use crate::InputError;
use crate::model::{Experiment, VariableDeclaration};
use crate::refusal;
use crate::simulation::ControlSignal;

/// Most measurements of one experiment: far above what a fit needs, and what a mistaken file may have.
const MOST: usize = 1_000_000;

/// The measurements of one experiment, in the order and the units of its [`quantities`](Experiment::quantities).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Measurements {
    /// Times from the start of the motion on \[s\], not decreasing, the first at least 0.
    pub times: Vec<f64>,
    /// One vector a time, with one number a quantity; not a number where it was not measured.
    pub values: Vec<Vec<f64>>,
    /// What the controls of the scene were meanwhile; of a scene without controls [`ControlSignal::Zero`].
    pub controls: ControlSignal,
}

impl Measurements {
    /// Time of the last measurement \[s\].
    pub(super) fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// Number of measurements of each quantity.
    pub(super) fn counts(&self, quantities: usize) -> Vec<usize> {
        let count = |k: usize| self.values.iter().filter(|row| !row[k].is_nan()).count();
        (0..quantities).map(count).collect()
    }

    /// Whether they are measurements of that experiment.
    pub(super) fn check(
        &self,
        experiment: &Experiment,
        controls: &[VariableDeclaration],
    ) -> Result<(), InputError> {
        let what = |what: &str| format!("{what} of `{}`", experiment.name);
        if self.values.len() != self.times.len() {
            return Err(refusal::wrong_length(
                what("the list of values"),
                self.values.len(),
                self.times.len(),
            ));
        }
        if self.times.len() > MOST {
            return Err(refusal::out_of_range(
                what("the number of times"),
                self.times.len() as f64,
                "",
                format!("at most {MOST}; keep every second, third, ... one"),
            ));
        }
        let mut before = 0.0;
        for &time in &self.times {
            if !time.is_finite() {
                return Err(refusal::not_finite(what("a time"), time));
            }
            if time < before {
                return Err(refusal::out_of_range(
                    what("a time"),
                    time,
                    "s",
                    format!("at least {before} s, the one before, from the start of the motion on"),
                ));
            }
            before = time;
        }
        for row in &self.values {
            if row.len() != experiment.quantities.len() {
                let wanted = experiment.quantities.len();
                return Err(refusal::wrong_length(what("a row"), row.len(), wanted));
            }
            if let Some(&value) = row.iter().find(|value| value.is_infinite()) {
                return Err(refusal::not_finite(what("a value"), value));
            }
        }
        if let (ControlSignal::Zero, Some(control)) = (&self.controls, controls.first()) {
            return Err(InputError::new(format!(
                "nothing says what the control `{}` was in `{}`; give the controls with the measurements, or write what acted as a \
                 function of `t`",
                control.name, experiment.name
            )));
        }
        if self.end() <= 0.0 {
            return Err(InputError::new(format!(
                "nothing is measured of `{}` behind the start; give measurements at times above 0 s",
                experiment.name
            )));
        }
        let counts = self.counts(experiment.quantities.len());
        if let Some(k) = counts.iter().position(|&count| count == 0) {
            return Err(InputError::new(format!(
                "`{}` of `{}` has no value at any time; measure it or leave it out of the declaration",
                experiment.quantities[k].name, experiment.name
            )));
        }
        Ok(())
    }
}
