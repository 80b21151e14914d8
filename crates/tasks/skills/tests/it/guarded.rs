//! Motions and grips that watch their object, zones, and reservations.

use std::sync::Arc;

use behavior::Status;
use cell_model::{Cell, Data};
use ipc_types::GripperGoal;
use robocell_skills::nodes;
use robocell_skills::setup::Setup;
use serde_json::{Value as Json, json};

use crate::bench::{Bench, LEFT, RIGHT, pose};

/// The keys with the object on which the tree works.
const WORK: (&str, &str) = ("current_object", "pickup_reference");
/// Over the objects of the cell, with the tool straight down.
const TARGET: [f64; 7] = [0.46, 0.0, 0.22, 0.0, 1.0, 0.0, 0.0];

/// One node for `arm` of a cell with two arms and six cubes.
fn bench(arm: usize, mut node: Json) -> Bench {
    let cell = Cell::load(&Data::checkout(), "franka-pyramid", 1, None).unwrap();
    let setup = Arc::new(Setup::new(&cell, []));
    node["id"] = "node".into();
    let keys = json!({"local": {"current_object": {"type": "text", "default": ""}}});
    let file = json!({
        "format": "behavior-tree/1", "name": "bench", "blackboard": keys, "root": node
    });
    let library = nodes::library(&setup);
    Bench::of((&cell, setup), &library, arm, &file)
}

fn moving(mut ports: Json) -> Bench {
    ports["target"] = json!(TARGET);
    let mut bench = bench(LEFT, json!({"type": "MoveToTarget", "ports": ports}));
    bench.works_at(WORK, 0);
    bench
}

#[test]
fn n08_a_motion_ends_at_its_target_and_not_at_one_of_an_earlier_goal() {
    let mut bench = moving(json!({}));
    bench.state.arms[LEFT].tcp = pose(0.46, 0.0, 0.22);
    assert_eq!(bench.tick(), Status::Running, "no controller was asked yet");
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(bench.goal().target, pose(0.46, 0.0, 0.22));
    bench.state.arms[LEFT].tcp = pose(0.46, 0.0, 0.25);
    assert_eq!(bench.tick(), Status::Running);
}

