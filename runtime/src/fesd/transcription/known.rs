//! The elements of a known motion: the sides that vanish in it, and where the solver starts.

use super::Transcription;
use super::guess::Placed;
use super::modes::{self, Mode};
use super::task::{Guess, Span};
use crate::dcs::W;

/// Weight or speed of a known motion that counts as none.
const NONE: f64 = 1e-4;

/// Numbers of elements of these spans, `count` together where that is enough: a jump is one element, the others are divided evenly,
/// the longest ones most often.
pub(super) fn parts(spans: &[Span], count: usize) -> Vec<usize> {
    let mut parts = vec![1; spans.len()];
    for _ in spans.len()..count {
        let part = |&i: &usize| (!spans[i].jumps, spans[i].length / parts[i] as f64);
        let compare = |a: &usize, b: &usize| {
            let (a, b) = (part(a), part(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        };
        if let Some(longest) = (0..spans.len()).max_by(compare) {
            parts[longest] += 1;
        }
    }
    parts
}

/// Length in numerical time and elements of an interval with these spans.
pub(super) fn laid_out(spans: &[Span], count: usize, places: &[f64]) -> (f64, Vec<Placed>) {
    let length: f64 = spans.iter().map(|span| span.length).sum();
    let elements = spans
        .iter()
        .zip(parts(spans, count))
        .flat_map(|(span, parts)| {
            (0..parts).map(move |part| Placed {
                width: span.length / length / parts as f64,
                points: places
                    .iter()
                    .map(|place| at(span, (part as f64 + place) / parts as f64))
                    .collect(),
            })
        });
    (length, elements.collect())
}

/// The point at a share of a span.
fn at(span: &Span, share: f64) -> Vec<f64> {
    let place = share * (span.points.len() - 1) as f64;
    let first = (place as usize).min(span.points.len() - 2);
    let fraction = place - first as f64;
    let pair = span.points[first].iter().zip(&span.points[first + 1]);
    pair.map(|(a, b)| a + fraction * (b - a)).collect()
}

/// What vanishes in the motion that the solver starts at, where that is a known one; nothing else.
pub(crate) fn known_sides(transcription: &Transcription<'_>) -> Vec<bool> {
    let mut vanishes = vec![false; transcription.variables];
    let Guess::Known(intervals) = &transcription.task.guess else {
        return vanishes;
    };
    let of_elements: Vec<&[[bool; 2]]> = intervals
        .iter()
        .flat_map(|spans| {
            let parts = parts(spans, transcription.task.elements);
            let repeated = spans.iter().zip(parts);
            repeated.flat_map(|(span, count)| std::iter::repeat_n(&span.weights[..], count))
        })
        .collect();
    let layout = &transcription.dcs.layout;
    let contacts = layout.contacts();
    let modes: Vec<Mode> = of_elements
        .iter()
        .flat_map(|weights| weights[..contacts].iter().map(mode))
        .collect();
    modes::mark_modes(
        transcription,
        &transcription.guess,
        NONE,
        &modes,
        &mut vanishes,
    );
    for (e, weights) in of_elements.iter().enumerate() {
        for (group, weights) in weights.iter().enumerate() {
            if group < contacts && !layout.bounces(group) {
                continue;
            }
            for (pair, &weighs) in weights.iter().enumerate() {
                let sum = 2 * pair + usize::from(weighs);
                modes::mark_sum(transcription, e, group, sum, &mut vanishes);
            }
        }
    }
    mark_undecided(transcription, &mut vanishes);
    mark_exits(transcription, &modes, &mut vanishes);
    vanishes
}

/// What a contact does whose step function, and whose weight, is there.
fn mode(weights: &[bool; 2]) -> Mode {
    match weights {
        [true, true] => Mode::Contact,
        [true, false] => Mode::Free,
        [false, _] => Mode::Jump,
    }
}

/// Marks the smaller one of each pair of a stage of which none is known to vanish.
fn mark_undecided(transcription: &Transcription<'_>, vanishes: &mut [bool]) {
    let pairs = transcription.dcs.layout.stage_pairs();
    let elements = transcription.elements.iter();
    for block in elements.flat_map(|element| &element.blocks) {
        for &(first, second) in &pairs {
            if let (Some(i), Some(j)) = (block.variables[first], block.variables[second])
                && !vanishes[i]
                && !vanishes[j]
            {
                let smaller = transcription.guess[i] < transcription.guess[j];
                vanishes[if smaller { i } else { j }] = true;
            }
        }
    }
}

/// Exit conditions. At the end of a jump the normal velocity is zero, and where a contact opens within an interval because its
/// force vanishes, that is zero at the end of its last element. The sums over elements leave both open to the length of a stage, and
/// an optimal control makes use of it.
fn mark_exits(transcription: &Transcription<'_>, modes: &[Mode], vanishes: &mut [bool]) {
    let layout = &transcription.dcs.layout;
    let mode = |e: usize, contact: usize| modes.get(e * layout.contacts() + contact);
    for (e, element) in transcription.elements.iter().enumerate() {
        let Some(last) = element.blocks.last() else {
            continue;
        };
        let next = transcription.elements.get(e + 1);
        let goes_on = next.is_some_and(|next| next.interval == element.interval);
        for contact in 0..layout.contacts() {
            let places = match (mode(e, contact), mode(e + 1, contact)) {
                (Some(Mode::Jump), next) if next != Some(&Mode::Jump) => {
                    let stops = !layout.bounces(contact);
                    vec![layout.algebraic(contact, W); usize::from(stops)]
                }
                (Some(Mode::Contact), Some(Mode::Free)) if goes_on => {
                    weights(transcription, contact)
                }
                _ => continue,
            };
            let variables = places.iter().filter_map(|&place| last.variables[place]);
            let variables: Vec<usize> = variables.collect();
            if variables.iter().all(|&i| transcription.guess[i] <= NONE) {
                variables.into_iter().for_each(|i| vanishes[i] = true);
            }
        }
    }
}

/// Places of the weight of a contact, and of the parts that friction and restitution split it into.
fn weights(transcription: &Transcription<'_>, contact: usize) -> Vec<usize> {
    let layout = &transcription.dcs.layout;
    let groups = layout.groups();
    let [_, _, weight, _] = groups[contact].places;
    let split = layout.slip_group(contact).into_iter().flat_map(|group| {
        let [forward, _, backward, _] = groups[group].places;
        [forward, backward]
    });
    std::iter::once(weight).chain(split).collect()
}
