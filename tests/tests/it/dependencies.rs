//! The packages on which each package may depend.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;

fn text(value: &Value) -> String {
    value.as_str().expect("text").to_owned()
}

fn metadata() -> Value {
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
    serde_json::from_slice(&output.stdout).expect("metadata")
}

/// Direct dependencies (not those of tests) of each package of the workspace.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let metadata = metadata();
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

/// Folders of `crates/`, from the bottom to the top.
const GROUPS: [&str; 3] = ["core", "tasks", "cell"];
/// Those above, of which none depends on another: a package of theirs uses public interfaces and
/// can be left out.
const BESIDE: [&str; 3] = ["gateways", "formats", "tools"];

/// The folder of `crates/` of each package in one.
fn groups() -> BTreeMap<String, String> {
    let packages = metadata()["packages"].as_array().expect("a list").clone();
    let group = |package: &Value| {
        let path = text(&package["manifest_path"]);
        let (_, below) = path.rsplit_once("/crates/")?;
        let (group, _) = below.split_once('/')?;
        Some((text(&package["name"]), group.to_owned()))
    };
    packages.iter().filter_map(group).collect()
}

#[test]
fn groups_of_crates_depend_on_each_other_one_way() {
    let groups = groups();
    let is_allowed = |own: &str, other: &str| {
        if own == other {
            return true;
        }
        let rank = |group: &str| GROUPS.iter().position(|known| *known == group);
        rank(other).is_some_and(|other| rank(own).is_none_or(|own| other < own))
    };
    for (package, group) in &groups {
        let is_known = [GROUPS, BESIDE].concat().contains(&group.as_str());
        assert!(is_known, "{package}: `crates/{group}` is not in a list");
    }
    assert!(groups.len() > 15, "{groups:?}");
    for (name, dependencies) in dependencies() {
        let Some(own) = groups.get(&name) else {
            continue;
        };
        let others = dependencies
            .iter()
            .filter_map(|d| Some((d, groups.get(d)?)));
        let wrong: Vec<_> = others.filter(|(_, of)| !is_allowed(own, of)).collect();
        assert!(wrong.is_empty(), "{name} of {own} depends on {wrong:?}");
    }
}

const PROCESSES: [&str; 5] = [
    "robocell-physics",
    "robocell-controller",
    "robocell-fci-proc",
    "robocell-task-proc",
    "robocell-monitor",
];
const ENGINES: [&str; 2] = ["rapier3d-f64", "parry3d-f64"];
const PURE: [&str; 7] = [
    "robocell-camera",
    "robocell-fci",
    "robocell-rmp",
    "robocell-plan",
    "robocell-behavior",
    "robocell-cell-model",
    "robocell-task",
];
/// Pure as well, but grasps need the shapes of parry (ADR 35).
const PURE_WITH_PARRY: [&str; 3] = ["robocell-grasp", "robocell-skills", "robocell-demos"];

/// Names of all packages `package` is built from, built alone.
fn closure(package: &str) -> BTreeSet<String> {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["tree", "--offline", "--locked", "--prefix", "none"])
        .args(["--edges", "normal,build", "--package", package])
        .args(["--manifest-path", manifest])
        .output()
        .expect("cargo");
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8_lossy(&output.stdout);
    let name = |line: &str| line.split(' ').next().map(str::to_owned);
    text.lines().filter_map(name).collect()
}

#[test]
fn only_what_joins_the_cores_knows_a_process() {
    for (name, dependencies) in dependencies() {
        // The Python package runs cells in its own process, the drill in virtual time; a gateway
        // recomputes the commands of its process.
        let joins = [
            "robocell-cell-sim",
            "robocell-gateways",
            "robocell-benches",
            "robocell-drill",
            "robocell-python",
        ];
        if !joins.contains(&name.as_str()) {
            let known: Vec<_> = PROCESSES
                .iter()
                .filter(|p| dependencies.contains(**p))
                .collect();
            assert!(known.is_empty(), "{name} depends on {known:?}");
        }
    }
}

#[test]
fn every_process_is_in_the_builds_that_leave_the_checkout_or_begin_in_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for file in [
        "crates/tools/from-checkout/src/main.rs",
        "python/build-wheel",
    ] {
        let text = std::fs::read_to_string(root.join(file)).unwrap();
        let missing: Vec<_> = PROCESSES.iter().filter(|p| !text.contains(**p)).collect();
        assert!(missing.is_empty(), "{file} does not build {missing:?}");
    }
}

#[test]
fn what_is_pure_knows_neither_bus_nor_engine_however_far_down() {
    for name in PURE {
        let all = closure(name);
        let impure: Vec<_> = all
            .iter()
            .filter(|known| known.starts_with("iceoryx2") || *known == "robocell-cell-bus")
            .chain(all.iter().filter(|known| ENGINES.contains(&known.as_str())))
            .collect();
        assert!(impure.is_empty(), "{name} is built from {impure:?}");
    }
    for name in PURE_WITH_PARRY {
        let all = closure(name);
        assert!(all.contains("parry3d-f64"), "{all:?}");
        assert!(
            !all.contains("rapier3d-f64") && !all.contains("iceoryx2"),
            "{all:?}"
        );
    }
    let all = dependencies();
    for name in ["robocell-rmp", "robocell-behavior"] {
        assert!(
            all[name].iter().all(|other| !all.contains_key(other)),
            "{name} is usable alone"
        );
    }
}

#[test]
fn of_what_authors_of_tasks_depend_on_only_the_program_knows_bus_and_engine() {
    let program = closure("robocell-task-program");
    assert!(program.contains("iceoryx2") && program.contains("rapier3d-f64"));
    assert!(!closure("robocell-task").contains("robocell-task-program"));
}

#[test]
fn only_physics_knows_the_engine() {
    for (name, dependencies) in dependencies() {
        let known = ENGINES.iter().any(|engine| dependencies.contains(*engine));
        // Programs of its own, which no process is built from.
        let fits_spheres = name == "robocell-cell-assets";
        // Its pictures need parry.
        let draws = name == "robocell-python";
        let grasps = name == "robocell-grasp";
        assert!(
            !known
                || fits_spheres
                || draws
                || grasps
                || name == "robocell-physics"
                || name == "robocell-tests",
            "{name}"
        );
    }
}

#[test]
fn the_built_in_cells_are_known_to_programs_only() {
    let programs = [
        "robocell-launch",
        "robocell-task-program",
        "robocell-python",
        "robocell-export",
    ];
    for (name, dependencies) in dependencies() {
        let known = dependencies.contains("robocell-cell-files");
        assert!(!known || programs.contains(&name.as_str()), "{name}");
    }
}

#[test]
fn nothing_but_the_benches_depends_on_the_launcher_or_the_tests() {
    for (name, dependencies) in dependencies() {
        for leaf in ["robocell-tests", "robocell-launch", "robocell-benches"] {
            let measures = name == "robocell-benches" && leaf == "robocell-launch";
            assert!(
                measures || !dependencies.contains(leaf),
                "{name} depends on {leaf}"
            );
        }
    }
}

#[test]
fn supervision_knows_no_command_line_however_far_down() {
    let all = closure("robocell-supervisor");
    assert!(
        !all.contains("clap") && !all.contains("robocell-launch"),
        "{all:?}"
    );
    assert!(dependencies()["robocell-launch"].contains("robocell-supervisor"));
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
