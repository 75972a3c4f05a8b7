//! A published optimal motion, solved again, and its published controls put to the test.

use crate::{Measure, Quantity};
use hangtime::model::Model;
use hangtime::ocp::{self, Problem, Settings, Solution};
use hangtime::simulation::{
    ControlSignal, EventDriven, InitialValueProblem, InputError, Simulation, Simulator as _,
};

use super::case::{Case, Reproduced};
use super::column::Column;
use super::comparison::{comparison, rows};
use super::motion::player;
use super::overview::{INDEX, section_of};
use crate::bounds::Bounds;
use crate::ending::Ending;
use crate::failure::BadInput;
use crate::files::ResultFiles;
use crate::json::{SolverSettings, solution_document};
use crate::quantity;
use crate::sampling::{State, dense};
use crate::task::{INTERVALS, optimum_facts};

/// Tolerance of the replay of the published controls.
const REPLAY_TOLERANCE: f64 = 1e-12;
/// A bound or an end that is missed by less counts as kept, in the unit of the quantity: rounding of the plotted
/// controls.
const KEPT: f64 = 1e-7;

/// Solves the case and replays the published controls.
pub(super) fn reproduce(case: Case, bounds: &Bounds) -> Result<Reproduced, BadInput> {
    let (chosen, published) = (&case.chosen, case.published);
    let model = chosen.model.as_ref();
    let refuse = |error| chosen.refuse(&error);
    let settings = Settings::default();
    let problem = Problem::of(model, INTERVALS);
    let mut observer = |_: &hangtime::Progress| bounds.asked().is_none();
    let solution = ocp::solve(model, &problem, &settings, &mut observer).map_err(refuse)?;
    let method = SolverSettings::new(model, &settings, problem.intervals);
    let ending = Ending::of(&solution);
    let json = solution_document(chosen, &method, &solution, &ending, usize::MAX).text();
    let diagnosis = ending.line(chosen.scene.name);
    let mut columns = Vec::new();
    let mut files = Vec::new();
    match &solution.motion {
        None => files.push((format!("{}.json", published.name), json)),
        Some(motion) => {
            let result = ResultFiles {
                stem: published.name.to_owned(),
                title: published.title.to_owned(),
                chosen,
                simulation: motion,
                json: &json,
                published: &case.data,
                rows: usize::MAX,
                index: Some(INDEX),
                facts: optimum_facts(&method, &solution, &ending),
                charts: Vec::new(),
                further: Vec::new(),
            };
            files.extend(result.contents());
            columns.push(Column {
                name: "hangtime",
                simulation: timed(motion, &solution),
                residual: solution.resimulation_error,
                rerun: None,
            });
        }
    }
    let mut remarks = Vec::new();
    if let Some(replay) = replay(&case).map_err(refuse)? {
        remarks.extend(remarks_on(&case, &replay));
        columns.push(Column {
            name: "published controls, replayed",
            residual: replay.residuals.primal,
            simulation: replay,
            rerun: None,
        });
    }
    let ours = columns.first().filter(|_| solution.motion.is_some());
    let rows = ours.map(|ours| rows(&case, ours)).unwrap_or_default();
    remarks.extend(ours.and_then(|ours| comparison_of_times(&case, ours)));
    if let Some(ours) = ours {
        remarks.push(left_bounds(
            model,
            "hangtime",
            &dense(model, &ours.simulation.trajectory),
        ));
    }
    let (header, table) = comparison(&case, &rows, &columns);
    let states = ours.map(|ours| dense(model, &ours.simulation.trajectory));
    Ok(Reproduced {
        player: ours.and_then(|ours| player(&case, &ours.simulation)),
        section: section_of(published, &remarks, &files, header, table),
        case,
        states: states.unwrap_or_default(),
        rows,
        seconds: solution.seconds.total,
        residual: solution.resimulation_error,
        remarks,
        diagnoses: diagnosis.into_iter().collect(),
        files,
    })
}

/// The re-simulated motion with the CPU time of the whole solve.
fn timed(motion: &Simulation, solution: &Solution) -> Simulation {
    let mut motion = motion.clone();
    motion.seconds.total = solution.seconds.total;
    motion
}

