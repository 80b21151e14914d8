//! The cubes, the tool and the gripper of one observation.

use nalgebra::Vector3;

use super::setup::{MAX_CUBES, StackSetup};
use crate::stack::geometry;
use robocell_task::job::Placement;
use robocell_task::observation::Observation;

/// The arm that stacks.
pub const ARM: usize = 0;

/// One cube as seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cube {
    /// Centre, world frame (m).
    pub position: Vector3<f64>,
    /// Turn about the vertical axis, within a quarter turn (rad).
    pub yaw: f64,
    /// Pulled by the operator.
    pub dragged: bool,
}

impl Cube {
    /// Where it is.
    pub fn place(&self) -> Placement {
        Placement {
            position: self.position.into(),
            yaw: self.yaw,
        }
    }
}

/// What the stacking policies need of an observation.
#[derive(Clone, Copy, Debug)]
pub struct View {
    cubes: [Cube; MAX_CUBES],
    count: usize,
    /// Measured TCP position, world frame (m).
    pub tcp: Vector3<f64>,
    /// Turn of the measured tool about the vertical axis (rad).
    pub tcp_yaw: f64,
    /// Measured finger distance (m).
    pub gripper_width: f64,
    /// Cube between the fingers, by its place in the order.
    pub held: Option<usize>,
}

impl View {
    /// `None` when the observation lacks the arm or a cube of the order; the
    /// policy then holds.
    pub fn read(setup: &StackSetup, observation: &Observation<'_>) -> Option<Self> {
        let arm = observation.arm(ARM)?;
        let mut cubes = [Cube::default(); MAX_CUBES];
        for (slot, spec) in cubes.iter_mut().zip(&setup.cubes) {
            let object = observation.object(spec.object)?;
            *slot = Cube {
                position: Vector3::from(object.pose.position),
                yaw: geometry::yaw(&object.pose),
                dragged: object.flags & ipc_types::world::OBJECT_DRAGGED != 0,
            };
        }
        Some(Self {
            cubes,
            count: setup.cubes.len(),
            tcp: Vector3::from(arm.tcp.position),
            tcp_yaw: geometry::tool_yaw(&arm.tcp),
            gripper_width: arm.gripper.width,
            held: observation
                .held_object(ARM)
                .and_then(|o| setup.cube_of_object(o)),
        })
    }

    /// The cubes of the order, from bottom to top.
    pub fn cubes(&self) -> &[Cube] {
        self.cubes.get(..self.count).unwrap_or_default()
    }

    /// The cube at `index` of the order; the last answer for an index out of
    /// range is a cube at the origin, which no caller asks for.
    pub fn cube(&self, index: usize) -> Cube {
        self.cubes().get(index).copied().unwrap_or_default()
    }

    /// Distance of a cube's centre from the measured TCP (m).
    pub fn distance_to_tcp(&self, index: usize) -> f64 {
        (self.cube(index).position - self.tcp).norm()
    }
}
