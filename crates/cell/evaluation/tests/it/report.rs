//! What a report says of generated rows.

use std::fs;
use std::path::{Path, PathBuf};

use evaluation::report::{Gate, Verdict, report};
use evaluation::row::{Row, RowOutcome};
use tempfile::TempDir;

use crate::{case, identity};

/// `rows` rows from seed `first` on, of which those that `fails` names did not end done.
fn write(
    dir: &Path,
    name: &str,
    seeds: std::ops::Range<u64>,
    fails: impl Fn(u64) -> bool,
) -> PathBuf {
    let mut text = String::new();
    for seed in seeds {
        let mut row = Row::error(&identity(), ("cube", "fsm"), &case(seed), "lost".to_owned());
        row.outcome = RowOutcome::Failed;
        if !fails(seed) {
            (row.outcome, row.reason) = (RowOutcome::Done, None);
        }
        row.sim_time_s = 20.0 + (seed % 10) as f64;
        text += &serde_json::to_string(&row).unwrap();
        text.push('\n');
    }
    let path = dir.join(name);
    fs::write(&path, text).unwrap();
    path
}

/// One of 20, without a pattern that halves could share.
fn base(seed: u64) -> bool {
    seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32 & 0xff < 13
}

#[test]
fn a_regression_of_3_percent_is_found_in_2000_rows() {
    let dir = TempDir::new().unwrap();
    let first = write(dir.path(), "a.jsonl", 0..2_000, base);
    let second = write(dir.path(), "b.jsonl", 0..2_000, |seed| {
        base(seed) || seed % 33 == 7
    });
    let reports = report(&first, Some(&second)).unwrap();
    let comparison = reports.comparison.unwrap();
    assert_eq!((comparison.pairs, comparison.second_only), (2_000, 0));
    assert!(comparison.first_only > 50, "{comparison}");
    assert_eq!(comparison.verdict, Verdict::Worse);
    let (low, high) = comparison.interval.unwrap();
    assert!(low < comparison.difference && comparison.difference < high && high < 0.0);
    let back = report(&second, Some(&first)).unwrap().comparison.unwrap();
    assert_eq!(back.verdict, Verdict::Better);
}

#[test]
fn equal_halves_show_no_difference_with_and_without_seeds_in_common() {
    let dir = TempDir::new().unwrap();
    let first = write(dir.path(), "a.jsonl", 0..1_000, base);
    let other = write(dir.path(), "b.jsonl", 1_000..2_000, base);
    let same = write(dir.path(), "c.jsonl", 0..1_000, |seed| base(seed + 1_000));
    for second in [&first, &other, &same] {
        let reports = report(&first, Some(second)).unwrap();
        let comparison = reports.comparison.unwrap();
        assert_eq!(comparison.verdict, Verdict::NoDifference, "{comparison}");
    }
    let text = report(&first, Some(&other))
        .unwrap()
        .comparison
        .unwrap()
        .to_string();
    assert!(text.contains("no episode in common"), "{text}");
}

