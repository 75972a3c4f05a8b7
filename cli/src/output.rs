//! The output directory: checked before a run, written whole or not at all.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::failure::BadInput;

/// A directory that was found writable.
#[derive(Debug)]
pub(crate) struct OutputDirectory {
    path: PathBuf,
    made: bool,
}

impl OutputDirectory {
    /// Makes the directory if needed and proves that a file can be written into it.
    pub(crate) fn open(path: &Path) -> Result<Self, BadInput> {
        let made = !path.exists();
        let refused = |error: io::Error| {
            BadInput::new(format!(
                "output directory `{}`: {error}; give --out a directory that can be written",
                path.display()
            ))
        };
        fs::create_dir_all(path).map_err(refused)?;
        let directory = Self {
            path: path.to_owned(),
            made,
        };
        let probe = directory.temporary("probe");
        fs::write(&probe, []).map_err(refused)?;
        fs::remove_file(&probe).map_err(refused)?;
        Ok(directory)
    }

    /// Writes all files: first under temporary names, then, once every byte is on the disk, under
    /// their own. Returns their paths.
    pub(crate) fn write(&self, files: &[(String, String)]) -> Result<Vec<PathBuf>, BadInput> {
        let written = files.iter().try_for_each(|(name, content)| {
            fs::write(self.temporary(name), content).map_err(|error| (name, error))
        });
        let moved = written.and_then(|()| {
            files.iter().try_for_each(|(name, _)| {
                fs::rename(self.temporary(name), self.path.join(name))
                    .map_err(|error| (name, error))
            })
        });
        moved.map_err(|(name, error)| {
            for (name, _) in files {
                // Those that were never written are not there; nothing else can be done here.
                let _ = fs::remove_file(self.temporary(name));
            }
            BadInput::new(format!(
                "output file `{}`: {error}; free space or give --out another directory",
                self.path.join(name).display()
            ))
        })?;
        Ok(files.iter().map(|(name, _)| self.path.join(name)).collect())
    }

    fn temporary(&self, name: &str) -> PathBuf {
        self.path
            .join(format!(".{name}.{}.part", std::process::id()))
    }
}

impl Drop for OutputDirectory {
    /// A directory made for a run that was refused afterwards is still empty and goes again.
    fn drop(&mut self) {
        if self.made {
            // Fails, as it should, if the directory holds anything.
            let _ = fs::remove_dir(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::OutputDirectory;

    fn scratch(name: &str) -> std::path::PathBuf {
        let path = std::env::temp_dir().join(format!("hangtime-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        path
    }

    #[test]
    fn output_directory_unused_leaves_nothing() {
        let path = scratch("unused");
        drop(OutputDirectory::open(&path).unwrap());
        assert!(!path.exists());
    }

    #[test]
    fn output_directory_failed_write_leaves_no_file() {
        let path = scratch("failed");
        let directory = OutputDirectory::open(&path).unwrap();
        let files = [
            ("good.csv".to_owned(), "1".to_owned()),
            ("missing/bad.csv".to_owned(), "2".to_owned()),
        ];
        let error = directory.write(&files).unwrap_err().to_string();
        assert!(error.contains("bad.csv"), "{error}");
        assert_eq!(std::fs::read_dir(&path).unwrap().count(), 0);
        drop(directory);
        assert!(!path.exists());
    }

    #[test]
    fn output_directory_write_leaves_exactly_the_files() {
        let path = scratch("good");
        let directory = OutputDirectory::open(&path).unwrap();
        directory
            .write(&[("a.csv".to_owned(), "1".to_owned())])
            .unwrap();
        drop(directory);
        let names: Vec<_> = std::fs::read_dir(&path)
            .unwrap()
            .map(|entry| entry.unwrap().file_name())
            .collect();
        assert_eq!(names, ["a.csv"]);
        std::fs::remove_dir_all(&path).unwrap();
    }
}
