//! The output directory: checked before a run; the files of a run appear in it together.
//!
//! A run writes into a fresh folder of its own, `.hangtime-XXXXXX.part`, whose name nobody can foresee. Once every byte
//! is on the disk, a directory that did not exist is made by renaming that folder. In one that exists, the files of
//! earlier runs that have the same names are moved out, and then the new ones in: old and new never stand side by side.
//! A run that is killed in between has left a mark; the next run into the directory moves the rest, or removes what
//! was not complete.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::TempDir;

use crate::failure::BadInput;

/// Most pages that are linked.
const MOST_PAGES: usize = 50;
/// Beginning and end of the name of a folder of a run.
const NAME: [&str; 2] = [".hangtime-", ".part"];
/// Random characters between them.
const RANDOM: usize = 12;
/// Held by the run that a folder belongs to.
const LOCK: &str = "lock";
/// The lock before it is held.
const UNNAMED: &str = "unnamed";
/// The files to be.
const NEW: &str = "new";
/// The files that they replace.
const OLD: &str = "old";
/// Stands beside the new files once all of them are on the disk.
const COMPLETE: &str = "complete";
/// A folder without a lock that is younger than this may belong to a run that is just beginning.
const JUST_MADE: Duration = Duration::from_secs(60);

/// A directory that was found writable.
#[derive(Debug)]
pub(crate) struct OutputDirectory {
    path: PathBuf,
    /// The option that named it.
    option: &'static str,
    stage: Stage,
}

/// A file that was written.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Written {
    /// Where it is.
    pub(crate) path: PathBuf,
    /// Whether there was a file of this name before.
    pub(crate) replaced: bool,
}

impl OutputDirectory {
    /// Makes the folder of this run, which proves that the directory can be written, or made. Puts in order what
    /// killed runs left there.
    pub(crate) fn open(path: &Path) -> Result<Self, BadInput> {
        Self::open_for("--out", path)
    }

    /// The pages that stand in it, by name; of many the first ones.
    pub(crate) fn pages(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.path).into_iter().flatten().flatten();
        let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
        let is_page = |name: &String| Path::new(name).extension().is_some_and(|end| end == "html");
        let mut pages: Vec<String> = names.filter(is_page).collect();
        pages.sort();
        pages.truncate(MOST_PAGES);
        pages
    }

    /// As [`open`](Self::open), for what another option named.
    pub(crate) fn open_for(option: &'static str, path: &Path) -> Result<Self, BadInput> {
        let refused = |error: io::Error| {
            BadInput::new(format!(
                "output directory `{}`: {error}; give {option} a directory that can be written",
                path.display()
            ))
        };
        if path.as_os_str().is_empty() {
            return Err(refused(io::Error::other("the name is empty")));
        }
        // The nearest directory above that exists; a file in the way shows itself here.
        let mut parent = path;
        while !parent.exists() {
            parent = match parent.parent() {
                Some(above) if !above.as_os_str().is_empty() => above,
                _ => Path::new("."),
            };
        }
        if !parent.is_dir() {
            return Err(refused(io::Error::from(io::ErrorKind::NotADirectory)));
        }
        let stage = Stage::make(parent).map_err(refused)?;
        put_in_order(parent, &stage).map_err(refused)?;
        Ok(Self {
            path: path.to_owned(),
            option,
            stage,
        })
    }

    /// Writes all files, given as (name, content), or none.
    pub(crate) fn write(mut self, files: &[(String, String)]) -> Result<Vec<Written>, BadInput> {
        self.try_write(files).map_err(|(name, error)| {
            BadInput::new(format!(
                "output file `{}`: {error}; no file was written; free space or give {} another directory",
                self.path.join(name).display(),
                self.option
            ))
        })
    }

    /// As [`write`](Self::write); an error comes with the file that it concerns.
    fn try_write<'f>(
        &mut self,
        files: &'f [(String, String)],
    ) -> Result<Vec<Written>, (&'f str, io::Error)> {
        let all = |error| ("", error);
        self.stage.fill(files)?;
        let is_new = !self.path.exists();
        if is_new && self.stage.become_directory(&self.path).is_ok() {
            return Ok(self.written(files, |_| false));
        }
        if is_new {
            // Another run made the directory first: what there is moves in beside its files.
            let stage = Stage::make(&self.path).map_err(all)?;
            fs::rename(self.stage.new_files(), stage.new_files()).map_err(all)?;
            self.stage = stage;
        }
        let replaced = self.stage.move_in(&self.path, files)?;
        Ok(self.written(files, |name| replaced.contains(&name)))
    }

    fn written(&self, files: &[(String, String)], replaced: impl Fn(&str) -> bool) -> Vec<Written> {
        let files = files.iter().map(|(name, _)| Written {
            path: self.path.join(name),
            replaced: replaced(name),
        });
        files.collect()
    }
}

