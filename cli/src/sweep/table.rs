//! Tables of sweeps in files: whole lines, in the order of their points.

use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::Path;

use crate::failure::BadInput;

use super::plan::SweepPlan;

/// A table that rows are appended to.
pub(super) struct Table<'a> {
    file: File,
    path: &'a Path,
}

impl<'a> Table<'a> {
    /// Begins a table, or goes on with one if `resume`; returns how many rows of `points` are in it. What a killed run
    /// left of a line is cut off.
    pub(super) fn open(
        path: &'a Path,
        plan: &SweepPlan,
        points: &[usize],
        resume: bool,
    ) -> Result<(Self, usize), BadInput> {
        let refused = |what: String| BadInput::new(format!("--out `{}`: {what}", path.display()));
        let failed = |error| refused(format!("{error}; give a file that can be written"));
        let mut options = OpenOptions::new();
        options.create(true).read(true).append(true);
        let file = options.open(path).map_err(failed)?;
        let text = fs::read(path).map_err(failed)?;
        let mut table = Self { file, path };
        if !text.is_empty() && !resume {
            return Err(refused(
                "is there already; add --resume to go on with it, or give another file".to_owned(),
            ));
        }
        let whole = text
            .iter()
            .rposition(|&byte| byte == b'\n')
            .map_or(0, |end| end + 1);
        table.file.set_len(whole as u64).map_err(failed)?;
        let text = String::from_utf8_lossy(&text[..whole]);
        let mut lines = text.lines();
        match lines.next() {
            None => {
                table.append(&plan.header())?;
                return Ok((table, 0));
            }
            Some(header) if header == plan.header() => {}
            Some(_) => return Err(refused(OTHER.to_owned())),
        }
        let mut done = 0;
        for line in lines {
            let expected = points.get(done).map(ToString::to_string);
            let number = line.split(',').next().map(str::to_owned);
            if expected.is_none() || number != expected || mark(line) != Some(plan.mark()) {
                return Err(refused(OTHER.to_owned()));
            }
            done += 1;
        }
        Ok((table, done))
    }

    /// Appends one line; it is handed to the system as a whole.
    pub(super) fn append(&mut self, row: &str) -> Result<(), BadInput> {
        let line = format!("{row}\n");
        self.file.write_all(line.as_bytes()).map_err(|error| {
            BadInput::new(format!(
                "--out `{}`: {error}; make room, and go on with --resume",
                self.path.display()
            ))
        })
    }
}

/// Why a file is no beginning of a table.
const OTHER: &str = "holds rows of another sweep (other scene, options, values, records or shard); give another file, \
     or remove it";

/// The mark at the end of a row.
fn mark(row: &str) -> Option<&str> {
    row.rsplit(',').next()
}

/// Joins tables of the shards of one sweep: returns header and rows, as the whole sweep would have written them.
pub(super) fn join(files: &[std::path::PathBuf]) -> Result<(String, usize), BadInput> {
    let mut header: Option<String> = None;
    let mut rows: Vec<(usize, String)> = Vec::new();
    let mut common: Option<String> = None;
    for file in files {
        let shown = file.display();
        let refused = |what: &str| BadInput::new(format!("--join `{shown}`: {what}"));
        let text = fs::read_to_string(file)
            .map_err(|error| refused(&format!("{error}; give the tables of all shards")))?;
        if !text.ends_with('\n') {
            return Err(refused(
                "ends within a row; finish that shard with --resume",
            ));
        }
        let mut lines = text.lines();
        let first = lines.next().unwrap_or_default();
        if header.get_or_insert_with(|| first.to_owned()) != first {
            return Err(refused("has other columns than the first table"));
        }
        for line in lines {
            let mark = mark(line).unwrap_or_default();
            if common.get_or_insert_with(|| mark.to_owned()) != mark {
                return Err(refused("holds rows of another sweep than the first table"));
            }
            let number = line
                .split(',')
                .next()
                .and_then(|number| number.parse().ok());
            let number = number.ok_or_else(|| refused("is no table of a sweep"))?;
            rows.push((number, line.to_owned()));
        }
    }
    rows.sort();
    // The same row may be in several files; a point with two different rows may not.
    rows.dedup();
    let count = common.as_deref().and_then(|mark| mark.split_once('/'));
    let count: usize = count
        .and_then(|(_, count)| count.parse().ok())
        .ok_or_else(|| {
            BadInput::new("--join: the tables hold no rows; give the tables of all shards")
        })?;
    if let Some(pair) = rows.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(BadInput::new(format!(
            "--join: point {} has two different rows; remove the table that is wrong",
            pair[0].0
        )));
    }
    let missing = (0..count).find(|&k| rows.get(k).is_none_or(|&(number, _)| number != k));
    if let Some(missing) = missing {
        return Err(BadInput::new(format!(
            "--join: {} of {count} points are in no table, the first of them is {missing}; finish their shards with \
             --resume",
            count.saturating_sub(rows.len())
        )));
    }
    let lines = header
        .into_iter()
        .chain(rows.into_iter().map(|(_, row)| row));
    Ok((lines.map(|line| line + "\n").collect(), count))
}