#[test]
fn n09_an_object_that_moved_stops_the_motion_and_asks_for_a_recovery() {
    let mut bench = moving(json!({"monitor_pickup_motion": true}));
    assert_eq!(bench.tick(), Status::Running);
    assert!(!bench.holds_still() && !bench.recovery());
    bench.object(0)[0] += 0.0081;
    for _ in 0..3 {
        assert_eq!(bench.tick(), Status::Running);
        assert!(bench.holds_still() && bench.recovery());
    }
    assert_eq!(
        (bench.count("[recover]"), bench.job.counters.recoveries),
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
fn a_motion_that_watches_nothing_only_warns() {
    let mut bench = moving(json!({}));
    for _ in 0..11 {
        assert_eq!(bench.tick_after(1.0), Status::Running);
    }
    assert_eq!((bench.count("[warning]"), bench.recovery()), (2, false));
}

#[test]
fn a_lift_waits_for_a_zone_that_it_lost_and_gives_way() {
    let mut bench = moving(json!({"monitor_grasp": true, "in_zone": true}));
    bench.hold(0);
    bench.set_text("zone_owner", "right");
    assert_eq!(bench.tick(), Status::Running);
    assert!(bench.holds_still());
    assert_eq!(bench.wait(), "", "short waits are normal");
    bench.tick_after(2.5);
    assert_eq!(bench.wait(), "left: zone 'zone', which right owns");
    assert!(!bench.holds_still() && bench.goal().target.position[1] < -0.2);
    assert_eq!(bench.gripper(), GripperGoal::Keep);
    bench.set_text("zone_owner", "");
    bench.tick();
    assert_eq!(bench.gripper(), GripperGoal::Close);
    assert_eq!(bench.goal().target, pose(0.46, 0.0, 0.22));
}

#[test]
fn a_pick_up_waits_for_a_zone_that_it_lost() {
    let mut bench = moving(json!({"monitor_pickup_motion": true, "in_zone": true}));
    bench.tick();
    assert_eq!(bench.text("zone_owner"), "left");
    bench.set_text("zone_owner", "right");
    assert_eq!(bench.tick(), Status::Running);
    assert!(bench.holds_still());
    bench.set_text("zone_owner", "");
    assert_eq!(bench.tick(), Status::Running);
    assert!(!bench.holds_still());
    assert_eq!(bench.text("zone_owner"), "left");
}

#[test]
fn a_carried_object_that_left_the_gripper_is_a_drop_and_asks_for_a_recovery() {
    let mut bench = moving(json!({"monitor_grasp": true}));
    bench.hold(0);
    bench.tick();
    assert_eq!(bench.gripper(), GripperGoal::Close);
    assert!(!bench.recovery());
    bench.object(0)[2] -= 0.1;
    bench.state.arms[LEFT].gripper.held_object = 0;
    for _ in 0..3 {
        assert_eq!(bench.tick(), Status::Running);
        assert!(bench.holds_still() && bench.recovery());
        assert_eq!(bench.gripper(), GripperGoal::Keep);
    }
    assert_eq!(bench.job.counters.drops, 1);
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
fn what_is_in_the_gripper_need_not_be_picked_up() {
    let mut bench = moving(json!({"monitor_pickup_motion": true, "skip_when_held": true}));
    bench.hold(0);
    assert_eq!(bench.tick(), Status::Success);
    assert!(bench.holds_still());
}

fn gripper(command: &str) -> Bench {
    let ports = json!({"command": command});
    let mut bench = bench(LEFT, json!({"type": "SetGripper", "ports": ports}));
    bench.works_at(WORK, 0);
    bench
}

#[test]
fn n13_an_object_that_moved_is_not_closed_on() {
    let mut bench = gripper("close");
    assert_eq!(bench.tick(), Status::Running);
    bench.object(0)[1] += 0.009;
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
fn a_gripper_that_closed_on_nothing_asks_for_a_recovery() {
    let mut bench = gripper("close");
    for _ in 0..4 {
        assert_eq!(bench.tick_after(0.25), Status::Running);
    }
    assert!(bench.recovery());
}

#[test]
fn n17_an_unknown_command_is_a_failure() {
    let node = json!({"type": "SetGripper", "ports": {"command": {"bb": "local.current_object"}}});
    let mut bench = bench(LEFT, node);
    bench.works_at(WORK, 0);
    assert_eq!(bench.tick(), Status::Failure);
    assert_eq!(bench.count("'cube_1' is not a command"), 1);
    assert!(bench.holds_still());
}

/// Where an object belongs, in the second layer of a stack.
const GOAL: [f64; 7] = [0.46, -0.28, 0.075, 1.0, 0.0, 0.0, 0.0];

#[test]
fn n27_lifted_means_high_and_in_the_gripper() {
    for (height, apart, lifted) in [(0.15, 0.05, true), (0.149, 0.0, false), (0.3, 0.051, false)] {
        for recover in [false, true] {
            let ports = json!({"object": "cube_1", "recover_on_failure": recover});
            let mut bench = bench(LEFT, json!({"type": "CheckObjectLifted", "ports": ports}));
            *bench.object(0) = [0.5, 0.0, height];
            bench.state.arms[LEFT].tcp.position = [0.5, apart, height];
            let expected = match (lifted, recover) {
                (true, _) => Status::Success,
                (false, false) => Status::Failure,
                (false, true) => Status::Running,
            };
            assert_eq!(bench.tick(), expected, "{height} {apart}");
            assert_eq!(bench.recovery(), !lifted && recover);
        }
    }
}

#[test]
fn n28_at_the_target_means_near_in_the_plane_and_in_its_layer() {
    for (x, z, there) in [
        (0.46, 0.075, true),
        (0.509, 0.075, true),
        (0.511, 0.075, false),
        (0.46, 0.025, false),
    ] {
        let ports = json!({"object": "cube_4", "target": GOAL, "recover_on_failure": true});
        let mut bench = bench(LEFT, json!({"type": "CheckObjectAtTarget", "ports": ports}));
        *bench.object(3) = [x, -0.28, z];
        let expected = if there {
            Status::Success
        } else {
            Status::Running
        };
        assert_eq!(bench.tick(), expected, "{x} {z}");
        assert_eq!(bench.recovery(), !there);
    }
}

#[test]
fn a_zone_is_entered_by_one_arm_and_left_by_its_owner_only() {
    let mut enter = bench(
        LEFT,
        json!({"type": "EnterZone", "ports": {"zone": "press"}}),
    );
    enter.set_text("press_owner", "right");
    assert_eq!(enter.tick(), Status::Running);
    enter.set_text("press_owner", "");
    enter.mute = true;
    assert_eq!(enter.tick_after(1.0), Status::Running, "it does not answer");
    enter.mute = false;
    assert_eq!(enter.tick(), Status::Success);
    assert_eq!(enter.text("press_owner"), "left");
    let mut leave = bench(
        LEFT,
        json!({"type": "LeaveZone", "ports": {"zone": "press"}}),
    );
    for (owner, then) in [("left", ""), ("right", "right")] {
        leave.set_text("press_owner", owner);
        assert_eq!(leave.tick(), Status::Success);
        assert_eq!(leave.text("press_owner"), then);
    }
}

#[test]
fn an_arm_with_no_job_of_its_own_waits_for_a_zone_where_it_started() {
    let mut bench = bench(RIGHT, json!({"type": "EnterZone"}));
    bench.set_text("zone_owner", "left");
    bench.tick();
    assert_eq!(bench.tick_after(2.5), Status::Running);
    let [_, y, z] = bench.goal().target.position;
    assert!((y - 0.4).abs() < 0.01 && z > 0.3, "{y} {z}");
}

#[test]
fn an_object_is_reserved_by_one_arm_at_a_time() {
    let node = |kind| json!({"type": kind, "ports": {"object": "cube_2"}});
    let mut reserve = bench(LEFT, node("Reserve"));
    for (owner, expected, then) in [
        ("available", Status::Success, "reserved:left"),
        ("reserved:left", Status::Success, "reserved:left"),
        ("carried:right", Status::Failure, "carried:right"),
    ] {
        reserve.set_text("object_state:cube_2", owner);
        assert_eq!(reserve.tick(), expected, "{owner}");
        assert_eq!(reserve.text("object_state:cube_2"), then);
    }
    let mut back = bench(LEFT, node("Unreserve"));
    back.set_text("object_state:cube_2", "placed:left");
    assert_eq!(back.tick(), Status::Success);
    assert_eq!(back.text("object_state:cube_2"), "available");
}
