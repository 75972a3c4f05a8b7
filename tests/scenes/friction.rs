//! Compiled scenes with friction of all kinds move like the same ones from a text.

use hangtime::prelude::*;

hangtime::model! {
    /// Two bodies on rough ground, and a wheel that one of them brakes.
    pub Rough {
        parameters { m: kg = 0.7, g: m/s^2 = 9.81, mu = 0.35, r: m = 0.2, j: kg m^2 = 0.1 }
        coordinates { x: m, y: m, z: m, w: rad }
        lagrangian m/2*(dot(x)^2 + dot(y)^2 + dot(z)^2) + j/2*dot(w)^2 - m*g*z
        surface ground: z >= 0
        impact ground: inelastic, friction mu, sliding (dot(x), dot(y))
        dry friction brake: bound mu*r*force(ground), sliding dot(w)
        start { z: 1 [m], dot(x): 1 [m/s], dot(y): 2 [m/s], dot(w): 3 [rad/s] }
        horizon 2 [s]
    }
}

hangtime::model! {
    /// A block that breaks loose from a belt.
    pub Belt {
        parameters { m: kg = 1, g: m/s^2 = 9.81, k: N/m = 20, belt: m/s = 0.5, slow: m/s = 0.2 }
        coordinates { y: m, z: m }
        lagrangian m/2*|dot((y, z))|^2 - m*g*z - k/2*y^2
        surface ground: z >= 0
        impact ground: inelastic, friction static 0.4, kinetic 0.1 + 0.2*exp(-speed/slow), sliding dot(y) - belt
        start { dot(y): belt }
        horizon 2 [s]
    }
}

#[test]
fn compiled_scenes_move_like_the_same_ones_from_a_text() {
    let scenes: [&dyn hangtime::model::Model; 2] = [&Rough::default(), &Belt::default()];
    for scene in scenes {
        let text = super::both::scene(scene.text());
        let [one, other] = [scene, &text as &dyn hangtime::model::Model].map(|scene| {
            let motion = simulate(scene).run().expect("a scene");
            assert!(
                motion.status.is_solved() && !motion.events.is_empty(),
                "{motion}"
            );
            let end = motion.trajectory.q.last().expect("a motion").clone();
            (motion.events.len(), end)
        });
        assert_eq!(one.0, other.0);
        for (a, b) in one.1.iter().zip(&other.1) {
            // The same kernels, in another order of operations.
            assert!((a - b).abs() < 1e-9, "{a} and {b}");
        }
    }
}
