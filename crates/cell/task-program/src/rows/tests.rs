//! Messages in rows, on machines with other folders.

use super::*;

#[test]
fn a_message_in_a_row_does_not_depend_on_where_the_files_are() {
    let message = |dir: &str| {
        let folders = Folders(vec![format!("{dir}/"), format!("{dir}/cells/")]);
        folders.left_out_of(&format!(
            "{dir}/cells/mine.toml:7: task.place is far; {dir}/robots/arm.urdf: it reaches 0.8 m"
        ))
    };
    let expected = "cells/mine.toml:7: task.place is far; robots/arm.urdf: it reaches 0.8 m";
    assert_eq!(message("/home/ada/work"), expected);
    assert_eq!(message("/mnt/node-7"), expected);
}

#[test]
fn the_root_and_relative_folders_stay_in_a_message() {
    let order = |data_dir: &str, inputs: &[PathBuf]| {
        let mut spec = cell_sim::eval::template("reach", "follow");
        spec.data_dir = Some(PathBuf::from(data_dir));
        let folders = Folders::of(&Order {
            spec: &spec,
            cases: &Cases::default(),
            seeds: [1, 2],
            shard: Shard::ALL,
            record: None,
            jobs: 1,
            out: Path::new("rows.jsonl"),
            inputs,
            arguments: Vec::new(),
        });
        folders.0
    };
    assert_eq!(order("/", &[PathBuf::from("job.toml")]), [""; 0]);
    let of_file = [PathBuf::from("/data/robots/arm.urdf")];
    assert_eq!(order("/data", &of_file), ["/data/", "/data/robots/"]);
}
