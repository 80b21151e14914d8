//! A run is computed again from its recording: the same to the last bit, or the
//! first message that differs by name.

use crate::verify_support;

use cell_sim::verify::{Message, Report, Verdict, verify};
use ipc_types::Keyframe;
use ipc_types::topic::Process;
use verify_support::{Bench, Timing, tick_of};

fn report(bench: &Bench) -> Report {
    verify(
        &crate::program(),
        &bench.cell,
        &bench.spec.policy,
        bench.recorded.as_slice(),
    )
    .expect("a report")
}

#[track_caller]
fn assert_all_same(bench: &Bench) -> Report {
    let report = report(bench);
    assert_eq!(report.verdict(), Verdict::Same, "{report}");
    assert_eq!(report.gap_count, 0, "{report}");
    let counts = [
        report.commands,
        report.statuses,
        report.decisions,
        report.records,
    ];
    assert_eq!(counts.map(|c| c.skipped), [0; 4], "{report}");
    report
}

fn stack(ticks: u64) -> Bench {
    let mut bench = Bench::new("franka-stack", "fsm", "", Timing::default());
    bench.run(ticks);
    bench
}

#[test]
fn plans_that_were_answered_late_are_computed_again() {
    let script = r#"{"at_s": 3.0, "do": "target", "orientation_wxyz": [0, 1, 0, 0], "position": [0.55, -0.25, 0.25]}"#;
    let mut bench = Bench::new("reach-shelf", "follow", script, Timing::default());
    bench.run(3_030);
    // The answer arrives after a restart of the controller, which sends its request again.
    bench.restart_controller(0);
    bench.run(5_500);
    assert_all_same(&bench);
    let status = bench.status(0);
    assert!(status.answered_plan > 0, "{status:?}");
    assert!(status.position_error < 0.01, "{status:?}");
}

#[test]
fn every_demo_and_policy_in_lockstep_is_the_same() {
    let drag = r#"{"at_s": 2.5, "do": "drag", "object": "red_cube", "to": [0.4, 0.35, 0.025]}
{"at_s": 4.2, "do": "reset"}"#;
    for (demo, policy, script) in [
        ("franka-stack", "fsm", drag),
        ("franka-stack", "ifelse", ""),
        ("franka-stack", "bt", drag),
        ("franka-pyramid", "json", ""),
    ] {
        let mut bench = Bench::new(demo, policy, script, Timing::default());
        bench.run(6_005);
        let report = assert_all_same(&bench);
        let arms = bench.cell.arms.len() as u64;
        assert_eq!(report.commands.compared, 6_005 * arms, "{demo} {policy}");
        assert_eq!(report.decisions.compared, 601);
        // One run from the first message on for each process.
        assert_eq!(report.stretches, arms + 1);
    }
}

/// States are missed, decisions come late, and the task looks between two tenth
/// ticks.
const REAL: Timing = Timing {
    misses: Some(|arm, tick| (tick * 7 + arm as u64 * 5).is_multiple_of(31) || tick % 997 < 6),
    late: Some(|tick| tick / 10 % 4),
    dozes: Some(|tick| tick.is_multiple_of(170) || (4_000..4_150).contains(&tick)),
};

#[test]
fn late_messages_and_missed_ones_are_the_same_again() {
    for (demo, policy) in [("franka-stack", "fsm"), ("franka-pyramid", "json")] {
        let mut bench = Bench::new(demo, policy, "", REAL);
        bench.run(8_000);
        let report = report(&bench);
        assert_eq!(report.verdict(), Verdict::Same, "{report}");
        assert_eq!(report.commands.skipped, 0, "{report}");
        let missed = bench
            .recorded
            .iter()
            .filter(|m| matches!(m, Message::Decision(_)) && !tick_of(m).is_multiple_of(10));
        assert!(missed.count() > 30);
        // Some of those saw a cube move that was not recorded at that tick.
        assert!(report.decisions.skipped < 20, "{report}");
        assert!(report.decisions.compared > 700, "{report}");
    }
}

#[test]
fn processes_that_are_started_again_are_followed() {
    let mut bench = Bench::new("franka-stack", "fsm", "", REAL);
    bench.run(2_300);
    bench.restart_controller(0);
    bench.run(1_111);
    bench.restart_task("fsm", 0);
    bench.run(1_003);
    bench.restart_task("bt", 57);
    bench.run(2_000);
    let report = report(&bench);
    assert_eq!(report.verdict(), Verdict::Same, "{report}");
    assert_eq!(report.commands.skipped, 0, "{report}");
    assert!(report.decisions.skipped < 10, "{report}");
}

