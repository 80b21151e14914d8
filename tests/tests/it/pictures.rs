//! Pictures of the cameras: the same from four processes as from one.

use std::path::Path;

use camera::{Picture, observe};
use cell_model::{Cell, Data};
use cell_record::Recording;
use cell_sim::OneProcess;
use cell_sim::eval::template;
use robocell_tests::cell::base;
use robocell_tests::program::{finish, robocell};

/// Simulated time between two pictures (ticks). A recording has whole states every ten ticks.
const EVERY: u64 = 10;

/// Records a run of four processes in lockstep.
fn record(demo: &str, seed: u64, seconds: f64, file: &Path) {
    let (seed, seconds) = (seed.to_string(), seconds.to_string());
    let file = file.display().to_string();
    let words = [
        "run",
        demo,
        "--headless",
        "--speed",
        "max",
        "--seed",
        &seed,
        "--timeout",
        &seconds,
        "--record",
        &file,
    ];
    let base = base();
    let said = finish(robocell(base.path(), &words));
    // 0 where the job was done before the time limit.
    assert!([0, 5].contains(&said.code), "{}", said.stderr);
}

/// Compares pictures of all cameras at `count` times; returns how many differ.
fn differing(demo: &str, seed: u64, count: u64) -> usize {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("run.mcap");
    record(demo, seed, (count * EVERY) as f64 * 1.0e-3, &file);
    let mut recording = Recording::open(&file).unwrap();
    let cell = Cell::load(&Data::checkout(), demo, seed, None).unwrap();
    let names: Vec<String> = cell
        .cameras
        .iter()
        .map(|camera| camera.name.clone())
        .collect();
    let mut spec = template(demo, &cell.default_policy);
    (spec.seed, spec.arms) = (seed, u8::try_from(cell.arms.len()).unwrap());
    spec.until_done = false;
    let mut sim = OneProcess::new(&demos::policies(), &spec, cell.clone()).unwrap();
    let hashes = |pictures: Vec<Picture>| -> Vec<[u64; 3]> {
        pictures.iter().map(Picture::hashes).collect()
    };
    let mut differ = 0;
    for time in 1..=count {
        for _ in 0..EVERY {
            assert!(sim.tick().unwrap(), "{demo} ended");
        }
        let recorded = recording.at((time * EVERY) as f64 * 1.0e-3).unwrap();
        assert_eq!(recorded.world.header.tick, sim.state().header.tick);
        let [four, one] = [&*recorded.world, sim.state()]
            .map(|state| hashes(observe(&cell, state, &names).unwrap()));
        differ += four
            .iter()
            .zip(&one)
            .filter(|(four, one)| four != one)
            .count();
    }
    differ
}

#[test]
fn pictures_of_four_processes_are_those_of_one() {
    assert_eq!(differing("franka-stack", 3, 25), 0);
}

/// `cargo test -p robocell-tests --release --test it -- --ignored --nocapture ten_thousand_pictures`
#[test]
#[ignore = "a series: 10,000 pictures"]
fn ten_thousand_pictures_of_four_processes_are_those_of_one() {
    let (mut all, mut differ) = (0, 0);
    for (demo, _) in Data::checkout().demos() {
        let cell = Cell::load(&Data::checkout(), &demo, 5, None).unwrap();
        differ += differing(&demo, 5, 600);
        all += 600 * cell.cameras.len();
        eprintln!("{demo}: {differ} of {all} pictures differ so far");
    }
    assert!(all >= 10_000, "{all} pictures");
    assert_eq!(differ, 0);
}