#[test]
fn a_report_has_rate_interval_reasons_and_times() {
    let dir = TempDir::new().unwrap();
    let file = write(dir.path(), "a.jsonl", 0..100, |seed| seed < 10);
    let text = report(&file, None).unwrap().files[0].to_string();
    for part in [
        "cube, policy fsm",
        "90 of 100: 90.00 % (95 %: 82.56 to 94.48 %)",
        "10 failed: lost",
        "p50 24.00 s, p90 28.00 s",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(
        !text.contains("seed 0"),
        "its sentence is the reason: {text}"
    );
    fs::write(&file, "").unwrap();
    let error = report(&file, None).unwrap_err().to_string();
    assert!(error.contains("empty"), "{error}");
    fs::write(&file, "{}\n").unwrap();
    let error = report(&file, None).unwrap_err().to_string();
    assert!(error.contains("a.jsonl:1"), "{error}");
}

#[test]
fn a_report_tells_of_each_reason_the_first_seed_with_its_sentence() {
    let dir = TempDir::new().unwrap();
    let file = write(dir.path(), "a.jsonl", 0..20, |seed| seed % 10 == 7);
    let sentence = "task.py:13: in decide: KeyError: unknown object 'redcube'";
    let text = fs::read_to_string(&file).unwrap();
    let told = text.replace(
        "\"message\":\"lost\"",
        &format!("\"message\":\"{sentence}\""),
    );
    fs::write(&file, told).unwrap();
    let found = report(&file, None).unwrap().files[0].to_string();
    assert!(found.contains(&format!("seed 7: {sentence}")), "{found}");
    // As older versions wrote them.
    let old = text
        .replace("\"message\":\"lost\",", "")
        .replace("\"message\":null,", "");
    let old = old.replace("\"task_restarts\":0,", "");
    assert!(
        !old.contains("message") && !old.contains("restarts"),
        "{old}"
    );
    fs::write(&file, old).unwrap();
    let found = report(&file, None).unwrap().files[0].to_string();
    assert!(
        found.contains("2 failed: lost") && !found.contains("seed 7"),
        "{found}"
    );
    for line in fs::read_to_string(&file).unwrap().lines() {
        let row: Row = serde_json::from_str(line).unwrap();
        assert_eq!((row.message, row.task_restarts), (None, 0));
    }
}

#[test]
fn a_report_of_a_sweep_has_a_line_for_each_variant_and_pairs_are_of_the_same() {
    let dir = TempDir::new().unwrap();
    let write = |name: &str, fails: fn(u64, u32) -> bool| {
        let mut text = String::new();
        for (seed, variant) in (0..40).flat_map(|seed| [(seed, 1), (seed, 2)]) {
            let mut case = case(seed);
            case.variant = variant;
            case.set = vec![format!("task.timeout_s={variant}").parse().unwrap()];
            let mut row = Row::error(&identity(), ("cube", "fsm"), &case, "lost".to_owned());
            if !fails(seed, variant) {
                (row.outcome, row.reason) = (RowOutcome::Done, None);
            }
            text += &serde_json::to_string(&row).unwrap();
            text.push('\n');
        }
        let path = dir.path().join(name);
        fs::write(&path, text).unwrap();
        path
    };
    let first = write("a.jsonl", |seed, variant| variant == 1 && seed < 10);
    let second = write("b.jsonl", |seed, variant| variant == 2 && seed < 10);
    let reports = report(&first, Some(&second)).unwrap();
    let text = reports.files[0].to_string();
    for line in [
        "task.timeout_s=1  30 of 40: 75.00 %",
        "task.timeout_s=2  40 of 40: 100.00 %",
    ] {
        assert!(text.contains(line), "{text}");
    }
    let comparison = reports.comparison.unwrap();
    let counts = (
        comparison.pairs,
        comparison.first_only,
        comparison.second_only,
    );
    assert_eq!(counts, (80, 10, 10));
}

#[test]
fn a_gate_passes_an_equal_policy_refuses_a_worse_one_and_asks_for_enough_seeds() {
    let dir = TempDir::new().unwrap();
    let decide = |count: u64, fails: fn(u64) -> bool, loss| {
        let first = write(dir.path(), "a.jsonl", 0..count, base);
        let second = write(dir.path(), "b.jsonl", 0..count, fails);
        let mut reports = report(&first, Some(&second)).unwrap();
        reports.decide(loss);
        reports.gate.unwrap()
    };
    // Of 200 seeds 10 more are not done.
    let worse: fn(u64) -> bool =
        |seed| base(seed) || (seed < 105 && (seed % 10 == 3 && !base(seed)));
    assert_eq!(decide(200, base, 0.05), Gate::Passed { loss: 0.05 });
    assert!(matches!(decide(200, worse, 0.05), Gate::Worse { loss, p } if loss > 0.04 && p < 0.01));
    let few = Gate::TooFew {
        pairs: 100,
        needed: 120,
        loss: 0.05,
    };
    assert_eq!(decide(100, base, 0.05), few);
    assert_eq!(decide(120, base, 0.05), Gate::Passed { loss: 0.05 });
    assert!(
        few.to_string()
            .contains("120 are needed to see a loss of 5.0 %"),
        "{few}"
    );
    // A loss that is shown is one, however few the seeds are.
    assert!(matches!(decide(100, worse, 0.01), Gate::Worse { .. }));
}
