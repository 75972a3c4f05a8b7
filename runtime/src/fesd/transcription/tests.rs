//! Derivatives and sizes of the program.

use super::test_scenes::{Bead, Blade, DryBead, EdgedBead, HeldBead, RoughBead, Wire};
use super::*;
use crate::model::Model;
use crate::rk::Scheme;
use crate::time_freezing::TimeFreezingSystem;
use hangtime_solver::nlp::{NlpProblem, check_derivatives};

/// What is unknown beside the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Unknown {
    /// Nothing: the controls are given.
    Nothing,
    /// Nothing, and the controls change with time.
    NothingUnderRamps,
    /// Controls and horizon.
    Everything,
    /// Controls that are linear between nodes, and the horizon.
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

fn worst_derivative(tableau: &ButcherTableau, bead: &dyn Model, unknown: Unknown) -> f64 {
    let mut dcs = HeavisideSystem::new(TimeFreezingSystem::new(bead, 50.0));
    if unknown == Unknown::NothingUnderRamps {
        dcs = dcs.driven(0.3, &[2.5]);
    }
    let start = State {
        time: 0.3,
        q: vec![0.2, 0.4],
        v: vec![1.5, -0.7],
    };
    let mut task = Task::step(&start, &[0.8], 0.25, 2);
    let linear = unknown == Unknown::EverythingBetweenNodes;
    if linear || unknown == Unknown::Everything {
        let declared = bead.declaration().optimal_control.expect("declared");
        let free_start = declared.free_start.iter();
        let free_start = free_start.map(|&k| (k, (-2.0, 2.0))).collect();
        task.horizon_bounds = Some((0.1, 1.0));
        task.intervals = 2;
        task.controls = Controls::Free {
            lower: vec![-3.0],
            upper: vec![2.0],
            guess: vec![vec![0.8]; 2 + usize::from(linear)],
            linear,
        };
        task.declared = true;
        task.free_start = free_start;
        // A joint of velocities says nothing of positions; each scene has one kind.
        if let Some(joints) = bead.declaration().joints {
            let first = if joints.list[0].holonomic {
                0
            } else {
                joints.rows()
            };
            task.joints_at_start = (first..2 * joints.rows()).collect();
        }
    }
    let mut program = transcribe(dcs, tableau, task);
    // A point off every bound and symmetry.
    let mut x = vec![0.0; program.variables()];
    program.initial_point(&mut x);
    for (i, value) in x.iter_mut().enumerate() {
        *value += 0.1 + 0.05 * (i as f64).sin();
    }
    let compared = check_derivatives(&mut program, Some(&x)).expect("finite at the start");
    let without_contacts = bead
        .declaration()
        .contacts
        .iter()
        .all(|contact| contact.dry);
    assert!(compared.len() > if without_contacts { 500 } else { 1000 });
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
            Unknown::NothingUnderRamps,
            Unknown::Everything,
            Unknown::EverythingBetweenNodes,
        ];
        for (bead, unknown) in beads.into_iter().flat_map(|b| unknowns.map(|u| (b, u))) {
            let ramps = matches!(
                unknown,
                Unknown::NothingUnderRamps | Unknown::EverythingBetweenNodes
            );
            if ramps && bead.declaration().joints.is_some() {
                // Joints read no controls.
                continue;
            }
            // Central differences of functions of size 100 with steps of 6e-6.
            let worst = worst_derivative(&tableau, bead, unknown);
            assert!(worst < 1e-6, "{scheme:?}, {unknown:?}: {worst:e}");
        }
    }
}

#[test]
fn laws_add_unknowns_to_the_contacts_that_have_them_only() {
    let tableau = ButcherTableau::new(Scheme::RadauIia, 2).expect("two stages");
    let sizes = |model: &dyn Model| {
        let start = State {
            time: 0.0,
            q: vec![0.2, 0.4],
            v: vec![1.5, -0.7],
        };
        let task = Task::step(&start, &[0.8], 0.25, 3);
        let system = TimeFreezingSystem::new(model, 50.0);
        let program = transcribe(HeavisideSystem::new(system), &tableau, task);
        (program.variables, program.constraints, program.pairs.len())
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
    let start = State {
        time: 0.3,
        q: vec![0.2, 0.4],
        v: vec![1.5, -0.7],
    };
    let task = Task::step(&start, &[0.8], 0.25, 3);
    let system = TimeFreezingSystem::new(&bead, 50.0);
    let mut program = transcribe(HeavisideSystem::new(system), &tableau, task);
    let names: Vec<String> = (0..program.constraints())
        .map(|row| program.constraint_name(row))
        .collect();
    // A position and a velocity at two stages of three elements.
    let count = |start: &str| names.iter().filter(|name| name.starts_with(start)).count();
    assert_eq!(count("joint `wire` at stage"), 6, "{names:?}");
    assert_eq!(count("velocity of joint `wire` at stage"), 6);
    // Of two coordinates, their velocities, the clock and the gap, two components are left to the scheme.
    assert_eq!(count("collocation"), 6 * (6 - 2));
    let mut x = vec![0.0; program.variables()];
    program.initial_point(&mut x);
    let mut values = vec![0.0; program.constraints()];
    program.constraint_values(&x, &mut values);
    // Rows change as the components that they decide: those are the equations themselves, over the entry of these.
    for (row, name) in names.iter().enumerate() {
        let Some(place) = name.strip_prefix("joint `wire` at ") else {
            continue;
        };
        let at = |what: &str| {
            let named = |i: &usize| program.variable_name(*i) == format!("{what} at {place}");
            let found = (0..program.variables()).find(named).expect("a variable");
            x[found]
        };
        let (y, z, t) = (at("y"), at("z"), at("clock"));
        let equation = z + y * z / 4.0 - (1.5 * y).sin() / 1.5 - 0.2 * t;
        let ratio = equation / values[row];
        let (by_y, by_z) = (z / 4.0 - (1.5 * y).cos(), 1.0 + y / 4.0);
        assert!(
            ratio.abs() > 0.3 * by_y.abs().min(by_z) && ratio.abs() < 3.0 * by_y.abs().max(by_z),
            "{name}: {ratio}"
        );
    }
}
