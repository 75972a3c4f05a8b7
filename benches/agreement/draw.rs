//! Deterministic random numbers: one stream for each kind of scene and number of a draw.

/// Pseudo-random numbers by `splitmix64` (Steele, Lea, Flood, *Fast splittable pseudorandom number generators*).
pub(crate) struct Draw {
    pub(crate) state: u64,
}

impl Draw {
    /// The stream of draw `number` of the kind called `kind`.
    pub(crate) fn new(kind: &str, number: u64) -> Self {
        // FNV-1a keeps kinds apart, whatever their order.
        let name = kind.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        Self {
            state: name ^ number.wrapping_mul(0xd134_2543_de82_ef95),
        }
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `from..to`.
    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        let unit = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        from + (to - from) * unit
    }

    /// One of the whole numbers below `count`.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        self.between(0.0, count as f64) as usize
    }

    /// True with this probability.
    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    /// 0 with this probability, and otherwise uniform in `from..to`.
    pub(crate) fn zero_or(&mut self, probability: f64, from: f64, to: f64) -> f64 {
        match self.chance(probability) {
            true => 0.0,
            false => self.between(from, to),
        }
    }

    /// Log-uniform in `1/factor..factor`.
    pub(crate) fn factor(&mut self, factor: f64) -> f64 {
        let decades = factor.log10();
        10.0_f64.powf(self.between(-decades, decades))
    }

    /// A thousandth, one, or a thousand; mostly one.
    pub(crate) fn scale(&mut self) -> f64 {
        let choice = self.between(0.0, 6.0);
        if choice < 1.0 {
            1e-3
        } else if choice < 2.0 {
            1e3
        } else {
            1.0
        }
    }
}
