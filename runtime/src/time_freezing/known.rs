//! What vanishes in a known motion.

use super::conditions;
use super::laid_out::spans_of_elements;
use super::layout::W;
use super::modes::{self, Mode};
use super::task::Guess;
use super::transcription::{Block, Element, SUMS, Transcription};

/// Weight or speed of a known motion that counts as none.
const NONE: f64 = 1e-4;

/// What is known of the sides of pairs.
#[derive(Default)]
struct KnownSides {
    /// Whether each variable is fixed at zero.
    vanishing: Vec<bool>,
    /// Variables without a sign: while a contact neither is closed nor acts, signs decide nothing but through its margin.
    unsigned: Vec<usize>,
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
fn known_sides(transcription: &Transcription<'_>) -> KnownSides {
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
    let contacts = layout.contacts;
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
    let mut unsigned = unsigned(transcription, &modes, &vanishes);
    unsigned.extend(conditions::mark_known(transcription, &mut vanishes));
    KnownSides {
        unsigned,
        vanishing: vanishes,
    }
}

/// What has no sign. Where a contact is free for whole elements: of each of its pairs in a stage the side that does not vanish, and the sums of these.
/// What vanishes says which part the margin is, and that may be another than the largest as long as it is not negative.
fn unsigned(transcription: &Transcription<'_>, modes: &[Mode], vanishes: &[bool]) -> Vec<usize> {
    let layout = &transcription.field.layout;
    let elements = &transcription.elements;
    let is_free = |e: usize, contact: usize| modes[e * layout.contacts + contact] == Mode::Free;
    let mut unsigned = Vec::new();
    for contact in 0..layout.contacts {
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
    // Where a contact lasts and an element has no stage at its end, the normal velocity there is an error of the scheme.
    for contact in (0..layout.contacts).filter(|&i| !layout.bounces(i)) {
        let lasts =
            |(e, _): &(usize, &Element)| modes[e * layout.contacts + contact] == Mode::Contact;
        let lasting = elements.iter().enumerate().filter(lasts);
        let ends = lasting.flat_map(|(_, element)| element.blocks.iter().filter(|b| b.boundary));
        let speed = layout.algebraic(contact, W);
        unsigned.extend(ends.filter_map(|block| block.variables[speed]));
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
    let mode = |e: usize, contact: usize| modes.get(e * layout.contacts + contact);
    for (e, element) in transcription.elements.iter().enumerate() {
        let Some(last) = element.blocks.last() else {
            continue;
        };
        let next = transcription.elements.get(e + 1);
        let goes_on = next.is_some_and(|next| next.interval == element.interval);
        for contact in 0..layout.contacts {
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

#[cfg(test)]
mod tests {
    use super::super::field::Field;
    use super::super::layout::{ALPHA, P};
    use super::super::task::{Outer, Span, Task};
    use super::super::test_scenes::Bead;
    use super::super::tests::worst_derivative;
    use super::super::{guess, rows};
    use super::*;
    use crate::program::sparse_program::Program;
    use crate::rk::{ButcherTableau, Scheme};
    use hangtime_solver::nlp::NlpProblem;

    /// A bead that flies for 0.1 s, lands on the floor in a jump of 0.1 s, and stays there.
    fn landing() -> Transcription<'static> {
        static BEAD: std::sync::LazyLock<Bead> = std::sync::LazyLock::new(Bead::default);
        let phase = |weights: [bool; 2],
                     share: f64,
                     heights: [f64; 2],
                     falls: [f64; 2],
                     times: [f64; 2]| {
            // (q, v, t, G) and the shares of floor and wall.
            let point = |k: usize| {
                let states = [0.0, heights[k], 0.0, falls[k], times[k], heights[k], 1.0];
                [&states[..], &[share, 1.0]].concat()
            };
            Span {
                length: 0.1,
                jumps: times[0] == times[1],
                weights: vec![weights, [true, false]],
                sets: Vec::new(),
                points: vec![point(0), point(1)],
            }
        };
        let spans = vec![
            phase([true, false], 1.0, [0.1, 0.0], [-1.0, -2.0], [0.0, 0.1]),
            phase([false, true], 0.0, [0.0, 0.0], [-2.0, 0.0], [0.1, 0.1]),
            phase([true, true], 0.7, [0.0, 0.0], [0.0, 0.0], [0.1, 0.2]),
        ];
        let mut program = Program::new(&*BEAD);
        let mut given = |value: f64| program.variable("given", (value, value), value, 1.0);
        let outer = Outer {
            horizon: given(0.2),
            start: [0.0, 0.1, 0.0, -1.0].map(&mut given).to_vec(),
            controls: vec![vec![program.variable("control", (-3.0, 2.0), 0.8, 1.0)]],
        };
        let task = Task {
            time: 0.0,
            linear: false,
            intervals: 1,
            elements: 5,
            coordinate_bounds: (vec![f64::NEG_INFINITY; 2], vec![f64::INFINITY; 2]),
            guess: Guess::Known(vec![spans]),
        };
        let tableau = ButcherTableau::new(Scheme::RadauIia, 2).expect("two stages");
        let field = Field::new(&*BEAD, 50.0);
        let mut transcription = Transcription::new(program, outer, field, &tableau, task);
        guess::set_guess(&mut transcription);
        rows::add(&mut transcription);
        transcription.finished()
    }

    #[test]
    fn elements_of_a_phase_share_one_length_and_its_derivatives_are_right() {
        let mut program = landing();
        let length = |e: usize| program.elements[e].length;
        // Of five elements two are of the flight, one of the jump, two of the contact.
        assert_eq!([length(1), length(4)], [length(0), length(3)]);
        assert!(length(0) < length(2) && length(2) < length(3));
        // In contact the bead is kept on the curved floor at each stage, and nowhere else.
        let corrected = program.elements.iter().map(|e| e.corrections.len());
        assert_eq!(corrected.collect::<Vec<_>>(), [0, 0, 0, 1, 1]);
        assert_eq!(
            program.program.variable_name(program.elements[3].sums - 1),
            "correction along floor at stage 1 of element 3 of interval 0, 0.0000 to 0.2000 s"
        );
        assert_eq!(
            program.program.variable_name(length(3)),
            "length of element 3 of interval 0, 0.0000 to 0.2000 s"
        );
        let worst = worst_derivative(&mut program);
        assert!(worst < 1e-6, "{worst:e}");
    }

    #[test]
    fn sides_vanish_by_what_the_motion_does() {
        let program = landing();
        let vanishes = known_sides(&program).vanishing;
        let at = |e: usize, stage: usize, offset: usize| {
            let place = program.field.layout.algebraic(0, offset);
            vanishes[program.elements[e].blocks[stage].variables[place].expect("a variable")]
        };
        // Step functions vanish in the jump only; at its end the normal velocity does, and in contact at every stage.
        for e in 0..5 {
            assert_eq!(at(e, 0, ALPHA), e == 2, "{e}");
            assert_eq!(at(e, 1, W), e >= 2, "{e}");
        }
        assert!(!at(2, 0, W) && at(3, 0, W));
    }

    #[test]
    fn other_sides_have_no_sign_while_a_contact_is_free() {
        let program = landing();
        let KnownSides {
            vanishing,
            unsigned,
        } = known_sides(&program);
        let variables = |e: usize, stage: usize| {
            let place = |offset| program.field.layout.algebraic(0, offset);
            let block = &program.elements[e].blocks[stage];
            [P, W].map(|offset| block.variables[place(offset)].expect("a variable"))
        };
        // At the last point before the jump the floor is struck: what vanishes there is the beginning of that.
        for (e, stage) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (3, 0), (4, 1)] {
            let free = e == 0 || (e, stage) == (1, 0);
            for variable in variables(e, stage) {
                let expected = free && !vanishing[variable];
                assert_eq!(unsigned.contains(&variable), expected, "{e} {stage}");
            }
        }
    }
}
