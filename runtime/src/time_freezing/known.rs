//! What vanishes in a known motion.

use super::laid_out::spans_of_elements;
use super::layout::W;
use super::modes::{self, Mode};
use super::task::Guess;
use super::transcription::{Block, SUMS, Transcription};

/// Weight or speed of a known motion that counts as none.
const NONE: f64 = 1e-4;

/// What is known of the sides of pairs.
#[derive(Default)]
pub(super) struct KnownSides {
    /// Whether each variable is fixed at zero.
    pub(super) vanishing: Vec<bool>,
    /// Variables without a sign: while a contact neither is closed nor acts, signs decide nothing but through its margin.
    pub(super) unsigned: Vec<usize>,
}

/// Fixes what vanishes in the motion that the solver starts at, where that is a known one.
pub(super) fn fix_sides(transcription: &mut Transcription<'_>) {
    let sides = known_sides(transcription);
    let program = &mut transcription.program;
    for &i in &sides.unsigned {
        let (_, upper) = program.bounds(i);
        program.bound(i, f64::NEG_INFINITY, upper);
    }
    let vanishing = sides.vanishing.iter().enumerate();
    for (i, _) in vanishing.filter(|(_, zero)| **zero) {
        program.bound(i, 0.0, 0.0);
    }
}

/// What is known of the motion that the solver starts at, where that is a known one; nothing else.
pub(super) fn known_sides(transcription: &Transcription<'_>) -> KnownSides {
    let guess = transcription.guess();
    let mut vanishes = vec![false; guess.len()];
    let Guess::Known(intervals) = &transcription.task.guess else {
        return KnownSides::default();
    };
    let of_elements: Vec<&[[bool; 2]]> = spans_of_elements(intervals, transcription.task.elements)
        .into_iter()
        .map(|span| &span.weights[..])
        .collect();
    let layout = &transcription.field.layout;
    let contacts = layout.contacts();
    let modes: Vec<Mode> = of_elements
        .iter()
        .flat_map(|weights| weights[..contacts].iter().map(mode))
        .collect();
    modes::mark_modes(transcription, &guess, NONE, &modes, &mut vanishes);
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
    mark_undecided(transcription, &guess, &mut vanishes);
    mark_exits(transcription, (&modes, &guess), &mut vanishes);
    KnownSides {
        unsigned: unsigned(transcription, &modes, &vanishes),
        vanishing: vanishes,
    }
}

/// Where a contact is free for whole elements: of each of its pairs in a stage the side that does not vanish, and the sums of these.
/// What vanishes says which part the margin is, and that may be another than the largest as long as it is not negative.
fn unsigned(transcription: &Transcription<'_>, modes: &[Mode], vanishes: &[bool]) -> Vec<usize> {
    let layout = &transcription.field.layout;
    let elements = &transcription.elements;
    let is_free = |e: usize, contact: usize| modes[e * layout.contacts() + contact] == Mode::Free;
    let mut unsigned = Vec::new();
    for contact in 0..layout.contacts() {
        let pairs = layout.stage_pairs_of(contact);
        for (e, element) in elements
            .iter()
            .enumerate()
            .filter(|&(e, _)| is_free(e, contact))
        {
            let multipliers = layout
                .groups_of(contact)
                .flat_map(|group| [1, 3].map(|sum| SUMS * group + sum));
            unsigned.extend(multipliers.map(|sum| element.sums + sum));
            // What comes next takes the last point into its sums.
            let last = e + 1 < elements.len() && !is_free(e + 1, contact);
            let blocks = &element.blocks[..element.blocks.len() - usize::from(last)];
            for (block, (first, second)) in blocks
                .iter()
                .flat_map(|b| pairs.iter().map(move |p| (b, *p)))
            {
                let pair = block.variables[first].zip(block.variables[second]);
                unsigned.extend(pair.and_then(|(i, j)| match (vanishes[i], vanishes[j]) {
                    (true, false) => Some(j),
                    (false, true) => Some(i),
                    _ => None,
                }));
            }
        }
    }
    unsigned
}

/// What a contact does whose step function, and whose weight, is there.
fn mode(weights: &[bool; 2]) -> Mode {
    match weights {
        [true, true] => Mode::Contact,
        [true, false] => Mode::Free,
        [false, _] => Mode::Jump,
    }
}

/// Marks the smaller one of each pair of a stage, or of a free start, of which none is known to vanish.
fn mark_undecided(transcription: &Transcription<'_>, guess: &[f64], vanishes: &mut [bool]) {
    let pairs = transcription.field.layout.stage_pairs();
    let elements = transcription.elements.iter();
    let stages = elements.flat_map(|element| &element.blocks);
    let start: Option<&Block> = transcription.is_free.then_some(&transcription.beginning);
    for block in start.into_iter().chain(stages) {
        for &(first, second) in &pairs {
            if let (Some(i), Some(j)) = (block.variables[first], block.variables[second])
                && !vanishes[i]
                && !vanishes[j]
            {
                let smaller = guess[i] < guess[j];
                vanishes[if smaller { i } else { j }] = true;
            }
        }
    }
}

/// Exit conditions. At the end of a jump the normal velocity is zero, and where a contact opens within an interval because its
/// force vanishes, that is zero at the end of its last element. The sums over elements leave both open to the length of a stage, and
/// an optimal control makes use of it.
fn mark_exits(
    transcription: &Transcription<'_>,
    (modes, guess): (&[Mode], &[f64]),
    vanishes: &mut [bool],
) {
    let layout = &transcription.field.layout;
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
            if variables.iter().all(|&i| guess[i] <= NONE) {
                variables.into_iter().for_each(|i| vanishes[i] = true);
            }
        }
    }
}

/// Places of the weight of a contact, and of the parts that friction and restitution split it into.
fn weights(transcription: &Transcription<'_>, contact: usize) -> Vec<usize> {
    let layout = &transcription.field.layout;
    let groups = layout.groups();
    let [_, _, weight, _] = groups[contact].places;
    let split = layout.slip_group(contact).into_iter().flat_map(|group| {
        let [forward, _, backward, _] = groups[group].places;
        [forward, backward]
    });
    std::iter::once(weight).chain(split).collect()
}
