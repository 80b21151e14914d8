//! What a user sees of files of rows.
#![allow(clippy::unwrap_used, reason = "a test that cannot continue has failed")]

mod report;

use std::fs::{self, Permissions};
use std::io::Write as _;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::{Path, PathBuf};

use cell_model::cells::sweep::Case;
use evaluation::EvaluationError;
use evaluation::identity::Identity;
use evaluation::info::{Episode, Plan};
use evaluation::merge::merge;
use evaluation::row::{Key, Row};
use evaluation::rows_file::RowsFile;
use evaluation::shard::Shard;
use tempfile::TempDir;

fn identity() -> Identity {
    Identity {
        build: "0.1.0+b".to_owned(),
        inputs: "i".to_owned(),
    }
}

fn plan(seeds: [u64; 2], shard: &str) -> Plan {
    Plan {
        arguments: Vec::new(),
        identity: identity(),
        seeds,
        shard: shard.parse::<Shard>().unwrap(),
        variants: 0,
    }
}

fn case(seed: u64) -> Case {
    Case {
        seed,
        ..Case::default()
    }
}

fn append(file: &mut RowsFile, key: Key) {
    let Key { seed, variant } = key;
    let case = Case {
        variant,
        ..case(seed)
    };
    let row = Row::error(&identity(), ("cube", "fsm"), &case, format!("why {key}"));
    let episode = Episode {
        seed,
        variant,
        host: "here".to_owned(),
        ended_s: 1,
        wall_time_s: 0.5,
    };
    file.append(&row, &episode).unwrap();
}

/// All rows of a shard, in an order that is not that of the seeds.
fn write(path: &Path, plan: &Plan) {
    let mut file = RowsFile::open(path, plan).unwrap();
    let mut left: Vec<Key> = file.left().collect();
    left.reverse();
    for key in left {
        append(&mut file, key);
    }
    file.finish().unwrap();
}

fn merged(files: &[PathBuf]) -> Result<Vec<u8>, EvaluationError> {
    let mut out = Vec::new();
    merge(files, &mut out).map(|_| out)
}

fn shards(dir: &TempDir, seeds: [u64; 2], count: u64) -> Vec<PathBuf> {
    let path = |index| dir.path().join(format!("{index}of{count}.jsonl"));
    let files: Vec<PathBuf> = (1..=count).map(path).collect();
    for (index, path) in (1..).zip(&files) {
        write(path, &plan(seeds, &format!("{index}/{count}")));
    }
    files
}

#[test]
fn shards_of_every_number_merge_to_the_bytes_of_an_unsharded_run() {
    let dir = TempDir::new().unwrap();
    let whole = dir.path().join("whole.jsonl");
    write(&whole, &plan([5, 40], "1/1"));
    let whole = fs::read(whole).unwrap();
    for count in 1..=64 {
        let mut files = shards(&dir, [5, 40], count);
        files.reverse();
        assert!(merged(&files).unwrap() == whole, "{count} shards");
    }
}

#[test]
fn shards_of_a_sweep_merge_to_the_bytes_of_an_unsharded_run() {
    let dir = TempDir::new().unwrap();
    let sweep = |shard: &str| Plan {
        variants: 3,
        ..plan([1, 7], shard)
    };
    let whole = dir.path().join("whole.jsonl");
    write(&whole, &sweep("1/1"));
    let text = fs::read_to_string(&whole).unwrap();
    assert_eq!(text.lines().count(), 21);
    assert!(
        text.lines()
            .nth(4)
            .unwrap()
            .contains("\"seed\":2,\"variant\":2,")
    );
    let files: Vec<PathBuf> = (1..=2)
        .map(|n| dir.path().join(format!("{n}.jsonl")))
        .collect();
    write(&files[0], &sweep("1/2"));
    write(&files[1], &sweep("2/2"));
    assert_eq!(merged(&files).unwrap(), text.as_bytes());
    let short = text
        .lines()
        .filter(|line| !line.contains("\"seed\":2,\"variant\":2,"));
    let short: Vec<&str> = short.collect();
    fs::write(&whole, short.join("\n") + "\n").unwrap();
    let error = merged(std::slice::from_ref(&whole))
        .unwrap_err()
        .to_string();
    assert!(error.contains("20 of 21 rows"), "{error}");
    fs::write(&whole, format!("{text}{text}")).unwrap();
    let error = merged(&[whole]).unwrap_err().to_string();
    assert!(
        error.contains("seed 1, variant 1 follows seed 7, variant 3"),
        "{error}"
    );
}

