//! The declarations of this program once more, as texts that are derived when they are loaded.

use crate::same::assert_all_same;
use crate::{
    chain, contact_laws, derivatives, dry_friction, forces, impact_laws, optimal_control_functions,
    profiles, shown,
};

#[test]
fn text_evaluates_to_what_the_compiled_scene_does() {
    let compared = assert_all_same(include_str!("chain.rs"), &[&chain::Chain10::default()])
        + assert_all_same(
            include_str!("contact_laws.rs"),
            &[
                &contact_laws::Hill::default(),
                &contact_laws::Rod::default(),
                &contact_laws::Chain::default(),
                &contact_laws::PumpAlong::default(),
                &contact_laws::PumpHolding::default(),
            ],
        )
        + assert_all_same(
            include_str!("derivatives.rs"),
            &[
                &derivatives::SkiJump::default(),
                &derivatives::PumpTrack::default(),
                &derivatives::DoublePendulum::default(),
                &derivatives::Chain::default(),
                &derivatives::Functions::default(),
                &derivatives::Top::default(),
                &derivatives::TopOfTextbooks::default(),
                &derivatives::Turntable::default(),
            ],
        )
        + assert_all_same(
            include_str!("dry_friction.rs"),
            &[
                &dry_friction::Arm::default(),
                &dry_friction::Train::default(),
                &dry_friction::LongTrain::default(),
            ],
        )
        + assert_all_same(include_str!("forces.rs"), &[&forces::Rod::default()])
        + assert_all_same(
            include_str!("impact_laws.rs"),
            &[&impact_laws::Ball::default(), &impact_laws::Hoop::default()],
        )
        + assert_all_same(
            include_str!("optimal_control_functions.rs"),
            &[
                &optimal_control_functions::Cart::default(),
                &optimal_control_functions::Effort::default(),
                &optimal_control_functions::Appointment::default(),
            ],
        )
        + assert_all_same(
            include_str!("profiles.rs"),
            &[
                &profiles::Measured::default(),
                &profiles::Formula::default(),
                &profiles::Edges::default(),
            ],
        )
        + assert_all_same(
            include_str!("shown.rs"),
            &[&shown::Wheel::default(), &shown::WrittenOut::default()],
        );
    assert_eq!(compared, 28);
}
