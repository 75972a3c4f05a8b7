//! Finite elements where the laws of contact leave something open: several contacts that stick at once, which
//! share the friction in no determined way, sequences of bounces between two surfaces, Painleve's paradox,
//! and impacts that Newton's law lets gain energy.

use crate::common::event::{accurate, sequence};
use crate::common::laws::{Rod, Wedge, rough_crate};
use crate::common::scenes::GRAVITY;
use crate::common::{distance, last, root, start};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{
    EventDriven, EventKind, Fesd, InitialValueProblem, Simulation, SimulationStatus, Simulator,
};

fn run(simulator: &dyn Simulator, model: &dyn Model, problem: &InitialValueProblem) -> Simulation {
    simulator
        .simulate(model, problem, &mut |_| true)
        .expect("the problem is accepted")
}

fn controlled(stages: usize, tolerance: f64) -> Fesd {
    Fesd::default()
        .with_scheme(Scheme::RadauIia, stages)
        .with_grid(1, 1)
        .with_tolerance(tolerance)
}

/// Equal elements, and elements of controlled length.
fn both() -> [Fesd; 2] {
    [Fesd::default(), controlled(5, 1e-9)]
}

#[test]
fn mass_that_falls_into_a_wedge_comes_to_rest_in_its_corner() {
    let problem = start(&[0.1, 1.0], &[0.3, 0.0], 3.0);
    for (friction, restitution) in [
        (0.0, 0.0),
        (0.0, 0.5),
        (0.3, 0.0),
        (0.3, 0.5),
        (0.7, 0.5),
        (1.5, 0.0),
        (1.5, 0.5),
    ] {
        let model = Wedge {
            mu: friction,
            e: restitution,
            ..Wedge::default()
        };
        let case = format!("mu {friction}, e {restitution}");
        let expected = run(&accurate(), &model, &problem);
        for simulator in both() {
            let simulation = run(&simulator, &model, &problem);
            assert_eq!(simulation.status, SimulationStatus::Solved, "{case}");
            assert_eq!(simulation.counts.fallbacks, 0, "{case}");
            let (q, v) = last(&simulation.trajectory);
            // Held positions and velocities are corrected to rounding error.
            assert!(distance(q, &[0.0; 2]) < 1e-14, "{case}: {q:?}");
            assert!(distance(v, &[0.0; 2]) < 1e-14, "{case}: {v:?}");
            let forces = simulation.trajectory.contact_force.last().unwrap();
            assert!(forces.iter().all(|force| *force >= 0.0), "{case}");
            // Parabolas between impacts: rounding errors, which grow a few times from impact to impact.
            let impacts = |simulation: &Simulation| {
                let mut impacts = simulation.events.clone();
                impacts.retain(|event| event.kind == EventKind::Impact);
                impacts.truncate(8);
                impacts
            };
            let (impacts, expected) = (impacts(&simulation), impacts(&expected));
            assert_eq!(impacts.len(), expected.len(), "{case}");
            for (a, b) in impacts.iter().zip(&expected) {
                assert_eq!(a.contact, b.contact, "{case}");
                assert!((a.time - b.time).abs() < 1e-12, "{case}: {:?}", a.time);
            }
        }
    }
}

/// Crates that rock on the ground, or between ground and wall, until ever shorter flights end in contact:
/// `(half width, half height, q, v, mu, stages, tolerance)`.
type Rocking = (f64, f64, [f64; 3], [f64; 3], f64, usize, f64);

const ROCKING: [Rocking; 2] = [
    (
        0.398_447_876_692_713_64,
        0.339_364_748_934_895_8,
        [
            -0.038_340_463_394_131_61,
            1.099_512_404_496_901_6,
            -1.712_235_573_428_251,
        ],
        [
            3.428_144_473_672_27,
            1.406_598_732_627_986_5,
            -0.549_648_136_393_480_5,
        ],
        0.6,
        3,
        1e-9,
    ),
    (
        0.474_496_094_297_849_6,
        0.190_405_214_893_592_8,
        [
            0.169_441_024_711_335_8,
            0.941_180_476_316_371,
            2.334_492_394_045_563_7,
        ],
        [
            2.724_124_645_932_167_5,
            0.762_380_250_910_411_2,
            0.142_220_204_817_834,
        ],
        0.3,
        5,
        1e-9,
    ),
];