#[test]
fn sorting_the_rows_keeps_a_link_to_them_their_mode_and_the_files_beside_them() {
    let dir = TempDir::new().unwrap();
    let (there, link) = (dir.path().join("there"), dir.path().join("a.jsonl"));
    fs::create_dir(&there).unwrap();
    let (rows, beside) = (there.join("b.jsonl"), there.join("b.jsonl.sorted"));
    fs::write(&rows, "").unwrap();
    fs::set_permissions(&rows, Permissions::from_mode(0o640)).unwrap();
    for file in [&beside, &dir.path().join("a.jsonl.sorted")] {
        fs::write(file, "mine").unwrap();
    }
    symlink(&rows, &link).unwrap();
    write(&link, &plan([1, 6], "1/1"));
    assert!(link.is_symlink());
    assert_eq!(fs::read_to_string(&rows).unwrap().lines().count(), 6);
    assert_eq!(rows.metadata().unwrap().permissions().mode() & 0o777, 0o640);
    for file in [&beside, &dir.path().join("a.jsonl.sorted")] {
        assert_eq!(fs::read_to_string(file).unwrap(), "mine");
    }
}

#[test]
fn a_file_that_was_cut_anywhere_is_completed_to_the_same_bytes() {
    let dir = TempDir::new().unwrap();
    let (path, plan) = (dir.path().join("a.jsonl"), plan([1, 6], "1/1"));
    let info = dir.path().join("a.jsonl.info");
    write(&path, &plan);
    let (whole, whole_info) = (fs::read(&path).unwrap(), fs::read(&info).unwrap());
    for cut in 0..=whole.len() {
        fs::write(&path, &whole[..cut]).unwrap();
        // The side file may be cut anywhere, too.
        fs::write(&info, &whole_info[..cut.min(whole_info.len())]).unwrap();
        let file = RowsFile::open(&path, &plan).unwrap();
        let complete = whole[..cut].split(|byte| *byte == b'\n').count() - 1;
        assert_eq!(file.rows(), complete as u64, "cut at {cut}");
        drop(file);
        write(&path, &plan);
        assert!(fs::read(&path).unwrap() == whole, "cut at {cut}");
    }
}

#[test]
fn what_is_refused_is_left_as_it_was_and_nothing_is_beside_it() {
    let dir = TempDir::new().unwrap();
    let (path, plan) = (dir.path().join("note"), plan([1, 6], "1/1"));
    for (content, part) in [
        ("{}\n", "note:1: no row of an episode"),
        ("a note without an end", "name another one"),
    ] {
        fs::write(&path, content).unwrap();
        let error = RowsFile::open(&path, &plan).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), content);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }
    let folder = dir.path().join("none/a.jsonl");
    for path in [Path::new("/dev/full"), dir.path(), &folder] {
        let error = RowsFile::open(path, &plan).unwrap_err().to_string();
        assert!(
            error.contains("name") || error.contains("does not exist"),
            "{error}"
        );
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }
}

