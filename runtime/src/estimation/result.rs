//! What a fit finds.

use crate::model::Experiment;
use crate::simulation::Simulation;
use serde::Serialize;
use std::fmt;

/// How a fit ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The conditions of an optimum of the least squares hold, and the measurements determine every parameter.
    Solved,
    /// They hold, and other values give the same misfit.
    Undetermined,
    /// They hold for differences only: at the values that were found the motion has no derivative.
    Uncertified,
    /// They do not hold.
    NotConverged,
    /// The observer ended it.
    Interrupted,
    /// The scene has no motion at the values from which it begins.
    Failed,
}

impl Status {
    /// Name used in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Undetermined => "undetermined",
            Self::Uncertified => "uncertified",
            Self::NotConverged => "not_converged",
            Self::Interrupted => "interrupted",
            Self::Failed => "failed",
        }
    }

    /// Whether an optimum was found that the measurements determine.
    #[must_use]
    pub fn is_solved(self) -> bool {
        self == Self::Solved
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A parameter that was looked for.
#[derive(Debug, Clone, PartialEq)]
pub struct EstimatedParameter {
    /// Index of the parameter.
    pub index: usize,
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The value that was found, in that unit.
    pub value: f64,
    /// Its standard deviation, as the deviations of the measurements say; none at a bound, and where the measurements do not
    /// determine it.
    pub deviation: Option<f64>,
    /// The range in which it was looked for.
    pub range: (f64, f64),
    /// Whether it ends at a bound that the misfit presses against.
    pub at_bound: bool,
    /// Derivative of the misfit by it.
    pub gradient: f64,
}

/// A change of parameters that changes no measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Changes of the parameters that take part, by their place among the parameters that were looked for, in their units; the
    /// largest as a share of its range is 1 % of that.
    pub changes: Vec<(usize, f64)>,
    /// The change in words.
    pub text: String,
}

/// An experiment beside its motion.
#[derive(Debug, Clone)]
pub struct FittedExperiment {
    /// What was declared.
    pub declared: &'static Experiment,
    /// Times of the measurements \[s\].
    pub times: Vec<f64>,
    /// By time and quantity, in their units; not a number where nothing was measured.
    pub measured: Vec<Vec<f64>>,
    /// What the motion has by time and quantity; right before an event at such a time.
    pub computed: Vec<Vec<f64>>,
    /// The motion.
    pub motion: Simulation,
}

impl FittedExperiment {
    /// What the motion has more than was measured of a quantity, in standard deviations, at each time.
    #[must_use]
    pub fn residuals(&self, quantity: usize) -> Vec<f64> {
        let within = self.declared.quantities[quantity].within;
        let pairs = self.computed.iter().zip(&self.measured);
        pairs
            .map(|(computed, measured)| (computed[quantity] - measured[quantity]) / within)
            .collect()
    }
}

/// An end of the searches, and from how many starts it was reached.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LocalFit {
    /// The misfit there.
    #[serde(rename = "objective")]
    pub misfit: f64,
    /// The values, in the order of [`Estimate::parameters`].
    pub values: Vec<f64>,
    /// Whether the conditions of an optimum hold.
    pub optimal: bool,
    /// From how many starts the searches ended there.
    pub starts: usize,
}

/// Parameters that make the motions of a scene most like those that were measured.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// How it ended.
    pub status: Status,
    /// Why it is not solved, in one line.
    pub diagnosis: Option<String>,
    /// What was looked for.
    pub parameters: Vec<EstimatedParameter>,
    /// The misfit: the sum of the squares of all residuals in standard deviations, or of their losses.
    pub misfit: f64,
    /// Number of measurements.
    pub measurements: usize,
    /// Distance from the optimum of the linear problem there, in standard deviations of what was found: the norm of the gradient
    /// in the metric of the covariance, halved. At most `1e-4` where the conditions of an optimum hold.
    pub distance: f64,
    /// Covariance of the parameters; zero for those at bounds, not a number for those that are not determined.
    pub covariance: Vec<Vec<f64>>,
    /// Directions in which the measurements determine nothing.
    pub undetermined: Vec<Direction>,
    /// The experiments; empty where there is no motion.
    pub experiments: Vec<FittedExperiment>,
    /// The ends of all searches, the best first.
    pub optima: Vec<LocalFit>,
    /// Starts.
    pub starts: usize,
    /// Steps of the search that led to it.
    pub steps: usize,
    /// Motions that were simulated.
    pub simulations: usize,
    /// CPU time \[s\].
    pub seconds: f64,
    /// What else is worth knowing.
    pub notes: Vec<String>,
}

impl Estimate {
    /// Correlation of two parameters by their places; not a number where either has no deviation.
    #[must_use]
    pub fn correlation(&self, one: usize, other: usize) -> f64 {
        let deviation = |k: usize| self.parameters[k].deviation.unwrap_or(f64::NAN);
        if one == other && deviation(one).is_finite() {
            return 1.0;
        }
        self.covariance[one][other] / (deviation(one) * deviation(other))
    }

    /// Root mean square of the residuals with as many degrees of freedom as there are measurements without the parameters; about
    /// 1 where the motion is that of the scene and deviations are declared as they are. Not a number without any.
    #[must_use]
    pub fn spread(&self) -> f64 {
        let bound = |known: &&EstimatedParameter| known.deviation.is_some();
        let found = self.parameters.iter().filter(bound).count();
        let left = self.measurements.saturating_sub(found);
        if left == 0 {
            return f64::NAN;
        }
        (self.misfit / left as f64).sqrt()
    }
}
