//! Scenes at rest, scenes that are refused, and a user's own arm.

#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a skipped test says so"
)]

use crate::support;

use cell_model::{Cell, Data, RobotFiles};
use ipc_types::{Validate, Wire, WorldState};
use physics_proc::world::{StepInput, World};
use support::Rig;

fn stack_cell(edit: impl Fn(String) -> String) -> Cell {
    let data = Data::checkout();
    let text = edit(data.read("cells/franka-stack.toml").unwrap().into_owned());
    Cell::from_text(&data, "franka-stack", "x.toml", &text, 1, None).unwrap()
}

#[test]
fn a_tower_of_four_stands_still() {
    let mut cell = stack_cell(|text| text);
    for (layer, object) in cell.objects.iter_mut().enumerate() {
        let offset = [0.0, 0.003, -0.002, 0.003][layer];
        object.pose = nalgebra::Isometry3::translation(
            0.55 + offset,
            0.2 - offset,
            0.0251 + 0.0501 * layer as f64,
        );
    }
    let mut rig = Rig::with(cell);
    rig.stay(1_000);
    let start: Vec<_> = (0..4).map(|index| rig.object(index)).collect();
    rig.stay(5_000);
    for (index, start) in start.iter().enumerate() {
        let drift = (rig.object(index).translation.vector - start.translation.vector).norm();
        assert!(drift < 1e-6, "object {index} drifts {drift} m");
    }
}

#[test]
fn an_object_inside_another_is_refused_by_name() {
    let cell = stack_cell(|text| text.replacen("[0.55, -0.30, 0.025]", "[0.47, -0.30, 0.025]", 1));
    let error = World::new(&cell).err().unwrap().to_string();
    assert!(
        error.contains("object 'blue_cube' starts") && error.contains("'red_cube'"),
        "{error}"
    );
}

#[test]
fn no_seed_lets_cubes_overlap() {
    for seed in 0..200 {
        let cell = Cell::load(&Data::checkout(), "franka-stack", seed, None).unwrap();
        assert!(World::new(&cell).is_ok(), "seed {seed}");
    }
}

/// A robot's files, as a user gives their own.
fn files_of(robot: &str) -> RobotFiles {
    let dir = Data::checkout_dir().join("robots").join(robot);
    let file = |suffix: &str| dir.join(format!("{robot}{suffix}"));
    RobotFiles {
        urdf: file(".urdf"),
        xrdf: Some(file(".xrdf")),
        rmpflow: Some(file("_rmpflow.yaml")),
        ..RobotFiles::default()
    }
}

#[test]
fn a_users_own_arm_holds_its_home() {
    for robot in ["panda", "ur10"] {
        let files = files_of(robot);
        let cell = Cell::load(&Data::checkout(), "reach", 0, Some(&files)).unwrap();
        let home = cell.arms[0].home.clone();
        let mut world = World::new(&cell).unwrap();
        for _ in 0..1_000 {
            world.step(&StepInput::default());
        }
        let mut state = WorldState::zeroed();
        world.write_state(&mut state);
        state.validate().unwrap();
        assert_eq!(state.quarantined, 0);
        for (joint, home) in home.iter().enumerate() {
            let error = (state.arms[0].joint_positions[joint] - home).abs();
            assert!(error < 2e-3, "{robot} joint {joint} is {error} rad off");
        }
    }
}
