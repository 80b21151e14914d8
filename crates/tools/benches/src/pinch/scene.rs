//! A rod between two fingers: the scene of <https://github.com/google-deepmind/mujoco/issues/3328>.
//!
//! Taken from it: a capsule of 45 g with a radius of 4 mm, horizontal, between two pads of 16 x
//! 60 x 40 mm and 200 g that slide along x, damped with 100 N s/m, 0.5 mm from it at the start;
//! friction 0.7; gravity along the pads. Different: the length of the capsule, and each finger
//! presses with a given force, while the drives of that scene press with the rest of a target 2
//! mm beyond the surface that their contacts allow.

use std::f64::consts::FRAC_PI_2;

use cell_model::{Cell, Data, JointSpec, Link, LinkShape, ParallelGripper, Robot, Shape};
use ipc_types::{ArmCommand, Header, Wire};
use nalgebra::{Isometry3, Matrix3, Vector3};
use rmp::{Chain, Frame, Joint, JointKind};

use crate::error::CoreError;

/// Name of the held object.
pub(super) const ROD: &str = "rod";
/// Edge lengths of a pad (m), and its mass (kg).
const PAD_M: [f64; 3] = [0.016, 0.06, 0.04];
const PAD_KG: f64 = 0.2;
/// From the middle to a pad at the start (m).
const OPEN_M: f64 = 0.0045;
const FRICTION: f64 = 0.7;
/// Largest force of a finger (N).
const MOST_N: f64 = 100.0;
/// The drives reach every force while the pads touch the rod.
const STIFFNESS_N_M: f64 = 50_000.0;
const DAMPING_N_S_M: f64 = 100.0;

const CELL: &str = r#"
description = "A rod between two fingers"
policies = ["none"]
default_policy = "none"
time_limit_s = 100.0
camera = { eye_m = [0.2, 0.2, 0.2], target_m = [0.0, 0.0, 0.0] }
task = { kind = "reach" }

[[arm]]
name = "fingers"
robot = "panda"
base_position_m = [0.0, 0.0, 0.0]

[[object]]
name = "rod"
shape = { kind = "capsule", radius_m = 0.004, height_m = 0.04 }
mass_kg = 0.045
friction = 0.7
position_m = [0.0, 0.0, 0.0]
colour = [0.5, 0.5, 0.5]
"#;

/// The rod between open fingers, which press with `force_n` each.
pub(super) fn cell(force_n: f64) -> Result<Cell, CoreError> {
    let mut cell = Cell::from_text(&Data::checkout(), "pinch", "bench", CELL, 0, None)?;
    for rod in &mut cell.objects {
        rod.pose = Isometry3::rotation(Vector3::new(FRAC_PI_2, 0.0, 0.0));
    }
    for arm in &mut cell.arms {
        arm.robot = fingers(&arm.robot, force_n)?;
        arm.home.clear();
    }
    Ok(cell)
}

/// Two fingers at a fixed base. The parts for motion policies are those of `other`.
fn fingers(other: &Robot, force_n: f64) -> Result<Robot, CoreError> {
    let names = ["left", "right"];
    let joints = names.iter().zip([-1.0, 1.0]).map(|(name, side)| Joint {
        name: (*name).to_owned(),
        parent: None,
        origin: Isometry3::identity(),
        axis: Vector3::new(side, 0.0, 0.0),
        kind: JointKind::Prismatic,
        lower: 0.0,
        upper: 0.04,
        mimic: None,
    });
    let frames = vec![Frame {
        name: "base".to_owned(),
        joint: None,
        pose: Isometry3::identity(),
    }];
    let pads = names
        .iter()
        .zip([-1.0, 1.0])
        .map(|(name, side)| pad(name, side));
    let spec = finger_spec(force_n);
    Ok(Robot {
        name: "two fingers".to_owned(),
        chain: Chain::new(joints.collect(), frames)?,
        joints: vec![spec; 2],
        links: [base()].into_iter().chain(pads).collect(),
        arm_joints: Vec::new(),
        gripper: Some(ParallelGripper {
            finger_joints: [0, 1],
            max_width: 2.0 * OPEN_M,
            default_force: force_n,
            max_force: MOST_N,
            speed: spec.velocity,
            pad_friction: FRICTION,
        }),
        suction: None,
        tcp_frame: 0,
        spheres: Vec::new(),
        self_spheres: Vec::new(),
        self_ignore: Vec::new(),
        default_joint_positions: Vec::new(),
        fixed_joint_positions: vec![spec.home; 2],
        ..other.clone()
    })
}

fn base() -> Link {
    Link {
        name: "base".to_owned(),
        mass: 0.0,
        center_of_mass: Vector3::zeros(),
        inertia: Matrix3::zeros(),
        shapes: Vec::new(),
    }
}

/// A pad whose surface is in the middle at position 0 of its joint.
fn pad(name: &str, side: f64) -> Link {
    let [x, y, z] = PAD_M;
    let center = Vector3::new(0.5 * side * x, 0.0, 0.0);
    let of = |a: f64, b: f64| PAD_KG * (a * a + b * b) / 12.0;
    Link {
        name: name.to_owned(),
        mass: PAD_KG,
        center_of_mass: center,
        inertia: Matrix3::from_diagonal(&Vector3::new(of(y, z), of(x, z), of(x, y))),
        shapes: vec![LinkShape {
            shape: Shape::Box { size_m: PAD_M },
            pose: Isometry3::translation(center.x, 0.0, 0.0),
        }],
    }
}

fn finger_spec(force_n: f64) -> JointSpec {
    JointSpec {
        lower: 0.0,
        upper: 0.04,
        velocity: 0.1,
        acceleration: 10.0,
        jerk: 500.0,
        effort: force_n,
        stiffness: STIFFNESS_N_M,
        damping: 0.0,
        armature: 1.0e-4,
        joint_damping: DAMPING_N_S_M,
        home: OPEN_M,
    }
}

/// The command for `tick` that closes the fingers.
pub(super) fn close(tick: u64) -> ArmCommand {
    let mut command = ArmCommand::zeroed();
    command.header = Header::caused_by::<ArmCommand>(tick);
    (command.header.generation, command.header.seq) = (1, tick + 1);
    command
}

/// The same as controls of `MuJoCo`'s servos, from the start of the fingers (m).
pub(super) const CLOSED: [f64; 2] = [-OPEN_M; 2];
