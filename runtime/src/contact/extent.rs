//! How far and how fast the coordinates of a motion have been, by which is measured what counts as zero at a contact.
//!
//! Rounding leaves of a gap a share of the coordinates that it reads, `sum_k |n_k| |q_k|`, and integration a share of what they have moved.
//! Terms may vanish together at an instant, so that the largest coordinates so far count, but with the slopes `n_k` of the place: a
//! surface that was steep or far away once leaves nothing in a coordinate, and its zeros are small again where it comes back.

/// Largest values of each coordinate of a motion so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Extent {
    start: Vec<f64>,
    place: Vec<f64>,
    way: Vec<f64>,
    speed: Vec<f64>,
    acceleration: Vec<f64>,
}

impl Extent {
    /// Grows to coordinates, velocities and accelerations; the first coordinates are the start.
    pub(crate) fn include(&mut self, q: &[f64], v: &[f64], a: &[f64]) {
        if self.start.is_empty() {
            self.start.extend(q);
            for values in [&mut self.place, &mut self.way, &mut self.speed] {
                values.resize(q.len(), 0.0);
            }
        }
        for (k, start) in self.start.iter().enumerate() {
            self.place[k] = self.place[k].max(q[k].abs());
            self.way[k] = self.way[k].max((q[k] - start).abs());
            self.speed[k] = self.speed[k].max(v[k].abs());
        }
        self.accelerate(a);
    }

    /// Grows to accelerations.
    pub(crate) fn accelerate(&mut self, a: &[f64]) {
        self.acceleration.resize(a.len(), 0.0);
        let sizes = self.acceleration.iter_mut().zip(a);
        // Where one has no value the largest so far stays.
        for (size, a) in sizes.filter(|(_, a)| a.is_finite()) {
            *size = size.max(a.abs());
        }
    }

    /// Size of the terms of a function with these slopes.
    pub(crate) fn places(&self, slopes: &[f64]) -> f64 {
        sum(slopes, &self.place)
    }

    /// By how much a function with these slopes has changed, at most.
    pub(crate) fn ways(&self, slopes: &[f64]) -> f64 {
        sum(slopes, &self.way)
    }

    /// Size of the terms of a velocity along these slopes.
    pub(crate) fn velocities(&self, slopes: &[f64]) -> f64 {
        sum(slopes, &self.speed)
    }

    /// Size of the terms of an acceleration along these slopes.
    pub(crate) fn accelerations(&self, slopes: &[f64]) -> f64 {
        sum(slopes, &self.acceleration)
    }
}

fn sum(slopes: &[f64], sizes: &[f64]) -> f64 {
    let terms = slopes.iter().zip(sizes);
    terms.map(|(slope, size)| slope.abs() * size).sum()
}
