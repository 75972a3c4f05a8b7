//! A simulation as tables.

use std::fmt::Write as _;

use hangtime::derivative::{Gradient, SequenceRange, Side};
use hangtime::model::{Declaration, Model};
use hangtime::simulation::{Event, Simulation};

use crate::ending::Ending;
use crate::table::{counted, described, headed, number, per_second, residual_line, seconds, table};
use crate::task::SimulationTask;

/// Most events that are printed.
const MOST_EVENTS: usize = 1_000;

/// A number for people: ten decimals, or an exponent where they would fill the line.
pub(crate) fn digits(value: f64) -> String {
    if value.abs() < 5e-11 {
        // Rounding has a sign that means nothing.
        format!("{:.10}", 0.0)
    } else if value.abs() < 1e7 {
        format!("{value:.10}")
    } else {
        format!("{value:.10e}")
    }
}

/// The result for people.
pub(crate) fn tables(
    task: &SimulationTask,
    simulation: &Simulation,
    gradient: Option<&Gradient>,
    ending: &Ending,
) -> String {
    let (chosen, method, horizon) = (&task.chosen, &task.method, task.problem.horizon);
    let declaration = chosen.model.declaration();
    let mut text = format!("{}: {}\n\n", chosen.scene.name, chosen.scene.title);
    let parameters = chosen.parameters();
    let _ = writeln!(text, "parameters  {}", parameters.join(", "));
    let _ = writeln!(text, "method      {}", method.settings);
    let _ = writeln!(text, "horizon     {} s", number(horizon));
    let _ = writeln!(text, "status      {}\n", ending.status);
    text += &event_table(declaration, &simulation.events);
    let trajectory = &simulation.trajectory;
    if let (Some(&time), Some(q), Some(v)) = (
        trajectory.time.last(),
        trajectory.q.last(),
        trajectory.v.last(),
    ) {
        let _ = writeln!(text, "state at t = {time} s");
        let coordinates = &declaration.coordinates[..declaration.mechanical()];
        let rows = coordinates.iter().enumerate().map(|(i, c)| {
            let unit = if c.unit.is_empty() { "1" } else { c.unit };
            vec![
                c.name.to_owned(),
                digits(q[i]),
                unit.to_owned(),
                digits(v[i]),
                per_second(c.unit),
            ]
        });
        if !coordinates.is_empty() {
            text += &table(["coordinate", "value", "", "velocity", ""], rows);
        }
        let states = declaration
            .states
            .iter()
            .zip(&v[declaration.mechanical()..]);
        let rows = states.map(|(known, value)| {
            let unit = if known.unit.is_empty() {
                "1"
            } else {
                known.unit
            };
            vec![known.name.to_owned(), digits(*value), unit.to_owned()]
        });
        if !declaration.states.is_empty() {
            text += &table(["state", "value", ""], rows);
        }
        text += "\n";
    }
    text += &work(simulation);
    if let Some(gradient) = gradient {
        text += &gradient_table(chosen.model.as_ref(), simulation, gradient);
    }
    text
}

/// The events with the states right after them.
fn event_table(declaration: &Declaration, events: &[Event]) -> String {
    if events.is_empty() {
        return "no events\n\n".to_owned();
    }
    let mechanical = declaration.mechanical();
    let coordinates = || declaration.coordinates[..mechanical].iter();
    let mut header: Vec<String> = ["event", "contact", "time [s]"].map(str::to_owned).into();
    header.extend(coordinates().map(|c| headed(c.name, c.unit)));
    header.extend(coordinates().map(|c| headed(&format!("d{}/dt", c.name), &per_second(c.unit))));
    header.extend(declaration.states.iter().map(|z| headed(z.name, z.unit)));
    let rows = events.iter().take(MOST_EVENTS).map(|event| {
        let names = [
            event.kind.name().replace('_', " "),
            declaration.contacts[event.contact].name.to_owned(),
            digits(event.time),
        ];
        let positions = &event.q[..mechanical];
        let states = positions.iter().chain(&event.v_after).copied().map(digits);
        names.into_iter().chain(states).collect()
    });
    let mut text = table(header, rows);
    if events.len() > MOST_EVENTS {
        let more = events.len() - MOST_EVENTS;
        let _ = writeln!(text, "  and {more} more, which --json and --out give");
    }
    text + "  (velocities right after the event)\n\n"
}

