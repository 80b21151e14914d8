//! A grasp is friction and holds.

#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "the measured numbers are worth reading"
)]

use crate::support;

use ipc_types::Validate;
use ipc_types::world::OBJECT_ASLEEP;
use support::Rig;

#[test]
fn a_grasped_cube_stays_where_it_is_for_ten_seconds() {
    let mut rig = Rig::new(3);
    rig.pick(0, 0.3);
    rig.stay(500);
    let state = rig.state();
    state.validate().unwrap();
    assert_eq!(state.arms[0].gripper.held_object, 1);
    assert!(
        (state.arms[0].gripper.grip_force - 20.0).abs() < 0.5,
        "{}",
        state.arms[0].gripper.grip_force
    );
    assert!((state.arms[0].gripper.width - 0.05).abs() < 5e-4);
    let start = rig.object_in_hand(0);
    rig.stay(10_000);
    let end = rig.object_in_hand(0);
    let slip = (end.translation.vector - start.translation.vector).norm();
    let penetration = rig.world.penetration();
    println!(
        "slip {:.5} mm, penetration {:.4} mm",
        slip * 1e3,
        penetration * 1e3
    );
    assert!(rig.object(0).translation.vector.z > 0.3);
    // It was 0.005 mm with drives that are rows of the solver; MuJoCo's cube slips by 0.24 to
    // 0.82 mm.
    assert!(slip <= 1.0e-6, "{slip}");
    assert!(penetration <= 1.5e-4, "{penetration}");
    assert_eq!(rig.state().arms[0].limit_violations, 0);
    assert_eq!(rig.world.refused_commands(), 0);
}

/// Where the held object is in the hand after ten seconds (m).
fn held_for_ten_seconds(wakes_others: bool) -> nalgebra::Vector3<f64> {
    let mut rig = Rig::new(3);
    rig.pick(0, 0.3);
    rig.stay(600);
    let others = rig.state().objects()[1..].to_vec();
    assert!(
        others
            .iter()
            .all(|object| object.flags & OBJECT_ASLEEP != 0)
    );
    for _ in 0..100 {
        if wakes_others {
            rig.world.wake_objects();
        }
        rig.stay(100);
    }
    rig.object_in_hand(0).translation.vector
}

#[test]
fn what_sleeps_or_wakes_elsewhere_does_not_let_the_held_object_slip() {
    let (asleep, awake) = (held_for_ten_seconds(false), held_for_ten_seconds(true));
    let apart = (asleep - awake).norm();
    println!("apart {:.6} mm", apart * 1e3);
    assert!(apart < 1.0e-6, "{apart}");
}

#[test]
fn an_opened_hand_lets_go_and_reports_it() {
    let mut rig = Rig::new(4);
    rig.pick(1, 0.1);
    rig.width = 0.08;
    rig.stay(600);
    let state = rig.state();
    assert_eq!(state.arms[0].gripper.held_object, 0);
    assert_eq!(state.arms[0].gripper.grip_force, 0.0);
    assert!((state.arms[0].gripper.width - 0.08).abs() < 1e-3);
    assert!(rig.object(1).translation.vector.z < 0.03);
}

#[test]
fn closing_on_nothing_holds_nothing() {
    let mut rig = Rig::new(5);
    rig.width = 0.0;
    rig.stay(800);
    let gripper = rig.state().arms[0].gripper;
    assert!(
        gripper.width.abs() < 1e-3 && gripper.held_object == 0,
        "{gripper:?}"
    );
}

#[test]
fn the_arm_follows_its_commands_closely() {
    let mut rig = Rig::new(6);
    let goal = rig.solve([0.5, 0.2, 0.3], 0.3);
    rig.travel(goal, 2.0);
    rig.stay(200);
    let measured = rig.state().arms[0].joint_positions;
    for joint in 0..7 {
        assert!(
            (measured[joint] - goal[joint]).abs() < 5e-4,
            "joint {joint}: {} {}",
            measured[joint],
            goal[joint]
        );
    }
}

#[test]
fn the_light_barrier_sees_a_cube_before_the_fingers_touch_it() {
    let mut rig = Rig::new(6);
    let beam = |rig: &Rig| rig.state().arms[0].gripper.beam_object;
    let pose = rig.object(2);
    let [x, y, z] = pose.translation.vector.into();
    let (_, _, yaw) = pose.rotation.euler_angles();
    let above = rig.solve([x, y, z + 0.1], yaw);
    rig.travel(above, 2.0);
    assert_eq!(beam(&rig), 0);
    let low = rig.solve([x, y, z], yaw);
    rig.travel(low, 1.0);
    assert_eq!(
        (beam(&rig), rig.state().arms[0].gripper.held_object),
        (3, 0)
    );
    rig.width = 0.0;
    rig.stay(500);
    assert_eq!(
        (beam(&rig), rig.state().arms[0].gripper.held_object),
        (3, 3)
    );
}
