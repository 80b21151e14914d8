//! The skills, as nodes: when they succeed, when they fail, and how a job ends.

use std::sync::Arc;

use behavior::Status;
use cell_model::{Cell, Data};
use ipc_types::GripperGoal;
use ipc_types::decision::GoalKind;
use ipc_types::equipment::{BreakCause, BreakLimit, SuctionRefusal};
use robocell_skills::{Setup, nodes};
use robocell_task::Reason;
use serde_json::{Value as Json, json};

use crate::bench::{Bench, LEFT, pose};
use crate::conditions::{SLOT, bench};

/// Where the tool of the left arm is at the start.
const TCP: [f64; 3] = [0.4, -0.5, 0.4];

fn skill(name: &str, ports: &Json) -> Bench {
    bench(&json!({"type": name, "ports": ports}))
}

/// Ticks every 10 ms until the node ends, for at most `seconds`; the answer, and the number of
/// ticks.
fn until_over(bench: &mut Bench, seconds: u32) -> (Status, u32) {
    for tick in 1..=100 * seconds {
        let answer = bench.tick();
        if answer != Status::Running {
            return (answer, tick);
        }
    }
    panic!("it still runs after {seconds} s")
}

fn reason(bench: &Bench) -> Option<&str> {
    bench.job.failure.as_ref().map(Reason::as_str)
}

#[test]
fn stay_keeps_the_goal_of_the_motion_before_it_for_its_time() {
    let up = json!({"id": "up", "type": "Up", "ports": {"by_m": 0.1}});
    let stay = json!({"id": "stay", "type": "Stay", "ports": {"for_s": 0.5}});
    let both = json!({"type": "Sequence", "ports": {"memory": true}, "children": [up, stay]});
    let mut bench = bench(&both);
    bench.tick();
    let [x, y, z] = TCP;
    bench.state.arms[LEFT].tcp = pose(x, y, z + 0.1);
    bench.tick();
    let goal = bench.goal();
    let (answer, ticks) = until_over(&mut bench, 2);
    assert_eq!(answer, Status::Success);
    // 0.15 s at rest above, and the stay.
    assert!((60..75).contains(&ticks), "{ticks}");
    assert_eq!(bench.goal().goal_id, goal.goal_id);
    assert_eq!(bench.goal().target, pose(x, y, z + 0.1));
}

#[test]
fn up_is_measured_from_its_start_and_not_from_where_the_arm_is() {
    let mut bench = skill("Up", &json!({"by_m": 0.2}));
    bench.tick();
    let [x, y, z] = TCP;
    bench.state.arms[LEFT].tcp = pose(x, y, z + 0.19);
    bench.tick();
    let target = bench.goal().target.position;
    assert!((target[2] - (z + 0.2)).abs() < 1e-9, "{target:?}");
}

#[test]
fn up_with_an_object_fails_soon_after_it_is_lost_and_keeps_the_gripper_closed() {
    let mut bench = skill("Up", &json!({"by_m": 0.2, "holding": "cube_1"}));
    bench.hold(0);
    bench.tick();
    assert_eq!(bench.gripper(), GripperGoal::Close);
    bench.state.arms[LEFT].gripper.held_object = 0;
    *bench.object(0) = [0.4, -0.5, 0.025];
    let (answer, ticks) = until_over(&mut bench, 1);
    assert_eq!((answer, ticks), (Status::Failure, 5));
    assert_eq!(bench.job.counters.drops, 1);
}

#[test]
fn home_is_the_joints_of_the_start_reached_and_followed_for_a_while() {
    let mut bench = skill("Home", &json!({}));
    let home = bench.setup.arms[LEFT].home;
    bench.state.arms[LEFT].joint_count = 7;
    bench.state.arms[LEFT].joint_positions = home;
    assert_eq!(bench.tick(), Status::Running);
    let goal = bench.goal();
    assert_eq!((goal.kind, goal.has_posture), (GoalKind::Joints.code(), 1));
    assert_eq!(goal.posture, home);
    let (answer, ticks) = until_over(&mut bench, 1);
    assert_eq!((answer, ticks), (Status::Success, 11));
    let mut off = skill("Home", &json!({}));
    off.state.arms[LEFT].joint_count = 7;
    off.state.arms[LEFT].joint_positions = home;
    off.state.arms[LEFT].joint_positions[6] += 0.031;
    let (answer, ticks) = until_over(&mut off, 12);
    assert_eq!(answer, Status::Failure);
    assert!((1000..1005).contains(&ticks), "{ticks}");
}

