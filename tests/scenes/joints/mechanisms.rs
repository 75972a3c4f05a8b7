//! Links: closed loops, and stops that are struck.

use super::{assert_close, last, scene, solved, tight};
use crate::four_bar::{RODS, SIZES};
use hangtime::baselines::{FixedStep, Moreau};
use hangtime::prelude::*;
use hangtime::rk::Scheme;
use hangtime::simulation::StepFormulation;

/// A stop for the crank of a four-bar linkage, and the middle of its rocker.
const SEEN: &str = "
    surface stop: t1 >= 0.2 [rad]
    impact stop: restitution 0.5
    outputs { y3: m = c3.y, z3: m = c3.z }
    horizon 1.5 [s]
";

/// Rods and a loop: the other links follow from the crank.
fn four_bar() -> String {
    format!("{SIZES}{RODS}{SEEN} start {{ t1: 1.2, t2: 0.35, t3: 1.5, dot(t1): -1 }}")
}

/// Elements of other schemes, and in the numerical time of time-freezing, hold joints alike.
#[test]
fn four_bar_moves_alike_by_all_elements() {
    let looped = scene(&four_bar());
    let exact = tight(&looped);
    let formulation = StepFormulation::TimeFreezing;
    let methods = [
        Fesd {
            formulation,
            ..Fesd::default()
        },
        Fesd {
            scheme: Scheme::GaussLegendre,
            ..Fesd::default()
        },
        Fesd {
            stages: Some(2),
            ..Fesd::default()
        },
    ];
    for method in methods {
        let run = solved(simulate(&looped).method(method).run());
        for name in ["t1", "dot(t1)", "y3"] {
            assert_close(last(&run, name), last(&exact, name), 1e-6, name);
        }
        let (t1, t2, t3) = (last(&run, "t1"), last(&run, "t2"), last(&run, "t3"));
        let across = t1.cos() + 2.2 * t2.cos() - 2.0 - 1.8 * t3.cos();
        let up = t1.sin() + 2.2 * t2.sin() - 1.8 * t3.sin();
        assert_close(across.hypot(up), 0.0, 1e-14, "loop");
    }
}

/// Fixed steps of order 4 and Moreau's time stepping of order 2 hold joints at the ends of their steps.
#[test]
fn fixed_steps_close_the_loop_after_each() {
    let text = four_bar().replace("impact stop: restitution 0.5", "impact stop: inelastic");
    let looped = scene(&text.replace("horizon 1.5", "horizon 0.4"));
    let exact = tight(&looped);
    let fixed = |steps| {
        let method = FixedStep::default();
        solved(simulate(&looped).method(method).steps(steps).run())
    };
    let moreau = |steps| {
        let method = Moreau::default();
        solved(simulate(&looped).method(method).steps(steps).run())
    };
    let off = |run: &Simulation| {
        let (t1, t2, t3) = (last(run, "t1"), last(run, "t2"), last(run, "t3"));
        let across = t1.cos() + 2.2 * t2.cos() - 2.0 - 1.8 * t3.cos();
        let up = t1.sin() + 2.2 * t2.sin() - 1.8 * t3.sin();
        assert_close(across.hypot(up), 0.0, 1e-14, "loop");
        (t1 - last(&exact, "t1")).abs()
    };
    let order = |one: f64, half: f64| (one / half).log2();
    let (one, half) = (off(&fixed(20)), off(&fixed(40)));
    println!("fixed steps: {one:e}, {half:e}, order {}", order(one, half));
    assert!(order(one, half) > 3.5, "{one:e}, {half:e}");
    let (one, half) = (off(&moreau(200)), off(&moreau(400)));
    println!("Moreau: {one:e}, {half:e}, order {}", order(one, half));
    assert!(order(one, half) > 1.8, "{one:e}, {half:e}");
}

/// A pin with clearance in its bush, which it strikes and leaves, moves the links as the joint does, up to that clearance.
#[test]
fn loop_with_clearance_tends_to_the_joint() {
    let horizon = "horizon 0.8 [s]";
    let joint = scene(&format!(
        "{SIZES}{RODS} start {{ t1: 1.2, t2: 0.35, t3: 1.5, dot(t1): -1 }} {horizon}"
    ));
    let exact = tight(&joint);
    // The pin begins in the middle of its bush, where the joint has it.
    let begin = ["t1", "t2", "t3"].map(|name| {
        let rate = format!("dot({name})");
        format!(
            "{name}: {:?}, {rate}: {:?}",
            exact[name][0],
            exact[rate.as_str()][0]
        )
    });
    let (links, sides) = RODS.split_once("joint loop: ").expect("a loop");
    let apart = sides.trim().replace(" == ", " - ");
    for play in [1e-3, 1e-4] {
        let bush = scene(&format!(
            "{SIZES}{links} let apart = {apart}
             surface bush: ({play} [m])^2 >= |apart|^2
             impact bush: inelastic
             start {{ {} }} {horizon}",
            begin.join(", ")
        ));
        let loose = tight(&bush);
        assert!(loose.events.len() >= 3, "{}", loose.events.len());
        for name in ["t1", "t2", "t3"] {
            // The worst ratio of a link to the clearance is that of levers: below 4 here.
            assert_close(last(&loose, name), last(&exact, name), 4.0 * play, name);
        }
        if play > 5e-4 {
            let elements = solved(simulate(&bush).run());
            assert_close(last(&elements, "t1"), last(&loose, "t1"), 1e-7, "t1");
        }
    }
}
