//! Measured motions from tables: a line a time, names and units in the first one.

use std::path::Path;

use hangtime::estimation::Measurements;
use hangtime::model::{Experiment, VariableDeclaration};
use hangtime::simulation::ControlSignal;
use hangtime_units::Unit;

use crate::cells::{cells, number_of, regular_text, short};
use crate::failure::{BadInput, did_you_mean};
use crate::table::counted;

/// Largest table that is read, in bytes.
const LARGEST: u64 = 64 << 20;
/// Why a table is none that has no line.
const EMPTY: &str =
    "the table is empty; its first line has names and units, such as `t [s], z [cm]`";
/// What the column of times may be called.
const TIMES: [&str; 2] = ["t", "time"];

/// Reads the measurements of an experiment of a scene with these controls; a path that is not absolute is that from `folder`.
pub(crate) fn read(
    folder: &Path,
    experiment: &Experiment,
    controls: &[VariableDeclaration],
) -> Result<Measurements, BadInput> {
    if let Some(text) = experiment.table() {
        let refuse =
            |what| BadInput::new(format!("measured `{}`, its table: {what}", experiment.name));
        return table(text, experiment, controls).map_err(refuse);
    }
    let file = folder.join(experiment.file);
    let refuse = |what: &str| {
        let file = file.display();
        BadInput::new(format!("measured `{}`, {file}: {what}", experiment.name))
    };
    let text = regular_text(&file, LARGEST).map_err(|error| {
        refuse(&format!(
            "{error}; give a table with a column of times and one for each quantity, or write it between the \
             quotation marks, on lines of its own"
        ))
    })?;
    table(&text, experiment, controls).map_err(|what| refuse(&what))
}

/// A column that is read.
struct Column {
    /// Its place in a line.
    place: usize,
    /// Its heading, for messages.
    heading: String,
    /// How many units of the scene one of its units is.
    factor: f64,
}

impl Column {
    /// What it is called in messages.
    fn called(&self) -> String {
        format!("column {} (`{}`)", self.place + 1, self.heading)
    }

    /// What a line has in it, in the unit of the scene; not a number where that is nothing.
    fn number(&self, cells: &[String]) -> Result<f64, String> {
        let text = cells[self.place].as_str();
        match (text.is_empty(), number_of(text)) {
            (true, _) => Ok(f64::NAN),
            (false, Some(value)) => Ok(value * self.factor),
            (false, None) => Err(format!(
                "`{}` is no finite number; write one, or leave the cell empty where nothing was measured",
                short(text)
            )),
        }
    }
}

