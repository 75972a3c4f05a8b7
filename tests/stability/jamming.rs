//! Jamming, and Painleve's rod.

use hangtime::simulation::{EventDriven, Fesd, InitialValueProblem, Simulator};

hangtime::model! {
    /// A uniform rod, two metres long, whose tip is pushed over a rough floor.
    pub PushedRod {
        parameters { m: kg = 1, g: m/s^2 = 9.81, mu = 1, start_angle = 1.1071487177940904 }
        coordinates { y: m, z: m, angle }
        lagrangian m/2*(dot(y)^2 + dot(z)^2) + m/6*1[m^2]*dot(angle)^2 - m*g*z
        surface floor: z - 1[m]*sin(angle) >= 0
        impact floor: inelastic, friction mu, sliding dot(y - 1[m]*cos(angle))
        start { z: 1[m]*sin(start_angle), angle: start_angle, dot(y): -1 [m/s] }
        horizon 1 [s]
    }
}

#[test]
fn least_friction_at_which_a_rod_neither_slips_nor_sticks_is_that_of_painleve() {
    for simulator in [
        Box::new(Fesd::default()) as Box<dyn Simulator>,
        Box::new(EventDriven::default()),
    ] {
        for start_angle in [0.7, 1.0, 2.0_f64.atan(), 1.3] {
            // The force on the tip moves it by (1 + 3 cos (cos - mu sin)) / m.
            let exact = (1.0 + 3.0 * start_angle.cos().powi(2))
                / (3.0 * start_angle.sin() * start_angle.cos());
            let jams = |mu: f64| {
                let model = PushedRod {
                    mu,
                    start_angle,
                    ..PushedRod::default()
                };
                let problem = InitialValueProblem::of(&model, None).expect("a horizon");
                // Where the start is allowed the first step is the last one.
                let run = simulator.simulate(&model, &problem, &mut |_| false);
                match run.expect("a problem that can be simulated").status.name() {
                    "ambiguous_contact" => true,
                    "interrupted" => false,
                    other => panic!("{other} at a friction of {mu}"),
                }
            };
            let (mut slips, mut jammed) = (0.9 * exact, 1.1 * exact);
            assert!(!jams(slips) && jams(jammed), "{start_angle}");
            while jammed - slips > 1e-7 {
                let middle = f64::midpoint(slips, jammed);
                if jams(middle) {
                    jammed = middle;
                } else {
                    slips = middle;
                }
            }
            assert!(
                (slips - exact).abs() < 1e-6,
                "{start_angle}: {slips} {exact}"
            );
        }
    }
}
