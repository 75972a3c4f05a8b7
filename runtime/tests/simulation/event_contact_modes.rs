//! Contacts whose normals depend on each other, which the language does not declare.

use crate::common::event::{accurate, check_consistency, run};
use crate::common::scenes::{self, GRAVITY};
use crate::common::{distance, last, start};
use hangtime::rk::Scheme;
use hangtime::simulation::{Fesd, SimulationStatus, Simulator};

#[test]
fn dependent_normals_carry_the_weight_once() {
    let model = scenes::DoubleFloor::default();
    let problem = start(&[0.0, 0.5], &[2.0, 0.0], 1.0);
    let elements = Fesd::default()
        .with_scheme(Scheme::RadauIia, 5)
        .with_grid(40, 2);
    let found = elements.simulate(&model, &problem, &mut |_| true);
    let runs = [run(&accurate(), &model, &problem), found.expect("accepted")];
    check_consistency(&model, &runs[0]);
    for simulation in runs {
        assert_eq!(simulation.status, SimulationStatus::Solved);
        let (q, v) = last(&simulation.trajectory);
        assert!(distance(q, &[1.0, 0.0]) < 1e-14);
        assert!(distance(v, &[0.0, 0.0]) < 1e-14);
        let force = simulation.trajectory.contact_force.last().expect("forces");
        // The floor stands twice: of the forces that carry the weight 2 g the smallest are equal, to what the proximal point
        // method leaves, 1e-16 by 1e-6.
        assert!((force[0] + force[2] - 2.0 * GRAVITY).abs() < 1e-13);
        assert!((force[0] - force[2]).abs() < 1e-8);
    }
}
