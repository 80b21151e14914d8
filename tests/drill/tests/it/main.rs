//! A short sample of the drill.

use std::path::Path;

use robocell_drill::batch::{Batch, examine, run_all};
use robocell_drill::draw::Level;
use robocell_drill::plan::Plan;
use robocell_drill::planted;

/// Longest run of a plan (ms).
const LONGEST_MS: u64 = 3_000;

#[test]
fn every_invariant_holds_and_the_result_does_not_depend_on_the_number_of_threads() {
    let run = |jobs| {
        let batch = Batch {
            seeds: 1..21,
            level: Level::Mixed,
            longest_ms: LONGEST_MS,
            jobs,
            limit: None,
            first: false,
        };
        run_all(&batch).unwrap()
    };
    let (first, failures) = run(2);
    assert!(failures.is_empty(), "{failures:#?}");
    let (second, _) = run(1);
    assert_eq!(first.digest, second.digest);
    assert!(first.faults.iter().any(|(_, _, effective)| *effective > 0));
}

#[test]
fn the_plans_that_failed_once_hold() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("plans.jsonl");
    let kept = std::fs::read_to_string(kept).unwrap();
    assert!(kept.lines().count() > 0);
    for line in kept.lines() {
        let plan: Plan = serde_json::from_str(line).unwrap();
        let failed = examine(&plan).unwrap().failed;
        assert_eq!(failed, None, "{line}");
    }
}

#[test]
fn every_planted_bug_fits_one_place() {
    let bugs = planted::all().unwrap();
    assert!(bugs.len() >= 20, "{}", bugs.len());
    for (_, bug) in bugs {
        let text = std::fs::read_to_string(planted::root().join(&bug.file)).unwrap();
        let changed = bug.change(&text).unwrap();
        assert_ne!(changed, text, "{}", bug.about);
    }
}