#[test]
fn an_altered_decision_is_caught_at_its_tick() {
    let mut bench = stack(5_500);
    for message in &mut bench.recorded {
        if let Message::Decision(decision) = message
            && decision.header.tick == 3_210
        {
            decision.goals[0].target.position[1] += 1.0e-12;
        }
    }
    let report = report(&bench);
    assert_eq!(report.verdict(), Verdict::Different);
    assert_eq!(report.decisions.different, 1, "{report}");
    let first = report.first_difference.expect("a difference");
    assert_eq!((first.message.as_str(), first.tick), ("decision", 3_210));
    assert_eq!(first.field, "goals[0].target.position[1]");
}

#[test]
fn an_altered_command_is_caught_and_named() {
    let mut bench = stack(2_500);
    for message in &mut bench.recorded {
        if let Message::Command(0, command) = message
            && command.header.tick == 1_777
        {
            command.joint_efforts[3] = -command.joint_efforts[3];
        }
    }
    let report = report(&bench);
    let first = report.first_difference.clone().expect("a difference");
    assert_eq!(
        (first.message.as_str(), first.tick),
        ("command of arm 0", 1_777)
    );
    assert_eq!(first.field, "joint_efforts[3]");
    assert_eq!(
        (report.commands.different, report.statuses.different),
        (1, 0)
    );
}

#[test]
fn a_gap_is_a_verdict_of_its_own_and_ends_at_the_next_state_record() {
    let mut bench = stack(5_500);
    bench.recorded.retain(|message| {
        !matches!(message, Message::World(piece) if (2_345..2_350).contains(&piece.state.tick))
    });
    let report = report(&bench);
    assert_eq!(report.verdict(), Verdict::Same, "{report}");
    assert_eq!(report.gap_count, 1, "{report}");
    assert_eq!(
        (report.gaps[0].missing, report.gaps[0].until_tick),
        (5, 2_350)
    );
    // From the gap to the record after the command of tick 3000.
    assert_eq!(report.commands.skipped, 3_001 - 2_345, "{report}");
    // The task did not look at those states.
    assert_eq!(report.decisions.skipped, 0, "{report}");
    assert_eq!(report.stretches, 3);
}

#[test]
fn a_recording_that_begins_in_the_middle_is_verified_from_there() {
    let mut bench = stack(4_500);
    bench.recorded.retain(|message| tick_of(message) >= 1_234);
    let report = report(&bench);
    assert_eq!(report.verdict(), Verdict::Same, "{report}");
    assert_eq!(report.gap_count, 0, "{report}");
    assert_eq!(report.commands.skipped, 2_001 - 1_234);
    assert_eq!(report.ticks, Some((2_001, 4_499)));
}

#[test]
fn without_a_state_record_nothing_is_compared() {
    let mut bench = stack(1_500);
    bench
        .recorded
        .retain(|message| !matches!(message, Message::Keyframe(..)));
    let report = report(&bench);
    assert_eq!(report.verdict(), Verdict::Nothing);
    assert_eq!(
        (report.commands.compared, report.commands.skipped),
        (0, 1_500)
    );
}

#[test]
fn a_state_record_that_is_not_what_was_computed_is_named() {
    let mut bench = stack(3_500);
    for message in &mut bench.recorded {
        if let Message::Keyframe(Process::Controller(0), keyframe) = message
            && keyframe.header.tick == 2_000
        {
            // A bit of the count of cycles.
            keyframe.bytes[37] ^= 1;
        }
    }
    let report = report(&bench);
    let first = report.first_difference.clone().expect("a difference");
    assert_eq!(
        (first.message.as_str(), first.tick),
        ("record of controller-0", 2_000)
    );
}

/// The same in parts of 64 bytes.
fn parts(whole: &Keyframe) -> Vec<Message> {
    let parts = whole.bytes().chunks(64).enumerate();
    let part = |(index, bytes): (usize, &[u8])| {
        let mut part = Box::new(*whole);
        part.bytes[..bytes.len()].copy_from_slice(bytes);
        part.offset = index as u64 * 64;
        part.len = u32::try_from(bytes.len()).expect("64 at most");
        Message::Keyframe(Process::Task, part)
    };
    parts.map(part).collect()
}

#[test]
fn a_checkpoint_in_parts_is_put_together_and_not_used_without_one_of_them() {
    let mut bench = stack(3_500);
    let whole = report(&bench).records.compared;
    let in_parts = bench.recorded.iter().flat_map(|message| match message {
        Message::Keyframe(Process::Task, keyframe) => parts(keyframe),
        other => vec![other.clone()],
    });
    bench.recorded = in_parts.collect();
    let found = report(&bench);
    assert_eq!(found.verdict(), Verdict::Same, "{found}");
    assert_eq!(found.records.compared, whole);
    let lost = bench.recorded.iter().position(|message| {
        matches!(message, Message::Keyframe(Process::Task, part)
            if part.header.tick == 2_000 && part.offset == 64)
    });
    bench.recorded.remove(lost.expect("a second part"));
    let found = report(&bench);
    assert_eq!(found.verdict(), Verdict::Same, "{found}");
    assert_eq!(found.records.compared, whole - 1);
}
