//! Files a person writes: cells, behaviours, robots. Each is put into a copy of the
//! built-in files and loaded as a run does.

use std::cell::OnceCell;
use std::path::{Path, PathBuf};

use cell_model::robots::{rmpflow, urdf, xrdf};
use cell_model::{Cell, Data};
use cell_sim::{OneProcess, eval::template};
use tempfile::TempDir;

use super::Target;

pub(crate) const CELL: Target = Target {
    name: "cell",
    run: |bytes| load(bytes, "cells/fuzzed.toml", "fuzzed", Use::Run),
    corpus: || {
        let mut cells = all("cells", ".toml");
        cells.retain(|(name, _)| !name.contains(".matrix.") && !name.contains(".machine."));
        texts(cells)
    },
};
pub(crate) const TREE: Target = Target {
    name: "tree",
    run: |bytes| {
        let file = "cells/franka-pyramid.tree.json";
        load(bytes, file, "franka-pyramid", Use::Task);
    },
    corpus: || vec![text("cells/franka-pyramid.tree.json")],
};
pub(crate) const MACHINE: Target = Target {
    name: "machine",
    run: |bytes| {
        let file = "cells/ur10-palletize.machine.toml";
        load(bytes, file, "ur10-palletize", Use::Task);
    },
    corpus: || vec![text("cells/ur10-palletize.machine.toml")],
};
pub(crate) const MATRIX: Target = Target {
    name: "matrix",
    run: |bytes| {
        let file = "cells/ur10-fill-bin.matrix.toml";
        load(bytes, file, "ur10-fill-bin", Use::Task);
    },
    corpus: || vec![text("cells/ur10-fill-bin.matrix.toml")],
};
pub(crate) const URDF: Target = Target {
    name: "urdf",
    run: |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let _read = urdf::parse("fuzzed.urdf", &text).is_ok();
    },
    corpus: || texts(all("robots", ".urdf")),
};
pub(crate) const XRDF: Target = Target {
    name: "xrdf",
    run: |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let _read = xrdf::parse("fuzzed.xrdf", &text).is_ok();
    },
    corpus: || texts(all("robots", ".xrdf")),
};
pub(crate) const TUNING: Target = Target {
    name: "tuning",
    run: |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let _read = rmpflow::parse("fuzzed.yaml", &text).is_ok();
    },
    corpus: || texts(all("robots", ".yaml")),
};

/// Use of a cell that can be loaded.
#[derive(Clone, Copy, PartialEq)]
enum Use {
    /// Its task is created, which reads the behaviour file.
    Task,
    /// It runs for some ticks.
    Run,
}

/// Ticks a cell runs.
const TICKS: usize = 20;

/// Loads `demo` with `bytes` as the text of `file`.
fn load(bytes: &[u8], file: &str, demo: &str, then: Use) {
    thread_local! {
        static COPY: OnceCell<Option<TempDir>> = const { OnceCell::new() };
    }
    COPY.with(|copy| {
        let Some(dir) = copy.get_or_init(copy_of_data) else {
            return;
        };
        let path = dir.path().join(file);
        let before = std::fs::read(&path).ok();
        if std::fs::write(&path, bytes).is_err() {
            return;
        }
        work(&Data::dir(dir.path()), demo, then);
        // The next target finds the original file.
        let _restored = match before {
            Some(text) => std::fs::write(&path, text).is_ok(),
            None => std::fs::remove_file(&path).is_ok(),
        };
    });
}

fn work(data: &Data, demo: &str, then: Use) {
    let Ok(cell) = Cell::load(data, demo, 0, None) else {
        return;
    };
    let policies = demos::policies();
    let spec = template(demo, &cell.default_policy.clone());
    if then == Use::Task {
        let _made = policies.task(&cell, &spec.policy).is_ok();
        return;
    }
    let Ok(mut sim) = OneProcess::new(&policies, &spec, cell) else {
        return;
    };
    for _ in 0..TICKS {
        if !sim.tick().unwrap_or(false) {
            return;
        }
    }
}

fn copy_of_data() -> Option<TempDir> {
    let dir = tempfile::tempdir().ok()?;
    for folder in ["cells", "robots"] {
        copy(&Data::checkout_dir().join(folder), &dir.path().join(folder)).ok()?;
    }
    Some(dir)
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if entry.file_type()?.is_dir() {
            copy(&from, &to)?;
        } else {
            std::fs::copy(from, to)?;
        }
    }
    Ok(())
}

fn text(file: &str) -> Vec<u8> {
    std::fs::read(Data::checkout_dir().join(file)).unwrap_or_default()
}

/// Names and texts of all files below `folder` that end so, by name.
fn all(folder: &str, ends: &str) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut open = vec![Data::checkout_dir().join(folder)];
    while let Some(dir) = open.pop() {
        for entry in std::fs::read_dir(dir).into_iter().flatten().flatten() {
            let path: PathBuf = entry.path();
            let name = path.display().to_string();
            if path.is_dir() {
                open.push(path);
            } else if name.ends_with(ends) {
                found.push((name, std::fs::read(path).unwrap_or_default()));
            }
        }
    }
    found.sort();
    found
}

fn texts(files: Vec<(String, Vec<u8>)>) -> Vec<Vec<u8>> {
    files.into_iter().map(|(_, text)| text).collect()
}
