//! What a scene does not declare takes nothing, in any formulation.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{one_start, solve};
use hangtime::model::Model;
use hangtime::ocp::{Formulation, Problem, Settings, TimeFreezingSettings, program_sizes};
use hangtime::simulation::{
    Fesd, FormulationSize, InitialValueProblem, InputError, StepFormulation, step_sizes,
};

/// Scenes that differ in one line each.
macro_rules! scene {
    ($name:ident; $($more:tt)*) => {
        hangtime::model! {
            /// A mass that falls on a floor.
            $name {
                parameters { m: kg = 2, g: m/s^2 = 9.81 }
                coordinates { y: m, z: m }
                surface floor: z >= 0
                start { z: 0.2 [m], dot(y): 1 [m/s] }
                $($more)*
            }
        }
    };
}

scene! { Minimal;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    impact floor: inelastic
    minimize y
    horizon 1 [s]
}
scene! { Rough;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    impact floor: inelastic, friction 0.1
    minimize y
    horizon 1 [s]
}
scene! { Driven;
    controls { u: N in -1..=1 }
    forces { y: u }
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    impact floor: inelastic
    minimize y
    horizon 1 [s]
}
scene! { Walled;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    surface wall: y <= 9[m]
    impact floor, wall: inelastic
    minimize y
    horizon 1 [s]
}
scene! { Bouncing;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    impact floor: restitution 0.5
    minimize y
    horizon 1 [s]
}
scene! { Limited;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    impact floor: inelastic
    minimize y
    constraint pace: dot(y) <= 2[m/s]
    horizon 1 [s]
}
scene! { Thrown;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    impact floor: inelastic
    minimize y
    free { dot(y) in 0..=2 }
    horizon 1 [s]
}
scene! { Placed;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    impact floor: inelastic
    minimize y
    free { z in 0.1..=0.3 }
    horizon 1 [s]
}
scene! { Timed;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    forces { y: 1[N/s]*t }
    impact floor: inelastic
    minimize y
    horizon 1 [s]
}
scene! { Timeless;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    impact floor: inelastic
    minimize time
    finally { y == 1[m] }
    horizon 1 [s]
}
scene! { Pressed;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    impact floor: inelastic
    minimize y
    constraint strong: force(floor) <= 99[N]
    horizon 1 [s]
}
scene! { Struck;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    impact floor: inelastic
    minimize y + sum(impulse(floor)^2)*1[m/kg/J]
    constraint soft: impulse(floor) <= 9[N s]
    horizon 1 [s]
}

scene! { Shown;
    lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
    impact floor: inelastic
    minimize y
    horizon 1 [s]
    outputs { push: N = force(floor), elapsed: s = t, speed: m/s = |dot((y, z))| }
    picture { point mass at (y, z), link mass to (t*1[m/s], 0) }
}

const INTERVALS: usize = 6;

// Names of groups.
const CLOCK: &str = "clock";
const CONTACT_FORCE: &str = "contact force";
const CONTROL: &str = "controls";
const CROSS_COMPLEMENTARITY: &str = "cross complementarity";
const ELEMENT_LENGTH: &str = "element lengths";
const EXPLICIT_TIME: &str = "explicit time";
const FINAL_TIME: &str = "free final time";
const FREE_START: &str = "free start";
const FRICTION: &str = "friction";
const GAP: &str = "gap";
const GOAL: &str = "goals";
const FORCES: &str = "declared forces";
const PATH_CONSTRAINT: &str = "path constraints";
const RESTITUTION: &str = "restitution";
const SEVERAL_CONTACTS: &str = "several contacts";
const STEP_FUNCTION: &str = "step functions";

fn simulated(model: &dyn Model, formulation: StepFormulation) -> Vec<FormulationSize> {
    let problem = InitialValueProblem::of(model, None).unwrap();
    let method = Fesd::default().with_formulation(formulation);
    step_sizes(model, &problem, &method).unwrap()
}

fn programs(
    model: &dyn Model,
    formulation: Formulation,
) -> Result<Vec<FormulationSize>, InputError> {
    let mut settings = Settings::default();
    settings.formulation = formulation;
    program_sizes(model, &Problem::of(model, INTERVALS), &settings)
}

