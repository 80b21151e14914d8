//! The end of a job, another attempt, and the counters that a decision reports.

use ipc_types::GripperGoal;
use ipc_types::decision::{GoalKind, Outcome};
use robocell_task::TraceEvent;

use crate::bench::{ATTEMPTS, Bench, Plan, memory};

const HOLDS: (u32, u32) = (GoalKind::Hold as u32, GripperGoal::Keep as u32);

#[test]
fn a_failed_job_holds_its_arms_and_its_grippers_and_stops_the_belt() {
    let mut bench = Bench::new(Plan {
        fails: 1,
        ..Plan::default()
    });
    bench.decide_times(2);
    assert_eq!(bench.decision.io.conveyor_running, 1);
    bench.decide_times(2);
    assert_eq!(bench.outcome(), Outcome::Failed);
    assert_eq!(bench.decision.phase.as_str(), "FAILED");
    assert_eq!(bench.decision.reason.as_str(), "no_more_cubes");
    assert_eq!(bench.goals(), [HOLDS; 2]);
    assert_eq!(bench.decision.io.conveyor_running, 0);
    let tried = memory(&bench.task).decisions;
    bench.decide_times(50);
    assert_eq!(
        memory(&bench.task).decisions,
        tried,
        "it is not asked again"
    );
}

#[test]
fn a_start_of_the_operator_tries_a_failed_job_again_with_all_its_attempts() {
    let mut bench = Bench::new(Plan {
        fails: 1,
        ..Plan::default()
    });
    bench.decide_times(5);
    assert!(bench.task.has_failed());
    let before = memory(&bench.task);
    bench.state.panel.task_start += 1;
    bench.decide();
    assert_eq!(bench.count("[task] started again"), 1);
    let after = memory(&bench.task);
    assert_eq!(after.decisions, before.decisions + 1, "it goes on");
    assert_eq!(
        after.reconciled,
        before.reconciled + 1,
        "people were at the cell"
    );
    assert_eq!(bench.outcome(), Outcome::Running);
    bench.decide_times(ATTEMPTS - 2);
    assert_eq!(bench.outcome(), Outcome::Running, "attempts are left");
    bench.decide();
    assert_eq!(bench.outcome(), Outcome::Failed);
}

#[test]
fn the_reason_in_words_is_that_of_the_failure_and_not_of_an_earlier_fault() {
    let mut bench = Bench::new(Plan {
        faults: 2,
        fails: 2,
        ..Plan::default()
    });
    bench.decide_times(3);
    assert_eq!(bench.task.message(), Some("a sensor is dirty"));
    bench.decide();
    assert!(bench.task.has_failed());
    assert_eq!(bench.task.message(), None);
    let mut bench = Bench::new(Plan {
        faults: 4,
        fails: 2,
        ..Plan::default()
    });
    bench.decide_times(4);
    assert_eq!(bench.task.message(), Some("a sensor is dirty"));
    bench.state.panel.task_reset += 1;
    bench.decide();
    assert_eq!(bench.task.message(), None, "another job");
}

#[test]
fn a_decision_that_is_not_a_number_is_replaced_by_one_that_holds_and_says_why() {
    let mut bench = Bench::new(Plan {
        not_a_number: 3,
        ..Plan::default()
    });
    bench.decide_times(2);
    let goal = bench.decision.goals[0].goal_id;
    bench.decide();
    assert_eq!(bench.goals(), [HOLDS; 2]);
    assert!(bench.decision.goals[0].goal_id > goal);
    assert_eq!(bench.outcome(), Outcome::Failed);
    assert_eq!(bench.decision.reason.as_str(), "invalid_decision");
    let faults = bench
        .lines
        .iter()
        .filter(|line| line.event == TraceEvent::Fault);
    assert_eq!(faults.count(), 1);
    let message = bench.task.message().unwrap();
    assert!(message.contains("position[2] is NaN"), "{message}");
    bench.decide();
    assert!(bench.task.has_failed(), "the job stays failed");
}

#[test]
fn each_entry_into_a_phase_counts_once_restored_or_not() {
    let mut bench = Bench::new(Plan::default());
    bench.decide();
    assert_eq!(bench.decision.phase_entry, 1);
    for expected in [1, 2, 3, 4] {
        let phase = bench.decision.phase;
        while bench.decision.phase == phase {
            assert_eq!(bench.decision.phase_entry, expected);
            let record = bench.task.checkpoint();
            bench.task = crate::bench::worker(Plan::default());
            bench.task.restore(&record).unwrap();
            bench.decide();
        }
    }
}

#[test]
fn a_reset_stops_the_belt_and_keeps_the_counts_of_requests() {
    let mut bench = Bench::new(Plan::default());
    bench.decide_times(25);
    let asked = bench.decision.io;
    assert_eq!((asked.add_bin, asked.conveyor_running), (3, 1));
    bench.state.panel.task_reset += 1;
    bench.state.panel.task_paused = 1;
    bench.decide();
    let reset = bench.decision.io;
    assert_eq!(
        (reset.add_bin, reset.conveyor_running),
        (3, 0),
        "a count that falls would hide the next request from physics"
    );
    bench.state.panel.task_paused = 0;
    bench.decide();
    assert_eq!(bench.decision.io.add_bin, 4);
}
