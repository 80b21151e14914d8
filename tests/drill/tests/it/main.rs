//! A short sample of the drill.

use std::path::Path;

use robocell_drill::batch::{examine, seeds};
use robocell_drill::plan::Plan;

/// Longest run of a plan (ms).
const LONGEST_MS: u64 = 3_000;

#[test]
fn every_invariant_holds_and_the_result_does_not_depend_on_the_number_of_threads() {
    let (first, failures) = seeds(1..13, LONGEST_MS, 2, None).unwrap();
    assert!(failures.is_empty(), "{failures:#?}");
    let (second, _) = seeds(1..13, LONGEST_MS, 1, None).unwrap();
    assert_eq!(first.digest, second.digest);
    assert!(first.faults.iter().any(|(_, _, effective)| *effective > 0));
}

#[test]
fn the_plans_that_failed_once_hold() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("plans.jsonl");
    let kept = std::fs::read_to_string(kept).unwrap();
    for line in kept.lines() {
        let plan: Plan = serde_json::from_str(line).unwrap();
        let failed = examine(&plan).unwrap().failed;
        assert_eq!(failed, None, "{line}");
    }
}