/// Every formulation.
fn sizes(model: &dyn Model) -> Vec<FormulationSize> {
    let mut all = simulated(model, StepFormulation::ActiveSet);
    all.extend(simulated(model, StepFormulation::TimeFreezing));
    all.extend(programs(model, Formulation::Phases).unwrap());
    let time_freezing = Formulation::TimeFreezing(TimeFreezingSettings::default());
    all.extend(programs(model, time_freezing).unwrap());
    all
}

/// Numbers of a group: variables, equations, inequalities, pairs, nonzeros of Jacobian and Hessian.
type Numbers = [isize; 6];

fn numbers(size: &FormulationSize, name: &str) -> Numbers {
    let group = size.groups.iter().find(|group| group.name == name);
    let Some(group) = group.map(|group| group.size) else {
        return [0; 6];
    };
    [
        group.variables,
        group.equalities,
        group.inequalities,
        group.complementarities,
        group.jacobian_nonzeros,
        group.hessian_nonzeros,
    ]
    .map(|number| isize::try_from(number).unwrap())
}

fn named<'s>(sizes: &'s [FormulationSize], name: &str) -> &'s FormulationSize {
    let found = sizes.iter().find(|size| size.formulation == name);
    found.unwrap_or_else(|| panic!("no {name}"))
}

/// What the formulation `to` of a scene has more than the formulation `from` of the minimal one, group by group.
fn added(model: &dyn Model, from: &str, to: &str) -> Vec<(&'static str, Numbers)> {
    let (less, more) = (sizes(&Minimal::default()), sizes(model));
    let (less, more) = (named(&less, from), named(&more, to));
    let names = |size: &FormulationSize| -> Vec<&'static str> {
        size.groups.iter().map(|group| group.name).collect()
    };
    let mut all = names(more);
    all.extend(
        names(less)
            .iter()
            .filter(|name| !names(more).contains(name)),
    );
    let differences = all.into_iter().map(|name| {
        let (less, more) = (numbers(less, name), numbers(more, name));
        (name, std::array::from_fn(|i| more[i] - less[i]))
    });
    differences.filter(|(_, more)| *more != [0; 6]).collect()
}

/// Names of the kernels that a scene has beside those of the minimal one.
fn added_kernels(model: &dyn Model) -> Vec<&'static str> {
    let minimal = Minimal::default();
    let known: Vec<&str> = minimal
        .declaration()
        .kernels
        .iter()
        .map(|k| k.name)
        .collect();
    let own = model.declaration().kernels.iter().map(|k| k.name);
    own.filter(|name| !known.contains(name)).collect()
}

const FLIGHT: &str = "simulation, element, free flight";
const HELD: &str = "simulation, element, `floor` holds";
const HELD_FROZEN: &str = "simulation, time-freezing element, `floor` holds";
const COARSE: &str = "optimal control, contact-implicit program";
const FINE: &str = "optimal control, collocation";
const FROZEN: &str = "optimal control, time-freezing program";
const ALL: [&str; 6] = [FLIGHT, HELD, HELD_FROZEN, COARSE, FINE, FROZEN];

/// Groups that every scene with contacts may have.
const COMMON: [&str; 9] = [
    "state",
    CLOCK,
    ELEMENT_LENGTH,
    CONTACT_FORCE,
    GAP,
    STEP_FUNCTION,
    CROSS_COMPLEMENTARITY,
    "switch times",
    "impacts",
];

#[test]
fn what_is_recorded_and_drawn_adds_nothing() {
    let text = |model: &dyn Model| format!("{:?}", sizes(model));
    assert_eq!(text(&Shown::default()), text(&Minimal::default()));
}

#[test]
fn force_adds_a_variable_and_an_equation_at_each_stage_of_its_contact() {
    let pressed = Pressed::default();
    assert_eq!(added(&pressed, HELD, HELD), []);
    // Six intervals and a switch: seven phases of four stages and a start each, of which all but the first are in contact.
    let more = [
        (PATH_CONSTRAINT, [0, 0, 35, 0, 0, 0]),
        (FORCES, [25, 25, 0, 0, 94, 4]),
    ];
    assert_eq!(added(&pressed, FINE, FINE), more);
    assert_eq!(added(&pressed, COARSE, COARSE), []);
    let kernels = ["path_functions", "path_jacobian", "path_hessian"];
    assert_eq!(added_kernels(&pressed), kernels);
    // The program of the time-freezing system leaves forces out, and conditions on them.
    assert_eq!(added(&pressed, FROZEN, FROZEN), []);
}

