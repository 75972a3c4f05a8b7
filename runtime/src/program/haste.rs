//! The price of a longer motion, which decides among motions that cost the same.

/// The variable for the final time and the price of its unit, in the unit of the objective; none for most programs.
#[derive(Default)]
pub(super) struct Haste(Option<(usize, f64)>);

impl Haste {
    /// A price; 0 for none.
    pub(super) fn new(horizon: usize, price: f64) -> Self {
        Self((price > 0.0).then_some((horizon, price)))
    }

    /// The price, which is none then; nothing where there is none.
    pub(super) fn take(&mut self) -> Option<Self> {
        self.0.take().map(|price| Self(Some(price)))
    }

    /// What the time costs at a solver's point.
    pub(super) fn at(&self, x: &[f64]) -> f64 {
        self.0.map_or(0.0, |(horizon, price)| price * x[horizon])
    }

    /// Adds its derivative to a gradient.
    pub(super) fn add_to(&self, gradient: &mut [f64]) {
        if let Some((horizon, price)) = self.0 {
            gradient[horizon] += price;
        }
    }
}
