//! The ski jumps of J. Golembiewski, T. Faulwasser, "Tutorial Problems for Nonsmooth Dynamics and
//! Optimal Control: Ski Jumping and Accelerating a Bike Without Pedaling", Fig. 3, digit for digit.
//!
//! The certified values are those of the exact motion: energy conservation gives the speed on the table, the time
//! of the take-off is a quadrature in 40 digits, flight and slope are closed forms.

use hangtime::simulation::EventKind::{Impact, LiftOff};

use super::read::rows;
use hangtime_cli::{
    ComparedValue, Measure, PublishedCase, PublishedCurve, PublishedData, PublishedDataError,
    PublishedPoint, Quantity, Reference, Task,
};

/// Time-lapse markers a second \[1/s\]; the first one is the start.
const MARKER_RATE: f64 = 5.0;
/// Length of the published simulations \[s\].
const HORIZON: f64 = 5.0;
/// The coordinates.
const Y: Quantity = Quantity::Coordinate(0);
const Z: Quantity = Quantity::Coordinate(1);

/// Both jumps.
pub(crate) const CASES: &[PublishedCase] = &[
    PublishedCase {
        name: "ski_sim_45",
        title: "ski jump, start 45 m high",
        source: "Golembiewski and Faulwasser, Fig. 3a",
        settings: &[("start_y", "10.2759m")],
        task: Task::Simulate { horizon: HORIZON },
        data: || data("ski_sim_45", include_str!("../../data/ski_sim_45.csv")),
        values: &[
            certified(Measure::EventTime(LiftOff), "s", 1.785_438_154_029_445),
            certified(Measure::EventTime(Impact), "s", 3.530_153_382_957_621),
            certified(
                Measure::EventCoordinate(Impact, 0),
                "m",
                35.110_734_822_426_41,
            ),
            // The first marker after the landing, which the figure marks as the impact.
            certified(Measure::At(3.6, Y), "m", 36.071_817_989_989_15),
            certified(Measure::At(3.6, Z), "m", 26.964_091_005_005_424),
            certified(Measure::At(HORIZON, Y), "m", 59.373_066_742_926_91),
        ],
    },
    PublishedCase {
        name: "ski_sim_50",
        title: "ski jump, start 50 m high",
        source: "Golembiewski and Faulwasser, Fig. 3b",
        settings: &[("start_y", "8.264m")],
        task: Task::Simulate { horizon: HORIZON },
        data: || data("ski_sim_50", include_str!("../../data/ski_sim_50.csv")),
        values: &[
            certified(Measure::EventTime(LiftOff), "s", 1.920_677_731_719_311_8),
            certified(Measure::EventTime(Impact), "s", 4.187_825_565_786_617),
            certified(
                Measure::EventCoordinate(Impact, 0),
                "m",
                48.783_281_003_982_325,
            ),
            certified(Measure::At(4.2, Y), "m", 49.010_002_331_939_83),
            certified(Measure::At(4.2, Z), "m", 20.494_998_834_030_08),
            certified(Measure::At(HORIZON, Y), "m", 65.182_983_649_453_43),
        ],
    },
];

const fn certified(measure: Measure, unit: &'static str, value: f64) -> ComparedValue {
    ComparedValue {
        measure,
        unit,
        stated: None,
        reference: Reference::Certified(value),
    }
}

/// One row: kind, index of a time-lapse marker, horizontal and vertical position \[m\].
type Row = (String, Option<usize>, f64, f64);

fn data(name: &'static str, csv: &'static str) -> Result<PublishedData, PublishedDataError> {
    let rows: Vec<Row> = rows(name, csv)?;
    let points: Vec<PublishedPoint> = rows
        .iter()
        .filter_map(|&(_, index, y, z)| {
            index.map(|index| PublishedPoint {
                time: index as f64 / MARKER_RATE,
                positions: vec![[y, z]],
                time_lapse: true,
            })
        })
        .collect();
    let curve = |quantity, axis: usize| PublishedCurve {
        quantity,
        unit: "m",
        points: points
            .iter()
            .map(|point| [point.time, point.positions[0][axis]])
            .collect(),
    };
    Ok(PublishedData {
        curves: vec![curve(Y, 0), curve(Z, 1)],
        points,
    })
}
