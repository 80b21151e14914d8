//! The files of all shards as one, which is that of an unsharded run byte for byte.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

use cell_model::user_file;
use serde::Deserialize;

use crate::EvaluationError;
use crate::info::{self, Plan};
use crate::row::Key;

/// Problems that are reported; the others are left out.
const MOST_PROBLEMS: usize = 100;

/// The fields of a row that decide its place.
#[derive(Deserialize)]
struct Head {
    build: String,
    inputs: String,
    seed: u64,
    #[serde(default)]
    variant: u32,
}

impl Head {
    fn key(&self) -> Key {
        Key {
            seed: self.seed,
            variant: self.variant,
        }
    }
}

/// One file that is read.
struct Source {
    path: PathBuf,
    reader: BufReader<File>,
    line: String,
    number: u64,
    rows: u64,
    head: Option<Head>,
}

/// What was merged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Merged {
    /// Rows.
    pub rows: u64,
}

/// Writes the rows of `files`, in the order of their seeds, to `out`. Memory is bounded by
/// the number of files.
///
/// # Errors
/// All that is wrong with the files, with their names: a shard or a seed that is missing or
/// there twice, another build, other inputs, lines that are cut off or no rows. What was
/// written before is of no use then.
pub fn merge(files: &[PathBuf], out: &mut dyn Write) -> Result<Merged, EvaluationError> {
    let mut problems = Problems::default();
    let mut sources = Vec::new();
    for path in files {
        let file = user_file::open_file(path).map_err(EvaluationError::io(path))?;
        sources.push(Source {
            path: path.clone(),
            reader: BufReader::new(file),
            line: String::new(),
            number: 0,
            rows: 0,
            head: None,
        });
    }
    check_shards(&sources, &mut problems);
    let merged = merge_rows(&mut sources, out, &mut problems)?;
    check_complete(&sources, &mut problems);
    if problems.0.is_empty() {
        return Ok(merged);
    }
    Err(EvaluationError::Merge {
        problems: problems.0,
    })
}

#[derive(Default)]
struct Problems(Vec<String>);

impl Problems {
    fn add(&mut self, problem: String) {
        match self.0.len() {
            count if count < MOST_PROBLEMS => self.0.push(problem),
            MOST_PROBLEMS => self.0.push(format!(
                "more than {MOST_PROBLEMS} problems; only the first are shown"
            )),
            _ => {}
        }
    }
}

impl Source {
    /// Reads the next row into `line` and `head`; none at the end.
    fn next(&mut self, problems: &mut Problems) -> Result<(), EvaluationError> {
        loop {
            self.head = None;
            self.number += 1;
            let count = user_file::read_line(&mut self.reader, &mut self.line);
            if count.map_err(EvaluationError::io(&self.path))? == 0 {
                return Ok(());
            }
            let place = format!("{}:{}", self.path.display(), self.number);
            if !self.line.ends_with('\n') {
                problems.add(format!(
                    "{place}: the line is cut off; repeat the command that wrote this file, which \
                     resumes"
                ));
                return Ok(());
            }
            match serde_json::from_str(&self.line) {
                Ok(head) => {
                    self.head = Some(head);
                    self.rows += 1;
                    return Ok(());
                }
                Err(error) => problems.add(format!("{place}: no row of an episode: {error}")),
            }
        }
    }

    fn name(&self) -> std::path::Display<'_> {
        self.path.display()
    }
}

/// Shards that are missing or there twice, where side files say which there are.
fn check_shards(sources: &[Source], problems: &mut Problems) {
    let plans: Vec<(&Path, Plan)> = sources
        .iter()
        .filter_map(|source| Some((source.path.as_path(), info::plan_of(&source.path)?)))
        .collect();
    let Some((first_path, first)) = plans.first() else {
        return;
    };
    let mut seen: BTreeMap<u64, &Path> = BTreeMap::new();
    for (path, plan) in &plans {
        let of = |plan: &Plan| (plan.seeds, plan.shard.count);
        if of(plan) != of(first) {
            problems.add(format!(
                "{}: shard {} of seeds {}..{}, but {} is shard {} of seeds {}..{}",
                path.display(),
                plan.shard,
                plan.seeds[0],
                plan.seeds[1],
                first_path.display(),
                first.shard,
                first.seeds[0],
                first.seeds[1]
            ));
        } else if let Some(other) = seen.insert(plan.shard.index, path) {
            problems.add(format!(
                "{} and {} are both shard {}",
                other.display(),
                path.display(),
                plan.shard
            ));
        }
    }
    // Files without a side file may be the others.
    if plans.len() < sources.len() {
        return;
    }
    for index in (1..=first.shard.count).filter(|index| !seen.contains_key(index)) {
        problems.add(format!("shard {index}/{} is missing", first.shard.count));
    }
}

