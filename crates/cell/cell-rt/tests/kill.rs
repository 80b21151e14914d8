//! A slot file whose writer is killed in the middle of its work.

use std::process::{Command, Stdio};

use cell_rt::{SlotFile, monotonic_ns, sleep_until};

const CAPACITY: usize = 4096;

#[test]
#[ignore = "run by the other test as a process of its own"]
fn helper_writes_until_killed() {
    let Ok(path) = std::env::var("CELL_RT_HELPER") else {
        return;
    };
    let mut file = SlotFile::open(path.as_ref(), CAPACITY).unwrap();
    let start = file.newest().map_or(0, |(seq, _)| seq);
    for seq in start + 1.. {
        file.write(seq, &record(seq)).unwrap();
    }
}

/// A record whose every word has its number.
fn record(seq: u64) -> Vec<u8> {
    seq.to_le_bytes().repeat(CAPACITY / 8)
}

#[test]
fn there_is_always_a_whole_record_and_never_an_older_one() {
    let path = std::env::temp_dir().join(format!("cell-rt-kill-{}", std::process::id()));
    let file = SlotFile::open(&path, CAPACITY).unwrap();
    let mut last = 0;
    for attempt in 0..60_u64 {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "helper_writes_until_killed", "--ignored"])
            .env("CELL_RT_HELPER", &path)
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        // Waits until it writes, and then a different time at each kill.
        while file.newest().is_none_or(|(seq, _)| seq <= last) {
            std::thread::yield_now();
        }
        sleep_until(monotonic_ns() + attempt * 13_337);
        child.kill().unwrap();
        child.wait().unwrap();
        let (seq, content) = file.newest().expect("one of the two is whole");
        assert!(seq > last && content == record(seq), "kill {attempt}");
        last = seq;
    }
    std::fs::remove_file(path).unwrap();
}
