//! A plan as tables, and the chart of its search.

use std::fmt::Write as _;

use hangtime::model::{Declaration, Model};
use hangtime::mpcc;
use hangtime::ocp::{ControlShape, Solution, Source};
use hangtime::simulation::{EventKind, Trajectory};

use crate::anytime::{self, Search};
use crate::ending::Ending;
use crate::figure::Look;
use crate::json::{SolverSettings, struck_after_the_end};
use crate::page::Figure;
use crate::quantity;
use crate::sampling::State;
use crate::settings::ChosenScene;
use crate::simulate::{digits, ranges};
use crate::table::{counted, headed, residual_line, seconds, table};
use crate::{Measure, Quantity};

/// How the best motion became better over the CPU time of the search, if it did: a chart, as (name, chart).
pub(crate) fn improvements(
    stem: &str,
    chosen: &ChosenScene,
    solution: &Solution,
) -> Vec<(String, Figure)> {
    if solution.improvements.len() < 2 {
        return Vec::new();
    }
    let search = Search::of("this search".to_owned(), Look::of("phases"), solution);
    let title = format!("{}: best objective over CPU time", chosen.scene.name);
    let chart = anytime::figure(&title, &[search], solution.objective);
    vec![(format!("{stem}-search.svg"), chart)]
}

/// Derivatives of the optimum.
fn gradient(declaration: &Declaration, solution: &Solution) -> String {
    let Some(gradient) = &solution.gradient else {
        return String::new();
    };
    let header = ["derivative by", "objective", "final time [s]"];
    let rows = gradient.parameters.iter().enumerate().map(|(k, &index)| {
        let known = &declaration.parameters[index];
        let time = gradient.final_time[k].map_or_else(|| "open".to_owned(), digits);
        vec![
            headed(known.name, known.unit),
            digits(gradient.objective[k]),
            time,
        ]
    });
    let names = gradient.parameters.iter().map(|&index| {
        let known = &declaration.parameters[index];
        headed(known.name, known.unit)
    });
    let names: Vec<String> = names.collect();
    let mut notes = String::new();
    for (name, (obstacle, sides)) in names
        .iter()
        .zip(gradient.obstacles.iter().zip(&gradient.sides))
    {
        if let Some(why) = obstacle {
            let _ = write!(notes, "note        no derivative by {name}: {why}");
            if let Some(sides) = sides {
                let [left, right] = sides.objective.map(digits);
                let _ = write!(notes, "; objective {left} from below, {right} from above");
            }
            notes.push('\n');
        }
    }
    table(header, rows)
        + "  (as long as the contact sequence stays)\n"
        + &notes
        + &ranges(&names, &gradient.ranges)
        + "\n"
}

/// The result for people.
pub(crate) fn tables(
    chosen: &ChosenScene,
    method: &SolverSettings,
    solution: &Solution,
    ending: &Ending,
) -> String {
    let mut text = format!("{}: {}\n\n", chosen.scene.name, chosen.scene.title);
    let _ = writeln!(text, "parameters    {}", chosen.parameters().join(", "));
    let _ = writeln!(
        text,
        "method        {}, {}, {}, {} of {}, {} controls, {}",
        method.name,
        method.scheme,
        counted(method.stages, "stage"),
        counted(method.intervals, "interval"),
        counted(method.elements, "element"),
        method.control_shape,
        counted(solution.starts, "start")
    );
    let _ = writeln!(text, "status        {}", ending.status);
    let Some(motion) = &solution.motion else {
        return text + &work(solution);
    };
    let _ = writeln!(text, "objective     {:.10}", solution.objective);
    let declared = chosen.model.declaration().optimal_control;
    let fixed = if declared.is_some_and(|declared| declared.free_time) {
        ""
    } else {
        ", fixed: `time` occurs neither in the objective nor in conditions"
    };
    let _ = writeln!(text, "final time    {:.10} s{fixed}", solution.horizon);
    for found in &solution.parameters {
        let _ = writeln!(text, "found         {found}");
    }
    for gain in gains(chosen, &motion.trajectory) {
        let _ = writeln!(text, "gain          {gain}");
    }
    let _ = writeln!(text, "stationarity  {}", solution.certificate());
    let _ = writeln!(text, "re-simulated  {}", resimulated(solution));
    if let Some(finer) = method.finer(solution) {
        let _ = writeln!(text, "elements      {finer}");
    }
    for struck in struck_after_the_end(chosen.model.as_ref(), solution) {
        let _ = writeln!(text, "end           {struck}");
    }
    text.push('\n');
    text += &gradient(chosen.model.declaration(), solution);
    text += &relaxed_and_optima(solution);
    text += &ends(chosen.model.as_ref(), &motion.trajectory);
    text += &switches(chosen.model.declaration(), solution);
    text += &controls(chosen.model.declaration(), solution);
    for excess in &solution.excess {
        let _ = writeln!(
            text,
            "exceeded      `{}` by up to {:.1e} {}, at {:.6} s",
            excess.name, excess.amount, excess.unit, excess.time
        );
    }
    for margin in &solution.margins {
        let amount = format!("{:.1e} {}", margin.amount, margin.unit);
        let _ = writeln!(
            text,
            "kept          {}, {}, which costs about {:.1e}",
            margin.name,
            amount.trim_end(),
            margin.cost
        );
    }
    let _ = writeln!(text, "residuals     {}", residual_line(solution.residuals));
    text += &work(solution);
    for note in &motion.notes {
        let _ = writeln!(text, "note          {note}");
    }
    text
}

