//! Tables of sweeps in files: whole lines, in the order of their points, of one writer at a time.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufRead as _, BufReader, Read as _, Write as _};
use std::path::{Path, PathBuf};

use crate::cells::regular_text;
use crate::failure::BadInput;
use crate::host::Refusal;

use super::plan::SweepPlan;

/// A table that rows are appended to. Nobody else can open it until it is dropped.
#[derive(Debug)]
pub struct SweepTable {
    file: File,
    path: PathBuf,
}

impl SweepTable {
    /// Goes on with the table of a whole sweep at `path`, or begins it; and the rows that are in it. What a killed run left of a row is cut
    /// off.
    ///
    /// # Errors
    /// Paths of what is no file, files that hold anything else, and those that another sweep writes at this moment.
    pub fn resume(path: &Path, plan: &SweepPlan) -> Result<(Self, Vec<String>), Refusal> {
        let mut rows = Vec::new();
        let points: Vec<usize> = (0..plan.count()).collect();
        let table = Self::open(path, plan, &points, true, &mut |row| {
            rows.push(row.to_owned());
        })?;
        Ok((table, rows))
    }

    /// Begins a table with rows of `points`, or goes on with one if `resume`: `known` is told the rows that are in it. What is no beginning
    /// of this table is refused, and left as it is.
    pub(super) fn open(
        path: &Path,
        plan: &SweepPlan,
        points: &[usize],
        resume: bool,
        known: &mut dyn FnMut(&str),
    ) -> Result<Self, BadInput> {
        let refused = |what: &str| BadInput::new(format!("table `{}`: {what}", path.display()));
        let failed = |error| refused(&format!("{error}; give a file that can be written"));
        refuse_other_than_files(path).map_err(failed)?;
        let mut options = OpenOptions::new();
        options.create(true).read(true).append(true);
        let file = options.open(path).map_err(failed)?;
        // A file system without locks lets everybody in.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(refused(
                "another sweep writes this table at the moment; wait for its end, or give another file",
            ));
        }
        if file.metadata().map_err(failed)?.len() > 0 && !resume {
            return Err(refused(
                "is there already; add --resume to go on with it, or give another file",
            ));
        }
        let whole = begun(&file, plan, points, known).map_err(failed)?;
        let whole = whole.ok_or_else(|| refused(OTHER))?;
        file.set_len(whole).map_err(failed)?;
        let mut table = Self {
            file,
            path: path.to_owned(),
        };
        if whole == 0 {
            table.add(&plan.header())?;
        }
        Ok(table)
    }

    /// Appends one row; it is handed to the system as a whole.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn append(&mut self, row: &str) -> Result<(), Refusal> {
        Ok(self.add(row)?)
    }

    pub(super) fn add(&mut self, row: &str) -> Result<(), BadInput> {
        let line = format!("{row}\n");
        self.file.write_all(line.as_bytes()).map_err(|error| {
            BadInput::new(format!(
                "table `{}`: {error}; make room, and go on with --resume",
                self.path.display()
            ))
        })
    }
}

/// Refuses to write over devices, folders and pipes, some of which never end a read.
pub(super) fn refuse_other_than_files(path: &Path) -> io::Result<()> {
    match std::fs::metadata(path) {
        Ok(found) if !found.is_file() => Err(io::Error::other("this is no file")),
        _ => Ok(()),
    }
}

/// Why a file is no beginning of a table.
const OTHER: &str = "holds rows of another sweep (other scene, options, values, records or shard); give another file, \
     or remove it";

/// How many bytes of a file are whole lines of the table of these points; `None` if it is no beginning of that. It is read no further than
/// up to the first difference.
fn begun(
    file: &File,
    plan: &SweepPlan,
    points: &[usize],
    known: &mut dyn FnMut(&str),
) -> io::Result<Option<u64>> {
    let header = plan.header() + "\n";
    let mut reader = BufReader::new(file);
    let mut first = Vec::new();
    let length = header.len() as u64;
    reader.by_ref().take(length).read_to_end(&mut first)?;
    if first.len() < header.len() {
        return Ok(header.as_bytes().starts_with(&first).then_some(0));
    }
    if first != header.as_bytes() {
        return Ok(None);
    }
    let mut whole = length;
    for done in 0.. {
        let mut line = Vec::new();
        let read = reader.read_until(b'\n', &mut line)?;
        if read == 0 {
            break;
        }
        let Some(point) = points.get(done) else {
            return Ok(None);
        };
        let number = format!("{point},");
        let Some(row) = line.strip_suffix(b"\n") else {
            let cut = line.starts_with(number.as_bytes()) || number.as_bytes().starts_with(&line);
            return Ok(cut.then_some(whole));
        };
        let row = String::from_utf8_lossy(row);
        if !row.starts_with(&number) || mark(&row) != Some(plan.mark()) {
            return Ok(None);
        }
        known(&row);
        whole += read as u64;
    }
    Ok(Some(whole))
}

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
        let text = regular_text(file, u64::MAX)
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
