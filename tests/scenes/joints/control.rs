//! Optimal control of scenes with joints, against the same in coordinates that need none.
//!
//! Both are collocated alike in as many components of the state, so that optima agree up to the error of the scheme, of the order 7 in
//! intervals, and to rounding where accelerations are constant.

use super::{assert_close, scene, solved};
use crate::four_bar::{CRANK, RODS, SIZES};
use hangtime::ocp::{Problem, Settings, program_sizes};
use hangtime::prelude::*;
use hangtime_scene_files::TextScene;

/// What drives a linkage at its crank.
const DRIVEN: &str = "
    controls { u: N*m }
    forces { t1: u }
    minimize integral(u^2)
    horizon 1 [s]
";

/// A four-bar linkage that is driven at its crank; the loop, and the start of the crank that closes it.
fn four_bar(goals: &str) -> TextScene {
    scene(&format!(
        "{SIZES}{RODS}{DRIVEN} start {{ t1: 1.2, t2: 0.35, t3: 1.5 }} {goals}"
    ))
}

/// The optimum of a scene on that many intervals, which has to be certified.
fn optimum(scene: &TextScene, intervals: usize) -> Solution {
    let solution = solve(scene).intervals(intervals).run();
    let solution = solution.unwrap_or_else(|error| panic!("{error}"));
    assert!(solution.status.is_solved(), "{solution}");
    solution
}

/// The relative difference of two objectives, and the times of their impacts.
#[track_caller]
fn assert_same(own: &Solution, its: &Solution, error: f64) {
    let scale = its.objective.abs();
    assert_close(
        own.objective / scale,
        its.objective / scale,
        error,
        "objective",
    );
    let events = |solution: &Solution| -> Vec<f64> {
        let planned = solution.planned_events.iter();
        planned.map(|event| event.0).collect()
    };
    let (own, its) = (events(own), events(its));
    assert_eq!(own.len(), its.len());
    for (own, its) in own.iter().zip(its) {
        // Flat optima: the times are known to the root of what the objective is.
        assert_close(*own, its, error.sqrt(), "time of an impact");
    }
}

#[test]
fn four_bar_is_driven_with_the_least_effort_of_its_crank() {
    let looped = four_bar("finally { t1 == 2.5, dot(t1) == 0 }");
    let start = solved(simulate(&looped).horizon(0.1).run())["t1"][0];
    let crank = scene(&format!(
        "{SIZES}{CRANK}{DRIVEN} start {{ t1: {start:?} }} finally {{ t1 == 2.5, dot(t1) == 0 }}"
    ));
    let (own, its) = (optimum(&looped, 6), optimum(&crank, 6));
    assert_same(&own, &its, 1e-8);
    let motion = own.motion.as_ref().expect("a motion");
    let note = |note: &String| note.starts_with("the start was completed");
    assert!(motion.notes.iter().any(note), "{:?}", motion.notes);
}

/// Goals that follow from each other and from the joints say nothing new: all links stand still where the crank does.
#[test]
fn goals_that_joints_imply_change_nothing() {
    let goals = "finally { t1 == 2.5, dot(t1) == 0, dot(t2) == 0, dot(t3) == 0 }";
    let once = four_bar("finally { t1 == 2.5, dot(t1) == 0 }");
    let again = four_bar(goals);
    assert_same(&optimum(&again, 4), &optimum(&once, 4), 1e-8);
}

/// A slider-crank that runs into a wall and is turned back.
#[test]
fn slider_crank_is_turned_back_from_a_wall_as_its_angle_is() {
    let common = "parameters { j: kg*m^2 = 0.4, m: kg = 1.2, r: m = 0.5, l: m = 1.3, k: N/m = 5 }
         controls { u: N*m in -20..=20 }
         forces { phi: u }
         surface wall: x <= 1.7 [m]
         impact wall: restitution 0.8
         minimize integral(u^2)
         finally { phi == 1.4, dot(phi) == 0 }
         horizon 0.6 [s]
         lagrangian j/2*dot(phi)^2 + m/2*dot(x)^2 - k/2*(x - 1 [m])^2";
    let arm = "sqrt(l^2 - (r*sin(1.2))^2)";
    let looped = scene(&format!(
        "coordinates {{ phi: rad, x: m }} {common}
         joint rod: |(x - r*cos(phi), r*sin(phi))|^2 == l^2
         start {{ phi: 1.2, x: r*cos(1.2) + {arm}, dot(phi): -4,
                  dot(x): 4 [1/s]*(r*sin(1.2) + r^2*sin(1.2)*cos(1.2)/{arm}) }}"
    ));
    let angle = scene(&format!(
        "coordinates {{ phi: rad }} let x = r*cos(phi) + sqrt(l^2 - (r*sin(phi))^2) {common}
         start {{ phi: 1.2, dot(phi): -4 }}"
    ));
    let (own, its) = (optimum(&looped, 6), optimum(&angle, 6));
    assert!(!its.planned_events.is_empty());
    assert_same(&own, &its, 1e-8);
}

