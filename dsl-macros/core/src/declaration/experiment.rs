//! Measured motions that a scene is compared with.

/// A measured motion, which the objective of the scene compares with by `minimize misfit(name)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Experiment {
    /// Its name.
    pub name: &'static str,
    /// Its documentation.
    pub documentation: &'static str,
    /// The file of the measurements, as declared, or [their table](Self::table).
    pub file: &'static str,
    /// What was measured.
    pub quantities: &'static [MeasuredQuantity],
    /// From how many standard deviations on a residual counts linearly; `None` where squares are added up.
    pub huber: Option<f64>,
    /// Whether it has a start of its own, see `Model::in_experiment`.
    pub own_start: bool,
}

impl Experiment {
    /// The table of the measurements, where the scene has it between the quotation marks, on lines of its own; `None` where
    /// [`file`](Self::file) is the name of a file.
    #[must_use]
    pub fn table(&self) -> Option<&'static str> {
        self.file.contains('\n').then_some(self.file)
    }
}

/// Something that was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredQuantity {
    /// Its name in the file, such as `z` or `dot(z)`.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it is.
    pub measured: Measured,
    /// Standard deviation of a measurement, in that unit; above 0.
    pub within: f64,
}

/// What is measured, by its index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measured {
    /// A coordinate.
    Coordinate(usize),
    /// The velocity of a coordinate; those of the last coordinates are the states of first order.
    Velocity(usize),
    /// What the scene records.
    Output(usize),
}
