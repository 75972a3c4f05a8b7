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

/// Names of the kernels that a scene has beside those of the minimal one.
fn added_kernels(model: &dyn Model) -> Vec<&'static str> {
    let minimal = Minimal::default();
    let known = minimal.declaration().kernels;
    let own = model.declaration().kernels.iter().map(|k| k.name);
    own.filter(|name| known.iter().all(|known| known.name != *name))
        .collect()
}

const FLIGHT: &str = "simulation, element, free flight";
const HELD: &str = "simulation, element, `floor` holds";
const HELD_FROZEN: &str = "simulation, time-freezing element, `floor` holds";
const COARSE: &str = "optimal control, contact-implicit program";
const FINE: &str = "optimal control, collocation";
const FROZEN: &str = "optimal control, time-freezing program";

/// What a scene has more than the minimal one, in a line each: group by group of every formulation, where a contact may slip or stick
/// instead, and kernels.
fn added(model: &dyn Model) -> String {
    let (less, more) = (sizes(&Minimal::default()), sizes(model));
    let mut told = String::new();
    for (from, to) in [
        (FLIGHT, FLIGHT),
        (HELD, HELD),
        (HELD, "simulation, element, `floor` slips"),
        (HELD, "simulation, element, `floor` sticks"),
        (HELD_FROZEN, HELD_FROZEN),
        (
            HELD_FROZEN,
            "simulation, time-freezing element, `floor` sticks",
        ),
        (COARSE, COARSE),
        (FINE, FINE),
        (FROZEN, FROZEN),
    ] {
        let Some(more) = more.iter().find(|size| size.formulation == to) else {
            continue;
        };
        let less = named(&less, from);
        let mut names: Vec<&str> = more.groups.iter().map(|group| group.name).collect();
        names.extend(less.groups.iter().map(|group| group.name));
        names.sort_unstable();
        names.dedup();
        for name in names {
            let (less, more) = (numbers(less, name), numbers(more, name));
            let added: Numbers = std::array::from_fn(|i| more[i] - less[i]);
            if added != [0; 6] {
                told += &format!("{to}, {name}: {added:?}\n");
            }
        }
    }
    told + &format!("kernels: {:?}\n", added_kernels(model))
}

#[test]
fn what_is_recorded_and_drawn_adds_nothing() {
    let text = |model: &dyn Model| format!("{:?}", sizes(model));
    assert_eq!(text(&Shown::default()), text(&Minimal::default()));
}

/// Variables, equations, inequalities, pairs, nonzeros of Jacobian and Hessian. Six intervals and a switch are seven phases of four stages, 28,
/// all but one of which are in contact; 96 elements of the contact-implicit program, 36 stages of 18 elements of the time-freezing program.
#[test]
fn what_a_declaration_adds_is_its_own_groups_and_nothing_else() {
    let scenes: [(&str, &dyn Model); 10] = [
        ("friction", &Rough::default()),
        ("a control", &Driven::default()),
        ("a second contact", &Walled::default()),
        ("restitution", &Bouncing::default()),
        ("a path constraint", &Limited::default()),
        ("a free velocity at the start", &Thrown::default()),
        ("a free place at the start", &Placed::default()),
        ("a force of time", &Timed::default()),
        ("a free final time with a goal", &Timeless::default()),
        ("a bound of a force", &Pressed::default()),
    ];
    let mut told: String = scenes
        .iter()
        .map(|(name, model)| format!("{name}\n{}", added(*model)))
        .collect();
    told += &format!("impulses\n{}", added(&Struck::default()));
    insta::assert_snapshot!(told);
}

#[test]
fn minimal_scene_takes_nothing_for_what_it_does_not_declare() {
    let minimal = Minimal::default();
    let all = sizes(&minimal);
    let groups = all.iter().flat_map(|size| {
        let groups = size.groups.iter();
        groups.map(|group| {
            format!(
                "{}, {}: {:?}",
                size.formulation,
                group.name,
                numbers(size, group.name)
            )
        })
    });
    insta::assert_snapshot!(groups.collect::<Vec<_>>().join("\n"));
    for kernel in minimal.declaration().kernels {
        let own = ["tangent", "path", "impact"];
        assert!(!own.iter().any(|own| kernel.name.starts_with(own)));
    }
    // In flight there is no force, in contact one a stage and what keeps the gap at zero.
    assert_eq!(named(&all, FLIGHT).size().variables, 6 * 2);
    assert_eq!(named(&all, HELD).size().variables, 6 * (2 + 1 + 1));
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