/// A wheel that runs into a wall and has to come back to a `place` \[m\] in a time \[s\]: rolling by a joint, and by its angle alone.
pub(super) fn wheel_against_a_wall(place: f64, time: f64) -> [TextScene; 2] {
    let common = format!(
        "parameters {{ m: kg = 2, r: m = 0.3, j: kg*m^2 = 0.09 }}
         controls {{ u: N*m in -3..=3 }}
         forces {{ phi: u }}
         impact wall: restitution 0.6
         minimize integral(u^2)
         horizon {time} [s]"
    );
    let rolling = scene(&format!(
        "coordinates {{ x: m, phi: rad }} {common}
         lagrangian m/2*dot(x)^2 + j/2*dot(phi)^2
         joint roll: dot(x) == r*dot(phi)
         surface wall: x <= 1 [m]
         start {{ dot(x): 2, dot(phi): 2 [m/s]/r }}
         finally {{ x == {place} [m], dot(x) == 0 }}"
    ));
    let angle = scene(&format!(
        "coordinates {{ phi: rad }} {common}
         lagrangian m/2*(r*dot(phi))^2 + j/2*dot(phi)^2
         surface wall: r*phi <= 1 [m]
         start {{ dot(phi): 2 [m/s]/r }}
         finally {{ r*phi == {place} [m], dot(phi) == 0 }}"
    ));
    [rolling, angle]
}

/// Its spin goes through the impact as the joint has it.
#[test]
fn wheel_that_rolls_by_a_joint_comes_back_from_a_wall_as_its_angle_does() {
    let [rolling, angle] = wheel_against_a_wall(0.5, 1.5);
    let (own, its) = (optimum(&rolling, 5), optimum(&angle, 5));
    assert_eq!(its.planned_events.len(), 1);
    // Accelerations are constant on intervals: the scheme is exact.
    assert_same(&own, &its, 1e-11);
}

/// A knife edge is parked sideways with the least effort: the joint against the velocities of edge and heading as states.
#[test]
fn knife_edge_is_parked_sideways_as_by_its_own_velocities() {
    let edge = scene(
        "parameters { m: kg = 1, j: kg*m^2 = 1 }
         coordinates { x: m, y: m, phi: rad }
         controls { f: N, tau: N*m }
         lagrangian m/2*(dot(x)^2 + dot(y)^2) + j/2*dot(phi)^2
         forces { x: f*cos(phi), y: f*sin(phi), phi: tau }
         joint edge: sin(phi)*dot(x) == cos(phi)*dot(y)
         minimize integral(f^2 + (tau/(1 [m]))^2)
         finally { x == 0, y == 1 [m], phi == 0, dot(x) == 0, dot(phi) == 0 }
         horizon 5 [s]",
    );
    let own = scene(
        "states { x: m, y: m, phi: rad, v: m/s, w: rad/s }
         controls { f: N, tau: N*m }
         rates { x: v*cos(phi), y: v*sin(phi), phi: w, v: f/(1 [kg]), w: tau/(1 [kg*m^2]) }
         minimize integral(f^2 + (tau/(1 [m]))^2)
         finally { x == 0, y == 1 [m], phi == 0, v == 0, w == 0 }
         horizon 5 [s]",
    );
    let (edge, own) = (optimum(&edge, 4), optimum(&own, 4));
    // Rotations of more than a radian in four elements of order 7.
    assert_same(&edge, &own, 1e-6);
}

/// The length of a rod is found at which its mass swings over in a second; the start follows it.
#[test]
fn length_in_a_joint_is_found_as_that_of_a_pendulum() {
    let common = "parameters { m: kg = 2, g: m/s^2 = 9.81 }
         free l: m in 0.6..=3 = 1.2
         minimize l
         horizon 1 [s]";
    let rod = format!(
        "{common} coordinates {{ x: m, z: m }}
         lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
         joint rod: x^2 + z^2 == l^2
         start {{ x: 0.5, z: -sqrt(l^2 - 0.25 [m^2]) }}
         finally {{ dot(x) == 0 }}"
    );
    let angle = scene(&format!(
        "{common} coordinates {{ phi: rad }}
         lagrangian m/2*l^2*dot(phi)^2 + m*g*l*cos(phi)
         start {{ phi: asin(0.5 [m]/l) }}
         finally {{ dot(phi) == 0 }}"
    ));
    assert_same(&optimum(&scene(&rod), 6), &optimum(&angle, 6), 1e-7);
    // A start that is given decides the length, which is not what is asked for.
    let text = rod.replace("z: -sqrt(l^2 - 0.25 [m^2])", "z: -1");
    let refused = solve(&scene(&text)).run().expect_err("a given start");
    let words = "the start, which fulfils joint `rod` at one value of `l` alone";
    assert!(refused.to_string().contains(words), "{refused}");
}

