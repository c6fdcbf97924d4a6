//! Folders of label and result files, read in parallel.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::objects::FramePair;
use super::parse::{parse_detections, parse_truths};
use crate::error::{Error, Result};

/// Which frames count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameRule {
    /// KITTI's offline rule: frames that have a result file, be it empty.
    Results,
    /// All frames; where the result file is missing, nothing was found.
    All,
}

/// Where the files lie.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Folders {
    /// Holds `000000.txt`, ... with 15 columns.
    pub truths: PathBuf,
    /// Holds `000000.txt`, ... with 16 columns.
    pub detections: PathBuf,
    /// The frames to choose from, None for all that have a label file.
    pub ids: Option<Vec<String>>,
    /// Which of them count.
    pub rule: FrameRule,
}

/// The frames of two folders.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadFrames {
    /// Six digits each, rising.
    pub ids: Vec<String>,
    /// One an id.
    pub frames: Vec<FramePair>,
    /// Frames without a result file: left out or without detections, by the rule.
    pub num_missing: usize,
}

/// Reads the frames that the rule names.
///
/// # Errors
/// [`Error::Missing`] for a folder that is not there, a result file without a label file, or no frame at all;
/// [`Error::Format`] for the first malformed line, in the order of frames, label files before result files.
pub fn read_folders(folders: &Folders) -> Result<ReadFrames> {
    let found = list(&folders.detections)?;
    let mut ids = match &folders.ids {
        Some(ids) => ids.clone(),
        // A result file without a label file is an error, so it must not be left out here.
        None => [list(&folders.truths)?, found.clone()].concat(),
    };
    ids.sort_unstable();
    ids.dedup();
    let num_all = ids.len();
    let has_result = |id: &String| found.binary_search(id).is_ok();
    let num_found = ids.iter().filter(|id| has_result(id)).count();
    if folders.rule == FrameRule::Results {
        ids.retain(has_result);
    }
    if ids.is_empty() {
        let reason = "no frames: expected files such as 000000.txt";
        let path = if num_all == 0 { &folders.truths } else { &folders.detections };
        return Err(Error::Missing { path: path.display().to_string(), reason: reason.to_owned() });
    }
    let frames: Vec<Result<FramePair>> =
        ids.par_iter().map_init(Vec::new, |buffer, id| read_pair(folders, id, has_result(id), buffer)).collect();
    Ok(ReadFrames { frames: frames.into_iter().collect::<Result<_>>()?, num_missing: num_all - num_found, ids })
}

fn read_pair(folders: &Folders, id: &str, has_result: bool, buffer: &mut Vec<u8>) -> Result<FramePair> {
    let mut unknown_names = Vec::new();
    let name = format!("{id}.txt");
    read(&folders.truths, &name, buffer)?;
    let truths = parse_truths(buffer, &shown(&folders.truths, &name))?;
    let detections = if has_result {
        read(&folders.detections, &name, buffer)?;
        parse_detections(buffer, &shown(&folders.detections, &name), &mut unknown_names)?
    } else {
        Vec::new()
    };
    Ok(FramePair { truths, detections, unknown_names })
}

/// The ids of the files that are named by six digits, rising.
fn list(folder: &Path) -> Result<Vec<String>> {
    let failed = |error: &std::io::Error| failure(folder, error);
    let mut ids = Vec::new();
    for entry in folder.read_dir().map_err(|e| failed(&e))? {
        let name = entry.map_err(|e| failed(&e))?.file_name();
        let id = name.to_str().and_then(|name| name.strip_suffix(".txt"));
        if let Some(id) = id.filter(|id| id.len() == 6 && id.bytes().all(|byte| byte.is_ascii_digit())) {
            ids.push(id.to_owned());
        }
    }
    ids.sort_unstable();
    Ok(ids)
}

fn read(folder: &Path, name: &str, buffer: &mut Vec<u8>) -> Result<()> {
    let path = folder.join(name);
    buffer.clear();
    // No call for the size: the buffer soon has room for any file of the folder.
    buffer.reserve(16 * 1024);
    File::open(&path)
        .and_then(|file| file.take(u64::MAX).read_to_end(buffer))
        .map(|_| ())
        .map_err(|error| failure(&path, &error))
}

/// A file's folder and name, as in the other messages of the package.
fn shown(folder: &Path, name: &str) -> String {
    match folder.file_name() {
        Some(parent) => format!("{}/{name}", parent.to_string_lossy()),
        None => name.to_owned(),
    }
}

fn failure(path: &Path, error: &std::io::Error) -> Error {
    let path = path.display().to_string();
    match error.kind() {
        ErrorKind::NotFound => Error::Missing { path, reason: "no such file or folder".to_owned() },
        _ => Error::Unreadable { path, reason: error.to_string() },
    }
}
