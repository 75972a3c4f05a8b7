//! The rides on the pump track of J. Golembiewski, T. Faulwasser, "Tutorial Problems for Nonsmooth Dynamics
//! and Optimal Control: Ski Jumping and Accelerating a Bike Without Pedaling", Fig. 4 and 5, digit for digit.
//!
//! The certified values of the rides without input are those of the exact motion, in Taylor series of 25 and of 35
//! digits for the contact phases; a flight is a parabola.

use std::f64::consts::TAU;

use hangtime::rk::Scheme;
use hangtime::simulation::EventKind::{Impact, LiftOff};

use super::read::rows;
use hangtime_cli::{
    ComparedValue, Measure, PublishedCase, PublishedCurve, PublishedData, PublishedDataError,
    PublishedPoint, PublishedSize, Quantity, Reference, Task,
};

/// Position along the track, speed, length of the link, and force along it.
const Y: Quantity = Quantity::Coordinate(0);
const SPEED: Quantity = Quantity::Velocity(0);
const LINK: Quantity = Quantity::Coordinate(2);
const FORCE: Quantity = Quantity::Control(0);

/// Points of a curve over time for each plotted position.
const STEPS_OF_A_POSITION: usize = 2;
/// Plotted positions for each one of the time lapse.
const POSITIONS_OF_A_LAPSE: usize = 5;

const POSITION: &str = include_str!("../../data/pump_q1_over_t.csv");
const SPEEDS: &str = include_str!("../../data/pump_v1_over_t.csv");
const LENGTHS: &str = include_str!("../../data/pump_s_over_t.csv");
const FORCES: &str = include_str!("../../data/pump_u_over_t.csv");

/// The fastest ride as nosnoc 0.2.0 transcribes it (the Python package, with IPOPT by CasADi 3.8.2), on the grid of the
/// publication: measured on the scene written for it by hand.
pub(crate) const SIZES: &[PublishedSize] = &[
    PublishedSize {
        what: "nosnoc 0.2.0",
        source: "measured, CasADi 3.8.2",
        scheme: Scheme::GaussLegendre,
        stages: 2,
        intervals: 30,
        elements: 3,
        variables: 4111,
        constraints: 3931,
        jacobian_nonzeros: 22622,
        hessian_nonzeros: 9472,
    },
    PublishedSize {
        what: "nosnoc 0.2.0",
        source: "measured, CasADi 3.8.2",
        scheme: Scheme::RadauIia,
        stages: 2,
        intervals: 30,
        elements: 3,
        variables: 3031,
        constraints: 2941,
        jacobian_nonzeros: 17949,
        hessian_nonzeros: 8752,
    },
];

/// The rides without input, then the fastest rides.
pub(crate) const CASES: &[PublishedCase] = &[
    PublishedCase {
        name: "pump_sim_10",
        title: "pump track, 10 km/h, no input",
        source: "Golembiewski and Faulwasser, Fig. 4a and 5",
        settings: &[("speed", "10km/h")],
        task: Task::Simulate { horizon: 0.8639 },
        data: || data(10, PASSIVE, include_str!("../../data/pump_sim_v1_10.csv")),
        values: &[
            certified(Measure::Final(Y), "m", 1.207_820_251_934_031_7),
            certified(Measure::Final(SPEED), "km/h", 0.140_591_556_724_449_47),
        ],
    },
    PublishedCase {
        name: "pump_sim_15",
        title: "pump track, 15 km/h, no input",
        source: "Golembiewski and Faulwasser, Fig. 4b and 5",
        settings: &[("speed", "15km/h")],
        task: Task::Simulate { horizon: 1.867 },
        data: || data(15, PASSIVE, include_str!("../../data/pump_sim_v1_15.csv")),
        values: &[
            certified(Measure::Final(Y), "m", 6.326_763_348_462_598),
            certified(Measure::Final(SPEED), "km/h", 14.984_474_680_620_843),
            ComparedValue {
                measure: Measure::Reach(0, TAU),
                unit: "s",
                stated: Some(1.87),
                reference: Reference::Certified(1.856_537_656_863_041),
            },
        ],
    },
    PublishedCase {
        name: "pump_sim_22",
        title: "pump track, 22 km/h, no input",
        source: "Golembiewski and Faulwasser, Fig. 4c and 5",
        settings: &[("speed", "22km/h")],
        task: Task::Simulate { horizon: 1.467 },
        data: || data(22, PASSIVE, include_str!("../../data/pump_sim_v1_22.csv")),
        values: &[
            certified(Measure::EventTime(LiftOff), "s", 0.181_362_026_053_197_64),
            certified(Measure::EventTime(Impact), "s", 0.661_078_435_632_722_5),
            certified(Measure::Final(Y), "m", 6.352_950_985_436_896),
            certified(Measure::Final(SPEED), "km/h", 15.531_199_243_569_133),
        ],
    },
    PublishedCase {
        name: "pump_opt_10",
        title: "pump track, fastest ride from 10 km/h",
        source: "Golembiewski and Faulwasser, Fig. 4d and 5",
        settings: &[("speed", "10km/h")],
        task: Task::Optimize,
        data: || data(10, OPTIMAL, include_str!("../../data/pump_opt_v1_10.csv")),
        values: &[
            best_known(Measure::FinalTime, "s", 2.451_488_66),
            unknown(Measure::Final(SPEED), "km/h"),
        ],
    },
    PublishedCase {
        name: "pump_opt_15",
        title: "pump track, fastest ride from 15 km/h",
        source: "Golembiewski and Faulwasser, Fig. 4e and 5",
        settings: &[("speed", "15km/h")],
        task: Task::Optimize,
        data: || data(15, OPTIMAL, include_str!("../../data/pump_opt_v1_15.csv")),
        values: &[
            // A global search over event-driven simulations, refined with its contact sequence.
            best_known(Measure::FinalTime, "s", 1.413_768_942),
            best_known(Measure::Final(SPEED), "km/h", 22.655_963),
            ComparedValue {
                measure: Measure::Gain(SPEED),
                unit: "km/h",
                stated: Some(7.56),
                reference: Reference::BestKnown(7.655_963),
            },
        ],
    },
    PublishedCase {
        name: "pump_opt_22",
        title: "pump track, fastest ride from 22 km/h",
        source: "Golembiewski and Faulwasser, Fig. 4f and 5",
        settings: &[("speed", "22km/h")],
        task: Task::Optimize,
        data: || data(22, OPTIMAL, include_str!("../../data/pump_opt_v1_22.csv")),
        values: &[
            best_known(Measure::FinalTime, "s", 1.085_341_85),
            unknown(Measure::Final(SPEED), "km/h"),
        ],
    },
];