#[test]
fn crate_that_rocks_ever_faster_comes_to_rest_without_the_complementarity_problem() {
    for (half_width, half_height, q, v, friction, stages, tolerance) in ROCKING {
        let model = rough_crate(half_width, half_height, friction);
        let problem = start(&q, &v, 2.0);
        let simulation = run(&controlled(stages, tolerance), &model, &problem);
        assert_eq!(simulation.status, SimulationStatus::Solved);
        assert_eq!(simulation.counts.fallbacks, 0);
        let expected = run(&accurate(), &model, &problem);
        assert_eq!(expected.status, SimulationStatus::Solved);
        let ((q, v), (q_expected, _)) = (last(&simulation.trajectory), last(&expected.trajectory));
        // The tolerance of an element, a few times larger after each of some ten impacts that count.
        assert!(
            distance(q, q_expected) < 1e3 * tolerance,
            "{q:?} {q_expected:?}"
        );
        assert!(distance(v, &[0.0; 3]) < 1e-14, "{v:?}");
    }
}

#[test]
fn rod_whose_force_grows_without_bound_ends_with_a_status() {
    // Slides towards the angle at which 1 - mu |n'e| vanishes; its force passes 1e5 N on the way there.
    let (mu, angle, spin): (f64, f64, f64) = (1.9169, 2.5735, -2.2747);
    let model = Rod {
        mu,
        ..Rod::default()
    };
    let v = [7.1806 - angle.sin() * spin, angle.cos() * spin, spin];
    let problem = start(&[0.0, angle.sin(), angle], &v, 1.0);
    let expected = run(&EventDriven::default(), &model, &problem);
    let pole = expected.status.diagnosis().expect("the run stops").time;
    for simulator in [controlled(3, 1e-6), controlled(5, 1e-12)] {
        let simulation = run(&simulator, &model, &problem);
        let diagnosis = match &simulation.status {
            SimulationStatus::AmbiguousContact(diagnosis) => diagnosis,
            // Elements may step over the pole, and no two runs agree beyond it.
            SimulationStatus::Inaccurate(_) => continue,
            status => panic!("{status:?}"),
        };
        assert!(diagnosis.message.contains("`tip`"), "{diagnosis:?}");
        assert!(diagnosis.message.contains("Painleve"), "{diagnosis:?}");
        // Short of the pole, where the force is many times the weight.
        let force = simulation.trajectory.contact_force.last().unwrap()[0];
        assert!(diagnosis.time < pole && force > 10.0 * GRAVITY, "{force}");
        assert_eq!(simulation.counts.fallbacks, 0);
    }
}

#[test]
fn rod_that_slides_into_the_paradox_ends_with_a_status() {
    let model = Rod {
        mu: 1.8,
        ..Rod::default()
    };
    for tenth in 7..16 {
        let angle = f64::from(tenth) / 10.0;
        for sliding in [-6.0, -3.0, -1.0, 1.0, 3.0] {
            let problem = start(&[0.0, angle.sin(), angle], &[sliding, 0.0, 0.0], 2.0);
            let expected = run(&EventDriven::default(), &model, &problem);
            let simulation = run(&controlled(5, 1e-9), &model, &problem);
            let (found, expected) = (simulation.status.name(), expected.status.name());
            assert_eq!(found, expected, "{angle} {sliding}");
            let diagnosis = simulation.status.diagnosis();
            assert!(
                diagnosis.is_none_or(|diagnosis| diagnosis.message.contains("Painleve")),
                "{diagnosis:?}"
            );
        }
    }
}

#[test]
fn impact_that_raises_the_kinetic_energy_is_noted_with_its_figures() {
    // A rod that sticks with its tip: v_n+ = -e v_n-, v_t+ = 0. In terms of the tip's velocity the energy is
    // v' D^-1 v / 2; at v_t- = 0.7, v_n- = -1, angle 1, that grows for e = 0.95.
    let angle: f64 = 1.0;
    let (sin, cos) = angle.sin_cos();
    let (d_nn, d_nt, d_tt) = (
        1.0 + 3.0 * cos * cos,
        -3.0 * sin * cos,
        1.0 + 3.0 * sin * sin,
    );
    let twice = |v_n: f64, v_t: f64| {
        (d_tt * v_n * v_n - 2.0 * d_nt * v_n * v_t + d_nn * v_t * v_t) / (d_nn * d_tt - d_nt * d_nt)
    };
    let problem = start(&[0.0, sin, angle], &[0.7, -1.0, 0.0], 0.01);
    for (restitution, gains) in [(0.95, true), (0.5, false)] {
        let model = Rod {
            e: restitution,
            mu: 1.0,
            ..Rod::default()
        };
        let gain = 0.5 * (twice(restitution, 0.0) - twice(-1.0, 0.7));
        assert_eq!(gain > 0.0, gains);
        for simulator in both() {
            let simulation = run(&simulator, &model, &problem);
            assert_eq!(sequence(&simulation), [(EventKind::Impact, 0)]);
            let impact = &simulation.events[0];
            // 1/2 v' M v with M = diag(1, 1, 1/3)
            let kinetic = |v: &[f64]| 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] / 3.0);
            let (before, after) = (kinetic(&impact.v_before), kinetic(&impact.v_after));
            assert!((after - before - gain).abs() < 1e-14);
            let figures = format!("`tip` at 0.000000 s from {before:.6e} to {after:.6e}");
            let noted = simulation.notes.iter().any(|note| {
                note.contains("1 impact raises the kinetic energy") && note.contains(&figures)
            });
            assert_eq!(noted, gains, "{figures}: {:?}", simulation.notes);
        }
    }
}

