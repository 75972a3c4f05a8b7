//! `hangtime profile`: a table of measured points as a statement of the language.

use std::fmt::Write as _;

use crate::arguments::ProfileArguments;
use crate::cells::{cells, number_of, regular_text, short};
use crate::failure::BadInput;
use crate::report::Report;
use crate::table::counted;

/// Largest table that is read, in bytes: far above the points that a profile may have.
const LARGEST: u64 = 4 << 20;

/// Most points of a profile.
const MOST: usize = 5_000;

/// Most bytes of its statement, some less than those of a scene file.
const LONGEST: usize = 65_000;

/// The scene in which the language is asked.
const SCENE: &str = "coordinates { position_ } lagrangian dot(position_)^2/2";

/// Prints the `profile` of the points in a file.
pub(crate) fn run(arguments: &ProfileArguments) -> Result<Report, BadInput> {
    let file = &arguments.file;
    let refuse = |what: &str| Err(BadInput::new(format!("{}: {what}", file.display())));
    let text = match regular_text(file, LARGEST) {
        Ok(text) => text,
        Err(error) => {
            return refuse(&format!(
                "{error}; give a table of two columns, a point a line, at most {MOST} of them"
            ));
        }
    };
    let stem = file.file_stem().and_then(|stem| stem.to_str());
    match table(&text).and_then(|table| table.statement(&name(stem.unwrap_or_default(), "track"))) {
        Ok(statement) => Ok(Report::of(statement)),
        Err(message) => refuse(&message),
    }
}

/// Two columns of a file.
#[derive(Debug)]
struct Table {
    /// Names and units, empty where none is given.
    columns: [(String, String); 2],
    points: Vec<[String; 2]>,
    /// The last argument.
    last: Option<f64>,
}

