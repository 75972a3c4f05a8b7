//! What vanishes in a known motion.

use super::field::Field;
use super::known::{KnownSides, known_sides};
use super::layout::{ALPHA, P, W};
use super::step_form::transcribe;
use super::task::{Guess, Outer, Span, Task};
use super::test_scenes::Bead;
use super::tests::worst_derivative;
use super::transcription::Transcription;
use crate::program::sparse_program::Program;
use crate::rk::{ButcherTableau, Scheme};
use hangtime_solver::nlp::NlpProblem;

/// A bead that flies for 0.1 s, lands on the floor in a jump of 0.1 s, and stays there.
fn landing() -> Transcription<'static> {
    static BEAD: std::sync::LazyLock<Bead> = std::sync::LazyLock::new(Bead::default);
    let phase =
        |weights: [bool; 2], share: f64, heights: [f64; 2], falls: [f64; 2], times: [f64; 2]| {
            // (q, v, t, G) and the shares of floor and wall.
            let point = |k: usize| {
                let states = [0.0, heights[k], 0.0, falls[k], times[k], heights[k], 1.0];
                [&states[..], &[share, 1.0]].concat()
            };
            Span {
                length: 0.1,
                jumps: times[0] == times[1],
                weights: vec![weights, [true, false]],
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
        slopes: Vec::new(),
        intervals: 1,
        elements: 5,
        coordinate_bounds: (vec![f64::NEG_INFINITY; 2], vec![f64::INFINITY; 2]),
        guess: Guess::Known(vec![spans]),
    };
    let tableau = ButcherTableau::new(Scheme::RadauIia, 2).expect("two stages");
    let field = Field::new(&*BEAD, 50.0, &[]);
    transcribe(program, outer, field, &tableau, task).finished()
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
        program.variable_name(program.elements[3].sums - 1),
        "correction along floor at stage 1 of element 3 of interval 0, 0.0000 to 0.2000 s"
    );
    assert_eq!(
        program.variable_name(length(3)),
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