/// The folder of a run. Whatever is left in it goes when it is dropped.
#[derive(Debug)]
struct Stage {
    /// Held as long as the folder is in use; closed before the folder goes.
    _lock: File,
    folder: TempDir,
}

impl Stage {
    fn make(parent: &Path) -> io::Result<Self> {
        let [prefix, suffix] = NAME;
        let folder = tempfile::Builder::new()
            .prefix(prefix)
            .suffix(suffix)
            .rand_bytes(RANDOM)
            .tempdir_in(parent)?;
        // Held before it has its name: other runs never see it free. Without locks in a file system, nobody will take
        // this folder for a leftover either.
        let unnamed = folder.path().join(UNNAMED);
        let lock = File::create_new(&unnamed)?;
        let _ = lock.lock();
        fs::rename(unnamed, folder.path().join(LOCK))?;
        Ok(Self {
            _lock: lock,
            folder,
        })
    }

    fn new_files(&self) -> PathBuf {
        self.folder.path().join(NEW)
    }

    /// Writes the files into the folder, down to the disk.
    fn fill<'f>(&self, files: &'f [(String, String)]) -> Result<(), (&'f str, io::Error)> {
        let folder = self.new_files();
        fs::create_dir(&folder).map_err(|error| ("", error))?;
        for (name, content) in files {
            let write = || {
                let mut file = File::create_new(folder.join(name))?;
                file.write_all(content.as_bytes())?;
                file.sync_all()
            };
            write().map_err(|error| (name.as_str(), error))?;
        }
        synchronize(&folder);
        Ok(())
    }

    /// Makes the directory `path` out of the new files.
    fn become_directory(&self, path: &Path) -> io::Result<()> {
        if let Some(above) = path.parent() {
            fs::create_dir_all(above)?;
        }
        fs::rename(self.new_files(), path)?;
        path.parent().into_iter().for_each(synchronize);
        Ok(())
    }

    /// Moves the new files into `directory`, which holds this folder; the names of those that were replaced.
    fn move_in<'f>(
        &self,
        directory: &Path,
        files: &'f [(String, String)],
    ) -> Result<Vec<&'f str>, (&'f str, io::Error)> {
        for (name, _) in files {
            if directory.join(name).is_dir() {
                return Err((name, io::Error::from(io::ErrorKind::IsADirectory)));
            }
        }
        let old = self.folder.path().join(OLD);
        let prepared = fs::create_dir(&old)
            .and_then(|()| File::create_new(self.folder.path().join(COMPLETE))?.sync_all());
        prepared.map_err(|error| ("", error))?;
        synchronize(self.folder.path());
        let mut replaced = Vec::new();
        let mut moved = Vec::new();
        let mut move_all = || {
            for (name, _) in files {
                match fs::rename(directory.join(name), old.join(name)) {
                    Ok(()) => replaced.push(name.as_str()),
                    Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                    Err(error) => return Err((name.as_str(), error)),
                }
            }
            for (name, _) in files {
                fs::rename(self.new_files().join(name), directory.join(name))
                    .map_err(|error| (name.as_str(), error))?;
                moved.push(name.as_str());
            }
            Ok(())
        };
        let outcome = move_all();
        if outcome.is_err() {
            // Back to what there was. Where even this fails, nothing is left to be tried.
            for name in moved {
                let _ = fs::remove_file(directory.join(name));
            }
            for name in &replaced {
                let _ = fs::rename(old.join(name), directory.join(name));
            }
        }
        synchronize(directory);
        outcome.map(|()| replaced)
    }
}

/// Completes what killed runs had on the disk, and removes the rest.
fn put_in_order(directory: &Path, own: &Stage) -> io::Result<()> {
    for entry in fs::read_dir(directory)? {
        let entry = entry?;
        if is_leftover(&entry, own)? {
            complete(directory, &entry.path());
            // A leftover that cannot be removed harms nobody.
            let _ = fs::remove_dir_all(entry.path());
        }
    }
    Ok(())
}

