//! Starts on a boundary, with either acceleration, in slight and in deep penetration.

use hangtime::simulation::InitialValueProblem;

use super::assert_outcomes;

pub(super) const SCENES: &[&str] = &["leaving-at-once", "rest", "slight-penetration"];

#[test]
fn starts_on_a_boundary_are_contacts_or_not() {
    assert_outcomes(SCENES);
}

hangtime::model! {
    /// A body that starts at some height above a floor.
    Started {
        parameters { height: m = 1 }
        coordinates { z: m }
        lagrangian 1[kg]/2*dot(z)^2
        surface floor: z >= 0
        impact floor: inelastic
        start { z: height }
        horizon 1 [s]
    }
}

#[test]
fn start_deep_inside_the_ground_is_refused_with_the_gap() {
    for (height, written) in [(-1e-3, "-1e-3 m"), (-1.0, "-1e0 m"), (-1e6, "-1e6 m")] {
        let model = Started { height };
        let refused = InitialValueProblem::of(&model, None)
            .and_then(|problem| problem.check(&model))
            .expect_err("a start inside the ground");
        let message = refused.to_string();
        assert!(message.contains("floor"), "{message}");
        assert!(message.contains(written), "{message}");
    }
}
