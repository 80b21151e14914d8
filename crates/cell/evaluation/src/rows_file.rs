//! The file of a shard's rows. A kill at any instant loses at most the rows in progress, and
//! the same command resumes.
//!
//! Rows are appended as episodes end, in any order. When the last one is there, the file is
//! replaced by one in the order of the seeds.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufRead as _, BufReader, BufWriter, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use cell_model::draft::Draft;
use cell_model::user_file;

use crate::EvaluationError;
use crate::info::{self, Episode, Plan};
use crate::row::{Key, Row};

/// A file of rows that is written.
#[derive(Debug)]
pub struct RowsFile {
    path: PathBuf,
    rows: File,
    /// Locked as long as this process writes.
    info: File,
    plan: Plan,
    done: BTreeSet<Key>,
}

impl RowsFile {
    /// Opens the file at `path` for the rows of `plan`, or creates it.
    ///
    /// # Errors
    /// Where it cannot be written, another process writes it, or it was started with another plan.
    pub fn open(path: &Path, plan: &Plan) -> Result<Self, EvaluationError> {
        let info_path = info::path_of(path);
        for path in [path, &info_path] {
            user_file::check_output(path).map_err(EvaluationError::io(path))?;
        }
        let mut created = Created::default();
        let info = created
            .open(&info_path)
            .map_err(EvaluationError::io(&info_path))?;
        // Not the rows: `finish` replaces that file, and its lock would remain with the old one.
        // Before the rows are read, as a line that another process writes now would be cut off.
        match info.try_lock() {
            // Some network file systems have no locks.
            Ok(()) | Err(TryLockError::Error(_)) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(EvaluationError::InUse {
                    path: path.to_owned(),
                });
            }
        }
        let mut file = Self {
            rows: created.open(path).map_err(EvaluationError::io(path))?,
            path: path.to_owned(),
            info,
            plan: plan.clone(),
            done: BTreeSet::new(),
        };
        let begun = info::plan_of(path);
        begun.iter().try_for_each(|begun| file.check_plan(begun))?;
        // A side file is the sign of an evaluation, even if a kill cut its plan off.
        file.take_rows(!created.has(&info_path))?;
        if begun.is_none() {
            file.write_plan()?;
        }
        created.keep();
        Ok(file)
    }

    /// Episodes that have no row now, in order. A range may be longer than any memory.
    pub fn left(&self) -> impl Iterator<Item = Key> + use<> {
        let (seeds, done) = (self.plan.shard.seeds(&self.plan.range()), self.done.clone());
        let variants = self.plan.variants();
        let all = seeds.flat_map(move |seed| {
            let variants = variants.clone();
            variants.map(move |variant| Key { seed, variant })
        });
        all.filter(move |key| !done.contains(key))
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.done.len() as u64
    }

    /// Appends a row, and its host and times to the side file.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn append(&mut self, row: &Row, episode: &Episode) -> Result<(), EvaluationError> {
        // In one call: the next start cuts off the part that a kill leaves.
        let line = line_of(row);
        let rows = self.rows.write_all(line.as_bytes());
        rows.map_err(EvaluationError::io(&self.path))?;
        self.done.insert(row.key());
        // Second: a kill in between loses only facts that no report reads.
        let line = line_of(episode);
        let info = self.info.write_all(line.as_bytes());
        info.map_err(EvaluationError::io(&info::path_of(&self.path)))
    }

    /// Brings the rows into the order of their seeds.
    ///
    /// # Errors
    /// Where it cannot be written. The rows stay where they are.
    pub fn finish(mut self) -> Result<(), EvaluationError> {
        let mut places = self.places()?;
        if places.is_sorted() {
            return Ok(());
        }
        places.sort_unstable();
        let path = self.path.clone();
        let write = |from: &mut File| -> std::io::Result<()> {
            let sorted = Draft::beside(&path)?;
            // Created as any file; `publish` then copies mode and owner from the rows.
            let mut out = BufWriter::new(sorted.create(0o666)?);
            let mut reader = BufReader::new(from);
            let mut line = Vec::new();
            // One line at a time: a place needs a few bytes of memory, a row hundreds.
            for (_, place) in places {
                line.clear();
                reader.seek(SeekFrom::Start(place))?;
                reader.read_until(b'\n', &mut line)?;
                out.write_all(&line)?;
            }
            out.flush()?;
            sorted.publish()
        };
        write(&mut self.rows).map_err(EvaluationError::io(&path))
    }

    /// Place (bytes) of every row, with its episode.
    fn places(&mut self) -> Result<Vec<(Key, u64)>, EvaluationError> {
        let mut places = Vec::new();
        self.each_row(|place, row| {
            places.push((row.key(), place));
            Ok(())
        })?;
        Ok(places)
    }

    /// The side file is new, or its first line was cut off by a kill.
    fn write_plan(&mut self) -> Result<(), EvaluationError> {
        let empty = self.info.set_len(0);
        let line = line_of(&self.plan);
        let write = empty.and_then(|()| self.info.write_all(line.as_bytes()));
        write.map_err(EvaluationError::io(&info::path_of(&self.path)))
    }

    fn check_plan(&self, found: &Plan) -> Result<(), EvaluationError> {
        let seeds = |plan: &Plan| format!("{}..{}", plan.seeds[0], plan.seeds[1]);
        let (identity, own) = (&found.identity, &self.plan.identity);
        for (what, found, wanted) in [
            ("build", identity.build.clone(), own.build.clone()),
            ("input", identity.inputs.clone(), own.inputs.clone()),
            ("range of seeds", seeds(found), seeds(&self.plan)),
            (
                "shard",
                found.shard.to_string(),
                self.plan.shard.to_string(),
            ),
        ] {
            if found != wanted {
                let path = self.path.clone();
                return Err(EvaluationError::Other {
                    path,
                    what,
                    found,
                    wanted,
                });
            }
        }
        Ok(())
    }

    /// Reads the rows of the file, and cuts off the part of a line that a kill left. A file
    /// that no evaluation has started is not changed.
    fn take_rows(&mut self, is_begun: bool) -> Result<(), EvaluationError> {
        let mut done = BTreeSet::new();
        let (plan, path) = (self.plan.clone(), self.path.clone());
        let mut number = 0;
        let end = self.each_row(|_, row| {
            number += 1;
            let reason = if row.build != plan.identity.build || row.inputs != plan.identity.inputs {
                "of another build, or of other inputs"
            } else if !plan.shard.has(&plan.range(), row.seed) {
                "of a seed that is not of this shard"
            } else if !plan.variants().contains(&row.variant) {
                "of a variant that is not of this evaluation"
            } else if !done.insert(row.key()) {
                "of an earlier episode"
            } else {
                return Ok(());
            };
            Err(EvaluationError::Line {
                path: path.clone(),
                line: number,
                reason: format!("{}: {reason}", row.key()),
            })
        })?;
        let length = self
            .rows
            .metadata()
            .map_err(EvaluationError::io(&self.path))?;
        if !is_begun && length.len() > end {
            return Err(EvaluationError::Line {
                path,
                line: number + 1,
                reason: "the line has no end, and no evaluation has started this file; name \
                         another one"
                    .to_owned(),
            });
        }
        self.done = done;
        self.rows
            .set_len(end)
            .map_err(EvaluationError::io(&self.path))
    }

    /// Calls `take` with place and content of every complete line; the place behind them.
    fn each_row(
        &mut self,
        mut take: impl FnMut(u64, &Row) -> Result<(), EvaluationError>,
    ) -> Result<u64, EvaluationError> {
        let fail = || EvaluationError::io(&self.path);
        let mut reader = BufReader::new(&self.rows);
        reader.seek(SeekFrom::Start(0)).map_err(fail())?;
        let (mut place, mut number, mut line) = (0, 0, String::new());
        loop {
            let count = user_file::read_line(&mut reader, &mut line).map_err(fail())?;
            if !line.ends_with('\n') {
                return Ok(place);
            }
            number += 1;
            let row: Row = serde_json::from_str(&line).map_err(|error| EvaluationError::Line {
                path: self.path.clone(),
                line: number,
                reason: error.to_string(),
            })?;
            take(place, &row)?;
            place += u64::try_from(count).unwrap_or(0);
        }
    }
}

/// Files that did not exist, and are removed again where the evaluation is refused.
#[derive(Debug, Default)]
struct Created(Vec<PathBuf>);

impl Created {
    fn open(&mut self, path: &Path) -> io::Result<File> {
        let mut options = OpenOptions::new();
        // Rows are appended after `each_row` has moved the position of this descriptor.
        let options = options.read(true).append(true);
        match options.clone().create_new(true).open(path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => options.open(path),
            made => {
                self.0.extend(made.is_ok().then(|| path.to_owned()));
                made
            }
        }
    }

    fn has(&self, path: &Path) -> bool {
        self.0.iter().any(|created| created == path)
    }

    fn keep(mut self) {
        self.0.clear();
    }
}

impl Drop for Created {
    fn drop(&mut self) {
        for path in &self.0 {
            std::fs::remove_file(path).ok();
        }
    }
}

/// One line of JSON.
fn line_of(value: &impl serde::Serialize) -> String {
    // Cannot fail: keys are strings, and numbers are finite.
    let mut line = serde_json::to_string(value).unwrap_or_default();
    line.push('\n');
    line
}