/// Whether an entry of the directory is the folder of a run that has ended, of the same user.
fn is_leftover(entry: &fs::DirEntry, own: &Stage) -> io::Result<bool> {
    let name: OsString = entry.file_name();
    let [prefix, suffix] = NAME;
    let named = name
        .to_str()
        .is_some_and(|name| name.starts_with(prefix) && name.ends_with(suffix));
    if !named || entry.path() == own.folder.path() {
        return Ok(false);
    }
    // Not through links: a planted one must not lead anywhere.
    let found = match fs::symlink_metadata(entry.path()) {
        // Another run ended in between, and its folder went with it.
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
        found => found?,
    };
    if !found.is_dir() || !same_owner(&found, &fs::symlink_metadata(own.folder.path())?) {
        return Ok(false);
    }
    Ok(match File::open(entry.path().join(LOCK)) {
        Ok(lock) => lock.try_lock().is_ok(),
        Err(_) => found
            .modified()
            .ok()
            .and_then(|made| made.elapsed().ok())
            .is_some_and(|age| age > JUST_MADE),
    })
}

/// Whether two folders belong to one user.
#[cfg(unix)]
fn same_owner(one: &fs::Metadata, other: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    one.uid() == other.uid()
}

/// Whether two folders belong to one user; systems without owners do not tell.
#[cfg(not(unix))]
fn same_owner(_: &fs::Metadata, _: &fs::Metadata) -> bool {
    true
}

/// Moves the rest of the files of a run that was killed while it moved them.
fn complete(directory: &Path, leftover: &Path) {
    if !leftover.join(COMPLETE).is_file() {
        return;
    }
    let Ok(files) = fs::read_dir(leftover.join(NEW)) else {
        return;
    };
    for file in files.flatten() {
        // One that cannot be moved goes with the leftover.
        let _ = fs::rename(file.path(), directory.join(file.file_name()));
    }
    synchronize(directory);
}