const fn certified(measure: Measure, unit: &'static str, value: f64) -> ComparedValue {
    compared(measure, unit, Reference::Certified(value))
}

const fn best_known(measure: Measure, unit: &'static str, value: f64) -> ComparedValue {
    compared(measure, unit, Reference::BestKnown(value))
}

const fn unknown(measure: Measure, unit: &'static str) -> ComparedValue {
    compared(measure, unit, Reference::Unknown)
}

const fn compared(measure: Measure, unit: &'static str, reference: Reference) -> ComparedValue {
    ComparedValue {
        measure,
        unit,
        stated: None,
        reference,
    }
}

/// Names of the inputs in the tables.
const PASSIVE: &str = "u0";
const OPTIMAL: &str = "ustar";

/// One row of a curve: start speed \[km/h\], input, index of a point, time \[s\], value.
type Row = (u32, String, usize, f64, f64);
/// One row of the forces: start speed \[km/h\], index of an interval, its start \[s\], force \[N\].
type ForceRow = (u32, usize, f64, f64);
/// One row of the positions: index, horizontal position, height of bike and rider, distance \[m\].
type PositionRow = (usize, f64, f64, f64, f64);

fn data(
    speed: u32,
    input: &str,
    positions: &'static str,
) -> Result<PublishedData, PublishedDataError> {
    let curve = |quantity, unit, name, csv| -> Result<PublishedCurve, PublishedDataError> {
        let rows: Vec<Row> = rows(name, csv)?;
        let points = rows
            .into_iter()
            .filter(|row| row.0 == speed && row.1 == input)
            .map(|(_, _, _, time, value)| [time, value])
            .collect();
        Ok(PublishedCurve {
            quantity,
            unit,
            points,
        })
    };
    let mut curves = vec![
        curve(Y, "m", "pump_q1_over_t", POSITION)?,
        curve(SPEED, "km/h", "pump_v1_over_t", SPEEDS)?,
        curve(LINK, "m", "pump_s_over_t", LENGTHS)?,
    ];
    if input == OPTIMAL {
        let rows: Vec<ForceRow> = rows("pump_u_over_t", FORCES)?;
        let rows = rows.into_iter().filter(|row| row.0 == speed);
        curves.push(PublishedCurve {
            quantity: FORCE,
            unit: "N",
            // The last row only tells where the last interval ends.
            points: rows
                .filter(|row| row.3.is_finite())
                .map(|(_, _, start, force)| [start, force])
                .collect(),
        });
    }
    let rows: Vec<PositionRow> = rows("pump positions", positions)?;
    let times = curves[0].points.iter().step_by(STEPS_OF_A_POSITION);
    let points = rows
        .into_iter()
        .zip(times)
        .map(|((index, y, bike, rider, _), [time, _])| PublishedPoint {
            time: *time,
            positions: vec![[y, bike], [y, rider]],
            time_lapse: index % POSITIONS_OF_A_LAPSE == 0,
        })
        .collect();
    Ok(PublishedData { points, curves })
}