/// The motion under the published controls up to the published final time.
fn replay(case: &Case) -> Result<Option<Simulation>, InputError> {
    let model = case.chosen.model.as_ref();
    let Some(horizon) = case.data.value(Measure::FinalTime) else {
        return Ok(None);
    };
    let controls = model.declaration().controls.len();
    let curves = (0..controls).map(|index| case.data.curve(Quantity::Control(index)));
    let Some(curves) = curves.collect::<Option<Vec<_>>>() else {
        return Ok(None);
    };
    let Some(first) = curves.first() else {
        return Ok(None);
    };
    // The first plotted instant is 0 up to rounding.
    let times = first.points.iter().enumerate();
    let times: Vec<f64> = times
        .map(|(k, point)| if k == 0 { 0.0 } else { point[0] })
        .collect();
    let values = (0..times.len())
        .map(|k| curves.iter().map(|curve| curve.points[k][1]).collect())
        .collect();
    let mut problem = InitialValueProblem::of(model, Some(horizon))?;
    problem.controls = ControlSignal::PiecewiseConstant { times, values };
    let event = EventDriven {
        tolerance: REPLAY_TOLERANCE,
        ..EventDriven::default()
    };
    event.simulate(model, &problem, &mut |_| true).map(Some)
}

/// What the replay of the published controls shows.
fn remarks_on(case: &Case, replay: &Simulation) -> Vec<String> {
    let model = case.chosen.model.as_ref();
    let states = dense(model, &replay.trajectory);
    let mut remarks = Vec::new();
    if let Some(end) = states.last() {
        let misses = case.data.curves.iter().filter_map(|curve| {
            let planned = curve.points.last()?[1];
            if matches!(curve.quantity, Quantity::Control(_)) {
                return None;
            }
            let value = end.value(curve.quantity)?;
            let value = quantity::converted(model, curve.quantity, value, curve.unit)?;
            let symbol = quantity::symbol(model, curve.quantity);
            let miss = value - planned;
            (miss.abs() > KEPT).then(|| format!("{symbol} {miss:+.1e} {}", curve.unit))
        });
        let misses: Vec<String> = misses.collect();
        remarks.push(if misses.is_empty() {
            "replayed event-driven, the published controls end where published".to_owned()
        } else {
            format!(
                "replayed event-driven, the published controls miss the published end: {}",
                misses.join(", ")
            )
        });
    }
    remarks.push(left_bounds(model, "published controls", &states));
    remarks
}

/// How far the coordinates leave their bounds.
fn left_bounds(model: &dyn Model, whose: &str, states: &[State]) -> String {
    let declaration = model.declaration();
    let coordinates = declaration.coordinates.iter().enumerate();
    let left: Vec<String> = coordinates
        .filter_map(|(index, coordinate)| {
            let bounds = quantity::bounds(model, Quantity::Coordinate(index));
            let turns = || {
                states
                    .windows(2)
                    .filter_map(|pair| turn(&pair[0], &pair[1], index))
            };
            let values = || states.iter().map(|state| state.q[index]).chain(turns());
            let low = values().fold(f64::INFINITY, f64::min);
            let high = values().fold(f64::NEG_INFINITY, f64::max);
            let [lower, upper] = bounds[..] else {
                return None;
            };
            let most = (lower - low).max(high - upper);
            (most > KEPT).then(|| {
                format!(
                    "{} by up to {most:.1e} {}",
                    coordinate.name, coordinate.unit
                )
            })
        })
        .collect();
    if left.is_empty() {
        format!("{whose}: coordinates within their bounds at all times")
    } else {
        format!(
            "{whose}: outside its bounds between the ends of the intervals: {}",
            left.join(", ")
        )
    }
}

/// Where a coordinate turns round between two states: the end of the parabola that its velocities make.
fn turn(before: &State, after: &State, index: usize) -> Option<f64> {
    let (v, change) = (before.v[index], after.v[index] - before.v[index]);
    let share = -v / change;
    let inside = after.time > before.time && share > 0.0 && share < 1.0;
    inside.then(|| before.q[index] + 0.5 * v * share * (after.time - before.time))
}

/// How the published final time compares with ours.
fn comparison_of_times(case: &Case, ours: &Column) -> Option<String> {
    let published = case.data.value(Measure::FinalTime)?;
    let time = ours.simulation.trajectory.time.last()?;
    let difference = published - time;
    let word = if difference > 0.0 {
        "longer"
    } else {
        "shorter"
    };
    Some(format!(
        "the published motion is {:.2} ms {word} than that of hangtime",
        difference.abs() * 1e3
    ))
}
