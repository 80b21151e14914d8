//! Rows N09 to N17: motions and grips that watch their cube.

use behavior::Status;
use ipc_types::GripperGoal;
use serde_json::{Value as Json, json};

use super::{Bench, LEFT, pose};

fn moving(ports: Json) -> Bench {
    let mut ports = ports;
    ports["target"] = json!({"bb": "local.approach"});
    let mut bench = Bench::new(LEFT, json!({"type": "MoveToTarget", "ports": ports}));
    bench.works_at(0, &["approach"], pose(0.46, 0.0, 0.22));
    bench
}

#[test]
fn n08_a_motion_ends_at_its_target_and_not_at_one_of_an_earlier_goal() {
    let mut bench = moving(json!({}));
    bench.state.arms[LEFT].tcp = pose(0.46, 0.0, 0.22);
    assert_eq!(bench.tick(), Status::Running, "nobody was asked yet");
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(bench.goal().target, pose(0.46, 0.0, 0.22));
    bench.state.arms[LEFT].tcp = pose(0.46, 0.0, 0.25);
    assert_eq!(bench.tick(), Status::Running);
}

#[test]
fn n09_a_cube_that_moved_stops_the_motion_and_asks_for_a_recovery() {
    let mut bench = moving(json!({"monitor_pickup_motion": true}));
    assert_eq!(bench.tick(), Status::Running);
    assert!(!bench.holds_still() && !bench.recovery());
    bench.cube(0)[0] += 0.0081;
    for _ in 0..3 {
        assert_eq!(bench.tick(), Status::Running);
        assert!(bench.holds_still() && bench.recovery());
    }
    assert_eq!(
        (bench.count("[recover]"), bench.counters.recoveries),
        (1, 1)
    );
}

#[test]
fn n11_a_pick_up_that_takes_too_long_asks_for_a_recovery() {
    let mut bench = moving(json!({"monitor_pickup_motion": true}));
    bench.tick_after(0.0);
    for _ in 0..4 {
        assert_eq!(bench.tick_after(1.0), Status::Running);
        assert!(!bench.recovery());
    }
    assert_eq!(bench.tick_after(1.0), Status::Running);
    assert!(bench.recovery());
    assert_eq!(bench.count("[warning]"), 1);
}

#[test]
fn a_motion_that_nobody_watches_only_warns() {
    let mut bench = moving(json!({}));
    for _ in 0..11 {
        assert_eq!(bench.tick_after(1.0), Status::Running);
    }
    assert_eq!((bench.count("[warning]"), bench.recovery()), (2, false));
}

#[test]
fn a_lift_waits_for_a_centre_that_it_lost_and_goes_out_of_the_way() {
    let mut bench = moving(json!({"monitor_grasp": true, "in_center": true}));
    bench.hold(0);
    bench.set_text("center_owner", "right");
    assert_eq!(bench.tick(), Status::Running);
    assert!(bench.holds_still());
    bench.tick_after(2.5);
    assert!(!bench.holds_still() && bench.goal().target.position[1] < -0.2);
    assert_eq!(bench.gripper(), GripperGoal::Keep);
    bench.set_text("center_owner", "");
    bench.tick();
    assert_eq!(bench.gripper(), GripperGoal::Close);
    assert_eq!(bench.goal().target, pose(0.46, 0.0, 0.22));
}

#[test]
fn a_pick_up_waits_for_a_centre_that_it_lost() {
    let mut bench = moving(json!({"monitor_pickup_motion": true, "in_center": true}));
    bench.tick();
    assert_eq!(bench.text("center_owner"), "left");
    bench.set_text("center_owner", "right");
    assert_eq!(bench.tick(), Status::Running);
    assert!(bench.holds_still());
    bench.set_text("center_owner", "");
    assert_eq!(bench.tick(), Status::Running);
    assert!(!bench.holds_still());
    assert_eq!(bench.text("center_owner"), "left");
}

