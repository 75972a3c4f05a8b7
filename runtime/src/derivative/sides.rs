//! Derivatives to one side, where there are no others.

/// Derivatives of the end of a motion to both sides, with a column for each quantity; not numbers by those by which there are others.
#[derive(Debug, Clone, PartialEq)]
pub struct OneSided {
    /// Towards smaller values.
    pub below: Side,
    /// Towards larger values.
    pub above: Side,
}

/// Derivatives to one side; not numbers where there is none, and infinite where the value moves with the root of the distance, as
/// where a graze is struck.
#[derive(Debug, Clone, PartialEq)]
pub struct Side {
    /// Of the coordinates at the end.
    pub q: Vec<Vec<f64>>,
    /// Of the velocities at the end.
    pub v: Vec<Vec<f64>>,
    /// Of chosen values at the end, by their names; none unless they were asked for.
    pub values: Vec<(String, Vec<f64>)>,
    /// Of the objective, in a scene that declares one.
    pub objective: Option<Vec<f64>>,
    /// Of a value that moves by `a sqrt(h)` with the distance `h` to that side the number `a`, in its unit over the root of that of
    /// the quantity, and 0 of others: rows of the coordinates, of the velocities, of chosen values, and of the objective. Empty where all
    /// derivatives are finite.
    pub roots: Vec<Vec<f64>>,
}
