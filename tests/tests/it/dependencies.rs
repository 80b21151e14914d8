//! Who may know whom.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on has failed"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;

/// Direct dependencies (not those of tests) of each package of the workspace.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let arguments = [
        "metadata",
        "--no-deps",
        "--offline",
        "--format-version",
        "1",
        "--manifest-path",
        manifest,
    ];
    let output = Command::new(cargo).args(arguments).output().expect("cargo");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("metadata");
    let text = |value: &Value| value.as_str().expect("text").to_owned();
    let of = |package: &Value| {
        let all = package["dependencies"].as_array().expect("a list").iter();
        all.filter(|d| d["kind"].is_null())
            .map(|d| text(&d["name"]))
            .collect()
    };
    metadata["packages"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|p| (text(&p["name"]), of(p)))
        .collect()
}

const PROCESSES: [&str; 4] = [
    "physics-proc",
    "controller-proc",
    "task-proc",
    "monitor-proc",
];
const ENGINES: [&str; 2] = ["rapier3d-f64", "parry3d-f64"];

#[test]
fn only_the_one_process_cell_knows_a_process() {
    for (name, dependencies) in dependencies() {
        if name != "cell-sim" {
            let known: Vec<_> = PROCESSES
                .iter()
                .filter(|p| dependencies.contains(**p))
                .collect();
            assert!(known.is_empty(), "{name} depends on {known:?}");
        }
    }
}

#[test]
fn the_cores_know_neither_bus_nor_engine() {
    let all = dependencies();
    for name in ["rmp", "behavior", "cell-model"] {
        for forbidden in ["cell-bus", "iceoryx2"].iter().chain(&ENGINES) {
            assert!(
                !all[name].contains(*forbidden),
                "{name} depends on {forbidden}"
            );
        }
    }
    for name in ["rmp", "behavior"] {
        assert!(
            all[name].iter().all(|other| !all.contains_key(other)),
            "{name} is usable alone"
        );
    }
}

#[test]
fn only_physics_knows_the_engine() {
    for (name, dependencies) in dependencies() {
        let known = ENGINES.iter().any(|engine| dependencies.contains(*engine));
        assert!(
            !known || name == "physics-proc" || name == "robocell-tests",
            "{name}"
        );
    }
}

#[test]
fn nothing_depends_on_the_tests_or_the_launcher() {
    for (name, dependencies) in dependencies() {
        for leaf in ["robocell-tests", "launch"] {
            assert!(!dependencies.contains(leaf), "{name} depends on {leaf}");
        }
    }
}

#[test]
fn the_six_packages_the_cell_is_made_of_are_used_directly() {
    let all = dependencies();
    for package in [
        "iceoryx2",
        "rapier3d-f64",
        "parry3d-f64",
        "nalgebra",
        "urdf-rs",
        "serde",
    ] {
        assert!(
            all.values()
                .any(|dependencies| dependencies.contains(package)),
            "{package}"
        );
    }
}