/// Where the start is free it is one in which the joints hold.
#[test]
fn free_start_of_a_rod_is_that_of_its_angle() {
    let common = "parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
         controls { u: N in -20..=20 }
         minimize integral(u^2)
         horizon 1.1 [s]";
    let rod = scene(&format!(
        "{common} coordinates {{ x: m, z: m }}
         lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
         forces {{ x: u }}
         joint rod: x^2 + z^2 == l^2
         start {{ x: 0.9, z: -1.3 }}
         free {{ x in 0..=1.4 [m], z }}
         finally {{ x == -1.2 [m], dot(x) == 0 }}"
    ));
    let angle = scene(&format!(
        "{common} coordinates {{ phi: rad }}
         lagrangian m/2*l^2*dot(phi)^2 + m*g*l*cos(phi)
         forces {{ phi: u*l*cos(phi) }}
         start {{ phi: 0.65 }}
         free {{ phi in 0..=1.2 [rad] }}
         finally {{ l*sin(phi) == -1.2 [m], dot(phi) == 0 }}"
    ));
    // Cartesian coordinates of a circle have an error of their own: 2e-6 on five intervals, 27 times less on eight.
    assert_same(&optimum(&rod, 8), &optimum(&angle, 8), 1e-6);
}

/// The force of a joint in an objective and in a constraint: that of the angle is `m l w^2 + m g cos(phi) + u sin(phi)`.
#[test]
fn tension_of_a_rod_costs_and_is_limited_as_that_of_its_angle() {
    let common = "parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
         controls { u: N in -20..=20 }
         horizon 1.1 [s]";
    let task = "minimize integral(tension^2) constraint strong: tension <= 30 [N]";
    let rod = task.replace("tension", "(-2*l*force(rod))");
    let rod = scene(&format!(
        "{common} coordinates {{ x: m, z: m }}
         lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
         forces {{ x: u }}
         joint rod: x^2 + z^2 == l^2
         start {{ x: 0.9, z: -1.2 }}
         {rod}
         finally {{ x == -0.9 [m], dot(x) == 0 }}"
    ));
    let angle = scene(&format!(
        "{common} coordinates {{ phi: rad }}
         let tension = m*l*dot(phi)^2 + m*g*cos(phi) + u*sin(phi)
         lagrangian m/2*l^2*dot(phi)^2 + m*g*l*cos(phi)
         forces {{ phi: u*l*cos(phi) }}
         start {{ phi: asin(0.6) }}
         {task}
         finally {{ l*sin(phi) == -0.9 [m], dot(phi) == 0 }}"
    ));
    assert_same(&optimum(&rod, 8), &optimum(&angle, 8), 1e-6);
}

/// Rows of joints stand in the place of as many collocation equations.
#[test]
fn joints_add_neither_unknowns_nor_equations_to_a_program() -> Result<(), InputError> {
    let common = "parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
         coordinates { x: m, z: m }
         controls { u: N }
         lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
         forces { x: u }
         start { x: 0.9, z: -1.2 }
         minimize integral(u^2)
         finally { x == -0.9 [m] }
         horizon 1 [s]";
    let sizes = |joint: &str| {
        let scene = scene(&format!("{common} {joint}"));
        let sizes = program_sizes(&scene, &Problem::of(&scene, 3), &Settings::default())?;
        Ok::<_, InputError>(sizes[1].clone())
    };
    let (free, held) = (sizes("")?, sizes("joint rod: x^2 + z^2 == l^2")?);
    assert_eq!(held.size().variables, free.size().variables);
    assert_eq!(held.size().equalities, free.size().equalities);
    let joints = held.groups.iter().find(|group| group.name == "joints");
    // A position and a velocity at four stages of three intervals.
    assert_eq!(joints.map(|group| group.size.equalities), Some(2 * 4 * 3));
    assert!(free.groups.iter().all(|group| group.name != "joints"));
    Ok(())
}
