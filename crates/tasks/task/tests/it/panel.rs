//! The operator leads one of two arms, and requests that are older than the task.

use ipc_types::GripperGoal;
use ipc_types::decision::{GoalKind, Outcome};
use robocell_task::Task;
use robocell_task::boxed;

use crate::bench::{Bench, GRIP_FORCE_N, Plan, UP, Worker, load, memory};

const HOLDS: (u32, u32) = (GoalKind::Hold as u32, GripperGoal::Keep as u32);

/// Two arms at work, paused.
fn paused() -> Bench {
    let mut bench = Bench::new(Plan::default());
    bench.decide_times(3);
    bench.state.panel.task_paused = 1;
    bench.decide();
    bench
}

fn point_at(bench: &mut Bench, arm: u32) {
    let panel = &mut bench.state.panel;
    (panel.target_arm, panel.target) = (arm, UP);
    panel.target_seq += 1;
}

#[test]
fn the_operator_moves_one_arm_and_the_other_holds() {
    let mut bench = paused();
    assert_eq!(bench.goals(), [HOLDS; 2]);
    point_at(&mut bench, 1);
    bench.decide();
    let [left, right] = bench.goals();
    assert_eq!(left, HOLDS);
    assert_eq!(right, (GoalKind::Pose.code(), GripperGoal::Keep.code()));
    assert_eq!(bench.decision.goals[1].target, UP);
    assert_eq!(bench.outcome(), Outcome::Paused);
}

#[test]
fn a_target_in_the_state_that_pauses_is_followed_and_an_older_one_is_not() {
    let mut bench = Bench::new(Plan::default());
    bench.decide_times(2);
    point_at(&mut bench, 1);
    bench.decide();
    bench.state.panel.task_paused = 1;
    bench.decide();
    assert_eq!(bench.goals(), [HOLDS; 2], "from before the pause");
    bench.state.panel.task_paused = 0;
    bench.decide();
    bench.state.panel.task_paused = 1;
    point_at(&mut bench, 1);
    bench.decide();
    assert_eq!(bench.goals()[1].0, GoalKind::Pose.code());
}

#[test]
fn a_gripper_closes_for_the_operator_with_the_force_of_the_task() {
    let mut bench = paused();
    let panel = &mut bench.state.panel;
    (panel.target_arm, panel.gripper) = (1, GripperGoal::Close.code());
    panel.gripper_seq += 1;
    bench.decide();
    let [left, right] = bench.decision.goals;
    assert_eq!(left.gripper, GripperGoal::Keep.code());
    assert_eq!(right.gripper, GripperGoal::Close.code());
    assert_eq!(right.grip_force, GRIP_FORCE_N);
    assert_eq!(right.kind, GoalKind::Hold.code(), "no target was given");
}

#[test]
fn joints_that_the_operator_sets_are_a_goal_of_joints() {
    let mut bench = paused();
    point_at(&mut bench, 0);
    bench.state.panel.target_is_joints = 1;
    bench.state.panel.target_joints[3] = -1.5;
    bench.decide();
    let goal = bench.decision.goals[0];
    assert_eq!((goal.kind, goal.has_posture), (GoalKind::Joints.code(), 1));
    assert_eq!(goal.posture[3], -1.5);
    let first = goal.goal_id;
    point_at(&mut bench, 0);
    bench.decide();
    let again = bench.decision.goals[0].goal_id;
    assert_eq!(again, first + 1, "each request is a new goal");
    bench.decide();
    assert_eq!(bench.decision.goals[0].goal_id, again);
}

#[test]
fn after_a_reset_each_arm_returns_until_the_operator_moves_it() {
    let mut bench = paused();
    bench.state.panel.task_reset += 1;
    bench.decide();
    let open = (GoalKind::Hold.code(), GripperGoal::Open.code());
    assert_eq!(bench.goals(), [open; 2], "the fingers open first");
    bench.decide_times(60);
    let home = (GoalKind::Joints.code(), GripperGoal::Open.code());
    assert_eq!(bench.goals(), [home; 2]);
    let arms = load("franka-pyramid").arms;
    for (goal, arm) in bench.decision.goals.iter().zip(&arms) {
        assert_eq!(goal.posture[..arm.home.len()], arm.home[..], "{}", arm.name);
    }
    point_at(&mut bench, 1);
    bench.decide();
    let led = (GoalKind::Pose.code(), GripperGoal::Keep.code());
    assert_eq!(bench.goals(), [home, led]);
}

#[test]
fn requests_to_an_earlier_task_are_not_obeyed_but_its_start_counts() {
    let mut bench = Bench::new(Plan::default());
    let panel = &mut bench.state.panel;
    (panel.task_reset, panel.scene_reset, panel.task_start) = (4, 2, 3);
    panel.task_started = 1;
    bench.decide();
    assert_eq!(bench.count("[task] reset"), 0);
    assert_eq!(memory(&bench.task).decisions, 1);
    let ready = |started: u32| {
        let mut bench = Bench::of(Task::new(
            &load("franka-pyramid"),
            "waits",
            GRIP_FORCE_N,
            boxed(Waits),
        ));
        bench.state.panel.task_started = started;
        bench.state.panel.task_start = 3;
        bench.decide();
        let first = bench.outcome();
        bench.state.panel.task_start += 1;
        bench.decide();
        (first, bench.outcome())
    };
    assert_eq!(ready(0), (Outcome::Idle, Outcome::Running));
    assert_eq!(ready(1), (Outcome::Running, Outcome::Running));
}

#[test]
fn guides_of_paths_do_not_keep_the_operator_out() {
    let cell = load("ur10-palletize");
    let task = Task::new(&cell, "worker", 0.0, boxed(Worker(Plan::default())));
    let mut bench = Bench::of(task);
    bench.state.arm_count = 1;
    bench.state.object_count = u32::try_from(cell.objects.len()).unwrap();
    bench.state.panel.task_paused = 1;
    bench.decide();
    point_at(&mut bench, 0);
    bench.decide();
    let mask = bench.decision.goals[0].obstacle_mask;
    let counts: Vec<(bool, bool)> = cell
        .obstacles()
        .enumerate()
        .map(|(bit, obstacle)| (obstacle.solid, mask >> bit & 1 == 1))
        .collect();
    assert!(counts.iter().all(|(solid, counts)| solid == counts));
    assert!(counts.contains(&(false, false)) && counts.contains(&(true, true)));
}

/// Waits for the start event.
struct Waits;

impl robocell_task::Policy for Waits {
    type Memory = ();

    fn decide(
        &self,
        (): &mut (),
        _: &robocell_task::Observation<'_>,
        job: &mut robocell_task::Job,
        out: &mut robocell_task::Output,
    ) {
        if !job.started {
            out.outcome = Outcome::Idle;
        }
    }
}