#[test]
fn open_succeeds_at_once_and_gives_the_job_up_where_the_fingers_are_blocked() {
    let mut bench = skill("Open", &json!({}));
    assert_eq!(bench.tick(), Status::Success);
    let mut blocked = skill("Open", &json!({}));
    blocked.state.arms[LEFT].gripper.width = 0.05;
    assert_eq!(blocked.tick(), Status::Running);
    assert_eq!(blocked.gripper(), GripperGoal::Open);
    let (answer, ticks) = until_over(&mut blocked, 6);
    assert_eq!(answer, Status::Failure);
    assert!((500..502).contains(&ticks), "{ticks}");
    assert_eq!(reason(&blocked), Some("gripper_blocked"));
    assert_eq!(blocked.count("[failed] the gripper does not open"), 1);
}

#[test]
fn close_fails_with_another_object_or_none_in_the_hand() {
    let close = |held: u32| {
        let mut bench = skill("Close", &json!({"object": "cube_1"}));
        bench.state.arms[LEFT].gripper.held_object = held;
        let over = until_over(&mut bench, 4);
        assert_eq!(bench.gripper(), GripperGoal::Close);
        assert_eq!(reason(&bench), None, "the tree may try again");
        over
    };
    assert_eq!(close(1), (Status::Success, 51));
    assert_eq!(close(0), (Status::Failure, 301));
    assert_eq!(close(2), (Status::Failure, 301));
}

/// A skill of an arm with a suction cup.
fn cup(cell: &Cell, name: &str) -> Bench {
    let setup = Arc::new(Setup::new(cell, []));
    let root = json!({"id": "n", "type": name});
    let file = json!({"format": "behavior-tree/1", "name": "bench", "root": root});
    Bench::of((cell, setup.clone()), &nodes::library(&setup), LEFT, &file)
}

#[test]
fn suction_is_switched_on_when_the_tool_is_at_rest_and_off_before_where_it_was_on() {
    let cell = Cell::load(&Data::checkout(), "ur10-palletize", 1, None).unwrap();
    let mut close = cup(&cell, "Close");
    // On since an attempt that attached nothing: the cup does not search again by itself.
    close.state.arms[LEFT].gripper.suction = 1;
    // 9 mm/s.
    for _ in 0..30 {
        close.state.arms[LEFT].tcp.position[2] -= 0.000_09;
        assert_eq!(close.tick(), Status::Running);
        assert_eq!(close.gripper(), GripperGoal::Open);
    }
    for _ in 0..30 {
        close.tick();
    }
    assert_eq!(close.gripper(), GripperGoal::Open, "it is still on");
    close.state.arms[LEFT].gripper.suction = 0;
    assert_eq!(close.tick(), Status::Running);
    assert_eq!(close.gripper(), GripperGoal::Close);
}

#[test]
fn suction_that_fails_says_which_force_broke_the_grip_or_why_nothing_attached() {
    let cell = Cell::load(&Data::checkout(), "ur10-palletize", 1, None).unwrap();
    let failed = |happens: fn(&mut ipc_types::GripperState)| {
        let mut close = cup(&cell, "Close");
        while close.gripper() != GripperGoal::Close {
            assert_eq!(close.tick(), Status::Running);
        }
        happens(&mut close.state.arms[LEFT].gripper);
        assert_eq!(close.tick(), Status::Failure);
        close.lines.concat()
    };
    let broke = failed(|gripper| {
        gripper.breaks += 1;
        gripper.break_limit = BreakLimit::Force.code();
        gripper.break_cause = BreakCause::Impulse.code();
        gripper.peak_force = 52.0;
    });
    assert!(broke.contains("52 N of 50 N"), "{broke}");
    let missed = failed(|gripper| {
        gripper.refusals += 1;
        gripper.refusal = SuctionRefusal::NothingThere.code();
    });
    assert!(missed.contains("nothing there"), "{missed}");
}

