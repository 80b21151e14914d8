//! Rows N01 to N07, N19 to N23 and N29: taking a cube, and getting it back.

use behavior::{Status, Value};
use ipc_types::{GripperGoal, Wire as _};
use serde_json::json;

use super::{Bench, LEFT, RIGHT, WORK, bench, current, pose, set_of, stack, target};
use crate::pyramid::notes::TARGETS;

fn acquire(arm: usize) -> Bench {
    bench(arm, json!({"type": "AcquireCube"}))
}

#[test]
fn n01_waits_without_touching_anything_while_the_other_owns_the_centre() {
    let mut bench = acquire(RIGHT);
    bench.set_text("center_owner", "left");
    // A pose that could not be read would fail.
    bench.state.objects.iter_mut().for_each(|o| o.flags = 0);
    let before = bench.all();
    assert_eq!(bench.tick(), Status::Running);
    assert_eq!(bench.all(), before);
    assert!(current(&bench).is_empty() && bench.lines.is_empty());
}

#[test]
fn an_arm_that_does_not_answer_leaves_the_centre_alone() {
    let mut bench = acquire(LEFT);
    bench.mute = true;
    assert_eq!(bench.tick_after(1.0), Status::Running);
    assert_eq!(bench.text("center_owner"), "");
    bench.mute = false;
    assert_eq!(bench.tick(), Status::Success);
}

#[test]
fn a_cube_between_the_fingers_of_the_other_arm_is_not_the_next() {
    let mut bench = acquire(LEFT);
    let top = bench.state.objects[0].pose.position;
    bench.state.arms[RIGHT].tcp = pose(top[0], top[1], top[2]);
    assert_eq!(
        bench.tick(),
        Status::Running,
        "the others are near, or covered"
    );
    bench.state.arms[RIGHT].tcp = pose(top[0], top[1], top[2] + 0.2);
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(current(&bench), "cube_1");
}

#[test]
fn n02_takes_the_centre_and_the_first_cube_of_the_order() {
    let mut bench = acquire(LEFT);
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(bench.text("center_owner"), "left");
    assert_eq!(bench.text("cube_state:cube_1"), "reserved:left");
    assert_eq!(current(&bench), "cube_1");
    assert_eq!(bench.get("stack_complete:left"), Some(Value::Bool(false)));
    for name in TARGETS {
        assert!(target(&bench, name).is_some(), "{name}");
    }
}

#[test]
fn n03_a_pose_that_cannot_be_read_is_a_failure_that_takes_nothing() {
    let mut bench = acquire(LEFT);
    bench.state.objects[0].flags = 0;
    assert_eq!(bench.tick(), Status::Failure);
    assert_eq!(bench.count("[error]"), 1);
    assert_eq!(bench.text("center_owner"), "");
    assert_eq!(bench.text("cube_state:cube_1"), "available");
    assert!(current(&bench).is_empty());
}

#[test]
fn n05_the_right_arm_has_an_order_of_its_own() {
    for (arm, order) in [(LEFT, [0, 1, 2, 3, 4, 5]), (RIGHT, [0, 2, 1, 5, 4, 3])] {
        let mut gone: Vec<usize> = Vec::new();
        for cube in order {
            let mut bench = acquire(arm);
            for other in &gone {
                bench.set_text(&format!("cube_state:cube_{}", other + 1), "carried:other");
                *bench.object(*other) = [0.3, 0.0, 0.5 + 0.2 * *other as f64];
            }
            assert_eq!(bench.tick(), Status::Success);
            assert_eq!(current(&bench), format!("cube_{}", cube + 1));
            gone.push(cube);
        }
    }
}

#[test]
fn n07_the_goal_is_a_layer_higher_for_each_placed_cube() {
    let mut bench = acquire(RIGHT);
    stack(&mut bench, ("right", 0.28), &[0, 2]);
    assert_eq!(bench.tick(), Status::Success);
    let [x, y, z, ..] = target(&bench, "object_goal").unwrap();
    assert!((x - 0.46).abs() < 1e-9 && (y - 0.28).abs() < 1e-9);
    assert!((z - 0.125).abs() < 1e-9, "{z}");
}