/// Derivatives of the end and of the events, with their units.
fn gradient_table(model: &dyn Model, simulation: &Simulation, gradient: &Gradient) -> String {
    let declaration = model.declaration();
    let units = gradient
        .with_respect_to
        .iter()
        .map(|name| unit_of(declaration, name));
    let units: Vec<String> = units.collect();
    let names = gradient.with_respect_to.iter().zip(&units);
    let headings: Vec<String> = names
        .clone()
        .map(|(name, unit)| headed(name, unit))
        .collect();
    let header = ["derivative of".to_owned()]
        .into_iter()
        .chain(names.map(|(name, unit)| headed(&format!("by {name}"), unit)));
    let mut rows = if gradient.values.is_empty() {
        end_rows(model, (&gradient.q, &gradient.v), "")
    } else {
        value_rows(model, &gradient.values, "")
    };
    for (side, name) in sides(gradient) {
        rows.extend(if gradient.values.is_empty() {
            end_rows(model, (&side.q, &side.v), name)
        } else {
            value_rows(model, &side.values, name)
        });
    }
    let events = simulation.events.iter().zip(&gradient.event_times);
    let events = events.filter(|_| gradient.values.is_empty());
    for (event, values) in events.take(MOST_EVENTS) {
        let kind = event.kind.name().replace('_', " ");
        let name = format!("time of {kind} at {}", event.contact_name);
        rows.push(derivative_row(&name, "s", values));
    }
    let to_sides = sides(gradient).into_iter();
    let to_sides = to_sides.filter_map(|(side, name)| Some((side.objective.as_ref()?, name)));
    let both = gradient.objective.as_ref().map(|values| (values, ""));
    for (values, side) in both.into_iter().chain(to_sides) {
        rows.push(derivative_row(&format!("objective{side}"), "", values));
    }
    let mut text = "\n".to_owned() + &table(header, rows) + &ranges(&headings, &gradient.ranges);
    if gradient.obstacles.iter().any(Option::is_none) {
        let about = |error| format!("about {error:.1e} of the largest in a row");
        let error = gradient.error_estimate.map_or("unknown".to_owned(), about);
        let _ = writeln!(text, "\nerror       of derivatives {error}");
    }
    if let Some(obstacle) = &gradient.obstacle {
        let _ = writeln!(text, "note        no derivatives: {obstacle}");
        if gradient.one_sided.is_some() {
            text += "            to one side there are others: what is open has none\n";
            if sides(gradient)
                .iter()
                .any(|(side, _)| !side.roots.is_empty())
            {
                text += "            where they are infinite the value moves with the root of the distance: square_root in --json\n";
            }
        }
    }
    text
}

/// Derivatives to either side, if there are such, with their words.
fn sides(gradient: &Gradient) -> Vec<(&Side, &'static str)> {
    let sides = gradient.one_sided.as_deref();
    sides.map_or_else(Vec::new, |sides| {
        vec![
            (&sides.below, ", from below"),
            (&sides.above, ", from above"),
        ]
    })
}

/// A row of the table of derivatives.
fn derivative_row(name: &str, unit: &str, values: &[f64]) -> Vec<String> {
    let values = values.iter().copied().map(digits);
    [headed(name, unit)].into_iter().chain(values).collect()
}