#[test]
fn an_exact_motion_ends_at_rest() {
    let ports = json!({"object": "cube_4"});
    let mut bench = skill("MoveTo", &ports);
    *bench.object(3) = [0.5, -0.3, 0.025];
    bench.tick();
    let wanted = bench.goal();
    assert!(wanted.goal_id > 0);
    let [x, y, z] = [0.5, -0.3, bench.object(3)[2]];
    bench.state.arms[LEFT].tcp = pose(x, y, z + 0.003);
    // Within its tolerance of 4 mm for longer than it has to be, at 9 mm/s.
    for tick in 0..40 {
        bench.state.arms[LEFT].tcp.position[2] -= 0.000_09;
        assert_eq!(bench.tick(), Status::Running, "{tick}");
    }
    let (answer, ticks) = until_over(&mut bench, 1);
    assert_eq!(answer, Status::Success);
    // The last 0.3 mm of its way may count as rest.
    assert!((11..=17).contains(&ticks), "{ticks}");
}

#[test]
fn suction_attaches_at_once_or_fails_after_two_seconds_and_is_off_when_it_let_go() {
    let cell = Cell::load(&Data::checkout(), "ur10-palletize", 1, None).unwrap();
    let bench = |name: &str| cup(&cell, name);
    let mut close = bench("Close");
    close.tick();
    close.state.arms[LEFT].gripper.held_object = 2;
    assert_eq!(until_over(&mut close, 1), (Status::Success, 5));
    // 0.15 s at rest before it is on.
    let (answer, ticks) = until_over(&mut bench("Close"), 3);
    assert_eq!(answer, Status::Failure);
    assert!((215..=218).contains(&ticks), "{ticks}");
    let mut open = bench("Open");
    let gripper = &mut open.state.arms[LEFT].gripper;
    (gripper.suction, gripper.attached) = (1, 1);
    open.tick_after(0.5);
    open.state.arms[LEFT].gripper.attached = 0;
    assert_eq!(open.tick(), Status::Running, "suction is still on");
    open.state.arms[LEFT].gripper.suction = 0;
    assert_eq!(open.tick_after(0.3), Status::Success);
}

#[test]
fn a_motion_to_an_object_that_moves_away_fails() {
    let ports = json!({"object": "cube_4", "above_m": 0.1, "move_tolerance_m": 0.02});
    for (moved, expected) in [(0.019, Status::Running), (0.021, Status::Failure)] {
        let mut bench = skill("MoveTo", &ports);
        *bench.object(3) = [0.5, -0.3, 0.025];
        bench.tick();
        bench.object(3)[1] += moved;
        assert_eq!(bench.tick(), expected, "{moved}");
        let resyncs = u32::from(expected == Status::Failure);
        assert_eq!(bench.job.counters.resyncs, resyncs);
    }
}

#[test]
fn a_motion_ends_at_its_time_limit_and_one_out_of_reach_does_not_start() {
    let mut bench = skill(
        "MoveTo",
        &json!({"pose": [0.5, -0.3, 0.3], "timeout_s": 2.0}),
    );
    let (answer, ticks) = until_over(&mut bench, 3);
    assert_eq!((answer, ticks), (Status::Failure, 201));
    let mut far = skill("MoveTo", &json!({"pose": [1.5, -0.3, 0.3]}));
    assert_eq!(far.tick(), Status::Failure);
    assert!(far.holds_still());
}

