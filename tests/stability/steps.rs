//! Impacts at places that are special for a method with steps, very short and very long steps and motions.

use hangtime::simulation::Fesd;
use hangtime_scene_files::of_text;

use super::run;

#[test]
fn hundred_thousand_steps_on_curved_ground_lose_no_energy() {
    let text = "parameters { g: m/s^2 = 10 }\ncoordinates { y: m, z: m }\n\
                lagrangian 1[kg]/2*(dot(y)^2 + dot(z)^2) - 1[kg]*g*z\n\
                surface bowl: z >= y^2/2[m]\nimpact bowl: inelastic\n\
                start { y: 1, z: 0.5 }\nhorizon 1000 [s]\n";
    let scene = of_text("bowl.hang", text).unwrap_or_else(|error| panic!("{error}"));
    let steps = Fesd::default().with_grid(100_000, 1);
    let (run, _) = run(&scene, &steps);
    assert!(run.status.is_solved(), "{:?}", run.status);
    let trajectory = &run.trajectory;
    let energy = |index: usize| {
        let (q, v) = (&trajectory.q[index], &trajectory.v[index]);
        (v[0] * v[0] + v[1] * v[1]) / 2.0 + 10.0 * q[1]
    };
    let last = trajectory.q.len() - 1;
    let drift = (energy(last) - energy(0)).abs() / energy(0);
    let estimate = run.error_estimate.expect("an estimate");
    assert!(
        drift < 1e-6 && drift <= 10.0 * estimate,
        "{drift}, estimate {estimate}"
    );
    let gap = trajectory.q[last][1] - trajectory.q[last][0].powi(2) / 2.0;
    assert!(gap.abs() < 1e-12, "{gap}");
}
