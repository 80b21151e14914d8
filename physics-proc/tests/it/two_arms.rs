//! Two arms in one world: what holds for one holds for each of them.

use crate::support;

use std::f64::consts::FRAC_PI_2;

use cell_model::{Cell, Data};
use ipc_types::arm::StopAction;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::{GripperGoal, OperatorRequest, Wire};
use physics_proc::world::{StepInput, World};
use support::Rig;

fn cell(seed: u64) -> Cell {
    Cell::load(&Data::checkout(), "franka-pyramid", seed, None).unwrap()
}

#[test]
fn the_pyramid_stands_and_both_arms_wait_at_home_without_touching() {
    for seed in [0, 1, 2, 3, 4] {
        let mut world = World::new(&cell(seed)).unwrap();
        let mut state = ipc_types::WorldState::zeroed();
        let mut positions = |world: &World| {
            world.write_state(&mut state);
            assert!(state.arms().iter().all(|arm| arm.limit_violations == 0));
            assert!(state.objects().iter().all(|o| o.flags & 2 == 0), "touched");
            std::array::from_fn::<_, 6, _>(|i| support::isometry(&state.objects[i].pose))
        };
        for _ in 0..500 {
            world.step(&StepInput::default());
        }
        let start = positions(&world);
        for _ in 0..10_000 {
            world.step(&StepInput::default());
        }
        for (index, (end, start)) in positions(&world).iter().zip(&start).enumerate() {
            let drift = (end.translation.vector - start.translation.vector).norm();
            assert!(drift < 5.0e-4, "seed {seed}, cube {index}: {drift} m");
        }
    }
}

#[test]
fn no_seed_lets_cubes_overlap() {
    for seed in 0..200 {
        assert!(World::new(&cell(seed)).is_ok(), "seed {seed}");
    }
}

#[test]
fn either_arm_takes_the_top_cube_while_the_other_holds_its_home() {
    for (arm, turn) in [(0, FRAC_PI_2), (1, -FRAC_PI_2)] {
        let mut rig = Rig::of_arm(cell(1), arm);
        rig.pick_turned(0, 0.1, turn);
        let state = rig.state();
        let (own, other) = (state.arms[arm].gripper, state.arms[1 - arm].gripper);
        assert_eq!((own.held_object, own.beam_object), (1, 1), "arm {arm}");
        assert!((own.grip_force - 20.0).abs() < 1.0, "{own:?}");
        assert_eq!((other.held_object, other.beam_object), (0, 0));
        assert!(rig.object(0).translation.vector.z > 0.2);
        for state in state.arms() {
            assert_eq!((state.limit_violations, state.fault), (0, 0));
        }
        let waiting = &state.arms[1 - arm];
        for (joint, home) in rig.cell.arms[1 - arm].home.iter().enumerate() {
            assert!((waiting.joint_positions[joint] - home).abs() < 1.0e-3);
        }
    }
}

#[test]
fn a_cube_is_dragged_out_of_the_hand_of_the_second_arm() {
    let mut rig = Rig::of_arm(cell(2), 1);
    rig.pick_turned(0, 0.1, -FRAC_PI_2);
    let place = rig.object(0).translation.vector;
    let mut drag = OperatorRequest::zeroed();
    drag.pose.orientation_wxyz = [1.0, 0.0, 0.0, 0.0];
    drag.pose.position = [place.x, place.y - 0.3, place.z];
    drag.seconds = 2.0;
    assert_eq!(
        rig.world.execute_request(OperatorAction::Drag, &drag).0,
        ReplyCode::Accepted
    );
    rig.stay(2_500);
    assert_eq!(rig.state().arms[1].gripper.held_object, 0);
    assert_eq!(rig.state().arms[1].limit_violations, 0);
}

#[test]
fn silence_stops_the_second_arm_only_if_it_is_its_own() {
    let mut rig = Rig::of_arm(cell(3), 1);
    rig.stay(100);
    // Arm 0 never had a controller; arm 1 now loses its.
    for _ in 0..30 {
        rig.world.step(&StepInput::default());
    }
    assert_eq!(rig.state().arms[1].stop_action, StopAction::Hold.code());
    rig.stay(5);
    assert_eq!(rig.state().arms[1].stop_action, StopAction::None.code());
    assert_eq!(rig.state().arms[1].command_generation, 1);
    assert_eq!(rig.state().arms[0].command_generation, 0);
}

#[test]
fn the_panel_speaks_for_one_arm_at_a_time() {
    let mut world = World::new(&cell(1)).unwrap();
    let mut state = ipc_types::WorldState::zeroed();
    let mut request = OperatorRequest::zeroed();
    request.pose.orientation_wxyz = [0.0, 1.0, 0.0, 0.0];
    request.pose.position = [0.4, -0.3, 0.4];
    world.execute_request(OperatorAction::Target, &request);
    // A gripper of the other arm: it keeps its place.
    request.arm = 1;
    request.count = GripperGoal::Close.code();
    world.execute_request(OperatorAction::Gripper, &request);
    world.write_state(&mut state);
    let panel = state.panel;
    assert_eq!(
        (panel.target_arm, panel.gripper),
        (1, GripperGoal::Close.code())
    );
    assert_eq!(panel.target.position, state.arms[1].tcp.position);
    // Back to the first arm: its hand was not closed.
    request.arm = 0;
    world.execute_request(OperatorAction::Target, &request);
    world.write_state(&mut state);
    let panel = state.panel;
    assert_eq!(
        (panel.target_arm, panel.gripper),
        (0, GripperGoal::Keep.code())
    );
    request.arm = 2;
    assert_eq!(
        world.execute_request(OperatorAction::Gripper, &request).0,
        ReplyCode::UnknownArm
    );
}
