//! Computes the episodes of a data set again, from the column `action` alone.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use cell_model::Data;
use cell_rt::stdout;
use cell_run::spec::RunSpec;
use cell_sim::OneProcess;
use cell_sim::action::{Hold, NUMBERS, decision_of};
use cell_sim::controller_proc::Controllers;
use ipc_types::Decision;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::{Field, Row};
use parquet::schema::types::Type;

use crate::ExportError;
use crate::episode::Action;
use crate::features::arms;

/// An episode of a data set.
struct Stored {
    run: RunSpec,
    state_hash: String,
    ticks: u64,
    grip_force: f64,
    actions: Vec<Action>,
    /// `observation.state` of each frame.
    states: Vec<Vec<f32>>,
}

/// Computes all episodes and prints the result; whether one differs.
pub(crate) fn run(data: &Data, dir: &Path) -> Result<bool, ExportError> {
    let episodes = read(dir)?;
    let frames: usize = episodes.values().map(|one| one.actions.len()).sum();
    let (count, differences) = (episodes.len(), differences(data, &episodes)?);
    let equal = count - differences.len();
    for (index, why) in &differences {
        let seed = episodes.get(index).map_or(0, |one| one.run.seed);
        stdout::line(format_args!("episode {index}, seed {seed}: {why}"));
    }
    stdout::line(format_args!(
        "{}: {equal} of {count} episodes with {frames} frames are equal",
        dir.display()
    ));
    Ok(!differences.is_empty())
}

