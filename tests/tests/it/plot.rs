//! Signals of a recording, drawn by `robocell plot`.

use std::path::{Path, PathBuf};

use robocell_tests::cell::base;
use robocell_tests::program::{Said, finish, robocell};
use tempfile::TempDir;

/// The begin of a stack, recorded in lockstep.
fn recorded() -> (TempDir, PathBuf) {
    let base = base();
    let file = base.path().join("run.mcap");
    let name = file.display().to_string();
    let mut arguments = vec!["run", "franka-stack", "--headless", "--timeout", "2"];
    arguments.extend(["--speed", "max", "--record", &name]);
    let said = finish(robocell(base.path(), &arguments));
    // It is out of time.
    assert_eq!(said.code, 5, "{said:?}");
    assert!(!said.stdout.contains("recording misses"), "{said:?}");
    (base, file)
}

fn plot(base: &Path, file: &Path, words: &[&str]) -> Said {
    let file = file.display().to_string();
    finish(robocell(base, &[&["plot", &file][..], words].concat()))
}

#[test]
fn signals_of_a_recording_are_listed_drawn_and_printed() {
    let (base, file) = recorded();
    let plot = |words: &[&str]| plot(base.path(), &file, words);
    let list = plot(&[]);
    for line in [
        "panda/joint1 position",
        "panda/gripper width",
        "objects/red_cube z",
    ] {
        assert!(list.stdout.lines().any(|l| l.starts_with(line)), "{list:?}");
    }

    let drawn = plot(&["panda/joint4 position", "panda/joint4 error"]);
    assert_eq!(drawn.code, 0, "{drawn:?}");
    for title in ["panda/joint4 position (°)\n", "\npanda/joint4 error (°)\n"] {
        assert!(drawn.stdout.contains(title), "{drawn:?}");
    }
    assert!(drawn.stdout.contains("1.0 s"), "{drawn:?}");

    let said = plot(&[
        "panda/joint4 position",
        "--from",
        "0.5",
        "--to",
        "1.5",
        "--json",
    ]);
    let said = said.json();
    let signal = &said["signals"][0];
    assert_eq!(signal["unit"], "°", "{signal}");
    let times = signal["time_s"].as_array().expect("times");
    // One for each tick.
    assert_eq!(times.len(), 1001);
    assert_eq!((&times[0], &times[1000]), (&0.5.into(), &1.5.into()));
    // The arm starts at its home position, with a bent elbow.
    let first = signal["values"][0].as_f64().expect("a value");
    assert!((-180.0..-60.0).contains(&first), "{first}");

    // A picture tells 16 lines apart; numbers have no such limit.
    let signals = list.stdout.lines().count();
    let every = plot(&["*", "--json"]).json();
    assert!(signals > 16, "{list:?}");
    assert_eq!(every["signals"].as_array().map(Vec::len), Some(signals));

    let picture = base.path().join("a.svg");
    let out = picture.display().to_string();
    let said = plot(&["panda/joint*", "--output", &out]);
    assert_eq!(said.code, 2, "more than 16: {said:?}");
    let said = plot(&[
        "panda/* error",
        "panda/distance to target",
        "panda/TCP z",
        "--output",
        &out,
    ]);
    assert_eq!((said.code, said.stdout.as_str()), (0, ""), "{said:?}");
    let svg = std::fs::read_to_string(&picture).expect("a picture");
    for part in [
        "<svg ",
        "panda/joint7 error",
        ">°<",
        ">mm<",
        ">m<",
        "<polyline",
    ] {
        assert!(svg.contains(part), "{part}");
    }
}

#[test]
fn what_cannot_be_plotted_is_refused_with_advice() {
    let (base, file) = recorded();
    let refused = |words: &[&str], code: i32, advice: &str| {
        let said = plot(base.path(), &file, words);
        assert_eq!(said.code, code, "{words:?}: {said:?}");
        assert!(said.stderr.contains(advice), "{words:?}: {said:?}");
    };
    let near = "did you mean `panda/joint1 position`?";
    refused(&["panda/joint1 positon"], 2, near);
    refused(&["panda/TCP z", "--from", "70"], 3, "there is 0.0");
    refused(&["panda/TCP z", "--from", "2", "--to", "1"], 2, "before");
    refused(&["panda/TCP z", "--output", "a.png"], 2, ".svg");
    let missing = plot(base.path(), Path::new("missing.mcap"), &[]);
    assert!(
        missing.code == 3 && missing.stderr.contains("missing.mcap"),
        "{missing:?}"
    );
}
