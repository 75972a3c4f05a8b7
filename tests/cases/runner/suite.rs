//! All cases: their runs, what fails among them, and the expectations that are changed to see that they fail.

use crate::block::{Block, blocks};
use crate::check::{check, looks};
use crate::document;
use crate::mutation::{Chance, changed};
use crate::run::{Results, results};
use crate::setting::Setting;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::{env, fs};

/// What the numbers begin with by which expectations are drawn.
const SEED: u64 = 20_261_128;

/// All cases of the folder.
#[derive(Debug)]
pub(crate) struct Suite {
    pub(crate) sections: Vec<Section>,
    /// Expectations that are changed: section, block, expectation.
    drawn: Vec<(usize, usize, usize)>,
    /// The results that these need, once they are there.
    kept: Mutex<BTreeMap<(usize, usize), Arc<Results>>>,
    /// New numbers of snapshots, by file and line.
    snapshots: Mutex<BTreeMap<(String, usize), f64>>,
}

/// A scene and what one fence says about it.
#[derive(Debug)]
pub(crate) struct Section {
    pub(crate) name: String,
    pub(crate) long: bool,
    blocks: Vec<Block>,
}

fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

impl Suite {
    /// Reads all files, and draws so many expectations.
    ///
    /// # Errors
    /// All that cannot be read.
    pub(crate) fn read(drawn: usize) -> Result<Self, String> {
        let entries = fs::read_dir(folder()).map_err(|error| error.to_string())?;
        let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        let mut files: Vec<PathBuf> = paths
            .filter(|path| path.extension().is_some_and(|ending| ending == "md"))
            .collect();
        files.sort();
        let (mut sections, mut mistakes) = (Vec::new(), Vec::new());
        let mut names = BTreeSet::new();
        for file in &files {
            let read = document::read(file).unwrap_or_else(|mistake| {
                mistakes.push(mistake);
                Vec::new()
            });
            for section in &read {
                let name = named(&section.file, &section.heading, &mut names);
                match blocks(section) {
                    Ok(blocks) => sections.push(Section::new(name, blocks)),
                    Err(mistake) => mistakes.push(mistake),
                }
            }
        }
        if !mistakes.is_empty() {
            return Err(mistakes.join("\n"));
        }
        let mut suite = Self {
            sections,
            drawn: Vec::new(),
            kept: Mutex::default(),
            snapshots: Mutex::default(),
        };
        suite.draw(drawn);
        Ok(suite)
    }

    fn draw(&mut self, count: usize) {
        let mut all = Vec::new();
        for (place, section) in self.sections.iter().enumerate() {
            if section.long {
                continue;
            }
            for (at, block) in section.blocks.iter().enumerate() {
                all.extend((0..block.expectations.len()).map(|index| (place, at, index)));
            }
        }
        let mut chance = Chance(SEED);
        while self.drawn.len() < count && !all.is_empty() {
            let next = chance.next() % all.len() as u64;
            self.drawn.push(all.swap_remove(next as usize));
        }
    }

    /// The results of a block, from before where they were kept.
    fn results(&self, place: usize, at: usize) -> Result<Arc<Results>, String> {
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(results) = kept().get(&(place, at)) {
            return Ok(Arc::clone(results));
        }
        let results = Arc::new(results(&self.sections[place].blocks[at])?);
        if self
            .drawn
            .iter()
            .any(|drawn| (drawn.0, drawn.1) == (place, at))
        {
            kept().insert((place, at), Arc::clone(&results));
        }
        Ok(results)
    }

