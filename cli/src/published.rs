//! Published results that the scenes reproduce: the plotted data, what they mean, and the values that
//! are known better.

use hangtime::rk::Scheme;
use hangtime::simulation::EventKind;
use serde::Serialize;

/// One published simulation or optimal motion.
#[derive(Debug, Clone, Copy)]
pub struct PublishedCase {
    /// Name of its files, without extension.
    pub name: &'static str,
    /// What it shows, in one line.
    pub title: &'static str,
    /// Where it was published.
    pub source: &'static str,
    /// Parameters that differ from the defaults, as (name, value with unit).
    pub settings: &'static [(&'static str, &'static str)],
    /// What was computed.
    pub task: Task,
    /// Reads the plotted data.
    pub data: fn() -> Result<PublishedData, PublishedDataError>,
    /// The numbers to compare.
    pub values: &'static [ComparedValue],
}

/// How large an optimal control problem is as another program transcribes it.
#[derive(Debug, Clone, Copy)]
pub struct PublishedSize {
    /// Which program.
    pub what: &'static str,
    /// Where the numbers are from.
    pub source: &'static str,
    /// Runge-Kutta scheme.
    pub scheme: Scheme,
    /// Its stages.
    pub stages: usize,
    /// Control intervals.
    pub intervals: usize,
    /// Finite elements of each.
    pub elements: usize,
    /// Variables.
    pub variables: usize,
    /// Constraints.
    pub constraints: usize,
    /// Nonzeros of the Jacobian.
    pub jacobian_nonzeros: usize,
    /// Nonzeros of a triangle of the Hessian.
    pub hessian_nonzeros: usize,
}

impl PublishedSize {
    /// The grid, in the words of this library.
    pub(crate) fn discretization(&self) -> String {
        format!(
            "{}, {} stages, {} intervals x {} elements",
            self.scheme.name(),
            self.stages,
            self.intervals,
            self.elements
        )
    }
}

/// What was computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Task {
    /// A simulation without controls.
    Simulate {
        /// Its length \[s\].
        horizon: f64,
    },
    /// The optimal control problem of the scene.
    Optimize,
}

/// The plotted data of a case.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PublishedData {
    /// Positions in the plane, in order of time.
    pub points: Vec<PublishedPoint>,
    /// Quantities over time.
    pub curves: Vec<PublishedCurve>,
}

/// The positions of all bodies at one instant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PublishedPoint {
    /// Time \[s\].
    pub time: f64,
    /// Horizontal and vertical position of each body, in the units of the axes.
    pub positions: Vec<[f64; 2]>,
    /// Whether it belongs to the time lapse; the others only mark the path.
    #[serde(skip)]
    pub time_lapse: bool,
}

/// A quantity over time.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedCurve {
    /// Which quantity.
    pub quantity: Quantity,
    /// Its unit.
    pub unit: &'static str,
    /// Points as (time \[s\], value). A control is constant from each point to the next.
    pub points: Vec<[f64; 2]>,
}

/// A quantity of the motion, by the index in the declaration of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// A coordinate.
    Coordinate(usize),
    /// Its time derivative.
    Velocity(usize),
    /// A control.
    Control(usize),
    /// Force of a contact, the multiplier of its gap.
    ContactForce(usize),
    /// Friction force of a contact, the multiplier of its sliding velocity.
    FrictionForce(usize),
    /// A quantity that the scene declares in `outputs`.
    Output(usize),
}

/// One number of a comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparedValue {
    /// What is measured.
    pub measure: Measure,
    /// The unit of all its values.
    pub unit: &'static str,
    /// What the text of the publication says; otherwise the plotted data are read where they show it.
    pub stated: Option<f64>,
    /// What is known better than the publication.
    pub reference: Reference,
}

/// What is measured on a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measure {
    /// Length of the motion.
    FinalTime,
    /// A quantity at the end.
    Final(Quantity),
    /// How much more a quantity is at the end than at the start.
    Gain(Quantity),
    /// A quantity at a time \[s\].
    At(f64, Quantity),
    /// Time of the first event of a kind.
    EventTime(EventKind),
    /// A coordinate at the first event of a kind.
    EventCoordinate(EventKind, usize),
    /// First time at which a coordinate reaches a value.
    Reach(usize, f64),
}

/// A value that is known independently of this library.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reference {
    /// Quadrature or Taylor series with at least two precisions that agree in all digits given.
    Certified(f64),
    /// The best local optimum that any search has found; nothing proves that there is no better one.
    BestKnown(f64),
    /// None.
    Unknown,
}

impl Reference {
    /// The value, if there is one.
    #[must_use]
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Certified(value) | Self::BestKnown(value) => Some(value),
            Self::Unknown => None,
        }
    }
}

/// Why the embedded data of a case could not be read.
#[derive(Debug, thiserror::Error)]
pub enum PublishedDataError {
    /// Not the expected CSV.
    #[error("published data `{name}`: {source}")]
    Csv {
        /// Name of the table.
        name: &'static str,
        /// What the reader says.
        source: csv::Error,
    },
}

/// Instants that differ by less count as the same one \[s\]: rounding of plotted times.
const SAME_TIME: f64 = 1e-9;

impl PublishedData {
    /// The plotted curve of a quantity.
    #[must_use]
    pub fn curve(&self, quantity: Quantity) -> Option<&PublishedCurve> {
        self.curves.iter().find(|curve| curve.quantity == quantity)
    }

    /// The value of a measure, if the plotted data show it.
    #[must_use]
    pub fn value(&self, measure: Measure) -> Option<f64> {
        let last = |curve: &PublishedCurve| curve.points.last().copied();
        let first = |curve: &PublishedCurve| curve.points.first().copied();
        match measure {
            Measure::FinalTime => self.curves.first().and_then(last).map(|[time, _]| time),
            Measure::Final(quantity) => self.curve(quantity).and_then(last).map(|point| point[1]),
            Measure::Gain(quantity) => {
                let curve = self.curve(quantity)?;
                Some(last(curve)?[1] - first(curve)?[1])
            }
            Measure::At(time, quantity) => self
                .curve(quantity)?
                .points
                .iter()
                .find(|point| (point[0] - time).abs() < SAME_TIME)
                .map(|point| point[1]),
            Measure::EventTime(_) | Measure::EventCoordinate(..) | Measure::Reach(..) => None,
        }
    }
}
