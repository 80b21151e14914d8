//! One node of the library in a separate tree; everything else stays as it was.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot continue has failed"
)]

#[path = "../../../../skills/tests/it/bench/mod.rs"]
mod bench;
mod nodes_check;
mod nodes_take;

use std::collections::BTreeMap;
use std::sync::Arc;

use behavior::Value;
use behavior::board::Board;
use behavior::descriptor::{self, Source};
use behavior::value::Set;
use cell_model::{Cell, Data};

use super::notes::{Numbers, to_numbers};
use super::numbers::PyramidTask;
use super::{Pyramid, library};
use bench::{Bench, LEFT, RIGHT, numbers, pose};

const FILE: &str = "franka-pyramid.tree.json";
/// The keys with the object on which the tree works.
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

/// The cubes are in the stack of an arm, whose middle is at `y` (m), and marked so.
fn stack(bench: &mut Bench, (robot, y): (&str, f64), cubes: &[u32]) {
    bench.set(&format!("placed:{robot}"), set_of(cubes));
    for (layer, cube) in cubes.iter().enumerate() {
        bench.set_text(
            &format!("cube_state:cube_{}", cube + 1),
            &format!("placed:{robot}"),
        );
        *bench.object(*cube as usize) = [0.46, y, 0.025 + 0.05 * layer as f64];
    }
}

fn set_of(cubes: &[u32]) -> Value {
    let set = cubes.iter().copied().fold(Set::default(), Set::with);
    Value::Set(set)
}

/// The names of the source, and those that this demo had at first.
#[test]
fn a_file_with_the_names_of_others_is_read_without_findings() {
    let (cell, task) = cell();
    let job = Arc::new(Pyramid::new(&task, &cell).unwrap());
    let library = library(&job);
    let mut text = cell.read(FILE).unwrap().into_owned();
    for (ours, theirs) in [
        ("\"LeaveZone\"", "\"ReleaseCenter\""),
        ("in_zone", "in_center"),
        ("\"straight_lead\": 0.05", "\"movement_tolerance\": 0.01"),
        (
            "\"orientation_tolerance\": 0.5",
            "\"end_effector_yaw_degrees\": 0.0",
        ),
        ("\"ports\": {\"target\"", "\"ports\": {\"target_prim\""),
        (
            "\"name\": \"recover\",",
            "\"name\": \"recover\", \"ports\": {\"stable_duration\": 0.2},",
        ),
    ] {
        assert!(text.contains(ours), "{ours}");
        text = text.replace(ours, theirs);
    }
    for known in library.types().iter().filter(|t| !t.aliases.is_empty()) {
        let named = |name: &str| format!("\"type\": \"{name}\"");
        for older in known
            .aliases
            .iter()
            .filter(|name| name.starts_with("Franka"))
        {
            text = text.replace(&named(known.name), &named(older));
        }
    }
    text = text.replace("\"ReleaseCenter\"", "\"FrankaReleaseCenter\"");
    let source = Source {
        file: FILE,
        text: &text,
        include: &|_| Err(String::new()),
    };
    let constants = BTreeMap::new();
    let findings = descriptor::check(&source, &library, &constants, &Board::new());
    assert_eq!(findings.unwrap_or_else(|e| panic!("{e}")), []);
    assert_eq!(text.matches("\"Franka").count(), 20, "{text}");
}
