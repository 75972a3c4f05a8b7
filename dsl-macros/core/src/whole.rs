//! Files that are read whole or not at all.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Reads a file of at most `limit` bytes.
///
/// # Errors
/// It cannot be read, is no file, such as a pipe whose end may never come, or is longer.
pub fn read_whole(file: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let refused = |why: String| io::Error::new(io::ErrorKind::InvalidInput, why);
    if !file.metadata()?.is_file() {
        return Err(refused("this is no file; give the path of one".to_owned()));
    }
    let mut bytes = Vec::new();
    File::open(file)?.take(limit + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > limit {
        true => Err(refused(format!("the file has more than {limit} bytes"))),
        false => Ok(bytes),
    }
}
