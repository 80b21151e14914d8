//! A short sample of the drill.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use robocell_drill::batch::{Batch, examine, run_all};
use robocell_drill::draw::Level;
use robocell_drill::plan::Plan;
use robocell_drill::planted;

/// Longest run of a plan (ms).
const LONGEST_MS: u64 = 3_000;

#[test]
fn every_invariant_holds_and_the_result_does_not_depend_on_the_number_of_threads() {
    let run = |level, seeds, jobs| {
        let batch = Batch {
            seeds,
            level,
            longest_ms: LONGEST_MS,
            jobs,
            limit: None,
            first: false,
        };
        run_all(&batch).unwrap()
    };
    let levels = [(Level::Loops, 100), (Level::Motion, 16), (Level::Whole, 8)];
    for (level, last) in levels {
        let (first, failures) = run(level, 1..last + 1, 2);
        assert!(failures.is_empty(), "{failures:#?}");
        assert!(first.faults.iter().any(|(_, _, effective)| *effective > 0));
        let (part, _) = run(level, 1..last / 4, 2);
        let (same, _) = run(level, 1..last / 4, 1);
        assert_eq!(part.digest, same.digest);
    }
}

#[test]
fn the_kept_plans_hold() {
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
    // One after the other: those that can be off are built together.
    let mut texts: BTreeMap<PathBuf, String> = BTreeMap::new();
    for (number, bug) in bugs {
        assert!(bug.has_switch(), "{number}: {}", bug.about);
        for change in bug.changes() {
            let path = planted::root().join(&change.file);
            let text = texts
                .entry(path)
                .or_insert_with_key(|path| std::fs::read_to_string(path).unwrap());
            let changed = change.of(&number.to_string(), text).unwrap();
            assert_ne!(changed, *text, "{}", bug.about);
            *text = changed;
        }
    }
}