#[test]
fn a_cube_under_another_is_not_taken_and_one_out_of_reach_neither() {
    let mut bench = acquire(LEFT);
    bench.set_text("cube_state:cube_1", "reserved:right");
    // The top cube is on both middle ones, these on the base.
    assert_eq!(bench.tick(), Status::Running);
    *bench.object(0) = [0.46, 1.0, 0.025];
    *bench.object(1) = [2.0, 0.0, 0.025];
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(current(&bench), "cube_3");
}

#[test]
fn a_cube_that_left_the_stack_is_taken_again() {
    let mut bench = acquire(LEFT);
    stack(&mut bench, ("left", -0.28), &[0, 1]);
    *bench.object(0) = [0.3, -0.5, 0.025];
    *bench.object(1) = [0.46, -0.28, 0.025];
    assert_eq!(bench.tick(), Status::Success);
    // The second is at the bottom of the stack now.
    assert_eq!(bench.get("placed:left"), Some(set_of(&[1])));
    assert_eq!(current(&bench), "cube_1");
    let [.., z, _, _, _, _] = target(&bench, "object_goal").unwrap();
    assert!((z - 0.075).abs() < 1e-9, "{z}");
}

#[test]
fn a_cube_that_is_its_own_already_is_aimed_at_again() {
    let mut bench = acquire(LEFT);
    assert_eq!(bench.tick(), Status::Success);
    bench.set("recovery_requested:left", Value::Bool(true));
    bench.set("stack_complete:left", Value::Bool(true));
    *bench.object(0) = [0.4, -0.1, 0.025];
    assert_eq!(bench.tick(), Status::Success);
    assert!(!bench.recovery());
    assert_eq!(bench.get("stack_complete:left"), Some(Value::Bool(true)));
    assert_eq!(bench.count("[acquire]"), 1, "no new reservation");
    let [x, y, ..] = target(&bench, "grasp").unwrap();
    assert_eq!((x, y), (0.4, -0.1));
}

#[test]
fn a_cube_in_the_hand_is_the_next_one() {
    let mut bench = acquire(RIGHT);
    bench.hold(4);
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(current(&bench), "cube_5");
    assert_eq!(bench.text("cube_state:cube_5"), "reserved:right");
}

#[test]
fn a_cube_in_the_way_of_the_stack_is_put_aside() {
    let mut bench = acquire(LEFT);
    *bench.object(3) = [0.48, -0.25, 0.025];
    *bench.object(0) = [0.47, -0.26, 0.075];
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(current(&bench), "cube_1");
    assert_eq!(bench.local("aside"), Some(Value::Bool(true)));
    let [x, ..] = target(&bench, "object_goal").unwrap();
    assert!((x - 0.46).abs() > 0.1, "{x}");
}

fn recover(arm: usize) -> Bench {
    let mut bench = bench(arm, json!({"type": "RecoverCube"}));
    bench.works_at(WORK, 0);
    let robot = bench.setup.arms[arm].name.clone();
    bench.set(&format!("recovery_requested:{robot}"), Value::Bool(true));
    bench
}

#[test]
fn n19_a_recovery_waits_while_the_other_owns_the_centre() {
    let mut bench = recover(RIGHT);
    bench.set_text("center_owner", "left");
    assert_eq!(bench.tick(), Status::Running);
    assert!(bench.holds_still());
    assert_eq!(bench.text("center_owner"), "left");
}

#[test]
fn n21_an_unreached_cube_gives_a_warning_an_interval_and_is_kept_for_three() {
    let mut bench = recover(LEFT);
    bench.set_text("cube_state:cube_1", "carried:left");
    bench.tick_after(0.0);
    for _ in 0..5 {
        assert_eq!(bench.tick_after(1.0), Status::Running);
    }
    assert_eq!(bench.count("[warning]"), 1);
    assert_eq!(bench.text("cube_state:cube_1"), "reserved:left");
    assert_eq!(bench.text("center_owner"), "left");
    for _ in 0..5 {
        bench.tick_after(1.0);
    }
    assert_eq!(bench.count("[warning]"), 2);
    // Another arm may reach it.
    for _ in 0..4 {
        assert_eq!(bench.tick_after(1.0), Status::Running);
    }
    assert_eq!(bench.tick_after(1.0), Status::Failure);
    assert_eq!(bench.text("cube_state:cube_1"), "available");
}

