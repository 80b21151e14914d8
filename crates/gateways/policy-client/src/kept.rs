//! Answers in a file: written beside an evaluation, and read in place of a server.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use crate::codec::{Convention, Rows};
use crate::failure::{Failure, reason};

/// FNV-1a of 64 bits: the same in every build.
pub(crate) fn hash(start: u64, bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(start, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Start of [`hash`].
pub(crate) const HASH_START: u64 = 0xcbf2_9ce4_8422_2325;

/// One answer; a line of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Answer {
    /// Number of the request in its episode, from 1. A request that was sent again has the same.
    pub(crate) number: u64,
    /// Hash of the observations of the episode up to this request, 16 hexadecimal digits: a server
    /// may remember.
    pub(crate) request: String,
    /// The actions; empty after a failure.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) rows: Rows,
    /// Why there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) failure: Option<Failure>,
}

impl Answer {
    /// The answer to a request.
    pub(crate) fn new(number: u64, request: u64, result: &Result<Rows, Failure>) -> Self {
        Self {
            number,
            request: format!("{request:016x}"),
            rows: result.as_ref().ok().cloned().unwrap_or_default(),
            failure: result.as_ref().err().cloned(),
        }
    }

    /// The actions, or why there are none.
    pub(crate) fn result(self) -> Result<Rows, Failure> {
        match self.failure {
            Some(failure) => Err(failure),
            None => Ok(self.rows),
        }
    }

    /// Hash of this answer and of the earlier ones, whose hash is `before`.
    pub(crate) fn hash(&self, before: u64) -> u64 {
        let rows = self
            .rows
            .iter()
            .flatten()
            .flat_map(|number| number.to_le_bytes());
        let failure = self
            .failure
            .iter()
            .flat_map(|failure| failure.reason.bytes());
        // The lengths are part of it: other rows with the same numbers are another answer.
        let shape = self
            .rows
            .iter()
            .flat_map(|row| (row.len() as u64).to_le_bytes());
        hash(hash(hash(before, shape), rows), failure)
    }
}

/// Reads the answers of an episode.
///
/// # Errors
/// For a file that cannot be read, and for the first line without an answer.
pub(crate) fn read(file: &Path) -> Result<Vec<Answer>, Failure> {
    let refused = |why: String| {
        Failure::new(
            reason::NOT_KEPT,
            format!(
                "{}: {why}; --keep-answers writes these files",
                file.display()
            ),
        )
    };
    let opened = File::open(file).map_err(|error| refused(error.to_string()))?;
    let lines = BufReader::new(opened).lines().enumerate();
    let line = |(index, line): (usize, io::Result<String>)| {
        let at = |error: String| refused(format!("line {}: {error}", index + 1));
        let line = line.map_err(|error| at(error.to_string()))?;
        serde_json::from_str(&line).map_err(|error| at(error.to_string()))
    };
    lines.map(line).collect()
}

/// Writes the answers of an episode, each as it comes.
#[derive(Debug)]
pub(crate) struct Writer(File);

impl Writer {
    /// In place of an earlier file, or at its end for an episode that resumes.
    ///
    /// # Errors
    /// Of the file system.
    pub(crate) fn open(file: &Path, resumes: bool) -> io::Result<Self> {
        if let Some(dir) = file.parent() {
            std::fs::create_dir_all(dir)?;
        }
        let mut options = OpenOptions::new();
        options
            .create(true)
            .write(true)
            .append(resumes)
            .truncate(!resumes);
        options.open(file).map(Self)
    }

    /// Appends an answer.
    ///
    /// # Errors
    /// Of the file system.
    pub(crate) fn add(&mut self, answer: &Answer) -> io::Result<()> {
        let mut line = serde_json::to_string(answer)?;
        line.push('\n');
        self.0.write_all(line.as_bytes())
    }
}

/// Facts about the servers of this process.
#[derive(Debug, Default)]
pub(crate) struct Seen {
    /// By request the hash of its answer: a server that answers one request in two ways makes rows
    /// that do not repeat.
    answers: Mutex<HashMap<String, u64>>,
    /// By address the convention, which is found with the first connection.
    conventions: Mutex<HashMap<String, Convention>>,
}

impl Seen {
    /// The convention of a server, if it is known.
    pub(crate) fn convention(&self, address: &str) -> Option<Convention> {
        let known = self
            .conventions
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        known.get(address).copied()
    }

    /// Keeps the convention of a server.
    pub(crate) fn found(&self, address: &str, convention: Convention) {
        let mut known = self
            .conventions
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        known.insert(address.to_owned(), convention);
    }

    /// Adds an answer; `false` if the request had other rows before.
    pub(crate) fn agrees(&self, answer: &Answer) -> bool {
        // A server that was not started yet gave no answer.
        if answer.failure.is_some() {
            return true;
        }
        let own = answer.hash(HASH_START);
        let mut seen = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        *seen.entry(answer.request.clone()).or_insert(own) == own
    }
}
