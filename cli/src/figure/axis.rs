//! Logarithmic axes.

/// Most numbers along an axis.
const MOST_TICKS: i32 = 9;
/// Free space at the ends of an axis, as a share of its length.
const MARGIN: f64 = 0.03;
/// Powers of ten beyond these are no measurement.
const POWERS: (f64, f64) = (-18.0, 3.0);

/// Where values stand along a logarithmic axis.
pub(super) struct Axis {
    /// Powers of ten at its ends.
    from: f64,
    to: f64,
    /// Where its ends are drawn.
    ends: (f64, f64),
    /// Whether zero has the place where it begins.
    pub(super) zero: bool,
}

impl Axis {
    /// An axis around positive values; `None` without any.
    pub(super) fn around(
        values: impl Iterator<Item = f64>,
        (start, end): (f64, f64),
        falling: bool,
    ) -> Option<Self> {
        let (least, most) = powers(values)?;
        let margin = (MARGIN * (most - least)).max(0.05);
        Some(Self {
            from: least - margin,
            to: most + margin,
            ends: if falling { (end, start) } else { (start, end) },
            zero: false,
        })
    }

    /// An axis from one power of ten to another, which begins with zero where that is asked for.
    pub(super) fn decades(
        values: impl Iterator<Item = f64>,
        ends: (f64, f64),
        zero: bool,
    ) -> Option<Self> {
        let (least, most) = powers(values).or(zero.then_some((0.0, 0.0)))?;
        let first = least.floor();
        Some(Self {
            from: if zero { first - 1.0 } else { first },
            to: most.ceil().max(first + 1.0),
            ends,
            zero,
        })
    }

    /// Where a value stands; zero stands where the axis begins.
    pub(super) fn place(&self, value: f64) -> f64 {
        let power = value.log10().clamp(self.from, self.to);
        let share = (power - self.from) / (self.to - self.from);
        self.ends.0 + share * (self.ends.1 - self.ends.0)
    }

    /// Values with a number: powers of ten, twice and five times these where there are few.
    pub(super) fn ticks(&self) -> Vec<f64> {
        let first = self.from.ceil() as i32 + i32::from(self.zero);
        let last = self.to.floor() as i32;
        let every = (last - first + 1).div_euclid(MOST_TICKS) + 1;
        let mut ticks: Vec<f64> = (first..=last)
            .filter(|power| power.rem_euclid(every) == 0)
            .map(|power| 10.0_f64.powi(power))
            .collect();
        if ticks.len() < 3 {
            ticks = (first - 1..=last)
                .flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10.0_f64.powi(power)))
                .filter(|value| (self.from..=self.to).contains(&value.log10()))
                .collect();
        }
        ticks
    }
}

/// Powers of ten of the least and the largest value.
fn powers(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let powers = values.map(|value| value.log10().clamp(POWERS.0, POWERS.1));
    let range = powers.fold((f64::INFINITY, f64::NEG_INFINITY), |range, power| {
        (range.0.min(power), range.1.max(power))
    });
    (range.0 <= range.1).then_some(range)
}

/// A value beside its axis: a decimal, or a power of ten where that is shorter.
pub(super) fn tick_label(value: f64) -> String {
    let power = value.log10().round();
    let is_power = (value.log10() - power).abs() < 1e-9;
    if !is_power || (-2.0..=3.0).contains(&power) {
        return if value < 1e-3 {
            format!("{value:.0e}")
        } else {
            // Products with powers of ten have digits that nobody wants to see.
            let rounded = (value * 1e6).round() / 1e6;
            rounded.to_string()
        };
    }
    let superscript = format!("{power:.0}")
        .chars()
        .map(|c| match c {
            '-' => '\u{207b}',
            '1' => '\u{b9}',
            '2' => '\u{b2}',
            '3' => '\u{b3}',
            c => c
                .to_digit(10)
                .and_then(|digit| char::from_u32(0x2070 + digit))
                .unwrap_or(c),
        })
        .collect::<String>();
    format!("10{superscript}")
}

#[cfg(test)]
mod tests {
    use super::{Axis, tick_label};

    #[test]
    fn ticks_are_few_round_and_in_range() {
        let wide = Axis::decades([1e-15, 2.0].into_iter(), (0.0, 1.0), false).unwrap();
        assert!(wide.ticks().len() <= 9 && wide.ticks().len() >= 4);
        let narrow = Axis::around([0.03, 0.4].into_iter(), (0.0, 1.0), true).unwrap();
        let labels: Vec<String> = narrow.ticks().into_iter().map(tick_label).collect();
        assert_eq!(labels, ["0.05", "0.1", "0.2"]);
        assert!(narrow.place(0.4) < narrow.place(0.03));
        assert_eq!(tick_label(1e-12), "10\u{207b}\u{b9}\u{b2}");
    }
}
