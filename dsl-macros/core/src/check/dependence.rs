//! E18: surfaces that are one and the same.
//!
//! Contacts that act at once obey Moreau's law, which decides every velocity, also where one gap is a combination of
//! others that vanish together with it: the legs of a table on a flat floor share forces that are not unique, and
//! move in one way. Gaps that depend on each other need not even vanish together: of the corners of a box, whose gaps
//! fulfil `a - b - c + d = 0`, never more than two touch. So a combination is no mistake. Two surfaces of the same gap are
//! one: their laws contradict each other or say the same twice. Of opposite gaps the two leave no room to move; a
//! constant between them keeps them apart.

use super::checker::Checker;
use crate::ast::Name;
use crate::graph::{self, Sym, Variable};
use crate::scene::Contact;

/// Rest below which two columns of values are the same, relative to the largest value: some thousand roundings.
const NEGLIGIBLE: f64 = 1e-11;

/// Difference of two quotients of gaps, relative, up to which they are compared at all points: a thousand times [`NEGLIGIBLE`], as a small divisor
/// has as many digits less.
const CLOSE: f64 = 1e-8;

/// Points of the first comparison, of which two have to have values.
const FEW: usize = 4;

/// Points at which gaps are compared, of which some may be without a value.
const POINTS: usize = 12;

/// Reports every contact whose gap is that of a contact before it, times a number. They are found by their values at random
/// points: an identity that holds at more points than it has coefficients, all of them random, holds
/// everywhere but with probability zero (Schwartz, "Fast probabilistic algorithms for verification of
/// polynomial identities", 1980). The parameters are random as well, so that defaults which make two
/// gaps equal by chance do not count, and the same at all points, as factors may contain them.
///
/// Pieces of a maximum are left out: each acts only where it is the largest, so two that are the same, as where a floor is
/// made of tiles, need not act together.
pub(super) fn gaps(contacts: &[Contact], checker: &mut Checker<'_>) {
    let whole = |contact: &&Contact| contact.alternatives.is_empty();
    let whole: Vec<&Contact> = contacts.iter().filter(whole).collect();
    let gaps: Vec<Sym> = whole.iter().map(|contact| contact.gap).collect();
    if gaps.len() < 2 {
        return;
    }
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let parameters: Vec<f64> = (0..checker.parameters.len())
        .map(|_| random.number(0.5, 1.5))
        .collect();
    let mut points = (0..POINTS).map(|_| {
        let coordinates = 0..=checker.coordinates.len();
        coordinates.map(|_| random.number(-1.0, 1.0)).collect()
    });
    let few: Vec<Vec<f64>> = points.by_ref().take(FEW).collect();
    let suspects = alike(&values(&gaps, &parameters, &few), gaps.len());
    if suspects.is_empty() {
        return;
    }
    let gaps: Vec<Sym> = suspects.iter().map(|&gap| gaps[gap]).collect();
    let points: Vec<Vec<f64>> = few.into_iter().chain(points).collect();
    let rows = values(&gaps, &parameters, &points);
    if rows.len() < POINTS / 2 {
        return;
    }
    let columns: Vec<Vec<f64>> = (0..gaps.len())
        .map(|gap| {
            let values: Vec<f64> = rows.iter().map(|row| row[gap]).collect();
            let scale = largest(&values).max(f64::MIN_POSITIVE);
            values.iter().map(|value| value / scale).collect()
        })
        .collect();
    for second in 0..columns.len() {
        let sign = |first: usize| proportional(&columns[first], &columns[second]);
        if let Some((first, sign)) = (0..second).find_map(|first| Some((first, sign(first)?))) {
            let [first, second] = [first, second].map(|i| &whole[suspects[i]].name);
            report(second, same(first, second, sign), checker);
        }
    }
}

/// The gaps at points; those at which a root or a logarithm has no value are passed over.
fn values(gaps: &[Sym], parameters: &[f64], points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let row = |point: &Vec<f64>| {
        let values = graph::substitute(gaps, |variable| {
            let value = match variable {
                Variable::Parameter(i) => parameters.get(usize::from(i)),
                Variable::Coordinate(i) => point.get(usize::from(i)),
                Variable::Time => point.last(),
                _ => None,
            };
            value.map(|&value| Sym::number(value))
        });
        let row: Option<Vec<f64>> = values.iter().map(|value| value.as_number()).collect();
        row.filter(|row| row.iter().all(|value| value.is_finite()))
    };
    points.iter().filter_map(row).collect()
}

/// Which of `count` gaps have the quotient of another one, between two points, up to rounding: all where there are no two points. Of gaps by
/// the thousand, as of all pairs of balls, few are left.
fn alike(rows: &[Vec<f64>], count: usize) -> Vec<usize> {
    let [one, other, ..] = rows else {
        return (0..count).collect();
    };
    let quotient = |gap: usize| one[gap] / other[gap];
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| quotient(*a).total_cmp(&quotient(*b)));
    let near = |pair: &[usize]| {
        let [a, b] = [quotient(pair[0]), quotient(pair[1])];
        // What is no number tells nothing.
        let apart = (a - b).abs() > CLOSE * a.abs().max(b.abs()).max(1.0);
        !apart
    };
    let mut suspects: Vec<usize> = Vec::new();
    for pair in order.windows(2).filter(|pair| near(pair)) {
        suspects.extend(pair);
    }
    suspects.sort_unstable();
    suspects.dedup();
    suspects
}

fn report(name: &Name, message: String, checker: &mut Checker<'_>) {
    checker.diagnostics.report("E18", name.place(), message);
}

fn same(first: &Name, second: &Name, sign: f64) -> String {
    let (first, second) = (&first.text, &second.text);
    if sign > 0.0 {
        format!(
            "surfaces `{first}` and `{second}` are the same, so they are always touched together and no rule \
             says which of their laws holds; leave one out"
        )
    } else {
        format!(
            "surfaces `{first}` and `{second}` are the same from both sides, so they leave no room to move; \
             leave one out, or describe the motion by a coordinate less"
        )
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |most, v| most.max(v.abs()))
}

/// Sign of the factor between two scaled columns, if one is a multiple of the other.
fn proportional(first: &[f64], second: &[f64]) -> Option<f64> {
    [1.0, -1.0].into_iter().find(|sign| {
        first
            .iter()
            .zip(second)
            .all(|(a, b)| (a - sign * b).abs() <= NEGLIGIBLE)
    })
}

/// A small generator (splitmix64), so that every expansion gives the same answer.
struct Random(u64);

impl Random {
    fn number(&mut self, least: f64, most: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let unit = ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64;
        least + unit * (most - least)
    }
}