#[test]
fn impulses_add_a_sum_and_a_condition_an_impact() {
    let struck = Struck::default();
    let more = [
        ("impacts", [0, 0, 0, 0, 0, 1]),
        (PATH_CONSTRAINT, [0, 0, 1, 0, 1, 0]),
        (FORCES, [1, 1, 0, 0, 2, 0]),
    ];
    assert_eq!(added(&struck, FINE, FINE), more);
    assert_eq!(added(&struck, COARSE, COARSE), []);
    let kernels = ["impact_functions", "impact_jacobian", "impact_hessian"];
    assert_eq!(added_kernels(&struck), kernels);
}

#[test]
fn minimal_scene_takes_nothing_for_what_it_does_not_declare() {
    let minimal = Minimal::default();
    let all = sizes(&minimal);
    for name in ALL {
        named(&all, name);
    }
    for size in &all {
        for group in &size.groups {
            assert!(
                COMMON.contains(&group.name),
                "{}: {group:?}",
                size.formulation
            );
        }
    }
    for kernel in minimal.declaration().kernels {
        let own = ["tangent", "path", "impact"]
            .iter()
            .any(|other| kernel.name.starts_with(other));
        assert!(!own, "{}", kernel.name);
    }
    // In flight there is no force, in contact one a stage and what keeps the gap at zero.
    assert_eq!(named(&all, FLIGHT).size().variables, 6 * 2);
    assert_eq!(named(&all, HELD).size().variables, 6 * (2 + 1 + 1));
}

#[test]
fn friction_adds_its_own_groups_and_nothing_else() {
    let rough = Rough::default();
    assert_eq!(added(&rough, FLIGHT, FLIGHT), []);
    // Slip turns the direction of the force, and adds the sign of the sliding velocity at six stages.
    let slips = "simulation, element, `floor` slips";
    let more = [
        (CONTACT_FORCE, [0, 0, 0, 0, 6, 0]),
        (FRICTION, [0, 0, 6, 0, 0, 0]),
    ];
    assert_eq!(added(&rough, HELD, slips), more);
    let sticks = "simulation, element, `floor` sticks";
    assert_eq!(
        added(&rough, HELD, sticks),
        [(FRICTION, [6, 6, 6, 0, 42, 0])]
    );
    let sticks = "simulation, time-freezing element, `floor` sticks";
    assert_eq!(
        added(&rough, HELD_FROZEN, sticks),
        [(FRICTION, [6, 6, 6, 0, 78, 0])]
    );
    // Four variables, two equations and two pairs in each of 96 elements.
    assert_eq!(
        added(&rough, COARSE, COARSE),
        [(FRICTION, [384, 192, 0, 192, 960, 0])]
    );
    // The contact slips at all of its 20 stages.
    assert_eq!(
        added(&rough, FINE, FINE),
        [(FRICTION, [0, 0, 21, 0, 21, 0])]
    );
    assert_eq!(
        added(&rough, FROZEN, FROZEN),
        [(FRICTION, [216, 144, 0, 72, 754, 144])]
    );
    let kernels = [
        "tangent_floor",
        "tangent_jacobian_floor",
        "tangent_hessian_floor",
    ];
    assert_eq!(added_kernels(&rough), kernels);
}

#[test]
fn control_adds_one_variable_an_interval_and_no_equation() {
    let driven = Driven::default();
    for name in [FLIGHT, HELD, HELD_FROZEN] {
        assert_eq!(added(&driven, name, name), [], "{name}");
    }
    assert_eq!(
        added(&driven, COARSE, COARSE),
        [(CONTROL, [6, 0, 0, 0, 96, 0])]
    );
    assert_eq!(added(&driven, FINE, FINE), [(CONTROL, [6, 0, 0, 0, 28, 2])]);
    assert_eq!(
        added(&driven, FROZEN, FROZEN),
        [(CONTROL, [6, 0, 0, 0, 36, 60])]
    );
    assert_eq!(added_kernels(&driven), Vec::<&str>::new());
}