/// Rows of the derivatives of the state at the end.
fn end_rows(model: &dyn Model, (q, v): (&[Vec<f64>], &[Vec<f64>]), side: &str) -> Vec<Vec<String>> {
    let declaration = model.declaration();
    let mechanical = declaration.mechanical();
    let coordinates = &declaration.coordinates[..mechanical];
    let places = coordinates
        .iter()
        .zip(q)
        .map(|(c, values)| derivative_row(&format!("{} at the end{side}", c.name), c.unit, values));
    let rates = coordinates.iter().zip(v).map(|(c, values)| {
        let name = format!("d{}/dt at the end{side}", c.name);
        derivative_row(&name, &per_second(c.unit), values)
    });
    let states = declaration.states.iter().zip(v.iter().skip(mechanical));
    let states = states.map(|(state, values)| {
        derivative_row(
            &format!("{} at the end{side}", state.name),
            state.unit,
            values,
        )
    });
    places.chain(rates).chain(states).collect()
}

/// Rows of the derivatives of chosen values at the end and of times of events, but for the objective.
fn value_rows(model: &dyn Model, values: &[(String, Vec<f64>)], side: &str) -> Vec<Vec<String>> {
    let values = values.iter().filter(|(name, _)| name != "objective");
    let rows = values.map(|(name, values)| {
        if name.starts_with("event_times[") {
            return derivative_row(&format!("{name}{side}"), "s", values);
        }
        let output = model.outputs().iter().find(|output| output.name == name);
        let unit = output.map_or_else(
            || unit_of(model.declaration(), name),
            |known| known.unit.to_owned(),
        );
        derivative_row(&format!("{name} at the end{side}"), &unit, values)
    });
    rows.collect()
}

/// How far quantities, which are headed by these words, may go, a line each side; empty where nothing ends any.
pub(crate) fn ranges(names: &[String], ranges: &[SequenceRange]) -> String {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for (name, range) in names.iter().zip(ranges) {
        for limit in [&range.below, &range.above].into_iter().flatten() {
            let plus = if limit.change > 0.0 { "+" } else { "" };
            let change = format!("{plus}{}", digits(limit.change));
            rows.push(vec![name.clone(), change, limit.because.clone()]);
        }
    }
    if rows.is_empty() {
        return String::new();
    }
    let header = ["holds up to", "change", "where, to first order,"];
    "\n".to_owned() + &described(header, rows)
}

/// The unit of something that a motion is differentiated by.
fn unit_of(declaration: &Declaration, name: &str) -> String {
    let parameter = declaration
        .parameters
        .iter()
        .find(|known| known.name == name);
    let coordinates = declaration.coordinates.iter();
    let mut variables = coordinates
        .chain(declaration.controls)
        .chain(declaration.states);
    if let Some(parameter) = parameter {
        return parameter.unit.to_owned();
    }
    let rate = name
        .strip_prefix("dot(")
        .and_then(|rest| rest.strip_suffix(')'));
    let known = variables.find(|known| known.name == rate.unwrap_or(name));
    known.map_or_else(String::new, |known| match rate {
        Some(_) => per_second(known.unit),
        None => known.unit.to_owned(),
    })
}

/// Residuals, counts, CPU time, notes.
fn work(simulation: &Simulation) -> String {
    let counts = simulation.counts;
    let mut text = String::new();
    if let Some(error) = simulation.error_estimate {
        let about = if error.is_finite() {
            format!("about {error:.1e} of the largest values")
        } else {
            "unknown".to_owned()
        };
        let _ = writeln!(text, "error       {about}");
    }
    let _ = writeln!(text, "residuals   {}", residual_line(simulation.residuals));
    let _ = writeln!(
        text,
        "counts      {}, {}, {}, {}",
        counted(counts.elements, "element"),
        counted(counts.newton, "Newton iteration"),
        counted(counts.factorizations, "factorization"),
        counted(counts.evaluations, "evaluation")
    );
    let _ = writeln!(text, "CPU time    {}", seconds(simulation.seconds.total));
    for note in &simulation.notes {
        let _ = writeln!(text, "note        {note}");
    }
    text
}
