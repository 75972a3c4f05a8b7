//! A measured cell, and its line of a table.

/// The heading of the table.
const HEADING: &str = "family,bodies,method,contacts,load_s,run_s,memory_mb,ended";

/// One method on one scene.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// Name of the family.
    pub(crate) family: String,
    /// Number of bodies.
    pub(crate) bodies: usize,
    /// Name of the method.
    pub(crate) method: String,
    /// Number of contacts.
    pub(crate) contacts: usize,
    /// CPU time to load the text \[s\].
    pub(crate) load: f64,
    /// CPU time of the run \[s\].
    pub(crate) seconds: f64,
    /// Most memory that the program held \[MB\].
    pub(crate) memory: f64,
    /// How it ended, if not as it should.
    pub(crate) ended: String,
}

impl Row {
    /// Its line.
    pub(crate) fn line(&self) -> String {
        format!(
            "\"{}\",{},{},{},{:.6},{:.6},{:.1},\"{}\"",
            self.family,
            self.bodies,
            self.method,
            self.contacts,
            self.load,
            self.seconds,
            self.memory,
            self.ended.replace('"', "'")
        )
    }

    /// The row of a line, if it is one.
    pub(crate) fn read(line: &str) -> Option<Self> {
        let (mut cells, mut quoted) = (vec![String::new()], false);
        for character in line.trim().chars() {
            match character {
                '"' => quoted = !quoted,
                ',' if !quoted => cells.push(String::new()),
                other => cells.last_mut()?.push(other),
            }
        }
        let cells: [String; 8] = cells.try_into().ok()?;
        let [
            family,
            bodies,
            method,
            contacts,
            load,
            seconds,
            memory,
            ended,
        ] = cells;
        Some(Self {
            family,
            bodies: bodies.parse().ok()?,
            method,
            contacts: contacts.parse().ok()?,
            load: load.parse().ok()?,
            seconds: seconds.parse().ok()?,
            memory: memory.parse().ok()?,
            ended,
        })
    }

    /// What grows: contacts, or bodies where there is one contact whatever their number.
    pub(crate) fn size(&self) -> f64 {
        if self.contacts > 1 {
            self.contacts as f64
        } else {
            self.bodies as f64
        }
    }
}

/// The power of the size by which time has grown from one row to another.
pub(crate) fn exponent(before: &Row, row: &Row) -> Option<f64> {
    let growth = row.size() / before.size();
    (growth > 1.0).then(|| (row.seconds / before.seconds).ln() / growth.ln())
}

/// All rows with a heading.
pub(crate) fn table(rows: &[Row]) -> String {
    let lines: Vec<String> = rows.iter().map(Row::line).collect();
    format!("{HEADING}\n{}\n", lines.join("\n"))
}