/// How far the re-simulation is from the plan: at the end, and in the objective where that is seen.
fn resimulated(solution: &Solution) -> String {
    let end = format!(
        "{:.1e} away from the plan at the end, {:.1e} in velocities",
        solution.resimulation_error, solution.resimulation_velocity_error
    );
    if solution.resimulated_objective.is_nan() {
        return end;
    }
    let difference = solution.resimulated_objective - solution.objective;
    format!("{end}, {:.1e} in the objective", difference.abs())
}

/// What the publications of the scene measure the optimum by: how much a quantity grows, beside the published number
/// if it is for the same parameters.
fn gains(chosen: &ChosenScene, trajectory: &Trajectory) -> Vec<String> {
    let model = chosen.model.as_ref();
    let Some(end) = trajectory.time.len().checked_sub(1) else {
        return Vec::new();
    };
    let [start, end] = [0, end].map(|k| State::of(model, trajectory, k));
    let mut gains: Vec<(Quantity, String)> = Vec::new();
    for case in chosen.scene.published {
        let same = case
            .settings
            .iter()
            .map(|(name, value)| format!("{name}={value}"));
        let same = ChosenScene::new(chosen.scene, &same.collect::<Vec<_>>())
            .is_ok_and(|other| other.parameters() == chosen.parameters());
        for value in case.values {
            let Measure::Gain(quantity) = value.measure else {
                continue;
            };
            let in_unit = |state: &State| {
                quantity::converted(model, quantity, state.value(quantity)?, value.unit)
            };
            let (Some(from), Some(to)) = (in_unit(&start), in_unit(&end)) else {
                continue;
            };
            let mut text = format!(
                "{} {:+.4} {unit}, from {from:.4} to {to:.4} {unit}",
                quantity::symbol(model, quantity),
                to - from,
                unit = value.unit,
            );
            let published = value.stated.filter(|_| same);
            if let Some(published) = published {
                let _ = write!(text, " (published: {published:+} {})", value.unit);
            }
            match gains.iter_mut().find(|(known, _)| *known == quantity) {
                Some(known) if published.is_some() => known.1 = text,
                Some(_) => {}
                None => gains.push((quantity, text)),
            }
        }
    }
    gains.into_iter().map(|(_, text)| text).collect()
}

/// The states at both ends of the motion.
fn ends(model: &dyn Model, trajectory: &Trajectory) -> String {
    let (Some(last), Some(time)) = (trajectory.time.len().checked_sub(1), trajectory.time.last())
    else {
        return String::new();
    };
    let declaration = model.declaration();
    let (mechanical, all) = (declaration.mechanical(), declaration.coordinates.len());
    let quantities = (0..mechanical)
        .flat_map(|i| [Quantity::Coordinate(i), Quantity::Velocity(i)])
        .chain((mechanical..all).map(Quantity::Velocity));
    let rows = quantities.map(|quantity| {
        let value = |k| State::of(model, trajectory, k).value(quantity).map(digits);
        vec![
            headed(
                &quantity::symbol(model, quantity),
                &quantity::unit(model, quantity),
            ),
            value(0).unwrap_or_default(),
            value(last).unwrap_or_default(),
        ]
    });
    let header = [
        "state".to_owned(),
        "at 0 s".to_owned(),
        format!("at {time:.10} s"),
    ];
    table(header, rows) + "\n"
}

