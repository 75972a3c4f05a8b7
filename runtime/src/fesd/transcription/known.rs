//! The elements of a known motion: the sides that vanish in it, and where the solver starts.

use super::Transcription;
use super::guess::Placed;
use super::modes::{self, Mode};
use super::task::Span;
use crate::dcs::W;

/// Length in numerical time and elements of an interval with these spans: a jump is one element, the others are divided
/// evenly, the longest ones most often.
pub(super) fn laid_out(spans: &[Span], count: usize, places: &[f64]) -> (f64, Vec<Placed>) {
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
    let length: f64 = spans.iter().map(|span| span.length).sum();
    let elements = spans.iter().zip(parts).flat_map(|(span, parts)| {
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

impl Transcription<'_> {
    /// What vanishes in the motion that the solver starts at, where that is a known one.
    pub(crate) fn known_sides(&self) -> Vec<bool> {
        let mut vanishes = vec![false; self.variables];
        modes::mark_vanishing(self, &self.guess, &mut vanishes);
        mark_ends_of_jumps(self, &mut vanishes);
        vanishes
    }
}

/// The exit condition of jumps: at its end the normal velocity is zero. The sums over an element leave the end of a jump
/// open, since the contact after it may do the rest in its first stage.
fn mark_ends_of_jumps(transcription: &Transcription<'_>, vanishes: &mut [bool]) {
    let contacts = transcription.dcs.layout.contacts();
    let modes = modes::fixed_modes(transcription, vanishes);
    for (e, element) in transcription.elements.iter().enumerate() {
        for contact in (0..contacts).filter(|&i| !transcription.dcs.layout.bounces(i)) {
            let next = modes.get((e + 1) * contacts + contact);
            let ends = modes[e * contacts + contact] == Mode::Jump && next != Some(&Mode::Jump);
            let place = transcription.dcs.layout.algebraic(contact, W);
            let last = element
                .blocks
                .last()
                .and_then(|block| block.variables[place]);
            if let Some(w) = last.filter(|_| ends) {
                vanishes[w] = true;
            }
        }
    }
}
