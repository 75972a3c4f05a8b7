//! What a scene does not declare takes nothing, in any formulation.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use crate::support::{one_start, solve};
use hangtime::model::Model;
use hangtime::ocp::{Formulation, Problem, Settings, TimeFreezingSettings, program_size};
use hangtime::simulation::{
    Fesd, FormulationSize, InitialValueProblem, StepFormulation, step_sizes,
};

/// Scenes that differ in one line each.
macro_rules! scene {
    ($name:ident; $($more:tt)*) => {
        hangtime::model! {
            /// A mass that falls on a floor.
            $name {
                parameters { m: kg = 2, g: m/s^2 = 9.81 }
                coordinates { y: m, z: m }
                lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
                surface floor: z >= 0
                start { z: 0.2 [m], dot(y): 1 [m/s] }
                horizon 1 [s]
                $($more)*
            }
        }
    };
}

scene! { Minimal;
    impact floor: inelastic
    minimize y
}
scene! { Rough;
    impact floor: inelastic, friction 0.1
    minimize y
}
scene! { Driven;
    controls { u: N in -1..=1 }
    forces { y: u }
    impact floor: inelastic
    minimize y
}
scene! { Walled;
    surface wall: y <= 9[m]
    impact floor, wall: inelastic
    minimize y
}
scene! { Bouncing;
    impact floor: restitution 0.5
    minimize y
}
scene! { Limited;
    impact floor: inelastic
    minimize y
    constraint pace: dot(y) <= 2[m/s]
}
scene! { Thrown;
    impact floor: inelastic
    minimize y
    free { dot(y) in 0..=2 }
}
scene! { Placed;
    impact floor: inelastic
    minimize y
    free { z in 0.1..=0.3 }
}
scene! { Timed;
    forces { y: 1[N/s]*t }
    impact floor: inelastic
    minimize y
}
scene! { Timeless;
    impact floor: inelastic
    minimize time
    finally { y == 1[m] }
}
scene! { Pressed;
    impact floor: inelastic
    minimize y
    constraint strong: force(floor) <= 99[N]
}
scene! { Struck;
    impact floor: inelastic
    minimize y + sum(impulse(floor)^2)*1[m/kg/J]
    constraint soft: impulse(floor) <= 9[N s]
}

scene! { Shown;
    impact floor: inelastic
    minimize y
    outputs { push: N = force(floor), elapsed: s = t, speed: m/s = |dot((y, z))| }
    picture { point mass at (y, z), link mass to (t*1[m/s], 0) }
}

const INTERVALS: usize = 6;

/// Every formulation.
fn sizes(model: &dyn Model) -> Vec<FormulationSize> {
    let problem = InitialValueProblem::of(model, None).unwrap();
    let frozen = StepFormulation::TimeFreezing;
    let mut all = step_sizes(model, &problem, &Fesd::default()).unwrap();
    let method = Fesd::default().with_formulation(frozen);
    all.extend(step_sizes(model, &problem, &method).unwrap());
    let time_freezing = Formulation::TimeFreezing(TimeFreezingSettings::default());
    for formulation in [Formulation::Phases, time_freezing] {
        let mut settings = Settings::default();
        settings.formulation = formulation;
        all.push(program_size(model, &Problem::of(model, INTERVALS), &settings).unwrap());
    }
    all
}

/// A line for each formulation: variables, equations, inequalities, pairs, nonzeros of Jacobian and Hessian.
fn table(model: &dyn Model) -> String {
    let lines = sizes(model).into_iter().map(|known| {
        let size = known.size;
        let numbers = [
            size.variables,
            size.equalities,
            size.inequalities,
            size.complementarities,
            size.jacobian_nonzeros,
            size.hessian_nonzeros,
        ];
        format!("{}: {numbers:?}\n", known.formulation)
    });
    lines.collect()
}

/// The lines and kernels of a scene that the minimal one does not have.
fn added(model: &dyn Model) -> String {
    let minimal = Minimal::default();
    let (less, more) = (table(&minimal), table(model));
    let known = minimal.declaration().kernels;
    let own = model.declaration().kernels.iter().map(|kernel| kernel.name);
    let kernels: Vec<&str> = own
        .filter(|name| known.iter().all(|known| known.name != *name))
        .collect();
    let lines = more.lines().filter(|line| !less.contains(line));
    let lines: Vec<&str> = lines.collect();
    format!("{}\nkernels: {kernels:?}\n", lines.join("\n"))
}

#[test]
fn what_is_recorded_and_drawn_adds_nothing() {
    assert_eq!(table(&Shown::default()), table(&Minimal::default()));
}

/// Six intervals and a switch are seven phases of four stages, 28, all but one of which are in contact; 36 stages of 18 elements of the
/// time-freezing program. What is not told of a scene is as in the minimal one.
#[test]
fn only_what_is_declared_adds_to_the_assembled_systems() {
    let scenes: [(&str, &dyn Model); 11] = [
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
        ("impulses", &Struck::default()),
    ];
    let mut told = format!("nothing\n{}", table(&Minimal::default()));
    for (name, model) in scenes {
        told += &format!("{name}\n{}", added(model));
    }
    insta::assert_snapshot!(told);
    for kernel in Minimal::default().declaration().kernels {
        let own = ["tangent", "path", "impact"];
        assert!(!own.iter().any(|own| kernel.name.starts_with(own)));
    }
}

/// A hop from a floor and back to it.
macro_rules! hop {
    ($name:ident; $($impact:tt)*) => {
        hangtime::model! {
            /// A hop from a floor.
            $name {
                parameters { m: kg = 1, g: m/s^2 = 10, d: m = 0.5 }
                coordinates { y: m, z: m }
                controls { u: N in -10..=10, p: N in 0..=30 }
                lagrangian m/2*(dot(y)^2 + dot(z)^2) - m*g*z
                forces { y: u, z: p }
                surface floor: z >= 0
                $($impact)*
                minimize integral(u^2 + p^2)
                finally { y == d, dot(y) == 0 }
                horizon 1 [s]
                start { z: 0.3 [m] }
            }
        }
    };
}

hop! { Hop; parameters { mu = 0 } impact floor: inelastic, friction mu }
hop! { SmoothHop; impact floor: inelastic }

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
    let variables = |model: &dyn Model| {
        let own = program_size(model, &Problem::of(model, 4), &one_start());
        own.unwrap().size.variables
    };
    assert!(variables(&Rail::default()) < variables(&Block::default()));
}