#[test]
fn second_contact_adds_what_the_first_one_takes_and_products_of_step_functions() {
    let walled = Walled::default();
    // Its gap is watched.
    for name in [FLIGHT, HELD, HELD_FROZEN] {
        assert_eq!(
            added(&walled, name, name),
            [(GAP, [0, 0, 6, 0, 0, 0])],
            "{name}"
        );
    }
    let more = [
        (CONTACT_FORCE, [96, 0, 0, 0, 192, 0]),
        (GAP, [96, 96, 0, 96, 192, 0]),
    ];
    assert_eq!(added(&walled, COARSE, COARSE), more);
    // Its gap at 28 stages.
    assert_eq!(added(&walled, FINE, FINE), [(GAP, [0, 0, 28, 0, 28, 0])]);
    // Where step functions appear in products, their entries belong to those.
    let more = [
        (GAP, [36, 36, 0, 0, 214, 0]),
        (STEP_FUNCTION, [216, 108, 0, 36, 72, -36]),
        (CROSS_COMPLEMENTARITY, [72, 72, 0, 36, 250, 0]),
        (SEVERAL_CONTACTS, [36, 36, 0, 0, 612, 144]),
    ];
    assert_eq!(added(&walled, FROZEN, FROZEN), more);
    assert!(
        added_kernels(&walled)
            .iter()
            .all(|name| name.ends_with("_wall"))
    );
}

#[test]
fn restitution_adds_variables_to_the_programs_of_time_freezing_only() {
    let bouncing = Bouncing::default();
    for name in [FLIGHT, HELD, HELD_FROZEN, COARSE] {
        assert_eq!(added(&bouncing, name, name), [], "{name}");
    }
    let all = sizes(&bouncing);
    // Each bounce is a phase and an impact of its own; the impact map takes no row more for it.
    assert_eq!(numbers(named(&all, FINE), RESTITUTION), [0; 6]);
    // Two variables and a row in each of 2 x 24 stages, four sums and two pairs in each of 24 elements: four an interval.
    let frozen = numbers(named(&all, FROZEN), RESTITUTION);
    assert_eq!(frozen, [192, 144, 0, 48, 862, 192]);
    assert_eq!(added_kernels(&bouncing), Vec::<&str>::new());
}

#[test]
fn explicit_time_adds_a_variable_where_no_clock_is_known() {
    let timed = Timed::default();
    assert_eq!(added(&timed, FLIGHT, FLIGHT), []);
    assert_eq!(added(&timed, HELD, HELD), []);
    // Contacts slow the clock, which the force reads, but at the end, where sums vanish up to rounding; the others have the clock anyway.
    let more = added(&timed, HELD_FROZEN, HELD_FROZEN);
    assert!(
        matches!(more[..], [(CONTACT_FORCE, [0, 0, 0, 0, 30..=36, 0])]),
        "{more:?}"
    );
    let more = [
        (CLOCK, [0, 0, 0, 0, 72, 36]),
        (ELEMENT_LENGTH, [0, 0, 0, 0, 0, 36]),
        (STEP_FUNCTION, [0, 0, 0, 0, 0, 36]),
    ];
    assert_eq!(added(&timed, FROZEN, FROZEN), more);
    assert_eq!(
        added(&timed, COARSE, COARSE),
        [(EXPLICIT_TIME, [96, 96, 0, 0, 192, 0])]
    );
    assert_eq!(
        added(&timed, FINE, FINE),
        [(EXPLICIT_TIME, [28, 28, 0, 0, 68, 8])]
    );
    assert_eq!(added_kernels(&timed), Vec::<&str>::new());
}

#[test]
fn path_constraints_and_free_starts_add_their_own_groups_to_time_freezing() {
    // A row that reads one variable at each of 36 stages.
    assert_eq!(
        added(&Limited::default(), FROZEN, FROZEN),
        [(PATH_CONSTRAINT, [0, 0, 36, 0, 36, 0])]
    );
    // The velocity, four parts of the switching functions in two rows with 2 + 3 entries, and a pair; the first element reads
    // the velocity at two stages, and two of the parts in its sums.
    assert_eq!(
        added(&Thrown::default(), FROZEN, FROZEN),
        [(FREE_START, [5, 2, 0, 1, 9, 0])]
    );
    // The lifted gap as well, in both rows, in one that says what it is, and at two stages.
    assert_eq!(
        added(&Placed::default(), FROZEN, FROZEN),
        [(FREE_START, [6, 3, 0, 1, 15, 0])]
    );
}