hangtime::model! {
    /// A box on two rough corners that is shaken.
    ShakenBox {
        parameters { m: kg = 4, b: m = 0.2, h: m = 0.4, g: m/s^2 = 9.81, mu = 0.6, f: N = 8, w: rad/s = 10, up: m = 0 }
        coordinates { y: m, z: m, phi: rad }
        let left = (y, z) + rotation(phi)*(-b, -h)
        let right = (y, z) + rotation(phi)*(b, -h)
        lagrangian m/2*|dot((y, z))|^2 + m*(b^2 + h^2)/6*dot(phi)^2 - m*g*z
        forces { y: f*sin(w*t) }
        surface near: left.z >= 0
        surface far: right.z >= 0
        impact near: inelastic, friction mu, sliding dot(left.y)
        impact far: inelastic, friction mu, sliding dot(right.y)
        start { z: h + up }
        horizon 1.5 [s]
    }
}

#[test]
fn box_on_two_rough_corners_rests_whatever_its_corners_share() {
    // No force at all, forces far below the limit that change their sign, and a fall that ends on both corners at once: the friction of
    // neither corner is determined, and that of both together is far below what they can bear.
    for (f, up) in [
        (0.0, 0.0),
        (2.0, 0.0),
        (8.0, 0.0),
        (15.0, 0.0),
        (0.0, 0.1),
        (0.0, 0.3),
    ] {
        let model = ShakenBox {
            f,
            up,
            ..ShakenBox::default()
        };
        let problem = InitialValueProblem::of(&model, None).unwrap();
        for simulator in [
            &Fesd::default() as &dyn Simulator,
            &accurate(),
            &EventDriven::default(),
        ] {
            let simulation = run(simulator, &model, &problem);
            let case = format!("{f} N from {up} m");
            assert_eq!(simulation.status, SimulationStatus::Solved, "{case}");
            let falls = up > 0.0;
            let struck = [(EventKind::Impact, 0), (EventKind::Impact, 1)];
            let expected = if falls { &struck[..] } else { &[] };
            assert_eq!(sequence(&simulation), expected, "{case}");
            assert!(
                simulation
                    .notes
                    .iter()
                    .all(|note| !note.contains("flights")),
                "{case}"
            );
            let (q, v) = last(&simulation.trajectory);
            assert!(distance(q, &[0.0, 0.4, 0.0]) < 1e-13, "{case}: {q:?}");
            assert!(distance(v, &[0.0; 3]) < 1e-13, "{case}: {v:?}");
        }
    }
}

#[test]
fn box_that_is_shaken_beyond_its_friction_slips_and_sticks_with_both_corners_at_once() {
    let model = ShakenBox {
        mu: 0.2,
        f: 12.0,
        ..ShakenBox::default()
    };
    let problem = InitialValueProblem::of(&model, None).unwrap();
    // It slips once the force exceeds mu m g, and sticks where the integral of what is left over vanishes.
    let (f, w, m): (f64, f64, f64) = (12.0, 10.0, 4.0);
    let limit = 0.2 * m * GRAVITY;
    let slips = (limit / f).asin() / w;
    let gained = |t: f64| f / w * ((w * slips).cos() - (w * t).cos()) - limit * (t - slips);
    let sticks = root(gained, 0.25, 0.4);
    for simulator in [&controlled(5, 1e-9) as &dyn Simulator, &accurate()] {
        let simulation = run(simulator, &model, &problem);
        assert_eq!(simulation.status, SimulationStatus::Solved);
        let first: Vec<_> = sequence(&simulation).into_iter().take(4).collect();
        let (slip, stick) = (EventKind::Slip, EventKind::Stick);
        assert_eq!(first, [(slip, 0), (slip, 1), (stick, 0), (stick, 1)]);
        let times = simulation.events.iter().map(|event| event.time).take(4);
        for (time, expected) in times.zip([slips, slips, sticks, sticks]) {
            assert!((time - expected).abs() < 1e-9, "{time} {expected}");
        }
    }
}
