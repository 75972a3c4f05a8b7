//! E18: contacts whose gaps depend on each other.
//!
//! Contacts that act at once obey Moreau's law, which decides every velocity as long as no gap is a
//! combination of others. Where `g = sum_i c_i g_i` for every position, contacts are touched together by
//! necessity, and the law cannot say which of them carries the force and which coefficients hold. A
//! constant in the sum keeps them apart: opposite walls are never touched together.

use super::checker::Checker;
use crate::ast::Name;
use crate::diagnostics::list;
use crate::graph::{self, Sym, Variable};
use crate::scene::Contact;

/// Rest below which a column of values counts as a combination of others, relative to its largest
/// value: some thousand roundings.
const NEGLIGIBLE: f64 = 1e-11;

/// Reports every contact whose gap is a combination of gaps before it. They are found by their values at random
/// points: an identity that holds at more points than it has coefficients, all of them random, holds
/// everywhere but with probability zero (Schwartz, "Fast probabilistic algorithms for verification of
/// polynomial identities", 1980). The parameters are random as well, so that defaults which make two
/// gaps equal by chance do not count, and the same at all points, as coefficients may contain them.
pub(super) fn gaps(contacts: &[Contact], checker: &mut Checker<'_>) {
    let gaps: Vec<Sym> = contacts.iter().map(|contact| contact.gap).collect();
    if gaps.len() < 2 {
        return;
    }
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let parameters: Vec<f64> = (0..checker.parameters.len())
        .map(|_| random.number(0.5, 1.5))
        .collect();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    // Points at which a root or a logarithm has no value are passed over.
    for _ in 0..4 * gaps.len() + 8 {
        let point: Vec<f64> = (0..=checker.coordinates.len())
            .map(|_| random.number(-1.0, 1.0))
            .collect();
        let values = graph::substitute(&gaps, |variable| {
            let value = match variable {
                Variable::Parameter(i) => parameters.get(usize::from(i)),
                Variable::Coordinate(i) => point.get(usize::from(i)),
                Variable::Time => point.last(),
                _ => None,
            };
            value.map(|&value| Sym::number(value))
        });
        let row: Option<Vec<f64>> = values.iter().map(|value| value.as_number()).collect();
        rows.extend(row.filter(|row| row.iter().all(|value| value.is_finite())));
    }
    if rows.len() < gaps.len() + 3 {
        return;
    }
    let columns: Vec<Vec<f64>> = (0..gaps.len())
        .map(|gap| {
            let values: Vec<f64> = rows.iter().map(|row| row[gap]).collect();
            let scale = largest(&values).max(f64::MIN_POSITIVE);
            values.iter().map(|value| value / scale).collect()
        })
        .collect();
    let names: Vec<&Name> = contacts.iter().map(|contact| &contact.name).collect();
    let mut reported = vec![false; columns.len()];
    for second in 0..columns.len() {
        for first in 0..second {
            if let Some(sign) = proportional(&columns[first], &columns[second])
                && act_together(contacts, &[first, second])
            {
                report(
                    names[second],
                    same(names[first], names[second], sign),
                    checker,
                );
                reported[second] = true;
                break;
            }
        }
    }
    for (index, others) in combinations(&columns) {
        let all: Vec<usize> = others.iter().copied().chain([index]).collect();
        if !reported[index] && others.len() > 1 && act_together(contacts, &all) {
            let others = others.into_iter().map(|other| names[other].text.as_str());
            let message = format!(
                "the gap of surface `{}` is a combination of those of {}, so it is touched wherever they are \
                 and no rule says how they share the force; leave one of them out",
                names[index].text,
                list(others)
            );
            report(names[index], message, checker);
        }
    }
}

/// Whether contacts can be touched at once: of the pieces of a maximum, only the largest acts.
fn act_together(contacts: &[Contact], among: &[usize]) -> bool {
    let mut others = among.iter().flat_map(|&i| &contacts[i].alternatives);
    !others.any(|other| among.contains(other))
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

/// Columns that are combinations of columns before them without a constant, with the columns that they
/// are made of: elimination, with a column of ones before all others.
fn combinations(columns: &[Vec<f64>]) -> Vec<(usize, Vec<usize>)> {
    struct Reduced {
        values: Vec<f64>,
        coefficients: Vec<f64>,
        pivot: usize,
    }
    let points = columns.first().map_or(0, Vec::len);
    let ones = vec![1.0; points];
    let mut known: Vec<Reduced> = Vec::new();
    let mut found = Vec::new();
    for (index, column) in std::iter::once(&ones).chain(columns).enumerate() {
        let mut values = column.clone();
        let mut coefficients = vec![0.0; columns.len() + 1];
        coefficients[index] = 1.0;
        for other in &known {
            let factor = values[other.pivot] / other.values[other.pivot];
            for (value, its) in values.iter_mut().zip(&other.values) {
                *value -= factor * its;
            }
            for (own, its) in coefficients.iter_mut().zip(&other.coefficients) {
                *own -= factor * its;
            }
        }
        if largest(&values) > NEGLIGIBLE {
            let pivot = (0..points).max_by(|&a, &b| values[a].abs().total_cmp(&values[b].abs()));
            known.push(Reduced {
                values,
                coefficients,
                pivot: pivot.unwrap_or(0),
            });
            continue;
        }
        let is_used = |coefficient: f64| coefficient.abs() > NEGLIGIBLE.sqrt();
        if !is_used(coefficients[0]) {
            let others = (1..index).filter(|&i| is_used(coefficients[i]));
            found.push((index - 1, others.map(|i| i - 1).collect()));
        }
    }
    found
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