#[test]
fn free_final_time_adds_one_variable() {
    let timeless = Timeless::default();
    for name in [FLIGHT, HELD, HELD_FROZEN] {
        assert_eq!(added(&timeless, name, name), [], "{name}");
    }
    let goal = (GOAL, [0, 1, 0, 0, 1, 0]);
    assert_eq!(
        added(&timeless, COARSE, COARSE),
        [goal, (FINAL_TIME, [1, 0, 0, 0, 384, 288])]
    );
    assert_eq!(
        added(&timeless, FINE, FINE),
        [goal, (FINAL_TIME, [1, 0, 0, 0, 81, 40])]
    );
    assert_eq!(
        added(&timeless, FROZEN, FROZEN),
        [goal, (FINAL_TIME, [1, 0, 0, 0, 6, 0])]
    );
    assert_eq!(added_kernels(&timeless), Vec::<&str>::new());
}

hangtime::model! {
    /// A hop from a floor and back to it; the floor may have friction.
    Hop {
        parameters { m: kg = 1, g: m/s^2 = 10, mu = 0, d: m = 0.5 }
        coordinates { y: m, z: m }
        controls { u: N in -10..=10, p: N in 0..=30 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u, z: p }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize integral(u^2 + p^2)
        finally { y == d, dot(y) == 0 }
        horizon 1 [s]
        start { z: 0.3 [m] }
    }
}

hangtime::model! {
    /// The same without a word of friction.
    SmoothHop {
        parameters { m: kg = 1, g: m/s^2 = 10, d: m = 0.5 }
        coordinates { y: m, z: m }
        controls { u: N in -10..=10, p: N in 0..=30 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u, z: p }
        surface floor: z >= 0
        impact floor: inelastic
        minimize integral(u^2 + p^2)
        finally { y == d, dot(y) == 0 }
        horizon 1 [s]
        start { z: 0.3 [m] }
    }
}

#[test]
fn friction_of_zero_is_no_friction_and_costs_nothing() {
    let zero = solve(&Hop::default(), 4, &one_start());
    let none = solve(&SmoothHop::default(), 4, &one_start());
    assert_eq!(zero.size, none.size);
    assert_eq!(zero.planned_events, none.planned_events);
    assert_eq!(zero.counts, none.counts);
    assert_eq!(zero.objective, none.objective);
}

hangtime::model! {
    /// A mass that is pushed along a dry rail with little effort.
    Rail {
        parameters { m: kg = 2, f: N = 5, d: m = 1, length: s = 1.2 }
        coordinates { y: m }
        controls { u: N in -30..=30 }
        lagrangian m/2*dot(y)^2
        forces { y: u }
        dry friction rail: bound f, sliding dot(y)
        minimize integral(u^2)
        finally { y == d, dot(y) == 0 }
        horizon length
    }
}

hangtime::model! {
    /// The same as a block on a rough floor, of which `m g mu` is the bound.
    Block {
        parameters { m: kg = 2, g: m/s^2 = 10, mu = 0.25, d: m = 1, length: s = 1.2 }
        coordinates { y: m, z: m }
        controls { u: N in -30..=30 }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
        forces { y: u }
        surface floor: z >= 0
        impact floor: inelastic, friction mu
        minimize integral(u^2)
        finally { y == d, dot(y) == 0 }
        horizon length
    }
}

#[test]
fn rail_has_neither_height_nor_gap() {
    let sizes = |model: &dyn Model| {
        let problem = Problem::of(model, 4);
        let sizes = program_sizes(model, &problem, &one_start()).unwrap();
        sizes
            .iter()
            .map(|size| {
                let all = size.groups.iter();
                all.map(|group| group.size.variables).sum::<usize>()
            })
            .collect::<Vec<_>>()
    };
    let (rail, block) = (sizes(&Rail::default()), sizes(&Block::default()));
    assert!(!rail.is_empty() && rail.iter().zip(&block).all(|(own, its)| own < its));
    let gaps = program_sizes(
        &Rail::default(),
        &Problem::of(&Rail::default(), 4),
        &one_start(),
    );
    for size in gaps.unwrap() {
        let gap = size.groups.iter().find(|group| group.name == "gap");
        assert!(gap.is_none(), "{}", size.formulation);
    }
}