#[test]
fn what_is_held_askew_is_brought_with_its_own_centre_into_the_next_free_slot() {
    let mut bench = skill("MoveTo", &json!({"object": "cube_1", "place": "shelf"}));
    *bench.object(1) = SLOT;
    bench.hold(0);
    bench.object(0)[0] += 0.01;
    bench.object(0)[2] -= 0.02;
    bench.state.objects[0].pose.orientation_wxyz = [1.0, 0.0, 0.0, 0.0];
    // Near the slot, so that the goal is the target itself and not a point on the way.
    let [x, y, z] = [SLOT[0] - 0.01, SLOT[1] + 0.1, SLOT[2] + 0.02];
    let shift = [x - TCP[0], y - TCP[1] + 0.02, z - TCP[2]];
    for (axis, off) in shift.into_iter().enumerate() {
        bench.state.arms[LEFT].tcp.position[axis] += off;
        bench.object(0)[axis] += off;
    }
    bench.tick();
    let target = bench.goal().target.position;
    for (is, wanted) in target.into_iter().zip([x, y, z]) {
        assert!((is - wanted).abs() < 1e-9, "{target:?}");
    }
}

#[test]
fn an_object_out_of_reach_is_waited_for_and_then_ends_the_job() {
    let mut bench = skill("Pick", &json!({"object": "cube_1"}));
    *bench.object(0) = [1.5, -0.4, 0.025];
    let (answer, ticks) = until_over(&mut bench, 12);
    assert_eq!(answer, Status::Failure);
    assert!((1000..1010).contains(&ticks), "{ticks}");
    assert_eq!(reason(&bench), Some("object_out_of_reach"));
    assert_eq!(bench.count("[wait] cube_1 is out of reach"), 1);
    // Brought back in between, the patience starts again.
    let mut back = skill("Pick", &json!({"object": "cube_1"}));
    for x in [1.5, 0.5, 1.5] {
        *back.object(0) = [x, -0.4, 0.025];
        (0..6).for_each(|_| {
            back.tick_after(1.0);
        });
    }
    assert_eq!(reason(&back), None);
    assert_eq!(back.count("[wait]"), 2);
}

#[test]
fn an_object_that_is_never_gripped_ends_the_job_after_its_attempts() {
    let mut bench = skill("Pick", &json!({"object": "cube_1", "max_attempts": 3}));
    *bench.object(0) = [0.5, -0.3, 0.025];
    let mut failures = 0;
    while bench.job.failure.is_none() {
        let (answer, _) = until_over(&mut bench, 10);
        assert_eq!(answer, Status::Failure);
        failures += 1;
    }
    assert_eq!(failures, 3);
    assert_eq!(reason(&bench), Some("object_not_reached"));
    assert_eq!(bench.count("[retry] cube_1 is not reached"), 3);
}

#[test]
fn another_object_in_the_hand_is_brought_back_before_the_one_that_is_wanted() {
    let mut bench = skill("Pick", &json!({"object": "cube_1"}));
    *bench.object(0) = [0.5, -0.3, 0.025];
    bench.hold(1);
    assert_eq!(bench.tick(), Status::Running);
    assert_eq!(bench.gripper(), GripperGoal::Close, "it is not dropped");
    assert_eq!(
        bench.count("[recover] cube_2 is in the gripper, not cube_1"),
        1
    );
    let mut opened_at = None;
    for _ in 0..3000 {
        bench.tick();
        let goal = bench.goal();
        let (tcp, held) = (goal.target, bench.gripper() == GripperGoal::Close);
        bench.state.arms[LEFT].tcp = tcp;
        if held && opened_at.is_none() {
            bench.hold(1);
        } else if opened_at.is_none() {
            opened_at = Some(*bench.object(1));
            let gripper = &mut bench.state.arms[LEFT].gripper;
            (gripper.width, gripper.held_object) = (0.08, 0);
        }
    }
    // Where the cell file has it.
    let began = bench.setup_position(1);
    let off = opened_at.map(|[x, y, _]| (x - began[0]).hypot(y - began[1]));
    assert!(off.is_some_and(|off| off < 0.02), "{opened_at:?} {began:?}");
    assert_eq!(reason(&bench).filter(|of| of.contains("another")), None);
}

