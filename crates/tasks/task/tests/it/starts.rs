//! A task across the restarts of its process and of physics.

use ipc_types::{Decision, WorldState};
use robocell_task::inputs::MISSED_TICKS;
use robocell_task::starts::{Begun, Decider, History, Kept, NoHistory};

use ipc_types::Wire as _;

use crate::bench::{Memory, Plan, memory, state, worker};

/// Checkpoints by the tick of the saved state, the newest last.
#[derive(Default)]
struct Saved(Vec<(u64, Vec<u8>)>);

impl History for Saved {
    fn at(&self, tick: u64) -> Option<Kept> {
        let found = self.0.iter().rev().find(|(of, _)| *of <= tick)?;
        Some(Kept {
            tick: found.0,
            checkpoint: found.1.clone(),
        })
    }

    fn keep(&mut self, tick: u64, _saved_tick: u64, checkpoint: &dyn Fn() -> Vec<u8>) {
        self.0.push((tick, checkpoint()));
    }
}

struct Run {
    decider: Decider,
    history: Saved,
    decision: Box<Decision>,
}

impl Run {
    fn new() -> Self {
        Self {
            decider: Decider::new(worker(Plan::default())),
            history: Saved::default(),
            decision: Box::new(Decision::zeroed()),
        }
    }

    fn on(&mut self, state: &WorldState) -> Begun {
        let begun = self.decider.begin(state, &mut self.history);
        let out = &mut self.decision;
        self.decider.decide(state, &[], out, &mut Vec::new());
        begun
    }

    /// Decides on every tenth tick of `ticks`; physics saves its state at tick 500.
    fn through(&mut self, ticks: std::ops::RangeInclusive<u64>) {
        for tick in ticks.step_by(10) {
            let mut state = state(tick);
            state.saving_tick = if tick >= 500 { 500 } else { 0 };
            self.on(&state);
        }
    }

    fn decisions(&self) -> u32 {
        memory(&self.decider.task).decisions
    }

    /// Start number 2 of physics, with the state of `tick` that its predecessor saved.
    fn physics_resumes(&mut self, tick: u64) -> Begun {
        let mut state = state(tick);
        state.header.generation = 2;
        state.resumed_tick = tick;
        self.on(&state)
    }
}

#[test]
fn a_task_resumes_from_its_checkpoint_of_the_state_that_physics_resumes_from() {
    let mut run = Run::new();
    run.through(10..=800);
    assert_eq!(run.history.0.len(), 1, "kept once for each saved state");
    assert_eq!(run.decisions(), 80);
    let goal = run.decision.goals[0].goal_id;
    assert!(matches!(run.physics_resumes(500), Begun::Resumed));
    // Before the decision on tick 500, and one more now.
    assert_eq!(run.decisions(), 49 + 1);
    assert_eq!(memory(&run.decider.task).reconciled, 2);
    assert!(run.decision.goals[0].goal_id < goal, "as of then");
}

#[test]
fn a_task_that_is_not_ahead_of_the_resumed_state_keeps_its_newer_memory() {
    let mut run = Run::new();
    run.through(10..=800);
    // The state of 900 was saved while no decision was made, so there is no checkpoint of it.
    assert!(matches!(run.physics_resumes(900), Begun::Resumed));
    assert_eq!(run.decisions(), 80 + 1);
}

#[test]
fn a_new_scene_starts_the_job_again_with_new_goal_numbers() {
    let mut run = Run::new();
    assert!(matches!(run.on(&state(10)), Begun::NewScene));
    assert!(matches!(run.on(&state(20)), Begun::Continued));
    run.through(30..=800);
    let goal = run.decision.goals[0].goal_id;
    let mut scene = state(10);
    scene.header.generation = 2;
    assert!(matches!(run.on(&scene), Begun::NewScene));
    assert_eq!((run.decisions(), run.decision.phase_entry), (1, 1));
    assert!(run.decision.goals[0].goal_id > goal);
    assert_eq!(run.decider.task.time().ticks(), 0);
}

#[test]
fn a_checkpoint_that_cannot_be_read_is_reported_and_the_scene_starts_again() {
    let mut run = Run::new();
    run.through(10..=800);
    run.history.0[0].1.truncate(20);
    assert!(matches!(run.physics_resumes(500), Begun::Lost(_)));
    assert_eq!(run.decisions(), 1);
}

#[test]
fn a_task_ahead_of_a_state_without_any_checkpoint_starts_a_new_scene() {
    let mut run = Run::new();
    run.through(10..=800);
    run.history.0.clear();
    assert!(matches!(run.physics_resumes(500), Begun::NewScene));
    assert_eq!(run.decisions(), 1);
}

#[test]
fn missed_decisions_reconcile_and_are_not_time_of_a_phase() {
    for (gap, reconciles) in [(MISSED_TICKS, false), (MISSED_TICKS + 10, true)] {
        let mut run = Run::new();
        run.through(10..=100);
        let before = run.decider.task.time().ticks();
        let begun = run.on(&state(100 + gap));
        assert_eq!(matches!(begun, Begun::Reconciled), reconciles);
        let memory: Memory = memory(&run.decider.task);
        assert_eq!(memory.reconciled, 1 + u32::from(reconciles));
        let passed = run.decider.task.time().ticks() - before;
        assert_eq!(passed, if reconciles { 0 } else { gap });
    }
}

#[test]
fn a_new_process_reconciles_only_where_a_decision_was_missed() {
    let mut run = Run::new();
    run.through(10..=200);
    let record = run.decider.task.checkpoint();
    for (tick, reconciled) in [(210, 1), (220, 2)] {
        let mut successor = Decider::new(worker(Plan::default()));
        let state = state(tick);
        successor.resume(&record, (1, 200), &state).unwrap();
        let begun = successor.begin(&state, &mut NoHistory);
        assert!(matches!(begun, Begun::Continued), "{tick}: {begun:?}");
        let mut out = Decision::zeroed();
        successor.decide(&state, &[], &mut out, &mut Vec::new());
        let expected = Memory {
            decisions: 21,
            reconciled,
        };
        assert_eq!(memory(&successor.task), expected, "{tick}");
    }
}

#[test]
fn a_successor_whose_checkpoint_is_damaged_works_on_in_the_running_scene() {
    let mut run = Run::new();
    let state = state(4000);
    assert!(run.decider.resume(&[7; 40], (1, 3990), &state).is_err());
    assert!(matches!(run.on(&state), Begun::Continued));
    assert_eq!(memory(&run.decider.task).reconciled, 1);
}

#[test]
fn a_checkpoint_after_the_saved_state_is_not_kept_for_it() {
    let mut run = Run::new();
    run.through(10..=100);
    // Heard late: the state of 60 was saved, and the task has decided on 100 already.
    let mut late = state(110);
    late.saving_tick = 60;
    run.on(&late);
    assert!(run.history.0.is_empty());
    late.header.tick = 120;
    late.saving_tick = 120;
    run.on(&late);
    assert_eq!(run.history.0.len(), 1);
}
