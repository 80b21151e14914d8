//! What a checkpoint restores, and what is refused.

use robocell_task::{CheckpointError, Job, Observation, Output, Policy, Restored, Task, boxed};

use crate::bench::{Bench, GRIP_FORCE_N, Memory, Plan, Worker, load, memory, worker};

#[test]
fn a_memory_that_the_policy_refuses_is_started_again_and_the_job_goes_on() {
    let mut bench = Bench::new(Plan::default());
    bench.decide_times(999);
    let kept = bench.task.checkpoint();
    bench.decide();
    let refused = bench.task.checkpoint();
    for (record, decisions) in [(kept, 999), (refused, 0)] {
        let mut task = worker(Plan::default());
        task.restore(&record).unwrap();
        assert_eq!(memory(&task).decisions, decisions);
        let mut after = Bench::of(task);
        after.state.header.tick = bench.state.header.tick;
        after.decide();
        assert!(after.decision.io.add_bin >= 100, "counted on");
    }
}

/// Another policy for the same job: it does nothing.
struct Other;

impl Policy for Other {
    type Memory = Memory;

    fn decide(&self, memory: &mut Memory, _: &Observation<'_>, _: &mut Job, _: &mut Output) {
        memory.decisions += 1;
    }

    fn reconcile(&self, memory: &mut Memory, _: &Observation<'_>, _: &mut Job, _: &mut Output) {
        memory.reconciled += 1;
    }
}

#[test]
fn another_policy_takes_over_the_job_and_compares_it_with_the_cell_first() {
    let mut bench = Bench::new(Plan::default());
    bench.decide_times(25);
    let record = bench.task.checkpoint();
    let goal = bench.decision.goals[0].goal_id;
    let cell = load("franka-pyramid");
    let mut other = Task::new(&cell, "other", GRIP_FORCE_N, boxed(Other));
    other.restore(&record).unwrap();
    assert_eq!(other.restored(), Restored::OtherPolicy);
    bench.task = other;
    bench.decide();
    assert_eq!(bench.task.restored(), Restored::All, "said once");
    let expected = Memory {
        decisions: 1,
        reconciled: 1,
    };
    assert_eq!(memory(&bench.task), expected);
    assert_eq!(bench.decision.policy.as_str(), "other");
    assert_eq!(bench.decision.io.add_bin, 3);
    assert!(bench.decision.goals[0].goal_id > goal);
}

/// A policy that reports absurd counts.
struct Counts(u32);

impl Policy for Counts {
    type Memory = ();

    fn decide(&self, (): &mut (), _: &Observation<'_>, job: &mut Job, _: &mut Output) {
        job.counters.drops = self.0;
    }
}

#[test]
fn counts_on_which_counting_would_overflow_are_refused_and_change_nothing() {
    let cell = load("franka-pyramid");
    let task = |drops| Task::new(&cell, "counts", GRIP_FORCE_N, boxed(Counts(drops)));
    for (drops, taken) in [(1_000_000, true), (u32::MAX, false)] {
        let mut bench = Bench::of(task(drops));
        bench.decide();
        let mut fresh = task(0);
        let before = fresh.checkpoint();
        let restored = fresh.restore(&bench.task.checkpoint());
        assert_eq!(restored.is_ok(), taken, "{drops}");
        assert_eq!(fresh.checkpoint() == before, !taken);
        if let Err(error) = restored {
            let said = error.to_string();
            assert!(said.contains("counts further than a run can get"), "{said}");
        }
    }
}

#[test]
fn a_checkpoint_of_a_cell_with_another_number_of_objects_is_refused() {
    let mut bench = Bench::new(Plan::default());
    bench.decide();
    let mut fewer = load("franka-pyramid");
    fewer.objects.pop();
    let mut task = Task::new(
        &fewer,
        "worker",
        GRIP_FORCE_N,
        boxed(Worker(Plan::default())),
    );
    let refused = task.restore(&bench.task.checkpoint());
    assert!(matches!(refused, Err(CheckpointError::OtherCell { .. })));
}
