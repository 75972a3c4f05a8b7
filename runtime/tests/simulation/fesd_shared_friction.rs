//! Finite elements where several contacts stick at once, which share the friction in no determined way, at the end of
//! ever shorter flights.

use crate::common::event::{accurate, run};
use crate::common::laws::rough_crate;
use crate::common::{distance, last, start};
use hangtime::rk::Scheme;
use hangtime::simulation::{Fesd, SimulationStatus};

fn controlled(stages: usize, tolerance: f64) -> Fesd {
    Fesd::default()
        .with_scheme(Scheme::RadauIia, stages)
        .with_grid(1, 1)
        .with_tolerance(tolerance)
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