/// Whether each file has all rows of its shard.
fn check_complete(sources: &[Source], problems: &mut Problems) {
    for source in sources {
        // Without a side file only gaps between rows are found, by `check_order`.
        let Some(plan) = info::plan_of(&source.path) else {
            continue;
        };
        let all = plan.rows();
        if all != source.rows {
            problems.add(format!(
                "{}: {} of {all} rows of shard {}; repeat the command that wrote this file, which \
                 resumes",
                source.name(),
                source.rows,
                plan.shard
            ));
        }
    }
}

fn merge_rows(
    sources: &mut [Source],
    out: &mut dyn Write,
    problems: &mut Problems,
) -> Result<Merged, EvaluationError> {
    let mut queue = BinaryHeap::new();
    for (index, source) in sources.iter_mut().enumerate() {
        source.next(problems)?;
        queue.extend(
            source
                .head
                .as_ref()
                .map(|head| Reverse((head.key(), index))),
        );
    }
    let mut rows = 0;
    let mut identity: Option<(String, String, PathBuf)> = None;
    let mut last: Option<(Key, usize)> = None;
    while let Some(Reverse((key, index))) = queue.pop() {
        let path = sources[index].path.clone();
        if let Some((before, of)) = last {
            let place = format!("{}:{}", path.display(), sources[index].number);
            check_order((before, &sources[of].path), (key, &path, place), problems);
        }
        last = Some((key, index));
        let source = &mut sources[index];
        if let Some(head) = &source.head {
            check_identity(head, &path, &mut identity, problems);
        }
        // The line as it was read: the result has to equal an unsharded run byte for byte.
        let written = out.write_all(source.line.as_bytes());
        written.map_err(EvaluationError::io(Path::new("the merged rows")))?;
        rows += 1;
        source.next(problems)?;
        queue.extend(
            source
                .head
                .as_ref()
                .map(|head| Reverse((head.key(), index))),
        );
    }
    Ok(Merged { rows })
}

/// Each row is behind the one before, and no seed is between them.
fn check_order(
    (before, of): (Key, &Path),
    (key, path, place): (Key, &Path, String),
    problems: &mut Problems,
) {
    let between = key.seed.saturating_sub(before.seed);
    if before == key {
        problems.add(format!(
            "{key} is in {} and in {}",
            of.display(),
            path.display()
        ));
    } else if before > key {
        // Rows are in the order in which episodes ended, until `RowsFile::finish` sorts them.
        problems.add(format!(
            "{place}: {key} follows {before}: the file is not finished; repeat the command \
             that wrote it, which resumes"
        ));
    } else if between == 2 {
        problems.add(format!("seed {} is missing", before.seed + 1));
    } else if between > 2 {
        problems.add(format!(
            "seeds {} to {} are missing",
            before.seed + 1,
            key.seed - 1
        ));
    }
}

/// All rows are of one build and of the same inputs.
fn check_identity(
    head: &Head,
    path: &Path,
    first: &mut Option<(String, String, PathBuf)>,
    problems: &mut Problems,
) {
    let Some((build, inputs, of)) = first else {
        *first = Some((head.build.clone(), head.inputs.clone(), path.to_owned()));
        return;
    };
    for (what, one, other) in [
        ("build", &head.build, &*build),
        ("inputs", &head.inputs, &*inputs),
    ] {
        if one != other {
            let (path, of) = (path.display(), of.display());
            let problem = format!("{path}: {what} {one}, but {of} has {other}");
            // Once for a file, and not for each of its rows.
            if !problems.0.contains(&problem) {
                problems.add(problem);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_that_are_not_shown_are_reported() {
        let mut problems = Problems::default();
        for number in 0..MOST_PROBLEMS + 10 {
            problems.add(format!("problem {number}"));
        }
        assert_eq!(problems.0.len(), MOST_PROBLEMS + 1);
        assert!(problems.0[MOST_PROBLEMS].contains("more than 100 problems"));
    }
}