#[test]
fn an_object_that_is_pushed_against_opening_fingers_is_let_go_of() {
    let open = json!({"id": "open", "type": "Open"});
    let pick = json!({"id": "pick", "type": "Pick", "ports": {"object": "cube_1"}});
    let mut bench = bench(&json!({"type": "Sequence", "children": [open, pick]}));
    *bench.object(0) = [0.5, -0.3, 0.025];
    bench.state.arms[LEFT].gripper.width = 0.05;
    bench.tick();
    let gripper = &mut bench.state.arms[LEFT].gripper;
    (gripper.width, gripper.held_object) = (0.08, 2);
    for _ in 0..30 {
        assert_eq!(bench.tick(), Status::Running);
        assert_eq!((bench.gripper(), reason(&bench)), (GripperGoal::Open, None));
    }
    assert_eq!(bench.count("is brought back"), 0);
}

#[test]
fn an_object_that_moves_while_it_is_approached_is_approached_again() {
    let mut bench = skill("Pick", &json!({"object": "cube_1"}));
    *bench.object(0) = [0.5, -0.3, 0.025];
    (0..5).for_each(|_| {
        bench.tick();
    });
    let before = bench.goal();
    bench.object(0)[1] -= 0.031;
    assert_eq!(bench.tick(), Status::Running);
    assert_eq!(
        (bench.job.counters.resyncs, bench.count("[resync]")),
        (1, 1)
    );
    (0..5).for_each(|_| {
        bench.tick();
    });
    let after = bench.goal();
    assert!(after.goal_id > before.goal_id);
    assert!((after.target.position[1] - -0.331).abs() < 1e-9);
    assert_eq!(bench.job.counters.resyncs, 1);
}

#[test]
fn an_object_in_the_hand_is_picked_and_a_full_place_ends_the_job() {
    let mut pick = skill("Pick", &json!({"object": "cube_1"}));
    pick.hold(0);
    assert_eq!(pick.tick(), Status::Success);
    let mut place = skill("Place", &json!({"object": "cube_1", "place": "shelf"}));
    place.hold(0);
    *place.object(1) = SLOT;
    *place.object(2) = [SLOT[0], SLOT[1] + 0.1, SLOT[2]];
    assert_eq!(place.tick(), Status::Failure);
    assert_eq!(reason(&place), Some("place_is_full"));
    assert_eq!(place.count("place 'shelf' has no free slot"), 1);
}

#[test]
fn equipment_is_asked_once_for_each_step() {
    let mut bench = skill("AddBin", &json!({}));
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(bench.job.io.add_bin, 1);
    let mut bench = skill("DropParts", &json!({}));
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(bench.job.io.drop_parts, 1);
    for run in [true, false] {
        let mut bench = skill("Conveyor", &json!({"run": run}));
        bench.job.io.conveyor_running = !run;
        assert_eq!(bench.tick(), Status::Success);
        assert_eq!(bench.job.io.conveyor_running, run);
    }
}

#[test]
fn a_job_is_given_up_with_the_reason_of_its_file() {
    let mut bench = skill("FailJob", &json!({"reason": "lid_is_missing"}));
    assert_eq!(bench.tick(), Status::Failure);
    assert_eq!(reason(&bench), Some("lid_is_missing"));
    assert_eq!(bench.count("[failed] lid_is_missing"), 1);
}

#[test]
fn an_arm_follows_the_targets_that_the_operator_sets_for_it_alone() {
    let mut bench = skill("FollowOperator", &json!({}));
    assert_eq!(bench.tick(), Status::Running);
    assert!(bench.holds_still(), "nothing was asked");
    let panel = &mut bench.state.panel;
    (panel.target_seq, panel.target, panel.target_arm) = (1, pose(0.5, -0.3, 0.3), 1);
    (panel.gripper_seq, panel.gripper) = (1, GripperGoal::Close.code());
    bench.tick();
    assert!(bench.holds_still(), "that was for the other arm");
    assert_eq!(bench.gripper(), GripperGoal::Keep);
    bench.state.panel.target_arm = 0;
    bench.tick();
    assert_eq!(bench.goal().target, pose(0.5, -0.3, 0.3));
    assert_eq!(bench.gripper(), GripperGoal::Close);
    assert!(bench.goal().grip_force > 0.0);
}
