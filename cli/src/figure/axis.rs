//! Axes: where values stand along them, and the numbers beside them.

/// Most numbers along a logarithmic axis.
const MOST_TICKS: i32 = 9;
/// Most numbers along a linear one, whatever its digits can tell apart.
const MOST_STEPS: usize = 20;
/// Distance of numbers along a linear axis, at least [px].
const APART: f64 = 34.0;
/// Sizes of values that are written without a power of ten.
const PLAIN: (f64, f64) = (1e-2, 1e5);
/// Free space at the ends of an axis, as a share of its length.
const MARGIN: f64 = 0.03;
/// Powers of ten beyond these are no measurement.
const POWERS: (f64, f64) = (-18.0, 3.0);

/// Where values stand along an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    /// Values at its ends; of a logarithmic one their powers of ten.
    from: f64,
    to: f64,
    /// Where its ends are drawn.
    ends: (f64, f64),
    scale: Scale,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scale {
    Linear,
    Logarithmic,
    /// With a place for zero where it begins.
    WithZero,
}

impl Axis {
    /// A linear axis.
    pub(super) fn linear([from, to]: [f64; 2], ends: (f64, f64)) -> Self {
        Self {
            from,
            to,
            ends,
            scale: Scale::Linear,
        }
    }

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
            scale: Scale::Logarithmic,
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
            scale: match zero {
                true => Scale::WithZero,
                false => Scale::Logarithmic,
            },
        })
    }

    /// Where a value stands; along a logarithmic axis zero stands where it begins.
    pub(super) fn place(&self, value: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => value,
            _ => value.log10().clamp(self.from, self.to),
        };
        // In halves, which do not overflow.
        let share = (0.5 * value - 0.5 * self.from) / (0.5 * self.to - 0.5 * self.from);
        self.ends.0 + share * (self.ends.1 - self.ends.0)
    }

    /// Where numbers stand, and what they are.
    pub(super) fn labels(&self) -> Vec<(f64, String)> {
        if self.scale == Scale::Linear {
            return self.steps();
        }
        let zero = (self.scale == Scale::WithZero).then(|| (0.0, "0".to_owned()));
        let powers = self.powers().into_iter();
        let powers = powers.map(|value| (value, power_label(value)));
        let labels = powers.chain(zero);
        labels
            .map(|(value, label)| (self.place(value), label))
            .collect()
    }

    /// Powers of ten, twice and five times these where there are few.
    fn powers(&self) -> Vec<f64> {
        let first = self.from.ceil() as i32 + i32::from(self.scale == Scale::WithZero);
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

    /// Multiples of 1, 2 or 5 times a power of ten.
    fn steps(&self) -> Vec<(f64, String)> {
        let count = ((self.ends.1 - self.ends.0).abs() / APART).max(1.0);
        let least = self.to / count - self.from / count;
        let power = 10.0_f64.powf(least.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power);
        let Some(step) = steps.into_iter().find(|step| *step >= least) else {
            return Vec::new();
        };
        let first = (self.from / step).ceil();
        let multiples = (0..MOST_STEPS).map(|k| (first + k as f64) * step);
        let size = self.from.abs().max(self.to.abs());
        let plain = (PLAIN.0..PLAIN.1).contains(&size);
        let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
        let label = |value: f64| match plain {
            // A sum of steps may miss zero by its rounding.
            _ if value.abs() < 0.5 * step => "0".to_owned(),
            true => format!("{value:.decimals$}"),
            false => with_power(value),
        };
        multiples
            .take_while(|value| *value <= self.to)
            .map(|value| (self.place(value), label(value)))
            .collect()
    }
}

/// Up to four digits and a power of ten.
fn with_power(value: f64) -> String {
    let text = format!("{value:.3e}");
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    format!("{digits}e{power}")
}

/// Powers of ten of the least and the largest value.
fn powers(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let powers = values.map(|value| value.log10().clamp(POWERS.0, POWERS.1));
    let range = powers.fold((f64::INFINITY, f64::NEG_INFINITY), |range, power| {
        (range.0.min(power), range.1.max(power))
    });
    (range.0 <= range.1).then_some(range)
}

/// A value beside a logarithmic axis: a decimal, or a power of ten where that is shorter.
fn power_label(value: f64) -> String {
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
    const RAISED: [char; 10] = [
        '\u{2070}', '\u{b9}', '\u{b2}', '\u{b3}', '\u{2074}', '\u{2075}', '\u{2076}', '\u{2077}',
        '\u{2078}', '\u{2079}',
    ];
    let raised = |c: char| {
        c.to_digit(10)
            .map_or('\u{207b}', |digit| RAISED[digit as usize])
    };
    let superscript: String = format!("{power:.0}").chars().map(raised).collect();
    format!("10{superscript}")
}

#[cfg(test)]
mod tests {
    use super::{Axis, power_label};

    fn labels(axis: Axis) -> Vec<String> {
        axis.labels().into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn numbers_are_few_round_and_in_range() {
        let wide = Axis::decades([1e-15, 2.0].into_iter(), (0.0, 1.0), false).unwrap();
        assert!((4..=9).contains(&wide.labels().len()));
        let narrow = Axis::around([0.03, 0.4].into_iter(), (0.0, 1.0), true).unwrap();
        assert!(narrow.place(0.4) < narrow.place(0.03));
        assert_eq!(labels(narrow), ["0.05", "0.1", "0.2"]);
        assert_eq!(power_label(1e-12), "10\u{207b}\u{b9}\u{b2}");
        assert_eq!(
            labels(Axis::linear([-0.3, 0.72], (0.0, 204.0))),
            ["-0.2", "0", "0.2", "0.4", "0.6"]
        );
        for ends in [
            [0.0, f64::MAX],
            [1.0, 1.0],
            [f64::NAN, 1.0],
            [-f64::MAX, f64::MAX],
            [1e17, 1e17 + 64.0],
        ] {
            assert!(
                labels(Axis::linear(ends, (0.0, 300.0))).len() <= 20,
                "{ends:?}"
            );
        }
    }
}
