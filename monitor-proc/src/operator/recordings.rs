//! Recordings requested by a page: their folder and names. A page gives no file names.

use std::path::{Path, PathBuf};

use cell_run::spec::RunSpec;

use crate::page::command::RecordOrder;
use crate::recorder::{Recorder, RecorderRequest};

/// Largest number of recordings of one demo.
// Names are tried one by one, so the search must end.
const MAX_NUMBER: u32 = 10_000;

/// Has `order` executed for the run of `spec`; returns a message for the person.
///
/// # Errors
///
/// The reason, for people.
pub fn record(recorder: &Recorder, spec: &RunSpec, order: RecordOrder) -> Result<String, String> {
    let file = || -> Result<PathBuf, String> {
        let folder = folder(&spec.record.flight_dir);
        let cannot = |error| format!("{}: {error}", folder.display());
        std::fs::create_dir_all(&folder).map_err(cannot)?;
        Ok(free(&folder, &spec.demo))
    };
    recorder.ask(match order {
        RecordOrder::Start => RecorderRequest::Start { file: file()? },
        RecordOrder::Stop => RecorderRequest::Stop,
        RecordOrder::Last(seconds) => RecorderRequest::Last {
            seconds,
            file: file()?,
        },
    })
}

/// `recordings` of all cells: in `STATE`, of a ring in `STATE/flight/CELL`; in `BASE`, of one
/// in `BASE/CELL/flight`. The next run of the cell empties `BASE/CELL`.
fn folder(flight: &Path) -> PathBuf {
    let all = flight.parent().and_then(Path::parent);
    all.unwrap_or(flight).join("recordings")
}

/// `DEMO.mcap`, or the first of `DEMO-2.mcap`, ... that is free.
fn free(folder: &Path, demo: &str) -> PathBuf {
    let name = |number: u32| match number {
        1 => folder.join(format!("{demo}.mcap")),
        _ => folder.join(format!("{demo}-{number}.mcap")),
    };
    let free = (1..MAX_NUMBER).map(name).find(|path| !path.exists());
    // Beyond the limit the name is taken, and the recorder refuses it with the file's name.
    free.unwrap_or_else(|| name(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_recording_is_written_over() {
        let dir = tempfile::tempdir().unwrap();
        assert!(free(dir.path(), "reach").ends_with("reach.mcap"));
        std::fs::write(dir.path().join("reach.mcap"), "").unwrap();
        assert!(free(dir.path(), "reach").ends_with("reach-2.mcap"));
        let (cell, run) = (Path::new("/s/flight/cell"), Path::new("/r/cell/flight"));
        assert_eq!(folder(cell), Path::new("/s/recordings"));
        assert_eq!(folder(run), Path::new("/r/recordings"));
    }
}
