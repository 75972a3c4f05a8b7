//! Links: closed loops, and stops that are struck.

use super::{assert_close, both, last, scene, solved, tight};
use crate::four_bar::{CRANK, RODS, SIZES};
use hangtime::baselines::{FixedStep, Moreau};
use hangtime::prelude::*;
use hangtime::rk::Scheme;
use hangtime::simulation::{InitialValueProblem, Simulator, StepFormulation};

/// A point mass on a rod, with the force in it.
const ROD: &str = "
    parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
    coordinates { x: m, z: m }
    lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
    joint rod: x^2 + z^2 == l^2
    outputs { tension: N = -2*l*force(rod) }
    start { x: 1.2, z: -0.9 }
    horizon 5 [s]
";

const ANGLE: &str = "
    parameters { m: kg = 2, g: m/s^2 = 9.81, l: m = 1.5 }
    coordinates { phi: rad }
    let p = (l*sin(phi), -l*cos(phi))
    lagrangian m/2*|dot(p)|^2 - m*g*p.z
    outputs { x: m = p.y, z: m = p.z, vx: m/s = dot(p).y, tension: N = m*g*cos(phi) + m*l*dot(phi)^2 }
    start { phi: 0.9272952180016122 }
    horizon 5 [s]
";

#[test]
fn point_on_a_rod_moves_as_its_angle_does() {
    let exact = tight(&scene(ANGLE));
    for run in both(&scene(ROD)) {
        for (own, its) in [
            ("x", "x"),
            ("z", "z"),
            ("dot(x)", "vx"),
            ("tension", "tension"),
        ] {
            assert_close(last(&run, own), last(&exact, its), 1e-8, own);
        }
        let (x, z) = (last(&run, "x"), last(&run, "z"));
        let (vx, vz) = (last(&run, "dot(x)"), last(&run, "dot(z)"));
        assert_close(x.hypot(z), 1.5, 1e-15 * 4.0, "length of the rod");
        assert_close(x * vx + z * vz, 0.0, 1e-14, "its rate");
    }
}

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

/// The same by the angle of the crank.
fn crank() -> String {
    format!("{SIZES}{CRANK}{SEEN} start {{ t1: 1.2, dot(t1): -1 }}")
}

