//! Derivatives and sizes of the program.

use super::field::Field;
use super::step_form::transcribe;
use super::task::{Guess, Outer, Task};
use super::test_scenes::{Bead, Blade, DryBead, EdgedBead, HeldBead, RoughBead, Wire};
use super::transcription::Transcription;
use crate::model::Model;
use crate::program::sparse_program::Program;
use crate::rk::{ButcherTableau, Scheme};
use hangtime_solver::ProblemSize;
use hangtime_solver::nlp::{NlpProblem, check_derivatives};

/// What is unknown beside the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Unknown {
    /// Nothing: the controls are given.
    Nothing,
    /// Controls, horizon, and what the scene leaves free at the start.
    Everything,
    /// The same with controls that are linear between nodes.
    EverythingBetweenNodes,
}

/// A bead that a post of three pieces throws back and brakes.
fn bouncing_edged_bead() -> EdgedBead {
    EdgedBead {
        e: 0.6,
        mu: 0.2,
        ..EdgedBead::default()
    }
}

/// The program of a bead from 0.3 s on, over intervals with so many elements.
fn program<'a>(
    bead: &'a dyn Model,
    tableau: &ButcherTableau,
    unknown: Unknown,
    elements: usize,
) -> Transcription<'a> {
    let linear = unknown == Unknown::EverythingBetweenNodes;
    let free = linear || unknown == Unknown::Everything;
    let intervals = if free { 2 } else { 1 };
    let mut program = Program::new(bead);
    let mut variable = |name: &str, value: f64, range: Option<(f64, f64)>| {
        let range = range.filter(|_| free).unwrap_or((value, value));
        program.variable(name, range, value, 1.0)
    };
    let declared = bead.declaration().optimal_control.expect("declared");
    let start = [0.2, 0.4, 1.5, -0.7].into_iter().enumerate();
    let range = |k: usize| declared.free_start.contains(&k).then_some((-2.0, 2.0));
    let outer = Outer {
        horizon: variable("horizon", 0.25, Some((0.1, 1.0))),
        controls: (0..intervals + usize::from(linear))
            .map(|_| vec![variable("control", 0.8, Some((-3.0, 2.0)))])
            .collect(),
        start: start
            .map(|(k, value)| variable("start", value, range(k)))
            .collect(),
    };
    let task = Task {
        time: 0.3,
        linear,
        intervals,
        elements,
        coordinate_bounds: (vec![f64::NEG_INFINITY; 2], vec![f64::INFINITY; 2]),
        guess: Guess::Simulated,
    };
    let field = Field::new(bead, 50.0);
    transcribe(program, outer, field, tableau, task).finished()
}

/// The largest error of a derivative at a point off every bound and symmetry.
pub(super) fn worst_derivative(transcription: &mut Transcription<'_>) -> f64 {
    let program = &mut transcription.program;
    let mut x = vec![0.0; program.variables()];
    program.initial_point(&mut x);
    for (i, value) in x.iter_mut().enumerate() {
        *value += 0.1 + 0.05 * (i as f64).sin();
    }
    let compared = check_derivatives(program, Some(&x)).expect("finite at the start");
    assert!(compared.len() > 500);
    assert!(compared.iter().all(|entry| !entry.missing));
    compared[0].error
}

#[test]
fn derivatives_agree_with_differences_for_both_kinds_of_schemes() {
    let (bead, rough) = (Bead::default(), RoughBead::default());
    let (dry, wire) = (DryBead::default(), Wire::default());
    let (edged, bouncing) = (EdgedBead::default(), bouncing_edged_bead());
    let (held, blade) = (HeldBead::default(), Blade::default());
    let beads: [&dyn Model; 8] = [&bead, &rough, &dry, &wire, &edged, &bouncing, &held, &blade];
    for scheme in [Scheme::RadauIia, Scheme::GaussLegendre] {
        let tableau = ButcherTableau::new(scheme, 2).expect("two stages");
        let unknowns = [
            Unknown::Nothing,
            Unknown::Everything,
            Unknown::EverythingBetweenNodes,
        ];
        for (bead, unknown) in beads.into_iter().flat_map(|b| unknowns.map(|u| (b, u))) {
            // Central differences of functions of size 100 with steps of 6e-6.
            let worst = worst_derivative(&mut program(bead, &tableau, unknown, 2));
            assert!(worst < 1e-6, "{scheme:?}, {unknown:?}: {worst:e}");
        }
    }
}

#[test]
fn laws_add_unknowns_to_the_contacts_that_have_them_only() {
    let tableau = ButcherTableau::new(Scheme::RadauIia, 2).expect("two stages");
    let sizes = |model: &dyn Model| {
        let program = program(model, &tableau, Unknown::Nothing, 3).program;
        let size = ProblemSize::of(&program);
        (size.variables, size.equalities, size.complementarities)
    };
    let (plain, rough) = (sizes(&Bead::default()), sizes(&RoughBead::default()));
    // An element and stage: 7 states, 12 step variables, one product; an element: its length, 8 sums.
    assert_eq!(plain.0, 3 * (2 * 20 + 9) + 1);
    assert_eq!(plain.2, 3 * (2 * 2 + 4));
    // Two frictions add 4 unknowns, 2 rows and a pair a stage, a restitution 2 unknowns and a row; each of
    // the three adds 4 sums and 2 pairs an element.
    assert_eq!(rough.0 - plain.0, 3 * (2 * 10 + 12));
    assert_eq!(rough.1 - plain.1, 3 * (2 * 5 + 12));
    assert_eq!(rough.2 - plain.2, 3 * (2 * 2 + 6));
    // Each of three pieces is compared with two others: 2 unknowns, a row and a pair a stage. One contact more than the
    // two gaps has a state, 6 step variables, 3 rows and a product, and 4 sums and 2 pairs an element.
    let edged = sizes(&EdgedBead::default());
    assert_eq!(edged.0 - plain.0, 3 * (2 * (6 * 2 + 8) + 4));
    assert_eq!(edged.1 - plain.1, 3 * (2 * (6 + 5) + 4));
    assert_eq!(edged.2 - plain.2, 3 * (2 * (6 + 1) + 2));
    // Where each of the three bounces and rubs, it dips into the ground, which is a state.
    let bouncing = sizes(&bouncing_edged_bead());
    assert_eq!(bouncing.0 - edged.0, 3 * (2 * 3 * (2 + 4 + 1) + 3 * 8));
    assert_eq!(bouncing.1 - edged.1, 3 * (2 * 3 * (1 + 2 + 1) + 3 * 8));
    assert_eq!(bouncing.2 - edged.2, 3 * (2 * 3 + 3 * 4));
}

#[test]
fn joints_stand_in_the_place_of_rows_of_collocation() {
    let tableau = ButcherTableau::new(Scheme::RadauIia, 2).expect("two stages");
    let bead = HeldBead::default();
    let program = program(&bead, &tableau, Unknown::Nothing, 3).program;
    let names: Vec<String> = (0..program.constraints())
        .map(|row| program.constraint_name(row))
        .collect();
    // A position and a velocity at two stages of three elements.
    let count = |start: &str| names.iter().filter(|name| name.starts_with(start)).count();
    assert_eq!(count("joint `wire`, stage"), 6, "{names:?}");
    assert_eq!(count("velocity of joint `wire`, stage"), 6);
    // Of two coordinates, their velocities, the clock and the gap, two components are left to the scheme.
    assert_eq!(count("collocation"), 6 * (6 - 2));
}
