//! The state after the engine has to disable a body.

use cell_model::{Cell, Data};
use ipc_types::arm::StopAction;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{ArmCommand, Validate, Wire, WorldState};
use rapier3d_f64::prelude::Vector;

use crate::world::{StepInput, World};

fn world() -> World {
    let cell = Cell::load(&Data::checkout(), "franka-stack", 1, None).unwrap();
    World::new(&cell).unwrap()
}

fn state_after(world: &mut World, ticks: usize) -> WorldState {
    for _ in 0..ticks {
        world.step(&StepInput::default());
    }
    let mut state = WorldState::zeroed();
    world.write_state(&mut state);
    state.validate().unwrap();
    state
}

/// Gives a joint of the arm a velocity (rad/s) within the engine.
fn set_rate(world: &mut World, rate: f64) {
    let (engine, arms) = world.engine_and_arms();
    let link = arms.bodies()[0].bodies()[4];
    let joints = &mut engine.rapier_mut().multibody_joints;
    let multibody = joints.rigid_body_link(link).unwrap().multibody;
    let multibody = joints.get_multibody_mut(multibody).unwrap();
    multibody.generalized_velocity_mut()[3] = rate;
}

#[test]
fn a_lost_object_is_reported_and_the_rest_goes_on() {
    let mut world = world();
    let (engine, _) = world.engine_and_arms();
    let body = engine.object_mut(1).unwrap();
    body.set_linvel(Vector::new(f64::NAN, 0.0, 0.0), true);
    let state = state_after(&mut world, 50);
    assert_eq!(state.quarantined, 1);
    let enabled: Vec<bool> = state
        .objects()
        .iter()
        .map(|o| o.flags & OBJECT_ENABLED != 0)
        .collect();
    assert_eq!(enabled, [true, false, true, true]);
    assert_eq!(state.arms[0].fault, 0);
}

#[test]
fn a_joint_that_diverges_latches_a_fault_before_readers_refuse_the_state() {
    let mut world = world();
    set_rate(&mut world, 1.0e7);
    let state = state_after(&mut world, 1);
    assert_eq!(state.arms[0].fault, 1);
}

#[test]
fn a_lost_link_latches_a_fault_until_the_scene_is_reset() {
    let mut world = world();
    set_rate(&mut world, f64::NAN);
    let state = state_after(&mut world, 50);
    assert_eq!(state.arms[0].fault, 1);
    assert_eq!(state.arms[0].stop_action, StopAction::Stop0.code());
    assert!(
        state.arms[0].joint_positions[1] != 0.0,
        "the last good state stays"
    );
    world.reset().unwrap();
    let state = state_after(&mut world, 50);
    assert_eq!(
        (state.arms[0].fault, state.arms[0].stop_action),
        (0, StopAction::None.code())
    );
}

/// Pushes the tool sideways, harder than the brakes hold, for 0.2 s; returns the distance of
/// the first joint from its start, at the end of the push and 1 s later (rad).
fn pushed(world: &mut World) -> [f64; 2] {
    let before = state_after(world, 1).arms[0].joint_positions[0];
    let tool = world.engine_and_arms().1.bodies()[0].bodies()[7];
    for _ in 0..200 {
        let body = &mut world.engine_and_arms().0.rapier_mut().bodies[tool];
        body.reset_forces(true);
        body.add_force(Vector::new(0.0, 600.0, 0.0), true);
        world.step(&StepInput::default());
    }
    world.engine_and_arms().0.rapier_mut().bodies[tool].reset_forces(true);
    let off = |state: &WorldState| state.arms[0].joint_positions[0] - before;
    let pushed = off(&state_after(world, 1));
    [pushed, off(&state_after(world, 1_000))]
}

#[test]
fn an_arm_on_its_brakes_stays_where_it_is_pushed_and_one_in_hold_comes_back() {
    // Before the first command the drives hold the home pose.
    let [pushed_to, later] = pushed(&mut world());
    assert!(
        pushed_to > 0.05 && later.abs() < 0.01,
        "{pushed_to} {later}"
    );
    // One command, and silence for longer than category 1 allows.
    let mut world = world();
    let mut command = ArmCommand::zeroed();
    command.header.generation = 1;
    command.header.seq = 1;
    command.joint_count = 7;
    let home = state_after(&mut world, 0).arms[0].setpoint_positions;
    command.joint_positions = home;
    let mut input = StepInput::default();
    input.commands[0] = Some(&command);
    world.step(&input);
    let state = state_after(&mut world, 2_100);
    assert_eq!(state.arms[0].stop_action, StopAction::Stop1.code());
    let efforts = &state.arms[0].joint_efforts[..7];
    assert!(efforts.iter().all(|effort| *effort == 0.0), "{efforts:?}");
    let [pushed_to, later] = pushed(&mut world);
    assert!(pushed_to > 0.05, "{pushed_to}");
    assert!((later - pushed_to).abs() < 0.05, "{pushed_to} {later}");
}

#[test]
fn an_arm_that_is_kept_outside_its_limits_is_at_fault_and_the_joint_is_named() {
    let mut world = world();
    let (watchdog, joints) = world.engine_and_arms().1.watchdog_and_joints(0);
    for _ in 0..499 {
        watchdog.count_outside(1);
    }
    watchdog.count_outside(0);
    for _ in 0..499 {
        watchdog.count_outside(2);
    }
    assert!(!watchdog.fault, "it was within its limits in between");
    watchdog.count_outside(1);
    assert!(watchdog.fault);
    assert_eq!(watchdog.violations, 499 + 998 + 1);
    joints[2] = 99.0;
    let words = world.fault_words();
    assert!(
        words.contains("arm 0") && words.contains("'panda_joint3' stays at 99.000"),
        "{words}"
    );
    assert_eq!(world.faults(), 1);
    assert_eq!(
        state_after(&mut world, 1).arms[0].stop_action,
        StopAction::Stop0.code()
    );
}
