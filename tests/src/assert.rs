//! What has to be true after a test.

use std::path::Path;

use serde_json::Value;

use crate::program::{Said, wait_for};

/// The program refused, said one thing, and named all of `words`.
///
/// # Panics
/// Where it did not.
pub fn refused(said: &Said, code: i32, words: &[&str]) {
    assert_eq!(said.code, code, "{said:?}");
    assert!(!said.stderr.contains("panicked"), "{said:?}");
    for word in words {
        assert!(
            said.stderr.contains(word),
            "`{word}` is not named: {said:?}"
        );
    }
}

/// Nothing was started and nothing was written: no run directory, or an empty
/// one.
///
/// # Panics
/// Where something was.
pub fn nothing_started(base: &Path) {
    let left: Vec<_> = std::fs::read_dir(base)
        .expect("the directory")
        .flatten()
        .map(|e| e.path())
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

/// Files of this run directory's cells in shared memory.
///
/// # Panics
/// Where shared memory cannot be listed.
pub fn segments(prefix: &str) -> Vec<String> {
    let entries = std::fs::read_dir("/dev/shm")
        .expect("shared memory")
        .flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    names.filter(|name| name.starts_with(prefix)).collect()
}

/// The prefix of the cell's names in shared memory.
///
/// # Panics
/// Where it has no run file.
pub fn prefix(run_dir: &Path) -> String {
    let text = wait_for("the run file", || {
        std::fs::read_to_string(run_dir.join("run.json")).ok()
    });
    let spec: Value = serde_json::from_str(&text).expect("a run file");
    spec["prefix"].as_str().expect("a prefix").to_owned()
}

/// Waits until no process of these ids exists.
///
/// # Panics
/// Where one stays.
pub fn all_gone(pids: &[u32]) {
    wait_for("the end of the processes", || {
        pids.iter()
            .all(|pid| !cell_rt::process::is_alive(*pid))
            .then_some(())
    });
}