/// The switches of the plan.
fn switches(declaration: &Declaration, solution: &Solution) -> String {
    if solution.planned_events.is_empty() {
        return "no events\n\n".to_owned();
    }
    let rows = solution.planned_events.iter().map(|(time, kind, contact)| {
        let kind = match kind {
            EventKind::LiftOff => "lift off",
            kind => kind.name(),
        };
        vec![
            kind.to_owned(),
            declaration.contacts[*contact].name.to_owned(),
            format!("{time:.10}"),
        ]
    });
    table(["event", "contact", "time [s]"], rows) + "\n"
}

/// The controls of every interval, or at every node.
fn controls(declaration: &Declaration, solution: &Solution) -> String {
    let place = match solution.shape {
        ControlShape::Constant => ["interval", "from [s]"],
        ControlShape::Linear => ["node", "at [s]"],
    };
    let header = place.map(str::to_owned).into_iter();
    let controls = declaration.controls.iter();
    let header = header.chain(controls.map(|control| headed(control.name, control.unit)));
    let timed = solution.controls.iter().zip(&solution.control_times);
    let rows = timed.enumerate().map(|(k, (controls, time))| {
        let values = controls.iter().map(|u| format!("{u:.6}"));
        [k.to_string(), format!("{time:.6}")]
            .into_iter()
            .chain(values)
            .collect()
    });
    table(header, rows) + "\n"
}

/// What the result took.
fn work(solution: &Solution) -> String {
    let counts = solution.counts;
    format!(
        "counts        {}, {} + {}, {}, {}\nCPU time      {}\n",
        counted(counts.programs, "program"),
        counts.global_iterations,
        counted(counts.iterations, "interior point iteration"),
        counted(counts.factorizations, "factorization"),
        counted(counts.repairs, "repair"),
        seconds(solution.seconds.total)
    )
}

/// The complementarity problem of the time-freezing formulation, and the local optima of several starts.
fn relaxed_and_optima(solution: &Solution) -> String {
    let mut text = String::new();
    if let Some(report) = &solution.time_freezing {
        let size = report.size;
        let how = match report.status {
            mpcc::Status::Uncertified => {
                "solved exactly with the contact sequence of the motion".to_owned()
            }
            status => status.to_string(),
        };
        let left_out = match &report.left_out[..] {
            [] => String::new(),
            left_out => format!(", without {}", left_out.join(" and ")),
        };
        let _ = writeln!(
            text,
            "time-freezing {how}{}: objective {:.7}, violation {:.1e}, largest product {:.1e}\n              \
             relaxed before: objective {:.7}, largest product {:.1e}{}\n              \
             {} variables, {} rows, {} pairs; {} iterations, {} of CPU time\n",
            left_out,
            report.objective,
            report.residuals.primal,
            report.residuals.complementarity,
            report.relaxed.objective,
            report.relaxed.complementarity,
            if report.relaxed.led_to_motion {
                ""
            } else {
                ", led to no motion; contact sequence of the search over words"
            },
            size.variables,
            size.equalities + size.inequalities,
            size.complementarities,
            report.iterations,
            seconds(report.seconds)
        );
    }
    if solution
        .optima
        .iter()
        .map(|o| o.sources.len())
        .sum::<usize>()
        > 1
    {
        let rows = solution.optima.iter().map(|optimum| {
            let sources = optimum.sources.iter().map(|source| match source {
                Source::Start(start) => start.to_string(),
                other => other.to_string(),
            });
            let sources: Vec<String> = sources.collect();
            vec![
                format!("{:.10}", optimum.objective),
                format!("{:.10}", optimum.horizon),
                optimum.status.name().to_owned(),
                optimum.stationarity.name().to_owned(),
                optimum.switches.to_string(),
                optimum.intervals.to_string(),
                sources.join(" "),
            ]
        });
        let header = [
            "local optimum",
            "final time [s]",
            "status",
            "stationarity",
            "switches",
            "intervals",
            "words, starts",
        ];
        text += &table(header, rows);
        text += "\n";
    }
    text
}