/// Reads a table. Controls keep the value of a line until the next one that has another.
fn table(
    text: &str,
    experiment: &Experiment,
    controls: &[VariableDeclaration],
) -> Result<Measurements, String> {
    let text = text.trim_start_matches('\u{feff}');
    let lines = text.lines().enumerate();
    let mut lines = lines
        .map(|(number, line)| (number + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let Some((number, first)) = lines.next() else {
        return Err(EMPTY.to_owned());
    };
    let headings = cells(first);
    let (time, columns, given) = columns(&headings, experiment, controls)
        .map_err(|what| format!("line {number}, {what}"))?;
    let mut measurements = Measurements::default();
    let mut steps = Steps::default();
    for (number, line) in lines {
        let cells = cells(line);
        if cells.len() != headings.len() {
            return Err(format!(
                "line {number}, `{}`: {}, where the first line names {}; write decimals with a point, or semicolons \
                 between the columns",
                short(line),
                counted(cells.len(), "column"),
                headings.len()
            ));
        }
        let wrong =
            |column: &Column, what: &str| format!("line {number}, {}: {what}", column.called());
        let cell = |column: &Column| column.number(&cells).map_err(|what| wrong(column, &what));
        let at = cell(&time)?;
        let before = measurements.times.last().copied().unwrap_or(0.0);
        if at.is_nan() || at < before {
            let wanted = match measurements.times.is_empty() {
                true => {
                    "times count from the start of the motion on, so that the first is at least 0"
                        .to_owned()
                }
                false => format!("times do not go back: the one before is {before} s"),
            };
            let text = short(&cells[time.place]);
            return Err(wrong(&time, &format!("`{text}`; {wanted}")));
        }
        let numbers =
            |columns: &[Column]| -> Result<Vec<f64>, String> { columns.iter().map(cell).collect() };
        let (row, acts) = (numbers(&columns)?, numbers(&given)?);
        if let Some(k) = steps.take(at, acts) {
            return Err(wrong(
                &given[k],
                "nothing says what the control was at first; write its first value into this line",
            ));
        }
        measurements.times.push(at);
        measurements.values.push(row);
    }
    if !controls.is_empty() {
        measurements.controls = ControlSignal::PiecewiseConstant {
            times: steps.times,
            values: steps.values,
        };
    }
    Ok(measurements)
}

/// Controls that keep their values until others follow.
#[derive(Default)]
struct Steps {
    times: Vec<f64>,
    values: Vec<Vec<f64>>,
}

impl Steps {
    /// Takes the values from a time on, those that are not numbers as before. The control that has no value yet, if there is one.
    fn take(&mut self, time: f64, mut values: Vec<f64>) -> Option<usize> {
        if let Some(before) = self.values.last() {
            for (value, before) in values.iter_mut().zip(before) {
                *value = if value.is_nan() { *before } else { *value };
            }
        }
        if let Some(k) = values.iter().position(|value| value.is_nan()) {
            return Some(k);
        }
        match (self.times.last(), self.values.last_mut()) {
            (_, Some(before)) if *before == values => {}
            (Some(&last), Some(before)) if last == time => *before = values,
            (last, _) => {
                // What is first written of them held from the start on.
                self.times.push(if last.is_some() { time } else { 0.0 });
                self.values.push(values);
            }
        }
        None
    }
}

/// The columns of the times, of all quantities, and of all controls.
fn columns(
    headings: &[String],
    experiment: &Experiment,
    controls: &[VariableDeclaration],
) -> Result<(Column, Vec<Column>, Vec<Column>), String> {
    let names: Vec<(&str, Option<&str>)> = headings.iter().map(|text| heading(text)).collect();
    let find = |wanted: &[&str], unit: &str, what: &str| {
        let mut places = (0..names.len()).filter(|&place| wanted.contains(&names[place].0));
        let Some(place) = places.next() else {
            let known = || names.iter().map(|name| name.0);
            return Err(format!(
                "no column is called `{}`{}; {what}, as in `{} [{}]` (columns: {})",
                wanted[0],
                did_you_mean(wanted[0], known()),
                wanted[0],
                if unit.is_empty() { "1" } else { unit },
                known().collect::<Vec<_>>().join(", ")
            ));
        };
        if let Some(second) = places.next() {
            return Err(format!(
                "column {} (`{}`): this is measured in column {} already; rename one",
                second + 1,
                headings[second],
                place + 1
            ));
        }
        let factor = factor(names[place].1, unit)
            .map_err(|error| format!("column {} (`{}`): {error}", place + 1, headings[place]))?;
        Ok(Column {
            place,
            heading: headings[place].clone(),
            factor,
        })
    };
    let time = find(&TIMES, "s", "the column of the times is")?;
    let quantities = experiment.quantities.iter();
    let columns = quantities.map(|quantity| {
        find(
            &[quantity.name],
            quantity.unit,
            "the scene compares with it",
        )
    });
    let columns = columns.collect::<Result<_, String>>()?;
    let given = controls
        .iter()
        .map(|control| find(&[control.name], control.unit, "a control of the scene is"));
    Ok((time, columns, given.collect::<Result<_, String>>()?))
}

/// Name and unit of a heading such as `z [cm]`, `z (cm)` or `dot(z) [m/s]`.
fn heading(text: &str) -> (&str, Option<&str>) {
    let text = text.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        let Some(inner) = text.strip_suffix(close) else {
            continue;
        };
        let Some((name, unit)) = inner.rsplit_once(open) else {
            continue;
        };
        // The parentheses of a velocity belong to its name.
        if name.trim() != "dot" {
            return (name.trim(), Some(unit.trim()));
        }
    }
    (text, None)
}

/// How many units `to` one of `from` is; a number without a unit is in `to` already.
fn factor(from: Option<&str>, to: &str) -> Result<f64, String> {
    let Some(from) = from else { return Ok(1.0) };
    let parse = |unit: &str| match unit {
        "" | "-" => "1".parse::<Unit>(),
        unit => unit.parse::<Unit>(),
    };
    let (own, wanted) = (
        parse(from).map_err(|error| error.to_string())?,
        parse(to).map_err(|error| error.to_string())?,
    );
    if own.exponents != wanted.exponents {
        return Err(format!(
            "`{from}` is no unit of what is measured; write one that converts to {}, or none for that",
            if to.is_empty() { "1" } else { to }
        ));
    }
    Ok(own.scale / wanted.scale)
}

#[cfg(test)]
mod tests {
    use super::{EMPTY, table};
    use hangtime::model::{Experiment, Measured, MeasuredQuantity, VariableDeclaration};
    use hangtime::simulation::ControlSignal;

    const EXPERIMENT: Experiment = Experiment {
        name: "flight",
        documentation: "",
        file: "flight.csv",
        quantities: &[
            MeasuredQuantity {
                name: "z",
                unit: "m",
                measured: Measured::Coordinate(0),
                within: 0.01,
            },
            MeasuredQuantity {
                name: "dot(phi)",
                unit: "rad/s",
                measured: Measured::Velocity(1),
                within: 0.1,
            },
        ],
        huber: None,
        own_start: false,
    };

    #[test]
    fn tables_of_any_style_are_read_in_the_units_of_the_scene() {
        for text in [
            "t [ms],z [cm],dot(phi) [rev/s]\n0,150,1\n20,148,\n",
            "\u{feff}dot(phi) [rev/s];\"time (s)\";remark;z (cm)\r\n1;0;a;150\r\n;0,02;b;148\r\n",
            "# a remark\nt [ms]\tdot(phi) [rev/s]\tz [cm]\n\n0\t1\t150\n20\t\t148",
        ] {
            let read = table(text, &EXPERIMENT, &[]).unwrap();
            assert_eq!(read.times, [0.0, 0.02]);
            let turn = 2.0 * std::f64::consts::PI;
            assert!(
                (read.values[0][0] - 1.5).abs() < 1e-15 && (read.values[1][0] - 1.48).abs() < 1e-15
            );
            assert!((read.values[0][1] - turn).abs() < 1e-14 && read.values[1][1].is_nan());
        }
    }

    const CONTROLS: [VariableDeclaration; 1] = [VariableDeclaration {
        name: "u",
        unit: "N",
        documentation: "",
    }];

    #[test]
    fn controls_hold_from_the_line_that_has_them_on() {
        let text = "t,z,dot(phi),u [kN]\n0.1,1,2,0.01\n0.2,1,2,\n0.3,1,2,0.01\n0.4,1,2,-0.02\n0.4,1,2,0.03\n";
        let read = table(text, &EXPERIMENT, &CONTROLS).unwrap();
        let steps = ControlSignal::PiecewiseConstant {
            times: vec![0.0, 0.4],
            values: vec![vec![10.0], vec![30.0]],
        };
        assert_eq!(read.controls, steps);
        for (text, reason) in [
            ("t,z,dot(phi)\n0,1,2\n", "line 1, no column is called `u`"),
            (
                "t,z,dot(phi),u [m]\n0,1,2,3\n",
                "line 1, column 4 (`u [m]`): `m` is no unit of",
            ),
            (
                "t,z,dot(phi),u\n0,1,2,\n",
                "line 2, column 4 (`u`): nothing says what the control was at first",
            ),
        ] {
            let message = table(text, &EXPERIMENT, &CONTROLS).unwrap_err();
            assert!(message.contains(reason), "{message}");
        }
    }

    #[test]
    fn tables_that_are_none_are_refused_with_line_and_column() {
        assert!(table("", &EXPERIMENT, &[]).is_err_and(|said| said == EMPTY));
        for line in "\
            t,z|0,1 => line 1, no column is called `dot(phi)`
            a,z,dot(phi)| => line 1, no column is called `t`
            t,z [kg],dot(phi)| => line 1, column 2 (`z [kg]`): `kg` is no unit of
            t,z [furlong],dot(phi)| => line 1, column 2 (`z [furlong]`): unknown unit
            t,z,z [cm],dot(phi)| => line 1, column 3 (`z [cm]`): this is measured in column 2
            t [s],z [m],dot(phi)|0,1,2|0.1,1.5m,2 => line 3, column 2 (`z [m]`): `1.5m` is no finite number
            t [s],z [m],dot(phi)|0,1,2||0.1,1 => line 4, `0.1,1`: 2 columns, where the first line names 3
            t [s],z [m],dot(phi)|0,1,2|0.2,1,2|0.1,1,2 => line 4, column 1 (`t [s]`): `0.1`; times do not go back
            t [s],z [m],dot(phi)|-1,1,2 => line 2, column 1 (`t [s]`): `-1`; times count from the start
            t [s],z [m],dot(phi)|,1,2 => line 2, column 1 (`t [s]`): ``; times count
            t [s],z [m],dot(phi)|0,inf,2 => line 2, column 2 (`z [m]`): `inf` is no finite number"
            .lines()
        {
            let (text, reason) = line.trim().split_once(" => ").unwrap();
            let text = text.replace('|', "\n");
            let message = table(&text, &EXPERIMENT, &[]).unwrap_err();
            assert!(message.contains(reason), "{message}");
        }
    }
}