#[test]
fn rows_that_do_not_end_are_refused() {
    let dir = TempDir::new().unwrap();
    let path = dir.path().join("a.jsonl");
    fs::write(&path, "x".repeat(2 << 20)).unwrap();
    let line = "it has a line of more than 1048576 bytes";
    let device = "it is a device; name a regular file";
    for (path, part) in [(path.as_path(), line), (Path::new("/dev/zero"), device)] {
        let errors = [
            evaluation::report::report(path, None).unwrap_err(),
            merge(&[path.to_owned()], &mut std::io::sink()).unwrap_err(),
        ];
        for error in errors {
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}

#[test]
fn a_file_of_another_command_is_refused_with_what_differs() {
    let dir = TempDir::new().unwrap();
    let path = dir.path().join("a.jsonl");
    write(&path, &plan([1, 6], "1/2"));
    let mut build = plan([1, 6], "1/2");
    build.identity.build = "0.2.0+c".to_owned();
    let mut inputs = plan([1, 6], "1/2");
    inputs.identity.inputs = "j".to_owned();
    for (plan, part) in [
        (build, "another build (0.1.0+b, now 0.2.0+c)"),
        (inputs, "another input (i, now j)"),
        (
            plan([1, 7], "1/2"),
            "another range of seeds (1..6, now 1..7)",
        ),
        (plan([1, 6], "2/2"), "another shard (1/2, now 2/2)"),
    ] {
        let error = RowsFile::open(&path, &plan).unwrap_err().to_string();
        assert!(error.contains(part) && error.contains("--out"), "{error}");
    }
    let held = RowsFile::open(&path, &plan([1, 6], "1/2")).unwrap();
    let error = RowsFile::open(&path, &plan([1, 6], "1/2")).unwrap_err();
    assert!(matches!(error, EvaluationError::InUse { .. }), "{error}");
    drop(held);
    fs::remove_file(dir.path().join("a.jsonl.info")).unwrap();
    let mut file = fs::OpenOptions::new().append(true).open(&path).unwrap();
    file.write_all(b"{\"seed\":1}\n").unwrap();
    let error = RowsFile::open(&path, &plan([1, 6], "1/2"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("a.jsonl:4: no row of an episode"), "{error}");
}

#[test]
fn what_is_no_complete_evaluation_is_refused_and_named() {
    let dir = TempDir::new().unwrap();
    let files = shards(&dir, [1, 12], 3);
    let refused = |files: &[PathBuf], parts: &[&str]| {
        let error = merged(files).unwrap_err().to_string();
        for part in parts {
            assert!(error.contains(part), "{part}: {error}");
        }
    };
    refused(
        &[files[0].clone(), files[2].clone()],
        &["shard 2/3 is missing", "seed 2 is missing"],
    );
    refused(&files[..2], &["shard 3/3 is missing"]);
    let twice = dir.path().join("twice.jsonl");
    fs::copy(&files[0], &twice).unwrap();
    let all = [files.clone(), vec![twice.clone()]].concat();
    refused(&all, &["seed 1 is in ", "twice.jsonl"]);
    let all = [files.clone(), vec![files[1].clone()]].concat();
    refused(&all, &["are both shard 2/3"]);
    // Without side files gaps are found.
    for file in &files {
        let mut info = file.as_os_str().to_owned();
        info.push(".info");
        fs::remove_file(info).unwrap();
    }
    assert!(merged(&files).is_ok());
    refused(
        &[files[0].clone(), files[2].clone()],
        &["seed 2 is missing", "seed 11 is missing"],
    );
    let text = fs::read_to_string(&files[1]).unwrap();
    fs::write(&files[1], &text[..text.len() - 1]).unwrap();
    fs::write(
        &files[2],
        text.replace("0.1.0+b", "0.1.0+other")
            .replace("\"i\"", "\"j\""),
    )
    .unwrap();
    refused(
        &files,
        &[
            "2of3.jsonl:4: the line is cut off",
            "build 0.1.0+other",
            "inputs j, but",
        ],
    );
    fs::write(&files[0], "{\"seed\": 1}\n[]\n").unwrap();
    refused(
        &files[..1],
        &["1of3.jsonl:1: no row of an episode", "1of3.jsonl:2:"],
    );
    let error = merged(&[dir.path().join("none.jsonl")])
        .unwrap_err()
        .to_string();
    assert!(error.contains("none.jsonl"), "{error}");
}

#[test]
fn a_file_that_is_not_finished_is_no_shard() {
    let dir = TempDir::new().unwrap();
    let (path, plan) = (dir.path().join("a.jsonl"), plan([1, 6], "1/1"));
    let mut file = RowsFile::open(&path, &plan).unwrap();
    for seed in [3, 1, 2] {
        append(&mut file, Key { seed, variant: 0 });
    }
    drop(file);
    let error = merged(&[path]).unwrap_err().to_string();
    for part in [
        "seed 1 follows seed 3",
        "3 of 6 rows of shard 1/1",
        "resumes",
    ] {
        assert!(error.contains(part), "{part}: {error}");
    }
}
