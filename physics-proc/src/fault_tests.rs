//! What is left when the engine has to disable a body.

use cell_model::{Cell, Data};
use ipc_types::arm::StopAction;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{Validate, Wire, WorldState};
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

#[test]
fn a_lost_object_is_reported_and_the_rest_goes_on() {
    let mut world = world();
    let handle = world.objects.bodies[1];
    world.engine.bodies[handle].set_linvel(Vector::new(f64::NAN, 0.0, 0.0), true);
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
fn a_lost_link_latches_a_fault_until_the_scene_is_reset() {
    let mut world = world();
    let handle = world.arms[0].bodies[4];
    let link = *world
        .engine
        .multibody_joints
        .rigid_body_link(handle)
        .unwrap();
    let multibody = world
        .engine
        .multibody_joints
        .get_multibody_mut(link.multibody)
        .unwrap();
    multibody.generalized_velocity_mut()[3] = f64::NAN;
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