/// Reads a table: a point a line, possibly with names and units, such as `s [m]`, in the first one.
fn table(text: &str) -> Result<Table, String> {
    let mut table = Table {
        columns: [("s".into(), String::new()), ("h".into(), String::new())],
        points: Vec::new(),
        last: None,
    };
    let text = text.trim_start_matches('\u{feff}');
    let lines = text.lines().enumerate();
    let mut lines = lines
        .map(|(number, line)| (number + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        .peekable();
    if let Some(&(number, first)) = lines.peek()
        && is_heading(first)
    {
        for (column, heading) in table.columns.iter_mut().zip(two(number, first)?) {
            *column = heading_of(&heading, &column.0)
                .map_err(|what| format!("line {number}, `{}`: {what}", short(&heading)))?;
        }
        lines.next();
    }
    for (number, line) in lines {
        let point = two(number, line)?;
        let needed = |what: &str| format!("line {number}, `{}`: {what}", short(line));
        let [Some(x), Some(y)] = point.map(|cell| number_of(&cell)) else {
            return Err(needed("two finite numbers are needed, such as `0.5, 0.12`"));
        };
        if table.last.is_some_and(|before| x <= before) {
            return Err(needed(
                "the points must go from left to right, each farther right than the one before",
            ));
        }
        table.last = Some(x);
        table.points.push([x, y].map(|value| format!("{value:?}")));
    }
    if table.points.len() > MOST {
        return Err(format!(
            "{} points, where a profile has at most {MOST}; keep every second, third, ... line",
            table.points.len()
        ));
    }
    Ok(table)
}

/// Whether a line holds names instead of a point.
fn is_heading(line: &str) -> bool {
    let cells = cells(line);
    let begins =
        |cell: &String| cell.starts_with(|c: char| !c.is_ascii_digit() && !"+-.".contains(c));
    cells.first().is_some_and(begins) && cells.iter().all(|cell| cell.parse::<f64>().is_err())
}

/// The two cells of a line.
fn two(number: usize, line: &str) -> Result<[String; 2], String> {
    <[String; 2]>::try_from(cells(line)).map_err(|cells| {
        format!(
            "line {number}, `{}`: {}, where a point has two; leave the others out, and write decimals with a point, or \
             semicolons between the columns",
            short(line),
            counted(cells.len(), "column")
        )
    })
}

/// Name and unit of a heading such as `s [m]` or `s (m)`.
fn heading_of(heading: &str, otherwise: &str) -> Result<(String, String), String> {
    let Some((called, rest)) = heading.split_once(['[', '(']) else {
        return Ok((name(heading, otherwise), String::new()));
    };
    let Some(unit) = rest.trim_end().strip_suffix([']', ')']) else {
        return Err("the unit ends with a bracket, as in `s [m]`".to_owned());
    };
    let unit = unit.trim();
    // A number without a unit.
    if unit == "-" {
        return Ok((name(called.trim(), otherwise), String::new()));
    }
    match unit.parse::<hangtime_units::Unit>() {
        Ok(_) => Ok((name(called.trim(), otherwise), unit.to_owned())),
        Err(error) => Err(format!("{error}; write a unit such as `s [m]`, or none")),
    }
}

/// A name of the language that reads like a text.
fn name(text: &str, otherwise: &str) -> String {
    let mut name = String::new();
    for c in text.chars() {
        if c.is_ascii_alphanumeric() {
            name.push(c);
        } else if !name.ends_with('_') && !name.is_empty() {
            name.push('_');
        }
    }
    let name = name.trim_end_matches('_');
    if is_free(name) {
        name.to_owned()
    } else {
        otherwise.to_owned()
    }
}

/// Whether a function may have this name.
fn is_free(name: &str) -> bool {
    let scene = format!("{SCENE} fn {name}(argument_) = argument_");
    hangtime_dsl::describe_text(&scene, "profile").is_ok()
}

impl Table {
    /// The statement, which the language has accepted.
    fn statement(&self, called: &str) -> Result<String, String> {
        let of = |unit: &str| match unit {
            "" => String::new(),
            unit => format!(": {unit}"),
        };
        let [(argument, argument_unit), (_, value_unit)] = &self.columns;
        let mut text = format!(
            "profile {called}({argument}{}){} {{\n",
            of(argument_unit),
            of(value_unit)
        );
        for [x, y] in &self.points {
            let _ = writeln!(text, "    ({x}, {y}),");
        }
        text.push_str("}\n");
        if text.len() > LONGEST {
            return Err(format!(
                "its `profile` has {} bytes, more than the {LONGEST} of a scene file; keep every second, third, ... line",
                text.len()
            ));
        }
        let scene = format!("{SCENE} {text}");
        match hangtime_dsl::describe_text(&scene, "profile") {
            Ok(_) => Ok(text),
            Err(mistakes) => Err(mistakes
                .into_iter()
                .find(|mistake| mistake.code != Some("E16"))
                .map_or_else(String::new, |mistake| mistake.message)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::table;

    fn statement(text: &str) -> Result<String, String> {
        table(text).and_then(|table| table.statement("hill"))
    }

    #[test]
    fn tables_of_any_style_are_read_with_names_and_units() {
        for text in [
            "s [m],z [mm]\n0,0\n0.5,120\n1,-200\n",
            "\u{feff}\"s (m)\";z (mm)\r\n0;0\r\n0,5;120\r\n1;-2e2\r\n",
            "s [m]\tz [mm]\n# a remark\n\n0 0\n .5 120\n1\t-200",
        ] {
            assert_eq!(
                statement(text).unwrap(),
                "profile hill(s: m): mm {\n    (0.0, 0.0),\n    (0.5, 120.0),\n    (1.0, -200.0),\n}\n"
            );
        }
        let named = table("t [m] z [-]\n0 1\n1 2\n2 4").unwrap();
        assert_eq!(
            named.columns,
            [("s", "m"), ("z", "")].map(|(name, unit)| (name.to_owned(), unit.to_owned()))
        );
        assert_eq!(super::name("t", "track"), "track");
        let plain = statement("0 1\n1 2\n2 4\n3 5\n4 5\n5 5\n6 5").unwrap();
        assert!(
            plain.starts_with("profile hill(s) {\n    (0.0, 1.0)") && plain.lines().count() == 9
        );
    }

    #[test]
    fn tables_that_are_none_are_refused_with_the_line_or_the_reason() {
        for line in "\
            0,1|1,two => line 2, `1,two`
            s,z|0,1 => and has 1
            0,1|2,1|1,1 => line 3, `1,1`: the points must go from left to right
            s,z,w|0,1,2 => line 1, `s,z,w`: 3 columns, where a point has two
            0,1|1,5,2,5 => line 2, `1,5,2,5`: 4 columns
            0 1 2 => line 1, `0 1 2`: 3 columns
            0,1|1,,2 => line 2, `1,,2`: 3 columns
            s|0,1 => line 1, `s`: 1 column,
            0,1|1,NaN => line 2, `1,NaN`: two finite numbers
            inf,1|1,2 => line 1, `inf,1`: two finite numbers
            0x10,1|20,2 => line 1, `0x10,1`: two finite numbers
            0,1|1,2 m => line 2, `1,2 m`: two finite numbers
            s [furlong],z|0,1 => line 1, `s [furlong]`: unknown unit
            s [mm,z|0,1 => line 1, `s [mm`: the unit ends"
            .lines()
        {
            let (text, reason) = line.trim().split_once(" => ").unwrap();
            let message = statement(&text.replace('|', "\n")).unwrap_err();
            assert!(message.contains(reason), "{message}");
        }
        assert!(statement("").unwrap_err().contains("and has 0"));
        let many: String = (0..6000).map(|i| format!("{i},0\n")).collect();
        let message = statement(&many).unwrap_err();
        assert!(message.contains("6000 points"), "{message}");
    }
}