/// Brings the entries of a directory to the disk, where the system can do that.
fn synchronize(directory: &Path) {
    if let Ok(directory) = File::open(directory) {
        let _ = directory.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    use tempfile::{TempDir, tempdir};

    use super::{COMPLETE, LOCK, NEW, OutputDirectory, Stage, is_leftover};

    fn files(texts: &[(&str, &str)]) -> Vec<(String, String)> {
        let texts = texts.iter();
        texts
            .map(|&(name, text)| (name.to_owned(), text.to_owned()))
            .collect()
    }

    fn names(directory: &Path) -> Vec<String> {
        let entries = fs::read_dir(directory).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    fn write(directory: &Path, texts: &[(&str, &str)]) -> Result<Vec<bool>, String> {
        let written = OutputDirectory::open(directory)
            .and_then(|directory| directory.write(&files(texts)))
            .map_err(|refusal| refusal.to_string())?;
        Ok(written.iter().map(|file| file.replaced).collect())
    }

    /// A folder as a killed run leaves it.
    fn leftover(directory: &Path, name: &str, texts: &[(&str, &str)]) -> PathBuf {
        let folder = directory.join(name);
        fs::create_dir_all(folder.join(NEW)).unwrap();
        fs::write(folder.join(LOCK), "").unwrap();
        for (name, text) in texts {
            fs::write(folder.join(NEW).join(name), text).unwrap();
        }
        folder
    }

    #[test]
    fn folder_that_went_while_another_run_looked_at_it_is_no_leftover() {
        let scratch = tempdir().unwrap();
        let own = Stage::make(scratch.path()).unwrap();
        let other = Stage::make(scratch.path()).unwrap();
        let seen: Vec<fs::DirEntry> = fs::read_dir(scratch.path())
            .unwrap()
            .map(Result::unwrap)
            .collect();
        assert_eq!(seen.len(), 2);
        let leftovers = || {
            seen.iter()
                .filter(|entry| is_leftover(entry, &own).unwrap())
        };
        assert_eq!(leftovers().count(), 0);
        drop(other);
        assert_eq!(leftovers().count(), 0);
    }

    #[test]
    fn runs_that_begin_and_end_in_one_directory_together_keep_theirs() {
        let scratch = tempdir().unwrap();
        let out = scratch.path();
        std::thread::scope(|scope| {
            for run in 0..4 {
                scope.spawn(move || {
                    for turn in 0..50 {
                        let name = format!("{run}-{turn}");
                        assert_eq!(write(out, &[(name.as_str(), "x")]), Ok(vec![false]));
                    }
                });
            }
        });
        assert_eq!(names(out).len(), 200);
    }

    #[test]
    fn directory_that_is_not_used_is_not_made() {
        let scratch = tempdir().unwrap();
        drop(OutputDirectory::open(&scratch.path().join("deep/out")).unwrap());
        assert!(names(scratch.path()).is_empty());
    }

    #[test]
    fn fresh_directory_appears_with_exactly_the_files() {
        let scratch = tempdir().unwrap();
        let out = scratch.path().join("deep/out");
        assert_eq!(
            write(&out, &[("b.csv", "2"), ("a.csv", "1")]),
            Ok(vec![false; 2])
        );
        assert_eq!(names(&out), ["a.csv", "b.csv"]);
        assert_eq!(names(scratch.path()), ["deep"]);
    }

    #[test]
    fn directory_in_use_keeps_other_files_and_tells_which_were_replaced() {
        let scratch = tempdir().unwrap();
        let out = scratch.path();
        assert_eq!(write(out, &[("mine", "1"), ("a", "1")]), Ok(vec![false; 2]));
        assert_eq!(write(out, &[("a", "2"), ("b", "2")]), Ok(vec![true, false]));
        assert_eq!(names(out), ["a", "b", "mine"]);
        assert_eq!(fs::read_to_string(out.join("a")).unwrap(), "2");
    }

    #[test]
    fn file_in_the_way_of_another_run_keeps_every_old_file() {
        let scratch = tempdir().unwrap();
        let out = scratch.path();
        write(out, &[("a", "old"), ("b", "old")]).unwrap();
        fs::create_dir(out.join("c")).unwrap();
        let refusal = write(out, &[("a", "new"), ("b", "new"), ("c", "new")]).unwrap_err();
        assert!(refusal.contains("/c`"), "{refusal}");
        assert_eq!(names(out), ["a", "b", "c"]);
        for name in ["a", "b"] {
            assert_eq!(fs::read_to_string(out.join(name)).unwrap(), "old");
        }
    }

    #[test]
    fn directory_made_meanwhile_by_another_run_gets_the_files_as_well() {
        let scratch = tempdir().unwrap();
        let out = scratch.path().join("out");
        let first = OutputDirectory::open(&out).unwrap();
        let second = OutputDirectory::open(&out).unwrap();
        second.write(&files(&[("a", "second"), ("b", "")])).unwrap();
        let written = first.write(&files(&[("a", "first")])).unwrap();
        assert!(written[0].replaced);
        assert_eq!(names(&out), ["a", "b"]);
        assert_eq!(names(scratch.path()), ["out"]);
    }

    #[test]
    fn leftover_of_a_run_killed_while_writing_is_removed() {
        let scratch = tempdir().unwrap();
        leftover(scratch.path(), ".hangtime-killed.part", &[("a", "half")]);
        write(scratch.path(), &[("b", "1")]).unwrap();
        assert_eq!(names(scratch.path()), ["b"]);
    }

    #[test]
    fn leftover_of_a_run_killed_while_moving_is_completed() {
        let scratch = tempdir().unwrap();
        let folder = leftover(scratch.path(), ".hangtime-killed.part", &[("b", "new")]);
        fs::write(folder.join(COMPLETE), "").unwrap();
        fs::write(scratch.path().join("a"), "new").unwrap();
        fs::write(scratch.path().join("b"), "old").unwrap();
        drop(OutputDirectory::open(scratch.path()).unwrap());
        assert_eq!(names(scratch.path()), ["a", "b"]);
        assert_eq!(fs::read_to_string(scratch.path().join("b")).unwrap(), "new");
    }

    #[test]
    fn folder_of_a_run_that_goes_on_is_left_alone() {
        let scratch = tempdir().unwrap();
        let running = OutputDirectory::open(scratch.path()).unwrap();
        write(scratch.path(), &[("a", "1")]).unwrap();
        running.write(&files(&[("b", "2")])).unwrap();
        assert_eq!(names(scratch.path()), ["a", "b"]);
    }

    #[cfg(unix)]
    #[test]
    fn planted_link_leads_nowhere() {
        let scratch = tempdir().unwrap();
        let elsewhere = TempDir::new().unwrap();
        let precious = leftover(elsewhere.path(), "precious", &[("a", "planted")]);
        fs::write(precious.join(COMPLETE), "").unwrap();
        let link = scratch.path().join(".hangtime-planted.part");
        std::os::unix::fs::symlink(&precious, link).unwrap();
        let target = elsewhere.path().join("target");
        fs::write(&target, "precious").unwrap();
        std::os::unix::fs::symlink(&target, scratch.path().join("a")).unwrap();
        write(scratch.path(), &[("a", "mine")]).unwrap();
        // The link itself is replaced, not what it leads to.
        assert_eq!(fs::read_to_string(&target).unwrap(), "precious");
        assert!(!scratch.path().join("a").is_symlink());
        assert_eq!(names(&precious), [COMPLETE, LOCK, NEW]);
    }
}
