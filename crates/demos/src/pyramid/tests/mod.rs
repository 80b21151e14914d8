//! One node of the library in a tree of its own; all else stays as it was.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot continue has failed"
)]

#[path = "../../../../skills/tests/it/bench/mod.rs"]
mod bench;
mod nodes_check;
mod nodes_take;

use std::sync::Arc;

use behavior::Value;
use behavior::value::Set;
use cell_model::{Cell, Data};

use super::notes::{Numbers, to_numbers};
use super::numbers::PyramidTask;
use super::{Pyramid, library};
use bench::{Bench, LEFT, RIGHT, numbers, pose};

const FILE: &str = "franka-pyramid.tree.json";
/// The keys that say at what the tree works.
const WORK: (&str, &str) = ("current_cube", "pickup_reference");

fn cell() -> (Cell, PyramidTask) {
    let cell = Cell::load(&Data::checkout(), "franka-pyramid", 1, None).unwrap();
    let task = cell.task.read().unwrap();
    (cell, task)
}

/// A tree of one node, `{"type": ..., "ports": ...}`, for `arm`.
fn bench(arm: usize, mut node: serde_json::Value) -> Bench {
    let (cell, task) = cell();
    let job = Arc::new(Pyramid::new(&task, &cell).unwrap());
    let text = cell.read(FILE).unwrap();
    let mut file: serde_json::Value = serde_json::from_str(&text).unwrap();
    node["id"] = "node".into();
    file["root"] = node;
    let setup = Arc::clone(&job.setup);
    Bench::of((&cell, setup), &library(&job), arm, &file)
}

fn current(bench: &Bench) -> String {
    bench.local_text("current_cube")
}

fn target(bench: &Bench, key: &str) -> Option<Numbers> {
    match bench.local(key)? {
        Value::Numbers(numbers) => numbers.as_slice().try_into().ok(),
        other => panic!("{other:?}"),
    }
}

fn set_of(cubes: &[u32]) -> Value {
    let set = cubes.iter().copied().fold(Set::default(), Set::with);
    Value::Set(set)
}
