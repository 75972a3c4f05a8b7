//! `hangtime profile`: a table of measured points as a statement of the language.

use std::fmt::Write as _;
use std::fs;

use crate::arguments::ProfileArguments;
use crate::failure::BadInput;
use crate::report::Report;

/// Largest table that is read, in bytes: far above the points that a profile may have.
const LARGEST: u64 = 4 << 20;

/// Prints the `profile` of the points in a file.
pub(crate) fn run(arguments: &ProfileArguments) -> Result<Report, BadInput> {
    let file = &arguments.file;
    let refuse = |what: &str| Err(BadInput::new(format!("{}: {what}", file.display())));
    let text = match fs::metadata(file).and_then(|known| {
        let small = known.len() <= LARGEST;
        small.then(|| fs::read_to_string(file)).transpose()
    }) {
        Ok(Some(text)) => text,
        Ok(None) => return refuse("more than 4 MB; a profile has at most 5000 points, keep fewer"),
        Err(error) => {
            return refuse(&format!(
                "{error}; give a table of two columns, a point a line"
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
}

/// Reads a table: a point a line, possibly with names and units, such as `s [m]`, in the first one.
fn table(text: &str) -> Result<Table, String> {
    let mut table = Table {
        columns: [("s".into(), String::new()), ("h".into(), String::new())],
        points: Vec::new(),
    };
    let text = text.trim_start_matches('\u{feff}');
    let lines = text.lines().enumerate();
    let mut lines = lines
        .map(|(number, line)| (number + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        .peekable();
    if let Some((_, first)) = lines.peek()
        && point(first).is_none()
        && first.chars().any(char::is_alphabetic)
    {
        for (column, heading) in table.columns.iter_mut().zip(first.split([',', ';', '\t'])) {
            *column = heading_of(heading, &column.0);
        }
        lines.next();
    }
    for (number, line) in lines {
        let Some(point) = point(line) else {
            return Err(format!(
                "line {number}, `{}`: two numbers are needed, such as `0.5, 0.12`",
                line.chars().take(60).collect::<String>()
            ));
        };
        table.points.push(point);
    }
    Ok(table)
}

/// Two numbers between commas, semicolons or blanks; between semicolons a comma is a decimal point.
fn point(line: &str) -> Option<[String; 2]> {
    let line = match line.contains(';') {
        true => line.replace(',', "."),
        false => line.to_owned(),
    };
    let mut cells = line
        .split(|c: char| c == ',' || c == ';' || c.is_whitespace())
        .filter(|cell| !cell.is_empty());
    let mut next = || -> Option<String> {
        let value: f64 = cells.next()?.parse().ok()?;
        value.is_finite().then(|| format!("{value:?}"))
    };
    Some([next()?, next()?])
}

/// Name and unit of a heading such as `s [m]` or `s (m)`.
fn heading_of(heading: &str, otherwise: &str) -> (String, String) {
    let heading = heading.trim().trim_matches('"');
    let (called, unit) = heading.split_once(['[', '(']).unwrap_or((heading, ""));
    let unit = unit.trim_end_matches([']', ')']).trim();
    let unit = match unit.parse::<hangtime_units::Unit>() {
        Ok(_) => unit.to_owned(),
        Err(_) => String::new(),
    };
    (name(called.trim(), otherwise), unit)
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
    let usable =
        name.starts_with(|c: char| c.is_ascii_alphabetic()) && !hangtime_dsl::is_word(name);
    if usable {
        name.to_owned()
    } else {
        otherwise.to_owned()
    }
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
        let scene = format!("coordinates {{ position }} lagrangian dot(position)^2/2 {text}");
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
        let plain = statement("0 1\n1 2\n2 4\n3 5\n4 5\n5 5\n6 5").unwrap();
        assert!(
            plain.starts_with("profile hill(s) {\n    (0.0, 1.0)") && plain.lines().count() == 9
        );
    }

    #[test]
    fn tables_that_are_none_are_refused_with_the_line_or_the_reason() {
        for (text, reason) in [
            ("0,1\n1,two\n", "line 2, `1,two`"),
            ("s,z\n0,1\n", "and has 1"),
            ("0,1\n2,1\n1,1\n", "1 follows 2"),
            ("", "and has 0"),
        ] {
            let message = statement(text).unwrap_err();
            assert!(message.contains(reason), "{message}");
        }
    }
}
