//! What every room holds: lines, numeric constants, types and public items, beside the table of what it may hold.

use std::collections::BTreeMap;
use std::path::Path;

use crate::tokens::{Token, tokens};

/// What is counted, in the order of the table.
pub(crate) const COLUMNS: [&str; 6] = ["code", "docs", "tests", "constants", "types", "public"];
/// Columns that count lines.
const LINES: usize = 3;
/// By so many lines, or by this share, a number may be lower than its row before the row is to be lowered.
const LOOSE_LINES: usize = 50;
const LOOSE_SHARE: f64 = 0.02;

/// Numbers of a room.
pub(crate) type Counts = [usize; 6];

/// The room that a file stands in: a folder of a large library, the sources of another package, or a folder of tests.
pub(crate) fn room(file: &Path) -> String {
    let parts: Vec<String> = file
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    let at = |name: &str| parts.iter().position(|part| part == name);
    if let Some(tests) = at("tests").or_else(|| at("benches")) {
        return parts[..=tests].join("/");
    }
    let Some(source) = at("src") else {
        return parts[0].clone();
    };
    let library = ["runtime", "solver"].contains(&parts[0].as_str());
    let inside = library && parts.len() > source + 2;
    parts[..=source + usize::from(inside)].join("/")
}

/// Counts a source file.
pub(crate) fn of_source(file: &Path, source: &str) -> Counts {
    let in_tests = file.iter().any(|part| part == "tests" || part == "benches");
    let end = match in_tests {
        true => 0,
        false => source.find("#[cfg(test)]\nmod ").unwrap_or(source.len()),
    };
    let written = |text: &str| text.lines().filter(|line| !line.trim().is_empty()).count();
    let (own, tests) = source.split_at(end);
    let is_comment = |line: &&str| line.trim_start().starts_with("//");
    let docs = own.lines().filter(is_comment).count();
    let tokens = tokens(own);
    let [constants, types, public] = items(&tokens);
    [
        written(own) - docs,
        docs,
        written(tests),
        constants,
        types,
        public,
    ]
}

/// Numeric constants, types, and public items.
fn items(tokens: &[Token]) -> [usize; 3] {
    let word = |at: usize| tokens.get(at).and_then(Token::word);
    let (mut constants, mut types, mut public) = (0, 0, 0);
    for at in 0..tokens.len() {
        match word(at) {
            Some("const" | "static") if tokens.get(at + 2).is_some_and(|next| next.is(':')) => {
                let behind = tokens[at + 3..].iter();
                let declared = behind.take_while(|token| !token.is('=') && !token.is(';'));
                constants += usize::from(declared.filter_map(Token::word).any(is_number));
            }
            Some("struct" | "enum" | "trait" | "union") => {
                types += usize::from(word(at + 1).is_some());
            }
            Some("pub") => {
                let kinds = [
                    "fn", "struct", "enum", "trait", "union", "const", "static", "type",
                ];
                public += usize::from(word(at + 1).is_some_and(|kind| kinds.contains(&kind)));
            }
            _ => {}
        }
    }
    [constants, types, public]
}

/// Whether a word is a type of numbers.
fn is_number(word: &str) -> bool {
    let rest = word.strip_prefix(['f', 'i', 'u']).unwrap_or_default();
    rest == "size" || rest.parse::<usize>().is_ok()
}

/// Rows by their rooms, and what stands above them; a row `room +column amount reason` raises a number.
pub(crate) struct Table {
    pub(crate) rows: BTreeMap<String, Counts>,
    /// Room, column, by how much, and why.
    pub(crate) raised: Vec<(String, usize, usize)>,
    /// Lines that begin with `#`, and rows that raise, as they stand.
    kept: Vec<String>,
}

impl Table {
    /// Reads a table.
    pub(crate) fn read(text: &str) -> Self {
        let mut table = Self {
            rows: BTreeMap::new(),
            raised: Vec::new(),
            kept: Vec::new(),
        };
        for line in text.lines() {
            let cells: Vec<&str> = line.split('\t').collect();
            let raises = cells.get(1).and_then(|cell| cell.strip_prefix('+'));
            if line.starts_with('#') || raises.is_some() {
                table.kept.push(line.to_owned());
            }
            if line.starts_with('#') {
                continue;
            }
            if let Some(column) = raises {
                let column = COLUMNS.iter().position(|known| *known == column);
                let column = column.unwrap_or_else(|| panic!("no such column: {line}"));
                let reason = cells.get(3).is_some_and(|reason| reason.len() > 10);
                assert!(reason, "a number is raised with a reason: {line}");
                let amount = cells[2].parse().expect("by how much it is raised");
                table.raised.push((cells[0].to_owned(), column, amount));
                continue;
            }
            let numbers: Vec<usize> = cells[1..].iter().filter_map(|n| n.parse().ok()).collect();
            let counts = numbers.try_into().expect("a number for each column");
            table.rows.insert(cells[0].to_owned(), counts);
        }
        table
    }

    /// What a room may hold.
    fn most(&self, room: &str) -> Counts {
        let mut most = self.rows.get(room).copied().unwrap_or_default();
        for (raised, column, amount) in &self.raised {
            if raised == room {
                most[*column] += amount;
            }
        }
        most
    }

    /// What is above the table, and what is so much below that its row is to be lowered: each with what to write.
    pub(crate) fn differs(&self, found: &BTreeMap<String, Counts>) -> [Vec<String>; 2] {
        let (mut above, mut below) = (Vec::new(), Vec::new());
        let gone = self.rows.keys().filter(|room| !found.contains_key(*room));
        below.extend(gone.map(|room| format!("{room} is gone: remove its row")));
        for (room, counts) in found {
            let most = self.most(room);
            for (column, (&count, &most)) in counts.iter().zip(&most).enumerate() {
                let name = COLUMNS[column];
                if count > most {
                    above.push(format!(
                        "{room} has {count} {name}, {} more than its row; take as many out, or add the row\n{room}\t+{name}\t{}\tWHY",
                        count - most,
                        count - most
                    ));
                }
                let loose = column < LINES && most.saturating_sub(count) > LOOSE_LINES;
                let share = (most.saturating_sub(count)) as f64 > LOOSE_SHARE * most as f64;
                if loose || share && most > LOOSE_LINES {
                    below.push(format!("{room} has {count} {name} in place of {most}"));
                }
            }
        }
        [above, below]
    }

    /// The table with every number that is lower now, as far as rows that raise do not stand for it, and without rows of rooms that are gone.
    pub(crate) fn lowered(&self, found: &BTreeMap<String, Counts>) -> String {
        let mut lines = self.kept.clone();
        for (room, row) in &self.rows {
            if let Some(counts) = found.get(room) {
                let most = self.most(room);
                let number = |k: usize| row[k].min((counts[k] + row[k]).saturating_sub(most[k]));
                let numbers: Vec<String> = (0..row.len()).map(|k| number(k).to_string()).collect();
                lines.push(format!("{room}\t{}", numbers.join("\t")));
            }
        }
        lines.join("\n") + "\n"
    }
}
