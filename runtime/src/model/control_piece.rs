//! Controls over a part of the time on which they are smooth.

/// Controls as an affine function of time, `values + slopes (t - origin)`.
#[derive(Debug, Clone, Default)]
pub(crate) struct ControlPiece {
    origin: f64,
    values: Vec<f64>,
    /// Empty where the controls are constant.
    slopes: Vec<f64>,
}

impl ControlPiece {
    /// The controls do not depend on time.
    pub(crate) fn set_constant(&mut self, values: impl Iterator<Item = f64>) {
        self.slopes.clear();
        self.values.clear();
        self.values.extend(values);
    }

    /// The controls are linear between two instants with their values there.
    pub(crate) fn set_linear(&mut self, (start, from): (f64, &[f64]), (end, to): (f64, &[f64])) {
        self.set_constant(from.iter().copied());
        self.origin = start;
        let ends = from.iter().zip(to);
        self.slopes
            .extend(ends.map(|(from, to)| (to - from) / (end - start)));
    }

    /// Writes the controls at time `t`.
    pub(crate) fn write(&self, t: f64, u: &mut [f64]) {
        u.copy_from_slice(&self.values);
        for (value, slope) in u.iter_mut().zip(&self.slopes) {
            *value += slope * (t - self.origin);
        }
    }

    /// Whether the controls depend on time.
    pub(crate) fn varies(&self) -> bool {
        !self.slopes.is_empty()
    }

    /// Rates of the controls, empty where they are constant.
    pub(crate) fn slopes(&self) -> &[f64] {
        &self.slopes
    }
}
