//! Jobs in behaviour files, without Rust: `[task] kind = "tree"`, `"machine"` or `"matrix"`.

mod dead_ends;
mod machine;
mod matrix;
mod nested;
mod parts;
mod phases;
mod tree;

use std::collections::BTreeMap;
use std::sync::Arc;

use behavior::Finding;
use behavior::descriptor::Source;
use behavior::inline::Inline;
use behavior::tree::Tree;
use cell_model::{Cell, Data};
use robocell_task::{AnyPolicy, Kind, Policies, SetupError};

use parts::Loader;

use crate::settings::{FileTask, PlaceTable};
use crate::setup::Setup;
use crate::skill::Station;

pub use tree::{StillDone, TreeJob, TreePolicy, TreeSource};

/// Name of the kind for trees.
pub const TREE: &str = "tree";
/// Name of its policy, and of this policy in cells with several.
pub const JSON: &str = "json";
/// Name of the kind for machines.
pub const MACHINE: &str = "machine";
/// Name of its policy, and of this policy in cells with several.
pub const TABLE: &str = "table";
/// Name of the kind and of the policy for matrices.
pub const MATRIX: &str = "matrix";

/// Adds the kinds that need no Rust.
#[must_use]
pub fn with_file_jobs(policies: Policies) -> Policies {
    policies
        .with(tree_kind())
        .with(machine_kind())
        .with(matrix_kind())
}

fn tree_kind() -> Kind<FileTask> {
    Kind::<FileTask>::new(TREE)
        .policy(JSON, |task, cell| {
            let sources = cell.arms.iter().map(|arm| {
                let (file, board) = task.of_arm(&arm.name);
                TreeSource {
                    file: file.to_owned(),
                    board: board.to_owned(),
                }
            });
            let mut job = TreeJob::new(Arc::new(Setup::new(cell, &task.place)));
            job.once = task.once;
            Ok(Box::new(job.policy(cell, &sources.collect::<Vec<_>>())?))
        })
        .trees(|_: &Data| Ok(nested::unknown()))
}

fn machine_kind() -> Kind<FileTask> {
    Kind::<FileTask>::new(MACHINE)
        .policy(TABLE, |task, cell| {
            machine(cell, &task.place, &task.behaviour)
        })
        .machines(check)
}

fn matrix_kind() -> Kind<FileTask> {
    Kind::<FileTask>::new(MATRIX).policy(MATRIX, |task, cell| {
        matrix(cell, &task.place, &task.behaviour)
    })
}

/// Findings about a machine or matrix that is checked without its cell, or its errors. `None`
/// if its states and handlers have no steps: they are those of a program.
fn check(source: &Source<'_>) -> Option<Result<Vec<Finding>, SetupError>> {
    let inline = match Inline::read(source.file, source.text) {
        Ok(inline) => inline,
        Err(wrong) => return Some(Err(SetupError::in_file(wrong.to_string()))),
    };
    // Without a cell every name of an object or place counts as known.
    let setup = Arc::new(Setup::unknown());
    let loader = Loader::alone(source, nested::unknown());
    if !inline.handlers.is_empty() {
        let loaded = matrix::MatrixPolicy::load(loader, &setup, source.text);
        return Some(loaded.map(|job| job.check(&inline)));
    }
    if !inline.states.is_empty() {
        let loaded = machine::MachineJob::load(loader, source.text);
        return Some(loaded.map(|job| job.check(&inline)));
    }
    None
}

/// The policy of a tree in code, for the first arm of the cell.
pub fn tree_in_code(setup: &Arc<Setup>, tree: Tree<Station>) -> Box<dyn AnyPolicy> {
    Box::new(TreePolicy::of_tree(setup, tree))
}

/// The policy of trees in files, one for each arm of the cell.
///
/// # Errors
/// Returns a [`SetupError`] with all errors of a file.
pub fn tree(
    cell: &Cell,
    places: &BTreeMap<String, PlaceTable>,
    sources: &[TreeSource],
) -> Result<Box<dyn AnyPolicy>, SetupError> {
    let job = TreeJob::new(Arc::new(Setup::new(cell, places)));
    Ok(Box::new(job.policy(cell, sources)?))
}

/// The policy of the machine in `file`, beside the cell file.
///
/// # Errors
/// Returns a [`SetupError`] with all errors of the file.
pub fn machine(
    cell: &Cell,
    places: &BTreeMap<String, PlaceTable>,
    file: &str,
) -> Result<Box<dyn AnyPolicy>, SetupError> {
    let setup = Arc::new(Setup::new(cell, places));
    let (loader, text) = Loader::new(cell, nested::of_file(cell, &setup, file), file)?;
    let policy = machine::MachinePolicy::load(loader, &setup, &text)?;
    Ok(Box::new(policy))
}

/// The policy of the matrix in `file`, beside the cell file.
///
/// # Errors
/// Returns a [`SetupError`] with all errors of the file.
pub fn matrix(
    cell: &Cell,
    places: &BTreeMap<String, PlaceTable>,
    file: &str,
) -> Result<Box<dyn AnyPolicy>, SetupError> {
    let setup = Arc::new(Setup::new(cell, places));
    let (loader, text) = Loader::new(cell, nested::of_file(cell, &setup, file), file)?;
    let policy = matrix::MatrixPolicy::load(loader, &setup, &text)?;
    Ok(Box::new(policy))
}