#[test]
fn four_bar_as_joint_is_its_closed_form_also_where_its_crank_strikes_a_stop() {
    // The start of the loop is completed; that of the closed form is what came out.
    let looped = scene(&four_bar());
    let start = solved(simulate(&looped).run());
    let begin = |name: &str| start[name][0];
    assert!(
        start
            .notes
            .iter()
            .any(|note| note.starts_with("the start was completed"))
    );
    let exact = simulate(&scene(&crank()))
        .start("t1", begin("t1"))
        .start("dot(t1)", begin("dot(t1)"))
        .method(EventDriven::default())
        .tolerance(1e-13)
        .run();
    let exact = solved(exact);
    let struck = exact.events.len();
    assert!(struck >= 2, "{struck} impacts");
    for run in both(&looped) {
        assert_eq!(run.events.len(), struck);
        for (own, its) in run.events.iter().zip(&exact.events) {
            assert_close(own.time, its.time, 1e-9, "time of the impact");
            assert_close(own.v_after[0], its.v_after[0], 1e-9, "velocity after it");
        }
        for name in ["t1", "dot(t1)", "y3", "z3"] {
            assert_close(last(&run, name), last(&exact, name), 2e-9, name);
        }
        println!(
            "residual {:e}, {} elements",
            run.residuals.primal, run.counts.elements
        );
    }
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

/// A slider-crank: the slider strikes a wall. Bodies are points and a crank.
#[test]
fn slider_crank_as_joint_is_its_closed_form_also_where_the_slider_is_struck() {
    let looped = scene(
        "parameters { j: kg*m^2 = 0.4, m: kg = 1.2, r: m = 0.5, l: m = 1.3, k: N/m = 5 }
         coordinates { phi: rad, x: m }
         lagrangian j/2*dot(phi)^2 + m/2*dot(x)^2 - k/2*(x - 1 [m])^2
         joint rod: |(x - r*cos(phi), r*sin(phi))|^2 == l^2
         surface wall: x <= 1.7 [m]
         impact wall: restitution 0.8
         start { phi: 1.5, x: 1.25, dot(phi): -6 }
         horizon 2 [s]",
    );
    let closed = scene(
        "parameters { j: kg*m^2 = 0.4, m: kg = 1.2, r: m = 0.5, l: m = 1.3, k: N/m = 5 }
         coordinates { phi: rad }
         let x = r*cos(phi) + sqrt(l^2 - r^2*sin(phi)^2)
         lagrangian j/2*dot(phi)^2 + m/2*dot(x)^2 - k/2*(x - 1 [m])^2
         surface wall: x <= 1.7 [m]
         impact wall: restitution 0.8
         outputs { slider: m = x }
         start { phi: 1.5, dot(phi): -6 }
         horizon 2 [s]",
    );
    let start = solved(simulate(&looped).run());
    let exact = simulate(&closed)
        .start("phi", start["phi"][0])
        .start("dot(phi)", start["dot(phi)"][0])
        .method(EventDriven::default())
        .tolerance(1e-13)
        .run();
    let exact = solved(exact);
    assert!(exact.events.len() >= 2, "{} impacts", exact.events.len());
    for run in both(&looped) {
        assert_eq!(run.events.len(), exact.events.len());
        assert_close(last(&run, "phi"), last(&exact, "phi"), 1e-8, "phi");
        assert_close(
            last(&run, "dot(phi)"),
            last(&exact, "dot(phi)"),
            1e-8,
            "its rate",
        );
        assert_close(last(&run, "x"), last(&exact, "slider"), 1e-8, "slider");
    }
}

#[test]
fn pivot_that_is_moved_over_time_is_a_joint_with_the_time() {
    let joint = scene(
        "parameters { m: kg = 1, g: m/s^2 = 9.81, l: m = 1, a: m = 0.1, w: 1/s = 3 }
         coordinates { x: m, z: m }
         lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
         joint rod: |(x - a*sin(w*t), z)|^2 == l^2
         start { x: 0.3, z: -1 }
         horizon 3 [s]",
    );
    let angle = scene(
        "parameters { m: kg = 1, g: m/s^2 = 9.81, l: m = 1, a: m = 0.1, w: 1/s = 3 }
         coordinates { phi: rad }
         let p = (a*sin(w*t) + l*sin(phi), -l*cos(phi))
         lagrangian m/2*|dot(p)|^2 - m*g*p.z
         outputs { x: m = p.y }
         horizon 3 [s]",
    );
    let start = solved(simulate(&joint).run());
    let (x, z) = (start["x"][0], start["z"][0]);
    let (vx, vz) = (start["dot(x)"][0], start["dot(z)"][0]);
    // Of the velocity, what turns around the pivot.
    let rate = ((vx - 0.3) * -z + vz * x) / (x * x + z * z);
    let exact = simulate(&angle)
        .start("phi", x.atan2(-z))
        .start("dot(phi)", rate)
        .method(EventDriven::default())
        .tolerance(1e-13)
        .run();
    let exact = solved(exact);
    for run in both(&joint) {
        assert_close(last(&run, "x"), last(&exact, "x"), 1e-9, "x");
    }
}

#[test]
fn forces_of_joints_know_the_forces_of_contacts() {
    // A body on a slope of 0.3 rad, held by a rail: N cos s = m g, and the rail carries N sin s.
    let body = scene(
        "parameters { m: kg = 2, g: m/s^2 = 9.81, s: rad = 0.3 }
         coordinates { x: m, z: m }
         lagrangian m/2*(dot(x)^2 + dot(z)^2) - m*g*z
         joint rail: x == 0 [m]
         surface slope: z*cos(s) - x*sin(s) >= 0
         impact slope: inelastic
         outputs { carries: N = force(rail), load: N = force(slope) }
         horizon 0.5 [s]",
    );
    for run in both(&body) {
        assert_close(
            last(&run, "load"),
            2.0 * 9.81 / 0.3_f64.cos(),
            1e-12,
            "load",
        );
        assert_close(
            last(&run, "carries"),
            2.0 * 9.81 * 0.3_f64.tan(),
            1e-12,
            "rail",
        );
    }
}

/// A coordinate that is rigid under the impulse, where a joint makes one coordinate of two.
#[test]
fn contacts_that_hold_coordinates_know_joints() {
    let rest = "surface floor: a + 2*b >= 0  impact floor: restitution 0.5, holding a
         start { a: 0.2, b: 0.4, dot(a): 0.3, dot(b): -1 }
         horizon 2 [s]";
    let joined = scene(&format!(
        "parameters {{ m: kg = 1, k: kg = 0.4, s: N/m = 3 }} coordinates {{ a: m, b: m, c: m }}
         lagrangian m/2*(dot(a)^2 + dot(b)^2 + dot(c)^2) + k*dot(a)*dot(b) - s/2*(a^2 + b*c)
         joint same: b == c {rest}"
    ));
    let single = scene(&format!(
        "parameters {{ m: kg = 1, k: kg = 0.4, s: N/m = 3 }} coordinates {{ a: m, b: m }}
         lagrangian m/2*(dot(a)^2 + 2*dot(b)^2) + k*dot(a)*dot(b) - s/2*(a^2 + b^2) {rest}"
    ));
    // The joint completes the start: b takes a part of what c is off.
    let start = solved(simulate(&joined).run());
    let begin = |name: &str| start[name][0];
    let exact = simulate(&single)
        .start("a", begin("a"))
        .start("b", begin("b"))
        .start("dot(a)", begin("dot(a)"))
        .start("dot(b)", begin("dot(b)"))
        .method(EventDriven::default())
        .tolerance(1e-13)
        .run();
    let exact = solved(exact);
    assert!(!exact.events.is_empty());
    for run in both(&joined) {
        assert_eq!(run.events.len(), exact.events.len());
        for name in ["a", "b", "dot(a)", "dot(b)"] {
            assert_close(last(&run, name), last(&exact, name), 1e-9, name);
        }
    }
}

#[test]
fn rows_that_follow_from_others_change_nothing_and_share_forces() {
    let twice = scene(&ROD.replace(
        "outputs {",
        "joint again: x^2 + z^2 == l^2  joint rate: x*dot(x) + z*dot(z) == 0
         outputs { second: N = -2*l*force(again), third: N = -l*force(rate),",
    ));
    let once = tight(&scene(ROD));
    for run in both(&twice) {
        let note = run.notes.iter().find(|note| note.contains("redundant"));
        assert!(
            note.is_some_and(|note| note.contains("`again`, `rate`")),
            "{:?}",
            run.notes
        );
        assert_close(last(&run, "x"), last(&once, "x"), 1e-8, "x");
        let sum: f64 = ["tension", "second", "third"]
            .map(|name| last(&run, name))
            .iter()
            .sum();
        assert_close(sum, last(&once, "tension"), 1e-6, "sum of the forces");
        // Of l2 = l1 and l3 = l1/2 the least square.
        assert_close(last(&run, "second"), last(&run, "tension"), 1e-9, "shared");
        assert_close(
            last(&run, "third"),
            last(&run, "tension") / 4.0,
            1e-9,
            "shared",
        );
    }
}

#[test]
fn loop_that_passes_a_singular_configuration_ends_there() {
    let parallel = scene(
        "parameters { m: kg = 1, a: m = 1, b: m = 2 }
         coordinates { t1: rad, t2: rad, t3: rad }
         lagrangian m/2*(a^2*dot(t1)^2 + b^2*dot(t2)^2 + a^2*dot(t3)^2)
         joint loop: (a*cos(t1) + b*cos(t2), a*sin(t1) + b*sin(t2)) == (b + a*cos(t3), a*sin(t3))
         start { t1: 1.2, t2: 0, t3: 1.2, dot(t1): -1, dot(t3): -1 }
         horizon 3 [s]",
    );
    for method in [&Fesd::default() as &dyn Simulator, &EventDriven::default()] {
        let problem = InitialValueProblem::of(&parallel, None).expect("a horizon");
        let run = method
            .simulate(&parallel, &problem, &mut |_| true)
            .expect("accepted");
        let why = run.status.diagnosis().expect("it ends");
        // All links lie on one line after 1.2 s.
        assert_close(why.time, 1.2, 1e-3, "time of the singular configuration");
        assert!(
            why.message.contains("singular configuration"),
            "{}",
            why.message
        );
        assert!(run["time"].iter().all(|&time| time < why.time));
    }
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
