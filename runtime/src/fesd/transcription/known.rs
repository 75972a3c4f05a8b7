//! The elements of a known motion: the sides that vanish in it, and where the solver starts.

use super::Transcription;
use super::guess::Placed;
use super::modes::{self, Mode};
use super::task::Span;
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

/// What vanishes in the motion that the solver starts at, where that is a known one.
pub(crate) fn known_sides(transcription: &Transcription<'_>) -> Vec<bool> {
    let mut vanishes = vec![false; transcription.variables];
    modes::mark_vanishing(transcription, &transcription.guess, &mut vanishes);
    mark_exits(transcription, &mut vanishes);
    vanishes
}

/// Exit conditions. At the end of a jump the normal velocity is zero, and where a contact opens within an interval because its
/// force vanishes, that is zero at the end of its last element. The sums over elements leave both open to the length of a stage, and
/// an optimal control makes use of it.
fn mark_exits(transcription: &Transcription<'_>, vanishes: &mut [bool]) {
    let layout = &transcription.dcs.layout;
    let modes = modes::fixed_modes(transcription, vanishes);
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