#[test]
fn n23_a_cube_that_creeps_starts_the_wait_again_and_a_still_one_ends_it_in_failure() {
    let mut bench = recover(LEFT);
    let above = |bench: &mut Bench| {
        let [x, y, z] = *bench.object(0);
        bench.state.arms[LEFT].tcp.position = [x, y, z + 0.2];
    };
    for _ in 0..10 {
        above(&mut bench);
        assert_eq!(bench.tick_after(0.15), Status::Running);
        bench.object(0)[0] -= 0.005;
    }
    above(&mut bench);
    assert_eq!(bench.tick_after(0.15), Status::Running);
    // Within half of the tolerance of the last reference, however often.
    bench.object(0)[0] += 0.003;
    assert_eq!(bench.tick_after(0.15), Status::Running);
    bench.object(0)[0] -= 0.005;
    assert_eq!(bench.tick_after(0.1), Status::Failure);
    assert!(!bench.recovery());
    assert_eq!(current(&bench), "cube_1", "still its own");
}

#[test]
fn a_recovery_opens_the_hand_but_never_around_its_own_cube() {
    let mut bench = recover(LEFT);
    assert_eq!(bench.tick(), Status::Running);
    assert_eq!(bench.gripper(), GripperGoal::Open);
    let mut bench = recover(LEFT);
    bench.hold(0);
    assert_eq!(bench.tick(), Status::Failure);
    assert_eq!(bench.gripper(), GripperGoal::Keep);
}

#[test]
fn a_cube_that_left_the_reach_is_available_to_all_arms_again() {
    let mut bench = recover(LEFT);
    *bench.object(0) = [1.5, 0.6, 0.025];
    assert_eq!(bench.tick(), Status::Failure);
    assert_eq!(bench.count("cube_1 is out of reach"), 1);
    assert_eq!(bench.text("cube_state:cube_1"), "available");
    assert_eq!(bench.text("center_owner"), "");
    assert_eq!(current(&bench), "");
    assert!(!bench.recovery());
}

#[test]
fn a_cube_that_was_given_up_is_left_alone_until_it_moves_or_a_while_has_passed() {
    let mut bench = acquire(LEFT);
    for (cube, x) in [(1, 0.8), (2, 0.9), (3, 1.0), (4, 1.1), (5, 1.2)] {
        *bench.object(cube) = [x, 0.0, 0.025];
    }
    *bench.object(0) = [0.46, -0.1, 0.025];
    bench.set_local(
        "given_up",
        Value::Text(behavior::Str::new("cube_1").unwrap()),
    );
    let at = behavior::value::Numbers::new(&[0.46, -0.1, 0.025]).unwrap();
    bench.set_local("given_up_at", Value::Numbers(at));
    assert_eq!(bench.tick(), Status::Running);
    assert_eq!(bench.text("center_owner"), "");
    bench.object(0)[1] += 0.02;
    assert_eq!(bench.tick(), Status::Success, "it moved");
    assert_eq!(current(&bench), "cube_1");
}

#[test]
fn a_cube_that_is_never_gripped_is_available_again_after_some_recoveries() {
    let mut bench = recover(LEFT);
    for turn in 1..=5 {
        assert_eq!(current(&bench), "cube_1", "{turn}");
        let [x, y, z] = *bench.object(0);
        bench.state.arms[LEFT].tcp.position = [x, y, z + 0.2];
        for _ in 0..2 {
            bench.tick_after(0.15);
        }
        let mut ticks = 0;
        while bench.tick_after(0.15) == Status::Running && ticks < 10 {
            ticks += 1;
        }
    }
    assert_eq!(bench.text("cube_state:cube_1"), "available");
    assert_eq!(bench.count("is not gripped, and available again"), 1);
}

#[test]
fn n22_no_interval_is_an_error() {
    let mut bench = bench(
        LEFT,
        json!({"type": "RecoverCube", "ports": {"warning_interval": 0.0}}),
    );
    assert_eq!(bench.tick(), Status::Failure);
    assert_eq!(bench.count("[error]"), 1);
}

