//! The shapes of a cell in a state.

use cell_model::cells::cell::ArmSpec;
use cell_model::{Cell, Shape};
use ipc_types::WorldState;
use ipc_types::world::{ArmState, OBJECT_ENABLED};
use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};

use crate::cast::{Solid, single};

/// Colour of all links: red, green, blue, 0 to 1.
const ROBOT: [f64; 3] = [0.86, 0.87, 0.89];

/// All that can be seen.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub(crate) bodies: Vec<Body>,
}

/// A shape in the world.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) solid: Solid,
    /// Pose of its frame in the world (m).
    pub(crate) pose: Isometry3<f64>,
    /// Half the edges of a box around it, in its frame (m).
    pub(crate) half: Vector3<f64>,
    pub(crate) colour: [f32; 3],
    /// Number in the mask.
    pub(crate) instance: u16,
}

/// Names of what a mask tells apart: entry `i` has number `i + 1`. Fixtures, then objects, then
/// the links of each arm as `ARM/LINK`, in the order of the cell.
pub fn instances(cell: &Cell) -> Vec<String> {
    let fixtures = cell.fixtures.iter().map(|fixture| fixture.name.clone());
    let objects = cell.objects.iter().map(|object| object.name.clone());
    let links = cell.arms.iter().flat_map(|arm| {
        let links = arm.robot.links.iter();
        links.map(|link| format!("{}/{}", arm.name, link.name))
    });
    fixtures.chain(objects).chain(links).collect()
}

impl Scene {
    /// The bodies of the cell in `state`. Fixtures without a body and objects that are not in the
    /// cell are not seen.
    pub fn new(cell: &Cell, state: &WorldState) -> Self {
        let mut scene = Self::default();
        let mut instance = 0_u16;
        // Every body takes a number, visible or not, so that a number means the same in all states.
        let mut next = || {
            instance = instance.saturating_add(1);
            instance
        };
        for fixture in &cell.fixtures {
            let number = next();
            if fixture.solid {
                scene.add(&fixture.shape, fixture.pose, fixture.colour, number);
            }
        }
        for (index, object) in cell.objects.iter().enumerate() {
            let number = next();
            let seen = state.objects.get(index);
            if let Some(seen) = seen.filter(|seen| seen.flags & OBJECT_ENABLED != 0) {
                scene.add(&object.shape, isometry(&seen.pose), object.colour, number);
            }
        }
        for (index, arm) in cell.arms.iter().enumerate() {
            let poses = state.arms().get(index).map(|seen| frame_poses(arm, seen));
            for (at, link) in arm.robot.links.iter().enumerate() {
                let number = next();
                let Some(pose) = poses.as_ref().and_then(|poses| poses.get(at)) else {
                    continue;
                };
                for part in &link.shapes {
                    scene.add(&part.shape, pose * part.pose, ROBOT, number);
                }
            }
        }
        scene
    }

    fn add(&mut self, shape: &Shape, pose: Isometry3<f64>, colour: [f64; 3], instance: u16) {
        let (solid, half) = Solid::of(shape);
        self.bodies.push(Body {
            solid,
            pose,
            half,
            colour: colour.map(single),
            instance,
        });
    }
}

/// Poses of the links of an arm in the world, base first.
pub(crate) fn frame_poses(arm: &ArmSpec, state: &ArmState) -> Vec<Isometry3<f64>> {
    let robot = &arm.robot;
    let mut positions = robot.with_arm_positions(&state.joint_positions);
    let fingers = robot
        .gripper
        .iter()
        .flat_map(|gripper| gripper.finger_joints);
    for finger in fingers {
        if let Some(slot) = positions.get_mut(finger) {
            // A state has no positions of fingers, only their distance; both move alike.
            *slot = 0.5 * state.gripper.width;
        }
    }
    let poses = robot.link_poses(&positions).into_iter();
    poses.map(|pose| arm.base * pose).collect()
}

fn isometry(pose: &ipc_types::Pose) -> Isometry3<f64> {
    let [w, x, y, z] = pose.orientation_wxyz;
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(pose.position.into(), rotation)
}
