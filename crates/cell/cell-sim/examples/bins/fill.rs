//! Filling a bin: how each run ends, what broke the grip and by what.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use ipc_types::decision::Outcome;
use ipc_types::equipment::{BreakCause, BreakLimit};

use crate::watched::Watched;

/// Runs every seed; whether each ended done or failed for one of the two named
/// reasons, at most a third of them so, and the arm kept all limits and touched
/// nothing.
pub(crate) fn series(seeds: RangeInclusive<u64>) -> bool {
    let mut ends = BTreeMap::<String, u32>::new();
    let mut breaks = BTreeMap::<String, u32>::new();
    let (mut good, mut done, mut all) = (0, 0, 0);
    for seed in seeds {
        let (run, broken_by) = one(seed);
        for how in broken_by {
            *breaks.entry(how).or_default() += 1;
        }
        let decision = run.sim.decision();
        let (outcome, reason) = (run.outcome(), decision.reason.as_str());
        let named = ["bin_out_of_reach", "bin_cannot_be_gripped"].contains(&reason);
        let ended = match outcome {
            Some(Outcome::Done) => true,
            Some(Outcome::Failed) => named,
            _ => false,
        };
        let is_good = ended && run.violations() == 0 && !run.touches.any();
        println!(
            "{} seed {seed}: {outcome:?} {reason} at {:.1} s, {} parts, drops {}, {} pick-ups again, {} violations, {}",
            if is_good { "ok " } else { "BAD" },
            run.now_s(),
            run.sim.state().equipment.parts_dropped,
            decision.drops,
            decision.resyncs,
            run.violations(),
            run.touches
        );
        *ends.entry(format!("{outcome:?} {reason}")).or_default() += 1;
        good += u32::from(is_good);
        done += u32::from(outcome == Some(Outcome::Done));
        all += 1;
    }
    println!(
        "ur10-fill-bin: {good} of {all} seeds good, {done} done; ends {ends:?}; breaks {breaks:?}"
    );
    good == all && 3 * done >= 2 * all
}

/// A run to its end, and what broke the grip each time.
fn one(seed: u64) -> (Watched, Vec<String>) {
    let mut run = Watched::new("ur10-fill-bin", "matrix", seed);
    let (mut breaks, mut count) = (Vec::new(), 0);
    let ends = [Some(Outcome::Done), Some(Outcome::Failed)];
    while !ends.contains(&run.outcome()) && run.tick(|_| {}) {
        let gripper = &run.sim.state().arms()[0].gripper;
        if gripper.breaks != count {
            count = gripper.breaks;
            breaks.push(format!(
                "{:?} by {:?}",
                BreakLimit::from_code(gripper.break_limit).unwrap_or(BreakLimit::None),
                BreakCause::from_code(gripper.break_cause).unwrap_or(BreakCause::None)
            ));
        }
    }
    (run, breaks)
}