#[test]
fn a_carried_cube_that_left_the_hand_is_a_drop_and_asks_for_a_recovery() {
    let mut bench = moving(json!({"monitor_grasp": true}));
    bench.hold(0);
    bench.tick();
    assert_eq!(bench.gripper(), GripperGoal::Close);
    assert!(!bench.recovery());
    bench.cube(0)[2] -= 0.06;
    for _ in 0..3 {
        assert_eq!(bench.tick(), Status::Running);
        assert!(bench.holds_still() && bench.recovery());
        assert_eq!(bench.gripper(), GripperGoal::Keep);
    }
    assert_eq!(bench.counters.drops, 1);
}

#[test]
fn a_grip_that_flickers_is_none_that_is_lost() {
    let mut bench = moving(json!({"monitor_grasp": true}));
    bench.hold(0);
    for tick in 0..40 {
        bench.state.arms[LEFT].gripper.held_object = u32::from(tick % 4 == 0);
        assert_eq!(bench.tick(), Status::Running);
    }
    assert!(!bench.recovery());
    bench.state.arms[LEFT].gripper.held_object = 0;
    (0..6).for_each(|_| {
        bench.tick();
    });
    assert!(bench.recovery(), "near, but not between the fingers");
}

#[test]
fn what_is_in_the_hand_need_not_be_picked_up() {
    let mut bench = moving(json!({"monitor_pickup_motion": true, "skip_when_held": true}));
    bench.hold(0);
    assert_eq!(bench.tick(), Status::Success);
    assert!(bench.holds_still());
}

fn gripper(command: &str) -> Bench {
    let ports = json!({"command": command});
    let mut bench = Bench::new(LEFT, json!({"type": "SetGripper", "ports": ports}));
    bench.works_at(0, &[], pose(0.0, 0.0, 0.0));
    bench
}

#[test]
fn n13_a_cube_that_moved_is_not_closed_on() {
    let mut bench = gripper("close");
    assert_eq!(bench.tick(), Status::Running);
    bench.cube(0)[1] += 0.009;
    assert_eq!(bench.tick_after(0.25), Status::Running);
    assert_eq!(bench.tick_after(0.25), Status::Running);
    assert!(bench.recovery());
    assert_eq!(bench.gripper(), GripperGoal::Keep);
}

#[test]
fn n14_closing_waits_closes_and_waits() {
    let mut bench = gripper("close");
    assert_eq!(bench.tick_after(0.25), Status::Running);
    assert_eq!(bench.gripper(), GripperGoal::Keep);
    assert_eq!(bench.tick_after(0.25), Status::Running);
    assert_eq!(bench.gripper(), GripperGoal::Close);
    bench.hold(0);
    assert_eq!(bench.tick_after(0.25), Status::Success);
    assert_eq!(bench.gripper(), GripperGoal::Close);
}

#[test]
fn n15_opening_has_the_same_timing_and_says_so_twice() {
    let mut bench = gripper("open");
    let mut opened = 0;
    for expected in [Status::Running, Status::Running, Status::Success] {
        assert_eq!(bench.tick_after(0.25), expected);
        opened += u32::from(bench.gripper() == GripperGoal::Open);
    }
    assert_eq!(opened, 2);
}

#[test]
fn a_hand_that_closed_on_nothing_asks_for_a_recovery() {
    let mut bench = gripper("close");
    for _ in 0..4 {
        assert_eq!(bench.tick_after(0.25), Status::Running);
    }
    assert!(bench.recovery());
}

#[test]
fn n17_an_unknown_command_is_a_failure() {
    let node = json!({"type": "SetGripper", "ports": {"command": {"bb": "local.current_cube"}}});
    let mut bench = Bench::new(LEFT, node);
    bench.works_at(0, &[], pose(0.0, 0.0, 0.0));
    assert_eq!(bench.tick(), Status::Failure);
    assert_eq!(bench.count("'cube_1' is no command"), 1);
    assert!(bench.holds_still());
}