#[test]
fn n29_a_robot_that_does_not_answer_is_a_failure_from_the_thirtieth_attempt() {
    let mut bench = bench(LEFT, json!({"type": "FrankaReset"}));
    bench.state.arms[LEFT].fault = 1;
    for attempt in 1..30 {
        assert_eq!(bench.tick(), Status::Running, "{attempt}");
    }
    assert_eq!(bench.tick(), Status::Failure);
    assert_eq!(bench.count("[error]"), 1);
}

#[test]
fn a_reset_takes_the_stack_that_is_there_for_its_own() {
    let mut bench = bench(LEFT, json!({"type": "FrankaReset"}));
    *bench.object(0) = [0.46, -0.28, 0.025];
    *bench.object(2) = [0.46, -0.28, 0.075];
    bench.set_text("center_owner", "left");
    bench.tick();
    assert_eq!(bench.tick_after(0.25), Status::Success);
    assert_eq!(bench.get("placed:left"), Some(set_of(&[0, 2])));
    assert_eq!(bench.text("center_owner"), "");
    assert_eq!(bench.gripper(), GripperGoal::Open);
}

#[test]
fn a_reset_keeps_a_hand_closed_that_holds_a_cube() {
    let mut bench = bench(LEFT, json!({"type": "FrankaReset"}));
    bench.hold(3);
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(bench.gripper(), GripperGoal::Keep);
}

#[test]
fn a_recovery_lets_the_others_cube_go_where_it_is() {
    let mut bench = recover(LEFT);
    bench.hold(3);
    bench.set_text("cube_state:cube_4", "reserved:right");
    bench.tick();
    assert_eq!(bench.tick(), Status::Running);
    assert_eq!(bench.gripper(), GripperGoal::Open);
    assert!(bench.holds_still(), "it would fall on its own cube");
    assert_eq!(bench.count("releases cube_4"), 1);
    bench.state.arms[LEFT].gripper = ipc_types::GripperState::zeroed();
    bench.state.arms[LEFT].gripper.width = 0.08;
    assert_eq!(bench.tick(), Status::Running);
    assert!(!bench.holds_still());
}

#[test]
fn a_recovery_leaves_a_hand_closed_that_holds_a_free_cube() {
    let mut bench = recover(LEFT);
    bench.hold(3);
    assert_eq!(bench.tick(), Status::Failure);
    assert_eq!(bench.gripper(), GripperGoal::Keep);
    assert!(!bench.recovery());
}

#[test]
fn an_arm_with_nothing_to_take_leaves_the_centre_and_gives_it_back() {
    let mut bench = acquire(LEFT);
    for cube in 0..6 {
        *bench.object(cube) = [1.5, 0.2 * cube as f64, 0.025];
    }
    bench.set_text("center_owner", "left");
    assert_eq!(bench.tick(), Status::Running);
    assert_eq!(bench.text("center_owner"), "left", "still there");
    assert!(bench.goal().target.position[1] < -0.28, "its own side");
    bench.state.arms[LEFT].tcp = bench.goal().target;
    assert_eq!(bench.tick(), Status::Running);
    assert_eq!(bench.text("center_owner"), "");
}

#[test]
fn another_arms_cube_in_the_hand_is_let_go_of_by_a_recovery() {
    let mut bench = acquire(LEFT);
    bench.hold(3);
    bench.set_text("cube_state:cube_4", "reserved:right");
    assert_eq!(bench.tick(), Status::Running);
    assert!(bench.recovery() && current(&bench).is_empty());
    let mut bench = super::bench(LEFT, json!({"type": "RecoverCube"}));
    bench.hold(3);
    bench.set_text("cube_state:cube_4", "reserved:right");
    assert_eq!(bench.tick(), Status::Running);
    assert_eq!(bench.gripper(), GripperGoal::Open);
    // A cube that belongs to no arm is picked up.
    bench.set_text("cube_state:cube_4", "available");
    assert_eq!(bench.tick(), Status::Failure);
    assert_eq!(bench.gripper(), GripperGoal::Keep);
}