    /// Runs a section.
    ///
    /// # Errors
    /// All expectations that do not hold: where they stand, what was expected, and what came.
    pub(crate) fn section(&self, place: usize) -> Result<(), String> {
        let mut failures = Vec::new();
        for (at, block) in self.sections[place].blocks.iter().enumerate() {
            let results = match self.results(place, at) {
                Ok(results) => results,
                Err(why) => {
                    let line = block
                        .expectations
                        .first()
                        .map_or(0, |first| first.line.number);
                    failures.push(format!("{}:{line}: {why}", block.file));
                    continue;
                }
            };
            for expectation in &block.expectations {
                for failure in check(block, &results, expectation) {
                    let line = &expectation.line;
                    if let Some(found) = failure.found.filter(|_| expectation.snapshot) {
                        let mut new = self
                            .snapshots
                            .lock()
                            .unwrap_or_else(PoisonError::into_inner);
                        new.insert((block.file.clone(), line.number), found);
                    }
                    let by = failure
                        .by
                        .map_or_else(String::new, |by| format!(" by {by}"));
                    let with = match block.shown.is_empty() {
                        true => String::new(),
                        false => format!(" with {}", block.shown),
                    };
                    failures.push(format!(
                        "tests/cases/{}:{}: {}{with}\n   {by}: {}",
                        block.file, line.number, line.text, failure.why
                    ));
                }
            }
        }
        match failures.is_empty() {
            true => Ok(()),
            false => Err(failures.join("\n")),
        }
    }

    /// Changes the expectations that were drawn.
    ///
    /// # Errors
    /// Those that hold all the same, by any method.
    pub(crate) fn mutations(&self) -> Result<(), String> {
        let mut chance = Chance(SEED);
        let mut accepted = Vec::new();
        for &(place, at, index) in &self.drawn {
            let block = &self.sections[place].blocks[at];
            let expectation = &block.expectations[index];
            let results = self.results(place, at)?;
            if !check(block, &results, expectation).is_empty() {
                // Told of where it stands.
                continue;
            }
            let changed = changed(expectation, &mut chance);
            if check(block, &results, &changed).len() < looks(block, &results, &changed) {
                let line = &expectation.line;
                accepted.push(format!(
                    "tests/cases/{}:{}: {}\n    holds as {:?}, moved by {}",
                    block.file, line.number, line.text, changed.claim, changed.moved
                ));
            }
        }
        match accepted.is_empty() {
            true => Ok(()),
            false => Err(accepted.join("\n")),
        }
    }

    /// Writes numbers that are snapshots anew, if `HANGTIME_UPDATE` asks for it.
    ///
    /// # Errors
    /// A file that cannot be read or written.
    pub(crate) fn write_snapshots(&self) -> Result<(), String> {
        if env::var_os("HANGTIME_UPDATE").is_none() {
            return Ok(());
        }
        let new = self
            .snapshots
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        for ((file, number), value) in new.iter() {
            let path = folder().join(file);
            let text = fs::read_to_string(&path).map_err(|error| error.to_string())?;
            let lines = text.lines().zip(1..).map(|(line, at)| match at == *number {
                true => renewed(line, *value),
                false => line.to_owned(),
            });
            let text: String = lines.map(|line| line + "\n").collect();
            fs::write(&path, text).map_err(|error| error.to_string())?;
        }
        Ok(())
    }
}

impl Section {
    fn new(name: String, blocks: Vec<Block>) -> Self {
        let long = |block: &Block| {
            let mut settings = block.settings.iter();
            settings.any(|setting| matches!(setting, Setting::Long))
        };
        Self {
            long: blocks.iter().any(long),
            name,
            blocks,
        }
    }
}

/// A name of letters, digits and lines: that of the file and of the heading, with a number where it is there before.
fn named(file: &str, heading: &str, known: &mut BTreeSet<String>) -> String {
    let letters = |text: &str| -> String {
        let text = text.to_lowercase();
        let plain = text
            .chars()
            .map(|c| if c.is_alphanumeric() { c } else { '_' });
        let plain: String = plain.collect();
        let words: Vec<&str> = plain.split('_').filter(|word| !word.is_empty()).collect();
        words.join("_")
    };
    let stem = file.strip_suffix(".md").unwrap_or(file);
    let name = format!("{}::{}", letters(stem), letters(heading));
    let numbered = (2..).map(|number| format!("{name}_{number}"));
    let mut names = [name.clone()].into_iter().chain(numbered);
    let free = names.find(|name| !known.contains(name)).unwrap_or(name);
    known.insert(free.clone());
    free
}

/// The line of a snapshot with another number.
fn renewed(line: &str, value: f64) -> String {
    let Some((before, rest)) = line.split_once("== ") else {
        return line.to_owned();
    };
    let end = rest.find(' ').unwrap_or(rest.len());
    format!("{before}== {value}{}", &rest[end..])
}