/// By episode that differs: where.
fn differences(
    data: &Data,
    episodes: &BTreeMap<i64, Stored>,
) -> Result<BTreeMap<i64, String>, ExportError> {
    let left = Mutex::new(episodes.iter());
    let found = Mutex::new((BTreeMap::new(), None));
    let work = || {
        // One at a time: episodes differ in length, so equal shares would leave threads idle.
        let next = || left.lock().unwrap_or_else(PoisonError::into_inner).next();
        while let Some((index, episode)) = next() {
            let result = difference(data, episode);
            let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
            match result {
                Ok(None) => {}
                Ok(Some(why)) => drop(found.0.insert(*index, why)),
                Err(error) => found.1 = Some(error),
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    std::thread::scope(|scope| {
        (0..threads).for_each(|_| drop(scope.spawn(work)));
    });
    let (found, error) = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    error.map_or(Ok(found), Err)
}

/// The first difference of an episode.
fn difference(data: &Data, stored: &Stored) -> Result<Option<String>, ExportError> {
    let spec = &stored.run;
    let cell = spec.load_cell_from(data)?;
    let hold = Hold::new(spec.action_hz.unwrap_or_default()).map_err(cell_sim::SimError::from)?;
    let (actions, force) = (stored.actions.clone(), stored.grip_force);
    let decide = move |tick: u64, decision: &mut Decision| {
        // After the last action the last one stays in force.
        let frame = usize::try_from(hold.action(tick)).unwrap_or(usize::MAX);
        if let Some(action) = actions.get(frame).or(actions.last()) {
            *decision = decision_of(tick, action, force);
        }
    };
    let controllers = Controllers::default();
    let mut sim = OneProcess::following(&controllers, spec, cell.clone(), Box::new(decide))?;
    loop {
        let state = sim.state();
        let tick = state.header.tick;
        if hold.begins(tick)
            && let Some(recorded) = stored
                .states
                .get(usize::try_from(hold.action(tick)).unwrap_or(usize::MAX))
        {
            // The hash at the end would tell that an episode differs, but not where.
            let computed = arms(&cell, state);
            // Bits are compared: NaN equals itself, and -0 differs from 0.
            let differs = computed.iter().zip(recorded);
            if let Some(at) = differs
                .into_iter()
                .position(|(one, two)| one.to_bits() != two.to_bits())
            {
                let value = |numbers: &[f32]| numbers.get(at).copied().unwrap_or(0.0);
                return Ok(Some(format!(
                    "frame {}, {:.2} s: number {at} of observation.state is {}, {} was recorded",
                    hold.action(tick),
                    tick as f64 * 1.0e-3,
                    value(&computed),
                    value(recorded)
                )));
            }
        }
        if tick >= stored.ticks {
            break;
        }
        if !sim.tick()? {
            return Ok(Some(format!("it ends at {:.2} s", tick as f64 * 1.0e-3)));
        }
    }
    let hash = format!("{:016x}", sim.state().state_hash);
    let differs = hash != stored.state_hash;
    Ok(differs.then(|| {
        format!(
            "its last state is {hash}, {} was recorded",
            stored.state_hash
        )
    }))
}

/// Reads all episodes.
fn read(dir: &Path) -> Result<BTreeMap<i64, Stored>, ExportError> {
    let mut episodes = BTreeMap::new();
    for path in tables(&dir.join("meta/episodes"))? {
        let columns = [
            "episode_index",
            "robocell/run",
            "robocell/state_hash",
            "robocell/ticks",
            "robocell/grip_force_n",
        ];
        for row in rows(&path, &columns)? {
            let run: RunSpec = serde_json::from_str(&text(&row, "robocell/run"))
                .map_err(|error| ExportError::episode(&path, format!("robocell/run: {error}")))?;
            let stored = Stored {
                run,
                state_hash: text(&row, "robocell/state_hash"),
                ticks: u64::try_from(whole(&row, "robocell/ticks")).unwrap_or(0),
                grip_force: match field(&row, "robocell/grip_force_n") {
                    Some(Field::Double(force)) => *force,
                    _ => 0.0,
                },
                actions: Vec::new(),
                states: Vec::new(),
            };
            episodes.insert(whole(&row, "episode_index"), stored);
        }
    }
    for path in tables(&dir.join("data"))? {
        for row in rows(&path, &["episode_index", "action", "observation.state"])? {
            if let Some(episode) = episodes.get_mut(&whole(&row, "episode_index")) {
                let action = numbers(&row, "action");
                let arms = action.chunks_exact(NUMBERS);
                let arms = arms.filter_map(|arm| arm.try_into().ok());
                episode.actions.push(arms.collect());
                episode.states.push(numbers(&row, "observation.state"));
            }
        }
    }
    if episodes.is_empty() {
        return Err(ExportError::episode(
            dir,
            "it has no episode; `robocell export` writes a data set",
        ));
    }
    Ok(episodes)
}

/// The files below a directory of chunks, in their order.
fn tables(dir: &Path) -> Result<Vec<PathBuf>, ExportError> {
    let list = |dir: &Path| -> Result<Vec<PathBuf>, ExportError> {
        let entries = std::fs::read_dir(dir).and_then(Iterator::collect::<Result<Vec<_>, _>>);
        let entries = entries.map_err(|error| ExportError::io(dir, error))?;
        let mut paths: Vec<PathBuf> = entries.iter().map(std::fs::DirEntry::path).collect();
        // A directory has no order, and the rows of an episode are in the order of the files.
        paths.sort();
        Ok(paths)
    };
    let mut all = Vec::new();
    for chunk in list(dir)? {
        all.extend(list(&chunk)?);
    }
    Ok(all)
}

/// The rows of a file, with these columns alone.
fn rows(path: &Path, columns: &[&str]) -> Result<Vec<Row>, ExportError> {
    let file = File::open(path).map_err(|error| ExportError::io(path, error))?;
    let all = || -> Result<Vec<Row>, ParquetError> {
        let reader = SerializedFileReader::new(file)?;
        let schema = reader.metadata().file_metadata().schema().clone();
        let fields = schema.get_fields().iter();
        let fields = fields
            .filter(|field| columns.contains(&field.name()))
            .map(Arc::clone);
        // Other columns may be pictures, which would be decoded.
        let wanted = Type::group_type_builder("schema")
            .with_fields(fields.collect())
            .build()?;
        reader.get_row_iter(Some(wanted))?.collect()
    };
    all().map_err(|error| ExportError::table(path, error))
}

fn field<'r>(row: &'r Row, name: &str) -> Option<&'r Field> {
    row.get_column_iter()
        .find(|(key, _)| *key == name)
        .map(|(_, field)| field)
}

fn whole(row: &Row, name: &str) -> i64 {
    match field(row, name) {
        Some(Field::Long(number)) => *number,
        _ => 0,
    }
}

fn text(row: &Row, name: &str) -> String {
    match field(row, name) {
        Some(Field::Str(text)) => text.clone(),
        _ => String::new(),
    }
}

fn numbers(row: &Row, name: &str) -> Vec<f32> {
    let Some(Field::ListInternal(list)) = field(row, name) else {
        return Vec::new();
    };
    let numbers = list.elements().iter().filter_map(|one| match one {
        Field::Float(number) => Some(*number),
        _ => None,
    });
    numbers.collect()
}
