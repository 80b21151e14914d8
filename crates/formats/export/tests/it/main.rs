//! Data sets of recorded episodes.
#![allow(clippy::unwrap_used, reason = "a test that cannot continue has failed")]

use std::path::{Path, PathBuf};

use cell_model::cells::sweep::Sweep;
use cell_model::{Cell, Data};
use cell_run::spec::RunSpec;
use cell_sim::controller_proc::Controllers;
use cell_sim::{Program, episodes, eval};
use export::{export, replay};
use serde_json::Value;

/// Records episodes of a demo at 20 Hz.
fn record(
    dir: &Path,
    demo: &str,
    seeds: std::ops::RangeInclusive<u64>,
    limit_s: f64,
) -> Vec<PathBuf> {
    std::fs::create_dir_all(dir).unwrap();
    let program = Program {
        policies: demos::policies(),
        controllers: Controllers::default(),
        gateways: Vec::new(),
        data: Data::checkout(),
    };
    let cell = Cell::load(&Data::checkout(), demo, 1, None).unwrap();
    let spec = RunSpec {
        action_hz: Some(20),
        frame_hash: Vec::new(),
        policy_server: None,
        arms: u8::try_from(cell.arms.len()).unwrap(),
        time_limit_s: Some(limit_s),
        ..eval::template(demo, &cell.default_policy)
    };
    let plan = eval::Plan {
        cases: episodes::cases(&program, &spec, Sweep::default()).unwrap(),
        spec,
        seeds: seeds.clone(),
        jobs: 1,
        record: Some(dir.to_owned()),
    };
    eval::evaluate(&program, &plan, |_| {}).unwrap();
    seeds
        .map(|seed| dir.join(episodes::recording_name(seed, 0)))
        .collect()
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn a_data_set_names_its_features_and_its_episodes_come_back_from_their_actions() {
    let dir = tempfile::tempdir().unwrap();
    let files = record(dir.path(), "cube", 1..=2, 20.0);
    let out = dir.path().join("set");
    let data = Data::checkout();
    let said = export(&data, &out, &files, &["wrist".to_owned()]).unwrap();
    assert!(said.starts_with("2 episodes, "), "{said}");
    let info = json(&out.join("meta/info.json"));
    assert_eq!(
        (&info["fps"], &info["total_episodes"]),
        (&20.into(), &2.into())
    );
    let features = &info["features"];
    assert_eq!(features["action"]["shape"], serde_json::json!([8]));
    assert_eq!(features["observation.state"]["names"][7], "panda.tcp_x");
    assert_eq!(
        features["observation.images.wrist"]["shape"],
        serde_json::json!([224, 224, 3])
    );
    let stats = json(&out.join("meta/stats.json"));
    assert_eq!(
        stats["observation.images.wrist"]["mean"]
            .as_array()
            .unwrap()
            .len(),
        3
    );
    let closed = &stats["action"]["max"][7];
    assert_eq!(closed, 1.0, "the gripper closes");
    assert!(!replay(&data, &out).unwrap(), "an episode differs");
}

#[test]
fn one_changed_bit_of_an_action_is_found() {
    let dir = tempfile::tempdir().unwrap();
    let files = record(dir.path(), "cube", 3..=3, 2.0);
    let out = dir.path().join("set");
    let data = Data::checkout();
    export(&data, &out, &files, &[]).unwrap();
    let table = out.join("data/chunk-000/file-000.parquet");
    let mut bytes = std::fs::read(&table).unwrap();
    // The first numbers of the column are the goal of the first actions, in the dictionary of
    // its values.
    let x = stored_goal(&files[0]).to_le_bytes();
    let at = bytes
        .windows(4)
        .rposition(|four| four == x)
        .expect("the goal");
    bytes[at] ^= 1;
    std::fs::write(&table, bytes).unwrap();
    assert!(
        replay(&data, &out).unwrap(),
        "the changed bit was not found"
    );
}

/// The x of the last goal of an episode.
#[allow(
    clippy::cast_possible_truncation,
    reason = "it was rounded before it was executed"
)]
fn stored_goal(file: &Path) -> f32 {
    let mut recording = cell_record::Recording::open(file).unwrap();
    let frame = recording.at(1.9).unwrap();
    frame.decision.goals[0].target.position[0] as f32
}

#[test]
fn what_an_action_cannot_say_is_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let files = record(dir.path(), "ur10-palletize", 1..=1, 3.0);
    let out = dir.path().join("set");
    let refused = export(&Data::checkout(), &out, &files, &[])
        .unwrap_err()
        .to_string();
    assert!(refused.contains("seed-1.mcap: at "), "{refused}");
    assert!(
        refused.contains("a data set of this cell is not written"),
        "{refused}"
    );
    let other = record(dir.path(), "cube", 2..=2, 1.0);
    let stack = record(&dir.path().join("stack"), "franka-stack", 2..=2, 1.0);
    let both = [other, stack].concat();
    let out = dir.path().join("mixed");
    let refused = export(&Data::checkout(), &out, &both, &[])
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("the first recording of `cube` at 20 Hz"),
        "{refused}"
    );
    let unknown = export(
        &Data::checkout(),
        &dir.path().join("no"),
        &both[..1],
        &["rist".to_owned()],
    );
    let unknown = unknown.unwrap_err().to_string();
    assert_eq!(
        unknown,
        "--camera: camera 'rist' is not known; did you mean 'wrist'?"
    );
}
