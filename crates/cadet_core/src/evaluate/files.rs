//! Folders of label and result files, read in parallel.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use rayon::prelude::*;

use cadet_base::error::{Error, Result};
use cadet_base::parallel;

/// Reads the files `ID.txt` of a folder; a frame without an id has no file, and so nothing in it.
///
/// # Errors
/// [`Error::Missing`] and [`Error::Unreadable`] for what can't be read, and whatever `parse`, which is given a file's
/// bytes and its name for messages, finds wrong: the first in the order of the ids.
pub fn read_files<T: Default + Send>(
    folder: &Path,
    ids: &[Option<String>],
    parse: impl Fn(&[u8], &str) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    // A file's folder and name, as in the other messages of the package.
    let parent = folder.file_name().map(|name| format!("{}/", name.to_string_lossy())).unwrap_or_default();
    let read_one = |buffer: &mut Vec<u8>, id: &Option<String>| {
        let Some(id) = id else { return Ok(T::default()) };
        let name = format!("{id}.txt");
        read(&folder.join(&name), buffer)?;
        parse(buffer, &format!("{parent}{name}"))
    };
    // Collecting the results first makes the first error the same whichever thread comes first.
    let parsed: Vec<Result<T>> = parallel::run(|| ids.par_iter().map_init(Vec::new, read_one).collect());
    parsed.into_iter().collect()
}

fn read(path: &Path, buffer: &mut Vec<u8>) -> Result<()> {
    buffer.clear();
    // Through `take`, nobody asks the system for the size: a call less for each of thousands of small files.
    buffer.reserve(16 * 1024);
    let read = File::open(path).and_then(|file| file.take(u64::MAX).read_to_end(buffer));
    read.map(|_| ()).map_err(|error| {
        let path = path.display().to_string();
        match error.kind() {
            ErrorKind::NotFound => Error::Missing { path, reason: "no such file".to_owned() },
            _ => Error::Unreadable { path, reason: error.to_string() },
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_error_wins_whichever_thread_is_faster() {
        let ids: Vec<Option<String>> = (0..500).map(|i| Some(format!("{i:06}"))).collect();
        for _ in 0..5 {
            let error = read_files(Path::new("/no/such"), &ids, |_, _| Ok(())).unwrap_err();
            assert_eq!(error.to_string(), "/no/such/000000.txt: no such file");
        }
        let none = read_files(Path::new("/no/such"), &[None, None], |_, _| Ok(vec![1])).unwrap();
        assert_eq!(none, [Vec::<i32>::new(), Vec::new()]);
    }
}
